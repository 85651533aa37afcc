//! Who sits where.

use std::collections::VecDeque;
use std::sync::Arc;

use maniple_geometry::Cycle;
use maniple_protocol::{Feed, Refused, ServerMessage, Turn, Welcome, encode_server};
use maniple_view::{CommandResult, Delta, Ended, Seat};

use crate::connection::ConnectionId;
use crate::doors::Doors;
use crate::link::{Link, unsendable};

/// Results of commands and ends of tasks that wait to be told to a client that lags too far for a merged delta: as many results as four
/// cycles can have. They cannot be left out, so there must be an end to them.
pub const NEWS_WAITING_MAX: usize = 1 << 16;

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
    /// `None` before the welcome.
    feed: Option<Feed>,
    news: News,
}

/// What a keyframe does not tell, and the client was not told either.
#[derive(Debug, Default)]
struct News {
    results: Vec<CommandResult>,
    ended: Vec<Ended>,
}

impl Table {
    /// Returns the table behind these doors; nobody is there.
    pub(crate) fn new(doors: Arc<Doors>) -> Self {
        let occupants = doors.seats().map(|_| None).collect();
        Self { doors, occupants }
    }

    /// Lets a connection sit down; returns the one that sat there before.
    pub(crate) fn sit(&mut self, seat: Seat, connection: ConnectionId, link: Link) -> Option<Link> {
        let before = self.occupants[seat.index()].replace(Occupant::new(connection, link));
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

    /// Tells whoever sits down all that it needs to know, and the view as it is.
    ///
    /// # Errors
    /// Why the connection has to be closed.
    pub(crate) fn welcome(&mut self, seat: Seat, welcome: Welcome, keyframe: Delta) -> Result<(), Refused> {
        self.occupant(seat).map_or(Ok(()), |occupant| occupant.begin(welcome, keyframe))
    }

    /// Queues a message other than a delta for whoever is at a seat.
    ///
    /// # Errors
    /// Why the connection has to be closed.
    pub(crate) fn push(&mut self, seat: Seat, message: &ServerMessage) -> Result<(), Refused> {
        self.occupant(seat).map_or(Ok(()), |occupant| occupant.link.push(message))
    }

    /// Takes the next delta of a seat. Whoever is there is told, unless it lags.
    ///
    /// # Errors
    /// Why the connection has to be closed.
    pub(crate) fn push_delta(
        &mut self,
        seat: Seat,
        delta: Delta,
        keyframe: impl FnOnce() -> Delta,
    ) -> Result<(), Refused> {
        self.occupant(seat).map_or(Ok(()), |occupant| occupant.push(delta, keyframe))
    }

    /// Takes that whoever is at a seat gives commands that were decided on the view of cycle `seen`.
    pub(crate) fn handle_commands(&mut self, seat: Seat, now: Cycle, seen: Cycle) {
        if let Some(occupant) = self.occupant(seat) {
            occupant.link.handle_commands(now, seen);
        }
    }

    /// Takes that whoever is at a seat is done with a delta.
    pub(crate) fn handle_done(&mut self, seat: Seat, cycle: Cycle) {
        if let Some(occupant) = self.occupant(seat) {
            occupant.link.handle_done(cycle);
        }
    }

    /// Tells whoever is at a seat what it has missed, if it has caught up with what was sent.
    ///
    /// # Errors
    /// Why the connection has to be closed.
    pub(crate) fn catch_up(&mut self, seat: Seat, keyframe: impl FnOnce() -> Delta) -> Result<(), Refused> {
        self.occupant(seat).map_or(Ok(()), |occupant| occupant.catch_up(keyframe))
    }

    /// Takes that what whoever is at a seat said was dropped.
    ///
    /// # Errors
    /// Why the connection has to be closed.
    pub(crate) fn handle_violation(&mut self, seat: Seat, reason: Refused) -> Result<(), Refused> {
        self.occupant(seat).map_or(Ok(()), |occupant| occupant.link.handle_violation(reason))
    }

    /// Tells whoever is at a seat all that it was not told yet and the last message, and closes the connection.
    pub(crate) fn close(&mut self, seat: Seat, last: &ServerMessage, keyframe: impl FnOnce() -> Delta) {
        let Some(mut occupant) = self.occupants[seat.index()].take() else { return };
        match occupant.tell(keyframe) {
            Ok(()) => occupant.link.close(last),
            Err(reason) => occupant.link.refuse(reason),
        }
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

    /// Returns how many may watch at the same time.
    pub(crate) fn spectators_max(&self) -> usize {
        self.doors.spectators_max()
    }

    fn occupant(&mut self, seat: Seat) -> Option<&mut Occupant> {
        self.occupants[seat.index()].as_mut()
    }
}

impl Occupant {
    fn new(connection: ConnectionId, link: Link) -> Self {
        Self { connection, link, feed: None, news: News::default() }
    }

    fn begin(&mut self, welcome: Welcome, keyframe: Delta) -> Result<(), Refused> {
        let mut feed = Feed::new(self.link.encoding(), &welcome.rules);
        let cycle = keyframe.cycle;
        let welcome = encode_server(self.link.encoding(), &ServerMessage::Welcome(welcome));
        let mut bytes = welcome.map_err(|error| unsendable(&error))?;
        bytes.extend(feed.begin(keyframe).map_err(|error| unsendable(&error))?);
        self.link.begin(bytes.into(), Some(cycle));
        self.feed = Some(feed);
        Ok(())
    }

    fn push(&mut self, delta: Delta, keyframe: impl FnOnce() -> Delta) -> Result<(), Refused> {
        let Some(feed) = &mut self.feed else { return Ok(()) };
        feed.push([delta]).map_err(|error| unsendable(&error))?;
        self.catch_up(keyframe)
    }

    /// Tells what was not told yet, unless the client lags.
    fn catch_up(&mut self, keyframe: impl FnOnce() -> Delta) -> Result<(), Refused> {
        let Some(now) = self.feed.as_ref().and_then(Feed::cycle) else { return Ok(()) };
        match self.link.turn(now) {
            Turn::Now => self.tell(keyframe)?,
            Turn::Later => {}
            Turn::Never => return Err(Refused::TooSlow),
        }
        self.forget()
    }

    /// Tells what was not told yet.
    fn tell(&mut self, keyframe: impl FnOnce() -> Delta) -> Result<(), Refused> {
        let Some(feed) = &mut self.feed else { return Ok(()) };
        let Some(now) = feed.cycle().filter(|&now| self.link.told() != Some(now)) else { return Ok(()) };
        let news = &mut self.news;
        let keyframe = |recent: &VecDeque<Delta>| {
            recent.iter().for_each(|delta| news.extend(delta));
            let News { results, ended } = std::mem::take(news);
            Delta { results, ended, ..keyframe() }
        };
        let bytes = feed.next(self.link.told(), keyframe).map_err(|error| unsendable(&error))?;
        self.link.push_delta(bytes, now);
        Ok(())
    }

    /// Lets go what was told, and keeps of what cannot be kept what has to be told.
    fn forget(&mut self) -> Result<(), Refused> {
        let Some(feed) = &mut self.feed else { return Ok(()) };
        for delta in feed.forget(self.link.told()) {
            self.news.extend(&delta);
        }
        if self.news.results.len() + self.news.ended.len() > NEWS_WAITING_MAX {
            return Err(Refused::TooSlow);
        }
        Ok(())
    }
}

impl News {
    fn extend(&mut self, delta: &Delta) {
        self.results.extend_from_slice(&delta.results);
        self.ended.extend_from_slice(&delta.ended);
    }
}

#[cfg(test)]
mod tests {
    use maniple_protocol::{CYCLES_WITHHELD_MAX, Encoding};
    use maniple_view::{Outcome, Refusal};

    use super::*;
    use crate::audience::tests::welcome;
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

    #[test]
    fn results_that_cannot_be_told_have_an_end() {
        let mut table = table(vec![Access::Open]);
        let (link, _takes_nothing) = Link::new(Encoding::Json);
        table.sit(Seat(0), ConnectionId(1), link);
        table.welcome(Seat(0), welcome(), Delta::default()).unwrap();
        let outcome = Outcome::Refused { reason: Refusal::Out };
        let results = vec![CommandResult { seq: 1, outcome }; NEWS_WAITING_MAX / 16];
        let refused = (1..CYCLES_WITHHELD_MAX / 2).find_map(|cycle| {
            let delta = Delta { cycle: Cycle(cycle), results: results.clone(), ..Delta::default() };
            table.push_delta(Seat(0), delta, || panic!("it lags")).err()
        });
        assert_eq!(refused, Some(Refused::TooSlow));
        let waiting = table.occupant(Seat(0)).map(|occupant| occupant.news.results.len());
        assert_eq!(waiting, Some(NEWS_WAITING_MAX + results.len()), "none is lost before");
    }

    fn table(access: Vec<Access>) -> Table {
        Table::new(Arc::new(Doors::new(access, 8)))
    }

    fn link() -> Link {
        Link::new(Encoding::Binary).0
    }
}
