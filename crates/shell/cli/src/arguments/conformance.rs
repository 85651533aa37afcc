//! How a client is tested.

use std::net::SocketAddr;

use clap::{Args, Subcommand};

use crate::output::JsonFlag;

/// What `conformance serve` looks at.
const SERVE_HELP: &str = "\
Plays a fixed match in lock-step against one client: seat 0 is the client's. What the client does wrong is told in the end, with
what was expected and the remedy; exit code 1 if there is anything. A client that pings in each cycle with the low 32 bits of the
check that it computed itself is also judged on what it understands: see docs/PROTOCOL.md, section 11.

Example: maniple conformance serve --listen 127.0.0.1:7171
         python3 clients/maniple.py 127.0.0.1 7171 TOKEN --conformance";

#[derive(Debug, Subcommand)]
pub(crate) enum ConformanceCommand {
    /// Play a fixed match against a client and say what it did wrong
    #[command(after_help = "Example: maniple conformance serve --listen 127.0.0.1:0", after_long_help = SERVE_HELP)]
    Serve(ConformanceServe),
}

#[derive(Debug, Args)]
pub(crate) struct ConformanceServe {
    /// Address and port to listen at; port 0 takes any that is free
    #[arg(long, value_name = "ADDRESS", default_value = "127.0.0.1:7171")]
    pub(crate) listen: SocketAddr,
    /// Cut the connection once in mid-match, and see the client come back with its token
    #[arg(long)]
    pub(crate) reconnect: bool,
    /// Seconds that the client has for each answer, 1 to 3600
    #[arg(long, value_name = "SECONDS", default_value_t = 10, value_parser = clap::value_parser!(u32).range(1..=3600))]
    pub(crate) patience: u32,
    #[command(flatten)]
    pub(crate) json: JsonFlag,
}
