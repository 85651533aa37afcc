//! What comes and goes on a ground: buildings, and whatever else stands for a while.

use std::collections::BTreeMap;

use glam::DVec2;
use maniple_geometry::{Circle, Segment};
use maniple_tilemap::Area;

use crate::around::Detours;
use crate::crowd::{Core, Crowd, Standing};
use crate::error::{ObstacleError, PlanError};
use crate::ground::Ground;
use crate::tighten::{Hit, Tightening};

/// Something that stands on a ground.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Obstacle {
    /// A circle, as objects are.
    Circle(Circle),
    /// A rectangle with its sides along the axes; it may lie anywhere between tiles.
    Rectangle(Area),
}

/// A ground, and obstacles on it that are put there and taken away by keys, such as the handles of objects. What that costs grows with
/// the tiles that they cover, and not with the map.
#[doc(alias = "overlay")]
#[derive(Clone, Debug)]
pub struct Obstacles<'a> {
    ground: &'a Ground,
    standing: BTreeMap<usize, Obstacle>,
    crowd: Crowd,
    detours: Detours<'a>,
    tightening: Tightening,
}

impl<'a> Obstacles<'a> {
    /// Returns a ground with nothing on it but its walls.
    #[must_use]
    pub fn new(ground: &'a Ground) -> Self {
        Self {
            ground,
            standing: BTreeMap::new(),
            crowd: Crowd::new(),
            detours: Detours::new(ground),
            tightening: Tightening::default(),
        }
    }

    /// Puts an obstacle there, in place of the one with the same key, which is returned.
    ///
    /// # Errors
    /// One that is not on the map, or has no size; then nothing changes.
    pub fn insert(&mut self, key: usize, obstacle: Obstacle) -> Result<Option<Obstacle>, ObstacleError> {
        self.check(obstacle)?;
        let before = self.remove(key);
        self.standing.insert(key, obstacle);
        self.crowd.put(self.seen(key, obstacle));
        Ok(before)
    }

    /// Takes an obstacle away and returns it; `None` where there is none with that key.
    pub fn remove(&mut self, key: usize) -> Option<Obstacle> {
        let before = self.standing.remove(&key)?;
        self.crowd.take(&self.seen(key, before));
        Some(before)
    }

    /// Returns whether the middle of a circle can be in a point, the margin included.
    #[must_use]
    pub fn holds(&self, point: DVec2) -> bool {
        self.ground.holds(point) && self.crowd.holds(point)
    }

    /// Returns whether a circle can go straight from one point to another, the margin included.
    #[must_use]
    pub fn is_clear(&self, from: DVec2, to: DVec2) -> bool {
        self.crowd.holds(from) && self.ground.is_clear(from, to) && self.crowd.is_clear(from, to)
    }

    /// Returns the goals of straight legs from one point to another, as [`Detours::path`] does, with turns moved to what makes them. A start may be too near to an obstacle:
    /// the first leg then leads away from it. `Ok(None)`: the obstacles close every way that the lattice of the ground knows.
    ///
    /// # Errors
    /// An end that is not on the map or has no room between the walls.
    pub fn path(&mut self, from: DVec2, to: DVec2) -> Result<Option<Vec<DVec2>>, PlanError> {
        let Self { ground, crowd, detours, tightening, .. } = self;
        let Some(legs) = detours.path(crowd, from, to)? else { return Ok(None) };
        let blocker = |from, to| {
            let wall = ground.walls.blocker(from, to).map(|&wall| Hit::Wall(wall));
            let slack = ground.room() - ground.reach;
            wall.or_else(|| {
                crowd.blocker(from, to).map(|standing| standing.hit(&Segment::new(from, to), slack))
            })
        };
        let mut path = [&[from], &legs[..]].concat();
        tightening.tighten(&blocker, ground.room(), &mut path);
        Ok(Some(path.split_off(1)))
    }

    /// Checks that an obstacle is one; so the tiles that it covers are no more than those of the map, nearly.
    fn check(&self, obstacle: Obstacle) -> Result<(), ObstacleError> {
        let (width, height) = self.ground.size();
        let is_valid = match obstacle {
            Obstacle::Circle(Circle { center, radius }) => {
                let is_radius = radius > 0.0 && radius <= f64::from(width.max(height));
                self.ground.is_within(center) && is_radius
            }
            Obstacle::Rectangle(Area { min, max }) => {
                let is_size = min.x < max.x && min.y < max.y;
                self.ground.is_within(min) && self.ground.is_within(max) && is_size
            }
        };
        if is_valid { Ok(()) } else { Err(ObstacleError { obstacle, width, height }) }
    }

    /// An obstacle as the middles of circles of the ground see it.
    fn seen(&self, number: usize, obstacle: Obstacle) -> Standing {
        let reach = self.ground.reach;
        match obstacle {
            Obstacle::Circle(Circle { center, radius }) => {
                Standing { number, core: Core::Middle(center), reach: reach + radius }
            }
            Obstacle::Rectangle(area) => Standing { number, core: Core::Rectangle(area), reach },
        }
    }
}
