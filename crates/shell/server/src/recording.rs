//! From what the referee records to the bytes of a replay, and back.

use maniple_protocol::{EncodeError, PROTOCOL, Record, ReplayHeader, ReplayWriter};
use maniple_referee::{RecordedEvent, Referee};
use maniple_view::Digest;

/// Name and version of the program, as replays name it.
const BUILD: &str = concat!("maniple ", env!("CARGO_PKG_VERSION"));

/// The replay of a match that is being played.
#[derive(Debug)]
pub struct Recording {
    writer: ReplayWriter,
    bytes: Vec<u8>,
}

impl Recording {
    /// Returns the replay of a match that has not begun; it holds the files that the match was loaded from.
    /// `map_override` is the map's name among them, where another one than the scenario's is played.
    ///
    /// # Errors
    /// Files that are too large for a replay.
    pub fn begin(referee: &Referee, map_override: Option<String>) -> Result<Self, EncodeError> {
        let loaded = referee.loaded();
        let files = loaded.files.0.iter().map(|file| (file.path.clone(), file.bytes.clone()));
        let header = ReplayHeader {
            protocol: PROTOCOL,
            build: BUILD.to_owned(),
            scenario_name: loaded.scenario.name.clone(),
            files: files.collect(),
            scenario: loaded.files.0.first().map(|file| file.path.clone()).unwrap_or_default(),
            map_override,
            seed: loaded.scenario.seed,
            map_hash: Digest(loaded.map.hash()),
            seats: u16::try_from(referee.seats()).expect("seats are counted in 16 bits"),
        };
        let (writer, bytes) = ReplayWriter::begin(&header)?;
        Ok(Self { writer, bytes })
    }

    /// Takes the referee's records and puts them behind those before. Call it after each step, and after whatever may
    /// have given a record before the next step: joins are recorded with the cycle in which this is called.
    ///
    /// # Errors
    /// A record that is too large for a replay.
    pub fn record(&mut self, referee: &mut Referee) -> Result<(), EncodeError> {
        for event in referee.take_records() {
            let record = match event {
                RecordedEvent::Joined { seat, name } => Record::Joined { cycle: referee.cycle(), seat, name },
                RecordedEvent::Commands { cycle, seat, seen_cycle, commands } => {
                    Record::Commands { cycle, seat, seen_cycle, list: commands }
                }
                RecordedEvent::Forfeited { cycle, seat } => Record::Absent { cycle, seat },
                RecordedEvent::Hash { cycle, hash } => Record::Cycle { cycle, hash },
                RecordedEvent::Ended { result } => Record::Ended { result },
            };
            self.bytes.extend(self.writer.push(&record)?);
        }
        Ok(())
    }

    /// Returns the bytes of the replay so far.
    #[must_use]
    pub fn into_bytes(self) -> Vec<u8> {
        self.bytes
    }
}

/// Returns what a referee takes to play a record again.
#[must_use]
pub fn event_of(record: Record) -> RecordedEvent {
    match record {
        Record::Joined { cycle: _, seat, name } => RecordedEvent::Joined { seat, name },
        Record::Commands { cycle, seat, seen_cycle, list } => {
            RecordedEvent::Commands { cycle, seat, seen_cycle, commands: list }
        }
        Record::Absent { cycle, seat } => RecordedEvent::Forfeited { cycle, seat },
        Record::Cycle { cycle, hash } => RecordedEvent::Hash { cycle, hash },
        Record::Ended { result } => RecordedEvent::Ended { result },
    }
}
