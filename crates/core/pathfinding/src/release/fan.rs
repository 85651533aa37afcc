//! How lanes fan out before and behind a narrow place, so that circles that come from aside turn little by little.

use glam::DVec2;
use maniple_geometry::Scalar;

use crate::ground::Ground;

/// The cosine and the sine of the angle by which a circle turns at once at most: 22.6 degrees. Who follows another around a turn by an
/// angle `t` has to be `reach / cos(t / 2)` behind it: 1.02 reaches instead of the 1.41 of a right angle.
const TURN: (f64, f64) = (12.0 / 13.0, 5.0 / 13.0);

/// Turns of one circle at most: by more than a right angle in all.
const TURNS_MAX: usize = 5;

/// How far a lane leads straight on at least, in reaches: from there it is seen from aside, past the corner.
const STRAIGHT_MIN: f64 = 0.52;

/// How far a lane leads straight on at most, in reaches.
const STRAIGHT_MAX: f64 = 4.0;

/// How far apart neighbouring lanes are where they have turned, in reaches: there nobody stands in the gaps of others.
const APART: f64 = 1.05;

/// Returns how far circles have to be behind each other that turn so.
pub(crate) fn spacing(reach: f64) -> f64 {
    reach / (0.5 * (1.0 + TURN.0)).sqrt()
}

/// The end of a lane at a narrow place.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Gate {
    pub(crate) point: DVec2,
    /// Away from the narrow place, along the lane; a unit vector.
    pub(crate) outwards: DVec2,
}

/// A gate, and how far the lane leads straight on outside of it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Mouth {
    gate: Gate,
    straight: f64,
    /// How far the middles of two circles are apart at least.
    reach: f64,
}

/// Returns how each lane goes on outside of its gate; lanes are given by neighbours, each with the ends of the ways of those who take it.
///
/// Where neighbours turn to the same side, the one on the outside turns farther out, or they would come too near to each other.
pub(crate) fn fan(ground: &Ground, lanes: &[(Gate, Vec<DVec2>)], reach: f64) -> Vec<Mouth> {
    let mut mouths: Vec<Mouth> =
        lanes.iter().map(|&(gate, _)| Mouth { gate, straight: STRAIGHT_MIN * reach, reach }).collect();
    let aims: Vec<DVec2> =
        mouths.iter().zip(lanes).map(|(mouth, (_, ends))| mouth.aim(ground, ends)).collect();
    let farther = |inside: usize, outside: usize| {
        let (gate, aim) = (lanes[outside].0, (aims[inside] + aims[outside]).normalize_or_zero());
        let offset = gate.point - lanes[inside].0.point;
        let aside = gate.outwards.perp_dot(aim).abs();
        let is_outside = aim.dot(offset) < 0.0 && aside > 0.0;
        let more = if is_outside { (APART * reach - offset.perp_dot(aim).abs()) / aside } else { 0.0 };
        (more > 0.0).then_some(more)
    };
    let pairs = (1..lanes.len()).map(|lane| (lane - 1, lane));
    for (inside, outside) in pairs.clone().chain(pairs.rev().map(|(left, right)| (right, left))) {
        if let Some(more) = farther(inside, outside) {
            let least = (mouths[inside].straight + more).lesser(STRAIGHT_MAX * reach);
            mouths[outside].straight = mouths[outside].straight.greater(least);
        }
    }
    mouths
}

impl Mouth {
    fn point(&self) -> DVec2 {
        self.gate.point + self.gate.outwards * self.straight
    }

    /// The mean direction in which the ends lie that are seen from here.
    fn aim(&self, ground: &Ground, ends: &[DVec2]) -> DVec2 {
        let from = self.point();
        let seen = ends.iter().filter(|&&end| ground.is_clear(from, end));
        let sum: DVec2 = seen.map(|&end| (end - from).normalize_or_zero()).sum();
        if sum == DVec2::ZERO { self.gate.outwards } else { sum.normalize() }
    }

    /// Returns the points, from the gate outwards, at which one turns whose way ends in `end`, a reach from each other; `None` where that
    /// way is not clear.
    pub(crate) fn turns(&self, ground: &Ground, end: DVec2) -> Option<Vec<DVec2>> {
        let mut points = vec![self.gate.point, self.point()];
        let mut direction = self.gate.outwards;
        for turn in 0..=TURNS_MAX {
            let at = points[points.len() - 1];
            let away = end - at;
            if turn == 0 && away.dot(direction) < 0.0 {
                return None;
            }
            if away.length() < self.reach || direction.dot(away) >= TURN.0 * away.length() {
                break;
            }
            let side = if direction.perp_dot(away) > 0.0 { TURN.1 } else { -TURN.1 };
            direction = direction * TURN.0 + direction.perp() * side;
            let next = at + direction * self.reach;
            if turn == TURNS_MAX || !ground.is_clear(at, next) {
                break;
            }
            points.push(next);
        }
        let is_clear = points.windows(2).all(|leg| ground.is_clear(leg[0], leg[1]));
        (is_clear && ground.is_clear(points[points.len() - 1], end)).then_some(points)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tests::Dice;
    use crate::tests::release::gap;

    #[test]
    fn whoever_comes_from_aside_turns_little_by_little() {
        let ground = Ground::new(&gap(3), 0.35).unwrap();
        let reach = 0.7;
        let mut dice = Dice(3);
        let ends: Vec<DVec2> =
            (0..300).map(|_| DVec2::new(2.0 + 27.0 * dice.share(), 3.0 + 12.0 * dice.share())).collect();
        let lanes = [-1.1, -0.4, 0.4, 1.1].map(|x: f64| {
            let gate = Gate { point: DVec2::new(15.5 + x, 20.0), outwards: DVec2::NEG_Y };
            let is_of_lane = |end: &&DVec2| ((end.x - 15.5) / 7.0 - x).abs() < 0.5;
            (gate, ends.iter().filter(is_of_lane).copied().collect())
        });
        let mut turned = 0;
        for (mouth, (gate, ends)) in fan(&ground, &lanes, reach).into_iter().zip(&lanes) {
            for &end in ends {
                let points = mouth.turns(&ground, end).unwrap();
                assert_eq!(points[0], gate.point);
                let way: Vec<DVec2> = points.into_iter().chain([end]).collect();
                for turn in way.windows(3) {
                    let (one, other) = ((turn[1] - turn[0]).normalize(), (turn[2] - turn[1]).normalize());
                    assert!(one.dot(other) > TURN.0 - 1e-9, "{end}: {one} {other}");
                }
                turned += usize::from(way.len() > 4);
            }
        }
        assert!(turned > 20, "{turned}");
    }
}
