//! What became of a command, and of a match.

use maniple_geometry::Cycle;
use serde::{Deserialize, Serialize};
use thiserror::Error;

use crate::identity::{Digest, Handle, Seat, UnitTypeId};

/// The answer to one command.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CommandResult {
    /// The number that came with the command.
    pub seq: u32,
    /// What became of it.
    pub outcome: Outcome,
}

/// What became of a command.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Outcome {
    /// It was applied at the start of `cycle`.
    Applied {
        /// The cycle.
        cycle: Cycle,
        /// Cycles between the last one that the client had seen and `cycle`; 0 in time.
        late: u32,
    },
    /// It was refused, and nothing changed.
    Refused {
        /// Why.
        reason: Refusal,
    },
}

/// Why a command was refused.
#[derive(Clone, Debug, Error, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Refusal {
    /// The seat has no such object. "Not yours", "not visible" and "never existed" are this one reason.
    #[error("no object of yours has this handle")]
    UnknownHandle,
    /// The goal is outside of the world.
    #[error("the goal is outside of the world, which is 0..{width} by 0..{height}")]
    OutOfWorld {
        /// World units to the right.
        width: u32,
        /// World units down.
        height: u32,
    },
    /// A number that no world accepts.
    #[error("{field} {problem}")]
    BadNumber {
        /// The field of the command.
        field: String,
        /// What is wrong with it.
        problem: String,
    },
    /// Faster than the object can go.
    #[error("faster than the {max} world units a cycle of this unit type")]
    TooFast {
        /// The largest speed, in world units a cycle.
        max: f64,
    },
    /// The object cannot do this: it does not move.
    #[error("this unit type has no such action")]
    UnknownAction,
    /// More waypoints than an object may have.
    #[error("more than {max} waypoints")]
    TooManyWaypoints {
        /// The largest number.
        max: u32,
    },
    /// A path without a waypoint.
    #[error("a path needs at least one waypoint")]
    EmptyPath,
    /// More commands than the seat may give in a cycle.
    #[error("more than {max} commands in one cycle")]
    TooManyCommands {
        /// The largest number.
        max: u32,
    },
    /// The start has gone by.
    #[error("the start lies before cycle {now}, to which the command applies")]
    StartInPast {
        /// The cycle.
        now: Cycle,
    },
    /// The seat has resigned, or the match has ended.
    #[error("the seat is out of the match")]
    Out,
    /// The seat sees no object with this handle. "Not visible", "dead" and "never existed" are this one reason.
    #[error("no object in your view has the handle of the target")]
    UnknownTarget,
    /// The target is none for this: of the own team, or one that cannot be hurt, or in a layer that the weapon does not hit,
    /// or no resource patch.
    #[error(
        "the target is none for this command: own or allied, not to be hurt, out of the weapon's layers, or no patch"
    )]
    BadTarget,
    /// The object is switching its mode, or is not finished.
    #[error("the object is switching its mode, or is not finished; wait, or cancel")]
    Busy,
    /// The seat lacks resources.
    #[error("it costs {cost}, and the seat has {stock}")]
    NotAffordable {
        /// What it costs.
        cost: u32,
        /// What the seat has.
        stock: u32,
    },
    /// The seat lacks a finished building.
    #[error("it requires a finished building of unit type {}", .unit_type.0)]
    Missing {
        /// The building's type.
        unit_type: UnitTypeId,
    },
    /// The building has too many units in training.
    #[error("more than {max} units in training")]
    TrainingFull {
        /// The largest number.
        max: u32,
    },
    /// The seat has too many objects, those in training included.
    #[error("more than {max} objects of a seat")]
    TooManyObjects {
        /// The largest number.
        max: u32,
    },
    /// Nothing is in training, and the object is no site.
    #[error("nothing is in training here, and this is no building site")]
    NothingToCancel,
    /// A wall or the edge of the map is where the building was to be.
    #[error("a wall or the edge of the map is in the place of the building")]
    BadPlace,
    /// The object carries nothing, or the seat has no building that takes loads.
    #[error("nothing is carried, or the seat has no building that takes loads")]
    NothingToReturn,
}

/// How a match ended.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MatchResult {
    /// Who won, in order of the seats: all of a team. Nobody is a draw.
    pub winners: Vec<Seat>,
    /// Why it ended.
    pub reason: EndReason,
    /// The cycles that were played.
    pub cycles: Cycle,
    /// One entry a seat, in order of the seats.
    pub scores: Vec<Score>,
    /// The state hash after the last cycle.
    pub hash: Digest,
}

/// Why a match ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum EndReason {
    /// The objective was decided.
    Objective,
    /// The scenario's length was reached.
    Length,
    /// All seats but one had resigned or were forfeited.
    Resigned,
}

/// What a seat achieved.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Score {
    /// The seat.
    pub seat: Seat,
    /// The name that its player gave.
    pub name: String,
    /// The team.
    pub team: u16,
    /// What counts by the objective: more is better.
    pub points: u64,
    /// All that was counted.
    pub tally: Tally,
    /// Whether the seat resigned or was forfeited.
    pub resigned: bool,
}

/// What a seat has done so far.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Tally {
    /// Units and buildings at the start.
    pub units: u32,
    /// Units that reached the seat's zone.
    pub arrived: u32,
    /// Sum of the cycles in which they did.
    pub arrival_sum: u64,
    /// Resources that were delivered.
    pub gathered: u64,
    /// Units that it made, and buildings that it finished.
    pub made: u32,
    /// Units of other teams that it destroyed.
    pub units_destroyed: u32,
    /// Buildings of other teams that it destroyed.
    pub buildings_destroyed: u32,
    /// Its units that died.
    pub units_lost: u32,
    /// Its buildings that died.
    pub buildings_lost: u32,
    /// The cycle at whose start the last of these buildings was gone; 0 if there was none.
    pub last_building: Cycle,
}

/// Why an object stopped.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum StopReason {
    /// It reached the end of its motions.
    Arrived,
    /// It was told to.
    Ordered,
    /// It collided with an object.
    Object {
        /// The object, where the view holds it; `None` too where it collided with several at the same moment.
        other: Option<Handle>,
    },
    /// It collided with a wall.
    Segment,
    /// It collided with the edge of the world.
    Edge,
}
