//! The daemon: a referee over TCP. It moves bytes and waits; what they mean is for the core to say.
//!
//! A [`Server`] listens and receives whoever comes; its [`Lobby`] knows the matches. A few threads play them by turns, each
//! of which owns its referee; each connection has a task. They talk through queues that are bounded in both directions, so neither
//! a flood nor a reader that has stopped reaches a simulation or another player.

mod audience;
mod bans;
mod connection;
mod doors;
mod journal;
mod limits;
mod link;
mod lobby;
mod matches;
pub mod metrics;
mod occupancy;
pub mod operation;
mod pace;
mod pool;
mod queue;
mod reading;
mod recording;
mod server;
pub mod settings;
mod simulation;
mod socket;
mod table;
pub mod tls;
mod token;

pub use audience::SPECTATORS_MAX;
pub use bans::BANS_MAX;
pub use connection::{
    DISCARD_BYTES_MAX, DISCARD_SILENCE, DISCARD_TIMEOUT, HELLO_TIMEOUT, IN_FLIGHT_MAX,
    SPECTATOR_IN_FLIGHT_MAX, Stream, TURN_AWAY_TIMEOUT,
};
pub use doors::{Access, JOIN_INTERVAL, WATCH_INTERVAL};
pub use journal::{JournalError, Journals, Resumed, SYNC_INTERVAL};
pub use limits::Limits;
pub use link::VIOLATIONS_MAX;
pub use lobby::{ASKS_MAX, Lobby, Offer};
pub use matches::{Match, MatchError, RunError};
pub use pace::LATE_PERIODS_MAX;
pub use queue::{CONTROLS_WAITING_MAX, FLUSH_TIMEOUT};
pub use recording::{BUILD, Recording, RecordingError, StartError, events, files, loaded, overrides};
pub use server::{House, Server};
pub use simulation::{EVENTS_BEFORE_STEP_MAX, RETURN_TIMEOUT, SNAPSHOT_CYCLES};
pub use socket::{SEND_BUFFER_SIZE, UNSENT_MAX};
pub use table::NEWS_WAITING_MAX;
pub use token::{Token, TokenError};
