//! Paths around circles and rectangles that stand in the way.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use glam::DVec2;
use maniple_geometry::Segment;

use crate::crowd::{Crowd, Standing};
use crate::error::PlanError;
use crate::ground::Ground;
use crate::jump::octile;
use crate::lattice::{DIAGONAL, Lattice, STRAIGHT};
use crate::planner::{check_goal, check_start};
use crate::pull::pull;

/// No node.
const NONE: u32 = u32::MAX;

/// For so many nodes that are looked at in a search, those of which it is looked back from the goal are as many as those from the start;
/// from then on one for so many.
const BACK_AT_ONCE: usize = 1 << 10;
const BACK_SELDOM: usize = 8;

/// The eight steps, in the order in which ties are decided.
const STEPS: [(i32, i32); 8] = [(1, 0), (0, 1), (-1, 0), (0, -1), (1, 1), (-1, 1), (-1, -1), (1, -1)];

/// What a search knows of a node.
#[derive(Clone, Copy, Debug, Default)]
struct Known {
    /// The last search that has reached it from the start, with the cost of the way and the node before it.
    search: u32,
    cost: u32,
    before: u32,
    /// The last search that has found a way from it to the goal.
    leads: u32,
}

/// Finds paths around walls and things at rest; keeps its memory from one to the next.
#[derive(Clone, Debug)]
pub struct Detours<'a> {
    ground: &'a Ground,
    memory: Memory,
}

/// What a search remembers of a lattice.
#[derive(Clone, Debug, Default)]
pub(crate) struct Memory {
    /// How many searches there have been.
    number: u32,
    known: Vec<Known>,
    /// The nodes that are to be expanded: by the cost of a whole way, then the rest of it, then the number of the node.
    queue: BinaryHeap<Reverse<u128>>,
    /// The nodes from which there is a way to the goal, and of which it is not known yet from where one comes there.
    leading: Vec<u32>,
    expanded: usize,
}

/// What is known of the nodes from which there is a way to the goal.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Back {
    /// There may be more.
    Open,
    /// The start has a way to one of them.
    Met,
    /// These are all, and the start is none of them.
    Closed,
}

impl<'a> Detours<'a> {
    /// Returns a planner for a ground.
    #[must_use]
    pub fn new(ground: &'a Ground) -> Self {
        Self::with_memory(ground, Memory::default())
    }

    /// Returns a planner for a ground that takes over the memory of another.
    pub(crate) fn with_memory(ground: &'a Ground, memory: Memory) -> Self {
        Self { ground, memory }
    }

    /// Returns its memory for another.
    pub(crate) fn into_memory(self) -> Memory {
        self.memory
    }

    /// Returns the goals of straight legs from one point to another that keep clear of walls and of a crowd: the shortest way
    /// between points of the lattice (Hart, Nilsson and Raphael, 1968), pulled straight. `Ok(None)`: the crowd closes every way that
    /// this lattice knows.
    ///
    /// # Errors
    /// An end that is not on the map or has no room between the walls.
    pub fn path(&mut self, crowd: &Crowd, from: DVec2, to: DVec2) -> Result<Option<Vec<DVec2>>, PlanError> {
        check_goal(self.ground, to)?;
        let departure = check_start(self.ground, from)?;
        self.memory.expanded = 0;
        let is_clear = |from, to| self.ground.walls.is_clear(from, to) && crowd.is_clear(from, to);
        if departure != from && !crowd.is_clear(from, departure) {
            return Ok(None);
        }
        let first = usize::from(departure == from);
        let mut points = vec![departure];
        if !is_clear(departure, to) {
            let (mut starts, mut goals) = (Vec::new(), Vec::new());
            let lattice = &self.ground.lattice;
            lattice.access(&self.ground.walls, departure, &mut starts);
            lattice.access(&self.ground.walls, to, &mut goals);
            starts.retain(|&node| crowd.is_clear(departure, lattice.point(node)));
            goals.retain(|&node| crowd.is_clear(lattice.point(node), to));
            let steps = Steps { lattice, crowd, is_allowed: |_| true };
            let Some(way) = self.memory.search(steps, (departure, &starts), &goals) else { return Ok(None) };
            points.extend(way.iter().map(|&node| lattice.point(node)).filter(|&point| point != departure));
        }
        if points[points.len() - 1] != to {
            points.push(to);
        }
        if points.len() > 2 {
            pull(|from, to| self.ground.walls.is_clear(from, to) && crowd.is_clear(from, to), &mut points);
        }
        Ok(Some(points.split_off(first)))
    }

    /// Returns the points of a shortest way between points of the lattice from one point to another by points that are allowed; `None`
    /// where there is none.
    pub(crate) fn way(
        &mut self,
        from: DVec2,
        to: DVec2,
        is_allowed: impl Fn(DVec2) -> bool + Copy,
    ) -> Option<Vec<DVec2>> {
        let (mut starts, mut goals) = (Vec::new(), Vec::new());
        let lattice = &self.ground.lattice;
        lattice.access(&self.ground.walls, from, &mut starts);
        lattice.access(&self.ground.walls, to, &mut goals);
        self.memory.expanded = 0;
        let steps = Steps { lattice, crowd: &Crowd::new(), is_allowed };
        let way = self.memory.search(steps, (from, &starts), &goals)?;
        Some(way.into_iter().map(|node| lattice.point(node)).collect())
    }

    /// Returns how many points of the lattice the last search looked at: the measure of its work.
    #[must_use]
    pub fn expanded(&self) -> usize {
        self.memory.expanded
    }
}

/// The steps of a lattice that a crowd leaves clear, between points that are allowed.
#[derive(Clone, Copy)]
struct Steps<'a, A> {
    lattice: &'a Lattice,
    crowd: &'a Crowd,
    is_allowed: A,
}

impl<A: Fn(DVec2) -> bool + Copy> Steps<'_, A> {
    /// Calls with each neighbour of a node to which walls leave a step, its place, and the cost of the step.
    fn each(self, node: u32, mut each: impl FnMut(u32, (i32, i32), u32)) {
        let place = self.lattice.place(node);
        let rows = self.lattice.around(place);
        let is_free = |dx: i32, dy: i32| rows[(dy + 1).cast_unsigned() as usize] >> (dx + 1) & 1 == 1;
        for (dx, dy) in STEPS {
            if is_free(dx, dy) && is_free(dx, 0) && is_free(0, dy) {
                let next = (place.0 + dx, place.1 + dy);
                let other = self.lattice.node(next.0.cast_unsigned(), next.1.cast_unsigned());
                each(other, next, if dx != 0 && dy != 0 { DIAGONAL } else { STRAIGHT });
            }
        }
    }

    /// Whether a way may lead by a node.
    fn is_allowed(self, node: u32) -> bool {
        (self.is_allowed)(self.lattice.point(node))
    }

    /// Who stands near a node.
    fn near(&self, node: u32) -> &[Standing] {
        self.crowd.near(self.lattice.tile(self.lattice.place(node)))
    }

    /// Whether a crowd leaves a step clear: what [`Crowd::is_clear`] says. No point of a step is farther along an axis than half a tile
    /// from the tile of either end, so that whoever is too near to the step is listed with both.
    fn is_clear(self, from: u32, to: u32, near: &[Standing]) -> bool {
        if near.is_empty() {
            return true;
        }
        let line: Segment = Segment::new(self.lattice.point(from), self.lattice.point(to));
        !near.iter().any(|standing| standing.is_hit_by(&line))
    }
}

impl Memory {
    /// Looks for the shortest way from the start, and at the same time back from the goal, until both meet: whichever is closed in by a
    /// crowd is often closed in narrowly.
    fn search(
        &mut self,
        steps: Steps<'_, impl Fn(DVec2) -> bool + Copy>,
        (from, starts): (DVec2, &[u32]),
        goals: &[u32],
    ) -> Option<Vec<u32>> {
        let lattice = steps.lattice;
        self.known.resize(lattice.nodes(), Known::default());
        self.number += 1;
        self.queue.clear();
        let target = lattice.place(*goals.first()?);
        for &node in starts {
            let cost = lattice.cost_of(lattice.point(node).distance(from));
            self.reach(node, (cost, NONE), octile(lattice.place(node), target));
        }
        let mut back = self.begin_back(goals);
        while let Some(Reverse(entry)) = self.queue.pop() {
            let (whole, rest, node) = unpack(entry);
            let cost = self.known[node as usize].cost;
            if whole - rest != cost {
                continue;
            }
            if goals.contains(&node) {
                return Some(self.trace(node));
            }
            // Where the goal is not closed in narrowly, it may be looked at more slowly.
            let is_narrow = self.expanded < BACK_AT_ONCE;
            if back == Back::Open && (is_narrow || self.expanded.is_multiple_of(BACK_SELDOM)) {
                back = self.go_back(steps);
            }
            if back == Back::Closed {
                return None;
            }
            self.expanded += 1;
            let near = steps.near(node);
            steps.each(node, |other, place, step| {
                let cost = cost + step;
                let known = self.known[other as usize];
                let is_better = (known.search != self.number || cost < known.cost) && steps.is_allowed(other);
                if is_better && steps.is_clear(node, other, near) {
                    self.reach(other, (cost, node), octile(place, target));
                    if known.leads == self.number {
                        back = Back::Met;
                    }
                }
            });
        }
        None
    }

    /// Notes a way from the start to a node, and the least cost of the rest.
    fn reach(&mut self, node: u32, (cost, before): (u32, u32), rest: u32) {
        let known = &mut self.known[node as usize];
        (known.search, known.cost, known.before) = (self.number, cost, before);
        self.queue.push(Reverse(pack(cost + rest, rest, node)));
    }

    /// Begins to look from where there is a way to the goal.
    fn begin_back(&mut self, goals: &[u32]) -> Back {
        self.leading.clear();
        let mut back = Back::Open;
        for &goal in goals {
            back = self.lead(goal, back);
        }
        back
    }

    /// Looks at one node more from which there is a way to the goal.
    fn go_back(&mut self, steps: Steps<'_, impl Fn(DVec2) -> bool + Copy>) -> Back {
        let Some(node) = self.leading.pop() else { return Back::Closed };
        self.expanded += 1;
        let near = steps.near(node);
        let mut back = Back::Open;
        steps.each(node, |other, _, _| {
            let is_new = self.known[other as usize].leads != self.number && steps.is_allowed(other);
            if is_new && steps.is_clear(other, node, near) {
                back = self.lead(other, back);
            }
        });
        back
    }

    /// Notes that there is a way from a node to the goal.
    fn lead(&mut self, node: u32, back: Back) -> Back {
        let known = &mut self.known[node as usize];
        known.leads = self.number;
        self.leading.push(node);
        if known.search == self.number { Back::Met } else { back }
    }

    fn trace(&self, goal: u32) -> Vec<u32> {
        let mut way = vec![goal];
        let mut node = goal;
        while self.known[node as usize].before != NONE {
            node = self.known[node as usize].before;
            way.push(node);
        }
        way.reverse();
        way
    }
}

/// An entry of the queue as one number that is compared at once.
fn pack(whole: u32, rest: u32, node: u32) -> u128 {
    u128::from(whole) << 64 | u128::from(rest) << 32 | u128::from(node)
}

#[expect(clippy::cast_possible_truncation, reason = "each part has 32 bits")]
fn unpack(entry: u128) -> (u32, u32, u32) {
    ((entry >> 64) as u32, (entry >> 32) as u32, entry as u32)
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use maniple_tilemap::TileMap;

    use super::*;
    use crate::tests::{Dice, scattered, slanted};

    const RADIUS: f64 = 0.35;

    /// Lattices of whole tiles and of halves, with many who rest on them.
    fn each_crowd(mut check: impl FnMut(&str, &TileMap, &Ground, &Crowd, &mut Dice)) {
        for seed in 0..40 {
            let mut dice = Dice(seed);
            let side = 8 + u32::try_from(seed).unwrap() % 9;
            let map = if seed % 3 == 0 { slanted(&mut dice, side) } else { scattered(&mut dice, side, 0.1) };
            let ground = Ground::new(&map, RADIUS).unwrap();
            let mut crowd = Crowd::new();
            for number in 0..(side * side / 10) as usize {
                crowd.insert(number, dice.point(&map), RADIUS + [0.2, 0.35, 1.3][number % 3]);
            }
            check(&format!("seed {seed}"), &map, &ground, &crowd, &mut dice);
        }
    }

    /// The slow twin: the nodes to which steps lead from others, of which it is said whether they are clear.
    fn flood(
        steps: Steps<'_, impl Fn(DVec2) -> bool + Copy>,
        from: &[u32],
        is_clear: impl Fn(DVec2, DVec2) -> bool,
    ) -> BTreeSet<u32> {
        let (mut found, mut next): (BTreeSet<u32>, Vec<u32>) =
            (from.iter().copied().collect(), from.to_vec());
        while let Some(node) = next.pop() {
            steps.each(node, |other, _, _| {
                let is_open = is_clear(steps.lattice.point(node), steps.lattice.point(other));
                if is_open && found.insert(other) {
                    next.push(other);
                }
            });
        }
        found
    }

    #[test]
    fn a_step_is_clear_if_and_only_if_the_straight_way_is() {
        let (mut clear, mut blocked) = (0, 0);
        each_crowd(|name, _, ground, crowd, _| {
            let steps = Steps { lattice: &ground.lattice, crowd, is_allowed: |_| true };
            for node in (0..).take(ground.lattice.nodes()) {
                steps.each(node, |other, _, _| {
                    let is_clear = steps.is_clear(node, other, steps.near(node));
                    let (from, to) = (ground.lattice.point(node), ground.lattice.point(other));
                    assert_eq!(is_clear, crowd.is_clear(from, to), "{name}: {from} to {to}");
                    assert_eq!(
                        is_clear,
                        steps.is_clear(node, other, steps.near(other)),
                        "{name}: {from} to {to}"
                    );
                    *(if is_clear { &mut clear } else { &mut blocked }) += 1;
                });
            }
        });
        assert!(clear > 1000 && blocked > 1000, "{clear} {blocked}");
    }

    #[test]
    fn there_is_a_way_if_and_only_if_a_flood_finds_one() {
        let (mut open, mut closed) = (0, 0);
        each_crowd(|name, map, ground, crowd, dice| {
            let mut detours = Detours::new(ground);
            for _ in 0..60 {
                let (from, to) = (dice.place(map, ground), dice.place(map, ground));
                let (lattice, walls) = (&ground.lattice, &ground.walls);
                let (mut starts, mut goals) = (Vec::new(), Vec::new());
                lattice.access(walls, from, &mut starts);
                lattice.access(walls, to, &mut goals);
                starts.retain(|&node| crowd.is_clear(from, lattice.point(node)));
                goals.retain(|&node| crowd.is_clear(lattice.point(node), to));
                let steps = Steps { lattice, crowd, is_allowed: |_| true };
                let found = flood(steps, &starts, |from, to| crowd.is_clear(from, to));
                let leading = flood(steps, &goals, |to, from| crowd.is_clear(from, to));
                let is_straight = walls.is_clear(from, to) && crowd.is_clear(from, to);
                let is_open = is_straight || goals.iter().any(|goal| found.contains(goal));
                let path = detours.path(crowd, from, to).unwrap();
                assert_eq!(path.is_some(), is_open, "{name}: {from} to {to}");
                *(if is_open { &mut open } else { &mut closed }) += 1;
                // Where one end is closed in narrowly, it is not looked everywhere.
                let least = found.len().min(leading.len());
                assert!(is_open || detours.expanded() <= 2 * least + 1, "{name}: {from} to {to}");
            }
        });
        assert!(open > 300 && closed > 300, "{open} {closed}");
    }
}
