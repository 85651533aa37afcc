//! The keys of a scenario as they are written.

use std::collections::BTreeMap;

use maniple_view::{Falloff, Identity, Layer, Scalar, Stops, TerrainKnowledge};
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

/// What spectators may watch.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Views {
    /// What a seat sees.
    Seats,
    /// What a seat sees, and everything.
    All,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct File {
    pub(super) name: Spanned<String>,
    pub(super) map: Option<Spanned<String>>,
    pub(super) generate: Option<Spanned<Generate>>,
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
    pub(super) combat: Option<Combat>,
    pub(super) harvest: Option<Spanned<Harvest>>,
    pub(super) production: Option<Production>,
    pub(super) modes: Option<Modes>,
    pub(super) neutral: Option<Neutral>,
    pub(super) spectators: Option<Spectators>,
    pub(super) objective: Spanned<Objective>,
    #[serde(default)]
    pub(super) units: Vec<Spanned<String>>,
    #[serde(default)]
    pub(super) unit: BTreeMap<String, Spanned<Unit>>,
    pub(super) seat: Spanned<Vec<Seat>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Generate {
    pub(super) kind: Spanned<String>,
    pub(super) width: Spanned<u32>,
    pub(super) height: Spanned<u32>,
    pub(super) spawns: Option<Spanned<u32>>,
    pub(super) clusters: Option<Spanned<u32>>,
    pub(super) patches: Option<Spanned<u32>>,
    pub(super) amount: Option<Spanned<u32>>,
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
    pub(super) terrain: TerrainKnowledge,
    #[serde(default)]
    pub(super) walls_block: bool,
    #[serde(default)]
    pub(super) identity: Identity,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Combat {
    #[serde(default)]
    pub(super) friendly_fire: bool,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Harvest {
    pub(super) patch: Spanned<String>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Production {}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Modes {}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Neutral {
    pub(super) groups: Spanned<Vec<Group>>,
    pub(super) wander: Option<Spanned<f64>>,
    pub(super) pause_seconds: Option<Spanned<f64>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Spectators {
    pub(super) views: Views,
    pub(super) delay_seconds: Option<Spanned<f64>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Objective {
    pub(super) kind: Kind,
    pub(super) zone_size: Option<Spanned<f64>>,
    pub(super) goal: Option<Spanned<u32>>,
    pub(super) team: Option<Spanned<u16>>,
}

#[derive(Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(super) enum Kind {
    Race,
    Resources,
    Kills,
    Buildings,
    LastStanding,
    Survive,
}

/// A file of unit types.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct UnitFile {
    #[serde(default)]
    pub(super) unit: BTreeMap<String, Spanned<Unit>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Unit {
    pub(super) radius: Option<Spanned<f64>>,
    pub(super) width: Option<Spanned<f64>>,
    pub(super) height: Option<Spanned<f64>>,
    pub(super) speed: Spanned<f64>,
    pub(super) sight: Option<Spanned<f64>>,
    #[serde(default)]
    pub(super) layer: Layer,
    pub(super) hit_points: Option<Spanned<u32>>,
    pub(super) armor: Option<Spanned<u32>>,
    pub(super) weapon: Option<Weapon>,
    pub(super) alternate: Option<Alternate>,
    pub(super) harvest: Option<Carrier>,
    pub(super) patch: Option<Patch>,
    #[serde(default)]
    pub(super) takes_loads: bool,
    pub(super) cost: Option<Spanned<u32>>,
    pub(super) make_seconds: Option<Spanned<f64>>,
    #[serde(default)]
    pub(super) requires: Vec<Spanned<String>>,
    #[serde(default)]
    pub(super) trains: Vec<Spanned<String>>,
    #[serde(default)]
    pub(super) builds: Vec<Spanned<String>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Weapon {
    pub(super) range: Spanned<f64>,
    pub(super) range_min: Option<Spanned<f64>>,
    pub(super) cooldown_seconds: Spanned<f64>,
    pub(super) damage_min: Spanned<u32>,
    pub(super) damage_max: Spanned<u32>,
    pub(super) splash_radius: Option<Spanned<f64>>,
    pub(super) splash_falloff: Option<Spanned<Falloff>>,
    pub(super) targets: Option<Spanned<Vec<Layer>>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Alternate {
    pub(super) name: Spanned<String>,
    pub(super) switch_seconds: Spanned<f64>,
    pub(super) speed: Spanned<f64>,
    pub(super) armor: Option<Spanned<u32>>,
    pub(super) weapon: Option<Weapon>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Carrier {
    pub(super) load_max: Spanned<u32>,
    pub(super) seconds_each: Spanned<f64>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Patch {
    pub(super) places: Spanned<u32>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Seat {
    pub(super) bot: Option<Spanned<String>>,
    pub(super) team: Option<Spanned<u16>>,
    pub(super) stock: Option<Spanned<u32>>,
    pub(super) groups: Spanned<Vec<Group>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Group {
    pub(super) unit: Spanned<String>,
    pub(super) count: Spanned<u32>,
}
