//! From what a referee records to the bytes of a replay, and back.

use std::io::{self, Write};

use maniple_game::{Files, LoadError, Loaded, LoadedFile, Overrides, load};
use maniple_geometry::Cycle;
use maniple_protocol::{EncodeError, PROTOCOL, Record, Replay, ReplayHeader, ReplayWriter};
use maniple_referee::RecordedEvent;
use maniple_view::Digest;
use thiserror::Error;

/// Name and version of the program, as replays name it.
pub const BUILD: &str = concat!("maniple ", env!("CARGO_PKG_VERSION"));

/// The replay of a match that is being played. It goes to where it is kept record by record: a match can be long, and
/// its players decide how much there is to record.
#[derive(Debug)]
pub struct Recording<W> {
    writer: ReplayWriter,
    sink: W,
}

/// Why a match cannot be recorded.
#[derive(Debug, Error)]
pub enum RecordingError {
    /// A record that is too large.
    #[error("the replay: {0}")]
    Encode(#[from] EncodeError),
    /// The sink does not take it.
    #[error("the replay cannot be written: {0}")]
    Write(#[from] io::Error),
}

impl<W: Write> Recording<W> {
    /// Begins the replay of a match that has not begun; it holds the files that the match was loaded from. What is
    /// written should be buffered: records are small.
    ///
    /// # Errors
    /// Files that are too large for a replay, or a sink that does not take it.
    ///
    /// # Panics
    /// If the match was not loaded from a scenario.
    pub fn begin(loaded: &Loaded, mut sink: W) -> Result<Self, RecordingError> {
        let files = &loaded.files.0;
        let scenario = files.first().expect("a match is made of a scenario");
        let header = ReplayHeader {
            protocol: PROTOCOL,
            build: BUILD.to_owned(),
            scenario_name: loaded.scenario.name.clone(),
            files: files.iter().map(|file| (file.path.clone(), file.bytes.clone())).collect(),
            scenario: scenario.path.clone(),
            // Named even where it is the scenario's own: what was loaded does not tell, and loads the same.
            map_override: loaded.map_path.clone(),
            seed: loaded.scenario.seed,
            cycles_max: loaded.scenario.cycles_max.0,
            rate: loaded.scenario.rate,
            profile: loaded.scenario.profile,
            map_hash: Digest(loaded.map.hash()),
            seats: u16::try_from(loaded.scenario.seats.len()).expect("seats are counted in 16 bits"),
        };
        let (writer, bytes) = ReplayWriter::begin(&header)?;
        sink.write_all(&bytes)?;
        Ok(Self { writer, sink })
    }

    /// Puts what a referee has recorded behind what was before.
    ///
    /// # Errors
    /// A record that is too large for a replay, or a sink that does not take it.
    pub fn extend(&mut self, events: impl IntoIterator<Item = RecordedEvent>) -> Result<(), RecordingError> {
        for event in events {
            self.sink.write_all(&self.writer.push(&record_of(event))?)?;
        }
        Ok(())
    }

    /// Goes on with a replay behind what a sink has of it.
    pub(crate) fn resume(writer: ReplayWriter, sink: W) -> Self {
        Self { writer, sink }
    }

    /// Returns the sink.
    pub(crate) fn sink(&mut self) -> &mut W {
        &mut self.sink
    }

    /// Returns the sink, whatever is still on its way.
    pub(crate) fn into_sink(self) -> W {
        self.sink
    }

    /// Writes what is still on its way, and returns the sink.
    ///
    /// # Errors
    /// A sink that does not take it.
    pub fn finish(mut self) -> Result<W, RecordingError> {
        self.sink.flush()?;
        Ok(self.sink)
    }
}

/// Returns what a referee takes to play a replay again, in order, with the end if the replay has one.
pub fn events(replay: &Replay) -> impl Iterator<Item = RecordedEvent> {
    let ended = replay.ended.iter().map(|result| RecordedEvent::Ended { result: result.clone() });
    replay.records.iter().cloned().map(event_of).chain(ended)
}

/// Returns the files from which the match of a replay is loaded.
#[must_use]
pub fn files(header: &ReplayHeader) -> Files {
    let file = |(path, bytes): &(String, Vec<u8>)| LoadedFile { path: path.clone(), bytes: bytes.clone() };
    Files(header.files.iter().map(file).collect())
}

/// A header that no match can be started from.
#[derive(Debug, Error)]
pub enum StartError {
    /// The files are none of a match.
    #[error(transparent)]
    Load(#[from] LoadError),
    /// They have another number of seats.
    #[error("the header says {header} seats, the scenario in it has {scenario}; record the match again")]
    Seats {
        /// The number of the header.
        header: u16,
        /// The number of the scenario.
        scenario: usize,
    },
    /// The map is another.
    #[error(
        "the map hashes to {found}, the replay says {header}; this build reads maps differently from {build}"
    )]
    Map {
        /// The hash of the header.
        header: Digest,
        /// The hash now.
        found: Digest,
        /// The program that recorded it.
        build: String,
    },
}

/// Returns the start of the match of a replay.
///
/// # Errors
/// See [`StartError`].
pub fn loaded(header: &ReplayHeader) -> Result<Loaded, StartError> {
    let mut loaded = load(&files(header), &header.scenario, &overrides(header))?;
    loaded.limit_cycles(Cycle(header.cycles_max));
    let seats = loaded.scenario.seats.len();
    if usize::from(header.seats) != seats {
        return Err(StartError::Seats { header: header.seats, scenario: seats });
    }
    let found = Digest(loaded.map.hash());
    if found != header.map_hash {
        let (header, build) = (header.map_hash, header.build.clone());
        return Err(StartError::Map { header, found, build });
    }
    Ok(loaded)
}

/// Returns what was asked for in the match of a replay instead of what its scenario says: all of it.
#[must_use]
pub fn overrides(header: &ReplayHeader) -> Overrides {
    let asked = Overrides {
        map: header.map_override.clone(),
        seed: Some(header.seed),
        rate: Some(header.rate),
        ..Overrides::default()
    };
    asked.with_profile(&header.profile)
}

fn record_of(event: RecordedEvent) -> Record {
    match event {
        RecordedEvent::Joined { cycle, seat, name } => Record::Joined { cycle, seat, name },
        RecordedEvent::Commands { cycle, seat, seen_cycle, commands } => {
            Record::Commands { cycle, seat, seen_cycle, list: commands }
        }
        RecordedEvent::Forfeited { cycle, seat } => Record::Absent { cycle, seat },
        RecordedEvent::Hash { cycle, hash } => Record::Cycle { cycle, hash },
        RecordedEvent::Ended { result } => Record::Ended { result },
    }
}

fn event_of(record: Record) -> RecordedEvent {
    match record {
        Record::Joined { cycle, seat, name } => RecordedEvent::Joined { cycle, seat, name },
        Record::Commands { cycle, seat, seen_cycle, list } => {
            RecordedEvent::Commands { cycle, seat, seen_cycle, commands: list }
        }
        Record::Absent { cycle, seat } => RecordedEvent::Forfeited { cycle, seat },
        Record::Cycle { cycle, hash } => RecordedEvent::Hash { cycle, hash },
        Record::Ended { result } => RecordedEvent::Ended { result },
    }
}
