//! Paths: from any point to any other, in straight legs.

use glam::DVec2;

use crate::error::{PlanError, Which};
use crate::field::Field;
use crate::ground::Ground;
use crate::jump::Search;
use crate::pull::pull;
use crate::taut::Taut;
use crate::tighten::{Hit, Tightening};

/// Plans paths on one ground; keeps its memory from one to the next, so that a warm planner takes none.
#[derive(Clone, Debug)]
pub struct Planner<'a> {
    ground: &'a Ground,
    search: Search,
    tightening: Tightening,
    taut: Taut,
    way: Vec<u32>,
    near_start: Vec<u32>,
    near_goal: Vec<u32>,
    path: Vec<DVec2>,
}

impl<'a> Planner<'a> {
    /// Returns a planner for a ground.
    #[must_use]
    pub fn new(ground: &'a Ground) -> Self {
        Self {
            ground,
            search: Search::default(),
            tightening: Tightening::remembering(),
            taut: Taut::default(),
            way: Vec::new(),
            near_start: Vec::new(),
            near_goal: Vec::new(),
            path: Vec::new(),
        }
    }

    /// Returns the ground that it plans on.
    #[must_use]
    pub fn ground(&self) -> &'a Ground {
        self.ground
    }

    /// Returns the goals of straight legs, one after the other, that lead a circle from a point to another without touching a
    /// wall; none where it is there. Exactly the goal comes last.
    ///
    /// A start may touch walls: the first leg then leads away from them. The path is short, not shortest.
    ///
    /// # Errors
    /// An end that is not on the map or has no room, or ends that are not connected; said without a search.
    pub fn path(&mut self, from: DVec2, to: DVec2) -> Result<&[DVec2], PlanError> {
        let departure = self.begin(from, to)?;
        if !self.ground.walls.is_clear(departure, to) {
            self.connect(from, departure, to)?;
            let mut way = std::mem::take(&mut self.way);
            let (start, goal) = (way[0], way[1]);
            way.clear();
            self.search.find(&self.ground.lattice, start, goal, &mut way);
            self.way = way;
            self.shorten(departure, to);
        }
        Ok(self.finish(from, to))
    }

    /// Returns a path as [`Self::path`] does, to the goal of a field: without a search.
    ///
    /// # Errors
    /// As [`Self::path`].
    ///
    /// # Panics
    /// With the field of another ground.
    pub fn path_by(&mut self, field: &Field, from: DVec2) -> Result<&[DVec2], PlanError> {
        let to = field.goal();
        let departure = self.begin(from, to)?;
        if !self.ground.walls.is_clear(departure, to) {
            self.connect(from, departure, to)?;
            let start = self.way[0];
            self.way.clear();
            field.follow(&self.ground.lattice, start, &mut self.way);
            self.shorten(departure, to);
        }
        Ok(self.finish(from, to))
    }

    /// Returns whether there is a path from a point to another; said without a search.
    pub fn connects(&mut self, from: DVec2, to: DVec2) -> bool {
        self.begin(from, to).is_ok_and(|departure| {
            self.ground.walls.is_clear(departure, to) || self.connect(from, departure, to).is_ok()
        })
    }

    /// Checks both ends, begins the path with the start, and returns the point from which it keeps its distance.
    fn begin(&mut self, from: DVec2, to: DVec2) -> Result<DVec2, PlanError> {
        check_within(self.ground, Which::Start, from)?;
        check_goal(self.ground, to)?;
        let departure = check_start(self.ground, from)?;
        self.path.clear();
        self.path.push(departure);
        Ok(departure)
    }

    /// Leaves in `way` a node near each end, the nearest ones that are connected.
    fn connect(&mut self, from: DVec2, departure: DVec2, to: DVec2) -> Result<(), PlanError> {
        let Self { ground, near_start, near_goal, .. } = self;
        ground.lattice.access(&ground.walls, departure, near_start);
        ground.lattice.access(&ground.walls, to, near_goal);
        for (which, point, near) in [(Which::Start, from, &near_start), (Which::Goal, to, &near_goal)] {
            if near.is_empty() {
                return Err(PlanError::Enclosed { which, point });
            }
        }
        let region = |node: u32| ground.lattice.region(node);
        let pairs = near_start.iter().flat_map(|&start| near_goal.iter().map(move |&goal| (start, goal)));
        let connected = pairs.into_iter().find(|&(start, goal)| region(start) == region(goal));
        let (start, goal) = connected.ok_or(PlanError::Unreachable { radius: ground.radius() })?;
        self.way.clear();
        self.way.extend([start, goal]);
        Ok(())
    }

    /// Makes the legs of the way between the first point of the path and the goal.
    fn shorten(&mut self, departure: DVec2, to: DVec2) {
        let Self { ground, path, way, tightening, taut, .. } = self;
        path.extend(way.iter().map(|&node| ground.lattice.point(node)).filter(|&point| point != departure));
        if path.last() != Some(&to) {
            path.push(to);
        }
        pull(|from, to| ground.walls.is_clear(from, to), path);
        let blocker = |from, to| ground.walls.blocker(from, to).map(|&wall| Hit::Wall(wall));
        tightening.tighten(&blocker, ground.room(), path);
        taut.shorten(ground, path);
        // The goal comes last by itself.
        path.pop();
    }

    /// Ends the path with the goal, and takes off the start, where the circle is.
    fn finish(&mut self, from: DVec2, to: DVec2) -> &[DVec2] {
        if self.path.last() != Some(&to) {
            self.path.push(to);
        }
        let is_there = self.path[0] == from;
        &self.path[usize::from(is_there)..]
    }
}

/// Returns how long a path from a point is, in world units.
#[must_use]
pub fn length(from: DVec2, legs: &[DVec2]) -> f64 {
    let starts = std::iter::once(&from).chain(legs);
    starts.zip(legs).map(|(start, end)| start.distance(*end)).sum()
}

/// Returns the point that a circle goes to first from a start, which is checked to have room.
pub(crate) fn check_start(ground: &Ground, start: DVec2) -> Result<DVec2, PlanError> {
    let blocked = PlanError::Blocked { which: Which::Start, point: start, room: ground.radius() };
    ground.departure(start).ok_or(blocked)
}

/// Checks that a goal is on the map and has room.
pub(crate) fn check_goal(ground: &Ground, goal: DVec2) -> Result<(), PlanError> {
    check_within(ground, Which::Goal, goal)?;
    if ground.holds(goal) {
        return Ok(());
    }
    Err(PlanError::Blocked { which: Which::Goal, point: goal, room: ground.reach })
}

fn check_within(ground: &Ground, which: Which, point: DVec2) -> Result<(), PlanError> {
    if ground.is_within(point) {
        return Ok(());
    }
    let (width, height) = ground.size();
    Err(PlanError::Outside { which, point, width, height })
}
