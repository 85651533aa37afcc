//! Who may go where: units in groups, and the goals of each.

use std::ops::Range;

use glam::DVec2;

use crate::release::{Goals, Group};

/// Units that share goals, by their places and by those of the goals.
#[derive(Clone, Debug)]
pub(crate) struct Squad {
    pub(crate) units: Range<usize>,
    pub(crate) goals: Range<usize>,
    pub(crate) whose: Goals,
}

/// All units and goals, squad after squad.
#[derive(Clone, Debug)]
pub(crate) struct Squads {
    pub(crate) goals: Vec<DVec2>,
    pub(crate) squads: Vec<Squad>,
}

impl Squads {
    /// Returns the one squad of all units there will be.
    pub(crate) fn one(goals: Vec<DVec2>) -> Self {
        let squad = Squad { units: 0..usize::MAX, goals: 0..goals.len(), whose: Goals::Interchangeable };
        Self { goals, squads: vec![squad] }
    }

    /// Returns a squad for each group.
    pub(crate) fn of_groups(groups: &[Group]) -> Self {
        let mut all = Self { goals: Vec::new(), squads: Vec::new() };
        let mut first = 0;
        for group in groups {
            let units = first..first + group.starts.len();
            let goals = all.goals.len()..all.goals.len() + group.goals.len();
            first = units.end;
            all.goals.extend(&group.goals);
            all.squads.push(Squad { units, goals, whose: group.whose });
        }
        all
    }

    /// Returns a squad for each unit, with one goal.
    pub(crate) fn of_each(goals: Vec<DVec2>) -> Self {
        let squad = |index| Squad { units: index..index + 1, goals: index..index + 1, whose: Goals::Own };
        let squads = (0..goals.len()).map(squad).collect();
        Self { goals, squads }
    }
}

impl Squad {
    /// Those of some units, in their order, that are of the squad.
    pub(crate) fn members_of<'a>(&self, units: &'a [usize]) -> &'a [usize] {
        part(units, &self.units)
    }

    /// Those of some goals, in their order, that are of the squad.
    pub(crate) fn part_of<'a>(&self, goals: &'a [usize]) -> &'a [usize] {
        part(goals, &self.goals)
    }
}

/// The numbers, in their order, that are in a range.
fn part<'a>(sorted: &'a [usize], range: &Range<usize>) -> &'a [usize] {
    let end = |limit: usize| sorted.partition_point(|&number| number < limit);
    &sorted[end(range.start)..end(range.end)]
}
