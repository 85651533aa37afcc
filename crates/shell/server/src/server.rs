//! Listens, and plays matches.

use std::io::{self, Write};
use std::net::SocketAddr;
use std::sync::{Arc, mpsc};
use std::thread;
use std::time::Duration;

use maniple_referee::Referee;
use maniple_view::{Digest, MatchResult};
use thiserror::Error;
use tokio::net::{TcpListener, TcpSocket, TcpStream};
use tokio::sync::{OwnedSemaphorePermit, Semaphore, oneshot};
use tokio::task::JoinSet;
use tokio_util::sync::CancellationToken;

use crate::connection::{ConnectionId, Gate, serve};
use crate::doors::{Access, Doors};
use crate::recording::{Recording, RecordingError};
use crate::simulation::{Event, Simulation};
use crate::table::Table;
use crate::token::Token;

/// Connections at the same time; more wait in the backlog of the socket. There are at most 64 seats and 64 spectators,
/// the rest is those that have not said hello yet, which takes them 5 seconds at most.
pub const CONNECTIONS_MAX: usize = 1024;

/// Bytes of a socket's send buffer. The system would let it grow to megabytes, which is a minute and more of deltas
/// that a client has yet to see when it is found to be too slow.
pub const SEND_BUFFER_SIZE: u32 = 64 * 1024;

/// Connections that wait to be accepted.
const BACKLOG: u32 = 1024;

/// Pause after a connection could not be accepted, which is mostly for want of file descriptors.
const ACCEPT_PAUSE: Duration = Duration::from_millis(100);

/// A socket that listens, and one match after the other on it.
#[derive(Debug)]
pub struct Server {
    listener: TcpListener,
    slots: Arc<Semaphore>,
}

/// Where a replay goes.
pub(crate) type Sink = Box<dyn Write + Send>;

/// A match that is to be played, and who may play it.
pub struct Match {
    referee: Referee,
    id: Digest,
    access: Vec<Access>,
    sink: Option<Sink>,
}

/// A match that cannot be set up.
#[derive(Clone, Copy, Debug, Error)]
pub enum MatchError {
    /// The operating system gives no random bits.
    #[error("the operating system gives no random bits: {0}")]
    Random(#[from] getrandom::Error),
    /// Not one entry a seat.
    #[error("the match has {seats} seats, but access is given for {given}")]
    Access {
        /// How many were given.
        given: usize,
        /// How many seats there are.
        seats: usize,
    },
}

/// Why a match could not be played to its end.
#[derive(Debug, Error)]
pub enum RunError {
    /// It cannot be recorded.
    #[error(transparent)]
    Recording(#[from] RecordingError),
    /// The operating system gives no thread.
    #[error("the thread of the simulation cannot be started: {0}")]
    Thread(#[from] io::Error),
    /// The simulation has panicked, which is a mistake of this program.
    #[error("the simulation has panicked")]
    Panicked,
}

impl Match {
    /// Returns a match with a random token for each seat; see [`Self::access`].
    ///
    /// # Errors
    /// An operating system without random bits.
    pub fn with_random_tokens(referee: Referee) -> Result<Self, MatchError> {
        let token = |_| Token::random().map(Access::Token);
        let access = (0..referee.seats()).map(token).collect::<Result<_, _>>()?;
        Self::new(referee, access)
    }

    /// Returns a match with these rights of access, in order of the seats.
    ///
    /// # Errors
    /// Not one entry a seat, or an operating system without random bits.
    pub fn new(mut referee: Referee, access: Vec<Access>) -> Result<Self, MatchError> {
        let (given, seats) = (access.len(), referee.seats());
        if given != seats {
            return Err(MatchError::Access { given, seats });
        }
        let mut id = [0; 8];
        getrandom::fill(&mut id)?;
        // Who goes on with a match opens them before its cycles are played again.
        if referee.cycle().0 == 0 {
            referee.open_stands();
        }
        Ok(Self { referee, id: Digest(u64::from_le_bytes(id)), access, sink: None })
    }

    /// Lets the replay of the match go to `sink` as it is played; of a match that is broken off, up to there. The
    /// simulation writes, so `sink` must not wait for anybody, and should be buffered. Without it nothing is recorded.
    #[must_use]
    pub fn recorded_to(mut self, sink: impl Write + Send + 'static) -> Self {
        self.sink = Some(Box::new(sink));
        self
    }

    /// Returns who may take which seat.
    #[must_use]
    pub fn access(&self) -> &[Access] {
        &self.access
    }

    /// Returns the number of the match, as clients are told.
    #[must_use]
    pub fn id(&self) -> Digest {
        self.id
    }
}

impl Server {
    /// Returns a server that listens; port 0 is any that is free.
    ///
    /// # Errors
    /// An address that cannot be had.
    pub fn bind(listen: SocketAddr) -> io::Result<Self> {
        let socket = if listen.is_ipv4() { TcpSocket::new_v4() } else { TcpSocket::new_v6() }?;
        #[cfg(unix)]
        socket.set_reuseaddr(true)?;
        socket.set_send_buffer_size(SEND_BUFFER_SIZE)?;
        socket.bind(listen)?;
        let listener = socket.listen(BACKLOG)?;
        Ok(Self { listener, slots: Arc::new(Semaphore::new(CONNECTIONS_MAX)) })
    }

    /// Returns the address on which it listens.
    ///
    /// # Errors
    /// Whatever the operating system says.
    pub fn local_addr(&self) -> io::Result<SocketAddr> {
        self.listener.local_addr()
    }

    /// Plays a match: waits until all seats have been joined, plays to the end, or until `shutdown`, and tells all
    /// connections. Returns its result; `None` if it was broken off by the shutdown. Connections that come between
    /// two matches wait for the next.
    ///
    /// # Errors
    /// See [`RunError`]; what clients do is none.
    pub async fn run(
        &self,
        game: Match,
        shutdown: impl Future<Output = ()>,
    ) -> Result<Option<MatchResult>, RunError> {
        let loaded = game.referee.loaded();
        let recording = game.sink.map(|sink| Recording::begin(loaded, sink)).transpose()?;
        let (events, received) = mpsc::channel();
        let doors = Arc::new(Doors::new(game.access));
        let table = Table::new(Arc::clone(&doors));
        let simulation = Simulation::new(game.referee, game.id, table, recording, received);
        let mut finished = spawn(simulation)?;
        let gate = Gate { events, doors, ended: CancellationToken::new() };
        let mut connections = JoinSet::new();
        let mut numbers = (0..).map(ConnectionId);
        let mut shutdown = std::pin::pin!(shutdown);
        let mut is_shutting_down = false;
        let outcome = loop {
            tokio::select! {
                outcome = &mut finished => break outcome,
                () = &mut shutdown, if !is_shutting_down => {
                    is_shutting_down = true;
                    // If the simulation has ended, there is nothing left to break off.
                    let _ = gate.events.send(Event::Shutdown);
                }
                (stream, peer, slot) = self.accept() => {
                    let Some(connection) = numbers.next() else { continue };
                    let gate = gate.clone();
                    connections.spawn(async move {
                        let Some(farewell) = serve(stream, connection, peer, gate).await else { return };
                        // On its own: who takes its time shall not hold up the next match.
                        tokio::spawn(async move {
                            farewell.wait().await;
                            drop(slot);
                        });
                    });
                }
                Some(_) = connections.join_next() => {}
            }
        };
        gate.ended.cancel();
        while connections.join_next().await.is_some() {}
        Ok(outcome.map_err(|_| RunError::Panicked)??)
    }

    /// Waits until every connection of the matches so far is closed, so that each client can take its last message. To
    /// be called when no match runs, before the program ends.
    ///
    /// Nobody can make it wait for longer than [`DISCARD_TIMEOUT`](crate::DISCARD_TIMEOUT).
    pub async fn wait_closed(&self) {
        let all = u32::try_from(CONNECTIONS_MAX).expect("the limit is below 2^32");
        drop(self.slots.acquire_many(all).await.expect("the semaphore is never closed"));
    }

    async fn accept(&self) -> (TcpStream, SocketAddr, OwnedSemaphorePermit) {
        loop {
            let slot = Arc::clone(&self.slots).acquire_owned().await.expect("the semaphore is never closed");
            match self.listener.accept().await {
                Ok((stream, peer)) => return (stream, peer, slot),
                Err(error) => {
                    tracing::warn!(%error, "a connection could not be accepted");
                    tokio::time::sleep(ACCEPT_PAUSE).await;
                }
            }
        }
    }
}

/// Starts the simulation on a thread of its own: on those of the runtime a long cycle would hold up connections, and
/// connections a cycle.
fn spawn(
    simulation: Simulation,
) -> io::Result<oneshot::Receiver<Result<Option<MatchResult>, RecordingError>>> {
    let (sender, finished) = oneshot::channel();
    let run = move || {
        // Nobody listens any more if the server itself was dropped.
        let _ = sender.send(simulation.run());
    };
    thread::Builder::new().name("simulation".to_owned()).spawn(run)?;
    Ok(finished)
}
