//! The arguments about the configuration of the daemon.

use std::net::SocketAddr;
use std::path::PathBuf;

use clap::Args;
use maniple_server::settings::{Flag, SettingsError, key};

#[derive(Clone, Debug, Args)]
pub(crate) struct ConfigurationArguments {
    /// The configuration; config/server.toml explains every key
    #[arg(long, value_name = "FILE")]
    pub(crate) config: Option<PathBuf>,
    /// Set a key of the configuration, as in limits.connections=2048, whatever file and environment say
    #[arg(long = "set", value_name = "KEY=VALUE")]
    pub(crate) set: Vec<String>,
    /// Address and port to listen at [default: 127.0.0.1:7171]; port 0 takes any that is free
    #[arg(long, value_name = "ADDRESS")]
    pub(crate) listen: Option<SocketAddr>,
    /// Where to keep matches, so that they go on when this has been killed; replays of those that have ended are in `finished`
    #[arg(long, value_name = "FOLDER")]
    pub(crate) journal: Option<PathBuf>,
    /// Say whether the configuration and the files that it names are right, and stop
    #[arg(long)]
    pub(crate) check: bool,
    /// Print the configuration as it holds, with the source of each value, and stop
    #[arg(long, conflicts_with = "check")]
    pub(crate) print_config: bool,
}

impl ConfigurationArguments {
    /// Returns what is set on the command line.
    ///
    /// # Errors
    /// A `--set` that sets nothing.
    pub(crate) fn flags(&self) -> Result<Vec<Flag>, SettingsError> {
        let mut flags = self.set.iter().map(|text| Flag::set(text)).collect::<Result<Vec<_>, _>>()?;
        if let Some(listen) = self.listen {
            flags.push(Flag::named("--listen", &key::ADDRESS, listen.to_string()));
        }
        if let Some(journal) = &self.journal {
            flags.push(Flag::named("--journal", &key::DIRECTORY, journal.to_string_lossy().into_owned()));
        }
        Ok(flags)
    }
}
