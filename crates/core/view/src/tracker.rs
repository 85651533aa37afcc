//! Turns what a seat sees of the world into its deltas.

use std::collections::BTreeMap;

use maniple_geometry::{Cycle, ObjectId};

use crate::base::Base;
use crate::delta::{Appeared, Changed, Delta, Moved, Stopped};
use crate::identity::{Handle, Seat, UnitTypeId};
use crate::outcome::{CommandResult, StopReason};
use crate::view::View;

/// Why an object stopped, in the server's names.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stop {
    /// It reached the end of its motions.
    Arrived,
    /// It was told to.
    Ordered,
    /// It collided with this object, or with others beside it.
    Object(ObjectId),
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
    /// Whose it is.
    pub owner: Seat,
    /// The layers it is in, as a mask; only orders newcomers that stand on the same point.
    pub layers: u32,
    /// Its true motion.
    pub base: Base,
    /// Why it stopped, where the last stop was in this cycle.
    pub stop: Option<Stop>,
    /// Motions that wait behind its present one.
    pub queued: u32,
}

/// What the server remembers of an object in a seat's view.
#[derive(Clone, Copy, Debug)]
struct Tracked {
    handle: Handle,
    /// The true base that the seat was told of or that lies behind a refreshed one.
    base: Base,
    queued: u32,
}

/// The server's side of one seat's view: gives handles, and turns sightings into deltas.
///
/// Nothing but the seat's own sightings goes in, so nothing else can come out.
#[derive(Debug)]
pub struct Tracker {
    seat: Seat,
    next_handle: u32,
    tracked: BTreeMap<ObjectId, Tracked>,
    own: BTreeMap<Handle, ObjectId>,
    view: View,
}

impl Tracker {
    /// Returns the tracker of a seat that has seen nothing yet.
    #[must_use]
    pub fn new(seat: Seat) -> Self {
        Self { seat, next_handle: 0, tracked: BTreeMap::new(), own: BTreeMap::new(), view: View::new() }
    }

    /// Takes all that the seat sees at the start of `cycle`, and who of the objects in its view died in sight;
    /// returns the delta.
    pub fn update(
        &mut self,
        cycle: Cycle,
        sightings: &[Sighting],
        died: &[ObjectId],
        results: Vec<CommandResult>,
    ) -> Delta {
        let mut delta = Delta { cycle, results, ..Delta::default() };
        self.forget(sightings, died, &mut delta);
        self.appear(cycle, sightings, &mut delta);
        for sighting in sightings {
            self.follow(sighting, &mut delta);
        }
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
        let appeared = |(object, seen): (Handle, &crate::view::Seen)| Appeared {
            object,
            unit_type: seen.unit_type,
            owner: seen.owner,
            base: seen.base,
            queued: seen.queued,
        };
        Delta {
            cycle: self.view.cycle(),
            appeared: self.view.objects().map(appeared).collect(),
            check: self.view.check(),
            ..Delta::default()
        }
    }

    /// Returns the object of the seat with this handle; `None` for all others, whatever the reason.
    #[must_use]
    pub fn own(&self, handle: Handle) -> Option<ObjectId> {
        self.own.get(&handle).copied()
    }

    /// Returns the view.
    #[must_use]
    pub fn view(&self) -> &View {
        &self.view
    }

    fn forget(&mut self, sightings: &[Sighting], died: &[ObjectId], delta: &mut Delta) {
        let mut in_sight: Vec<ObjectId> = sightings.iter().map(|sighting| sighting.object).collect();
        in_sight.sort_unstable();
        let gone: Vec<ObjectId> =
            self.tracked.keys().filter(|object| in_sight.binary_search(object).is_err()).copied().collect();
        for object in gone {
            let Some(tracked) = self.tracked.remove(&object) else { continue };
            self.own.remove(&tracked.handle);
            let list = if died.contains(&object) { &mut delta.died } else { &mut delta.vanished };
            list.push(tracked.handle);
        }
        delta.died.sort_unstable();
        delta.vanished.sort_unstable();
    }

    /// Newcomers get their handles in the order of (y, x, layers), which says nothing but what is seen.
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
            let handle = Handle(self.next_handle);
            self.next_handle += 1;
            let own = sighting.owner == self.seat;
            if own {
                self.own.insert(handle, sighting.object);
            }
            let tracked = Tracked { handle, base: sighting.base, queued: sighting.queued };
            self.tracked.insert(sighting.object, tracked);
            delta.appeared.push(Appeared {
                object: handle,
                unit_type: sighting.unit_type,
                owner: sighting.owner,
                base,
                queued: own.then_some(sighting.queued),
            });
        }
    }

    /// Newcomers are up to date already, so nothing differs for them.
    fn follow(&mut self, sighting: &Sighting, delta: &mut Delta) {
        let own = sighting.owner == self.seat;
        let other = match sighting.stop {
            Some(Stop::Object(other)) => self.tracked.get(&other).map(|tracked| tracked.handle),
            Some(Stop::Arrived | Stop::Ordered | Stop::Segment | Stop::Edge) | None => None,
        };
        let Some(tracked) = self.tracked.get_mut(&sighting.object) else { return };
        let object = tracked.handle;
        if tracked.base != sighting.base {
            tracked.base = sighting.base;
            if sighting.base.is_moving() {
                delta.moved.push(Moved { object, base: sighting.base });
            } else {
                let Base { point, cycle, fraction, .. } = sighting.base;
                let reason = if own { sighting.stop.map(|stop| told(stop, other)) } else { None };
                delta.stopped.push(Stopped { object, point, cycle, fraction, reason });
            }
        }
        if own && tracked.queued != sighting.queued {
            tracked.queued = sighting.queued;
            delta.changed.push(Changed { object, queued: sighting.queued });
        }
    }
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
