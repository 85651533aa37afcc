//! Golden vectors of packed motions, and a reader of them in another language.

use std::path::{Path, PathBuf};
use std::process::Command;

use glam::DVec2;
use maniple_geometry::Cycle;
use maniple_protocol::Packer;
use maniple_view::{
    Appeared, Base, Delta, Handle, Moved, Positions, Status, StopReason, Stopped, UnitTypeId,
};
use serde_json::{Value, json};

use crate::commands::ROOT;
use crate::matches::{Game, open, tiny};

#[test]
fn packed_motions_have_their_golden_bytes() {
    let mut cases = Vec::new();
    for bits in [None, Some(8), Some(0)] {
        for (name, delta) in deltas(bits) {
            cases.push(case(name, bits, &delta));
        }
    }
    let found = serde_json::to_string_pretty(&cases).unwrap() + "\n";
    let path = golden();
    if std::env::var("UPDATE_GOLDEN").is_ok_and(|value| value == "1") {
        std::fs::write(&path, &found).unwrap();
    }
    let expected = std::fs::read_to_string(&path).unwrap_or_default();
    assert!(
        found == expected,
        "packed.json differs; if that is meant, PROTOCOL rises: run with UPDATE_GOLDEN=1"
    );
}

#[test]
fn the_reader_of_the_document_reads_the_golden_vectors() {
    let reader = Path::new(ROOT).join("docs/packed.py");
    let Ok(run) = Command::new("python3").arg(reader).arg(golden()).output() else {
        println!("SKIPPED: there is no python3; docs/packed.py was not run");
        return;
    };
    let text = String::from_utf8_lossy(&run.stdout);
    assert!(
        run.status.success() && text.ends_with(" cases agree\n"),
        "{}{text}",
        String::from_utf8_lossy(&run.stderr)
    );
}

/// The unit types of the vectors: speeds in world units a cycle, of both modes.
const SPEEDS: [(f64, Option<f64>); 2] = [(0.35, None), (0.2, Some(0.45))];

fn known(bits: Option<u8>) -> Vec<(u32, u16, Base)> {
    let moving = |cycle, fraction, velocity: (f64, f64)| Base {
        point: DVec2::new(20.3, 7.9),
        cycle: Cycle(cycle),
        fraction,
        velocity: DVec2::from(velocity),
    };
    let all = [
        (0, 0, moving(290, 0.0, (0.21, -0.28))),
        (3, 1, moving(299, 0.7, (-0.12, 0.16))),
        (200, 1, moving(40, 0.0, (0.0, 0.0))),
    ];
    all.map(|(object, unit_type, base)| (object, unit_type, positions(bits).rounded(base))).to_vec()
}

/// Returns deltas of cycle 301, each with motions of another kind.
fn deltas(bits: Option<u8>) -> Vec<(&'static str, Delta)> {
    let before = known(bits);
    let at = |number: usize, cycle, fraction: f64, velocity: (f64, f64)| {
        let base = before[number].2;
        let point = base.position(Cycle(cycle)) + base.velocity * fraction;
        let base = Base { point, cycle: Cycle(cycle), fraction, velocity: DVec2::from(velocity) };
        positions(bits).rounded(base)
    };
    let elsewhere = |base: Base| Base { point: base.point + DVec2::new(-35.0, 1.0), ..base };
    let halt = |number, cycle, fraction| at(number, cycle, fraction, (0.0, 0.0));
    let at_last = [moved(0, at(0, 300, 0.0, (0.28, 0.21))), moved(200, at(2, 301, 0.0, (0.0, -0.2)))];
    let within = [moved(0, at(0, 300, 0.3, (-0.28, 0.21))), moved(3, at(1, 300, 0.9, (0.27, 0.36)))];
    let long_ago = [moved(0, at(0, 295, 0.5, (0.1, 0.02))), moved(3, at(1, 301, 0.0, (-0.1, -0.4)))];
    let jump = [moved(3, elsewhere(at(1, 300, 0.0, (0.0, 0.2))))];
    let bumped = Some(StopReason::Object { other: Some(Handle(300)) });
    let stops = [
        stopped(0, halt(0, 300, 0.25), Some(StopReason::Arrived)),
        stopped(3, halt(1, 300, 0.0), None),
        stopped(200, elsewhere(halt(2, 301, 0.0)), bumped),
    ];
    let rest = positions(bits).rounded(Base { fraction: 0.3, ..halt(2, 2, 0.0) });
    let all = Delta {
        appeared: vec![appeared(201, 1, at(0, 301, 0.0, (0.45, 0.0))), appeared(202, 0, rest)],
        ..delta(
            &[moved(200, at(2, 300, 0.0, (-0.12, -0.16)))],
            &[stopped(0, halt(0, 300, 1.0), Some(StopReason::Segment))],
        )
    };
    vec![
        ("nothing", delta(&[], &[])),
        ("turns when a cycle begins", delta(&at_last, &[])),
        ("turns within a cycle", delta(&within, &[])),
        ("a speed of its own, and long ago", delta(&long_ago, &[])),
        ("elsewhere", delta(&jump, &[])),
        ("stops", delta(&[], &stops)),
        ("all at once", all),
    ]
}

fn delta(moved: &[Moved], stopped: &[Stopped]) -> Delta {
    Delta { cycle: Cycle(301), moved: moved.to_vec(), stopped: stopped.to_vec(), ..Delta::default() }
}

fn moved(object: u32, base: Base) -> Moved {
    Moved { object: Handle(object), base }
}

fn stopped(object: u32, base: Base, reason: Option<StopReason>) -> Stopped {
    let Base { point, cycle, fraction, .. } = base;
    Stopped { object: Handle(object), point, cycle, fraction, reason }
}

fn appeared(object: u32, unit_type: u16, base: Base) -> Appeared {
    Appeared {
        object: Handle(object),
        unit_type: UnitTypeId(unit_type),
        owner: None,
        base,
        status: Status::default(),
        own: None,
    }
}

fn case(name: &str, bits: Option<u8>, delta: &Delta) -> Value {
    let mut rules = Game::new(tiny("", &open()), &["idle", "idle"]).referee.rules();
    let scout = rules.unit_types[0].clone();
    rules.positions = positions(bits);
    rules.unit_types = SPEEDS
        .map(|(speed, other)| {
            let alternate = other.map(|speed| maniple_view::Alternate {
                name: "other".to_owned(),
                switch_cycles: 1,
                speed,
                armor: 0,
                weapon: None,
            });
            maniple_view::UnitType { speed, alternate, ..scout.clone() }
        })
        .to_vec();
    let mut packer = Packer::new(&rules);
    let before = known(bits);
    let seen = |&(object, unit_type, base): &(u32, u16, Base)| appeared(object, unit_type, base);
    packer.pack(&Delta {
        cycle: Cycle(300),
        appeared: before.iter().map(seen).collect(),
        ..Delta::default()
    });
    let packed = packer.pack(delta);
    let hex: String = packed.motions.iter().map(|byte| format!("{byte:02x}")).collect();
    let moved: serde_json::Map<String, Value> =
        delta.moved.iter().map(|moved| (moved.object.to_string(), told(&moved.base))).collect();
    let stopped: serde_json::Map<String, Value> = delta
        .stopped
        .iter()
        .map(|stopped| {
            let (reason, other) = number(stopped.reason);
            (stopped.object.to_string(), json!([told(&stopped.base()), reason, other]))
        })
        .collect();
    let known: serde_json::Map<String, Value> = before
        .iter()
        .map(|(object, unit_type, base)| (object.to_string(), json!([unit_type, told(base)])))
        .collect();
    json!({
        "name": name,
        "bits": bits,
        "cycle": delta.cycle,
        "speeds": SPEEDS,
        "known": known,
        "appeared": delta.appeared.iter().map(|new| new.unit_type).collect::<Vec<_>>(),
        "motions": hex,
        "expected": [delta.appeared.iter().map(|new| told(&new.base)).collect::<Vec<_>>(), moved, stopped],
    })
}

fn told(base: &Base) -> Value {
    json!([base.point.x, base.point.y, base.cycle, base.fraction, base.velocity.x, base.velocity.y])
}

fn number(reason: Option<StopReason>) -> (u8, Option<Handle>) {
    match reason {
        None => (0, None),
        Some(StopReason::Arrived) => (1, None),
        Some(StopReason::Ordered) => (2, None),
        Some(StopReason::Segment) => (3, None),
        Some(StopReason::Edge) => (4, None),
        Some(StopReason::Object { other: None }) => (5, None),
        Some(StopReason::Object { other }) => (6, other),
    }
}

fn positions(bits: Option<u8>) -> Positions {
    bits.map_or(Positions::Exact, |bits| Positions::Grid { bits })
}

fn golden() -> PathBuf {
    Path::new(ROOT).join("tests/golden/packed.json")
}
