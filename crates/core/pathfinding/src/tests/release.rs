//! Schedules, walked by the kinematics.

use glam::DVec2;
use maniple_geometry::{Circle, Cycle, Limits, Moment, ObjectId, Scalar};
use maniple_kinematics::{EventKind, Layers, Leg, Placement, Stops, Wall, WallKind, World};
use maniple_tilemap::TileMap;

use super::crowds::{corners, maze};
use super::{Dice, drawn, scattered};
use crate::Ground;
use crate::release::{
    Goals, Group, ReleaseError, Releasing, Request, Schedule, bound, bound_of_groups, release,
};

const RADIUS: f64 = 0.35;

/// World units a cycle.
const SPEED: f64 = 0.2;

/// A room above and one below a wall that is three tiles thick, with a gap in its middle. Rooms are a tile wider for even gaps, so
/// that the middle is that of the gap.
pub(crate) fn gap(width: usize) -> TileMap {
    let side = 30 + width % 2;
    let open = format!("@{}@", ".".repeat(side - 2));
    let left = (side - width) / 2;
    let wall = format!("{}{}{}", "@".repeat(left), ".".repeat(width), "@".repeat(left));
    let edge = "@".repeat(side);
    let mut rows = vec![edge.as_str()];
    rows.extend(std::iter::repeat_n(open.as_str(), 19));
    rows.extend(std::iter::repeat_n(wall.as_str(), 3));
    rows.extend(std::iter::repeat_n(open.as_str(), 19));
    rows.push(&edge);
    drawn(&rows)
}

fn open(side: usize) -> TileMap {
    let row = ".".repeat(side);
    drawn(&vec![row.as_str(); side])
}

/// `columns` by `rows` points, a tile apart, around a middle.
pub(crate) fn block((columns, rows): (usize, usize), middle: DVec2) -> Vec<DVec2> {
    let first = middle - 0.5 * DVec2::new(columns as f64 - 1.0, rows as f64 - 1.0);
    (0..rows).flat_map(|y| (0..columns).map(move |x| first + DVec2::new(x as f64, y as f64))).collect()
}

/// A time in cycles as a moment.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "schedules of tests are short")]
pub(crate) fn moment(time: f64) -> Moment {
    Moment { cycle: Cycle(time.floor() as u32), fraction: time - time.floor() }
}

fn group(starts: Vec<DVec2>, goals: Vec<DVec2>) -> Group {
    Group { starts, goals, whose: Goals::Interchangeable }
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
            if !legs.is_empty() {
                world.go(ObjectId(id), &legs, Placement::Replace, Some(moment(walk.departure))).unwrap();
            }
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

/// Schedules groups, walks them, and returns the makespan over the bound.
fn check(name: &str, map: &TileMap, radius: f64, groups: &[Group]) -> f64 {
    let ground = Ground::new(map, radius).unwrap();
    let request = Request { groups, speed: SPEED, still: &[], moving: &[] };
    let schedule = release(&ground, &request).unwrap_or_else(|error| panic!("{name}: {error}"));
    let (collisions, last) = walk(map, radius, groups, &schedule);
    assert_eq!(collisions, 0, "{name}");
    assert!((last - schedule.makespan).abs() < 1e-6, "{name}: {last} instead of {}", schedule.makespan);
    assert_eq!(release(&ground, &request), Ok(schedule), "{name}");
    let bound = bound_of_groups(&ground, groups, SPEED).unwrap();
    let units: usize = groups.iter().map(|group| group.starts.len()).sum();
    println!("{name}: {units} in {last:.1} cycles, {:.3} of the bound {bound:.1}", last / bound);
    last / bound
}

#[test]
fn a_hundred_go_through_gaps_nearly_as_fast_as_circles_can() {
    for radius in [0.25, 0.35, 0.45] {
        for (width, most) in [(1, 1.05), (2, 1.05), (3, 1.10), (4, 1.20), (5, 1.20)] {
            let map = gap(width);
            let middle = 0.5 * f64::from(map.width());
            let groups =
                [group(block((10, 10), DVec2::new(middle, 9.0)), block((10, 10), DVec2::new(middle, 33.0)))];
            let share = check(&format!("gap {width}, radius {radius}"), &map, radius, &groups);
            assert!((1.0..most).contains(&share), "{width} {radius}: {share}");
        }
    }
}

#[test]
fn it_matters_little_where_a_group_stands_before_a_gap() {
    for radius in [0.25, 0.35, 0.45] {
        for width in 1..=3 {
            let map = gap(width);
            let middle = 0.5 * f64::from(map.width());
            for step in 0..4 {
                // Neither multiples of a tile nor of the distance in which the width of a path is looked at.
                let aside = DVec2::new(0.93 * f64::from(step) - 1.3, 0.0713 * f64::from(step));
                let (above, below) =
                    (DVec2::new(middle, 9.0) + aside, DVec2::new(middle, 33.0) - 0.7 * aside);
                let groups = [group(block((10, 10), above), block((10, 10), below))];
                let share = check(&format!("gap {width}, radius {radius}, {aside}"), &map, radius, &groups);
                assert!((1.0..1.10).contains(&share), "{width} {radius} {aside}: {share}");
            }
        }
    }
}

#[test]
fn a_group_crosses_an_open_field_as_fast_as_one_does() {
    for side in [4, 10, 22] {
        let size = 4 * side + 10;
        let map = open(size);
        let half = 0.5 * side as f64 + 2.0;
        let far = size as f64 - half;
        let groups =
            [group(block((side, side), DVec2::new(half, half)), block((side, side), DVec2::new(far, far)))];
        let share = check(&format!("open {side}"), &map, RADIUS, &groups);
        assert!((1.0 - 1e-9..1.0 + 1e-9).contains(&share), "{share}");
    }
}

/// A way around two corners that is wide everywhere.
fn bent() -> TileMap {
    let row = |y: usize| -> String {
        let is_wall = |x: usize| ((20..22).contains(&x) && y < 45) || ((40..42).contains(&x) && y >= 15);
        (0..62).map(|x| if is_wall(x) { '@' } else { '.' }).collect()
    };
    let rows: Vec<String> = (0..60).map(row).collect();
    drawn(&rows.iter().map(String::as_str).collect::<Vec<_>>())
}

/// One after the other around the corners, a hundred circles need as long as one needs for 69 world units more than the first.
#[test]
fn a_group_goes_side_by_side_around_corners() {
    for (side, most) in [(5, 1.1), (10, 1.25), (15, 1.5)] {
        let ends = [DVec2::new(10.0, 10.0), DVec2::new(52.0, 50.0)];
        let groups = [group(block((side, side), ends[0]), block((side, side), ends[1]))];
        let share = check(&format!("bent, {side} by {side}"), &bent(), RADIUS, &groups);
        assert!(share < most, "{share}");
    }
}

/// In a maze some goals are closed in by those who have arrived before; somebody has to exchange goals then.
#[test]
fn groups_fill_the_dead_ends_of_mazes() {
    for seed in 0..8 {
        let (map, groups) = maze((60, 0.7), 150, seed);
        check(&format!("maze, seed {seed}"), &map, RADIUS, &groups);
    }
}

/// The same, where without an exchange fewer lanes are left, and 855 cycles instead of 644.
#[test]
fn who_is_left_with_a_closed_goal_exchanges_it() {
    let (map, groups) = maze((40, 0.7), 100, 6);
    let ground = Ground::new(&map, RADIUS).unwrap();
    let schedule =
        release(&ground, &Request { groups: &groups, speed: SPEED, still: &[], moving: &[] }).unwrap();
    check("maze, a closed goal", &map, RADIUS, &groups);
    assert!(schedule.makespan < 700.0, "{}", schedule.makespan);
}

/// Whoever comes the other way keeps to its right, too; straight ahead all would meet in the middle, and there is no schedule.
#[test]
fn four_groups_that_change_corners_keep_to_the_right() {
    for (units, most) in [(20, 1.3), (100, 1.35), (400, 1.5)] {
        let (map, groups) = corners(units);
        let share = check(&format!("corners, {units}"), &map, RADIUS, &groups);
        assert!((1.0..most).contains(&share), "{units}: {share}");
    }
}

#[test]
fn two_groups_go_through_a_gap_from_both_sides() {
    for (width, most) in [(1, 1.4), (2, 1.4), (4, 1.7)] {
        let map = gap(width);
        let middle = 0.5 * f64::from(map.width());
        let above = |x: f64| block((5, 10), DVec2::new(middle + x, 8.0));
        let below = |x: f64| block((5, 10), DVec2::new(middle + x, 34.0));
        let groups = [group(above(-5.0), below(-5.0)), group(below(5.0), above(5.0))];
        let share = check(&format!("from both sides of {width}"), &map, RADIUS, &groups);
        assert!((1.0..most).contains(&share), "{width}: {share}");
    }
}

#[test]
fn two_groups_that_pass_one_gap_need_as_long_as_one_of_all() {
    let map = gap(2);
    let ground = Ground::new(&map, RADIUS).unwrap();
    let middle = 0.5 * f64::from(map.width());
    let (above, below) =
        (block((10, 10), DVec2::new(middle, 9.0)), block((10, 10), DVec2::new(middle, 33.0)));
    let whole = bound(&ground, &group(above.clone(), below.clone()), SPEED).unwrap();
    let part = |points: &[DVec2], parity: usize| points.iter().copied().skip(parity).step_by(2).collect();
    let halves = [0, 1].map(|parity| group(part(&above, parity), part(&below, parity)));
    let meeting = [halves[0].clone(), group(halves[1].goals.clone(), halves[1].starts.clone())];
    for groups in [halves, meeting] {
        let alone =
            groups.iter().map(|group| bound(&ground, group, SPEED).unwrap()).fold(0.0, Scalar::greater);
        let together = bound_of_groups(&ground, &groups, SPEED).unwrap();
        assert!(alone < 0.8 * whole, "{alone} {whole}");
        // The first of the whole group are a little nearer to the gap than those of both halves, or not.
        assert!((together - whole).abs() < 0.03 * whole, "{together} {whole}");
    }
}

#[test]
fn scattered_circles_go_each_to_a_goal_of_its_own() {
    for seed in 0..20 {
        let mut dice = Dice(seed);
        let map = scattered(&mut dice, 40, 0.1);
        let (starts, goals) = places(&mut dice, &map, 40);
        let groups: Vec<Group> =
            starts.iter().zip(&goals).map(|(&start, &goal)| group(vec![start], vec![goal])).collect();
        check(&format!("scattered, seed {seed}"), &map, RADIUS, &groups);
    }
}

#[test]
fn whoever_has_its_own_goal_gets_there() {
    let map = gap(2);
    let middle = 0.5 * f64::from(map.width());
    let starts = block((8, 3), DVec2::new(middle, 9.0));
    let goals = block((8, 3), DVec2::ZERO).into_iter();
    let mut goals: Vec<DVec2> = goals.map(|goal| DVec2::new(middle, 33.0) + 2.0 * goal).collect();
    goals.rotate_left(7);
    check("own goals", &map, RADIUS, &[Group { starts, goals, whose: Goals::Own }]);
}

#[test]
fn who_stands_in_the_way_is_gone_around() {
    let map = gap(5);
    let middle = 0.5 * f64::from(map.width());
    let groups = [group(block((4, 4), DVec2::new(middle, 9.0)), block((4, 4), DVec2::new(middle, 33.0)))];
    let ground = Ground::new(&map, RADIUS).unwrap();
    let stone = |x: f64, y: f64| Circle::new(DVec2::new(x, y), 0.5);
    let request = |still| release(&ground, &Request { groups: &groups, speed: SPEED, still, moving: &[] });
    let some = [stone(middle, 21.5), stone(middle - 1.0, 21.5), stone(middle - 2.0, 21.5)];
    let schedule = request(&some).unwrap();
    for walk in &schedule.walks[0] {
        assert!(walk.legs.windows(2).all(|leg| {
            let line: maniple_geometry::Segment = (leg[0], leg[1]).into();
            some.iter().all(|stone| line.nearest(stone.center).distance(stone.center) >= 0.85)
        }));
    }
    let wall = [-2.0, -1.0, 0.0, 1.0, 2.0].map(|x| stone(middle + x, 21.5));
    assert!(matches!(request(&wall), Err(ReleaseError::NoDeparture { group: 0, .. })));
    let odd = [group(vec![DVec2::new(middle, 9.0)], vec![])];
    let error = release(&ground, &Request { groups: &odd, speed: SPEED, still: &[], moving: &[] });
    assert_eq!(error, Err(ReleaseError::Goals { group: 0, circles: 1, goals: 0 }));
}

#[test]
fn a_schedule_found_in_parts_is_that_found_at_once() {
    let map = gap(3);
    let middle = 0.5 * f64::from(map.width());
    let through = [group(block((6, 5), DVec2::new(middle, 9.0)), block((6, 5), DVec2::new(middle, 33.0)))];
    let across = [group(block((6, 6), DVec2::new(8.0, 6.0)), block((6, 6), DVec2::new(22.0, 14.0)))];
    let ground = Ground::new(&map, RADIUS).unwrap();
    for groups in [&through[..], &across[..]] {
        let request = Request { groups, speed: SPEED, still: &[], moving: &[] };
        let whole = release(&ground, &request);
        for budget in [1, 5_000, 100_000] {
            let mut releasing = Releasing::new(&request);
            let (mut ended, mut parts, mut most) = (None, 0, 0);
            while ended.is_none() {
                let before = releasing.looks();
                ended = releasing.advance(&ground, budget);
                most = most.max(releasing.looks() - before);
                parts += 1;
            }
            println!("budget {budget}: {parts} parts, {most} looks at most, {} in all", releasing.looks());
            assert_eq!(ended, Some(whole.clone()));
            assert!(most < budget + 20_000, "{most}");
        }
    }
}

/// What the largest groups take; `MANIPLE_LONG=1` schedules 2,000, the ordinary run 100.
#[test]
#[expect(clippy::disallowed_methods, reason = "a test may look at its environment")]
fn large_groups_are_scheduled_in_parts() {
    let side = if std::env::var_os("MANIPLE_LONG").is_some() { (50, 40) } else { (10, 10) };
    let ground = Ground::new(&open(130), RADIUS).unwrap();
    let groups = [group(block(side, DVec2::new(32.0, 32.0)), block(side, DVec2::new(98.0, 98.0)))];
    let request = Request { groups: &groups, speed: SPEED, still: &[], moving: &[] };
    let mut releasing = Releasing::new(&request);
    let (mut ended, mut cycles, mut most) = (None, 0, 0);
    while ended.is_none() {
        let before = releasing.looks();
        ended = releasing.advance(&ground, 1 << 20);
        most = most.max(releasing.looks() - before);
        cycles += 1;
    }
    println!("{} units: {} looks in {cycles} cycles, {most} at most", side.0 * side.1, releasing.looks());
    assert!(ended.unwrap().is_ok() && most < (1 << 20) + 120_000);
}

/// Points with room, more than a tile apart: so many, and as many others.
fn places(dice: &mut Dice, map: &TileMap, count: usize) -> (Vec<DVec2>, Vec<DVec2>) {
    let ground = Ground::new(map, RADIUS).unwrap();
    let mut points: Vec<DVec2> = Vec::new();
    while points.len() < 2 * count {
        let point = dice.place(map, &ground);
        if points.iter().all(|other| other.distance(point) > 1.0) {
            points.push(point);
        }
    }
    let others = points.split_off(count);
    (points, others)
}
