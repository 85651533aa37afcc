//! The wish of the user to stop.

use std::future::poll_fn;
use std::io;
use std::pin::pin;
use std::sync::mpsc;
use std::task::Poll;
use std::thread;

use tokio::runtime::Builder;
use tokio::signal::ctrl_c;
use tokio::sync::{oneshot, watch};

use crate::failure::INTERRUPTED;

/// Ends the process with the code that a shell gives to an interrupted one, whenever that is from now on.
pub(crate) fn exit_when_interrupted() {
    when_interrupted(|| std::process::exit(INTERRUPTED));
}

/// Does something at the first interrupt from now on, in a thread of its own. The ones after it do nothing.
pub(crate) fn when_interrupted(act: impl FnOnce() + Send + 'static) {
    let (listens, heard) = mpsc::channel();
    thread::spawn(move || {
        let runtime = Builder::new_current_thread().enable_all().build();
        let interrupted = runtime.map(|runtime| {
            runtime.block_on(interrupted(|| {
                // The other end waits for it.
                let _ = listens.send(());
            }))
        });
        if matches!(interrupted, Ok(Ok(()))) {
            act();
        }
    });
    // A runtime that cannot be had leaves the system's own way to stop.
    let _ = heard.recv();
}

/// Whether the user wants the daemon to stop, from the moment on at which it was asked to listen.
#[derive(Clone, Debug)]
pub(crate) struct Interrupt(watch::Receiver<bool>);

impl Interrupt {
    /// Listens from now on. A signal that cannot be listened to is one that never comes.
    pub(crate) async fn listen() -> Self {
        let (sender, receiver) = watch::channel(false);
        let (listens, heard) = oneshot::channel();
        tokio::spawn(async move {
            let listening = || {
                // The other end waits for it.
                let _ = listens.send(());
            };
            match interrupted(listening).await {
                Ok(()) => drop(sender.send(true)),
                Err(_) => sender.closed().await,
            }
        });
        // An error is one of the runtime, which is shutting down.
        let _ = heard.await;
        Self(receiver)
    }

    /// Waits for the interrupt.
    pub(crate) async fn wait(&mut self) {
        if self.0.wait_for(|is_interrupted| *is_interrupted).await.is_err() {
            std::future::pending::<()>().await;
        }
    }

    /// Returns whether it has come.
    pub(crate) fn has_come(&self) -> bool {
        *self.0.borrow()
    }
}

/// Waits for an interrupt; `listening` is called when the first would be noticed.
async fn interrupted(listening: impl FnOnce()) -> io::Result<()> {
    let mut signal = pin!(ctrl_c());
    // It listens once it has been polled.
    let first = poll_fn(|context| Poll::Ready(signal.as_mut().poll(context))).await;
    listening();
    match first {
        Poll::Ready(outcome) => outcome,
        Poll::Pending => signal.await,
    }
}
