//! Where values come from, and which of them holds.

use std::collections::BTreeMap;
use std::ffi::OsString;
use std::fmt::{self, Write as _};
use std::net::SocketAddr;
use std::path::{Path, PathBuf};

use serde::Serialize;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

use super::error::SettingsError;
use super::key::{KEYS, Key, VARIABLE_PREFIX};
use super::value::{Files, Value};

/// Where a value comes from.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Origin {
    /// Nobody has given it.
    Default,
    /// A configuration file.
    File {
        /// The file.
        path: PathBuf,
        /// The line, from 1.
        line: usize,
    },
    /// The environment.
    Environment {
        /// The variable.
        variable: String,
    },
    /// The command line.
    Flag {
        /// The flag.
        flag: String,
    },
}

/// A value from the command line.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Flag {
    /// How it is written, for errors and for who asks where a value comes from.
    pub flag: String,
    /// Section and key, as in `limits.connections`.
    pub key: String,
    /// What it holds.
    pub value: String,
}

/// The value of each key, and where it comes from.
#[derive(Clone, Debug)]
pub struct Configuration {
    /// In the order of [`KEYS`].
    held: Vec<(Value, Origin)>,
}

impl fmt::Display for Origin {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Default => f.write_str("default"),
            Self::File { path, line } => write!(f, "{}, line {line}", path.display()),
            Self::Environment { variable } => write!(f, "environment {variable}"),
            Self::Flag { flag } => write!(f, "flag {flag}"),
        }
    }
}

impl Flag {
    /// Reads what stands behind `--set`.
    ///
    /// # Errors
    /// A text without `=`.
    pub fn set(text: &str) -> Result<Self, SettingsError> {
        let (key, value) =
            text.split_once('=').ok_or_else(|| SettingsError::BadFlag { text: text.to_owned() })?;
        Ok(Self { flag: format!("--set {key}"), key: key.to_owned(), value: value.to_owned() })
    }

    /// Returns a value that a flag of its own gives.
    #[must_use]
    pub fn named(flag: &str, key: &Key, value: String) -> Self {
        Self { flag: flag.to_owned(), key: key.path(), value }
    }
}

impl Configuration {
    /// Reads the file, then the environment, then the flags: what comes later holds. Of the environment it takes the
    /// variables `MANIPLE_<SECTION>_<KEY>`; others are of other programs.
    ///
    /// # Errors
    /// The first of the mistakes.
    pub fn resolve(
        file: Option<(&Path, &str)>,
        environment: impl IntoIterator<Item = (OsString, OsString)>,
        flags: &[Flag],
    ) -> Result<Self, SettingsError> {
        let mut configuration = Self::default();
        if let Some((path, text)) = file {
            configuration.take_file(path, text)?;
        }
        // In order of the names, so that of several mistakes it is always the same that is told.
        let variables: BTreeMap<OsString, OsString> = environment.into_iter().collect();
        for (variable, value) in &variables {
            configuration.take_variable(&variable.to_string_lossy(), value)?;
        }
        for flag in flags {
            configuration.take_flag(flag)?;
        }
        Ok(configuration)
    }

    /// Returns the configuration as a TOML file that says of each value where it comes from.
    #[must_use]
    pub fn text(&self) -> String {
        let mut text = String::new();
        let mut section = "";
        for (key, (value, origin)) in self.rows() {
            if key.section != section {
                let gap = if section.is_empty() { "" } else { "\n" };
                section = key.section;
                let _ = writeln!(text, "{gap}[{section}]");
            }
            let _ = writeln!(text, "{} = {value} # {origin}", key.name);
        }
        text
    }

    /// Returns each key with what it holds, as TOML writes it, and where that comes from.
    pub fn values(&self) -> impl Iterator<Item = (&'static Key, String, &Origin)> {
        self.rows().map(|(key, (value, origin))| (key, value.to_string(), origin))
    }

    /// Returns where the value of a key comes from.
    #[must_use]
    pub fn origin(&self, key: &Key) -> &Origin {
        &self.held(key).1
    }

    pub(super) fn address(&self, key: &Key) -> Option<SocketAddr> {
        let Value::Address(address) = &self.held(key).0 else { panic!("{} is of another kind", key.path()) };
        *address
    }

    pub(super) fn path(&self, key: &Key) -> Option<&PathBuf> {
        let Value::Path(path) = &self.held(key).0 else { panic!("{} is of another kind", key.path()) };
        path.as_ref()
    }

    pub(super) fn count(&self, key: &Key) -> u32 {
        let Value::Count(count) = &self.held(key).0 else { panic!("{} is of another kind", key.path()) };
        *count
    }

    pub(super) fn word(&self, key: &Key) -> &str {
        let Value::Text(text) = &self.held(key).0 else { panic!("{} is of another kind", key.path()) };
        text
    }

    pub(super) fn files(&self, key: &Key) -> &Files {
        let Value::Files(files) = &self.held(key).0 else { panic!("{} is of another kind", key.path()) };
        files
    }

    /// Returns the error that `key` is given, but not `missing`.
    pub(super) fn alone(&self, key: &Key, missing: &Key) -> SettingsError {
        SettingsError::Alone { origin: self.origin(key).clone(), key: key.path(), missing: missing.path() }
    }

    fn rows(&self) -> impl Iterator<Item = (&'static Key, &(Value, Origin))> {
        KEYS.iter().zip(&self.held)
    }

    fn held(&self, key: &Key) -> &(Value, Origin) {
        &self.held[place_of(key)]
    }

    fn take_file(&mut self, path: &Path, text: &str) -> Result<(), SettingsError> {
        let line_of = |offset: usize| text[..offset].matches('\n').count() + 1;
        let origin = |offset| Origin::File { path: path.to_owned(), line: line_of(offset) };
        let file = DeTable::parse(text).map_err(|error| SettingsError::Syntax {
            file: path.to_owned(),
            line: line_of(error.span().map_or(0, |span| span.start)),
            problem: error.message().to_owned(),
        })?;
        for (section, content) in in_order(file.get_ref()) {
            let origin_of_section = origin(section.span().start);
            let section = section.get_ref().to_string();
            let DeValue::Table(content) = content.get_ref() else {
                return Err(SettingsError::NoSection {
                    origin: origin_of_section,
                    key: section,
                    known: Key::sections(),
                });
            };
            check_section(&origin_of_section, &section)?;
            for (name, value) in in_order(content) {
                let origin = origin(name.span().start);
                let key = find(&origin, &section, name.get_ref())?;
                let source = &text[value.span()];
                let value = Value::read(key.kind, value.get_ref());
                self.hold(key, value.ok_or_else(|| bad_value(origin.clone(), key, source))?, origin);
            }
        }
        Ok(())
    }

    fn take_variable(&mut self, variable: &str, value: &OsString) -> Result<(), SettingsError> {
        let Some(rest) = variable.strip_prefix(VARIABLE_PREFIX) else { return Ok(()) };
        let origin = Origin::Environment { variable: variable.to_owned() };
        for section in Key::sections() {
            let is_here = |rest: &&str| rest.starts_with(&format!("{}_", section.to_ascii_uppercase()));
            let Some(name) = Some(rest).filter(is_here).map(|rest| &rest[section.len() + 1..]) else {
                continue;
            };
            let key = find(&origin, section, &name.to_ascii_lowercase())?;
            let value = value
                .to_str()
                .and_then(|text| Value::parse(key.kind, text))
                .ok_or_else(|| bad_value(origin.clone(), key, &format!("\"{}\"", value.to_string_lossy())))?;
            self.hold(key, value, origin);
            return Ok(());
        }
        Ok(())
    }

    fn take_flag(&mut self, Flag { flag, key, value }: &Flag) -> Result<(), SettingsError> {
        let origin = Origin::Flag { flag: flag.clone() };
        let Some((section, name)) = key.split_once('.') else {
            return Err(SettingsError::NoSection { origin, key: key.clone(), known: Key::sections() });
        };
        let key = find(&origin, section, name)?;
        let parsed = Value::parse(key.kind, value);
        let parsed = parsed.ok_or_else(|| bad_value(origin.clone(), key, &format!("\"{value}\"")))?;
        self.hold(key, parsed, origin);
        Ok(())
    }

    fn hold(&mut self, key: &Key, value: Value, origin: Origin) {
        self.held[place_of(key)] = (value, origin);
    }
}

/// The defaults.
impl Default for Configuration {
    fn default() -> Self {
        let held = |key: &Key| {
            let value = Value::parse(key.kind, key.default);
            (value.unwrap_or_else(|| panic!("{} has a bad default", key.path())), Origin::Default)
        };
        Self { held: KEYS.iter().map(held).collect() }
    }
}

/// Returns what a table holds in the order of the file, so that the first mistake is the one that is told.
fn in_order<'a, 'b>(
    table: &'a DeTable<'b>,
) -> Vec<(&'a Spanned<toml::de::DeString<'b>>, &'a Spanned<DeValue<'b>>)> {
    let mut entries: Vec<_> = table.iter().collect();
    entries.sort_by_key(|(name, _)| name.span().start);
    entries
}

fn check_section(origin: &Origin, section: &str) -> Result<(), SettingsError> {
    let known = Key::sections();
    if known.contains(&section) {
        return Ok(());
    }
    Err(SettingsError::UnknownSection { origin: origin.clone(), section: section.to_owned(), known })
}

fn find(origin: &Origin, section: &str, name: &str) -> Result<&'static Key, SettingsError> {
    check_section(origin, section)?;
    let of_section = || KEYS.iter().filter(|key| key.section == section);
    of_section().find(|key| key.name == name).ok_or_else(|| SettingsError::UnknownKey {
        origin: origin.clone(),
        section: section.to_owned(),
        key: name.to_owned(),
        known: of_section().map(|key| key.name).collect(),
    })
}

fn place_of(key: &Key) -> usize {
    KEYS.iter().position(|other| other == key).expect("every key is in the list")
}

fn bad_value(origin: Origin, key: &Key, found: &str) -> SettingsError {
    SettingsError::BadValue { origin, key: key.path(), found: found.to_owned(), limit: key.kind.to_string() }
}
