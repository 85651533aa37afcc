//! The core agrees with the oracle, which shares nothing with it, cycle by cycle.

use std::collections::BTreeMap;

use glam::DVec2;
use maniple_geometry::limits::{RADIUS_MIN, SPEED_MIN};
use maniple_geometry::{Circle, Limits, ObjectId};
use maniple_kinematics::{Event, EventKind, Layers, Stops, WallKind, World};
use maniple_oracle::{
    Actual, Ending, Exact, Goal, Object, Obstacle, Outcome, Solution, Vector, Verdict, Wall, judge, rounded,
    solve,
};

use super::scene::{Random, Scene};

/// Scenes of the ordinary run; `MANIPLE_LONG=1` plays fifty times as many.
const SCENES: u64 = 300;

/// How far a rounded place may be off where nothing collides, in skins: it is rounded twice, by `u (c + 2 v)`, a
/// sixteenth of the skin or less, and so is the state that the oracle starts from.
const ROUNDING: f64 = 0.125;

/// How far distances in the core may be off, in skins: those of two rounded places by `2 u (c + 2 v)`, and their time
/// relatively by `8 u`, which is `16 u v` in the distance; together `u (2 c + 20 v)`. The skin is `32 u (c + r + v)`.
const ERROR: f64 = 20.0 / 32.0;

#[test]
fn random_scenes_agree_with_the_oracle() {
    let seen = check_all("random", SCENES, Scene::random);
    assert!(seen.stops > 1000 && seen.walls > 100 && seen.arrivals > 100, "{seen:?}");
    assert!(seen.unsure * 4 < seen.cycles, "there is something to compare: {seen:?}");
}

#[test]
fn a_crowd_that_gathers_agrees_with_the_oracle() {
    let seen = check_all("gathering", SCENES / 60, |random| gathering(random, 200));
    assert!(seen.stops > 1000, "{seen:?}");
    assert!(seen.unsure * 4 < seen.cycles, "there is something to compare: {seen:?}");
}

#[test]
fn columns_that_march_in_step_without_a_gap_agree_with_the_oracle() {
    let seen = check_all("columns", SCENES / 60, Scene::columns);
    assert!(seen.unsure * 4 < seen.cycles, "there is something to compare: {seen:?}");
}

#[test]
fn circles_that_slide_along_a_slanted_wall_agree_with_the_oracle() {
    let seen = check_all("sliding", SCENES / 15, Scene::sliding);
    assert!(seen.unsure * 2 < seen.cycles, "there is something to compare: {seen:?}");
}

#[test]
fn a_packed_crowd_in_which_rounding_decides_who_is_first_is_nowhere_deeper_than_a_skin() {
    let seen = check_all("crowd", SCENES / 60, Scene::crowd);
    assert!(seen.stops > 1000, "{seen:?}");
}

#[test]
fn circles_that_meet_head_on_stop_when_a_skin_is_left() {
    let scene = asked(&[((0.0, 0.0), (1.0, 0.0), 0.5), ((2.5, 0.0), (-1.0, 0.0), 0.5)], &[], 0.25);
    let solution = solve(&scene);
    // 2.5 - 2 t = 1 + 0.25
    for (place, other) in [(0, 1), (1, 0)] {
        let outcome = &solution.outcomes[place];
        assert_eq!(outcome.ending, Ending::Stopped(Obstacle::Object(other)));
        assert_eq!(outcome.time, number(0.625));
        assert_eq!(outcome.leverage, 0.5);
    }
    assert_eq!(solution.outcomes[0].point, Vector::new([0.625, 0.0]));
    assert_eq!(solution.outcomes[1].point, Vector::new([1.875, 0.0]));
}

#[test]
fn a_graze_by_exactly_the_sum_of_the_radii_is_none_and_one_ulp_less_is_one() {
    for (height, stops) in [(1.0, false), (1.0f64.next_down(), true), (1.0f64.next_up(), false)] {
        let scene = asked(&[((0.0, 0.0), (8.0, 0.0), 0.5), ((4.0, height), (0.0, 0.0), 0.5)], &[], 0.0);
        assert_eq!(solve(&scene).outcomes[0].ending != Ending::Continues, stops, "{height:e}");
        let wall = [((4.0, height - 0.5), (4.0, 9.0))];
        let scene = asked(&[((0.0, 0.0), (8.0, 0.0), 0.5)], &wall, 0.0);
        // Half of the ulp above 0.5 is lost to rounding below it.
        let stops = height - 0.5 < 0.5;
        assert_eq!(solve(&scene).outcomes[0].ending != Ending::Continues, stops, "{height:e}");
    }
}

#[test]
fn a_circle_stops_at_the_end_of_a_wall_and_beside_it() {
    // 3, 4, 5: the end is 4 to the right when it is 5 away.
    let wall = [((0.0, 0.0), (0.0, -9.0))];
    let outcome = solve(&asked(&[((-10.0, 3.0), (20.0, 0.0), 5.0)], &wall, 0.0)).outcomes.remove(0);
    assert_eq!(outcome.ending, Ending::Stopped(Obstacle::Wall(0)));
    assert_near(&outcome, (3, 10), [-4.0, 3.0]);
    let outcome = solve(&asked(&[((-10.0, -3.0), (20.0, 0.0), 5.0)], &wall, 1.0)).outcomes.remove(0);
    assert_near(&outcome, (1, 5), [-6.0, -3.0]);
    assert_eq!(outcome.leverage, 1.0);
}

#[test]
fn a_chain_stops_one_after_the_other_and_errors_add_up() {
    let chain = [
        ((0.0, 0.0), (8.0, 0.0), 0.5),
        ((2.0, 0.0), (4.0, 0.0), 0.5),
        ((4.0, 0.0), (0.0, 0.0), 0.5),
        ((9.0, 9.0), (0.0, 0.0), 0.5),
    ];
    let solution = solve(&asked(&chain, &[], 0.0));
    let expected =
        [(Ending::Stopped(Obstacle::Object(1)), 0.25), (Ending::Stopped(Obstacle::Object(0)), 0.25)];
    for (place, (ending, time)) in expected.into_iter().enumerate() {
        assert_eq!(
            (solution.outcomes[place].ending, &solution.outcomes[place].time),
            (ending, &number(time))
        );
    }
    assert_eq!(solution.outcomes[2].ending, Ending::Continues);
    // The first reaches the second only after that has stopped: 1 + 8 t = 2 with its partner off by its leverage and its rounding.
    let chain = [((0.0, 0.0), (4.0, 0.0), 0.5), ((2.5, 0.0), (2.0, 0.0), 0.5), ((4.0, 0.0), (0.0, 0.0), 0.5)];
    let solution = solve(&asked(&chain, &[], 0.0));
    assert_eq!(solution.outcomes[1].time, number(0.25));
    assert_eq!(solution.outcomes[0].time, number(0.5));
    assert_eq!([0, 1].map(|place| solution.outcomes[place].leverage), [3.0, 1.0]);
    assert_eq!(solution.outcomes[0].ending, Ending::Stopped(Obstacle::Object(1)));
}

#[test]
fn collisions_at_one_time_stop_all_who_are_in_them() {
    let cross = [
        ((-2.0, 0.0), (2.0, 0.0), 0.5),
        ((2.0, 0.0), (-2.0, 0.0), 0.5),
        ((0.0, -2.0), (0.0, 2.0), 0.5),
        ((0.0, 2.0), (0.0, -2.0), 0.5),
    ];
    let solution = solve(&asked(&cross, &[], 0.0));
    for outcome in &solution.outcomes {
        // The centres are 2 - 2 t from the middle and sqrt(2) times that from each other.
        assert_eq!(rounded(&outcome.time), 1.0 - 0.5f64.sqrt() / 2.0);
        assert!(matches!(outcome.ending, Ending::Stopped(_)), "{outcome:?}");
    }
    assert_eq!(solution.margin, 0.0, "rounding may put any of them first");
}

#[test]
fn who_is_bumped_from_behind_goes_on_if_only_the_approaching_stop() {
    let chase = [((0.0, 0.0), (4.0, 0.0), 0.5), ((2.0, 0.0), (2.0, 0.0), 0.5)];
    let both = asked(&chase, &[], 0.0);
    assert!(solve(&both).outcomes.iter().all(|outcome| outcome.time == number(0.5)));
    let approaching = maniple_oracle::Scene { stops: maniple_oracle::Stops::Approaching, ..both };
    let solution = solve(&approaching);
    assert_eq!(solution.outcomes[0].ending, Ending::Stopped(Obstacle::Object(1)));
    assert_eq!(solution.outcomes[1].ending, Ending::Continues);
}

#[test]
fn who_is_within_two_skins_stops_at_once_if_it_would_come_nearer_and_else_goes_on() {
    let at = |gap: f64, way: (f64, f64)| {
        let scene = asked(&[((0.0, 0.0), (0.0, 0.0), 0.5), ((1.0 + gap, 0.0), way, 0.5)], &[], 0.25);
        solve(&scene).outcomes.remove(1).time
    };
    assert_eq!(at(0.0, (-1.0, 0.0)), number(0.0));
    assert_eq!(at(0.5, (-1.0, 0.0)), number(0.0));
    assert_eq!(at(0.625, (-1.0, 0.0)), number(0.375));
    for way in [(0.0, 1.0), (0.0, -1.0), (1.0, 0.0)] {
        assert_eq!(at(0.0, way), number(1.0));
    }
    // Other solvers begin with overlaps.
    assert_eq!(at(-0.5, (-1.0, 0.0)), number(0.0));
    assert_eq!(at(-0.5, (1.0, 0.0)), number(1.0));
}

#[test]
fn the_judge_finds_what_was_missed_invented_and_passed_through() {
    let pair = [((0.0, 0.0), (4.0, 0.0), 0.5), ((2.0, 0.0), (0.0, 0.0), 0.5)];
    let wall = [((3.0, -1.0), (3.0, 1.0))];
    let scene = asked(&pair, &wall, 0.0);
    let result = |x: f64, until: f64, is_stopped| {
        let resting = Actual { point: [2.0, 0.0], until: 1.0, is_stopped: false };
        verdict(&scene, &[Actual { point: [x, 0.0], until, is_stopped }, resting])
    };
    assert_eq!(result(1.0, 0.25, true), Verdict::default());
    let through = result(4.0, 1.0, false);
    assert_eq!(through.missed, [0]);
    assert_eq!((through.deviation_mean, through.deviation_max), (1.5, 3.0));
    assert_eq!((through.deepest, through.deepest_at_end), (1.0, 0.0));
    assert_eq!(through.tunnelled, [(0, Obstacle::Object(1)), (0, Obstacle::Wall(0))]);
    let inside = result(1.25, 0.3125, true);
    assert_eq!((inside.deepest, inside.deepest_at_end, inside.deviation_max), (0.25, 0.25, 0.25));
    assert_eq!((inside.overlapping, inside.tunnelled), (vec![(0, Obstacle::Object(1))], Vec::new()));
    let aside = asked(&pair[1..], &[], 0.0);
    let stopped = verdict(&aside, &[Actual { point: [2.0, 0.0], until: 0.0, is_stopped: true }]);
    assert_eq!((stopped.spurious, stopped.deviation_max), (vec![0], 0.0));
}

#[test]
fn the_judge_has_nothing_against_the_oracle_and_finds_all_that_ignoring_collisions_misses() {
    for seed in 0..10 {
        let mut scene = gathering(&mut Random(seed), 100);
        simplify(&mut scene);
        let asked = Run::new(&scene).given().asked();
        let solution = solve(&asked);
        let stops = |outcome: &Outcome| matches!(outcome.ending, Ending::Stopped(_));
        let own = |outcome: &Outcome| Actual {
            point: outcome.point.to_f64(),
            until: rounded(&outcome.time),
            is_stopped: stops(outcome),
        };
        let own: Vec<Actual> = solution.outcomes.iter().map(own).collect();
        let fair = judge(&asked, &solution, &own, asked.skin);
        assert!(fair.deviation_max <= ROUNDING * asked.skin, "seed {seed}: {fair:?}");
        let expected = Verdict {
            deviation_mean: fair.deviation_mean,
            deviation_max: fair.deviation_max,
            ..Verdict::default()
        };
        assert_eq!(fair, expected, "seed {seed}");
        let free = |object: &Object| {
            let [(x, v), (y, w)] = [0, 1].map(|axis| (object.center[axis], object.velocity[axis]));
            let point = object.goal.map_or([x + v, y + w], |goal| goal.point);
            Actual { point, until: object.goal.map_or(1.0, |goal| goal.time), is_stopped: false }
        };
        let free: Vec<Actual> = asked.objects.iter().map(free).collect();
        let blind = judge(&asked, &solution, &free, asked.skin);
        let stopped: Vec<usize> = (0..)
            .zip(&solution.outcomes)
            .filter(|(_, outcome)| stops(outcome))
            .map(|(place, _)| place)
            .collect();
        assert_eq!((&blind.missed, blind.spurious.len()), (&stopped, 0), "seed {seed}");
        assert!(!blind.tunnelled.is_empty() && !blind.overlapping.is_empty(), "seed {seed}: {blind:?}");
        assert!(
            blind.deepest >= blind.deepest_at_end && blind.deepest_at_end > 0.0,
            "seed {seed}: {blind:?}"
        );
    }
}

#[test]
fn the_oracle_says_the_same_whatever_the_order_of_the_objects() {
    for seed in 0..10 {
        let mut scene = gathering(&mut Random(seed), 100);
        simplify(&mut scene);
        let asked = Run::new(&scene).given().asked();
        let objects = asked.objects.iter().rev().copied().collect();
        let reversed = solve(&maniple_oracle::Scene { objects, ..asked.clone() });
        let straight = solve(&asked);
        assert_eq!(straight.margin, reversed.margin, "seed {seed}");
        for (one, other) in straight.outcomes.iter().zip(reversed.outcomes.iter().rev()) {
            assert_eq!((&one.time, &one.point, one.leverage), (&other.time, &other.point, other.leverage));
        }
    }
}

/// What the oracle is asked about circles at `center` with `velocity` and `radius`, and walls from one point to another.
#[expect(clippy::type_complexity, reason = "a row of plain numbers reads best in a test")]
fn asked(
    circles: &[((f64, f64), (f64, f64), f64)],
    walls: &[((f64, f64), (f64, f64))],
    skin: f64,
) -> maniple_oracle::Scene {
    let object = |&(center, velocity, radius): &((f64, f64), (f64, f64), f64)| Object {
        center: [center.0, center.1],
        velocity: [velocity.0, velocity.1],
        radius,
        goal: None,
    };
    let wall = |&(start, end): &((f64, f64), (f64, f64))| Wall { start: start.into(), end: end.into() };
    maniple_oracle::Scene {
        objects: circles.iter().map(object).collect(),
        walls: walls.iter().map(wall).collect(),
        skin,
        stops: maniple_oracle::Stops::Both,
    }
}

fn verdict(scene: &maniple_oracle::Scene, actual: &[Actual]) -> Verdict {
    judge(scene, &solve(scene), actual, 0.0)
}

fn number(value: f64) -> Exact {
    Exact::try_from(value).unwrap()
}

/// Checks that a stop is at a fraction of the cycle and at a point, to 200 bits.
fn assert_near(outcome: &Outcome, (part, whole): (i32, i32), point: [f64; 2]) {
    let is_tiny = |difference: Exact| rounded(&difference).abs() < 2f64.powi(-200);
    assert!(is_tiny(&outcome.time - Exact::from(part) / Exact::from(whole)), "{}", outcome.time);
    let expected = Vector::new(point);
    assert!(is_tiny(&outcome.point.x - expected.x) && is_tiny(&outcome.point.y - expected.y), "{outcome:?}");
}

/// What a run of scenes saw.
#[derive(Debug, Default)]
struct Seen {
    cycles: usize,
    /// Cycles in which rounding may decide, so that stops were not compared.
    unsure: usize,
    stops: usize,
    walls: usize,
    arrivals: usize,
    retreats: usize,
    /// The largest deviation, in skins times leverage.
    deviation_max: f64,
    /// The deepest penetration within a cycle, in skins.
    deepest: f64,
}

impl Seen {
    fn add(&mut self, events: &[Event]) {
        let count = |kinds: &[EventKind]| events.iter().filter(|event| kinds.contains(&event.kind)).count();
        self.stops += count(&[EventKind::Object, EventKind::Segment, EventKind::Edge]);
        self.walls += count(&[EventKind::Segment, EventKind::Edge]);
        self.arrivals += count(&[EventKind::Arrived]);
    }
}

fn check_all(class: &str, scenes: u64, make: impl Fn(&mut Random) -> Scene) -> Seen {
    let seed = 20_260_402;
    let scenes = if std::env::var_os("MANIPLE_LONG").is_some() { 50 * scenes } else { scenes };
    println!("class {class}: seed {seed}, {scenes} scenes");
    let mut seen = Seen::default();
    for number in 0..scenes {
        let mut scene = make(&mut Random(seed + number));
        simplify(&mut scene);
        Run::new(&scene).check(&format!("{class} {}", seed + number), &mut seen);
    }
    println!("class {class}: {seen:?}");
    seen
}

/// Circles strewn over a box, a quarter of its area, who are all sent to its middle.
fn gathering(random: &mut Random, count: u32) -> Scene {
    let size = (f64::from(count) * std::f64::consts::PI * 0.16 * 4.0).sqrt();
    let stops = if random.chance(0.5) { Stops::Both } else { Stops::Approaching };
    let mut scene = Scene::boxed(size, stops).cycles(10);
    let mut world = scene.world();
    while world.len() < count as usize {
        let (id, radius) = (u32::try_from(world.len()).unwrap(), random.between(0.3, 0.45));
        let place = |random: &mut Random| random.between(0.5, size - 0.5);
        let center = DVec2::new(place(random), place(random));
        if world.insert(ObjectId(id), Circle::new(center, radius), Layers::GROUND).is_err() {
            continue;
        }
        scene = scene.object(id, center.into(), radius);
        for cycle in [0, 3, 6] {
            let goal = (size * random.between(0.4, 0.6), size * random.between(0.4, 0.6));
            scene = scene.go(cycle, id, goal, random.between(0.1, 2.0));
        }
    }
    scene
}

/// Leaves what the oracle knows: one layer, and orders of one leg that begin with the cycle. Declares no larger limits than
/// the scene needs, so that the skin is as small as it may be.
fn simplify(scene: &mut Scene) {
    scene.single_orders();
    scene.orders.retain(|order| !order.legs.is_empty());
    let (mut radius_max, mut speed_max) = (RADIUS_MIN, SPEED_MIN);
    for order in &mut scene.orders {
        order.queue = false;
        order.start = None;
        speed_max = order.legs[0].1.max(speed_max);
    }
    for object in &scene.objects {
        radius_max = object.2.max(radius_max);
    }
    let size = scene.walls[1].segment.end.x;
    scene.limits = Limits::new(size, radius_max, speed_max).unwrap();
}

/// A scene that is played in the core, and what the oracle has to know of its objects.
struct Run<'a> {
    scene: &'a Scene,
    world: World,
    ids: Vec<ObjectId>,
    /// The goal and speed of who is on the way.
    legs: BTreeMap<ObjectId, (DVec2, f64)>,
}

impl<'a> Run<'a> {
    fn new(scene: &'a Scene) -> Self {
        let world = scene.world();
        Self { scene, ids: world.ids(), world, legs: BTreeMap::new() }
    }

    fn check(mut self, name: &str, seen: &mut Seen) {
        for _ in 0..self.scene.cycles {
            self = self.given();
            let asked = self.asked();
            let solution = solve(&asked);
            let context = format!("{name}, cycle {}, margin {:e}", self.world.cycle(), solution.margin);
            let events = self.world.step().to_vec();
            let (retreats, skin) = (self.world.activity().retreats, self.world.skin());
            // Who was pulled back is elsewhere by some units of rounding, and may not quite have arrived.
            let is_sure = solution.margin > ERROR * skin && retreats == 0;
            if is_sure {
                self.compare(&solution, &events, (seen, &context));
            }
            let verdict = judge(&asked, &solution, &self.actual(&events), skin);
            assert!(verdict.deepest <= skin && verdict.deepest_at_end == 0.0, "{context}: {verdict:?}");
            assert!(verdict.overlapping.is_empty() && verdict.tunnelled.is_empty(), "{context}: {verdict:?}");
            let is_right = verdict.missed.is_empty() && verdict.spurious.is_empty();
            assert!(is_right || !is_sure, "{context}: {verdict:?}");
            seen.add(&events);
            seen.cycles += 1;
            seen.unsure += usize::from(!is_sure);
            seen.retreats += retreats;
            seen.deepest = seen.deepest.max(verdict.deepest / skin);
            for event in events.iter().filter(|event| event.rests) {
                self.legs.remove(&event.object);
            }
        }
    }

    /// Gives the objects the orders of the present cycle.
    fn given(mut self) -> Self {
        self.scene.give(&mut self.world);
        for order in self.scene.orders.iter().filter(|order| order.cycle == self.world.cycle().0) {
            self.legs.insert(ObjectId(order.id), order.legs[0]);
        }
        self
    }

    /// The state at the start of the cycle.
    fn asked(&self) -> maniple_oracle::Scene {
        let wall = |wall: &maniple_kinematics::Wall| Wall {
            start: wall.segment.start.to_array(),
            end: wall.segment.end.to_array(),
        };
        let stops = match self.scene.stops {
            Stops::Both => maniple_oracle::Stops::Both,
            Stops::Approaching => maniple_oracle::Stops::Approaching,
        };
        maniple_oracle::Scene {
            objects: self.ids.iter().map(|&id| self.object(id)).collect(),
            walls: self.walls().map(wall).collect(),
            skin: self.world.skin(),
            stops,
        }
    }

    fn object(&self, id: ObjectId) -> Object {
        let (circle, motion) = (self.world.circle(id).unwrap(), self.world.motion(id).unwrap());
        let resting = Object {
            center: circle.center.to_array(),
            velocity: [0.0; 2],
            radius: circle.radius,
            goal: None,
        };
        let Some(&(goal, speed)) = self.legs.get(&id) else { return resting };
        if goal == circle.center {
            return Object { goal: Some(Goal { point: goal.to_array(), time: 0.0 }), ..resting };
        }
        // The time of the arrival is given; what becomes of it is asked.
        let left = (goal - motion.start).length() / speed - motion.from.until(self.world.cycle());
        let goal = (left <= 1.0).then(|| Goal { point: goal.to_array(), time: left.max(2f64.powi(-80)) });
        Object { velocity: motion.velocity.to_array(), goal, ..resting }
    }

    /// Compares what became of the objects: why they rest, and where they are.
    fn compare(&self, solution: &Solution, events: &[Event], (seen, context): (&mut Seen, &str)) {
        for (&id, outcome) in self.ids.iter().zip(&solution.outcomes) {
            let expected = match outcome.ending {
                Ending::Continues => None,
                Ending::Arrived => Some((EventKind::Arrived, None)),
                Ending::Stopped(Obstacle::Object(other)) => Some((EventKind::Object, Some(self.ids[other]))),
                Ending::Stopped(Obstacle::Wall(wall)) => {
                    let is_edge = self.walls().nth(wall).unwrap().kind == WallKind::Edge;
                    Some((if is_edge { EventKind::Edge } else { EventKind::Segment }, None))
                }
            };
            let ending = rest(events, id).map(|event| (event.kind, event.other));
            assert_eq!(ending, expected, "{context}, object {id}: {outcome:?}");
            let center = self.world.circle(id).unwrap().center;
            let [dx, dy] = [&outcome.point.x - number(center.x), &outcome.point.y - number(center.y)]
                .map(|difference| rounded(&difference));
            let allowed = self.world.skin() * (ROUNDING + ERROR * outcome.leverage);
            let deviation = dx.hypot(dy) / allowed;
            assert!(deviation <= 1.0, "{context}, object {id}: {deviation} of what is allowed, {outcome:?}");
            seen.deviation_max = seen.deviation_max.max(deviation);
        }
    }

    /// What the core made of the objects.
    fn actual(&self, events: &[Event]) -> Vec<Actual> {
        let actual = |&id: &ObjectId| {
            let point = self.world.circle(id).unwrap().center.to_array();
            let rest = rest(events, id);
            let is_stopped = rest.is_some_and(|event| event.kind != EventKind::Arrived);
            Actual { point, until: rest.map_or(1.0, |event| event.time), is_stopped }
        };
        self.ids.iter().map(actual).collect()
    }

    /// The walls in the order in which they are named where two are hit at once: edges last.
    fn walls(&self) -> impl Iterator<Item = &maniple_kinematics::Wall> {
        self.scene.walls.iter().rev()
    }
}

/// The event after which an object rests, if it does.
fn rest(events: &[Event], id: ObjectId) -> Option<&Event> {
    events.iter().rfind(|event| event.object == id && event.rests)
}
