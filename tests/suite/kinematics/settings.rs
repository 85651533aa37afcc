//! What a world gives up, and what it keeps, under other settings than the exact ones.

use maniple_kinematics::{Event, EventKind, Method, Settings, Stops, World};

use super::Scene;
use super::march::{Field, March};

const SIDE: f64 = 40.0;
const SEED: u64 = 11;

/// Overlaps after each of some cycles, events in all, and the hash.
fn marched(settings: Settings) -> (usize, usize, u64) {
    let field = Field::boxed(SIDE, 12, SEED);
    let places = field.places(600, SEED, |_| true);
    let mut march = March::under(settings, &field, &places, SEED);
    let (mut overlaps, mut events) = (0, 0);
    for _ in 0..60 {
        march.order();
        events += march.step();
        overlaps += march.world.overlaps().len();
    }
    (overlaps, events, march.world.digest())
}

fn stepped(substeps: u32) -> Settings {
    Settings { method: Method::Stepped { substeps }, certify: false, ..Settings::exact(Stops::Both) }
}

/// Lets one circle run at a speed towards another at rest, and past it if it may.
fn run_into_another(settings: Settings, speed: f64) -> (World, Vec<Event>) {
    let scene = Scene::boxed(30.0, settings.stops).object(1, (2.0, 5.0), 0.5).object(2, (10.0, 5.0), 0.5).go(
        0,
        1,
        (18.0, 5.0),
        speed,
    );
    let mut world = scene.world_under(settings);
    scene.give(&mut world);
    let events = world.step().to_vec();
    (world, events)
}

#[test]
fn steps_let_the_fast_pass_through_and_the_slow_back_off() {
    for (speed, is_stopped) in [(12.0, false), (8.0, true)] {
        let (world, events) = run_into_another(stepped(2), speed);
        let stops = events.iter().filter(|event| event.kind == EventKind::Object).count();
        assert_eq!(stops == 1, is_stopped, "at a speed of {speed}: {events:?}");
        assert!(world.overlaps().is_empty());
    }
    let (_, events) = run_into_another(Settings::exact(Stops::Both), 12.0);
    assert_eq!(events[0].kind, EventKind::Object);
}

#[test]
fn whoever_backs_off_is_where_it_was_the_time_before() {
    let (world, events) = run_into_another(stepped(4), 8.0);
    assert_eq!((events[0].time, events[0].rests), (0.75, true));
    assert_eq!(world.circle(events[0].object).unwrap().center, (8.0, 5.0).into());
}

#[test]
fn more_steps_overlap_less_and_the_certificate_never() {
    println!("seed {SEED}");
    let few = marched(stepped(1));
    let many = marched(stepped(16));
    assert!(few.0 > 2 * many.0 && many.0 > 0, "{few:?} {many:?}");
    let (overlaps, events, _) = marched(Settings { certify: true, ..stepped(1) });
    assert!(overlaps == 0 && events > 1000, "{overlaps} overlaps, {events} events");
}

#[test]
fn without_the_certificate_a_march_is_the_same_but_for_last_bits() {
    let exact = marched(Settings::exact(Stops::Both));
    let uncertified = marched(Settings { certify: false, ..Settings::exact(Stops::Both) });
    assert_eq!(exact.0, 0);
    assert_eq!(exact.1, uncertified.1);
}

#[test]
fn any_skin_keeps_everybody_apart_where_it_is_certified() {
    for skin in [0.0, 1e-15, 1e-3, 0.05] {
        let (overlaps, events, _) = marched(Settings { skin: Some(skin), ..Settings::exact(Stops::Both) });
        assert!(overlaps == 0 && events > 1000, "skin {skin}: {overlaps} overlaps, {events} events");
    }
}

#[test]
fn every_setting_gives_the_same_bits_twice() {
    for settings in [stepped(1), stepped(3), Settings { certify: true, ..stepped(2) }] {
        assert_eq!(marched(settings), marched(settings), "{settings:?}");
    }
}
