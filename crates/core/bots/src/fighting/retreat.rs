//! Stepping back while the weapon reloads.

use glam::DVec2;
use maniple_pathfinding::Ground;
use maniple_view::Command;

use super::aim::{can_hit, weapon};
use crate::seeing::Item;

/// With less than so many of so many parts of its hit points a unit is hurt. Of 8 matches of `focus` against `rush` in the second ORTS game 8
/// were won with this, 5 with a third, and 4 where nobody steps back.
const HURT: (u32, u32) = (3, 5);

/// How much farther than an enemy reaches a unit steps back, in world units.
const SAFE: f64 = 1.0;

/// How much shorter the range of an enemy has to be to be kept away from, in world units.
const OUTRANGED: f64 = 0.5;

/// Directions that are tried, from straight away from the enemies to across, as turns of it: cosine and sine of 0, 45 and 90 degrees.
const TURNS: [(f64, f64); 5] = [(1.0, 0.0), (0.7, 0.7), (0.7, -0.7), (0.0, 1.0), (0.0, -1.0)];

/// Returns the order to step back from enemies that reach a unit while it reloads until the cycle `ready`: where its weapon reaches farther
/// than theirs, or as far and it is hurt; from who reaches farther there is no getting away. `None` where it stays.
pub(crate) fn step_back(
    item: &Item<'_>,
    enemies: &[Item<'_>],
    ground: &Ground,
    (now, ready): (u32, u32),
) -> Option<Command> {
    let range = weapon(item)?.range;
    let is_hurt = is_hurt(item);
    let mut away = DVec2::ZERO;
    for enemy in enemies {
        let Some(theirs) = weapon(enemy).filter(|weapon| can_hit(weapon, item)) else { continue };
        let is_feared = (is_hurt && theirs.range <= range) || theirs.range + OUTRANGED < range;
        let reach = theirs.range + SAFE;
        let distance = item.distance(enemy);
        if is_feared && distance < reach {
            let offset = item.center - enemy.center;
            let length = offset.length();
            if length > 0.0 {
                away += offset * ((reach - distance) / length);
            }
        }
    }
    let length = away.length();
    // Half of the time it goes there, the other half it comes back.
    let step = item.kind.speed * f64::from(ready.saturating_sub(now + 1)) * 0.5;
    if length == 0.0 || step < item.kind.speed {
        return None;
    }
    let unit = away / length;
    let goals = TURNS.iter().map(|&(cos, sin)| {
        let turned = DVec2::new(unit.x * cos - unit.y * sin, unit.x * sin + unit.y * cos);
        item.center + turned * step
    });
    let goal = goals.into_iter().find(|&goal| ground.is_clear(item.center, goal))?;
    Some(Command::Move { object: item.object, x: goal.x, y: goal.y, s: None, queue: false, start: None })
}

/// Returns whether a unit has lost most of its hit points.
pub(crate) fn is_hurt(item: &Item<'_>) -> bool {
    let left = item.seen.status.hit_points;
    left.zip(item.kind.hit_points).is_some_and(|(left, whole)| left * HURT.1 < whole * HURT.0)
}

#[cfg(test)]
mod tests {
    use maniple_view::Terrain;

    use super::*;
    use crate::test_items::{armed, item, resting};

    #[test]
    fn who_is_hurt_or_reaches_farther_steps_back_and_others_stay() {
        let terrain =
            Terrain { width: 20, height: 10, tiles: vec![".".repeat(20); 10], segments: Vec::new() };
        let ground = Ground::new(&terrain.map().unwrap(), 0.5).unwrap();
        // Own range and hit points, range of the enemy, cycles until the weapon is ready; where it goes.
        let check = |(range, left): (f64, u32), theirs: f64, ready: u32, expected: Option<f64>| {
            let (own, other) = (armed(range), armed(theirs));
            let (seen, seen_other) = (resting(10.0, left), resting(14.0, 100));
            let enemy = item(1, &seen_other, &other);
            let command = step_back(&item(0, &seen, &own), &[enemy], &ground, (5, 5 + ready));
            let x = command.map(|command| {
                let Command::Move { x, y, .. } = command else { panic!("{command:?}") };
                assert!((y - 5.0).abs() < 1e-9);
                x
            });
            assert_eq!(x, expected, "{range} {left} {theirs} {ready}");
        };
        // Half of 8 cycles at a quarter of a world unit.
        check((4.0, 59), 4.0, 9, Some(9.0));
        check((4.0, 60), 4.0, 9, None);
        check((5.0, 100), 4.0, 9, Some(9.0));
        // From who reaches farther there is no getting away.
        check((4.0, 10), 5.0, 9, None);
        // There is no time, or the enemy does not reach so far.
        check((4.0, 10), 4.0, 1, None);
        check((4.0, 10), 1.0, 9, None);
    }
}
