//! A goal that those who have arrived close in: one of them takes it, and leaves its own to who is left.

use glam::DVec2;

use super::{Departures, GOALS};
use crate::planner::Planner;
use crate::release::ends::Ends;
use crate::release::error::ReleaseError;
use crate::release::releasing::Tools;
use crate::release::traffic::Planned;
use crate::release::trajectory::Trajectory;
use crate::work::{PATH, Work};

/// How many of those around a goal are asked to take it, and for how many of those who are left.
const ASKED_MAX: usize = 8;
const LEFT_MAX: usize = 4;

/// How many exchanges there are to be tried.
pub(super) const EXCHANGES_MAX: usize = ASKED_MAX * LEFT_MAX;

/// Somebody whose plan stands, by the numbers of its start and its goal, and its place in the traffic.
#[derive(Clone, Copy, Debug)]
pub(super) struct Departed {
    pub(super) start: usize,
    pub(super) goal: usize,
    pub(super) place: usize,
}

/// A plan that is made for one of two.
struct Made {
    departed: Departed,
    planned: Planned,
}

impl Departures {
    /// Lets one of those who have arrived around a goal of somebody who is left take that goal, and leave its own to it, if both find a
    /// departure among all others. Each turn asks another one for another of the first who are left.
    pub(super) fn exchange(
        &mut self,
        tools: &mut Tools<'_>,
        ends: &Ends,
        turn: usize,
        work: &mut Work,
    ) -> Result<(), ReleaseError> {
        let Some(&number) = self.order.first(LEFT_MAX).get(turn / ASKED_MAX) else { return Ok(()) };
        let start = &ends.starts[number];
        let Some(&closed) = self.order.goals(start.stream).first() else { return Ok(()) };
        let point = ends.goals[closed].point;
        let is_of_group = |departed: &&Departed| {
            self.is_interchangeable[start.group] && ends.starts[departed.start].group == start.group
        };
        let mut near: Vec<Departed> = self.departed.iter().filter(is_of_group).copied().collect();
        let distance = |departed: &Departed| ends.goals[departed.goal].point.distance_squared(point);
        near.sort_by(|a, b| distance(a).total_cmp(&distance(b)).then(a.place.cmp(&b.place)));
        match near.get(turn % ASKED_MAX) {
            Some(&departed) => self.exchange_with(tools, ends, (number, closed, departed), work),
            None => Ok(()),
        }
    }

    fn exchange_with(
        &mut self,
        tools: &mut Tools<'_>,
        ends: &Ends,
        (number, closed, departed): (usize, usize, Departed),
        work: &mut Work,
    ) -> Result<(), ReleaseError> {
        let (start, other) = (&ends.starts[number], &ends.starts[departed.start]);
        let (closed_point, left_point) = (ends.goals[closed].point, ends.goals[departed.goal].point);
        let mut traffic = self.traffic.without(departed.place);
        let trajectory = &self.traffic.planned(departed.place).trajectory;
        // Up to its last turn the other goes as it did.
        let turns: Vec<DVec2> = trajectory.legs().iter().map(|leg| leg.stretch.end).collect();
        let kept = &turns[..turns.len().saturating_sub(1)];
        let goes_on = legs_to(&mut tools.planner, (other.point, kept), closed_point)?;
        let goes = legs_to(&mut tools.planner, (start.point, &start.legs), left_point)?;
        work.add(2 * PATH + self.departed.len() as u64);
        let mut made = Vec::new();
        for (number, goal, legs) in [(departed.start, closed, goes_on), (number, departed.goal, goes)] {
            let from = ends.starts[number].point;
            let trajectory = Trajectory::new(from, &legs, self.speed);
            let is_over_waiting =
                |&waiting: &usize| trajectory.leads_over(ends.starts[waiting].point, tools.reach());
            let waiting = self.order.first(usize::MAX);
            if waiting.iter().filter(|&&waiting| waiting != number).any(is_over_waiting) {
                return Ok(());
            }
            let before = traffic.looks;
            let departure = traffic.earliest(&trajectory, None);
            work.add(traffic.looks - before);
            let Some(departure) = departure else { return Ok(()) };
            let planned = Planned { trajectory, departure, radius: tools.ground.radius() };
            let place = traffic.push(planned.clone());
            made.push(Made { departed: Departed { start: number, goal, place }, planned });
        }
        self.traffic = traffic;
        self.never.clear();
        self.departed.retain(|other| other.start != departed.start);
        for other in &mut self.departed {
            other.place -= usize::from(other.place > departed.place);
        }
        for Made { departed, planned } in made {
            self.note(ends, departed, &planned);
        }
        self.crowd.remove(number, start.point, tools.reach());
        self.crowd.insert(GOALS + closed, closed_point, tools.reach());
        self.order.leave(ends, (number, closed));
        (self.detours_tried, self.exchanges_tried) = (0, 0);
        Ok(())
    }
}

/// Returns legs from a point, and on from the last of them to a goal.
fn legs_to(
    planner: &mut Planner<'_>,
    (from, legs): (DVec2, &[DVec2]),
    goal: DVec2,
) -> Result<Vec<DVec2>, ReleaseError> {
    let last = legs.last().copied().unwrap_or(from);
    let mut whole = legs.to_vec();
    whole.extend_from_slice(planner.path(last, goal)?);
    Ok(whole)
}
