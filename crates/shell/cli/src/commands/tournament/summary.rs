//! What all matches come to.

use maniple_view::Seat;
use serde::Serialize;

use crate::commands::tournament::estimate::{Sample, Spread, wilson};
use crate::commands::tournament::game::{Row, SeatRow};
use crate::commands::tournament::schedule::Player;

/// What all matches come to, as it is printed.
#[derive(Clone, Debug, Serialize)]
pub(super) struct Summary {
    pub(super) scenario: String,
    /// The first seed.
    pub(super) seed: u64,
    /// Matches that were asked for.
    pub(super) count: u32,
    /// Matches that were played to their end; all other figures but `failed` are about these.
    pub(super) played: u32,
    /// Matches that could not be played.
    pub(super) failed: u32,
    pub(super) interrupted: bool,
    pub(super) draws: u32,
    /// Of a match, in cycles.
    pub(super) length: Spread,
    /// In the order in which the bots were named.
    pub(super) players: Vec<Standing<OfPlayer>>,
    /// The same, counted for the seat whoever sat there.
    pub(super) seats: Vec<Standing<OfSeat>>,
    pub(super) matches: Vec<Row>,
    pub(super) timing: Timing,
}

/// Whoever plays with a bot.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(super) struct OfPlayer {
    pub(super) player: Player,
}

/// Whoever sits there.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(super) struct OfSeat {
    pub(super) seat: Seat,
}

/// What depends on the machine and on how many matches are played at a time.
#[derive(Clone, Debug, Serialize)]
pub(super) struct Timing {
    pub(super) jobs: u32,
    pub(super) seconds: f64,
    pub(super) matches_per_second: f64,
    pub(super) cycles_per_second: f64,
    /// From the files in memory to the start of cycle 0.
    pub(super) creation_ms_mean: f64,
    pub(super) creation_ms_max: f64,
}

/// What somebody, or a seat, has achieved in all matches that were played.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(super) struct Standing<Who> {
    #[serde(flatten)]
    pub(super) who: Who,
    pub(super) wins: u32,
    pub(super) draws: u32,
    pub(super) losses: u32,
    /// Wins and half of the draws, as a share of the matches; `None` if there are none.
    pub(super) score: Option<f64>,
    /// Wins as a share of the matches; `None` if there are none.
    pub(super) win_rate: Option<f64>,
    /// The 95 % interval of the win rate.
    pub(super) win_rate_interval: (f64, f64),
    /// Points by the objective, of a match.
    pub(super) points: Spread,
    pub(super) crashes: u32,
    /// Commands that were applied late.
    pub(super) late: u64,
    /// Commands that were refused.
    pub(super) refused: u64,
}

/// Returns what each player has achieved.
pub(super) fn of_players(rows: &[Row], players: &[Player]) -> Vec<Standing<OfPlayer>> {
    let standing = |player: &Player| {
        let count = count(rows, |_, seat| seat.player == *player);
        count.standing(OfPlayer { player: player.clone() })
    };
    players.iter().map(standing).collect()
}

/// Returns what was achieved at each seat.
pub(super) fn of_seats(rows: &[Row], seats: usize) -> Vec<Standing<OfSeat>> {
    let standing = |seat: Seat| count(rows, |place, _| place == seat.index()).standing(OfSeat { seat });
    (0..).map(Seat).take(seats).map(standing).collect()
}

/// Counts the places that are meant, of all matches that were played.
fn count(rows: &[Row], is_meant: impl Fn(usize, &SeatRow) -> bool) -> Count {
    let mut count = Count::default();
    for row in rows.iter().filter(|row| row.failure.is_none()) {
        for (place, seat) in row.seats.iter().enumerate() {
            if is_meant(place, seat) {
                count.add(row, seat);
            }
        }
    }
    count
}

#[derive(Clone, Copy, Debug, Default)]
struct Count {
    played: u32,
    wins: u32,
    draws: u32,
    points: Sample,
    crashes: u32,
    late: u64,
    refused: u64,
}

impl Count {
    fn add(&mut self, row: &Row, seat: &SeatRow) {
        self.played += 1;
        self.wins += u32::from(seat.won);
        self.draws += u32::from(row.is_draw());
        self.points.add(seat.points as f64);
        self.crashes += u32::from(seat.crash.is_some());
        self.late += seat.late;
        self.refused += seat.refused;
    }

    fn standing<Who>(self, who: Who) -> Standing<Who> {
        let share = |part: f64| (self.played > 0).then(|| part / f64::from(self.played));
        Standing {
            who,
            wins: self.wins,
            draws: self.draws,
            losses: self.played - self.wins - self.draws,
            score: share(f64::from(self.wins) + 0.5 * f64::from(self.draws)),
            win_rate: share(f64::from(self.wins)),
            win_rate_interval: wilson(self.wins, self.played),
            points: self.points.spread(),
            crashes: self.crashes,
            late: self.late,
            refused: self.refused,
        }
    }
}

/// Returns how long matches were, in cycles.
pub(super) fn length(rows: &[Row]) -> Spread {
    let mut sample = Sample::default();
    for row in rows.iter().filter(|row| row.failure.is_none()) {
        sample.add(f64::from(row.cycles));
    }
    sample.spread()
}
