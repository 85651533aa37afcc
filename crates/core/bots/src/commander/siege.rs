//! Units with a second mode that reaches farther and hits around.

use glam::DVec2;
use maniple_view::{Command, Weapon};

use super::army::Situation;
use super::scene::Item;

/// Cycles with nobody in range after which a unit goes back to its first mode.
pub(super) const PATIENCE: u32 = 16;

/// How much farther than the least range of the second mode an enemy has to be, in world units: it comes nearer meanwhile.
const MARGIN: f64 = 2.0;

/// Most points that are compared.
const CANDIDATES_MAX: usize = 12;

/// Returns the order to switch where the second mode reaches an enemy that the first does not, and none is too near for it.
pub(super) fn deploy(item: &Item<'_>, enemies: &[Item<'_>]) -> Option<Command> {
    let first = item.kind.weapon.as_ref()?;
    let second = item.kind.alternate.as_ref()?.weapon.as_ref()?;
    if second.range <= first.range {
        return None;
    }
    let mut gains = false;
    for enemy in enemies {
        let distance = item.distance(enemy);
        if distance < second.range_min + MARGIN {
            return None;
        }
        gains |= distance > first.range && reaches(item, enemy, second);
    }
    gains.then_some(Command::Switch { object: item.object })
}

/// Returns whether a weapon reaches the centre of an enemy: it is fired at a point.
pub(super) fn reaches(item: &Item<'_>, enemy: &Item<'_>, weapon: &Weapon) -> bool {
    let distance = item.center.distance(enemy.center) - item.kind.shape.radius();
    weapon.range_min <= distance && distance <= weapon.range && weapon.targets.contains(&enemy.kind.layer)
}

/// Returns the point at which a weapon hits most enemies, and not more friends; `None` where there is none.
pub(super) fn best_point(
    targets: &[&Item<'_>],
    situation: &Situation<'_, '_>,
    weapon: &Weapon,
) -> Option<DVec2> {
    let radius = weapon.splash.map_or(0.0, |splash| splash.radius);
    let hit = |items: &[Item<'_>], point: DVec2| {
        let is_hit = |item: &&Item<'_>| {
            item.center.distance(point) <= radius + item.kind.shape.radius()
                && weapon.targets.contains(&item.kind.layer)
        };
        i64::try_from(items.iter().filter(is_hit).count()).unwrap_or(i64::MAX)
    };
    let gain = |point: DVec2| {
        let friends = if situation.friendly_fire {
            hit(&situation.scene.own, point) + hit(&situation.scene.allies, point)
        } else {
            0
        };
        hit(&situation.scene.enemies, point) - 2 * friends
    };
    let stride = targets.len().div_ceil(CANDIDATES_MAX).max(1);
    let points = targets.iter().step_by(stride).map(|item| (gain(item.center), item.center));
    let best = points.max_by(|one, other| {
        (one.0.cmp(&other.0)).then(other.1.y.total_cmp(&one.1.y)).then(other.1.x.total_cmp(&one.1.x))
    });
    best.filter(|&(gain, _)| gain > 0).map(|(_, point)| point)
}
