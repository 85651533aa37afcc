//! What the daemon counts. Whoever counts never waits: every figure is an atomic number.
//!
//! [`Metrics::described`] is the list of all figures, with their names and meanings; `docs/OPERATIONS.md` has the same
//! list, and a test compares them.

mod counted;
mod kinds;
mod timings;

use std::sync::Arc;
use std::sync::atomic::{AtomicI64, AtomicU64, Ordering};

use prometheus_client::collector::Collector;
use prometheus_client::encoding::text::encode;
use prometheus_client::encoding::{DescriptorEncoder, NoLabelSet};
use prometheus_client::metrics::MetricType;
use prometheus_client::registry::Registry;

pub(crate) use counted::Connected;
pub use counted::{Counted, Traffic};
pub use kinds::{End, Kind, Kinds};
pub use timings::{Spread, TIMING_BOUNDS, Timings};

/// What every name begins with.
const PREFIX: &str = "maniple";

/// A number that only grows.
#[derive(Debug, Default)]
pub struct Count(AtomicU64);

/// A number that goes up and down.
#[derive(Debug, Default)]
pub struct Level(AtomicI64);

/// How cycles keep their time.
#[derive(Debug, Default)]
pub struct CycleTimings {
    /// Wall-clock time that a cycle takes: commands, step and deltas.
    pub duration: Timings,
    /// By how much a cycle of a real-time match begins later than it is due.
    pub lateness: Timings,
    /// By how much the time between the beginnings of two cycles of a real-time match differs from the period.
    pub jitter: Timings,
}

/// All figures of a daemon, over all its matches since it began.
#[derive(Debug, Default)]
pub struct Metrics {
    /// How the cycles of all matches keep their time.
    pub cycles: CycleTimings,
    /// Cycles that were put off because the match was too slow for its rate.
    pub cycles_put_off: Count,
    /// Matches that are open or run.
    pub matches: Level,
    /// Matches that are over, by how they ended.
    pub matches_ended: Kinds<End>,
    /// Open connections, whatever they are.
    pub connections: Level,
    /// Connections at a seat.
    pub players: Level,
    /// Connections that watch.
    pub spectators: Level,
    /// Bytes that clients have sent.
    pub bytes_received: Count,
    /// Bytes that clients have been sent.
    pub bytes_sent: Count,
    /// Messages that wait for a connection to take them, in all.
    pub queue_depth: Level,
    /// Answers to commands, by kind: applied, or why not.
    pub results: Kinds<maniple_view::Outcome>,
    /// Connections that were refused or closed, by reason.
    pub refused: Kinds<maniple_protocol::Refused>,
    /// Keyframes for clients that were too far behind for deltas.
    pub resyncs: Count,
    /// Requests to the administration, done or refused.
    pub admin_requests: Count,
}

/// A figure, its name and its meaning.
#[derive(Clone, Copy, Debug)]
pub struct Described<'a> {
    /// Without the prefix, and without the `_total` that a count ends in.
    name: &'static str,
    /// What it counts, in a sentence without a full stop; the unit is in the name.
    pub meaning: &'static str,
    reading: Reading<'a>,
}

#[derive(Clone, Copy, Debug)]
enum Reading<'a> {
    Count(&'a Count),
    Level(&'a Level),
    /// By a label: its name, and the count of each of its values.
    Labelled(&'static str, &'a dyn Labelled),
    Timings(&'a Timings),
}

/// Counts by the value of a label.
trait Labelled: std::fmt::Debug {
    /// Returns the values that the label can have, each with its count.
    fn counts(&self) -> Vec<(&'static str, u64)>;
}

impl Count {
    /// Adds one.
    pub fn increment(&self) {
        self.add(1);
    }

    /// Adds so many.
    pub fn add(&self, number: u64) {
        self.0.fetch_add(number, Ordering::Relaxed);
    }

    /// Returns the number.
    #[must_use]
    pub fn value(&self) -> u64 {
        self.0.load(Ordering::Relaxed)
    }
}

impl Level {
    /// Adds so many, or takes them away.
    pub fn change(&self, by: i64) {
        self.0.fetch_add(by, Ordering::Relaxed);
    }

    /// Returns the number.
    #[must_use]
    pub fn value(&self) -> i64 {
        self.0.load(Ordering::Relaxed)
    }
}

impl Metrics {
    /// Returns all figures.
    #[must_use]
    pub fn described(&self) -> [Described<'_>; 16] {
        use Reading::{Count, Labelled, Level, Timings};
        let described = |name, meaning, reading| Described { name, meaning, reading };
        [
            described(
                "cycle_seconds",
                "Time that a cycle takes: commands, step and deltas",
                Timings(&self.cycles.duration),
            ),
            described(
                "lateness_seconds",
                "Time by which a cycle begins later than it is due",
                Timings(&self.cycles.lateness),
            ),
            described(
                "jitter_seconds",
                "Time by which two cycles are farther apart, or nearer, than the period",
                Timings(&self.cycles.jitter),
            ),
            described(
                "cycles_put_off",
                "Cycles put off because the match was too slow for its rate",
                Count(&self.cycles_put_off),
            ),
            described("matches", "Matches that are open or run", Level(&self.matches)),
            described(
                "matches_ended",
                "Matches that are over, by how they ended",
                Labelled("how", &self.matches_ended),
            ),
            described("connections", "Open connections", Level(&self.connections)),
            described("players", "Connections at a seat", Level(&self.players)),
            described("spectators", "Connections that watch", Level(&self.spectators)),
            described("bytes_received", "Bytes that clients have sent", Count(&self.bytes_received)),
            described("bytes_sent", "Bytes that clients have been sent", Count(&self.bytes_sent)),
            described(
                "queue_depth",
                "Messages that wait for a connection to take them",
                Level(&self.queue_depth),
            ),
            described(
                "command_results",
                "Answers to commands: applied, or why not",
                Labelled("kind", &self.results),
            ),
            described(
                "refused",
                "Connections refused or closed, by reason",
                Labelled("reason", &self.refused),
            ),
            described("resyncs", "Keyframes for clients that were too far behind", Count(&self.resyncs)),
            described("admin_requests", "Requests to the administration", Count(&self.admin_requests)),
        ]
    }

    /// Returns all figures in the OpenMetrics text format.
    #[must_use]
    pub fn text(self: &Arc<Self>) -> String {
        let mut registry = Registry::with_prefix(PREFIX);
        registry.register_collector(Box::new(Arc::clone(self)));
        let mut text = String::new();
        encode(&mut text, &registry).expect("a string takes all that is written to it");
        text
    }
}

impl Described<'_> {
    /// Returns the whole name, as it is asked for; that of timings has `_bucket`, `_sum` and `_count` behind it.
    #[must_use]
    pub fn full_name(&self) -> String {
        let ending = match self.reading {
            Reading::Count(_) | Reading::Labelled(..) => "_total",
            Reading::Level(_) | Reading::Timings(_) => "",
        };
        format!("{PREFIX}_{}{ending}", self.name)
    }

    /// Returns what kind of figure it is, in the words of Prometheus.
    #[must_use]
    pub fn kind(&self) -> &'static str {
        match self.reading {
            Reading::Count(_) | Reading::Labelled(..) => "counter",
            Reading::Level(_) => "gauge",
            Reading::Timings(_) => "histogram",
        }
    }

    /// Returns the name of the label by which it is counted; `None`: it is one number.
    #[must_use]
    pub fn label(&self) -> Option<&'static str> {
        match self.reading {
            Reading::Labelled(label, _) => Some(label),
            Reading::Count(_) | Reading::Level(_) | Reading::Timings(_) => None,
        }
    }
}

impl Collector for Metrics {
    fn encode(&self, mut encoder: DescriptorEncoder<'_>) -> Result<(), std::fmt::Error> {
        for Described { name, meaning, reading } in self.described() {
            let kind = match reading {
                Reading::Count(_) | Reading::Labelled(..) => MetricType::Counter,
                Reading::Level(_) => MetricType::Gauge,
                Reading::Timings(_) => MetricType::Histogram,
            };
            let mut metric = encoder.encode_descriptor(name, meaning, None, kind)?;
            match reading {
                Reading::Count(count) => metric.encode_counter::<NoLabelSet, _, u64>(&count.value(), None)?,
                Reading::Level(level) => metric.encode_gauge(&level.value())?,
                Reading::Labelled(label, counts) => {
                    for (value, count) in counts.counts() {
                        metric
                            .encode_family(&[(label, value)])?
                            .encode_counter::<NoLabelSet, _, u64>(&count, None)?;
                    }
                }
                Reading::Timings(timings) => {
                    let reading = timings.read();
                    metric.encode_histogram::<NoLabelSet>(
                        reading.sum_seconds,
                        reading.count,
                        &reading.buckets,
                        None,
                    )?;
                }
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use maniple_protocol::Refused;

    use super::*;

    #[test]
    fn every_figure_is_in_the_text_under_its_name() {
        let metrics = Arc::new(Metrics::default());
        let text = metrics.text();
        for figure in metrics.described() {
            let (name, kind) = (figure.full_name(), figure.kind());
            let family = name.trim_end_matches("_total");
            assert!(text.contains(&format!("# TYPE {family} {kind}\n")), "{name}: {text}");
            assert!(text.contains(&format!("# HELP {family} {}\n", figure.meaning)), "{name}: {text}");
            let sample = match figure.label() {
                Some(label) => format!("\n{name}{{{label}=\""),
                None if kind == "histogram" => format!("\n{name}_bucket{{le=\""),
                None => format!("\n{name} 0\n"),
            };
            assert!(text.contains(&sample), "{sample}: {text}");
        }
        assert!(text.ends_with("# EOF\n"));
    }

    #[test]
    fn what_is_counted_is_told() {
        let metrics = Arc::new(Metrics::default());
        metrics.bytes_sent.add(40);
        metrics.bytes_sent.increment();
        metrics.players.change(3);
        metrics.players.change(-1);
        metrics.refused.count(&Refused::Token);
        metrics.cycles.duration.record(Duration::from_millis(3));
        let text = metrics.text();
        for line in [
            "maniple_bytes_sent_total 41",
            "maniple_players 2",
            "maniple_refused_total{reason=\"token\"} 1",
            "maniple_refused_total{reason=\"full\"} 0",
            "maniple_cycle_seconds_bucket{le=\"0.002\"} 0",
            "maniple_cycle_seconds_bucket{le=\"0.003\"} 1",
            "maniple_cycle_seconds_bucket{le=\"+Inf\"} 1",
            "maniple_cycle_seconds_sum 0.003",
            "maniple_cycle_seconds_count 1",
        ] {
            assert!(text.lines().any(|found| found == line), "{line}: {text}");
        }
    }
}
