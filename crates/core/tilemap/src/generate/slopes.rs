//! Half-blocked tiles, where blocks have corners.

use crate::Corner;

use super::canvas::{Canvas, Spot};
use super::dice::Dice;
use super::kind::Kind;

/// The share of corners that slope where the ground is irregular.
const SHARE_IRREGULAR: f64 = 0.6;

/// Returns, row by row, which corner stays blocked of a blocked tile of which half is opened; `None` for all others.
///
/// Only tiles that stick out are opened: open above and to one side and in the corner between, blocked below and to
/// the other side. So ways get no narrower, and stairs become straight.
pub(super) fn slopes(canvas: &Canvas, dice: Dice, kind: Kind) -> Vec<Option<Corner>> {
    let share = match kind {
        Kind::Plain | Kind::Maze => 0.0,
        Kind::Obstacles => SHARE_IRREGULAR,
        Kind::Islands | Kind::Cliffs | Kind::Choke => 1.0,
    };
    let is_sloped = |spot: Spot| dice.share("slope", canvas.key(spot)) < share;
    canvas.spots().map(|spot| blocked_corner(canvas, spot).filter(|_| is_sloped(spot))).collect()
}

fn blocked_corner(canvas: &Canvas, (x, y): Spot) -> Option<Corner> {
    if canvas.is_open((x, y)) {
        return None;
    }
    let is_open = |right: i32, down: i32| canvas.is_open((x + right, y + down));
    let sides = [
        (Corner::Northwest, 1, 1),
        (Corner::Northeast, -1, 1),
        (Corner::Southwest, 1, -1),
        (Corner::Southeast, -1, -1),
    ];
    let found = sides.into_iter().find(|&(_, right, down)| {
        let is_outside_open = is_open(right, 0) && is_open(0, down) && is_open(right, down);
        is_outside_open && !is_open(-right, 0) && !is_open(0, -down)
    });
    found.map(|(corner, ..)| corner)
}
