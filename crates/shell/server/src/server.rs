//! Listens, receives who comes, and plays matches.

use std::collections::BTreeMap;
use std::io;
use std::net::SocketAddr;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::thread::available_parallelism;
use std::time::Duration;

use maniple_protocol::Refused;
use maniple_view::MatchResult;
use tokio::net::{TcpListener, TcpSocket, TcpStream};
use tokio::sync::{OwnedSemaphorePermit, Semaphore};
use tokio::task::JoinSet;
use tokio::time::timeout;
use tokio_util::sync::CancellationToken;

use crate::bans::Bans;
use crate::connection::{ConnectionId, HELLO_TIMEOUT, Reception, Stream, serve, turn_away};
use crate::journal::Journals;
use crate::limits::{Addresses, Limits};
use crate::lobby::{Lobby, Offer};
use crate::matches::{Match, RunError};
use crate::metrics::{Connected, Counted, Metrics};
use crate::pool::Pool;
use crate::socket::{set_connected, set_listening};
use crate::tls::Tls;

/// Connections that wait to be accepted.
const BACKLOG: u32 = 1024;

/// Pause after a connection could not be accepted, which is mostly for want of file descriptors.
const ACCEPT_PAUSE: Duration = Duration::from_millis(100);

/// A socket that listens, and the matches that are played over it.
#[derive(Debug)]
pub struct Server {
    listener: TcpListener,
    house: House,
}

/// All of a server but the socket: the lobby, and the connections.
#[derive(Clone, Debug)]
pub struct House {
    pub(crate) lobby: Arc<Lobby>,
    slots: Arc<Semaphore>,
    addresses: Addresses,
    pub(crate) bans: Bans,
    /// `None`: nothing is encrypted.
    tls: Option<Tls>,
    pub(crate) is_ready: Arc<AtomicBool>,
    numbers: Arc<AtomicU64>,
}

impl House {
    /// Returns a house whose matches are played by so many threads; none: each by a task of the runtime, in its time.
    ///
    /// # Errors
    /// An operating system that gives no thread.
    pub fn new(
        limits: Limits,
        offers: BTreeMap<String, Offer>,
        journals: Option<Journals>,
        threads: usize,
    ) -> io::Result<Self> {
        let pool = if threads == 0 { Pool::Tasks } else { Pool::with_threads(threads)? };
        Ok(Self {
            lobby: Arc::new(Lobby::new(pool, limits, offers, journals)),
            slots: Arc::new(Semaphore::new(limits.connections)),
            addresses: Addresses::default(),
            bans: Bans::default(),
            tls: None,
            is_ready: Arc::default(),
            numbers: Arc::default(),
        })
    }

    /// Returns the same with connections that are encrypted, and no others.
    #[must_use]
    pub fn encrypted(self, tls: Tls) -> Self {
        Self { tls: Some(tls), ..self }
    }

    /// Returns the same in which clients create no matches: only its operators do.
    #[must_use]
    pub fn closed_to_clients(self) -> Self {
        self.lobby.close_to_clients();
        self
    }

    /// Returns what it counts.
    #[must_use]
    pub fn metrics(&self) -> &Arc<Metrics> {
        self.lobby.metrics()
    }

    /// Puts other limits into force. Who is in stays in.
    pub(crate) fn change_limits(&self, limits: Limits) {
        let before = self.lobby.change_limits(limits).connections;
        self.slots.add_permits(limits.connections.saturating_sub(before));
        let fewer = u32::try_from(before.saturating_sub(limits.connections)).unwrap_or(u32::MAX);
        let slots = Arc::clone(&self.slots);
        tokio::spawn(async move {
            // Those that are taken go when their connections do.
            slots.acquire_many(fewer).await.expect("the semaphore is never closed").forget();
        });
    }

    /// Returns its lobby.
    #[must_use]
    pub fn lobby(&self) -> &Arc<Lobby> {
        &self.lobby
    }

    /// Serves a connection, in a task of its own, until it is over or `closing` is cancelled; one too many is dropped.
    pub fn receive(&self, stream: impl Stream, peer: SocketAddr, closing: &CancellationToken) {
        if let Ok(slot) = Arc::clone(&self.slots).try_acquire_owned() {
            tokio::spawn(self.attend(stream, peer, slot, closing.clone()));
        }
    }

    /// Serves a connection until it has nothing to do with a match any more; it may take its last message after that.
    fn attend<S: Stream>(
        &self,
        stream: S,
        peer: SocketAddr,
        slot: OwnedSemaphorePermit,
        closing: CancellationToken,
    ) -> impl Future<Output = ()> + Send + use<S> {
        let connection = ConnectionId(self.numbers.fetch_add(1, Ordering::Relaxed));
        let limit = self.lobby.limits().connections_per_address;
        let place = self.addresses.take(peer.ip(), limit);
        let metrics = self.metrics();
        let stream = Counted::new(stream, Connected::new(Arc::clone(metrics)));
        let refused = if self.bans.is_banned(peer.ip()) {
            Some(Refused::Operator)
        } else {
            let limit = u32::try_from(limit).unwrap_or(u32::MAX);
            place.is_none().then_some(Refused::AddressFull { limit })
        };
        if let Some(reason) = &refused {
            tracing::info!(%peer, %reason, "refused");
            metrics.refused.count(reason);
        }
        let reception =
            Reception { lobby: Arc::clone(&self.lobby), connection, peer, closing, bans: self.bans.clone() };
        let tls = self.tls.clone();
        async move {
            let held = (slot, place);
            let Some(tls) = tls else { return welcome(stream, reception, refused, held).await };
            if refused.is_some() {
                // A handshake is work that whoever is refused shall not make.
                return;
            }
            let closing = reception.closing.clone();
            let accepted = tokio::select! {
                accepted = timeout(HELLO_TIMEOUT, tls.accept(stream)) => accepted,
                () = closing.cancelled() => return,
            };
            match accepted {
                Ok(Ok(stream)) => welcome(stream, reception, None, held).await,
                Ok(Err(error)) => tracing::info!(%peer, %error, "no encrypted connection"),
                Err(_) => tracing::info!(%peer, "no encrypted connection in time"),
            }
        }
    }
}

/// Serves a connection, or refuses it; `held` is what is free again when it is over.
async fn welcome(
    stream: impl Stream,
    reception: Reception,
    refused: Option<Refused>,
    held: impl Send + 'static,
) {
    if let Some(reason) = refused {
        return turn_away(stream, reason).await;
    }
    let Some(farewell) = serve(stream, reception).await else { return };
    // On its own: who takes its time shall not hold up the next match.
    tokio::spawn(async move {
        farewell.wait().await;
        drop(held);
    });
}

impl Server {
    /// Returns a server that listens; port 0 is any that is free. A thread for each processor plays its matches.
    ///
    /// # Errors
    /// An address that cannot be had, or no thread.
    pub fn bind(listen: SocketAddr) -> io::Result<Self> {
        let threads = available_parallelism().map_or(1, usize::from);
        Self::open(listen, House::new(Limits::default(), BTreeMap::new(), None, threads)?)
    }

    /// Returns a server that listens for a house; port 0 is any that is free.
    ///
    /// # Errors
    /// An address that cannot be had.
    pub fn open(listen: SocketAddr, house: House) -> io::Result<Self> {
        let socket = if listen.is_ipv4() { TcpSocket::new_v4() } else { TcpSocket::new_v6() }?;
        #[cfg(unix)]
        socket.set_reuseaddr(true)?;
        set_listening(&socket)?;
        socket.bind(listen)?;
        Ok(Self { listener: socket.listen(BACKLOG)?, house })
    }

    /// Returns a server for a house over a socket that listens already.
    ///
    /// # Errors
    /// A socket that cannot be set as those of a server are, or that the runtime cannot wait for.
    pub fn over(listener: std::net::TcpListener, house: House) -> io::Result<Self> {
        set_listening(&listener)?;
        listener.set_nonblocking(true)?;
        Ok(Self { listener: TcpListener::from_std(listener)?, house })
    }

    /// Returns what it listens for.
    #[must_use]
    pub fn house(&self) -> &House {
        &self.house
    }

    /// Returns the address on which it listens.
    ///
    /// # Errors
    /// Whatever the operating system says.
    pub fn local_addr(&self) -> io::Result<SocketAddr> {
        self.listener.local_addr()
    }

    /// Plays a match, beside those of the lobby, for whoever names no match: waits until all seats have been joined, plays to the end,
    /// or until `shutdown`, and tells all connections. Returns its result; `None` if it was broken off by the shutdown. Connections that
    /// come between two matches wait for the next.
    ///
    /// # Errors
    /// See [`RunError`]; what clients do is none.
    pub async fn run(
        &self,
        game: Match,
        shutdown: impl Future<Output = ()>,
    ) -> Result<Option<MatchResult>, RunError> {
        let mut opened = self.house.lobby.open_standing(game)?;
        let closing = CancellationToken::new();
        let mut connections = JoinSet::new();
        let mut shutdown = std::pin::pin!(shutdown);
        let mut is_shutting_down = false;
        let outcome = loop {
            tokio::select! {
                outcome = &mut opened.finished => break outcome.unwrap_or_else(|_| Err(RunError::gone())),
                () = &mut shutdown, if !is_shutting_down => {
                    is_shutting_down = true;
                    self.house.lobby.shut_down();
                }
                (stream, peer, slot) = self.accept() => {
                    connections.spawn(self.house.attend(stream, peer, slot, closing.clone()));
                }
                Some(_) = connections.join_next() => {}
            }
        };
        self.house.lobby.forget(opened.id);
        closing.cancel();
        while connections.join_next().await.is_some() {}
        outcome
    }

    /// Receives whoever comes, and plays the matches of the lobby. After `shutdown` no match is taken in any more, and when all have
    /// ended, or after `hurry`, which breaks them off, it returns.
    pub async fn serve(&self, shutdown: impl Future<Output = ()>, hurry: impl Future<Output = ()>) {
        let closing = CancellationToken::new();
        let (mut shutdown, mut hurry) = (std::pin::pin!(shutdown), std::pin::pin!(hurry));
        let (mut is_asked, mut is_hurrying) = (false, false);
        while !(self.house.lobby.is_draining() && self.house.lobby.matches() == 0) {
            tokio::select! {
                () = &mut shutdown, if !is_asked => {
                    is_asked = true;
                    self.house.lobby.drain();
                }
                () = &mut hurry, if is_asked && !is_hurrying => {
                    is_hurrying = true;
                    self.house.lobby.shut_down();
                }
                () = self.house.lobby.wait_change() => {}
                (stream, peer, slot) = self.accept() => {
                    drop(tokio::spawn(self.house.attend(stream, peer, slot, closing.clone())));
                }
            }
        }
        closing.cancel();
        self.wait_closed().await;
    }

    /// Waits until every connection of the matches so far is closed, so that each client can take its last message. To
    /// be called when no match runs, before the program ends.
    ///
    /// Nobody can make it wait for longer than [`DISCARD_TIMEOUT`](crate::DISCARD_TIMEOUT).
    pub async fn wait_closed(&self) {
        let all = u32::try_from(self.house.lobby.limits().connections).unwrap_or(u32::MAX);
        drop(self.house.slots.acquire_many(all).await.expect("the semaphore is never closed"));
    }

    async fn accept(&self) -> (TcpStream, SocketAddr, OwnedSemaphorePermit) {
        loop {
            let slots = Arc::clone(&self.house.slots);
            let slot = slots.acquire_owned().await.expect("the semaphore is never closed");
            match self.listener.accept().await {
                Ok((stream, peer)) => {
                    if let Err(error) = set_connected(&stream) {
                        tracing::debug!(%peer, %error, "the socket cannot be set");
                    }
                    return (stream, peer, slot);
                }
                Err(error) => {
                    tracing::warn!(%error, "a connection could not be accepted");
                    tokio::time::sleep(ACCEPT_PAUSE).await;
                }
            }
        }
    }
}

#[cfg(test)]
mod tests;
