//! A row for each match.

use maniple_view::EndReason;

use crate::commands::tournament::game::Row;
use crate::csv::line;

/// Returns the matches as CSV: a line of headings, and a line for each match.
///
/// `winner` has the names of the players that won, with ` + ` between them, and is empty for a draw.
pub(super) fn csv(rows: &[Row], seats: usize) -> String {
    let of_match = ["match", "seed", "winner", "reason", "cycles", "hash", "failure"].map(str::to_owned);
    let of_seat = |seat: usize| {
        ["player", "won", "points", "late", "refused", "crash"].map(|field| format!("seat_{seat}_{field}"))
    };
    let mut text = line(of_match.into_iter().chain((0..seats).flat_map(of_seat)));
    for row in rows {
        text += &line(cells(row));
    }
    text
}

fn cells(row: &Row) -> Vec<String> {
    let winners = row.seats.iter().filter(|seat| seat.won).map(|seat| seat.player.to_string());
    let mut cells = vec![
        row.number.to_string(),
        row.seed.to_string(),
        winners.collect::<Vec<String>>().join(" + "),
        row.reason.map(word).unwrap_or_default().to_owned(),
        row.cycles.to_string(),
        row.hash.map(|hash| hash.to_string()).unwrap_or_default(),
        row.failure.clone().unwrap_or_default(),
    ];
    for seat in &row.seats {
        let crash = seat.crash.as_ref();
        cells.extend([
            seat.player.to_string(),
            seat.won.to_string(),
            seat.points.to_string(),
            seat.late.to_string(),
            seat.refused.to_string(),
            crash.map(|crash| format!("cycle {}: {}", crash.cycle, crash.message)).unwrap_or_default(),
        ]);
    }
    cells
}

/// The word for a reason, the same as in JSON.
fn word(reason: EndReason) -> &'static str {
    match reason {
        EndReason::Objective => "objective",
        EndReason::Length => "length",
        EndReason::Resigned => "resigned",
    }
}
