//! Walls where they are hard: at their ends and joints, a diameter apart, and hardly longer than nothing.

use std::cell::Cell;

use glam::DVec2;
use maniple_geometry::Limits;
use maniple_kinematics::EventKind;

use super::super::scene::{Random, Scene};
use super::site::{Site, TRIPLES, across, direction, logarithmic, nudged, velocity};
use super::tally::{Played, Tally};
use crate::rational::{Exact, number};

const SCENES: u64 = 2000;

/// Largest speed of these scenes.
const SPEED_MAX: f64 = 64.0;

/// What passes where a way is nearest to it.
#[derive(Clone, Copy, PartialEq)]
enum Corner {
    End,
    Joint,
    /// A wall of this length.
    Short(f64),
}

#[test]
fn the_end_of_a_wall_is_hit_exactly_when_it_is_nearer_than_the_radius() {
    let stopped = Cell::new(0);
    let make = |random: &mut Random| corner(random, Corner::End);
    Tally::checked("corner: end of a segment ± 8 ulp", SCENES, make, |_, played| count(&stopped, played));
    assert_both(&stopped);
}

#[test]
fn the_joint_of_two_walls_is_hit_exactly_when_it_is_nearer_than_the_radius() {
    let stopped = Cell::new(0);
    let make = |random: &mut Random| corner(random, Corner::Joint);
    Tally::checked("corner: joint of two segments ± 8 ulp", SCENES, make, |_, played| {
        count(&stopped, played);
    });
    assert_both(&stopped);
}

#[test]
fn a_wall_of_no_length_to_speak_of_is_hit_exactly_when_it_is_nearer_than_the_radius() {
    let stopped = Cell::new(0);
    let make = |random: &mut Random| {
        let length = logarithmic(random, (1e-9, 1e-8));
        corner(random, Corner::Short(length))
    };
    Tally::checked("segments 1e-9 long", SCENES, make, |_, played| count(&stopped, played));
    assert_both(&stopped);
}

#[test]
fn a_corridor_is_passed_exactly_when_it_is_as_wide_as_the_circle() {
    let stopped = Cell::new(0);
    let tally = Tally::checked("corridors of 2r ± 4 ulp", SCENES, corridor, |scene, played| {
        count(&stopped, played);
        if scene.objects.len() == 1 && is_level(scene) {
            // Nothing is rounded on this way, so that the width alone decides.
            let goal = scene.orders[0].legs[0].0;
            let is_through =
                played.world.circle(maniple_geometry::ObjectId(0)).expect("it is there").center == goal;
            assert_eq!(is_through, is_wide(scene), "{scene:?}");
        }
    });
    assert_both(&stopped);
    assert!(tally.retreats > 0, "in slanted corridors rounding alone makes some of them overlap");
}

/// One circle whose way passes a corner at its radius.
fn corner(random: &mut Random, corner: Corner) -> Scene {
    let size: f64 = random.pick(&[1.0, 100.0, 1e6]);
    let is_exact = random.chance(0.5);
    let (x, y, length) = random.pick(&TRIPLES);
    let radius = if is_exact { 5.0 * 13.0 * 17.0 * 5.0 / 4096.0 } else { random.between(0.1, 2.0) };
    let (start, way) = if is_exact {
        (point(random, size.min(64.0)).floor() / 4.0, DVec2::new(x, y))
    } else {
        (point(random, size), direction(random))
    };
    let speed = if is_exact { length } else { random.between(0.1, 0.5 * SPEED_MAX) };
    let goal = start + way * 64.0;
    let when = if is_exact { f64::from(4 + random.below(12)) / 8.0 } else { random.between(0.0, 2.0) };
    let side = if random.chance(0.5) { 1.0 } else { -1.0 };
    let beside = across(way) * (side * radius / way.length());
    let ulps = random.pick(&[0, 2, 8]);
    let passed = nudged(random, start + velocity(start, goal, speed) * when + beside, ulps);
    let mut walls = Vec::new();
    // Away from the way, or along it to the last bit.
    let mut arm = |random: &mut Random, length: f64| {
        let away = beside / radius;
        let turned = DVec2::from_angle(random.between(-1.5, 1.5)).rotate(away);
        let way = random.pick(&[away, turned, across(away), -across(away)]);
        walls.push((passed, passed + way * length));
    };
    match corner {
        Corner::End => arm(random, 3.0),
        Corner::Joint => {
            arm(random, 2.0);
            arm(random, 2.5);
        }
        // Far out there are no two doubles as near as that.
        Corner::Short(length) => arm(random, length.max(4.0 * f64::EPSILON * size)),
    }
    walls.retain(|(start, end)| start != end);
    let mut site = Site::new(limits(size), random, &walls);
    if site.put(start, radius).is_some() {
        site.go(0, 0, goal, speed);
    }
    site.scene(3)
}

/// Two walls a diameter apart, up to a few bits, and circles that want to pass between them.
fn corridor(random: &mut Random) -> Scene {
    let size: f64 = random.pick(&[1.0, 100.0, 1e6]);
    let (x, y, length) = random.pick(&TRIPLES);
    let any = random.between(0.1, 2.0);
    let radius = random.pick(&[0.5, 0.625, any]);
    let way = if random.chance(0.7) { DVec2::new(x, y) / length } else { direction(random) };
    let start = point(random, size).floor();
    let mouth = start + way * (3.0 * radius + 1.0);
    let side = across(way) * radius;
    let ulps = random.pick(&[0, 0, 1, 4]);
    let walls = [side, -side].map(|side| {
        let from = nudged(random, mouth + side, ulps);
        // Parallel to the way, so that the width is the same all along.
        (from, from + way * 8.0)
    });
    let mut site = Site::new(limits(size), random, &walls);
    let speed = random.between(0.4, 4.0);
    for place in 0..1 + random.below(2) {
        let from = start - way * (f64::from(place) * (2.0 * radius + 0.1));
        if let Some(id) = site.put(from, radius) {
            site.go(0, id, from + way * (14.0 + 3.0 * radius), speed);
        }
    }
    site.scene(60)
}

/// Whether the walls and the way of a scene go along an axis.
fn is_level(scene: &Scene) -> bool {
    let way = scene.orders[0].legs[0].0 - scene.objects[0].1;
    let is_straight = |wall: &maniple_kinematics::Wall| {
        let along = wall.segment.end - wall.segment.start;
        along.x == 0.0 || along.y == 0.0
    };
    (way.x == 0.0 || way.y == 0.0) && scene.walls.iter().all(is_straight)
}

/// Whether both walls of a level corridor are a radius or more from the way.
fn is_wide(scene: &Scene) -> bool {
    let (_, center, radius, _) = scene.objects[0];
    let is_level = scene.orders[0].legs[0].0.y == center.y;
    let is_beside = |wall: &maniple_kinematics::Wall| {
        // The difference itself is rounded, so not even it can be taken from doubles.
        let offset = Exact::of(wall.segment.start).minus(&Exact::of(center));
        let beside = if is_level { offset.1 } else { offset.0 };
        &beside * &beside >= number(radius) * number(radius)
    };
    scene.walls.iter().all(is_beside)
}

fn limits(size: f64) -> Limits {
    Limits::new(2.0 * size + 4096.0, 4.0, SPEED_MAX).expect("good limits")
}

fn point(random: &mut Random, size: f64) -> DVec2 {
    DVec2::new(random.between(-size, size), random.between(-size, size))
}

fn count(stopped: &Cell<u64>, played: &Played) {
    let is_collision = |event: &maniple_kinematics::Event| event.kind == EventKind::Segment;
    stopped.set(stopped.get() + u64::from(played.events.iter().any(is_collision)));
}

/// Both answers come up in more than a tenth of the scenes.
fn assert_both(stopped: &Cell<u64>) {
    println!("stopped in {} scenes of {SCENES}", stopped.get());
    assert!(stopped.get() > SCENES / 10);
    assert!(std::env::var_os("MANIPLE_LONG").is_some() || stopped.get() < SCENES - SCENES / 10);
}
