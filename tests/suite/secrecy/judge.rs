//! Whether what a team may know is the same in two worlds, and if not, whether it has a cause that it may know.

use std::collections::BTreeMap;

use glam::DVec2;
use maniple_game::World;
use maniple_geometry::{Cycle, Moment, ObjectId};
use maniple_view::{Action, Base, EndOfTask, Mode, Seat, Sighting, Stop, Task};

use super::players;
use super::twin::{Seen, Twin};

/// A shot: who fired, and at whom.
type Shot = (ObjectId, Option<ObjectId>);

/// A world at the start of a cycle, as the judge needs it.
pub(super) struct Look {
    pub(super) cycle: Cycle,
    pub(super) seen: Seen,
    pub(super) all: BTreeMap<ObjectId, Sighting>,
    pub(super) dead: Vec<ObjectId>,
    pub(super) shots: Vec<Shot>,
    ended: Vec<(ObjectId, Task, EndOfTask)>,
    stock: u32,
    /// By seat.
    out: Vec<bool>,
}

impl Look {
    pub(super) fn new(twin: &Twin, world: &World) -> Self {
        let seats = (0..).map(Seat).take(twin.teams.len());
        Self {
            cycle: world.cycle(),
            seen: twin.look(world),
            all: world.objects().iter().map(|it| (it.object, *it)).collect(),
            dead: world.dead().to_vec(),
            shots: world.fired().to_vec(),
            ended: world.ended().to_vec(),
            stock: world.stock(twin.watcher),
            out: seats.map(|seat| world.is_out(seat)).collect(),
        }
    }

    pub(super) fn sees(&self, object: ObjectId) -> bool {
        self.seen.objects.contains_key(&object)
    }
}

/// What the judge says to a cycle.
pub(super) enum Verdict {
    /// The team may know of no difference.
    Alike,
    /// It may, for this reason: what it is told need not be the same any more.
    Differs(&'static str),
    /// What it has differs without a cause that it may know.
    Leak(String),
}

/// What was found to differ in a cycle.
#[derive(Default)]
struct Found {
    /// What others chose to do, and what follows from what is hidden by the rules of the game.
    lawful: Vec<&'static str>,
    /// What can only differ if something lawful does.
    owing: Vec<String>,
    /// What nothing explains.
    strange: Vec<String>,
}

/// Two worlds and the twin of each.
pub(super) struct Judge {
    pub(super) twins: [Twin; 2],
    /// Those who stand in both worlds from the start, with the same luck.
    roles: BTreeMap<ObjectId, ObjectId>,
    /// Whom the team sees in one world, and who that is in the other.
    pairs: BTreeMap<ObjectId, ObjectId>,
}

/// The cycle that is judged: both worlds before it and after it.
struct Case<'a> {
    before: &'a [Look; 2],
    now: &'a [Look; 2],
}

impl Judge {
    pub(super) fn new(twins: [Twin; 2], roles: BTreeMap<ObjectId, ObjectId>) -> Self {
        Self { twins, roles, pairs: BTreeMap::new() }
    }

    /// Compares the worlds at the start of the match.
    pub(super) fn begin(&mut self, now: &[Look; 2]) -> Verdict {
        let mut found = Found::default();
        self.meet(now, &mut found);
        self.compare_tiles(now, &mut found);
        found.verdict()
    }

    /// Compares the worlds after a cycle in which they were alike before.
    pub(super) fn compare(&mut self, before: &[Look; 2], now: &[Look; 2]) -> Verdict {
        let case = Case { before, now };
        let mut found = Found::default();
        for (&one, &other) in &self.pairs {
            self.follow([one, other], &case, &mut found);
        }
        self.compare_own_shots(&case, &mut found);
        self.compare_tiles(now, &mut found);
        self.pairs.retain(|one, other| now[0].sees(*one) && now[1].sees(*other));
        self.meet(now, &mut found);
        if now[0].stock != now[1].stock {
            found.owing.push(format!("stock {} {}", now[0].stock, now[1].stock));
        }
        if found.lawful.is_empty() {
            self.compare_news(&case, &mut found);
        }
        found.verdict()
    }

    fn watcher(&self) -> Seat {
        self.twins[0].watcher
    }

    /// Returns who an object that is seen in one world is in the other.
    fn twin_of(&self, world: usize, object: ObjectId) -> Option<ObjectId> {
        if world == 0 {
            self.pairs.get(&object).copied()
        } else {
            self.pairs.iter().find(|(_, other)| **other == object).map(|(one, _)| *one)
        }
    }

    /// Compares somebody who was seen before the cycle.
    fn follow(&self, ids: [ObjectId; 2], case: &Case<'_>, found: &mut Found) {
        let was = case.before[0].seen.objects[&ids[0]];
        let now = [0, 1].map(|world| case.now[world].seen.objects.get(&ids[world]));
        let died = [0, 1].map(|world| case.now[world].dead.contains(&ids[world]));
        if let [Some(one), Some(other)] = now {
            return self.compare_states([one, other], case, found);
        }
        if died[0] == died[1] {
            match now {
                [None, None] => {}
                _ if was.owner == Some(self.watcher()) => found.strange.push(format!("{was:?} is hidden")),
                _ => found.lawful.push("left"),
            }
            return;
        }
        let is_out =
            was.owner.is_some_and(|owner| case.now[0].out[owner.index()] != case.now[1].out[owner.index()]);
        let is_foreign = was.owner.is_some_and(|owner| owner != self.watcher());
        if is_out || is_foreign && was.status.mode == Mode::Site || self.is_hurt_by_hidden(ids, case) {
            found.lawful.push("died");
        } else if was.status.amount.is_some() && self.is_gathered_from(ids, case) {
            found.lawful.push("gathered");
        } else {
            found.strange.push(format!("{was:?} died in one world: {died:?}"));
        }
    }

    /// Compares somebody who is seen before the cycle and after it.
    fn compare_states(&self, now: [&Sighting; 2], case: &Case<'_>, found: &mut Found) {
        let [one, other] = now;
        let ids = now.map(|it| it.object);
        if one.status.hit_points != other.status.hit_points {
            if self.is_hurt_by_hidden(ids, case) {
                found.lawful.push("hurt");
            } else {
                found.strange.push(format!("hit points without a cause: {one:?} {other:?}"));
            }
        }
        if one.status.amount != other.status.amount {
            if self.is_gathered_from(ids, case) {
                found.lawful.push("gathered");
            } else {
                found.strange.push(format!("an amount without a cause: {one:?} {other:?}"));
            }
        }
        let doing = now.map(|it| (it.status.mode, it.status.action));
        if one.owner == Some(self.watcher()) {
            let known = now.map(|it| (it.base, it.stop.map(kind_of_stop), it.own));
            if doing[0] != doing[1] || known[0] != known[1] {
                self.owe(now, case, found);
            }
            return;
        }
        if doing[0] != doing[1] {
            found.lawful.push("choice");
        }
        let motions =
            [0, 1].map(|world| motion(&case.before[world].all[&ids[world]], now[world], case.now[0].cycle));
        if motions[0] != motions[1] {
            let is_same = self.roles.get(&ids[0]) == Some(&ids[1]);
            if one.owner.is_none() && is_same && is_departure_of_one(ids, now, case) {
                found.strange.push(format!("what is nobody's sets out: {one:?} {other:?}"));
            } else {
                found.lawful.push("motion");
            }
        }
    }

    /// Notes that an own object differs. Who was stopped by somebody that has gone at once knows why; so does who was bumped into at
    /// the very moment in which it stopped anyway, and who was stopped by a motion whose past is another.
    fn owe(&self, now: [&Sighting; 2], case: &Case<'_>, found: &mut Found) {
        let is_bumped = |world: usize| matches!(now[world].stop, Some(Stop::Object(Some(by))) if !case.now[world].sees(by));
        let is_pushed = |world: usize| self.is_pushed(world, now[world], case);
        if is_bumped(0) || is_bumped(1) || is_pushed(0) != is_pushed(1) {
            found.lawful.push("bumped");
        } else if self.is_stopped_by_another_past(now, case) {
            found.lawful.push("past");
        } else {
            found.owing.push(format!("{:?} {:?}", now[0], now[1]));
        }
    }

    /// Returns whether somebody was stopped by several at once, of whom at least one has a will of its own.
    fn is_pushed(&self, world: usize, it: &Sighting, case: &Case<'_>) -> bool {
        if it.stop != Some(Stop::Object(None)) {
            return false;
        }
        let moment = it.base.moment();
        let looks = [&case.before[world], &case.now[world]];
        let touches = |other: &&Sighting| {
            other.object != it.object
                && looks.iter().filter_map(|look| look.all.get(&other.object)).any(|other| {
                    self.twins[world].apart((it, it.base.point), (other, at(&other.base, moment))) <= 1e-6
                })
        };
        let others: Vec<&Sighting> = case.now[world].all.values().filter(touches).collect();
        others.len() > 1 && others.iter().any(|other| other.owner != Some(self.watcher()))
    }

    /// Returns whether a stop beside the same object differs in no more than its last bits, and that object came on motions which are
    /// not the same: all that is seen of it is rounded, but it is the motion that stops.
    fn is_stopped_by_another_past(&self, now: [&Sighting; 2], case: &Case<'_>) -> bool {
        let [Some(Stop::Object(Some(one))), Some(Stop::Object(Some(other)))] = now.map(|it| it.stop) else {
            return false;
        };
        let partners = [&case.before[0].all[&one], &case.before[1].all[&other]];
        let [base, other_base] = now.map(|it| it.base);
        self.twin_of(0, one) == Some(other)
            && partners[0].owner != Some(self.watcher())
            && partners.iter().all(|partner| partner.base.is_moving())
            && partners[0].base != partners[1].base
            && now[0].own == now[1].own
            && now[0].status == now[1].status
            && base.cycle == other_base.cycle
            && (base.fraction - other_base.fraction).abs() <= LAST_BITS
            && (base.point - other_base.point).length() <= LAST_BITS
    }

    /// Pairs those who came into sight.
    fn meet(&mut self, now: &[Look; 2], found: &mut Found) {
        let watcher = self.watcher();
        let new = |world: usize| {
            let mut new: Vec<Sighting> = now[world]
                .seen
                .objects
                .values()
                .filter(|it| self.twin_of(world, it.object).is_none())
                .copied()
                .collect();
            new.sort_by(|a, b| players::order(a, b, now[world].cycle));
            new.into_iter().partition::<Vec<_>, _>(|it| it.owner == Some(watcher))
        };
        let [(own, foreign), (other_own, other_foreign)] = [new(0), new(1)];
        let cycle = now[0].cycle;
        let facts =
            |it: &Sighting| (it.unit_type, it.owner, it.status, it.base.position(cycle), it.base.velocity);
        if !own.iter().map(|it| (facts(it), it.own)).eq(other_own.iter().map(|it| (facts(it), it.own))) {
            found.owing.push(format!("new of its own: {own:?} {other_own:?}"));
        }
        if !foreign.iter().map(facts).eq(other_foreign.iter().map(facts)) {
            found.lawful.push("came");
        }
        let pairs = own.iter().zip(&other_own).chain(foreign.iter().zip(&other_foreign));
        self.pairs.extend(pairs.map(|(one, other)| (one.object, other.object)));
    }

    /// Compares what is visible of the ground.
    fn compare_tiles(&self, now: &[Look; 2], found: &mut Found) {
        let [one, other] = [0, 1].map(|world| (&now[world].seen.tiles, &self.twins[world].blocked));
        let rows = one.0.iter().zip(one.1).zip(other.0.iter().zip(other.1));
        for (one, other) in rows {
            let tiles = one.0.iter().zip(one.1).zip(other.0.iter().zip(other.1));
            for ((is_seen, is_blocked), (is_seen_too, is_blocked_too)) in tiles {
                if (*is_seen || *is_seen_too) && is_blocked != is_blocked_too {
                    found.lawful.push("terrain");
                } else if is_seen != is_seen_too {
                    found.owing.push("visible tiles".to_owned());
                }
            }
        }
    }

    /// Compares at whom the watcher's own fire: they chose at the start of the cycle, when all was alike.
    fn compare_own_shots(&self, case: &Case<'_>, found: &mut Found) {
        for world in [0, 1] {
            let is_own = |object: ObjectId| case.before[world].all[&object].owner == Some(self.watcher());
            for &shot in case.now[world].shots.iter().filter(|shot| is_own(shot.0)) {
                if !self.is_in_both(world, shot, case) {
                    found.strange.push(format!("a shot of its own in world {world}: {shot:?}"));
                }
            }
        }
    }

    /// Compares the shots of those who were in sight when they fired and still are, and what became of the watcher's tasks.
    fn compare_news(&self, case: &Case<'_>, found: &mut Found) {
        let Case { before, now } = case;
        let shots = |world: usize| {
            let name = |object: ObjectId| {
                let was_seen = before[world].sees(object);
                let now =
                    if world == 0 { self.twin_of(0, object) } else { now[1].sees(object).then_some(object) };
                now.filter(|_| was_seen)
            };
            let mut shots: Vec<Shot> = now[world]
                .shots
                .iter()
                .filter_map(|&(object, target)| Some((name(object)?, target.and_then(name))))
                .collect();
            shots.sort_unstable();
            shots
        };
        if shots(0) != shots(1) {
            found.lawful.push("shots");
        }
        let ended = |world: usize| {
            let is_own = |object: &ObjectId| {
                now[world].seen.objects.get(object).is_some_and(|it| it.owner == Some(self.watcher()))
            };
            let name = |object: ObjectId| {
                if world == 0 { self.twin_of(0, object) } else { Some(object) }
            };
            let mut ended: Vec<(Option<ObjectId>, Task, EndOfTask)> = now[world]
                .ended
                .iter()
                .filter(|(object, ..)| is_own(object))
                .map(|&(object, task, why)| (name(object), task, why))
                .collect();
            ended.sort_by_key(|(object, ..)| *object);
            ended
        };
        if ended(0) != ended(1) {
            found.owing.push(format!("ends of tasks: {:?} {:?}", ended(0), ended(1)));
        }
    }

    /// Returns whether a shot was fired in the other world, too, with the same luck.
    fn is_in_both(&self, world: usize, (shooter, target): Shot, case: &Case<'_>) -> bool {
        let Some(twin) = self.twin_of(world, shooter) else { return false };
        let is_own = case.before[world].all.get(&shooter).is_some_and(|it| it.owner == Some(self.watcher()));
        let ids = if world == 0 { [shooter, twin] } else { [twin, shooter] };
        if !is_own && self.roles.get(&ids[0]) != Some(&ids[1]) {
            return false;
        }
        let target = match target.map(|target| self.twin_of(world, target)) {
            None => None,
            Some(Some(target)) => Some(target),
            Some(None) => return false,
        };
        case.now[1 - world].shots.contains(&(twin, target))
    }

    /// Returns whether somebody may have been hit by a shot that was fired in one of the worlds only.
    fn is_hurt_by_hidden(&self, ids: [ObjectId; 2], case: &Case<'_>) -> bool {
        [0, 1].into_iter().any(|world| {
            let (all, cycle) = (&case.before[world].all, case.before[world].cycle);
            let place = |object: &ObjectId| all.get(object).map(|it| (it, it.base.position(cycle)));
            case.now[world].shots.iter().any(|&(shooter, target)| {
                if self.is_in_both(world, (shooter, target), case) {
                    return false;
                }
                let Some(victim) = place(&ids[world]) else {
                    return true;
                };
                match target.map(|target| place(&target)) {
                    Some(Some(target)) => {
                        target.0.object == ids[world] || self.twins[world].apart(victim, target) <= SPLASH_MAX
                    }
                    Some(None) => true,
                    None => place(&shooter).is_none_or(|shooter| {
                        self.twins[world].apart(victim, shooter) <= SPLASH_MAX + RANGE_MAX
                    }),
                }
            })
        })
    }

    /// Returns whether others than the watcher gather at a patch in one of the worlds.
    fn is_gathered_from(&self, ids: [ObjectId; 2], case: &Case<'_>) -> bool {
        [0, 1].into_iter().any(|world| {
            [&case.before[world], &case.now[world]].into_iter().any(|look| {
                let place = |it: &Sighting| it.base.position(look.cycle);
                let Some(patch) = look.all.get(&ids[world]) else {
                    return false;
                };
                look.all.values().any(|it| {
                    it.owner != Some(self.watcher())
                        && it.status.action == Action::Gather
                        && self.twins[world].apart((it, place(it)), (patch, place(patch))) <= 0.125
                })
            })
        })
    }
}

/// By how much stops differ that differ in their last bits, in cycles and in world units.
const LAST_BITS: f64 = 1e-9;

/// The largest splash of a scene, in world units, and some more.
const SPLASH_MAX: f64 = 1.5;

/// The longest range of a scene, in world units.
const RANGE_MAX: f64 = 5.0;

impl Found {
    fn verdict(self) -> Verdict {
        if let Some(strange) = self.strange.into_iter().next() {
            return Verdict::Leak(strange);
        }
        match (self.lawful.first(), self.owing.into_iter().next()) {
            (Some(reason), _) => Verdict::Differs(reason),
            (None, Some(owing)) => Verdict::Leak(format!("nothing that may be known explains {owing}")),
            (None, None) => Verdict::Alike,
        }
    }
}

/// The bits of a motion: where it is at the start of a cycle, how fast, and, if it turned or stopped in the cycle before, where and when.
type Motion = ([u64; 4], Option<([u64; 3], Cycle)>);

/// Returns how somebody moves who was seen before the cycle and after it.
fn motion(was: &Sighting, it: &Sighting, cycle: Cycle) -> Motion {
    let (from, to) = (was.base.position(Cycle(cycle.0 - 1)), it.base.position(cycle));
    let (velocity, point) = (it.base.velocity, it.base.point);
    let goes_on = velocity == was.base.velocity && (to - from - velocity).length() < 1e-6;
    let turn = ([point.x, point.y, it.base.fraction].map(f64::to_bits), it.base.cycle);
    ([to.x, to.y, velocity.x, velocity.y].map(f64::to_bits), (!goes_on).then_some(turn))
}

/// Returns whether one of two who rested has set out by itself and the other otherwise or not, and nothing held it.
fn is_departure_of_one(ids: [ObjectId; 2], now: [&Sighting; 2], case: &Case<'_>) -> bool {
    let played = case.before[0].cycle;
    [0, 1].into_iter().all(|world| {
        let was = &case.before[world].all[&ids[world]];
        !was.base.is_moving() && now[world].stop.is_none()
    }) && now.iter().any(|it| it.base.is_moving() && it.base.cycle == played)
}

/// Returns where a motion is at a moment, whether it has begun by then or not.
fn at(base: &Base, moment: Moment) -> DVec2 {
    let cycles = f64::from(moment.cycle.0) - f64::from(base.cycle.0);
    base.point + base.velocity * (cycles + (moment.fraction - base.fraction))
}

/// The kind of a stop, without the number of who was in the way.
fn kind_of_stop(stop: Stop) -> u8 {
    match stop {
        Stop::Arrived => 0,
        Stop::Ordered => 1,
        Stop::Object(Some(_)) => 2,
        Stop::Object(None) => 3,
        Stop::Segment => 4,
        Stop::Edge => 5,
    }
}
