//! Formations, by themselves and led.

use glam::DVec2;
use maniple_tilemap::TileMap;

use super::drawn;
use super::release::block;
use super::trial::{Outcome, Trial};
use crate::{Formation, FormationError, Ground, Tactic};

/// Points of a circle by thirds, fourths and fifths, without trigonometry.
const FACINGS: [DVec2; 4] = [DVec2::X, DVec2::new(0.0, -1.0), DVec2::new(0.6, 0.8), DVec2::new(-0.8, 0.6)];

#[test]
fn slots_never_overlap() {
    for formation in Formation::ALL {
        for radius in [0.05, 0.35, 1.0, 4.0] {
            for count in (0..60).chain([99, 100, 101, 400]) {
                for facing in FACINGS {
                    let slots = formation.slots(DVec2::new(70.0, 50.0), facing, count, radius);
                    assert_eq!(slots.len(), count, "{formation:?} {count}");
                    let least = 2.0 * radius * 1.2;
                    for (index, one) in slots.iter().enumerate() {
                        let is_apart = |other: &DVec2| other.distance(*one) >= least;
                        assert!(slots[..index].iter().all(is_apart), "{formation:?} {count} {radius}");
                    }
                }
            }
        }
    }
}

#[test]
fn formations_are_their_own_image_in_the_line_of_their_facing() {
    let anchor = DVec2::new(10.0, 20.0);
    for formation in Formation::ALL {
        for count in 0..60 {
            for facing in FACINGS {
                let slots = formation.slots(anchor, facing, count, 0.35);
                for slot in &slots {
                    let away = *slot - anchor;
                    let image = anchor + 2.0 * facing * away.dot(facing) - away;
                    assert!(slots.iter().any(|other| other.distance(image) < 1e-9), "{formation:?} {count}");
                    assert!(away.dot(facing) < 1e-9, "nobody stands before the anchor");
                }
            }
        }
    }
}

#[test]
fn shapes_are_what_they_are_called() {
    let distance = Formation::distance(0.35);
    let places = |formation: Formation, count| -> Vec<(f64, f64)> {
        let slots = formation.slots(DVec2::ZERO, DVec2::X, count, 0.35);
        slots
            .iter()
            .map(|slot| ((slot.x / distance).round() + 0.0, (2.0 * slot.y / distance).round() + 0.0))
            .collect()
    };
    assert_eq!(places(Formation::Line, 3), [(0.0, -2.0), (0.0, 0.0), (0.0, 2.0)]);
    assert_eq!(places(Formation::Column, 3), [(0.0, 0.0), (-1.0, 0.0), (-2.0, 0.0)]);
    assert_eq!(places(Formation::Wedge, 4), [(0.0, 0.0), (-1.0, -2.0), (-1.0, 2.0), (-1.0, 0.0)]);
    assert_eq!(places(Formation::Box, 5), [(0.0, -2.0), (0.0, 0.0), (0.0, 2.0), (-1.0, -1.0), (-1.0, 1.0)]);
}

#[test]
fn slots_in_walls_are_moved_to_the_nearest_free_ones() {
    let map = drawn(&[
        "............",
        "............",
        "......@@....",
        "......@@....",
        "............",
        "............",
    ]);
    let ground = Ground::new(&map, 0.35).unwrap();
    for formation in Formation::ALL {
        for anchor in [DVec2::new(5.5, 2.5), DVec2::new(8.5, 3.5), DVec2::new(1.0, 1.0)] {
            let slots = formation.slots_on(&ground, anchor, DVec2::X, 12).unwrap();
            let wanted = formation.slots(anchor, DVec2::X, 12, 0.35);
            for (index, (slot, wanted)) in slots.iter().zip(&wanted).enumerate() {
                assert!(ground.holds(*slot));
                assert!(!ground.holds(*wanted) || slot == wanted, "{formation:?} {anchor}");
                assert!(slots[..index].iter().all(|other| other.distance(*slot) >= 0.7));
            }
        }
    }
    let blocked = DVec2::new(6.5, 2.5);
    let error = Formation::Box.slots_on(&ground, blocked, DVec2::X, 3).unwrap_err();
    assert_eq!(error, FormationError::Anchor { point: blocked });
    let error = Formation::Box.slots_on(&ground, DVec2::new(1.0, 1.0), DVec2::X, 200).unwrap_err();
    assert!(matches!(error, FormationError::NoRoom { count: 200, .. }), "{error}");
}

/// A room, a wall that is three tiles thick with a gap, and a long room behind it.
fn long_room(width: usize) -> TileMap {
    let side = 30 + width % 2;
    let row = |open: usize| {
        let wall = "@".repeat((side - open) / 2);
        format!("{wall}{}{wall}", ".".repeat(open))
    };
    let mut rows = vec!["@".repeat(side)];
    rows.extend(std::iter::repeat_n(row(side - 2), 16));
    rows.extend(std::iter::repeat_n(row(width), 3));
    rows.extend(std::iter::repeat_n(row(side - 2), 40));
    rows.push("@".repeat(side));
    drawn(&rows.iter().map(String::as_str).collect::<Vec<_>>())
}

#[test]
fn a_hundred_form_up_again_behind_a_gap() {
    for (width, formation) in
        [(1, Formation::Box), (2, Formation::Box), (3, Formation::Box), (3, Formation::Wedge)]
    {
        let map = long_room(width);
        let ground = Ground::new(&map, 0.35).unwrap();
        let middle = 0.5 * f64::from(map.width());
        let count = if formation == Formation::Wedge { 25 } else { 100 };
        let starts = block(if count == 25 { (5, 5) } else { (10, 10) }, DVec2::new(middle, 8.0));
        let to = DVec2::new(middle, 57.0);
        let mut stages = formation.march(&ground, DVec2::new(middle, 8.0), to, count).unwrap();
        assert_eq!(stages.len(), 2, "{width} {formation:?}");
        assert!(stages[0].iter().all(|slot| slot.y > 20.0), "{:?}", stages[0]);
        let goals = stages.pop().unwrap();
        let trial = Trial { stages, ..Trial::new(&map, Tactic::Auto, starts, goals) };
        let Outcome { arrived, collisions, orders, cycles, formed, .. } = trial.run(4000);
        println!(
            "gap {width}, {formation:?} of {count}: {formed:?} formed up, {arrived} arrived, {collisions} collisions, {orders} \
             orders, {cycles} cycles"
        );
        assert_eq!((arrived, collisions, formed), (count, 0, vec![count]), "{width} {formation:?}");
    }
}
