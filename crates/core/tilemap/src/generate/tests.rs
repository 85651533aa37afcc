//! What holds for every generated map, and what is refused. That all can be reached is tested apart, in the suite.

use glam::DVec2;

use super::*;
use crate::{Corner, Tile, check, regions};

const DUEL: Request = Request {
    kind: Kind::Plain,
    width: 64,
    height: 64,
    players: 2,
    spawns: 1,
    clusters: 4,
    patches: 6,
    amount: 1_000,
    radius: 0.5,
};

/// Sizes and numbers that maps are asked for with, odd ones too.
fn requests() -> impl Iterator<Item = Request> {
    let shapes = [
        DUEL,
        Request { clusters: 5, ..DUEL },
        Request { spawns: 5, clusters: 0, ..DUEL },
        Request { height: 48, ..DUEL },
        Request { width: 32, height: 32, players: 1, ..DUEL },
        Request { width: 47, height: 61, clusters: 3, patches: 7, radius: 0.375, ..DUEL },
        Request { width: 96, height: 41, players: 0, clusters: 3, patches: 5, ..DUEL },
        Request { width: 96, height: 96, players: 4, clusters: 8, radius: 1.2, ..DUEL },
        Request { width: 80, height: 80, players: 3, spawns: 2, clusters: 3, ..DUEL },
    ];
    shapes.into_iter().flat_map(|shape| Kind::ALL.map(|kind| Request { kind, ..shape }))
}

fn each_map(check: impl Fn(&Request, &TileMap, &str)) {
    for request in requests() {
        for seed in 0..8 {
            let what = format!("seed {seed}, {request:?}");
            match generate(&request, seed) {
                Ok(map) => check(&request, &map, &what),
                Err(error) => panic!("{what}: {error}"),
            }
        }
    }
}

#[test]
fn a_map_holds_what_was_asked_for() {
    each_map(|request, map, what| {
        assert_eq!((map.width(), map.height()), (request.width, request.height), "{what}");
        for player in 0..request.players {
            let spawns = map.spawns().iter().filter(|spawn| spawn.player == player).count();
            assert_eq!(spawns, request.spawns as usize, "{what}");
        }
        assert_eq!(map.spawns().len(), (request.players * request.spawns) as usize, "{what}");
        assert_eq!(map.resources().len(), (request.clusters * request.patches) as usize, "{what}");
        assert!(map.resources().iter().all(|patch| patch.amount == request.amount), "{what}");
        let blocked = map.tiles().iter().filter(|tile| tile.shape != TileShape::Open).count();
        assert_eq!(blocked == 0, request.kind == Kind::Plain, "{what}: {blocked} blocked");
    });
}

#[test]
fn a_map_for_two_is_the_same_after_half_a_turn() {
    each_map(|request, map, what| {
        if request.players % 2 == 1 {
            return;
        }
        let (width, height) = (map.width(), map.height());
        for (x, y) in (0..height).flat_map(|y| (0..width).map(move |x| (x, y))) {
            let twin = map.tile(width - 1 - x, height - 1 - y);
            let expected = Tile { shape: half_turned(twin.shape), ..twin };
            assert_eq!(map.tile(x, y), expected, "{what}: tile ({x}, {y})");
        }
        let turned = |place: DVec2| DVec2::new(f64::from(width), f64::from(height)) - place;
        for spawn in map.spawns() {
            let twin = Spawn { player: spawn.player ^ 1, position: turned(spawn.position) };
            assert!(map.spawns().contains(&twin), "{what}: {spawn:?}");
        }
        for patch in map.resources() {
            let twin = Resource { position: turned(patch.position), ..*patch };
            assert!(map.resources().contains(&twin), "{what}: {patch:?}");
        }
    });
}

#[test]
fn of_two_players_the_first_starts_in_the_left_or_upper_half_and_far_from_the_other() {
    each_map(|request, map, what| {
        let is_wide = map.width() >= map.height();
        let along = |place: DVec2| if is_wide { place.x } else { place.y };
        let half = f64::from(map.width().max(map.height())) / 2.0;
        for spawn in map.spawns().iter().filter(|_| request.players == 2) {
            assert_eq!(along(spawn.position) < half, spawn.player == 0, "{what}: {spawn:?}");
        }
        for (number, spawn) in map.spawns().iter().enumerate() {
            for other in &map.spawns()[..number] {
                let offset = (spawn.position - other.position).abs();
                let apart = if offset.x > offset.y { offset.x } else { offset.y };
                assert!(
                    apart >= f64::from(request.clearing() + request.lane()),
                    "{what}: {spawn:?} {other:?}"
                );
            }
        }
    });
}

#[test]
fn the_ground_around_spawns_is_open() {
    each_map(|request, map, what| {
        let half = f64::from(request.clearing()) / 2.0;
        for spawn in map.spawns() {
            let corner = map.tile_at(spawn.position - half);
            for (x, y) in (0..request.clearing()).flat_map(|y| (0..request.clearing()).map(move |x| (x, y))) {
                assert!(map.is_passable(corner.0 + x, corner.1 + y), "{what}: {spawn:?} + ({x}, {y})");
            }
        }
    });
    assert_eq!(DUEL.clearing(), 12);
    assert_eq!(Request { width: 32, height: 32, players: 1, ..DUEL }.clearing(), 12);
    assert_eq!(Request { spawns: 5, ..DUEL }.clearing(), 10);
    assert_eq!(Request { width: 24, height: 24, spawns: 3, ..DUEL }.clearing(), 6);
}

#[test]
fn patches_are_a_tile_from_each_other_and_from_walls() {
    const PATCH_RADIUS: f64 = 0.375;
    each_map(|_, map, what| {
        let walls = map.segments();
        for (number, patch) in map.resources().iter().enumerate() {
            for other in &map.resources()[..number] {
                let gap = (patch.position - other.position).length() - 2.0 * PATCH_RADIUS;
                assert!(gap >= 1.0, "{what}: {patch:?} {other:?}");
            }
            for wall in &walls {
                let nearest = crate::gaps::nearest(wall, patch.position);
                assert!((nearest - patch.position).length() - PATCH_RADIUS >= 1.0, "{what}: {patch:?}");
            }
        }
    });
}

#[test]
fn each_player_has_patches_beside_a_spawn() {
    each_map(|request, map, what| {
        for player in (0..request.players).filter(|_| request.clusters >= request.players) {
            let most = map.spawns().iter().filter(|spawn| spawn.player == player).map(|spawn| {
                let offsets = map.resources().iter().map(|patch| patch.position - spawn.position);
                offsets.filter(|offset| (4.0..=7.0).contains(&offset.length())).count()
            });
            assert!(most.max() >= Some(request.patches as usize), "{what}: player {player}");
        }
    });
}

#[test]
fn a_map_has_one_region_and_nothing_odd() {
    each_map(|request, map, what| {
        assert_eq!(regions(map).count(), 1, "{what}");
        if request.radius <= 0.5 {
            assert_eq!(check(map, Some(request.radius)), [], "{what}");
        }
    });
}

#[test]
fn a_seed_gives_the_same_map_again_and_another_seed_another_one() {
    for request in requests() {
        let hash = |seed| generate(&request, seed).unwrap().hash();
        let mut hashes: Vec<u64> = (100..106).map(hash).collect();
        assert_eq!(hashes, (100..106).map(hash).collect::<Vec<_>>(), "{request:?}");
        hashes.sort_unstable();
        hashes.dedup();
        assert_eq!(hashes.len(), 6, "{request:?}");
    }
}

#[test]
fn what_is_out_of_range_is_named_with_the_range() {
    let check = |request: Request, expected: &str| {
        let error = generate(&request, 1).unwrap_err().to_string();
        assert!(error.contains(expected), "{error}: no {expected:?}");
    };
    check(Request { width: 15, ..DUEL }, "width is 15; it must be a whole number from 16 to 512");
    check(Request { height: 513, ..DUEL }, "height is 513;");
    check(Request { players: 9, ..DUEL }, "players is 9; it must be a whole number from 0 to 8");
    check(Request { spawns: 0, ..DUEL }, "spawns is 0;");
    check(Request { clusters: 65, ..DUEL }, "clusters is 65;");
    check(Request { patches: 13, ..DUEL }, "patches is 13;");
    check(Request { amount: 1 << 31, ..DUEL }, "amount is 2147483648;");
    for radius in [0.0, -1.0, 4.5, f64::NAN, f64::INFINITY] {
        check(
            Request { radius, ..DUEL },
            &format!("radius is {radius}; it must be above 0 and at most 4 tiles"),
        );
    }
    check(
        Request { width: 16, height: 16, spawns: 8, ..DUEL },
        "16 x 16 tiles have no room for 2 x 8 spawns with 6 x 6 open tiles around each",
    );
    check(
        Request { width: 24, height: 24, clusters: 30, ..DUEL },
        "24 x 24 tiles have no room for 30 clusters of 6 patches beside the spawns; make the map larger, or ask for fewer",
    );
    assert_eq!("cliffs".parse(), Ok(Kind::Cliffs));
    let error = "hills".parse::<Kind>().unwrap_err().to_string();
    assert_eq!(
        error,
        "\"hills\" is no kind of map; the kinds are plain, obstacles, maze, islands, cliffs, choke"
    );
    assert_eq!(Kind::ALL.map(Kind::name), Kind::NAMES);
}

#[test]
fn the_least_and_the_largest_numbers_give_a_map_or_a_reason() {
    for kind in Kind::ALL {
        let tiny = Request { kind, width: 16, height: 16, players: 1, clusters: 0, ..DUEL };
        assert_eq!(generate(&tiny, 3).map(|map| map.spawns().len()), Ok(1), "{kind}");
        let wide = Request { kind, width: 512, height: 16, clusters: 0, ..DUEL };
        assert_eq!(generate(&wide, 3).map(|map| map.spawns().len()), Ok(2), "{kind}");
        let slow = Request { kind, radius: 4.0, players: 8, width: 160, height: 160, ..DUEL };
        assert_eq!(generate(&slow, 3).map(|map| map.spawns().len()), Ok(8), "{kind}");
    }
}

fn half_turned(shape: TileShape) -> TileShape {
    match shape {
        TileShape::Open => TileShape::Open,
        TileShape::Blocked => TileShape::Blocked,
        TileShape::Diagonal(Corner::Northwest) => TileShape::Diagonal(Corner::Southeast),
        TileShape::Diagonal(Corner::Northeast) => TileShape::Diagonal(Corner::Southwest),
        TileShape::Diagonal(Corner::Southwest) => TileShape::Diagonal(Corner::Northeast),
        TileShape::Diagonal(Corner::Southeast) => TileShape::Diagonal(Corner::Northwest),
    }
}
