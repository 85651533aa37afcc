//! The administration: a Unix socket, a token, and a JSON object a line in both directions.
//!
//! A request is `{"token": "<32 hex digits>", "do": <verb>}`, see [`Verb`]; the answer is `{"ok": …}` or
//! `{"error": {…}, "message": "…"}`, see [`Answer`].

mod socket;

use std::collections::BTreeMap;
use std::net::IpAddr;
use std::sync::Arc;

use maniple_view::{ClockMode, Digest, Seat};
use serde::{Deserialize, Serialize};
use thiserror::Error;
use tokio::task::spawn_blocking;

use super::{Clock, CreatedMatch, Entry, MatchStatus, Operated, OperationError, Seats, Wanted};
use crate::metrics::Metrics;
use crate::settings::Limits;
use crate::token::Token;

pub use socket::{
    ADMIN_CONNECTIONS_MAX, ADMIN_LINE_MAX, ADMIN_TIMEOUT, AdminClient, AdminClientError, AdminServer,
    AdminSocketError, admin_token, read_admin_token,
};

/// What can be asked for.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Verb {
    /// The matches that are open or run.
    List,
    /// Create a match.
    Create {
        /// The name of its scenario.
        scenario: String,
        /// How time passes in it.
        clock: ClockMode,
        /// Who may take its seats.
        seats: Seats,
    },
    /// Halt the clock of a match, or let it go on.
    Pause {
        /// The match.
        r#match: Digest,
        /// What the clock shall do.
        clock: Clock,
    },
    /// Break a match off.
    End {
        /// The match.
        r#match: Digest,
    },
    /// Close the connection at a seat.
    Kick {
        /// The match.
        r#match: Digest,
        /// The seat.
        seat: Seat,
    },
    /// Let an address in no more, or again.
    Ban {
        /// The address.
        address: IpAddr,
        /// Whether it is let in.
        entry: Entry,
    },
    /// Let running matches come to their end, and end the daemon then.
    Drain,
    /// Read the configuration again and put its limits into force; nothing else of it.
    Reload,
}

/// What is asked, and by whom.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct AdminRequest {
    /// The token of the administration.
    pub token: String,
    /// What is to be done.
    #[serde(rename = "do")]
    pub verb: Verb,
}

/// The answer to a request.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(untagged)]
pub enum Answer {
    /// It is done.
    Done {
        /// What there is to tell.
        ok: Told,
    },
    /// It is not done.
    Refused {
        /// Why, for programs.
        error: AdminError,
        /// Why, for people.
        message: String,
    },
}

/// What there is to tell.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Told {
    /// Nothing but that it is done.
    Done,
    /// The matches.
    Matches(Vec<MatchStatus>),
    /// The match that was created.
    Created(CreatedMatch),
    /// The limits that are in force now, with the names of their keys.
    Limits(BTreeMap<&'static str, u64>),
}

/// Why a request is refused.
#[derive(Clone, Debug, Error, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum AdminError {
    /// The line is no request.
    #[error("this is no request: {problem}; write {{\"token\": \"...\", \"do\": \"list\"}}")]
    Malformed {
        /// What is wrong.
        problem: String,
    },
    /// The line is too long.
    #[error("a request has at most {limit} bytes; send a shorter one")]
    TooLong {
        /// The largest number of bytes, without the line end.
        limit: usize,
    },
    /// The token is another.
    #[error(
        "the token is not that of the administration; it is in the file that listen.admin_token_file names"
    )]
    Token,
    /// The daemon cannot do it.
    #[error(transparent)]
    Operation {
        /// Why not.
        #[from]
        reason: OperationError,
    },
    /// The configuration cannot be used.
    #[error("nothing is changed: {problem}")]
    Configuration {
        /// What is wrong with it.
        problem: String,
    },
}

/// Reads the configuration again, and returns its limits, or what is wrong with it.
pub type Reload = Box<dyn Fn() -> Result<Limits, String> + Send + Sync>;

/// Who does what the administration asks for.
pub struct Administration {
    daemon: Arc<dyn Operated>,
    metrics: Arc<Metrics>,
    token: Token,
    reload: Arc<dyn Fn() -> Result<Limits, String> + Send + Sync>,
}

impl Administration {
    /// Returns the administration of a daemon by whoever has the token.
    #[must_use]
    pub fn new(daemon: Arc<dyn Operated>, metrics: Arc<Metrics>, token: Token, reload: Reload) -> Self {
        Self { daemon, metrics, token, reload: reload.into() }
    }

    /// Does what a line asks for, and returns the answer.
    pub(crate) async fn answer(&self, line: &[u8]) -> Answer {
        self.metrics.admin_requests.increment();
        match self.request(line).await {
            Ok(ok) => Answer::Done { ok },
            Err(error) => refusal(error),
        }
    }

    async fn request(&self, line: &[u8]) -> Result<Told, AdminError> {
        let request: AdminRequest = serde_json::from_slice(line)
            .map_err(|error| AdminError::Malformed { problem: error.to_string() })?;
        let is_it = request.token.parse::<Token>().is_ok_and(|token| token.is_same(self.token));
        if !is_it {
            tracing::warn!("a request to the administration had another token");
            return Err(AdminError::Token);
        }
        let told = self.act(&request.verb).await;
        match &told {
            Ok(_) => tracing::info!(verb = ?request.verb, "the administration has acted"),
            Err(error) => tracing::info!(verb = ?request.verb, %error, "the administration could not act"),
        }
        told
    }

    async fn act(&self, verb: &Verb) -> Result<Told, AdminError> {
        match *verb {
            Verb::Create { ref scenario, clock, seats } => {
                let wanted = Wanted { scenario: scenario.clone(), clock, seats };
                return Ok(Told::Created(self.daemon.create(wanted).await?));
            }
            Verb::List => return Ok(Told::Matches(self.daemon.matches())),
            Verb::Pause { r#match, clock } => self.daemon.pause(r#match, clock)?,
            Verb::End { r#match } => self.daemon.end(r#match)?,
            Verb::Kick { r#match, seat } => self.daemon.kick(r#match, seat)?,
            Verb::Ban { address, entry } => self.daemon.ban(address, entry)?,
            Verb::Drain => self.daemon.drain(),
            Verb::Reload => {
                let reload = Arc::clone(&self.reload);
                let read =
                    spawn_blocking(move || reload()).await.unwrap_or_else(|error| Err(error.to_string()));
                let limits = read.map_err(|problem| AdminError::Configuration { problem })?;
                self.daemon.change_limits(limits);
                return Ok(Told::Limits(limits.by_key()));
            }
        }
        Ok(Told::Done)
    }
}

fn refusal(error: AdminError) -> Answer {
    Answer::Refused { message: error.to_string(), error }
}

#[cfg(test)]
mod tests;
