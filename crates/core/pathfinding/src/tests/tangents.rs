//! The shortest way of a circle there is: the yardstick of lengths.
//!
//! It goes along tangents and around corners: straight between circles of the reach around the corners, and along those circles.
//! A* over these tangents (Hart, Nilsson and Raphael, 1968); the tangents of a corner are found when a search first comes to
//! it. Of each arc only four points are looked at, so that it is never longer than the shortest way.

use std::cmp::Reverse;
use std::collections::{BTreeMap, BinaryHeap};

use glam::DVec2;
use maniple_geometry::Scalar;
use maniple_tilemap::TileMap;

use crate::Ground;

/// Tangents touch, and rounding must not block them.
const TOUCH: f64 = 1e-9;

/// A circle around a corner, and on which side of it a way goes by: to the left of the way lies the corner, or to the right.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Pass {
    corner: usize,
    is_left: bool,
}

/// A straight piece of a way, from a circle or the start to a circle or the goal.
#[derive(Clone, Copy)]
struct Tangent {
    from: DVec2,
    to: DVec2,
    pass: Pass,
}

/// The corners of a map as circles of one radius go around them, and the tangents between them that were needed so far.
pub(crate) struct Tangents {
    ground: Ground,
    reach: f64,
    corners: Vec<DVec2>,
    onward: Vec<[Option<Vec<Tangent>>; 2]>,
}

impl Tangents {
    /// Returns the corners for a radius and a margin, in world units.
    pub(crate) fn new(map: &TileMap, radius: f64, margin: f64) -> Self {
        let ground = Ground::with_margin(map, radius, margin - TOUCH).unwrap();
        let reach = radius + margin;
        let mut corners: Vec<DVec2> = map.segments().iter().flat_map(|wall| [wall.start, wall.end]).collect();
        corners.sort_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)));
        corners.dedup();
        // Somewhere around a corner a circle must have room: all around is looked at 64 times.
        corners.retain(|&corner| rays().any(|ray| ground.holds(corner + ray * reach)));
        let onward = corners.iter().map(|_| [None, None]).collect();
        Self { ground, reach, corners, onward }
    }

    /// Returns the length of the shortest way, which must not be longer than `most`; `None` where there is none. Only corners in the
    /// ellipse are looked at over which a way of that length can lead.
    pub(crate) fn shortest(&mut self, from: DVec2, to: DVec2, most: f64) -> Option<f64> {
        if self.ground.is_clear(from, to) {
            return Some(from.distance(to));
        }
        let most = most + 1e-6;
        let last = self.lasts(from, to, most);
        let mut best: BTreeMap<(Pass, [u64; 2]), f64> = BTreeMap::new();
        let mut known: Vec<(f64, Tangent)> = Vec::new();
        let mut queue = BinaryHeap::new();
        for tangent in self.firsts(from, to, most) {
            known.push((from.distance(tangent.to), tangent));
        }
        for (index, (walked, tangent)) in known.iter().enumerate() {
            queue.push(Reverse(((walked + tangent.to.distance(to)).to_bits(), index)));
        }
        let mut found = f64::INFINITY;
        while let Some(Reverse((bits, index))) = queue.pop() {
            if f64::from_bits(bits) >= found {
                break;
            }
            let (walked, tangent) = known[index];
            let key = (tangent.pass, [tangent.to.x.to_bits(), tangent.to.y.to_bits()]);
            if best.get(&key).is_some_and(|&best| best < walked) {
                continue;
            }
            if let Some(end) = last.get(&tangent.pass)
                && let Some(arc) = self.arc(tangent, *end)
            {
                found = found.lesser(walked + arc + end.from.distance(to));
            }
            self.open(tangent.pass);
            let side = usize::from(tangent.pass.is_left);
            let onward = self.onward[tangent.pass.corner][side].as_ref().unwrap();
            for &next in onward {
                let Some(arc) = self.arc(tangent, next) else { continue };
                let walked = walked + arc + next.from.distance(next.to);
                let whole = walked + next.to.distance(to);
                let key = (next.pass, [next.to.x.to_bits(), next.to.y.to_bits()]);
                if whole > most || best.get(&key).is_some_and(|&best| best <= walked) {
                    continue;
                }
                best.insert(key, walked);
                known.push((walked, next));
                queue.push(Reverse((whole.to_bits(), known.len() - 1)));
            }
        }
        (found <= most).then_some(found)
    }

    /// The tangents from a point to the circles within an ellipse.
    fn firsts(&self, from: DVec2, to: DVec2, most: f64) -> Vec<Tangent> {
        let near = (0..self.corners.len()).filter(|&corner| {
            let corner = self.corners[corner];
            corner.distance(from) + corner.distance(to) <= most + 2.0 * self.reach
        });
        let passes = near.flat_map(|corner| [false, true].map(|is_left| Pass { corner, is_left }));
        let tangents = passes.filter_map(|pass| self.first(from, pass));
        tangents.filter(|tangent| self.is_clear(tangent)).collect()
    }

    /// The tangents to the goal, by the circle that they leave: those from the goal, turned around.
    fn lasts(&self, from: DVec2, to: DVec2, most: f64) -> BTreeMap<Pass, Tangent> {
        let turned = self.firsts(to, from, most).into_iter().map(|tangent| {
            let pass = Pass { is_left: !tangent.pass.is_left, ..tangent.pass };
            (pass, Tangent { from: tangent.to, to: tangent.from, pass })
        });
        turned.collect()
    }

    /// Finds all tangents that leave a circle.
    fn open(&mut self, pass: Pass) {
        let side = usize::from(pass.is_left);
        if self.onward[pass.corner][side].is_some() {
            return;
        }
        let corners = (0..self.corners.len()).filter(|&corner| corner != pass.corner);
        let passes = corners.flat_map(|corner| [false, true].map(|is_left| Pass { corner, is_left }));
        let tangents = passes.filter_map(|next| self.between(pass, next));
        let tangents = tangents.filter(|tangent| self.is_clear(tangent)).collect();
        self.onward[pass.corner][side] = Some(tangents);
    }

    /// The tangent from a point to a circle: it touches where the line to the middle, seen from the middle, is turned by the angle
    /// whose cosine is the radius over the distance.
    fn first(&self, from: DVec2, pass: Pass) -> Option<Tangent> {
        let corner = self.corners[pass.corner];
        let normal = normal(corner - from, -sign(pass) * self.reach / corner.distance(from))?;
        Some(Tangent { from, to: corner + normal * (sign(pass) * self.reach), pass })
    }

    /// The line that touches both circles, each on a side: with the unit `u` from one to the other and `n` across it, the
    /// normal is `u s + n √(1 - s²)` where `s` is the difference of the signed radii over the distance.
    fn between(&self, pass: Pass, next: Pass) -> Option<Tangent> {
        let (a, b) = (self.corners[pass.corner], self.corners[next.corner]);
        let reach = self.reach;
        let normal = normal(b - a, reach * (sign(pass) - sign(next)) / a.distance(b))?;
        let (from, to) = (a + normal * (sign(pass) * reach), b + normal * (sign(next) * reach));
        Some(Tangent { from, to, pass: next })
    }

    fn is_clear(&self, tangent: &Tangent) -> bool {
        self.ground.is_clear(tangent.from, tangent.to)
    }

    /// The length of the arc from the end of a tangent to the start of another, both at one circle, the way round that the
    /// circle is passed; `None` where it is not free, or more than half a turn.
    #[expect(clippy::disallowed_methods, reason = "a yardstick for lengths, with room for the last bits")]
    fn arc(&self, arrival: Tangent, departure: Tangent) -> Option<f64> {
        let corner = self.corners[arrival.pass.corner];
        let (first, last) = (arrival.to - corner, departure.from - corner);
        let turn = first.perp_dot(last) * -sign(arrival.pass);
        let chord = first.distance(last);
        if chord < TOUCH {
            return Some(chord);
        }
        if turn < 0.0 {
            return None;
        }
        let middle = |p: DVec2, q: DVec2| (p + q).normalize_or_zero() * self.reach;
        let half = middle(first, last);
        let points = [half, middle(first, half), middle(half, last)];
        if !points.into_iter().all(|point| self.ground.holds(corner + point)) {
            return None;
        }
        let sine = chord / (2.0 * self.reach);
        Some(2.0 * self.reach * if sine < 1.0 { sine.asin() } else { 1.0_f64.asin() })
    }
}

/// Directions all around.
fn rays() -> impl Iterator<Item = DVec2> {
    let steps = (-8..=8).map(|step| f64::from(step) / 8.0);
    steps.flat_map(|step| {
        [DVec2::new(1.0, step), DVec2::new(-1.0, step), DVec2::new(step, 1.0), DVec2::new(step, -1.0)]
            .map(DVec2::normalize)
    })
}

/// On which side of the line the circle's middle does not lie: the normal times this leads from the middle to the line.
fn sign(pass: Pass) -> f64 {
    if pass.is_left { -1.0 } else { 1.0 }
}

fn normal(offset: DVec2, along: f64) -> Option<DVec2> {
    let unit = offset.normalize_or_zero();
    let square = 1.0 - along * along;
    (square >= 0.0).then(|| unit * along + unit.perp() * square.sqrt())
}
