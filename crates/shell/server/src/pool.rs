//! Who plays the matches: threads of their own, or, in a runtime without threads, tasks.
//!
//! A match is played by turns. A turn plays the cycle that is due and answers what has come in, and says when the next is
//! due. Whoever has something for a match wakes it. So a few threads play hundreds of matches, the one that has waited
//! longest first, and none of them is a thread of the runtime: there a long cycle would hold up connections, and
//! connections a cycle.

use std::cmp::Reverse;
use std::collections::{BTreeMap, BinaryHeap};
use std::io;
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::{self, JoinHandle};
use std::time::Duration;

use tokio::sync::Notify;
use tokio::time::{Instant, sleep_until};

/// What is played by turns.
pub(crate) trait Player: Send {
    /// Does what there is to do now. It never waits, and does not panic: whoever plays many must not lose a thread.
    fn turn(&mut self) -> Turn;
}

/// When there is something to do again.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Turn {
    /// At this time, or when it is woken before.
    At(Instant),
    /// When it is woken.
    Woken,
    /// Never: it is dropped.
    Over,
}

/// Who plays the matches.
#[derive(Clone, Debug)]
pub(crate) enum Pool {
    /// Threads.
    Threads(Arc<Threads>),
    /// A task each, on the runtime of whoever enters it: for tests, in which time is simulated.
    Tasks,
}

/// Wakes a player.
#[derive(Clone, Debug)]
pub(crate) enum Waker {
    /// One that threads play, by its number.
    Thread(Arc<Threads>, u64),
    /// One that a task plays.
    Task(Arc<Notify>),
}

/// Threads that play.
#[derive(Debug)]
pub(crate) struct Threads {
    queue: Mutex<Queue>,
    /// There is something to do, or something is due earlier than before.
    changed: Condvar,
}

#[derive(Default)]
struct Queue {
    players: BTreeMap<u64, Entry>,
    /// When who is due; entries that are not those of the player any more are skipped.
    agenda: BinaryHeap<Reverse<(Instant, u64)>>,
    next: u64,
    is_closed: bool,
}

struct Entry {
    /// `None` while a thread plays it.
    player: Option<Box<dyn Player>>,
    due: Option<Instant>,
    /// Since when a thread plays it.
    begun: Option<Instant>,
    /// Whether it was woken while a thread played it.
    is_woken: bool,
}

impl Pool {
    /// Returns a pool of so many threads.
    ///
    /// # Errors
    /// An operating system that gives no thread.
    pub(crate) fn with_threads(count: usize) -> io::Result<Self> {
        let threads = Arc::new(Threads { queue: Mutex::default(), changed: Condvar::new() });
        for number in 0..count {
            let shared = Arc::clone(&threads);
            let _detached: JoinHandle<()> =
                thread::Builder::new().name(format!("simulation {number}")).spawn(move || shared.work())?;
        }
        Ok(Self::Threads(threads))
    }

    /// Takes a player in: its first turn is at once. `make` gets the means to wake it.
    pub(crate) fn enter<P: Player + 'static>(&self, make: impl FnOnce(Waker) -> P) {
        match self {
            Self::Threads(threads) => {
                let number = threads.lock().take_number();
                threads.put(number, Box::new(make(Waker::Thread(Arc::clone(threads), number))));
            }
            Self::Tasks => {
                let notify = Arc::new(Notify::new());
                let mut player = make(Waker::Task(Arc::clone(&notify)));
                tokio::spawn(async move {
                    loop {
                        match player.turn() {
                            Turn::At(due) => tokio::select! {
                                () = sleep_until(due) => {}
                                () = notify.notified() => {}
                            },
                            Turn::Woken => notify.notified().await,
                            Turn::Over => return,
                        }
                    }
                });
            }
        }
    }

    /// Returns the longest time for which somebody has been due, or has had a turn that goes on: whether the threads do their work.
    pub(crate) fn longest_wait(&self) -> Duration {
        match self {
            Self::Threads(threads) => threads.lock().longest_wait(Instant::now()),
            Self::Tasks => Duration::ZERO,
        }
    }

    /// Lets the threads end once nothing is played any more.
    pub(crate) fn close(&self) {
        match self {
            Self::Threads(threads) => {
                threads.lock().is_closed = true;
                threads.changed.notify_all();
            }
            Self::Tasks => {}
        }
    }
}

impl Waker {
    /// Lets a player have a turn as soon as may be; nothing happens if it is over.
    pub(crate) fn wake(&self) {
        match self {
            Self::Thread(threads, number) => threads.wake(*number),
            Self::Task(notify) => notify.notify_one(),
        }
    }
}

impl Threads {
    fn lock(&self) -> MutexGuard<'_, Queue> {
        // What it guards is changed in single steps, so it is whole even then.
        self.queue.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn put(&self, number: u64, player: Box<dyn Player>) {
        let mut queue = self.lock();
        queue.players.insert(number, Entry { player: Some(player), due: None, begun: None, is_woken: false });
        queue.schedule(number, Instant::now());
        drop(queue);
        self.changed.notify_one();
    }

    fn wake(&self, number: u64) {
        let mut queue = self.lock();
        let Some(entry) = queue.players.get_mut(&number) else { return };
        if entry.player.is_none() {
            entry.is_woken = true;
            return;
        }
        let now = Instant::now();
        if entry.due.is_some_and(|due| due <= now) {
            return;
        }
        queue.schedule(number, now);
        drop(queue);
        self.changed.notify_one();
    }

    fn work(&self) {
        while let Some((number, mut player)) = self.take() {
            let turn = player.turn();
            let mut queue = self.lock();
            let Some(entry) = queue.players.get_mut(&number) else { continue };
            entry.player = Some(player);
            entry.begun = None;
            let is_woken = std::mem::take(&mut entry.is_woken);
            match turn {
                Turn::Over => {
                    let over = queue.players.remove(&number);
                    drop(queue);
                    // What it holds is let go without the lock.
                    drop(over);
                    self.changed.notify_all();
                }
                Turn::At(_) | Turn::Woken if is_woken => queue.schedule(number, Instant::now()),
                Turn::At(due) => queue.schedule(number, due),
                Turn::Woken => {}
            }
        }
    }

    /// Waits until somebody is due, and returns who; `None` once nothing is left to do for ever.
    fn take(&self) -> Option<(u64, Box<dyn Player>)> {
        let mut queue = self.lock();
        loop {
            let now = Instant::now();
            queue.drop_stale();
            let earliest = queue.agenda.peek().map(|&Reverse(first)| first);
            match earliest {
                Some((due, number)) if due <= now => {
                    queue.agenda.pop();
                    let entry = queue.players.get_mut(&number)?;
                    entry.due = None;
                    entry.begun = Some(now);
                    let player = entry.player.take()?;
                    // Another thread watches for the next.
                    self.changed.notify_one();
                    return Some((number, player));
                }
                Some((due, _)) => {
                    let waited = self.changed.wait_timeout(queue, due - now);
                    queue = waited.unwrap_or_else(PoisonError::into_inner).0;
                }
                None if queue.is_closed && queue.players.is_empty() => return None,
                None => queue = self.changed.wait(queue).unwrap_or_else(PoisonError::into_inner),
            }
        }
    }
}

impl Queue {
    fn take_number(&mut self) -> u64 {
        self.next += 1;
        self.next
    }

    fn longest_wait(&self, now: Instant) -> Duration {
        let since = self.players.values().filter_map(|entry| entry.begun.or(entry.due)).min();
        since.map_or(Duration::ZERO, |since| now.saturating_duration_since(since))
    }

    fn schedule(&mut self, number: u64, due: Instant) {
        if let Some(entry) = self.players.get_mut(&number) {
            entry.due = Some(due);
            self.agenda.push(Reverse((due, number)));
        }
    }

    /// Drops the entries at the front that somebody woken or over has left behind.
    fn drop_stale(&mut self) {
        while let Some(&Reverse((due, number))) = self.agenda.peek() {
            let holds = |entry: &Entry| entry.due == Some(due) && entry.player.is_some();
            if self.players.get(&number).is_some_and(holds) {
                return;
            }
            self.agenda.pop();
        }
    }
}

impl std::fmt::Debug for Queue {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Queue").field("players", &self.players.len()).finish_non_exhaustive()
    }
}

#[cfg(test)]
mod tests {
    use std::sync::mpsc::{Receiver, Sender, channel};

    use super::*;

    /// Does what it is told, one letter a turn, and tells which turn it has.
    struct Actor {
        name: u32,
        turns: u32,
        plan: Box<dyn FnMut(u32) -> Turn + Send>,
        told: Sender<(u32, u32)>,
    }

    impl Player for Actor {
        fn turn(&mut self) -> Turn {
            self.turns += 1;
            self.told.send((self.name, self.turns)).unwrap();
            (self.plan)(self.turns)
        }
    }

    #[test]
    fn whoever_is_due_has_a_turn_and_whoever_is_woken_too() {
        for threads in [1, 3] {
            let pool = Pool::with_threads(threads).unwrap();
            let (told, heard) = channel();
            let waker = enter(&pool, 1, &told, |_| Turn::Woken);
            assert_eq!(heard.recv(), Ok((1, 1)));
            waker.wake();
            assert_eq!(heard.recv(), Ok((1, 2)));
            let soon = |_| Turn::At(Instant::now() + Duration::from_millis(5));
            enter(&pool, 2, &told, soon);
            for turn in 1..5 {
                assert_eq!(heard.recv(), Ok((2, turn)));
            }
            wake_all(&pool, &heard, &waker);
        }
    }

    fn wake_all(pool: &Pool, heard: &Receiver<(u32, u32)>, waker: &Waker) {
        waker.wake();
        while heard.recv().unwrap().0 != 1 {}
        let Pool::Threads(threads) = pool else { unreachable!("made with threads") };
        assert_eq!(threads.lock().players.len(), 2);
        pool.close();
    }

    #[test]
    fn a_wake_in_the_middle_of_a_turn_is_not_lost() {
        let pool = Pool::with_threads(1).unwrap();
        let (told, heard) = channel();
        let (give, wakers) = channel::<Waker>();
        let mut own = None;
        let waker = enter(&pool, 1, &told, move |turn| {
            if turn > 20 {
                return Turn::Over;
            }
            let own = own.get_or_insert_with(|| wakers.recv().unwrap());
            own.wake();
            own.wake();
            Turn::Woken
        });
        give.send(waker).unwrap();
        for turn in 1..=21 {
            assert_eq!(heard.recv(), Ok((1, turn)));
        }
    }

    #[test]
    fn a_turn_that_does_not_end_is_seen_until_it_does() {
        let pool = Pool::with_threads(1).unwrap();
        let (told, heard) = channel();
        let (release, held) = channel::<()>();
        enter(&pool, 1, &told, move |_| {
            held.recv().unwrap();
            Turn::Woken
        });
        assert_eq!(heard.recv(), Ok((1, 1)));
        let hour = Duration::from_secs(3600);
        let Pool::Threads(threads) = &pool else { unreachable!("made with threads") };
        let in_an_hour = || threads.lock().longest_wait(Instant::now() + hour);
        assert!(in_an_hour() >= hour, "the turn goes on");
        let (other_told, other_heard) = channel();
        enter(&pool, 2, &other_told, |_| Turn::Over);
        drop(other_told);
        release.send(()).unwrap();
        assert_eq!(other_heard.recv(), Ok((2, 1)), "the other was waiting for the thread");
        // The one thread is done with the first before it begins with the other.
        assert!(other_heard.recv().is_err(), "the other is over");
        assert_eq!(in_an_hour(), Duration::ZERO, "nobody waits, and no turn goes on");
        pool.close();
    }

    #[test]
    fn who_is_due_and_has_no_turn_is_seen_too() {
        let (mut queue, now, hour) = (Queue::default(), Instant::now(), Duration::from_secs(3600));
        let number = queue.take_number();
        queue.players.insert(number, Entry { player: None, due: None, begun: None, is_woken: false });
        assert_eq!(queue.longest_wait(now), Duration::ZERO, "it has nothing to do");
        queue.schedule(number, now + hour);
        assert_eq!(queue.longest_wait(now), Duration::ZERO, "it is not due");
        assert_eq!(queue.longest_wait(now + 3 * hour), 2 * hour);
    }

    #[test]
    fn who_is_over_is_dropped_and_a_closed_pool_ends() {
        let pool = Pool::with_threads(2).unwrap();
        let (told, heard) = channel();
        let waker = enter(&pool, 1, &told, |_| Turn::Over);
        assert_eq!(heard.recv(), Ok((1, 1)));
        drop(told);
        assert!(heard.recv().is_err(), "the player is dropped");
        waker.wake();
        pool.close();
        let Pool::Threads(threads) = pool else { unreachable!("made with threads") };
        assert!(threads.take().is_none());
    }

    #[tokio::test(start_paused = true)]
    async fn tasks_play_in_the_time_of_their_runtime() {
        let (told, heard) = channel();
        let start = Instant::now();
        let hour = Duration::from_secs(3600);
        let waker = enter(&Pool::Tasks, 1, &told, move |turn| match turn {
            1..=3 => Turn::At(start + hour * turn),
            4 => Turn::Woken,
            _ => Turn::Over,
        });
        tokio::time::sleep(hour * 4).await;
        assert_eq!(heard.try_iter().last(), Some((1, 4)));
        waker.wake();
        tokio::time::sleep(hour).await;
        assert_eq!(heard.try_iter().last(), Some((1, 5)));
    }

    fn enter(
        pool: &Pool,
        name: u32,
        told: &Sender<(u32, u32)>,
        plan: impl FnMut(u32) -> Turn + Send + 'static,
    ) -> Waker {
        let mut kept = None;
        pool.enter(|waker| {
            kept = Some(waker);
            Actor { name, turns: 0, plan: Box::new(plan), told: told.clone() }
        });
        kept.expect("a player is made at once")
    }
}
