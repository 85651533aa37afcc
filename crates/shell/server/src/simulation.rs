//! One match: its referee, its connections and its clock.

mod event;
#[cfg(test)]
mod tests;
mod watching;

use std::any::Any;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;
use std::sync::mpsc::{Receiver, TryRecvError};
use std::time::Duration;

use maniple_protocol::{Hello, Input, Refused, ServerMessage, Welcome};
use maniple_referee::{Paused, QUEUED_MAX, Referee, Stand};
use maniple_view::{ClockMode, Digest, MatchResult, Seat, Vantage};
use tokio::sync::oneshot;
use tokio::time::Instant;

use crate::audience::{Audience, SPECTATORS_MAX};
use crate::connection::{ConnectionId, IN_FLIGHT_MAX, SPECTATOR_IN_FLIGHT_MAX};
use crate::link::Link;
use crate::matches::{RunError, Sink};
use crate::metrics::{End, Metrics};
use crate::occupancy::Occupancy;
use crate::operation::Clock;
use crate::pace::Pace;
use crate::pool::{Player, Turn};
use crate::recording::{Recording, RecordingError};
use crate::table::Table;
pub(crate) use event::{Event, Mailbox};

/// Events that are taken in before a cycle that is due: all that 64 players and all spectators may have in flight. Without
/// a limit clients could hold up the cycle by talking on.
pub const EVENTS_BEFORE_STEP_MAX: usize = 64 * IN_FLIGHT_MAX + SPECTATORS_MAX * SPECTATOR_IN_FLIGHT_MAX;

/// Time for the players of a match that goes on after the daemon was killed to come back; then it goes on without them.
pub const RETURN_TIMEOUT: Duration = Duration::from_secs(10);

/// Cycles from one snapshot of a match that is kept to the next; a match that is taken up is played again from the last.
pub const SNAPSHOT_CYCLES: u32 = 4096;

/// How a match came out; `None`: it was broken off.
pub(crate) type Outcome = Result<Option<MatchResult>, RunError>;

/// A match, its connections and its clock.
pub(crate) struct Simulation {
    referee: Referee,
    match_id: Digest,
    table: Table,
    audience: Audience,
    /// `None` where nobody wants a replay: then nothing of what has happened is kept.
    recording: Option<Recording<Sink>>,
    events: Receiver<Event>,
    start: Instant,
    /// `None` in lock-step, in a pause, and before all seats have been joined.
    pace: Option<Pace>,
    is_shutting_down: bool,
    /// Whether whoever runs the server has ended it.
    is_called_off: bool,
    /// Where the outcome goes; `None` once it is told.
    finished: Option<oneshot::Sender<Outcome>>,
    occupancy: Arc<Occupancy>,
    metrics: Arc<Metrics>,
    /// Time for the players to come; `None`: for ever, or they have.
    begin_within: Option<Duration>,
    /// Time for the players of a match that was taken up to come back; `None`: they have, or need not.
    return_within: Option<Duration>,
}

/// The match that a simulation plays, who keeps it, and the ways in and out.
pub(crate) struct Played {
    pub(crate) referee: Referee,
    pub(crate) id: Digest,
    pub(crate) table: Table,
    pub(crate) recording: Option<Recording<Sink>>,
    pub(crate) events: Receiver<Event>,
    pub(crate) finished: oneshot::Sender<Outcome>,
    pub(crate) occupancy: Arc<Occupancy>,
    /// Time for the players to come; `None`: for ever.
    pub(crate) begin_within: Option<Duration>,
    /// Whether its players have been here before and have to come back.
    pub(crate) is_resumed: bool,
}

impl Player for Simulation {
    /// A mistake of ours that panics ends this match and no other.
    fn turn(&mut self) -> Turn {
        let turn = catch_unwind(AssertUnwindSafe(|| self.play()));
        let outcome = match turn {
            Ok(Ok(Turn::Over)) => self.finish(),
            Ok(Ok(turn)) => return turn,
            Ok(Err(error)) => Err(error.into()),
            Err(panic) => Err(RunError::Panicked { message: message_of(panic.as_ref()) }),
        };
        if let Err(error) = &outcome {
            self.break_off(error);
        }
        self.metrics.matches_ended.count(&match &outcome {
            Ok(Some(result)) if result.winners.is_empty() => End::Drawn,
            Ok(Some(_)) => End::Won,
            Ok(None) => End::BrokenOff,
            Err(_) => End::Failed,
        });
        if let Some(finished) = self.finished.take() {
            // Nobody listens any more if the server itself was dropped.
            let _ = finished.send(outcome);
        }
        Turn::Over
    }
}

/// Returns by which share of a period, `0.0..1.0`, the clock of a match starts later than it could: many matches begin at the same time, at
/// the start of a round or of the daemon, and their cycles would then all be due at once. Numbers of matches are random.
fn phase(id: Digest) -> f64 {
    (id.0 >> 11) as f64 / (1u64 << 53) as f64
}

/// Returns the text that somebody panicked with.
fn message_of(panic: &(dyn Any + Send)) -> String {
    let literal = panic.downcast_ref::<&str>().map(|text| (*text).to_owned());
    literal.or_else(|| panic.downcast_ref::<String>().cloned()).unwrap_or_default()
}

impl Simulation {
    /// Returns the simulation of a match that nobody has joined.
    pub(crate) fn new(played: Played) -> Self {
        let Played { referee, id, table, recording, events, finished, occupancy, begin_within, is_resumed } =
            played;
        let metrics = Arc::clone(occupancy.metrics());
        // A match that goes on from a snapshot has had its time before.
        let passed = referee.time();
        let start = Instant::now().checked_sub(passed).expect("times of matches are far below 2^63 s");
        let return_within = is_resumed.then_some(passed + RETURN_TIMEOUT);
        let audience = Audience::new(table.spectators_max());
        Self {
            referee,
            match_id: id,
            table,
            audience,
            recording,
            events,
            start,
            pace: None,
            is_shutting_down: false,
            is_called_off: false,
            finished: Some(finished),
            occupancy,
            metrics,
            begin_within,
            return_within,
        }
    }

    /// Takes in what has come, and plays the cycle that is due. Returns when the next is.
    ///
    /// # Errors
    /// What happened cannot be recorded: a match that nobody can verify does not go on.
    fn play(&mut self) -> Result<Turn, RecordingError> {
        let is_all = self.take_in();
        self.occupancy.note_spectators(self.audience.count());
        self.tell_time();
        self.record()?;
        // Who has gone, resigned or been forfeited has no say any more.
        self.tell_pause();
        if self.referee.have_all_joined() {
            self.occupancy.note_begin();
        }
        self.occupancy.note_clock(self.referee.cycle(), self.referee.pause().on);
        let now = self.start.elapsed();
        self.review_begin(now);
        self.review_return(now);
        if let Some(limit) = self.return_within
            && !self.is_over()
        {
            return Ok(if is_all { Turn::At(self.start + limit) } else { Turn::At(Instant::now()) });
        }
        if !self.is_over() && self.next_step(now).is_some_and(|due| due <= now) {
            self.step(now)?;
        }
        if self.is_over() {
            return Ok(Turn::Over);
        }
        if !is_all {
            return Ok(Turn::At(Instant::now()));
        }
        let due = self.next_step(self.start.elapsed());
        let due = due.into_iter().chain(self.begin_within).min();
        Ok(due.map_or(Turn::Woken, |due| Turn::At(self.start + due)))
    }

    /// Tells the referee the time; none passes before the players of a match that was taken up are back.
    fn tell_time(&mut self) {
        if self.return_within.is_none() {
            self.referee.handle_time(self.start.elapsed());
        }
    }

    /// Lets a match go on that was taken up, when all who are in it are back, or it is time to.
    fn review_return(&mut self, now: Duration) {
        let Some(limit) = self.return_within else { return };
        let is_back = |seat: Seat| self.referee.is_connected(seat) || self.referee.is_out(seat);
        if now >= limit || self.table.seats().all(is_back) {
            self.return_within = None;
            self.tell_time();
        }
    }

    /// Gives a match up whose players have not come in time.
    fn review_begin(&mut self, now: Duration) {
        let Some(limit) = self.begin_within else { return };
        if self.referee.have_all_joined() {
            self.begin_within = None;
        } else if now >= limit {
            self.is_shutting_down = true;
        }
    }

    fn is_over(&self) -> bool {
        self.referee.result().is_some() || self.is_shutting_down || self.is_called_off
    }

    /// Tells everybody how it ended, and ends the recording.
    fn finish(&mut self) -> Outcome {
        let last = match self.referee.result() {
            Some(result) => ServerMessage::Ended { result: result.clone() },
            None => ServerMessage::Refused { reason: self.reason_to_break_off() },
        };
        self.close(&last);
        if let Some(recording) = self.recording.take() {
            recording.end(self.referee.result().is_some() || self.is_called_off)?;
        }
        Ok(self.referee.result().cloned())
    }

    /// Tells everybody that the match cannot go on, and notes why. It may have panicked: whatever can still be done is.
    fn break_off(&mut self, error: &RunError) {
        tracing::error!(id = %self.match_id, %error, "ALARM: a match has failed; no other is concerned");
        if let Some(recording) = self.recording.take() {
            recording.give_up(&error.to_string());
        }
        let close = AssertUnwindSafe(|| self.close(&ServerMessage::Refused { reason: Refused::Broken }));
        if catch_unwind(close).is_err() {
            tracing::error!(id = %self.match_id, "connections of a broken match were not told");
        }
    }

    fn reason_to_break_off(&self) -> Refused {
        if self.is_called_off {
            return Refused::Operator;
        }
        match self.begin_within {
            Some(limit) if self.start.elapsed() >= limit => {
                Refused::NotBegun { seconds: u32::try_from(limit.as_secs()).unwrap_or(u32::MAX) }
            }
            Some(_) | None => Refused::Shutdown,
        }
    }

    fn record(&mut self) -> Result<(), RecordingError> {
        let records = self.referee.take_records();
        match &mut self.recording {
            Some(recording) => recording.extend(records),
            None => Ok(()),
        }
    }

    /// Returns when something has to be done even if nobody says anything; `None` if nothing has.
    fn next_step(&mut self, now: Duration) -> Option<Duration> {
        match self.referee.mode() {
            ClockMode::Lockstep if self.referee.is_ready() => Some(now),
            ClockMode::Lockstep => self.referee.poll_timeout(),
            ClockMode::Realtime if self.referee.is_ready() => {
                let period = Duration::from_secs_f64(1.0 / self.referee.rate());
                let begin = now.saturating_add(period.mul_f64(phase(self.match_id)));
                Some(self.pace.get_or_insert_with(|| Pace::new(period, begin)).due())
            }
            ClockMode::Realtime => {
                // Once it goes on, the next cycle is due a period later or two, and nothing is to be made good.
                self.pace = None;
                None
            }
        }
    }

    /// Handles what has come in; returns whether that is all.
    fn take_in(&mut self) -> bool {
        for _ in 0..EVENTS_BEFORE_STEP_MAX {
            match self.events.try_recv() {
                Ok(event) => self.handle_event(event),
                Err(TryRecvError::Empty) => return true,
                Err(TryRecvError::Disconnected) => {
                    self.is_shutting_down = true;
                    return true;
                }
            }
        }
        false
    }

    fn step(&mut self, now: Duration) -> Result<(), RecordingError> {
        if !self.referee.is_ready() {
            return Ok(());
        }
        if let Some(pace) = &self.pace {
            self.occupancy.note_lateness(now.saturating_sub(pace.due()), pace.jitter(now));
        }
        if let Some(periods) = self.pace.as_mut().and_then(|pace| pace.handle_step(now)) {
            self.metrics.cycles_put_off.add(periods);
            tracing::warn!(
                cycle = self.referee.cycle().0,
                periods,
                "too slow for the rate; cycles were put off"
            );
        }
        self.record()?;
        self.referee.step();
        self.record()?;
        if let Some(recording) = &mut self.recording {
            recording.commit()?;
            if self.referee.cycle().0.is_multiple_of(SNAPSHOT_CYCLES) {
                recording.keep_snapshot(&self.referee);
            }
        }
        for seat in self.table.seats() {
            self.send_delta(seat);
        }
        self.send_to_spectators();
        self.occupancy.note_waiting(self.table.waiting() + self.audience.waiting());
        self.occupancy.note_duration(self.start.elapsed().saturating_sub(now));
        Ok(())
    }

    fn handle_event(&mut self, event: Event) {
        self.tell_time();
        match event {
            Event::Hello { connection, hello, wanted, link } => {
                self.handle_hello(connection, &hello, wanted, link);
            }
            Event::Watch { connection, watch, link } => self.handle_watch(connection, &watch, link),
            Event::Input { connection, input, permit } => {
                if let Some(seat) = self.table.seat_of(connection) {
                    self.handle_input(seat, input);
                } else if let Some(vantage) = self.audience.vantage_of(connection) {
                    self.handle_spectator(connection, vantage, input);
                }
                drop(permit);
            }
            Event::Gone { connection } => {
                if let Some(seat) = self.table.seat_of(connection) {
                    self.table.leave(seat);
                    self.note_leave(seat);
                    tracing::info!(seat = seat.0, cycle = self.referee.cycle().0, "left");
                } else if self.audience.leave(connection).is_some() {
                    tracing::info!(connection = connection.0, "watches no more");
                }
            }
            Event::Shutdown => self.is_shutting_down = true,
            Event::CallOff => self.is_called_off = true,
            Event::PutOut(seat) => self.remove(seat, Refused::Operator),
            Event::Clock(Clock::Halt) => self.referee.halt(),
            Event::Clock(Clock::GoOn) => self.referee.release(),
        }
    }

    fn handle_hello(&mut self, connection: ConnectionId, hello: &Hello, wanted: Option<Seat>, link: Link) {
        let admitted = self.table.seat_for(&hello.token, wanted).and_then(|seat| {
            let joined = self.referee.handle_join(seat, &hello.player);
            let malformed =
                |problem: String| Refused::Malformed { place: "the handshake".to_owned(), problem };
            joined.map(|()| seat).map_err(|error| malformed(error.to_string()))
        });
        let seat = match admitted {
            Ok(seat) => seat,
            Err(reason) => {
                tracing::info!(connection = connection.0, client = hello.client, %reason, "refused");
                self.metrics.refused.count(&reason);
                return link.refuse(reason);
            }
        };
        self.occupancy.note_seat(seat, true);
        if let Some(before) = self.table.sit(seat, connection, link) {
            before.refuse(Refused::Replaced);
            tracing::info!(seat = seat.0, "taken over");
        }
        tracing::info!(
            seat = seat.0,
            connection = connection.0,
            player = hello.player,
            client = hello.client,
            "joined"
        );
        let welcome = self.welcome(Vantage::Seat(seat), None);
        let keyframe = self.referee.take_delta(seat).expect("who has just joined gets a keyframe");
        let welcomed = self.table.welcome(seat, welcome, keyframe);
        self.check_sent(seat, welcomed);
        let pause = self.referee.pause();
        if pause.on || !pause.seats.is_empty() {
            self.send_pause(seat, pause);
        }
    }

    fn handle_input(&mut self, seat: Seat, input: Input) {
        match input {
            Input::Commands { seen_cycle, list } => {
                self.table.handle_commands(seat, self.referee.cycle(), seen_cycle);
                if self.referee.handle_commands(seat, seen_cycle, list).is_err() {
                    let limit = u32::try_from(QUEUED_MAX).expect("the limit is below 2^32");
                    self.warn(seat, Refused::TooManyCommands { limit });
                }
                self.catch_up(seat);
            }
            Input::Done { cycle } => {
                self.referee.handle_done(seat, cycle);
                self.table.handle_done(seat, cycle);
                self.catch_up(seat);
            }
            Input::Dropped(reason) => self.warn(seat, reason),
            Input::Ping { id } => {
                let (cycle, fraction) = (self.referee.cycle(), self.fraction());
                self.send(seat, &ServerMessage::Pong { id, cycle, fraction });
            }
            Input::Pause { on } => self.handle_pause(seat, on),
            Input::Violation(reason) => self.remove(seat, reason),
            Input::Hello(_) | Input::Watch(_) | Input::List | Input::Create(_) | Input::Enter { .. } => {
                self.remove(seat, Refused::Handshake);
            }
        }
    }

    fn handle_pause(&mut self, seat: Seat, on: bool) {
        if on {
            self.referee.handle_pause(seat);
        } else {
            self.referee.handle_go_on(seat);
        }
        if !self.tell_pause() {
            self.send_pause(seat, self.referee.pause());
        }
    }

    /// Tells everybody who wants a pause, if that has changed; returns whether it has.
    fn tell_pause(&mut self) -> bool {
        let Some(pause) = self.referee.take_pause_change() else { return false };
        tracing::info!(cycle = self.referee.cycle().0, on = pause.on, seats = ?pause.seats, "pause");
        for seat in self.table.seats() {
            self.send_pause(seat, pause.clone());
        }
        true
    }

    fn send_pause(&mut self, seat: Seat, Paused { seats, on }: Paused) {
        self.send(seat, &ServerMessage::Paused { seats, on });
    }

    /// Returns the welcome to a view; `stand` is what a spectator is told of the cycle.
    fn welcome(&self, vantage: Vantage, stand: Option<&Stand>) -> Welcome {
        Welcome {
            match_id: self.match_id,
            seat: vantage.seat(),
            delay: stand.map(Stand::delay),
            seats: u16::try_from(self.referee.seats()).expect("seats are counted in 16 bits"),
            cycle: stand.map_or(self.referee.cycle(), Stand::cycle),
            rate: self.referee.rate(),
            clock: self.referee.mode(),
            rules: self.referee.rules_of(vantage),
            terrain: self.referee.terrain_of(vantage).as_ref().clone(),
        }
    }

    /// Returns how much of the present cycle's wall-clock time has passed; 0 where nothing is due.
    fn fraction(&self) -> f64 {
        let now = self.start.elapsed();
        self.pace.as_ref().map_or(0.0, |pace| pace.fraction(now))
    }

    fn send_delta(&mut self, seat: Seat) {
        if let Some(delta) = self.referee.take_delta(seat) {
            for result in &delta.results {
                self.metrics.results.count(&result.outcome);
            }
            let keyframe = || {
                self.metrics.resyncs.increment();
                self.referee.keyframe(seat)
            };
            let sent = self.table.push_delta(seat, delta, keyframe);
            self.check_sent(seat, sent);
        }
    }

    /// Tells a seat what it has missed, if it has caught up: in lock-step the next cycle may wait for it.
    fn catch_up(&mut self, seat: Seat) {
        let keyframe = || {
            self.metrics.resyncs.increment();
            self.referee.keyframe(seat)
        };
        let sent = self.table.catch_up(seat, keyframe);
        self.check_sent(seat, sent);
    }

    fn warn(&mut self, seat: Seat, reason: Refused) {
        let warned = self.table.handle_violation(seat, reason);
        self.check_sent(seat, warned);
    }

    fn send(&mut self, seat: Seat, message: &ServerMessage) {
        let sent = self.table.push(seat, message);
        self.check_sent(seat, sent);
    }

    fn check_sent(&mut self, seat: Seat, sent: Result<(), Refused>) {
        if let Err(reason) = sent {
            self.remove(seat, reason);
        }
    }

    /// Closes the connection at a seat; the player may come back.
    fn remove(&mut self, seat: Seat, reason: Refused) {
        if let Some(link) = self.table.leave(seat) {
            tracing::warn!(seat = seat.0, cycle = self.referee.cycle().0, %reason, "removed");
            self.metrics.refused.count(&reason);
            link.refuse(reason);
            self.note_leave(seat);
        }
    }

    fn note_leave(&mut self, seat: Seat) {
        self.referee.handle_leave(seat);
        self.occupancy.note_seat(seat, false);
    }

    /// Closes every connection behind a last message.
    fn close(&mut self, last: &ServerMessage) {
        for seat in self.table.seats() {
            self.table.close(seat, last, || self.referee.keyframe(seat));
        }
        self.audience.close(last, &|vantage| self.referee.stand(vantage).ok()?.keyframe());
        while let Ok(event) = self.events.try_recv() {
            if let Event::Hello { link, .. } | Event::Watch { link, .. } = event {
                link.refuse(Refused::Shutdown);
            }
        }
    }
}
