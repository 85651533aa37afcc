//! Who goes next.

use glam::DVec2;

use super::schedule::Unit;
use super::trajectory::Trajectory;

/// Who has not left, and what stands in whose way.
#[derive(Clone, Debug)]
pub(crate) struct Order {
    /// By number, in the order in which they go if they can.
    waiting: Vec<usize>,
    /// For each circle and each of its ways how many circles of its own group that wait stand in it, and of others.
    blocked: Vec<Vec<(u32, u32)>>,
    /// For each circle the ways that it stands in.
    stands_in: Vec<Vec<(usize, usize)>>,
    /// For each circle how many waiting ones have all their ways over its goal.
    covered: Vec<u32>,
    /// For each circle the circles over whose goals all its ways lead.
    covers: Vec<Vec<usize>>,
}

impl Order {
    /// Returns the order of circles that are sorted by who should go first; `reach` is how far two middles are apart at least.
    pub(crate) fn new(units: &[Unit], reach: f64) -> Self {
        let count = units.len();
        let mut order = Self {
            waiting: (0..count).collect(),
            blocked: units.iter().map(|unit| vec![(0, 0); unit.ways.len()]).collect(),
            stands_in: vec![Vec::new(); count],
            covered: vec![0; count],
            covers: vec![Vec::new(); count],
        };
        for (number, unit) in units.iter().enumerate() {
            for (other, standing) in units.iter().enumerate() {
                if other == number {
                    continue;
                }
                let point = standing.ways[0].start();
                for (way, trajectory) in unit.ways.iter().enumerate() {
                    if leads_over(trajectory, point, reach) {
                        let blocked = &mut order.blocked[number][way];
                        let is_own = standing.group == unit.group;
                        *(if is_own { &mut blocked.0 } else { &mut blocked.1 }) += 1;
                        order.stands_in[other].push((number, way));
                    }
                }
                if unit.ways.iter().all(|way| leads_over(way, standing.goal, reach)) {
                    order.covered[other] += 1;
                    order.covers[number].push(other);
                }
            }
        }
        order
    }

    /// Returns who goes next, and by which of its ways it can; `None` where all have left.
    ///
    /// That is the first whose way is free of those who wait, and whose goal is in nobody's way; else the first whose way is
    /// free; else the first whose own group leaves it a way, since others may leave in time; else simply the first.
    pub(crate) fn next(&self, units: &[Unit]) -> Option<(usize, Vec<usize>)> {
        let all = |number: usize| (0..units[number].ways.len()).collect::<Vec<_>>();
        let ways = |number: usize, is_open: fn(&(u32, u32)) -> bool| {
            let ways = all(number).into_iter();
            ways.filter(|&way| is_open(&self.blocked[number][way])).collect::<Vec<_>>()
        };
        let is_free: fn(&(u32, u32)) -> bool = |&(own, others)| own == 0 && others == 0;
        let is_free_of_own: fn(&(u32, u32)) -> bool = |&(own, _)| own == 0;
        let find = |is_open, may_cover: bool| {
            self.waiting.iter().find_map(|&number| {
                let is_harmless = may_cover || self.covered[number] == 0;
                let ways = if is_harmless { ways(number, is_open) } else { Vec::new() };
                (!ways.is_empty()).then_some((number, ways))
            })
        };
        find(is_free, false)
            .or_else(|| find(is_free, true))
            .or_else(|| find(is_free_of_own, true))
            .or_else(|| self.waiting.first().map(|&number| (number, all(number))))
    }

    /// Notes that a circle has left.
    pub(crate) fn leave(&mut self, units: &[Unit], number: usize) {
        self.waiting.retain(|&waiting| waiting != number);
        for &(other, way) in &self.stands_in[number] {
            let blocked = &mut self.blocked[other][way];
            let is_own = units[other].group == units[number].group;
            *(if is_own { &mut blocked.0 } else { &mut blocked.1 }) -= 1;
        }
        for &other in &self.covers[number] {
            self.covered[other] -= 1;
        }
    }
}

/// Whether the legs of a trajectory come nearer than `reach` to a point.
fn leads_over(trajectory: &Trajectory, point: DVec2, reach: f64) -> bool {
    trajectory.is_near(point, reach)
}
