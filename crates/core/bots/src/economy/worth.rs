//! What is worth having: which fighter, and what it takes to train it.

use maniple_view::{UnitType, UnitTypeId};

use crate::player::Start;
use crate::seeing::Scene;

/// Returns the fighter that is worth most for what it costs, of all that the seat's buildings train or its workers' buildings would; of
/// several the first. `None` where there is none.
///
/// Two armies wear each other out as the squares of their numbers (Lanchester, *Aircraft in Warfare*, 1916): an army is worth its number
/// squared times the damage and the hit points of one, and so many can be had as the resources last.
pub(crate) fn best_fighter(start: &Start, scene: &Scene<'_>) -> Option<UnitTypeId> {
    let own = scene.own.iter().flat_map(|item| item.kind.trains.iter());
    let builds = scene.own.iter().flat_map(|item| item.kind.builds.iter());
    let later = builds.flat_map(|&building| start.kind(building).trains.iter());
    let mut known: Vec<UnitTypeId> = own.chain(later).copied().collect();
    known.sort_unstable();
    known.dedup();
    known.retain(|&unit_type| is_fighter(start.kind(unit_type)));
    known.into_iter().rev().max_by(|&one, &other| worth(start.kind(one)).total_cmp(&worth(start.kind(other))))
}

/// Returns the building that is missing for a unit type to be trained: what it requires, or what trains it; `None` where nothing is, or
/// the seat's workers cannot build it. What stands unfinished is not missing.
pub(crate) fn missing_for(start: &Start, scene: &Scene<'_>, unit_type: UnitTypeId) -> Option<UnitTypeId> {
    let mut wanted = unit_type;
    // Each round goes a step up the chain of what is required.
    for _ in 0..start.rules.unit_types.len() {
        let missing = requirements(start, scene, wanted).find(|&building| !has(scene, building));
        match missing {
            Some(building) => wanted = building,
            None => break,
        }
    }
    (wanted != unit_type && can_build(scene, wanted)).then_some(wanted)
}

/// Returns what it takes to train or build a unit type: what it requires, then what trains it.
fn requirements(start: &Start, scene: &Scene<'_>, unit_type: UnitTypeId) -> impl Iterator<Item = UnitTypeId> {
    let trains = trainers(start, scene, unit_type).next();
    start.kind(unit_type).making.requires.iter().copied().chain(trains)
}

/// Returns the buildings that the seat's workers build and that train a unit type.
pub(crate) fn trainers(
    start: &Start,
    scene: &Scene<'_>,
    unit_type: UnitTypeId,
) -> impl Iterator<Item = UnitTypeId> {
    let buildings = scene.buildable().into_iter();
    buildings.filter(move |&building| start.kind(building).trains.contains(&unit_type))
}

fn has(scene: &Scene<'_>, unit_type: UnitTypeId) -> bool {
    scene.own.iter().any(|item| item.seen.unit_type == unit_type)
}

fn can_build(scene: &Scene<'_>, unit_type: UnitTypeId) -> bool {
    scene.own.iter().any(|item| item.kind.builds.contains(&unit_type))
}

fn is_fighter(kind: &UnitType) -> bool {
    kind.weapon.is_some() && kind.harvest.is_none() && kind.speed > 0.0
}

/// Returns what one of a type is worth for its cost.
///
/// By the square law that is damage times hit points over the square of the cost. Who reaches farther and is faster strikes without being
/// struck as long as it keeps its range; the cube of both is a guess that makes tanks of the ORTS games come before marines: with these
/// `macro` lost all of 4 matches against `commander`, with tanks it wins.
fn worth(kind: &UnitType) -> f64 {
    let Some(weapon) = &kind.weapon else { return 0.0 };
    let damage = f64::from(weapon.damage_min.midpoint(weapon.damage_max)) / f64::from(weapon.cooldown);
    let cost = f64::from(kind.making.cost.max(1));
    let lead = weapon.range * kind.speed;
    damage * f64::from(kind.hit_points.unwrap_or(1)) / (cost * cost) * (lead * lead * lead)
}
