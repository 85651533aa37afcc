//! What keys hold.

use std::collections::BTreeMap;
use std::fmt;
use std::net::SocketAddr;
use std::path::PathBuf;

use toml::Spanned;
use toml::de::{DeTable, DeValue};

use super::key::Kind;

/// Scenarios and other things with a name and a file.
pub(super) type Files = BTreeMap<String, PathBuf>;

/// What a key holds; of which variant it is follows from the [`Kind`] of the key.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Value {
    Address(Option<SocketAddr>),
    Path(Option<PathBuf>),
    Count(u32),
    Text(String),
    Files(Files),
}

impl Value {
    /// Reads a value as the environment and the command line write it; `None`: it is none.
    pub(super) fn parse(kind: Kind, text: &str) -> Option<Self> {
        match kind {
            Kind::OptionalAddress if text.is_empty() => Some(Self::Address(None)),
            Kind::Address | Kind::OptionalAddress => {
                text.parse().ok().map(|address| Self::Address(Some(address)))
            }
            Kind::OptionalPath => {
                Some(Self::Path(Some(text).filter(|text| !text.is_empty()).map(PathBuf::from)))
            }
            Kind::Count { least, most } => {
                let is_plain = text.bytes().all(|byte| byte.is_ascii_digit());
                let count: u32 = text.parse().ok().filter(|_| is_plain)?;
                (least..=most).contains(&count).then_some(Self::Count(count))
            }
            Kind::Choice(words) => words.contains(&text).then(|| Self::Text(text.to_owned())),
            Kind::Text => Some(Self::Text(text.to_owned())),
            Kind::Files if text.is_empty() => Some(Self::Files(Files::new())),
            Kind::Files => {
                let mut files = Files::new();
                for pair in text.split(',') {
                    let (name, file) = pair.split_once('=')?;
                    let is_new = files.insert(name.to_owned(), PathBuf::from(file)).is_none();
                    if name.is_empty() || file.is_empty() || !is_new {
                        return None;
                    }
                }
                Some(Self::Files(files))
            }
        }
    }

    /// Reads a value of a TOML file; `None`: it is none.
    pub(super) fn read(kind: Kind, value: &DeValue<'_>) -> Option<Self> {
        match (kind, value) {
            (Kind::Count { .. }, DeValue::Integer(number)) if number.radix() == 10 => {
                Self::parse(kind, number.as_str())
            }
            (Kind::Files, DeValue::Table(table)) => files(table).map(Self::Files),
            (
                Kind::Address | Kind::OptionalAddress | Kind::OptionalPath | Kind::Choice(_) | Kind::Text,
                DeValue::String(text),
            ) => Self::parse(kind, text),
            _ => None,
        }
    }
}

fn files(table: &DeTable<'_>) -> Option<Files> {
    let mut files = Files::new();
    for (name, file) in table {
        let file: &Spanned<DeValue<'_>> = file;
        let file = file.get_ref().as_str().filter(|file| !file.is_empty())?;
        files.insert(name.get_ref().to_string(), PathBuf::from(file));
    }
    Some(files)
}

/// As TOML.
impl fmt::Display for Value {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let text = |text: String| toml::Value::String(text).to_string();
        match self {
            Self::Address(None) | Self::Path(None) => f.write_str("\"\""),
            Self::Address(Some(address)) => f.write_str(&text(address.to_string())),
            Self::Path(Some(path)) => f.write_str(&text(path.to_string_lossy().into_owned())),
            Self::Count(count) => write!(f, "{count}"),
            Self::Text(words) => f.write_str(&text(words.clone())),
            Self::Files(files) => {
                let of = |path: &PathBuf| toml::Value::String(path.to_string_lossy().into_owned());
                let table: toml::Table = files.iter().map(|(name, path)| (name.clone(), of(path))).collect();
                f.write_str(&toml::Value::Table(table).to_string())
            }
        }
    }
}

/// What it may be, for an error.
impl fmt::Display for Kind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Address => f.write_str("an IP address and a port, as \"127.0.0.1:7171\" or \"[::]:7171\""),
            Self::OptionalAddress => write!(f, "{}, or \"\" for none", Self::Address),
            Self::OptionalPath => f.write_str("a path, or \"\" for none"),
            Self::Count { least, most } => write!(f, "a whole number from {least} to {most}"),
            Self::Choice(words) => {
                let words: Vec<String> = words.iter().map(|word| format!("\"{word}\"")).collect();
                write!(f, "one of {}", words.join(", "))
            }
            Self::Text => f.write_str("a text"),
            Self::Files => f.write_str(
                "names and files: in a file { duel = \"duel.toml\" }, elsewhere duel=duel.toml,rush=rush.toml",
            ),
        }
    }
}
