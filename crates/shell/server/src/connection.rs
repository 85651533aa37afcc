//! One connection: bytes in, events out, and what the simulation answers.

use std::io;
use std::net::SocketAddr;
use std::sync::Arc;
use std::time::Duration;

use maniple_protocol::{Encoding, Hello, Inbound, Input, Refused, ServerMessage, Watch, encode_server};
use maniple_view::{Digest, Seat};
use tokio::io::{AsyncRead, AsyncReadExt, AsyncWrite, AsyncWriteExt, ReadHalf, WriteHalf, split};
use tokio::sync::Semaphore;
use tokio::time::timeout;
use tokio_util::sync::CancellationToken;

use crate::bans::Bans;
use crate::doors::Doors;
use crate::link::Link;
use crate::lobby::{ASKS_MAX, Lobby};
use crate::queue::FLUSH_TIMEOUT;
use crate::reading::read;
use crate::simulation::{Event, Mailbox};

/// Time for the hello; a client sends it at once.
pub const HELLO_TIMEOUT: Duration = Duration::from_secs(HELLO_SECONDS as u64);

/// The same in seconds, as a client is told.
const HELLO_SECONDS: u32 = 5;

/// Time in which a connection that is one too many has to say in which encoding, and again to take the answer.
pub const TURN_AWAY_TIMEOUT: Duration = Duration::from_secs(1);

/// Messages of a connection that wait for the simulation. More are left in the socket, so that a flood holds up its
/// sender alone. A client sends two messages a cycle, and a few more where commands do not fit in one.
pub const IN_FLIGHT_MAX: usize = 16;

/// The same of a spectator, who has nothing to say but pings: those shall not stand before the commands of players.
pub const SPECTATOR_IN_FLIGHT_MAX: usize = 1;

/// Time in which bytes that still come in after the last message are read and dropped. A socket that is closed while
/// its peer goes on to write resets the connection, and what the peer has yet to read is lost, the last message too.
/// This is how far behind a client may be that still answers each cycle.
pub const DISCARD_TIMEOUT: Duration = Duration::from_secs(20);

/// Time without a byte after which a client has taken the last message, or never will.
pub const DISCARD_SILENCE: Duration = Duration::from_secs(3);

/// Bytes that are read and dropped after the last message at most: more than a client says in [`DISCARD_TIMEOUT`], far
/// less than one can send.
pub const DISCARD_BYTES_MAX: usize = 4 << 20;

/// What bytes come and go through: a TCP connection, also an encrypted one, or, in tests, a simulated one.
pub trait Stream: AsyncRead + AsyncWrite + Unpin + Send + 'static {}

impl<S: AsyncRead + AsyncWrite + Unpin + Send + 'static> Stream for S {}

/// A connection of the server, counted in the order in which they came.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct ConnectionId(pub(crate) u64);

/// The way into a match.
#[derive(Clone, Debug)]
pub(crate) struct Gate {
    /// To the simulation.
    pub(crate) mailbox: Mailbox,
    /// Where whoever wants in waits.
    pub(crate) doors: Arc<Doors>,
    /// Cancelled when the match has ended.
    pub(crate) ended: CancellationToken,
}

/// What a connection needs to know of its server.
#[derive(Clone, Debug)]
pub(crate) struct Reception {
    pub(crate) lobby: Arc<Lobby>,
    pub(crate) connection: ConnectionId,
    pub(crate) peer: SocketAddr,
    /// Cancelled when nobody is received any more.
    pub(crate) closing: CancellationToken,
    /// Which addresses are let in no more.
    pub(crate) bans: Bans,
}

/// Serves a connection until its last message is sent. Returns what is left to do, if anything is; it has nothing to do
/// with a match any more.
pub(crate) async fn serve<S: Stream>(stream: S, reception: Reception) -> Option<Farewell<S>> {
    let Reception { connection, peer, .. } = reception;
    tracing::debug!(connection = connection.0, %peer, "connected");
    let (half, mut writer) = split(stream);
    let mut reader = Reader { half, inbound: Inbound::new() };
    match greet(&mut reader, &mut writer, &reception).await {
        Greeting::Opened(opening, gate) => {
            let attended = attend(&mut reader, &mut writer, opening, connection, &gate);
            tokio::select! {
                () = attended => {}
                () = reception.bans.wait(peer.ip()) => {
                    tracing::info!(connection = connection.0, %peer, "put out: its address is banned");
                    reception.lobby.metrics().refused.count(&Refused::Operator);
                    // The simulation may have ended already.
                    let _ = gate.mailbox.send(Event::Gone { connection });
                    return None;
                }
            }
        }
        Greeting::Refused(reason) => {
            tracing::info!(connection = connection.0, %peer, %reason, "refused");
            reception.lobby.metrics().refused.count(&reason);
            refuse(&mut writer, reader.inbound.encoding(), reason).await;
        }
        Greeting::Gone => {}
    }
    let goodbye = writer.shutdown().await;
    goodbye.is_ok().then_some(Farewell { reader, _writer: writer, connection, peer })
}

/// Refuses a connection, in the encoding of its first bytes, which it has [`TURN_AWAY_TIMEOUT`] for.
pub(crate) async fn turn_away(mut stream: impl Stream, reason: Refused) {
    let mut first = [0; 4];
    let read = timeout(TURN_AWAY_TIMEOUT, stream.read_exact(&mut first)).await;
    let encoding = match read {
        Ok(Ok(_)) => Encoding::detect(&first).ok().flatten().unwrap_or(Encoding::Json),
        Ok(Err(_)) | Err(_) => Encoding::Json,
    };
    refuse(&mut stream, encoding, reason).await;
    // It is closed in any case.
    let _ = stream.shutdown().await;
    let _ = timeout(TURN_AWAY_TIMEOUT, discard(&mut stream)).await;
}

/// A connection that has been told all, and is given the time to take it.
pub(crate) struct Farewell<S> {
    reader: Reader<S>,
    /// The socket is closed when both halves are.
    _writer: WriteHalf<S>,
    connection: ConnectionId,
    peer: SocketAddr,
}

impl<S: Stream> Farewell<S> {
    /// Waits until the client has closed the connection, or it is time to.
    pub(crate) async fn wait(mut self) {
        self.reader.discard().await;
        tracing::debug!(connection = self.connection.0, peer = %self.peer, "closed");
    }
}

/// How a connection begins.
enum Greeting {
    Opened(Opening, Gate),
    Refused(Refused),
    /// The client has closed it.
    Gone,
}

/// Who has come.
enum Opening {
    /// A player, and the open seat that it wants.
    Hello(Hello, Option<Seat>),
    /// A spectator.
    Watch(Watch),
}

/// Answers what is asked of the lobby, until the client has said which match it is for, and who it is.
async fn greet<S: Stream>(
    reader: &mut Reader<S>,
    writer: &mut WriteHalf<S>,
    reception: &Reception,
) -> Greeting {
    let mut chosen: Option<(Digest, Option<Seat>)> = None;
    let open = |opening, chosen: Option<(Digest, Option<Seat>)>| {
        let gate = reception.lobby.gate(chosen.map(|(id, _)| id));
        gate.map_or_else(Greeting::Refused, |gate| Greeting::Opened(opening, gate))
    };
    for _ in 0..=ASKS_MAX {
        let said = tokio::select! {
            biased;
            said = timeout(HELLO_TIMEOUT, reader.next()) => said,
            () = reception.closing.cancelled() => return Greeting::Refused(Refused::Shutdown),
            () = reception.bans.wait(reception.peer.ip()) => return Greeting::Refused(Refused::Operator),
        };
        let answer = match said {
            Err(_) => return Greeting::Refused(Refused::Timeout { seconds: HELLO_SECONDS }),
            Ok(Err(_) | Ok(None)) => return Greeting::Gone,
            Ok(Ok(Some(Input::Hello(hello)))) => {
                let seat = chosen.and_then(|(_, seat)| seat);
                return open(Opening::Hello(hello, seat), chosen);
            }
            Ok(Ok(Some(Input::Watch(watch)))) => return open(Opening::Watch(watch), chosen),
            Ok(Ok(Some(Input::Enter { match_id, seat }))) => {
                chosen = Some((match_id, seat));
                continue;
            }
            Ok(Ok(Some(Input::List))) => Ok(reception.lobby.list()),
            Ok(Ok(Some(Input::Create(create)))) => reception.lobby.create(create, reception.peer.ip()).await,
            Ok(Ok(Some(Input::Violation(reason)))) => Err(reason),
            Ok(Ok(Some(
                Input::Commands { .. }
                | Input::Done { .. }
                | Input::Ping { .. }
                | Input::Pause { .. }
                | Input::Dropped(_),
            ))) => Err(Refused::Handshake),
        };
        match answer {
            Ok(answer) => {
                let Ok(bytes) = encode_server(reader.inbound.encoding(), &answer) else {
                    return Greeting::Refused(Refused::Broken);
                };
                if !matches!(timeout(FLUSH_TIMEOUT, write(writer, &bytes)).await, Ok(Ok(()))) {
                    return Greeting::Gone;
                }
            }
            Err(reason) => return Greeting::Refused(reason),
        }
    }
    Greeting::Refused(Refused::AsksTooMuch { limit: ASKS_MAX })
}

/// Hands everything that comes after the first message to the simulation, and writes what it answers, until the simulation
/// has closed the connection.
async fn attend<S: Stream>(
    reader: &mut Reader<S>,
    writer: &mut WriteHalf<S>,
    opening: Opening,
    connection: ConnectionId,
    gate: &Gate,
) {
    let turn = async {
        match &opening {
            Opening::Hello(hello, _) => {
                gate.doors.wait_turn(&hello.token).await;
                Ok(())
            }
            Opening::Watch(_) => gate.doors.wait_turn_to_watch().await,
        }
    };
    let turn = tokio::select! {
        turn = turn => turn,
        () = gate.ended.cancelled() => Ok(()),
    };
    if let Err(reason) = turn {
        return refuse(writer, reader.inbound.encoding(), reason).await;
    }
    let (link, outbox) = Link::new(reader.inbound.encoding());
    let (event, in_flight_max) = match opening {
        Opening::Hello(hello, wanted) => (Event::Hello { connection, hello, wanted, link }, IN_FLIGHT_MAX),
        Opening::Watch(watch) => (Event::Watch { connection, watch, link }, SPECTATOR_IN_FLIGHT_MAX),
    };
    if let Err(unsent) = gate.mailbox.send(event)
        && let Event::Hello { link, .. } | Event::Watch { link, .. } = *unsent
    {
        link.refuse(Refused::Shutdown);
    }
    let mut write = std::pin::pin!(outbox.write_to(writer));
    let written = tokio::select! {
        () = reader.listen(connection, in_flight_max, &gate.mailbox) => None,
        written = &mut write => Some(written),
    };
    // The simulation may have ended already; then the link is gone as well.
    let _ = gate.mailbox.send(Event::Gone { connection });
    let written = match written {
        Some(written) => written,
        // Who cannot write may not get round to reading.
        None => tokio::select! {
            written = &mut write => written,
            () = reader.discard() => write.await,
        },
    };
    if let Err(error) = written {
        tracing::debug!(connection = connection.0, %error, "not all was sent");
    }
}

async fn refuse(writer: &mut (impl AsyncWrite + Unpin), encoding: Encoding, reason: Refused) {
    let Ok(bytes) = encode_server(encoding, &ServerMessage::Refused { reason }) else { return };
    // Whoever does not take it has gone or does not care.
    let _ = timeout(FLUSH_TIMEOUT, write(writer, &bytes)).await;
}

/// Writes all at once: what is encrypted would wait in a buffer for more.
async fn write(writer: &mut (impl AsyncWrite + Unpin), bytes: &[u8]) -> io::Result<()> {
    writer.write_all(bytes).await?;
    writer.flush().await
}

/// The reading half.
struct Reader<S> {
    half: ReadHalf<S>,
    inbound: Inbound,
}

impl<S: Stream> Reader<S> {
    /// Returns what the client says next; `None` if it has closed the connection.
    async fn next(&mut self) -> io::Result<Option<Input>> {
        loop {
            if let Some(input) = self.inbound.poll() {
                return Ok(Some(input));
            }
            let inbound = &mut self.inbound;
            if read(&mut self.half, |bytes| inbound.handle_bytes(bytes)).await? == 0 {
                return Ok(None);
            }
        }
    }

    /// Hands on what the client says, at most so much at a time, until it closes the connection or breaks the protocol.
    async fn listen(&mut self, connection: ConnectionId, in_flight_max: usize, mailbox: &Mailbox) {
        let room = Arc::new(Semaphore::new(in_flight_max));
        while let Ok(Some(input)) = self.next().await {
            let is_last = matches!(input, Input::Violation(_));
            let Ok(permit) = Arc::clone(&room).acquire_owned().await else { return };
            let sent = mailbox.send(Event::Input { connection, input, permit });
            if is_last || sent.is_err() {
                return;
            }
        }
    }

    async fn discard(&mut self) {
        discard(&mut self.half).await;
    }
}

/// Reads and drops what comes until the end, or one of the limits.
async fn discard(half: &mut (impl AsyncRead + Unpin)) {
    let read_all = async {
        let mut left = DISCARD_BYTES_MAX;
        while left > 0 {
            match timeout(DISCARD_SILENCE, read(half, |_| {})).await {
                Ok(Ok(count @ 1..)) => left = left.saturating_sub(count),
                Ok(Ok(0) | Err(_)) | Err(_) => return,
            }
        }
    };
    // In time or not, it is over.
    let _ = timeout(DISCARD_TIMEOUT, read_all).await;
}

#[cfg(test)]
mod tests {
    use std::sync::mpsc::Receiver;

    use maniple_protocol::PROTOCOL;
    use tokio::sync::Notify;
    use tokio::time::{Instant, sleep};

    use super::*;
    use crate::pool::Waker;

    #[tokio::test(start_paused = true)]
    async fn of_a_flood_only_so_many_messages_wait_for_the_simulation() {
        for in_flight_max in [SPECTATOR_IN_FLIGHT_MAX, IN_FLIGHT_MAX] {
            let (nearby, mut far) = tokio::io::duplex(64);
            let (mailbox, events) = Mailbox::new(Waker::Task(Arc::new(Notify::new())));
            let mut reader = Reader { half: split(nearby).0, inbound: Inbound::new() };
            let listening =
                tokio::spawn(async move { reader.listen(ConnectionId(1), in_flight_max, &mailbox).await });
            tokio::spawn(async move {
                let watch = format!(
                    "{{\"watch\":{{\"protocol\":{PROTOCOL},\"client\":\"\",\"view\":\"everything\"}}}}\n"
                );
                let flood = watch + &"{\"ping\":{\"id\":1}}\n".repeat(100 * IN_FLIGHT_MAX);
                // It goes when nobody listens any more.
                let _ = far.write_all(flood.as_bytes()).await;
            });
            for _ in 0..3 {
                // Whatever can be read is read before time passes.
                sleep(Duration::from_secs(1)).await;
                assert_eq!(taken(&events), in_flight_max);
            }
            drop(events);
            listening.await.unwrap();
        }
    }

    /// Deals with all that waits, and returns how much it was.
    fn taken(events: &Receiver<Event>) -> usize {
        events.try_iter().map(drop).count()
    }

    #[tokio::test(start_paused = true)]
    async fn what_comes_after_the_last_message_is_dropped_up_to_each_limit() {
        // Who closes.
        let (nearby, far) = tokio::io::duplex(64);
        drop(far);
        assert_eq!(discarded(nearby).await, Duration::ZERO);
        // Who says nothing.
        let (nearby, _far) = tokio::io::duplex(64);
        assert_eq!(discarded(nearby).await, DISCARD_SILENCE);
        // Who never stops.
        let (nearby, mut far) = tokio::io::duplex(64);
        let talker = tokio::spawn(async move {
            while far.write_all(b"on").await.is_ok() {
                sleep(DISCARD_SILENCE / 2).await;
            }
        });
        assert_eq!(discarded(nearby).await, DISCARD_TIMEOUT);
        talker.await.unwrap();
        // Who floods.
        let (nearby, mut far) = tokio::io::duplex(64);
        let flood = tokio::spawn(async move {
            let mut sent = 0;
            while let Ok(count) = far.write(&[0; 64]).await {
                sent += count;
                assert!(sent < 2 * DISCARD_BYTES_MAX, "there is no end to it");
            }
            sent
        });
        assert_eq!(discarded(nearby).await, Duration::ZERO);
        assert!((DISCARD_BYTES_MAX..=DISCARD_BYTES_MAX + 128).contains(&flood.await.unwrap()));
    }

    /// Returns how long a connection was read from.
    async fn discarded(mut half: impl AsyncRead + Unpin) -> Duration {
        let start = Instant::now();
        timeout(2 * DISCARD_TIMEOUT, discard(&mut half)).await.expect("it ends");
        start.elapsed()
    }
}
