//! Land in the water.

use super::canvas::{Canvas, Material, Spot};
use super::dice::Dice;
use super::noise::noise;
use super::spawns::square_distance;
use super::{Layout, Request};

/// How many tiles of the map there are for each island, about.
const TILES_AN_ISLAND: i32 = 230;

/// How many places are rolled for each island that nobody starts on.
const ROLLS_AN_ISLAND: i32 = 24;

/// Least distance between the middles of islands, in tiles.
const APART: i32 = 12;

/// The radius of an island, in tiles, and of one with a spawn beside half of its clearing.
const RADIUS: (i32, i32) = (6, 10);
const RADIUS_BESIDE_CLEARING: i32 = 3;

/// How wide the water between two islands is, in tiles, about.
const CHANNEL: f64 = 5.0;

/// How far the shore wanders, in tiles, and over how many tiles.
const WOBBLE: f64 = 7.0;
const PITCH: i32 = 5;

/// The share of the fords that are there although there is another way.
const LOOPS: f64 = 0.45;

/// Fords between islands whose middles are farther apart, in tiles, are only made where there is no other way.
const FORD_MAX: i32 = 30;

/// An island: its middle and its radius in tiles.
type Island = (Spot, f64);

/// Draws the water and returns what ways through it are made of.
pub(super) fn draw(canvas: &mut Canvas, request: &Request, dice: Dice, layout: &Layout) -> Material {
    let islands = islands(canvas, request, dice, layout);
    for spot in canvas.spots() {
        if !is_land(canvas, dice, &islands, spot) {
            canvas.put(spot, Material::Water);
        }
    }
    let size = request.lane().cast_signed() + 1;
    for (from, to) in fords(canvas, dice, &islands) {
        canvas.open_way(from, to, (size, Material::Ford));
    }
    Material::Ford
}

/// Returns the islands: one of each spawn and of each cluster apart, and others where there is room.
fn islands(canvas: &Canvas, request: &Request, dice: Dice, layout: &Layout) -> Vec<Island> {
    let mut islands: Vec<Island> = Vec::new();
    let home = request.clearing().cast_signed() / 2 + RADIUS_BESIDE_CLEARING;
    for &(_, spot) in &layout.spawns {
        islands.push((spot, f64::from(home)));
    }
    let is_apart = |islands: &[Island], spot: Spot| {
        islands.iter().all(|&(other, _)| square_distance(other, spot) >= APART * APART)
    };
    for &spot in &layout.neutral {
        if is_apart(&islands, spot) {
            islands.push((spot, f64::from(RADIUS.1)));
        }
    }
    let wanted = canvas.width() * canvas.height() / TILES_AN_ISLAND;
    for roll in 0..wanted * ROLLS_AN_ISLAND {
        let index = u64::from(roll.cast_unsigned());
        let spot =
            (dice.below("island x", index, canvas.width()), dice.below("island y", index, canvas.height()));
        let twin = canvas.twin(spot);
        let is_twin_apart = twin == spot || square_distance(spot, twin) >= APART * APART;
        if is_twin_apart && is_apart(&islands, spot) {
            let radius = f64::from(dice.between("island radius", index, RADIUS));
            islands.push((spot, radius));
            if twin != spot {
                islands.push((twin, radius));
            }
        }
    }
    islands
}

/// Whether a tile is within an island, and not in the channel to the next one.
fn is_land(canvas: &Canvas, dice: Dice, islands: &[Island], spot: Spot) -> bool {
    let wobble = (noise(canvas, dice, "shore", (spot, PITCH)) - 0.5) * WOBBLE;
    let (mut nearest, mut second) = (f64::INFINITY, f64::INFINITY);
    for &(middle, radius) in islands {
        let beyond = f64::from(square_distance(middle, spot)).sqrt() - radius;
        if beyond < nearest {
            second = nearest;
            nearest = beyond;
        } else if beyond < second {
            second = beyond;
        }
    }
    let (x, y) = spot;
    let edge = x.min(y).min(canvas.width() - 1 - x).min(canvas.height() - 1 - y);
    nearest + wobble < 0.0 && second - nearest > CHANNEL + wobble && f64::from(edge) > 0.5 + wobble / 3.0
}

/// Returns the fords: the shortest that join all islands (Kruskal, 1956), and some of those with no island between.
fn fords(canvas: &Canvas, dice: Dice, islands: &[Island]) -> Vec<(Spot, Spot)> {
    let mut pairs: Vec<(i32, u64, usize, usize)> = Vec::new();
    for (to, &(end, _)) in islands.iter().enumerate() {
        for (from, &(start, _)) in islands[..to].iter().enumerate() {
            let key =
                pair_key(canvas, start, end).min(pair_key(canvas, canvas.twin(start), canvas.twin(end)));
            pairs.push((square_distance(start, end), key, from, to));
        }
    }
    pairs.sort_unstable();
    let mut parts: Vec<usize> = (0..islands.len()).collect();
    let mut fords = Vec::new();
    for (square, key, from, to) in pairs {
        let (start, end) = (islands[from].0, islands[to].0);
        let is_joining = parts[from] != parts[to];
        let is_wanted = || dice.share("ford", key) < LOOPS && is_free_between(islands, start, end);
        if is_joining || square <= FORD_MAX * FORD_MAX && is_wanted() {
            let (old, new) = (parts[from], parts[to]);
            parts.iter_mut().filter(|part| **part == old).for_each(|part| *part = new);
            fords.push((start, end));
        }
    }
    fords
}

/// Returns a number for a pair of places, the same in both orders.
fn pair_key(canvas: &Canvas, a: Spot, b: Spot) -> u64 {
    let index = |spot: Spot| u64::from((spot.1 * canvas.width() + spot.0).cast_unsigned());
    let (first, second) = (index(a).min(index(b)), index(a).max(index(b)));
    first << 32 | second
}

/// Whether no other island lies in the circle around two of them (Gabriel and Sokal, 1969).
fn is_free_between(islands: &[Island], start: Spot, end: Spot) -> bool {
    let across = square_distance(start, end);
    islands.iter().all(|&(other, _)| {
        other == start
            || other == end
            || square_distance(start, other) + square_distance(other, end) >= across
    })
}
