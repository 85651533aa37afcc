//! The ground for circles of each radius, with the buildings that stand on it.

use std::collections::BTreeMap;
use std::sync::Arc;

use glam::DVec2;
use maniple_pathfinding::Ground;
use maniple_view::{Terrain, UNKNOWN_TILE};

use crate::seeing::{Block, size};

/// The terrain with buildings as walls, as circles of each radius that was asked for see it.
#[derive(Clone, Debug, Default)]
pub(crate) struct Roads {
    terrain: Terrain,
    blocks: Vec<Block>,
    /// By the bits of the radius; `None` where no ground can be made for it.
    grounds: BTreeMap<u64, Option<Arc<Ground>>>,
}

impl Roads {
    /// Takes in the terrain as far as it is known, and all that stands on it.
    pub(crate) fn refresh(&mut self, terrain: &Terrain, blocks: Vec<Block>) {
        if blocks != self.blocks || *terrain != self.terrain {
            self.grounds.clear();
            self.terrain = terrain.clone();
            self.blocks = blocks;
        }
    }

    /// Returns the ground for a radius; `None` where it is larger than paths are planned for.
    pub(crate) fn ground(&mut self, radius: f64) -> Option<Arc<Ground>> {
        let Self { terrain, blocks, grounds } = self;
        let ground = grounds.entry(radius.to_bits());
        ground.or_insert_with(|| built_up(terrain, blocks, radius).map(Arc::new)).clone()
    }

    /// Returns the width and height of the map, in world units.
    pub(crate) fn size(&self) -> DVec2 {
        size(&self.terrain)
    }

    /// Returns whether a point is inside of a building.
    pub(crate) fn is_covered(&self, point: DVec2) -> bool {
        self.blocks.iter().any(|block| {
            let offset = (point - block.center).abs();
            offset.x < block.half.x && offset.y < block.half.y
        })
    }
}

/// Returns the ground with the sides of buildings as walls; what is not known of the terrain counts as open.
///
/// Behind the border of its tiles a terrain lists the walls of any angle.
fn built_up(terrain: &Terrain, blocks: &[Block], radius: f64) -> Option<Ground> {
    let mut terrain = terrain.clone();
    if terrain.tiles.iter().any(|row| row.contains(UNKNOWN_TILE)) {
        terrain.tiles.iter_mut().for_each(|row| *row = row.replace(UNKNOWN_TILE, "."));
        let border = terrain.map()?.border();
        terrain.segments =
            border.iter().map(|wall| (wall.start.x, wall.start.y, wall.end.x, wall.end.y)).collect();
    }
    for Block { center, half } in blocks {
        let (low, high) = (*center - *half, *center + *half);
        terrain.segments.extend([
            (low.x, low.y, high.x, low.y),
            (high.x, low.y, high.x, high.y),
            (high.x, high.y, low.x, high.y),
            (low.x, high.y, low.x, low.y),
        ]);
    }
    Ground::new(&terrain.map()?, radius).ok()
}

#[cfg(test)]
mod tests {
    use maniple_pathfinding::Planner;

    use super::*;

    fn terrain(rows: &[&str]) -> Terrain {
        let mut terrain = Terrain {
            width: u32::try_from(rows[0].len()).unwrap(),
            height: u32::try_from(rows.len()).unwrap(),
            tiles: rows.iter().map(|&row| row.to_owned()).collect(),
            segments: Vec::new(),
        };
        if let Some(map) = terrain.map() {
            terrain.segments = Terrain::of(&map).segments;
        }
        terrain
    }

    #[test]
    fn ways_lead_around_buildings_as_near_as_the_circle_fits() {
        for open in ["........", "....?..."] {
            let mut roads = Roads::default();
            let house = Block { center: DVec2::new(4.0, 3.25), half: DVec2::new(1.0, 2.0) };
            roads.refresh(&terrain(&[open; 8]), vec![house]);
            assert!(roads.is_covered(DVec2::new(4.9, 3.0)) && !roads.is_covered(DVec2::new(5.1, 3.0)));
            let ground = roads.ground(0.4).unwrap();
            let (from, to) = (DVec2::new(1.0, 3.0), DVec2::new(7.0, 3.0));
            assert!(!ground.is_clear(from, to));
            let mut planner = Planner::new(&ground);
            let legs = planner.path(from, to).unwrap();
            // 1.25 world units are left above, and more below: both have room.
            assert!(legs.len() > 1 && legs.iter().all(|leg| ground.holds(*leg)), "{legs:?}");
            roads.refresh(&terrain(&[open; 8]), Vec::new());
            assert!(roads.ground(0.4).unwrap().is_clear(from, to));
            assert!(roads.ground(5.0).is_none());
        }
    }
}
