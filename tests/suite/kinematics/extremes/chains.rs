//! Many circles that touch, or meet at one time.

use glam::DVec2;
use maniple_geometry::Limits;
use maniple_kinematics::{Event, EventKind};

use super::super::scene::{Random, Scene};
use super::site::{Site, TRIPLES, across, count, direction};
use super::tally::Tally;

/// Circles of a chain or ring, at least and at most.
const LINKS: (u32, u32) = (2, 200);

/// The eight vectors of one length that swaps and changes of sign make of (3, 4): what comes to their common end from
/// them is symmetrical to the bit.
const STAR: [(f64, f64); 8] =
    [(3.0, 4.0), (4.0, 3.0), (-3.0, 4.0), (-4.0, 3.0), (3.0, -4.0), (4.0, -3.0), (-3.0, -4.0), (-4.0, -3.0)];

#[test]
fn chains_of_touching_circles_with_one_pushed_never_overlap() {
    let tally = Tally::of("chains of 2 to 200, one pushed", 300, chain);
    assert!(tally.retreats > 0, "rounding alone makes some of them overlap, so the certificate has work");
}

#[test]
fn rings_of_touching_circles_with_one_pushed_never_overlap() {
    let tally = Tally::of("rings of 3 to 200, one pushed", 300, ring);
    assert!(tally.retreats > 0, "rounding alone makes some of them overlap, so the certificate has work");
}

#[test]
fn who_meets_in_one_point_at_one_time_stops_a_skin_above_touching() {
    Tally::checked("2 to 8 meet in one point at one time", 1500, meeting, |scene, played| {
        assert_eq!(played.retreats, 0, "stops need no certificate");
        // The second order, from within two skins, is refused at once to all who were stopped.
        let again = scene.orders.last().expect("orders").cycle;
        let stopped = |event: &&Event| event.kind == EventKind::Object;
        let (first, second): (Vec<&Event>, Vec<&Event>) =
            played.events.iter().filter(stopped).partition(|event| event.cycle.0 < again);
        assert!(first.len() >= 2, "{:?}", played.events);
        for event in second.iter().filter(|event| first.iter().any(|other| other.object == event.object)) {
            let names = |other: &&&Event| other.object == event.object;
            let partner = first.iter().find(names).and_then(|event| event.other);
            assert!(event.time == 0.0 || event.other != partner, "{event:?} again");
        }
    });
}

#[test]
fn equal_times_are_one_generation() {
    Tally::checked("equal collision times by construction", 1500, equal_times, |scene, played| {
        let collisions = || played.events.iter().filter(|event| event.kind == EventKind::Object);
        let times: std::collections::BTreeSet<u64> = collisions().map(|event| event.time.to_bits()).collect();
        assert_eq!(times.len(), 1, "{:?}", played.events);
        // Who goes in between two others is told of the one with the smaller id.
        for event in collisions() {
            let (center, goal) = (scene.objects[event.object.0 as usize].1, goal_of(scene, event.object.0));
            let way = goal - center;
            let gap = |id: u32| {
                let d = scene.objects[id as usize].1 - center;
                (d.dot(way) > 0.0).then(|| d.length())
            };
            let partner = event.other.expect("a collision with an object").0;
            let mut nearer = (0..partner).filter(|&id| id != event.object.0 && gap(id) == gap(partner));
            assert_eq!(nearer.next(), None, "{event:?}: {scene:?}");
        }
    });
}

/// Touching circles in a row that is straight or bent; all march in step and one is pushed, or only one is.
fn chain(random: &mut Random) -> Scene {
    let mut site = Site::new(limits(), random, &[]);
    let links = count(random, LINKS);
    let (x, y, length) = random.pick(&TRIPLES);
    let straight = if random.chance(0.5) { DVec2::new(x, y) / length } else { direction(random) };
    let (bend, radius) = (random.pick(&[0.0, 0.0, 1e-9, 0.3]), random.between(0.2, 2.0));
    let equal = random.chance(0.5);
    let mut center = DVec2::new(random.between(-500.0, 500.0), random.between(-500.0, 500.0));
    let mut last = radius;
    site.put(center, radius).expect("the plane is empty");
    for _ in 1..links {
        let way = DVec2::from_angle(bend * random.between(-1.0, 1.0)).rotate(straight);
        let next = if equal { radius } else { random.between(0.2, 2.0) };
        let Some(id) = site.put_outwards(center + way * (last + next), way, next) else { break };
        (center, last) = (site.center(id), next);
    }
    push(&mut site, random, straight);
    site.scene(6)
}

/// Touching circles around a point; all march in step and one is pushed, or only one is.
fn ring(random: &mut Random) -> Scene {
    let mut site = Site::new(limits(), random, &[]);
    let (links, radius) = (count(random, (3, LINKS.1)), random.between(0.2, 2.0));
    let middle = DVec2::new(random.between(-300.0, 300.0), random.between(-300.0, 300.0));
    let half = std::f64::consts::PI / f64::from(links);
    let size = radius / half.sin();
    for link in 0..links {
        let way = DVec2::from_angle(2.0 * half * f64::from(link));
        let _ = site.put_outwards(middle + way * size, way, radius);
    }
    let straight = direction(random);
    if random.chance(0.3) {
        // Everybody comes to the middle.
        for id in site.ids() {
            site.go(0, id, middle, 0.5);
        }
    } else {
        push(&mut site, random, straight);
    }
    site.scene(6)
}

/// Orders of who march in step with one pushed: faster, slower, into its neighbour, or out of the row.
fn push(site: &mut Site, random: &mut Random, straight: DVec2) {
    let ids = site.ids();
    let pushed = random.below(ids.end);
    let speed = random.between(0.01, 4.0);
    let marches = random.chance(0.7);
    let way = random.pick(&[straight, -straight, across(straight), DVec2::from_angle(0.7).rotate(straight)]);
    for id in ids {
        let from = site.center(id);
        if id == pushed {
            let speed = speed * random.pick(&[1.0, 0.999, 1.001, 2.0]);
            let way = if marches { way } else { random.pick(&[straight, -straight, across(straight)]) };
            site.go(0, id, from + way * 64.0, speed);
        } else if marches {
            site.go(0, id, from + way * 64.0, speed);
        }
    }
}

/// Some of eight circles that come to one point from the same distance, and then once more.
fn meeting(random: &mut Random) -> Scene {
    let mut site = Site::new(limits(), random, &[]);
    let middle =
        DVec2::new(f64::from(random.below(512)), f64::from(random.below(512))) / 4.0 - DVec2::splat(64.0);
    let (far, radius) = (f64::from(4 + random.below(12)) / 4.0, random.pick(&[0.25, 0.5, 0.125, 0.3]));
    let mut arms = STAR;
    for place in (1..arms.len()).rev() {
        arms.swap(place, random.below(u32::try_from(place).expect("eight") + 1) as usize);
    }
    let guests = 2 + random.below(7);
    let speed = random.between(0.5, 8.0);
    for &arm in arms.iter().take(guests as usize) {
        let id = site.put(middle + DVec2::from(arm) * far, radius).expect("they are far apart");
        site.go(0, id, middle, speed);
    }
    // Long enough for all to come to rest.
    let again = (4..).find(|&cycle| f64::from(cycle - 4) * speed >= 5.0 * far).expect("a cycle");
    for id in site.ids() {
        site.go(again, id, middle, speed);
    }
    site.scene(again + 1)
}

/// Copies, moved by whole numbers, of one or two who go into what is the same everywhere.
fn equal_times(random: &mut Random) -> Scene {
    let mut site = Site::new(limits(), random, &[]);
    let (speed, half) = (random.between(1.6, 15.0), random.pick(&[0.25, 0.5, 0.625, 0.875]));
    let upwards = random.chance(0.5);
    let turned = |x: f64, y: f64| if upwards { DVec2::new(x, y) } else { DVec2::new(y, x) };
    let kind = random.below(4);
    for copy in 0..2 + random.below(8) {
        let corner = turned(4.0 * f64::from(copy), f64::from(random.below(3)) * 16.0);
        // The ids of the two that are met come in any order.
        let side = if random.chance(0.5) { half } else { -half };
        match kind {
            0 => {
                // Two who meet head-on.
                let one = site.put(corner, 0.5).expect("free");
                let other = site.put(corner + turned(0.0, 2.5), 0.5).expect("free");
                site.go(0, one, corner + turned(0.0, 64.0), speed);
                site.go(0, other, corner - turned(0.0, 64.0), speed);
            }
            1 => {
                // One who goes in between two that rest, and would fit in if they were not there.
                for side in [side, -side] {
                    site.put(corner + turned(side, 2.0), 0.125).expect("free");
                }
                let id = site.put(corner, 0.875).expect("free");
                site.go(0, id, corner + turned(0.0, 64.0), speed);
            }
            2 => {
                // One who goes in between two that come towards it.
                for side in [side, -side] {
                    let id = site.put(corner + turned(side, 2.0), 0.125).expect("free");
                    site.go(0, id, corner + turned(side, -62.0), speed);
                }
                let id = site.put(corner, 0.875).expect("free");
                site.go(0, id, corner + turned(0.0, 64.0), speed);
            }
            _ => {
                // Two from both sides into one that rests.
                site.put(corner + turned(side, 2.0), 0.125).expect("free");
                for away in [-1.75, 1.75] {
                    let from = corner + turned(side, 2.0 + away);
                    let id = site.put(from, 0.5).expect("free");
                    site.go(0, id, from - turned(0.0, 64.0 * away), speed);
                }
            }
        }
    }
    site.scene(3)
}

fn goal_of(scene: &Scene, id: u32) -> DVec2 {
    let order = scene.orders.iter().find(|order| order.id == id);
    order.expect("it was ordered").legs[0].0
}

fn limits() -> Limits {
    Limits::new(2048.0, 4.0, 16.0).expect("good limits")
}
