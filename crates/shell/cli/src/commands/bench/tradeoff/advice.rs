//! What the figures advise, in words.

use crate::commands::bench::tradeoff::arena::RADIUS;
use crate::commands::bench::tradeoff::row::Row;

/// A setting that saves less than this share of the cost gains nothing that one could rely on: figures vary so much from run to
/// run.
const GAIN_MIN: f64 = 0.05;

/// Being off by less than this on average, in world units, is not to be seen: a hundredth of the radius.
const DEVIATION_SEEN: f64 = RADIUS / 100.0;

/// Missing less than this share of the stops is seldom seen.
const MISSED_SEEN: f64 = 0.01;

/// The setting with which the others are compared.
const EXACT: &str = "exact";

/// Returns what the rows of one scene advise, a sentence for each question.
pub(super) fn advice(rows: &[Row]) -> Vec<String> {
    let find = |label: &str| rows.iter().find(|row| row.setting == label);
    let Some(exact) = find(EXACT) else { return Vec::new() };
    let mut sentences = Vec::new();
    if let (Some(single), Some(bare)) = (find("f32"), find("uncertified")) {
        sentences.push(format!(
            "exact costs {:.2} times f32 and {:.2} times exact without the certificate here",
            ratio(exact, single),
            ratio(exact, bare)
        ));
        sentences.push(of_single(exact, single));
        sentences.push(of_certificate(exact, bare));
    }
    sentences.extend(of_steps(exact, rows));
    if let (Some(half), Some(quarter)) = (find("rate 1/2"), find("rate 1/4")) {
        sentences.push(format!(
            "half and a quarter of the cycles cost {:.2} and {:.2} times as much for the same world time, and commands wait \
             two and four times as long",
            ratio(half, exact),
            ratio(quarter, exact)
        ));
    }
    for grid in rows.iter().filter(|row| row.positions != exact.positions) {
        sentences.push(format!(
            "a grid of {} sends {:.1} bytes a point instead of {:.1}, and a client sees everybody {:.0e} off on average",
            grid.positions, grid.bytes_per_point, exact.bytes_per_point, grid.deviation_mean
        ));
    }
    sentences
}

/// Returns what all scenes together advise.
pub(super) fn conclusions(rows: &[Row]) -> Vec<String> {
    let mut labels: Vec<&str> = Vec::new();
    for row in rows {
        if !labels.contains(&row.setting) {
            labels.push(row.setting);
        }
    }
    let of = |label: &str| -> Vec<&Row> { rows.iter().filter(|row| row.setting == label).collect() };
    let costs: Vec<String> = labels
        .iter()
        .filter(|label| **label != EXACT && of(label).iter().all(|row| row.positions == "exact"))
        .map(|label| {
            let (of_setting, exact) = (of(label), of(EXACT));
            let logarithms = of_setting.iter().zip(&exact).map(|(row, exact)| ratio(row, exact).ln());
            let cost = (logarithms.sum::<f64>() / of_setting.len() as f64).exp();
            let worst = of_setting.iter().map(|row| row.missed).fold(0.0, f64::max);
            format!("{label} {cost:.2} ({})", percent(worst))
        })
        .collect();
    let front: Vec<&str> =
        labels.iter().copied().filter(|label| of(label).iter().all(|row| row.pareto)).collect();
    let front = if front.is_empty() { "none".to_owned() } else { front.join(", ") };
    vec![
        format!(
            "all scenes: of the cost of exact (geometric mean), and the most that is missed of the stops: {}",
            costs.join(", ")
        ),
        format!("all scenes: on the front in each: {front}"),
    ]
}

fn of_single(exact: &Row, single: &Row) -> String {
    let figures = format!(
        "it is off by {:.0e} on average, {:.0e} at most, misses {} of the stops and stops {} of the objects that go free",
        single.deviation_mean,
        single.deviation_max,
        percent(single.missed),
        percent(single.spurious)
    );
    let is_gain = ratio(single, exact) < 1.0 - GAIN_MIN;
    let is_right = single.deviation_mean < DEVIATION_SEEN && single.missed < MISSED_SEEN;
    match (is_gain, is_right) {
        (true, true) => format!("f32 is worth it where that matters: {figures}"),
        (false, true) => {
            format!("f32 is not worth it at {:.2} times the cost: {figures}", ratio(single, exact))
        }
        (true | false, false) => format!("f32 fails: {figures}"),
    }
}

fn of_certificate(exact: &Row, bare: &Row) -> String {
    let cost = ratio(exact, bare) - 1.0;
    let price = if cost < GAIN_MIN / 5.0 { "next to nothing".to_owned() } else { percent(cost) };
    if bare.overlapping_share > 0.0 {
        format!(
            "the certificate costs {price}; without it {} of the objects overlap, {:.0e} deep at most",
            percent(bare.overlapping_share),
            bare.deepest
        )
    } else {
        format!("the certificate costs {price}; without it nobody overlapped in the judged cycles")
    }
}

/// Up to how many steps are cheaper than the exact solution, and what the first that are not would give.
fn of_steps(exact: &Row, rows: &[Row]) -> Vec<String> {
    let is_plain = |row: &&Row| {
        row.substeps.is_some()
            && row.scalar == exact.scalar
            && row.certify != exact.certify
            && row.rate == exact.rate
    };
    let mut sentences = Vec::new();
    for row in rows.iter().filter(is_plain) {
        let (cost, label) = (ratio(row, exact), row.setting);
        let errors = format!(
            "misses {} of the stops, {} overlap",
            percent(row.missed),
            percent(row.overlapping_share)
        );
        if cost >= 1.0 - GAIN_MIN {
            sentences.push(format!(
                "stepped {label} is not worth it: {cost:.2} times the cost of exact, {errors}"
            ));
            return sentences;
        }
        sentences.push(format!("stepped {label} costs {cost:.2} times exact, {errors}"));
    }
    sentences
}

fn ratio(row: &Row, other: &Row) -> f64 {
    row.ns_per_object_cycle / other.ns_per_object_cycle
}

fn percent(share: f64) -> String {
    let percent = 100.0 * share;
    if percent == 0.0 {
        "none".to_owned()
    } else if percent < 0.1 {
        "below 0.1 %".to_owned()
    } else {
        format!("{percent:.1} %")
    }
}
