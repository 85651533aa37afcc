//! One thread syncs the journals of all matches.

use std::io;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{RecvTimeoutError, Sender, channel};
use std::sync::{Arc, Mutex, PoisonError, Weak};
use std::thread;
use std::time::{Duration, Instant};

use super::Storage;

/// The thread that syncs; it ends when this is dropped.
#[derive(Debug)]
pub(super) struct Syncer {
    journals: Arc<Mutex<Vec<Entry>>>,
    _until_dropped: Sender<()>,
}

#[derive(Debug)]
struct Entry {
    file: Arc<dyn Storage>,
    /// Gone with the journal.
    health: Weak<Health>,
}

/// How it stands with the disk's copy of a journal.
#[derive(Debug, Default)]
pub(super) struct Health {
    /// Whether something was written since the last sync.
    is_dirty: AtomicBool,
    has_failed: AtomicBool,
    failure: Mutex<Option<String>>,
}

impl Health {
    pub(super) fn note_write(&self) {
        self.is_dirty.store(true, Ordering::Release);
    }

    /// Checks that no sync has failed.
    pub(super) fn check(&self) -> io::Result<()> {
        if !self.has_failed.load(Ordering::Acquire) {
            return Ok(());
        }
        let failure = self.failure.lock().unwrap_or_else(PoisonError::into_inner);
        let why = failure.clone().unwrap_or_default();
        Err(io::Error::other(format!("the disk has not taken what was written before: {why}")))
    }

    fn fail(&self, error: &io::Error) {
        *self.failure.lock().unwrap_or_else(PoisonError::into_inner) = Some(error.to_string());
        self.has_failed.store(true, Ordering::Release);
    }
}

impl Syncer {
    pub(super) fn start(interval: Duration) -> Self {
        let journals: Arc<Mutex<Vec<Entry>>> = Arc::default();
        let (sender, dropped) = channel::<()>();
        let shared = Arc::clone(&journals);
        let sync = move || {
            let mut due = Instant::now() + interval;
            while let Err(RecvTimeoutError::Timeout) =
                dropped.recv_timeout(due.saturating_duration_since(Instant::now()))
            {
                // Counted from the beginning of one to that of the next, so that nothing waits for longer.
                due = Instant::now() + interval;
                sync_all(&shared);
            }
            sync_all(&shared);
        };
        thread::Builder::new().name("journals".to_owned()).spawn(sync).expect("a thread at the start");
        Self { journals, _until_dropped: sender }
    }

    pub(super) fn add(&self, file: Arc<dyn Storage>) -> Arc<Health> {
        let health = Arc::new(Health::default());
        let entry = Entry { file, health: Arc::downgrade(&health) };
        self.journals.lock().unwrap_or_else(PoisonError::into_inner).push(entry);
        health
    }
}

/// Syncs those in which something was written. One that fails is never tried again: the system may have dropped what it could
/// not write, and would say that all is well.
fn sync_all(journals: &Mutex<Vec<Entry>>) {
    let dirty: Vec<(Arc<dyn Storage>, Arc<Health>)> = {
        let mut journals = journals.lock().unwrap_or_else(PoisonError::into_inner);
        journals.retain(|entry| entry.health.strong_count() > 0);
        let open =
            journals.iter().filter_map(|entry| Some((Arc::clone(&entry.file), entry.health.upgrade()?)));
        open.filter(|(_, health)| health.is_dirty.load(Ordering::Acquire)).collect()
    };
    for (file, health) in dirty {
        // Before the sync: what is written meanwhile may not be in it.
        health.is_dirty.store(false, Ordering::Release);
        if health.has_failed.load(Ordering::Acquire) {
            continue;
        }
        if let Err(error) = file.sync() {
            tracing::error!(%error, "ALARM: a journal is not on the disk; its match stops");
            health.fail(&error);
        }
    }
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::AtomicU32;

    use super::*;

    /// Counts how often it is synced.
    #[derive(Debug, Default)]
    struct Disk(AtomicU32);

    impl Storage for Disk {
        fn append(&self, _: &[u8]) -> io::Result<()> {
            Ok(())
        }

        fn sync(&self) -> io::Result<()> {
            self.0.fetch_add(1, Ordering::Relaxed);
            Ok(())
        }
    }

    #[test]
    fn what_was_written_during_a_sync_that_failed_is_not_synced_either() {
        let (disk, health) = (Arc::new(Disk::default()), Arc::new(Health::default()));
        let entry = Entry { file: Arc::<Disk>::clone(&disk), health: Arc::downgrade(&health) };
        let journals = Mutex::new(vec![entry]);
        for synced in [0, 1] {
            assert_eq!(disk.0.load(Ordering::Relaxed), synced);
            health.note_write();
            sync_all(&journals);
        }
        health.note_write();
        health.fail(&io::Error::other("gone"));
        sync_all(&journals);
        assert_eq!(disk.0.load(Ordering::Relaxed), 2);
    }
}
