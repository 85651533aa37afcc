//! The active objects that one thread looks after, and their motion spheres.

use glam::DVec2;
use maniple_geometry::{Cycle, Planar, Scalar};

use crate::objects::Objects;
use crate::room::{component_room, keep_room, make_room};
use crate::sphere::MotionSphere;
use crate::state::{Phase, Tag};
use crate::track::{Stage, add_stages};

/// The active objects that one thread looks after.
#[derive(Clone, Debug)]
pub(crate) struct Batch<S: Scalar> {
    /// The slots; those at rest are dropped when a cycle begins.
    pub(crate) slots: Vec<u32>,
    /// For each slot whose track turns in the cycle, in their order, its place in the list.
    pub(crate) turning: Vec<u32>,
    /// For each slot the motion sphere of the cycle.
    pub(crate) spheres: Vec<MotionSphere>,
    /// For each sphere the number of its sector.
    pub(crate) sectors: Vec<u32>,
    /// Radius of the smallest and of the largest sphere.
    pub(crate) radii: (f32, f32),
    /// Slots that were dropped since their objects rest for the whole cycle.
    pub(crate) settled: Vec<u32>,
    /// Slots that were dropped since their objects were taken out.
    pub(crate) vacated: Vec<u32>,
    stages: Vec<Stage<S>>,
}

/// What is the same for all objects of a cycle.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Frame<S: Scalar> {
    pub(crate) cycle: Cycle,
    pub(crate) anchor: DVec2,
    /// By how much spheres are larger than needed: it takes in the skin, and the rounding of positions, which is far
    /// below it.
    pub(crate) margin: S,
}

impl<S: Scalar> Batch<S> {
    pub(crate) fn new() -> Self {
        Self {
            slots: Vec::new(),
            turning: Vec::new(),
            spheres: Vec::new(),
            sectors: Vec::new(),
            radii: (f32::INFINITY, 0.0),
            settled: Vec::new(),
            vacated: Vec::new(),
            stages: Vec::new(),
        }
    }

    /// Makes the spheres of the cycle, and drops who rests.
    pub(crate) fn gather(&mut self, objects: &Objects<S>, frame: Frame<S>) {
        self.clear_spheres();
        let mut kept = 0;
        for index in 0..self.slots.len() {
            let slot = self.slots[index];
            let state = &objects.states[slot as usize];
            if state.phase == Phase::Leaving {
                self.vacated.push(slot);
                continue;
            }
            let sphere = if state.turns_in(frame.cycle) {
                self.turning.push(u32::try_from(kept).expect("slots have 32 bits"));
                self.stages.clear();
                add_stages(&objects.plan(slot), frame.cycle, &mut self.stages);
                MotionSphere::around(&self.stages, state.radius, frame.margin, frame.anchor)
            } else if state.is_moving() {
                let center = state.position(frame.cycle).to_dvec2() + state.velocity.to_dvec2() * 0.5;
                MotionSphere::outward(center - frame.anchor, state.reach)
            } else {
                self.settled.push(slot);
                continue;
            };
            self.slots[kept] = slot;
            kept += 1;
            self.add_sphere(sphere);
        }
        self.slots.truncate(kept);
        keep_room(&mut self.slots);
        keep_room(&mut self.spheres);
        make_room(&mut self.turning, component_room(kept));
        make_room(&mut self.stages, component_room(kept));
    }

    /// Drops the spheres, but not the slots.
    pub(crate) fn clear_spheres(&mut self) {
        self.spheres.clear();
        self.turning.clear();
        self.radii = (f32::INFINITY, 0.0);
    }

    /// Adds the sphere of the next slot.
    #[inline]
    pub(crate) fn add_sphere(&mut self, sphere: MotionSphere) {
        self.spheres.push(sphere);
        if sphere.radius < self.radii.0 {
            self.radii.0 = sphere.radius;
        }
        if sphere.radius > self.radii.1 {
            self.radii.1 = sphere.radius;
        }
    }

    /// Notes the sector of each sphere.
    pub(crate) fn find_sectors(&mut self, sector: impl Fn(&MotionSphere) -> u32) {
        self.sectors.clear();
        self.sectors.extend(self.spheres.iter().map(sector));
    }

    /// Returns the spheres with the tags of their objects.
    #[inline]
    pub(crate) fn tagged(&self) -> impl Iterator<Item = (&MotionSphere, Tag)> {
        let mut turning = self.turning.iter().copied().peekable();
        (0u32..).zip(self.spheres.iter().zip(&self.slots)).map(move |(place, (sphere, &slot))| {
            (sphere, Tag::new(slot, turning.next_if_eq(&place).is_some()))
        })
    }

    /// Bytes on the heap.
    pub(crate) fn bytes(&self) -> usize {
        let slots = self.slots.capacity()
            + self.turning.capacity()
            + self.sectors.capacity()
            + self.settled.capacity()
            + self.vacated.capacity();
        size_of::<u32>() * slots
            + size_of::<MotionSphere>() * self.spheres.capacity()
            + size_of::<Stage<S>>() * self.stages.capacity()
    }
}
