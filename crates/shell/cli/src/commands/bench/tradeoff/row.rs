//! A row of the comparison, and which rows are on the Pareto front.

use serde::Serialize;

use crate::commands::bench::tradeoff::measure::{Assessed, Timed};
use crate::commands::bench::tradeoff::setting::{Precision, Setting};
use crate::csv::line;

/// What a setting costs in a scene, and how far it is from the truth; shares are from 0 to 1, lengths in world units.
#[derive(Clone, Debug, Serialize)]
pub(super) struct Row {
    pub(super) scene: String,
    pub(super) scalar: Precision,
    /// `event` or `stepped`.
    pub(super) solver: &'static str,
    /// `None` for the events.
    pub(super) substeps: Option<u32>,
    pub(super) certify: bool,
    pub(super) skin: f64,
    /// Cycles for each base cycle.
    pub(super) rate: f64,
    pub(super) positions: String,
    pub(super) ns_per_object_cycle: f64,
    pub(super) missed: f64,
    pub(super) tunnelled: f64,
    pub(super) deepest: f64,
    pub(super) overlapping_share: f64,
    pub(super) deviation_mean: f64,
    pub(super) deviation_max: f64,
    pub(super) bytes_per_cycle: f64,
    pub(super) pareto: bool,
    pub(super) setting: &'static str,
    /// The mean deviation, or 0 where it is rounding: below the smallest skin of the scene, which is that of the exact setting.
    pub(super) error: f64,
    pub(super) bytes_per_point: f64,
    /// Stops that should not have been, as a share of all objects.
    pub(super) spurious: f64,
    pub(super) run_deviation: f64,
    pub(super) timed_objects: u32,
    pub(super) timed_cycles: u32,
    pub(super) judged_objects: u32,
    pub(super) judged_cycles: u32,
    /// Stops that should have been, in the judged cycles.
    pub(super) judged_stops: u64,
}

impl Row {
    pub(super) fn new(scene: &str, setting: &Setting, timed: &Timed, assessed: &Assessed) -> Self {
        let Assessed { judged, objects, skin, run_deviation } = *assessed;
        let of_objects = |count: u64| share(count, judged.objects);
        Self {
            scene: scene.to_owned(),
            scalar: setting.precision,
            solver: if setting.substeps().is_some() { "stepped" } else { "event" },
            substeps: setting.substeps(),
            certify: setting.certify,
            skin,
            rate: 1.0 / f64::from(setting.stretch),
            positions: setting.positions.text(),
            ns_per_object_cycle: 1e9 * timed.cycle.as_secs_f64() / f64::from(timed.objects),
            missed: share(judged.missed, judged.stops),
            tunnelled: of_objects(judged.tunnelled),
            deepest: judged.deepest,
            overlapping_share: of_objects(judged.overlapping),
            deviation_mean: judged.deviation_sum / judged.objects as f64,
            deviation_max: judged.deviation_max,
            bytes_per_cycle: timed.bytes,
            pareto: false,
            setting: setting.label,
            error: judged.deviation_sum / judged.objects as f64,
            bytes_per_point: timed.bytes_per_point,
            spurious: of_objects(judged.spurious),
            run_deviation,
            timed_objects: timed.objects,
            timed_cycles: timed.cycles,
            judged_objects: objects,
            judged_cycles: judged.cycles,
            judged_stops: judged.stops,
        }
    }

    /// Returns the names and texts of the fields, in the order of the columns.
    pub(super) fn fields(&self) -> [(&'static str, String); 27] {
        let number = |value: f64| format!("{value:?}");
        [
            ("scene", self.scene.clone()),
            ("scalar", self.scalar.text().to_owned()),
            ("solver", self.solver.to_owned()),
            ("substeps", self.substeps.map(|substeps| substeps.to_string()).unwrap_or_default()),
            ("certify", self.certify.to_string()),
            ("skin", number(self.skin)),
            ("rate", number(self.rate)),
            ("positions", self.positions.clone()),
            ("ns_per_object_cycle", number(self.ns_per_object_cycle)),
            ("missed", number(self.missed)),
            ("tunnelled", number(self.tunnelled)),
            ("deepest", number(self.deepest)),
            ("overlapping_share", number(self.overlapping_share)),
            ("deviation_mean", number(self.deviation_mean)),
            ("deviation_max", number(self.deviation_max)),
            ("bytes_per_cycle", number(self.bytes_per_cycle)),
            ("pareto", self.pareto.to_string()),
            ("setting", self.setting.to_owned()),
            ("error", number(self.error)),
            ("bytes_per_point", number(self.bytes_per_point)),
            ("spurious", number(self.spurious)),
            ("run_deviation", number(self.run_deviation)),
            ("timed_objects", self.timed_objects.to_string()),
            ("timed_cycles", self.timed_cycles.to_string()),
            ("judged_objects", self.judged_objects.to_string()),
            ("judged_cycles", self.judged_cycles.to_string()),
            ("judged_stops", self.judged_stops.to_string()),
        ]
    }

    /// Returns whether another row costs and errs no more, nor makes commands wait longer, and is better in something.
    fn is_beaten_by(&self, other: &Self) -> bool {
        let of = |row: &Self| [row.ns_per_object_cycle, row.bytes_per_point, row.error, -row.rate];
        let (own, others) = (of(self), of(other));
        others.iter().zip(&own).all(|(other, own)| other <= own) && others != own
    }
}

/// Takes rounding out of the errors of the rows of one scene, and marks those that no other beats.
pub(super) fn mark_pareto(rows: &mut [Row]) {
    let skins = rows.iter().map(|row| row.skin).filter(|&skin| skin > 0.0);
    let rounding = skins.fold(f64::INFINITY, f64::min);
    for row in &mut *rows {
        row.error = if row.deviation_mean <= rounding { 0.0 } else { row.deviation_mean };
    }
    for place in 0..rows.len() {
        rows[place].pareto = !rows.iter().any(|other| rows[place].is_beaten_by(other));
    }
}

/// Returns the rows as CSV.
pub(super) fn csv(rows: &[Row]) -> String {
    let mut text = String::new();
    if let Some(row) = rows.first() {
        text += &line(row.fields().map(|(name, _)| name));
    }
    for row in rows {
        text += &line(row.fields().map(|(_, value)| value));
    }
    text
}

fn share(part: u64, whole: u64) -> f64 {
    if whole == 0 { 0.0 } else { part as f64 / whole as f64 }
}
