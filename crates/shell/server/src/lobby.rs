//! The matches of a server: which there are, who may create one, and the way into each.

use std::collections::BTreeMap;
use std::net::IpAddr;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use maniple_game::scenario::Views;
use maniple_game::{Files, Loaded, Overrides, load};
use maniple_protocol::{Create, Listed, ListedSeat, ListedSpectators, Refused, ServerMessage};
use maniple_referee::Referee;
use maniple_view::Digest;
use tokio::sync::{Notify, oneshot};
use tokio::task::spawn_blocking;
use tokio_util::sync::CancellationToken;

use crate::connection::Gate;
use crate::doors::{Access, Doors};
use crate::journal::{JournalError, Journals, Resumed};
use crate::limits::{Addresses, Limits, Place};
use crate::matches::{Beginning, Match, MatchError, RunError, Sink};
use crate::metrics::Metrics;
use crate::occupancy::Occupancy;
use crate::operation::MatchStatus;
use crate::pool::Pool;
use crate::recording::Recording;
use crate::simulation::{Event, Mailbox, Outcome, Played, Simulation};
use crate::table::Table;

/// How often a connection may ask the lobby before it says which match it is for.
pub const ASKS_MAX: u32 = 16;

/// A scenario of which clients may create matches: its files, the scenario first.
#[derive(Clone, Debug)]
pub struct Offer {
    /// The files.
    pub files: Files,
    /// The path of the scenario among them.
    pub scenario: String,
}

/// The matches of a server.
#[derive(Debug)]
pub struct Lobby {
    pool: Pool,
    limits: Mutex<Limits>,
    metrics: Arc<Metrics>,
    offers: BTreeMap<String, Offer>,
    is_closed_to_clients: AtomicBool,
    creators: Addresses,
    /// `None` where nothing is kept of a match that is broken off.
    journals: Option<Journals>,
    board: Mutex<Board>,
    /// A match is gone.
    changed: Notify,
}

#[derive(Debug, Default)]
struct Board {
    /// By number.
    open: BTreeMap<u64, Open>,
    /// The match that a hello without a match is for.
    standing: Option<u64>,
    /// Whether no match is taken in any more.
    is_draining: bool,
}

/// A match that is played or waits for its players.
#[derive(Debug)]
struct Open {
    gate: Gate,
    loaded: Notice,
    occupancy: Arc<Occupancy>,
    /// `None` where whoever runs the server opened it.
    _creator: Option<Place>,
}

/// What everybody may know of a match that does not change.
#[derive(Clone, Debug)]
struct Notice {
    scenario: String,
    clock: maniple_view::ClockMode,
    rate: f64,
    is_open: Vec<bool>,
    spectators: Option<ListedSpectators>,
}

/// A match that has been taken in.
#[derive(Debug)]
pub(crate) struct Opened {
    pub(crate) id: Digest,
    pub(crate) finished: oneshot::Receiver<Outcome>,
}

impl Lobby {
    /// Returns a lobby without a match.
    pub(crate) fn new(
        pool: Pool,
        limits: Limits,
        offers: BTreeMap<String, Offer>,
        journals: Option<Journals>,
    ) -> Self {
        let (creators, board) = (Addresses::default(), Mutex::default());
        let (limits, metrics) = (Mutex::new(limits), Arc::default());
        let is_closed_to_clients = AtomicBool::new(false);
        let changed = Notify::new();
        Self { pool, limits, metrics, offers, is_closed_to_clients, creators, journals, board, changed }
    }

    /// Returns the matches that a daemon has left in the folder of journals, and why others are not taken up.
    ///
    /// # Errors
    /// A folder that cannot be read.
    pub fn resume(&self) -> Result<Resumed, JournalError> {
        self.journals.as_ref().map_or_else(|| Ok(Resumed::default()), Journals::resume)
    }

    /// Takes in a match, new or one that goes on, beside the others.
    ///
    /// # Errors
    /// What cannot be recorded.
    pub fn take_in(self: &Arc<Self>, game: Match) -> Result<(), RunError> {
        let opened = self.open(game, None, None)?;
        self.let_go_on(opened);
        Ok(())
    }

    fn let_go_on(self: &Arc<Self>, opened: Opened) {
        let lobby = Arc::clone(self);
        tokio::spawn(async move { lobby.see_to_the_end(opened).await });
    }

    /// Returns what is allowed.
    #[must_use]
    pub fn limits(&self) -> Limits {
        *self.limits.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Puts other limits into force; returns those before.
    pub(crate) fn change_limits(&self, limits: Limits) -> Limits {
        std::mem::replace(&mut *self.limits.lock().unwrap_or_else(PoisonError::into_inner), limits)
    }

    /// Returns what it counts.
    #[must_use]
    pub fn metrics(&self) -> &Arc<Metrics> {
        &self.metrics
    }

    fn board(&self) -> MutexGuard<'_, Board> {
        // What it guards is changed in single steps, so it is whole even then.
        self.board.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Takes a match in, to which a connection comes that names none.
    ///
    /// # Errors
    /// What cannot be recorded.
    pub(crate) fn open_standing(&self, game: Match) -> Result<Opened, RunError> {
        let opened = self.open(game, None, None)?;
        self.board().standing = Some(opened.id.0);
        Ok(opened)
    }

    fn open(
        &self,
        game: Match,
        creator: Option<Place>,
        begin_within: Option<Duration>,
    ) -> Result<Opened, RunError> {
        let Match { referee, id, access, beginning, spectators_max } = game;
        let loaded = Notice::new(&referee, &access);
        let is_resumed = matches!(beginning, Beginning::Resumed(_));
        let recording = match (beginning, &self.journals) {
            (Beginning::Resumed(recording), _) => Some(recording),
            (Beginning::Fresh(_), Some(journals)) => {
                let journal = journals.create(id, referee.mode(), &access)?;
                Some(Recording::begin(referee.loaded(), Sink::Journal(journal))?)
            }
            (Beginning::Fresh(sink), None) => {
                let begin = |sink| Recording::begin(referee.loaded(), Sink::Replay(sink));
                sink.map(begin).transpose()?
            }
        };
        let doors = Arc::new(Doors::new(access, spectators_max));
        let table = Table::new(Arc::clone(&doors));
        let (finished, outcome) = oneshot::channel();
        let occupancy = Arc::new(Occupancy::new(Arc::clone(&self.metrics)));
        self.metrics.matches.change(1);
        self.pool.enter(|waker| {
            let (mailbox, events) = Mailbox::new(waker);
            let gate = Gate { mailbox, doors, ended: CancellationToken::new() };
            let open = Open { gate, loaded, occupancy: Arc::clone(&occupancy), _creator: creator };
            self.board().open.insert(id.0, open);
            let played = Played {
                referee,
                id,
                table,
                recording,
                events,
                finished,
                occupancy,
                begin_within,
                is_resumed,
            };
            Simulation::new(played)
        });
        Ok(Opened { id, finished: outcome })
    }

    /// Takes a match off the board, so that nobody comes to it any more, and sends away who waits at its doors.
    pub(crate) fn forget(&self, id: Digest) {
        let mut board = self.board();
        if board.standing == Some(id.0) {
            board.standing = None;
        }
        if let Some(open) = board.open.remove(&id.0) {
            open.gate.ended.cancel();
            self.metrics.matches.change(-1);
        }
        drop(board);
        self.changed.notify_one();
    }

    /// Waits until a match is gone, or one has gone since the last time.
    pub(crate) async fn wait_change(&self) {
        self.changed.notified().await;
    }

    /// Breaks all matches off; they are told.
    pub(crate) fn shut_down(&self) {
        let mut board = self.board();
        board.is_draining = true;
        for open in board.open.values() {
            // One that has ended by itself has nothing left to break off.
            let _ = open.gate.mailbox.send(Event::Shutdown);
        }
    }

    /// Takes no further match in.
    pub fn drain(&self) {
        self.board().is_draining = true;
        self.changed.notify_one();
    }

    /// Returns whether no further match is taken in.
    #[must_use]
    pub fn is_draining(&self) -> bool {
        self.board().is_draining
    }

    /// Hands an event to a match; `None`: there is no such match.
    pub(crate) fn send(&self, id: Digest, event: Event) -> Option<()> {
        let board = self.board();
        let open = board.open.get(&id.0)?;
        // One that has ended and is about to be forgotten has nothing to do with it any more.
        let _ = open.gate.mailbox.send(event);
        Some(())
    }

    /// Returns the longest time for which a match has waited for its turn, or has had one.
    pub(crate) fn longest_wait(&self) -> Duration {
        self.pool.longest_wait()
    }

    /// Returns the matches as operators see them.
    pub(crate) fn statuses(&self) -> Vec<MatchStatus> {
        self.board().open.iter().map(|(&id, open)| open.status(Digest(id))).collect()
    }

    /// Returns by seat whether somebody sits there; `None`: there is no such match.
    pub(crate) fn taken(&self, id: Digest) -> Option<Vec<bool>> {
        let board = self.board();
        let open = board.open.get(&id.0)?;
        Some((0..open.loaded.is_open.len()).map(|seat| open.occupancy.is_taken(seat)).collect())
    }

    /// Returns whether all seats of a match have been joined; one that is gone has not begun.
    #[must_use]
    pub fn has_begun(&self, id: Digest) -> bool {
        self.board().open.get(&id.0).is_some_and(|open| open.occupancy.has_begun())
    }

    /// Returns how many matches there are.
    #[must_use]
    pub fn matches(&self) -> usize {
        self.board().open.len()
    }

    /// Returns the way into a match, or into the one that is for whoever names none.
    ///
    /// # Errors
    /// The reason that the client is told.
    pub(crate) fn gate(&self, chosen: Option<Digest>) -> Result<Gate, Refused> {
        let board = self.board();
        let id = chosen.map(|id| id.0).or(board.standing);
        id.and_then(|id| board.open.get(&id)).map(|open| open.gate.clone()).ok_or(Refused::NoMatch)
    }

    /// Returns the answer to `list`.
    pub(crate) fn list(&self) -> ServerMessage {
        let listed = |(&id, open): (&u64, &Open)| open.listed(Digest(id));
        let list = self.board().open.iter().map(listed).collect();
        ServerMessage::Matches { scenarios: self.offers_to_clients().keys().cloned().collect(), list }
    }

    /// Creates a match for a client, and returns the answer to `create`.
    ///
    /// # Errors
    /// The reason that the client is told.
    pub(crate) async fn create(
        self: &Arc<Self>,
        wanted: Create,
        address: IpAddr,
    ) -> Result<ServerMessage, Refused> {
        if !self.offers_to_clients().contains_key(&wanted.scenario) {
            return Err(Refused::NoScenario);
        }
        self.check_room()?;
        let limit = self.limits().matches_per_address;
        let full = || Refused::AddressFull { limit: u32::try_from(limit).unwrap_or(u32::MAX) };
        let place = self.creators.take(address, limit).ok_or_else(full)?;
        let (match_id, tokens) = self.create_for(wanted, Some(place)).await?;
        tracing::info!(id = %match_id, %address, "a match is created");
        Ok(ServerMessage::Created { match_id, tokens })
    }

    /// Creates a match, and returns its number and by seat the token that opens it; none where all are open. `place` is that of the
    /// client whom it is for.
    ///
    /// # Errors
    /// The reason that a client is told.
    pub(crate) async fn create_for(
        self: &Arc<Self>,
        wanted: Create,
        place: Option<Place>,
    ) -> Result<(Digest, Vec<String>), Refused> {
        let offer = self.offers.get(&wanted.scenario).cloned().ok_or(Refused::NoScenario)?;
        self.check_room()?;
        // Walls and visibility of a large map take a while, in which others want to be served.
        let lobby = Arc::clone(self);
        let made = spawn_blocking(move || {
            let game = make(&offer, &wanted)?;
            lobby.check_room()?;
            let access = game.access().to_vec();
            let opened = lobby
                .open(game, place, Some(lobby.limits().begin_within))
                .map_err(|error| unmade(&wanted.scenario, &error))?;
            Ok((opened, access))
        });
        let (opened, access) = made.await.map_err(|_| Refused::Broken)??;
        let token = |access: &Access| match access {
            Access::Open => None,
            Access::Token(token) => Some(token.to_string()),
        };
        let id = opened.id;
        self.let_go_on(opened);
        Ok((id, access.iter().filter_map(token).collect()))
    }

    /// Lets clients create no matches: only whoever runs the server does.
    pub(crate) fn close_to_clients(&self) {
        self.is_closed_to_clients.store(true, Ordering::Relaxed);
    }

    /// Returns the scenarios of which clients may create matches.
    fn offers_to_clients(&self) -> &BTreeMap<String, Offer> {
        static NONE: BTreeMap<String, Offer> = BTreeMap::new();
        if self.is_closed_to_clients.load(Ordering::Relaxed) { &NONE } else { &self.offers }
    }

    /// Waits for the end of a match that nobody else waits for.
    pub(crate) async fn see_to_the_end(&self, opened: Opened) {
        let outcome = opened.finished.await.unwrap_or_else(|_| Err(RunError::gone()));
        self.forget(opened.id);
        match outcome {
            Ok(Some(result)) => {
                tracing::info!(id = %opened.id, winners = ?result.winners, cycles = result.cycles.0, "a match has ended");
            }
            Ok(None) => tracing::info!(id = %opened.id, "a match was broken off"),
            Err(error) => tracing::error!(id = %opened.id, %error, "a match has failed"),
        }
    }

    fn check_room(&self) -> Result<(), Refused> {
        let board = self.board();
        if board.is_draining {
            return Err(Refused::Draining);
        }
        let limit = self.limits().matches;
        if board.open.len() < limit {
            return Ok(());
        }
        Err(Refused::MatchesFull { limit: u32::try_from(limit).unwrap_or(u32::MAX) })
    }
}

impl Drop for Lobby {
    fn drop(&mut self) {
        self.pool.close();
    }
}

/// Returns a match of a scenario, with a seed that nobody knows.
fn make(offer: &Offer, wanted: &Create) -> Result<Match, Refused> {
    let mut seed = [0; 8];
    getrandom::fill(&mut seed).map_err(|error| unmade(&wanted.scenario, &error))?;
    let overrides = Overrides { seed: Some(u64::from_le_bytes(seed)), ..Overrides::default() };
    let loaded: Loaded =
        load(&offer.files, &offer.scenario, &overrides).map_err(|error| unmade(&wanted.scenario, &error))?;
    let referee = Referee::new(loaded, wanted.clock).map_err(|error| unmade(&wanted.scenario, &error))?;
    let seats = referee.seats();
    let game = if wanted.open {
        Match::new(referee, vec![Access::Open; seats])
    } else {
        Match::with_random_tokens(referee)
    };
    game.map_err(|error: MatchError| unmade(&wanted.scenario, &error))
}

/// Logs why a match cannot be made, which is not the client's mistake, and returns what the client is told.
fn unmade(scenario: &str, error: &dyn std::fmt::Display) -> Refused {
    tracing::error!(scenario, %error, "a match cannot be created");
    Refused::Draining
}

impl Notice {
    fn new(referee: &Referee, access: &[Access]) -> Self {
        let scenario = &referee.loaded().scenario;
        let is_open = |access: &Access| matches!(access, Access::Open);
        let watchable = |spectators: maniple_game::scenario::Spectators| ListedSpectators {
            everything: spectators.views == Views::All,
            delay: spectators.delay,
        };
        Self {
            scenario: scenario.name.clone(),
            clock: referee.mode(),
            rate: referee.rate(),
            is_open: access.iter().map(is_open).collect(),
            spectators: scenario.spectators.map(watchable),
        }
    }
}

impl Open {
    fn status(&self, id: Digest) -> MatchStatus {
        let Notice { scenario, clock, is_open, .. } = &self.loaded;
        let taken = (0..is_open.len()).filter(|&seat| self.occupancy.is_taken(seat)).count();
        let seats = |count: usize| u16::try_from(count).expect("seats are counted in 16 bits");
        MatchStatus {
            id,
            scenario: scenario.clone(),
            clock: *clock,
            phase: self.occupancy.phase(),
            cycle: self.occupancy.cycle(),
            seats: seats(is_open.len()),
            players: seats(taken),
            spectators: self.occupancy.spectators(),
            timings_ms: self.occupancy.timings(),
        }
    }

    fn listed(&self, match_id: Digest) -> Listed {
        let Notice { scenario, clock, rate, is_open, spectators } = &self.loaded;
        let seat = |(seat, &open): (usize, &bool)| ListedSeat { open, taken: self.occupancy.is_taken(seat) };
        Listed {
            match_id,
            scenario: scenario.clone(),
            clock: *clock,
            rate: *rate,
            has_begun: self.occupancy.has_begun(),
            seats: is_open.iter().enumerate().map(seat).collect(),
            spectators: *spectators,
        }
    }
}

#[cfg(test)]
mod tests {
    use std::sync::mpsc::{Receiver, Sender, channel};

    use tokio::time::advance;

    use super::*;
    use crate::operation::{Health, Operated, STUCK_AFTER};
    use crate::pool::{Player, Turn};
    use crate::server::House;

    /// Has a turn that lasts until it is released.
    struct Slow(Sender<()>, Receiver<()>);

    impl Player for Slow {
        fn turn(&mut self) -> Turn {
            self.0.send(()).unwrap();
            self.1.recv().unwrap();
            Turn::Over
        }
    }

    #[tokio::test(start_paused = true)]
    async fn a_daemon_starts_is_ready_drains_and_is_stuck_while_a_turn_does_not_end() {
        let house = House::new(Limits::default(), BTreeMap::new(), None, 1).unwrap();
        assert_eq!(house.health(), Health::Starting);
        house.note_ready();
        assert_eq!(house.health(), Health::Ready);
        let (begun, has_begun) = channel();
        let (release, released) = channel();
        house.lobby.pool.enter(|_| Slow(begun, released));
        has_begun.recv().unwrap();
        advance(STUCK_AFTER / 2).await;
        assert_eq!(house.health(), Health::Ready);
        advance(STUCK_AFTER).await;
        assert_eq!(house.health(), Health::Stuck);
        release.send(()).unwrap();
        assert!(has_begun.recv().is_err(), "it is over");
        assert_eq!(house.health(), Health::Ready);
        house.lobby.drain();
        assert_eq!(house.health(), Health::Draining);
    }
}
