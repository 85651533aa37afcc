//! What the program logs, to standard error.

use std::io::IsTerminal;

use maniple_server::settings::{Configuration, LogFormat, SettingsError, key};
use tracing_subscriber::EnvFilter;

use crate::configuration::failure;
use crate::failure::Failure;

/// Begins to log.
pub(crate) fn begin(configuration: &Configuration) -> Result<(), Failure> {
    let log = configuration.log();
    let filter = EnvFilter::try_new(&log.filter).map_err(|error| {
        failure(SettingsError::BadValue {
            origin: configuration.origin(&key::FILTER).clone(),
            key: key::FILTER.path(),
            found: format!("{:?} ({error})", log.filter),
            limit: "a filter, as \"debug\" or \"maniple_server=trace,warn\"".to_owned(),
        })
    })?;
    let builder = tracing_subscriber::fmt().with_env_filter(filter).with_writer(std::io::stderr);
    match log.format {
        LogFormat::Text => {
            let is_plain = std::env::var_os("NO_COLOR").is_some_and(|wish| !wish.is_empty());
            builder.with_ansi(std::io::stderr().is_terminal() && !is_plain).init();
        }
        LogFormat::Json => builder.json().init(),
    }
    Ok(())
}
