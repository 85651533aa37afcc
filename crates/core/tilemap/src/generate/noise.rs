//! Noise: a number per tile that changes slowly from tile to tile.

use super::canvas::{Canvas, Spot};
use super::dice::Dice;

/// Returns a number from 0 to 1 that changes over about `pitch` tiles, the same for a tile and its twin.
///
/// Value noise: chance at the nodes of a lattice, `t t (3 - 2 t)` between them. On a symmetric map it is the mean of
/// a tile and its twin, so that there is no seam where the two halves meet.
pub(super) fn noise(canvas: &Canvas, dice: Dice, purpose: &str, (spot, pitch): (Spot, i32)) -> f64 {
    let here = at(dice, purpose, spot, pitch);
    if canvas.is_symmetric() { (here + at(dice, purpose, canvas.twin(spot), pitch)) / 2.0 } else { here }
}

/// Returns the noise on a line at a place, from 0 to 1.
pub(super) fn line_noise(dice: Dice, purpose: &str, place: i32, pitch: i32) -> f64 {
    at(dice, purpose, (place, 0), pitch)
}

fn at(dice: Dice, purpose: &str, (x, y): Spot, pitch: i32) -> f64 {
    let node = (x.div_euclid(pitch), y.div_euclid(pitch));
    let weight = |place: i32| {
        let between = f64::from(place.rem_euclid(pitch)) / f64::from(pitch);
        between * between * (3.0 - 2.0 * between)
    };
    let chance = |right: i32, down: i32| {
        let (column, row) = (node.0 + right, node.1 + down);
        dice.share(purpose, u64::from(column.cast_unsigned()) << 32 | u64::from(row.cast_unsigned()))
    };
    let mix = |from: f64, to: f64, weight: f64| from + (to - from) * weight;
    let above = mix(chance(0, 0), chance(1, 0), weight(x));
    let below = mix(chance(0, 1), chance(1, 1), weight(x));
    mix(above, below, weight(y))
}
