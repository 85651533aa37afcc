//! Buildings of others and patches that were seen, and are there as far as is known.

use std::collections::BTreeMap;

use glam::DVec2;
use maniple_view::{Shape, hull_distance};

use super::block::Block;
use super::scene::{Item, Scene};

/// How much nearer than its sight a place has to be to an own unit to be counted as seen, in world units.
const MARGIN: f64 = 0.25;

/// What stands at places that may be out of sight.
#[derive(Clone, Debug, Default)]
pub(crate) struct Memory {
    buildings: Places,
    patches: Places,
}

/// By the bits of the centre: what stands does not move.
type Places = BTreeMap<(u64, u64), Block>;

impl Memory {
    /// Takes in what is in sight, and forgets what is gone from where the seat looks.
    pub(crate) fn refresh(&mut self, scene: &Scene<'_>) {
        let stands = |item: &&Item<'_>| item.kind.speed == 0.0 && item.kind.alternate.is_none();
        refresh(&mut self.buildings, scene, scene.enemies.iter().filter(stands));
        refresh(&mut self.patches, scene, scene.patches());
    }

    /// Returns what items cover and the buildings that are remembered, by (y, x), nothing twice.
    pub(crate) fn with<'a, 'b>(&self, items: impl Iterator<Item = &'b Item<'a>>) -> Vec<Block>
    where
        'a: 'b,
    {
        let mut blocks: Vec<Block> = items.map(Item::block).chain(self.blocks().copied()).collect();
        blocks.sort_by(|one, other| {
            (one.center.y.total_cmp(&other.center.y)).then(one.center.x.total_cmp(&other.center.x))
        });
        blocks.dedup();
        blocks
    }

    /// Returns the buildings of others.
    pub(crate) fn blocks(&self) -> impl Iterator<Item = &Block> {
        self.buildings.values()
    }

    /// Returns the patches, by (y, x).
    pub(crate) fn patches(&self) -> impl Iterator<Item = &Block> {
        self.patches.values()
    }
}

fn refresh<'a, 'b>(places: &mut Places, scene: &Scene<'_>, items: impl Iterator<Item = &'b Item<'a>>)
where
    'a: 'b,
{
    let seen: Places = items.map(|item| (key(item.center), item.block())).collect();
    let is_looked_at = |block: &Block| {
        scene.own.iter().any(|item| {
            let shape = Shape::Rectangle { width: 2.0 * block.half.x, height: 2.0 * block.half.y };
            hull_distance(block.center - item.center, &item.kind.shape, &shape) < item.kind.sight - MARGIN
        })
    };
    places.retain(|key, block| seen.contains_key(key) || !is_looked_at(block));
    places.extend(seen);
}

fn key(point: DVec2) -> (u64, u64) {
    (point.y.to_bits(), point.x.to_bits())
}
