//! What a scenario says of the trade between accuracy and speed.

use std::ops::Range;

use maniple_view::{GRID_BITS_MAX, Positions, Profile, SKIN_MAX, SUBSTEPS_MAX, Solver};
use toml::Spanned;

use super::check::{Found, number};
use super::{Problem, file};

/// A number that only means something with one of the choices of another key.
struct Companion {
    field: &'static str,
    choice: &'static str,
    min: u32,
    max: u32,
}

const SUBSTEPS: Companion =
    Companion { field: "substeps", choice: "solver = \"stepped\"", min: 1, max: SUBSTEPS_MAX };

const GRID_BITS: Companion =
    Companion { field: "grid_bits", choice: "positions = \"grid\"", min: 0, max: GRID_BITS_MAX as u32 };

pub(super) fn profile(kinematics: &file::Kinematics, view: &file::View) -> Found<Profile> {
    let skin = kinematics.skin.as_ref();
    Ok(Profile {
        scalar: kinematics.scalar,
        solver: solver(kinematics)?,
        certify: kinematics.certify.unwrap_or(Profile::EXACT.certify),
        skin: skin.map(|skin| number(skin, "skin", 0.0, SKIN_MAX)).transpose()?,
        positions: positions(view)?,
    })
}

fn solver(kinematics: &file::Kinematics) -> Found<Solver> {
    let (choice, span) = chosen(kinematics.solver.as_ref(), file::Solver::Event);
    let substeps = kinematics.substeps.as_ref();
    match choice {
        file::Solver::Event => SUBSTEPS.without(substeps).map(|()| Solver::Event),
        file::Solver::Stepped => SUBSTEPS.with(substeps, span).map(|substeps| Solver::Stepped { substeps }),
    }
}

fn positions(view: &file::View) -> Found<Positions> {
    let (choice, span) = chosen(view.positions.as_ref(), file::Positions::Exact);
    let bits = view.grid_bits.as_ref();
    match choice {
        file::Positions::Exact => GRID_BITS.without(bits).map(|()| Positions::Exact),
        file::Positions::Grid => {
            let bits = GRID_BITS.with(bits, span)?;
            Ok(Positions::Grid { bits: u8::try_from(bits).expect("GRID_BITS_MAX is a u8") })
        }
    }
}

/// Returns what is chosen, and where.
fn chosen<T: Copy>(written: Option<&Spanned<T>>, default: T) -> (T, Range<usize>) {
    written.map_or((default, 0..0), |written| (*written.get_ref(), written.span()))
}

impl Companion {
    /// Returns the number, which has to be there; `place` is where the choice was made.
    fn with(&self, written: Option<&Spanned<u32>>, place: Range<usize>) -> Found<u32> {
        let Self { field, choice, min, max } = *self;
        let written = written.ok_or((place, Problem::Incomplete { choice, field, min, max }))?;
        let value = *written.get_ref();
        if (min..=max).contains(&value) {
            return Ok(value);
        }
        let (value, min, max) = (f64::from(value), f64::from(min), f64::from(max));
        Err((written.span(), Problem::OutOfRange { field, value, min, max }))
    }

    /// Checks that the number is not there.
    fn without(&self, written: Option<&Spanned<u32>>) -> Found<()> {
        let Self { field, choice, .. } = *self;
        written.map_or(Ok(()), |written| Err((written.span(), Problem::Pointless { field, choice })))
    }
}
