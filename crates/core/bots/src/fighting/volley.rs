//! Who fires at whom: the fire of all is concentrated, and no more of it than it takes.

use std::collections::BTreeMap;

use maniple_view::Handle;

use super::aim::{damage, is_in_range, weapon};
use crate::seeing::Item;

/// Returns the target of each of those who fire in a cycle and have somebody in range.
///
/// One after the other, by handle, takes the enemy in range with the least hit points that are left after the shots before; among those
/// for whom these are enough already only where there is no other. Who is armed comes before who is not, and of several the first by
/// handle.
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
