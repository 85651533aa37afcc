//! What a server lets its operators see and do.

use std::net::IpAddr;

use maniple_view::{Digest, Seat};

use super::{Clock, Entry, Health, MatchStatus, Operated, OperationError};
use crate::server::House;
use crate::settings::Limits;
use crate::simulation::Event;

impl House {
    fn send(&self, id: Digest, event: Event) -> Result<(), OperationError> {
        self.lobby.send(id, event).ok_or(OperationError::NoSuchMatch { id })
    }
}

impl Operated for House {
    fn health(&self) -> Health {
        if self.lobby.is_draining() { Health::Draining } else { Health::Ready }
    }

    fn matches(&self) -> Vec<MatchStatus> {
        self.lobby.statuses()
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
        House::change_limits(self, limits);
    }
}
