//! What a match is about: when it ends, and who has won.

use std::cmp::Reverse;

use maniple_geometry::Cycle;
use maniple_view::{EndReason, Seat, Tally};
use serde::{Deserialize, Serialize};

use crate::scenario::Objective;
use crate::world::{SeatState, State};

/// How a match ended.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Ending {
    /// Who won, in order of the seats; nobody is a draw.
    pub winners: Vec<Seat>,
    /// Why it ended.
    pub reason: EndReason,
    /// The cycles that were played.
    pub cycles: Cycle,
}

/// What a seat still has.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Left {
    pub(crate) units: u32,
    pub(crate) buildings: u32,
}

/// What decides a match, at a moment.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Standing<'a> {
    pub(crate) objective: &'a Objective,
    pub(crate) seats: &'a [SeatState],
    /// In order of the seats.
    pub(crate) left: &'a [Left],
    pub(crate) cycles: Cycle,
    pub(crate) cycles_max: Cycle,
}

/// Returns what each seat still has.
pub(crate) fn left(state: &State) -> Vec<Left> {
    let mut left = vec![Left::default(); state.seats.len()];
    for (_, unit) in state.units.alive() {
        let Some(owner) = unit.owner else { continue };
        let left = &mut left[owner.index()];
        if state.unit_type(unit.unit_type).is_building() {
            left.buildings += 1;
        } else {
            left.units += 1;
        }
    }
    left
}

/// Returns what of a tally counts by an objective: more is better.
pub(crate) fn points(objective: &Objective, tally: &Tally, left: Left) -> u64 {
    match objective {
        Objective::Race { .. } => tally.arrived.into(),
        Objective::Resources { .. } => tally.gathered,
        Objective::Kills => tally.units_destroyed.into(),
        Objective::Buildings => tally.buildings_destroyed.into(),
        Objective::LastStanding | Objective::Survive { .. } => {
            u64::from(left.units) + u64::from(left.buildings)
        }
    }
}

impl Standing<'_> {
    /// Returns how the match has ended; `None` while it goes on.
    ///
    /// Teams that are out count before the objective, and that before the length.
    pub(crate) fn ending(&self) -> Option<Ending> {
        let teams = self.teams();
        let teams_in = self.teams_where(|seat, _| !seat.is_out);
        let reason = if teams_in.is_empty() || (teams_in.len() == 1 && teams.len() > 1) {
            EndReason::Resigned
        } else if self.is_decided(&teams_in) {
            EndReason::Objective
        } else if self.cycles >= self.cycles_max {
            EndReason::Length
        } else {
            return None;
        };
        let winner = match reason {
            EndReason::Resigned => teams_in.first().copied(),
            EndReason::Objective | EndReason::Length => self.winner(reason, &teams_in),
        };
        let winners =
            (0..).map(Seat).zip(self.seats).filter(|(_, seat)| Some(seat.team) == winner && !seat.is_out);
        Some(Ending { winners: winners.map(|(seat, _)| seat).collect(), reason, cycles: self.cycles })
    }

    /// Returns whether the objective is reached.
    fn is_decided(&self, teams_in: &[u16]) -> bool {
        // Alone, a team plays on until it has nothing left.
        let is_last =
            |teams_with: Vec<u16>| teams_with.is_empty() || (teams_with.len() == 1 && teams_in.len() > 1);
        match *self.objective {
            Objective::Race { .. } => {
                self.seats.iter().all(|seat| seat.is_out || seat.tally.arrived == seat.tally.units)
            }
            Objective::Resources { goal } => {
                goal.is_some_and(|goal| teams_in.iter().any(|&team| self.sum(team).points >= u64::from(goal)))
            }
            Objective::Kills | Objective::Buildings | Objective::LastStanding => is_last(self.teams_with()),
            Objective::Survive { team } => !self.teams_with().contains(&team),
        }
    }

    /// Returns the team that has won; `None` is a draw.
    fn winner(&self, reason: EndReason, teams_in: &[u16]) -> Option<u16> {
        let is_over = reason == EndReason::Objective;
        match *self.objective {
            Objective::Survive { team } if is_over => {
                self.best(teams_in.iter().copied().filter(|&it| it != team))
            }
            Objective::Survive { team } => Some(team),
            Objective::LastStanding if !is_over => None,
            Objective::Kills | Objective::Buildings | Objective::LastStanding if is_over => {
                match self.teams_with()[..] {
                    [team] => Some(team),
                    _ => self.best(teams_in.iter().copied()),
                }
            }
            Objective::Race { .. }
            | Objective::Resources { .. }
            | Objective::Kills
            | Objective::Buildings
            | Objective::LastStanding => self.best(teams_in.iter().copied()),
        }
    }

    /// Returns the team with more points, or as many sooner, than each other; `None` where two are equal.
    fn best(&self, teams: impl Iterator<Item = u16>) -> Option<u16> {
        let mut order: Vec<(Sum, u16)> = teams.map(|team| (self.sum(team), team)).collect();
        order.sort_by_key(|(sum, _)| (Reverse(sum.points), sum.late));
        match order[..] {
            [] => None,
            [(_, team)] => Some(team),
            [(first, team), (second, _), ..] => (first != second).then_some(team),
        }
    }

    fn sum(&self, team: u16) -> Sum {
        let mut sum = Sum { points: 0, late: 0 };
        for (seat, left) in self.seats.iter().zip(self.left).filter(|(seat, _)| seat.team == team) {
            sum.points += points(self.objective, &seat.tally, *left);
            match self.objective {
                Objective::Race { .. } => sum.late += seat.tally.arrival_sum,
                Objective::Buildings => sum.late = sum.late.max(seat.tally.last_building.0.into()),
                Objective::Resources { .. }
                | Objective::Kills
                | Objective::LastStanding
                | Objective::Survive { .. } => {}
            }
        }
        sum
    }

    /// Returns the teams that have what the objective is about.
    fn teams_with(&self) -> Vec<u16> {
        self.teams_where(|_, left| match self.objective {
            Objective::Kills => left.units > 0,
            Objective::Buildings => left.buildings > 0,
            Objective::LastStanding
            | Objective::Survive { .. }
            | Objective::Race { .. }
            | Objective::Resources { .. } => left.units + left.buildings > 0,
        })
    }

    fn teams(&self) -> Vec<u16> {
        self.teams_where(|_, _| true)
    }

    fn teams_where(&self, is_meant: impl Fn(&SeatState, &Left) -> bool) -> Vec<u16> {
        let meant = self.seats.iter().zip(self.left).filter(|(seat, left)| is_meant(seat, left));
        let mut teams: Vec<u16> = meant.map(|(seat, _)| seat.team).collect();
        teams.sort_unstable();
        teams.dedup();
        teams
    }
}

/// What a team has achieved.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Sum {
    points: u64,
    /// When; among equals less wins.
    late: u64,
}

#[cfg(test)]
mod tests {
    use super::*;

    const RACE: Objective = Objective::Race { zone_size: 2.0 };

    #[test]
    fn a_race_ends_when_all_have_arrived_and_more_or_sooner_wins() {
        let check = |arrivals: &[(u32, u64); 2],
                     out: &[usize],
                     cycles,
                     expected: Option<EndReason>,
                     winners: &[u16]| {
            let mut seats = [seat(0), seat(1)];
            for (seat, &(arrived, arrival_sum)) in seats.iter_mut().zip(arrivals) {
                seat.tally = Tally { units: 2, arrived, arrival_sum, ..Tally::default() };
            }
            for &place in out {
                seats[place].is_out = true;
            }
            check_ending(&RACE, &seats, &[(2, 0), (2, 0)], cycles, expected, winners);
        };
        let (objective, length, resigned) = (EndReason::Objective, EndReason::Length, EndReason::Resigned);
        check(&[(0, 0), (0, 0)], &[], 10, None, &[]);
        check(&[(0, 0), (0, 0)], &[], 100, Some(length), &[]);
        check(&[(1, 1), (0, 0)], &[], 100, Some(length), &[0]);
        check(&[(1, 1), (1, 1)], &[], 100, Some(length), &[]);
        check(&[(2, 3), (2, 4)], &[], 10, Some(objective), &[0]);
        check(&[(2, 4), (2, 3)], &[], 10, Some(objective), &[1]);
        check(&[(2, 3), (2, 4)], &[0], 10, Some(resigned), &[1]);
        check(&[(0, 0), (0, 0)], &[0, 1], 10, Some(resigned), &[]);
        check(&[(2, 3), (0, 0)], &[], 10, None, &[]);
    }

    #[test]
    fn most_resources_win_at_the_length_and_a_goal_ends_it() {
        let check = |goal, gathered: [u64; 2], cycles, expected: Option<EndReason>, winners: &[u16]| {
            let mut seats = [seat(0), seat(1)];
            for (seat, gathered) in seats.iter_mut().zip(gathered) {
                seat.tally.gathered = gathered;
            }
            check_ending(
                &Objective::Resources { goal },
                &seats,
                &[(1, 1), (1, 1)],
                cycles,
                expected,
                winners,
            );
        };
        check(None, [50, 60], 99, None, &[]);
        check(None, [50, 60], 100, Some(EndReason::Length), &[1]);
        check(None, [60, 60], 100, Some(EndReason::Length), &[]);
        check(Some(60), [59, 59], 99, None, &[]);
        check(Some(60), [59, 60], 50, Some(EndReason::Objective), &[1]);
    }

    #[test]
    fn who_is_left_alone_wins_and_nobody_left_is_decided_by_points() {
        let check = |objective: &Objective,
                     left: [(u32, u32); 2],
                     destroyed: [(u32, u32, u32); 2],
                     cycles,
                     expected: Option<EndReason>,
                     winners: &[u16]| {
            let mut seats = [seat(0), seat(1)];
            for (seat, (units, buildings, last)) in seats.iter_mut().zip(destroyed) {
                seat.tally.units_destroyed = units;
                seat.tally.buildings_destroyed = buildings;
                seat.tally.last_building = Cycle(last);
            }
            check_ending(objective, &seats, &left, cycles, expected, winners);
        };
        let (objective, length) = (EndReason::Objective, EndReason::Length);
        let nothing = [(0, 0, 0); 2];
        check(&Objective::Kills, [(1, 0), (1, 0)], nothing, 9, None, &[]);
        check(&Objective::Kills, [(1, 0), (0, 5)], nothing, 9, Some(objective), &[0]);
        check(&Objective::Kills, [(0, 0), (0, 0)], [(5, 0, 0), (4, 0, 0)], 9, Some(objective), &[0]);
        check(&Objective::Kills, [(0, 0), (0, 0)], [(5, 0, 0), (5, 0, 0)], 9, Some(objective), &[]);
        check(&Objective::Kills, [(9, 0), (1, 0)], [(4, 0, 0), (5, 0, 0)], 100, Some(length), &[1]);
        check(&Objective::Buildings, [(0, 1), (9, 0)], nothing, 9, Some(objective), &[0]);
        check(&Objective::Buildings, [(0, 1), (9, 1)], [(0, 2, 8), (0, 2, 7)], 100, Some(length), &[1]);
        check(&Objective::Buildings, [(0, 1), (9, 1)], [(0, 2, 7), (0, 2, 7)], 100, Some(length), &[]);
        check(&Objective::LastStanding, [(0, 1), (0, 0)], nothing, 9, Some(objective), &[0]);
        check(&Objective::LastStanding, [(7, 1), (1, 0)], nothing, 100, Some(length), &[]);
        check(&Objective::LastStanding, [(0, 0), (0, 0)], nothing, 9, Some(objective), &[]);
        let survive = Objective::Survive { team: 1 };
        check(&survive, [(1, 0), (1, 0)], nothing, 99, None, &[]);
        check(&survive, [(1, 0), (1, 0)], nothing, 100, Some(length), &[1]);
        check(&survive, [(1, 0), (0, 0)], nothing, 9, Some(objective), &[0]);
    }

    #[test]
    fn a_seat_alone_plays_on_until_it_is_done_or_has_nothing_left() {
        let mut alone = [seat(0)];
        alone[0].tally.units = 1;
        check_ending(&RACE, &alone, &[(1, 0)], 9, None, &[]);
        check_ending(&Objective::Kills, &alone, &[(1, 0)], 9, None, &[]);
        check_ending(&Objective::Kills, &alone, &[(0, 0)], 9, Some(EndReason::Objective), &[0]);
        check_ending(&Objective::LastStanding, &alone, &[(1, 0)], 100, Some(EndReason::Length), &[]);
        let survive = Objective::Survive { team: 0 };
        check_ending(&survive, &alone, &[(1, 0)], 100, Some(EndReason::Length), &[0]);
        check_ending(&survive, &alone, &[(0, 0)], 9, Some(EndReason::Objective), &[]);
        alone[0].tally.arrived = 1;
        check_ending(&RACE, &alone, &[(1, 0)], 9, Some(EndReason::Objective), &[0]);
        alone[0].is_out = true;
        check_ending(&RACE, &alone, &[(0, 0)], 9, Some(EndReason::Resigned), &[]);
    }

    #[test]
    fn a_team_wins_and_loses_together() {
        let mut seats = [seat(0), seat(1), seat(0)];
        check_ending(&Objective::Kills, &seats, &[(0, 0), (1, 0), (1, 0)], 9, None, &[]);
        let (objective, resigned) = (Some(EndReason::Objective), Some(EndReason::Resigned));
        check_ending(&Objective::Kills, &seats, &[(0, 0), (0, 0), (1, 0)], 9, objective, &[0, 2]);
        seats[0].is_out = true;
        check_ending(&Objective::Kills, &seats, &[(0, 0), (1, 0), (1, 0)], 9, None, &[]);
        seats[1].is_out = true;
        check_ending(&Objective::Kills, &seats, &[(0, 0), (0, 0), (1, 0)], 9, resigned, &[2]);
    }

    fn seat(team: u16) -> SeatState {
        SeatState { team, stock: 0, is_out: false, tally: Tally::default(), had: 0, has: 0 }
    }

    #[expect(clippy::too_many_arguments, reason = "a line of the table each")]
    fn check_ending(
        objective: &Objective,
        seats: &[SeatState],
        left: &[(u32, u32)],
        cycles: u32,
        expected: Option<EndReason>,
        winners: &[u16],
    ) {
        let left: Vec<Left> = left.iter().map(|&(units, buildings)| Left { units, buildings }).collect();
        let standing =
            Standing { objective, seats, left: &left, cycles: Cycle(cycles), cycles_max: Cycle(100) };
        let expected = expected.map(|reason| Ending {
            winners: winners.iter().copied().map(Seat).collect(),
            reason,
            cycles: Cycle(cycles),
        });
        assert_eq!(standing.ending(), expected, "{objective:?} {seats:?} {left:?}");
    }
}
