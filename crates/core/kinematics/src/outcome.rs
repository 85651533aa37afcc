//! What became of those to whom something happened in a cycle.

use maniple_geometry::{Moment, Motion, Scalar};

use crate::event::{Event, EventKind};
use crate::graph::Setting;
use crate::plan::Leg;
use crate::runner::{Runner, Track, stage_at};
use crate::track::{Stage, departure};

/// What an object does from now on.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Change<S: Scalar> {
    /// It collided: it rests and forgets what waits.
    Halted {
        /// Where it rests.
        point: S::Vector,
    },
    /// It goes on.
    Turned {
        /// Its law of motion from now on.
        motion: Motion<S>,
        /// The leg that it is on, if it moves.
        leg: Option<Leg<S>>,
        /// How many of the waiting legs were taken or dropped.
        consumed: u32,
    },
}

/// What became of the runners of a cycle: those of whom nothing is said go on as before.
#[derive(Clone, Debug)]
pub(crate) struct Outcome<S: Scalar> {
    /// Slots, when it happened for those who were halted, and what they do from now on.
    pub(crate) changes: Vec<(u32, S, Change<S>)>,
    pub(crate) events: Vec<Event>,
    /// How often anybody was pulled back.
    pub(crate) retreats: usize,
}

impl<S: Scalar> Outcome<S> {
    pub(crate) fn new() -> Self {
        Self { changes: Vec::new(), events: Vec::new(), retreats: 0 }
    }

    pub(crate) fn clear(&mut self) {
        self.changes.clear();
        self.events.clear();
        self.retreats = 0;
    }

    /// Bytes on the heap.
    pub(crate) fn bytes(&self) -> usize {
        size_of::<(u32, S, Change<S>)>() * self.changes.capacity()
            + size_of::<Event>() * self.events.capacity()
    }

    /// Adds what became of a runner.
    pub(crate) fn add(&mut self, runner: &Runner<S>, arena: &[Stage<S>], setting: &Setting<'_, S>) {
        let turns = matches!(runner.track, Track::Turning(..));
        if !turns && !runner.is_held {
            return;
        }
        let event = |time: S, kind, other, rests| Event {
            cycle: setting.cycle,
            time: time.to_f64(),
            object: runner.id,
            kind,
            other,
            rests,
        };
        for stage in runner.stages(arena).iter().filter(|stage| stage.piece.since <= runner.end) {
            let rests = !stage.piece.is_moving();
            self.events.extend(stage.opening.map(|kind| event(stage.piece.since, kind, None, rests)));
        }
        self.retreats += runner.retreats as usize;
        if let Some(halt) = runner.halt {
            self.events.push(event(runner.end, halt.kind, halt.other, true));
            self.changes.push((runner.slot, runner.end, Change::Halted { point: runner.last }));
            return;
        }
        let (motion, leg, consumed) = match runner.track {
            Track::Straight { .. } => {
                let (state, intent) = setting.objects.of(runner.slot);
                (state.motion(), Some(intent.leg), 0)
            }
            Track::Turning(..) => {
                let stage = stage_at(runner.stages(arena), runner.end);
                (stage.motion, stage.course.map(|course| course.leg), stage.consumed)
            }
        };
        let consumed = u32::try_from(consumed).expect("few legs wait");
        let (motion, leg) = match leg {
            _ if !runner.is_held => (motion, leg),
            Some(leg) if leg.goal != runner.last => {
                let next = Moment::start_of(setting.cycle.next());
                (departure(runner.last, leg, next).0, Some(leg))
            }
            leg => {
                // Pulled back by so little that the rounded point is the goal: it has arrived.
                self.events.extend(leg.map(|_| event(runner.end, EventKind::Arrived, None, true)));
                let moment = Moment { cycle: setting.cycle, fraction: runner.end.to_f64() };
                (Motion::at_rest(runner.last, moment), None)
            }
        };
        self.changes.push((runner.slot, runner.end, Change::Turned { motion, leg, consumed }));
    }
}

/// Sorts events by time, then by id; those of one object at one time stay in their order.
pub(crate) fn sort_events(events: &mut Vec<Event>, spare: &mut Vec<Event>, keys: &mut Vec<(u64, u32, u32)>) {
    keys.clear();
    // Times are not negative, so that their bits are in their order.
    let key = |(place, event): (u32, &Event)| (event.time.to_bits(), event.object.0, place);
    keys.extend((0u32..).zip(events.iter()).map(key));
    keys.sort_unstable();
    std::mem::swap(events, spare);
    events.clear();
    events.extend(keys.iter().map(|key| spare[key.2 as usize]));
}
