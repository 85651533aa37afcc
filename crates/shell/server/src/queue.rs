//! The messages that wait for a connection: one bounded queue of shared bytes.

use std::collections::VecDeque;
use std::io;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use maniple_protocol::{SharedBytes, Untaken};
use tokio::io::{AsyncWrite, AsyncWriteExt};
use tokio::sync::Notify;

/// Messages other than deltas that wait for a connection: more than any client has a use for. Who asks for more answers than it
/// reads is too slow.
pub const CONTROLS_WAITING_MAX: usize = 512;

/// Time for what is left of the queue after the last message. A client that is alive takes it in far less.
pub const FLUSH_TIMEOUT: Duration = Duration::from_secs(5);

/// Pieces for which an empty queue keeps its room.
const ROOM_KEPT: usize = 4;

/// What a piece of the queue is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    /// Welcome and keyframe: nothing goes before them.
    Beginning,
    Delta,
    Control,
}

/// The simulation's end of the queue. It never waits; dropping it closes the connection.
#[derive(Debug)]
pub(crate) struct Queue(Arc<Shared>);

/// The connection's end.
#[derive(Debug)]
pub(crate) struct Outbox(Arc<Shared>);

/// What both ends share.
#[derive(Debug, Default)]
struct Shared {
    state: Mutex<State>,
    /// Wakes the connection.
    filled: Notify,
    closed: Notify,
}

#[derive(Debug, Default)]
struct State {
    pieces: VecDeque<(Kind, SharedBytes)>,
    /// What the connection writes just now.
    in_hand: Option<(Kind, usize)>,
    controls: usize,
    deltas: Untaken,
    /// Nothing comes any more.
    is_closed: bool,
    /// Nobody takes anything any more.
    is_gone: bool,
}

/// More messages wait than may.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct FullError;

/// Returns both ends of an empty queue.
pub(crate) fn queue() -> (Queue, Outbox) {
    let shared = Arc::new(Shared::default());
    (Queue(Arc::clone(&shared)), Outbox(shared))
}

impl Queue {
    /// Queues what a connection begins with.
    pub(crate) fn push_beginning(&self, bytes: SharedBytes) {
        self.push(Kind::Beginning, bytes);
    }

    /// Queues a delta. How many may wait is for the caller to say.
    pub(crate) fn push_delta(&self, bytes: SharedBytes) {
        self.push(Kind::Delta, bytes);
    }

    /// Queues another message, behind all others.
    ///
    /// # Errors
    /// [`CONTROLS_WAITING_MAX`] wait.
    pub(crate) fn push_control(&self, bytes: SharedBytes) -> Result<(), FullError> {
        self.check_room()?;
        self.push(Kind::Control, bytes);
        Ok(())
    }

    /// Queues another message, before the deltas.
    ///
    /// # Errors
    /// [`CONTROLS_WAITING_MAX`] wait.
    pub(crate) fn push_urgent(&self, bytes: SharedBytes) -> Result<(), FullError> {
        self.check_room()?;
        let mut state = self.0.lock();
        let place = state.pieces.iter().position(|(kind, _)| *kind == Kind::Delta);
        state.insert(place, Kind::Control, bytes);
        drop(state);
        self.0.filled.notify_one();
        Ok(())
    }

    /// Returns how many messages the connection has not taken.
    pub(crate) fn waiting(&self) -> usize {
        self.0.lock().pieces.len()
    }

    /// Returns what of the deltas the connection has not taken.
    pub(crate) fn untaken(&self) -> Untaken {
        self.0.lock().deltas
    }

    /// Queues the last message behind all others, and closes the connection behind it.
    pub(crate) fn close(self, last: SharedBytes) {
        self.push(Kind::Control, last);
    }

    /// Queues the last message in the place of the deltas that wait, and closes the connection behind it.
    pub(crate) fn cut_short(self, last: SharedBytes) {
        self.0.lock().drop_deltas();
        self.push(Kind::Control, last);
    }

    fn check_room(&self) -> Result<(), FullError> {
        if self.0.lock().controls < CONTROLS_WAITING_MAX { Ok(()) } else { Err(FullError) }
    }

    fn push(&self, kind: Kind, bytes: SharedBytes) {
        self.0.lock().insert(None, kind, bytes);
        self.0.filled.notify_one();
    }
}

impl Drop for Queue {
    fn drop(&mut self) {
        self.0.lock().is_closed = true;
        self.0.filled.notify_one();
        self.0.closed.notify_one();
    }
}

impl Outbox {
    /// Writes what comes until the other end is closed and all is written, or [`FLUSH_TIMEOUT`] has passed since.
    ///
    /// # Errors
    /// A connection that is broken, or does not take the rest in time.
    pub(crate) async fn write_to(self, writer: &mut (impl AsyncWrite + Unpin)) -> io::Result<()> {
        let write = async {
            loop {
                let next = self.0.lock().take_next();
                match next {
                    Next::Piece(bytes) => {
                        writer.write_all(&bytes).await?;
                        // What is encrypted would wait in a buffer for more.
                        writer.flush().await?;
                    }
                    Next::Nothing => self.0.filled.notified().await,
                    Next::End => return Ok(()),
                }
            }
        };
        let deadline = async {
            self.0.closed.notified().await;
            tokio::time::sleep(FLUSH_TIMEOUT).await;
        };
        tokio::select! {
            biased;
            result = write => result,
            () = deadline => Err(io::ErrorKind::TimedOut.into()),
        }
    }
}

impl Drop for Outbox {
    fn drop(&mut self) {
        let mut state = self.0.lock();
        state.is_gone = true;
        state.pieces = VecDeque::new();
    }
}

enum Next {
    Piece(SharedBytes),
    Nothing,
    End,
}

impl Shared {
    fn lock(&self) -> MutexGuard<'_, State> {
        // Nothing can go wrong between two changes that belong together.
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl State {
    /// Puts a piece before the one at `place`; `None`: behind all.
    fn insert(&mut self, place: Option<usize>, kind: Kind, bytes: SharedBytes) {
        // Into a connection that has gone it is lost: that this is so is told by its reader.
        if self.is_gone {
            return;
        }
        match kind {
            Kind::Delta => {
                self.deltas.deltas += 1;
                self.deltas.bytes += bytes.len();
            }
            Kind::Control => self.controls += 1,
            Kind::Beginning => {}
        }
        self.pieces.insert(place.unwrap_or(self.pieces.len()), (kind, bytes));
    }

    /// Takes that the last piece is written, and returns the next.
    fn take_next(&mut self) -> Next {
        match self.in_hand.take() {
            Some((Kind::Delta, bytes)) => {
                self.deltas.deltas -= 1;
                self.deltas.bytes -= bytes;
            }
            Some((Kind::Control, _)) => self.controls -= 1,
            Some((Kind::Beginning, _)) | None => {}
        }
        let Some((kind, bytes)) = self.pieces.pop_front() else {
            self.pieces.shrink_to(ROOM_KEPT);
            return if self.is_closed { Next::End } else { Next::Nothing };
        };
        self.in_hand = Some((kind, bytes.len()));
        Next::Piece(bytes)
    }

    fn drop_deltas(&mut self) {
        self.pieces.retain(|(kind, _)| *kind != Kind::Delta);
        self.deltas = match self.in_hand {
            Some((Kind::Delta, bytes)) => Untaken { deltas: 1, bytes },
            Some((Kind::Beginning | Kind::Control, _)) | None => Untaken::default(),
        };
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[tokio::test]
    async fn what_is_urgent_goes_before_the_deltas_but_never_before_the_beginning() {
        let (queue, outbox) = queue();
        queue.push_beginning(bytes("welcome "));
        queue.push_control(bytes("paused ")).unwrap();
        queue.push_delta(bytes("1 "));
        queue.push_delta(bytes("2 "));
        assert_eq!(queue.untaken(), Untaken { deltas: 2, bytes: 4 });
        queue.push_urgent(bytes("pong ")).unwrap();
        queue.push_control(bytes("last but one ")).unwrap();
        queue.close(bytes("ended"));
        assert_eq!(written(outbox).await, "welcome paused pong 1 2 last but one ended");
    }

    #[tokio::test]
    async fn what_is_cut_short_keeps_its_beginning_and_loses_its_deltas() {
        let (queue, outbox) = queue();
        queue.push_beginning(bytes("welcome "));
        queue.push_delta(bytes("1 "));
        queue.push_control(bytes("pong ")).unwrap();
        queue.push_delta(bytes("2 "));
        queue.cut_short(bytes("refused"));
        assert_eq!(written(outbox).await, "welcome pong refused");
    }

    #[tokio::test]
    async fn there_is_an_end_to_the_messages_that_wait_and_the_last_still_goes_out() {
        let (queue, outbox) = queue();
        for _ in 0..CONTROLS_WAITING_MAX {
            queue.push_control(bytes("a")).unwrap();
        }
        assert_eq!(queue.push_control(bytes("b")), Err(FullError));
        assert_eq!(queue.push_urgent(bytes("c")), Err(FullError));
        queue.cut_short(bytes("d"));
        assert_eq!(written(outbox).await, format!("{}d", "a".repeat(CONTROLS_WAITING_MAX)));
    }

    #[tokio::test(start_paused = true)]
    async fn what_is_being_written_counts_until_the_connection_has_taken_it() {
        let (queue, outbox) = queue();
        let (mut nearby, mut far) = tokio::io::duplex(2);
        let writing = tokio::spawn(async move { outbox.write_to(&mut nearby).await });
        queue.push_delta(bytes("123"));
        queue.push_delta(bytes("45"));
        tokio::task::yield_now().await;
        assert_eq!(queue.untaken(), Untaken { deltas: 2, bytes: 5 });
        let mut buffer = [0; 3];
        tokio::io::AsyncReadExt::read_exact(&mut far, &mut buffer).await.unwrap();
        tokio::time::sleep(Duration::from_millis(1)).await;
        assert_eq!(queue.untaken(), Untaken::default());
        drop(queue);
        writing.await.unwrap().unwrap();
    }

    #[tokio::test(start_paused = true)]
    async fn a_connection_that_takes_nothing_is_given_up() {
        let (queue, outbox) = queue();
        queue.push_control(bytes("123")).unwrap();
        queue.close(bytes("last"));
        let (mut nearby, _far) = tokio::io::duplex(1);
        let begun = tokio::time::Instant::now();
        let written = tokio::time::timeout(2 * FLUSH_TIMEOUT, outbox.write_to(&mut nearby)).await;
        assert_eq!(written.expect("it is given up").unwrap_err().kind(), io::ErrorKind::TimedOut);
        assert_eq!(begun.elapsed(), FLUSH_TIMEOUT);
    }

    #[test]
    fn what_is_pushed_to_a_connection_that_has_gone_is_lost() {
        let (queue, outbox) = queue();
        queue.push_delta(bytes("1"));
        drop(outbox);
        for _ in 0..=CONTROLS_WAITING_MAX {
            queue.push_control(bytes("2")).unwrap();
        }
        assert!(queue.0.lock().pieces.is_empty());
    }

    fn bytes(text: impl AsRef<[u8]>) -> SharedBytes {
        text.as_ref().into()
    }

    async fn written(outbox: Outbox) -> String {
        let mut written = Vec::new();
        outbox.write_to(&mut written).await.unwrap();
        String::from_utf8(written).unwrap()
    }
}
