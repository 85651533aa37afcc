//! Deltas whose positions are on a grid, in whole numbers: fewer bytes than doubles.

use glam::DVec2;
use maniple_geometry::Cycle;
use maniple_view::{
    Appeared, Base, Changed, CommandResult, Delta, Digest, Ended, GRID_FRACTIONS, Handle, Moved, Own,
    Positions, Seat, Shot, Status, StopReason, Stopped, UnitTypeId,
};
use serde::{Deserialize, Serialize};
use thiserror::Error;

/// An object that came into sight: what [`Appeared`] says, in its order.
pub type GridAppeared = (Handle, UnitTypeId, Option<Seat>, Spot, Pace, Status, Option<Own>);

/// A delta in numbers of steps of the grid that the rules name.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct GridDelta {
    /// See [`Delta::cycle`].
    pub cycle: Cycle,
    /// See [`Delta::results`].
    pub results: Vec<CommandResult>,
    /// See [`Delta::sight`].
    pub sight: Vec<(u32, u32)>,
    /// See [`Delta::revealed`].
    pub revealed: Vec<(u32, u32, String)>,
    /// See [`Delta::walls`].
    pub walls: Vec<(f64, f64, f64, f64)>,
    /// Objects that came into sight.
    pub appeared: Vec<GridAppeared>,
    /// Objects whose motion changed: what [`Moved`] says.
    pub moved: Vec<(Handle, Spot, Pace)>,
    /// Objects that stopped: what [`Stopped`] says.
    pub stopped: Vec<(Handle, Spot, Option<StopReason>)>,
    /// See [`Delta::vanished`].
    pub vanished: Vec<Handle>,
    /// See [`Delta::died`].
    pub died: Vec<Handle>,
    /// See [`Delta::changed`].
    pub changed: Vec<Changed>,
    /// See [`Delta::shots`].
    pub shots: Vec<Shot>,
    /// See [`Delta::ended`].
    pub ended: Vec<Ended>,
    /// See [`Delta::stock`].
    pub stock: Option<u32>,
    /// See [`Delta::check`].
    pub check: Digest,
}

/// Where and when.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Spot {
    /// Steps of the grid.
    pub x: i64,
    /// Steps of the grid.
    pub y: i64,
    /// Cycles before that of the delta.
    pub ago: u32,
    /// 256ths of a cycle, behind the start of that cycle.
    pub fraction: u16,
}

/// How fast, in steps of the grid of velocities.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Pace {
    /// To the right.
    pub x: i64,
    /// Downwards.
    pub y: i64,
}

/// A grid delta that cannot be one.
#[derive(Clone, Copy, Debug, Error, PartialEq, Eq)]
pub enum GridError {
    /// The rules say that positions are exact.
    #[error("a grid_delta, but by the rules positions are exact; this server breaks the protocol")]
    NoGrid,
    /// A moment before the first cycle.
    #[error("the grid_delta of cycle {cycle} has a moment {ago} cycles ago; this server breaks the protocol")]
    BeforeStart {
        /// The cycle of the delta.
        cycle: Cycle,
        /// How many cycles ago.
        ago: u32,
    },
}

impl GridDelta {
    /// Returns a delta in steps of the grid; `None` where positions are exact, or where it has something between the
    /// steps, which no tracker of a grid makes.
    #[must_use]
    pub fn of(delta: &Delta, positions: Positions) -> Option<Self> {
        let grid = Grid::of(positions)?;
        let cycle = delta.cycle;
        let appeared = |new: &Appeared| {
            let (spot, pace) = (grid.spot(&new.base, cycle)?, grid.pace(&new.base)?);
            Some((new.object, new.unit_type, new.owner, spot, pace, new.status, new.own))
        };
        let moved =
            |moved: &Moved| Some((moved.object, grid.spot(&moved.base, cycle)?, grid.pace(&moved.base)?));
        let stopped =
            |stopped: &Stopped| Some((stopped.object, grid.spot(&stopped.base(), cycle)?, stopped.reason));
        Some(Self {
            cycle,
            results: delta.results.clone(),
            sight: delta.sight.clone(),
            revealed: delta.revealed.clone(),
            walls: delta.walls.clone(),
            appeared: delta.appeared.iter().map(appeared).collect::<Option<_>>()?,
            moved: delta.moved.iter().map(moved).collect::<Option<_>>()?,
            stopped: delta.stopped.iter().map(stopped).collect::<Option<_>>()?,
            vanished: delta.vanished.clone(),
            died: delta.died.clone(),
            changed: delta.changed.clone(),
            shots: delta.shots.clone(),
            ended: delta.ended.clone(),
            stock: delta.stock,
            check: delta.check,
        })
    }

    /// Returns the delta in doubles; the same bits that the server has.
    ///
    /// # Errors
    /// Rules without a grid, or a moment before the first cycle.
    pub fn delta(self, positions: Positions) -> Result<Delta, GridError> {
        let grid = Grid::of(positions).ok_or(GridError::NoGrid)?;
        let cycle = self.cycle;
        let base = |spot, pace| grid.base(spot, pace, cycle);
        let mut delta = Delta {
            cycle,
            results: self.results,
            sight: self.sight,
            revealed: self.revealed,
            walls: self.walls,
            vanished: self.vanished,
            died: self.died,
            changed: self.changed,
            shots: self.shots,
            ended: self.ended,
            stock: self.stock,
            check: self.check,
            ..Delta::default()
        };
        for (object, unit_type, owner, spot, pace, status, own) in self.appeared {
            let base = base(spot, pace)?;
            delta.appeared.push(Appeared { object, unit_type, owner, base, status, own });
        }
        for (object, spot, pace) in self.moved {
            delta.moved.push(Moved { object, base: base(spot, pace)? });
        }
        for (object, spot, reason) in self.stopped {
            let Base { point, cycle, fraction, .. } = base(spot, Pace { x: 0, y: 0 })?;
            delta.stopped.push(Stopped { object, point, cycle, fraction, reason });
        }
        Ok(delta)
    }
}

/// The steps of a grid, powers of two: to multiply and to divide by them is exact.
struct Grid {
    step: f64,
    velocity_step: f64,
}

impl Grid {
    fn of(positions: Positions) -> Option<Self> {
        match positions {
            Positions::Exact => None,
            Positions::Grid { .. } => {
                Some(Self { step: positions.step(), velocity_step: positions.velocity_step() })
            }
        }
    }

    fn spot(&self, base: &Base, cycle: Cycle) -> Option<Spot> {
        Some(Spot {
            x: whole(base.point.x / self.step)?,
            y: whole(base.point.y / self.step)?,
            ago: cycle.0.checked_sub(base.cycle.0)?,
            fraction: u16::try_from(whole(base.fraction * GRID_FRACTIONS)?).ok()?,
        })
    }

    fn pace(&self, base: &Base) -> Option<Pace> {
        Some(Pace {
            x: whole(base.velocity.x / self.velocity_step)?,
            y: whole(base.velocity.y / self.velocity_step)?,
        })
    }

    fn base(&self, spot: Spot, pace: Pace, cycle: Cycle) -> Result<Base, GridError> {
        let ago = spot.ago;
        let moment = cycle.0.checked_sub(ago).ok_or(GridError::BeforeStart { cycle, ago })?;
        Ok(Base {
            point: DVec2::new(double(spot.x), double(spot.y)) * self.step,
            cycle: Cycle(moment),
            fraction: f64::from(spot.fraction) / GRID_FRACTIONS,
            velocity: DVec2::new(double(pace.x), double(pace.y)) * self.velocity_step,
        })
    }
}

/// Returns a number that is whole, and so small that doubles have every one of its size.
#[expect(clippy::cast_possible_truncation, reason = "it is whole and below 2^53")]
fn whole(number: f64) -> Option<i64> {
    let is_exact = number.floor() == number && number.abs() < (1u64 << 53) as f64;
    is_exact.then_some(number as i64)
}

#[expect(clippy::cast_precision_loss, reason = "a server's numbers are below 2^53; of others any will do")]
fn double(number: i64) -> f64 {
    number as f64
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::arbitrary::Random;

    #[test]
    fn a_delta_on_a_grid_comes_back_to_the_same_bits() {
        for seed in 0..500 {
            let mut random = Random::new(seed);
            for bits in [0, 7, 20] {
                let positions = Positions::Grid { bits };
                let delta = rounded(random.delta(), positions);
                let grid = GridDelta::of(&delta, positions).expect("it is on the grid");
                let again = grid.delta(positions).unwrap();
                assert_eq!(format!("{again:?}"), format!("{delta:?}"), "seed {seed}, {bits} bits");
            }
        }
    }

    #[test]
    fn what_lies_between_the_steps_is_on_no_grid() {
        let positions = Positions::Grid { bits: 2 };
        let check = |x: f64, is_on_grid: bool| {
            let base =
                Base { point: DVec2::new(x, 0.0), cycle: Cycle(0), fraction: 0.0, velocity: DVec2::ZERO };
            let delta = Delta { moved: vec![Moved { object: Handle(0), base }], ..Delta::default() };
            assert_eq!(GridDelta::of(&delta, positions).is_some(), is_on_grid, "{x}");
            assert_eq!(GridDelta::of(&delta, Positions::Exact), None);
        };
        check(0.25, true);
        check(0.3, false);
        check(f64::NAN, false);
        check(1e300, false);
    }

    #[test]
    fn a_moment_before_the_start_and_a_grid_that_the_rules_do_not_have_are_errors() {
        let spot = Spot { x: 0, y: 0, ago: 6, fraction: 0 };
        let grid =
            GridDelta { cycle: Cycle(5), stopped: vec![(Handle(1), spot, None)], ..GridDelta::default() };
        let positions = Positions::Grid { bits: 255 };
        assert_eq!(grid.clone().delta(positions), Err(GridError::BeforeStart { cycle: Cycle(5), ago: 6 }));
        assert_eq!(grid.delta(Positions::Exact), Err(GridError::NoGrid));
    }

    /// Returns a delta that is on the grid, with small numbers and moments that have been.
    fn rounded(mut delta: Delta, positions: Positions) -> Delta {
        let small = |x: f64| if x.abs() < 1e6 { x } else { 1.5 };
        let point = |point: DVec2| DVec2::new(small(point.x), small(point.y));
        let cycle = delta.cycle;
        let base = |base: Base| {
            let fraction = if base.fraction > 0.0 && base.fraction <= 1.0 { base.fraction } else { 0.25 };
            positions.rounded(Base {
                point: point(base.point),
                velocity: point(base.velocity),
                fraction,
                cycle: Cycle(base.cycle.0.min(cycle.0)),
            })
        };
        for appeared in &mut delta.appeared {
            appeared.base = base(appeared.base);
        }
        for moved in &mut delta.moved {
            moved.base = base(moved.base);
        }
        for stopped in &mut delta.stopped {
            let Base { point, cycle, fraction, .. } = base(stopped.base());
            (stopped.point, stopped.cycle, stopped.fraction) = (point, cycle, fraction);
        }
        delta
    }
}
