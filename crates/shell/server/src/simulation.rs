//! The thread that owns the referee.

mod watching;

use std::sync::mpsc::{Receiver, RecvTimeoutError};
use std::time::{Duration, Instant};

use maniple_protocol::{Hello, Input, Refused, ServerMessage, Watch, Welcome};
use maniple_referee::{Paused, QUEUED_MAX, Referee, Stand};
use maniple_view::{ClockMode, Digest, MatchResult, Seat, Vantage};
use tokio::sync::OwnedSemaphorePermit;

use crate::audience::{Audience, SPECTATORS_MAX};
use crate::connection::{ConnectionId, IN_FLIGHT_MAX, SPECTATOR_IN_FLIGHT_MAX};
use crate::link::Link;
use crate::pace::Pace;
use crate::recording::{Recording, RecordingError};
use crate::server::Sink;
use crate::table::Table;

/// Events that are taken in before a cycle that is due: all that 64 players and all spectators may have in flight. Without
/// a limit clients could hold up the cycle by talking on.
pub const EVENTS_BEFORE_STEP_MAX: usize = 64 * IN_FLIGHT_MAX + SPECTATORS_MAX * SPECTATOR_IN_FLIGHT_MAX;

/// What happens outside of the simulation.
#[derive(Debug)]
pub(crate) enum Event {
    /// A connection has said who it is.
    Hello {
        /// The connection.
        connection: ConnectionId,
        /// Its hello.
        hello: Hello,
        /// The way back.
        link: Link,
    },
    /// A connection has said that it wants to watch.
    Watch {
        /// The connection.
        connection: ConnectionId,
        /// What it wants to watch.
        watch: Watch,
        /// The way back.
        link: Link,
    },
    /// A connection said something after its first message.
    Input {
        /// The connection.
        connection: ConnectionId,
        /// What it said.
        input: Input,
        /// Held until it has been dealt with.
        permit: OwnedSemaphorePermit,
    },
    /// A connection is closed.
    Gone {
        /// The connection.
        connection: ConnectionId,
    },
    /// The match is to be broken off.
    Shutdown,
}

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
}

impl Simulation {
    /// Returns the simulation of a match that nobody has joined.
    pub(crate) fn new(
        referee: Referee,
        match_id: Digest,
        table: Table,
        recording: Option<Recording<Sink>>,
        events: Receiver<Event>,
    ) -> Self {
        let start = Instant::now();
        Self {
            referee,
            match_id,
            table,
            audience: Audience::new(SPECTATORS_MAX),
            recording,
            events,
            start,
            pace: None,
            is_shutting_down: false,
        }
    }

    /// Plays the match to its end, and closes all connections. Returns its result; `None` if it was broken off.
    ///
    /// # Errors
    /// What happened cannot be recorded: a match that nobody can verify does not go on.
    pub(crate) fn run(mut self) -> Result<Option<MatchResult>, RecordingError> {
        let played = self.play();
        self.close();
        played?;
        if let Some(recording) = self.recording {
            recording.finish()?;
        }
        Ok(self.referee.result().cloned())
    }

    fn play(&mut self) -> Result<(), RecordingError> {
        while self.referee.result().is_none() && !self.is_shutting_down {
            self.referee.handle_time(self.start.elapsed());
            self.record()?;
            // Who has gone, resigned or been forfeited has no say any more.
            self.tell_pause();
            let now = self.start.elapsed();
            match self.next_step(now) {
                Some(due) if due <= now => {
                    self.take_in();
                    self.step(now)?;
                }
                Some(due) => self.wait(Some(due - now)),
                None => self.wait(None),
            }
        }
        Ok(())
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
                Some(self.pace.get_or_insert_with(|| Pace::new(period, now)).due())
            }
            ClockMode::Realtime => {
                // Once it goes on, the next cycle is due a whole period later, and nothing is to be made good.
                self.pace = None;
                None
            }
        }
    }

    /// Waits for an event and handles it.
    fn wait(&mut self, limit: Option<Duration>) {
        let received = match limit {
            Some(limit) => self.events.recv_timeout(limit),
            None => self.events.recv().map_err(|_| RecvTimeoutError::Disconnected),
        };
        match received {
            Ok(event) => self.handle_event(event),
            Err(RecvTimeoutError::Timeout) => {}
            Err(RecvTimeoutError::Disconnected) => self.is_shutting_down = true,
        }
    }

    /// Handles what has come in before the cycle.
    fn take_in(&mut self) {
        for _ in 0..EVENTS_BEFORE_STEP_MAX {
            let Ok(event) = self.events.try_recv() else { return };
            self.handle_event(event);
        }
    }

    fn step(&mut self, now: Duration) -> Result<(), RecordingError> {
        if !self.referee.is_ready() {
            return Ok(());
        }
        if let Some(periods) = self.pace.as_mut().and_then(|pace| pace.handle_step(now)) {
            tracing::warn!(
                cycle = self.referee.cycle().0,
                periods,
                "too slow for the rate; cycles were put off"
            );
        }
        self.record()?;
        self.referee.step();
        self.record()?;
        for seat in self.table.seats() {
            self.send_delta(seat);
        }
        self.send_to_spectators();
        Ok(())
    }

    fn handle_event(&mut self, event: Event) {
        self.referee.handle_time(self.start.elapsed());
        match event {
            Event::Hello { connection, hello, link } => self.handle_hello(connection, &hello, link),
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
                    self.referee.handle_leave(seat);
                    tracing::info!(seat = seat.0, cycle = self.referee.cycle().0, "left");
                } else if self.audience.leave(connection).is_some() {
                    tracing::info!(connection = connection.0, "watches no more");
                }
            }
            Event::Shutdown => self.is_shutting_down = true,
        }
    }

    fn handle_hello(&mut self, connection: ConnectionId, hello: &Hello, link: Link) {
        let admitted = self.table.seat_for(&hello.token).and_then(|seat| {
            let joined = self.referee.handle_join(seat, &hello.player);
            let malformed = |problem: String| Refused::Malformed { place: "message 1".to_owned(), problem };
            joined.map(|()| seat).map_err(|error| malformed(error.to_string()))
        });
        let seat = match admitted {
            Ok(seat) => seat,
            Err(reason) => {
                tracing::info!(connection = connection.0, client = hello.client, %reason, "refused");
                return link.refuse(reason);
            }
        };
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
            Input::Hello(_) | Input::Watch(_) => self.remove(seat, Refused::Handshake),
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
            let sent = self.table.push_delta(seat, delta, || self.referee.keyframe(seat));
            self.check_sent(seat, sent);
        }
    }

    /// Tells a seat what it has missed, if it has caught up: in lock-step the next cycle may wait for it.
    fn catch_up(&mut self, seat: Seat) {
        let sent = self.table.catch_up(seat, || self.referee.keyframe(seat));
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
            link.refuse(reason);
            self.referee.handle_leave(seat);
        }
    }

    /// Tells every connection that it is over, and why.
    fn close(&mut self) {
        let last = match self.referee.result() {
            Some(result) => ServerMessage::Ended { result: result.clone() },
            None => ServerMessage::Refused { reason: Refused::Shutdown },
        };
        for seat in self.table.seats() {
            self.table.close(seat, &last, || self.referee.keyframe(seat));
        }
        self.audience.close(&last, &|vantage| self.referee.stand(vantage).ok()?.keyframe());
        while let Ok(event) = self.events.try_recv() {
            if let Event::Hello { link, .. } | Event::Watch { link, .. } = event {
                link.refuse(Refused::Shutdown);
            }
        }
    }
}
