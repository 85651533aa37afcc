//! What a team may know of a world: slow and obvious, by the words of `docs/PROTOCOL.md`, section 6, and by none of the code that is
//! tested.

#![expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "numbers of a scene are small, and coordinates not negative"
)]

use std::collections::BTreeMap;

use glam::DVec2;
use maniple_game::World;
use maniple_geometry::{Moment, ObjectId};
use maniple_view::{Layer, Seat, Shape, Sighting, UnitType};

/// The rules by which a team sees.
pub(super) struct Twin {
    /// Row by row: whether a tile is blocked.
    pub(super) blocked: Vec<Vec<bool>>,
    pub(super) walls_block: bool,
    /// Whether the world is one of single precision.
    pub(super) is_single: bool,
    pub(super) unit_types: Vec<UnitType>,
    /// By seat.
    pub(super) teams: Vec<u16>,
    pub(super) watcher: Seat,
}

/// What a team sees at the start of a cycle.
pub(super) struct Seen {
    pub(super) objects: BTreeMap<ObjectId, Sighting>,
    /// Row by row: whether a tile is visible.
    pub(super) tiles: Vec<Vec<bool>>,
}

/// A tile: column and row.
type Tile = (i32, i32);

impl Twin {
    /// Returns what the watcher's team sees of a world.
    pub(super) fn look(&self, world: &World) -> Seen {
        let all = world.objects();
        let own: Vec<&Sighting> = all.iter().filter(|it| self.is_of_team(it)).collect();
        let mut tiles = vec![vec![false; self.blocked[0].len()]; self.blocked.len()];
        for eye in &own {
            self.look_at_tiles(eye, world, &mut tiles);
        }
        let is_seen = |it: &Sighting| {
            self.is_of_team(it)
                || own.iter().any(|eye| self.is_in_sight(eye, it, world))
                    && (!self.walls_block || self.is_on(it, world, &tiles))
        };
        let objects = all.iter().filter(|it| is_seen(it)).map(|it| (it.object, *it)).collect();
        Seen { objects, tiles }
    }

    pub(super) fn kind(&self, it: &Sighting) -> &UnitType {
        &self.unit_types[usize::from(it.unit_type.0)]
    }

    /// Returns how far it is from hull to hull.
    pub(super) fn apart(&self, one: (&Sighting, DVec2), other: (&Sighting, DVec2)) -> f64 {
        distance(other.1 - one.1, self.kind(one.0).shape, self.kind(other.0).shape)
    }

    /// Returns where an object is, rounded as the world rounds it.
    fn place(&self, it: &Sighting, world: &World) -> DVec2 {
        let base = &it.base;
        if !self.is_single {
            return base.position(world.cycle());
        }
        let elapsed = Moment { cycle: base.cycle, fraction: base.fraction }.until(world.cycle());
        (base.point.as_vec2() + base.velocity.as_vec2() * elapsed as f32).as_dvec2()
    }

    fn is_of_team(&self, it: &Sighting) -> bool {
        it.owner.is_some_and(|owner| self.teams[owner.index()] == self.teams[self.watcher.index()])
    }

    /// Compares squares where both are round, as sight does: a root would round.
    fn is_in_sight(&self, eye: &Sighting, other: &Sighting, world: &World) -> bool {
        let sight = self.kind(eye).sight;
        let (from, to) = (self.place(eye, world), self.place(other, world));
        if let (Shape::Circle { radius: one }, Shape::Circle { radius: two }) =
            (self.kind(eye).shape, self.kind(other).shape)
        {
            let reach = one + two + sight;
            return (to - from).length_squared() <= reach * reach;
        }
        self.apart((eye, from), (other, to)) <= sight
    }

    /// Returns whether an object covers or touches a visible tile.
    fn is_on(&self, it: &Sighting, world: &World, visible: &[Vec<bool>]) -> bool {
        let center = self.place(it, world);
        let tile = Shape::Rectangle { width: 1.0, height: 1.0 };
        self.all_tiles().any(|(x, y)| {
            let middle = DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5);
            visible[y as usize][x as usize] && distance(middle - center, self.kind(it).shape, tile) <= 0.0
        })
    }

    fn look_at_tiles(&self, eye: &Sighting, world: &World, visible: &mut [Vec<bool>]) {
        let kind = self.kind(eye);
        let center = self.place(eye, world);
        let (half, radius) = (kind.shape.half(), kind.shape.rounding());
        let (low, high) = (tile_of(center - half), tile_of(center + half));
        let hides = self.walls_block && kind.layer == Layer::Ground;
        let gap_squared = |(x, y): Tile| {
            let gap = |at: i32, from: i32, to: i32| f64::from((from - at - 1).max(at - to - 1).max(0));
            let (gx, gy) = (gap(x, low.0, high.0), gap(y, low.1, high.1));
            gx * gx + gy * gy
        };
        let within = |reach: f64, tile: Tile| gap_squared(tile) <= reach * reach;
        let from = tile_of(center);
        let is_lit = |tile: Tile| {
            within(radius + kind.sight, tile)
                && (!hides || within(radius + 1.0 / 1024.0, tile) || self.is_line_clear(from, tile))
        };
        let far = |tile: Tile| !within(radius + kind.sight, tile);
        for (x, y) in self.all_tiles() {
            if visible[y as usize][x as usize] || far((x, y)) {
                continue;
            }
            let is_face = || {
                let mut around = (-1..=1).flat_map(|down| (-1..=1).map(move |right| (x + right, y + down)));
                around.any(|tile| self.is_blocked(tile) == Some(false) && is_lit(tile))
            };
            visible[y as usize][x as usize] =
                is_lit((x, y)) || hides && self.is_blocked((x, y)) == Some(true) && is_face();
        }
    }

    /// Walks the line of sight from one tile to another.
    fn is_line_clear(&self, from: Tile, to: Tile) -> bool {
        let (dx, dy) = (to.0 - from.0, to.1 - from.1);
        let is_wide = dx.abs() >= dy.abs();
        let (along, aside) = if is_wide { (dx, dy) } else { (dy, dx) };
        let n = along.abs();
        (1..n).all(|j| {
            // Twice the place aside in n-ths, from the middle of the tile before: tiles begin at odd multiples of n.
            let doubled = 2 * aside * j + n;
            let place = doubled.div_euclid(2 * n);
            let tile = |aside: i32| {
                let step = along.signum() * j;
                let (x, y) = if is_wide { (step, aside) } else { (aside, step) };
                self.is_blocked((from.0 + x, from.1 + y)) == Some(true)
            };
            let is_between = doubled.rem_euclid(2 * n) == 0;
            !(tile(place) && (!is_between || tile(place - 1)))
        })
    }

    /// Returns whether a tile is blocked; `None` outside of the map.
    fn is_blocked(&self, (x, y): Tile) -> Option<bool> {
        let row = self.blocked.get(usize::try_from(y).ok()?)?;
        row.get(usize::try_from(x).ok()?).copied()
    }

    fn all_tiles(&self) -> impl Iterator<Item = Tile> + use<> {
        let size = |length: usize| i32::try_from(length).expect("a scene is small");
        let (width, height) = (size(self.blocked[0].len()), size(self.blocked.len()));
        (0..height).flat_map(move |y| (0..width).map(move |x| (x, y)))
    }
}

/// Returns how far it is from hull to hull.
fn distance(offset: DVec2, one: Shape, other: Shape) -> f64 {
    let beyond = (offset.abs() - one.half() - other.half()).max(DVec2::ZERO);
    beyond.length() - one.rounding() - other.rounding()
}

/// Returns the tile that a point is on; on an edge, the one to the right or below.
fn tile_of(point: DVec2) -> Tile {
    let floor = point.floor();
    (floor.x as i32, floor.y as i32)
}
