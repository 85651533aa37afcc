//! All that decides what a world does next, as plain data, and a world from it.
//!
//! Where the objects lie in memory, the lists that find them and the room for the next cycle are made anew: nothing
//! depends on them.

use std::collections::BTreeMap;

use glam::DVec2;
use maniple_geometry::{Cycle, Limits, Moment, NumberError, ObjectId, Planar, Scalar};
use serde::{Deserialize, Serialize};

use crate::error::RestoreError;
use crate::plan::{Course, Leg, Placement, Planned, WAYPOINTS_MAX};
use crate::settings::Method;
use crate::state::{Phase, State};
use crate::track::departure;
use crate::wall::Layers;
use crate::world::World;

/// By how much a motion may have come beyond its goal at the start of a cycle, as a part of its duration and in cycles:
/// far more than rounding does, far less than anybody sees.
const OVERDUE_MAX: f64 = 1.0 / (1u64 << 32) as f64;

/// All that decides what a world does next, but for limits, settings and walls, which its owner has.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct WorldSnapshot {
    /// The cycle that comes next.
    pub cycle: Cycle,
    /// The state hash after the last cycle.
    pub digest: u64,
    /// The objects.
    pub objects: BTreeMap<ObjectId, ObjectSnapshot>,
}

/// What an object does and is going to do, in doubles, which hold either scalar.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ObjectSnapshot {
    /// World units.
    pub radius: f64,
    /// The layers that it is in.
    pub layers: Layers,
    /// The centre at `from`, in world units.
    pub start: DVec2,
    /// Since when it moves or rests.
    pub from: Moment,
    /// The leg that it is on; `None`: it rests. Its velocity follows from it.
    pub leg: Option<Leg>,
    /// For a motion that an order began in the present moment: whether it rested before.
    pub rested_before: bool,
    /// What waits, at most [`WAYPOINTS_MAX`].
    pub waiting: Vec<WaitingLeg>,
}

/// A leg that waits.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct WaitingLeg {
    /// The leg; `None`: an order to stop.
    pub leg: Option<Leg>,
    /// Whether it replaces what is before it.
    pub placement: Placement,
    /// Not before this moment.
    pub start: Option<Moment>,
}

impl<S: Scalar> World<S> {
    /// Returns all that decides what the world does next, but for limits, settings and walls.
    #[must_use]
    pub fn snapshot(&self) -> WorldSnapshot {
        let object = |slot: u32| {
            let (state, intent) = self.objects.of(slot);
            let leg = state.is_moving().then_some(intent.leg);
            if let Some(leg) = leg {
                let (motion, _) = departure(state.start, leg, state.motion().from);
                assert_eq!(motion.velocity, state.velocity, "a velocity follows from the leg");
            }
            let waiting = |planned: &Planned<S>| WaitingLeg {
                leg: planned.leg.map(|leg| widened(&leg)),
                placement: planned.placement,
                start: planned.start,
            };
            let saved = ObjectSnapshot {
                radius: state.radius.to_f64(),
                layers: self.objects.layers[slot as usize],
                start: state.start.to_dvec2(),
                from: state.motion().from,
                leg: leg.map(|leg| widened(&leg)),
                rested_before: state.rested_before,
                waiting: self.objects.queues.waiting(intent.queue).iter().map(waiting).collect(),
            };
            (intent.id, saved)
        };
        WorldSnapshot {
            cycle: self.cycle,
            digest: self.digest,
            objects: self.objects.slots().map(object).collect(),
        }
    }

    /// Goes on where a snapshot was taken, of a world with the same limits, settings and walls.
    ///
    /// # Errors
    /// See [`RestoreError`]; the world is of no use any more then. An overlap is one only under settings that promise
    /// that there are none.
    ///
    /// # Panics
    /// If there are objects in the world already.
    pub fn restore(&mut self, snapshot: &WorldSnapshot) -> Result<(), RestoreError> {
        assert!(self.is_empty(), "what is restored comes into an empty world");
        self.cycle = snapshot.cycle;
        self.digest = snapshot.digest;
        self.reserve(snapshot.objects.len());
        for (&id, object) in &snapshot.objects {
            let bad = |problem: Problem| problem.of(id, object, snapshot.cycle);
            object.check::<S>(&self.limits, snapshot.cycle).map_err(bad)?;
            self.put_back(id, object);
        }
        // Who rests for good goes into the lists of those at rest, and who does not is found in its sector from now on.
        self.gather();
        self.fill_sectors();
        if self.settings.method == Method::Event && self.settings.certify {
            self.overlaps().first().map_or(Ok(()), |&overlap| Err(RestoreError::Overlap(overlap)))?;
        }
        Ok(())
    }

    /// Puts an object in that was checked, as an active one.
    fn put_back(&mut self, id: ObjectId, object: &ObjectSnapshot) {
        let start = S::Vector::from_dvec2(object.start);
        let state =
            State { phase: Phase::Active, ..State::at_rest(start, object.from, S::from_f64(object.radius)) };
        self.note_layers(object.layers);
        let slot = self.objects.insert(id, state, object.layers);
        if let Some(leg) = &object.leg {
            let leg = narrowed(leg);
            let (motion, _) = departure(start, leg, object.from);
            self.objects.set_out(slot, &motion, leg);
            self.objects.states[slot as usize].rested_before = object.rested_before;
        }
        let planned = |waiting: &WaitingLeg| Planned {
            leg: waiting.leg.map(|leg| narrowed(&leg)),
            placement: waiting.placement,
            start: waiting.start,
        };
        self.objects.extend_queue(slot, 0, object.waiting.iter().map(planned));
        self.objects.settle(slot, self.cycle);
        self.batches[0].slots.push(slot);
    }
}

/// What is wrong with an object, before it is said with which.
enum Problem {
    Number(&'static str, NumberError),
    Moment,
    NoWay,
    TooManyWaypoints,
    Waiting,
}

impl Problem {
    fn of(self, id: ObjectId, object: &ObjectSnapshot, now: Cycle) -> RestoreError {
        match self {
            Self::Number(field, problem) => RestoreError::BadNumber { object: id, field, problem },
            Self::Moment => RestoreError::BadMoment { object: id, from: object.from.cycle, now },
            Self::NoWay => RestoreError::NoWay { object: id },
            Self::TooManyWaypoints => RestoreError::TooManyWaypoints { object: id, max: WAYPOINTS_MAX },
            Self::Waiting => RestoreError::BadWaiting { object: id },
        }
    }
}

impl ObjectSnapshot {
    fn check<S: Scalar>(&self, limits: &Limits, now: Cycle) -> Result<(), Problem> {
        limits.check_point(self.start).map_err(|(field, problem)| Problem::Number(field, problem))?;
        limits.check_radius(self.radius).map_err(|problem| Problem::Number("r", problem))?;
        check_fraction(self.from, limits)?;
        let elapsed = self.from.until(now);
        if elapsed < 0.0 {
            return Err(Problem::Moment);
        }
        if let Some(leg) = &self.leg {
            check_leg(leg, limits)?;
            let (leg, start) = (narrowed::<S>(leg), S::Vector::from_dvec2(self.start));
            if leg.goal == start {
                return Err(Problem::NoWay);
            }
            let duration = Course::along(leg, start).duration;
            if elapsed > duration * (1.0 + OVERDUE_MAX) + OVERDUE_MAX {
                return Err(Problem::Moment);
            }
        }
        if self.waiting.len() > WAYPOINTS_MAX {
            return Err(Problem::TooManyWaypoints);
        }
        for waiting in &self.waiting {
            let is_ordered = match waiting.placement {
                Placement::Replace => waiting.start.is_some(),
                Placement::Queue => waiting.leg.is_some(),
            };
            if !is_ordered {
                return Err(Problem::Waiting);
            }
            waiting.leg.map_or(Ok(()), |leg| check_leg(&leg, limits))?;
            waiting.start.map_or(Ok(()), |start| check_fraction(start, limits))?;
        }
        Ok(())
    }
}

fn check_leg(leg: &Leg, limits: &Limits) -> Result<(), Problem> {
    limits.check_point(leg.goal).map_err(|(field, problem)| Problem::Number(field, problem))?;
    limits.check_speed(leg.speed).map_err(|problem| Problem::Number("s", problem))?;
    if leg.speed == 0.0 {
        return Err(Problem::Number("s", NumberError::NotPositive(leg.speed)));
    }
    Ok(())
}

/// The moment of a collision may be nearer to 0 than what an order may say.
fn check_fraction(moment: Moment, limits: &Limits) -> Result<(), Problem> {
    if (0.0..=1.0).contains(&moment.fraction) {
        return Ok(());
    }
    limits.check_fraction(moment.fraction).map_err(|problem| Problem::Number("fraction", problem))
}

fn widened<S: Scalar>(leg: &Leg<S>) -> Leg {
    Leg { goal: leg.goal.to_dvec2(), speed: leg.speed.to_f64() }
}

fn narrowed<S: Scalar>(leg: &Leg) -> Leg<S> {
    Leg { goal: S::Vector::from_dvec2(leg.goal), speed: S::from_f64(leg.speed) }
}

#[cfg(test)]
mod tests {
    use maniple_geometry::{Circle, Segment};

    use super::*;
    use crate::error::Overlap;
    use crate::event::Event;
    use crate::settings::Settings;
    use crate::solve::Stops;
    use crate::wall::{Wall, WallKind};

    #[test]
    fn a_world_goes_on_from_each_snapshot_as_if_there_had_been_none() {
        for seed in 0..12 {
            for stops in [Stops::Both, Stops::Approaching] {
                let exact = Settings::exact(stops);
                play::<f64>(seed, exact);
                play::<f32>(seed, exact);
                play::<f64>(seed, Settings { method: Method::Stepped { substeps: 4 }, ..exact });
            }
        }
    }

    #[test]
    fn a_snapshot_that_is_none_is_refused_with_the_object_and_what_is_wrong() {
        let check = |change: fn(&mut ObjectSnapshot), expected: &str| {
            let mut snapshot = two();
            change(snapshot.objects.get_mut(&ObjectId(7)).unwrap());
            let error = empty::<f64>(Stops::Both.into()).restore(&snapshot).unwrap_err();
            assert!(error.to_string().contains(expected), "{error}\n  lacks {expected}");
        };
        check(|object| object.start.x = f64::NAN, "object 7: x is not a number");
        check(|object| object.start.y = 65.0, "object 7: y is 65; the largest allowed is 64");
        check(|object| object.radius = -1.0, "object 7: r is -1; it must be positive");
        check(|object| object.from.fraction = 1.5, "object 7: fraction is 1.5");
        check(|object| object.from.fraction = f64::NAN, "object 7: fraction is not a number");
        check(|object| object.from.cycle = Cycle(9), "from cycle 9 on, which does not go on at cycle 5");
        check(|object| object.leg.as_mut().unwrap().speed = 0.0, "object 7: s is 0; it must be positive");
        check(|object| object.leg.as_mut().unwrap().goal = object.start, "a way to where it starts");
        check(|object| object.leg.as_mut().unwrap().speed = 4.0, "from cycle 2 on, which does not go on");
        check(|object| object.waiting = vec![object.waiting[0]; 65], "more than 64 waypoints");
        check(|object| object.waiting[0].placement = Placement::Replace, "no order makes");
        check(|object| object.waiting[0].leg = None, "no order makes");
        // At the start of cycle 5 object 3 rests at (30, 30).
        check(
            |object| (object.leg, object.start) = (None, DVec2::new(30.9, 30.0)),
            "objects 3 and 7 overlap",
        );
        check(
            |object| (object.leg, object.start) = (None, DVec2::new(20.4, 10.0)),
            "object 7 overlaps wall 0",
        );
    }

    #[test]
    fn settings_that_promise_no_distance_may_be_restored_with_an_overlap() {
        let mut snapshot = two();
        let object = snapshot.objects.get_mut(&ObjectId(7)).unwrap();
        (object.leg, object.start) = (None, DVec2::new(30.9, 30.0));
        let settings = Settings { certify: false, ..Settings::exact(Stops::Both) };
        let mut world = empty::<f64>(settings);
        assert_eq!(world.restore(&snapshot), Ok(()));
        assert_eq!(world.overlaps(), [Overlap::Objects(ObjectId(3), ObjectId(7))]);
    }

    /// Plays a crowd by random orders; beside it goes a world that is made anew from a snapshot again and again, before
    /// the orders of a cycle or between them.
    fn play<S: Scalar>(seed: u64, settings: Settings) {
        let mut dice = Dice(seed);
        let mut world = crowd::<S>(&mut dice, settings);
        let mut twin = renewed(&world);
        let mut stopped = 0;
        for cycle in 0..60 {
            for _ in 0..dice.below(12) {
                if dice.below(4) == 0 {
                    twin = renewed(&world);
                }
                order(&mut dice, &mut world, &mut twin);
            }
            if dice.below(2) == 0 {
                twin = renewed(&world);
            }
            let told: Vec<Event> = world.step().to_vec();
            assert_eq!(twin.step(), told, "seed {seed}, {settings:?}, cycle {cycle}");
            assert_eq!(twin.digest(), world.digest(), "seed {seed}, {settings:?}, cycle {cycle}");
            assert_eq!(twin.snapshot(), world.snapshot(), "seed {seed}, {settings:?}, cycle {cycle}");
            stopped += told.iter().filter(|event| event.other.is_some()).count();
        }
        assert!(stopped > 10, "seed {seed}: {stopped} collisions");
    }

    fn renewed<S: Scalar>(world: &World<S>) -> World<S> {
        let mut renewed = empty(world.settings);
        assert_eq!(renewed.restore(&world.snapshot()), Ok(()));
        renewed
    }

    fn crowd<S: Scalar>(dice: &mut Dice, settings: Settings) -> World<S> {
        let mut world = empty(settings);
        for number in 0..60 {
            let layers = if number % 5 == 0 { Layers::AIR } else { Layers::GROUND };
            let radius = S::from_f64([0.25, 0.5, 1.5][dice.below(3) as usize]);
            let _ = world.insert(ObjectId(number * 7 % 64), Circle::new(dice.point::<S>(), radius), layers);
        }
        world
    }

    /// Gives both worlds the same order, which they both take or refuse.
    fn order<S: Scalar>(dice: &mut Dice, world: &mut World<S>, twin: &mut World<S>) {
        let id = ObjectId(dice.below(64));
        let moment = Moment {
            cycle: Cycle(world.cycle().0 + dice.below(3)),
            fraction: f64::from(dice.below(4)) / 4.0,
        };
        let start = (dice.below(3) == 0).then_some(moment);
        let legs: Vec<Leg<S>> = (0..1 + dice.below(3))
            .map(|_| Leg { goal: dice.point::<S>(), speed: S::from_f64(f64::from(1 + dice.below(16)) / 8.0) })
            .collect();
        let placement = if dice.below(3) == 0 { Placement::Queue } else { Placement::Replace };
        match dice.below(12) {
            0 | 1 => assert_eq!(world.halt(id, start), twin.halt(id, start)),
            2 => assert_eq!(world.remove(id), twin.remove(id)),
            3 => {
                let (circle, layers) = (Circle::new(dice.point::<S>(), S::from_f64(0.5)), Layers::GROUND);
                assert_eq!(world.insert(id, circle, layers), twin.insert(id, circle, layers));
            }
            4 => {
                let center = dice.point::<S>();
                assert_eq!(world.teleport(id, center), twin.teleport(id, center));
            }
            _ => assert_eq!(world.go(id, &legs, placement, start), twin.go(id, &legs, placement, start)),
        }
    }

    /// A world with a wall and nobody in it.
    fn empty<S: Scalar>(settings: Settings) -> World<S> {
        let limits = Limits::new(64.0, 2.0, 4.0).unwrap();
        let at = |x: f64, y: f64| S::Vector::from_dvec2(DVec2::new(x, y));
        let segment = Segment::new(at(20.0, 4.0), at(20.0, 24.0));
        World::new(limits, settings, &[Wall { segment, kind: WallKind::Segment, layers: Layers::GROUND }])
            .unwrap()
    }

    /// Two objects at the start of cycle 5: 3 rests, 7 is on its way with a leg behind.
    fn two() -> WorldSnapshot {
        let mut world = empty::<f64>(Stops::Both.into());
        let circle = |x: f64, y: f64| Circle::new(DVec2::new(x, y), 0.5);
        world.insert(ObjectId(3), circle(30.0, 30.0), Layers::GROUND).unwrap();
        world.insert(ObjectId(7), circle(30.0, 40.0), Layers::GROUND).unwrap();
        world.step();
        world.step();
        let leg = |x: f64| Leg { goal: DVec2::new(x, 40.0), speed: 0.5 };
        world.go(ObjectId(7), &[leg(35.0), leg(38.0)], Placement::Replace, None).unwrap();
        for _ in 0..3 {
            world.step();
        }
        world.snapshot()
    }

    /// A stream of numbers from a seed: Knuth's linear congruential generator.
    struct Dice(u64);

    impl Dice {
        fn below(&mut self, count: u32) -> u32 {
            self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            u32::try_from(self.0 >> 33).unwrap() % count
        }

        fn point<S: Scalar>(&mut self) -> S::Vector {
            let mut coordinate = || 2.0 + f64::from(self.below(4096)) / 128.0;
            S::Vector::from_dvec2(DVec2::new(coordinate(), coordinate()))
        }
    }
}
