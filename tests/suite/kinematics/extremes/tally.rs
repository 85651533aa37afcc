//! Plays scenes, looks at everything between and at the stored states without rounding, and counts what it finds.

use std::collections::BTreeMap;

use glam::DVec2;
use maniple_geometry::{Cycle, Limits, ObjectId};
use maniple_kinematics::{Event, EventKind, Wall, World};

use super::super::scene::{Random, Scene};
use super::ways::{self, Finding, Standing, Stretch, Way};
use crate::rational::number;

/// The seed of every class; scene number n of a class is made from the seed plus n.
pub(super) const SEED: u64 = 20_260_901;

/// How many times as many scenes `MANIPLE_LONG=1` plays.
const LONGER: u64 = 20;

/// What was found in the scenes of a class.
#[derive(Debug)]
pub(super) struct Tally {
    pub(super) class: &'static str,
    pub(super) scenes: u64,
    pub(super) cycles: u64,
    /// Objects that were stopped by an object or a wall.
    pub(super) collisions: u64,
    pub(super) retreats: u64,
    /// Deepest overlap at a stored state, in world units; not above zero if there is none.
    pub(super) deepest: f64,
    /// Deepest overlap between stored states, as a share of the skin.
    pub(super) deepest_between: f64,
    /// Pairs that came nearer than touching by any amount without being stopped.
    pub(super) missed: u64,
    /// Objects that were stopped by an object that they would not have come nearer to than touching.
    pub(super) unfounded: u64,
    /// Objects that stopped beside another one elsewhere than a skin above touching, or not at once though within two.
    pub(super) misplaced: u64,
    /// The first scene in which something was wrong, and what.
    pub(super) fault: Option<String>,
}

/// What became of a scene.
pub(super) struct Played {
    pub(super) world: World,
    pub(super) events: Vec<Event>,
    pub(super) retreats: usize,
}

impl Tally {
    /// Plays the scenes of a class and checks that nothing overlaps and nothing is missed.
    pub(super) fn of(class: &'static str, scenes: u64, make: impl Fn(&mut Random) -> Scene) -> Self {
        Self::checked(class, scenes, make, |_, _| {})
    }

    /// As [`Tally::of`], with a further check of each scene.
    pub(super) fn checked(
        class: &'static str,
        scenes: u64,
        make: impl Fn(&mut Random) -> Scene,
        check: impl Fn(&Scene, &Played),
    ) -> Self {
        let mut tally = Self::measured(class, scenes, make, check);
        tally.assert_exact();
        tally
    }

    /// As [`Tally::checked`], without the promises: for what is beyond the declared limits.
    pub(super) fn measured(
        class: &'static str,
        scenes: u64,
        make: impl Fn(&mut Random) -> Scene,
        check: impl Fn(&Scene, &Played),
    ) -> Self {
        let scenes = if std::env::var_os("MANIPLE_LONG").is_some() { LONGER * scenes } else { scenes };
        println!("class {class}: seed {SEED}, {scenes} scenes");
        let mut tally = Self::new(class);
        for number in 0..scenes {
            let scene = make(&mut Random(SEED + number));
            let played = tally.play(&scene, number);
            let _telling = Telling { class, number };
            check(&scene, &played);
        }
        tally.tell();
        tally
    }

    fn new(class: &'static str) -> Self {
        Self {
            class,
            scenes: 0,
            cycles: 0,
            collisions: 0,
            retreats: 0,
            deepest: 0.0,
            deepest_between: 0.0,
            missed: 0,
            unfounded: 0,
            misplaced: 0,
            fault: None,
        }
    }

    fn play(&mut self, scene: &Scene, number: u64) -> Played {
        let _telling = Telling { class: self.class, number };
        let mut world = scene.world();
        let (mut events, mut retreats) = (Vec::new(), 0);
        let mut goals = BTreeMap::new();
        for cycle in 0..scene.cycles {
            scene.give(&mut world);
            for order in scene.orders.iter().filter(|order| order.cycle == cycle) {
                goals.insert(order.id, order.legs.last().copied());
            }
            let before = standing(&world, scene);
            let told = world.step().to_vec();
            let state = State {
                scene,
                cycle: Cycle(cycle),
                before,
                after: standing(&world, scene),
                told: &told,
                goals: &goals,
            };
            let activity = world.activity();
            let overlaps = world.overlaps();
            if !overlaps.is_empty() {
                self.note(f64::INFINITY, format!("scene {number}, cycle {cycle}: {overlaps:?}"));
            }
            self.examine(&state, activity.retreats > 0, (number, cycle));
            self.cycles += 1;
            self.retreats += activity.retreats as u64;
            retreats += activity.retreats;
            events.extend(told);
        }
        self.scenes += 1;
        let is_collision = |event: &&Event| !matches!(event.kind, EventKind::Arrived | EventKind::Ordered);
        self.collisions += events.iter().filter(is_collision).count() as u64;
        Played { world, events, retreats }
    }

    fn examine(&mut self, state: &State<'_>, has_retreats: bool, at: (u64, u32)) {
        let skin = skin(&state.scene.limits);
        let ways = state.ways();
        let list: Vec<(u32, &Way)> = ways.iter().map(|(&id, way)| (id, way)).collect();
        for (place, &(a, one)) in list.iter().enumerate() {
            for &(b, other) in &list[place + 1..] {
                let found = ways::pair(one, other, has_retreats);
                self.add(found, skin, || format!("{at:?}: {a} and {b}"));
                self.note(ways::stored_depth(one, other), format!("{at:?}: {a} and {b} overlap"));
            }
            for wall in &state.scene.walls {
                let found = ways::wall(one, &wall.segment);
                self.add(found, skin, || format!("{at:?}: {a} and {:?}", wall.segment));
                let stored = ways::stored_wall_depth(one, &wall.segment);
                self.note(stored, format!("{at:?}: {a} overlaps {:?}", wall.segment));
            }
        }
        if has_retreats {
            return;
        }
        for event in state.told {
            if !state.is_founded(event, &ways) {
                self.unfounded += 1;
                self.fault.get_or_insert_with(|| format!("{at:?}: unfounded {event:?}"));
            }
            if event.kind == EventKind::Object && !state.is_in_place(event, &ways, skin) {
                self.misplaced += 1;
                self.fault.get_or_insert_with(|| format!("{at:?}: misplaced {event:?}"));
            }
        }
    }

    fn add(&mut self, found: Finding, skin: f64, what: impl Fn() -> String) {
        let share = found.depth / skin;
        if share > self.deepest_between {
            self.deepest_between = share;
        }
        if share >= 1.0 {
            self.fault.get_or_insert_with(|| format!("{}: {share} skins deep between states", what()));
        }
        if found.is_missed {
            self.missed += 1;
            self.fault.get_or_insert_with(|| format!("{}: missed, {:e} deep", what(), found.depth));
        }
    }

    fn note(&mut self, depth: f64, what: String) {
        if depth > 0.0 {
            self.deepest = self.deepest.max(depth);
            self.fault.get_or_insert(what);
        }
    }

    /// Prints the line of the class in the table of results.
    fn tell(&self) {
        let Self { class, scenes, cycles, collisions, retreats, .. } = self;
        println!(
            "| class | scenes | cycles | collisions | retreats | deepest | between, skins | missed | unfounded | misplaced |"
        );
        println!(
            "| {class} | {scenes} | {cycles} | {collisions} | {retreats} | {} | {:.4} | {} | {} | {} |",
            self.deepest, self.deepest_between, self.missed, self.unfounded, self.misplaced
        );
    }

    fn assert_exact(&mut self) {
        let fault = self.fault.take();
        assert!(self.deepest <= 0.0, "{}: {} deep at a stored state; {fault:?}", self.class, self.deepest);
        assert!(self.deepest_between < 1.0, "{}: {} skins; {fault:?}", self.class, self.deepest_between);
        assert_eq!(self.missed, 0, "{}: missed; {fault:?}", self.class);
        assert_eq!(self.unfounded, 0, "{}: unfounded; {fault:?}", self.class);
        assert_eq!(self.misplaced, 0, "{}: misplaced; {fault:?}", self.class);
    }
}

/// A cycle that was played, as the world tells of it.
struct State<'a> {
    scene: &'a Scene,
    cycle: Cycle,
    before: BTreeMap<u32, Standing>,
    after: BTreeMap<u32, Standing>,
    told: &'a [Event],
    /// Goal and speed of the last order to each; `None` if it was to stop.
    goals: &'a BTreeMap<u32, Option<(DVec2, f64)>>,
}

impl State<'_> {
    fn ways(&self) -> BTreeMap<u32, Way> {
        let mut told: BTreeMap<u32, Vec<&Event>> = BTreeMap::new();
        for event in self.told {
            told.entry(event.object.0).or_default().push(event);
        }
        let none = Vec::new();
        let way = |&(id, _, radius, _): &(u32, DVec2, f64, u32)| {
            let events = told.get(&id).unwrap_or(&none);
            (id, Way::new((&self.before[&id], &self.after[&id]), radius, events))
        };
        self.scene.objects.iter().map(way).collect()
    }

    /// Whether an object that was stopped would else have come nearer than touching to what stopped it.
    fn is_founded(&self, event: &Event, ways: &BTreeMap<u32, Way>) -> bool {
        match (event.kind, event.other) {
            (EventKind::Object, Some(other)) => self.is_founded_on_object(event, other.0, ways),
            (EventKind::Segment | EventKind::Edge, _) => {
                self.is_founded_on_wall(event, &ways[&event.object.0])
            }
            _ => true,
        }
    }

    fn is_founded_on_object(&self, event: &Event, other: u32, ways: &BTreeMap<u32, Way>) -> bool {
        let id = event.object.0;
        let reach = number(ways[&id].radius) + number(ways[&other].radius);
        let (one, partner) = (ways[&id].before(event.time), ways[&other].before(event.time));
        let from = one.since.max(partner.since);
        let to = (self.goes_on(id) && self.goes_on(other)).then_some(1.0);
        // The partner may have come to rest at that very time.
        let is_now = |stretch: &&Stretch| stretch.since == event.time && stretch.velocity == DVec2::ZERO;
        let at_rest = ways[&other].stretches.iter().find(is_now);
        ways::enters((&on(one), &on(partner)), &reach, (from, to))
            || at_rest.is_some_and(|rest| ways::enters((&on(one), rest), &reach, (event.time, to)))
    }

    fn is_founded_on_wall(&self, event: &Event, way: &Way) -> bool {
        let line = on(way.before(event.time));
        let enters = |wall: &Wall| ways::enters_wall(&line, way.radius, &wall.segment);
        !self.goes_on(event.object.0) || self.scene.walls.iter().any(enters)
    }

    /// Whether an object that was stopped by another one is a skin above touching, or was within two skins already.
    fn is_in_place(&self, event: &Event, ways: &BTreeMap<u32, Way>, skin: f64) -> bool {
        let (one, other) = (&ways[&event.object.0], &ways[&event.other.expect("a partner").0]);
        let gap = |time: f64| {
            let place = |way: &Way| way.before(time).place(time);
            (place(one) - place(other)).length() - one.radius - other.radius
        };
        let from = one.before(event.time).since.max(other.before(event.time).since);
        if event.time == from || other.stretches.iter().any(|stretch| stretch.since == event.time) {
            return gap(event.time) < 2.2 * skin;
        }
        gap(from) > 1.8 * skin && (0.5 * skin..1.5 * skin).contains(&gap(event.time))
    }

    /// Whether an object would not arrive in this cycle, so that its line goes on to the end.
    fn goes_on(&self, id: u32) -> bool {
        let Some(&Some((goal, speed))) = self.goals.get(&id) else { return true };
        let motion = &self.before[&id].motion;
        // From the start of the motion, since who moves by less than a bit a cycle is not where it seems to be.
        let left = (goal - motion.start).length() / speed - motion.from.until(self.cycle);
        !motion.is_moving() || left > 1.0 + 1e-9
    }
}

/// A stretch that nothing ends before the cycle does.
fn on(stretch: &Stretch) -> Stretch {
    Stretch { until: 1.0, goal: None, ..*stretch }
}

fn standing(world: &World, scene: &Scene) -> BTreeMap<u32, Standing> {
    let of = |id: u32| Standing {
        center: world.circle(ObjectId(id)).expect("the object is there").center,
        motion: world.motion(ObjectId(id)).expect("the object is there"),
    };
    scene.objects.iter().map(|object| (object.0, of(object.0))).collect()
}

/// The skin as it is promised, and not as the world says: `32 u (c + r + v)`.
pub(super) fn skin(limits: &Limits) -> f64 {
    16.0 * f64::EPSILON * (limits.coordinate_max() + limits.radius_max() + limits.speed_max())
}

/// Says which scene was being played when something panics.
struct Telling {
    class: &'static str,
    number: u64,
}

impl Drop for Telling {
    fn drop(&mut self) {
        if std::thread::panicking() {
            println!("class {}: scene {}, of seed {}", self.class, self.number, SEED + self.number);
        }
    }
}
