//! Groups that are hindered: by who rests in a gap, and by who is bumped.

use glam::DVec2;
use maniple_geometry::{Circle, ObjectId};
use maniple_kinematics::{Layers, World};
use maniple_tilemap::TileMap;

use super::crowds::corners;
use super::release::{block, gap};
use super::trial::{Outcome, Trial};
use super::{Dice, drawn};
use crate::{Tactic, length};

/// Two rooms, and two gaps between them: one in the middle and one at the right.
fn two_gaps() -> TileMap {
    let open = format!("@{}@", ".".repeat(38));
    let wall = format!("{}..{}..@", "@".repeat(19), "@".repeat(16));
    let edge = "@".repeat(40);
    let mut rows = vec![edge.as_str()];
    rows.extend(std::iter::repeat_n(open.as_str(), 14));
    rows.extend(std::iter::repeat_n(wall.as_str(), 3));
    rows.extend(std::iter::repeat_n(open.as_str(), 14));
    rows.push(&edge);
    drawn(&rows)
}

fn through_two_gaps(map: &TileMap, closed: std::ops::Range<u32>) -> Trial<'_> {
    let block = |y: f64| block((6, 5), DVec2::new(20.0, y));
    let stones =
        [-0.5, 0.5].map(|x| (Circle::new(DVec2::new(20.0 + x, 16.5), 0.45), closed.clone())).to_vec();
    Trial { stones, ..Trial::new(map, Tactic::Auto, block(8.0), block(24.0)) }
}

#[test]
fn where_the_near_gap_is_closed_the_far_one_is_taken() {
    let map = two_gaps();
    // By the far gap it is so far for the middle of the group, in cycles.
    let way = [DVec2::new(38.0, 15.0), DVec2::new(38.0, 18.0), DVec2::new(20.0, 24.0)];
    let far = length(DVec2::new(20.0, 8.0), &way) / super::trial::SPEED;
    for (name, closed) in [("never", 9999..9999), ("from the start", 0..9999), ("under way", 25..9999)] {
        let Outcome { arrived, collisions, orders, cycles, last_order, .. } =
            through_two_gaps(&map, closed).run(4000);
        println!(
            "closed {name}: {arrived} arrived, {collisions} collisions, {orders} orders, the last in {last_order}, {cycles} cycles; far: \
             {far:.0}"
        );
        assert_eq!((arrived, collisions), (30, 0), "{name}");
        assert!(f64::from(cycles) < 4.0 * far, "{name}");
        assert!(orders <= 30 * 4, "{name}: nobody shuffles");
    }
}

/// Moves a unit a little to where there is room, and leaves it at rest there.
fn bump(world: &mut World, id: u32, dice: &mut Dice, (map, units): (&TileMap, u32)) {
    let circle = world.circle(ObjectId(id)).unwrap();
    for _ in 0..20 {
        let center = circle.center + DVec2::new(dice.share() - 0.5, dice.share() - 0.5);
        let is_apart = |other: u32| {
            other == id
                || world.circle(ObjectId(other)).unwrap().center.distance(center) > 2.0 * circle.radius + 0.01
        };
        let has_room =
            map.segments().iter().all(|wall| wall.nearest(center).distance(center) > circle.radius + 0.01);
        if (0..units).all(is_apart) && has_room {
            world.remove(ObjectId(id)).unwrap();
            world.insert(ObjectId(id), Circle::new(center, circle.radius), Layers::GROUND).unwrap();
            return;
        }
    }
}

/// Bumps somebody every so many cycles for so long, and asserts that all arrive in bounded time.
fn check(name: &str, trial: &Trial<'_>, units: u32, every: u32) {
    const BUMPED_UNTIL: u32 = 300;
    let undisturbed = trial.run(4000);
    for seed in 0..4 {
        let mut dice = Dice(seed);
        let outcome = trial.run_with(6000, |cycle, world| {
            if cycle > 0 && cycle % every == 0 && cycle < BUMPED_UNTIL {
                let id = u32::try_from(dice.roll() % u64::from(units)).unwrap();
                bump(world, id, &mut dice, (trial.map, units));
            }
        });
        let Outcome { arrived, collisions, orders, refused, cycles, .. } = outcome;
        println!(
            "{name}, seed {seed}: {arrived} arrived, {collisions} collisions, {orders} orders, {cycles} cycles; undisturbed {}",
            undisturbed.cycles
        );
        assert_eq!((arrived, refused), (units as usize, 0), "{name}, seed {seed}");
        assert!(cycles < BUMPED_UNTIL + 4 * undisturbed.cycles, "{name}, seed {seed}: {cycles}");
    }
}

#[test]
fn who_is_bumped_at_random_arrives_in_bounded_time() {
    let map = gap(2);
    let middle = 0.5 * f64::from(map.width());
    let starts = block((7, 7), DVec2::new(middle, 9.0));
    let through = Trial::new(&map, Tactic::Auto, starts, block((7, 7), DVec2::new(middle, 33.0)));
    check("gap", &through, 49, 10);
    // Planning takes cycles, in which others are on their way and are bumped, too.
    check("gap, in parts", &Trial { budget: 20_000, ..through.clone() }, 49, 25);
    let (map, groups) = corners(20);
    let corners = Trial::of_groups(&map, Tactic::Auto, groups);
    check("corners", &corners, 20, 30);
    check("corners, in step", &Trial { is_in_step: true, ..corners.clone() }, 20, 30);
}

#[test]
fn who_comes_to_rest_on_the_board_is_gone_around() {
    let (map, groups) = corners(20);
    let middle = DVec2::splat(0.5 * f64::from(map.width()));
    let stones = [(-1.5, 40..9999), (0.5, 60..200), (2.5, 80..9999)];
    let stones = stones.map(|(x, cycles)| (Circle::new(middle + DVec2::new(x, 0.5), 0.9), cycles)).to_vec();
    let Outcome { arrived, collisions, orders, cycles, .. } =
        Trial { stones, is_in_step: true, ..Trial::of_groups(&map, Tactic::Auto, groups) }.run(3000);
    println!("stones: {arrived} arrived, {collisions} collisions, {orders} orders, {cycles} cycles");
    assert_eq!((arrived, collisions), (20, 0));
}
