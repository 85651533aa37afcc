//! What the largest unit can reach, and ways to what it cannot.
//!
//! The unit is taken as a square as wide as a way has to be ([`Request::lane`]), which stands on whole tiles and moves over
//! their edges; its place is that of its upper left tile. The circle fits into the square, so it gets wherever the
//! square gets: what is found reachable is. Half-blocked tiles are blocked here, and so are patches where they
//! are in the way.

use std::collections::VecDeque;

use super::canvas::{Canvas, Material, Spot, square};
use super::{Layout, Request, clusters};

/// Cut-off ground where the unit can stand at so many places gets a way; less of it is filled up.
const AREA_MIN: usize = 24;

/// Most ways that are made on one map: each joins at least one area of [`AREA_MIN`] places.
const WAYS_MAX: usize = 4_096;

/// The label of a place where the unit cannot stand.
const NONE: u32 = u32::MAX;

/// Whether patches are in the way.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Patches {
    Block,
    Ignore,
}

/// The ground, and where the largest unit gets on it.
pub(super) struct Ways {
    canvas: Canvas,
    lane: i32,
    /// Whether a patch lies on a tile.
    is_patch: Vec<bool>,
    /// Places each of which has to be reachable: where the unit stands on a spawn, or beside a patch.
    targets: Vec<Vec<Spot>>,
}

impl Ways {
    pub(super) fn new(canvas: Canvas, request: &Request, layout: &Layout) -> Self {
        let lane = request.lane().cast_signed();
        let mut is_patch = vec![false; canvas.spots().count()];
        let mut targets = Vec::new();
        for &(_, (x, y)) in &layout.spawns {
            targets.push(vec![(x - lane / 2, y - lane / 2)]);
        }
        for &patch in &layout.patches {
            let (min, max) = clusters::tiles_of(patch);
            square(min, max).for_each(|spot| is_patch[canvas.index(spot)] = true);
            let beside = square((min.0 - lane, min.1 - lane), (max.0 + 1, max.1 + 1));
            targets.push(beside.collect());
        }
        Self { canvas, lane, is_patch, targets }
    }

    pub(super) fn into_canvas(self) -> Canvas {
        self.canvas
    }

    /// Joins everything that is large or has to be reached, by ways of the material, and fills up the rest. Returns
    /// whether all can be reached now.
    pub(super) fn connect(&mut self, bridge: Material) -> bool {
        for _ in 0..WAYS_MAX {
            let areas = Areas::of(self, Patches::Block);
            let Some(main) = self.main(&areas) else { return false };
            let Some(goal) = self.cut_off(&areas, main) else { break };
            if !self.make_way(&areas, main, (&goal, bridge)) {
                return false;
            }
        }
        self.fill();
        self.is_connected()
    }

    /// Returns the label of the area of the first target, or of the largest area where nothing has to be reached.
    fn main(&self, areas: &Areas) -> Option<u32> {
        match self.targets.first() {
            Some(target) => target.iter().find_map(|&spot| areas.label(&self.canvas, spot)),
            None => {
                let largest = areas.sizes.iter().max()?;
                (0..).zip(&areas.sizes).find(|(_, size)| *size == largest).map(|(label, _)| label)
            }
        }
    }

    /// Returns places of which one has to be reachable, and none is.
    fn cut_off(&self, areas: &Areas, main: u32) -> Option<Vec<Spot>> {
        let is_reached = |spot: &Spot| areas.label(&self.canvas, *spot) == Some(main);
        if let Some(target) = self.targets.iter().find(|target| !target.iter().any(is_reached)) {
            return Some(target.clone());
        }
        let large = (0..).zip(&areas.sizes).find(|&(label, &size)| label != main && size >= AREA_MIN);
        let (large, _) = large?;
        let is_in_it = |spot: &Spot| areas.label(&self.canvas, *spot) == Some(large);
        Some(self.canvas.spots().filter(is_in_it).collect())
    }

    /// Opens the way from an area to one of the goals that goes through the fewest blocked places, the shortest of them
    /// being not always found. Returns whether there is any.
    fn make_way(&mut self, areas: &Areas, main: u32, (goals, bridge): (&[Spot], Material)) -> bool {
        let canvas = &self.canvas;
        let free = self.blocked_sums(|ways, spot| ways.is_patch[ways.canvas.index(spot)]);
        let mut is_goal = vec![false; areas.labels.len()];
        goals
            .iter()
            .filter(|goal| canvas.is_inside(**goal))
            .for_each(|goal| is_goal[canvas.index(*goal)] = true);
        let mut costs = vec![u32::MAX; areas.labels.len()];
        let mut before: Vec<Option<Spot>> = vec![None; areas.labels.len()];
        let mut waiting: VecDeque<(u32, Spot)> = VecDeque::new();
        for spot in canvas.spots().filter(|&spot| areas.label(canvas, spot) == Some(main)) {
            costs[canvas.index(spot)] = 0;
            waiting.push_back((0, spot));
        }
        let mut end = None;
        while let Some((cost, spot)) = waiting.pop_front() {
            if cost > costs[canvas.index(spot)] {
                continue;
            }
            if is_goal[canvas.index(spot)] {
                end = Some(spot);
                break;
            }
            for next in around(spot).into_iter().filter(|&next| free.is_clear(next, self.lane)) {
                let price = u32::from(areas.label(canvas, next).is_none());
                if cost + price < costs[canvas.index(next)] {
                    costs[canvas.index(next)] = cost + price;
                    before[canvas.index(next)] = Some(spot);
                    // The queue holds two neighbouring costs at most: free steps go to its front.
                    if price == 0 {
                        waiting.push_front((cost, next));
                    } else {
                        waiting.push_back((cost + 1, next));
                    }
                }
            }
        }
        let mut place = end;
        while let Some(spot) = place {
            place = before[self.canvas.index(spot)];
            self.canvas.open(spot, self.lane, bridge);
        }
        end.is_some()
    }

    /// Blocks the open tiles that the unit cannot cover wherever it stands.
    fn fill(&mut self) {
        let blocked = Areas::of(self, Patches::Block);
        let ignored = Areas::of(self, Patches::Ignore);
        let Some(main) = self.main(&blocked) else { return };
        let standing = self.canvas.spots().find(|&spot| blocked.label(&self.canvas, spot) == Some(main));
        let Some(main) = standing.and_then(|spot| ignored.label(&self.canvas, spot)) else { return };
        let mut is_covered = vec![false; ignored.labels.len()];
        for spot in self.canvas.spots().filter(|&spot| ignored.label(&self.canvas, spot) == Some(main)) {
            let end = (spot.0 + self.lane, spot.1 + self.lane);
            square(spot, end).for_each(|tile| is_covered[self.canvas.index(tile)] = true);
        }
        let before = self.canvas.clone();
        for spot in before.spots() {
            if before.is_open(spot) && !is_covered[before.index(spot)] {
                self.canvas.put(spot, filler(&before, spot));
            }
        }
    }

    /// Whether every target can be reached from every other.
    fn is_connected(&self) -> bool {
        let areas = Areas::of(self, Patches::Block);
        let Some(main) = self.main(&areas) else { return false };
        self.targets
            .iter()
            .all(|target| target.iter().any(|&spot| areas.label(&self.canvas, spot) == Some(main)))
    }

    fn blocked_sums(&self, is_blocked: impl Fn(&Self, Spot) -> bool) -> Sums {
        let (width, height) = (self.canvas.width(), self.canvas.height());
        let mut sums = vec![0; ((width + 1) * (height + 1)).cast_unsigned() as usize];
        let row = (width + 1).cast_unsigned() as usize;
        for spot in self.canvas.spots() {
            let index = (spot.1 + 1).cast_unsigned() as usize * row + (spot.0 + 1).cast_unsigned() as usize;
            let here = i32::from(is_blocked(self, spot));
            sums[index] = here + sums[index - 1] + sums[index - row] - sums[index - row - 1];
        }
        Sums { width, height, sums }
    }
}

/// Returns what to fill a tile with: what is blocked beside it, so that the ground stays of a piece.
fn filler(canvas: &Canvas, spot: Spot) -> Material {
    let beside = around(spot).into_iter().filter(|&next| canvas.is_inside(next));
    let mut blocked = beside.map(|next| canvas.material(next)).filter(|material| !material.is_open());
    blocked.next().unwrap_or(Material::Rock)
}

fn around((x, y): Spot) -> [Spot; 4] {
    [(x, y - 1), (x - 1, y), (x + 1, y), (x, y + 1)]
}

/// How many tiles are blocked above and left of each corner of tiles.
struct Sums {
    width: i32,
    height: i32,
    sums: Vec<i32>,
}

impl Sums {
    /// Whether a square of `side` tiles is on the map and nothing in it is blocked.
    fn is_clear(&self, (x, y): Spot, side: i32) -> bool {
        if x < 0 || y < 0 || x + side > self.width || y + side > self.height {
            return false;
        }
        let sum = |x: i32, y: i32| self.sums[(y * (self.width + 1) + x).cast_unsigned() as usize];
        sum(x + side, y + side) - sum(x, y + side) - sum(x + side, y) + sum(x, y) == 0
    }
}

/// Which places the unit can get to from each other.
struct Areas {
    /// By place, row by row.
    labels: Vec<u32>,
    /// How many places each area has.
    sizes: Vec<usize>,
}

impl Areas {
    fn of(ways: &Ways, patches: Patches) -> Self {
        let canvas = &ways.canvas;
        let sums = ways.blocked_sums(|ways, spot| {
            let is_patch = patches == Patches::Block && ways.is_patch[ways.canvas.index(spot)];
            is_patch || !ways.canvas.is_open(spot)
        });
        let mut areas = Self { labels: vec![NONE; canvas.spots().count()], sizes: Vec::new() };
        let mut waiting = Vec::new();
        for first in canvas.spots() {
            if areas.labels[canvas.index(first)] != NONE || !sums.is_clear(first, ways.lane) {
                continue;
            }
            let label = u32::try_from(areas.sizes.len()).unwrap_or(NONE);
            let mut size = 0;
            areas.labels[canvas.index(first)] = label;
            waiting.push(first);
            while let Some(spot) = waiting.pop() {
                size += 1;
                for next in around(spot) {
                    if sums.is_clear(next, ways.lane) && areas.labels[canvas.index(next)] == NONE {
                        areas.labels[canvas.index(next)] = label;
                        waiting.push(next);
                    }
                }
            }
            areas.sizes.push(size);
        }
        areas
    }

    /// Returns the area of a place; `None` where the unit cannot stand.
    fn label(&self, canvas: &Canvas, spot: Spot) -> Option<u32> {
        canvas.is_inside(spot).then(|| self.labels[canvas.index(spot)]).filter(|&label| label != NONE)
    }
}
