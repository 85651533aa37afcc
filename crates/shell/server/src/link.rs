//! The way from the simulation to a connection.

use maniple_geometry::Cycle;
use maniple_protocol::{
    EncodeError, Encoding, Lag, Refused, ServerMessage, SharedBytes, Turn, encode_server,
};

use crate::queue::{FullError, Outbox, Queue, queue};

/// Rules that a client may break before its connection is closed, where what it said can be dropped: a mistake that a program
/// makes now and then should not cost it a match.
pub const VIOLATIONS_MAX: u32 = 2;

/// The simulation's end of a connection: it knows how far behind the client is. It never waits; dropping it closes the connection.
#[derive(Debug)]
pub(crate) struct Link {
    encoding: Encoding,
    queue: Queue,
    lag: Lag,
    violations: u32,
}

impl Link {
    /// Returns both ends.
    pub(crate) fn new(encoding: Encoding) -> (Self, Outbox) {
        let (queue, outbox) = queue();
        (Self { encoding, queue, lag: Lag::default(), violations: 0 }, outbox)
    }

    /// Returns how the client's messages are written.
    pub(crate) fn encoding(&self) -> Encoding {
        self.encoding
    }

    /// Queues welcome and keyframe, which goes up to cycle `told`; `None`: there is no keyframe yet.
    pub(crate) fn begin(&mut self, bytes: SharedBytes, told: Option<Cycle>) {
        self.queue.push_beginning(bytes);
        if let Some(cycle) = told {
            self.lag.handle_sent(cycle);
        }
    }

    /// Queues a message that is no delta: for a client that lags before those that wait.
    ///
    /// # Errors
    /// Why the connection has to be closed: it is too slow, or nobody could take this message.
    pub(crate) fn push(&mut self, message: &ServerMessage) -> Result<(), Refused> {
        let bytes = encode_server(self.encoding, message).map_err(|error| unsendable(&error))?.into();
        let pushed =
            if self.lag.is_behind() { self.queue.push_urgent(bytes) } else { self.queue.push_control(bytes) };
        pushed.map_err(|FullError| Refused::TooSlow)
    }

    /// Queues what tells the client all up to a cycle.
    pub(crate) fn push_delta(&mut self, bytes: SharedBytes, cycle: Cycle) {
        self.queue.push_delta(bytes);
        self.lag.handle_sent(cycle);
    }

    /// Returns what is to be done with what it was not told up to cycle `now`.
    pub(crate) fn turn(&mut self, now: Cycle) -> Turn {
        self.lag.poll(now, self.queue.untaken())
    }

    /// Returns up to which cycle it was told; `None`: nothing.
    pub(crate) fn told(&self) -> Option<Cycle> {
        self.lag.sent()
    }

    /// Takes that the client is done with a delta.
    pub(crate) fn handle_done(&mut self, cycle: Cycle) {
        self.lag.handle_done(cycle);
    }

    /// Takes that commands came in cycle `now`, decided on a view of cycle `seen`.
    pub(crate) fn handle_commands(&mut self, now: Cycle, seen: Cycle) {
        self.lag.handle_commands(now, seen);
    }

    /// Takes that what the client said was dropped, and warns it.
    ///
    /// # Errors
    /// Why the connection has to be closed: that was once too often, or it is too slow.
    pub(crate) fn handle_violation(&mut self, reason: Refused) -> Result<(), Refused> {
        if self.violations == VIOLATIONS_MAX {
            return Err(reason);
        }
        self.violations += 1;
        self.push(&ServerMessage::Warned { reason, left: VIOLATIONS_MAX - self.violations })
    }

    /// Returns how many messages wait for the connection to take them.
    pub(crate) fn waiting(&self) -> usize {
        self.queue.waiting()
    }

    /// Queues the last message and closes the connection behind it. Who lags is told at once why it is closed: the deltas that wait are
    /// of no use to it.
    pub(crate) fn close(self, last: &ServerMessage) {
        let bytes: SharedBytes = match encode_server(self.encoding, last) {
            Ok(bytes) => bytes.into(),
            Err(error) => return tracing::error!(%error, "the last message cannot be sent"),
        };
        if self.lag.is_behind() && matches!(last, ServerMessage::Refused { .. }) {
            self.queue.cut_short(bytes);
        } else {
            self.queue.close(bytes);
        }
    }

    /// Tells the client why it is closed, and closes the connection.
    pub(crate) fn refuse(self, reason: Refused) {
        self.close(&ServerMessage::Refused { reason });
    }
}

/// Returns why a connection is closed to which a message cannot be written.
pub(crate) fn unsendable(error: &EncodeError) -> Refused {
    tracing::error!(%error, "a message cannot be sent");
    Refused::Malformed { place: "a message to this client".to_owned(), problem: error.to_string() }
}

#[cfg(test)]
mod tests {
    use maniple_protocol::{CYCLES_UNSEEN_MAX, decode_server};

    use super::*;

    #[tokio::test]
    async fn who_lags_gets_what_is_no_delta_first_and_a_reason_in_the_place_of_deltas() {
        let ended = include_bytes!("../../../../tests/golden/protocol/ended.json").trim_ascii_end();
        let ended = decode_server(Encoding::Json, ended).unwrap();
        let refused = ServerMessage::Refused { reason: Refused::TooSlow };
        for (lags, last, expected) in [
            (false, &ended, vec![None, None, Some(pong(7)), Some(ended.clone())]),
            (false, &refused, vec![None, None, Some(pong(7)), Some(refused.clone())]),
            (true, &ended, vec![Some(pong(7)), None, None, Some(ended.clone())]),
            (true, &refused, vec![Some(pong(7)), Some(refused.clone())]),
        ] {
            let (mut link, outbox) = Link::new(Encoding::Json);
            for cycle in [Cycle(0), Cycle(1)] {
                assert_eq!(link.turn(cycle), Turn::Now);
                link.push_delta(b"delta\n"[..].into(), cycle);
            }
            if lags {
                link.handle_done(Cycle(0));
                link.push_delta([][..].into(), Cycle(CYCLES_UNSEEN_MAX + 1));
                assert_eq!(link.turn(Cycle(100)), Turn::Later);
            }
            link.push(&pong(7)).unwrap();
            link.close(last);
            let told = lines(outbox).await;
            let told = told.iter().map(|line| decode_server(Encoding::Json, line.as_bytes()).ok());
            assert_eq!(told.collect::<Vec<_>>(), expected, "{lags}");
        }
    }

    #[tokio::test]
    async fn two_violations_are_warned_of_and_the_third_is_the_last() {
        let (mut link, outbox) = Link::new(Encoding::Json);
        let reason = Refused::TooLarge { limit: 7 };
        for _ in 0..VIOLATIONS_MAX {
            assert_eq!(link.handle_violation(reason.clone()), Ok(()));
        }
        assert_eq!(link.handle_violation(reason.clone()), Err(reason.clone()));
        drop(link);
        let told: Vec<_> =
            lines(outbox).await.iter().map(|line| decode_server(Encoding::Json, line.as_bytes())).collect();
        let warned = |left| Ok(ServerMessage::Warned { reason: reason.clone(), left });
        assert_eq!(told, [warned(1), warned(0)]);
    }

    async fn lines(outbox: Outbox) -> Vec<String> {
        let mut written = Vec::new();
        outbox.write_to(&mut written).await.unwrap();
        String::from_utf8(written).unwrap().lines().map(str::to_owned).collect()
    }

    fn pong(id: u32) -> ServerMessage {
        ServerMessage::Pong { id, cycle: Cycle(0), fraction: 0.0 }
    }
}
