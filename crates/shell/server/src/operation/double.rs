//! A daemon for tests: one match, and a list of what was asked of it.

use std::sync::Mutex;

use super::*;

fn spread(max: f64) -> Spread {
    Spread { p50: max / 4.0, p99: max / 2.0, max }
}

pub(super) const MATCH: Digest = Digest(7);

#[derive(Debug)]
pub(super) struct Double {
    pub(super) health: Mutex<Health>,
    pub(super) done: Mutex<Vec<String>>,
}

impl Double {
    pub(super) fn new(health: Health) -> Self {
        Self { health: Mutex::new(health), done: Mutex::default() }
    }

    pub(super) fn done(&self) -> Vec<String> {
        std::mem::take(&mut self.done.lock().unwrap())
    }

    fn note(&self, done: String) {
        self.done.lock().unwrap().push(done);
    }

    fn find(id: Digest) -> Result<(), OperationError> {
        if id == MATCH { Ok(()) } else { Err(OperationError::NoSuchMatch { id }) }
    }
}

impl Operated for Double {
    fn health(&self) -> Health {
        *self.health.lock().unwrap()
    }

    fn matches(&self) -> Vec<MatchStatus> {
        vec![MatchStatus {
            id: MATCH,
            scenario: "duel".to_owned(),
            clock: ClockMode::Realtime,
            phase: Phase::Running,
            cycle: 12,
            seats: 2,
            players: 1,
            spectators: 3,
            timings_ms: MatchTimings { cycle: spread(0.5), lateness: spread(1.0), jitter: spread(1.5) },
        }]
    }

    fn create(&self, wanted: Wanted) -> Creating<'_> {
        Box::pin(async move {
            if wanted.scenario != "duel" {
                return Err(OperationError::NotCreated { reason: Refused::NoScenario });
            }
            self.note(format!("create {:?} {:?}", wanted.clock, wanted.seats));
            Ok(CreatedMatch { id: MATCH, tokens: vec!["one".to_owned(), "other".to_owned()] })
        })
    }

    fn pause(&self, id: Digest, clock: Clock) -> Result<(), OperationError> {
        Self::find(id)?;
        self.note(format!("pause {id} {clock:?}"));
        Ok(())
    }

    fn end(&self, id: Digest) -> Result<(), OperationError> {
        Self::find(id)?;
        self.note(format!("end {id}"));
        Ok(())
    }

    fn kick(&self, id: Digest, seat: Seat) -> Result<(), OperationError> {
        Self::find(id)?;
        match seat.0 {
            0 => self.note(format!("kick {id} {seat}")),
            1 => return Err(OperationError::NobodyThere { seat }),
            _ => return Err(OperationError::NoSuchSeat { seats: 2 }),
        }
        Ok(())
    }

    fn ban(&self, address: IpAddr, entry: Entry) -> Result<(), OperationError> {
        self.note(format!("ban {address} {entry:?}"));
        Ok(())
    }

    fn drain(&self) {
        self.note("drain".to_owned());
    }

    fn change_limits(&self, limits: Limits) {
        self.note(format!("limits {limits:?}"));
    }
}
