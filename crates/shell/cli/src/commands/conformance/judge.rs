//! The match of a test: what the client is told, and what is looked for in what it says.

use std::collections::BTreeMap;

use maniple_geometry::Cycle;
use maniple_protocol::{ServerMessage, Welcome};
use maniple_referee::Referee;
use maniple_view::{ClockMode, CommandResult, Delta, Digest, Outcome, Seat, Sequenced};

use super::mistake::Mistake;
use super::story;
use super::verdict::{Findings, Verdict};
use crate::failure::Failure;
use crate::start;

/// The number of the match; there is one.
const MATCH: Digest = Digest(0xc0ff_ee00_c0ff_ee00);

/// Whose seat it is.
const CLIENT: Seat = Seat(0);
const OTHER: Seat = Seat(1);

/// Plays the story against a client and takes down its mistakes.
pub(crate) struct Judge {
    referee: Referee,
    has_reconnect: bool,
    is_cut: bool,
    is_answered: bool,
    /// Commands of the client in this cycle that the referee got.
    given: usize,
    /// Answers to those that the story refuses.
    refused: Vec<CommandResult>,
    refusals: usize,
    commands: u32,
    has_pinged: bool,
    proved: u32,
    deltas: u32,
    told: BTreeMap<&'static str, u32>,
    findings: Findings,
}

impl Judge {
    /// Returns the match before its start; with `has_reconnect` the connection is cut once.
    pub(crate) fn new(has_reconnect: bool) -> Result<Self, Failure> {
        let mut referee = start::referee(story::loaded()?, ClockMode::Lockstep)?;
        referee.handle_join(OTHER, "story").map_err(Failure::failed)?;
        referee.take_delta(OTHER);
        referee.take_records();
        Ok(Self {
            referee,
            has_reconnect,
            is_cut: false,
            is_answered: false,
            given: 0,
            refused: Vec::new(),
            refusals: 0,
            commands: 0,
            has_pinged: false,
            proved: 0,
            deltas: 0,
            told: BTreeMap::new(),
            findings: Findings::default(),
        })
    }

    /// Lets the client in; returns what it is told, or what is wrong with its name.
    pub(crate) fn welcome(&mut self, player: &str) -> Result<Vec<ServerMessage>, String> {
        self.referee.handle_join(CLIENT, player).map_err(|error| error.to_string())?;
        self.referee.take_records();
        self.is_cut = false;
        let welcome = ServerMessage::Welcome(Welcome {
            match_id: MATCH,
            seat: Some(CLIENT),
            delay: None,
            seats: 2,
            cycle: self.referee.cycle(),
            rate: self.referee.rate(),
            clock: self.referee.mode(),
            rules: self.referee.rules(),
            terrain: self.referee.terrain().as_ref().clone(),
        });
        let keyframe = self.delta(Vec::new());
        Ok(vec![welcome, keyframe])
    }

    /// Takes down a mistake.
    pub(crate) fn note(&mut self, mistake: Mistake) {
        self.findings.note(self.referee.cycle().0, mistake);
    }

    /// Takes commands of the client.
    pub(crate) fn handle_commands(&mut self, seen_cycle: Cycle, list: Vec<Sequenced>) {
        if seen_cycle != self.referee.cycle() {
            self.note(Mistake::SeenCycle { found: seen_cycle.0 });
        }
        for sequenced in &list {
            self.look_at(sequenced);
        }
        let count = u32::try_from(list.len()).unwrap_or(u32::MAX);
        self.commands = self.commands.saturating_add(count);
        if story::refuses(self.referee.cycle().0) {
            for Sequenced { seq, .. } in list {
                let reason = story::refusal(self.refusals);
                self.refusals += 1;
                self.refused.push(CommandResult { seq, outcome: Outcome::Refused { reason } });
            }
            return;
        }
        let (length, limit) = (list.len(), self.referee.rules().commands_a_cycle_max);
        let is_taken = self.referee.handle_commands(CLIENT, seen_cycle, list).is_ok();
        self.given += if is_taken { length } else { 0 };
        if !is_taken || self.given > usize::try_from(limit).unwrap_or(usize::MAX) {
            self.note(Mistake::TooManyCommands { limit });
        }
    }

    /// Takes that the client is done.
    pub(crate) fn handle_done(&mut self, cycle: Cycle) {
        let now = self.referee.cycle().0;
        if cycle.0.checked_add(1) == Some(now) && self.deltas > 1 {
            return self.note(Mistake::DoneTwice);
        }
        if cycle.0 != now {
            self.note(Mistake::DoneCycle { found: cycle.0 });
        }
        if self.proved > 0 && !self.has_pinged {
            self.note(Mistake::NoProof);
        }
        self.is_answered = true;
    }

    /// Takes a ping, which proves what the client makes of the view; returns the pong.
    pub(crate) fn handle_ping(&mut self, id: u32) -> ServerMessage {
        let expected = low_half(self.referee.view(CLIENT).check());
        if id != expected {
            self.note(Mistake::Check { found: id, expected });
        } else if !self.has_pinged {
            self.proved += 1;
        }
        self.has_pinged = true;
        ServerMessage::Pong { id, cycle: self.referee.cycle(), fraction: 0.0 }
    }

    /// Takes that the client wants a pause, or none; returns what it is told. The other seat wants each pause, too, and
    /// each is short.
    pub(crate) fn handle_pause(&mut self, on: bool) -> Vec<ServerMessage> {
        let nobody = ServerMessage::Paused { seats: Vec::new(), on: false };
        if on {
            vec![ServerMessage::Paused { seats: vec![CLIENT, OTHER], on: true }, nobody]
        } else {
            vec![nobody]
        }
    }

    /// Plays a cycle; returns what the client is told.
    pub(crate) fn step(&mut self) -> Vec<ServerMessage> {
        let cycle = self.referee.cycle();
        for (seat, command) in story::orders(cycle.0) {
            let list = vec![Sequenced { seq: 0, command }];
            // Too many of the client's commands have been told to it.
            let _ = self.referee.handle_commands(seat, cycle, list);
        }
        self.referee.step();
        self.referee.take_records();
        self.referee.take_delta(OTHER);
        (self.is_answered, self.has_pinged) = (false, false);
        let now = self.referee.cycle().0;
        if self.has_reconnect && now == story::CUT_CYCLE {
            self.referee.handle_leave(CLIENT);
            (self.given, self.is_cut) = (0, true);
            self.refused.clear();
            return Vec::new();
        }
        let mut messages = Vec::new();
        if let Some(seats) = story::wish(now) {
            self.count("paused", 1);
            messages.push(ServerMessage::Paused { seats, on: false });
        }
        let refused = std::mem::take(&mut self.refused);
        messages.push(self.delta(refused));
        if let Some(result) = self.referee.result() {
            messages.push(ServerMessage::Ended { result: result.clone() });
        }
        messages
    }

    /// Returns whether the client has said that it is done with the cycle.
    pub(crate) fn is_answered(&self) -> bool {
        self.is_answered
    }

    /// Returns whether the connection is to be cut now.
    pub(crate) fn wants_cut(&self) -> bool {
        self.is_cut
    }

    /// Returns whether the match is over.
    pub(crate) fn has_ended(&self) -> bool {
        self.referee.result().is_some()
    }

    /// Returns the verdict.
    pub(crate) fn verdict(mut self) -> Verdict {
        if self.has_ended() && self.referee.is_out(CLIENT) {
            self.note(Mistake::Resigned);
        }
        let findings = self.findings.into_list();
        Verdict {
            passed: findings.is_empty(),
            cycles: self.referee.cycle().0,
            proved: self.proved,
            deltas: self.deltas,
            commands: self.commands,
            told: self.told,
            findings,
        }
    }

    /// Returns the delta for the client, with the results of its own commands and those that the story refused.
    fn delta(&mut self, refused: Vec<CommandResult>) -> ServerMessage {
        let mut delta = self.referee.take_delta(CLIENT).expect("there is one after each step and join");
        // Behind the client's own are those of what the story ordered in its name.
        delta.results.truncate(self.given);
        self.given = 0;
        delta.results.extend(refused);
        // The last one needs no answer.
        self.deltas += u32::from(self.referee.result().is_none());
        self.count_told(&delta);
        ServerMessage::Delta(delta)
    }

    fn look_at(&mut self, Sequenced { seq, command }: &Sequenced) {
        let seq = *seq;
        let view = self.referee.view(CLIENT);
        let own = |handle| view.object(handle).is_some_and(|seen| seen.owner == Some(CLIENT));
        let unknown = command.object().filter(|&handle| !own(handle));
        let hidden = command.target().filter(|&handle| view.object(handle).is_none());
        if let Some(object) = unknown {
            self.note(Mistake::UnknownHandle { seq, object: object.0 });
        }
        if let Some(target) = hidden {
            self.note(Mistake::UnknownTarget { seq, target: target.0 });
        }
        if !command.is_finite() {
            self.note(Mistake::NotFinite { seq });
        }
    }

    fn count(&mut self, what: &'static str, times: usize) {
        *self.told.entry(what).or_default() += u32::try_from(times).unwrap_or(u32::MAX);
    }

    fn count_told(&mut self, delta: &Delta) {
        for (what, times) in story::told(delta) {
            self.count(what, times);
        }
    }
}

fn low_half(check: Digest) -> u32 {
    u32::try_from(check.0 & u64::from(u32::MAX)).expect("the upper half is masked out")
}
