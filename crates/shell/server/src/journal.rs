//! Journals: what is kept of a match while it is played, so that it can go on after the daemon was killed.
//!
//! A journal is a replay that goes on, in a folder of its own beside what a replay must not hold, the tokens of the seats:
//!
//! ```text
//! FOLDER/lock                          held while a daemon uses the folder
//! FOLDER/3f0a5c2e91d07b64/match.json   clock and tokens
//! FOLDER/3f0a5c2e91d07b64/journal      header, commands and hashes; see docs/PROTOCOL.md
//! FOLDER/3f0a5c2e91d07b64/snapshot     now and then, the state from which the rest of the journal is played again
//! FOLDER/3f0a5c2e91d07b64/fault.txt    why it was given up; it is not taken up again
//! FOLDER/finished/3f0a5c2e91d07b64.replay
//! ```
//!
//! The records of a cycle are handed to the system before a delta of it leaves, so a daemon that is killed loses nothing.
//! The disk has them when they were synced, which is for all matches together every [`SYNC_INTERVAL`].

mod resume;
mod sync;

use std::fs::{self, File, OpenOptions, TryLockError};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::thread;
use std::time::{Duration, Instant};

use maniple_view::{ClockMode, Digest};
use serde::{Deserialize, Serialize};
use thiserror::Error;

use crate::doors::Access;
use crate::token::Token;

pub use resume::Resumed;
use sync::{Health, Syncer};

/// Time after which what was written is on the disk, at the latest, where the disk is that fast.
pub const SYNC_INTERVAL: Duration = Duration::from_millis(100);

/// How long the lock of a folder is waited for, and how often it is looked. A process that is being started holds what its parent has locked
/// until it runs, and a daemon that was killed until it is gone.
const LOCK_WAIT: Duration = Duration::from_secs(1);
const LOCK_LOOK: Duration = Duration::from_millis(10);

/// The folder of those that have ended.
const FINISHED: &str = "finished";

/// The file in a match's folder that grows.
const JOURNAL: &str = "journal";

/// What has to be known of a match beside its journal.
const MATCH: &str = "match.json";

/// The state at some cycle of the journal.
const SNAPSHOT: &str = "snapshot";

/// Why a match was given up.
const FAULT: &str = "fault.txt";

/// A folder of journals.
#[derive(Debug)]
pub struct Journals {
    folder: PathBuf,
    syncer: Syncer,
    /// Locked while this is there.
    _lock: File,
}

/// A journal that cannot be kept or taken up.
#[derive(Debug, Error)]
pub enum JournalError {
    /// The file system does not do what is needed.
    #[error("{path}: {problem}; make room, or see to the rights of the folder")]
    File {
        /// The file or folder.
        path: PathBuf,
        /// What the system says.
        problem: io::Error,
    },
    /// Another daemon uses the folder.
    #[error("{folder}: another daemon keeps its matches here; stop it, or name another folder")]
    Locked {
        /// The folder.
        folder: PathBuf,
    },
    /// What is kept was altered.
    #[error("{path}: {problem}; put back a copy, or move the match's folder away to give it up")]
    Altered {
        /// The file.
        path: PathBuf,
        /// What is wrong, and where.
        problem: String,
    },
}

/// What a match's folder holds beside its journal.
#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Kept {
    #[serde(rename = "match")]
    id: Digest,
    clock: ClockMode,
    /// By seat; null: open.
    tokens: Vec<Option<String>>,
}

impl Kept {
    fn new(id: Digest, clock: ClockMode, access: &[Access]) -> Self {
        let token = |access: &Access| match access {
            Access::Open => None,
            Access::Token(token) => Some(token.to_string()),
        };
        Self { id, clock, tokens: access.iter().map(token).collect() }
    }

    /// Returns who may take which seat.
    ///
    /// # Errors
    /// A token that is none.
    fn access(&self) -> Result<Vec<Access>, String> {
        let access = |token: &Option<String>| match token {
            None => Ok(Access::Open),
            Some(token) => token.parse::<Token>().map(Access::Token).map_err(|error| error.to_string()),
        };
        self.tokens.iter().map(access).collect()
    }
}

impl Journals {
    /// Returns the journals in a folder, which is made where there is none. What is written is synced every `interval`.
    ///
    /// # Errors
    /// A folder that cannot be had, or that another daemon uses.
    pub fn open(folder: &Path, interval: Duration) -> Result<Self, JournalError> {
        let finished = folder.join(FINISHED);
        fs::create_dir_all(&finished).map_err(|problem| file_error(&finished, problem))?;
        let path = folder.join("lock");
        let lock = OpenOptions::new().create(true).truncate(false).write(true).open(&path);
        let lock = lock.map_err(|problem| file_error(&path, problem))?;
        take(&lock, folder, &path)?;
        Ok(Self { folder: folder.to_owned(), syncer: Syncer::start(interval), _lock: lock })
    }

    /// Begins the journal of a match.
    ///
    /// # Errors
    /// A file system that does not take it.
    pub(crate) fn create(
        &self,
        id: Digest,
        clock: ClockMode,
        access: &[Access],
    ) -> Result<Journal, JournalError> {
        let folder = self.folder.join(id.to_string());
        fs::create_dir(&folder).map_err(|problem| file_error(&folder, problem))?;
        let path = folder.join(MATCH);
        let kept = serde_json::to_vec(&Kept::new(id, clock, access)).expect("plain data");
        let mut file = private(&path).map_err(|problem| file_error(&path, problem))?;
        let written = file.write_all(&kept).and_then(|()| file.sync_all());
        written.map_err(|problem| file_error(&path, problem))?;
        let path = folder.join(JOURNAL);
        let file = File::create_new(&path).map_err(|problem| file_error(&path, problem))?;
        sync_folder(&folder)?;
        sync_folder(&self.folder)?;
        Ok(self.journal(id, Arc::new(file)))
    }

    fn journal(&self, id: Digest, file: Arc<dyn Storage>) -> Journal {
        let health = self.syncer.add(Arc::clone(&file));
        Journal {
            folder: self.folder.join(id.to_string()),
            finished: self.folder.join(FINISHED).join(format!("{id}.replay")),
            file,
            waiting: Vec::new(),
            health,
        }
    }
}

/// What a journal is written to: a file, or, in tests, one that fails.
pub(crate) trait Storage: Send + Sync + std::fmt::Debug {
    /// Puts bytes behind the others; when it returns the system has them.
    fn append(&self, bytes: &[u8]) -> io::Result<()>;

    /// Waits until the disk has all.
    fn sync(&self) -> io::Result<()>;
}

impl Storage for File {
    fn append(&self, bytes: &[u8]) -> io::Result<()> {
        let mut file = self;
        file.write_all(bytes)
    }

    fn sync(&self) -> io::Result<()> {
        self.sync_data()
    }
}

/// The journal of a match that is played.
#[derive(Debug)]
pub(crate) struct Journal {
    folder: PathBuf,
    finished: PathBuf,
    file: Arc<dyn Storage>,
    /// Since the last commit.
    waiting: Vec<u8>,
    health: Arc<Health>,
}

impl Journal {
    /// Takes bytes that go out with the next commit.
    pub(crate) fn write(&mut self, bytes: &[u8]) {
        self.waiting.extend_from_slice(bytes);
    }

    /// Hands all that was written to the system.
    ///
    /// # Errors
    /// A system that does not take it, or a sync that has failed: what the disk has is not known then, and never will be.
    pub(crate) fn commit(&mut self) -> io::Result<()> {
        self.health.check()?;
        if self.waiting.is_empty() {
            return Ok(());
        }
        self.file.append(&self.waiting)?;
        self.waiting.clear();
        self.health.note_write();
        Ok(())
    }

    /// Keeps the state of the match in place of the one before. What cannot be written is no loss: the journal has all.
    pub(crate) fn keep_snapshot(&self, bytes: &[u8]) {
        let (new, path) = (self.folder.join("snapshot.new"), self.folder.join(SNAPSHOT));
        if let Err(error) = fs::write(&new, bytes).and_then(|()| fs::rename(&new, &path)) {
            tracing::warn!(path = %path.display(), %error, "a snapshot is not kept");
        }
    }

    /// Ends the journal of a match that has ended, which from now on is a replay.
    ///
    /// # Errors
    /// A file system that does not do it.
    pub(crate) fn archive(mut self) -> io::Result<()> {
        self.commit()?;
        self.file.sync()?;
        fs::rename(self.folder.join(JOURNAL), &self.finished)?;
        fs::remove_dir_all(&self.folder)
    }

    /// Notes why a match is given up, so that it is not taken up again to fail again.
    pub(crate) fn give_up(self, fault: &str) {
        let path = self.folder.join(FAULT);
        if let Err(error) = fs::write(&path, fault) {
            tracing::error!(path = %path.display(), %error, fault, "a fault cannot be noted");
        }
    }
}

fn private(path: &Path) -> io::Result<File> {
    let mut options = OpenOptions::new();
    options.write(true).create_new(true);
    #[cfg(unix)]
    std::os::unix::fs::OpenOptionsExt::mode(&mut options, 0o600);
    options.open(path)
}

/// Sees to it that the names in a folder are on the disk.
fn sync_folder(folder: &Path) -> Result<(), JournalError> {
    let synced = File::open(folder).and_then(|folder| folder.sync_all());
    synced.map_err(|problem| file_error(folder, problem))
}

/// Takes the lock of a folder, and waits for it for [`LOCK_WAIT`].
fn take(lock: &File, folder: &Path, path: &Path) -> Result<(), JournalError> {
    let begun = Instant::now();
    loop {
        match lock.try_lock() {
            Ok(()) => return Ok(()),
            Err(TryLockError::Error(problem)) => return Err(file_error(path, problem)),
            Err(TryLockError::WouldBlock) if begun.elapsed() < LOCK_WAIT => thread::sleep(LOCK_LOOK),
            Err(TryLockError::WouldBlock) => {
                return Err(JournalError::Locked { folder: folder.to_owned() });
            }
        }
    }
}

fn file_error(path: &Path, problem: io::Error) -> JournalError {
    JournalError::File { path: path.to_owned(), problem }
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
    use std::thread::sleep;

    use super::*;

    /// A disk that fails when it is told to.
    #[derive(Debug, Default)]
    struct Disk {
        is_full: AtomicBool,
        is_broken: AtomicBool,
        appended: AtomicUsize,
        synced: AtomicUsize,
    }

    impl Storage for Disk {
        fn append(&self, bytes: &[u8]) -> io::Result<()> {
            if self.is_full.load(Ordering::SeqCst) {
                return Err(io::ErrorKind::StorageFull.into());
            }
            self.appended.fetch_add(bytes.len(), Ordering::SeqCst);
            Ok(())
        }

        fn sync(&self) -> io::Result<()> {
            self.synced.fetch_add(1, Ordering::SeqCst);
            if self.is_broken.load(Ordering::SeqCst) {
                return Err(io::Error::other("the disk is gone"));
            }
            Ok(())
        }
    }

    #[test]
    fn what_was_written_is_synced_and_a_sync_that_failed_is_never_tried_again() {
        let (journals, folder) = journals("synced");
        let disk = Arc::new(Disk::default());
        let mut journal = journals.journal(Digest(1), Arc::<Disk>::clone(&disk));
        journal.write(b"abc");
        assert_eq!(disk.appended.load(Ordering::SeqCst), 0, "together, at the end of a cycle");
        journal.commit().unwrap();
        assert_eq!(disk.appended.load(Ordering::SeqCst), 3);
        wait(|| disk.synced.load(Ordering::SeqCst) == 1);
        disk.is_broken.store(true, Ordering::SeqCst);
        journal.write(b"d");
        journal.commit().unwrap();
        wait(|| journal.commit().is_err());
        let error = journal.commit().unwrap_err().to_string();
        assert!(error.contains("the disk is gone"), "{error}");
        // It seems well again, and is not believed.
        disk.is_broken.store(false, Ordering::SeqCst);
        let synced = disk.synced.load(Ordering::SeqCst);
        sleep(10 * INTERVAL);
        assert!(journal.commit().is_err());
        assert_eq!(disk.synced.load(Ordering::SeqCst), synced);
        fs::remove_dir_all(folder).unwrap();
    }

    #[test]
    fn a_full_disk_takes_no_further_cycle_and_no_new_match() {
        let (journals, folder) = journals("full");
        let disk = Arc::new(Disk::default());
        disk.is_full.store(true, Ordering::SeqCst);
        let mut journal = journals.journal(Digest(1), Arc::<Disk>::clone(&disk));
        journal.write(b"abc");
        assert_eq!(journal.commit().unwrap_err().kind(), io::ErrorKind::StorageFull);
        // As where there is no room for a folder.
        fs::write(folder.join(Digest(2).to_string()), "").unwrap();
        let error = journals.create(Digest(2), ClockMode::Lockstep, &[]).unwrap_err();
        assert!(error.to_string().contains("make room"), "{error}");
        fs::remove_dir_all(folder).unwrap();
    }

    #[test]
    fn a_replay_that_the_disk_has_not_is_not_finished() {
        let (journals, folder) = journals("unfinished");
        let disk = Arc::new(Disk::default());
        let journal = journals.journal(Digest(1), Arc::<Disk>::clone(&disk));
        disk.is_broken.store(true, Ordering::SeqCst);
        assert_eq!(journal.archive().unwrap_err().to_string(), "the disk is gone");
        fs::remove_dir_all(folder).unwrap();
    }

    #[test]
    fn a_match_that_was_given_up_is_not_taken_up_again() {
        let (journals, folder) = journals("given_up");
        let mut journal = journals.create(Digest(3), ClockMode::Lockstep, &[Access::Open]).unwrap();
        // Were it looked at, it would be said to be none.
        journal.write(b"no journal");
        journal.commit().unwrap();
        journal.give_up("a mistake");
        assert!(folder.join(Digest(3).to_string()).join(FAULT).exists());
        let resumed = journals.resume().unwrap();
        assert!(resumed.matches.is_empty() && resumed.errors.is_empty());
        fs::remove_dir_all(folder).unwrap();
    }

    #[cfg(unix)]
    #[test]
    fn the_tokens_of_a_match_are_for_the_owner_alone() {
        use std::os::unix::fs::PermissionsExt;
        let (journals, folder) = journals("tokens");
        let access = [Access::Token(Token::random().unwrap())];
        let journal = journals.create(Digest(4), ClockMode::Lockstep, &access).unwrap();
        let kept = fs::metadata(journal.folder.join(MATCH)).unwrap();
        assert_eq!(kept.permissions().mode() & 0o777, 0o600);
        fs::remove_dir_all(folder).unwrap();
    }

    const INTERVAL: Duration = Duration::from_millis(5);

    fn journals(name: &str) -> (Journals, PathBuf) {
        let folder = std::env::temp_dir().join(format!("maniple-{}-{name}", std::process::id()));
        (Journals::open(&folder, INTERVAL).unwrap(), folder)
    }

    /// Waits for what comes at the next sync or never.
    fn wait(mut is_so: impl FnMut() -> bool) {
        for _ in 0..2000 {
            if is_so() {
                return;
            }
            sleep(INTERVAL);
        }
        panic!("what was waited for never came");
    }
}
