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

#[cfg(test)]
mod tests {
    use maniple_geometry::Cycle;

    use super::*;
    use crate::view::View;

    #[test]
    fn the_hashes_are_those_of_the_description_of_the_protocol() {
        assert_eq!(hash_tile(5, VISIBLE), 0xa551_ca04_b29e_affe);
        assert_eq!(hash_tile(5, b'.'), 0xa551_ce04_b29e_b6ca);
        let wall = (2.0, 1.0, 1.0, 2.0);
        assert_eq!(hash_wall(&wall), 0x9e0a_c711_b490_6885);
        let ground = ground(TerrainKnowledge::Explored, Some(TileSet::new(4, 2)));
        let mut view = View::with_ground(ground);
        let delta = Delta {
            cycle: Cycle(3),
            sight: vec![(5, 1)],
            revealed: vec![(1, 1, ".".to_owned())],
            walls: vec![wall],
            ..Delta::default()
        };
        view.apply_unchecked(&delta).unwrap();
        assert_eq!(view.check().0, 0x1810_33ea_eaf9_5da0);
        assert!(view.is_visible(1, 1) && !view.is_visible(0, 1) && !view.is_visible(4, 0));
        assert_eq!((view.terrain().tile(1, 1), view.terrain().tile(0, 1)), (Some('.'), None));
        assert_eq!(view.keyframe(), Delta { check: view.check(), ..delta });
    }

    #[test]
    fn fog_goes_and_comes_and_shroud_only_goes() {
        let mut ground = ground(TerrainKnowledge::Explored, Some(TileSet::new(4, 2)));
        let seen = Delta { sight: vec![(2, 3)], revealed: vec![(2, 0, "@.".to_owned())], ..Delta::default() };
        ground.apply(&seen).unwrap();
        assert_eq!(ground.terrain().tiles, ["??@.", "????"]);
        let hash = ground.sum();
        let unseen = Delta { sight: vec![(2, 1), (1, 1)], ..Delta::default() };
        ground.apply(&unseen).unwrap();
        let visible: Vec<bool> = (0..4).map(|x| ground.is_visible(x, 0)).collect();
        assert_eq!((visible, ground.is_visible(0, 1)), (vec![false, false, false, true], false));
        assert_eq!(ground.terrain().tiles, ["??@.", "????"]);
        ground.apply(&unseen).unwrap();
        assert_eq!(ground.sum(), hash);
    }

    #[test]
    fn what_does_not_fit_the_map_is_an_error() {
        let fog = || Some(TileSet::new(4, 2));
        let check = |knowledge, visible, sight: &[(u32, u32)], revealed: &[(u32, u32, &str)]| {
            let revealed = revealed.iter().map(|&(x, y, tiles)| (x, y, tiles.to_owned())).collect();
            let delta = Delta { cycle: Cycle(9), sight: sight.to_vec(), revealed, ..Delta::default() };
            ground(knowledge, visible).apply(&delta)
        };
        let (known, explored) = (TerrainKnowledge::Known, TerrainKnowledge::Explored);
        assert_eq!(check(explored, fog(), &[(0, 8)], &[(0, 0, "...."), (3, 1, "1")]), Ok(()));
        for sight in [&[(0, 9)][..], &[(8, 1)], &[(1, u32::MAX)], &[(4, 4), (u32::MAX, 1)]] {
            assert_eq!(check(explored, fog(), sight, &[]), Err(MismatchError::Sight { cycle: Cycle(9) }));
        }
        assert!(check(known, None, &[(0, 1)], &[]).is_err(), "there is no fog");
        for (x, y, tiles) in [
            (4, 0, "."),
            (0, 2, "."),
            (2, 0, "..."),
            (0, 0, ""),
            (0, 0, "?"),
            (0, 0, "漢"),
            (u32::MAX, 0, ".."),
        ] {
            let expected = Err(MismatchError::Revealed { cycle: Cycle(9), x, y });
            assert_eq!(check(explored, fog(), &[], &[(x, y, tiles)]), expected, "{tiles}");
        }
        assert!(check(explored, fog(), &[], &[(0, 0, ".."), (1, 0, ".")]).is_err(), "known already");
        assert!(check(known, fog(), &[], &[(0, 0, ".")]).is_err(), "known from the start");
    }

    fn ground(knowledge: TerrainKnowledge, visible: Option<TileSet>) -> Ground {
        let terrain = match knowledge {
            TerrainKnowledge::Known => {
                Terrain { tiles: vec!["....".to_owned(); 2], ..Terrain::unknown(4, 2) }
            }
            TerrainKnowledge::Explored => Terrain::unknown(4, 2),
        };
        Ground { terrain: Arc::new(terrain), knowledge, visible, sum: 0 }
    }
}
