//! Controllers that lead circles of the kinematics.

use glam::DVec2;
use maniple_geometry::Circle;
use maniple_tilemap::TileMap;

use super::drawn;
use super::release::{block, gap};
use super::trial::{Outcome, Trial};
use crate::{Delivery, Goals, Ground, Group, Planner, Progress, Request, Tactic, release};

fn through_gap(map: &TileMap, tactic: Tactic) -> Trial<'_> {
    let middle = 0.5 * f64::from(map.width());
    let starts = block((10, 10), DVec2::new(middle, 9.0));
    Trial::new(map, tactic, starts, block((10, 10), DVec2::new(middle, 33.0)))
}

#[test]
fn a_schedule_brings_all_through_gaps_where_reactions_fail() {
    for width in [1, 2, 3] {
        let map = gap(width);
        for tactic in Tactic::ALL {
            let outcome = through_gap(&map, tactic).run(if tactic == Tactic::Auto { 2000 } else { 500 });
            println!(
                "gap {width} {}: {} arrived, {} collisions, {} orders, {} cycles",
                tactic.name(),
                outcome.arrived,
                outcome.collisions,
                outcome.orders,
                outcome.cycles
            );
            if tactic == Tactic::Auto {
                assert_eq!((outcome.arrived, outcome.collisions, outcome.orders), (100, 0, 100));
            } else {
                assert!(outcome.arrived < 60, "{}: {}", tactic.name(), outcome.arrived);
            }
        }
    }
}

#[test]
fn all_arrive_over_a_slow_line_that_loses_orders() {
    for width in [1, 2, 3] {
        let map = gap(width);
        for (latency, lost) in [(2, 0.01), (2, 0.03), (2, 0.05)] {
            let outcome = Trial { latency, lost, ..through_gap(&map, Tactic::Auto) }.run(6000);
            println!(
                "gap {width}, {latency} cycles, {lost} lost: {} arrived, {} collisions, {} of {} orders lost, {} cycles",
                outcome.arrived, outcome.collisions, outcome.lost, outcome.orders, outcome.cycles
            );
            assert_eq!(outcome.arrived, 100, "{width} {latency} {lost}");
            // Who does not hear that it has to go is run into, by one of those who go by: the next is told in time.
            assert!(outcome.collisions <= outcome.lost, "{width} {latency} {lost}: {}", outcome.collisions);
        }
    }
}

#[test]
fn a_denied_gap_is_waited_for_without_shuffling() {
    let map = gap(1);
    let middle = 0.5 * f64::from(map.width());
    let stone = Circle::new(DVec2::new(middle, 21.5), 0.35);
    let free_at = Trial { stones: vec![(stone, 0..600)], ..through_gap(&map, Tactic::Auto) }.run(4000);
    println!("denied {} {} {} {}", free_at.arrived, free_at.collisions, free_at.orders, free_at.cycles);
    assert_eq!((free_at.arrived, free_at.collisions), (100, 0));
    let never = Trial { stones: vec![(stone, 0..u32::MAX)], ..through_gap(&map, Tactic::Auto) }.run(1000);
    println!("never {} {} {} {}", never.arrived, never.collisions, never.orders, never.last_order);
    assert!(never.orders <= 200 && never.last_order < 50, "{} {}", never.orders, never.last_order);
}

#[test]
fn who_cannot_reach_a_goal_is_told_so_at_once() {
    let map = drawn(&[".....@.....", ".....@.....", ".....@....."]);
    let goal = DVec2::new(8.5, 1.5);
    for tactic in [Tactic::Alone, Tactic::Replan, Tactic::Auto] {
        let outcome = Trial::new(&map, tactic, vec![DVec2::new(1.5, 1.5)], vec![goal]).run(20);
        assert_eq!(outcome.progress, [Progress::Unreachable], "{}", tactic.name());
    }
}

#[test]
fn who_is_in_the_way_all_at_once_is_evaded() {
    let map = gap(5);
    let middle = 0.5 * f64::from(map.width());
    // Two of five tiles are closed from the start, and the schedule has to do with the others.
    let stones = [-1.5, -0.5].map(|x| (Circle::new(DVec2::new(middle + x, 21.5), 0.45), 0..5000)).to_vec();
    let outcome = Trial { stones, ..through_gap(&map, Tactic::Auto) }.run(4000);
    println!("evaded {} {} {} {}", outcome.arrived, outcome.collisions, outcome.orders, outcome.cycles);
    assert_eq!((outcome.arrived, outcome.collisions), (100, 0));
}

#[test]
fn the_same_trial_ends_the_same() {
    let map = gap(2);
    let run = || Trial { latency: 2, lost: 0.02, ..through_gap(&map, Tactic::Auto) }.run(6000);
    assert_eq!(run(), run());
}

/// A way with more turns than an object has waypoints: its end is ordered on the way, and nobody waits for it.
#[test]
fn a_way_of_many_legs_is_ordered_in_parts() {
    let open = "........";
    let walls = ["@@@@@@@.", ".@@@@@@@"];
    let rows: Vec<&str> = (0..97).map(|y| if y % 2 == 0 { open } else { walls[y / 2 % 2] }).collect();
    let map = drawn(&rows);
    let at = |y: f64| (0..5).map(|x| DVec2::new(0.5 + f64::from(x), y)).collect::<Vec<_>>();
    let ground = Ground::new(&map, 0.35).unwrap();
    let (starts, goals) = (at(0.5), at(96.5));
    let legs = Planner::new(&ground).path(starts[4], goals[0]).unwrap().len();
    assert!(legs > 2 * 64, "{legs}");
    for (latency, delivery) in [(0, Delivery::Sure), (2, Delivery::Sure), (2, Delivery::Lossy { repeats: 2 })]
    {
        let trial =
            Trial { latency, delivery, ..Trial::new(&map, Tactic::Auto, starts.clone(), goals.clone()) };
        let Outcome { arrived, collisions, orders, refused, cycles, .. } = trial.run(8000);
        println!("{legs} legs, {latency} cycles: {arrived} arrived, {orders} orders, {cycles} cycles");
        assert_eq!((arrived, collisions, refused), (5, 0, 0), "{latency}");
        let request = [Group { starts: starts.clone(), goals: goals.clone(), whose: Goals::Interchangeable }];
        let request = Request { groups: &request, speed: 0.2, still: &[], moving: &[] };
        let makespan = release(&ground, &request).unwrap().makespan;
        assert!(f64::from(cycles) < makespan + 20.0, "{latency}: {cycles} instead of {makespan}");
    }
}
