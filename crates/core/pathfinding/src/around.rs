//! Paths around circles that stand in the way.

use std::cmp::Reverse;
use std::collections::{BTreeMap, BinaryHeap};

use glam::DVec2;
use maniple_geometry::Segment;

use crate::error::PlanError;
use crate::ground::Ground;
use crate::jump::octile;
use crate::lattice::{DIAGONAL, STRAIGHT};
use crate::planner::{check_goal, check_start};
use crate::pull::pull;

/// No node.
const NONE: u32 = u32::MAX;

/// The eight steps, in the order in which ties are decided.
const STEPS: [(i32, i32); 8] = [(1, 0), (0, 1), (-1, 0), (0, -1), (1, 1), (-1, 1), (-1, -1), (1, -1)];

/// Distance of the points at which it is looked who is near a line, in world units: half a tile.
const LOOK: f64 = 0.5;

/// Circles at rest, by the tiles near which they are, as others see them that are to keep clear.
#[derive(Clone, Debug, Default)]
pub struct Crowd {
    tiles: BTreeMap<(i32, i32), Vec<Standing>>,
}

/// A circle of a crowd: its number, its middle, and how far the middles of others keep from that.
type Standing = (usize, DVec2, f64);

impl Crowd {
    /// Returns nobody.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// Takes in a circle with a number of its own; `reach` is how far the middles of others keep from its middle, in world units.
    pub fn insert(&mut self, number: usize, center: DVec2, reach: f64) {
        Self::each_tile(center, reach, |tile| {
            self.tiles.entry(tile).or_default().push((number, center, reach));
        });
    }

    /// Takes out a circle that was taken in like this.
    pub fn remove(&mut self, number: usize, center: DVec2, reach: f64) {
        Self::each_tile(center, reach, |tile| {
            if let Some(circles) = self.tiles.get_mut(&tile) {
                circles.retain(|circle| circle.0 != number);
            }
        });
    }

    /// Returns whether the middle of a circle can go straight from one point to another, but for those that it is too near to at
    /// the start already: from them it has to move away.
    #[must_use]
    pub fn is_clear(&self, from: DVec2, to: DVec2) -> bool {
        let line: Segment = Segment::new(from, to);
        let length = line.length();
        let steps = (length / LOOK).ceil();
        let mut step = 0.0;
        loop {
            let point = if steps > 0.0 { from + (to - from) * (step / steps) } else { from };
            let circles = self.tiles.get(&tile(point)).map_or(&[][..], Vec::as_slice);
            let is_hit = circles.iter().any(|&(_, center, reach)| {
                let reach = if from.distance_squared(center) < reach * reach {
                    // Along the line the distance is convex: it is enough that it grows at the start.
                    if (from - center).dot(to - from) >= 0.0 { 0.0 } else { reach }
                } else {
                    reach
                };
                line.nearest(center).distance_squared(center) < reach * reach
            });
            if is_hit {
                return false;
            }
            step += 1.0;
            if step > steps {
                return true;
            }
        }
    }

    fn each_tile(center: DVec2, reach: f64, mut each: impl FnMut((i32, i32))) {
        let around = DVec2::splat(reach + LOOK);
        let (low, high) = (tile(center - around), tile(center + around));
        for y in low.1..=high.1 {
            for x in low.0..=high.0 {
                each((x, y));
            }
        }
    }
}

#[expect(clippy::cast_possible_truncation, reason = "a point of a map has a small tile")]
fn tile(point: DVec2) -> (i32, i32) {
    (point.x.floor() as i32, point.y.floor() as i32)
}

/// What a search knows of a node.
#[derive(Clone, Copy, Debug, Default)]
struct Known {
    search: u32,
    cost: u32,
    before: u32,
}

/// Finds paths around walls and circles at rest; keeps its memory from one to the next.
#[derive(Clone, Debug)]
pub struct Detours<'a> {
    ground: &'a Ground,
    number: u32,
    known: Vec<Known>,
    queue: BinaryHeap<Reverse<(u32, u32, u32)>>,
    expanded: usize,
}

impl<'a> Detours<'a> {
    /// Returns a planner for a ground.
    #[must_use]
    pub fn new(ground: &'a Ground) -> Self {
        Self { ground, number: 0, known: Vec::new(), queue: BinaryHeap::new(), expanded: 0 }
    }

    /// Returns the goals of straight legs from one point to another that keep clear of walls and of a crowd: the shortest way
    /// between points of the lattice (Hart, Nilsson and Raphael, 1968), pulled straight. `Ok(None)`: the crowd closes every way that
    /// this lattice knows.
    ///
    /// # Errors
    /// An end that is not on the map or has no room between the walls.
    pub fn path(&mut self, crowd: &Crowd, from: DVec2, to: DVec2) -> Result<Option<Vec<DVec2>>, PlanError> {
        check_goal(self.ground, to)?;
        let departure = check_start(self.ground, from)?;
        self.expanded = 0;
        let is_clear = |from, to| self.ground.walls.is_clear(from, to) && crowd.is_clear(from, to);
        if departure != from && !crowd.is_clear(from, departure) {
            return Ok(None);
        }
        let first = usize::from(departure == from);
        let mut points = vec![departure];
        if !is_clear(departure, to) {
            let (mut starts, mut goals) = (Vec::new(), Vec::new());
            let lattice = &self.ground.lattice;
            lattice.access(&self.ground.walls, departure, &mut starts);
            lattice.access(&self.ground.walls, to, &mut goals);
            starts.retain(|&node| crowd.is_clear(departure, lattice.point(node)));
            goals.retain(|&node| crowd.is_clear(lattice.point(node), to));
            let Some(way) = self.search(crowd, (departure, &starts), &goals) else { return Ok(None) };
            let lattice = &self.ground.lattice;
            points.extend(way.iter().map(|&node| lattice.point(node)).filter(|&point| point != departure));
        }
        if points[points.len() - 1] != to {
            points.push(to);
        }
        if points.len() > 2 {
            pull(|from, to| self.ground.walls.is_clear(from, to) && crowd.is_clear(from, to), &mut points);
        }
        Ok(Some(points.split_off(first)))
    }

    /// Returns how many points of the lattice the last search looked at: the measure of its work.
    #[must_use]
    pub fn expanded(&self) -> usize {
        self.expanded
    }

    fn search(&mut self, crowd: &Crowd, (from, starts): (DVec2, &[u32]), goals: &[u32]) -> Option<Vec<u32>> {
        let lattice = &self.ground.lattice;
        self.known.resize(lattice.nodes(), Known::default());
        self.number += 1;
        self.queue.clear();
        let target = lattice.place(*goals.first()?);
        for &node in starts {
            let cost = lattice.cost_of(lattice.point(node).distance(from));
            self.known[node as usize] = Known { search: self.number, cost, before: NONE };
            let rest = octile(lattice.place(node), target);
            self.queue.push(Reverse((cost + rest, rest, node)));
        }
        while let Some(Reverse((whole, rest, node))) = self.queue.pop() {
            let cost = self.known[node as usize].cost;
            if whole - rest != cost {
                continue;
            }
            if goals.contains(&node) {
                return Some(self.trace(node));
            }
            self.expanded += 1;
            let place = lattice.place(node);
            for (dx, dy) in STEPS {
                let next = (place.0 + dx, place.1 + dy);
                if !lattice.is_diagonal_free(place, next) {
                    continue;
                }
                let other = lattice.node(next.0.cast_unsigned(), next.1.cast_unsigned());
                let cost = cost + if dx != 0 && dy != 0 { DIAGONAL } else { STRAIGHT };
                let known = self.known[other as usize];
                let is_better = known.search != self.number || cost < known.cost;
                if is_better && crowd.is_clear(lattice.point(node), lattice.point(other)) {
                    self.known[other as usize] = Known { search: self.number, cost, before: node };
                    let rest = octile(next, target);
                    self.queue.push(Reverse((cost + rest, rest, other)));
                }
            }
        }
        None
    }

    fn trace(&self, goal: u32) -> Vec<u32> {
        let mut way = vec![goal];
        let mut node = goal;
        while self.known[node as usize].before != NONE {
            node = self.known[node as usize].before;
            way.push(node);
        }
        way.reverse();
        way
    }
}
