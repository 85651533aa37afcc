//! A match that is to be played, and who may play it.

use std::io::{self, Write};

use maniple_game::Loaded;
use maniple_geometry::Cycle;
use maniple_protocol::encode_snapshot;
use maniple_referee::Referee;
use maniple_view::{ClockMode, Digest, Seat};
use thiserror::Error;

use crate::audience::SPECTATORS_MAX;
use crate::doors::Access;
use crate::journal::{Journal, JournalError};
use crate::recording::{Recording, RecordingError};
use crate::token::Token;

/// Where what happens goes.
pub(crate) enum Sink {
    /// A replay for whoever asked for it.
    Replay(Box<dyn Write + Send>),
    /// A journal, from which the match can be taken up again.
    Journal(Journal),
}

impl Write for Sink {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        match self {
            Self::Replay(sink) => sink.write(bytes),
            Self::Journal(journal) => {
                journal.write(bytes);
                Ok(bytes.len())
            }
        }
    }

    fn flush(&mut self) -> io::Result<()> {
        match self {
            Self::Replay(sink) => sink.flush(),
            Self::Journal(journal) => journal.commit(),
        }
    }
}

impl Recording<Sink> {
    /// Sees to it that what was recorded is not lost with this process, where it is a journal.
    ///
    /// # Errors
    /// A journal that cannot be kept.
    pub(crate) fn commit(&mut self) -> Result<(), RecordingError> {
        match self.sink() {
            Sink::Replay(_) => Ok(()),
            Sink::Journal(journal) => journal.commit().map_err(RecordingError::Write),
        }
    }

    /// Keeps a snapshot beside the journal, where there is one. A match goes on without it, only more slowly.
    pub(crate) fn keep_snapshot(&mut self, referee: &Referee) {
        match self.sink() {
            Sink::Replay(_) => {}
            Sink::Journal(journal) => match encode_snapshot(&referee.snapshot()) {
                Ok(bytes) => journal.keep_snapshot(&bytes),
                Err(error) => tracing::warn!(%error, "a match is too large for a snapshot"),
            },
        }
    }

    /// Ends the recording of a match that has ended, or goes on another time.
    ///
    /// # Errors
    /// What cannot be written.
    pub(crate) fn end(self, has_ended: bool) -> Result<(), RecordingError> {
        match self.finish()? {
            Sink::Journal(journal) if has_ended => Ok(journal.archive()?),
            Sink::Replay(_) | Sink::Journal(_) => Ok(()),
        }
    }

    /// Ends the recording of a match that has failed.
    pub(crate) fn give_up(self, fault: &str) {
        match self.into_sink() {
            Sink::Replay(_) => {}
            Sink::Journal(journal) => journal.give_up(fault),
        }
    }
}

/// What is known of how a match began: nothing yet is recorded, or it goes on.
pub(crate) enum Beginning {
    /// It begins; the replay goes there, if anywhere.
    Fresh(Option<Box<dyn Write + Send>>),
    /// It goes on.
    Resumed(Recording<Sink>),
}

/// A match that is to be played, and who may play it.
pub struct Match {
    pub(crate) referee: Referee,
    pub(crate) id: Digest,
    pub(crate) access: Vec<Access>,
    pub(crate) beginning: Beginning,
    pub(crate) spectators_max: usize,
}

/// A match that cannot be set up.
#[derive(Clone, Copy, Debug, Error)]
pub enum MatchError {
    /// The operating system gives no random bits.
    #[error("the operating system gives no random bits: {0}")]
    Random(#[from] getrandom::Error),
    /// Not one entry a seat.
    #[error("the match has {seats} seats, but access is given for {given}")]
    Access {
        /// How many were given.
        given: usize,
        /// How many seats there are.
        seats: usize,
    },
}

/// Why a match could not be played to its end.
#[derive(Debug, Error)]
pub enum RunError {
    /// It cannot be recorded.
    #[error(transparent)]
    Recording(#[from] RecordingError),
    /// No journal can be begun for it.
    #[error(transparent)]
    Journal(#[from] JournalError),
    /// The simulation has panicked, which is a mistake of this program.
    #[error("the simulation has panicked: {message}")]
    Panicked {
        /// What it panicked with; empty where that is no text.
        message: String,
    },
}

impl RunError {
    /// Returns the error of a simulation that was dropped before it had told its outcome.
    pub(crate) fn gone() -> Self {
        Self::Panicked { message: "it has ended without an outcome".to_owned() }
    }
}

impl Match {
    /// Returns a match with a random token for each seat; see [`Self::access`].
    ///
    /// # Errors
    /// An operating system without random bits.
    pub fn with_random_tokens(referee: Referee) -> Result<Self, MatchError> {
        let token = |_| Token::random().map(Access::Token);
        let access = (0..referee.seats()).map(token).collect::<Result<_, _>>()?;
        Self::new(referee, access)
    }

    /// Returns a match with these rights of access, in order of the seats.
    ///
    /// # Errors
    /// Not one entry a seat, or an operating system without random bits.
    pub fn new(mut referee: Referee, access: Vec<Access>) -> Result<Self, MatchError> {
        let (given, seats) = (access.len(), referee.seats());
        if given != seats {
            return Err(MatchError::Access { given, seats });
        }
        let mut id = [0; 8];
        getrandom::fill(&mut id)?;
        referee.open_stands();
        let id = Digest(u64::from_le_bytes(id));
        let beginning = Beginning::Fresh(None);
        Ok(Self { referee, id, access, beginning, spectators_max: SPECTATORS_MAX })
    }

    /// Returns a match that goes on where its recording ends; its players have to come back.
    pub(crate) fn resumed(
        mut referee: Referee,
        id: Digest,
        access: Vec<Access>,
        recording: Recording<Sink>,
    ) -> Self {
        for seat in (0..).map(Seat).take(referee.seats()) {
            referee.handle_leave(seat);
        }
        let beginning = Beginning::Resumed(recording);
        Self { referee, id, access, beginning, spectators_max: SPECTATORS_MAX }
    }

    /// Lets the replay of the match go to `sink` as it is played; of a match that is broken off, up to there. The
    /// simulation writes, so `sink` must not wait for anybody, and should be buffered. Without it nothing is recorded. Has no effect
    /// where there is a journal.
    #[must_use]
    pub fn recorded_to(mut self, sink: impl Write + Send + 'static) -> Self {
        self.beginning = Beginning::Fresh(Some(Box::new(sink)));
        self
    }

    /// Lets at most so many watch at the same time, and not [`SPECTATORS_MAX`].
    ///
    /// # Panics
    /// For more than that.
    #[must_use]
    pub fn watched_by_at_most(mut self, spectators_max: usize) -> Self {
        assert!(spectators_max <= SPECTATORS_MAX, "a match has a limit of spectators");
        self.spectators_max = spectators_max;
        self
    }

    /// Returns who may take which seat.
    #[must_use]
    pub fn access(&self) -> &[Access] {
        &self.access
    }

    /// Returns the cycle at whose start it is: 0, or where it goes on.
    #[must_use]
    pub fn cycle(&self) -> Cycle {
        self.referee.cycle()
    }

    /// Returns the state hash there.
    #[must_use]
    pub fn hash(&self) -> Digest {
        self.referee.hash()
    }

    /// Returns how time passes in it.
    #[must_use]
    pub fn clock(&self) -> ClockMode {
        self.referee.mode()
    }

    /// Returns what it was loaded from.
    #[must_use]
    pub fn loaded(&self) -> &Loaded {
        self.referee.loaded()
    }

    /// Returns its seed.
    #[must_use]
    pub fn seed(&self) -> u64 {
        self.referee.loaded().scenario.seed
    }

    /// Returns the number of the match, as clients are told.
    #[must_use]
    pub fn id(&self) -> Digest {
        self.id
    }
}
