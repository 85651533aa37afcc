//! The state machine of a match.

mod replay;
mod resume;
mod watch;

use std::sync::Arc;
use std::time::Duration;

use maniple_game::{Loaded, Stall, World, WorldError};
use maniple_geometry::Cycle;
use maniple_view::{
    COMMANDS_A_CYCLE_MAX, ClockMode, Command, CommandResult, Delta, Digest, MatchResult, Observation,
    Outcome, Refusal, Rules, Score, Seat, Sequenced, Terrain, Tracker, View,
};

use crate::bank::Banks;
use crate::part::Part;
use crate::pause::{Agreement, Paused};
use crate::record::RecordedEvent;
use crate::seat::{Batch, FloodError, JoinError, SeatState, check_name};
use crate::stand::Stands;

/// One match.
///
/// A seat's delta is there after [`Referee::new`], after a join and after each step, and has to be taken with
/// [`Referee::take_delta`] before the next step; so have the records.
#[doc(alias = "engine")]
pub struct Referee {
    loaded: Arc<Loaded>,
    mode: ClockMode,
    world: World,
    seats: Vec<SeatState>,
    banks: Banks,
    agreement: Agreement,
    records: Vec<RecordedEvent>,
    result: Option<MatchResult>,
    stands: Stands,
    /// Who sees everything; `None` where that is not watched.
    overseer: Option<Tracker>,
}

impl Referee {
    /// Returns the match at the start of cycle 0; nobody has joined yet.
    ///
    /// # Errors
    /// A map or scenario beyond what kinematics can work with.
    pub fn new(loaded: impl Into<Arc<Loaded>>, mode: ClockMode) -> Result<Self, WorldError> {
        let loaded = loaded.into();
        let world = World::new(&loaded)?;
        let mut referee = Self::around(world, loaded, mode);
        referee.tell(vec![Vec::new(); referee.seats.len()]);
        referee.record_hash();
        Ok(referee)
    }

    /// Returns the match of a world of which nobody has been told yet.
    fn around(world: World, loaded: Arc<Loaded>, mode: ClockMode) -> Self {
        let scenario = &loaded.scenario;
        let cycle_length = Duration::from_secs_f64(1.0 / scenario.rate);
        let banks = Banks::new(scenario.seats.len(), scenario.clock.time_bank, cycle_length);
        let rules = world.rules(Vec::new());
        let view = View::new(&rules, Arc::clone(&loaded.terrain));
        let tracker = |seat| {
            let tracker = Tracker::new(seat, world.skin_of_limits(), rules.positions, view.clone());
            tracker.with_identity(rules.identity)
        };
        let seats =
            (0..).map(Seat).map(|seat| SeatState::new(tracker(seat))).take(scenario.seats.len()).collect();
        let agreement = Agreement::new(scenario.seats.len());
        let (records, result) = (Vec::new(), None);
        let stands = Stands::default();
        Self { loaded, mode, world, seats, banks, agreement, records, result, stands, overseer: None }
    }

    /// Takes that a player has come, or come back. The next delta of the seat is a keyframe; the name stays that of
    /// the first time.
    ///
    /// # Errors
    /// A name that cannot be one.
    ///
    /// # Panics
    /// If the match has no such seat; so do all functions that take a seat.
    pub fn handle_join(&mut self, seat: Seat, name: &str) -> Result<(), JoinError> {
        check_name(name)?;
        let state = &mut self.seats[seat.index()];
        state.is_connected = true;
        state.delta = Some(state.tracker.keyframe());
        if !state.has_joined() {
            name.clone_into(&mut state.name);
            self.records.push(RecordedEvent::Joined {
                cycle: self.world.cycle(),
                seat,
                name: name.to_owned(),
            });
            self.banks.restart();
        }
        Ok(())
    }

    /// Takes that a player has gone; in lock-step the seat's time bank runs on. A pause goes on as long as a player is
    /// left who could end it.
    pub fn handle_leave(&mut self, seat: Seat) {
        let state = &mut self.seats[seat.index()];
        state.is_connected = false;
        state.delta = None;
        self.review_pause();
    }

    /// Takes that a seat wants a pause: once all seats that are in and have a player want it, no cycle is ready and no
    /// time bank runs until one of them wants to go on. Neither the state nor the record knows of it.
    ///
    /// Has no effect before all players have come, from a seat that is out, and beyond [`crate::PAUSES_MAX`] times.
    pub fn handle_pause(&mut self, seat: Seat) {
        if self.result.is_none() && self.have_all_joined() && self.counts(seat) {
            self.agreement.handle_wish(seat);
            self.review_pause();
        }
    }

    /// Takes that a seat wants no pause: a pause ends, a wish for one is withdrawn. Has no effect from a seat that is
    /// out.
    pub fn handle_go_on(&mut self, seat: Seat) {
        if self.counts(seat) {
            self.agreement.handle_no_wish(seat);
        }
    }

    /// Lets the clock stand still because whoever runs the match wants it: no cycle is ready and no time bank runs until
    /// [`Referee::release`]. Players are told as of a pause, and cannot end it. Neither the state nor the record knows of it.
    pub fn halt(&mut self) {
        self.agreement.handle_halt(true);
    }

    /// Lets the clock go on after [`Referee::halt`], unless the seats want a pause.
    pub fn release(&mut self) {
        self.agreement.handle_halt(false);
    }

    /// Takes commands for the next cycle to be simulated; `seen_cycle` is that of the last delta that the client had
    /// applied when it gave them. After the end of the match they are dropped.
    ///
    /// # Errors
    /// More commands than may wait for a cycle; the whole batch is dropped then.
    pub fn handle_commands(
        &mut self,
        seat: Seat,
        seen_cycle: Cycle,
        commands: Vec<Sequenced>,
    ) -> Result<(), FloodError> {
        let state = &mut self.seats[seat.index()];
        if self.result.is_some() {
            return Ok(());
        }
        state.queue(self.world.cycle(), Batch { seen_cycle, commands })
    }

    /// Takes that a seat has given all its commands for `cycle`; any but the present one is ignored.
    pub fn handle_done(&mut self, seat: Seat, cycle: Cycle) {
        if cycle == self.world.cycle() {
            self.banks.handle_done(seat);
        }
    }

    /// Takes the time that has passed since any fixed moment; only lock-step needs it. Seats whose time bank is empty
    /// are forfeited, if the scenario says so.
    pub fn handle_time(&mut self, now: Duration) {
        if self.agreement.is_on() {
            self.banks.handle_time_off(now);
            return;
        }
        self.banks.handle_time(now);
        if !self.have_all_joined() {
            self.banks.restart();
        }
        if !self.is_waiting() || self.loaded.scenario.clock.stall == Stall::Skip {
            return;
        }
        let stalled: Vec<Seat> = self.seats_in().filter(|&seat| self.banks.is_empty(seat)).collect();
        for seat in stalled {
            self.forfeit(seat);
        }
    }

    /// Lets a seat lose: its objects die at the end of the cycle. Does nothing if it is out already, or the match has
    /// ended.
    pub fn forfeit(&mut self, seat: Seat) {
        if self.result.is_some() || self.world.is_out(seat) {
            return;
        }
        self.world.resign(seat);
        self.records.push(RecordedEvent::Forfeited { cycle: self.world.cycle(), seat });
        self.review_pause();
    }

    /// Plays exactly one cycle: applies the commands that wait, seat by seat in the order in which they came,
    /// simulates, and makes the delta of each seat.
    ///
    /// # Panics
    /// After the match has ended, and if a delta or a record of the cycle before was not taken.
    pub fn step(&mut self) {
        self.step_by_parts(|_| {});
    }

    /// As [`Referee::step`], and says after each part of the work that it is done, so that a caller who has a clock can
    /// see what a cycle spends its time on.
    ///
    /// # Panics
    /// As [`Referee::step`].
    pub fn step_by_parts(&mut self, mut done: impl FnMut(Part)) {
        assert!(self.result.is_none(), "a match that has ended goes on no more");
        for state in &self.seats {
            assert!(state.delta.is_none() || !state.is_connected, "each delta is taken before the next step");
        }
        let is_hash = |record: &RecordedEvent| matches!(record, RecordedEvent::Hash { .. });
        assert!(!self.records.iter().any(is_hash), "the records are taken before the next step");
        let results = self.seats_all().map(|seat| self.apply(seat)).collect();
        done(Part::Commands);
        self.world.step_by_parts(|part| done(Part::World(part)));
        self.banks.next_cycle();
        self.tell(results);
        done(Part::Views);
        self.record_hash();
        self.conclude();
        self.review_pause();
        done(Part::Result);
    }

    /// Returns the delta of a seat since the last that was taken; the first, and the first after a join, is a
    /// keyframe. `None` if it was taken already, or nobody is there.
    pub fn take_delta(&mut self, seat: Seat) -> Option<Delta> {
        self.seats[seat.index()].delta.take()
    }

    /// Returns who wants a pause and whether there is one, if that has changed since the last call; everybody is to be
    /// told.
    pub fn take_pause_change(&mut self) -> Option<Paused> {
        self.agreement.take_change()
    }

    /// Returns what has happened since the last call, for the replay.
    pub fn take_records(&mut self) -> Vec<RecordedEvent> {
        std::mem::take(&mut self.records)
    }

    /// Returns whether the next cycle may be played: all seats have been joined once, the match goes on and is not
    /// paused, and in lock-step every seat that is still in is done or has an empty time bank. In real time the rate is
    /// up to the caller.
    #[must_use]
    pub fn is_ready(&self) -> bool {
        if self.result.is_some() || self.agreement.is_on() || !self.have_all_joined() {
            return false;
        }
        match self.mode {
            ClockMode::Realtime => true,
            ClockMode::Lockstep => self.seats_in().all(|seat| self.banks.is_free(seat)),
        }
    }

    /// Returns the time, in that of [`Referee::handle_time`], at which the next time bank will be empty. `None` if
    /// nobody is waited for.
    #[must_use]
    pub fn poll_timeout(&self) -> Option<Duration> {
        if !self.is_waiting() {
            return None;
        }
        self.seats_in()
            .filter(|&seat| !self.banks.is_free(seat))
            .filter_map(|seat| self.banks.empty_at(seat))
            .min()
    }

    /// Returns the delta that turns an empty view into the present one of a seat.
    #[must_use]
    pub fn keyframe(&self, seat: Seat) -> Delta {
        self.seats[seat.index()].tracker.keyframe()
    }

    /// Returns the server's copy of a seat's view.
    #[must_use]
    pub fn view(&self, seat: Seat) -> &View {
        self.seats[seat.index()].tracker.view()
    }

    /// Returns the world: for judges and for those who may know everything, never for a seat.
    #[must_use]
    pub fn world(&self) -> &World {
        &self.world
    }

    /// Returns the rules, with the names of the players that have come.
    #[must_use]
    pub fn rules(&self) -> Rules {
        self.world.rules(self.seats.iter().map(|state| state.name.clone()).collect())
    }

    /// Returns the terrain that every seat knows from the start.
    #[must_use]
    pub fn terrain(&self) -> &Arc<Terrain> {
        &self.loaded.terrain
    }

    /// Returns what the match was made of.
    #[must_use]
    pub fn loaded(&self) -> &Loaded {
        &self.loaded
    }

    /// Returns how time passes.
    #[must_use]
    pub fn mode(&self) -> ClockMode {
        self.mode
    }

    /// Returns the last time that was taken by [`Referee::handle_time`].
    #[must_use]
    pub fn time(&self) -> Duration {
        self.banks.now()
    }

    /// Returns the cycles a second.
    #[must_use]
    pub fn rate(&self) -> f64 {
        self.loaded.scenario.rate
    }

    /// Returns the number of seats.
    #[must_use]
    pub fn seats(&self) -> usize {
        self.seats.len()
    }

    /// Returns whether a seat has resigned or was forfeited.
    #[must_use]
    pub fn is_out(&self, seat: Seat) -> bool {
        self.world.is_out(seat)
    }

    /// Returns who wants a pause, and whether there is one.
    #[must_use]
    pub fn pause(&self) -> Paused {
        self.agreement.state()
    }

    /// Returns whether a player is at a seat.
    #[must_use]
    pub fn is_connected(&self, seat: Seat) -> bool {
        self.seats[seat.index()].is_connected
    }

    /// Returns the cycle at whose start the match is.
    #[must_use]
    pub fn cycle(&self) -> Cycle {
        self.world.cycle()
    }

    /// Returns the state hash at the start of the present cycle.
    #[must_use]
    pub fn hash(&self) -> Digest {
        self.world.hash()
    }

    /// Returns how the match has ended; `None` while it goes on.
    #[must_use]
    pub fn result(&self) -> Option<&MatchResult> {
        self.result.as_ref()
    }

    fn seats_all(&self) -> impl Iterator<Item = Seat> + use<> {
        (0..).map(Seat).take(self.seats.len())
    }

    fn seats_in(&self) -> impl Iterator<Item = Seat> {
        self.seats_all().filter(|&seat| !self.world.is_out(seat))
    }

    /// Returns whether every seat has been joined at least once.
    #[must_use]
    pub fn have_all_joined(&self) -> bool {
        self.seats.iter().all(SeatState::has_joined)
    }

    /// Returns whether time banks run.
    fn is_waiting(&self) -> bool {
        let goes_on = self.result.is_none() && !self.agreement.is_on();
        self.mode == ClockMode::Lockstep && goes_on && self.have_all_joined()
    }

    /// Returns whether a seat has a say in a pause: it is in, and a player is there.
    fn counts(&self, seat: Seat) -> bool {
        self.is_connected(seat) && !self.world.is_out(seat)
    }

    fn review_pause(&mut self) {
        let (seats, world) = (&self.seats, &self.world);
        self.agreement.review(|seat| seats[seat.index()].is_connected && !world.is_out(seat));
    }

    /// Applies the commands of a seat and returns their results.
    fn apply(&mut self, seat: Seat) -> Vec<CommandResult> {
        let cycle = self.world.cycle();
        let mut results = Vec::new();
        for Batch { seen_cycle, commands } in self.seats[seat.index()].take_batches() {
            let late = cycle.0.saturating_sub(seen_cycle.0);
            for Sequenced { seq, command } in &commands {
                let applied = if results.len() < COMMANDS_A_CYCLE_MAX {
                    self.apply_one(seat, command)
                } else {
                    let max = u32::try_from(COMMANDS_A_CYCLE_MAX).unwrap_or(u32::MAX);
                    Err(Refusal::TooManyCommands { max })
                };
                let outcome = match applied {
                    Ok(()) => Outcome::Applied { cycle, late },
                    Err(reason) => Outcome::Refused { reason },
                };
                results.push(CommandResult { seq: *seq, outcome });
            }
            self.records.push(RecordedEvent::Commands { cycle, seat, seen_cycle, commands });
        }
        results
    }

    fn apply_one(&mut self, seat: Seat, command: &Command) -> Result<(), Refusal> {
        if self.world.is_out(seat) {
            return Err(Refusal::Out);
        }
        let Some(handle) = command.object() else {
            self.world.resign(seat);
            return Ok(());
        };
        let tracker = &self.seats[seat.index()].tracker;
        let object = tracker.own(handle).ok_or(Refusal::UnknownHandle)?;
        let target = command.target().and_then(|target| tracker.seen(target));
        self.world.command(seat, object, command, target)
    }

    /// Makes the delta of each seat; `results` are those of its commands.
    fn tell(&mut self, results: Vec<Vec<CommandResult>>) {
        let cycle = self.world.cycle();
        for (seat, results) in self.seats_all().zip(results) {
            let sightings = self.world.sightings(seat);
            let (revealed, walls) = self.world.explored(seat);
            let observation = Observation {
                sightings: &sightings,
                visible: self.world.visible(seat),
                revealed,
                walls,
                died: &self.world.died(seat),
                shots: &self.world.shots(seat),
                ended: self.world.ended(),
                stock: self.world.stock(seat),
            };
            let state = &mut self.seats[seat.index()];
            let delta = state.tracker.update(cycle, observation, results);
            let is_wanted = state.is_connected || cycle == Cycle(0);
            self.tell_spectators(seat, &delta);
            self.seats[seat.index()].delta = is_wanted.then_some(delta);
        }
        self.tell_spectators_of_everything();
    }

    fn record_hash(&mut self) {
        self.records.push(RecordedEvent::Hash { cycle: self.world.cycle(), hash: self.world.hash() });
    }

    /// Says how the match has ended, if it has.
    fn conclude(&mut self) {
        let Some(result) = self.outcome() else { return };
        self.records.push(RecordedEvent::Ended { result: result.clone() });
        self.result = Some(result);
        // Nobody can be helped any more by what is held back.
        self.stands.release();
    }

    /// Returns how the match has ended; `None` while it goes on.
    fn outcome(&self) -> Option<MatchResult> {
        let ending = self.world.ending()?;
        let score = |((seat, state), points): ((Seat, &SeatState), u64)| Score {
            seat,
            name: state.name.clone(),
            team: self.world.team(seat),
            points,
            tally: self.world.tally(seat),
            resigned: self.world.is_out(seat),
        };
        let scores = (0..).map(Seat).zip(&self.seats).zip(self.world.points()).map(score).collect();
        Some(MatchResult {
            winners: ending.winners.clone(),
            reason: ending.reason,
            cycles: ending.cycles,
            scores,
            hash: self.world.hash(),
        })
    }
}

#[cfg(test)]
mod tests;
