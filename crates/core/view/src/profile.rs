//! What a match trades accuracy with, for speed or for bytes.

use glam::DVec2;
use serde::{Deserialize, Serialize};

use crate::base::Base;

/// Most looks a cycle of [`Solver::Stepped`]: beyond, exact times cost less than any look.
pub const SUBSTEPS_MAX: u32 = 1000;

/// Thickest skin that may be asked for, in world units: a tile. Units that keep farther apart cannot pass a gap.
pub const SKIN_MAX: f64 = 1.0;

/// Most binary digits behind the point of a position on a grid: a coordinate then has at most 50 bits, which doubles hold.
pub const GRID_BITS_MAX: u8 = 20;

/// Binary digits that a velocity on a grid has more than a position: rounding moves an object by a 360th of the grid a
/// cycle, so that a hundred cycles need no second word.
pub const VELOCITY_BITS: u8 = 8;

/// Parts of a cycle in which the moment of a stop is told on a grid.
pub const GRID_FRACTIONS: f64 = 256.0;

/// What a match trades accuracy with. The default is exact; whatever else is chosen is faster, or smaller on the wire.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Profile {
    /// The numbers that kinematics runs in.
    pub scalar: Scalar,
    /// How collisions are found.
    pub solver: Solver,
    /// Whether each cycle ends with the proof that nobody overlaps.
    pub certify: bool,
    /// Distance above touching at which a colliding circle stops, in world units; `None`: what follows from the limits.
    pub skin: Option<f64>,
    /// What clients are told of positions.
    pub positions: Positions,
}

impl Profile {
    /// The profile under which every promise holds.
    pub const EXACT: Self = Self {
        scalar: Scalar::F64,
        solver: Solver::Event,
        certify: true,
        skin: None,
        positions: Positions::Exact,
    };
}

impl Default for Profile {
    fn default() -> Self {
        Self::EXACT
    }
}

/// The numbers that kinematics runs in.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Scalar {
    /// Doubles.
    #[default]
    F64,
    /// Single precision: half the memory, and a skin 2^29 times as thick.
    F32,
}

/// How collisions are found.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Solver {
    /// At their exact time, one after the other.
    #[default]
    Event,
    /// By looking so many times a cycle who overlaps by then.
    Stepped {
        /// How often, 1 to [`SUBSTEPS_MAX`].
        substeps: u32,
    },
}

/// What clients are told of positions.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Positions {
    /// The doubles of the world.
    #[default]
    Exact,
    /// The nearest multiples of 2^-bits world units; velocities have [`VELOCITY_BITS`] digits more.
    Grid {
        /// Binary digits behind the point, 0 to [`GRID_BITS_MAX`].
        bits: u8,
    },
}

impl Positions {
    /// Returns the distance of neighbouring positions, in world units; 0 where they are exact.
    #[must_use]
    pub fn step(self) -> f64 {
        match self {
            Self::Exact => 0.0,
            Self::Grid { bits } => step(bits),
        }
    }

    /// Returns the distance of neighbouring velocities, in world units a cycle; 0 where they are exact.
    #[must_use]
    pub fn velocity_step(self) -> f64 {
        match self {
            Self::Exact => 0.0,
            Self::Grid { bits } => step(bits.saturating_add(VELOCITY_BITS)),
        }
    }

    /// Returns what is told of a base: on a grid point and velocity are rounded to the nearest multiple, and the
    /// fraction down.
    #[must_use]
    pub fn rounded(self, base: Base) -> Base {
        let Self::Grid { .. } = self else { return base };
        Base {
            point: nearest(base.point, self.step()),
            cycle: base.cycle,
            fraction: (base.fraction * GRID_FRACTIONS).floor() / GRID_FRACTIONS,
            velocity: nearest(base.velocity, self.velocity_step()),
        }
    }
}

/// Returns 2^-bits; exact, and 0 far beyond [`GRID_BITS_MAX`].
fn step(bits: u8) -> f64 {
    (0..bits).fold(1.0, |step, _| step * 0.5)
}

/// Returns the nearest point whose coordinates are multiples of `step`, a power of two: `floor(x / step + 1/2) step`, of
/// which only the sum rounds, and only where a coordinate has more bits than a double. Never -0.
fn nearest(point: DVec2, step: f64) -> DVec2 {
    let on_grid = |x: f64| (x / step + 0.5).floor() * step;
    DVec2::new(on_grid(point.x), on_grid(point.y)) + DVec2::ZERO
}

#[cfg(test)]
mod tests {
    use maniple_geometry::Cycle;

    use super::*;

    #[test]
    fn a_base_on_a_grid_is_the_nearest_and_stays_where_it_is() {
        let check = |bits: u8, (x, y): (f64, f64), expected: (f64, f64)| {
            let base = Base {
                point: DVec2::new(x, y),
                cycle: Cycle(3),
                fraction: 0.999,
                velocity: DVec2::new(x / 1000.0, 0.0),
            };
            let grid = Positions::Grid { bits };
            let told = grid.rounded(base);
            assert_eq!(told.point, DVec2::from(expected));
            assert!(told.point.x != 0.0 || told.point.x.is_sign_positive());
            assert_eq!(told.fraction, 255.0 / 256.0);
            assert!((told.velocity.x - base.velocity.x).abs() <= grid.velocity_step() / 2.0);
            assert_eq!(grid.rounded(told), told);
            assert_eq!(Positions::Exact.rounded(base), base);
        };
        check(0, (1.4, 2.5), (1.0, 3.0));
        check(2, (1.4, 2.5), (1.5, 2.5));
        check(20, (0.0, 1e9), (0.0, 1e9));
        check(20, (-0.3, 4095.3), (-314_573.0 / 1_048_576.0, 4_294_233_293.0 / 1_048_576.0));
        check(4, (-0.01, 0.0), (0.0, 0.0));
        assert!(step(255) > 0.0);
    }
}
