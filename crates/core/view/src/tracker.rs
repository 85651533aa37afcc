//! Turns what a seat sees of the world into its deltas.

use std::collections::BTreeMap;

use maniple_geometry::{Cycle, ObjectId};
use serde::{Deserialize, Serialize};

use crate::base::{Base, DEVIATION_MAX, DEVIATION_SKINS_MAX};
use crate::delta::{Appeared, Changed, Delta, Ended, Moved, Shot, Stopped};
use crate::identity::{Handle, Seat, UnitTypeId};
use crate::outcome::{CommandResult, StopReason};
use crate::profile::Positions;
use crate::rules::Identity;
use crate::status::{EndOfTask, Own, Status, Task};
use crate::tile_set::TileSet;
use crate::vantage::Vantage;
use crate::view::View;

/// Why an object stopped, in the server's names.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Stop {
    /// It reached the end of its motions.
    Arrived,
    /// It was told to.
    Ordered,
    /// It collided with this object; `None`: with several at the same moment, of which nothing but their numbers would choose one.
    Object(Option<ObjectId>),
    /// It collided with a wall.
    Segment,
    /// It collided with the edge of the world.
    Edge,
}

/// An object that a seat sees at the end of a cycle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sighting {
    /// The object.
    pub object: ObjectId,
    /// Its type.
    pub unit_type: UnitTypeId,
    /// Whose it is; `None`: nobody's.
    pub owner: Option<Seat>,
    /// The layers it is in, as a mask; only orders newcomers that stand on the same point.
    pub layers: u32,
    /// Its true motion.
    pub base: Base,
    /// Why it stopped, where the last stop was in this cycle.
    pub stop: Option<Stop>,
    /// What is to be seen of it.
    pub status: Status,
    /// What only its owner knows.
    pub own: Own,
}

/// All that a seat notices at the end of a cycle.
#[derive(Clone, Copy, Debug, Default)]
pub struct Observation<'a> {
    /// All that it sees.
    pub sightings: &'a [Sighting],
    /// The tiles that are visible to it; `None`: there is no fog.
    pub visible: Option<&'a TileSet>,
    /// Tiles that it sees for the first time; see [`Delta::revealed`].
    pub revealed: &'a [(u32, u32, String)],
    /// Walls that it knows of for the first time; see [`Delta::walls`].
    pub walls: &'a [(f64, f64, f64, f64)],
    /// Who died in sight in the cycle.
    pub died: &'a [ObjectId],
    /// Who fired in the cycle, at whom; `None`: at a point.
    pub shots: &'a [(ObjectId, Option<ObjectId>)],
    /// Whose tasks ended in the cycle; those of other seats are left out.
    pub ended: &'a [(ObjectId, Task, EndOfTask)],
    /// Resources of the seat.
    pub stock: u32,
}

/// What the server remembers of an object in a seat's view.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Tracked {
    pub(crate) handle: Handle,
    /// Its true motion when it was last seen.
    pub(crate) truth: Base,
    /// The base in the view.
    pub(crate) told: Base,
    pub(crate) status: Status,
    pub(crate) own: Own,
    pub(crate) is_own: bool,
}

/// Who looks, and how closely.
#[derive(Clone, Copy, Debug)]
struct Eyes {
    vantage: Vantage,
    /// World units.
    deviation_max: f64,
    positions: Positions,
    identity: Identity,
}

/// The server's side of one view: gives handles, and turns sightings into deltas.
///
/// Nothing but the seat's own sightings goes in, so nothing else can come out. Of objects of other seats it tells only
/// what is to be seen: an order that keeps to its line and speed starts a new motion in the world, and none in the view.
#[derive(Debug)]
pub struct Tracker {
    eyes: Eyes,
    pub(crate) next_handle: u32,
    pub(crate) tracked: BTreeMap<ObjectId, Tracked>,
    /// The objects in the view.
    pub(crate) seen: BTreeMap<Handle, ObjectId>,
    /// Those of them that are the seat's: a map of their own, so that a handle of another's object is looked for as one that never was,
    /// with the same steps.
    pub(crate) owned: BTreeMap<Handle, ObjectId>,
    /// The handles of those that went out of sight, where they will be known again.
    pub(crate) remembered: BTreeMap<ObjectId, Handle>,
    pub(crate) view: View,
}

impl Tracker {
    /// Returns the tracker of a seat, or of all there is, that has seen nothing yet, with the view that its client starts with too, in
    /// a world from whose limits this skin follows, in world units.
    #[must_use]
    pub fn new(vantage: impl Into<Vantage>, skin: f64, positions: Positions, view: View) -> Self {
        let unseen = DEVIATION_SKINS_MAX * skin;
        let unseen = if unseen < DEVIATION_MAX { unseen } else { DEVIATION_MAX };
        Self {
            eyes: Eyes {
                vantage: vantage.into(),
                deviation_max: unseen + positions.step(),
                positions,
                identity: Identity::Fresh,
            },
            next_handle: 0,
            tracked: BTreeMap::new(),
            seen: BTreeMap::new(),
            owned: BTreeMap::new(),
            remembered: BTreeMap::new(),
            view,
        }
    }

    /// Returns it with another rule for those who come back into sight than [`Identity::Fresh`].
    #[must_use]
    pub fn with_identity(mut self, identity: Identity) -> Self {
        self.eyes.identity = identity;
        self
    }

    /// Takes all that the seat notices at the start of `cycle`; returns the delta.
    pub fn update(
        &mut self,
        cycle: Cycle,
        observation: Observation<'_>,
        results: Vec<CommandResult>,
    ) -> Delta {
        let Observation { sightings, visible, revealed, walls, died, shots, ended, stock } = observation;
        let mut delta = Delta { cycle, results, ..Delta::default() };
        delta.sight = self.view.changes_of_sight(visible);
        delta.revealed = revealed.to_vec();
        delta.walls = walls.to_vec();
        delta.stock = (stock != self.view.stock()).then_some(stock);
        self.forget(sightings, died, &mut delta);
        self.appear(cycle, sightings, &mut delta);
        for sighting in sightings {
            self.follow(cycle, sighting, &mut delta);
        }
        self.hear(shots, ended, &mut delta);
        delta.moved.sort_by_key(|moved| moved.object);
        delta.stopped.sort_by_key(|stopped| stopped.object);
        delta.changed.sort_by_key(|changed| changed.object);
        let applied = self.view.apply_unchecked(&delta);
        assert_eq!(applied, Ok(()), "a tracker's delta fits its own view");
        delta.check = self.view.check();
        delta
    }

    /// Returns the delta that turns an empty view into this one.
    #[must_use]
    pub fn keyframe(&self) -> Delta {
        self.view.keyframe()
    }

    /// Returns the object of the seat with this handle; `None` for all others, whatever the reason.
    #[must_use]
    pub fn own(&self, handle: Handle) -> Option<ObjectId> {
        self.owned.get(&handle).copied()
    }

    /// Returns the object in the view with this handle; `None` where it holds none.
    #[must_use]
    pub fn seen(&self, handle: Handle) -> Option<ObjectId> {
        self.seen.get(&handle).copied()
    }

    /// Returns the view.
    #[must_use]
    pub fn view(&self) -> &View {
        &self.view
    }

    /// Returns whether what only the owner knows of an object is in the view.
    pub(crate) fn owns(&self, owner: Option<Seat>) -> bool {
        self.eyes.vantage.owns(owner)
    }

    fn forget(&mut self, sightings: &[Sighting], died: &[ObjectId], delta: &mut Delta) {
        let mut in_sight: Vec<ObjectId> = sightings.iter().map(|sighting| sighting.object).collect();
        in_sight.sort_unstable();
        let gone: Vec<ObjectId> =
            self.tracked.keys().filter(|object| in_sight.binary_search(object).is_err()).copied().collect();
        for object in gone {
            let Some(tracked) = self.tracked.remove(&object) else { continue };
            self.seen.remove(&tracked.handle);
            self.owned.remove(&tracked.handle);
            if died.contains(&object) {
                delta.died.push(tracked.handle);
                continue;
            }
            delta.vanished.push(tracked.handle);
            if self.eyes.identity == Identity::Persistent {
                self.remembered.insert(object, tracked.handle);
            }
        }
        delta.died.sort_unstable();
        delta.vanished.sort_unstable();
    }

    /// Newcomers get their handles in the order of (y, x, layers), which says nothing but what is seen. On a grid, too, it is
    /// their true place that counts: several may share a point of the grid, and then only who they are could order them.
    fn appear(&mut self, cycle: Cycle, sightings: &[Sighting], delta: &mut Delta) {
        let mut newcomers: Vec<(&Sighting, Base)> = sightings
            .iter()
            .filter(|sighting| !self.tracked.contains_key(&sighting.object))
            .map(|sighting| (sighting, sighting.base.refreshed(cycle)))
            .collect();
        newcomers.sort_by(|(a, base_a), (b, base_b)| {
            (base_a.point.y.total_cmp(&base_b.point.y))
                .then(base_a.point.x.total_cmp(&base_b.point.x))
                .then(a.layers.cmp(&b.layers))
        });
        for (sighting, base) in newcomers {
            let base = self.eyes.positions.rounded(base);
            let handle = self.remembered.remove(&sighting.object).unwrap_or_else(|| {
                let handle = Handle(self.next_handle);
                self.next_handle += 1;
                handle
            });
            let own = self.eyes.vantage.owns(sighting.owner);
            self.seen.insert(handle, sighting.object);
            if own {
                self.owned.insert(handle, sighting.object);
            }
            let Sighting { status, own: known, .. } = *sighting;
            let tracked =
                Tracked { handle, truth: sighting.base, told: base, status, own: known, is_own: own };
            self.tracked.insert(sighting.object, tracked);
            delta.appeared.push(Appeared {
                object: handle,
                unit_type: sighting.unit_type,
                owner: sighting.owner,
                base,
                status,
                own: own.then_some(known),
            });
        }
        delta.appeared.sort_by_key(|appeared| appeared.object);
    }

    /// Newcomers are up to date already, so nothing differs for them.
    fn follow(&mut self, cycle: Cycle, sighting: &Sighting, delta: &mut Delta) {
        let own = self.eyes.vantage.owns(sighting.owner);
        let other = match sighting.stop {
            Some(Stop::Object(Some(other))) => self.tracked.get(&other).map(|tracked| tracked.handle),
            Some(Stop::Object(None) | Stop::Arrived | Stop::Ordered | Stop::Segment | Stop::Edge) | None => {
                None
            }
        };
        let Some(tracked) = self.tracked.get_mut(&sighting.object) else { return };
        let object = tracked.handle;
        if let Some(base) = tracked.news(cycle, sighting, &self.eyes) {
            tracked.told = base;
            if sighting.base.is_moving() {
                delta.moved.push(Moved { object, base });
            } else {
                let Base { point, cycle, fraction, .. } = base;
                let reason = if own { sighting.stop.map(|stop| told(stop, other)) } else { None };
                delta.stopped.push(Stopped { object, point, cycle, fraction, reason });
            }
        }
        tracked.truth = sighting.base;
        let status = (tracked.status != sighting.status).then_some(sighting.status);
        let known = (own && tracked.own != sighting.own).then_some(sighting.own);
        if status.is_some() || known.is_some() {
            (tracked.status, tracked.own) = (sighting.status, sighting.own);
            delta.changed.push(Changed { object, status, own: known });
        }
    }

    /// Tells of shots of those in sight, and of the tasks of the seat's own objects.
    fn hear(
        &self,
        shots: &[(ObjectId, Option<ObjectId>)],
        ended: &[(ObjectId, Task, EndOfTask)],
        delta: &mut Delta,
    ) {
        let handle = |object: &ObjectId| self.tracked.get(object).map(|tracked| tracked.handle);
        for (shooter, target) in shots {
            let Some(object) = handle(shooter) else { continue };
            delta.shots.push(Shot { object, target: target.as_ref().and_then(handle) });
        }
        let is_own = |object: &ObjectId| self.tracked.get(object).is_some_and(|tracked| tracked.is_own);
        for (object, task, why) in ended.iter().filter(|(object, ..)| is_own(object)) {
            let Some(object) = handle(object) else { continue };
            delta.ended.push(Ended { object, task: *task, why: *why });
        }
        delta.shots.sort_by_key(|shot| shot.object);
        delta.ended.sort_by_key(|ended| ended.object);
    }
}

impl Tracked {
    /// Returns the base that the seat has to be told of; `None` while the one in its view does.
    ///
    /// A seat gave the orders of its own objects, so it is told of every new motion. Of others it is told where the
    /// view would show something else. If that is not because of an event in the last cycle but has added up, the base
    /// is a fresh one: when the motion began is not to be seen.
    fn news(&self, cycle: Cycle, sighting: &Sighting, eyes: &Eyes) -> Option<Base> {
        let truth = sighting.base;
        let is_new = truth != self.truth;
        match eyes.positions {
            Positions::Exact if eyes.vantage.owns(sighting.owner) => is_new.then_some(truth),
            Positions::Exact => {
                let holds = self.told == truth || self.told.predicts(&truth, cycle, eyes.deviation_max);
                (!holds).then_some(if is_new { truth } else { truth.refreshed(cycle) })
            }
            Positions::Grid { .. } => {
                let is_told = is_new && eyes.vantage.owns(sighting.owner);
                (is_told || !self.holds_on_grid(&truth, cycle, eyes)).then(|| on_grid(&truth, cycle, eyes))
            }
        }
    }

    /// Returns whether the base in the view still does on a grid: it is never more than a step of the grid off, and who
    /// rests is where the grid has it.
    fn holds_on_grid(&self, truth: &Base, cycle: Cycle, eyes: &Eyes) -> bool {
        if truth.is_moving() {
            self.told.stays_near(truth, cycle, eyes.deviation_max)
        } else {
            !self.told.is_moving() && self.told.point == on_grid(truth, cycle, eyes).point
        }
    }
}

/// Returns what is told of a base on a grid: of who moves that of the present cycle, which has no fraction to be told.
fn on_grid(truth: &Base, cycle: Cycle, eyes: &Eyes) -> Base {
    let base = if truth.is_moving() { truth.refreshed(cycle) } else { *truth };
    eyes.positions.rounded(base)
}

fn told(stop: Stop, other: Option<Handle>) -> StopReason {
    match stop {
        Stop::Arrived => StopReason::Arrived,
        Stop::Ordered => StopReason::Ordered,
        Stop::Object(_) => StopReason::Object { other },
        Stop::Segment => StopReason::Segment,
        Stop::Edge => StopReason::Edge,
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec2;

    use super::*;

    const SKIN: f64 = 1.0 / (1u64 << 40) as f64;

    #[test]
    fn on_a_grid_a_view_is_never_more_than_a_step_off_and_a_stop_is_where_the_grid_has_it() {
        for (bits, owner) in [(0, 0), (4, 1), (10, 0), (10, 1), (20, 1)] {
            let grid = Positions::Grid { bits };
            let (mut tracker, mut client) =
                (Tracker::new(Seat(0), SKIN, grid, View::default()), View::default());
            let moving = base(DVec2::new(1.3, 1.7), 2, 0.3, DVec2::new(0.321_987, 0.077_123));
            let rest =
                Base { velocity: DVec2::ZERO, ..base(moving.position(Cycle(340)), 339, 0.7, DVec2::ZERO) };
            let mut told = 0;
            for cycle in 0..400 {
                let truth = match cycle {
                    0..3 => base(DVec2::new(1.3, 1.7), 0, 0.0, DVec2::ZERO),
                    3..340 => moving,
                    _ => rest,
                };
                let delta = tracker.update(Cycle(cycle), seeing(&[sighting(Seat(owner), truth)]), vec![]);
                told += delta.moved.len() + delta.stopped.len();
                client.apply(&delta).unwrap();
                let seen = client.position(Handle(0)).unwrap();
                let aside = seen.distance(truth.position(Cycle(cycle)));
                assert!(aside <= grid.step() + 1e-6, "{bits} bits, cycle {cycle}: {aside}");
                for base in delta.moved.iter().map(|moved| moved.base) {
                    assert_eq!((grid.rounded(base), base.fraction, base.cycle), (base, 0.0, Cycle(cycle)));
                }
                if cycle >= 340 {
                    assert_eq!(seen, grid.rounded(rest).point);
                }
            }
            println!("{bits} bits: told {told} times in 340 cycles");
            assert!((2..=7).contains(&told), "{bits} bits: told {told} times");
        }
    }

    #[test]
    fn newcomers_on_one_point_of_the_grid_are_told_alike_whoever_is_where() {
        let told = |swapped: bool| {
            let mut tracker = Tracker::new(Seat(0), SKIN, Positions::Grid { bits: 0 }, View::default());
            let speeds = [0.25, 0.5].map(|speed| DVec2::new(speed, 0.0));
            let one = sighting(Seat(1), base(DVec2::new(2.1, 3.1), 0, 0.0, speeds[0]));
            let other = sighting(Seat(1), base(DVec2::new(1.6, 3.2), 0, 0.0, speeds[1]));
            let mut sightings = if swapped { [other, one] } else { [one, other] };
            sightings[1].object = ObjectId(sightings[0].object.0 + 1);
            tracker.update(Cycle(0), seeing(&sightings), vec![]).appeared
        };
        assert_eq!(told(false), told(true));
        assert_eq!(told(false)[0].base.point, told(false)[1].base.point);
    }

    #[test]
    fn who_comes_back_has_a_fresh_handle_or_the_one_it_had() {
        for (identity, expected) in [
            (Identity::Fresh, [vec![0, 1], vec![2, 3], vec![4, 5]]),
            (Identity::Persistent, [vec![0, 1], vec![0, 2], vec![1, 3]]),
        ] {
            let tracker = Tracker::new(Seat(0), SKIN, Positions::Exact, View::default());
            let (mut tracker, mut client) = (tracker.with_identity(identity), View::default());
            let standing = |object: u32, y: f64| {
                let base = base(DVec2::new(1.0, y), 0, 0.0, DVec2::ZERO);
                Sighting { object: ObjectId(object), ..sighting(Seat(1), base) }
            };
            let mut appeared = Vec::new();
            // By number: 7 and 9 at first, then 7 and 3, who stands before it, then 9 and 7 again; but 7 has died.
            let scenes =
                [vec![standing(7, 1.0), standing(9, 2.0)], vec![], vec![standing(3, 0.5), standing(7, 1.0)]];
            let rest = [vec![], vec![standing(9, 2.0), standing(10, 3.0)]];
            for (cycle, sightings) in (0..).zip(scenes.iter().chain(&rest)) {
                let died = if cycle == 3 { [ObjectId(7)].as_slice() } else { &[] };
                let observation = Observation { died, ..seeing(sightings) };
                let delta = tracker.update(Cycle(cycle), observation, vec![]);
                client.apply(&delta).unwrap();
                assert_eq!(&client, tracker.view());
                if !delta.appeared.is_empty() {
                    appeared.push(delta.appeared.iter().map(|new| new.object.0).collect::<Vec<u32>>());
                }
            }
            assert_eq!(appeared, expected, "{identity:?}");
        }
    }

    #[test]
    fn a_handle_of_anothers_object_is_looked_for_as_one_that_never_was() {
        let mut tracker = Tracker::new(Seat(0), SKIN, Positions::Exact, View::default());
        let at = |object, owner, y| Sighting {
            object: ObjectId(object),
            ..sighting(Seat(owner), base(DVec2::new(1.0, y), 0, 0.0, DVec2::ZERO))
        };
        // Own, another's, another's that goes out of sight, own that dies.
        let all = [at(9, 0, 1.0), at(8, 1, 2.0), at(7, 1, 3.0), at(6, 0, 4.0)];
        tracker.update(Cycle(0), seeing(&all), vec![]);
        let died = [ObjectId(6)];
        tracker.update(Cycle(1), Observation { died: &died, ..seeing(&all[..2]) }, vec![]);
        let found: Vec<_> = (0..6).map(|handle| tracker.own(Handle(handle))).collect();
        assert_eq!(found, [Some(ObjectId(9)), None, None, None, None, None]);
        let found: Vec<_> = (0..6).map(|handle| tracker.seen(Handle(handle))).collect();
        assert_eq!(found, [Some(ObjectId(9)), Some(ObjectId(8)), None, None, None, None]);
        // One search each, in maps that hold nothing but what is found: there is no other step that could tell them apart.
        assert_eq!(tracker.owned.keys().collect::<Vec<_>>(), [&Handle(0)]);
        assert_eq!(tracker.seen.keys().collect::<Vec<_>>(), [&Handle(0), &Handle(1)]);
    }

    #[test]
    fn a_crawler_on_a_grid_is_told_of_when_it_has_come_a_step_further() {
        let grid = Positions::Grid { bits: 2 };
        let (mut tracker, mut client) = (Tracker::new(Seat(0), SKIN, grid, View::default()), View::default());
        let crawling = base(DVec2::new(1.0, 1.0), 0, 0.0, DVec2::new(0.0004, 0.0));
        let mut told = 0;
        for cycle in 0..4000 {
            let delta = tracker.update(Cycle(cycle), seeing(&[sighting(Seat(1), crawling)]), vec![]);
            client.apply(&delta).unwrap();
            told += delta.moved.len();
            assert!(delta.stopped.is_empty());
        }
        assert!((6..=7).contains(&told), "{told}");
        assert_eq!(client.position(Handle(0)).unwrap().x % 0.25, 0.0);
    }

    #[test]
    fn a_deviation_that_adds_up_is_told_by_a_fresh_base_before_it_is_too_large() {
        let deviation_max = DEVIATION_SKINS_MAX * SKIN;
        let old = base(DVec2::new(1.0, 1.0), 0, 0.0, DVec2::new(0.5, 0.25));
        let point = old.point + old.velocity * 4.5;
        let new = base(point, 4, 0.5, old.velocity + DVec2::new(deviation_max / 10.0, 0.0));
        let (mut tracker, mut client) =
            (Tracker::new(Seat(0), SKIN, Positions::Exact, View::default()), View::default());
        let mut told = Vec::new();
        for cycle in 1..40 {
            let truth = if cycle < 5 { old } else { new };
            let delta = tracker.update(Cycle(cycle), seeing(&[sighting(Seat(1), truth)]), vec![]);
            client.apply(&delta).unwrap();
            assert_eq!(&client, tracker.view());
            let aside = client.position(Handle(0)).unwrap().distance(truth.position(Cycle(cycle)));
            assert!(aside <= deviation_max, "cycle {cycle}: {aside}");
            for moved in delta.moved {
                assert_eq!(moved.base, new.refreshed(Cycle(cycle)));
                told.push(cycle);
            }
        }
        // The new motion began half a cycle before cycle 5, so ten of its cycles are over after cycle 14.
        assert_eq!(told, [14]);
    }

    #[test]
    fn a_seat_is_told_of_each_motion_of_its_own_and_of_others_only_where_it_shows() {
        let old = base(DVec2::new(1.0, 1.0), 0, 0.0, DVec2::X);
        let renewed = base(DVec2::new(3.5, 1.0), 2, 0.5, DVec2::X);
        let at_rest = base(DVec2::new(2.0, 2.0), 1, 0.0, DVec2::ZERO);
        let bumped = base(DVec2::new(2.0, 2.0), 2, 0.25, DVec2::ZERO);
        for (owner, expected) in [(Seat(0), (1, 1)), (Seat(1), (0, 0))] {
            let mut told = (0, 0);
            for (before, after) in [(old, renewed), (at_rest, bumped)] {
                let mut tracker = Tracker::new(Seat(0), SKIN, Positions::Exact, View::default());
                tracker.update(Cycle(2), seeing(&[sighting(owner, before)]), vec![]);
                let delta = tracker.update(Cycle(3), seeing(&[sighting(owner, after)]), vec![]);
                told.0 += delta.moved.len();
                told.1 += delta.stopped.len();
            }
            assert_eq!(told, expected, "{owner}");
        }
    }

    fn base(point: DVec2, cycle: u32, fraction: f64, velocity: DVec2) -> Base {
        Base { point, cycle: Cycle(cycle), fraction, velocity }
    }

    fn seeing(sightings: &[Sighting]) -> Observation<'_> {
        Observation { sightings, ..Observation::default() }
    }

    fn sighting(owner: Seat, base: Base) -> Sighting {
        Sighting {
            object: ObjectId(7),
            unit_type: UnitTypeId(0),
            owner: Some(owner),
            layers: 1,
            base,
            stop: None,
            status: Status::default(),
            own: Own::default(),
        }
    }
}
