//! The way that a group shares: from its middle to the middle of its goals, once for each lane.

use glam::DVec2;

use super::assign::Sight;
use super::bundle::Bundle;
use super::fan::{Gate, Mouth, fan};
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
    /// How long the way is in the middle, in world units.
    pub(crate) length: f64,
    /// Whether all go around corners, in one track.
    pub(crate) has_turns: bool,
    /// For each lane how it goes on before the first cut, and behind the last one; none where lanes do not fan out.
    entries: Vec<Mouth>,
    exits: Vec<Mouth>,
}

impl Trunk {
    /// Returns the shared way from one point to another, of which `lanes_of` says the lanes.
    pub(crate) fn new(
        planner: &mut Planner<'_>,
        (from, to): (DVec2, DVec2),
        lanes_of: impl FnOnce(&[DVec2]) -> Lanes,
    ) -> Result<Self, PlanError> {
        let path: Vec<DVec2> = std::iter::once(from).chain(planner.path(from, to)?.iter().copied()).collect();
        let (length, has_turns) = (length(from, &path[1..]), path.len() > 2);
        let lanes = lanes_of(&path);
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
        Ok(Self { lanes, ways, ends, length, has_turns, entries: Vec::new(), exits: Vec::new() })
    }

    /// Returns the shared way by a bundle of lanes, from one point to another.
    pub(crate) fn of_bundle((from, to): (DVec2, DVec2), bundle: Bundle) -> Self {
        let (lanes, length) = (Lanes::of_bundle(&bundle), bundle.length());
        let ends = bundle.lanes.iter().map(|lane| (1, lane.len())).collect();
        let way = |lane: Vec<DVec2>| std::iter::once(from).chain(lane).chain([to]).collect();
        let ways = bundle.lanes.into_iter().map(way).collect();
        Self {
            lanes,
            ways,
            ends: Some(ends),
            length,
            has_turns: false,
            entries: Vec::new(),
            exits: Vec::new(),
        }
    }

    /// Lets the lanes of a narrow place fan out, towards the starts and the goals of those who take each lane; `reach` is how far the middles
    /// of two circles are apart at least.
    pub(crate) fn fan_out(
        &mut self,
        ground: &Ground,
        (starts, goals): (Vec<Vec<DVec2>>, Vec<Vec<DVec2>>),
        reach: f64,
    ) {
        let mouths = |far_ends: Vec<Vec<DVec2>>, gate_of: &dyn Fn(usize) -> Gate| {
            let lanes: Vec<_> =
                far_ends.into_iter().enumerate().map(|(lane, ends)| (gate_of(lane), ends)).collect();
            fan(ground, &lanes, reach)
        };
        self.entries = mouths(starts, &|lane| {
            let (way, (first, last)) = (&self.ways[lane], self.ends(lane));
            let inwards =
                if first < last { (way[first + 1] - way[first]).normalize() } else { self.forwards() };
            Gate { point: way[first], outwards: -inwards }
        });
        self.exits = mouths(goals, &|lane| {
            let (way, (first, last)) = (&self.ways[lane], self.ends(lane));
            let outwards =
                if first < last { (way[last] - way[last - 1]).normalize() } else { self.forwards() };
            Gate { point: way[last], outwards }
        });
    }

    /// The direction in which the first cut is passed, a unit vector.
    ///
    /// # Panics
    /// Where nothing is narrow.
    fn forwards(&self) -> DVec2 {
        self.lanes.first().expect("there is a narrow place").forwards()
    }

    /// Returns the legs of a circle to the last cut by a lane: through the mouth of the lane, or onto the shared way as far ahead as it sees it.
    ///
    /// # Panics
    /// Where nothing is narrow.
    pub(crate) fn entry(
        &self,
        planner: &mut Planner<'_>,
        lane: usize,
        from: DVec2,
    ) -> Result<Vec<DVec2>, PlanError> {
        let (way, (first, last)) = (&self.ways[lane], self.ends(lane));
        let ground = planner.ground();
        let seen = (1..=first).rev().find(|&index| ground.is_clear(from, way[index]));
        let mouth = self.entries.get(lane).filter(|_| seen.is_none_or(|seen| seen == first));
        let turns = mouth.and_then(|mouth| mouth.turns(ground, from));
        let mut legs = match (turns, seen) {
            (Some(turns), _) => turns.into_iter().rev().collect(),
            (None, Some(entry)) => way[entry..=first].to_vec(),
            (None, None) => planner.path(from, way[first])?.to_vec(),
        };
        legs.extend_from_slice(&way[first + 1..=last]);
        Ok(legs)
    }

    /// Returns the legs of a circle from the last cut by a lane to a goal: through the mouth of the lane, or off the shared way as early as it sees the goal.
    ///
    /// # Panics
    /// Where nothing is narrow.
    pub(crate) fn exit(
        &self,
        planner: &mut Planner<'_>,
        lane: usize,
        to: DVec2,
    ) -> Result<Vec<DVec2>, PlanError> {
        let (way, (_, last)) = (&self.ways[lane], self.ends(lane));
        let ground = planner.ground();
        let seen = (last..way.len() - 1).find(|&index| ground.is_clear(way[index], to));
        let mouth = self.exits.get(lane).filter(|_| seen.is_none_or(|seen| seen == last));
        let turns = mouth.and_then(|mouth| mouth.turns(ground, to));
        let mut legs = match (turns, seen) {
            (Some(turns), _) => turns[1..].to_vec(),
            (None, Some(exit)) => way[last + 1..=exit].to_vec(),
            (None, None) => return Ok(planner.path(way[last], to)?.to_vec()),
        };
        legs.push(to);
        Ok(legs)
    }

    /// Where the last cut is passed by a lane.
    ///
    /// # Panics
    /// Where nothing is narrow.
    pub(crate) fn gate(&self, lane: usize) -> DVec2 {
        self.ways[lane][self.ends(lane).1]
    }

    fn ends(&self, lane: usize) -> (usize, usize) {
        self.ends.as_ref().expect("there is a narrow place")[lane]
    }

    /// How far it is from the first cut to the last one, in world units.
    pub(crate) fn length_of_cuts(&self) -> f64 {
        let way = &self.ways[self.lanes.count / 2];
        self.ends.as_ref().map_or(0.0, |ends| {
            let (first, last) = ends[self.lanes.count / 2];
            length(way[first], &way[first + 1..=last])
        })
    }

    /// Returns whether all go in lanes: through a narrow place, or side by side.
    pub(crate) fn has_lanes(&self) -> bool {
        self.ends.is_some()
    }

    /// Returns the legs of a circle where nothing is narrow: straight ahead, by the shared way, or a way of its own.
    pub(crate) fn way(
        &self,
        planner: &mut Planner<'_>,
        (from, to): (DVec2, DVec2),
    ) -> Result<Vec<DVec2>, PlanError> {
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

    /// Returns a start as it is seen from the first cut; from the end of the way where nothing is narrow.
    pub(crate) fn sight_of_start(&self, planner: &mut Planner<'_>, from: DVec2) -> Result<Sight, PlanError> {
        let lane = self.lanes.count / 2;
        let way = &self.ways[lane];
        let first = self.ends.as_ref().map_or(way.len() - 1, |ends| ends[lane].0);
        let ground = planner.ground();
        let distance = match (1..=first).rev().find(|&index| ground.is_clear(from, way[index])) {
            Some(entry) => length(from, &way[entry..=first]),
            None => length(from, planner.path(from, way[first])?),
        };
        Ok(Sight { distance, bearing: self.lanes.first().map_or(0.0, |cut| cut.bearing(from)) })
    }

    /// Returns a goal as it is seen from the last cut; from the beginning of the way where nothing is narrow.
    pub(crate) fn sight_of_goal(&self, planner: &mut Planner<'_>, to: DVec2) -> Result<Sight, PlanError> {
        let lane = self.lanes.count / 2;
        let way = &self.ways[lane];
        let last = self.ends.as_ref().map_or(0, |ends| ends[lane].1);
        let ground = planner.ground();
        let distance = match (last..way.len() - 1).find(|&index| ground.is_clear(way[index], to)) {
            Some(exit) => length(way[last], &way[last + 1..=exit]) + way[exit].distance(to),
            None => length(way[last], planner.path(way[last], to)?),
        };
        Ok(Sight { distance, bearing: self.lanes.last().map_or(0.0, |cut| cut.bearing(to)) })
    }
}
