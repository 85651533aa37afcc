//! What a simulation is told, and how.

use std::sync::mpsc::{Receiver, Sender, channel};

use maniple_protocol::{Hello, Input, Watch};
use maniple_view::Seat;
use tokio::sync::OwnedSemaphorePermit;

use crate::connection::ConnectionId;
use crate::link::Link;
use crate::operation::Clock;
use crate::pool::Waker;

/// What happens outside of the simulation.
#[derive(Debug)]
pub(crate) enum Event {
    /// A connection has said who it is.
    Hello {
        /// The connection.
        connection: ConnectionId,
        /// Its hello.
        hello: Hello,
        /// The open seat that it wants, if it wants one.
        wanted: Option<Seat>,
        /// The way back.
        link: Link,
    },
    /// A connection has said that it wants to watch.
    Watch {
        /// The connection.
        connection: ConnectionId,
        /// What it wants to watch.
        watch: Watch,
        /// The way back.
        link: Link,
    },
    /// A connection said something after its first message.
    Input {
        /// The connection.
        connection: ConnectionId,
        /// What it said.
        input: Input,
        /// Held until it has been dealt with.
        permit: OwnedSemaphorePermit,
    },
    /// A connection is closed.
    Gone {
        /// The connection.
        connection: ConnectionId,
    },
    /// The match is to be broken off, because the server goes down.
    Shutdown,
    /// Whoever runs the server ends the match.
    CallOff,
    /// Whoever runs the server closes the connection at a seat.
    PutOut(Seat),
    /// Whoever runs the server halts the clock, or lets it go on.
    Clock(Clock),
}

/// Where events of a match go.
#[derive(Clone, Debug)]
pub(crate) struct Mailbox {
    events: Sender<Event>,
    waker: Waker,
}

impl Mailbox {
    /// Returns the mailbox of whom `waker` wakes, and its other end.
    pub(crate) fn new(waker: Waker) -> (Self, Receiver<Event>) {
        let (events, received) = channel();
        (Self { events, waker }, received)
    }

    /// Hands an event to the match.
    ///
    /// # Errors
    /// The event, if the match is over.
    pub(crate) fn send(&self, event: Event) -> Result<(), Box<Event>> {
        self.events.send(event).map_err(|error| Box::new(error.0))?;
        self.waker.wake();
        Ok(())
    }
}
