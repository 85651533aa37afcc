//! One match without I/O: seats, clock contract, stalls, results, recording.
//!
//! The same [`Referee`] is driven by a server, by a loop, by a replay and by a test. Whoever drives it hands in what
//! came (`handle_*`), asks [`Referee::is_ready`] or keeps to a rate, calls [`Referee::step`] for each cycle, and
//! takes out what goes to the seats and into the replay (`take_*`).

mod bank;
mod part;
mod pause;
mod record;
mod referee;
mod seat;
mod snapshot;
mod stand;

pub use part::Part;
pub use pause::{PAUSES_MAX, Paused};
pub use record::{RecordedEvent, ReplayError};
pub use referee::Referee;
pub use seat::{FloodError, JoinError, NAME_BYTES_MAX, QUEUED_MAX};
pub use snapshot::{ResumeError, Snapshot};
pub use stand::{HELD_ENTRIES_MAX, Stand, WatchError};
