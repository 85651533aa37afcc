//! Where an adversarial scene is put together: places that touch to the last bit but do not overlap.

use glam::DVec2;
use maniple_geometry::{Circle, Limits, ObjectId, Scalar, Segment};
use maniple_kinematics::{Layers, Stops, Wall, WallKind, World};

use super::super::scene::{Order, Random, Scene};

/// How often a place is moved outwards by another few bits before it is given up.
const NUDGES_MAX: u32 = 64;

/// Whole vectors of a whole length (x, y, length): ways along them can touch without any rounding.
pub(super) const TRIPLES: [(f64, f64, f64); 8] = [
    (1.0, 0.0, 1.0),
    (0.0, 1.0, 1.0),
    (-1.0, 0.0, 1.0),
    (3.0, 4.0, 5.0),
    (-4.0, 3.0, 5.0),
    (5.0, -12.0, 13.0),
    (-8.0, -15.0, 17.0),
    (24.0, 7.0, 25.0),
];

/// A scene under construction; everything in it was accepted.
pub(super) struct Site {
    pub(super) scene: Scene,
    world: World,
}

impl Site {
    /// An endless plane with these walls.
    pub(super) fn new(limits: Limits, random: &mut Random, walls: &[(DVec2, DVec2)]) -> Self {
        let stops = random.pick(&[Stops::Both, Stops::Approaching]);
        let wall = |&(start, end): &(DVec2, DVec2)| Wall {
            segment: Segment::new(flushed(start), flushed(end)),
            kind: WallKind::Segment,
            layers: Layers::GROUND,
        };
        let walls: Vec<Wall> = walls.iter().map(wall).collect();
        let world = World::new(limits, stops, &walls).expect("the walls are good");
        let (objects, orders) = (Vec::new(), Vec::new());
        Self { scene: Scene { limits, stops, walls, objects, orders, cycles: 1 }, world }
    }

    /// Puts a circle in, with the next id, if it is free of all others.
    pub(super) fn put(&mut self, center: DVec2, radius: f64) -> Option<u32> {
        let id = u32::try_from(self.scene.objects.len()).expect("few objects");
        let center = flushed(center);
        self.world.insert(ObjectId(id), Circle::new(center, radius), Layers::GROUND).ok()?;
        self.scene.objects.push((id, center, radius, Layers::GROUND.0));
        Some(id)
    }

    /// Puts a circle in at a place, or as few bits outwards of it as it takes.
    pub(super) fn put_outwards(&mut self, center: DVec2, outwards: DVec2, radius: f64) -> Option<u32> {
        let size = center.x.abs() + center.y.abs() + radius;
        let step = outwards * (0.5 * f64::EPSILON * size / outwards.length());
        (0..NUDGES_MAX).find_map(|nudges| self.put(center + step * f64::from(nudges), radius))
    }

    pub(super) fn go(&mut self, cycle: u32, id: u32, goal: DVec2, speed: f64) {
        let legs = vec![(flushed(goal), speed)];
        self.scene.orders.push(Order { cycle, id, legs, queue: false, start: None });
    }

    pub(super) fn center(&self, id: u32) -> DVec2 {
        self.scene.objects[id as usize].1
    }

    pub(super) fn radius(&self, id: u32) -> f64 {
        self.scene.objects[id as usize].2
    }

    /// The objects, by id.
    pub(super) fn ids(&self) -> std::ops::Range<u32> {
        0..u32::try_from(self.scene.objects.len()).expect("few objects")
    }

    pub(super) fn scene(self, cycles: u32) -> Scene {
        self.scene.cycles(cycles)
    }
}

/// The velocity that an order to go from a point to a goal gives.
pub(super) fn velocity(point: DVec2, goal: DVec2, speed: f64) -> DVec2 {
    let way = goal - point;
    flushed(way * (speed / way.dot(way).sqrt()))
}

/// The vector a quarter turn further.
pub(super) fn across(way: DVec2) -> DVec2 {
    DVec2::new(-way.y, way.x)
}

/// A vector of length 1, up to rounding.
pub(super) fn direction(random: &mut Random) -> DVec2 {
    let angle = random.between(0.0, std::f64::consts::TAU);
    DVec2::new(angle.cos(), angle.sin())
}

/// A point whose coordinates are up to so many units in the last place away.
pub(super) fn nudged(random: &mut Random, point: DVec2, ulps: u32) -> DVec2 {
    let mut nudge = |value: f64| {
        let steps = random.below(2 * ulps + 1);
        let (mut value, up) = (value, steps > ulps);
        for _ in 0..steps.abs_diff(ulps) {
            value = if up { value.next_up() } else { value.next_down() };
        }
        value
    };
    flushed(DVec2::new(nudge(point.x), nudge(point.y)))
}

/// A number of which each order of magnitude between two numbers is as likely.
pub(super) fn logarithmic(random: &mut Random, (low, high): (f64, f64)) -> f64 {
    (low * (high / low).powf(random.unit())).clamp(low, high)
}

/// A whole number in that range, both ends included, small ones as likely as large ones.
pub(super) fn count(random: &mut Random, (low, high): (u32, u32)) -> u32 {
    let count = logarithmic(random, (f64::from(low), f64::from(high) + 0.999));
    (low..=high).take_while(|&number| f64::from(number) <= count).last().unwrap_or(low)
}

fn flushed(vector: DVec2) -> DVec2 {
    DVec2::new(vector.x.flushed() + 0.0, vector.y.flushed() + 0.0)
}
