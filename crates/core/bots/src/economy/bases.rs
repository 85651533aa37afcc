//! Where the next base is, when the patches near those that stand run out.

use glam::DVec2;
use maniple_view::UnitTypeId;

use crate::player::Start;
use crate::seeing::{Block, Item, Memory, Scene, nearest_point};

/// A patch is of a base when it is nearer than this to a building that takes loads, hull to hull in world units.
const NEAR: f64 = 12.0;

/// Resources that are left near the bases when another one is built: what is gathered meanwhile, and as much again for the way to it.
const LEFT: u32 = 3000;

/// Patches nearer to each other than this, in world units, are one cluster.
const CLUSTER: f64 = 10.0;

/// Returns the building of the next base and the middle of the patches that it is built for: of those that are known and far from every base
/// the cluster nearest to the first base. `None` while enough is left, or where no other patches are known.
pub(crate) fn next_base(start: &Start, scene: &Scene<'_>, memory: &Memory) -> Option<(UnitTypeId, DVec2)> {
    let stores: Vec<&Item<'_>> = scene.own.iter().filter(|item| item.kind.takes_loads).collect();
    let home = stores.first()?.center;
    let is_of_a_base = |point: DVec2| stores.iter().any(|store| distance(&store.block(), point) < NEAR);
    let left = scene.patches().filter(|patch| is_of_a_base(patch.center));
    let left = left.fold(0u32, |sum, patch| sum.saturating_add(patch.seen.status.amount.unwrap_or(0)));
    // One base after the other.
    if left >= LEFT || stores.iter().any(|store| !store.is_finished()) {
        return None;
    }
    let unit_type = scene.buildable().into_iter().find(|&unit_type| start.kind(unit_type).takes_loads)?;
    let far: Vec<DVec2> =
        memory.patches().map(|block| block.center).filter(|&it| !is_of_a_base(it)).collect();
    let from_home = |point: &&DVec2| point.distance_squared(home);
    let first = *far.iter().min_by(|one, other| from_home(one).total_cmp(&from_home(other)))?;
    let cluster: Vec<DVec2> = far.into_iter().filter(|point| point.distance(first) < CLUSTER).collect();
    Some((unit_type, cluster.iter().sum::<DVec2>() / cluster.len() as f64))
}

fn distance(block: &Block, point: DVec2) -> f64 {
    nearest_point(block, point).distance(point)
}
