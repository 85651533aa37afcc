//! What a player may say.

use maniple_geometry::Cycle;
use serde::{Deserialize, Serialize};

use crate::identity::{Handle, UnitTypeId};

/// Largest number of waypoints that wait behind an object's motion.
pub const WAYPOINTS_MAX: usize = 64;

/// Largest number of commands of a seat that one cycle takes: 4 for each of 4,096 objects.
pub const COMMANDS_A_CYCLE_MAX: usize = 16_384;

/// The moment at which a command takes effect: a cycle and a fraction of it, `0.0..=1.0`.
pub type Start = (Cycle, f64);

/// One waypoint of a path: x and y in world units, and the speed in world units a cycle; without a speed the
/// object goes at its own.
pub type Waypoint = (f64, f64, Option<f64>);

/// An order to one object, or to the match.
#[doc(alias = "order")]
#[doc(alias = "action")]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Command {
    /// Go straight to (x, y).
    Move {
        /// The object, by its owner's handle.
        object: Handle,
        /// World units to the right.
        x: f64,
        /// World units down.
        y: f64,
        /// World units a cycle; 0 stops; absent means the object's own speed, above which is refused.
        #[serde(default)]
        s: Option<f64>,
        /// Whether to go behind the motions before it, at most [`WAYPOINTS_MAX`], instead of replacing them.
        #[serde(default)]
        queue: bool,
        /// When to start. Without `queue`, what runs goes on until then; with `queue`, it starts at the later
        /// of this moment and the arrival before it.
        #[serde(default)]
        start: Option<Start>,
    },
    /// Go along waypoints; taken or refused as a whole.
    Path {
        /// The object, by its owner's handle.
        object: Handle,
        /// The waypoints, in order; 1 to [`WAYPOINTS_MAX`].
        points: Vec<Waypoint>,
        /// When to start; what runs goes on until then.
        #[serde(default)]
        start: Option<Start>,
    },
    /// Stop, and forget the motions behind.
    Stop {
        /// The object, by its owner's handle.
        object: Handle,
    },
    /// Leave the match as a loser; all objects of the seat die at the end of the cycle.
    Resign,
    /// Go straight to where the target is in range, and fire until it is dead or out of sight.
    Attack {
        /// The object, by its owner's handle.
        object: Handle,
        /// An object in sight of another team or of nobody, in a layer that the weapon hits.
        target: Handle,
    },
    /// Go straight to where a point is in range, and fire at it until told otherwise; for weapons with splash.
    AttackAt {
        /// The object, by its owner's handle.
        object: Handle,
        /// World units to the right.
        x: f64,
        /// World units down.
        y: f64,
    },
    /// Go straight to (x, y); stand and fight while an enemy is in range.
    AttackMove {
        /// The object, by its owner's handle.
        object: Handle,
        /// World units to the right.
        x: f64,
        /// World units down.
        y: f64,
    },
    /// Stand, and fight whichever enemy is in range.
    Hold {
        /// The object, by its owner's handle.
        object: Handle,
    },
    /// Go straight to a resource patch, and gather until the load is full.
    Gather {
        /// The object, by its owner's handle.
        object: Handle,
        /// A resource patch in sight.
        patch: Handle,
    },
    /// Go straight to the nearest building of the seat that takes loads, and deliver.
    ReturnLoad {
        /// The object, by its owner's handle.
        object: Handle,
    },
    /// Go straight to a place, build there, and stay until it is finished; or go on with a site of the seat that is there.
    Build {
        /// The object, by its owner's handle.
        object: Handle,
        /// What to build.
        unit_type: UnitTypeId,
        /// World units to the right, of its centre.
        x: f64,
        /// World units down, of its centre.
        y: f64,
    },
    /// Train a unit behind those that wait; paid at once.
    Train {
        /// The building, by its owner's handle.
        object: Handle,
        /// What to train.
        unit_type: UnitTypeId,
    },
    /// Give up the last unit in training, or a building site, and get back what was paid.
    Cancel {
        /// The building or site, by its owner's handle.
        object: Handle,
    },
    /// Switch to the other mode; a switch that is under way is turned back.
    Switch {
        /// The object, by its owner's handle.
        object: Handle,
    },
}

impl Command {
    /// Returns the object that obeys; `None` for a command to the match.
    #[must_use]
    pub fn object(&self) -> Option<Handle> {
        match self {
            Self::Move { object, .. }
            | Self::Path { object, .. }
            | Self::Stop { object }
            | Self::Attack { object, .. }
            | Self::AttackAt { object, .. }
            | Self::AttackMove { object, .. }
            | Self::Hold { object }
            | Self::Gather { object, .. }
            | Self::ReturnLoad { object }
            | Self::Build { object, .. }
            | Self::Train { object, .. }
            | Self::Cancel { object }
            | Self::Switch { object } => Some(*object),
            Self::Resign => None,
        }
    }

    /// Returns the object that it is aimed at; `None` where it is aimed at none.
    #[must_use]
    pub fn target(&self) -> Option<Handle> {
        match self {
            Self::Attack { target, .. } | Self::Gather { patch: target, .. } => Some(*target),
            Self::Move { .. }
            | Self::Path { .. }
            | Self::Stop { .. }
            | Self::AttackAt { .. }
            | Self::AttackMove { .. }
            | Self::Hold { .. }
            | Self::ReturnLoad { .. }
            | Self::Build { .. }
            | Self::Train { .. }
            | Self::Cancel { .. }
            | Self::Switch { .. }
            | Self::Resign => None,
        }
    }

    /// Returns whether all its numbers are finite, as JSON can say them.
    #[must_use]
    pub fn is_finite(&self) -> bool {
        let is_start_finite = |start: &Option<Start>| start.is_none_or(|(_, fraction)| fraction.is_finite());
        let is_speed_finite = |speed: Option<f64>| speed.is_none_or(f64::is_finite);
        match self {
            Self::Move { x, y, s, start, .. } => {
                x.is_finite() && y.is_finite() && is_speed_finite(*s) && is_start_finite(start)
            }
            Self::Path { points, start, .. } => {
                is_start_finite(start)
                    && points.iter().all(|&(x, y, s)| x.is_finite() && y.is_finite() && is_speed_finite(s))
            }
            Self::AttackAt { x, y, .. } | Self::AttackMove { x, y, .. } | Self::Build { x, y, .. } => {
                x.is_finite() && y.is_finite()
            }
            Self::Stop { .. }
            | Self::Resign
            | Self::Attack { .. }
            | Self::Hold { .. }
            | Self::Gather { .. }
            | Self::ReturnLoad { .. }
            | Self::Train { .. }
            | Self::Cancel { .. }
            | Self::Switch { .. } => true,
        }
    }
}

/// A command with the number that its result will carry.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Sequenced {
    /// The seat's own number for the command; need not be unique, is only sent back.
    pub seq: u32,
    /// The command.
    pub command: Command,
}
