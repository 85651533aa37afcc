//! What the world refuses.

use std::fmt;

use maniple_geometry::{Cycle, NumberError, ObjectId};
use thiserror::Error;

use crate::wall::WallId;

/// A wall that cannot be built.
#[derive(Clone, Copy, Debug, Error, PartialEq)]
pub enum WallError {
    /// A coordinate that no world accepts.
    #[error("segment {index}: {field} {problem}")]
    BadNumber {
        /// The place of the wall in the list.
        index: usize,
        /// The coordinate: `x1`, `y1`, `x2` or `y2`.
        field: &'static str,
        /// What is wrong with it.
        problem: NumberError,
    },
    /// A segment that starts where it ends.
    #[error("segment {index} starts where it ends, in ({x}, {y}); leave it out")]
    NoLength {
        /// The place of the wall in the list.
        index: usize,
        /// The point, to the right.
        x: f64,
        /// The point, downwards.
        y: f64,
    },
    /// It would lie in an object.
    #[error("the segment would lie in object {other}; move one of them away")]
    OverlapsObject {
        /// The object with the smallest id of those that it would lie in.
        other: ObjectId,
    },
}

/// An object that cannot be put into the world.
#[derive(Clone, Copy, Debug, Error, PartialEq)]
pub enum InsertError {
    /// A number that the world does not accept.
    #[error("{field} {problem}")]
    BadNumber {
        /// The field: `x`, `y` or `r`.
        field: &'static str,
        /// What is wrong with it.
        problem: NumberError,
    },
    /// There is no object with this id to be put somewhere else.
    #[error("there is no such object")]
    UnknownObject,
    /// The id is taken.
    #[error("there is an object with this id already; give each its own")]
    DuplicateId,
    /// It would overlap an object.
    #[error("overlaps object {other}; move one of them away")]
    OverlapsObject {
        /// The object with the smallest id of those that it would overlap.
        other: ObjectId,
    },
    /// It would overlap a wall.
    #[error("overlaps a wall from ({}, {}) to ({}, {}); move it away", .segment.0, .segment.1, .segment.2, .segment.3)]
    OverlapsWall {
        /// The wall, as (x1, y1, x2, y2).
        segment: (f64, f64, f64, f64),
    },
}

/// An order that the world refuses; nothing changed.
#[derive(Clone, Copy, Debug, Error, PartialEq)]
pub enum OrderError {
    /// There is no object with this id.
    #[error("there is no such object")]
    UnknownObject,
    /// A number that the world does not accept.
    #[error("{field} {problem}")]
    BadNumber {
        /// The field: `x`, `y`, `s` or `start`.
        field: &'static str,
        /// What is wrong with it.
        problem: NumberError,
    },
    /// The start has gone by.
    #[error("start lies before cycle {now}, which comes next")]
    StartInPast {
        /// The cycle that comes next.
        now: Cycle,
    },
    /// More legs than an object may have waiting.
    #[error("more than {max} waypoints")]
    TooManyWaypoints {
        /// The largest number.
        max: usize,
    },
    /// An order without a leg.
    #[error("a path needs at least one waypoint")]
    EmptyPath,
}

/// A breach of the promise that nothing overlaps, found by [`crate::World::overlaps`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Overlap {
    /// Two objects.
    Objects(ObjectId, ObjectId),
    /// An object and a wall.
    Wall(ObjectId, WallId),
}

impl fmt::Display for Overlap {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Objects(one, other) => write!(f, "objects {one} and {other} overlap"),
            Self::Wall(object, wall) => write!(f, "object {object} overlaps wall {}", wall.0),
        }
    }
}

/// A snapshot that is none of a world; see [`crate::World::restore`].
#[derive(Clone, Copy, Debug, Error, PartialEq)]
pub enum RestoreError {
    /// A number that the world does not accept.
    #[error("object {object}: {field} {problem}")]
    BadNumber {
        /// The object.
        object: ObjectId,
        /// The field: `x`, `y`, `r`, `fraction`, or `s`.
        field: &'static str,
        /// What is wrong with it.
        problem: NumberError,
    },
    /// A motion that begins later than the present, or is over already.
    #[error("object {object} is on a motion from cycle {from} on, which does not go on at cycle {now}")]
    BadMoment {
        /// The object.
        object: ObjectId,
        /// The cycle in which the motion begins.
        from: Cycle,
        /// The cycle of the snapshot.
        now: Cycle,
    },
    /// A leg that starts at its goal.
    #[error("object {object} is on a way to where it starts")]
    NoWay {
        /// The object.
        object: ObjectId,
    },
    /// More legs than an object may have waiting.
    #[error("object {object} has more than {max} waypoints")]
    TooManyWaypoints {
        /// The object.
        object: ObjectId,
        /// The largest number.
        max: usize,
    },
    /// A waiting leg that replaces others at no moment, or an order to stop that waits behind others.
    #[error("object {object} has a waiting leg that no order makes")]
    BadWaiting {
        /// The object.
        object: ObjectId,
    },
    /// An overlap, which no cycle leaves behind.
    #[error("{0}")]
    Overlap(Overlap),
}
