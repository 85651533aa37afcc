//! Why a map could not be generated.

use thiserror::Error;

use super::Request;

/// Why a map could not be generated: what, the limit and the remedy.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
pub enum GenerateError {
    /// No kind has this name.
    #[error("{name:?} is no kind of map; the kinds are {known}")]
    Kind {
        /// The name.
        name: String,
        /// The names of all kinds.
        known: String,
    },
    /// A whole number that is out of its range.
    #[error("{what} is {found}; it must be a whole number from {least} to {most}")]
    Number {
        /// Which number.
        what: &'static str,
        /// The number.
        found: u32,
        /// The least that is allowed.
        least: u32,
        /// The largest that is allowed.
        most: u32,
    },
    /// A radius that no way can be made for.
    #[error("radius is {found}; it must be above 0 and at most {most} tiles")]
    Radius {
        /// The radius.
        found: String,
        /// The largest that is allowed.
        most: String,
    },
    /// What is asked for does not fit, wherever it was tried.
    #[error("{width} x {height} tiles have no room for {what}; make the map larger, or ask for {fewer}")]
    NoRoom {
        /// The width in tiles.
        width: u32,
        /// The height in tiles.
        height: u32,
        /// What does not fit.
        what: String,
        /// What to ask for instead.
        fewer: &'static str,
    },
    /// Spawns or patches cannot be reached from each other, whatever was tried.
    #[error(
        "no way {lane} tiles wide could be made to everything on {width} x {height} tiles; make the map larger, or ask for fewer clusters or a smaller radius"
    )]
    NoWay {
        /// How wide a way has to be, in tiles.
        lane: u32,
        /// The width in tiles.
        width: u32,
        /// The height in tiles.
        height: u32,
    },
}

impl GenerateError {
    pub(super) fn no_room_for_spawns(request: &Request) -> Self {
        let Request { width, height, players, spawns, .. } = *request;
        let side = request.clearing();
        let what = format!("{players} x {spawns} spawns with {side} x {side} open tiles around each");
        Self::NoRoom { width, height, what, fewer: "fewer players or spawns" }
    }

    pub(super) fn no_room_for_clusters(request: &Request) -> Self {
        let Request { width, height, clusters, patches, .. } = *request;
        let what = format!("{clusters} clusters of {patches} patches beside the spawns");
        Self::NoRoom { width, height, what, fewer: "fewer clusters or patches" }
    }

    pub(super) fn no_way(request: &Request) -> Self {
        Self::NoWay { lane: request.lane(), width: request.width, height: request.height }
    }
}
