//! What a player may say.

use maniple_geometry::Cycle;
use serde::{Deserialize, Serialize};

use crate::identity::Handle;

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
