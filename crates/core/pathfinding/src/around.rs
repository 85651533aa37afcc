//! Paths around circles and rectangles that stand in the way.

use std::cmp::Reverse;
use std::collections::btree_map::Entry;
use std::collections::{BTreeMap, BinaryHeap};

use glam::DVec2;
use maniple_geometry::{Scalar, Segment};
use maniple_tilemap::Area;

use crate::error::PlanError;
use crate::ground::Ground;
use crate::jump::octile;
use crate::lattice::{DIAGONAL, STRAIGHT};
use crate::planner::{check_goal, check_start};
use crate::pull::pull;
use crate::tighten::Hit;
use crate::walls::is_apart;

/// No node.
const NONE: u32 = u32::MAX;

/// The eight steps, in the order in which ties are decided.
const STEPS: [(i32, i32); 8] = [(1, 0), (0, 1), (-1, 0), (0, -1), (1, 1), (-1, 1), (-1, -1), (1, -1)];

/// Distance of the points at which it is looked who is near a line, in world units: half a tile.
const LOOK: f64 = 0.5;

/// Things at rest, by the tiles near which they are, as circles see them that are to keep clear.
#[derive(Clone, Debug, Default)]
pub struct Crowd {
    tiles: BTreeMap<(i32, i32), Vec<Standing>>,
}

/// Something at rest, as the middle of a circle sees it that goes by.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Standing {
    pub(crate) number: usize,
    pub(crate) core: Core,
    /// How far the middle keeps from the core, in world units.
    pub(crate) reach: f64,
}

/// What a middle keeps its distance from: the middle of a circle, or a whole rectangle.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Core {
    Middle(DVec2),
    Rectangle(Area),
}

impl Crowd {
    /// Returns nobody.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// Takes in a circle with a number of its own; `reach` is how far the middles of others keep from its middle, in world units.
    pub fn insert(&mut self, number: usize, center: DVec2, reach: f64) {
        self.put(Standing { number, core: Core::Middle(center), reach });
    }

    /// Takes out a circle that was taken in like this.
    pub fn remove(&mut self, number: usize, center: DVec2, reach: f64) {
        self.take(&Standing { number, core: Core::Middle(center), reach });
    }

    /// Takes in something.
    pub(crate) fn put(&mut self, standing: Standing) {
        standing.each_tile(|tile| self.tiles.entry(tile).or_default().push(standing));
    }

    /// Takes out something that was taken in like this.
    pub(crate) fn take(&mut self, standing: &Standing) {
        standing.each_tile(|tile| {
            if let Entry::Occupied(mut entry) = self.tiles.entry(tile) {
                entry.get_mut().retain(|other| other.number != standing.number);
                if entry.get().is_empty() {
                    entry.remove();
                }
            }
        });
    }

    /// Returns whether the middle of a circle is in a point without being too near to anything.
    pub(crate) fn holds(&self, point: DVec2) -> bool {
        self.near(point).iter().all(|standing| standing.distance(point) >= standing.reach)
    }

    fn near(&self, point: DVec2) -> &[Standing] {
        self.tiles.get(&tile(point)).map_or(&[][..], Vec::as_slice)
    }

    /// Returns whether the middle of a circle can go straight from one point to another, but for those that it is too near to at
    /// the start already: from them it has to move away.
    #[must_use]
    pub fn is_clear(&self, from: DVec2, to: DVec2) -> bool {
        self.blocker(from, to).is_none()
    }

    /// Returns what is in the way from one point to another: the first that is found.
    pub(crate) fn blocker(&self, from: DVec2, to: DVec2) -> Option<&Standing> {
        let line: Segment = Segment::new(from, to);
        let steps = (line.length() / LOOK).ceil();
        let mut step = 0.0;
        while step <= steps {
            let point = if steps > 0.0 { from + (to - from) * (step / steps) } else { from };
            let hit = self.near(point).iter().find(|standing| standing.is_hit_by(&line));
            if hit.is_some() {
                return hit;
            }
            step += 1.0;
        }
        None
    }
}

impl Standing {
    /// Returns whether a middle comes too near that goes along a line; if it is too near at its start already, whether it does not move
    /// away.
    fn is_hit_by(&self, line: &Segment) -> bool {
        let away = line.start - self.nearest(line.start);
        if away.length_squared() < self.reach * self.reach {
            // Along the line the distance is convex: it is enough that it grows at the start. Within a rectangle there is none.
            let is_inside = matches!(self.core, Core::Rectangle(area) if area.contains(line.start));
            return is_inside || away.dot(line.direction()) < 0.0;
        }
        match self.core {
            Core::Middle(center) => line.nearest(center).distance_squared(center) < self.reach * self.reach,
            Core::Rectangle(area) => {
                // A line that starts outside cannot be inside without crossing a side.
                sides(area).iter().any(|side| !is_apart(line, side, self.reach))
            }
        }
    }

    /// Returns what a line meets that comes too near; `slack` is how much farther than necessary turns are placed, in world units.
    pub(crate) fn hit(&self, line: &Segment, slack: f64) -> Hit {
        match self.core {
            Core::Middle(center) => Hit::Circle { center, room: self.reach + slack },
            Core::Rectangle(area) => {
                let sides = sides(area);
                let hit = sides.iter().find(|side| !is_apart(line, side, self.reach));
                // A line within the rectangle meets none.
                Hit::Wall(*hit.unwrap_or(&sides[0]))
            }
        }
    }

    /// How far a point is from the core, in world units.
    fn distance(&self, point: DVec2) -> f64 {
        point.distance(self.nearest(point))
    }

    fn nearest(&self, point: DVec2) -> DVec2 {
        match self.core {
            Core::Middle(center) => center,
            Core::Rectangle(area) => DVec2::new(
                point.x.greater(area.min.x).lesser(area.max.x),
                point.y.greater(area.min.y).lesser(area.max.y),
            ),
        }
    }

    fn each_tile(&self, mut each: impl FnMut((i32, i32))) {
        let around = DVec2::splat(self.reach + LOOK);
        let (low, high) = match self.core {
            Core::Middle(center) => (center, center),
            Core::Rectangle(area) => (area.min, area.max),
        };
        let (low, high) = (tile(low - around), tile(high + around));
        for y in low.1..=high.1 {
            for x in low.0..=high.0 {
                each((x, y));
            }
        }
    }
}

/// The sides of a rectangle.
fn sides(area: Area) -> [Segment; 4] {
    let corners =
        [area.min, DVec2::new(area.max.x, area.min.y), area.max, DVec2::new(area.min.x, area.max.y)];
    [0, 1, 2, 3].map(|side| Segment::new(corners[side], corners[(side + 1) % 4]))
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

/// Finds paths around walls and things at rest; keeps its memory from one to the next.
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
