//! Takes matches up again where a daemon has left them.

use std::fmt::Display;
use std::fs::{self, OpenOptions};
use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use maniple_game::Loaded;
use maniple_protocol::{Partial, ReplayProblem, decode_snapshot, read_partial};
use maniple_referee::{RecordedEvent, Referee, Snapshot};

use super::{FAULT, FINISHED, JOURNAL, JournalError, Journals, Kept, MATCH, SNAPSHOT, file_error};
use crate::matches::{Match, Sink};
use crate::recording::{Recording, events, loaded};

/// What became of the matches of a folder.
#[derive(Default)]
pub struct Resumed {
    /// Those that go on.
    pub matches: Vec<Match>,
    /// Those that do not, and why.
    pub errors: Vec<JournalError>,
}

impl Journals {
    /// Takes up all matches that have not ended, each at the start of the last cycle that its journal knows of. One that cannot be
    /// taken up stays as it is.
    ///
    /// # Errors
    /// A folder that cannot be read.
    pub fn resume(&self) -> Result<Resumed, JournalError> {
        let entries = fs::read_dir(&self.folder).map_err(|problem| file_error(&self.folder, problem))?;
        let mut folders: Vec<PathBuf> = Vec::new();
        for entry in entries {
            let path = entry.map_err(|problem| file_error(&self.folder, problem))?.path();
            if path.is_dir() && !path.ends_with(FINISHED) {
                folders.push(path);
            }
        }
        folders.sort_unstable();
        let mut resumed = Resumed::default();
        for folder in folders {
            match self.resume_one(&folder) {
                Ok(game) => resumed.matches.extend(game),
                Err(error) => resumed.errors.push(error),
            }
        }
        Ok(resumed)
    }

    /// Returns the match of a folder; `None` where it was given up, or had not begun to be kept.
    fn resume_one(&self, folder: &Path) -> Result<Option<Match>, JournalError> {
        let (kept_path, path) = (folder.join(MATCH), folder.join(JOURNAL));
        if folder.join(FAULT).exists() {
            tracing::warn!(folder = %folder.display(), "a match was given up and is not taken up again");
            return Ok(None);
        }
        let bytes = fs::read(&path).unwrap_or_default();
        if bytes.is_empty() {
            // Killed while it was created: nobody was told of it.
            fs::remove_dir_all(folder).map_err(|problem| file_error(folder, problem))?;
            return Ok(None);
        }
        let altered = |path: &Path, problem: String| JournalError::Altered { path: path.to_owned(), problem };
        let kept = fs::read(&kept_path).map_err(|problem| file_error(&kept_path, problem))?;
        let kept: Kept =
            serde_json::from_slice(&kept).map_err(|error| altered(&kept_path, error.to_string()))?;
        let access = kept.access().map_err(|problem| altered(&kept_path, problem))?;
        let mut partial = match read_partial(&bytes) {
            Ok(partial) => partial,
            Err(error) if error.problem == ReplayProblem::Cut => {
                fs::remove_dir_all(folder).map_err(|problem| file_error(folder, problem))?;
                return Ok(None);
            }
            Err(error) => return Err(altered(&path, error.to_string())),
        };
        check_tail(&partial, &bytes).map_err(|problem| altered(&path, problem))?;
        partial.cut_to_last_hash();
        let referee = referee(folder, &kept, &partial).map_err(|problem| altered(&path, problem))?;
        if access.len() != referee.seats() {
            let problem = format!("{} tokens for {} seats", access.len(), referee.seats());
            return Err(altered(&kept_path, problem));
        }
        let file = OpenOptions::new().append(true).open(&path);
        let file = file.map_err(|problem| file_error(&path, problem))?;
        let cut = file.set_len(partial.whole_bytes as u64).and_then(|()| file.sync_all());
        cut.map_err(|problem| file_error(&path, problem))?;
        let journal = self.journal(kept.id, Arc::new(file));
        if partial.replay.ended.is_some() {
            journal.archive().map_err(|problem| file_error(&path, problem))?;
            return Ok(None);
        }
        tracing::info!(id = %kept.id, cycle = referee.cycle().0, "a match goes on");
        let recording = Recording::resume(partial.writer(), Sink::Journal(journal));
        Ok(Some(Match::resumed(referee, kept.id, access, recording)))
    }
}

/// Checks that what is behind the last whole record is the beginning of another, or nothing: all else was altered.
fn check_tail(partial: &Partial, bytes: &[u8]) -> Result<(), String> {
    let Some(fault) = &partial.fault else { return Ok(()) };
    // Zeros: what the disk had made room for when the power went.
    let is_torn = matches!(fault.problem, ReplayProblem::Unfinished | ReplayProblem::Cut)
        || bytes[partial.whole_bytes..].iter().all(|&byte| byte == 0);
    if is_torn { Ok(()) } else { Err(fault.to_string()) }
}

/// Plays a match again up to where its journal ends, from its snapshot if there is one.
fn referee(folder: &Path, kept: &Kept, partial: &Partial) -> Result<Referee, String> {
    let loaded = Arc::new(loaded(&partial.replay.header).map_err(|error| error.to_string())?);
    let records: Vec<RecordedEvent> = events(&partial.replay).collect();
    let (mut referee, played) = match snapshot(folder, kept, &loaded, &records) {
        Some(going_on) => going_on,
        None => {
            let mut referee = Referee::new(loaded, kept.clock).map_err(|error| error.to_string())?;
            referee.open_stands();
            (referee, 0)
        }
    };
    for event in &records[played..] {
        referee.handle_record(event).map_err(|error| error.to_string())?;
    }
    Ok(referee)
}

/// Returns the match of a snapshot, and how many of the records are behind it; `None` where there is none, or none that belongs to the
/// journal, which is said: then all is played again.
fn snapshot(
    folder: &Path,
    kept: &Kept,
    loaded: &Arc<Loaded>,
    records: &[RecordedEvent],
) -> Option<(Referee, usize)> {
    let path = folder.join(SNAPSHOT);
    let bytes = match fs::read(&path) {
        Ok(bytes) => bytes,
        Err(error) if error.kind() == ErrorKind::NotFound => return None,
        Err(error) => return useless(&path, &error),
    };
    let snapshot: Snapshot = match decode_snapshot(&bytes) {
        Ok(snapshot) => snapshot,
        Err(error) => return useless(&path, &error),
    };
    let referee = match Referee::resume(Arc::clone(loaded), kept.clock, &snapshot) {
        Ok(referee) => referee,
        Err(error) => return useless(&path, &error),
    };
    let hash = RecordedEvent::Hash { cycle: referee.cycle(), hash: referee.hash() };
    match records.iter().position(|record| *record == hash) {
        Some(place) => Some((referee, place + 1)),
        None => useless(&path, &"the journal does not lead to its state"),
    }
}

fn useless<T>(path: &Path, problem: &dyn Display) -> Option<T> {
    tracing::warn!(path = %path.display(), %problem, "a snapshot is of no use; the match is played again from its start");
    None
}
