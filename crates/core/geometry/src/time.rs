//! Simulated time: whole cycles, and fractions within one.

use serde::{Deserialize, Serialize};

/// The number of a cycle, counted from 0; also the state at its start.
#[doc(alias = "tick")]
#[doc(alias = "frame")]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(transparent)]
pub struct Cycle(pub u32);

impl Cycle {
    /// Returns the cycle after this one.
    ///
    /// # Panics
    /// After cycle 4,294,967,295, which is 17 years at 8 cycles a second.
    #[must_use]
    pub fn next(self) -> Self {
        Self(self.0.checked_add(1).expect("a match is shorter than 2^32 cycles"))
    }

    /// Returns the cycles from `earlier` to this one; negative where `earlier` is later.
    #[must_use]
    pub fn since(self, earlier: Self) -> f64 {
        f64::from(self.0) - f64::from(earlier.0)
    }
}

impl std::fmt::Display for Cycle {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        self.0.fmt(f)
    }
}

/// A point in simulated time: `fraction` of the way from the start of `cycle` to its end.
#[derive(Clone, Copy, Debug, PartialEq, PartialOrd, Serialize, Deserialize)]
pub struct Moment {
    /// The cycle.
    pub cycle: Cycle,
    /// The part of the cycle that has passed, `0.0..=1.0`.
    pub fraction: f64,
}

impl Moment {
    /// Returns the start of a cycle.
    #[must_use]
    pub fn start_of(cycle: Cycle) -> Self {
        Self { cycle, fraction: 0.0 }
    }

    /// Returns the cycles from this moment to the start of `cycle`: `(k - k0) - f0`, evaluated in this order,
    /// which is part of the protocol: a client has to get the same bits.
    #[must_use]
    pub fn until(self, cycle: Cycle) -> f64 {
        cycle.since(self.cycle) - self.fraction
    }
}
