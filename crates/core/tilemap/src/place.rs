//! Places to start from, on a map that names none.

use std::collections::VecDeque;

use glam::DVec2;
use twox_hash::XxHash3_64;

use crate::regions::{neighbours, regions};
use crate::{Regions, TileMap};

/// Sets this use of the seed apart from all others.
const PURPOSE: &[u8] = b"place far apart";

/// Returns `count` centres of tiles of the largest region, in world units, far apart by the length of the way over
/// the edges of tiles; `None` where that region has fewer tiles.
///
/// The seed chooses the first tile; each further one is as far as possible from its nearest predecessor, the first
/// such tile row by row (Gonzalez, *Clustering to minimize the maximum intercluster distance*, 1985). The
/// same map, count and seed give the same places.
#[must_use]
pub fn place_far_apart(map: &TileMap, count: usize, seed: u64) -> Option<Vec<DVec2>> {
    if count == 0 {
        return Some(Vec::new());
    }
    let regions = regions(map);
    let largest = regions.largest()?;
    let tiles = tiles_of(map, &regions, largest);
    if tiles.len() < count {
        return None;
    }
    let choice = XxHash3_64::oneshot_with_seed(seed, PURPOSE) % tiles.len() as u64;
    let mut tile = *tiles.get(usize::try_from(choice).unwrap_or(0))?;
    let mut distances = vec![u32::MAX; map.tiles().len()];
    let mut places = Vec::new();
    loop {
        places.push(DVec2::new(f64::from(tile.0) + 0.5, f64::from(tile.1) + 0.5));
        if places.len() == count {
            return Some(places);
        }
        spread(map, &mut distances, tile);
        tile = farthest(map, &distances, &tiles)?;
    }
}

fn tiles_of(map: &TileMap, regions: &Regions, label: u32) -> Vec<(u32, u32)> {
    let rows = (0..map.height()).flat_map(|y| (0..map.width()).map(move |x| (x, y)));
    rows.filter(move |&(x, y)| regions.label(x, y) == Some(label)).collect()
}

fn index(map: &TileMap, (x, y): (u32, u32)) -> usize {
    y as usize * map.width() as usize + x as usize
}

fn farthest(map: &TileMap, distances: &[u32], tiles: &[(u32, u32)]) -> Option<(u32, u32)> {
    let mut best = None;
    for &tile in tiles {
        let distance = distances[index(map, tile)];
        if best.is_none_or(|(_, farthest)| distance > farthest) {
            best = Some((tile, distance));
        }
    }
    best.map(|(tile, _)| tile)
}

/// Lowers the distances to the nearest chosen tile after another one was chosen. Only tiles that are nearer to it
/// than to its predecessors are visited, so that many places cost little more than a few.
fn spread(map: &TileMap, distances: &mut [u32], from: (u32, u32)) {
    let mut waiting = VecDeque::from([from]);
    distances[index(map, from)] = 0;
    while let Some(tile) = waiting.pop_front() {
        let distance = distances[index(map, tile)] + 1;
        for next in neighbours(tile.0, tile.1) {
            if map.is_passable(next.0, next.1) && distances[index(map, next)] > distance {
                distances[index(map, next)] = distance;
                waiting.push_back(next);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::octile;

    const CORRIDOR: &[u8] = b"type octile\nheight 2\nwidth 9\nmap\n.........\n.@@@@@@@.\n";

    #[test]
    fn two_places_are_at_the_ends_of_what_the_first_allows() {
        let map = octile::read(CORRIDOR).unwrap();
        for seed in 0..50 {
            let places = place_far_apart(&map, 2, seed).unwrap();
            let ends = [DVec2::new(0.5, 1.5), DVec2::new(8.5, 1.5)];
            assert!(ends.contains(&places[1]), "seed {seed}: {places:?}");
        }
    }

    #[test]
    fn places_repeat_with_the_seed_and_differ_between_seeds() {
        let map = octile::read(CORRIDOR).unwrap();
        let first = |seed| place_far_apart(&map, 1, seed).unwrap()[0];
        assert_eq!(first(7), first(7));
        assert!((0..20).any(|seed| first(seed) != first(7)));
    }

    #[test]
    fn as_many_places_as_tiles_are_all_of_them_and_more_are_none() {
        let map = octile::read(CORRIDOR).unwrap();
        let mut places = place_far_apart(&map, 11, 3).unwrap();
        places.sort_by(|a, b| (a.y, a.x).partial_cmp(&(b.y, b.x)).unwrap());
        places.dedup();
        assert_eq!(places.len(), 11);
        assert_eq!(place_far_apart(&map, 12, 3), None);
        assert_eq!(place_far_apart(&map, 0, 3), Some(Vec::new()));
    }

    #[test]
    fn only_the_largest_region_is_used() {
        let map = octile::read(b"type octile\nheight 1\nwidth 6\nmap\n..@...\n").unwrap();
        for seed in 0..20 {
            assert!(place_far_apart(&map, 3, seed).unwrap().iter().all(|place| place.x > 3.0));
        }
    }
}
