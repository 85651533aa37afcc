//! Who stands in the way, and of what a straight way keeps clear.

use glam::DVec2;
use hashbrown::HashTable;
use maniple_geometry::{Scalar, Segment};
use maniple_tilemap::Area;

use crate::tighten::Hit;
use crate::walls::is_apart;

/// Distance of the points at which it is looked who is near a line, in world units: half a tile.
const LOOK: f64 = 0.5;

/// Things at rest, by the tiles near which they are, as circles see them that are to keep clear.
#[derive(Clone, Debug, Default)]
pub struct Crowd {
    /// The tiles near which somebody stands. It is only ever asked for one, so that its order cannot be seen.
    tiles: HashTable<Tile>,
}

/// Who stands near a tile.
#[derive(Clone, Debug)]
struct Tile {
    place: (i32, i32),
    standing: Vec<Standing>,
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
        standing.each_tile(|place| {
            let entry =
                self.tiles.entry(hash_of(place), |tile| tile.place == place, |tile| hash_of(tile.place));
            entry.or_insert_with(|| Tile { place, standing: Vec::new() }).get_mut().standing.push(standing);
        });
    }

    /// Takes out something that was taken in like this.
    pub(crate) fn take(&mut self, standing: &Standing) {
        standing.each_tile(|place| {
            if let Ok(mut entry) = self.tiles.find_entry(hash_of(place), |tile| tile.place == place) {
                entry.get_mut().standing.retain(|other| other.number != standing.number);
                if entry.get().standing.is_empty() {
                    entry.remove();
                }
            }
        });
    }

    /// Returns whether the middle of a circle is in a point without being too near to anything.
    pub(crate) fn holds(&self, point: DVec2) -> bool {
        self.near(tile(point)).iter().all(|standing| standing.distance(point) >= standing.reach)
    }

    /// Returns all of which a point of a tile may be too near, or half a tile around it along both axes; and more.
    pub(crate) fn near(&self, place: (i32, i32)) -> &[Standing] {
        let tile = self.tiles.find(hash_of(place), |tile| tile.place == place);
        tile.map_or(&[][..], |tile| &tile.standing)
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
            let hit = self.near(tile(point)).iter().find(|standing| standing.is_hit_by(&line));
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
    pub(crate) fn is_hit_by(&self, line: &Segment) -> bool {
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

/// A hash of a tile: of all bits of the product the upper ones depend on both coordinates (Knuth, *The Art of Computer Programming* 3,
/// 6.4).
fn hash_of((x, y): (i32, i32)) -> u64 {
    let both = u64::from(x.cast_unsigned()) << 32 | u64::from(y.cast_unsigned());
    let product = both.wrapping_mul(0x9e37_79b9_7f4a_7c15);
    product ^ product >> 32
}

#[expect(clippy::cast_possible_truncation, reason = "a point of a map has a small tile")]
fn tile(point: DVec2) -> (i32, i32) {
    (point.x.floor() as i32, point.y.floor() as i32)
}
