//! Mostly open ground with small blocks.

use super::Request;
use super::canvas::{Canvas, Material, Spot, square};
use super::dice::Dice;

/// The share of the map that is to be blocked, in hundredths: from the first to the second, by the seed.
const BLOCKED: (i32, i32) = (10, 15);

/// The most blocks that are rolled for each hundred tiles of the map; most of them lie in the way of others.
const BLOCKS_PER_HUNDRED_TILES: i32 = 24;

/// Rectangles that a block is made of, and how long their sides are.
const RECTANGLES: (i32, i32) = (1, 4);
const SIDE: (i32, i32) = (2, 4);

/// How far the further rectangles of a block lie from its first one.
const SPREAD: i32 = 2;

/// Of so many blocks one is of trees.
const TREES_ONE_IN: i32 = 3;

/// Draws the blocks and returns what ways through them are made of.
pub(super) fn draw(canvas: &mut Canvas, request: &Request, dice: Dice) -> Material {
    let share = dice.between("blocked", 0, BLOCKED);
    scatter(canvas, request, dice, share);
    Material::Ground
}

/// Lays blocks onto open ground until so many hundredths of the map more are blocked, or no more find room.
pub(super) fn scatter(canvas: &mut Canvas, request: &Request, dice: Dice, hundredths: i32) {
    let area = canvas.width() * canvas.height();
    let wanted = canvas.blocked() + area * hundredths / 100;
    for block in 0..area * BLOCKS_PER_HUNDRED_TILES / 100 {
        if canvas.blocked() >= wanted {
            break;
        }
        let number = u64::from(block.cast_unsigned());
        let tiles = tiles(canvas, dice, number);
        if is_room(canvas, &tiles, request.lane().cast_signed()) {
            let is_trees = dice.below("trees", number, TREES_ONE_IN) == 0;
            let material = if is_trees { Material::Trees } else { Material::Rock };
            tiles.into_iter().for_each(|tile| canvas.put(tile, material));
        }
    }
}

/// Returns the tiles of a block: rectangles that overlap.
fn tiles(canvas: &Canvas, dice: Dice, block: u64) -> Vec<Spot> {
    let x = dice.below("block x", block, canvas.width());
    let y = dice.below("block y", block, canvas.height());
    let mut tiles = Vec::new();
    for rectangle in 0..dice.between("rectangles", block, RECTANGLES) {
        let index = block << 8 | u64::from(rectangle.cast_unsigned());
        let reach = if rectangle == 0 { 0 } else { SPREAD };
        let left = x + dice.between("rectangle x", index, (-reach, reach));
        let top = y + dice.between("rectangle y", index, (-reach, reach));
        let size =
            (dice.between("rectangle width", index, SIDE), dice.between("rectangle height", index, SIDE));
        tiles.extend(square((left, top), (left + size.0, top + size.1)));
    }
    tiles
}

/// Whether a block lies on ground that may be blocked, a way's width from all that is blocked already and from its twin.
fn is_room(canvas: &Canvas, tiles: &[Spot], lane: i32) -> bool {
    tiles.iter().all(|&(x, y)| {
        let twin = canvas.twin((x, y));
        let is_beside_twin = canvas.is_symmetric()
            && tiles.iter().any(|&tile| {
                let apart = (tile.0 - twin.0).abs().max((tile.1 - twin.1).abs());
                (1..=lane).contains(&apart)
            });
        !is_beside_twin
            && canvas.is_inside((x, y))
            && !canvas.is_kept((x, y))
            && square((x - lane, y - lane), (x + lane + 1, y + lane + 1)).all(|near| canvas.is_open(near))
    })
}
