//! Who watches.

use maniple_protocol::{Refused, ServerMessage};
use maniple_view::{Delta, Vantage};

use crate::connection::ConnectionId;
use crate::link::Link;

/// Spectators of a match at the same time: as many as there can be players. Each gets a delta a cycle, like those; a
/// broadcast to more is for one of them to make.
pub const SPECTATORS_MAX: usize = 64;

/// The spectators of a match.
#[derive(Debug, Default)]
pub(crate) struct Audience {
    spectators: Vec<Spectator>,
}

#[derive(Debug)]
struct Spectator {
    connection: ConnectionId,
    vantage: Vantage,
    link: Link,
}

impl Audience {
    /// Checks that there is room for one more.
    ///
    /// # Errors
    /// The reason that the client is told.
    pub(crate) fn check_room(&self) -> Result<(), Refused> {
        if self.spectators.len() < SPECTATORS_MAX { Ok(()) } else { Err(spectators_full()) }
    }

    /// Returns how many messages wait for them to take them.
    pub(crate) fn waiting(&self) -> usize {
        self.spectators.iter().map(|spectator| spectator.link.waiting()).sum()
    }

    /// Returns how many there are.
    pub(crate) fn count(&self) -> usize {
        self.spectators.len()
    }

    /// Lets a connection watch.
    pub(crate) fn join(&mut self, connection: ConnectionId, vantage: Vantage, link: Link) {
        self.spectators.push(Spectator { connection, vantage, link });
    }

    /// Lets a spectator go, and returns the connection; `None` if it is none, or none any more.
    pub(crate) fn leave(&mut self, connection: ConnectionId) -> Option<Link> {
        let place = self.spectators.iter().position(|spectator| spectator.connection == connection)?;
        Some(self.spectators.swap_remove(place).link)
    }

    /// Returns what a connection watches; `None` if it is no spectator, or none any more.
    pub(crate) fn vantage_of(&self, connection: ConnectionId) -> Option<Vantage> {
        let is_it = |spectator: &&Spectator| spectator.connection == connection;
        self.spectators.iter().find(is_it).map(|spectator| spectator.vantage)
    }

    /// Returns what is watched, each view once, in their order.
    pub(crate) fn vantages(&self) -> Vec<Vantage> {
        let mut vantages: Vec<Vantage> = self.spectators.iter().map(|spectator| spectator.vantage).collect();
        vantages.sort_unstable();
        vantages.dedup();
        vantages
    }

    /// Returns who watches a view.
    pub(crate) fn watching(&self, vantage: Vantage) -> Vec<ConnectionId> {
        let watches = |spectator: &&Spectator| spectator.vantage == vantage;
        self.spectators.iter().filter(watches).map(|spectator| spectator.connection).collect()
    }

    /// Queues a message for a spectator.
    ///
    /// # Errors
    /// Why the connection has to be closed.
    pub(crate) fn push(&mut self, connection: ConnectionId, message: &ServerMessage) -> Result<(), Refused> {
        self.link(connection).map_or(Ok(()), |link| link.push(message))
    }

    /// Queues deltas for a spectator.
    ///
    /// # Errors
    /// As [`Self::push`].
    pub(crate) fn push_deltas(&mut self, connection: ConnectionId, deltas: &[Delta]) -> Result<(), Refused> {
        self.link(connection).map_or(Ok(()), |link| link.push_deltas(deltas))
    }

    /// Lets all go, and returns the connections.
    pub(crate) fn leave_all(&mut self) -> impl Iterator<Item = Link> + use<> {
        std::mem::take(&mut self.spectators).into_iter().map(|spectator| spectator.link)
    }

    fn link(&mut self, connection: ConnectionId) -> Option<&mut Link> {
        let is_it = |spectator: &&mut Spectator| spectator.connection == connection;
        self.spectators.iter_mut().find(is_it).map(|spectator| &mut spectator.link)
    }
}

/// Returns the reason for one too many.
pub(crate) fn spectators_full() -> Refused {
    let limit = u32::try_from(SPECTATORS_MAX).expect("the limit is below 2^32");
    Refused::SpectatorsFull { limit }
}

#[cfg(test)]
mod tests {
    use maniple_protocol::Encoding;
    use maniple_view::Seat;

    use super::*;

    #[test]
    fn there_is_room_for_so_many_and_again_when_one_has_gone() {
        let mut audience = Audience::default();
        for number in (0..).take(SPECTATORS_MAX) {
            assert_eq!(audience.check_room(), Ok(()));
            let vantage = if number % 2 == 0 { Vantage::Everything } else { Vantage::Seat(Seat(3)) };
            audience.join(ConnectionId(number), vantage, Link::new(Encoding::Json).0);
        }
        assert_eq!(audience.check_room(), Err(Refused::SpectatorsFull { limit: 64 }));
        assert_eq!(audience.vantages(), [Vantage::Everything, Vantage::Seat(Seat(3))]);
        assert_eq!(audience.watching(Vantage::Everything).len(), SPECTATORS_MAX / 2);
        assert_eq!(audience.vantage_of(ConnectionId(5)), Some(Vantage::Seat(Seat(3))));
        assert!(audience.leave(ConnectionId(5)).is_some() && audience.leave(ConnectionId(5)).is_none());
        assert_eq!(audience.vantage_of(ConnectionId(5)), None);
        assert_eq!(audience.check_room(), Ok(()));
    }
}
