//! How a match ended, for people.

use maniple_game::scenario::Objective;
use maniple_view::{EndReason, Score, Seat};

use crate::output::grouped;

/// Returns who has won.
pub(crate) fn winners(winners: &[Seat]) -> String {
    match winners {
        [] => "a draw".to_owned(),
        [seat] => format!("seat {seat} wins"),
        seats => {
            let seats: Vec<String> = seats.iter().map(Seat::to_string).collect();
            format!("seats {} win", seats.join(", "))
        }
    }
}

/// Returns why a match ended.
pub(crate) fn reason(objective: &Objective, reason: EndReason) -> &'static str {
    match (reason, objective) {
        (EndReason::Length, _) => "the time was up",
        (EndReason::Resigned, _) => "the others had resigned",
        (EndReason::Objective, Objective::Race { .. }) => "all units have arrived",
        (EndReason::Objective, Objective::Resources { .. }) => "the goal was gathered",
        (EndReason::Objective, Objective::Kills) => "only one team had units left",
        (EndReason::Objective, Objective::Buildings) => "only one team had buildings left",
        (EndReason::Objective, Objective::LastStanding) => "only one team had anything left",
        (EndReason::Objective, Objective::Survive { .. }) => "who was to survive had nothing left",
    }
}

/// Returns what a seat has achieved.
pub(crate) fn score(objective: &Objective, score: &Score) -> String {
    let tally = &score.tally;
    let points = grouped(score.points);
    let achieved = match objective {
        Objective::Race { .. } => {
            let sum = grouped(tally.arrival_sum);
            format!("{points} of {} units in the zone, sum of cycles {sum}", tally.units)
        }
        Objective::Resources { .. } => format!("{points} resources gathered"),
        Objective::Kills => format!("{points} units destroyed, {} lost", tally.units_lost),
        Objective::Buildings => format!("{points} buildings destroyed, {} lost", tally.buildings_lost),
        Objective::LastStanding | Objective::Survive { .. } => format!("{points} units and buildings left"),
    };
    format!("{achieved}{}", if score.resigned { ", resigned" } else { "" })
}
