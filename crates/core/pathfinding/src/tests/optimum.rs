//! Lengths beside the shortest there are.

use glam::DVec2;
use maniple_tilemap::{Kind, TileMap};

use super::real::{load, middle, shared_maps};
use super::tangents::Tangents;
use super::{Dice, drawn, generated, scattered};
use crate::{Ground, MARGIN, Planner, length};

/// Queries for each generated or scattered map.
const QUERIES: usize = 12;

/// Queries for each real map in the long run.
const QUERIES_REAL: usize = 300;

/// The goal for the mean length over the shortest.
const MEAN_MAX: f64 = 1.013;

/// The goal for the worst.
const WORST_MAX: f64 = 1.07;

/// Lengths over the shortest for queries of the map, each a start and a goal.
fn compare(
    map: &TileMap,
    radius: f64,
    mut queries: impl FnMut(&Ground) -> Option<(DVec2, DVec2)>,
) -> Vec<f64> {
    let ground = Ground::new(map, radius).unwrap();
    let mut planner = Planner::new(&ground);
    let mut tangents = Tangents::new(map, radius, MARGIN);
    let mut ratios = Vec::new();
    while let Some((from, to)) = queries(&ground) {
        let Ok(legs) = planner.path(from, to) else { continue };
        let length = length(from, legs);
        let shortest = tangents.shortest(from, to, length).unwrap();
        assert!(length / shortest > 1.0 - 1e-9, "{from} {to} {radius}: {length} {shortest}");
        // Of what is next to each other a ratio says nothing.
        if shortest > 2.0 {
            ratios.push(length / shortest);
        }
    }
    ratios
}

fn compare_random(map: &TileMap, radius: f64, dice: &mut Dice) -> Vec<f64> {
    let mut left = QUERIES;
    compare(map, radius, |ground| {
        left = left.checked_sub(1)?;
        Some((dice.place(map, ground), dice.place(map, ground)))
    })
}

/// Says and checks mean and worst.
fn check(name: &str, mut ratios: Vec<f64>) {
    let mean = ratios.iter().sum::<f64>() / ratios.len() as f64;
    ratios.sort_by(f64::total_cmp);
    let worst = ratios[ratios.len() - 1];
    println!("{name}: {} paths, mean {mean:.4}, worst {worst:.4}", ratios.len());
    assert!(mean < MEAN_MAX, "{name}: mean {mean}");
    assert!(worst < WORST_MAX, "{name}: worst {worst}");
}

#[expect(clippy::disallowed_methods, reason = "a test may look at its environment")]
fn is_long() -> bool {
    std::env::var_os("MANIPLE_LONG").is_some()
}

/// The long run has more and larger maps.
#[test]
fn paths_are_hardly_longer_than_the_shortest() {
    let mut dice = Dice(31);
    let (rounds, sides) = if is_long() { (6, [20, 64]) } else { (1, [20, 20]) };
    for radius in [0.2, 0.35, 0.45, 0.8, 1.4] {
        let mut ratios = Vec::new();
        for round in 0..rounds {
            for kind in Kind::ALL {
                let map = generated(kind, sides[round % 2], radius, dice.roll());
                ratios.extend(compare_random(&map, radius, &mut dice));
            }
            if radius < 1.0 {
                for _ in 0..6 {
                    ratios.extend(compare_random(&scattered(&mut dice, 14, 0.15), radius, &mut dice));
                }
            }
        }
        check(&format!("radius {radius}"), ratios);
    }
}

/// A sample of the queries that are published with real maps; in the long run alone, since the yardstick looks at all corners.
#[test]
fn paths_on_real_maps_are_hardly_longer_than_the_optimum() {
    let Some(folder) = is_long().then(|| shared_maps("lengths on real maps")).flatten() else { return };
    for name in ["den520d", "brc202d"] {
        let (map, queries) = load(&folder.join(format!("dao/{name}.map.scen")));
        let stride = queries.len().div_ceil(QUERIES_REAL);
        let mut queries = queries.iter().step_by(stride);
        let ratios =
            compare(&map, 0.35, |_| queries.next().map(|query| (middle(query.start), middle(query.goal))));
        check(name, ratios);
    }
}

/// Around a block that hangs into the way: to its first corner, a turn, along its lower side, and the same again.
#[test]
#[expect(clippy::disallowed_methods, reason = "a yardstick for lengths, with room for the last bits")]
fn the_yardstick_knows_the_way_around_a_block() {
    let mut rows = vec!["....@@...."; 5];
    rows.extend(["..........", "..........", ".........."]);
    let map = drawn(&rows);
    for reach in [0.25, 0.5, 0.9] {
        let mut tangents = Tangents::new(&map, reach, 1e-3);
        let reach = reach + 1e-3;
        let straight = (13.0 - reach * reach).sqrt();
        let angle = 2.0_f64.atan2(3.0) + (reach / 13.0_f64.sqrt()).asin();
        let expected = 2.0 * (straight + reach * angle) + 2.0;
        let (from, to) = (DVec2::new(1.0, 3.0), DVec2::new(9.0, 3.0));
        let found = tangents.shortest(from, to, 20.0).unwrap();
        assert!((found - expected).abs() < 1e-6, "{reach}: {found} instead of {expected}");
        assert_eq!(tangents.shortest(from, to, expected - 1e-3), None, "{reach}");
    }
}
