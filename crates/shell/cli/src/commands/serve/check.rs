//! What `maniple serve` says of its configuration without serving.

use std::path::Path;

use maniple_game::Overrides;
use maniple_server::operation::administration::read_admin_token;
use maniple_server::settings::{Configuration, Origin, Settings, key};
use maniple_server::tls;
use serde::Serialize;

use crate::arguments::Serve;
use crate::failure::Failure;
use crate::output::{Format, print};
use crate::start;

/// A key of the configuration as it holds.
#[derive(Debug, Serialize)]
struct Held {
    key: String,
    /// As TOML writes it.
    value: String,
    source: Origin,
}

/// Prints the configuration with the source of each value.
pub(super) fn print_configuration(arguments: &Serve, configuration: &Configuration) -> Result<(), Failure> {
    let held = configuration.values().map(|(key, value, origin)| Held {
        key: key.path(),
        value,
        source: origin.clone(),
    });
    let held: Vec<Held> = held.collect();
    print(Format::of(&arguments.json), &held, |_| configuration.text())
}

/// What was looked at, and found right.
#[derive(Debug, Serialize)]
struct Checked {
    /// The configuration file; null: there is none.
    file: Option<String>,
    /// The files and folders that it names.
    files: Vec<String>,
}

impl Checked {
    fn text(&self) -> String {
        let file = self.file.as_deref().unwrap_or("without a file");
        let mut text = format!("the configuration is right: {file}\n");
        for file in &self.files {
            text.push_str(&format!("checked {file}\n"));
        }
        text
    }
}

/// Reads all that the configuration names, and says that it is right.
pub(super) fn check(
    arguments: &Serve,
    configuration: &Configuration,
    settings: &Settings,
) -> Result<(), Failure> {
    let mut files = Vec::new();
    let mut checked = |path: &Path| files.push(path.display().to_string());
    let at = |key: &key::Key| format!("{}: {}", configuration.origin(key), key.path());
    if let Some(pair) = &settings.listen.tls {
        tls::acceptor(pair).map_err(|error| in_key(error, at(&key::TLS_CERTIFICATE)))?;
        checked(&pair.certificate);
        checked(&pair.key);
    }
    if let Some(admin) = &settings.listen.admin
        && admin.token.exists()
    {
        read_admin_token(&admin.token).map_err(|error| in_key(error, at(&key::ADMIN_SOCKET)))?;
        checked(&admin.token);
    }
    for (name, file) in &settings.lobby.scenarios {
        let loaded = start::loaded(Some(file), &Overrides::default());
        loaded.map_err(|failure| failure.within(Path::new(&format!("{}.{name}", at(&key::SCENARIOS)))))?;
        checked(file);
    }
    if let Some(scenario) = &arguments.scenario {
        start::loaded(Some(scenario), &Overrides::default())?;
        checked(scenario);
    }
    if let Some(directory) = &settings.journal.directory {
        // It is made at the start; what is in its way is not cleared.
        if directory.exists() && !directory.is_dir() {
            let problem = anyhow::anyhow!("{} is no folder; name one, or none", directory.display());
            return Err(Failure::BadInput(problem.context(at(&key::DIRECTORY))));
        }
        checked(directory);
    }
    let file = arguments.configuration.config.as_ref().map(|path| path.display().to_string());
    print(Format::of(&arguments.json), &Checked { file, files }, Checked::text)
}

fn in_key(error: impl Into<anyhow::Error>, place: String) -> Failure {
    Failure::BadInput(error.into().context(place))
}
