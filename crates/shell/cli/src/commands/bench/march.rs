//! The scene of the benchmarks: circles that march on random headings, and turn where they are stopped.
//!
//! A function of its seed. Only operations that are rounded alike everywhere are in it, so that a march ends with the
//! same state hash on every machine.

use std::f64::consts::PI;
use std::time::{Duration, Instant};

use glam::DVec2;
use maniple_geometry::contact::Straight;
use maniple_geometry::{Circle, Limits, ObjectId, Segment};
use maniple_kinematics::{EventKind, Layers, Leg, Part, Placement, Stops, Wall, WallError, WallKind, World};
use maniple_tilemap::TileMap;

/// Radius of every circle, in world units.
const RADIUS: f64 = 0.4;

/// Smallest and largest speed of a circle, in world units a cycle.
const SPEEDS: (f64, f64) = (0.1, 1.0);

/// A goal is at least this far away, in world units: whoever is at the edge of a world without walls turns inwards. Walls
/// keep everybody a radius away from the edge, so that nobody there turns more often for it.
const WAY_MIN: f64 = RADIUS / 2.0;

/// After so many places in a row that were taken, no more circles find room: less than a hundred-thousandth of the
/// ground is free.
const MISSES_MAX: u32 = 100_000;

/// Distance of the centres of those at rest, and twice their distance from the field, in world units.
const RESTING_PITCH: f64 = 1.0;

/// Room to the right of a field for those at rest, in world units: 4 million have 2,000 columns. It is there whether any
/// rest or not, so that the limits, and with them the march, do not depend on it.
const APART: f64 = 2048.0;

/// Cycles before the first one that is measured: by then all memory is taken and everybody has met a neighbour or two.
const WARM_UP: u32 = 10;

/// Where a march takes place: a rectangle with the origin in its corner.
#[derive(Clone, Debug)]
pub(super) struct Field {
    size: DVec2,
    walls: Vec<Wall>,
    ground: Ground,
}

/// Where in a field circles may start.
#[derive(Clone, Debug)]
enum Ground {
    /// Anywhere.
    Open,
    /// In the passable tiles of a map, by column and row.
    Tiles(Vec<(u32, u32)>),
}

/// Where everybody starts.
#[derive(Clone, Debug)]
pub(super) struct Scene {
    pub(super) field: Field,
    /// The centres of those who march, by id.
    pub(super) starts: Vec<DVec2>,
    /// How many rest apart.
    pub(super) resting: u32,
    seed: u64,
}

/// A march, between two cycles.
pub(super) struct March<'a> {
    scene: &'a Scene,
    pub(super) world: World,
    /// How many headings each has drawn.
    draws: Vec<u64>,
    /// Who has no heading.
    stopped: Vec<ObjectId>,
}

/// What a random number is for, so that no two are the same.
#[derive(Clone, Copy, Debug)]
pub(super) enum Purpose {
    Tile,
    StartX,
    StartY,
    Speed,
    HeadingX,
    HeadingY,
    GoalX,
    GoalY,
}

impl Field {
    /// Returns a square with four walls, of which so many circles cover the share `density`.
    pub(super) fn square(objects: u32, density: f64) -> Self {
        let side = (f64::from(objects) * PI * RADIUS * RADIUS / density).sqrt();
        let corner = |x, y| DVec2::new(x, y) * side;
        let corners = [corner(0.0, 0.0), corner(0.0, 1.0), corner(1.0, 1.0), corner(1.0, 0.0)];
        let wall = |place: usize| Wall {
            segment: Segment::new(corners[place], corners[(place + 1) % 4]),
            kind: WallKind::Edge,
            layers: Layers::GROUND,
        };
        Self { size: DVec2::splat(side), walls: (0..4).map(wall).collect(), ground: Ground::Open }
    }

    /// Returns the field of a map.
    pub(super) fn of_map(map: &TileMap) -> Self {
        let size = DVec2::new(f64::from(map.width()), f64::from(map.height()));
        let wall = |segment: Segment| {
            let Segment { start, end } = segment;
            let is_edge = (start.x == end.x && (start.x == 0.0 || start.x == size.x))
                || (start.y == end.y && (start.y == 0.0 || start.y == size.y));
            let kind = if is_edge { WallKind::Edge } else { WallKind::Segment };
            Wall { segment, kind, layers: Layers::GROUND }
        };
        let tiles = (0..map.height()).flat_map(|y| (0..map.width()).map(move |x| (x, y)));
        Self {
            size,
            walls: map.segments().into_iter().map(wall).collect(),
            ground: Ground::Tiles(tiles.filter(|&(x, y)| map.is_passable(x, y)).collect()),
        }
    }

    /// Returns the field with more walls.
    pub(super) fn walled(mut self, walls: &[Segment]) -> Self {
        let wall = |&segment: &Segment| Wall { segment, kind: WallKind::Segment, layers: Layers::GROUND };
        self.walls.extend(walls.iter().map(wall));
        self
    }

    /// Returns the field with nothing in it.
    pub(super) fn emptied(&self) -> Self {
        Self { walls: Vec::new(), ..self.clone() }
    }

    /// Returns how large it is, in world units.
    pub(super) fn size(&self) -> DVec2 {
        self.size
    }

    /// Returns the walls.
    pub(super) fn walls(&self) -> &[Wall] {
        &self.walls
    }

    /// Returns how many circles cover the share `density` of the ground, rounded down.
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "the cast stops at both ends"
    )]
    pub(super) fn capacity(&self, density: f64) -> u32 {
        let area = match &self.ground {
            Ground::Open => self.size.x * self.size.y,
            Ground::Tiles(tiles) => tiles.len() as f64,
        };
        (area * density / (PI * RADIUS * RADIUS)) as u32
    }

    /// Returns a world with the walls.
    fn world(&self) -> Result<World, WallError> {
        let reach = (self.size.x + APART).max(self.size.y);
        let limits = Limits::new(reach, RADIUS, SPEEDS.1).expect("a field is not larger than a map may be");
        World::new(limits, Stops::Both, &self.walls)
    }

    fn draw_start(&self, seed: u64, attempt: u64) -> DVec2 {
        let share =
            DVec2::new(unit(seed, Purpose::StartX, &[attempt]), unit(seed, Purpose::StartY, &[attempt]));
        match &self.ground {
            Ground::Open => share * self.size,
            Ground::Tiles(tiles) => {
                let bits = u128::from(keyed(seed, Purpose::Tile, &[attempt]));
                let tile = usize::try_from((bits * tiles.len() as u128) >> 64).expect("below the length");
                let (x, y) = tiles[tile];
                DVec2::new(f64::from(x), f64::from(y)) + share
            }
        }
    }

    /// Returns the point in which a heading from `center` leaves the field.
    fn goal(&self, center: DVec2, heading: DVec2) -> DVec2 {
        let way = |from: f64, along: f64, size: f64| {
            if along > 0.0 {
                (size - from) / along
            } else if along < 0.0 {
                -from / along
            } else {
                f64::INFINITY
            }
        };
        let length = way(center.x, heading.x, self.size.x).min(way(center.y, heading.y, self.size.y));
        (center + heading * length).clamp(DVec2::ZERO, self.size)
    }
}

impl Scene {
    /// Returns a scene with so many circles, or with as many of them as find room, each at a random place that is free
    /// (random sequential addition).
    ///
    /// # Errors
    /// A wall of the field that no world accepts.
    pub(super) fn place(field: Field, objects: u32, resting: u32, seed: u64) -> Result<Self, WallError> {
        let mut world = field.world()?;
        let mut starts = Vec::with_capacity(objects as usize);
        let (mut attempts, mut misses) = (0u64.., 0);
        for id in (0..objects).map(ObjectId) {
            while misses < MISSES_MAX {
                let start = field.draw_start(seed, attempts.next().expect("there is always another attempt"));
                if world.insert(id, Circle::new(start, RADIUS), Layers::GROUND).is_ok() {
                    starts.push(start);
                    misses = 0;
                    break;
                }
                misses += 1;
            }
        }
        Ok(Self { field, starts, resting, seed })
    }

    /// Returns the same places without walls.
    pub(super) fn emptied(&self) -> Self {
        Self { field: self.field.emptied(), ..self.clone() }
    }

    /// Returns how many march.
    pub(super) fn objects(&self) -> u32 {
        u32::try_from(self.starts.len()).expect("there is an id for each")
    }

    /// Returns the point on the rim of the field to which an object marches from `center`, and counts the draws.
    pub(super) fn goal(&self, object: ObjectId, draws: &mut u64, center: DVec2) -> DVec2 {
        loop {
            let goal = self.field.goal(center, self.heading(object, *draws));
            *draws += 1;
            if goal.distance_squared(center) >= WAY_MIN * WAY_MIN {
                return goal;
            }
        }
    }

    fn heading(&self, object: ObjectId, draw: u64) -> DVec2 {
        // A point of the unit disc, drawn again while it is none: no angle, whose sine would be rounded differently on
        // other machines. Nearly four in five are one.
        for attempt in 0.. {
            let axis = |purpose| 2.0 * unit(self.seed, purpose, &[u64::from(object.0), draw, attempt]) - 1.0;
            let point = DVec2::new(axis(Purpose::HeadingX), axis(Purpose::HeadingY));
            let square = point.dot(point);
            if 1e-6 < square && square < 1.0 {
                return point / square.sqrt();
            }
        }
        unreachable!("there is always another attempt")
    }

    fn speed(&self, object: ObjectId) -> f64 {
        SPEEDS.0 + (SPEEDS.1 - SPEEDS.0) * unit(self.seed, Purpose::Speed, &[u64::from(object.0)])
    }
}

impl<'a> March<'a> {
    /// Returns the march at its start: nobody has a heading yet.
    pub(super) fn new(scene: &'a Scene) -> Self {
        let objects = scene.objects();
        let columns = f64::from(scene.resting).sqrt().ceil();
        let mut world = scene.field.world().expect("the walls were accepted");
        world.reserve(objects as usize + scene.resting as usize);
        for (id, &start) in (0..).map(ObjectId).zip(&scene.starts) {
            world.insert(id, Circle::new(start, RADIUS), Layers::GROUND).expect("the start is free");
        }
        for place in 0..scene.resting {
            let row = (f64::from(place) / columns).floor();
            let cell = DVec2::new(f64::from(place) - row * columns + 1.5, row + 0.5);
            let center = DVec2::new(scene.field.size.x, 0.0) + cell * RESTING_PITCH;
            let inserted =
                world.insert(ObjectId(objects + place), Circle::new(center, RADIUS), Layers::GROUND);
            inserted.expect("nobody else is there");
        }
        let stopped = (0..objects).map(ObjectId).collect();
        Self { scene, world, draws: vec![0; objects as usize], stopped }
    }

    /// Simulates as many cycles as it takes until the next is like all others.
    pub(super) fn warm_up(&mut self) {
        for _ in 0..WARM_UP {
            self.order();
            self.step();
        }
    }

    /// Gives a new heading to everybody who has none.
    pub(super) fn order(&mut self) {
        for object in self.stopped.drain(..) {
            let center = self.world.circle(object).expect("nobody is taken out").center;
            let goal = self.scene.goal(object, &mut self.draws[object.0 as usize], center);
            let leg = Leg { goal, speed: self.scene.speed(object) };
            self.world.go(object, &[leg], Placement::Replace, None).expect("the goal is in the field");
        }
    }

    /// Simulates a cycle. A function of its own in every build, so that `tests/instructions.sh` finds it.
    #[inline(never)]
    pub(super) fn step(&mut self) -> Cycled {
        let begun = Instant::now();
        let (mut last, mut parts) = (begun, [Duration::ZERO; Part::ALL.len()]);
        let events = self.world.step_by_parts(|part| {
            let now = Instant::now();
            parts[part as usize] = now - last;
            last = now;
        });
        let took = last - begun;
        let mut collisions = 0;
        for event in events {
            collisions += match event.kind {
                EventKind::Object | EventKind::Segment | EventKind::Edge => 1,
                EventKind::Arrived | EventKind::Ordered => 0,
            };
            if event.rests {
                self.stopped.push(event.object);
            }
        }
        Cycled { took, parts, collisions }
    }

    /// Returns everybody who marches as going straight on for the whole of the next cycle, by id: also the few who are going
    /// to arrive within it.
    pub(super) fn straights(&self) -> Vec<Straight> {
        let straight = |id| {
            let Circle { center, radius } = self.world.circle(id)?;
            Some(Straight { point: center, velocity: self.world.motion(id)?.velocity, radius })
        };
        let ids = (0..self.scene.objects()).map(ObjectId);
        ids.map(|id| straight(id).expect("nobody is taken out")).collect()
    }
}

/// What a cycle of a march took.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cycled {
    /// The time for the cycle alone, without the orders.
    pub(super) took: Duration,
    /// The time for each of [`Part::ALL`].
    pub(super) parts: [Duration; Part::ALL.len()],
    /// How often an object stopped because of another one, a wall or the edge.
    pub(super) collisions: u64,
}

/// Returns 64 random bits that depend on nothing but the arguments (the mixing function of SplitMix64: Steele, Lea,
/// Flood, *Fast Splittable Pseudorandom Number Generators*, 2014, §5).
fn keyed(seed: u64, purpose: Purpose, parts: &[u64]) -> u64 {
    [seed, purpose as u64].iter().chain(parts).fold(0u64, |bits, part| {
        let mut mixed = bits.wrapping_add(*part).wrapping_add(0x9e37_79b9_7f4a_7c15);
        mixed = (mixed ^ (mixed >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        mixed ^ (mixed >> 31)
    })
}

/// Returns a random number in `0.0..1.0`: the upper 53 of the bits, as many as a double holds.
pub(super) fn unit(seed: u64, purpose: Purpose, parts: &[u64]) -> f64 {
    (keyed(seed, purpose, parts) >> 11) as f64 / (1u64 << 53) as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_scene_covers_its_share_and_starts_without_an_overlap() {
        let field = Field::square(500, 0.25);
        assert!((499..=500).contains(&field.capacity(0.25)));
        let scene = Scene::place(field, 500, 30, 7).expect("walls");
        assert_eq!(scene.starts.len(), 500);
        let march = March::new(&scene);
        assert_eq!((march.world.len(), march.world.overlaps()), (530, Vec::new()));
    }

    #[test]
    fn a_seed_decides_the_scene() {
        let starts = |seed| Scene::place(Field::square(50, 0.05), 50, 0, seed).expect("walls").starts;
        assert_eq!(starts(1), starts(1));
        assert_ne!(starts(1), starts(2));
    }

    #[test]
    fn everybody_moves_in_every_cycle_with_and_without_walls() {
        let scene = Scene::place(Field::square(300, 0.3), 300, 20, 7).expect("walls");
        for scene in [&scene, &scene.emptied()] {
            let mut march = March::new(scene);
            let mut collisions = 0;
            for _ in 0..60 {
                march.order();
                collisions += march.step().collisions;
                assert_eq!(march.world.activity().runners, 300);
            }
            assert!(collisions > 300, "{collisions}");
        }
    }

    #[test]
    fn a_goal_lies_where_the_heading_leaves_the_field() {
        let field = Field::square(1000, 0.05);
        let side = field.size.x;
        let check = |heading: (f64, f64), expected: (f64, f64)| {
            assert_eq!(field.goal(DVec2::new(2.0, 3.0), heading.into()), expected.into());
        };
        check((1.0, 0.0), (side, 3.0));
        check((-1.0, 0.0), (0.0, 3.0));
        check((0.0, -1.0), (2.0, 0.0));
        check((-0.5, -0.5), (0.0, 1.0));
    }
}
