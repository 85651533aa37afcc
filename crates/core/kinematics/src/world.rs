//! The kinematic world: who is where, and who is told what.

use std::collections::{BTreeMap, BTreeSet};

use maniple_geometry::predicate::{circle_overlaps_segment, circles_overlap};
use maniple_geometry::{Circle, Cycle, Limits, Moment, Motion, NumberError, ObjectId, Planar, Scalar};

use crate::digest::object_hash;
use crate::error::{InsertError, OrderError, Overlap, WallError};
use crate::event::Event;
use crate::plan::{Leg, Placement, Plan, Planned, WAYPOINTS_MAX};
use crate::sectors::Sectors;
use crate::solve::Stops;
use crate::sphere::MotionSphere;
use crate::wall::{Layers, Wall};

/// Smallest edge of a sector, in world units: room for two circles of the usual size, whose radius is below half a
/// tile, and their motion in a cycle.
const SECTOR_EDGE_MIN: f64 = 2.0;

/// Circles that go straight, and walls; whoever would overlap something stops.
///
/// The state between two cycles: [`World::step`] takes it from the start of a cycle to its end.
#[derive(Clone, Debug)]
pub struct World<S: Scalar = f64> {
    pub(crate) limits: Limits,
    pub(crate) skin: S,
    pub(crate) stops: Stops,
    pub(crate) cycle: Cycle,
    pub(crate) digest: u64,
    /// Wrapping sum of one hash an object.
    pub(crate) sum: u64,
    pub(crate) walls: Vec<Wall<S>>,
    pub(crate) slots: BTreeMap<ObjectId, usize>,
    pub(crate) free: Vec<usize>,
    // One entry a slot:
    pub(crate) ids: Vec<ObjectId>,
    pub(crate) radii: Vec<S>,
    pub(crate) layers: Vec<Layers>,
    pub(crate) plans: Vec<Plan<S>>,
    pub(crate) hashes: Vec<u64>,
    /// Slots of the objects that move or are going to.
    pub(crate) active: BTreeSet<usize>,
    pub(crate) wall_sectors: Sectors<S>,
    /// The objects that do not move, by slot.
    pub(crate) resting: Sectors<S>,
    /// The runners of the cycle that is being solved, by place; empty between cycles.
    pub(crate) moving: Sectors<S>,
    pub(crate) events: Vec<Event>,
    pub(crate) activity: Activity,
}

/// What the last cycle had to do.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Activity {
    /// Objects that moved, or reached something without moving.
    pub runners: usize,
    /// Pairs of motion spheres that were tested.
    pub pairs_tested: usize,
    /// Components of the motion-sphere intersection graph.
    pub components: usize,
    /// How often an object was pulled back because rounding alone would have made it overlap.
    pub retreats: usize,
}

impl<S: Scalar> World<S> {
    /// Returns a world without objects, at cycle 0.
    ///
    /// # Errors
    /// A wall with a coordinate that is out of the limits, or without length.
    pub fn new(limits: Limits, stops: Stops, walls: &[Wall<S>]) -> Result<Self, WallError> {
        let bound = S::from_f64(limits.coordinate_max());
        let (mut low, mut high) = (S::Vector::new(bound, bound), S::Vector::new(-bound, -bound));
        for (index, wall) in walls.iter().enumerate() {
            check_wall(&limits, index, wall)?;
            for end in [wall.segment.start, wall.segment.end] {
                low = S::Vector::new(low.x().lesser(end.x()), low.y().lesser(end.y()));
                high = S::Vector::new(high.x().greater(end.x()), high.y().greater(end.y()));
            }
        }
        if walls.is_empty() {
            (low, high) = (high, low);
        }
        let sectors = Sectors::new(low, high, S::from_f64(SECTOR_EDGE_MIN));
        let mut wall_sectors = sectors.clone();
        for (number, wall) in (0u32..).zip(walls) {
            let (start, end) = (wall.segment.start, wall.segment.end);
            wall_sectors.insert_box(
                number,
                S::Vector::new(start.x().lesser(end.x()), start.y().lesser(end.y())),
                S::Vector::new(start.x().greater(end.x()), start.y().greater(end.y())),
            );
        }
        Ok(Self {
            limits,
            skin: limits.skin(),
            stops,
            cycle: Cycle(0),
            digest: 0,
            sum: 0,
            walls: walls.to_vec(),
            slots: BTreeMap::new(),
            free: Vec::new(),
            ids: Vec::new(),
            radii: Vec::new(),
            layers: Vec::new(),
            plans: Vec::new(),
            hashes: Vec::new(),
            active: BTreeSet::new(),
            wall_sectors,
            moving: sectors.clone(),
            resting: sectors,
            events: Vec::new(),
            activity: Activity::default(),
        })
    }

    /// Puts an object at rest into the world.
    ///
    /// # Errors
    /// A number out of the limits, an id that is taken, or a place that is.
    pub fn insert(&mut self, id: ObjectId, circle: Circle<S>, layers: Layers) -> Result<(), InsertError> {
        let bad = |(field, problem)| InsertError::BadNumber { field, problem };
        self.limits.check_point(circle.center.to_dvec2()).map_err(bad)?;
        self.limits.check_radius(circle.radius.to_f64()).map_err(|problem| bad(("r", problem)))?;
        if self.slots.contains_key(&id) {
            return Err(InsertError::DuplicateId);
        }
        self.check_place(circle, layers)?;
        let plan = Plan::at_rest(circle.center, Moment::start_of(self.cycle));
        let slot = self.claim(id, circle.radius, layers, plan);
        self.slots.insert(id, slot);
        self.resting.insert(number(slot), circle.center, circle.radius);
        self.rehash(slot);
        Ok(())
    }

    /// Takes an object out of the world.
    ///
    /// # Errors
    /// [`OrderError::UnknownObject`].
    pub fn remove(&mut self, id: ObjectId) -> Result<(), OrderError> {
        let slot = self.slots.remove(&id).ok_or(OrderError::UnknownObject)?;
        if !self.plans[slot].motion.is_moving() {
            self.resting.remove(number(slot), self.plans[slot].motion.start, self.radii[slot]);
        }
        self.active.remove(&slot);
        self.sum = self.sum.wrapping_sub(self.hashes[slot]);
        self.hashes[slot] = 0;
        self.plans[slot] = Plan::at_rest(S::Vector::zero(), Moment::start_of(self.cycle));
        self.free.push(slot);
        Ok(())
    }

    /// Lets an object go along legs, one after the other; taken as a whole or refused as a whole.
    ///
    /// With [`Placement::Replace`], what runs goes on until `start`, or ends now where there is none. With
    /// [`Placement::Queue`], the first leg begins at the later of `start` and the end of what is before it.
    ///
    /// # Errors
    /// An unknown object, a number out of the limits, a start before the present cycle, no leg, or more than
    /// [`WAYPOINTS_MAX`] waiting.
    pub fn go(
        &mut self,
        id: ObjectId,
        legs: &[Leg<S>],
        placement: Placement,
        start: Option<Moment>,
    ) -> Result<(), OrderError> {
        let slot = *self.slots.get(&id).ok_or(OrderError::UnknownObject)?;
        if legs.is_empty() {
            return Err(OrderError::EmptyPath);
        }
        for leg in legs {
            self.check_leg(leg)?;
        }
        self.check_start(start)?;
        let start = match placement {
            Placement::Replace => Some(start.unwrap_or(Moment::start_of(self.cycle))),
            Placement::Queue => start,
        };
        let kept = self.kept(slot, placement, start);
        if kept + legs.len() > WAYPOINTS_MAX {
            return Err(OrderError::TooManyWaypoints { max: WAYPOINTS_MAX });
        }
        let planned = legs.iter().enumerate().map(|(place, &leg)| match place {
            0 => Planned { leg: Some(leg), placement, start },
            _ => Planned { leg: Some(leg), placement: Placement::Queue, start: None },
        });
        self.plans[slot].extend(kept, planned);
        self.active.insert(slot);
        self.rehash(slot);
        Ok(())
    }

    /// Lets an object stop and forget what waits, at `start` or now; what runs goes on until then.
    ///
    /// # Errors
    /// An unknown object, a start that is no moment or lies before the present cycle, or a full queue.
    pub fn halt(&mut self, id: ObjectId, start: Option<Moment>) -> Result<(), OrderError> {
        let slot = *self.slots.get(&id).ok_or(OrderError::UnknownObject)?;
        self.check_start(start)?;
        let start = Some(start.unwrap_or(Moment::start_of(self.cycle)));
        let kept = self.kept(slot, Placement::Replace, start);
        if kept + 1 > WAYPOINTS_MAX {
            return Err(OrderError::TooManyWaypoints { max: WAYPOINTS_MAX });
        }
        let halt = Planned { leg: None, placement: Placement::Replace, start };
        self.plans[slot].extend(kept, std::iter::once(halt));
        self.active.insert(slot);
        self.rehash(slot);
        Ok(())
    }

    /// Returns the cycle that comes next.
    #[must_use]
    pub fn cycle(&self) -> Cycle {
        self.cycle
    }

    /// Returns the objects, by id.
    pub fn ids(&self) -> impl Iterator<Item = ObjectId> + '_ {
        self.slots.keys().copied()
    }

    /// Returns where an object is now; `None` for an unknown one.
    #[must_use]
    pub fn circle(&self, id: ObjectId) -> Option<Circle<S>> {
        let &slot = self.slots.get(&id)?;
        Some(Circle::new(self.position(slot), self.radii[slot]))
    }

    /// Returns the motion of an object; `None` for an unknown one.
    #[must_use]
    pub fn motion(&self, id: ObjectId) -> Option<Motion<S>> {
        self.slots.get(&id).map(|&slot| self.plans[slot].motion)
    }

    /// Returns how many legs wait behind the present one of an object; `None` for an unknown one.
    #[must_use]
    pub fn waypoints(&self, id: ObjectId) -> Option<usize> {
        self.slots.get(&id).map(|&slot| self.plans[slot].queue.len())
    }

    /// Returns whether nothing moves and nothing is going to.
    #[must_use]
    pub fn is_at_rest(&self) -> bool {
        self.active.is_empty()
    }

    /// Returns the limits that the world was made with.
    #[must_use]
    pub fn limits(&self) -> &Limits {
        &self.limits
    }

    /// Returns how far above touching a colliding circle stops, in world units.
    #[must_use]
    pub fn skin(&self) -> S {
        self.skin
    }

    /// Returns the state hash after the last cycle; 0 before the first. See [`crate::chained`].
    #[must_use]
    pub fn digest(&self) -> u64 {
        self.digest
    }

    /// Returns what the last cycle had to do.
    #[must_use]
    pub fn activity(&self) -> Activity {
        self.activity
    }

    /// Returns all overlaps, exactly: there never are any. Compares all pairs, so it is slow.
    #[must_use]
    pub fn overlaps(&self) -> Vec<Overlap> {
        let mut overlaps = Vec::new();
        let objects: Vec<(ObjectId, usize)> = self.slots.iter().map(|(&id, &slot)| (id, slot)).collect();
        for (place, &(id, slot)) in objects.iter().enumerate() {
            let (p, r) = (self.position(slot), self.radii[slot]);
            for &(other, with) in &objects[place + 1..] {
                let share = self.layers[slot].share(self.layers[with]);
                if share && circles_overlap::<S>(p, r, self.position(with), self.radii[with]) {
                    overlaps.push(Overlap::Objects(id, other));
                }
            }
            for (number, wall) in self.walls.iter().enumerate() {
                if self.layers[slot].share(wall.layers) && circle_overlaps_segment(p, r, &wall.segment) {
                    overlaps.push(Overlap::Wall(id, number));
                }
            }
        }
        overlaps
    }

    /// Where the object of a slot is now; flushed, like everything that is stored.
    pub(crate) fn position(&self, slot: usize) -> S::Vector {
        self.plans[slot].motion.position(self.cycle).flushed()
    }

    /// Brings the hash of a slot, and with it the sum, up to date.
    pub(crate) fn rehash(&mut self, slot: usize) {
        let hash = object_hash(self.ids[slot], (self.radii[slot], self.layers[slot]), &self.plans[slot]);
        self.sum = self.sum.wrapping_sub(self.hashes[slot]).wrapping_add(hash);
        self.hashes[slot] = hash;
    }

    fn claim(&mut self, id: ObjectId, radius: S, layers: Layers, plan: Plan<S>) -> usize {
        if let Some(slot) = self.free.pop() {
            self.ids[slot] = id;
            self.radii[slot] = radius;
            self.layers[slot] = layers;
            self.plans[slot] = plan;
            return slot;
        }
        self.ids.push(id);
        self.radii.push(radius);
        self.layers.push(layers);
        self.plans.push(plan);
        self.hashes.push(0);
        self.ids.len() - 1
    }

    fn kept(&self, slot: usize, placement: Placement, start: Option<Moment>) -> usize {
        let plan = &self.plans[slot];
        match (placement, start) {
            (Placement::Replace, Some(start)) => plan.kept_by(start, Moment::start_of(self.cycle)),
            (Placement::Replace, None) => 0,
            (Placement::Queue, _) => plan.queue.len(),
        }
    }

    fn check_leg(&self, leg: &Leg<S>) -> Result<(), OrderError> {
        let bad = |(field, problem)| OrderError::BadNumber { field, problem };
        self.limits.check_point(leg.goal.to_dvec2()).map_err(bad)?;
        let speed = leg.speed.to_f64();
        self.limits.check_speed(speed).map_err(|problem| bad(("s", problem)))?;
        if speed == 0.0 {
            return Err(bad(("s", NumberError::NotPositive(speed))));
        }
        Ok(())
    }

    fn check_start(&self, start: Option<Moment>) -> Result<(), OrderError> {
        let Some(start) = start else { return Ok(()) };
        let bad = |problem| OrderError::BadNumber { field: "start", problem };
        self.limits.check_fraction(start.fraction).map_err(bad)?;
        if start.cycle < self.cycle {
            return Err(OrderError::StartInPast { now: self.cycle });
        }
        Ok(())
    }

    fn check_place(&self, circle: Circle<S>, layers: Layers) -> Result<(), InsertError> {
        let place = MotionSphere { center: circle.center, radius: circle.radius };
        let near = self.resting.near(&place);
        let moving = self.active.iter().copied().filter(|&slot| self.plans[slot].motion.is_moving());
        let near = near.iter().map(|&slot| slot as usize).chain(moving);
        let overlapped = near.filter(|&slot| {
            self.layers[slot].share(layers)
                && circles_overlap::<S>(circle.center, circle.radius, self.position(slot), self.radii[slot])
        });
        if let Some(other) = overlapped.map(|slot| self.ids[slot]).min() {
            return Err(InsertError::OverlapsObject { other });
        }
        let blocking = self.wall_sectors.near(&place);
        let blocking = blocking.iter().map(|&number| &self.walls[number as usize]).find(|wall| {
            wall.layers.share(layers) && circle_overlaps_segment(circle.center, circle.radius, &wall.segment)
        });
        match blocking {
            Some(wall) => {
                let (start, end) = (wall.segment.start.to_dvec2(), wall.segment.end.to_dvec2());
                Err(InsertError::OverlapsWall { segment: (start.x, start.y, end.x, end.y) })
            }
            None => Ok(()),
        }
    }
}

/// A slot as the number that sectors hold.
pub(crate) fn number(slot: usize) -> u32 {
    u32::try_from(slot).expect("ids are 32 bits, so slots are")
}

fn check_wall<S: Scalar>(limits: &Limits, index: usize, wall: &Wall<S>) -> Result<(), WallError> {
    let (start, end) = (wall.segment.start.to_dvec2(), wall.segment.end.to_dvec2());
    for (field, value) in [("x1", start.x), ("y1", start.y), ("x2", end.x), ("y2", end.y)] {
        limits.check_coordinate(value).map_err(|problem| WallError::BadNumber { index, field, problem })?;
    }
    if start == end {
        return Err(WallError::NoLength { index, x: start.x, y: start.y });
    }
    Ok(())
}
