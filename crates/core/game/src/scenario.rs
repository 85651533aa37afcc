//! What a match consists of: a TOML text, checked once.

mod check;
mod error;
mod file;
mod map;
mod nearest;
mod overrides;
mod profile;
mod spectators;
mod units;

use std::time::Duration;

use maniple_geometry::Cycle;
use maniple_tilemap::Request;
use maniple_view::{Identity, Profile, Stops, TerrainKnowledge, UnitType, UnitTypeId};

pub(crate) use check::{Draft, Source};
pub use error::{Problem, ScenarioError};
pub use file::{Stall, Views};
pub use overrides::Overrides;
pub use spectators::Spectators;

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

/// Most units that a building trains or has waiting.
pub const TRAINING_MAX: u32 = 5;

/// How far a unit sees where a scenario does not say, in world units, hull to hull.
pub const SIGHT_DEFAULT: f64 = 8.0;

/// Shortest sight, in world units; above any skin, so that whoever stops a unit is seen by it.
pub const SIGHT_MIN: f64 = 1.0 / 1024.0;

/// Edge of a zone that a map does not give, where a scenario does not say, in tiles.
pub const ZONE_SIZE_DEFAULT: f64 = 8.0;

/// Most files of unit types.
pub const UNIT_FILES_MAX: usize = 16;

/// Largest of the whole numbers of a unit type and of a stock: sums of 4,096 of them fit into 32 bits.
pub const COUNT_MAX: u32 = 1_000_000;

/// Longest cooldown, switch, pause and time of making, in seconds: an hour.
pub const SECONDS_MAX: f64 = 3600.0;

/// Shortest range of a weapon, in world units: above the skin of doubles, so that who touches a target can hit it.
pub const RANGE_MIN: f64 = 1.0 / 64.0;

/// Shortest side of a rectangle, in world units.
pub const SIDE_MIN: f64 = 1.0 / 16.0;

/// Longest side of a rectangle, in world units.
pub const SIDE_MAX: f64 = 64.0;

/// What it takes to make a unit where its type does not say, in seconds.
pub const MAKE_SECONDS_DEFAULT: f64 = 10.0;

/// How far neutral units wander where a scenario does not say, in world units.
pub const WANDER_DEFAULT: f64 = 4.0;

/// Shortest way that neutral units wander at most, in world units.
pub const WANDER_MIN: f64 = 1.0 / 16.0;

/// Longest way that neutral units wander at most, in world units.
pub const WANDER_MAX: f64 = 4096.0;

/// How long neutral units rest in the mean where a scenario does not say, in seconds.
pub const PAUSE_SECONDS_DEFAULT: f64 = 4.0;

/// Spawns of each seat on a generated map, where a scenario does not say.
pub const SPAWNS_DEFAULT: u32 = 1;

/// Clusters of patches on a generated map, where a scenario does not say.
pub const CLUSTERS_DEFAULT: u32 = 0;

/// Patches of a cluster on a generated map, where a scenario does not say.
pub const PATCHES_DEFAULT: u32 = 6;

/// How much there is of each patch on a generated map, where a scenario does not say.
pub const PATCH_AMOUNT_DEFAULT: u32 = 1000;

/// By how much spectators are behind where a scenario does not say, in seconds: what a player is told of the present
/// by somebody who watches is too old to help.
pub const DELAY_SECONDS_DEFAULT: f64 = 30.0;

/// Longest time by which spectators are behind, in seconds: ten minutes.
pub const DELAY_SECONDS_MAX: f64 = 600.0;

/// Most cycles by which spectators are behind: the deltas of so many are kept of each view, which is 3 MB of each
/// where nothing happens, and ten minutes at 13 cycles a second.
pub const DELAY_CYCLES_MAX: u32 = 8192;

/// Largest number of a team.
pub const TEAM_MAX: u16 = 63;

/// Longest edge of a placed zone, in tiles: that of the largest map.
pub const ZONE_SIZE_MAX: f64 = maniple_tilemap::SIZE_MAX as f64;

/// A checked scenario; speeds are in world units a cycle.
#[derive(Clone, Debug, PartialEq)]
pub struct Scenario {
    /// Its name.
    pub name: String,
    /// Where its map comes from.
    pub map: MapSource,
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
    /// How units fight; `None`: they do not.
    pub combat: Option<Combat>,
    /// How units gather; `None`: they do not.
    pub harvest: Option<HarvestRule>,
    /// Whether units are made.
    pub production: bool,
    /// Whether units have modes.
    pub modes: bool,
    /// Who belongs to nobody and wanders; `None`: nobody does.
    pub neutral: Option<Neutral>,
    /// Who may watch what; `None`: nobody may.
    pub spectators: Option<Spectators>,
    /// What the match is about.
    pub objective: Objective,
    /// The unit types, by name; a [`UnitTypeId`] is the place in this list.
    pub unit_types: Vec<UnitType>,
    /// The seats; at least one.
    pub seats: Vec<SeatStart>,
}

impl Scenario {
    /// Returns the scenario that `text` holds, with no unit types but its own; `name` is that of its file and only used in errors.
    ///
    /// # Errors
    /// A text that is not TOML, an unknown or missing key, a number out of range, a group of an unknown unit type:
    /// with file, line and column, and the nearest known name where there is one.
    pub fn read(name: &str, text: &str) -> Result<Self, ScenarioError> {
        Draft::parse(Source { name, text })?.checked(&[], &Overrides::default())
    }
}

/// Where a map comes from.
#[derive(Clone, Debug, PartialEq)]
pub enum MapSource {
    /// The path of a file, relative to the scenario's own folder.
    File(String),
    /// It is made from the seed of the match.
    Generated(Request),
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
    /// Whether blocked tiles hide what lies behind them from those on the ground.
    pub walls_block: bool,
    /// Whether an object that comes back into sight is known again.
    pub identity: Identity,
}

/// How units fight.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Combat {
    /// Whether splash hurts objects of the same team, too.
    pub friendly_fire: bool,
}

/// How units gather.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct HarvestRule {
    /// The type of the resources on the map.
    pub patch: UnitTypeId,
}

/// Who belongs to nobody and wanders.
#[derive(Clone, Debug, PartialEq)]
pub struct Neutral {
    /// The units, at least one.
    pub groups: Vec<Group>,
    /// Half the edge of the square around a unit in which it chooses its next goal, in world units.
    pub wander: f64,
    /// Cycles that a unit rests in the mean; at least one.
    pub pause: u32,
}

/// What a match is about; see [`maniple_view::Objective`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Objective {
    /// The units of each seat must reach its zone.
    Race {
        /// Edge of the zones that the map does not give, in world units.
        zone_size: f64,
    },
    /// Who gathers most.
    Resources {
        /// Resources with which a team wins at once.
        goal: Option<u32>,
    },
    /// Who destroys most units.
    Kills,
    /// Who destroys most buildings.
    Buildings,
    /// Who is the last to have units or buildings.
    LastStanding,
    /// Whether a team survives.
    Survive {
        /// The team.
        team: u16,
    },
}

/// What a seat begins with.
#[derive(Clone, Debug, PartialEq)]
pub struct SeatStart {
    /// The bot that plays the seat where nobody else does; `None` where none is named.
    pub bot: Option<String>,
    /// Its team, 0 to [`TEAM_MAX`]; the seat's own number where the scenario does not say.
    pub team: u16,
    /// Its resources.
    pub stock: u32,
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
