use std::io::{self, Write};

use maniple_game::{Files, LoadedFile, Overrides, load};

use super::*;
use crate::doors::{Access, Doors};
use crate::pool::Waker;

#[test]
fn a_cycle_that_is_due_does_not_wait_for_who_talks_on() {
    let (mailbox, events) = Mailbox::new(Waker::Task(Arc::default()));
    let mut simulation = Simulation::new(played(events));
    for _ in 0..=EVENTS_BEFORE_STEP_MAX {
        mailbox.send(Event::Gone { connection: ConnectionId(9) }).unwrap();
    }
    assert!(!simulation.take_in(), "one has to wait");
    assert!(simulation.take_in(), "it has its turn");
}

#[test]
fn a_match_that_cannot_be_recorded_any_more_ends_and_says_why() {
    /// Takes the header, and nothing else.
    struct Full(bool);
    impl Write for Full {
        fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
            let is_full = std::mem::replace(&mut self.0, true);
            if is_full { Err(io::ErrorKind::StorageFull.into()) } else { Ok(bytes.len()) }
        }

        fn flush(&mut self) -> io::Result<()> {
            Ok(())
        }
    }
    let (_mailbox, events) = Mailbox::new(Waker::Task(Arc::default()));
    let (finished, mut outcome) = oneshot::channel();
    let played = played(events);
    let sink = Sink::Replay(Box::new(Full(false)));
    let recording = Some(Recording::begin(played.referee.loaded(), sink).unwrap());
    let mut simulation = Simulation::new(Played { recording, finished, ..played });
    assert_eq!(simulation.turn(), Turn::Over);
    assert!(matches!(outcome.try_recv(), Ok(Err(RunError::Recording(RecordingError::Write(_))))));
}

/// Returns a match that nobody has joined.
fn played(events: Receiver<Event>) -> Played {
    let seat = "{ groups = [{ unit = 'a', count = 1 }] }";
    let scenario = format!(
        "name = 'tiny'\nmap = 'tiny.map'\nseed = 5\nlength_seconds = 9\nseat = [{seat}, {seat}]\n\
         objective = {{ kind = 'race', zone_size = 3 }}\nunit.a = {{ radius = 0.3, speed = 4, sight = 5 }}\n"
    );
    let map = format!("type octile\nheight 12\nwidth 24\nmap\n{}", "........................\n".repeat(12));
    let file = |path: &str, text: &str| LoadedFile { path: path.to_owned(), bytes: text.into() };
    let files = Files(vec![file("tiny.toml", &scenario), file("tiny.map", &map)]);
    let loaded = load(&files, "tiny.toml", &Overrides::default()).unwrap();
    Played {
        referee: Referee::new(loaded, ClockMode::Realtime).unwrap(),
        id: Digest(1),
        table: Table::new(Arc::new(Doors::new(vec![Access::Open; 2], 8))),
        recording: None,
        events,
        finished: oneshot::channel().0,
        occupancy: Arc::new(Occupancy::new(Arc::default())),
        begin_within: None,
        is_resumed: false,
    }
}

#[test]
fn the_clocks_of_matches_start_anywhere_within_a_period() {
    for (id, share) in [(0, 0.0), (1 << 63, 0.5), (1 << 62, 0.25)] {
        assert_eq!(phase(Digest(id)), share);
    }
    assert!(phase(Digest(u64::MAX)) < 1.0);
}
