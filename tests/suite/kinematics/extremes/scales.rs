//! Numbers of very different sizes in one scene, and of sizes at the end of what is accepted.

use glam::DVec2;
use maniple_geometry::Limits;
use maniple_geometry::limits::{COORDINATE_MAX, RADIUS_MAX, RADIUS_MIN, SPEED_MAX, SPEED_MIN, TINY};
use maniple_kinematics::EventKind;

use super::super::scene::{Random, Scene};
use super::site::{Site, across, direction, logarithmic, nudged};
use super::tally::Tally;

/// Scenes of each class in the ordinary run.
const SCENES: u64 = 500;

/// Share of the plane that the circles of a packing cover.
const PACKED: f64 = 0.90;

/// What a scene of mixed sizes is made of: clusters of circles that are near each other or touch, and others that come
/// from afar, most of them aimed at the rim of somebody.
#[derive(Clone, Copy, Debug)]
struct Sizes {
    /// Largest coordinate, declared and used.
    coordinates: f64,
    radii: (f64, f64),
    speeds: (f64, f64),
    /// Edge of a cluster.
    cluster: f64,
    /// Whether clusters are in the corners of the world only.
    is_far: bool,
}

/// The world limits that the core promises at least, all together.
const PROMISED: Sizes =
    Sizes { coordinates: 1e6, radii: (1e-3, 1e3), speeds: (1e-9, 1e4), cluster: 4e3, is_far: false };

#[test]
fn a_packing_of_nine_tenths_that_is_sent_to_one_point_never_overlaps() {
    Tally::of("hexagonal packing at 0.90, all to one point", 120, packing);
}

#[test]
fn speeds_of_all_sizes_in_one_scene_miss_nothing() {
    let sizes = Sizes { radii: (0.1, 10.0), speeds: (SPEED_MIN, 1e6), cluster: 60.0, ..PROMISED };
    const { assert!(SPEED_MIN <= 1e-12 && 1e6 <= SPEED_MAX, "what is asked for") };
    Tally::of("speeds 1e-12 to 1e6 mixed", SCENES, |random| sizes.scene(random));
}

#[test]
fn radii_of_all_sizes_in_one_scene_miss_nothing() {
    let sizes = Sizes { coordinates: 8192.0, radii: (1e-6, 1e3), speeds: (1e-6, 1e3), ..PROMISED };
    const { assert!(RADIUS_MIN <= 1e-6 && 1e3 <= RADIUS_MAX, "what is asked for") };
    Tally::of("radii 1e-6 to 1e3 mixed", SCENES, |random| sizes.scene(random));
}

#[test]
fn coordinates_of_a_billion_miss_nothing() {
    let sizes =
        Sizes { coordinates: 1e9, radii: (0.1, 1e3), speeds: (1e-3, 1e4), cluster: 2e3, is_far: true };
    const { assert!(1e9 <= COORDINATE_MAX, "what is asked for") };
    Tally::of("coordinates to 1e9", SCENES, |random| sizes.scene(random));
}

#[test]
fn the_declared_limits_hold_all_together_in_one_scene() {
    Tally::of("promised limits, all together", 2 * SCENES, |random| PROMISED.scene(random));
}

#[test]
fn the_largest_limits_hold_all_together_in_one_scene() {
    let sizes = Sizes {
        coordinates: COORDINATE_MAX,
        radii: (RADIUS_MIN, RADIUS_MAX),
        speeds: (SPEED_MIN, SPEED_MAX),
        cluster: 2e5,
        is_far: false,
    };
    Tally::of("largest limits, all together", SCENES, |random| sizes.scene(random));
}

#[test]
fn moves_of_no_length_to_speak_of_are_made_or_refused() {
    Tally::checked("zero-length moves", 3000, tiny_moves, |scene, played| {
        // Whoever was sent to where it is has arrived there at once.
        for order in &scene.orders {
            let stays = order.cycle == 0 && order.legs[0].0 == scene.objects[order.id as usize].1;
            let arrived = |event: &maniple_kinematics::Event| {
                event.object.0 == order.id && event.kind == EventKind::Arrived && event.time == 0.0
            };
            assert!(!stays || played.events.iter().any(arrived), "{order:?}: {:?}", played.events);
        }
    });
}

impl Sizes {
    fn scene(&self, random: &mut Random) -> Scene {
        let limits = Limits::new(self.coordinates, self.radii.1, self.speeds.1).expect("good limits");
        let mut site = Site::new(limits, random, &[]);
        for _ in 0..1 + random.below(3) {
            self.add_cluster(&mut site, random);
        }
        for _ in 0..6 {
            // Those who come from afar, a way of a cycle or two.
            let far = logarithmic(
                random,
                (self.cluster, self.coordinates.min(4.0 * self.speeds.1).max(2.0 * self.cluster)),
            );
            let target = random.pick(&site.scene.objects).1;
            let radius = logarithmic(random, self.radii);
            let place = self.inside(target + direction(random) * far);
            site.put(place, radius);
        }
        for cycle in [0, 0, 2] {
            for id in site.ids() {
                if random.chance(0.6) {
                    self.order(&mut site, random, cycle, id);
                }
            }
        }
        site.scene.orders.sort_by_key(|order| order.cycle);
        site.scene(5)
    }

    fn add_cluster(&self, site: &mut Site, random: &mut Random) {
        let reach = self.coordinates - 2.0 * self.cluster;
        let corner = |random: &mut Random| random.pick(&[-reach, reach]);
        let middle = if self.is_far || random.chance(0.5) {
            DVec2::new(corner(random), corner(random))
        } else {
            DVec2::new(random.between(-reach, reach), 0.0) * random.pick(&[0.0, 0.01, 1.0])
        };
        let mut last = None;
        for _ in 0..8 {
            let radius = logarithmic(random, self.radii);
            last = match last {
                Some(id) if random.chance(0.6) => {
                    let way = direction(random);
                    let place = site.center(id) + way * (site.radius(id) + radius);
                    site.put_outwards(self.inside(place), way, radius).or(last)
                }
                Some(_) | None => {
                    let mut axis = || self.cluster * random.between(-0.5, 0.5);
                    let place = middle + DVec2::new(axis(), axis());
                    site.put(self.inside(place), radius).or(last)
                }
            };
        }
    }

    /// An order to pass somebody at the sum of the radii, up to the last bits, to go straight at it, or to go just so far.
    fn order(&self, site: &mut Site, random: &mut Random, cycle: u32, id: u32) {
        let (from, radius) = (site.center(id), site.radius(id));
        let speed = logarithmic(random, self.speeds);
        let target = random.pick(&site.scene.objects);
        let offset = target.1 - from;
        let length = offset.length();
        if target.0 == id || length == 0.0 {
            return;
        }
        let reach = radius + target.2;
        let side = if random.chance(0.5) { reach } else { -reach };
        let rim = if random.chance(0.7) {
            // Where the tangent from here touches the circle of that radius around the other.
            let (sine, cosine) = (side / length, (1.0 - (side / length).powi(2)).max(0.0).sqrt());
            from + DVec2::new(cosine, sine).rotate(offset) * cosine
        } else {
            target.1
        };
        let beyond = random.pick(&[0.5, 1.0, 2.0]);
        let goal = from + (rim - from) * beyond + across(offset) * random.pick(&[0.0, 0.0, 1e-3]);
        // Who is slow would never get there: it goes as far as it comes in a cycle or two.
        let cycles = length / speed;
        let goal = if cycles > 16.0 {
            from + (goal - from) * (random.pick(&[0.5, 1.0, 1.5]) / cycles)
        } else {
            goal
        };
        let goal = self.inside(nudged(random, goal, 2));
        if goal != from || cycle == 0 {
            site.go(cycle, id, goal, speed);
        }
    }

    fn inside(&self, point: DVec2) -> DVec2 {
        point.clamp(DVec2::splat(-self.coordinates), DVec2::splat(self.coordinates))
    }
}

/// Hexagonally packed circles that are all sent to one point, again and again.
fn packing(random: &mut Random) -> Scene {
    let limits = Limits::new(2048.0, 16.0, 64.0).expect("good limits");
    let mut site = Site::new(limits, random, &[]);
    let radius = random.pick(&[0.01, 0.5, 2.0]) * random.between(0.9, 1.1);
    // A hexagonal packing of circles that touch covers π / (2 √3).
    let full = std::f64::consts::PI / (2.0 * 3f64.sqrt());
    let pitch = 2.0 * radius * (full / PACKED).sqrt();
    let (columns, rows) = (5 + random.below(5), 5 + random.below(5));
    let corner = DVec2::new(random.between(-999.0, 900.0), random.between(-999.0, 900.0));
    for row in 0..rows {
        for column in 0..columns {
            let shift = if row % 2 == 0 { 0.0 } else { 0.5 };
            let place = DVec2::new(f64::from(column) + shift, f64::from(row) * 0.75f64.sqrt());
            site.put(corner + place * pitch, radius).expect("there is a gap");
        }
    }
    let across = DVec2::new(f64::from(columns), f64::from(rows)) * pitch;
    let point = corner + across * DVec2::new(random.unit(), random.unit());
    for cycle in 0..8 {
        let speed = radius * random.between(0.05, 8.0);
        for id in site.ids() {
            if cycle == 0 || random.chance(0.8) {
                site.go(cycle, id, point, speed);
            }
        }
    }
    site.scene(8)
}

/// Circles in touch that are sent hardly further than where they are.
fn tiny_moves(random: &mut Random) -> Scene {
    let limits = Limits::new(1e6, 2.0, 1e4).expect("good limits");
    let mut site = Site::new(limits, random, &[]);
    let origin =
        random.pick(&[DVec2::ZERO, DVec2::new(0.0, 5.0), DVec2::new(300.0, -7.0), DVec2::new(1e6, 1e6)]);
    let origin = origin * 0.9999;
    let radius = random.pick(&[0.5, 1e-3, 0.7]);
    site.put(origin, radius).expect("the plane is empty");
    for way in [DVec2::X, DVec2::Y, direction(random)] {
        site.put_outwards(origin + way * (2.0 * radius), way, radius);
    }
    for cycle in 0..2 {
        for id in site.ids() {
            let (from, towards) = (site.center(id), origin - site.center(id));
            let way = random.pick(&[towards, -towards, across(towards), DVec2::X, DVec2::Y]);
            let goal = match random.below(4) {
                0 => from,
                1 => nudged(random, from, 1),
                2 => from + way * random.pick(&[1e-15, 1e-12, 1e-9]),
                _ => from + DVec2::new(random.pick(&[TINY, 2.0 * TINY, 0.0]), random.pick(&[0.0, TINY])),
            };
            let speed = logarithmic(random, (SPEED_MIN, 1e4));
            if random.chance(0.8) {
                site.go(cycle, id, goal, speed);
            }
        }
    }
    site.scene(4)
}
