//! What happened in a cycle.

use maniple_geometry::{Cycle, ObjectId};

/// Something that happened to an object in a cycle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Event {
    /// The cycle in which it happened.
    pub cycle: Cycle,
    /// The fraction of that cycle, `0.0..=1.0`.
    pub time: f64,
    /// The object.
    pub object: ObjectId,
    /// What happened.
    pub kind: EventKind,
    /// The smallest id of the objects that it collided with; `None` for every other kind.
    pub other: Option<ObjectId>,
    /// Whether it collided with other objects at the same time, too.
    pub is_one_of_several: bool,
    /// Whether the object rests after it: an arrival at a waypoint may go on at once.
    pub rests: bool,
}

/// Why an object stopped, or that it reached a waypoint.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum EventKind {
    /// It reached the goal of a leg.
    Arrived,
    /// It was told to stop.
    Ordered,
    /// It collided with an object, and perhaps with a wall at the same time.
    Object,
    /// It collided with a wall, and perhaps with the edge at the same time.
    Segment,
    /// It collided with the edge of the world.
    Edge,
}
