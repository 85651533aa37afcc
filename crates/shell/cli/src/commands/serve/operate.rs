//! Those who operate the daemon: over HTTP, over the socket of the administration, and as its service manager.

use std::net::TcpListener;
use std::sync::Arc;

use anyhow::Context;
use maniple_server::operation::administration::{AdminServer, Administration, Reload, admin_token};
use maniple_server::operation::http::HttpServer;
use maniple_server::operation::{Operated, systemd};
use maniple_server::settings::Settings;
use maniple_server::{House, Server};
use tokio::task::JoinSet;

use crate::arguments::{ConfigurationArguments, Serve};
use crate::configuration::of_daemon;
use crate::failure::Failure;
use crate::interrupt::Interrupt;

/// Returns the socket that the service manager has opened, if it has. To be called before there are other threads.
pub(super) fn inherited() -> Result<Option<TcpListener>, Failure> {
    systemd::inherited_listener().map_err(Failure::bad_input)
}

/// Who operates the daemon, until they are dismissed.
pub(super) struct Operators {
    house: House,
    http: Option<String>,
    tasks: JoinSet<()>,
}

impl Operators {
    /// Opens the ways in that the settings name.
    pub(super) async fn admit(
        arguments: &Serve,
        settings: &Settings,
        server: &Server,
        mut interrupt: Interrupt,
    ) -> Result<Self, Failure> {
        let daemon: Arc<dyn Operated> = Arc::new(server.house().clone());
        let metrics = server.house().metrics();
        let house = server.house().clone();
        let mut operators = Self { house, http: None, tasks: JoinSet::new() };
        if let Some(address) = settings.listen.http {
            let http = HttpServer::bind(address).await;
            let http = http.with_context(|| format!("listen.http: cannot listen on {address}"));
            let http = http.map_err(Failure::Failed)?;
            operators.http = Some(http.local_addr().map_err(Failure::failed)?.to_string());
            operators.tasks.spawn(http.run(Arc::clone(&daemon), Arc::clone(metrics)));
        }
        if let Some(files) = &settings.listen.admin {
            let token = admin_token(&files.token).map_err(Failure::bad_input)?;
            let socket = AdminServer::bind(&files.socket).map_err(Failure::failed)?;
            let reload = reload(arguments.configuration.clone());
            let administration = Administration::new(Arc::clone(&daemon), Arc::clone(metrics), token, reload);
            operators.tasks.spawn(socket.run(Arc::new(administration)));
        }
        operators.tasks.spawn(systemd::keep_telling(daemon));
        operators.tasks.spawn(async move {
            interrupt.wait().await;
            systemd::tell_stopping();
        });
        Ok(operators)
    }

    /// Returns where the daemon answers over HTTP.
    pub(super) fn http(&self) -> Option<String> {
        self.http.clone()
    }

    /// Tells all who operate the daemon that clients can connect.
    pub(super) fn tell_ready(&self, address: &str) {
        self.house.note_ready();
        systemd::tell_ready(&format!("listening on {address}"));
    }

    /// Tells the service manager that the daemon ends, if it has not heard, and closes the ways in.
    pub(super) async fn dismiss(mut self) {
        systemd::tell_stopping();
        self.tasks.shutdown().await;
    }
}

/// Returns what reads the configuration again.
fn reload(arguments: ConfigurationArguments) -> Reload {
    Box::new(move || {
        let configuration = of_daemon(&arguments, &[]).map_err(|failure| failure.cause())?;
        Ok(configuration.limits())
    })
}
