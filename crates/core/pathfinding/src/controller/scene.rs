//! What a controller is told, and what it says.

use glam::DVec2;
use maniple_geometry::Circle;

/// How near to a goal a unit has arrived, in world units: what rounding on the wire may take.
pub(crate) const THERE: f64 = 1.0 / 1024.0;

/// Cycles after an order in which a unit need not show that it obeys: an order applies a cycle after it was given, its effect
/// is seen a cycle later, and a slow line takes as much again.
pub(crate) const GRACE: u32 = 4;

/// Cycles between an order and the start that it names: so much later an order may apply than it was given.
pub(crate) const LEAD: u32 = 3;

/// Most legs that are ordered at once.
pub(crate) const LEGS_MAX: usize = 64;

/// What becomes of orders on their way. Only [`crate::Tactic::Auto`] asks.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Delivery {
    /// They arrive in time: units rely on it that others do what they were told.
    #[default]
    Sure,
    /// Some get lost. Orders of a schedule are given again, before the departure, so many times, a cycle later each, and schedules begin
    /// so much later; in step nobody is sent to where it has not been seen that the way gets free.
    Lossy {
        /// How many times.
        repeats: u32,
    },
}

impl Delivery {
    /// How often orders of schedules are given again.
    pub(crate) fn repeats(self) -> u32 {
        match self {
            Self::Sure => 0,
            Self::Lossy { repeats } => repeats,
        }
    }
}

/// A unit as it is seen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Seen {
    /// Its centre, in world units.
    pub position: DVec2,
    /// Whether it moves.
    pub is_moving: bool,
}

/// What is seen at the start of a cycle.
#[derive(Clone, Copy, Debug)]
pub struct Scene<'a> {
    /// The cycle.
    pub cycle: u32,
    /// The units that are led, always in the same order.
    pub units: &'a [Seen],
    /// All other circles that rest.
    pub others: &'a [Circle],
}

/// What a unit is to do, in the place of all that it was told before.
#[derive(Clone, Debug, PartialEq)]
pub struct Order {
    /// Its place among the units.
    pub unit: usize,
    /// The goals of its legs, one after the other; none: it is to stop.
    pub legs: Vec<DVec2>,
    /// When it departs, in cycles since cycle 0; `None`: at once.
    pub start: Option<f64>,
}

impl Order {
    pub(crate) fn stop(unit: usize) -> Self {
        Self { unit, legs: Vec::new(), start: None }
    }
}

/// Whether a point is at a goal.
pub(crate) fn is_there(point: DVec2, goal: DVec2) -> bool {
    point.distance_squared(goal) <= THERE * THERE
}
