//! `maniple replay verify`: whether a match plays again to the same hashes, and where it does not.

use std::fmt::Write as _;
use std::path::Path;

use anyhow::Context;
use maniple_protocol::{Fingerprint, decode_snapshot};
use maniple_referee::{RecordedEvent, Referee, ReplayError, Snapshot};
use maniple_view::Digest;
use serde::Serialize;

use super::{beginning, read};
use crate::arguments::ReplayVerify;
use crate::failure::Failure;
use crate::files;
use crate::output::{Format, grouped, print};

/// Most places that are named where a state differs from a snapshot.
const DIFFERENCES_MAX: usize = 10;

/// What a replay decides of a snapshot: not how much time was left, who wanted a pause, or who watched.
const DECIDED: [&str; 2] = ["world/", "seats/"];

/// Whether a replay plays again to the same hashes.
#[derive(Debug, Serialize)]
struct Verdict {
    verified: bool,
    cycles: u32,
    /// The first cycle that differs; null where none does.
    first_difference: Option<u32>,
    /// The hash at the end of what agreed.
    hash: Digest,
    /// Where the state differs from the snapshot, and how: this match against that one.
    differences: Vec<String>,
}

impl Verdict {
    fn text(&self) -> String {
        let mut text = match self.first_difference {
            None if self.verified => {
                format!("verified: {} cycles, hash {}\n", grouped(u64::from(self.cycles)), self.hash)
            }
            None => "not verified: the state differs from the snapshot\n".to_owned(),
            Some(cycle) => format!("not verified: cycle {cycle} is the first that differs\n"),
        };
        for difference in &self.differences {
            let _ = writeln!(text, "  {difference}");
        }
        text
    }
}

pub(super) fn run(arguments: &ReplayVerify) -> Result<(), Failure> {
    let (replay, _) = read(&arguments.file)?;
    let mut referee = beginning(&replay, &arguments.file)?;
    let snapshot = arguments.snapshot.as_deref().map(|path| read_snapshot(path, &referee)).transpose()?;
    let mut verdict = Verdict {
        verified: true,
        cycles: 0,
        first_difference: None,
        hash: referee.hash(),
        differences: Vec::new(),
    };
    let mut failure = None;
    for event in maniple_server::events(&replay) {
        let outcome = referee.handle_record(&event);
        if let (RecordedEvent::Hash { .. }, Some(snapshot)) = (&event, &snapshot)
            && snapshot.cycle() == referee.cycle()
        {
            verdict.differences = differences(&referee, snapshot);
            verdict.verified &= verdict.differences.is_empty();
        }
        if let Err(error) = outcome {
            verdict.verified = false;
            let goes_on = matches!(error, ReplayError::Hash { .. })
                && snapshot.as_ref().is_some_and(|snapshot| snapshot.cycle() > referee.cycle());
            failure.get_or_insert((first(&error, &referee), error));
            if !goes_on {
                break;
            }
        } else if failure.is_none() {
            verdict.cycles = referee.cycle().0;
            verdict.hash = referee.hash();
        }
    }
    verdict.first_difference = failure.as_ref().map(|(cycle, _)| *cycle);
    print(Format::of(&arguments.json), &verdict, Verdict::text)?;
    let file = || arguments.file.display().to_string();
    match failure {
        None if verdict.verified => Ok(()),
        None => Err(Failure::Failed(anyhow::anyhow!("{}: the state differs from the snapshot", file()))),
        Some((_, error)) => Err(Failure::Failed(anyhow::Error::new(error).context(file()))),
    }
}

/// Returns the first cycle that differs by an error.
fn first(error: &ReplayError, referee: &Referee) -> u32 {
    match error {
        ReplayError::Hash { cycle, .. } => cycle.0,
        ReplayError::Result { .. } | ReplayError::Order { .. } | ReplayError::Seat { .. } => {
            referee.cycle().0
        }
    }
}

/// Returns where a match differs from a snapshot of its cycle.
fn differences(referee: &Referee, snapshot: &Snapshot) -> Vec<String> {
    let (here, there) = (Fingerprint::of(&referee.snapshot()), Fingerprint::of(snapshot));
    let found = here.differences(&there, usize::MAX).into_iter();
    let is_decided = |path: &str| DECIDED.iter().any(|part| path.starts_with(part));
    found
        .filter(|difference| is_decided(&difference.path))
        .take(DIFFERENCES_MAX)
        .map(|difference| difference.to_string())
        .collect()
}

fn read_snapshot(path: &Path, referee: &Referee) -> Result<Snapshot, Failure> {
    let bytes = files::read(path)?;
    let snapshot: Snapshot =
        decode_snapshot(&bytes).with_context(|| path.display().to_string()).map_err(Failure::BadInput)?;
    snapshot
        .check_origin(referee.loaded())
        .with_context(|| path.display().to_string())
        .map_err(Failure::BadInput)?;
    Ok(snapshot)
}
