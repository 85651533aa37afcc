//! What became of those to whom something happened in a cycle.

use maniple_geometry::{Cycle, Moment, Motion, ObjectId, Scalar};

use crate::digest::object_hash;
use crate::event::{Event, EventKind};
use crate::graph::Setting;
use crate::objects::Objects;
use crate::plan::{Leg, Plan};
use crate::room::{keep_room, make_room};
use crate::runner::{Halt, Runner, Track, stage_at};
use crate::track::{Stage, departure};

/// Objects that are asked for one right after the other before they are changed, so that the memory answers all at once:
/// they are near each other, but in another order.
const AT_ONCE: usize = 64;

/// An object that collided: it rests and forgets what waits.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Halted<S: Scalar> {
    pub(crate) slot: u32,
    pub(crate) id: ObjectId,
    /// When.
    pub(crate) time: S,
    /// Where it rests.
    pub(crate) point: S::Vector,
    pub(crate) halt: Halt,
    /// Its summand in the state hash from now on.
    pub(crate) hash: u64,
}

/// An object that goes on otherwise than before.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Turned<S: Scalar> {
    pub(crate) slot: u32,
    /// Its law of motion from now on.
    pub(crate) motion: Motion<S>,
    /// The leg that it is on, if it moves.
    pub(crate) leg: Option<Leg<S>>,
    /// How many of the waiting legs were taken or dropped.
    pub(crate) consumed: usize,
}

/// What became of the runners of a cycle: those of whom nothing is said go on as before.
#[derive(Clone, Debug)]
pub(crate) struct Outcome<S: Scalar> {
    pub(crate) halted: Vec<Halted<S>>,
    pub(crate) turned: Vec<Turned<S>>,
    /// All events but those of being halted, which come behind the others of the same object.
    pub(crate) events: Vec<Event>,
    /// How often anybody was pulled back.
    pub(crate) retreats: usize,
    /// How many of the halted and of the turned have been applied.
    applied: (usize, usize),
}

impl<S: Scalar> Outcome<S> {
    pub(crate) fn new() -> Self {
        Self { halted: Vec::new(), turned: Vec::new(), events: Vec::new(), retreats: 0, applied: (0, 0) }
    }

    pub(crate) fn clear(&mut self) {
        keep_room(&mut self.halted);
        keep_room(&mut self.turned);
        keep_room(&mut self.events);
        self.halted.clear();
        self.turned.clear();
        self.events.clear();
        self.retreats = 0;
        self.applied = (0, 0);
    }

    /// Lets objects rest or go on as it says, but for those who have been applied.
    pub(crate) fn apply(&self, objects: &mut Objects<S>, cycle: Cycle) {
        let (halted, turned) = (&self.halted[self.applied.0..], &self.turned[self.applied.1..]);
        for some in halted.chunks(AT_ONCE) {
            objects.fetch(some.iter().map(|halted| halted.slot));
            for &Halted { slot, time, point, hash, .. } in some {
                objects.halt(slot, point, Moment { cycle, fraction: time.to_f64() }, hash);
            }
        }
        for &Turned { slot, motion, leg, consumed } in turned {
            match leg {
                Some(leg) => objects.set_out(slot, &motion, leg),
                None => objects.set_at_rest(slot, motion.start, motion.from),
            }
            objects.consume(slot, consumed);
            objects.settle(slot, cycle.next());
        }
    }

    /// Notes that all have been applied who are in it by now.
    pub(crate) fn note_applied(&mut self) {
        self.applied = (self.halted.len(), self.turned.len());
    }

    /// Adds all events to a list, those of one object in their order.
    pub(crate) fn tell(&self, events: &mut Vec<Event>, cycle: Cycle) {
        events.extend_from_slice(&self.events);
        events.extend(self.halted.iter().map(|halted| Event {
            cycle,
            time: halted.time.to_f64(),
            object: halted.id,
            kind: halted.halt.kind,
            other: halted.halt.other,
            is_one_of_several: halted.halt.is_one_of_several,
            rests: true,
        }));
    }

    /// Bytes on the heap.
    pub(crate) fn bytes(&self) -> usize {
        size_of::<Halted<S>>() * self.halted.capacity()
            + size_of::<Turned<S>>() * self.turned.capacity()
            + size_of::<Event>() * self.events.capacity()
    }

    /// Adds what became of a runner that does not just go straight on.
    pub(crate) fn add(&mut self, runner: &Runner<S>, arena: &[Stage<S>], setting: &Setting<'_, S>) {
        let event = |time: S, kind, other, rests| Event {
            cycle: setting.cycle,
            time: time.to_f64(),
            object: runner.id,
            kind,
            other,
            is_one_of_several: false,
            rests,
        };
        for stage in runner.stages(arena).iter().filter(|stage| stage.piece.since <= runner.end) {
            let rests = !stage.piece.is_moving();
            self.events.extend(stage.opening.map(|kind| event(stage.piece.since, kind, None, rests)));
        }
        self.retreats += runner.retreats as usize;
        if let Some(halt) = runner.halt {
            let from = Moment { cycle: setting.cycle, fraction: runner.end.to_f64() };
            let plan = Plan { motion: Motion::at_rest(runner.last, from), course: None, queue: &[] };
            let layers = setting.objects.layers[runner.slot as usize];
            let hash = object_hash(runner.id, (runner.radius, layers), &plan);
            self.halted.push(Halted {
                slot: runner.slot,
                id: runner.id,
                time: runner.end,
                point: runner.last,
                halt,
                hash,
            });
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
        self.turned.push(Turned { slot: runner.slot, motion, leg, consumed });
    }
}

/// What sorting events needs; kept for its memory.
#[derive(Clone, Debug, Default)]
pub(crate) struct EventSorter {
    spare: Vec<Event>,
    /// For each bucket where it begins.
    starts: Vec<u32>,
    /// Of one bucket: time, object, and place among the events.
    keys: Vec<(u64, u32, u32)>,
}

impl EventSorter {
    /// Sorts events by time, then by id; those of one object at one time stay in their order.
    ///
    /// A counting sort into buckets of time, about one for each event, and then each bucket by itself: times are spread
    /// over the cycle, so it costs little more than writing the events down.
    pub(crate) fn sort(&mut self, events: &mut Vec<Event>) {
        let buckets = events.len().next_power_of_two();
        self.starts.clear();
        self.starts.resize(buckets + 2, 0);
        for event in events.iter() {
            self.starts[bucket(event.time, buckets) + 2] += 1;
        }
        let mut sum = 0;
        for start in &mut self.starts {
            sum += *start;
            *start = sum;
        }
        keep_room(&mut self.starts);
        keep_room(events);
        make_room(&mut self.spare, events.capacity());
        std::mem::swap(events, &mut self.spare);
        events.clear();
        events.extend_from_slice(&self.spare);
        for event in &self.spare {
            let place = &mut self.starts[bucket(event.time, buckets) + 1];
            events[*place as usize] = *event;
            *place += 1;
        }
        for bucket in 0..buckets {
            let range = self.starts[bucket] as usize..self.starts[bucket + 1] as usize;
            if range.len() > 1 {
                self.sort_bucket(&mut events[range]);
            }
        }
    }

    fn sort_bucket(&mut self, events: &mut [Event]) {
        // Times are not negative, so that their bits are in their order.
        let key = |event: &Event| (event.time.to_bits(), event.object.0);
        if let [first, second] = events {
            if key(second) < key(first) {
                std::mem::swap(first, second);
            }
            return;
        }
        self.keys.clear();
        self.keys.extend((0u32..).zip(&*events).map(|(place, event)| (key(event).0, key(event).1, place)));
        self.keys.sort_unstable();
        keep_room(&mut self.keys);
        self.spare.clear();
        self.spare.extend_from_slice(events);
        for (event, key) in events.iter_mut().zip(&self.keys) {
            *event = self.spare[key.2 as usize];
        }
    }

    /// Bytes on the heap.
    pub(crate) fn bytes(&self) -> usize {
        size_of::<Event>() * self.spare.capacity()
            + size_of::<u32>() * self.starts.capacity()
            + size_of::<(u64, u32, u32)>() * self.keys.capacity()
    }
}

/// The bucket of a time, later ones for later times.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    clippy::cast_precision_loss,
    reason = "a time is from 0 to 1, and buckets are fewer than 2^53"
)]
fn bucket(time: f64, buckets: usize) -> usize {
    ((time * buckets as f64) as usize).min(buckets - 1)
}

#[cfg(test)]
mod tests {
    use maniple_geometry::{Cycle, ObjectId};

    use super::*;

    #[test]
    fn events_come_by_time_and_id_and_else_in_their_order() {
        let mut state = 1u32;
        let mut random = |below: u32| {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 8) % below
        };
        for count in [0, 1, 2, 3, 17, 1000] {
            let make = |place: u32, random: &mut dyn FnMut(u32) -> u32| Event {
                cycle: Cycle(place),
                time: f64::from(random(8)) / 7.0,
                object: ObjectId(random(5)),
                kind: EventKind::Arrived,
                other: None,
                is_one_of_several: false,
                rests: false,
            };
            let mut events: Vec<Event> = (0..count).map(|place| make(place, &mut random)).collect();
            let mut expected = events.clone();
            expected.sort_by(|a, b| a.time.total_cmp(&b.time).then(a.object.cmp(&b.object)));
            EventSorter::default().sort(&mut events);
            assert_eq!(events, expected);
        }
    }
}
