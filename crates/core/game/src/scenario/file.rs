//! The keys of a scenario as they are written.

use std::collections::BTreeMap;

use maniple_view::{Scalar, Stops};
use serde::Deserialize;
use toml::Spanned;

/// What happens in lock-step to a seat whose time bank is empty.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Stall {
    /// The cycle goes on without waiting for it.
    #[default]
    Skip,
    /// It loses: like a resignation.
    Forfeit,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct File {
    pub(super) name: Spanned<String>,
    pub(super) map: Spanned<String>,
    pub(super) rate: Option<Spanned<f64>>,
    pub(super) length_seconds: Spanned<f64>,
    #[serde(default)]
    pub(super) seed: u64,
    #[serde(default)]
    pub(super) kinematics: Kinematics,
    #[serde(default)]
    pub(super) clock: Clock,
    #[serde(default)]
    pub(super) view: View,
    pub(super) vision: Option<Vision>,
    pub(super) objective: Objective,
    #[serde(default)]
    pub(super) unit: BTreeMap<String, Spanned<Unit>>,
    pub(super) seat: Spanned<Vec<Seat>>,
}

#[derive(Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Kinematics {
    #[serde(default)]
    pub(super) stops: Stops,
    #[serde(default)]
    pub(super) scalar: Scalar,
    pub(super) solver: Option<Spanned<Solver>>,
    pub(super) substeps: Option<Spanned<u32>>,
    pub(super) certify: Option<bool>,
    pub(super) skin: Option<Spanned<f64>>,
}

#[derive(Clone, Copy, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(super) enum Solver {
    Event,
    Stepped,
}

#[derive(Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct View {
    pub(super) positions: Option<Spanned<Positions>>,
    pub(super) grid_bits: Option<Spanned<u32>>,
}

#[derive(Clone, Copy, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(super) enum Positions {
    Exact,
    Grid,
}

#[derive(Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Clock {
    pub(super) time_bank_seconds: Option<Spanned<f64>>,
    #[serde(default)]
    pub(super) stall: Stall,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Vision {
    #[serde(default)]
    pub(super) terrain: Terrain,
}

#[derive(Default, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(super) enum Terrain {
    #[default]
    Known,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Objective {
    pub(super) kind: Kind,
    pub(super) zone_size: Option<Spanned<f64>>,
}

#[derive(Deserialize)]
#[serde(rename_all = "snake_case")]
pub(super) enum Kind {
    Race,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Unit {
    pub(super) radius: Spanned<f64>,
    pub(super) speed: Spanned<f64>,
    pub(super) sight: Option<Spanned<f64>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Seat {
    pub(super) bot: Option<Spanned<String>>,
    pub(super) groups: Spanned<Vec<Group>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Group {
    pub(super) unit: Spanned<String>,
    pub(super) count: Spanned<u32>,
}
