//! Schedules, walked by the kinematics.

use glam::DVec2;
use maniple_geometry::{Circle, Cycle, Limits, Moment, ObjectId};
use maniple_kinematics::{EventKind, Layers, Leg, Placement, Stops, Wall, WallKind, World};
use maniple_tilemap::TileMap;

use super::drawn;
use crate::release::{Goals, Group, Request, Schedule, release};
use crate::Ground;

const RADIUS: f64 = 0.35;

/// World units a cycle.
const SPEED: f64 = 0.2;

/// A room above and one below a wall that is three tiles thick, with a gap in its middle.
fn gap(width: usize) -> TileMap {
    let side = 31;
    let open = format!("{}{}{}", "@", ".".repeat(side - 2), "@");
    let left = (side - width) / 2;
    let wall = format!("{}{}{}", "@".repeat(left), ".".repeat(width), "@".repeat(side - width - left));
    let edge = "@".repeat(side);
    let mut rows = vec![edge.as_str()];
    rows.extend(std::iter::repeat_n(open.as_str(), 19));
    rows.extend(std::iter::repeat_n(wall.as_str(), 3));
    rows.extend(std::iter::repeat_n(open.as_str(), 19));
    rows.push(&edge);
    drawn(&rows)
}

/// `columns` by `rows` points, a tile apart, from a first one on.
fn block((columns, rows): (usize, usize), first: DVec2) -> Vec<DVec2> {
    (0..rows)
        .flat_map(|y| (0..columns).map(move |x| first + DVec2::new(x as f64, y as f64)))
        .collect()
}

/// Walks a schedule and returns the collisions, and when the last one arrived, in cycles.
fn walk(map: &TileMap, radius: f64, groups: &[Group], schedule: &Schedule) -> (usize, f64) {
    let side = f64::from(map.width().max(map.height()));
    let walls: Vec<Wall> = map
        .segments()
        .into_iter()
        .map(|segment| Wall { segment, kind: WallKind::Segment, layers: Layers::GROUND })
        .collect();
    let mut world = World::new(Limits::new(side, radius, SPEED).unwrap(), Stops::Both, &walls).unwrap();
    let mut id = 0;
    for (group, walks) in groups.iter().zip(&schedule.walks) {
        for (start, walk) in group.starts.iter().zip(walks) {
            world.insert(ObjectId(id), Circle::new(*start, radius), Layers::GROUND).unwrap();
            let legs: Vec<Leg> = walk.legs.iter().map(|&goal| Leg { goal, speed: SPEED }).collect();
            let cycle = walk.departure.floor();
            let moment = Moment { cycle: Cycle(cycle as u32), fraction: walk.departure - cycle };
            world.go(ObjectId(id), &legs, Placement::Replace, Some(moment)).unwrap();
            id += 1;
        }
    }
    let (mut collisions, mut last) = (0, 0.0);
    while !world.is_at_rest() {
        for event in world.step() {
            collisions += usize::from(event.kind != EventKind::Arrived);
            last = f64::from(event.cycle.0) + event.time;
        }
    }
    let mut id = 0;
    for (group, walks) in groups.iter().zip(&schedule.walks) {
        for walk in walks {
            assert!(collisions > 0 || world.circle(ObjectId(id)).unwrap().center == group.goals[walk.goal]);
            id += 1;
        }
    }
    (collisions, last)
}

#[test]
fn a_hundred_go_through_gaps() {
    for width in std::env::var("WIDTHS").map_or(vec![1, 2, 3], |w| w.split(",").map(|w| w.parse().unwrap()).collect()) {
        let map = gap(width);
        let ground = Ground::new(&map, RADIUS).unwrap();
        let middle = 0.5 * f64::from(map.width());
        let groups = [Group {
            starts: block((10, 10), DVec2::new(middle - 4.5, 4.5)),
            goals: block((10, 10), DVec2::new(middle - 4.5, 28.5)),
            whose: Goals::Interchangeable,
        }];
        let request = Request { groups: &groups, speed: SPEED, still: &[] };
        let begun = std::time::Instant::now();
        let schedule = release(&ground, &request).unwrap();
        let took = begun.elapsed();
        let (collisions, last) = walk(&map, RADIUS, &groups, &schedule);
        println!("gap {width}: makespan {} walked {last} collisions {collisions}, {took:?}", schedule.makespan);
        let direct = 24.0 / SPEED;
        println!("   straight {direct}");
        assert_eq!(collisions, 0);
    }
}

#[test]
fn debug_print() {
        let map = gap(3);
        let ground = Ground::new(&map, RADIUS).unwrap();
        let middle = 0.5 * f64::from(map.width());
        let groups = [Group {
            starts: block((10, 10), DVec2::new(middle - 4.5, 4.5)),
            goals: block((10, 10), DVec2::new(middle - 4.5, 28.5)),
            whose: Goals::Interchangeable,
        }];
        let request = Request { groups: &groups, speed: SPEED, still: &[] };
        let schedule = release(&ground, &request).unwrap();
        let mut all: Vec<_> = schedule.walks[0].iter().zip(&groups[0].starts).collect();
        all.sort_by(|a, b| a.0.departure.total_cmp(&b.0.departure));
        for (walk, start) in all {
            let first = crate::length(*start, &walk.legs[..1]) / SPEED;
            println!("{start} dep {:.1} entry {:.1} arr {:.1} legs {:?}", walk.departure, walk.departure + first, walk.arrival, walk.legs.iter().map(|l| format!("{:.2},{:.2}", l.x, l.y)).collect::<Vec<_>>());
        }
}
