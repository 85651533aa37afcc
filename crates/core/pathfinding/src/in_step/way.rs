//! The way of one among others that have theirs already.

use crate::in_step::board::{Board, Place};
use crate::in_step::distances::FAR;
use crate::in_step::reservations::{FOREVER, Gap, Reservations};

/// No node.
const NONE: u32 = u32::MAX;

/// What a way is looked for in.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Surroundings<'a> {
    pub(crate) board: &'a Board,
    pub(crate) reservations: &'a Reservations,
    /// How far the goal is from each place.
    pub(crate) distances: &'a [u32],
    /// The first step from which on one can stay at the goal.
    pub(crate) end: u32,
    /// Others are looked out for up to this step.
    pub(crate) horizon: u32,
    /// Decides ties.
    pub(crate) salt: u64,
}

impl Surroundings<'_> {
    /// What a way costs at least that is in a place at a step.
    fn cost_min(&self, place: Place, arrival: u32) -> u32 {
        (arrival + self.distances[place.index()]).max(self.end)
    }

    /// The neighbours of a place, from one on that the salt chooses.
    pub(crate) fn around(&self, place: Place) -> impl Iterator<Item = Place> {
        let around = self.board.neighbours(place);
        // Four neighbours at most, so two bits choose.
        let first = (self.salt >> (place.0 % 63) & 3) % (around.len() as u64).max(1);
        let (before, behind) = around.split_at(usize::try_from(first).expect("it is below four"));
        behind.iter().chain(before).copied()
    }
}

/// A gap in which one can be in a place.
#[derive(Clone, Copy, Debug)]
struct Node {
    place: Place,
    gap: Gap,
    /// The first step at which one can be there.
    arrival: u32,
    parent: u32,
    /// Another node of the same place.
    sibling: u32,
    is_done: bool,
}

/// The first node of a place, and in which search it was found.
#[derive(Clone, Copy, Debug)]
struct Mark {
    search: u32,
    node: u32,
}

/// Finds shortest ways in space and time, by safe intervals (Phillips and Likhachev, *SIPP: Safe Interval Path Planning for Dynamic
/// Environments*, 2011): a state is a gap of a place, for in a gap the earliest is never worse. Keeps its memory.
#[derive(Clone, Debug)]
pub(crate) struct WayFinder {
    nodes: Vec<Node>,
    marks: Vec<Mark>,
    search: u32,
    /// What a way from the start costs at least.
    least: u32,
    /// Nodes by what a way through them costs at least, from the least on.
    buckets: Vec<Vec<u32>>,
    pub(crate) expanded: u64,
}

impl WayFinder {
    pub(crate) fn new(board: &Board) -> Self {
        Self {
            nodes: Vec::new(),
            marks: vec![Mark { search: 0, node: NONE }; board.len()],
            search: 0,
            least: 0,
            buckets: Vec::new(),
            expanded: 0,
        }
    }

    /// Returns a shortest way from a place to where the distance is 0 and one can stay, or, if the horizon is nearer, to there; place
    /// by place from step 0 on. `None` where there is none that costs less than `cost_max`.
    pub(crate) fn find(
        &mut self,
        surroundings: &Surroundings<'_>,
        start: Place,
        cost_max: u32,
    ) -> Option<Vec<Place>> {
        if surroundings.distances[start.index()] == FAR || surroundings.end == FOREVER {
            return None;
        }
        self.search += 1;
        self.nodes.clear();
        for bucket in &mut self.buckets {
            bucket.clear();
        }
        let gap = surroundings.reservations.gaps(start, 0, 0).next()?;
        self.least = surroundings.cost_min(start, 0);
        self.reach(surroundings, Step { parent: NONE, place: start, gap, arrival: 0 }, cost_max);
        let mut lowest = 0;
        while lowest < self.buckets.len() {
            let Some(number) = self.buckets[lowest].pop() else {
                lowest += 1;
                continue;
            };
            let node = self.nodes[number as usize];
            let distance = surroundings.distances[node.place.index()];
            if node.is_done
                || (surroundings.cost_min(node.place, node.arrival) - self.least) as usize != lowest
            {
                continue;
            }
            if (distance == 0 && node.gap.until == FOREVER) || node.arrival >= surroundings.horizon {
                return Some(self.way(number));
            }
            self.nodes[number as usize].is_done = true;
            self.expanded += 1;
            self.expand(surroundings, number, cost_max);
        }
        None
    }

    fn expand(&mut self, surroundings: &Surroundings<'_>, number: u32, cost_max: u32) {
        let node = self.nodes[number as usize];
        let (first, last) = (node.arrival + 1, node.gap.until.saturating_add(1));
        for place in surroundings.around(node.place) {
            for gap in surroundings.reservations.gaps(place, first, last) {
                let arrival = gap.from.max(first);
                // The last step may be one too late, where somebody comes: then it is a swap or nothing.
                if arrival > gap.until
                    || arrival > last
                    || (arrival == gap.from
                        && surroundings.reservations.is_swap((node.place, &node.gap), (place, &gap)))
                {
                    continue;
                }
                self.reach(surroundings, Step { parent: number, place, gap, arrival }, cost_max);
            }
        }
    }

    /// Notes that a gap can be reached.
    fn reach(&mut self, surroundings: &Surroundings<'_>, step: Step, cost_max: u32) {
        let Step { parent, place, gap, arrival } = step;
        let cost = surroundings.cost_min(place, arrival);
        if cost >= cost_max {
            return;
        }
        let mark = self.marks[place.index()];
        let first = if mark.search == self.search { mark.node } else { NONE };
        let mut number = first;
        while number != NONE && self.nodes[number as usize].gap.number != gap.number {
            number = self.nodes[number as usize].sibling;
        }
        if number == NONE {
            number = u32::try_from(self.nodes.len()).expect("gaps are counted in 32 bits");
            self.nodes.push(Node { place, gap, arrival, parent, sibling: first, is_done: false });
            self.marks[place.index()] = Mark { search: self.search, node: number };
        } else {
            let node = &mut self.nodes[number as usize];
            if node.arrival <= arrival {
                return;
            }
            // Where the goal is taken for long, many arrivals have the same bound, and a later one may have come first.
            (node.arrival, node.parent, node.is_done) = (arrival, parent, false);
        }
        let bucket = (cost - self.least) as usize;
        if self.buckets.len() <= bucket {
            self.buckets.resize(bucket + 1, Vec::new());
        }
        self.buckets[bucket].push(number);
    }

    fn way(&self, last: u32) -> Vec<Place> {
        let mut way = Vec::new();
        let mut node = self.nodes[last as usize];
        way.push(node.place);
        while node.parent != NONE {
            let parent = self.nodes[node.parent as usize];
            way.extend((parent.arrival..node.arrival).map(|_| parent.place));
            node = parent;
        }
        way.reverse();
        way
    }
}

/// A step to a gap.
#[derive(Clone, Copy, Debug)]
struct Step {
    parent: u32,
    place: Place,
    gap: Gap,
    arrival: u32,
}
