//! Why there is no ground, or no path.

use glam::DVec2;
use maniple_geometry::NumberError;
use thiserror::Error;

use crate::obstacles::Obstacle;

/// Why a map cannot be seen by a circle.
#[derive(Clone, Copy, Debug, Error, PartialEq)]
pub enum GroundError {
    /// The radius is no radius.
    #[error("the radius {0}")]
    Radius(NumberError),
    /// The margin is no length.
    #[error("the margin {0} must be a length from 0 to 1 world units")]
    Margin(f64),
}

/// Why something cannot stand on a ground: a circle's middle, or a rectangle, is not on the map, or its size is none.
#[derive(Clone, Copy, Debug, Error, PartialEq)]
#[error(
    "{obstacle:?} cannot stand on a map of {width} x {height} tiles; give a circle with its middle on the map and a radius above 0 \
     and not above the map's longer side, or a rectangle on the map whose max is right of and below its min"
)]
pub struct ObstacleError {
    /// The obstacle.
    pub obstacle: Obstacle,
    /// The width of the map, in tiles.
    pub width: u32,
    /// The height of the map, in tiles.
    pub height: u32,
}

/// An end of a path.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Which {
    /// Where it begins.
    Start,
    /// Where it ends.
    Goal,
}

impl std::fmt::Display for Which {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        formatter.write_str(match self {
            Self::Start => "start",
            Self::Goal => "goal",
        })
    }
}

/// Why there is no path.
#[derive(Clone, Copy, Debug, Error, PartialEq)]
pub enum PlanError {
    /// An end is not on the map.
    #[error(
        "the {which} ({}, {}) is not on the map of {width} x {height} tiles; choose a point within",
        point.x, point.y
    )]
    Outside {
        /// The end.
        which: Which,
        /// Where it is.
        point: DVec2,
        /// The width of the map, in tiles.
        width: u32,
        /// The height of the map, in tiles.
        height: u32,
    },
    /// The circle has no room in an end.
    #[error(
        "the {which} ({}, {}) is blocked, or nearer to a wall than {room} world units; choose a point with more room",
        point.x, point.y
    )]
    Blocked {
        /// The end.
        which: Which,
        /// Where it is.
        point: DVec2,
        /// How far from every wall the end has to be, in world units.
        room: f64,
    },
    /// From an end no point of the lattice can be seen, so that it is cut off from everywhere but what it sees.
    #[error("the {which} ({}, {}) is in a nook too narrow to be left for sure; choose a point with more room", point.x, point.y)]
    Enclosed {
        /// The end.
        which: Which,
        /// Where it is.
        point: DVec2,
    },
    /// Both ends have room, but no way between them has.
    #[error(
        "no way from start to goal has room for a radius of {radius}; choose a goal in the region of the start"
    )]
    Unreachable {
        /// The radius, in world units.
        radius: f64,
    },
}
