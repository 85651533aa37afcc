//! The ground as the bot knows it: which tiles are free, and ways over them.

use std::cmp::Reverse;
use std::collections::{BTreeMap, BinaryHeap};
use std::sync::Arc;

use glam::DVec2;
use maniple_view::Terrain;

use crate::seeing::Block;

/// How far it looks along a way for the next point that it can go to straight, in tiles.
const LOOK_AHEAD: usize = 12;

/// Distance of the points at which a straight line is checked, in world units.
const STEP: f64 = 0.25;

/// Cost of a step to the next tile, and of a diagonal one: about 1 to the root of 2.
const STRAIGHT: u32 = 10;
const DIAGONAL: u32 = 14;

/// Most ways that are remembered.
const WAYS_MAX: usize = 64;

/// The tiles of the map, and what stands on them.
#[derive(Clone, Debug, Default)]
pub(super) struct Ground {
    width: usize,
    height: usize,
    /// By row: whether a tile is wholly open.
    open: Vec<bool>,
    /// By row: whether it is, and nothing stands on it.
    free: Vec<bool>,
    blocks: Vec<Block>,
    /// The ways to places, until something changes.
    ways: BTreeMap<(usize, usize, usize, usize), Arc<Distances>>,
}

/// How far it is from each tile to a place.
#[derive(Clone, Debug)]
pub(super) struct Distances {
    /// By row; in tenths of a tile. `u32::MAX`: there is no way.
    tiles: Vec<u32>,
}

impl Ground {
    /// Returns the ground of a terrain, with nothing on it. Tiles that are not known count as open.
    pub(super) fn new(terrain: &Terrain) -> Self {
        let is_open = |tile| tile == '.' || tile == '?';
        let open: Vec<bool> = terrain.tiles.iter().flat_map(|row| row.chars().map(is_open)).collect();
        Self {
            width: terrain.width as usize,
            height: terrain.height as usize,
            free: open.clone(),
            open,
            blocks: Vec::new(),
            ways: BTreeMap::new(),
        }
    }

    /// Takes in tiles that became known.
    pub(super) fn reveal(&mut self, tiles: &[(u32, u32, String)]) {
        for (x, y, row) in tiles {
            let first = *y as usize * self.width + *x as usize;
            for (open, tile) in self.open[first..].iter_mut().zip(row.chars()) {
                *open = tile == '.';
            }
        }
        if !tiles.is_empty() {
            self.refresh();
        }
    }

    /// Takes in all that stands on the ground.
    pub(super) fn stand(&mut self, blocks: Vec<Block>) {
        if blocks != self.blocks {
            self.blocks = blocks;
            self.refresh();
        }
    }

    fn refresh(&mut self) {
        self.free.clone_from(&self.open);
        for block in &self.blocks {
            let (x_min, y_min, x_max, y_max) = self.tiles_of(block);
            for y in y_min..=y_max {
                self.free[y * self.width + x_min..=y * self.width + x_max].fill(false);
            }
        }
        self.ways.clear();
    }

    /// Returns the width and height, in world units.
    pub(super) fn size(&self) -> DVec2 {
        DVec2::new(self.width as f64, self.height as f64)
    }

    /// Returns whether all tiles of a rectangle are free.
    pub(super) fn is_free(&self, block: &Block) -> bool {
        let (low, high) = (block.center - block.half, block.center + block.half);
        if low.x < 0.0 || low.y < 0.0 || high.x > self.size().x || high.y > self.size().y {
            return false;
        }
        let (x_min, y_min, x_max, y_max) = self.tiles_of(block);
        (y_min..=y_max).all(|y| (x_min..=x_max).all(|x| self.free[y * self.width + x]))
    }

    /// Returns whether a circle gets straight from one point to another over free tiles; `target` does not stand in the way.
    pub(super) fn is_clear(&self, from: DVec2, to: DVec2, radius: f64, target: Option<&Block>) -> bool {
        let spared = target.map(|block| self.tiles_of(block));
        let is_spared = |x: usize, y: usize| {
            spared.is_some_and(|(x_min, y_min, x_max, y_max)| {
                (x_min..=x_max).contains(&x) && (y_min..=y_max).contains(&y)
            })
        };
        let steps = steps(from.distance(to));
        let step = (to - from) / f64::from(steps);
        // Where it stands already is no matter.
        (1..=steps).all(|number| {
            let center = from + step * f64::from(number);
            let corners = [(-radius, -radius), (radius, -radius), (-radius, radius), (radius, radius)];
            corners.iter().all(|&corner| {
                self.tile(center + DVec2::from(corner))
                    .is_some_and(|(x, y)| self.free[y * self.width + x] || is_spared(x, y))
            })
        })
    }

    /// Returns how far it is from everywhere to beside a block, or to the tile of a point.
    pub(super) fn distances(&mut self, goal: &Block) -> Arc<Distances> {
        let (x_min, y_min, x_max, y_max) = self.tiles_of(goal);
        let key = (x_min, y_min, x_max, y_max);
        if let Some(distances) = self.ways.get(&key) {
            return Arc::clone(distances);
        }
        let mut starts = self.free_tiles((x_min, y_min), (x_max, y_max));
        let mut ring = 1;
        while starts.is_empty() && ring < self.width + self.height {
            let low = (x_min.saturating_sub(ring), y_min.saturating_sub(ring));
            let high = ((x_max + ring).min(self.width - 1), (y_max + ring).min(self.height - 1));
            starts = self.free_tiles(low, high);
            ring += 1;
        }
        if self.ways.len() >= WAYS_MAX {
            self.ways.clear();
        }
        let distances = Arc::new(self.flood(&starts));
        self.ways.insert(key, Arc::clone(&distances));
        distances
    }

    fn free_tiles(&self, low: (usize, usize), high: (usize, usize)) -> Vec<usize> {
        (low.1..=high.1)
            .flat_map(|y| (low.0..=high.0).map(move |x| y * self.width + x))
            .filter(|&place| self.free[place])
            .collect()
    }

    /// Dijkstra's algorithm from several tiles.
    fn flood(&self, starts: &[usize]) -> Distances {
        let mut distances = vec![u32::MAX; self.free.len()];
        let mut heap = BinaryHeap::new();
        for &start in starts {
            distances[start] = 0;
            heap.push(Reverse((0, start)));
        }
        while let Some(Reverse((distance, place))) = heap.pop() {
            if distance > distances[place] {
                continue;
            }
            self.for_each_neighbour(place, |next, cost| {
                if distance + cost < distances[next] {
                    distances[next] = distance + cost;
                    heap.push(Reverse((distance + cost, next)));
                }
            });
        }
        Distances { tiles: distances }
    }

    /// Calls `visit` with each free tile beside one, and what the step costs; diagonal steps cut no corner.
    fn for_each_neighbour(&self, place: usize, mut visit: impl FnMut(usize, u32)) {
        let (x, y) = (place % self.width, place / self.width);
        let is_free = |x: usize, y: usize| x < self.width && y < self.height && self.free[y * self.width + x];
        for (dx, dy) in [(-1, 0), (1, 0), (0, -1), (0, 1), (-1, -1), (1, -1), (-1, 1), (1, 1)] {
            let (Some(to_x), Some(to_y)) = (x.checked_add_signed(dx), y.checked_add_signed(dy)) else {
                continue;
            };
            let is_diagonal = dx != 0 && dy != 0;
            if !is_free(to_x, to_y) || (is_diagonal && !(is_free(to_x, y) && is_free(x, to_y))) {
                continue;
            }
            visit(to_y * self.width + to_x, if is_diagonal { DIAGONAL } else { STRAIGHT });
        }
    }

    /// Returns the points of a way down the distances, each straight from the one before; empty where it is there, or there is no way.
    pub(super) fn way(&self, from: DVec2, distances: &Distances, radius: f64) -> Vec<DVec2> {
        let Some(start) = self.tile(from).map(|(x, y)| y * self.width + x) else { return Vec::new() };
        let mut tiles = vec![start];
        let mut here = start;
        while distances.tiles[here] > 0 {
            let mut best = (distances.tiles[here], here);
            self.for_each_neighbour(here, |next, cost| {
                let distance = distances.tiles[next];
                if distance < u32::MAX
                    && (distance + cost, next) < (best.0.saturating_add(cost), best.1)
                    && distance < best.0
                {
                    best = (distance, next);
                }
            });
            if best.1 == here {
                break;
            }
            here = best.1;
            tiles.push(here);
        }
        self.pulled(from, &tiles, radius)
    }

    /// Returns the tiles of a way that cannot be left out.
    fn pulled(&self, from: DVec2, tiles: &[usize], radius: f64) -> Vec<DVec2> {
        let center =
            |place: usize| DVec2::new((place % self.width) as f64 + 0.5, (place / self.width) as f64 + 0.5);
        let mut points = Vec::new();
        let (mut anchor, mut at) = (from, 0);
        while at + 1 < tiles.len() {
            let last = (at + LOOK_AHEAD).min(tiles.len() - 1);
            let next = (at + 1..=last)
                .rev()
                .find(|&place| self.is_clear(anchor, center(tiles[place]), radius, None))
                .unwrap_or(at + 1);
            anchor = center(tiles[next]);
            points.push(anchor);
            at = next;
        }
        points
    }

    /// Returns how far it is from a point, in tenths of a tile; `None` where there is no way.
    pub(super) fn distance(&self, from: DVec2, distances: &Distances) -> Option<u32> {
        let (x, y) = self.tile(from)?;
        Some(distances.tiles[y * self.width + x]).filter(|&distance| distance < u32::MAX)
    }

    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "checked not to be negative")]
    fn tile(&self, point: DVec2) -> Option<(usize, usize)> {
        if !(point.x >= 0.0 && point.y >= 0.0) {
            return None;
        }
        let (x, y) = (point.x as usize, point.y as usize);
        (x < self.width && y < self.height).then_some((x, y))
    }

    /// Returns the tiles that a block touches, as smallest and largest x and y; those of a point at least the nearest one.
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "cut to the map on both sides"
    )]
    fn tiles_of(&self, block: &Block) -> (usize, usize, usize, usize) {
        let (low, high) = (block.center - block.half, block.center + block.half);
        let first = |value: f64, count: usize| if value > 0.0 { (value as usize).min(count - 1) } else { 0 };
        let last = |value: f64, count: usize| {
            let end = value.ceil() - 1.0;
            if end > 0.0 { (end as usize).min(count - 1) } else { 0 }
        };
        let (x_min, y_min) = (first(low.x, self.width), first(low.y, self.height));
        (x_min, y_min, last(high.x, self.width).max(x_min), last(high.y, self.height).max(y_min))
    }
}

#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a distance on the map")]
fn steps(distance: f64) -> u32 {
    (distance / STEP) as u32 + 1
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ground(rows: &[&str]) -> Ground {
        Ground::new(&Terrain {
            width: u32::try_from(rows[0].len()).unwrap(),
            height: u32::try_from(rows.len()).unwrap(),
            tiles: rows.iter().map(|&row| row.to_owned()).collect(),
            segments: Vec::new(),
        })
    }

    fn point(x: f64, y: f64) -> Block {
        Block { center: DVec2::new(x, y), half: DVec2::ZERO }
    }

    #[test]
    fn a_way_leads_around_walls_and_each_part_of_it_is_clear() {
        let mut ground = ground(&["........", ".@@@@@@.", "........", "@@@@@@..", "........"]);
        let distances = ground.distances(&point(0.5, 4.5));
        let from = DVec2::new(3.5, 0.5);
        let way = ground.way(from, &distances, 0.4);
        assert_eq!(way.last(), Some(&DVec2::new(0.5, 4.5)));
        let mut anchor = from;
        for &next in &way {
            assert!(ground.is_clear(anchor, next, 0.4, None), "{anchor} {next}");
            anchor = next;
        }
        assert!(!ground.is_clear(from, DVec2::new(3.5, 2.5), 0.4, None));
        // 4 tiles to the right or 3 to the left, and down through the gap on the right: 8 or more in all.
        assert!(ground.distance(from, &distances).unwrap() > 80);
    }

    #[test]
    fn what_stands_is_gone_around_and_reached_from_beside() {
        let mut ground = ground(&["........"; 8]);
        let house = Block { center: DVec2::new(4.0, 4.0), half: DVec2::new(2.0, 2.0) };
        ground.stand(vec![house]);
        assert!(!ground.is_free(&house));
        let distances = ground.distances(&house);
        let way = ground.way(DVec2::new(0.5, 4.5), &distances, 0.2);
        assert_eq!(way, [DVec2::new(1.5, 4.5)]);
        assert!(ground.is_clear(DVec2::new(0.5, 4.5), DVec2::new(2.0, 4.5), 0.2, Some(&house)));
        assert!(!ground.is_clear(DVec2::new(0.5, 4.5), DVec2::new(2.0, 4.5), 0.2, None));
        ground.stand(Vec::new());
        assert!(ground.is_free(&house));
    }

    #[test]
    fn where_no_way_leads_there_is_none() {
        let mut ground = ground(&["..@..", "..@..", "..@.."]);
        let distances = ground.distances(&point(4.5, 1.5));
        assert_eq!(ground.distance(DVec2::new(0.5, 0.5), &distances), None);
        assert!(ground.way(DVec2::new(0.5, 0.5), &distances, 0.4).is_empty());
    }
}
