//! Getting somewhere: along a way, and with patience where others stand in it.

use std::collections::BTreeMap;

use glam::DVec2;
use maniple_view::{Command, Handle, View, Waypoint};

use super::ground::Ground;
use crate::keyed::{Purpose, fraction, keyed};
use crate::seeing::{Block, Item, nearest_point};

/// Most cycles that a unit waits after it was stopped, so that not all go on at once.
const WAIT_MAX: u64 = 4;

/// Farther than this from where it was told to go last, in world units, a unit has got on.
const PROGRESS: f64 = 2.0;

/// Most waypoints of an order; farther on the ground may have changed.
const WAYPOINTS: usize = 16;

/// Stops after which detours get no wider.
const DETOURS_MAX: u32 = 6;

/// How often a unit was stopped, and until when it waits.
#[derive(Clone, Copy, Debug)]
struct Trip {
    from: DVec2,
    tries: u32,
    wait_until: u32,
}

/// The patience of all units.
#[derive(Clone, Debug, Default)]
pub(super) struct Trips {
    seed: u64,
    trips: BTreeMap<Handle, Trip>,
}

/// What comes next for a unit that shall get somewhere.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Step {
    /// Wait.
    Wait,
    /// The way there is free: now do what it came for.
    Now,
    /// First go to a point aside, which can be gone to straight.
    Aside(DVec2),
    /// Go along the way.
    Along,
}

impl Trips {
    pub(super) fn new(seed: u64) -> Self {
        Self { seed, trips: BTreeMap::new() }
    }

    /// Forgets those that are gone.
    pub(super) fn keep(&mut self, is_there: impl Fn(Handle) -> bool) {
        self.trips.retain(|&object, _| is_there(object));
    }

    /// Returns what comes next for a unit that stands and shall get to `goal`; every other time that it was stopped near the
    /// same place it goes aside.
    pub(super) fn step(&mut self, ground: &mut Ground, view: &View, item: &Item<'_>, goal: &Block) -> Step {
        let (object, now) = (item.object, view.cycle().0);
        let fresh = Trip { from: item.center, tries: 0, wait_until: now };
        let trip = self.trips.entry(object).or_insert(fresh);
        if now < trip.wait_until {
            return Step::Wait;
        }
        if trip.from.distance(item.center) > PROGRESS {
            *trip = fresh;
        }
        let tries = trip.tries;
        trip.tries = tries.saturating_add(1);
        let wait = keyed(self.seed, view.cycle().0, object.0, Purpose::Wait) % WAIT_MAX;
        trip.wait_until = now + 1 + u32::try_from(wait).unwrap_or(0);
        if tries % 2 == 1
            && let Some(aside) = self.aside(ground, view, item, tries)
        {
            return Step::Aside(aside);
        }
        let radius = item.kind.shape.radius();
        let nearest = nearest_point(goal, item.center);
        if ground.is_clear(item.center, nearest, radius, Some(goal)) {
            return Step::Now;
        }
        let distances = ground.distances(goal);
        if ground.distance(item.center, &distances) == Some(0) { Step::Now } else { Step::Along }
    }

    /// Returns a point aside, the farther the more often it was stopped; `None` where chance hits none that is free.
    fn aside(&self, ground: &Ground, view: &View, item: &Item<'_>, tries: u32) -> Option<DVec2> {
        let reach = 0.5 + 0.5 * f64::from(tries.min(DETOURS_MAX));
        let chance = |purpose| 2.0 * fraction(keyed(self.seed, view.cycle().0, item.object.0, purpose)) - 1.0;
        let point = item.center + DVec2::new(chance(Purpose::DetourX), chance(Purpose::DetourY)) * reach;
        ground.is_clear(item.center, point, item.kind.shape.radius(), None).then_some(point)
    }

    /// Returns the points of the way to a goal, the last one within its tile.
    pub(super) fn way(&self, ground: &mut Ground, item: &Item<'_>, goal: &Block) -> Vec<DVec2> {
        let distances = ground.distances(goal);
        ground.way(item.center, &distances, item.kind.shape.radius())
    }
}

/// Returns the order to go along points.
pub(super) fn path(object: Handle, points: &[DVec2]) -> Option<Command> {
    let points: Vec<Waypoint> = points.iter().take(WAYPOINTS).map(|point| (point.x, point.y, None)).collect();
    (!points.is_empty()).then_some(Command::Path { object, points, start: None })
}
