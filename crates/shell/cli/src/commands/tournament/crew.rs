//! Threads that play matches.

use std::sync::Arc;
use std::sync::atomic::{AtomicU32, AtomicU64, Ordering};
use std::sync::mpsc::{self, RecvTimeoutError, Sender};
use std::thread;
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressStyle};
use rayon::ThreadPoolBuilder;

use crate::commands::tournament::game::{Plan, Row, play};
use crate::failure::Failure;
use crate::interrupt;
use crate::output::grouped;

/// How often the bar is drawn if no match ends.
const BAR_PERIOD: Duration = Duration::from_millis(200);

/// What was played.
#[derive(Debug, Default)]
pub(super) struct Outcome {
    /// In order of their numbers; with gaps if the run was interrupted.
    pub(super) rows: Vec<Row>,
    pub(super) is_interrupted: bool,
    /// From the first match to the last.
    pub(super) took: Duration,
    /// How long it took to make the matches: the sum, and the longest.
    pub(super) creation: (Duration, Duration),
}

enum News {
    Played(Row, Duration),
    Interrupted,
}

/// What the threads share.
struct Shared {
    plan: Plan,
    count: u32,
    /// The next match to be played.
    next: AtomicU32,
    /// Cycles of all matches so far.
    cycles: AtomicU64,
}

/// Plays matches, `jobs` at a time.
///
/// # Errors
/// Threads that cannot be had.
pub(super) fn play_all(plan: Plan, count: u32, jobs: u32) -> Result<Outcome, Failure> {
    let (sender, news) = mpsc::channel();
    let interrupted = sender.clone();
    interrupt::when_interrupted(move || {
        // Nobody listens any more once all is played.
        let _ = interrupted.send(News::Interrupted);
    });
    let shared = Arc::new(Shared { plan, count, next: AtomicU32::new(0), cycles: AtomicU64::new(0) });
    let begun = Instant::now();
    for job in 0..jobs.min(count) {
        let (shared, sender) = (Arc::clone(&shared), sender.clone());
        let thread = thread::Builder::new().name(format!("matches {job}"));
        thread.spawn(move || work(&shared, &sender)).map_err(Failure::failed)?;
    }
    let bar = Bar::new(count, begun);
    let mut outcome = Outcome::default();
    while outcome.rows.len() < count as usize && !outcome.is_interrupted {
        match news.recv_timeout(BAR_PERIOD) {
            Ok(News::Played(row, creation)) => {
                outcome.rows.push(row);
                let (sum, longest) = outcome.creation;
                outcome.creation = (sum + creation, longest.max(creation));
            }
            Ok(News::Interrupted) => outcome.is_interrupted = true,
            // The interrupt's end of the channel stays open.
            Err(RecvTimeoutError::Timeout | RecvTimeoutError::Disconnected) => {}
        }
        bar.draw(outcome.rows.len(), shared.cycles.load(Ordering::Relaxed));
    }
    bar.bar.finish_and_clear();
    outcome.took = begun.elapsed();
    outcome.rows.sort_unstable_by_key(|row| row.number);
    Ok(outcome)
}

/// Plays one match after the other until none is left, or nobody wants to know.
fn work(shared: &Shared, news: &Sender<News>) {
    // Alone in its pool, this thread moves the circles of its matches itself: threads that share one match wait for
    // each other, threads with a match each do not.
    let alone = ThreadPoolBuilder::new().num_threads(1).use_current_thread().build();
    let progress = || {
        shared.cycles.fetch_add(1, Ordering::Relaxed);
    };
    let play_on = || loop {
        let number = shared.next.fetch_add(1, Ordering::Relaxed);
        if number >= shared.count {
            return;
        }
        let (row, creation) = play(&shared.plan, number, progress);
        if news.send(News::Played(row, creation)).is_err() {
            return;
        }
    };
    match alone {
        Ok(pool) => pool.install(play_on),
        // The results are the same in the pool of the process.
        Err(_) => play_on(),
    }
}

/// A bar on standard error; none where that is no terminal.
struct Bar {
    bar: ProgressBar,
    begun: Instant,
}

impl Bar {
    fn new(count: u32, begun: Instant) -> Self {
        let bar = ProgressBar::new(u64::from(count));
        let bar = match ProgressStyle::with_template("{bar:40} {pos}/{len} matches, {msg}") {
            Ok(style) => bar.with_style(style),
            Err(_) => bar,
        };
        Self { bar, begun }
    }

    fn draw(&self, played: usize, cycles: u64) {
        if self.bar.is_hidden() {
            return;
        }
        let seconds = self.begun.elapsed().as_secs_f64();
        self.bar.set_message(format!(
            "{:.1} matches/s, {} cycles/s",
            played as f64 / seconds,
            grouped(whole(cycles as f64 / seconds)),
        ));
        self.bar.set_position(played as u64);
    }
}

/// Returns a rate without its fraction.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "a rate is not negative, and an infinite one may saturate"
)]
pub(super) fn whole(rate: f64) -> u64 {
    rate as u64
}

#[cfg(test)]
mod tests {
    use std::panic::panic_any;

    use maniple_bots::Bot;
    use maniple_game::Overrides;
    use maniple_geometry::Cycle;
    use maniple_view::{Command, Delta, EndReason, Rules, Seat, Terrain, View};

    use super::*;
    use crate::commands::tournament::schedule::{Schedule, players};
    use crate::commands::tournament::summary::{of_players, of_seats};
    use crate::files::{SHIPPED_SCENARIO, shipped};

    /// Panics as its name says.
    struct Faulty(&'static str);

    impl Bot for Faulty {
        fn name(&self) -> &'static str {
            self.0
        }

        fn on_start(&mut self, _seat: Seat, _rules: &Rules, _terrain: &Terrain) {
            assert!(self.0 != "at start", "before the first cycle");
        }

        fn on_cycle(&mut self, view: &View, _delta: &Delta) -> Vec<Command> {
            let cycle = view.cycle().0;
            assert!(self.0 != "in cycle 7" || cycle < 7, "in cycle {cycle}");
            assert!(self.0 != "at the end" || cycle < 30, "too late to lose");
            if self.0 == "wordless" {
                panic_any(1);
            }
            Vec::new()
        }
    }

    fn make(name: &str, _seed: u64, _seat: Seat) -> Result<Box<dyn Bot + Send>, Failure> {
        let names = ["harmless", "at start", "in cycle 7", "at the end", "wordless"];
        let name = names.into_iter().find(|known| *known == name);
        Ok(Box::new(Faulty(name.expect("that our own code panics is tested here"))))
    }

    fn plan(bots: [&str; 2]) -> Plan {
        let bots = bots.map(str::to_owned).to_vec();
        Plan {
            files: shipped(),
            scenario: SHIPPED_SCENARIO.to_owned(),
            asked: Overrides::default(),
            cycles_max: Some(Cycle(30)),
            schedule: Schedule { seed: 3, seats: 2 },
            players: players(&bots),
            bots,
            make,
            replays: None,
        }
    }

    #[test]
    fn a_bot_that_panics_resigns_and_all_others_play_on() {
        let check = |faulty: &'static str, cycle: u32, cycles: u32, message: &str| {
            let plan = plan(["harmless", faulty]);
            let Outcome { rows, is_interrupted, .. } = play_all(plan.clone(), 4, 2).expect("threads");
            assert!(!is_interrupted && rows.len() == 4);
            for row in &rows {
                let (harmless, other) = if row.number % 2 == 0 { (0, 1) } else { (1, 0) };
                let crash = row.seats[other].crash.as_ref().expect("a crash");
                assert_eq!((crash.cycle, row.cycles), (cycle, cycles), "{faulty}");
                assert!(crash.message.starts_with(message), "{}", crash.message);
                assert_eq!((&row.seats[harmless].crash, &row.failure), (&None, &None));
                let is_lost = row.reason == Some(EndReason::Resigned);
                assert_eq!((row.seats[harmless].won, is_lost), (cycles < 30, cycles < 30), "{faulty}");
            }
            let standings = of_players(&rows, &plan.players);
            assert_eq!((standings[0].crashes, standings[1].crashes), (0, 4));
            let seats = of_seats(&rows, 2);
            assert_eq!((seats[0].crashes, seats[1].crashes), (2, 2));
        };
        check("at start", 0, 1, "before the first cycle (");
        check("in cycle 7", 7, 8, "in cycle 7 (");
        check("wordless", 0, 1, "a panic without words (");
        // After the last cycle nothing is left to lose, but the crash counts.
        check("at the end", 30, 30, "too late to lose (");
    }

    #[test]
    fn a_match_in_which_our_own_code_panics_is_told_and_counts_for_nobody() {
        let plan = plan(["harmless", "unknown"]);
        let Outcome { rows, .. } = play_all(plan.clone(), 2, 1).expect("threads");
        for row in &rows {
            let failure = row.failure.as_ref().expect("a failure");
            assert!(
                failure.contains("Maniple itself") && failure.contains("our own code panics"),
                "{failure}"
            );
        }
        let standing = &of_players(&rows, &plan.players)[0];
        assert_eq!((standing.wins, standing.draws, standing.losses), (0, 0, 0));
        assert_eq!((standing.score, standing.win_rate_interval), (None, (0.0, 1.0)));
    }

    #[test]
    fn rows_do_not_depend_on_how_many_matches_are_played_at_a_time() {
        let rows = |jobs| play_all(plan(["harmless", "in cycle 7"]), 9, jobs).expect("threads").rows;
        assert_eq!(rows(1), rows(4));
    }
}
