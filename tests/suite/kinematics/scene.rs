//! Scenes for the tests: objects, walls and orders that any kinematic world can be given.

use std::fmt::Write as _;

use glam::DVec2;
use maniple_geometry::{Circle, Cycle, Limits, Moment, ObjectId, Segment};
use maniple_kinematics::{
    Event, InsertError, Layers, Leg, Placement, Settings, Stops, Wall, WallKind, World,
};

/// A deterministic stream of random numbers for tests (SplitMix64, Steele, Lea and Flood 2014).
pub(crate) struct Random(pub(crate) u64);

impl Random {
    pub(crate) fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// A number in 0..1.
    pub(crate) fn unit(&mut self) -> f64 {
        (self.next() >> 11) as f64 / (1u64 << 53) as f64
    }

    pub(crate) fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    /// A number in 0..count.
    pub(crate) fn below(&mut self, count: u32) -> u32 {
        u32::try_from(self.next() % u64::from(count)).expect("below a number of 32 bits")
    }

    /// One of the items.
    pub(crate) fn pick<T: Copy>(&mut self, items: &[T]) -> T {
        items[self.below(u32::try_from(items.len()).expect("few items")) as usize]
    }

    pub(crate) fn chance(&mut self, share: f64) -> bool {
        self.unit() < share
    }
}

/// One order of a scene.
#[derive(Clone, Debug)]
pub(crate) struct Order {
    pub(crate) cycle: u32,
    pub(crate) id: u32,
    /// No leg means to stop.
    pub(crate) legs: Vec<(DVec2, f64)>,
    pub(crate) queue: bool,
    pub(crate) start: Option<(u32, f64)>,
}

/// A scene: what is there, and what is ordered when.
#[derive(Clone, Debug)]
pub(crate) struct Scene {
    pub(crate) limits: Limits,
    pub(crate) stops: Stops,
    pub(crate) walls: Vec<Wall>,
    /// id, centre, radius, layers
    pub(crate) objects: Vec<(u32, DVec2, f64, u32)>,
    pub(crate) orders: Vec<Order>,
    pub(crate) cycles: u32,
}

impl Scene {
    /// An empty box from (0, 0) to (size, size).
    pub(crate) fn boxed(size: f64, stops: Stops) -> Self {
        let corner = |x, y| DVec2::new(x, y);
        // The blocked side is outside, to the right.
        let corners = [corner(0.0, 0.0), corner(0.0, size), corner(size, size), corner(size, 0.0)];
        let edge = |place: usize| Wall {
            segment: Segment::new(corners[place], corners[(place + 1) % 4]),
            kind: WallKind::Edge,
            layers: Layers(u32::MAX),
        };
        Self {
            limits: Limits::new(size.max(100.0), 20.0, 1e4).unwrap(),
            stops,
            walls: (0..4).map(edge).collect(),
            objects: Vec::new(),
            orders: Vec::new(),
            cycles: 1,
        }
    }

    pub(crate) fn wall(mut self, from: (f64, f64), to: (f64, f64)) -> Self {
        let segment = Segment::new(from.into(), to.into());
        self.walls.push(Wall { segment, kind: WallKind::Segment, layers: Layers::GROUND });
        self
    }

    pub(crate) fn object(mut self, id: u32, center: (f64, f64), radius: f64) -> Self {
        self.objects.push((id, center.into(), radius, 1));
        self
    }

    pub(crate) fn go(mut self, cycle: u32, id: u32, goal: (f64, f64), speed: f64) -> Self {
        let legs = vec![(goal.into(), speed)];
        self.orders.push(Order { cycle, id, legs, queue: false, start: None });
        self
    }

    pub(crate) fn order(mut self, order: Order) -> Self {
        self.orders.push(order);
        self
    }

    pub(crate) fn cycles(mut self, cycles: u32) -> Self {
        self.cycles = cycles;
        self
    }

    /// The world of the scene at cycle 0, its objects inserted in the order of the list.
    pub(crate) fn world(&self) -> World {
        self.world_under(Settings::exact(self.stops))
    }

    /// As [`Scene::world`], under other settings than the exact ones.
    pub(crate) fn world_under(&self, settings: Settings) -> World {
        let mut world = World::new(self.limits, settings, &self.walls).unwrap();
        for &(id, center, radius, layers) in &self.objects {
            world
                .insert(ObjectId(id), Circle::new(center, radius), Layers(layers))
                .unwrap_or_else(|error| panic!("object {id}: {error}"));
        }
        world
    }

    /// Gives a world the orders of its present cycle.
    pub(crate) fn give(&self, world: &mut World) {
        let now = world.cycle();
        for order in self.orders.iter().filter(|order| Cycle(order.cycle) == now) {
            let start = order.start.map(|(cycle, fraction)| Moment { cycle: Cycle(cycle), fraction });
            let id = ObjectId(order.id);
            let given = if order.legs.is_empty() {
                world.halt(id, start)
            } else {
                let legs: Vec<Leg> = order.legs.iter().map(|&(goal, speed)| Leg { goal, speed }).collect();
                let placement = if order.queue { Placement::Queue } else { Placement::Replace };
                world.go(id, &legs, placement, start)
            };
            given.unwrap_or_else(|error| panic!("order {order:?}: {error}"));
        }
    }

    /// Gives each order only its first leg, as `maniple simulate` does, and takes everything into one layer.
    pub(crate) fn single_orders(&mut self) {
        for order in &mut self.orders {
            order.legs.truncate(1);
        }
        for object in &mut self.objects {
            object.3 = 1;
        }
        let mut clear = Self { objects: Vec::new(), ..self.clone() };
        for object in std::mem::take(&mut self.objects) {
            let circle = Circle::new(object.1, object.2);
            if clear.world().insert(ObjectId(object.0), circle, Layers::GROUND).is_ok() {
                clear.objects.push(object);
            }
        }
        self.objects = clear.objects;
        self.orders.retain(|order| self.objects.iter().any(|object| object.0 == order.id));
        for wall in &mut self.walls {
            wall.layers = Layers(u32::MAX);
        }
    }

    /// The scene as `maniple simulate` reads it.
    pub(crate) fn to_json(&self) -> String {
        let size = self.walls[1].segment.end.x;
        let segments: Vec<serde_json::Value> = self.walls[4..]
            .iter()
            .map(|Wall { segment: Segment { start, end }, .. }| {
                serde_json::json!([start.x, start.y, end.x, end.y])
            })
            .collect();
        let object = |&(id, center, r, _): &(u32, DVec2, f64, u32)| serde_json::json!({"id": id, "x": center.x, "y": center.y, "r": r});
        let order = |order: &Order| {
            let (goal, speed) = order.legs.first().copied().unwrap_or((DVec2::ONE, 0.0));
            let mut json = serde_json::json!(
                {"cycle": order.cycle, "id": order.id, "x": goal.x, "y": goal.y, "s": speed, "queue": order.queue});
            if let Some(start) = order.start {
                json["start"] = serde_json::json!(start);
            }
            json
        };
        let stops = match self.stops {
            Stops::Both => "both",
            Stops::Approaching => "approaching",
        };
        serde_json::json!({
            "bounds": [0.0, 0.0, size, size],
            "segments": segments,
            "objects": self.objects.iter().map(object).collect::<Vec<_>>(),
            "moves": self.orders.iter().map(order).collect::<Vec<_>>(),
            "stops": stops,
        })
        .to_string()
    }

    /// Plays the scene; after each cycle K1 is checked exactly. Also returns how often an object was pulled back.
    pub(crate) fn play(&self) -> (World, Vec<Event>, usize) {
        let mut world = self.world();
        let (mut events, mut retreats) = (Vec::new(), 0);
        for _ in 0..self.cycles {
            self.give(&mut world);
            events.extend_from_slice(world.step());
            retreats += world.activity().retreats;
            assert_eq!(world.overlaps(), [], "after cycle {}", world.cycle());
        }
        (world, events, retreats)
    }

    /// Objects at random places and orders at random times in a box with some walls.
    pub(crate) fn random(random: &mut Random) -> Self {
        let stops = if random.chance(0.5) { Stops::Both } else { Stops::Approaching };
        let size = random.between(6.0, 30.0);
        let mut scene = Self::boxed(size, stops).cycles(1 + random.below(10));
        // On a coarse lattice of places and speeds, ties and exact touches are common.
        let lattice = random.chance(0.4).then_some(0.5);
        for _ in 0..random.below(5) {
            let (a, b) = (scene.place(random, lattice), scene.place(random, lattice));
            if a != b {
                scene = scene.wall(a.into(), b.into());
            }
        }
        let fast = random.chance(0.2);
        let several_layers = random.chance(0.2);
        for id in 0..4 + random.below(40) {
            let radius = if lattice.is_some() { 0.5 } else { random.between(0.1, 0.8) };
            let layers = if several_layers { 1 + random.below(3) } else { 1 };
            let center = scene.place(random, lattice);
            let mut world = scene.world();
            if world.insert(ObjectId(id), Circle::new(center, radius), Layers(layers)).is_ok() {
                scene.objects.push((id, center, radius, layers));
            }
        }
        let ids: Vec<u32> = scene.objects.iter().map(|object| object.0).collect();
        for _ in 0..if ids.is_empty() {
            0
        } else {
            random.below(3 * u32::try_from(ids.len()).expect("few ids") + 1)
        } {
            let id = random.pick(&ids);
            scene.orders.push(scene.random_order(random, id, (lattice, fast)));
        }
        scene.orders.sort_by_key(|order| order.cycle);
        scene
    }

    /// Columns of circles that touch and march in step in one direction, some of them a little slower.
    pub(crate) fn columns(random: &mut Random) -> Self {
        let stops = if random.chance(0.5) { Stops::Both } else { Stops::Approaching };
        let mut scene = Self::boxed(1000.0, stops).cycles(20);
        let radius = random.between(0.2, 0.9);
        let corner = DVec2::new(random.between(200.0, 300.0), random.between(200.0, 300.0));
        let way = DVec2::new(random.between(-1.0, 1.0), random.between(-1.0, 1.0)) * 100.0;
        let speed = random.between(0.1, 5.0);
        for id in 0..30 {
            let (column, row) = (id % 5, id / 5);
            let center = corner + DVec2::new(f64::from(column), f64::from(row)) * (2.0 * radius);
            let mut world = scene.world();
            if world.insert(ObjectId(id), Circle::new(center, radius), Layers::GROUND).is_ok() {
                scene.objects.push((id, center, radius, 1));
                let speed = if random.chance(0.1) { speed * 0.999 } else { speed };
                scene = scene.go(0, id, (center + way).into(), speed);
            }
        }
        scene
    }

    /// Circles that touch a slanted wall to the last bit and slide along it.
    pub(crate) fn sliding(random: &mut Random) -> Self {
        let stops = if random.chance(0.5) { Stops::Both } else { Stops::Approaching };
        let mut scene = Self::boxed(1000.0, stops).cycles(20);
        let from = DVec2::new(random.between(300.0, 400.0), random.between(300.0, 400.0));
        let way = DVec2::new(random.between(-1.0, 1.0), random.between(-1.0, 1.0)) * 200.0;
        scene = scene.wall(from.into(), (from + way).into());
        let (along, normal) = (way / way.length(), DVec2::new(-way.y, way.x) / way.length());
        for id in 0..12 {
            let radius = random.between(0.2, 0.9);
            let side = if random.chance(0.5) { 1.0 } else { -1.0 };
            let mut center = from + way * (f64::from(id) / 12.0) + normal * (side * radius);
            // The last bits away from the wall, until it no longer overlaps.
            let mut world = scene.world();
            let insert = |world: &mut World, center| {
                world.insert(ObjectId(id), Circle::new(center, radius), Layers::GROUND)
            };
            while let Err(InsertError::OverlapsWall { .. }) = insert(&mut world, center) {
                center += normal * (side * 1e-14 * random.between(0.0, 8.0));
            }
            if world.len() == scene.objects.len() {
                continue; // On a short wall, another object is in the way.
            }
            scene.objects.push((id, center, radius, 1));
            let goal = center + along * random.between(1.0, 10.0);
            scene = scene.go(0, id, goal.into(), random.between(0.1, 2.0));
        }
        scene
    }

    /// A hexagonal packing with hardly a gap, everyone ordered to the middle, again and again.
    pub(crate) fn crowd(random: &mut Random) -> Self {
        let stops = if random.chance(0.5) { Stops::Both } else { Stops::Approaching };
        let mut scene = Self::boxed(40.0, stops).cycles(6);
        let pitch = 1.0 + 1e-9 * random.unit();
        for id in 0..60 {
            let (column, row) = (f64::from(id % 8), f64::from(id / 8));
            let center = DVec2::new(
                15.0 + pitch * (column + 0.5 * (row % 2.0)),
                15.0 + pitch * row * 0.8660254037844388,
            );
            scene = scene.object(id, center.into(), 0.5);
            for cycle in 0..6 {
                let goal = (random.between(17.0, 21.0), random.between(16.0, 20.0));
                scene = scene.go(cycle, id, goal, random.between(0.01, 20.0));
            }
        }
        scene
    }

    fn place(&self, random: &mut Random, lattice: Option<f64>) -> DVec2 {
        let size = self.walls[1].segment.end.x;
        let place = DVec2::new(random.between(0.0, size), random.between(0.0, size));
        lattice.map_or(place, |step| (place / step).floor() * step)
    }

    fn random_order(&self, random: &mut Random, id: u32, (lattice, fast): (Option<f64>, bool)) -> Order {
        let cycle = random.below(self.cycles);
        let legs = if random.chance(0.08) { 0 } else { 1 + random.below(3) };
        let speed = |random: &mut Random| {
            let speed = if fast { random.between(1.0, 60.0) } else { random.between(0.05, 3.0) };
            if lattice.is_some() { speed.ceil() } else { speed }
        };
        let legs = (0..legs).map(|_| (self.place(random, lattice), speed(random))).collect::<Vec<_>>();
        let start = random.chance(0.3).then(|| {
            let fraction = if lattice.is_some() { 0.5 } else { random.unit() };
            (cycle + random.below(3), fraction)
        });
        Order { cycle, id, queue: !legs.is_empty() && random.chance(0.4), legs, start }
    }
}

/// The events of a scene, one a line.
pub(crate) fn listed(events: &[Event]) -> String {
    events.iter().fold(String::new(), |mut text, event| {
        let other = event.other.map_or_else(|| "-".to_owned(), |other| other.to_string());
        let _ = writeln!(text, "{} {:?} {} {:?} {other}", event.cycle, event.time, event.object, event.kind);
        text
    })
}
