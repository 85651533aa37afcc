//! Objects and walls come and go during a match.

use std::collections::BTreeMap;

use glam::DVec2;
use maniple_geometry::predicate::{circle_overlaps_segment, circles_overlap};
use maniple_geometry::{Circle, ObjectId, Segment};
use maniple_kinematics::{
    Event, EventKind, InsertError, Layers, Leg, OrderError, Placement, Stops, Wall, WallError, WallId,
    WallKind, World,
};

use super::scene::{Random, Scene};

/// Random scenes of the ordinary run; `MANIPLE_LONG=1` plays a hundred times as many.
const SCENES: u64 = 400;

/// A world, and beside it a list of what must be in it.
struct Changing {
    /// The state of the random numbers at the start; said when something fails.
    seed: u64,
    world: World,
    /// Radius and layers.
    objects: BTreeMap<ObjectId, (f64, Layers)>,
    walls: BTreeMap<WallId, Wall>,
    size: f64,
    /// How often something was done, and how often refused, by what it was.
    done: BTreeMap<&'static str, (u64, u64)>,
}

#[test]
fn whatever_comes_and_goes_nothing_overlaps_and_only_what_would_is_refused() {
    let seed = 23;
    let scenes = if std::env::var_os("MANIPLE_LONG").is_some() { 100 * SCENES } else { SCENES };
    println!("seed {seed}");
    let mut done: BTreeMap<&'static str, (u64, u64)> = BTreeMap::new();
    for number in 0..scenes {
        let mut random = Random(seed + number);
        let mut changing = Changing::new(&mut random, (8.0, 40.0));
        for _ in 0..20 {
            for _ in 0..random.below(24) {
                changing.change(&mut random, (40, 1.5));
            }
            changing.step();
        }
        for (what, (taken, refused)) in std::mem::take(&mut changing.done) {
            let sum = done.entry(what).or_default();
            *sum = (sum.0 + taken, sum.1 + refused);
        }
    }
    println!("taken and refused: {done:?}");
    for what in ["insert", "insert wall", "remove", "remove wall", "teleport"] {
        assert!(done[what].0 > scenes && done[what].1 > scenes, "{what} was taken and refused: {done:?}");
    }
}

#[test]
fn thousands_come_and_go_in_a_large_world() {
    let seed = 29;
    println!("seed {seed}");
    let mut random = Random(seed);
    let mut changing = Changing::new(&mut random, (150.0, 151.0));
    for _ in 0..40 {
        for _ in 0..600 {
            changing.change(&mut random, (6000, 0.6));
        }
        changing.step();
    }
    assert!(changing.objects.len() > 1500, "{}", changing.objects.len());
}

#[test]
fn the_id_of_a_removed_object_is_refused_and_can_be_taken_again() {
    for stops in [Stops::Both, Stops::Approaching] {
        for cycles in [0, 1, 5] {
            let scene = Scene::boxed(40.0, stops).object(1, (5.0, 5.0), 0.5).object(2, (5.0, 9.0), 0.5);
            let mut world = scene.world();
            world.go(ObjectId(1), &[leg((35.0, 5.0), 1.0)], Placement::Replace, None).unwrap();
            for _ in 0..cycles {
                world.step();
            }
            let place = world.circle(ObjectId(1)).unwrap();
            world.remove(ObjectId(1)).unwrap();
            check_unknown(&mut world, ObjectId(1));
            assert_eq!(world.ids(), [ObjectId(2)]);
            // Its place and its id are free at once, and what it was told is forgotten.
            world.insert(ObjectId(1), place, Layers::GROUND).unwrap();
            assert!(world.is_at_rest());
            assert_eq!(world.step(), []);
            assert_eq!(world.circle(ObjectId(1)), Some(place));
            world.go(ObjectId(1), &[leg((35.0, 5.0), 40.0)], Placement::Replace, None).unwrap();
            assert_eq!(kinds(world.step()), [EventKind::Arrived]);
        }
    }
}

#[test]
fn objects_move_through_the_place_of_a_removed_wall_and_stop_at_an_inserted_one() {
    for stops in [Stops::Both, Stops::Approaching] {
        let scene = Scene::boxed(40.0, stops).wall((20.0, 1.0), (20.0, 39.0));
        let mut world = scene.object(1, (5.0, 5.0), 0.5).world();
        let go = |world: &mut World, goal: (f64, f64)| {
            world.go(ObjectId(1), &[leg(goal, 30.0)], Placement::Replace, None).unwrap();
            kinds(world.step())
        };
        assert_eq!(go(&mut world, (35.0, 5.0)), [EventKind::Segment]);
        let wall = world.remove_wall(WallId(4)).unwrap();
        assert_eq!(world.remove_wall(WallId(4)), None);
        assert_eq!(go(&mut world, (35.0, 5.0)), [EventKind::Arrived]);
        let id = world.insert_wall(wall).unwrap();
        assert_eq!(go(&mut world, (5.0, 5.0)), [EventKind::Segment]);
        assert!(world.circle(ObjectId(1)).unwrap().center.x > 20.5);
        world.remove_wall(id).unwrap();
        // A wall that comes while somebody is on the way is as solid.
        world.go(ObjectId(1), &[leg((5.0, 5.0), 1.0)], Placement::Replace, None).unwrap();
        assert_eq!(world.step(), []);
        let across = Wall { segment: Segment::new((12.0, 0.0).into(), (12.0, 40.0).into()), ..wall };
        world.insert_wall(across).unwrap();
        let events: Vec<Event> = (0..20).flat_map(|_| world.step().to_vec()).collect();
        assert_eq!(kinds(&events), [EventKind::Segment]);
        let center = world.circle(ObjectId(1)).unwrap().center;
        let through = Wall { segment: Segment::new(center, (40.0, 40.0).into()), ..wall };
        assert_eq!(world.insert_wall(through), Err(WallError::OverlapsObject { other: ObjectId(1) }));
    }
}

#[test]
fn who_is_teleported_forgets_its_way_and_its_old_place_is_free() {
    for stops in [Stops::Both, Stops::Approaching] {
        let scene = Scene::boxed(40.0, stops).object(1, (5.0, 5.0), 0.5).object(2, (5.0, 9.0), 0.5);
        let mut world = scene.world();
        let legs = [leg((35.0, 5.0), 1.0), leg((35.0, 35.0), 1.0)];
        world.go(ObjectId(1), &legs, Placement::Replace, None).unwrap();
        world.step();
        let left = world.circle(ObjectId(1)).unwrap();
        let taken = InsertError::OverlapsObject { other: ObjectId(2) };
        assert_eq!(world.teleport(ObjectId(1), DVec2::new(5.0, 8.5)), Err(taken));
        assert_eq!(world.circle(ObjectId(1)), Some(left));
        world.teleport(ObjectId(1), DVec2::new(20.0, 30.0)).unwrap();
        assert_eq!(world.waypoints(ObjectId(1)), Some(0));
        world.insert(ObjectId(3), left, Layers::GROUND).unwrap();
        assert_eq!(world.step(), []);
        assert_eq!(world.circle(ObjectId(1)).unwrap().center, DVec2::new(20.0, 30.0));
        // Onto a place that overlaps its own old one.
        world.teleport(ObjectId(1), DVec2::new(20.1, 30.0)).unwrap();
        assert_eq!(world.circle(ObjectId(1)).unwrap().center, DVec2::new(20.1, 30.0));
    }
}

impl Changing {
    fn new(random: &mut Random, (smallest, largest): (f64, f64)) -> Self {
        let seed = random.0;
        let stops = random.pick(&[Stops::Both, Stops::Approaching]);
        let size = random.between(smallest, largest);
        let scene = Scene::boxed(size, stops);
        let walls = (0..).map(WallId).zip(scene.walls.iter().copied()).collect();
        let (objects, done) = (BTreeMap::new(), BTreeMap::new());
        Self { seed, world: scene.world(), objects, walls, size, done }
    }

    /// Does one random thing; `ids` is how many there are to choose from.
    fn change(&mut self, random: &mut Random, (ids, radius_max): (u32, f64)) {
        let id = ObjectId(random.below(ids));
        match random.below(16) {
            0..4 => {
                let circle = Circle::new(self.place(random), random.between(0.1, radius_max));
                self.insert(id, circle, Layers(random.pick(&[1, 1, 1, 2, 3])));
            }
            4 => self.remove(id),
            5 | 6 => self.teleport(id, self.place(random)),
            7 => {
                let start = self.place(random);
                let way = DVec2::new(random.between(-4.0, 4.0), random.between(-4.0, 4.0));
                let end = (start + way).clamp(DVec2::ZERO, DVec2::splat(self.size));
                let (kind, layers) = (WallKind::Segment, Layers(random.pick(&[1, 1, 3])));
                self.insert_wall(Wall { segment: Segment::new(start, end), kind, layers });
            }
            8 => {
                // The edge stays.
                let id = WallId(4 + random.below(12));
                self.note("remove wall", self.walls.contains_key(&id));
                assert_eq!(self.world.remove_wall(id), self.walls.remove(&id), "{id:?}");
            }
            _ => {
                let goal = self.place(random);
                let speed = random.pick(&[0.05, 0.3, 1.0, 5.0]);
                let placement = random.pick(&[Placement::Replace, Placement::Queue]);
                let given = self.world.go(id, &[leg(goal.into(), speed)], placement, None);
                let is_there = self.objects.contains_key(&id);
                assert_eq!(given, if is_there { Ok(()) } else { Err(OrderError::UnknownObject) });
            }
        }
        assert_eq!(self.world.len(), self.objects.len());
    }

    /// A place anywhere, or near somebody, so near that they may touch.
    fn place(&self, random: &mut Random) -> DVec2 {
        let anywhere = DVec2::new(random.between(0.0, self.size), random.between(0.0, self.size));
        let ids: Vec<ObjectId> = self.objects.keys().copied().collect();
        if ids.is_empty() || random.chance(0.5) {
            return anywhere;
        }
        let id = random.pick(&ids);
        let way = DVec2::new(random.between(-1.0, 1.0), random.between(-1.0, 1.0));
        let near = self.center(id) + way * (2.0 * self.objects[&id].0);
        near.clamp(DVec2::ZERO, DVec2::splat(self.size))
    }

    fn center(&self, id: ObjectId) -> DVec2 {
        self.world.circle(id).expect("the object is there").center
    }

    fn insert(&mut self, id: ObjectId, circle: Circle, layers: Layers) {
        let expected = if self.objects.contains_key(&id) {
            Err(InsertError::DuplicateId)
        } else {
            self.check_place(circle, layers, None)
        };
        self.note("insert", expected.is_ok());
        assert_same(self.world.insert(id, circle, layers), expected, &format!("insert {id} {circle:?}"));
        if expected.is_ok() {
            self.objects.insert(id, (circle.radius, layers));
        }
    }

    fn remove(&mut self, id: ObjectId) {
        let is_there = self.objects.remove(&id).is_some();
        self.note("remove", is_there);
        if is_there {
            assert_eq!(self.world.remove(id), Ok(()));
        }
        check_unknown(&mut self.world, id);
    }

    fn teleport(&mut self, id: ObjectId, center: DVec2) {
        let expected = match self.objects.get(&id) {
            None => Err(InsertError::UnknownObject),
            Some(&(radius, layers)) => self.check_place(Circle::new(center, radius), layers, Some(id)),
        };
        self.note("teleport", expected.is_ok());
        assert_same(self.world.teleport(id, center), expected, &format!("teleport {id} to {center}"));
        if expected.is_ok() {
            assert_eq!(self.center(id), center);
            assert!(!self.world.motion(id).expect("the object is there").is_moving());
        }
    }

    fn insert_wall(&mut self, wall: Wall) {
        let Segment { start, end } = wall.segment;
        if start == end {
            let refused = Err(WallError::NoLength { index: 0, x: start.x, y: start.y });
            assert_eq!(self.world.insert_wall(wall), refused);
            return;
        }
        let overlaps = |(id, (radius, layers)): (&ObjectId, &(f64, Layers))| {
            let is_in = circle_overlaps_segment(self.center(*id), *radius, &wall.segment);
            (layers.share(wall.layers) && is_in).then_some(*id)
        };
        let blocking = self.objects.iter().find_map(overlaps);
        let inserted = self.world.insert_wall(wall);
        match blocking {
            Some(other) => assert_eq!(inserted, Err(WallError::OverlapsObject { other })),
            None => {
                let old = self.walls.insert(inserted.expect("nothing is in its place"), wall);
                assert_eq!(old, None, "two walls have one number");
            }
        }
        self.note("insert wall", blocking.is_none());
    }

    /// Says by looking at everything whether a place is free.
    fn check_place(&self, circle: Circle, layers: Layers, but: Option<ObjectId>) -> Result<(), InsertError> {
        let Circle { center, radius } = circle;
        for (&other, &(reach, theirs)) in self.objects.iter().filter(|(id, _)| Some(**id) != but) {
            if layers.share(theirs) && circles_overlap::<f64>(center, radius, self.center(other), reach) {
                return Err(InsertError::OverlapsObject { other });
            }
        }
        for Wall { segment, layers: theirs, .. } in self.walls.values() {
            if layers.share(*theirs) && circle_overlaps_segment(center, radius, segment) {
                let Segment { start, end } = segment;
                return Err(InsertError::OverlapsWall { segment: (start.x, start.y, end.x, end.y) });
            }
        }
        Ok(())
    }

    /// Simulates a cycle and looks at all pairs.
    fn step(&mut self) {
        self.world.step();
        assert_eq!(self.world.overlaps(), [], "after cycle {}", self.world.cycle());
        let ids: Vec<ObjectId> = self.objects.keys().copied().collect();
        assert_eq!(self.world.ids(), ids);
        let circles: Vec<(DVec2, f64, Layers)> =
            self.objects.iter().map(|(&id, &(radius, layers))| (self.center(id), radius, layers)).collect();
        for (place, &(p, r, layers)) in circles.iter().enumerate() {
            for (other, &(q, s, theirs)) in circles[..place].iter().enumerate() {
                let is_overlap = layers.share(theirs) && circles_overlap::<f64>(p, r, q, s);
                assert!(!is_overlap, "{} and {} overlap", ids[place], ids[other]);
            }
            for (wall, Wall { segment, layers: theirs, .. }) in &self.walls {
                let is_overlap = layers.share(*theirs) && circle_overlaps_segment(p, r, segment);
                assert!(!is_overlap, "{} and wall {wall:?} overlap", ids[place]);
            }
        }
    }

    fn note(&mut self, what: &'static str, is_taken: bool) {
        let (taken, refused) = self.done.entry(what).or_default();
        *(if is_taken { taken } else { refused }) += 1;
    }
}

impl Drop for Changing {
    fn drop(&mut self) {
        if std::thread::panicking() {
            println!("the scene of seed {}", self.seed);
        }
    }
}

/// Compares two answers; which of several walls is in the way is not said.
fn assert_same(found: Result<(), InsertError>, expected: Result<(), InsertError>, what: &str) {
    let both_walls = matches!(
        (found, expected),
        (Err(InsertError::OverlapsWall { .. }), Err(InsertError::OverlapsWall { .. }))
    );
    assert!(both_walls || found == expected, "{what}: {found:?} instead of {expected:?}");
}

fn check_unknown(world: &mut World, id: ObjectId) {
    let unknown = Err(OrderError::UnknownObject);
    assert_eq!(world.go(id, &[leg((1.0, 1.0), 1.0)], Placement::Replace, None), unknown);
    assert_eq!(world.halt(id, None), unknown);
    assert_eq!(world.remove(id), unknown);
    assert_eq!(world.teleport(id, DVec2::ONE), Err(InsertError::UnknownObject));
    assert_eq!((world.circle(id), world.motion(id), world.waypoints(id)), (None, None, None));
}

fn leg(goal: (f64, f64), speed: f64) -> Leg {
    Leg { goal: goal.into(), speed }
}

fn kinds(events: &[Event]) -> Vec<EventKind> {
    events.iter().map(|event| event.kind).collect()
}
