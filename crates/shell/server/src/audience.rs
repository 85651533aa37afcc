//! Who watches.

use std::collections::BTreeMap;

use maniple_protocol::{
    EncodeError, Encoding, Feed, Refused, ServerMessage, SharedBytes, Turn, Welcome, encode_server,
};
use maniple_view::{Delta, Vantage};

use crate::connection::ConnectionId;
use crate::link::{Link, unsendable};

/// Spectators of a match at the same time. Each costs a message a cycle, whose bytes it shares with all who watch the same; a cycle
/// of so many takes a few milliseconds of one processor.
pub const SPECTATORS_MAX: usize = 4096;

/// The spectators of a match.
#[derive(Debug)]
pub(crate) struct Audience {
    spectators_max: usize,
    spectators: BTreeMap<ConnectionId, Spectator>,
    /// What is watched, in each encoding in which it is.
    channels: Vec<Channel>,
}

#[derive(Debug)]
struct Spectator {
    vantage: Vantage,
    link: Link,
}

/// What those get who watch the same view in the same encoding.
#[derive(Debug)]
struct Channel {
    vantage: Vantage,
    feed: Feed,
    /// What who comes now is told, as long as it does not change.
    beginning: Option<Beginning>,
}

#[derive(Debug)]
struct Beginning {
    /// The names of the players in the welcome: they may come without a cycle.
    players: Vec<String>,
    bytes: SharedBytes,
}

impl Audience {
    /// Returns an audience of nobody, with room for so many.
    pub(crate) fn new(spectators_max: usize) -> Self {
        Self { spectators_max, spectators: BTreeMap::new(), channels: Vec::new() }
    }

    /// Checks that there is room for one more.
    ///
    /// # Errors
    /// The reason that the client is told.
    pub(crate) fn check_room(&self) -> Result<(), Refused> {
        if self.spectators.len() < self.spectators_max {
            Ok(())
        } else {
            Err(spectators_full(self.spectators_max))
        }
    }

    /// Returns how many messages wait for them to take them.
    pub(crate) fn waiting(&self) -> usize {
        self.spectators.values().map(|spectator| spectator.link.waiting()).sum()
    }

    /// Returns how many there are.
    pub(crate) fn count(&self) -> usize {
        self.spectators.len()
    }

    /// Returns whether what who comes now is told is written already: somebody came before, and nothing has changed since, not even the
    /// names of the players.
    pub(crate) fn knows_beginning(&self, vantage: Vantage, encoding: Encoding, players: &[String]) -> bool {
        let is_it = |channel: &&Channel| channel.is_of(vantage, encoding);
        let beginning = self.channels.iter().find(is_it).and_then(|channel| channel.beginning.as_ref());
        beginning.is_some_and(|beginning| beginning.players == players)
    }

    /// Takes the welcome to a view, and the keyframe if there is one already, for who comes now.
    ///
    /// # Errors
    /// Why whoever comes now has to be sent away.
    pub(crate) fn handle_beginning(
        &mut self,
        vantage: Vantage,
        encoding: Encoding,
        welcome: Welcome,
        keyframe: Option<Delta>,
    ) -> Result<(), Refused> {
        let place = self.channels.iter().position(|channel| channel.is_of(vantage, encoding));
        let place = place.unwrap_or_else(|| {
            let feed = Feed::new(encoding, &welcome.rules);
            self.channels.push(Channel { vantage, feed, beginning: None });
            self.channels.len() - 1
        });
        let channel = &mut self.channels[place];
        let players = welcome.rules.players.clone();
        let begin = || -> Result<SharedBytes, EncodeError> {
            let mut bytes = encode_server(encoding, &ServerMessage::Welcome(welcome))?;
            if let Some(keyframe) = keyframe {
                bytes.extend(channel.feed.begin(keyframe)?);
            }
            Ok(bytes.into())
        };
        let bytes = begin().map_err(|error| unsendable(&error))?;
        channel.beginning = Some(Beginning { players, bytes });
        Ok(())
    }

    /// Lets a connection watch a view.
    ///
    /// # Panics
    /// Without a beginning of now.
    pub(crate) fn join(&mut self, connection: ConnectionId, vantage: Vantage, mut link: Link) {
        let is_it = |channel: &&Channel| channel.is_of(vantage, link.encoding());
        let channel = self.channels.iter().find(is_it).expect("there is a beginning of what is watched");
        let beginning = channel.beginning.as_ref().expect("there is a beginning of now");
        link.begin(SharedBytes::clone(&beginning.bytes), channel.feed.cycle());
        self.spectators.insert(connection, Spectator { vantage, link });
    }

    /// Lets a spectator go, and returns the connection; `None` if it is none, or none any more.
    pub(crate) fn leave(&mut self, connection: ConnectionId) -> Option<Link> {
        let spectator = self.spectators.remove(&connection)?;
        let (vantage, encoding) = (spectator.vantage, spectator.link.encoding());
        if !self.spectators.values().any(|spectator| spectator.is_of(vantage, encoding)) {
            self.channels.retain(|channel| !channel.is_of(vantage, encoding));
        }
        Some(spectator.link)
    }

    /// Returns what a connection watches; `None` if it is no spectator, or none any more.
    pub(crate) fn vantage_of(&self, connection: ConnectionId) -> Option<Vantage> {
        self.spectators.get(&connection).map(|spectator| spectator.vantage)
    }

    /// Returns what is watched, each view once, in their order.
    pub(crate) fn vantages(&self) -> Vec<Vantage> {
        let mut vantages: Vec<Vantage> = self.channels.iter().map(|channel| channel.vantage).collect();
        vantages.sort_unstable();
        vantages.dedup();
        vantages
    }

    /// Returns who watches a view.
    pub(crate) fn watching(&self, vantage: Vantage) -> Vec<ConnectionId> {
        let watches = |(_, spectator): &(&ConnectionId, &Spectator)| spectator.vantage == vantage;
        self.spectators.iter().filter(watches).map(|(&connection, _)| connection).collect()
    }

    /// Queues a message other than a delta for a spectator.
    ///
    /// # Errors
    /// Why the connection has to be closed.
    pub(crate) fn push(&mut self, connection: ConnectionId, message: &ServerMessage) -> Result<(), Refused> {
        self.spectators.get_mut(&connection).map_or(Ok(()), |spectator| spectator.link.push(message))
    }

    /// Takes that what a spectator said was dropped.
    ///
    /// # Errors
    /// Why the connection has to be closed.
    pub(crate) fn handle_violation(
        &mut self,
        connection: ConnectionId,
        reason: Refused,
    ) -> Result<(), Refused> {
        self.spectators
            .get_mut(&connection)
            .map_or(Ok(()), |spectator| spectator.link.handle_violation(reason))
    }

    /// Takes the next deltas of a view. Who watches it is told, unless it lags. Returns whose connections have to be closed, and
    /// why.
    pub(crate) fn push_deltas(
        &mut self,
        vantage: Vantage,
        deltas: &[Delta],
        keyframe: &dyn Fn() -> Delta,
    ) -> Vec<(ConnectionId, Refused)> {
        let mut refused = Vec::new();
        for channel in self.channels.iter_mut().filter(|channel| channel.vantage == vantage) {
            if deltas.is_empty() {
                continue;
            }
            channel.beginning = None;
            let encoding = channel.feed.encoding();
            let watching = self
                .spectators
                .iter_mut()
                .filter(|(_, spectator)| spectator.is_of(vantage, encoding))
                .map(|(&connection, spectator)| (connection, &mut spectator.link));
            if let Err(error) = channel.feed.push(deltas.iter().cloned()) {
                let reason = unsendable(&error);
                refused.extend(watching.map(|(connection, _)| (connection, reason.clone())));
                continue;
            }
            refused.extend(tell(&mut channel.feed, watching.collect(), keyframe));
        }
        refused
    }

    /// Lets all go: tells everybody what it was not told yet, and the last message. `keyframe` gives that of a view.
    pub(crate) fn close(&mut self, last: &ServerMessage, keyframe: &dyn Fn(Vantage) -> Option<Delta>) {
        for mut spectator in std::mem::take(&mut self.spectators).into_values() {
            let is_its = |channel: &&mut Channel| spectator.is_of(channel.vantage, channel.feed.encoding());
            let feed = self.channels.iter_mut().find(is_its).map(|channel| &mut channel.feed);
            if let Some(feed) = feed.filter(|feed| feed.cycle() != spectator.link.told())
                && let (Some(now), Some(keyframe)) = (feed.cycle(), keyframe(spectator.vantage))
                && let Ok(bytes) = feed.next(spectator.link.told(), |_| keyframe)
            {
                spectator.link.push_delta(bytes, now);
            }
            spectator.link.close(last);
        }
        self.channels.clear();
    }
}

impl Spectator {
    fn is_of(&self, vantage: Vantage, encoding: Encoding) -> bool {
        self.vantage == vantage && self.link.encoding() == encoding
    }
}

impl Channel {
    fn is_of(&self, vantage: Vantage, encoding: Encoding) -> bool {
        self.vantage == vantage && self.feed.encoding() == encoding
    }
}

/// Tells those who do not lag what they were not told yet, those who were told the most first. Returns whose connections have to be
/// closed, and why.
fn tell(
    feed: &mut Feed,
    mut watching: Vec<(ConnectionId, &mut Link)>,
    keyframe: &dyn Fn() -> Delta,
) -> Vec<(ConnectionId, Refused)> {
    let Some(now) = feed.cycle() else { return Vec::new() };
    let mut refused = Vec::new();
    watching.sort_by_key(|(_, link)| std::cmp::Reverse(link.told()));
    for (connection, link) in &mut watching {
        match link.turn(now) {
            Turn::Now => match feed.next(link.told(), |_| keyframe()) {
                Ok(bytes) => link.push_delta(bytes, now),
                Err(error) => refused.push((*connection, unsendable(&error))),
            },
            Turn::Later => {}
            Turn::Never => refused.push((*connection, Refused::TooSlow)),
        }
    }
    // What nobody needs any more is let go, and what a spectator misses it misses.
    feed.forget(watching.iter().map(|(_, link)| link.told()).min().flatten());
    refused
}

/// Returns the reason for one too many.
pub(crate) fn spectators_full(spectators_max: usize) -> Refused {
    Refused::SpectatorsFull { limit: u32::try_from(spectators_max).unwrap_or(u32::MAX) }
}

#[cfg(test)]
pub(crate) mod tests {
    use maniple_protocol::decode_server;
    use maniple_view::Seat;

    use super::*;

    #[test]
    fn there_is_room_for_so_many_and_again_when_one_has_gone() {
        let mut audience = Audience::new(8);
        for number in 0..8 {
            assert_eq!(audience.check_room(), Ok(()));
            let vantage = if number % 2 == 0 { Vantage::Everything } else { Vantage::Seat(Seat(3)) };
            join(&mut audience, number, vantage);
        }
        assert_eq!(audience.check_room(), Err(Refused::SpectatorsFull { limit: 8 }));
        assert_eq!(audience.vantages(), [Vantage::Everything, Vantage::Seat(Seat(3))]);
        assert_eq!(audience.watching(Vantage::Everything).len(), 4);
        assert_eq!(audience.vantage_of(ConnectionId(5)), Some(Vantage::Seat(Seat(3))));
        assert!(audience.leave(ConnectionId(5)).is_some() && audience.leave(ConnectionId(5)).is_none());
        assert_eq!(audience.vantage_of(ConnectionId(5)), None);
        assert_eq!(audience.check_room(), Ok(()));
        for number in [1, 3, 7] {
            audience.leave(ConnectionId(number));
        }
        assert_eq!(audience.vantages(), [Vantage::Everything], "what nobody watches costs nothing");
    }

    fn join(audience: &mut Audience, number: u64, vantage: Vantage) {
        let (link, encoding) = (Link::new(Encoding::Json).0, Encoding::Json);
        if !audience.knows_beginning(vantage, encoding, &welcome().rules.players) {
            audience.handle_beginning(vantage, encoding, welcome(), None).unwrap();
        }
        audience.join(ConnectionId(number), vantage, link);
    }

    pub(crate) fn welcome() -> Welcome {
        let json = include_bytes!("../../../../tests/golden/protocol/welcome.json");
        let message = decode_server(Encoding::Json, json.trim_ascii_end()).unwrap();
        let ServerMessage::Welcome(welcome) = message else { panic!("{message:?}") };
        welcome
    }
}
