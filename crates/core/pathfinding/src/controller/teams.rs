//! Who may go where: units in groups, and the goals of each.

use std::ops::Range;

use glam::DVec2;

use crate::release::{Goals, Group};

/// Units that share goals, by their places and by those of the goals.
#[derive(Clone, Debug)]
pub(crate) struct Team {
    pub(crate) units: Range<usize>,
    pub(crate) goals: Range<usize>,
    pub(crate) whose: Goals,
}

/// All units and goals, team after team.
#[derive(Clone, Debug)]
pub(crate) struct Teams {
    pub(crate) goals: Vec<DVec2>,
    pub(crate) teams: Vec<Team>,
}

impl Teams {
    /// Returns the one team of all units there will be.
    pub(crate) fn one(goals: Vec<DVec2>) -> Self {
        let team = Team { units: 0..usize::MAX, goals: 0..goals.len(), whose: Goals::Interchangeable };
        Self { goals, teams: vec![team] }
    }

    /// Returns a team for each group.
    pub(crate) fn of_groups(groups: &[Group]) -> Self {
        let mut all = Self { goals: Vec::new(), teams: Vec::new() };
        let mut first = 0;
        for group in groups {
            let units = first..first + group.starts.len();
            let goals = all.goals.len()..all.goals.len() + group.goals.len();
            first = units.end;
            all.goals.extend(&group.goals);
            all.teams.push(Team { units, goals, whose: group.whose });
        }
        all
    }

    /// Returns a team for each unit, with one goal.
    pub(crate) fn of_each(goals: Vec<DVec2>) -> Self {
        let team = |index| Team { units: index..index + 1, goals: index..index + 1, whose: Goals::Own };
        let teams = (0..goals.len()).map(team).collect();
        Self { goals, teams }
    }
}

impl Team {
    /// Those of some units, in their order, that are of the team.
    pub(crate) fn members_of<'a>(&self, units: &'a [usize]) -> &'a [usize] {
        part(units, &self.units)
    }

    /// Those of some goals, in their order, that are of the team.
    pub(crate) fn part_of<'a>(&self, goals: &'a [usize]) -> &'a [usize] {
        part(goals, &self.goals)
    }
}

/// The numbers, in their order, that are in a range.
fn part<'a>(sorted: &'a [usize], range: &Range<usize>) -> &'a [usize] {
    let end = |limit: usize| sorted.partition_point(|&number| number < limit);
    &sorted[end(range.start)..end(range.end)]
}
