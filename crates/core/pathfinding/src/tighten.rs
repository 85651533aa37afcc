//! Turns of a path moved to the corners that make them.

use glam::DVec2;
use hashbrown::HashTable;
use maniple_geometry::Segment;

use crate::turns::{Pass, Turns, length};

/// How often all turns are looked at: each moves its neighbours' best places.
const PASSES_MAX: usize = 3;

/// How many corners one turn can be made of, and how often another is looked for.
const CORNERS_MAX: usize = 6;

/// A turn is only moved if the path becomes shorter by this much, in world units.
const GAIN_MIN: f64 = 1.0 / 1024.0;

/// What a leg comes too near to.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Hit {
    /// A wall: one of its ends is a corner.
    Wall(Segment),
    /// A circle, which is gone around as a corner is.
    Circle {
        /// Its middle.
        center: DVec2,
        /// How far from it a way turns, in world units.
        room: f64,
    },
}

/// How many bends are remembered at most; then all are forgotten.
const REMEMBERED_MAX: usize = 1 << 12;

/// The memory of passes, kept from one path to the next.
#[derive(Clone, Debug, Default)]
pub(crate) struct Tightening {
    points: Vec<DVec2>,
    bend: Bend,
}

impl Tightening {
    /// Returns one that remembers bends, for those whose blockers are always the same: paths to the same places have most of their
    /// turns in common.
    pub(crate) fn remembering() -> Self {
        let bend = Bend { found: Some(HashTable::new()), ..Bend::default() };
        Self { points: Vec::new(), bend }
    }

    /// Makes a path shorter; each leg stays clear. `blocker` says what a leg comes too near to, and `room` is how far from
    /// corners it turns, in world units.
    pub(crate) fn tighten(
        &mut self,
        blocker: &impl Fn(DVec2, DVec2) -> Option<Hit>,
        room: f64,
        path: &mut Vec<DVec2>,
    ) {
        for _ in 0..PASSES_MAX {
            if !self.pass(blocker, room, path) {
                break;
            }
        }
        // Steps of eight directions may have led to the wrong side of something; for a whole path that is one bend, the other
        // side is as easily tried.
        if let &[first, ref turns @ .., last] = &path[..]
            && !turns.is_empty()
            && self.bend.find(blocker, (first, turns, last), room)
        {
            path.truncate(1);
            path.extend_from_slice(&self.bend.turns.points);
            path.push(last);
        }
    }

    /// Returns whether anything changed.
    fn pass(
        &mut self,
        blocker: &impl Fn(DVec2, DVec2) -> Option<Hit>,
        room: f64,
        path: &mut Vec<DVec2>,
    ) -> bool {
        let Some((&first, rest)) = path.split_first() else { return false };
        self.points.clear();
        self.points.push(first);
        let mut before = first;
        let mut has_changed = false;
        for turn in rest.windows(2) {
            let (via, after) = (turn[0], turn[1]);
            if self.bend.find(blocker, (before, &[via], after), room) {
                self.points.extend_from_slice(&self.bend.turns.points);
                has_changed = true;
            } else if let &[.., last, _] = &self.points[..]
                && self.bend.find(blocker, (last, &[before, via], after), room)
            {
                // Corners that belong to one hull had been shared out to two turns.
                self.points.pop();
                self.points.extend_from_slice(&self.bend.turns.points);
                has_changed = true;
            } else {
                self.points.push(via);
            }
            before = self.points[self.points.len() - 1];
        }
        self.points.extend(rest.last());
        std::mem::swap(&mut self.points, path);
        has_changed
    }
}

/// The shortest way between two points that leaves what is between them to one side.
///
/// Such a way is the hull of the corners between the points: it goes along the tangent of the first corner's circle, along
/// lines that touch two circles, and along the tangent of the last one. Legs turn where two such lines meet.
#[derive(Clone, Debug, Default)]
struct Bend {
    passes: Vec<Pass>,
    turns: Turns,
    /// What was found up to now, if it is remembered. It is only ever asked for one, so that its order cannot be seen.
    found: Option<HashTable<Found>>,
}

/// A way of which it is known whether there is a shorter one.
#[derive(Clone, Debug)]
struct Found {
    /// Its points.
    way: Vec<DVec2>,
    /// The turns of the shorter one.
    turns: Option<Vec<DVec2>>,
}

impl Bend {
    /// Does what [`Self::look`] does, or remembers it.
    fn find(
        &mut self,
        blocker: &impl Fn(DVec2, DVec2) -> Option<Hit>,
        way: (DVec2, &[DVec2], DVec2),
        room: f64,
    ) -> bool {
        let points = || std::iter::once(way.0).chain(way.1.iter().copied()).chain(std::iter::once(way.2));
        let hash = hash_of(points());
        let is_it = |found: &Found| found.way.iter().copied().eq(points());
        if let Some(known) = self.found.as_ref().and_then(|found| found.find(hash, is_it)) {
            self.turns.points.clear();
            self.turns.points.extend(known.turns.iter().flatten());
            return known.turns.is_some();
        }
        let is_found = self.look(blocker, way, room);
        if let Some(found) = &mut self.found {
            if found.len() == REMEMBERED_MAX {
                found.clear();
            }
            let turns = is_found.then(|| self.turns.points.clone());
            let entry = Found { way: points().collect(), turns };
            found.insert_unique(hash, entry, |found| hash_of(found.way.iter().copied()));
        }
        is_found
    }

    /// Finds turns between two points that are shorter than the old ones, on the same side or else on the other one, and
    /// returns whether there are any. Where the straight way is clear, there are none on it.
    fn look(
        &mut self,
        blocker: &impl Fn(DVec2, DVec2) -> Option<Hit>,
        way: (DVec2, &[DVec2], DVec2),
        room: f64,
    ) -> bool {
        let (before, old, after) = way;
        let last = old.last().copied().unwrap_or(before);
        let side = if (after - before).perp_dot(last - before) < 0.0 { -1.0 } else { 1.0 };
        let length = length(before, old, after);
        [room * side, room * -side]
            .into_iter()
            .any(|room| self.find_beside(blocker, (before, after), room, length))
    }

    /// Finds turns that leave everything to one side, the one that the sign of `room` says.
    ///
    /// Corners are found one by one: a leg that is not clear meets a wall whose end belongs to the hull.
    fn find_beside(
        &mut self,
        blocker: &impl Fn(DVec2, DVec2) -> Option<Hit>,
        ends: (DVec2, DVec2),
        room: f64,
        old: f64,
    ) -> bool {
        self.passes.clear();
        for _ in 0..=CORNERS_MAX {
            if !self.turns.lay(ends, &self.passes) {
                return false;
            }
            // More corners only make it longer.
            if !self.passes.is_empty() && self.turns.length(ends.0, ends.1) > old - GAIN_MIN {
                return false;
            }
            let mut legs = self.turns.legs(ends.0, ends.1);
            let blocked = legs.find_map(|leg| blocker(leg.0, leg.1).map(|hit| (leg, hit)));
            drop(legs);
            let Some((leg, hit)) = blocked else { return true };
            if !self.insert(leg, hit, ends, room) {
                return false;
            }
        }
        false
    }

    /// Adds what a leg came too near to to the hull, and takes off what does not stick out any more. Returns whether it is a new one.
    fn insert(
        &mut self,
        (from, to, line): (DVec2, DVec2, Option<usize>),
        hit: Hit,
        (before, after): (DVec2, DVec2),
        room: f64,
    ) -> bool {
        let Some(place) = line else { return false };
        let height = |point: DVec2| (to - from).perp_dot(point - from) * room;
        let pass = match hit {
            Hit::Wall(wall) if height(wall.end) > height(wall.start) => Pass { corner: wall.end, room },
            Hit::Wall(wall) => Pass { corner: wall.start, room },
            Hit::Circle { center, room: own } => Pass { corner: center, room: own.copysign(room) },
        };
        if self.passes.iter().any(|other| other.corner == pass.corner) {
            return false;
        }
        self.passes.insert(place, pass);
        for index in [Some(place + 1), place.checked_sub(1)].into_iter().flatten() {
            let Some(&own) = self.passes.get(index) else { continue };
            let last = index.checked_sub(1).map_or(before, |last| self.passes[last].corner);
            let next = self.passes.get(index + 1).map_or(after, |pass| pass.corner);
            if (next - last).perp_dot(own.corner - last) * room <= 0.0 {
                self.passes.remove(index);
            }
        }
        true
    }
}

/// A hash of points.
fn hash_of(points: impl Iterator<Item = DVec2>) -> u64 {
    points.flat_map(|point| [point.x, point.y]).fold(0, |hash: u64, coordinate| {
        let mixed = (hash ^ coordinate.to_bits()).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        mixed ^ mixed >> 29
    })
}
