//! The arguments of `maniple admin`.

use std::net::IpAddr;
use std::path::PathBuf;

use clap::{Args, Subcommand};
use maniple_server::operation::administration::Verb;
use maniple_server::operation::{self, Entry, Seats};
use maniple_view::{Digest, Seat};

use crate::arguments::Clock;
use crate::output::JsonFlag;

#[derive(Debug, Args)]
pub(crate) struct Admin {
    /// The socket that listen.admin_socket of the daemon names
    #[arg(long, value_name = "PATH")]
    pub(crate) socket: PathBuf,
    /// The file with the token; without it the socket's name with .token behind
    #[arg(long, value_name = "FILE", conflicts_with = "token")]
    pub(crate) token_file: Option<PathBuf>,
    /// The token itself
    #[arg(long, value_name = "T", env = "MANIPLE_ADMIN_TOKEN", hide_env_values = true)]
    pub(crate) token: Option<String>,
    #[command(flatten)]
    pub(crate) json: JsonFlag,
    #[command(subcommand)]
    pub(crate) verb: AdminVerb,
}

#[derive(Clone, Debug, Subcommand)]
pub(crate) enum AdminVerb {
    /// List the matches that are open or run
    List,
    /// Create a match of a scenario of lobby.scenarios, and print the tokens of its seats
    Create {
        /// The name of the scenario
        scenario: String,
        /// How time passes
        #[arg(long, value_enum, default_value = "realtime")]
        clock: Clock,
        /// Let whoever comes take the seats, without tokens
        #[arg(long)]
        open: bool,
    },
    /// Halt the clock of a match
    Pause {
        /// The match
        #[arg(value_name = "MATCH")]
        id: Digest,
        /// Let it go on again instead
        #[arg(long)]
        off: bool,
    },
    /// Break a match off; its players are told
    End {
        /// The match
        #[arg(value_name = "MATCH")]
        id: Digest,
    },
    /// Close the connection at a seat; the player may come back
    Kick {
        /// The match
        #[arg(value_name = "MATCH")]
        id: Digest,
        /// The seat
        seat: u16,
    },
    /// Let an IP address in no more, and close its connections
    Ban {
        /// The address
        address: IpAddr,
        /// Let it in again instead
        #[arg(long)]
        off: bool,
    },
    /// Let running matches come to their end, create no new ones, and end the daemon then
    Drain,
    /// Let the daemon read its configuration again and put the section [limits] into force
    Reload,
}

impl AdminVerb {
    /// Returns the request.
    pub(crate) fn verb(&self) -> Verb {
        match *self {
            Self::List => Verb::List,
            Self::Create { ref scenario, clock, open } => Verb::Create {
                scenario: scenario.clone(),
                clock: clock.mode(),
                seats: if open { Seats::Open } else { Seats::Tokens },
            },
            Self::Pause { id, off } => Verb::Pause {
                r#match: id,
                clock: if off { operation::Clock::GoOn } else { operation::Clock::Halt },
            },
            Self::End { id } => Verb::End { r#match: id },
            Self::Kick { id, seat } => Verb::Kick { r#match: id, seat: Seat(seat) },
            Self::Ban { address, off } => {
                Verb::Ban { address, entry: if off { Entry::Allowed } else { Entry::Denied } }
            }
            Self::Drain => Verb::Drain,
            Self::Reload => Verb::Reload,
        }
    }
}
