//! The daemon that is measured, and what is read of it.

use std::collections::BTreeMap;
use std::io::{BufRead, BufReader};
use std::path::PathBuf;
use std::process::{Child, Command, Stdio};
use std::time::Instant;

use anyhow::Context;
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::TcpStream;

use crate::arguments::BenchLoad;

/// The scenario of the matches, which is written for the purpose.
pub(super) const SCENARIO: &str = "load";

/// Ticks a second of the processor times that the system tells.
const TICKS: f64 = 100.0;

/// A daemon with a lobby; it is stopped, and its files are removed, when this is dropped.
pub(super) struct Daemon {
    process: Child,
    folder: PathBuf,
    pub(super) address: String,
    http: String,
}

/// What is known of the daemon at a moment.
pub(super) struct Reading {
    pub(super) at: Instant,
    pub(super) cpu_seconds: f64,
    pub(super) rss_kib: f64,
    pub(super) lateness: Histogram,
    refused: BTreeMap<String, u64>,
}

/// How many cycles were late by at most so much: upper bound in seconds and count, of those of smaller bounds included.
#[derive(Clone, Debug, Default)]
pub(super) struct Histogram(Vec<(f64, u64)>);

impl Daemon {
    pub(super) fn start(arguments: &BenchLoad) -> anyhow::Result<Self> {
        let folder = std::env::temp_dir().join(format!("maniple-load-{}", std::process::id()));
        std::fs::create_dir_all(&folder).with_context(|| folder.display().to_string())?;
        let path = |name: &str| folder.join(name);
        let write = |name: &str, text: String| {
            std::fs::write(path(name), text).with_context(|| path(name).display().to_string())
        };
        write("load.toml", scenario(arguments.rate))?;
        write("load.map", map())?;
        let most = 2 * (arguments.clients + 2 * arguments.matches + 2 * arguments.hostile) + 64;
        let journal = arguments.journal.as_deref().map(|folder| folder.display().to_string());
        write(
            "server.toml",
            format!(
                "[listen]\naddress = \"127.0.0.1:0\"\nhttp = \"127.0.0.1:0\"\n[lobby]\n\
                 scenarios = {{ {SCENARIO} = \"{}\" }}\n[limits]\nconnections = {most}\n\
                 connections_per_address = {most}\nmatches = {}\nmatches_per_address = {}\n\
                 [journal]\ndirectory = \"{}\"\n",
                path("load.toml").display(),
                arguments.matches + 1,
                arguments.matches + 1,
                journal.unwrap_or_default(),
            ),
        )?;
        let program = std::env::current_exe().context("this program cannot be found")?;
        let mut command = Command::new(program);
        command.args(["serve", "--json", "--log", "error", "--config"]).arg(path("server.toml"));
        let mut process = command.stdout(Stdio::piped()).spawn().context("the daemon cannot be started")?;
        let stdout = process.stdout.take().context("the daemon has no output")?;
        let mut lines = BufReader::new(stdout).lines();
        let line = lines.next().context("the daemon says nothing")??;
        std::thread::spawn(move || lines.for_each(drop));
        let listening: serde_json::Value = serde_json::from_str(&line)?;
        let told =
            |key: &str| listening[key].as_str().map(str::to_owned).with_context(|| format!("no {key}"));
        Ok(Self { address: told("address")?, http: told("http")?, process, folder })
    }

    pub(super) async fn read(&self) -> anyhow::Result<Reading> {
        let text = self.metrics().await?;
        let process = format!("/proc/{}", self.process.id());
        let status = std::fs::read_to_string(format!("{process}/status"));
        let status =
            status.context("memory and processor time are read from /proc, which this system has not")?;
        let rss = status.lines().find_map(|line| line.strip_prefix("VmRSS:"));
        let rss = rss.and_then(|rss| rss.split_whitespace().next()).context("no VmRSS")?;
        let stat = std::fs::read_to_string(format!("{process}/stat"))?;
        // Behind the name, which may hold spaces: times in user and system mode are the 12th and 13th.
        let fields = stat.rsplit(')').next().unwrap_or_default().split_whitespace();
        let ticks = fields.skip(11).take(2).map(str::parse::<f64>).sum::<Result<f64, _>>()?;
        Ok(Reading {
            at: Instant::now(),
            cpu_seconds: ticks / TICKS,
            rss_kib: rss.parse()?,
            lateness: Histogram::of(&text, "maniple_lateness_seconds_bucket"),
            refused: by_label(&text, "maniple_refused_total"),
        })
    }

    async fn metrics(&self) -> anyhow::Result<String> {
        let mut stream = TcpStream::connect(&self.http).await?;
        let request = format!("GET /metrics HTTP/1.1\r\nHost: {}\r\nConnection: close\r\n\r\n", self.http);
        stream.write_all(request.as_bytes()).await?;
        let mut answer = String::new();
        stream.read_to_string(&mut answer).await?;
        Ok(answer)
    }
}

impl Drop for Daemon {
    fn drop(&mut self) {
        // Whatever is left of either is of no use.
        let _ = self.process.kill();
        let _ = self.process.wait();
        let _ = std::fs::remove_dir_all(&self.folder);
    }
}

impl Reading {
    pub(super) fn refused_since(&self, before: &Self) -> BTreeMap<String, u64> {
        let since = |(reason, count): (&String, &u64)| {
            let count = count - before.refused.get(reason).copied().unwrap_or(0);
            (count > 0).then(|| (reason.clone(), count))
        };
        self.refused.iter().filter_map(since).collect()
    }
}

impl Histogram {
    fn of(text: &str, name: &str) -> Self {
        let bucket = |line: &str| {
            let rest = line.strip_prefix(name)?.strip_prefix("{le=\"")?;
            let (bound, count) = rest.split_once("\"} ")?;
            let bound = if bound == "+Inf" { f64::INFINITY } else { bound.parse().ok()? };
            Some((bound, count.trim().parse().ok()?))
        };
        Self(text.lines().filter_map(bucket).collect())
    }

    /// Returns what was counted since.
    pub(super) fn since(&self, before: &Self) -> Self {
        let earlier = |bound: f64| before.0.iter().find(|(other, _)| *other == bound).map_or(0, |it| it.1);
        Self(self.0.iter().map(|&(bound, count)| (bound, count - earlier(bound))).collect())
    }

    /// Returns the least bound, in seconds, that holds for this share of what was counted.
    pub(super) fn quantile(&self, share: f64) -> f64 {
        let all = self.0.last().map_or(0, |it| it.1);
        let needed = share * all as f64;
        self.0.iter().find(|(_, count)| *count as f64 >= needed).map_or(0.0, |it| it.0)
    }
}

fn by_label(text: &str, name: &str) -> BTreeMap<String, u64> {
    let count = |line: &str| {
        let (label, count) = line.strip_prefix(name)?.strip_prefix('{')?.split_once("} ")?;
        let value = label.split('"').nth(1)?;
        Some((value.to_owned(), count.trim().parse().ok()?))
    };
    text.lines().filter_map(count).collect()
}

/// Seconds that a match lasts: as long as one may.
const LENGTH_SECONDS: u32 = 86_400;

/// Returns a scenario for matches that go on: two seats, eight units each, which the bots send about.
fn scenario(rate: f64) -> String {
    let seat = "{ groups = [{ unit = 'a', count = 8 }] }";
    format!(
        "name = '{SCENARIO}'\nmap = 'load.map'\nseed = 5\nrate = {rate}\nlength_seconds = {}\n\
         seat = [{seat}, {seat}]\nspectators = {{ views = 'all', delay_seconds = 0 }}\nvision = {{}}\n\
         objective = {{ kind = 'resources' }}\n\
         unit.a = {{ radius = 0.3, speed = 2, sight = 5 }}\n",
        LENGTH_SECONDS
    )
}

fn map() -> String {
    format!("type octile\nheight 32\nwidth 32\nmap\n{}", format!("{}\n", ".".repeat(32)).repeat(32))
}
