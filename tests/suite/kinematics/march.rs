//! Many circles that march on random headings and turn where they are stopped, in a box or on a map.

use glam::DVec2;
use maniple_geometry::{Circle, Limits, ObjectId, Segment};
use maniple_kinematics::{Layers, Leg, Placement, Settings, Stops, Wall, WallKind, World};

/// Radius of everybody, in world units.
const RADIUS: f64 = 0.4;

/// Where a march takes place: a rectangle from the origin on, and its walls.
#[derive(Clone, Debug)]
pub(crate) struct Field {
    pub(crate) size: DVec2,
    pub(crate) walls: Vec<Wall>,
}

/// A march, between two cycles.
pub(crate) struct March {
    pub(crate) world: World,
    size: DVec2,
    seed: u64,
    /// By id: how many headings were drawn.
    draws: Vec<u64>,
    stopped: Vec<ObjectId>,
}

impl Field {
    /// A square box with so many short walls in it.
    pub(crate) fn boxed(side: f64, walls: u64, seed: u64) -> Self {
        let corners = [(0.0, 0.0), (0.0, side), (side, side), (side, 0.0)].map(DVec2::from);
        let edge = |place: usize| wall(corners[place], corners[(place + 1) % 4], WallKind::Edge);
        let inner = |number: u64| {
            let share = |purpose: u64| unit(&[seed, purpose, number]);
            let start = DVec2::new(share(1), share(2)) * side;
            let way = DVec2::new(share(3) - 0.5, share(4) - 0.5) * 12.0;
            wall(start, (start + way).clamp(DVec2::ZERO, DVec2::splat(side)), WallKind::Segment)
        };
        let walls = (0..4).map(edge).chain((0..walls).map(inner)).collect();
        Self { size: DVec2::splat(side), walls }
    }

    /// Random places for so many circles on the ground, clear of the walls and of each other, by id.
    pub(crate) fn places(
        &self,
        objects: u32,
        seed: u64,
        is_ground: impl Fn(DVec2) -> bool,
    ) -> Vec<(u32, DVec2)> {
        let mut world = self.world(Settings::exact(Stops::Both));
        let mut places = Vec::new();
        for attempt in 0.. {
            let id = u32::try_from(places.len()).expect("few objects");
            if id == objects {
                break;
            }
            assert!(attempt < 1000 * u64::from(objects), "only {id} of {objects} find room");
            let center = DVec2::new(unit(&[seed, 5, attempt]), unit(&[seed, 6, attempt])) * self.size;
            if is_ground(center)
                && world.insert(ObjectId(id), Circle::new(center, RADIUS), Layers::GROUND).is_ok()
            {
                places.push((id, center));
            }
        }
        places
    }

    fn world(&self, settings: Settings) -> World {
        let limits = Limits::new(self.size.max_element(), RADIUS, 1.0).expect("the field has a size");
        World::new(limits, settings, &self.walls).expect("the walls are in the field")
    }
}

impl March {
    /// The march from places on, in which objects are inserted in the order of the list.
    pub(crate) fn new(field: &Field, places: &[(u32, DVec2)], seed: u64) -> Self {
        Self::under(Settings::exact(Stops::Both), field, places, seed)
    }

    /// As [`March::new`], under other settings.
    pub(crate) fn under(settings: Settings, field: &Field, places: &[(u32, DVec2)], seed: u64) -> Self {
        let mut world = field.world(settings);
        world.reserve(places.len());
        for &(id, center) in places {
            world.insert(ObjectId(id), Circle::new(center, RADIUS), Layers::GROUND).expect("a free place");
        }
        let ids = || (0..).map(ObjectId).take(places.len());
        Self { world, size: field.size, seed, draws: vec![0; places.len()], stopped: ids().collect() }
    }

    /// Gives a new heading to everybody who has none: a goal on the rim of the field.
    pub(crate) fn order(&mut self) {
        for id in self.stopped.drain(..) {
            let draws = &mut self.draws[id.0 as usize];
            let share = |purpose: u64| unit(&[self.seed, purpose, u64::from(id.0), *draws]);
            let along = share(7);
            let goal = match share(8) {
                side if side < 0.25 => DVec2::new(along, 0.0),
                side if side < 0.5 => DVec2::new(along, 1.0),
                side if side < 0.75 => DVec2::new(0.0, along),
                _ => DVec2::new(1.0, along),
            };
            *draws += 1;
            let speed = 0.1 + 0.9 * unit(&[self.seed, 9, u64::from(id.0)]);
            let leg = Leg { goal: goal * self.size, speed };
            self.world.go(id, &[leg], Placement::Replace, None).expect("the goal is in the field");
        }
    }

    /// Simulates a cycle; returns how much happened.
    pub(crate) fn step(&mut self) -> usize {
        let events = self.world.step();
        self.stopped.extend(events.iter().filter(|event| event.rests).map(|event| event.object));
        events.len()
    }
}

pub(crate) fn wall(start: DVec2, end: DVec2, kind: WallKind) -> Wall {
    Wall { segment: Segment::new(start, end), kind, layers: Layers::GROUND }
}

/// A number in 0..1 that depends on all parts (the mixing function of SplitMix64).
pub(crate) fn unit(parts: &[u64]) -> f64 {
    let bits = parts.iter().fold(0u64, |bits, part| {
        let mut mixed = bits.wrapping_add(*part).wrapping_add(0x9e37_79b9_7f4a_7c15);
        mixed = (mixed ^ (mixed >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        mixed ^ (mixed >> 31)
    });
    (bits >> 11) as f64 / (1u64 << 53) as f64
}
