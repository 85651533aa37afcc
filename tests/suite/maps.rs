//! Real maps: those that ship, and those in the shared folder beside the checkout.

use std::fs;
use std::path::{Path, PathBuf};

use crate::commands::skipped;

use maniple_tilemap::{Resolver, TileMap, check, loops, place_far_apart, read, regions};

/// The files in a folder of the disk.
struct Folder<'a>(&'a Path);

impl Resolver for Folder<'_> {
    fn resolve(&self, path: &str) -> Result<Vec<u8>, String> {
        fs::read(self.0.join(path)).map_err(|error| error.to_string())
    }
}

#[test]
fn every_shipped_map_loads_without_a_finding_about_its_objects() {
    let files = maps_in(&root().join("maps"));
    assert!(files.len() >= 4, "only {} maps ship", files.len());
    for file in files {
        let map = load(&file);
        assert_eq!(map.foreign_objects(), 0, "{}", file.display());
        assert_eq!(check(&map, None), [], "{}", file.display());
    }
}

#[test]
fn shipped_tiled_maps_send_each_player_to_the_other_side() {
    for name in ["choke.tmx", "diamond.tmx"] {
        let map = load(&root().join("maps").join(name));
        let middle = f64::from(map.width()) / 2.0;
        for player in [0, 1] {
            let spawns: Vec<_> = map.spawns().iter().filter(|spawn| spawn.player == player).collect();
            let zones: Vec<_> = map.zones().iter().filter(|zone| zone.player == Some(player)).collect();
            assert!(!spawns.is_empty() && !zones.is_empty(), "{name}: player {player}");
            for (spawn, zone) in spawns.iter().flat_map(|spawn| zones.iter().map(move |zone| (spawn, zone))) {
                let zone_middle = (zone.area.min.x + zone.area.max.x) / 2.0;
                assert!((spawn.position.x < middle) != (zone_middle < middle), "{name}: player {player}");
            }
        }
        assert_eq!(check(&map, Some(0.5)), [], "{name}");
    }
    assert!(!load(&root().join("maps/diamond.tmx")).free_walls().is_empty());
}

#[test]
fn every_shared_map_loads_and_its_walls_form_closed_loops() {
    let shared = root().join("../shared/maps");
    if !shared.is_dir() {
        skipped(&format!("no maps at {}; real maps were not tested", shared.display()));
        return;
    }
    let files = maps_in(&shared);
    assert!(files.len() >= 25, "only {} maps in {}", files.len(), shared.display());
    for file in files {
        let map = load(&file);
        let border = map.border();
        let regions = regions(&map);
        assert!(loops(&border) >= regions.count(), "{}", file.display());
        let places = place_far_apart(&map, 4, 1).unwrap();
        for place in places {
            let (x, y) = map.tile_at(place);
            assert_eq!(regions.label(x, y), regions.largest(), "{}", file.display());
        }
        assert_eq!(load(&file).hash(), map.hash(), "{}", file.display());
    }
}

pub(crate) fn root() -> PathBuf {
    PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/../../.."))
}

pub(crate) fn load(file: &Path) -> TileMap {
    let bytes = fs::read(file).unwrap();
    let folder = Folder(file.parent().unwrap());
    match read(&file.to_string_lossy(), &bytes, &folder) {
        Ok(map) => map,
        Err(error) => panic!("{}: {error}", file.display()),
    }
}

/// The maps in a folder and the folders in it, sorted by path.
pub(crate) fn maps_in(folder: &Path) -> Vec<PathBuf> {
    let mut maps = Vec::new();
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            maps.extend(maps_in(&path));
        } else if path.extension().is_some_and(|ending| ending == "map" || ending == "tmx") {
            maps.push(path);
        }
    }
    maps.sort();
    maps
}
