//! Weapons, ranges and damage.

use maniple_geometry::Cycle;
use maniple_view::{Mode, UnitType, Weapon};

use crate::seeing::Item;

/// Returns whether it is there to fight: it has a weapon and does not gather.
pub(crate) fn is_fighter(item: &Item<'_>) -> bool {
    item.kind.weapon.is_some() && item.kind.harvest.is_none()
}

/// Returns what it fights with in its mode; `None` where it cannot.
pub(crate) fn weapon<'a>(item: &Item<'a>) -> Option<&'a Weapon> {
    match item.seen.status.mode {
        Mode::Normal => item.kind.weapon.as_ref(),
        Mode::Alternate => alternate_weapon(item.kind),
        Mode::Switching | Mode::SwitchingBack | Mode::Site => None,
    }
}

/// Returns what a unit type fights with in its other mode; `None` where it has none, or does not.
pub(crate) fn alternate_weapon(kind: &UnitType) -> Option<&Weapon> {
    kind.alternate.as_ref()?.weapon.as_ref()
}

/// Returns whether a unit can fire in this cycle.
pub(crate) fn is_ready(item: &Item<'_>, cycle: Cycle) -> bool {
    item.seen.own.is_some_and(|own| own.ready <= cycle)
}

/// Returns whether a weapon reaches from one to the other where they are.
pub(crate) fn is_in_range(item: &Item<'_>, enemy: &Item<'_>, weapon: &Weapon) -> bool {
    let distance = item.distance(enemy);
    weapon.range_min <= distance && distance <= weapon.range && can_hit(weapon, enemy)
}

/// Returns whether a weapon hits in the layer of an enemy.
pub(crate) fn can_hit(weapon: &Weapon, enemy: &Item<'_>) -> bool {
    weapon.targets.contains(&enemy.kind.layer)
}

/// Returns how much a shot takes off an enemy in the mean, rounded down.
pub(crate) fn damage(weapon: &Weapon, enemy: &Item<'_>) -> u32 {
    let armor = match (enemy.seen.status.mode, &enemy.kind.alternate) {
        (Mode::Alternate | Mode::SwitchingBack, Some(alternate)) => alternate.armor,
        (Mode::Normal | Mode::Switching | Mode::Site | Mode::Alternate | Mode::SwitchingBack, _) => {
            enemy.kind.armor
        }
    };
    weapon.damage_min.midpoint(weapon.damage_max).saturating_sub(armor).max(1)
}
