//! Ways between near ends, searched for among the lines that touch corners.
//!
//! Steps of eight directions are up to 8 % longer than straight ways, and by more or less on different sides of things; so they may
//! lead to the wrong side, and on short ways that is much. The shortest way of a circle goes along lines that touch the circles
//! around corners. Those lines are many, so only they are looked at that can be part of a way shorter than the one that is
//! known: A* (Hart, Nilsson and Raphael, 1968) over corners and their two sides, bounded by the length of that way. Costs
//! are lengths of legs, so that what is shorter here is shorter when it is walked.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use glam::DVec2;

use crate::ground::Ground;
use crate::turns::{Line, Pass, Turns, line_between, line_from, line_to, meeting, turn_length};

/// Ways up to this length are searched for, in world units: of longer ones none that was measured was 7 % too long, and the lines
/// to look at grow with the square of the area.
const LENGTH_MAX: f64 = 48.0;

/// A way is only taken for a shorter one by this share of its length: what is searched for is the right side of things, and all that
/// are not much longer need not be looked at.
const GAIN_SHARE_MIN: f64 = 1.0 / 128.0;

/// How many corners are looked from at most.
const EXPANDED_MAX: usize = 256;

/// No corner.
const NONE: usize = usize::MAX;

/// What the search knows of a corner and a side of it.
#[derive(Clone, Copy, Debug)]
struct Known {
    pass: Pass,
    /// The straight way from the corner to the goal.
    rest: f64,
    /// The length of legs up to the place where the last one touches the circle; infinite before there are any.
    cost: f64,
    /// The line on which it comes there.
    line: Line,
    /// The corner before it, or [`NONE`].
    before: usize,
}

/// The memory of searches, kept from one to the next.
#[derive(Clone, Debug, Default)]
pub(crate) struct Taut {
    known: Vec<Known>,
    /// By the length of the whole way at least, as bits, which for lengths are in the order of the numbers; then the corner.
    queue: BinaryHeap<Reverse<(u64, usize)>>,
    passes: Vec<Pass>,
    turns: Turns,
}

impl Taut {
    /// Makes a path of legs, its start included, the shortest between its ends that the search finds, if it is short and there
    /// is one that is much shorter.
    pub(crate) fn shorten(&mut self, ground: &Ground, path: &mut Vec<DVec2>) {
        let &[from, .., to] = &path[..] else { return };
        let length = crate::length(from, &path[1..]);
        if path.len() == 2 || length > LENGTH_MAX {
            return;
        }
        self.gather(ground, (from, to), length);
        if !self.search(ground, (from, to), length * (1.0 - GAIN_SHARE_MIN)) {
            return;
        }
        let is_shorter = self.turns.lay((from, to), &self.passes) && self.turns.length(from, to) < length;
        if is_shorter && self.turns.legs(from, to).all(|leg| ground.walls.is_clear(leg.0, leg.1)) {
            path.truncate(1);
            path.extend_from_slice(&self.turns.points);
            path.push(to);
        }
    }

    /// Lists both sides of all corners in the ellipse over which a way can be as short as that.
    fn gather(&mut self, ground: &Ground, (from, to): (DVec2, DVec2), length: f64) {
        let room = ground.room();
        let (middle, axis) = ((from + to) / 2.0, (to - from).normalize_or_zero());
        let most = length + 2.0 * room;
        // A point of an ellipse with half axes `a` and `b`, turned by the unit `u`, is at most `√((a u.x)² + (b u.y)²)` to the
        // side of its middle.
        let (long, short) = (most * most / 4.0, (most * most - from.distance_squared(to)) / 4.0);
        let square = axis * axis;
        let half = DVec2::new(long * square.x + short * square.y, long * square.y + short * square.x);
        let half = DVec2::new(half.x.sqrt(), half.y.sqrt());
        self.known.clear();
        let placeholder = Line { point: DVec2::ZERO, direction: DVec2::ZERO };
        for corner in ground.corners.within(middle - half, middle + half) {
            let rest = corner.distance(to);
            if corner.distance(from) + rest < most {
                self.known.extend([room, -room].map(|room| Known {
                    pass: Pass { corner, room },
                    rest,
                    cost: f64::INFINITY,
                    line: placeholder,
                    before: NONE,
                }));
            }
        }
    }

    /// Leaves in `passes` the corners of the shortest way found, and returns whether there is one shorter than `bound`.
    fn search(&mut self, ground: &Ground, (from, to): (DVec2, DVec2), mut bound: f64) -> bool {
        self.begin(ground, (from, to), bound);
        let mut last = NONE;
        let mut expanded = 0;
        while let Some(Reverse((bits, index))) = self.queue.pop() {
            if f64::from_bits(bits) >= bound || expanded == EXPANDED_MAX {
                break;
            }
            // An entry that was overtaken by a better one is out of date.
            if bits != self.known[index].whole(to).to_bits() {
                continue;
            }
            expanded += 1;
            if let Some(whole) = end(ground, self.known[index], to, bound) {
                (bound, last) = (whole, index);
            }
            self.expand(ground, index, to, bound);
        }
        self.passes.clear();
        while last != NONE {
            self.passes.push(self.known[last].pass);
            last = self.known[last].before;
        }
        self.passes.reverse();
        !self.passes.is_empty()
    }

    /// Queues the corners that the start sees.
    fn begin(&mut self, ground: &Ground, (from, to): (DVec2, DVec2), bound: f64) {
        self.queue.clear();
        for next in 0..self.known.len() {
            let line = line_to(from, self.known[next].pass);
            let cost = from.distance(line.point);
            if cost + line.point.distance(to) < bound && ground.walls.is_clear(from, line.point) {
                self.reach(next, (cost, line, NONE), to);
            }
        }
    }

    /// Queues the corners to which a way shorter than `bound` may lead from a corner.
    fn expand(&mut self, ground: &Ground, index: usize, to: DVec2, bound: f64) {
        let own = self.known[index];
        for next in 0..self.known.len() {
            let other = self.known[next];
            let corner = other.pass.corner;
            // Quick to say of most: places where circles are touched are at most so far from their middles.
            let least = own.cost + own.line.point.distance(corner) + other.rest - 2.0 * ground.room();
            if least >= bound || corner == own.pass.corner {
                continue;
            }
            let Some(line) = line_between(own.pass, other.pass) else { continue };
            let Some(turn) = turn(own.line, line, own.pass) else { continue };
            let touch = own.pass.corner + line.direction.perp() * own.pass.room;
            let cost = own.cost + turn + touch.distance(line.point);
            if cost + line.point.distance(to) < bound
                && is_better((cost, line), &other)
                && is_turn_clear(ground, own, line, line.point)
            {
                self.reach(next, (cost, line, index), to);
            }
        }
    }

    fn reach(&mut self, index: usize, (cost, line, before): (f64, Line, usize), to: DVec2) {
        let known = &mut self.known[index];
        *known = Known { cost, line, before, ..*known };
        self.queue.push(Reverse((known.whole(to).to_bits(), index)));
    }
}

impl Known {
    /// Returns how long a way over the corner is at least.
    fn whole(&self, to: DVec2) -> f64 {
        self.cost + self.line.point.distance(to)
    }
}

/// Returns the length of the way that goes on from a corner to the goal; `None` where it is not clear, or not shorter than `bound`.
fn end(ground: &Ground, own: Known, to: DVec2, bound: f64) -> Option<f64> {
    let line = line_from(own.pass, to);
    let whole = own.cost + turn(own.line, line, own.pass)? + line.point.distance(to);
    (whole < bound && is_turn_clear(ground, own, line, to)).then_some(whole)
}

/// How much longer the legs of a turn are; `None` where the way would not turn towards the corner.
fn turn(to: Line, from: Line, pass: Pass) -> Option<f64> {
    let turns = to.direction.perp_dot(from.direction) * pass.room <= 0.0;
    turns.then(|| turn_length(to.direction, from.direction, pass.room))
}

/// Whether a way is better than the one that is known to come to the same side of the same corner. They touch its circle in
/// different places; the one that comes earlier has to turn more.
fn is_better((cost, line): (f64, Line), known: &Known) -> bool {
    match turn(known.line, line, known.pass) {
        Some(turn) => cost < known.cost + turn,
        None => cost + turn_length(line.direction, known.line.direction, known.pass.room) < known.cost,
    }
}

/// Whether the turn from the line on which a way comes to a corner, and the next line up to a point, are clear.
fn is_turn_clear(ground: &Ground, own: Known, line: Line, end: DVec2) -> bool {
    let (first, second) = meeting(own.line, line, own.pass);
    let is_clear = |from, to| ground.walls.is_clear(from, to);
    is_clear(second, end) && (first == second || is_clear(first, second)) && is_clear(own.line.point, first)
}
