//! How a world is simulated: what a user may trade for speed.

use crate::solve::Stops;

/// How a world is simulated. All but the default trade accuracy for speed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Who stops in a collision of two objects.
    pub stops: Stops,
    /// How collisions are found.
    pub method: Method,
    /// Whether each cycle ends with the proof that nobody overlaps, and with whoever does being pulled back. Without it,
    /// rounding alone can make circles overlap by the last bits.
    pub certify: bool,
    /// How far above touching a colliding circle stops, in world units, instead of the skin that follows from the limits.
    pub skin: Option<f64>,
}

impl Settings {
    /// Returns the settings under which all promises hold.
    #[must_use]
    pub fn exact(stops: Stops) -> Self {
        Self { stops, method: Method::Event, certify: true, skin: None }
    }
}

impl From<Stops> for Settings {
    fn from(stops: Stops) -> Self {
        Self::exact(stops)
    }
}

/// How collisions are found.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Method {
    /// At their exact time, one after the other.
    #[default]
    Event,
    /// By looking, so many times a cycle, who overlaps by then and has come nearer; whoever does goes back to where it was
    /// the time before and stops. Whoever is fast passes through.
    Stepped {
        /// How often, at least once.
        substeps: u32,
    },
}
