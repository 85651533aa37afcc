//! What a match consists of: a TOML text, checked once.

mod check;
mod error;
mod file;
mod nearest;
mod overrides;
mod profile;

use std::time::Duration;

use maniple_geometry::Cycle;
use maniple_view::{Profile, Stops, UnitType, UnitTypeId};

pub use error::{Problem, ScenarioError};
pub use file::Stall;
pub use overrides::Overrides;

/// Longest text of a scenario, in bytes; a scenario of a thousand unit types is shorter.
pub const SCENARIO_BYTES_MAX: usize = 1 << 20;

/// Longest name of a scenario, unit type or bot, in bytes: it has to fit on one line.
pub const NAME_BYTES_MAX: usize = 64;

/// Smallest rate, in cycles a second: a cycle of a quarter of an hour. Every length and speed divided by it stays
/// in range.
pub const RATE_MIN: f64 = 1.0 / 1024.0;

/// Most cycles a second: a cycle of a millisecond is the shortest that a real-time server can keep.
pub const RATE_MAX: f64 = 1000.0;

/// Cycles a second where a scenario does not say.
pub const RATE_DEFAULT: f64 = 8.0;

/// Longest match, in seconds: a day. With [`RATE_MAX`] that is 86.4 million cycles, far below 2^32.
pub const LENGTH_SECONDS_MAX: f64 = 86_400.0;

/// Smallest time bank, in seconds: shorter than a clock can tell.
pub const TIME_BANK_SECONDS_MIN: f64 = 0.001;

/// Largest time bank, in seconds: longer, and nobody would know the match from a hung one.
pub const TIME_BANK_SECONDS_MAX: f64 = 3600.0;

/// Time bank where a scenario does not say, in seconds.
pub const TIME_BANK_SECONDS_DEFAULT: f64 = 10.0;

/// Most seats: each gets a delta a cycle.
pub const SEATS_MAX: usize = 64;

/// Most unit types.
pub const UNIT_TYPES_MAX: usize = 256;

/// Most groups of a seat; one a unit type is the usual number.
pub const GROUPS_MAX: usize = UNIT_TYPES_MAX;

/// Most units of a seat: a cycle takes four commands for each.
pub const UNITS_MAX: u32 = 4096;

/// How far a unit sees where a scenario does not say, in world units, hull to hull.
pub const SIGHT_DEFAULT: f64 = 8.0;

/// Shortest sight, in world units; above any skin, so that whoever stops a unit is seen by it.
pub const SIGHT_MIN: f64 = 1.0 / 1024.0;

/// Edge of a zone that a map does not give, where a scenario does not say, in tiles.
pub const ZONE_SIZE_DEFAULT: f64 = 8.0;

/// Longest edge of a placed zone, in tiles: that of the largest map.
pub const ZONE_SIZE_MAX: f64 = maniple_tilemap::SIZE_MAX as f64;

/// A checked scenario; speeds are in world units a cycle.
#[derive(Clone, Debug, PartialEq)]
pub struct Scenario {
    /// Its name.
    pub name: String,
    /// The path of its map, relative to the scenario's own folder.
    pub map: String,
    /// Cycles a second.
    pub rate: f64,
    /// Cycles that the match lasts at most; at least one.
    pub cycles_max: Cycle,
    /// What all randomness of the match starts from.
    pub seed: u64,
    /// Who stops in a collision.
    pub stops: Stops,
    /// What accuracy is traded with.
    pub profile: Profile,
    /// How long a lock-step cycle waits.
    pub clock: Clock,
    /// What seats see; `None`: everything.
    pub vision: Option<Vision>,
    /// What the match is about.
    pub objective: Objective,
    /// The unit types, by name; a [`UnitTypeId`] is the place in this list.
    pub unit_types: Vec<UnitType>,
    /// The seats; at least one.
    pub seats: Vec<SeatStart>,
}

impl Scenario {
    /// Returns the scenario that `text` holds; `name` is that of its file and only used in errors.
    ///
    /// # Errors
    /// A text that is not TOML, an unknown or missing key, a number out of range, a group of an unknown unit type:
    /// with file, line and column, and the nearest known name where there is one.
    pub fn read(name: &str, text: &str) -> Result<Self, ScenarioError> {
        Self::read_with(name, text, &Overrides::default())
    }

    /// As [`Scenario::read`], but with what is asked for instead of what `text` says. Speeds stay what they are a second,
    /// whatever the rate.
    ///
    /// # Errors
    /// As [`Scenario::read`]; the overrides have been checked.
    pub(crate) fn read_with(name: &str, text: &str, overrides: &Overrides) -> Result<Self, ScenarioError> {
        check::read(name, text, overrides)
    }
}

/// How long a lock-step cycle waits for a seat, and what happens then.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Clock {
    /// What a seat may use up; a cycle's length is added each cycle, up to this.
    pub time_bank: Duration,
    /// What happens to a seat whose bank is empty.
    pub stall: Stall,
}

/// What seats see.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Vision {
    /// What terrain a seat knows.
    pub terrain: TerrainKnowledge,
}

/// What terrain a seat knows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TerrainKnowledge {
    /// All of it, from the start.
    Known,
}

/// What a match is about.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Objective {
    /// The units of each seat must reach its zone.
    Race {
        /// Edge of the zones that the map does not give, in world units.
        zone_size: f64,
    },
}

/// What a seat begins with.
#[derive(Clone, Debug, PartialEq)]
pub struct SeatStart {
    /// The bot that plays the seat where nobody else does; `None` where none is named.
    pub bot: Option<String>,
    /// Its units, at least one.
    pub groups: Vec<Group>,
}

/// Units of one type.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Group {
    /// Their type.
    pub unit_type: UnitTypeId,
    /// How many; at least one.
    pub count: u32,
}
