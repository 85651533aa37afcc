//! The wish of the user, or of the system, to stop.

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
pub(crate) struct Interrupt(watch::Receiver<u32>);

impl Interrupt {
    /// Listens from now on. A signal that cannot be listened to is one that never comes.
    pub(crate) async fn listen() -> Self {
        let (sender, receiver) = watch::channel(0);
        let (listens, heard) = oneshot::channel();
        tokio::spawn(async move {
            let mut listens = Some(listens);
            let mut listening = || {
                // The other end waits for it, once.
                if let Some(listens) = listens.take() {
                    let _ = listens.send(());
                }
            };
            while let Ok(()) = interrupted(&mut listening).await {
                sender.send_modify(|count| *count += 1);
            }
            sender.closed().await;
        });
        // An error is one of the runtime, which is shutting down.
        let _ = heard.await;
        Self(receiver)
    }

    /// Waits for the interrupt.
    pub(crate) async fn wait(&mut self) {
        if self.0.wait_for(|count| *count > 0).await.is_err() {
            std::future::pending::<()>().await;
        }
    }

    /// Waits for what breaks matches off after the interrupt: that they are kept, or a second interrupt.
    pub(crate) async fn wait_again(&mut self, are_kept: bool) {
        let least = if are_kept { 1 } else { 2 };
        if self.0.wait_for(|count| *count >= least).await.is_err() {
            std::future::pending::<()>().await;
        }
    }

    /// Returns whether it has come.
    pub(crate) fn has_come(&self) -> bool {
        *self.0.borrow() > 0
    }

    /// Returns whether it has come more than once.
    pub(crate) fn has_come_again(&self) -> bool {
        *self.0.borrow() > 1
    }
}

/// Waits for an interrupt, or for the signal by which services are stopped; `listening` is called when the first would be noticed.
async fn interrupted(listening: impl FnOnce()) -> io::Result<()> {
    #[cfg(unix)]
    let mut stop = tokio::signal::unix::signal(tokio::signal::unix::SignalKind::terminate())?;
    #[cfg(unix)]
    let stopped = async move {
        if stop.recv().await.is_none() {
            std::future::pending::<()>().await;
        }
        Ok(())
    };
    #[cfg(not(unix))]
    let stopped = std::future::pending::<io::Result<()>>();
    let mut signal = pin!(async {
        tokio::select! {
            outcome = ctrl_c() => outcome,
            outcome = stopped => outcome,
        }
    });
    // It listens once it has been polled.
    let first = poll_fn(|context| Poll::Ready(signal.as_mut().poll(context))).await;
    listening();
    match first {
        Poll::Ready(outcome) => outcome,
        Poll::Pending => signal.await,
    }
}
