//! Who sits where.

use maniple_protocol::{Refused, ServerMessage};
use maniple_view::Seat;

use crate::connection::ConnectionId;
use crate::link::Link;
use crate::token::Token;

/// Who may take a seat.
#[derive(Clone, Copy, Debug)]
pub enum Access {
    /// Whoever comes without a token while nobody sits there.
    Open,
    /// Whoever has the token; a seat that is taken is taken over.
    Token(Token),
}

/// The seats of a match and the connections at them.
#[derive(Debug)]
pub(crate) struct Table {
    places: Vec<Place>,
}

#[derive(Debug)]
struct Place {
    access: Access,
    occupant: Option<Occupant>,
}

#[derive(Debug)]
struct Occupant {
    connection: ConnectionId,
    link: Link,
}

impl Table {
    /// Returns the table with these seats, in order; nobody is there.
    pub(crate) fn new(access: &[Access]) -> Self {
        Self { places: access.iter().map(|&access| Place { access, occupant: None }).collect() }
    }

    /// Lets a connection sit down; returns the one that sat there before.
    pub(crate) fn sit(&mut self, seat: Seat, connection: ConnectionId, link: Link) -> Option<Link> {
        let before = self.places[seat.index()].occupant.replace(Occupant { connection, link });
        before.map(|occupant| occupant.link)
    }

    /// Lets whoever is at a seat get up, and returns the connection.
    pub(crate) fn leave(&mut self, seat: Seat) -> Option<Link> {
        self.places[seat.index()].occupant.take().map(|occupant| occupant.link)
    }

    /// Returns the seat that a hello with this token gets.
    ///
    /// # Errors
    /// The reason that the client is told.
    pub(crate) fn seat_for(&self, token: &str) -> Result<Seat, Refused> {
        if token.is_empty() { self.open_seat() } else { self.seat_of_token(token) }
    }

    /// Queues a message for whoever is at a seat.
    ///
    /// # Errors
    /// Why the connection has to be closed.
    pub(crate) fn push(&self, seat: Seat, message: &ServerMessage) -> Result<(), Refused> {
        self.places[seat.index()].occupant.as_ref().map_or(Ok(()), |occupant| occupant.link.push(message))
    }

    /// Returns the seat of a connection; `None` if it has none, or none any more.
    pub(crate) fn seat_of(&self, connection: ConnectionId) -> Option<Seat> {
        let is_there =
            |place: &Place| place.occupant.as_ref().is_some_and(|occupant| occupant.connection == connection);
        self.seats().zip(&self.places).find(|(_, place)| is_there(place)).map(|(seat, _)| seat)
    }

    /// Returns all seats.
    pub(crate) fn seats(&self) -> impl Iterator<Item = Seat> + use<> {
        (0..).map(Seat).take(self.places.len())
    }

    fn open_seat(&self) -> Result<Seat, Refused> {
        let mut open = self.seats().zip(&self.places).filter(|(_, place)| match place.access {
            Access::Open => true,
            Access::Token(_) => false,
        });
        let mut refusal = Refused::Token;
        open.find(|(_, place)| {
            refusal = Refused::Full;
            place.occupant.is_none()
        })
        .map(|(seat, _)| seat)
        .ok_or(refusal)
    }

    /// Compares with every seat's token, found or not, so that the time tells nothing.
    fn seat_of_token(&self, token: &str) -> Result<Seat, Refused> {
        let token: Token = token.parse().map_err(|_| Refused::Token)?;
        let mut found = Err(Refused::Token);
        for (seat, place) in self.seats().zip(&self.places) {
            match place.access {
                Access::Token(own) if own.is_same(token) => found = Ok(seat),
                Access::Token(_) | Access::Open => {}
            }
        }
        found
    }
}

#[cfg(test)]
mod tests {
    use maniple_protocol::Encoding;

    use super::*;

    #[test]
    fn a_token_opens_its_seat_whoever_sits_there() {
        let (a, b) = (Token::random().unwrap(), Token::random().unwrap());
        let mut table = Table::new(&[Access::Token(a), Access::Open, Access::Token(b)]);
        assert_eq!(table.seat_for(&b.to_string()), Ok(Seat(2)));
        assert_eq!(table.seat_for(&Token::random().unwrap().to_string()), Err(Refused::Token));
        assert_eq!(table.seat_for("nonsense"), Err(Refused::Token));
        assert!(table.sit(Seat(2), ConnectionId(7), link()).is_none());
        assert_eq!(table.seat_for(&b.to_string()), Ok(Seat(2)));
        assert!(table.sit(Seat(2), ConnectionId(8), link()).is_some());
        assert_eq!((table.seat_of(ConnectionId(7)), table.seat_of(ConnectionId(8))), (None, Some(Seat(2))));
    }

    #[test]
    fn open_seats_are_filled_in_order_and_again_when_left() {
        let token = Access::Token(Token::random().unwrap());
        let mut table = Table::new(&[Access::Open, token, Access::Open]);
        for (connection, seat) in [(ConnectionId(1), Seat(0)), (ConnectionId(2), Seat(2))] {
            assert_eq!(table.seat_for(""), Ok(seat));
            table.sit(seat, connection, link());
        }
        assert_eq!(table.seat_for(""), Err(Refused::Full));
        assert!(table.leave(Seat(0)).is_some());
        assert_eq!(table.seat_for(""), Ok(Seat(0)));
        assert_eq!(Table::new(&[token]).seat_for(""), Err(Refused::Token));
    }

    fn link() -> Link {
        Link::new(Encoding::Binary).0
    }
}
