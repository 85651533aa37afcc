//! What a server lets its operators see and do.

use std::net::IpAddr;
use std::sync::atomic::Ordering;

use maniple_protocol::{Create, PROTOCOL};
use maniple_view::{Digest, Seat};

use super::{
    Clock, CreatedMatch, Creating, Entry, Health, MatchStatus, Operated, OperationError, STUCK_AFTER, Seats,
    Wanted,
};
use crate::server::House;
use crate::settings::Limits;
use crate::simulation::Event;

impl House {
    /// Notes that the daemon has begun: clients can connect.
    pub fn note_ready(&self) {
        self.is_ready.store(true, Ordering::Relaxed);
    }

    fn send(&self, id: Digest, event: Event) -> Result<(), OperationError> {
        self.lobby.send(id, event).ok_or(OperationError::NoSuchMatch { id })
    }
}

impl Operated for House {
    fn health(&self) -> Health {
        if self.lobby.longest_wait() >= STUCK_AFTER {
            Health::Stuck
        } else if self.lobby.is_draining() {
            Health::Draining
        } else if self.is_ready.load(Ordering::Relaxed) {
            Health::Ready
        } else {
            Health::Starting
        }
    }

    fn matches(&self) -> Vec<MatchStatus> {
        self.lobby.statuses()
    }

    fn create(&self, Wanted { scenario, clock, seats }: Wanted) -> Creating<'_> {
        let open = match seats {
            Seats::Tokens => false,
            Seats::Open => true,
        };
        Box::pin(async move {
            let wanted = Create { protocol: PROTOCOL, scenario, clock, open };
            let created = self.lobby.create_for(wanted, None).await;
            let (id, tokens) = created.map_err(|reason| OperationError::NotCreated { reason })?;
            Ok(CreatedMatch { id, tokens })
        })
    }

    fn pause(&self, id: Digest, clock: Clock) -> Result<(), OperationError> {
        self.send(id, Event::Clock(clock))
    }

    fn end(&self, id: Digest) -> Result<(), OperationError> {
        self.send(id, Event::CallOff)
    }

    fn kick(&self, id: Digest, seat: Seat) -> Result<(), OperationError> {
        let taken = self.lobby.taken(id).ok_or(OperationError::NoSuchMatch { id })?;
        match taken.get(seat.index()) {
            Some(true) => self.send(id, Event::PutOut(seat)),
            Some(false) => Err(OperationError::NobodyThere { seat }),
            None => {
                let seats = u16::try_from(taken.len()).expect("seats are counted in 16 bits");
                Err(OperationError::NoSuchSeat { seats })
            }
        }
    }

    fn ban(&self, address: IpAddr, entry: Entry) -> Result<(), OperationError> {
        self.bans.change(address, entry)
    }

    fn drain(&self) {
        self.lobby.drain();
    }

    fn change_limits(&self, limits: Limits) {
        Self::change_limits(self, limits);
    }
}
