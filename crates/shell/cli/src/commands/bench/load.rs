//! `maniple bench load`: a daemon under load, over loopback.
//!
//! The daemon is a process of its own, so that its memory and processor time are its own; this process plays the bots, the spectators and
//! those who mean it ill. What is measured is what the daemon says of itself (`/metrics`) and what the system says of it.

mod crowd;
mod daemon;
mod hostile;

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use anyhow::Context;
use maniple_client::Lobby;
use maniple_view::{ClockMode, Digest};
use serde::Serialize;
use tokio::time::sleep;

use crate::arguments::BenchLoad;
use crate::commands::bench::load::crowd::Crowd;
use crate::commands::bench::load::daemon::{Daemon, Reading};
use crate::commands::bench::load::hostile::beset;
use crate::failure::Failure;
use crate::interrupt::Interrupt;
use crate::output::{Format, note, print};

/// Time for what comes at once at the start to be over before measuring begins.
const WARM_UP: Duration = Duration::from_secs(3);

/// What a load costs the daemon. Times by which cycles are late are upper bounds: those of the daemon's histogram.
#[derive(Debug, Serialize)]
struct Row {
    /// Spectators; each match has two bots besides.
    clients: usize,
    matches: usize,
    hostile: usize,
    seconds: f64,
    lateness_ms_p50: f64,
    lateness_ms_p99: f64,
    lateness_ms_max: f64,
    bytes_per_client_second: f64,
    /// Processor time of the daemon for each message that it sent.
    cpu_us_per_message: f64,
    /// Share of one processor that the daemon used.
    cpu_share: f64,
    rss_mib: f64,
    /// By how much the memory grew with the spectators, shared out among them.
    rss_kib_per_client: f64,
    /// By how much the memory grew while it was measured.
    rss_growth_mib: f64,
    /// Clients other than the hostile that lost their connection, by the reason that they were told: `closed` is none.
    disconnected: BTreeMap<&'static str, u64>,
    /// Connections that the daemon refused or closed, by reason; the hostile ones, where all goes well.
    refused: BTreeMap<String, u64>,
}

/// What clients count.
#[derive(Debug, Default)]
struct Counts {
    messages: AtomicU64,
    bytes: AtomicU64,
    /// Those that have got their keyframe.
    watching: AtomicU64,
    disconnected: Mutex<BTreeMap<&'static str, u64>>,
}

impl Counts {
    fn note_disconnected(&self, reason: &'static str) {
        *self.disconnected().entry(reason).or_default() += 1;
    }

    fn disconnected(&self) -> MutexGuard<'_, BTreeMap<&'static str, u64>> {
        // It is whole whoever has panicked.
        self.disconnected.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Runs `maniple bench load`.
pub(crate) fn run(arguments: &BenchLoad) -> Result<(), Failure> {
    let runtime = tokio::runtime::Builder::new_multi_thread().enable_all().build();
    let row = runtime.map_err(Failure::failed)?.block_on(async {
        let mut interrupt = Interrupt::listen().await;
        // Whatever happens, the daemon is stopped.
        tokio::select! {
            row = measure(arguments) => row.map_err(Failure::Failed),
            () = interrupt.wait() => Err(Failure::Interrupted),
        }
    })?;
    print(Format::of(&arguments.json), &row, Row::text)
}

async fn measure(arguments: &BenchLoad) -> anyhow::Result<Row> {
    let daemon = Daemon::start(arguments)?;
    let counts = Arc::new(Counts::default());
    let crowd = Crowd::new(daemon.address.clone(), Arc::clone(&counts));
    let ids = create(&daemon.address, arguments.matches).await?;
    note(&format!("{} matches of two bots", ids.len()));
    crowd.play_all(&ids).await?;
    sleep(WARM_UP).await;
    let before_crowd = daemon.read().await?;
    for number in 0..arguments.clients {
        crowd.watch(ids[number % ids.len()]).await?;
    }
    while counts.watching.load(Ordering::Relaxed) < arguments.clients as u64 {
        sleep(Duration::from_millis(50)).await;
        let gone = counts.disconnected().clone();
        anyhow::ensure!(gone.is_empty(), "clients were sent away before they had seen anything: {gone:?}");
    }
    note(&format!("{} spectators watch", arguments.clients));
    for number in 0..arguments.hostile {
        tokio::spawn(beset(daemon.address.clone(), number, ids.clone()));
    }
    sleep(WARM_UP).await;
    let before = daemon.read().await?;
    let (messages, bytes) = (counts.messages.load(Ordering::Relaxed), counts.bytes.load(Ordering::Relaxed));
    sleep(Duration::from_secs_f64(arguments.seconds)).await;
    let after = daemon.read().await?;
    let messages = counts.messages.load(Ordering::Relaxed) - messages;
    let bytes = counts.bytes.load(Ordering::Relaxed) - bytes;
    Ok(Row::new(arguments, [&before_crowd, &before, &after], (messages, bytes), &counts))
}

async fn create(address: &str, matches: usize) -> anyhow::Result<Vec<Digest>> {
    let mut ids = Vec::new();
    while ids.len() < matches {
        let mut lobby = Lobby::connect(address).await?;
        for _ in 0..maniple_server::ASKS_MAX {
            if ids.len() < matches {
                let created = lobby.create(daemon::SCENARIO, ClockMode::Realtime, true).await;
                ids.push(created.context("a match cannot be created")?.match_id);
            }
        }
    }
    Ok(ids)
}

impl Row {
    fn new(
        arguments: &BenchLoad,
        [before_crowd, before, after]: [&Reading; 3],
        (messages, bytes): (u64, u64),
        counts: &Counts,
    ) -> Self {
        let clients = arguments.clients;
        let lateness = after.lateness.since(&before.lateness);
        let seconds = after.at.duration_since(before.at).as_secs_f64();
        let cpu = after.cpu_seconds - before.cpu_seconds;
        let share = |whole: f64, parts: f64| if parts > 0.0 { whole / parts } else { 0.0 };
        Self {
            clients,
            matches: arguments.matches,
            hostile: arguments.hostile,
            seconds,
            lateness_ms_p50: lateness.quantile(0.5) * 1e3,
            lateness_ms_p99: lateness.quantile(0.99) * 1e3,
            lateness_ms_max: lateness.quantile(1.0) * 1e3,
            bytes_per_client_second: share(bytes as f64, seconds * (clients + 2 * arguments.matches) as f64),
            cpu_us_per_message: share(cpu * 1e6, messages as f64),
            cpu_share: share(cpu, seconds),
            rss_mib: after.rss_kib / 1024.0,
            rss_kib_per_client: share(before.rss_kib - before_crowd.rss_kib, clients as f64),
            rss_growth_mib: (after.rss_kib - before.rss_kib) / 1024.0,
            disconnected: counts.disconnected().clone(),
            refused: after.refused_since(before),
        }
    }

    fn text(&self) -> String {
        let mut text = String::new();
        let _ = writeln!(
            text,
            "{} spectators, {} matches of two bots, {} hostile connections, {:.1} s",
            self.clients, self.matches, self.hostile, self.seconds
        );
        let _ = writeln!(
            text,
            "cycles late by at most {} ms (half), {} ms (99 %), {} ms (all)",
            self.lateness_ms_p50, self.lateness_ms_p99, self.lateness_ms_max
        );
        let _ = writeln!(
            text,
            "{:.0} bytes a second and client; {:.1} us of processor time a message; {:.0} % of one processor",
            self.bytes_per_client_second,
            self.cpu_us_per_message,
            100.0 * self.cpu_share
        );
        let _ = writeln!(
            text,
            "{:.1} MiB resident, {:.1} KiB a spectator, {:+.1} MiB while it was measured",
            self.rss_mib, self.rss_kib_per_client, self.rss_growth_mib
        );
        let _ = write!(text, "{} lost their connection", self.disconnected.values().sum::<u64>());
        for (reason, count) in &self.disconnected {
            let _ = write!(text, "; {reason}: {count}");
        }
        for (reason, count) in &self.refused {
            let _ = write!(text, "; refused, {reason}: {count}");
        }
        text.push('\n');
        text
    }
}
