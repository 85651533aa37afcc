//! Long ridges with ramps.

use super::Request;
use super::canvas::{Canvas, Material, Spot, square};
use super::dice::Dice;

/// How thick a ridge is, in tiles; with less a slope would have no tile behind it.
const THICKNESS: i32 = 2;

/// How long a ridge is, in tiles of its way, as a share of the longer side of the map in tenths.
const LENGTH_TENTHS: (i32, i32) = (5, 10);

/// How far a ridge goes straight on, in tiles.
const STRAIGHT: (i32, i32) = (5, 11);

/// How far it is from one ramp to the next, in tiles.
const RAMPS_APART: (i32, i32) = (13, 19);

/// How much wider a ramp is than the largest unit needs, in tiles.
const RAMP_EXTRA: i32 = 2;

/// Least distance between ridges, in tiles beside the width of a way.
const APART: i32 = 3;

/// How many tiles of the map there are for each ridge that is begun; most of them find no room.
const TILES_A_RIDGE: i32 = 24;

/// Ridges shorter than this, in tiles, are not built.
const LENGTH_MIN: usize = 7;

/// The eight directions, clockwise.
const DIRECTIONS: [Spot; 8] = [(1, 0), (1, 1), (0, 1), (-1, 1), (-1, 0), (-1, -1), (0, -1), (1, -1)];

/// Draws the ridges and returns what ways through them are made of.
pub(super) fn draw(canvas: &mut Canvas, request: &Request, dice: Dice) -> Material {
    for ridge in 0..canvas.width() * canvas.height() / TILES_A_RIDGE {
        let ridge = u64::from(ridge.cast_unsigned());
        let way = way(canvas, request, dice, ridge);
        if way.len() >= LENGTH_MIN {
            build(canvas, request, (dice, ridge), &way);
        }
    }
    Material::Ramp
}

/// Returns the way of a ridge, up to where it would come too near to something.
fn way(canvas: &Canvas, request: &Request, dice: Dice, ridge: u64) -> Vec<Spot> {
    let longer = canvas.width().max(canvas.height());
    let length = longer * dice.between("length", ridge, LENGTH_TENTHS) / 10;
    let mut spot =
        (dice.below("ridge x", ridge, canvas.width()), dice.below("ridge y", ridge, canvas.height()));
    let mut direction = dice.below("heading", ridge, 8);
    let mut way = Vec::new();
    let mut bend: i32 = 0;
    // A ridge bends to one side and back, so that it does not close a ring.
    let side = if dice.below("side", ridge, 2) == 0 { 1 } else { -1 };
    let mut straight = dice.between("straight", ridge << 8, STRAIGHT);
    for step in 0..length {
        if !is_room(canvas, request, spot) || is_beside_own_twin(canvas, request, &way, spot) {
            break;
        }
        way.push(spot);
        if straight == 0 {
            bend += 1;
            let turn = if bend % 2 == 1 { side } else { -side };
            let turn = if dice.below("turn", ridge << 8 | u64::from(step.cast_unsigned()), 4) == 0 {
                0
            } else {
                turn
            };
            direction = (direction + turn).rem_euclid(8);
            straight = dice.between("straight", ridge << 8 | u64::from(bend.cast_unsigned()), STRAIGHT);
        }
        straight -= 1;
        let (right, down) = DIRECTIONS[direction.cast_unsigned() as usize];
        spot = (spot.0 + right, spot.1 + down);
    }
    way
}

/// Whether a piece of a ridge keeps away from other ridges and from what has to stay open.
fn is_room(canvas: &Canvas, request: &Request, (x, y): Spot) -> bool {
    let apart = request.lane().cast_signed() + APART;
    let near = square((x - apart, y - apart), (x + THICKNESS + apart, y + THICKNESS + apart));
    let own = square((x, y), (x + THICKNESS, y + THICKNESS));
    let mut inside = near.filter(|&spot| canvas.is_inside(spot));
    own.into_iter().all(|spot| !canvas.is_kept(spot))
        && canvas.is_inside((x, y))
        && inside.all(|spot| canvas.is_open(spot))
}

/// Whether a piece of a ridge comes near to what half a turn makes of the pieces before it, or of itself.
fn is_beside_own_twin(canvas: &Canvas, request: &Request, way: &[Spot], spot: Spot) -> bool {
    let apart = request.lane().cast_signed() + APART + THICKNESS;
    let is_near = |twin: Spot| (twin.0 - spot.0).abs().max((twin.1 - spot.1).abs()) <= apart;
    canvas.is_symmetric() && way.iter().chain([&spot]).any(|&piece| is_near(canvas.twin(piece)))
}

/// Builds a ridge with ramps: pieces of the way without rock.
fn build(canvas: &mut Canvas, request: &Request, (dice, ridge): (Dice, u64), way: &[Spot]) {
    let ramp = request.lane().cast_signed() + RAMP_EXTRA + THICKNESS - 1;
    let mut until_ramp = dice.between("first ramp", ridge, RAMPS_APART) / 2 + 2;
    let mut ramps = Vec::new();
    for (place, &(x, y)) in (0_i32..).zip(way) {
        if until_ramp <= 0 {
            ramps.push((x, y));
        } else {
            for spot in square((x, y), (x + THICKNESS, y + THICKNESS)) {
                canvas.put(spot, Material::Rock);
            }
        }
        until_ramp -= 1;
        if until_ramp <= -ramp {
            let index = ridge << 8 | u64::from(place.cast_unsigned());
            until_ramp = dice.between("ramps", index, RAMPS_APART);
        }
    }
    for (x, y) in ramps {
        for spot in square((x, y), (x + THICKNESS, y + THICKNESS)) {
            if canvas.is_open(spot) && !canvas.is_kept(spot) {
                canvas.put(spot, Material::Ramp);
            }
        }
    }
}
