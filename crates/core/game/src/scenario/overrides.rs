//! What is asked for instead of what a scenario says.

use maniple_view::{GRID_BITS_MAX, Positions, Profile, SKIN_MAX, SUBSTEPS_MAX, Scalar, Solver};

use super::{Problem, RATE_MAX, RATE_MIN};

/// What is asked for instead of what a scenario says; `None` leaves it to the scenario.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Overrides {
    /// The path of another map, as the files know it.
    pub map: Option<String>,
    /// Another seed.
    pub seed: Option<u64>,
    /// Other cycles a second.
    pub rate: Option<f64>,
    /// Other numbers for kinematics.
    pub scalar: Option<Scalar>,
    /// Another solver.
    pub solver: Option<Solver>,
    /// With or without certificate.
    pub certify: Option<bool>,
    /// Another skin, in world units.
    pub skin: Option<f64>,
    /// Other positions for clients.
    pub positions: Option<Positions>,
}

impl Overrides {
    /// Returns these with all that a profile says. Of its skin only that there is one: there is no way back to the skin
    /// that follows from the limits, for a scenario that says another.
    #[must_use]
    pub fn with_profile(self, profile: &Profile) -> Self {
        let Profile { scalar, solver, certify, skin, positions } = *profile;
        Self {
            scalar: Some(scalar),
            solver: Some(solver),
            certify: Some(certify),
            skin: skin.or(self.skin),
            positions: Some(positions),
            ..self
        }
    }

    /// Checks the numbers, which may come from a replay that somebody made.
    ///
    /// # Errors
    /// A number out of range.
    pub fn check(&self) -> Result<(), Problem> {
        let range = |field, value: f64, min: f64, max: f64| {
            if min <= value && value <= max && (value != 0.0 || value.is_sign_positive()) {
                Ok(())
            } else {
                Err(Problem::OutOfRange { field, value, min, max })
            }
        };
        if let Some(rate) = self.rate {
            range("rate", rate, RATE_MIN, RATE_MAX)?;
        }
        if let Some(Solver::Stepped { substeps }) = self.solver {
            range("substeps", f64::from(substeps), 1.0, f64::from(SUBSTEPS_MAX))?;
        }
        if let Some(skin) = self.skin {
            range("skin", skin, 0.0, SKIN_MAX)?;
        }
        if let Some(Positions::Grid { bits }) = self.positions {
            range("grid_bits", f64::from(bits), 0.0, f64::from(GRID_BITS_MAX))?;
        }
        Ok(())
    }

    /// Returns a profile with what is asked for instead.
    pub(super) fn applied(&self, profile: Profile) -> Profile {
        Profile {
            scalar: self.scalar.unwrap_or(profile.scalar),
            solver: self.solver.unwrap_or(profile.solver),
            certify: self.certify.unwrap_or(profile.certify),
            skin: self.skin.or(profile.skin),
            positions: self.positions.unwrap_or(profile.positions),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_no_scenario_may_say_no_override_may() {
        let check = |overrides: Overrides, expected: &str| {
            let text = overrides.check().unwrap_err().to_string();
            assert_eq!(text, expected);
        };
        let none = Overrides::default;
        assert_eq!(none().check(), Ok(()));
        check(Overrides { rate: Some(0.0), ..none() }, "rate is 0; it must be from 0.0009765625 to 1000");
        check(
            Overrides { rate: Some(f64::NAN), ..none() },
            "rate is NaN; it must be from 0.0009765625 to 1000",
        );
        check(Overrides { skin: Some(-1.0), ..none() }, "skin is -1; it must be from 0 to 1");
        check(Overrides { skin: Some(-0.0), ..none() }, "skin is -0; it must be from 0 to 1");
        let solver = Some(Solver::Stepped { substeps: 0 });
        check(Overrides { solver, ..none() }, "substeps is 0; it must be from 1 to 1000");
        let positions = Some(Positions::Grid { bits: 21 });
        check(Overrides { positions, ..none() }, "grid_bits is 21; it must be from 0 to 20");
    }
}
