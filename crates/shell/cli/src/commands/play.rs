//! `maniple match`: bots against each other in this process.

use std::fmt::Write as _;
use std::time::Instant;

use indicatif::{ProgressBar, ProgressStyle};
use maniple_game::Overrides;
use maniple_game::scenario::Objective;
use maniple_geometry::Cycle;
use maniple_view::{ClockMode, Digest, EndReason, MatchResult, Score, Seat};
use serde::Serialize;

use crate::arguments::Match;
use crate::commands::tournament;
use crate::explain::Costs;
use crate::failure::Failure;
use crate::output::{Format, grouped, note, print, print_text};
use crate::{files, headless, models, outcome, start};

/// How a match went, as it is printed.
#[derive(Debug, Serialize)]
struct Report {
    scenario: String,
    seed: u64,
    cycles: u32,
    winners: Vec<Seat>,
    scores: Vec<Score>,
    hash: Digest,
    cycles_per_second: f64,
    /// Where the replay is; null where none was asked for.
    replay: Option<String>,
    #[serde(skip)]
    reason: EndReason,
    #[serde(skip)]
    objective: Objective,
    #[serde(skip)]
    rate: f64,
}

/// Runs `maniple match`.
pub(crate) fn run(arguments: &Match) -> Result<(), Failure> {
    if let Some(count) = arguments.many.count {
        return tournament::run(arguments, count);
    }
    let asked = Overrides {
        map: start::map_path(arguments.map.as_deref()),
        seed: arguments.seed,
        ..arguments.profile.overrides()?
    };
    let mut loaded = start::loaded(arguments.scenario.as_deref(), &asked)?;
    if let Some(cycles) = arguments.cycles {
        loaded.limit_cycles(Cycle(cycles));
    }
    let mut bots = headless::bots(&loaded, &arguments.bots)?;
    let (name, seed, rate) = (loaded.scenario.name.clone(), loaded.scenario.seed, loaded.scenario.rate);
    let objective = loaded.scenario.objective;
    let bar = progress_bar(u64::from(loaded.scenario.cycles_max.0));
    let replay = arguments.replay.as_deref().map(files::create).transpose()?;
    note(&models::line(&loaded));
    let explained = arguments.explain.then(|| loaded.clone());
    let begun = Instant::now();
    let mut costs = Costs::begin();
    let progress = |cycle| bar.set_position(u64::from(cycle));
    let referee = start::referee(loaded, ClockMode::Lockstep)?;
    let result = match &explained {
        Some(_) => headless::play(referee, &mut bots, replay, progress, |part| costs.done(part))?,
        None => headless::play(referee, &mut bots, replay, progress, |_| {})?,
    };
    let seconds = begun.elapsed().as_secs_f64();
    bar.finish_and_clear();
    let MatchResult { winners, reason, cycles, scores, hash } = result;
    let report = Report {
        scenario: name,
        seed,
        cycles: cycles.0,
        winners,
        scores,
        hash,
        cycles_per_second: f64::from(cycles.0) / seconds,
        replay: arguments.replay.as_ref().map(|path| path.display().to_string()),
        reason,
        objective,
        rate,
    };
    print(Format::of(&arguments.json), &report, |report| text(report, arguments))?;
    explained.map_or(Ok(()), |loaded| print_text(&format!("\n{}", costs.table(&loaded, cycles.0))))
}

/// A bar on standard error; none where that is no terminal.
fn progress_bar(cycles: u64) -> ProgressBar {
    let style = ProgressStyle::with_template("{bar:40} {pos}/{len} cycles, {per_sec}");
    let bar = ProgressBar::new(cycles);
    match style {
        Ok(style) => bar.with_style(style),
        Err(_) => bar,
    }
}

fn text(report: &Report, arguments: &Match) -> String {
    let mut text = format!(
        "{}, seed {}: {} after {} cycles ({:.1} s of play), {} cycles a second\n",
        report.scenario,
        report.seed,
        outcome::winners(&report.winners),
        grouped(u64::from(report.cycles)),
        f64::from(report.cycles) / report.rate,
        whole(report.cycles_per_second),
    );
    for score in &report.scores {
        let _ = writeln!(
            text,
            "  seat {}  {:<12} {}",
            score.seat,
            score.name,
            outcome::score(&report.objective, score),
        );
    }
    let ended = outcome::reason(&report.objective, report.reason);
    let _ = writeln!(text, "  {ended}; state hash {}", report.hash);
    let _ = match &report.replay {
        Some(replay) => {
            let cycle = report.cycles / 2;
            writeln!(text, "next: maniple replay render {replay} --cycle {cycle} --out match.png")
        }
        None => {
            let scenario = arguments.scenario.iter().map(|path| format!(" {}", path.display()));
            let map = arguments.map.iter().map(|path| format!(" --map {}", path.display()));
            let same: String = scenario.chain(map).collect();
            writeln!(text, "next: maniple match{same} --bot random --seed 2 --replay match.replay")
        }
    };
    text
}

#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "a rate is positive, and an infinite one may saturate"
)]
fn whole(rate: f64) -> String {
    grouped(rate as u64)
}
