//! The core agrees with its slow twin, event by event and bit by bit.

use maniple_kinematics::{Event, EventKind};

use super::scene::{Random, Scene, listed};
use super::twin::Twin;

/// Scenes of the ordinary run; `MANIPLE_LONG=1` plays a hundred times as many.
const SCENES: u64 = 4000;

#[test]
fn random_scenes_agree_with_the_slow_twin() {
    check_all("random", SCENES, 100, Scene::random);
}

#[test]
fn columns_that_march_in_step_without_a_gap_agree_with_the_slow_twin() {
    let retreats = check_all("columns", SCENES / 40, 100, Scene::columns);
    assert!(retreats > 0, "rounding alone makes some of them overlap, so the certificate has work");
}

#[test]
fn circles_that_slide_along_a_slanted_wall_agree_with_the_slow_twin() {
    let retreats = check_all("sliding", SCENES / 20, 100, Scene::sliding);
    assert!(retreats > 0, "rounding alone makes some of them overlap the wall");
}

#[test]
fn a_packed_crowd_that_is_sent_to_one_point_agrees_with_the_slow_twin() {
    check_all("crowd", SCENES / 20, 100, Scene::crowd);
}

/// Plays scenes in the core and in the twin and returns how often the core pulled an object back.
pub(super) fn check_all(class: &str, scenes: u64, longer: u64, make: impl Fn(&mut Random) -> Scene) -> usize {
    let seed = 20_260_401;
    let scenes = if std::env::var_os("MANIPLE_LONG").is_some() { longer * scenes } else { scenes };
    println!("class {class}: seed {seed}, {scenes} scenes");
    let (mut retreats, mut events) = (0, std::collections::BTreeMap::new());
    for number in 0..scenes {
        let scene = make(&mut Random(seed + number));
        let played = agree(&scene, &format!("{class} {}", seed + number));
        for event in &played.1 {
            *events.entry(event.kind).or_insert(0) += 1;
        }
        retreats += played.0;
    }
    println!("class {class}: {events:?}, {retreats} retreats");
    let collisions = [EventKind::Object, EventKind::Segment].map(|kind| events.get(&kind).copied());
    assert!(collisions.into_iter().flatten().sum::<u64>() > scenes / 2, "there is something to agree on");
    retreats
}

fn agree(scene: &Scene, name: &str) -> (usize, Vec<Event>) {
    let (world, events, retreats) = scene.play();
    let mut twin = Twin::new(scene);
    let expected = twin.play();
    assert_eq!(listed(&events), listed(&expected), "events of scene {name}: {scene:#?}");
    for id in world.ids() {
        let (ours, theirs) = (world.circle(id).unwrap().center, twin.position(id.0));
        assert_eq!(ours.x.to_bits(), theirs.x.to_bits(), "x of {id} in scene {name}: {scene:#?}");
        assert_eq!(ours.y.to_bits(), theirs.y.to_bits(), "y of {id} in scene {name}: {scene:#?}");
    }
    (retreats, events)
}
