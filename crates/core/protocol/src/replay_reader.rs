//! Reads replays, and says where one was cut or altered.

use std::fmt;

use maniple_geometry::Cycle;
use maniple_view::{MatchResult, Seat};
use serde::de::DeserializeOwned;
use thiserror::Error;

use crate::codec;
use crate::limits::REPLAY_RECORD_MAX;
use crate::message::PROTOCOL;
use crate::replay::{
    CHECKSUM_SIZE, LENGTH_SIZE, MAGIC, PREAMBLE_SIZE, REPLAY_VERSION, Record, ReplayHeader, ReplayWriter,
    next_chain, preamble_chain,
};

/// A replay in memory.
#[derive(Clone, Debug, PartialEq)]
pub struct Replay {
    /// What the match started from.
    pub header: ReplayHeader,
    /// What happened, in order, without the end.
    pub records: Vec<Record>,
    /// How it ended; `None` only in a [`Partial`].
    pub ended: Option<MatchResult>,
}

/// As much of a replay as is whole.
#[derive(Clone, Debug)]
pub struct Partial {
    /// What could be read.
    pub replay: Replay,
    /// How many bytes of the file are whole records; a journal is cut to this length before it goes on.
    pub whole_bytes: usize,
    /// Why the rest could not be read; `None` where the replay is finished.
    pub fault: Option<ReplayError>,
    chain: u64,
    /// The last state hash.
    last_hash: Option<Mark>,
}

/// A place behind a record.
#[derive(Clone, Copy, Debug)]
struct Mark {
    byte: usize,
    chain: u64,
    /// How many records are before it, without the header.
    records: usize,
}

/// A file that is no whole replay: what is wrong, and where.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
pub struct ReplayError {
    /// What is wrong.
    pub problem: ReplayProblem,
    /// The byte, counted from 0, at which the record begins, or at which the file ends where that is the problem.
    pub byte: usize,
    /// The record, counted from 0, which is the header.
    pub record: usize,
    /// The cycle of the last state hash before; `None` where there is none.
    pub last_cycle: Option<Cycle>,
}

/// What is wrong with a replay.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
pub enum ReplayProblem {
    /// It does not begin with `MNPR`.
    #[error("this is no replay: it does not begin with `MNPR`")]
    NotAReplay,
    /// Its layout has another version.
    #[error("its layout has version {found}, this program reads {REPLAY_VERSION}")]
    Version {
        /// The version of the file.
        found: u16,
    },
    /// Its records belong to another protocol.
    #[error(
        "it was recorded with protocol {found}, this program plays back {PROTOCOL}; use the `build` it names"
    )]
    Protocol {
        /// The protocol of the header.
        found: u32,
    },
    /// A header of a match that lasts no cycle.
    #[error(
        "its header says that the match lasts 0 cycles at most; at least 1 is needed: it was not recorded so"
    )]
    NoCycles,
    /// The file ends within a record.
    #[error("the file ends within a record: it was cut")]
    Cut,
    /// The file ends after a whole record, but the match has not.
    #[error("the file ends before the match: it was cut, or recording was broken off")]
    Unfinished,
    /// A length out of range.
    #[error("a record has {length} bytes, at most {REPLAY_RECORD_MAX} are possible: the file was altered")]
    Length {
        /// The length of the file's record.
        length: u32,
    },
    /// A checksum that does not belong to the bytes before it.
    #[error("the checksum does not match: the file was altered here")]
    Altered,
    /// A body that is no record, under the right checksum.
    #[error("byte {offset} of the record's body: {problem}")]
    Malformed {
        /// The byte within the body.
        offset: usize,
        /// What is wrong there.
        problem: String,
    },
    /// A record that cannot stand here.
    #[error("{0}")]
    Order(String),
    /// Bytes behind the last record.
    #[error("there are bytes behind the end of the match")]
    AfterEnd,
}

impl fmt::Display for ReplayError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "replay, byte {}, record {}, ", self.byte, self.record)?;
        match self.last_cycle {
            Some(cycle) => write!(f, "after cycle {cycle}: {}", self.problem),
            None => write!(f, "before the first cycle: {}", self.problem),
        }
    }
}

impl Partial {
    /// Returns a writer that goes on behind [`Self::whole_bytes`].
    #[must_use]
    pub fn writer(&self) -> ReplayWriter {
        ReplayWriter::after(self.chain)
    }

    /// Drops what is behind the last state hash: commands of a cycle of which nobody knows that it was played. What the replay has is
    /// then whole cycles, and a writer goes on behind the last.
    pub fn cut_to_last_hash(&mut self) {
        let Some(Mark { byte, chain, records }) = self.last_hash else { return };
        if self.replay.ended.is_none() {
            self.replay.records.truncate(records);
            (self.whole_bytes, self.chain) = (byte, chain);
        }
    }
}

/// Reads a replay of a match that has ended.
///
/// # Errors
/// Any byte that is missing, altered or too much; see [`ReplayProblem`].
pub fn read_replay(bytes: &[u8]) -> Result<Replay, ReplayError> {
    let partial = read_partial(bytes)?;
    match partial.fault {
        None => Ok(partial.replay),
        Some(fault) => Err(fault),
    }
}

/// Reads as much of a replay as is whole: for a journal, or to look into a damaged file.
///
/// # Errors
/// A file whose header cannot be read; what is wrong behind it is in [`Partial::fault`].
pub fn read_partial(bytes: &[u8]) -> Result<Partial, ReplayError> {
    let mut reader = Reader::new(bytes)?;
    let header = reader.header().map_err(|(problem, byte)| reader.error(problem, byte))?;
    let seats = header.seats;
    let mut replay = Replay { header, records: Vec::new(), ended: None };
    let mut last_hash = None;
    let fault = loop {
        match reader.record(seats) {
            Ok(Record::Ended { result }) => replay.ended = Some(result),
            Ok(record) => {
                let is_hash = matches!(record, Record::Cycle { .. });
                replay.records.push(record);
                let records = replay.records.len();
                if is_hash {
                    last_hash = Some(Mark { byte: reader.at, chain: reader.chain, records });
                }
            }
            Err((problem, byte)) => break Some(reader.error(problem, byte)),
        }
        if replay.ended.is_some() {
            let end = reader.at;
            let is_all = end == bytes.len();
            break if is_all { None } else { Some(reader.error(ReplayProblem::AfterEnd, end)) };
        }
    };
    Ok(Partial { replay, whole_bytes: reader.at, fault, chain: reader.chain, last_hash })
}

/// A problem and the byte at which it shows.
type Fault = (ReplayProblem, usize);

struct Reader<'a> {
    bytes: &'a [u8],
    /// Where the next record begins.
    at: usize,
    /// The checksum of the record before.
    chain: u64,
    /// The number of the next record.
    record: usize,
    last_cycle: Option<Cycle>,
    /// The latest cycle that a record named.
    latest: Cycle,
}

impl<'a> Reader<'a> {
    fn new(bytes: &'a [u8]) -> Result<Self, ReplayError> {
        let mut reader = Self {
            bytes,
            at: 0,
            chain: preamble_chain(),
            record: 0,
            last_cycle: None,
            latest: Cycle::default(),
        };
        let common = bytes.len().min(MAGIC.len());
        if bytes[..common] != MAGIC[..common] {
            return Err(reader.error(ReplayProblem::NotAReplay, 0));
        }
        let Some(version) = bytes.get(MAGIC.len()..PREAMBLE_SIZE) else {
            return Err(reader.error(ReplayProblem::Cut, bytes.len()));
        };
        let found = u16::from_le_bytes([version[0], version[1]]);
        if found != REPLAY_VERSION {
            return Err(reader.error(ReplayProblem::Version { found }, MAGIC.len()));
        }
        reader.at = PREAMBLE_SIZE;
        Ok(reader)
    }

    fn header(&mut self) -> Result<ReplayHeader, Fault> {
        let start = self.at;
        let next = self.next_body()?;
        let header: ReplayHeader = parse(next.body, start)?;
        if header.protocol != PROTOCOL {
            return Err((ReplayProblem::Protocol { found: header.protocol }, start));
        }
        if header.cycles_max == 0 {
            return Err((ReplayProblem::NoCycles, start));
        }
        self.accept(&next);
        Ok(header)
    }

    fn record(&mut self, seats: u16) -> Result<Record, Fault> {
        if self.at == self.bytes.len() {
            return Err((ReplayProblem::Unfinished, self.at));
        }
        let start = self.at;
        let next = self.next_body()?;
        let record: Record = parse(next.body, start)?;
        self.check_order(&record, seats).map_err(|problem| (ReplayProblem::Order(problem), start))?;
        self.accept(&next);
        Ok(record)
    }

    /// Returns the next record without going behind it.
    fn next_body(&self) -> Result<Next<'a>, Fault> {
        let cut = (ReplayProblem::Cut, self.bytes.len());
        let rest = &self.bytes[self.at..];
        let Some((prefix, tail)) = rest.split_first_chunk::<LENGTH_SIZE>() else { return Err(cut) };
        let length = u32::from_le_bytes(*prefix);
        let size = usize::try_from(length).unwrap_or(usize::MAX);
        if size > REPLAY_RECORD_MAX {
            return Err((ReplayProblem::Length { length }, self.at));
        }
        let whole = tail.split_at_checked(size);
        let whole = whole.and_then(|(body, tail)| Some((body, tail.first_chunk::<CHECKSUM_SIZE>()?)));
        let Some((body, checksum)) = whole else {
            return Err(if self.has_flipped_length(rest) { (ReplayProblem::Altered, self.at) } else { cut });
        };
        let chain = next_chain(self.chain, &rest[..LENGTH_SIZE + size]);
        if u64::from_le_bytes(*checksum) != chain {
            return Err((ReplayProblem::Altered, self.at));
        }
        Ok(Next { body, chain, end: self.at + LENGTH_SIZE + size + CHECKSUM_SIZE })
    }

    /// Returns whether the record is whole if one bit of its length is another: then the file was not cut, but altered.
    fn has_flipped_length(&self, rest: &[u8]) -> bool {
        let Some((prefix, tail)) = rest.split_first_chunk::<LENGTH_SIZE>() else { return false };
        let length = u32::from_le_bytes(*prefix);
        (0..u32::BITS).any(|bit| {
            let length = length ^ (1 << bit);
            let size = usize::try_from(length).unwrap_or(usize::MAX);
            let whole = tail.split_at_checked(size);
            let Some((body, tail)) = whole else { return false };
            let Some(checksum) = tail.first_chunk::<CHECKSUM_SIZE>() else { return false };
            let bytes = [&length.to_le_bytes(), body].concat();
            u64::from_le_bytes(*checksum) == next_chain(self.chain, &bytes)
        })
    }

    fn accept(&mut self, next: &Next<'_>) {
        self.at = next.end;
        self.chain = next.chain;
        self.record += 1;
    }

    fn check_order(&mut self, record: &Record, seats: u16) -> Result<(), String> {
        let (cycle, seat) = match *record {
            Record::Joined { cycle, seat, .. }
            | Record::Commands { cycle, seat, .. }
            | Record::Absent { cycle, seat } => (cycle, Some(seat)),
            Record::Cycle { cycle, .. } => (cycle, None),
            Record::Ended { .. } => return Ok(()),
        };
        if let Some(Seat(number)) = seat
            && number >= seats
        {
            return Err(format!("seat {number} of a match with {seats} seats, which count from 0"));
        }
        if cycle < self.latest {
            return Err(format!("cycle {cycle} after cycle {}", self.latest));
        }
        if let Record::Cycle { .. } = record {
            if let Some(last) = self.last_cycle
                && last.0.checked_add(1) != Some(cycle.0)
            {
                return Err(format!("the hash of cycle {cycle} after that of cycle {last}"));
            }
            self.last_cycle = Some(cycle);
        }
        self.latest = cycle;
        Ok(())
    }

    fn error(&self, problem: ReplayProblem, byte: usize) -> ReplayError {
        ReplayError { problem, byte, record: self.record, last_cycle: self.last_cycle }
    }
}

/// A record whose checksum is right.
struct Next<'a> {
    body: &'a [u8],
    chain: u64,
    /// Where it ends in the file.
    end: usize,
}

fn parse<T: DeserializeOwned>(body: &[u8], start: usize) -> Result<T, Fault> {
    codec::decode(body)
        .map_err(|error| (ReplayProblem::Malformed { offset: error.offset, problem: error.problem }, start))
}

#[cfg(test)]
mod tests {
    use maniple_view::{Digest, Profile};

    use super::*;
    use crate::arbitrary::Random;

    #[test]
    fn a_replay_reads_back() {
        let (bytes, replay) = sample();
        assert_eq!(read_replay(&bytes), Ok(replay));
    }

    #[test]
    fn a_file_cut_anywhere_is_an_error_that_says_where() {
        let (bytes, _) = sample();
        let borders = borders(&bytes);
        for length in 0..bytes.len() {
            let error = read_replay(&bytes[..length]).unwrap_err();
            assert_eq!(error.byte, length, "{error}");
            let is_border = borders.contains(&length);
            let expected = if is_border { ReplayProblem::Unfinished } else { ReplayProblem::Cut };
            assert_eq!(error.problem, expected, "cut to {length}");
            let whole = borders.iter().filter(|&&border| border <= length).count();
            assert_eq!(error.record, whole, "cut to {length}");
        }
    }

    #[test]
    fn a_byte_altered_anywhere_is_an_error_at_its_record() {
        let (bytes, _) = sample();
        let borders = borders(&bytes);
        for place in 0..bytes.len() {
            for flip in [1, 0x80, 0xff] {
                let mut altered = bytes.clone();
                altered[place] ^= flip;
                let error = read_replay(&altered).unwrap_err();
                let record = borders.iter().filter(|&&border| border <= place).count();
                assert_eq!(error.record, record, "byte {place}: {error}");
            }
        }
    }

    #[test]
    fn records_that_are_swapped_left_out_or_doubled_are_an_error() {
        let (bytes, _) = sample();
        let borders = borders(&bytes);
        for (i, window) in borders.windows(3).enumerate() {
            let [a, b, c] = window else { panic!("three borders") };
            let (head, first, second, tail) = (&bytes[..*a], &bytes[*a..*b], &bytes[*b..*c], &bytes[*c..]);
            for pieces in [[head, second, first, tail], [head, second, tail, &[]], [head, first, first, tail]]
            {
                let error = read_replay(&pieces.concat()).unwrap_err();
                assert!(error.record > i, "{error}");
            }
        }
        let doubled = [&bytes, &bytes[borders[1]..]].concat();
        assert_eq!(read_replay(&doubled).unwrap_err().problem, ReplayProblem::AfterEnd);
    }

    #[test]
    fn an_error_tells_byte_record_and_last_cycle() {
        let (bytes, _) = sample();
        let error = read_replay(&bytes[..bytes.len() - 1]).unwrap_err();
        let place = format!("replay, byte {}, record 9, after cycle 2: ", bytes.len() - 1);
        assert_eq!(error.to_string(), place + "the file ends within a record: it was cut");
        assert_eq!(
            read_replay(b"PK").unwrap_err().to_string(),
            "replay, byte 0, record 0, before the first cycle: this is no replay: it does not begin with `MNPR`"
        );
        assert_eq!(read_replay(b"MNPR\x02\0").unwrap_err().problem, ReplayProblem::Version { found: 2 });
    }

    #[test]
    fn records_that_cannot_stand_there_are_an_error() {
        let hash = Digest(1);
        check_order(&[Record::Absent { cycle: Cycle(0), seat: Seat(2) }], 1);
        check_order(&[Record::Cycle { cycle: Cycle(0), hash }, Record::Cycle { cycle: Cycle(2), hash }], 2);
        check_order(&[Record::Cycle { cycle: Cycle(0), hash }, Record::Cycle { cycle: Cycle(0), hash }], 2);
        check_order(
            &[Record::Cycle { cycle: Cycle(1), hash }, Record::Absent { cycle: Cycle(0), seat: Seat(0) }],
            2,
        );
    }

    #[test]
    fn another_protocol_is_refused() {
        let header = ReplayHeader { protocol: PROTOCOL + 1, ..header() };
        let (_, bytes) = ReplayWriter::begin(&header).unwrap();
        let problem = ReplayProblem::Protocol { found: PROTOCOL + 1 };
        assert_eq!(read_replay(&bytes).unwrap_err().problem, problem);
    }

    #[test]
    fn a_match_without_a_cycle_is_refused() {
        let header = ReplayHeader { cycles_max: 0, ..header() };
        let (_, bytes) = ReplayWriter::begin(&header).unwrap();
        assert_eq!(read_replay(&bytes).unwrap_err().problem, ReplayProblem::NoCycles);
    }

    #[test]
    fn a_journal_goes_on_where_it_was_cut() {
        let (bytes, replay) = sample();
        for length in 0..bytes.len() {
            let Ok(partial) = read_partial(&bytes[..length]) else { continue };
            let mut whole = bytes[..partial.whole_bytes].to_vec();
            let mut writer = partial.writer();
            for record in &replay.records[partial.replay.records.len()..] {
                whole.extend(writer.push(record).unwrap());
            }
            let result = replay.ended.clone().unwrap();
            whole.extend(writer.push(&Record::Ended { result }).unwrap());
            assert_eq!(whole, bytes, "cut to {length}");
        }
    }

    #[test]
    fn random_bytes_are_an_error() {
        for seed in 0..1000 {
            let mut random = Random::new(seed);
            let (bytes, _) = sample();
            let mut forged = bytes[..random.below(bytes.len())].to_vec();
            forged.extend(random.bytes(64));
            if !bytes.starts_with(&forged) {
                assert!(read_replay(&forged).is_err(), "seed {seed}");
            }
        }
    }

    /// A header and 9 records: hashes of the cycles 0, 1 and 2, and one of each other kind.
    fn sample() -> (Vec<u8>, Replay) {
        let mut random = Random::new(11);
        let header = header();
        let hash = |cycle: u32| Record::Cycle { cycle: Cycle(cycle), hash: Digest(u64::from(cycle) << 60) };
        let commands = |seat: u16, list| Record::Commands {
            cycle: Cycle(1),
            seat: Seat(seat),
            seen_cycle: Cycle(0),
            list,
        };
        let records = vec![
            Record::Joined { cycle: Cycle(0), seat: Seat(0), name: "Ada".to_owned() },
            Record::Joined { cycle: Cycle(0), seat: Seat(1), name: "Élie".to_owned() },
            hash(0),
            hash(1),
            commands(0, (0..3).map(|_| random.sequenced()).collect()),
            commands(1, Vec::new()),
            Record::Absent { cycle: Cycle(1), seat: Seat(1) },
            hash(2),
        ];
        let result = random.result();
        let (mut writer, mut bytes) = ReplayWriter::begin(&header).unwrap();
        for record in &records {
            bytes.extend(writer.push(record).unwrap());
        }
        bytes.extend(writer.push(&Record::Ended { result: result.clone() }).unwrap());
        (bytes, Replay { header, records, ended: Some(result) })
    }

    fn header() -> ReplayHeader {
        ReplayHeader {
            protocol: PROTOCOL,
            build: "maniple 0.1.0".to_owned(),
            scenario_name: "race".to_owned(),
            files: vec![
                ("race.toml".to_owned(), b"map = \"a.map\"".to_vec()),
                ("a.map".to_owned(), vec![0, 255, 10]),
            ],
            scenario: "race.toml".to_owned(),
            map_override: None,
            seed: 1 << 40,
            cycles_max: 900,
            rate: 8.0,
            profile: Profile::EXACT,
            map_hash: Digest(77),
            seats: 2,
        }
    }

    /// Returns where the records end, the header's first.
    fn borders(bytes: &[u8]) -> Vec<usize> {
        let mut borders = Vec::new();
        let mut at = PREAMBLE_SIZE;
        while at < bytes.len() {
            let length = u32::from_le_bytes(bytes[at..at + 4].try_into().unwrap());
            at += LENGTH_SIZE + usize::try_from(length).unwrap() + CHECKSUM_SIZE;
            borders.push(at);
        }
        borders
    }

    fn check_order(records: &[Record], expected_record: usize) {
        let (mut writer, mut bytes) = ReplayWriter::begin(&header()).unwrap();
        for record in records {
            bytes.extend(writer.push(record).unwrap());
        }
        let error = read_replay(&bytes).unwrap_err();
        assert!(matches!(error.problem, ReplayProblem::Order(_)), "{error}");
        assert_eq!(error.record, expected_record, "{error}");
    }
}
