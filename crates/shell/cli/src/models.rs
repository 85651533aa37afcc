//! What a match models, and what it does not.

use maniple_game::Loaded;
use maniple_game::scenario::Objective;
use maniple_view::{Positions, Profile, Scalar, Solver, TerrainKnowledge};

use crate::output::grouped;

/// Returns what a match models, in a line.
pub(crate) fn line(loaded: &Loaded) -> String {
    let parts = [
        vision(loaded),
        radii(loaded),
        layers(loaded),
        segments(loaded),
        format!("rules: {}", rules(loaded)),
        format!("kinematics: {}", kinematics(&loaded.scenario.profile)),
        positions(&loaded.scenario.profile),
    ];
    format!("models: {}", parts.join("; "))
}

/// Returns whether there is fog.
pub(crate) fn vision(loaded: &Loaded) -> String {
    match loaded.scenario.vision {
        None => "no fog (perfect information)".to_owned(),
        Some(vision) => {
            let terrain = match vision.terrain {
                TerrainKnowledge::Known => "terrain known",
                TerrainKnowledge::Explored => "terrain explored",
            };
            let walls = if vision.walls_block { ", walls block sight" } else { "" };
            format!("fog (circles of sight, {terrain}{walls})")
        }
    }
}

/// Returns how many different radii the units of the match have.
pub(crate) fn radii(loaded: &Loaded) -> String {
    let types = &loaded.scenario.unit_types;
    let mut radii: Vec<u64> = loaded
        .setup
        .units
        .iter()
        .map(|unit| types[usize::from(unit.unit_type.0)].shape.rounding().to_bits())
        .collect();
    radii.sort_unstable();
    radii.dedup();
    counted(radii.len(), "radius", "radii")
}

/// Returns in which layers units are.
pub(crate) fn layers(loaded: &Loaded) -> String {
    let mut layers: Vec<_> = loaded.scenario.unit_types.iter().map(|unit_type| unit_type.layer).collect();
    layers.sort_unstable();
    layers.dedup();
    counted(layers.len(), "layer", "layers")
}

/// Returns how many segments there are.
pub(crate) fn segments(loaded: &Loaded) -> String {
    counted(loaded.map.segments().len(), "segment", "segments")
}

/// Returns which rules run, the objective last.
pub(crate) fn rules(loaded: &Loaded) -> String {
    let scenario = &loaded.scenario;
    let modules = [
        ("combat", scenario.combat.is_some()),
        ("harvest", scenario.harvest.is_some()),
        ("production", scenario.production),
        ("modes", scenario.modes),
        ("neutral", scenario.neutral.is_some()),
    ];
    let objective = match scenario.objective {
        Objective::Race { .. } => "race",
        Objective::Resources { .. } => "resources",
        Objective::Kills => "kills",
        Objective::Buildings => "buildings",
        Objective::LastStanding => "last standing",
        Objective::Survive { .. } => "survive",
    };
    let running = modules.into_iter().filter(|(_, runs)| *runs).map(|(name, _)| name);
    running.chain([objective]).collect::<Vec<&str>>().join(", ")
}

/// Returns how exactly objects move: `exact (event, f64, certified)` where every promise holds.
pub(crate) fn kinematics(profile: &Profile) -> String {
    let Profile { scalar, solver, certify, skin, positions } = *profile;
    let is_exact = Profile { positions, ..Profile::EXACT } == *profile;
    let solver = match solver {
        Solver::Event => "event".to_owned(),
        Solver::Stepped { substeps } => format!("stepped, {}", counted(substeps as usize, "look", "looks")),
    };
    let scalar = match scalar {
        Scalar::F64 => "f64",
        Scalar::F32 => "f32",
    };
    let certified = if certify { "certified" } else { "not certified" };
    let skin = skin.map(|skin| format!(", skin {skin}")).unwrap_or_default();
    let traded = if is_exact { "exact" } else { "traded" };
    format!("{traded} ({solver}, {scalar}, {certified}{skin})")
}

/// Returns what clients are told of positions.
pub(crate) fn positions(profile: &Profile) -> String {
    match profile.positions {
        Positions::Exact => "positions: exact".to_owned(),
        Positions::Grid { bits } => format!("positions: grid of 2^-{bits}"),
    }
}

fn counted(count: usize, one: &str, many: &str) -> String {
    format!("{} {}", grouped(count as u64), if count == 1 { one } else { many })
}
