//! The kinematic world: who is where.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use maniple_geometry::predicate::{circle_overlaps_segment, circles_overlap};
use maniple_geometry::{Circle, Cycle, Limits, Moment, Motion, ObjectId, Planar, Scalar};

use crate::bands::Bands;
use crate::batch::Batch;
use crate::components::Components;
use crate::cycle::Tidying;
use crate::error::{InsertError, OrderError, Overlap, WallError};
use crate::event::Event;
use crate::graph::Graph;
use crate::objects::Objects;
use crate::outcome::EventSorter;
use crate::resting::Resting;
use crate::settings::{Method, Settings};
use crate::solve::Solver;
use crate::state::{NO_QUEUE, Phase, State};
use crate::wall::{Layers, Wall, WallId};
use crate::walls::Walls;

/// Fewer active objects than this are not worth more than one thread.
const ACTIVE_A_THREAD_MIN: usize = 2048;

/// Circles that go straight, and walls; whoever would overlap something stops.
///
/// The state between two cycles: [`World::step`] takes it from the start of a cycle to its end.
#[derive(Clone, Debug)]
pub struct World<S: Scalar = f64> {
    pub(crate) limits: Limits,
    pub(crate) skin: S,
    pub(crate) settings: Settings,
    pub(crate) cycle: Cycle,
    pub(crate) digest: u64,
    pub(crate) objects: Objects<S>,
    pub(crate) walls: Walls<S>,
    pub(crate) resting: Resting,
    /// Whether there are objects or walls with different layers; else layers are not looked at.
    pub(crate) is_layered: bool,
    layers: Option<Layers>,
    /// Objects at rest that begin something by themselves in a cycle to come; some may have changed since.
    pub(crate) alarms: BinaryHeap<Reverse<(u32, u32)>>,
    /// Objects that are going to be active from the next cycle on.
    pub(crate) fresh: Vec<u32>,
    pub(crate) batches: Vec<Batch<S>>,
    pub(crate) bands: Bands<S>,
    pub(crate) graphs: Vec<Graph<S>>,
    pub(crate) components: Components<S>,
    pub(crate) solvers: Vec<Solver<S>>,
    pub(crate) events: Vec<Event>,
    pub(crate) event_sorter: EventSorter,
    pub(crate) activity: Activity,
    /// The cycle in which the objects are put into order again.
    pub(crate) tidy_at: u32,
    pub(crate) tidying: Tidying,
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
    /// Returns a world without objects, at cycle 0; the walls are numbered in their order, from 0 on.
    ///
    /// # Errors
    /// A wall with a coordinate that is out of the limits, or without length.
    ///
    /// # Panics
    /// With a skin that is negative or no number, or no substeps.
    pub fn new(limits: Limits, settings: impl Into<Settings>, walls: &[Wall<S>]) -> Result<Self, WallError> {
        let settings: Settings = settings.into();
        assert!(settings.skin.is_none_or(|skin| skin >= 0.0 && skin.is_finite()), "a skin is a length");
        assert!(settings.method != Method::Stepped { substeps: 0 }, "a cycle has at least one substep");
        let needed: S = limits.skin();
        let skin = settings.skin.map_or(needed, S::from_f64);
        // Spheres have to take in the rounding, however thin the skin is.
        let widest = skin.greater(needed);
        let mut world = Self {
            limits,
            skin,
            settings,
            cycle: Cycle(0),
            digest: 0,
            objects: Objects::new(widest + widest),
            walls: Walls::new(),
            resting: Resting::default(),
            is_layered: false,
            layers: None,
            alarms: BinaryHeap::new(),
            fresh: Vec::new(),
            batches: vec![Batch::new()],
            bands: Bands::new(),
            graphs: Vec::new(),
            components: Components::new(),
            solvers: Vec::new(),
            events: Vec::new(),
            event_sorter: EventSorter::default(),
            activity: Activity::default(),
            tidy_at: 1,
            tidying: Tidying::default(),
        };
        for (index, wall) in walls.iter().enumerate() {
            check_wall(&limits, index, wall)?;
            world.note_layers(wall.layers);
            world.walls.insert(*wall);
        }
        Ok(world)
    }

    /// Takes memory for so many objects, so that none is taken later.
    pub fn reserve(&mut self, objects: usize) {
        self.objects.reserve(objects);
    }

    /// Puts an object at rest into the world.
    ///
    /// # Errors
    /// A number out of the limits, an id that is taken, or a place that is.
    pub fn insert(&mut self, id: ObjectId, circle: Circle<S>, layers: Layers) -> Result<(), InsertError> {
        let bad = |(field, problem)| InsertError::BadNumber { field, problem };
        self.limits.check_point(circle.center.to_dvec2()).map_err(bad)?;
        self.limits.check_radius(circle.radius.to_f64()).map_err(|problem| bad(("r", problem)))?;
        if self.objects.slot(id).is_some() {
            return Err(InsertError::DuplicateId);
        }
        self.check_place(circle, layers, None)?;
        self.note_layers(layers);
        let state = State::at_rest(circle.center, Moment::start_of(self.cycle), circle.radius);
        let slot = self.objects.insert(id, state, layers);
        self.resting.insert(slot, &self.objects.states);
        Ok(())
    }

    /// Takes an object out of the world.
    ///
    /// # Errors
    /// [`OrderError::UnknownObject`].
    pub fn remove(&mut self, id: ObjectId) -> Result<(), OrderError> {
        let slot = self.objects.slot(id).ok_or(OrderError::UnknownObject)?;
        let phase = self.objects.states[slot as usize].phase;
        if matches!(phase, Phase::Resting | Phase::Fresh) {
            self.resting.remove(slot, &self.objects.states);
        }
        self.objects.remove(slot);
        if phase == Phase::Resting {
            self.objects.vacate(slot);
        } else {
            self.objects.states[slot as usize].phase = Phase::Leaving;
        }
        Ok(())
    }

    /// Puts an object somewhere else, at rest; it forgets what it did.
    ///
    /// # Errors
    /// A number out of the limits, an unknown object, or a place that is taken.
    pub fn teleport(&mut self, id: ObjectId, center: S::Vector) -> Result<(), InsertError> {
        let bad = |(field, problem)| InsertError::BadNumber { field, problem };
        self.limits.check_point(center.to_dvec2()).map_err(bad)?;
        let slot = self.objects.slot(id).ok_or(InsertError::UnknownObject)?;
        let circle = Circle::new(center, self.objects.states[slot as usize].radius);
        self.check_place(circle, self.objects.layers[slot as usize], Some(slot))?;
        let phase = self.objects.states[slot as usize].phase;
        if matches!(phase, Phase::Resting | Phase::Fresh) {
            self.resting.remove(slot, &self.objects.states);
        }
        self.objects.set_at_rest(slot, center, Moment::start_of(self.cycle));
        self.objects.clear_queue(slot);
        self.objects.settle(slot, self.cycle);
        if phase == Phase::Active {
            self.objects.states[slot as usize].phase = Phase::Fresh;
            self.fresh.push(slot);
        }
        self.resting.insert(slot, &self.objects.states);
        Ok(())
    }

    /// Puts a wall into the world, from the next cycle on, and returns its number.
    ///
    /// # Errors
    /// A coordinate that is out of the limits, no length, or an object in the place.
    pub fn insert_wall(&mut self, wall: Wall<S>) -> Result<WallId, WallError> {
        check_wall(&self.limits, 0, &wall)?;
        let middle = (wall.segment.start.to_dvec2() + wall.segment.end.to_dvec2()) * 0.5;
        let half = wall.segment.length().to_f64() * 0.5 + self.objects.margin.to_f64();
        let mut blocking: Option<ObjectId> = None;
        self.visit_near(middle, half, |slot| {
            let state = &self.objects.states[slot as usize];
            let shares = self.objects.layers[slot as usize].share(wall.layers);
            if shares && circle_overlaps_segment(state.position(self.cycle), state.radius, &wall.segment) {
                let id = self.objects.intents[slot as usize].id;
                blocking = Some(blocking.map_or(id, |other| other.min(id)));
            }
        });
        if let Some(other) = blocking {
            return Err(WallError::OverlapsObject { other });
        }
        self.note_layers(wall.layers);
        Ok(WallId(self.walls.insert(wall)))
    }

    /// Takes a wall out of the world; `None` where there is none of this number.
    pub fn remove_wall(&mut self, id: WallId) -> Option<Wall<S>> {
        self.walls.remove(id.0)
    }

    /// Returns the cycle that comes next.
    #[must_use]
    pub fn cycle(&self) -> Cycle {
        self.cycle
    }

    /// Returns how many objects there are.
    #[must_use]
    pub fn len(&self) -> usize {
        self.objects.len()
    }

    /// Returns whether there are no objects.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.objects.len() == 0
    }

    /// Returns the objects, by id.
    #[must_use]
    pub fn ids(&self) -> Vec<ObjectId> {
        self.objects.ids()
    }

    /// Returns where an object is now; `None` for an unknown one.
    #[must_use]
    pub fn circle(&self, id: ObjectId) -> Option<Circle<S>> {
        let state = &self.objects.states[self.objects.slot(id)? as usize];
        Some(Circle::new(state.position(self.cycle), state.radius))
    }

    /// Returns the motion of an object; `None` for an unknown one.
    #[must_use]
    pub fn motion(&self, id: ObjectId) -> Option<Motion<S>> {
        self.objects.slot(id).map(|slot| self.objects.states[slot as usize].motion())
    }

    /// Returns how many legs wait behind the present one of an object; `None` for an unknown one.
    #[must_use]
    pub fn waypoints(&self, id: ObjectId) -> Option<usize> {
        self.objects.slot(id).map(|slot| self.objects.plan(slot).queue.len())
    }

    /// Returns whether nothing moves and nothing is going to.
    #[must_use]
    pub fn is_at_rest(&self) -> bool {
        let waits = |slot: u32| self.objects.intents[slot as usize].queue != NO_QUEUE;
        let rests = |slot: u32| {
            let state = &self.objects.states[slot as usize];
            state.phase == Phase::Leaving || (!state.is_moving() && !waits(slot))
        };
        let is_going_to = |&Reverse((_, slot)): &Reverse<(u32, u32)>| {
            self.objects.states[slot as usize].phase == Phase::Resting && waits(slot)
        };
        let active = self.batches.iter().flat_map(|batch| &batch.slots).chain(&self.fresh);
        active.copied().all(rests) && !self.alarms.iter().any(is_going_to)
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

    /// Returns how many objects the largest component of the last cycle had. Counts all, so it is slow.
    #[must_use]
    pub fn largest_component(&self) -> usize {
        self.components.largest()
    }

    /// Returns the memory that the world has taken, in bytes, queued waypoints apart.
    #[must_use]
    pub fn bytes(&self) -> usize {
        self.objects.bytes()
            + self.walls.bytes()
            + self.resting.bytes()
            + self.components.bytes()
            + size_of::<u32>() * self.fresh.capacity()
            + size_of::<Reverse<(u32, u32)>>() * self.alarms.capacity()
            + size_of::<Event>() * self.events.capacity()
            + self.event_sorter.bytes()
            + self.batches.iter().map(Batch::bytes).sum::<usize>()
            + self.bands.bytes()
            + self.graphs.iter().map(Graph::bytes).sum::<usize>()
            + self.solvers.iter().map(Solver::bytes).sum::<usize>()
    }

    /// Returns all overlaps, exactly: there never are any. Looks at every object, so it is slow.
    #[must_use]
    pub fn overlaps(&self) -> Vec<Overlap> {
        crate::audit::overlaps(&self.objects, &self.walls, self.cycle)
    }

    /// Puts an object into the list of the active from the next cycle on.
    pub(crate) fn activate(&mut self, slot: u32) {
        let state = &mut self.objects.states[slot as usize];
        if state.phase == Phase::Resting {
            state.phase = Phase::Fresh;
            self.fresh.push(slot);
            let batch = self.batches.iter_mut().min_by_key(|batch| batch.slots.len());
            batch.expect("there is always a batch").slots.push(slot);
        }
    }

    /// Returns how many threads the next cycle is worth.
    pub(crate) fn threads(&self) -> usize {
        let active: usize = self.batches.iter().map(|batch| batch.slots.len()).sum();
        rayon::current_num_threads().min(active / ACTIVE_A_THREAD_MIN).max(1)
    }

    /// Shares the active objects out to so many batches.
    pub(crate) fn share_out(&mut self, threads: usize) {
        if self.batches.len() == threads {
            return;
        }
        let slots: Vec<u32> = self.batches.iter().flat_map(|batch| &batch.slots).copied().collect();
        self.batches.resize_with(threads, Batch::new);
        for (batch, share) in self.batches.iter_mut().zip(slots.chunks(slots.len().div_ceil(threads).max(1)))
        {
            batch.slots.clear();
            batch.slots.extend_from_slice(share);
        }
    }

    /// Visits the slots of the objects that may be within `reach` of a point, some of them more than once.
    fn visit_near(&self, center: glam::DVec2, reach: f64, mut visit: impl FnMut(u32)) {
        self.resting.near(center, reach, &mut visit);
        let is_there = |slot: u32| self.objects.states[slot as usize].phase == Phase::Active;
        self.bands.near(center, reach, |slot| {
            if is_there(slot) {
                visit(slot);
            }
        });
    }

    pub(crate) fn note_layers(&mut self, layers: Layers) {
        self.is_layered |= *self.layers.get_or_insert(layers) != layers;
    }

    fn check_place(&self, circle: Circle<S>, layers: Layers, but: Option<u32>) -> Result<(), InsertError> {
        let (center, reach) = (circle.center.to_dvec2(), (circle.radius + self.objects.margin).to_f64());
        let mut overlapped: Option<ObjectId> = None;
        self.visit_near(center, reach, |slot| {
            let state = &self.objects.states[slot as usize];
            if but != Some(slot)
                && self.objects.layers[slot as usize].share(layers)
                && circles_overlap::<S>(
                    circle.center,
                    circle.radius,
                    state.position(self.cycle),
                    state.radius,
                )
            {
                let id = self.objects.intents[slot as usize].id;
                overlapped = Some(overlapped.map_or(id, |other| other.min(id)));
            }
        });
        if let Some(other) = overlapped {
            return Err(InsertError::OverlapsObject { other });
        }
        let mut blocking: Option<(f64, f64, f64, f64)> = None;
        self.walls.near(center, reach, |wall| {
            if wall.layers.share(layers)
                && circle_overlaps_segment(circle.center, circle.radius, &wall.segment)
            {
                let (start, end) = (wall.segment.start.to_dvec2(), wall.segment.end.to_dvec2());
                blocking = Some((start.x, start.y, end.x, end.y));
            }
        });
        blocking.map_or(Ok(()), |segment| Err(InsertError::OverlapsWall { segment }))
    }
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
