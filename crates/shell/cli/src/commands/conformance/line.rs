//! The connection of the client under test.

use std::io::{ErrorKind, Read, Write};
use std::net::{Shutdown, TcpStream};
use std::time::{Duration, Instant};

use maniple_protocol::{Inbound, Input, Outbound, ServerMessage};

/// Bytes that are read at once.
const READ_SIZE: usize = 8 * 1024;

/// Time for a write; a client that answers reads.
const WRITE_TIMEOUT: Duration = Duration::from_secs(10);

/// What came.
pub(crate) enum Heard {
    /// A message, or what is none.
    Input(Input),
    /// The end.
    Closed,
    /// Nothing in time.
    Silence,
}

/// One connection, in both directions.
pub(crate) struct Line {
    stream: TcpStream,
    inbound: Inbound,
    /// From the first message to the client on, since its encoding has shown then.
    outbound: Option<Outbound>,
}

impl Line {
    /// Returns the line of a connection.
    pub(crate) fn new(stream: TcpStream) -> std::io::Result<Self> {
        stream.set_nonblocking(false)?;
        stream.set_nodelay(true)?;
        stream.set_write_timeout(Some(WRITE_TIMEOUT))?;
        Ok(Self { stream, inbound: Inbound::new(), outbound: None })
    }

    /// Waits for what the client says next.
    pub(crate) fn hear(&mut self, deadline: Instant) -> Heard {
        let mut buffer = [0; READ_SIZE];
        loop {
            // Before the next message: who never stops talking is late, too.
            let left = deadline.saturating_duration_since(Instant::now());
            if left.is_zero() {
                return Heard::Silence;
            }
            if let Some(input) = self.inbound.poll() {
                return Heard::Input(input);
            }
            if self.stream.set_read_timeout(Some(left)).is_err() {
                return Heard::Silence;
            }
            match self.stream.read(&mut buffer) {
                Ok(0) => return Heard::Closed,
                Ok(count) => self.inbound.handle_bytes(&buffer[..count]),
                Err(error) if is_passing(error.kind()) => {}
                Err(_) => return Heard::Closed,
            }
        }
    }

    /// Says messages in one write. That nobody takes them is told by [`Self::hear`].
    pub(crate) fn say(&mut self, messages: &[ServerMessage]) {
        let encoding = self.inbound.encoding();
        let outbound = self.outbound.get_or_insert_with(|| Outbound::new(encoding));
        let mut bytes = Vec::new();
        for message in messages {
            bytes.extend(outbound.encode(message).expect("the messages of the story are short"));
        }
        let _ = self.stream.write_all(&bytes);
    }

    /// Closes the connection once the client has read everything and closed it, too, or it has had the time to.
    pub(crate) fn finish(&mut self, patience: Duration) {
        let _ = self.stream.shutdown(Shutdown::Write);
        let deadline = Instant::now() + patience;
        let mut buffer = [0; READ_SIZE];
        loop {
            let left = deadline.saturating_duration_since(Instant::now());
            if left.is_zero() || self.stream.set_read_timeout(Some(left)).is_err() {
                return;
            }
            match self.stream.read(&mut buffer) {
                Ok(1..) => {}
                Ok(0) | Err(_) => return,
            }
        }
    }
}

/// Returns whether an error says only that nothing has come yet.
fn is_passing(kind: ErrorKind) -> bool {
    matches!(kind, ErrorKind::WouldBlock | ErrorKind::TimedOut | ErrorKind::Interrupted)
}
