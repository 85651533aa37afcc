//! The arguments about encrypted connections.

use std::net::SocketAddr;
use std::path::PathBuf;

use anyhow::Context;
use clap::Args;
use maniple_client::{Destination, Tls};

use crate::failure::Failure;

#[derive(Debug, Args)]
pub(crate) struct TlsArguments {
    /// Speak TLS to the server, and believe only who shows a certificate for the address of --connect
    #[arg(long)]
    tls: bool,
    /// PEM file with the server's certificate, or that of who vouches for it; without it those that the system trusts
    #[arg(long, value_name = "FILE", requires = "tls")]
    ca: Option<PathBuf>,
    /// The name that the certificate has to have, if it is not the IP address
    #[arg(long, value_name = "NAME", requires = "tls")]
    server_name: Option<String>,
}

impl TlsArguments {
    /// Returns the address of a server that is spoken to so.
    pub(crate) fn server(&self, server: SocketAddr) -> Result<Destination, Failure> {
        if !self.tls {
            return Ok(Destination::from(server.to_string()));
        }
        let name = self.server_name.clone().unwrap_or_else(|| server.ip().to_string());
        let tls = Tls::new(&name, self.ca.as_deref()).context("--tls").map_err(Failure::BadInput)?;
        Ok(Destination::from(server.to_string()).encrypted(tls))
    }
}
