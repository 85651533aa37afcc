//! The configuration of the daemon: defaults, a file, the environment, and flags, in rising precedence.
//!
//! [`key::KEYS`] lists the keys. [`Configuration::resolve`] reads all sources, and [`Configuration::settings`] gives the
//! checked result. Nothing here opens a file.

mod error;
pub mod key;
mod source;
mod value;

use std::collections::BTreeMap;
use std::net::SocketAddr;
use std::path::PathBuf;
use std::time::Duration;

pub use crate::limits::Limits;
pub use error::SettingsError;
pub use key::{KEYS, Key, Kind};
pub use source::{Configuration, Flag, Origin};

/// What the daemon is told by its configuration.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Settings {
    /// Where it listens.
    pub listen: Listen,
    /// What matches there may be.
    pub lobby: Lobby,
    /// How much of something there may be. These can be changed while it runs.
    pub limits: Limits,
    /// How matches are kept.
    pub journal: Journal,
    /// What it tells of itself.
    pub log: Log,
}

/// Where the daemon listens.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Listen {
    /// For players and spectators.
    pub address: SocketAddr,
    /// `None`: nothing is encrypted.
    pub tls: Option<TlsFiles>,
    /// `None`: there is no administration.
    pub admin: Option<AdminFiles>,
    /// For health, metrics and matches; `None`: nowhere.
    pub http: Option<SocketAddr>,
}

/// What TLS needs: PEM files.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TlsFiles {
    /// The certificate of the server, and those that vouch for it.
    pub certificate: PathBuf,
    /// Its private key.
    pub key: PathBuf,
}

/// What the administration needs.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct AdminFiles {
    /// The Unix socket.
    pub socket: PathBuf,
    /// The file with the token.
    pub token: PathBuf,
}

/// What matches there may be.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Lobby {
    /// Who may create them.
    pub create: MayCreate,
    /// The files of the scenarios, by name.
    pub scenarios: BTreeMap<String, PathBuf>,
}

/// Who may create matches.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MayCreate {
    /// Whoever connects.
    Anyone,
    /// Whoever has the token of the administration.
    Admin,
}

/// How matches are kept.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Journal {
    /// The folder of the journals; `None`: there are none.
    pub directory: Option<PathBuf>,
    /// Time after which a journal is on the disk.
    pub sync_interval: Duration,
}

/// What the daemon tells of itself.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Log {
    /// Which events, as `tracing` filters them.
    pub filter: String,
    /// In which form.
    pub format: LogFormat,
}

/// In which form events are logged.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LogFormat {
    /// Lines for people.
    Text,
    /// A JSON object a line.
    Json,
}

impl Limits {
    /// Returns each limit under the name of its key.
    #[must_use]
    pub fn by_key(&self) -> BTreeMap<&'static str, u64> {
        let number = |count: usize| u64::try_from(count).expect("a count has at most 64 bits");
        BTreeMap::from([
            (key::CONNECTIONS.name, number(self.connections)),
            (key::CONNECTIONS_PER_ADDRESS.name, number(self.connections_per_address)),
            (key::MATCHES.name, number(self.matches)),
            (key::MATCHES_PER_ADDRESS.name, number(self.matches_per_address)),
            (key::BEGIN_SECONDS.name, self.begin_within.as_secs()),
        ])
    }
}

impl Configuration {
    /// Returns the settings.
    ///
    /// # Errors
    /// A key that means nothing without another.
    pub fn settings(&self) -> Result<Settings, SettingsError> {
        let lobby = Lobby {
            create: match self.word(&key::CREATE) {
                "anyone" => MayCreate::Anyone,
                "admin" => MayCreate::Admin,
                other => unreachable!("{other} is no choice"),
            },
            scenarios: self.files(&key::SCENARIOS).clone(),
        };
        let journal = Journal {
            directory: self.path(&key::DIRECTORY).cloned(),
            sync_interval: Duration::from_millis(self.count(&key::SYNC_MILLISECONDS).into()),
        };
        Ok(Settings { listen: self.listen()?, lobby, limits: self.limits(), journal, log: self.log() })
    }

    /// Returns what is to be logged.
    #[must_use]
    pub fn log(&self) -> Log {
        let format = match self.word(&key::FORMAT) {
            "text" => LogFormat::Text,
            "json" => LogFormat::Json,
            other => unreachable!("{other} is no choice"),
        };
        Log { filter: self.word(&key::FILTER).to_owned(), format }
    }

    fn listen(&self) -> Result<Listen, SettingsError> {
        let pair = |key, other| match (self.path(key), self.path(other)) {
            (Some(file), Some(other)) => Ok(Some((file.clone(), other.clone()))),
            (Some(_), None) => Err(self.alone(key, other)),
            (None, Some(_)) => Err(self.alone(other, key)),
            (None, None) => Ok(None),
        };
        let tls = pair(&key::TLS_CERTIFICATE, &key::TLS_KEY)?;
        let admin = match (self.path(&key::ADMIN_SOCKET), self.path(&key::ADMIN_TOKEN_FILE)) {
            (None, Some(_)) => return Err(self.alone(&key::ADMIN_TOKEN_FILE, &key::ADMIN_SOCKET)),
            (None, None) => None,
            (Some(socket), token) => {
                let beside = || {
                    let mut path = socket.clone().into_os_string();
                    path.push(".token");
                    path.into()
                };
                Some(AdminFiles { socket: socket.clone(), token: token.cloned().unwrap_or_else(beside) })
            }
        };
        Ok(Listen {
            address: self.address(&key::ADDRESS).expect("this address is always given"),
            tls: tls.map(|(certificate, key)| TlsFiles { certificate, key }),
            admin,
            http: self.address(&key::HTTP),
        })
    }

    /// Returns the limits.
    #[must_use]
    pub fn limits(&self) -> Limits {
        Limits {
            connections: self.number(&key::CONNECTIONS),
            connections_per_address: self.number(&key::CONNECTIONS_PER_ADDRESS),
            matches: self.number(&key::MATCHES),
            matches_per_address: self.number(&key::MATCHES_PER_ADDRESS),
            begin_within: Duration::from_secs(self.count(&key::BEGIN_SECONDS).into()),
        }
    }

    fn number(&self, key: &Key) -> usize {
        usize::try_from(self.count(key)).expect("a count has 32 bits")
    }
}

#[cfg(test)]
mod tests;
