//! Where the configuration comes from: a file, the environment, and the command line.

use std::path::Path;

use anyhow::Context;
use maniple_server::settings::{Configuration, Flag, Origin, SettingsError, key};

use crate::arguments::{Arguments, Command, ConfigurationArguments};
use crate::failure::Failure;
use crate::files;

/// Variables that every command minds; the others are those of the daemon.
const LOG_VARIABLES: &str = "MANIPLE_LOG_";

/// Returns the configuration: of the daemon all of it, of other commands what they log.
pub(crate) fn resolve(arguments: &Arguments) -> Result<Configuration, Failure> {
    let mut flags = Vec::new();
    if let Some(filter) = &arguments.log {
        flags.push(Flag::named("--log", &key::FILTER, filter.clone()));
    }
    if let Some(format) = &arguments.log_format {
        flags.push(Flag::named("--log-format", &key::FORMAT, format.clone()));
    }
    match &arguments.command {
        Command::Serve(serve) => of_daemon(&serve.configuration, &flags),
        Command::Map(_)
        | Command::Simulate(_)
        | Command::Match(_)
        | Command::Bot(_)
        | Command::Conformance(_)
        | Command::Watch(_)
        | Command::Admin(_)
        | Command::Replay(_)
        | Command::Bench(_) => {
            let is_minded = |name: &str| name.starts_with(LOG_VARIABLES);
            let environment = std::env::vars_os().filter(|(name, _)| name.to_str().is_some_and(is_minded));
            Configuration::resolve(None, environment, &flags).map_err(failure)
        }
    }
}

/// Returns the configuration of the daemon; `more` holds over what the arguments say.
pub(crate) fn of_daemon(arguments: &ConfigurationArguments, more: &[Flag]) -> Result<Configuration, Failure> {
    let mut flags = arguments.flags().map_err(failure)?;
    flags.extend_from_slice(more);
    let file = arguments.config.as_deref().map(|path| Ok((path, text_of(path)?))).transpose()?;
    let file = file.as_ref().map(|(path, text)| (*path, text.as_str()));
    Configuration::resolve(file, std::env::vars_os(), &flags).map_err(failure)
}

fn text_of(path: &Path) -> Result<String, Failure> {
    let text = String::from_utf8(files::read(path)?);
    text.with_context(|| format!("{}: the file has to be UTF-8", path.display())).map_err(Failure::BadInput)
}

/// Returns whether it is the command line or an input that is wrong.
pub(crate) fn failure(error: SettingsError) -> Failure {
    let is_flag =
        matches!(error, SettingsError::BadFlag { .. }) || matches!(error.origin(), Some(Origin::Flag { .. }));
    if is_flag { Failure::usage(error.to_string()) } else { Failure::bad_input(error) }
}
