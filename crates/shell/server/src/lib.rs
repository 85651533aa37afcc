//! The daemon: a referee over TCP. It moves bytes and waits; what they mean is for the core to say.
//!
//! A [`Server`] listens and plays one [`Match`] after the other. The simulation has a thread of its own, which owns
//! the referee; each connection has a task. They talk through queues that are bounded in both directions, so neither
//! a flood nor a reader that has stopped reaches the simulation or another player.

mod audience;
mod connection;
mod doors;
mod link;
mod pace;
mod queue;
mod recording;
mod server;
mod simulation;
mod table;
mod token;

pub use audience::SPECTATORS_MAX;
pub use connection::{
    DISCARD_BYTES_MAX, DISCARD_SILENCE, DISCARD_TIMEOUT, HELLO_TIMEOUT, IN_FLIGHT_MAX,
    SPECTATOR_IN_FLIGHT_MAX,
};
pub use doors::{Access, JOIN_INTERVAL};
pub use link::VIOLATIONS_MAX;
pub use pace::LATE_PERIODS_MAX;
pub use queue::{CONTROLS_WAITING_MAX, FLUSH_TIMEOUT};
pub use recording::{BUILD, Recording, RecordingError, events, files, overrides};
pub use server::{CONNECTIONS_MAX, Match, MatchError, RunError, SEND_BUFFER_SIZE, Server};
pub use simulation::EVENTS_BEFORE_STEP_MAX;
pub use table::NEWS_WAITING_MAX;
pub use token::{Token, TokenError};
