//! What the service manager is told, and the socket that it may have opened.
//!
//! All of it does nothing where no service manager asks for it.

use std::io;
use std::net::TcpListener;
use std::sync::Arc;
use std::time::Duration;

use listenfd::ListenFd;
use sd_notify::NotifyState;
use thiserror::Error;

use super::Operated;

/// Why the socket of the service manager cannot be used.
#[derive(Debug, Error)]
pub enum InheritedError {
    /// It is no socket that listens for TCP.
    #[error(
        "the socket that the service manager hands over cannot be used; it has to be ListenStream= with a port"
    )]
    Unusable(#[from] io::Error),
    /// There is more than one.
    #[error("the service manager hands over {found} sockets, but there is use for one: ListenStream= once")]
    TooMany {
        /// How many there are.
        found: usize,
    },
}

/// Returns the socket that the service manager has opened for the daemon; `None`: it has not.
///
/// It changes the environment, so it has to be called before there are other threads.
///
/// # Errors
/// See [`InheritedError`].
pub fn inherited_listener() -> Result<Option<TcpListener>, InheritedError> {
    let mut inherited = ListenFd::from_env();
    match inherited.len() {
        0 => Ok(None),
        1 => {
            let listener = inherited.take_tcp_listener(0)?;
            if let Some(listener) = &listener {
                listener.set_nonblocking(true)?;
            }
            Ok(listener)
        }
        found => Err(InheritedError::TooMany { found }),
    }
}

/// Tells the service manager that clients can connect.
pub fn tell_ready(status: &str) {
    tell(&[NotifyState::Ready, NotifyState::Status(status)]);
}

/// Tells the service manager that the daemon is about to end.
pub fn tell_stopping() {
    tell(&[NotifyState::Stopping]);
}

/// Tells the service manager that the daemon does its work, twice in each of its periods, as long as it does. Comes back at
/// once if the service manager does not want to know.
pub async fn keep_telling(daemon: Arc<dyn Operated>) {
    let Some(period) = sd_notify::watchdog_enabled() else { return };
    beat(&*daemon, period, || tell(&[NotifyState::Watchdog])).await;
}

async fn beat(daemon: &dyn Operated, period: Duration, tell_alive: impl Fn()) {
    // A timer does not take 0.
    let mut beats = tokio::time::interval((period / 2).max(Duration::from_millis(1)));
    loop {
        beats.tick().await;
        if daemon.health().is_alive() {
            tell_alive();
        }
    }
}

fn tell(state: &[NotifyState<'_>]) {
    if let Err(error) = sd_notify::notify(state) {
        tracing::warn!(%error, "the service manager cannot be told");
    }
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::{AtomicU32, Ordering};

    use super::*;
    use crate::operation::Health;
    use crate::operation::double::Double;

    #[tokio::test(start_paused = true)]
    async fn a_daemon_that_works_says_so_twice_in_a_period_and_one_that_is_stuck_does_not() {
        for (health, beats) in
            [(Health::Ready, 20), (Health::Starting, 20), (Health::Draining, 20), (Health::Stuck, 0)]
        {
            let (daemon, told) = (Double::new(health), AtomicU32::new(0));
            let beating = beat(&daemon, Duration::from_secs(2), || {
                told.fetch_add(1, Ordering::Relaxed);
            });
            let ended = tokio::time::timeout(Duration::from_millis(19_500), beating).await;
            assert!(ended.is_err(), "it goes on");
            assert_eq!(told.into_inner(), beats, "{health:?}");
        }
    }
}
