//! Plays a match again from its records.

use maniple_view::Seat;

use super::Referee;
use crate::record::{RecordedEvent, ReplayError};

impl Referee {
    /// Does what a record says, and compares what comes out: a [`RecordedEvent::Hash`] plays a cycle (the first one
    /// only compares). Records go into a fresh referee, all of them in their order; what they make it record is
    /// dropped, and a delta that was not taken is too.
    ///
    /// # Errors
    /// See [`ReplayError`]. The match is of no use any more then.
    pub fn handle_record(&mut self, record: &RecordedEvent) -> Result<(), ReplayError> {
        let outcome = self.repeat(record);
        self.records.clear();
        outcome
    }

    fn repeat(&mut self, record: &RecordedEvent) -> Result<(), ReplayError> {
        let now = self.cycle();
        let misplaced = |problem| ReplayError::Order { now, problem };
        match record {
            RecordedEvent::Joined { cycle, seat, name } => {
                self.check_seat(*seat)?;
                if *cycle != now {
                    return Err(misplaced("has a player who joins in another cycle"));
                }
                self.handle_join(*seat, name).map_err(|_| misplaced("has a name that cannot be one"))
            }
            RecordedEvent::Commands { cycle, seat, seen_cycle, commands } => {
                self.check_seat(*seat)?;
                if *cycle != now {
                    return Err(misplaced("has commands for another cycle"));
                }
                self.handle_commands(*seat, *seen_cycle, commands.clone())
                    .map_err(|_| misplaced("has more commands than may wait for a cycle"))
            }
            RecordedEvent::Forfeited { cycle, seat } => {
                self.check_seat(*seat)?;
                if *cycle != now {
                    return Err(misplaced("has a forfeit of another cycle"));
                }
                self.forfeit(*seat);
                Ok(())
            }
            RecordedEvent::Hash { cycle, hash } => {
                if self.result().is_some() {
                    let found = self.result().cloned().map(Box::new);
                    return Err(ReplayError::Result { expected: None, found });
                }
                if *cycle != now {
                    self.play();
                }
                if *cycle != self.cycle() {
                    return Err(misplaced("has the hash of another cycle"));
                }
                let found = self.hash();
                if *hash == found {
                    Ok(())
                } else {
                    Err(ReplayError::Hash { cycle: *cycle, expected: *hash, found })
                }
            }
            RecordedEvent::Ended { result } if self.result() == Some(result) => Ok(()),
            RecordedEvent::Ended { result } => Err(ReplayError::Result {
                expected: Some(Box::new(result.clone())),
                found: self.result().cloned().map(Box::new),
            }),
        }
    }

    fn play(&mut self) {
        for state in &mut self.seats {
            state.delta = None;
        }
        self.records.clear();
        self.step();
    }

    fn check_seat(&self, seat: Seat) -> Result<(), ReplayError> {
        if seat.index() < self.seats() {
            return Ok(());
        }
        Err(ReplayError::Seat { seat, seats: self.seats() })
    }
}
