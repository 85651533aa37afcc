//! Where players start.

use super::canvas::Spot;
use super::dice::Dice;
use super::kind::Kind;
use super::{ATTEMPTS_MAX, Request};

/// How many places are rolled for a spawn before there is no room for it.
const ROLLS_MAX: i32 = 96;

/// Among how many fitting places the one far from all others is taken. Few for the first spawn of a player, or it
/// would always lie in a corner.
const CHOICE_FIRST: usize = 3;
const CHOICE_FURTHER: usize = 12;

/// Open tiles between the square around a spawn and the edge of the map.
const EDGE_DISTANCE: i32 = 2;

/// Returns player and place of each spawn, the place being the corner that four tiles share; `None` where they found no
/// room. The first spawn of each player comes before the second of any.
pub(super) fn place(request: &Request, dice: Dice) -> Option<Vec<(u32, Spot)>> {
    let mut placing = Placing { request, dice, spawns: Vec::new() };
    if request.players == 0 {
        return Some(placing.spawns);
    }
    let step = if request.is_symmetric() { 2 } else { 1 };
    for number in 0..request.spawns {
        for player in (0..request.players).step_by(step) {
            let spot = placing.best(player, number)?;
            placing.spawns.push((player, spot));
            if request.is_symmetric() {
                placing.spawns.push((player + 1, twin(request, spot)));
            }
        }
    }
    Some(placing.spawns)
}

/// Returns where a corner of tiles goes by half a turn of the map.
fn twin(request: &Request, (x, y): Spot) -> Spot {
    (request.width.cast_signed() - x, request.height.cast_signed() - y)
}

/// Returns the square of the distance between two places.
pub(super) fn square_distance(a: Spot, b: Spot) -> i32 {
    (a.0 - b.0) * (a.0 - b.0) + (a.1 - b.1) * (a.1 - b.1)
}

struct Placing<'a> {
    request: &'a Request,
    dice: Dice,
    spawns: Vec<(u32, Spot)>,
}

impl Placing<'_> {
    /// Returns, of some places that fit, the one farthest from all other spawns and its own twin.
    fn best(&self, player: u32, number: u32) -> Option<Spot> {
        let wanted = if number == 0 { CHOICE_FIRST } else { CHOICE_FURTHER };
        let rolled = (0..ROLLS_MAX).map(|roll| self.roll(player, number, roll));
        let fitting = rolled.filter(|&spot| self.is_fitting(player, spot)).take(wanted);
        let mut best = None;
        for spot in fitting {
            let distance = self.others(spot).map(|other| square_distance(spot, other)).min();
            let distance = distance.unwrap_or(i32::MAX);
            if best.is_none_or(|(_, farthest)| distance > farthest) {
                best = Some((spot, distance));
            }
        }
        best.map(|(spot, _)| spot)
    }

    fn roll(&self, player: u32, number: u32, roll: i32) -> Spot {
        let index = u64::from(player) << 40 | u64::from(number) << 32 | u64::from(roll.cast_unsigned());
        let (least, most) = self.bounds(number);
        let x = self.dice.between("spawn x", index, (least.0, most.0));
        (x, self.dice.between("spawn y", index, (least.1, most.1)))
    }

    /// Returns the least and largest place. Of two players the first one gets the left or upper quarter of the map for
    /// its first spawn, on a plain for all of them if they find room, and the half otherwise.
    fn bounds(&self, number: u32) -> (Spot, Spot) {
        let request = self.request;
        let side = request.clearing().cast_signed();
        let edge = side / 2 + EDGE_DISTANCE;
        let (width, height) = (request.width.cast_signed(), request.height.cast_signed());
        let mut most = (width - edge, height - edge);
        if request.players == 2 {
            let is_quarter =
                number == 0 || request.kind == Kind::Plain && self.dice.attempt() < ATTEMPTS_MAX / 2;
            let most_of = |size: i32| if is_quarter { size / 4 } else { size / 2 - side / 2 - 1 }.max(edge);
            if width >= height {
                most.0 = most_of(width).min(most.0);
            } else {
                most.1 = most_of(height).min(most.1);
            }
        }
        ((edge, edge), most)
    }

    fn others(&self, spot: Spot) -> impl Iterator<Item = Spot> {
        let own = self.request.is_symmetric().then(|| twin(self.request, spot));
        self.spawns.iter().map(|&(_, other)| other).chain(own)
    }

    /// Whether a place is on the map, its square keeps a way's width from all others, and the player's first spawn is the
    /// nearest of all first ones.
    fn is_fitting(&self, player: u32, spot: Spot) -> bool {
        let request = self.request;
        let apart = (request.clearing() + request.lane()).cast_signed();
        let edge = request.clearing().cast_signed() / 2 + 1;
        let is_inside = |place: i32, size: u32| (edge..=size.cast_signed() - edge).contains(&place);
        let is_apart = |other: Spot| (spot.0 - other.0).abs().max((spot.1 - other.1).abs()) >= apart;
        let firsts = self.spawns.iter().take(request.players as usize);
        let nearest = firsts.min_by_key(|&&(other, first)| (square_distance(spot, first), other));
        let is_own = self.spawns.len() < request.players as usize
            || nearest.is_some_and(|&(owner, _)| owner == player);
        is_inside(spot.0, request.width)
            && is_inside(spot.1, request.height)
            && is_own
            && self.others(spot).all(is_apart)
    }
}
