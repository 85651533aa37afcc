//! Units that walk the ways of a plan in step, each as far as is known that those before it leave in time.

use glam::DVec2;
use maniple_geometry::Scalar;

use super::passage::{Departure, Passage};
use super::scene::{Delivery, GRACE, LEAD, LEGS_MAX, Order, Scene, Seen, THERE};
use crate::in_step::{Board, Place};

/// Rounding of times, in cycles; so long nobody comes nearer by more than rounding.
const SLACK: f64 = 1e-9;

/// How far from where it is expected a unit may rest, in world units: what rounding on the wire may take, twice.
const AT: f64 = 2.0 * THERE;

/// A walk without a stop, between two places of a way by their indices, and when it starts, in cycles.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Run {
    from: usize,
    to: usize,
    start: f64,
}

/// What a unit is known to do. Indices are those of the places of its way.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Walker {
    /// It rests.
    Resting { at: usize },
    /// It was told to go, and has not been seen to.
    Ordered { from: usize, to: usize, start: f64 },
    /// It was seen to go from one place to another, without a stop; perhaps it was told to go on from there.
    Going { from: usize, to: usize, start: f64, onward: Option<usize> },
}

/// When a unit leaves a place of its way.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Leaving {
    Left,
    At(f64),
    Unknown,
}

/// Somebody is not where it has to be.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Astray;

/// What all units are known to do.
#[derive(Clone, Debug)]
pub(crate) struct Walkers {
    walkers: Vec<Walker>,
    /// Cycles of a step.
    step: f64,
    delivery: Delivery,
}

impl Walkers {
    /// Returns units that rest at the beginning of their ways; steps are a pitch long, at a speed in world units a cycle.
    pub(crate) fn new(units: usize, (pitch, speed): (f64, f64), delivery: Delivery) -> Self {
        Self { walkers: vec![Walker::Resting { at: 0 }; units], step: pitch / speed, delivery }
    }

    /// Whether all rest at the ends of their ways.
    pub(crate) fn are_done(&self, passage: &Passage) -> bool {
        let is_done =
            |(unit, walker): (usize, &Walker)| *walker == Walker::Resting { at: passage.way(unit).len() - 1 };
        self.walkers.iter().enumerate().all(is_done)
    }

    /// The part of its way that a unit may still walk, or is walking.
    pub(crate) fn ahead<'a>(&self, passage: &'a Passage, unit: usize) -> &'a [Place] {
        let (Walker::Resting { at: from } | Walker::Ordered { from, .. } | Walker::Going { from, .. }) =
            self.walkers[unit];
        &passage.way(unit)[from..]
    }

    /// Takes in where all are.
    pub(crate) fn look(
        &mut self,
        (board, passage): (&Board, &Passage),
        scene: &Scene<'_>,
    ) -> Result<(), Astray> {
        for (unit, walker) in self.walkers.iter_mut().enumerate() {
            let way = passage.way(unit);
            let is_at =
                |index: usize, seen: Seen| board.point(way[index]).distance_squared(seen.position) <= AT * AT;
            *walker = walker.seen((scene.units[unit], f64::from(scene.cycle)), self.step, is_at)?;
        }
        Ok(())
    }

    /// Returns the orders of a cycle: for those who rest, and for those who would come to rest before another order can reach
    /// them.
    pub(crate) fn orders(&mut self, (board, passage): (&Board, &Passage), cycle: u32) -> Vec<Order> {
        let mut given: Vec<Option<Run>> = vec![None; self.walkers.len()];
        // How far one is told to go may let another go farther, who is told in the same cycle.
        loop {
            let mut has_changed = false;
            for (unit, given) in given.iter_mut().enumerate() {
                let way = Way { passage, unit, step: self.step };
                if let Some((walker, run)) = self.told(way, f64::from(cycle + LEAD), given.is_some()) {
                    has_changed = true;
                    self.walkers[unit] = walker;
                    *given = Some(run);
                }
            }
            if !has_changed {
                break;
            }
        }
        let order = |(unit, run): (usize, Option<Run>)| {
            let way = Way { passage, unit, step: self.step };
            run.map(|run| way.order(board, run))
        };
        given.into_iter().enumerate().filter_map(order).collect()
    }

    /// What a unit does if it is told to go, or to go farther than it was told in this cycle, and what it is told; `None` where there is
    /// nothing to tell.
    fn told(&self, way: Way<'_>, earliest: f64, is_told: bool) -> Option<(Walker, Run)> {
        let leaving =
            |(unit, index): Departure| self.walkers[unit].leaving(index, (self.step, self.delivery));
        match self.walkers[way.unit] {
            Walker::Resting { at } => {
                let (start, to) = way.first_run(at, earliest, leaving)?;
                Some((Walker::Ordered { from: at, to, start }, Run { from: at, to, start }))
            }
            Walker::Ordered { from, to, start } if is_told => {
                let to = way.onward((from, to), start, leaving)?;
                Some((Walker::Ordered { from, to, start }, Run { from, to, start }))
            }
            Walker::Going { from, to, start, onward } if is_told || onward.is_none() => {
                let arrival = start + self.step * (to - from) as f64;
                if arrival < earliest || arrival >= earliest + 1.0 {
                    return None;
                }
                let end = way.onward((to, onward.unwrap_or(to)), arrival, leaving)?;
                let going = Walker::Going { from, to, start, onward: Some(end) };
                Some((going, Run { from: to, to: end, start: arrival }))
            }
            Walker::Ordered { .. } | Walker::Going { .. } => None,
        }
    }

    /// Who may be moving, or told to.
    pub(crate) fn under_way(&self) -> impl Iterator<Item = usize> {
        let is_under_way = |(_, walker): &(usize, &Walker)| !matches!(walker, Walker::Resting { .. });
        self.walkers.iter().enumerate().filter(is_under_way).map(|(unit, _)| unit)
    }
}

impl Walker {
    /// What a unit does that is seen like this at a time.
    fn seen(
        self,
        (seen, now): (Seen, f64),
        step: f64,
        is_at: impl Fn(usize, Seen) -> bool,
    ) -> Result<Self, Astray> {
        match self {
            Self::Resting { at } => {
                if seen.is_moving || !is_at(at, seen) {
                    Err(Astray)
                } else {
                    Ok(self)
                }
            }
            Self::Ordered { from, to, start } => {
                if now > start && (seen.is_moving || !is_at(from, seen)) {
                    let going = Self::Going { from, to, start, onward: None };
                    return going.seen((seen, now), step, is_at);
                }
                let is_lost = now > start + f64::from(GRACE);
                Ok(if is_lost { Self::Resting { at: from } } else { self })
            }
            Self::Going { from, to, start, onward } => {
                let arrival = start + step * (to - from) as f64;
                if now < arrival {
                    return if seen.is_moving { Ok(self) } else { Err(Astray) };
                }
                let is_late = now > arrival + f64::from(GRACE);
                if let Some(end) = onward
                    && (seen.is_moving || !is_at(to, seen))
                {
                    if now <= arrival {
                        return Ok(self);
                    }
                    let going = Self::Going { from: to, to: end, start: arrival, onward: None };
                    return going.seen((seen, now), step, is_at);
                }
                if seen.is_moving {
                    return if is_late { Err(Astray) } else { Ok(self) };
                }
                match () {
                    () if !is_at(to, seen) => Err(Astray),
                    // What it was told may still come.
                    () if onward.is_some() && !is_late => Ok(self),
                    () => Ok(Self::Resting { at: to }),
                }
            }
        }
    }

    /// When the unit leaves the place with an index on its way: as far as it was told to go, or, where orders get lost, was seen
    /// to.
    fn leaving(self, index: usize, (step, delivery): (f64, Delivery)) -> Leaving {
        let (from, to, start) = match (self, delivery) {
            (Self::Resting { at }, _) => (at, at, 0.0),
            (Self::Ordered { from, to, start }, Delivery::Sure) => (from, to, start),
            (Self::Ordered { from, .. }, Delivery::Lossy { .. }) => (from, from, 0.0),
            (Self::Going { from, to, start, onward }, Delivery::Sure) => (from, onward.unwrap_or(to), start),
            (Self::Going { from, to, start, .. }, Delivery::Lossy { .. }) => (from, to, start),
        };
        match index {
            _ if index < from => Leaving::Left,
            _ if index < to => Leaving::At(start + step * (index - from) as f64),
            _ => Leaving::Unknown,
        }
    }
}

/// The way of one unit.
#[derive(Clone, Copy, Debug)]
struct Way<'a> {
    passage: &'a Passage,
    unit: usize,
    /// Cycles of a step.
    step: f64,
}

impl Way<'_> {
    /// When a unit that rests can start, and how far it gets without a stop; `None` where that is not known.
    fn first_run(
        &self,
        at: usize,
        earliest: f64,
        leaving: impl Fn(Departure) -> Leaving,
    ) -> Option<(f64, usize)> {
        if at + 1 == self.passage.way(self.unit).len() {
            return None;
        }
        let start = match self.passage.after(self.unit, at + 1).map_or(Leaving::Left, &leaving) {
            Leaving::Left => earliest,
            Leaving::At(time) => earliest.greater(time),
            Leaving::Unknown => return None,
        };
        self.onward((at, at), start, leaving).map(|to| (start, to))
    }

    /// How far a unit gets without a stop that leaves a place at a time, and gets to another for sure; `None` where it gets no
    /// farther.
    fn onward(
        &self,
        (from, sure): (usize, usize),
        start: f64,
        leaving: impl Fn(Departure) -> Leaving,
    ) -> Option<usize> {
        let way = self.passage.way(self.unit);
        let mut to = sure;
        while to + 1 < way.len() && to - from < LEGS_MAX {
            let time = start + self.step * (to - from) as f64 + SLACK;
            let is_free = match self.passage.after(self.unit, to + 1).map_or(Leaving::Left, &leaving) {
                Leaving::Left => true,
                Leaving::At(left) => left <= time,
                Leaving::Unknown => false,
            };
            if !is_free {
                break;
            }
            to += 1;
        }
        // Where it ends has to be another place than where it begins, or it could not be told whether it went.
        while to > sure && way[to] == way[from] {
            to -= 1;
        }
        (to > sure).then_some(to)
    }

    fn order(&self, board: &Board, Run { from, to, start }: Run) -> Order {
        let points: Vec<DVec2> =
            self.passage.way(self.unit)[from..=to].iter().map(|&place| board.point(place)).collect();
        let mut legs = Vec::new();
        for (index, &point) in points.iter().enumerate().skip(1) {
            let is_straight =
                points.get(index + 1).is_some_and(|&next| next - point == point - points[index - 1]);
            if !is_straight {
                legs.push(point);
            }
        }
        Order { unit: self.unit, legs, start: Some(start) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Ground;
    use crate::tests::drawn;

    /// Who is quick may do both steps in one cycle, and would be where it was.
    #[test]
    fn no_run_ends_where_it_begins() {
        let board = Board::new(&Ground::new(&drawn(&["..", ".."]), 0.35).unwrap()).unwrap();
        let [here, there] = [board.place(0, 0).unwrap(), board.place(1, 0).unwrap()];
        let mut passage = Passage::new(board.len(), &[here]);
        for place in [there, here, there] {
            passage.push(&[place]);
        }
        fn way(passage: &Passage) -> Way<'_> {
            Way { passage, unit: 0, step: 0.25 }
        }
        assert_eq!(way(&passage).onward((0, 0), 0.0, |_| Leaving::Left), Some(3));
        passage.push(&[here]);
        assert_eq!(way(&passage).onward((0, 0), 0.0, |_| Leaving::Left), Some(3));
        assert_eq!(way(&passage).onward((2, 2), 0.0, |_| Leaving::Left), Some(3));
    }
}
