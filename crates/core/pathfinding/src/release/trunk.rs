//! The way that a group shares: from its middle to the middle of its goals, once for each lane.

use glam::DVec2;

use super::lanes::Lanes;
use crate::error::PlanError;
use crate::ground::Ground;
use crate::planner::{Planner, length};

/// The shared way, and who goes where on it.
#[derive(Clone, Debug)]
pub(crate) struct Trunk {
    pub(crate) lanes: Lanes,
    /// For each lane the points of the way.
    ways: Vec<Vec<DVec2>>,
    /// Where in each way the first and the last cut are; `None` where nothing is narrow.
    ends: Option<Vec<(usize, usize)>>,
}

impl Trunk {
    /// Returns the shared way from one point to another for circles whose middles keep `reach` from each other.
    pub(crate) fn new(
        ground: &Ground,
        planner: &mut Planner<'_>,
        (from, to): (DVec2, DVec2),
        reach: f64,
    ) -> Result<Self, PlanError> {
        let legs = planner.path(from, to)?.to_vec();
        let lanes = Lanes::new(ground, from, &legs, reach);
        let mut ways = Vec::new();
        let mut ends = Vec::new();
        for lane in 0..lanes.count {
            let mut way = vec![from];
            let (mut first, mut last) = (None, 0);
            for point in lanes.points(lane) {
                way.extend(planner.path(way[way.len() - 1], point)?);
                last = way.len() - 1;
                first = first.or(Some(last));
            }
            way.extend(planner.path(way[way.len() - 1], to)?);
            ends.extend(first.map(|first| (first, last)));
            ways.push(way);
        }
        let ends = (!ends.is_empty()).then_some(ends);
        Ok(Self { lanes, ways, ends })
    }

    /// Returns whether the shared way is one straight leg, in which nothing is narrow.
    pub(crate) fn is_straight(&self) -> bool {
        self.ends.is_none() && self.ways[0].len() <= 2
    }

    /// Returns the way of one circle by a lane: onto the shared way as far ahead as it sees it, and off it as early as it sees
    /// its goal; but through every cut.
    pub(crate) fn way(
        &self,
        planner: &mut Planner<'_>,
        lane: usize,
        (from, to): (DVec2, DVec2),
    ) -> Result<Vec<DVec2>, PlanError> {
        let way = &self.ways[lane];
        let Some((first, last)) = self.ends.as_ref().map(|ends| ends[lane]) else {
            return Ok(self.free_way(planner, (from, to))?);
        };
        let ground = planner.ground();
        let entry = (0..=first).rev().find(|&index| ground.is_clear(from, way[index]));
        let exit = (last..way.len()).find(|&index| ground.is_clear(way[index], to));
        let mut legs = match entry {
            Some(entry) => way[entry..=first].to_vec(),
            None => planner.path(from, way[first])?.to_vec(),
        };
        legs.extend_from_slice(&way[first + 1..=last]);
        match exit {
            Some(exit) => legs.extend_from_slice(&way[last + 1..=exit]),
            None => {
                legs.extend_from_slice(planner.path(way[last], to)?);
                return Ok(legs);
            }
        }
        legs.push(to);
        Ok(legs)
    }

    /// The way where nothing is narrow: straight ahead, by the shared way, or a way of its own.
    fn free_way(&self, planner: &mut Planner<'_>, (from, to): (DVec2, DVec2)) -> Result<Vec<DVec2>, PlanError> {
        let (way, ground) = (&self.ways[0], planner.ground());
        if ground.is_clear(from, to) {
            return Ok(vec![to]);
        }
        let entry = (0..way.len()).rev().find(|&index| ground.is_clear(from, way[index]));
        let exit = (0..way.len()).find(|&index| ground.is_clear(way[index], to));
        if let (Some(entry), Some(exit)) = (entry, exit)
            && entry <= exit
        {
            let mut legs = way[entry..=exit].to_vec();
            legs.push(to);
            return Ok(legs);
        }
        Ok(planner.path(from, to)?.to_vec())
    }

    /// Returns how far it is for a circle to the first cut, in world units; to the end of the way where nothing is narrow.
    pub(crate) fn distance_to_cut(&self, planner: &mut Planner<'_>, from: DVec2) -> Result<f64, PlanError> {
        let way = &self.ways[self.lanes.count / 2];
        let first = self.ends.as_ref().map_or(way.len() - 1, |ends| ends[self.lanes.count / 2].0);
        let ground = planner.ground();
        match (0..=first).rev().find(|&index| ground.is_clear(from, way[index])) {
            Some(entry) => Ok(length(from, &way[entry..=first])),
            None => Ok(length(from, planner.path(from, way[first])?)),
        }
    }

    /// Returns how far a goal is from the last cut, in world units; from the beginning of the way where nothing is narrow.
    pub(crate) fn distance_from_cut(&self, planner: &mut Planner<'_>, to: DVec2) -> Result<f64, PlanError> {
        let way = &self.ways[self.lanes.count / 2];
        let last = self.ends.as_ref().map_or(0, |ends| ends[self.lanes.count / 2].1);
        let ground = planner.ground();
        match (last..way.len()).find(|&index| ground.is_clear(way[index], to)) {
            Some(exit) => Ok(length(way[last], &way[last + 1..=exit]) + way[exit].distance(to)),
            None => Ok(length(way[last], planner.path(way[last], to)?)),
        }
    }
}
