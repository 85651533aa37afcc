//! Units with a second mode that reaches farther and hits around.

use std::collections::BTreeMap;

use glam::DVec2;
use maniple_geometry::Cycle;
use maniple_view::{Command, Handle, Weapon};

use super::aim::{alternate_weapon, can_hit, is_ready};
use crate::seeing::{Item, Scene};

/// Cycles with nobody in range after which a unit goes back to its first mode.
const PATIENCE: u32 = 16;

/// How much farther than the least range of the second mode an enemy has to be, in world units: it comes nearer meanwhile.
const MARGIN: f64 = 2.0;

/// Most points that are compared.
const CANDIDATES_MAX: usize = 12;

/// What a unit in its second mode can do in a cycle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Siege {
    /// There is nobody in range, or it reloads.
    Wait,
    /// It fires at a point.
    Fire(DVec2),
    /// Wherever it fires, it hits friends as well as enemies.
    Spare,
    /// There has been nobody in range for a while.
    Over,
}

/// Since when units in their second mode have had nobody in range.
#[derive(Clone, Debug, Default)]
pub(crate) struct Sieges {
    bored: BTreeMap<Handle, u32>,
}

impl Sieges {
    /// Forgets who is gone.
    pub(crate) fn refresh(&mut self, scene: &Scene<'_>) {
        self.bored.retain(|object, _| scene.own(*object).is_some());
    }

    /// Returns what a unit in its second mode can do; `None` where it has no weapon in it.
    pub(crate) fn next(
        &mut self,
        item: &Item<'_>,
        scene: &Scene<'_>,
        cycle: Cycle,
        friendly_fire: bool,
    ) -> Option<Siege> {
        let weapon = alternate_weapon(item.kind)?;
        let in_range = |enemy: &&Item<'_>| reaches(item, enemy, weapon, 0.0);
        let targets: Vec<&Item<'_>> = scene.enemies.iter().filter(in_range).collect();
        if targets.is_empty() {
            let since = *self.bored.entry(item.object).or_insert(cycle.0);
            return Some(if cycle.0 > since + PATIENCE { Siege::Over } else { Siege::Wait });
        }
        self.bored.remove(&item.object);
        if !is_ready(item, cycle) {
            return Some(Siege::Wait);
        }
        Some(best_point(&targets, scene, weapon, friendly_fire).map_or(Siege::Spare, Siege::Fire))
    }
}

/// Returns the order to switch where the second mode reaches an enemy that the first does not, or will if it comes nearer by `closing`,
/// in world units, and none is too near for it.
pub(crate) fn deploy(item: &Item<'_>, enemies: &[Item<'_>], closing: f64) -> Option<Command> {
    let first = item.kind.weapon.as_ref()?;
    let second = alternate_weapon(item.kind)?;
    if second.range <= first.range {
        return None;
    }
    let mut gains = false;
    for enemy in enemies {
        let distance = item.distance(enemy);
        if distance < second.range_min + MARGIN {
            return None;
        }
        gains |= distance > first.range && reaches(item, enemy, second, closing);
    }
    gains.then_some(Command::Switch { object: item.object })
}

/// Returns whether a weapon that is fired at points reaches the centre of an enemy, or will if it comes nearer by `closing`, in world
/// units.
fn reaches(item: &Item<'_>, enemy: &Item<'_>, weapon: &Weapon, closing: f64) -> bool {
    let distance = item.center.distance(enemy.center) - item.kind.shape.radius();
    weapon.range_min <= distance && distance <= weapon.range + closing && can_hit(weapon, enemy)
}

/// Returns the point at which a weapon hits most enemies, and not more friends where it hurts them, too; `None` where there is none.
fn best_point(
    targets: &[&Item<'_>],
    scene: &Scene<'_>,
    weapon: &Weapon,
    friendly_fire: bool,
) -> Option<DVec2> {
    let radius = weapon.splash.map_or(0.0, |splash| splash.radius);
    let hit = |items: &[Item<'_>], point: DVec2| {
        let is_hit = |item: &&Item<'_>| {
            item.center.distance(point) <= radius + item.kind.shape.radius() && can_hit(weapon, item)
        };
        i64::try_from(items.iter().filter(is_hit).count()).unwrap_or(i64::MAX)
    };
    let gain = |point: DVec2| {
        let friends = if friendly_fire { hit(&scene.own, point) + hit(&scene.allies, point) } else { 0 };
        hit(&scene.enemies, point) - 2 * friends
    };
    let stride = targets.len().div_ceil(CANDIDATES_MAX).max(1);
    let points = targets.iter().step_by(stride).map(|item| (gain(item.center), item.center));
    let best = points.max_by(|one, other| {
        (one.0.cmp(&other.0)).then(other.1.y.total_cmp(&one.1.y)).then(other.1.x.total_cmp(&one.1.x))
    });
    best.filter(|&(gain, _)| gain > 0).map(|(_, point)| point)
}
