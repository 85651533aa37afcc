//! Who sits where.

use std::sync::Arc;

use maniple_protocol::{Refused, ServerMessage};
use maniple_view::Seat;

use crate::connection::ConnectionId;
use crate::doors::Doors;
use crate::link::Link;

/// The seats of a match and the connections at them.
#[derive(Debug)]
pub(crate) struct Table {
    doors: Arc<Doors>,
    /// By seat.
    occupants: Vec<Option<Occupant>>,
}

#[derive(Debug)]
struct Occupant {
    connection: ConnectionId,
    link: Link,
}

impl Table {
    /// Returns the table behind these doors; nobody is there.
    pub(crate) fn new(doors: Arc<Doors>) -> Self {
        let occupants = doors.seats().map(|_| None).collect();
        Self { doors, occupants }
    }

    /// Lets a connection sit down; returns the one that sat there before.
    pub(crate) fn sit(&mut self, seat: Seat, connection: ConnectionId, link: Link) -> Option<Link> {
        let before = self.occupants[seat.index()].replace(Occupant { connection, link });
        before.map(|occupant| occupant.link)
    }

    /// Lets whoever is at a seat get up, and returns the connection.
    pub(crate) fn leave(&mut self, seat: Seat) -> Option<Link> {
        self.occupants[seat.index()].take().map(|occupant| occupant.link)
    }

    /// Returns the seat that a hello with this token gets: that of the token, or without one the open seat that it wants, or the
    /// first, where nobody sits.
    ///
    /// # Errors
    /// The reason that the client is told.
    pub(crate) fn seat_for(&self, token: &str, wanted: Option<Seat>) -> Result<Seat, Refused> {
        if !token.is_empty() {
            return self.doors.seat_of_token(token);
        }
        if let Some(wanted) = wanted
            && wanted.index() >= self.occupants.len()
        {
            let seats = u16::try_from(self.occupants.len()).expect("seats are counted in 16 bits");
            return Err(Refused::NoSuchSeat { seats });
        }
        let is_wanted = |seat: Seat| wanted.is_none_or(|wanted| wanted == seat);
        let is_free = |seat: &Seat| is_wanted(*seat) && self.occupants[seat.index()].is_none();
        let refusal =
            || if self.doors.open_seats().next().is_some() { Refused::Full } else { Refused::Token };
        self.doors.open_seats().find(is_free).ok_or_else(refusal)
    }

    /// Queues a message for whoever is at a seat.
    ///
    /// # Errors
    /// Why the connection has to be closed.
    pub(crate) fn push(&mut self, seat: Seat, message: &ServerMessage) -> Result<(), Refused> {
        self.occupants[seat.index()].as_mut().map_or(Ok(()), |occupant| occupant.link.push(message))
    }

    /// Returns the seat of a connection; `None` if it has none, or none any more.
    pub(crate) fn seat_of(&self, connection: ConnectionId) -> Option<Seat> {
        let is_at = |seat: &Seat| {
            self.occupants[seat.index()].as_ref().is_some_and(|occupant| occupant.connection == connection)
        };
        self.seats().find(is_at)
    }

    /// Returns how many messages wait for connections to take them.
    pub(crate) fn waiting(&self) -> usize {
        self.occupants.iter().flatten().map(|occupant| occupant.link.waiting()).sum()
    }

    /// Returns all seats.
    pub(crate) fn seats(&self) -> impl Iterator<Item = Seat> + use<> {
        self.doors.seats()
    }
}

#[cfg(test)]
mod tests {
    use maniple_protocol::Encoding;

    use super::*;
    use crate::doors::Access;
    use crate::token::Token;

    #[test]
    fn a_token_opens_its_seat_whoever_sits_there() {
        let token = Token::random().unwrap();
        let mut table = table(vec![Access::Open, Access::Token(token)]);
        for (connection, is_taken_over) in [(ConnectionId(7), false), (ConnectionId(8), true)] {
            assert_eq!(table.seat_for(&token.to_string(), None), Ok(Seat(1)));
            assert_eq!(table.sit(Seat(1), connection, link()).is_some(), is_taken_over);
        }
        assert_eq!((table.seat_of(ConnectionId(7)), table.seat_of(ConnectionId(8))), (None, Some(Seat(1))));
    }

    #[test]
    fn open_seats_are_filled_in_order_and_again_when_left() {
        let token = Access::Token(Token::random().unwrap());
        let mut open = table(vec![Access::Open, token, Access::Open]);
        for (connection, seat) in [(ConnectionId(1), Seat(0)), (ConnectionId(2), Seat(2))] {
            assert_eq!(open.seat_for("", None), Ok(seat));
            open.sit(seat, connection, link());
        }
        assert_eq!(open.seat_for("", None), Err(Refused::Full));
        assert_eq!(open.seat_for("", Some(Seat(2))), Err(Refused::Full));
        assert!(open.leave(Seat(0)).is_some());
        assert_eq!(open.seat_for("", None), Ok(Seat(0)));
        assert_eq!(open.seat_for("", Some(Seat(0))), Ok(Seat(0)));
        assert_eq!(open.seat_for("", Some(Seat(3))), Err(Refused::NoSuchSeat { seats: 3 }));
        assert_eq!(open.seat_for("", Some(Seat(1))), Err(Refused::Full), "that one needs its token");
        assert_eq!(table(vec![token]).seat_for("", None), Err(Refused::Token));
    }

    fn table(access: Vec<Access>) -> Table {
        Table::new(Arc::new(Doors::new(access)))
    }

    fn link() -> Link {
        Link::new(Encoding::Binary).0
    }
}
