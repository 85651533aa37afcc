//! `maniple simulate`: the core's results, and what is wrong with a scene.

use std::collections::BTreeSet;

use maniple_geometry::limits::SPEED_MIN;
use maniple_geometry::{Limits, ObjectId};
use maniple_kinematics::{Event, EventKind, World};
use serde_json::{Value, json};

use crate::commands::{fails, file, folder, json as simulated};
use crate::kinematics::{Random, Scene};

#[test]
fn a_scene_is_simulated_as_the_core_does() {
    let folder = folder("simulate");
    let seed = 5;
    println!("seed {seed}");
    let mut kinds = BTreeSet::new();
    for number in 0..150 {
        let mut scene = Scene::random(&mut Random(seed + number));
        scene.single_orders();
        let path = file(&folder, "scene.json", &scene.to_json());
        let cycles = scene.cycles.to_string();
        let threads = (1 + number % 3).to_string();
        let found = simulated(&["simulate", &path, "--cycles", &cycles, "--threads", &threads, "--json"]);
        scene.limits = declared_limits(&scene);
        let (world, events, _) = scene.play();
        kinds.extend(events.iter().map(|event| event.kind));
        // As text, in which each number has its own digits.
        assert_eq!(found.to_string(), outcome(&world, &events).to_string(), "scene {number}");
    }
    let all =
        [EventKind::Arrived, EventKind::Ordered, EventKind::Object, EventKind::Segment, EventKind::Edge];
    assert_eq!(kinds, BTreeSet::from(all), "a kind of event was not compared");
}

/// What `maniple simulate` prints of a world and all that has happened in it.
fn outcome(world: &World, events: &[Event]) -> Value {
    let event = |event: &Event| {
        let kind = match event.kind {
            EventKind::Arrived => "arrived",
            EventKind::Ordered => "ordered",
            EventKind::Object => "object",
            EventKind::Segment => "segment",
            EventKind::Edge => "edge",
        };
        let Event { cycle, time, object, other, .. } = event;
        let other = other.map(|other| other.0);
        json!({"cycle": cycle.0, "time": time, "id": object.0, "kind": kind, "other": other})
    };
    let object = |id: ObjectId| {
        let center = world.circle(id).expect("the object is there").center;
        let is_moving = world.motion(id).expect("the object is there").is_moving();
        json!({"id": id.0, "x": center.x, "y": center.y, "moving": is_moving})
    };
    json!({
        "cycles": world.cycle().0,
        "objects": world.ids().into_iter().map(object).collect::<Vec<_>>(),
        "events": events.iter().map(event).collect::<Vec<_>>(),
        "hash": format!("{:016x}", world.digest()),
    })
}

/// The limits that follow from what the file of a scene declares.
fn declared_limits(scene: &Scene) -> Limits {
    let ends = scene.walls[..4].iter().flat_map(|wall| [wall.segment.start, wall.segment.end]);
    let reach = ends.map(|end| end.x.abs().max(end.y.abs())).fold(0.0, f64::max);
    let speeds = scene.orders.iter().flat_map(|order| order.legs.first()).map(|leg| leg.1);
    Limits::new(reach, 1024.0, speeds.fold(SPEED_MIN, f64::max)).expect("these are limits")
}

#[test]
fn the_skin_of_a_small_scene_is_small() {
    let folder = folder("small_scene");
    let scene = r#"{"bounds":[0,0,20,20],"objects":[{"id":1,"x":2.25,"y":5,"r":0.5},{"id":2,"x":10,"y":5,"r":0.5}],
        "moves":[{"cycle":0,"id":1,"x":10,"y":5,"s":1}]}"#;
    let found = simulated(&["simulate", &file(&folder, "scene.json", scene), "--json"]);
    let gap = 9.0 - found["objects"][0]["x"].as_f64().expect("a number");
    assert!(0.0 < gap && gap < 1e-11, "{gap:e}");
}

#[test]
fn a_scene_that_does_not_come_to_rest_is_bad_input_that_names_the_way_out() {
    let folder = folder("no_rest");
    let check = |order: &str| {
        let objects = r#"[{"id":1,"x":2,"y":5,"r":0.5}]"#;
        let scene = format!(r#"{{"bounds":[0,0,20,20],"objects":{objects},"moves":[{order}]}}"#);
        let scene = file(&folder, "scene.json", &scene);
        let error = fails(&["simulate", &scene], 3);
        for named in ["scene.json", "1048576 cycles", "--cycles"] {
            assert!(error.contains(named), "{error} does not name {named}");
        }
        assert_eq!(simulated(&["simulate", &scene, "--cycles", "7", "--json"])["cycles"], 7);
    };
    check(r#"{"cycle":0,"id":1,"x":5,"y":5,"s":1e-11}"#);
    check(r#"{"cycle":4294967295,"id":1,"x":5,"y":5,"s":1}"#);
    check(r#"{"cycle":0,"id":1,"x":5,"y":5,"s":1,"start":[4294967295,0.5]}"#);
}

#[test]
fn without_cycles_a_scene_runs_until_all_rest() {
    let folder = folder("until_rest");
    let scene = r#"{"bounds":[0,0,20,20],"objects":[{"id":4,"x":2,"y":5,"r":0.5}],
        "moves":[{"cycle":0,"id":4,"x":5,"y":5,"s":1},{"cycle":9,"id":4,"x":5,"y":6.5,"s":1,"start":[12,0.25]}]}"#;
    let found = simulated(&["simulate", &file(&folder, "scene.json", scene), "--json"]);
    assert_eq!(found["cycles"], 14);
    assert_eq!(found["objects"][0]["moving"], false);
    assert_eq!(
        found["events"][1],
        serde_json::json!(
        {"cycle": 13, "time": 0.75, "id": 4, "kind": "arrived", "other": null})
    );
}

#[test]
fn a_wrong_scene_is_bad_input_that_names_object_and_field() {
    let folder = folder("bad_scene");
    let check = |objects: &str, moves: &str, named: &[&str]| {
        let scene = format!(r#"{{"bounds":[0,0,20,20],"objects":[{objects}],"moves":[{moves}]}}"#);
        let error = fails(&["simulate", &file(&folder, "scene.json", &scene)], 3);
        assert!(named.iter().all(|name| error.contains(name)), "{error} does not name {named:?}");
    };
    let one = r#"{"id":1,"x":2,"y":5,"r":0.5}"#;
    check(&format!(r#"{one},{{"id":2,"x":2.9,"y":5,"r":0.5}}"#), "", &["object 2", "overlaps object 1"]);
    check(&format!(r#"{one},{{"id":1,"x":9,"y":5,"r":0.5}}"#), "", &["object 1", "id"]);
    check(r#"{"id":3,"x":0.4,"y":5,"r":0.5}"#, "", &["object 3", "overlaps a wall"]);
    check(r#"{"id":3,"x":5,"y":25,"r":0.5}"#, "", &["object 3", "y is 25", "bounds"]);
    check(r#"{"id":3,"x":5,"y":5,"r":0}"#, "", &["object 3", "r is 0", "positive"]);
    check(r#"{"id":3,"x":5,"y":-0.0,"r":1}"#, "", &["object 3", "y is -0"]);
    check(r#"{"id":3,"x":1e999,"y":5,"r":1}"#, "", &["objects[0].x", "out of range", "object 3"]);
    check(one, r#"{"cycle":2,"id":1,"x":1e999,"y":1,"s":1}"#, &["moves[0].x", "out of range", "object 1"]);
    check(r#"{"id":3,"x":5,"y":5,"r":1,"mass":2}"#, "", &["objects[0].mass", "object 3"]);
    check(r#"{"id":-3,"x":5,"y":5,"r":1}"#, "", &["objects[0].id"]);
    check(one, r#"{"cycle":2,"id":7,"x":1,"y":1,"s":1}"#, &["cycle 2", "id 7"]);
    check(one, r#"{"cycle":2,"id":1,"x":1,"y":1,"s":-1}"#, &["object 1", "cycle 2", "s is -1"]);
    check(
        one,
        r#"{"cycle":2,"id":1,"x":1,"y":1,"s":0,"queue":true}"#,
        &["object 1", "cycle 2", "s is 0", "queue"],
    );
    check(
        one,
        r#"{"cycle":2,"id":1,"x":1,"y":1,"s":1e7}"#,
        &["object 1", "cycle 2", "s is 10000000", "1048576"],
    );
    check(
        one,
        r#"{"cycle":2,"id":1,"x":1,"y":21,"s":1}"#,
        &["object 1", "cycle 2", "y is 21", "20", "bounds"],
    );
    check(one, r#"{"cycle":2,"id":1,"x":1,"y":1,"s":1,"start":[1,0]}"#, &["object 1", "start"]);
    check(one, r#"{"cycle":2,"id":1,"x":1,"y":1,"s":1,"start":[3,1.5]}"#, &["object 1", "start", "1.5"]);
    let error = fails(&["simulate", &file(&folder, "scene.json", r#"{"bounds":[0,0,0,1],"objects":[]}"#)], 3);
    assert!(error.contains("bounds"), "{error}");
}
