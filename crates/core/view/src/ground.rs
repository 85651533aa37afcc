//! What one player knows of the terrain, and which of it is visible.

use std::sync::Arc;

use crate::delta::Delta;
use crate::fnv::Fnv;
use crate::rules::{Rules, TILES_KNOWN, Terrain, TerrainKnowledge, UNKNOWN_TILE};
use crate::tile_set::TileSet;
use crate::view::MismatchError;

/// What counts for a visible tile in the hash of a view, where a known one counts as its character.
const VISIBLE: u8 = b'*';

/// The terrain as one player knows it.
///
/// *Shroud* lies over a tile that was never seen, *fog* over a known one that is not visible now.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Ground {
    /// Shared by all who know the same; a player who explores has an own one from the first tile on.
    terrain: Arc<Terrain>,
    knowledge: TerrainKnowledge,
    /// `None`: there is no fog.
    visible: Option<TileSet>,
    /// Wrapping sum of a hash a visible tile, and, if terrain is explored, a known tile and a wall.
    sum: u64,
}

impl Ground {
    /// Returns the ground at the start, with nothing visible if there is fog.
    pub(crate) fn new(rules: &Rules, terrain: Arc<Terrain>) -> Self {
        let visible = rules.fog.then(|| TileSet::new(terrain.width, terrain.height));
        Self { terrain, knowledge: rules.terrain, visible, sum: 0 }
    }

    /// Changes it by a delta.
    pub(crate) fn apply(&mut self, delta: &Delta) -> Result<(), MismatchError> {
        self.toggle(delta)?;
        if delta.revealed.is_empty() && delta.walls.is_empty() {
            return Ok(());
        }
        let cycle = delta.cycle;
        for &(x, y, ref tiles) in &delta.revealed {
            self.reveal(x, y, tiles).ok_or(MismatchError::Revealed { cycle, x, y })?;
        }
        Arc::make_mut(&mut self.terrain).segments.extend_from_slice(&delta.walls);
        for wall in &delta.walls {
            self.sum = self.sum.wrapping_add(hash_wall(wall));
        }
        Ok(())
    }

    fn toggle(&mut self, delta: &Delta) -> Result<(), MismatchError> {
        let mismatch = MismatchError::Sight { cycle: delta.cycle };
        let mut at = 0u32;
        for &(skip, count) in &delta.sight {
            let visible = self.visible.as_mut().ok_or(mismatch)?;
            let first = at.checked_add(skip).ok_or(mismatch)?;
            at = first.checked_add(count).filter(|&end| end <= visible.area()).ok_or(mismatch)?;
            visible.toggle_run(first, count);
            for number in first..at {
                let (x, y) = (number % visible.width(), number / visible.width());
                let hash = hash_tile(number, VISIBLE);
                let is_visible = visible.contains(x, y);
                self.sum = if is_visible { self.sum.wrapping_add(hash) } else { self.sum.wrapping_sub(hash) };
            }
        }
        Ok(())
    }

    /// Takes that the tiles from (x, y) on to the right are known; `None` where that cannot be.
    fn reveal(&mut self, x: u32, y: u32, tiles: &str) -> Option<()> {
        let terrain = Arc::make_mut(&mut self.terrain);
        let row = terrain.tiles.get_mut(y as usize)?;
        let places = x as usize..(x as usize).checked_add(tiles.len())?;
        let is_shroud = |known: &[u8]| known.iter().all(|&tile| tile == UNKNOWN_TILE as u8);
        let can_be = row.as_bytes().get(places.clone()).is_some_and(is_shroud)
            && tiles.chars().all(|tile| TILES_KNOWN.contains(tile));
        if !can_be || tiles.is_empty() {
            return None;
        }
        row.replace_range(places, tiles);
        let first = y.wrapping_mul(terrain.width).wrapping_add(x);
        for (offset, tile) in (0..).zip(tiles.bytes()) {
            self.sum = self.sum.wrapping_add(hash_tile(first.wrapping_add(offset), tile));
        }
        Some(())
    }

    /// Writes into a delta how it differs from the ground at the start.
    pub(crate) fn write_keyframe(&self, delta: &mut Delta) {
        if let Some(visible) = &self.visible {
            delta.sight = changes(&TileSet::new(self.terrain.width, self.terrain.height), visible);
        }
        if self.knowledge == TerrainKnowledge::Known {
            return;
        }
        for (y, row) in (0..).zip(&self.terrain.tiles) {
            let mut x = 0;
            for tiles in row.split(UNKNOWN_TILE) {
                let count = u32::try_from(tiles.len()).unwrap_or(u32::MAX);
                if count > 0 {
                    delta.revealed.push((x, y, tiles.to_owned()));
                }
                x += count + 1;
            }
        }
        delta.walls.clone_from(&self.terrain.segments);
    }

    /// Returns what has to be toggled so that these tiles are visible: see [`Delta::sight`].
    pub(crate) fn changes(&self, visible: Option<&TileSet>) -> Vec<(u32, u32)> {
        match (&self.visible, visible) {
            (Some(before), Some(now)) => changes(before, now),
            (None, None) => Vec::new(),
            (Some(_), None) | (None, Some(_)) => panic!("a view is in fog where its match is"),
        }
    }

    pub(crate) fn terrain(&self) -> &Terrain {
        &self.terrain
    }

    pub(crate) fn is_visible(&self, x: u32, y: u32) -> bool {
        match &self.visible {
            Some(visible) => visible.contains(x, y),
            None => x < self.terrain.width && y < self.terrain.height,
        }
    }

    pub(crate) fn sum(&self) -> u64 {
        self.sum
    }
}

fn changes(before: &TileSet, now: &TileSet) -> Vec<(u32, u32)> {
    let (mut changes, mut at) = (Vec::new(), 0);
    before.differences(now, |first, count| {
        changes.push((first - at, count));
        at = first + count;
    });
    changes
}

/// FNV-1a over number and character. The character comes last: it is never 0, without which the hashes of neighbouring
/// numbers would add up to the same sums.
fn hash_tile(number: u32, character: u8) -> u64 {
    let mut fnv = Fnv::new();
    fnv.write(&number.to_le_bytes());
    fnv.write(&[character]);
    fnv.hash()
}

/// FNV-1a over the coordinates, little-endian.
fn hash_wall(&(x1, y1, x2, y2): &(f64, f64, f64, f64)) -> u64 {
    let mut fnv = Fnv::new();
    for coordinate in [x1, y1, x2, y2] {
        fnv.write(&coordinate.to_le_bytes());
    }
    fnv.hash()
}
