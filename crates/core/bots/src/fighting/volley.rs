//! Who fires at whom: the fire of all is concentrated, and no more of it than it takes.

use std::collections::BTreeMap;

use maniple_view::Handle;

use super::aim::{damage, is_in_range, weapon};
use crate::seeing::Item;

/// Returns the target of each of those who fire in a cycle and have somebody in range.
///
/// One after the other, by handle, takes the enemy in range with the least hit points that are left after the shots before. Who is armed
/// comes before who is not, then who is not killed by the shots before, and of several the first by handle.
pub(crate) fn volley(shooters: &[&Item<'_>], enemies: &[Item<'_>]) -> BTreeMap<Handle, Handle> {
    let mut left: BTreeMap<Handle, u32> =
        enemies.iter().map(|enemy| (enemy.object, enemy.seen.status.hit_points.unwrap_or(0))).collect();
    let mut targets = BTreeMap::new();
    for shooter in shooters {
        let Some(weapon) = weapon(shooter) else { continue };
        let worth = |enemy: &&Item<'_>| {
            let left = left[&enemy.object];
            (enemy.kind.weapon.is_none(), left == 0, left, enemy.object)
        };
        let in_range = enemies.iter().filter(|enemy| is_in_range(shooter, enemy, weapon));
        let Some(target) = in_range.min_by_key(worth) else { continue };
        targets.insert(shooter.object, target.object);
        let left = left.entry(target.object).or_default();
        *left = left.saturating_sub(damage(weapon, target));
    }
    targets
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_items::{armed, item, resting};

    #[test]
    fn the_weakest_in_range_gets_as_much_fire_as_it_takes_and_no_more() {
        let (kind, unarmed) = (armed(4.0), maniple_view::UnitType { weapon: None, ..armed(4.0) });
        let check = |enemies: &[(f64, u32)], expected: &[(u32, u32)]| {
            let own: Vec<_> = [5.0, 5.0, 5.0, 5.0].map(|x| resting(x, 100)).to_vec();
            let shooters: Vec<Item<'_>> =
                (0..).zip(&own).map(|(number, seen)| item(number, seen, &kind)).collect();
            let seen: Vec<_> = enemies.iter().map(|&(x, hit_points)| resting(x, hit_points)).collect();
            let mut enemies: Vec<Item<'_>> =
                (10..).zip(&seen).map(|(number, seen)| item(number, seen, &kind)).collect();
            if let Some(last) = enemies.last_mut() {
                last.kind = &unarmed;
            }
            let shooters: Vec<&Item<'_>> = shooters.iter().collect();
            let targets = volley(&shooters, &enemies);
            let expected = expected.iter().map(|&(one, other)| (Handle(one), Handle(other)));
            assert_eq!(targets, expected.collect(), "{enemies:?}");
        };
        // 20 a shot: two kill the one with 30, and the next two go at the one with 100 before who is not armed.
        check(&[(8.0, 100), (8.0, 30), (8.0, 10)], &[(0, 11), (1, 11), (2, 10), (3, 10)]);
        // Who is out of range is not fired at; who is dead already only where there is no other.
        check(&[(11.0, 10), (8.0, 30), (11.0, 10)], &[(0, 11), (1, 11), (2, 11), (3, 11)]);
        check(&[(8.0, 20), (8.0, 20), (8.0, 70)], &[(0, 10), (1, 11), (2, 10), (3, 10)]);
        check(&[(11.0, 10)], &[]);
    }
}
