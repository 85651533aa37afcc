//! What goes out to one connection.

use std::io;
use std::time::Duration;

use bytes::Bytes;
use maniple_protocol::{EncodeError, Encoding, Outbound, Refused, ServerMessage};
use maniple_view::Delta;
use tokio::io::{AsyncWrite, AsyncWriteExt};
use tokio::sync::mpsc;
use tokio::sync::mpsc::error::TrySendError;
use tokio_util::sync::{CancellationToken, DropGuard};

/// Messages that wait for a connection: a minute of deltas at 8 cycles a second. A client that is further behind than
/// this, and than the send buffer of its socket, shows a game that is long over.
pub const OUT_QUEUE_MAX: usize = 512;

/// Time for what is left of the queue after the last message. A client that is alive takes it in far less.
pub const FLUSH_TIMEOUT: Duration = Duration::from_secs(5);

/// The simulation's end of a connection. It never waits; dropping it closes the connection.
#[derive(Debug)]
pub(crate) struct Link {
    outbound: Outbound,
    queue: mpsc::Sender<Bytes>,
    /// Room for the last message, so that a full queue does not keep the client from being told.
    farewell: mpsc::OwnedPermit<Bytes>,
    _closing: DropGuard,
}

/// The connection's end.
#[derive(Debug)]
pub(crate) struct Outbox {
    queue: mpsc::Receiver<Bytes>,
    closing: CancellationToken,
}

impl Link {
    /// Returns both ends.
    pub(crate) fn new(encoding: Encoding) -> (Self, Outbox) {
        let (queue, receiver) = mpsc::channel(OUT_QUEUE_MAX + 1);
        let farewell = queue.clone().try_reserve_owned().expect("a new queue has room");
        let closing = CancellationToken::new();
        let guard = closing.clone().drop_guard();
        let outbound = Outbound::new(encoding);
        (Self { outbound, queue, farewell, _closing: guard }, Outbox { queue: receiver, closing })
    }

    /// Queues a message. Into a connection that has gone it is lost: that this is so is told by its reader.
    ///
    /// # Errors
    /// Why the connection has to be closed: it is too slow, or nobody could take this message.
    pub(crate) fn push(&mut self, message: &ServerMessage) -> Result<(), Refused> {
        let bytes = self.outbound.encode(message).map_err(|error| unsendable(&error))?;
        self.queue(bytes)
    }

    /// Queues deltas in one piece, which counts as one message: they may be more than may wait.
    ///
    /// # Errors
    /// As [`Self::push`].
    pub(crate) fn push_deltas(&mut self, deltas: &[Delta]) -> Result<(), Refused> {
        let mut bytes = Vec::new();
        for delta in deltas {
            let message = ServerMessage::Delta(delta.clone());
            bytes.extend(self.outbound.encode(&message).map_err(|error| unsendable(&error))?);
        }
        if bytes.is_empty() { Ok(()) } else { self.queue(bytes) }
    }

    fn queue(&self, bytes: Vec<u8>) -> Result<(), Refused> {
        match self.queue.try_send(bytes.into()) {
            Ok(()) | Err(TrySendError::Closed(_)) => Ok(()),
            Err(TrySendError::Full(_)) => Err(Refused::TooSlow),
        }
    }

    /// Returns how many messages wait for the connection to take them.
    pub(crate) fn waiting(&self) -> usize {
        // One place is kept for the last message.
        self.queue.max_capacity() - 1 - self.queue.capacity()
    }

    /// Queues the last message and closes the connection behind it.
    pub(crate) fn close(mut self, last: &ServerMessage) {
        match self.outbound.encode(last) {
            Ok(bytes) => drop(self.farewell.send(bytes.into())),
            Err(error) => tracing::error!(%error, "the last message cannot be sent"),
        }
    }

    /// Tells the client why it is closed, and closes the connection.
    pub(crate) fn refuse(self, reason: Refused) {
        self.close(&ServerMessage::Refused { reason });
    }
}

impl Outbox {
    /// Writes what comes until the other end is closed and all is written, or [`FLUSH_TIMEOUT`] has passed since.
    ///
    /// # Errors
    /// A connection that is broken, or does not take the rest in time.
    pub(crate) async fn write_to(mut self, writer: &mut (impl AsyncWrite + Unpin)) -> io::Result<()> {
        let closing = self.closing.clone();
        let write = async {
            while let Some(bytes) = self.queue.recv().await {
                writer.write_all(&bytes).await?;
                // What is encrypted would wait in a buffer for more.
                writer.flush().await?;
            }
            Ok(())
        };
        let deadline = async {
            closing.cancelled().await;
            tokio::time::sleep(FLUSH_TIMEOUT).await;
        };
        tokio::select! {
            biased;
            result = write => result,
            () = deadline => Err(io::ErrorKind::TimedOut.into()),
        }
    }
}

/// Returns why a connection is closed to which a message cannot be written.
fn unsendable(error: &EncodeError) -> Refused {
    tracing::error!(%error, "a message cannot be sent");
    Refused::Malformed { place: "a message to this client".to_owned(), problem: error.to_string() }
}

#[cfg(test)]
mod tests {
    use maniple_protocol::decode_server;

    use super::*;

    #[tokio::test]
    async fn a_full_queue_is_too_slow_and_the_client_is_told_at_the_end() {
        let (mut link, outbox) = Link::new(Encoding::Json);
        for id in (0..).take(OUT_QUEUE_MAX) {
            link.push(&pong(id)).unwrap();
        }
        assert_eq!(link.push(&pong(0)), Err(Refused::TooSlow));
        assert_eq!(link.waiting(), OUT_QUEUE_MAX);
        link.refuse(Refused::TooSlow);
        let mut written = Vec::new();
        outbox.write_to(&mut written).await.unwrap();
        let lines: Vec<&[u8]> = written.split(|&byte| byte == b'\n').collect();
        assert_eq!(lines.len(), OUT_QUEUE_MAX + 2);
        let last = decode_server(Encoding::Json, lines[OUT_QUEUE_MAX]).unwrap();
        assert_eq!(last, ServerMessage::Refused { reason: Refused::TooSlow });
    }

    #[tokio::test]
    async fn a_connection_that_takes_nothing_is_given_up() {
        tokio::time::pause();
        let (mut link, outbox) = Link::new(Encoding::Binary);
        link.push(&pong(1)).unwrap();
        link.refuse(Refused::Shutdown);
        let (mut nearby, _far) = tokio::io::duplex(1);
        let error = outbox.write_to(&mut nearby).await.unwrap_err();
        assert_eq!(error.kind(), io::ErrorKind::TimedOut);
    }

    #[test]
    fn what_is_pushed_to_a_connection_that_has_gone_is_lost() {
        let (mut link, outbox) = Link::new(Encoding::Binary);
        drop(outbox);
        assert_eq!(link.push(&pong(1)), Ok(()));
        link.refuse(Refused::Shutdown);
    }

    fn pong(id: u32) -> ServerMessage {
        ServerMessage::Pong { id, cycle: Default::default(), fraction: 0.0 }
    }
}
