//! Worlds in which nothing is even: radii and speeds of all sizes, everybody in one corner, a giant among dwarfs,
//! coordinates far from the origin. The core agrees with its slow twin there, and crowds of thousands never overlap.

use glam::DVec2;
use maniple_geometry::{Circle, Limits, ObjectId, Segment};
use maniple_kinematics::{Layers, Stops, Wall, World};

use super::agreement::check_all;
use super::scene::{Order, Random, Scene};

/// Scenes of each class in the ordinary run; `MANIPLE_LONG=1` plays twenty times as many.
const SCENES: u64 = 200;

/// Objects of a crowd that is too large for the twin.
const CROWD: u32 = 5000;

/// Smallest and largest radius and speed, in world units and world units a cycle.
const RADII: (f64, f64) = (0.1, 16.0);
const SPEEDS: (f64, f64) = (0.01, 50.0);

/// What a scene of this file is made of.
#[derive(Clone, Copy, Debug)]
struct Class {
    /// Corner of the box that has the smallest coordinates.
    corner: f64,
    /// Edge of the box.
    size: f64,
    /// Who there is, at most.
    objects: u32,
    /// Whether everybody is sent to one corner.
    gathers: bool,
    radius: fn(&mut Random, u32) -> f64,
}

const MIXED: Class = Class { corner: 0.0, size: 160.0, objects: 60, gathers: false, radius: any_radius };
const CORNER: Class = Class { gathers: true, size: 35.0, radius: small_radius, ..MIXED };
const GIANT: Class = Class { radius: one_giant, size: 45.0, ..MIXED };
const FAR: Class = Class { corner: 1e6, ..MIXED };
const FAR_CORNER: Class = Class { corner: -1e6, ..CORNER };

#[test]
fn radii_and_speeds_of_all_sizes_agree_with_the_slow_twin() {
    agree("mixed", MIXED);
}

#[test]
fn everybody_in_one_corner_agrees_with_the_slow_twin() {
    agree("corner", CORNER);
}

#[test]
fn a_giant_among_dwarfs_agrees_with_the_slow_twin() {
    agree("giant", GIANT);
}

#[test]
fn a_world_far_from_the_origin_agrees_with_the_slow_twin() {
    agree("far", FAR);
    agree("far corner", FAR_CORNER);
}

#[test]
fn thousands_of_all_sizes_never_overlap() {
    check_crowd(Class { size: 2800.0, ..MIXED }, 1.0);
}

#[test]
fn thousands_who_crowd_into_one_corner_never_overlap() {
    check_crowd(Class { size: 250.0, ..CORNER }, 20.0);
}

#[test]
fn a_giant_among_thousands_of_dwarfs_never_overlaps() {
    check_crowd(Class { size: 110.0, ..GIANT }, 1.0);
}

#[test]
fn thousands_far_from_the_origin_never_overlap() {
    check_crowd(Class { size: 250.0, ..FAR_CORNER }, 20.0);
}

fn agree(name: &str, class: Class) {
    check_all(name, SCENES, 20, |random| {
        let mut scene = class.scene(random);
        for _ in 0..2 * scene.objects.len() {
            let cycle = random.below(scene.cycles);
            let order = class.order(random, &scene, cycle, 1.0);
            scene.orders.push(order);
        }
        scene.orders.sort_by_key(|order| order.cycle);
        scene
    });
}

/// Lets thousands go for 20 cycles, a third of them somewhere else in each; `faster` is how much faster than usual.
fn check_crowd(class: Class, faster: f64) {
    let seed = 31;
    println!("seed {seed}");
    let mut random = Random(seed);
    let mut scene = Class { objects: CROWD, ..class }.scene(&mut random);
    assert!(scene.objects.len() > CROWD as usize / 2, "only {} find room", scene.objects.len());
    scene.cycles = 20;
    for cycle in 0..scene.cycles {
        for _ in 0..scene.objects.len() / 3 {
            let order = class.order(&mut random, &scene, cycle, faster);
            scene.orders.push(order);
        }
    }
    // Scene::play checks every state.
    let (world, events, _) = scene.play();
    println!("{} objects, {} events", world.len(), events.len());
    assert!(events.len() > 1000, "{}", events.len());
}

impl Class {
    /// Objects at random places in a box with a few walls, without orders.
    fn scene(&self, random: &mut Random) -> Scene {
        let stops = random.pick(&[Stops::Both, Stops::Approaching]);
        let reach = self.corner.abs() + self.size;
        let mut scene = Scene::boxed(self.size, stops).cycles(4 + random.below(9));
        scene.limits = Limits::new(reach, RADII.1, 20.0 * SPEEDS.1).unwrap();
        for _ in 0..random.below(6) {
            let (from, to) = (self.place(random), self.place(random));
            scene = scene.wall((from - self.corner).into(), (to - self.corner).into());
        }
        scene.walls = scene.walls.iter().map(|wall| self.moved(wall)).collect();
        let mut world = World::new(scene.limits, stops, &scene.walls).unwrap();
        for id in 0..self.objects {
            let (center, radius) = (self.place(random), (self.radius)(random, id));
            if world.insert(ObjectId(id), Circle::new(center, radius), Layers::GROUND).is_ok() {
                scene.objects.push((id, center, radius, 1));
            }
        }
        scene
    }

    /// An order to one of the objects to go somewhere, often by a detour.
    fn order(&self, random: &mut Random, scene: &Scene, cycle: u32, faster: f64) -> Order {
        let id = random.pick(&scene.objects).0;
        let legs = (0..1 + random.below(2)).map(|_| {
            let goal = if self.gathers { self.place_in_corner(random) } else { self.place(random) };
            (goal, faster * logarithmic(random, SPEEDS))
        });
        let legs = legs.collect();
        Order { cycle, id, legs, queue: random.chance(0.2), start: None }
    }

    fn place(&self, random: &mut Random) -> DVec2 {
        let mut axis = || self.corner + random.between(0.0, self.size);
        DVec2::new(axis(), axis())
    }

    fn place_in_corner(&self, random: &mut Random) -> DVec2 {
        let mut axis = || self.corner + random.between(0.0, 0.1 * self.size);
        DVec2::new(axis(), axis())
    }

    fn moved(&self, wall: &Wall) -> Wall {
        let Segment { start, end } = wall.segment;
        Wall { segment: Segment::new(start + self.corner, end + self.corner), ..*wall }
    }
}

fn any_radius(random: &mut Random, _: u32) -> f64 {
    logarithmic(random, RADII)
}

fn small_radius(random: &mut Random, _: u32) -> f64 {
    logarithmic(random, (RADII.0, 16.0 * RADII.0))
}

fn one_giant(random: &mut Random, id: u32) -> f64 {
    if id == 0 { RADII.1 } else { random.between(RADII.0, 4.0 * RADII.0) }
}

/// A number of which each order of magnitude between two numbers is as likely: the smaller times a whole power of two and
/// a bit, so that no logarithm is rounded.
fn logarithmic(random: &mut Random, (low, high): (f64, f64)) -> f64 {
    let mut doublings = 0;
    let mut reach = low;
    while 2.0 * reach <= high {
        reach *= 2.0;
        doublings += 1;
    }
    let mut value = low * random.between(1.0, 2.0);
    for _ in 0..random.below(doublings + 1) {
        value *= 2.0;
    }
    if value < high { value } else { high }
}
