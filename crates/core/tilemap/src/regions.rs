//! Which tiles hang together.

use crate::TileMap;

/// The label of a tile that belongs to no region.
const NONE: u32 = u32::MAX;

/// The regions of a map: sets of passable tiles that can be reached from each other over the edges of tiles.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Regions {
    width: u32,
    labels: Vec<u32>,
    sizes: Vec<u32>,
    firsts: Vec<(u32, u32)>,
}

impl Regions {
    /// Returns how many regions there are.
    #[must_use]
    pub fn count(&self) -> usize {
        self.sizes.len()
    }

    /// Returns the region of a tile, `0..count`, numbered in the order of their first tiles, row by row; `None` for
    /// a tile that is not passable or outside of the map.
    #[must_use]
    pub fn label(&self, x: u32, y: u32) -> Option<u32> {
        if x >= self.width {
            return None;
        }
        self.labels.get(y as usize * self.width as usize + x as usize).copied().filter(|&label| label != NONE)
    }

    /// Returns how many tiles each region has, by label.
    #[must_use]
    pub fn sizes(&self) -> &[u32] {
        &self.sizes
    }

    /// Returns the first tile of each region, row by row, by label.
    #[must_use]
    pub fn firsts(&self) -> &[(u32, u32)] {
        &self.firsts
    }

    /// Returns the label of the region with the most tiles, the first one of them; `None` where nothing is
    /// passable.
    #[must_use]
    pub fn largest(&self) -> Option<u32> {
        let largest = self.sizes.iter().max()?;
        (0..).zip(&self.sizes).find(|(_, size)| *size == largest).map(|(label, _)| label)
    }
}

/// Returns the regions of a map. Tiles hang together over a common edge, not over a corner; half-blocked tiles
/// belong to no region, and free walls do not part any.
#[must_use]
pub fn regions(map: &TileMap) -> Regions {
    let mut regions = Regions {
        width: map.width(),
        labels: vec![NONE; map.tiles().len()],
        sizes: Vec::new(),
        firsts: Vec::new(),
    };
    let mut waiting = Vec::new();
    for y in 0..map.height() {
        for x in 0..map.width() {
            if map.is_passable(x, y) && regions.label(x, y).is_none() {
                regions.firsts.push((x, y));
                let size = fill(map, &mut regions, &mut waiting, (x, y));
                regions.sizes.push(size);
            }
        }
    }
    regions
}

/// Gives the next label to everything that hangs together with `first`, and returns how many tiles that are.
fn fill(map: &TileMap, regions: &mut Regions, waiting: &mut Vec<(u32, u32)>, first: (u32, u32)) -> u32 {
    let width = map.width() as usize;
    let label = u32::try_from(regions.sizes.len()).unwrap_or(NONE);
    let mut size = 0;
    regions.labels[first.1 as usize * width + first.0 as usize] = label;
    waiting.push(first);
    while let Some((x, y)) = waiting.pop() {
        size += 1;
        for (x, y) in neighbours(x, y) {
            if map.is_passable(x, y) && regions.label(x, y).is_none() {
                regions.labels[y as usize * width + x as usize] = label;
                waiting.push((x, y));
            }
        }
    }
    size
}

/// Returns the tiles above, left, right and below. Those beyond the upper or left edge of the map have a coordinate
/// that no map reaches, so that they are impassable like the ones beyond the other edges.
pub(crate) fn neighbours(x: u32, y: u32) -> [(u32, u32); 4] {
    [(x, y.wrapping_sub(1)), (x.wrapping_sub(1), y), (x + 1, y), (x, y + 1)]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::octile;

    #[test]
    fn tiles_hang_together_over_edges_and_not_over_corners() {
        let map = octile::read(b"type octile\nheight 3\nwidth 4\nmap\n.@..\n@...\n.@@.\n").unwrap();
        let regions = regions(&map);
        assert_eq!(regions.count(), 3);
        assert_eq!(regions.sizes(), [1, 6, 1]);
        assert_eq!(regions.firsts(), [(0, 0), (2, 0), (0, 2)]);
        assert_eq!(regions.largest(), Some(1));
        assert_eq!(regions.label(1, 0), None);
        assert_eq!(regions.label(3, 2), Some(1));
        assert_eq!(regions.label(4, 0), None);
        assert_eq!(regions.label(0, 3), None);
    }

    #[test]
    fn a_map_without_open_ground_has_no_region() {
        let map = octile::read(b"type octile\nheight 1\nwidth 2\nmap\n@T\n").unwrap();
        assert_eq!(regions(&map).count(), 0);
        assert_eq!(regions(&map).largest(), None);
    }
}
