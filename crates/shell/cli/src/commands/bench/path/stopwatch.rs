//! How long planning takes, others on the machine apart.

use std::time::Duration;

/// Measures the time that this thread has had a processor, so that figures of a busy machine can be compared; where the system does
/// not tell, the time that passes.
#[derive(Clone, Copy, Debug)]
pub(super) struct Stopwatch {
    start: Duration,
}

impl Stopwatch {
    /// What is measured.
    pub(super) const MEASURES: &str = if cfg!(unix) { "processor time" } else { "time that passes" };

    pub(super) fn start() -> Self {
        Self { start: now() }
    }

    pub(super) fn elapsed(self) -> Duration {
        now().saturating_sub(self.start)
    }
}

#[cfg(unix)]
fn now() -> Duration {
    let time = rustix::time::clock_gettime(rustix::time::ClockId::ThreadCPUTime);
    Duration::try_from(time).expect("no thread has run for less than nothing")
}

#[cfg(not(unix))]
fn now() -> Duration {
    use std::sync::LazyLock;
    use std::time::Instant;

    static BEGIN: LazyLock<Instant> = LazyLock::new(Instant::now);
    BEGIN.elapsed()
}
