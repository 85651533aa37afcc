//! `maniple simulate`: a kinematic scene, and what becomes of it.

mod scene;

use std::collections::VecDeque;

use anyhow::{Context, bail};
use maniple_geometry::{Circle, ObjectId};
use maniple_kinematics::{Event, EventKind, Layers, Leg, Placement, World};
use maniple_view::Digest;
use serde::Serialize;

use crate::arguments::Simulate;
use crate::commands::simulate::scene::{Move, Scene};
use crate::failure::Failure;
use crate::files;
use crate::output::{Format, print};

/// Cycles that a scene without `--cycles` may take to come to rest: 2^20, 36 hours at 8 cycles a second.
/// Without a limit one that crawls, or waits for a late move, would run on for as long.
const CYCLES_MAX: u32 = 1 << 20;

/// What became of a scene.
#[derive(Debug, Serialize)]
struct Outcome {
    cycles: u32,
    objects: Vec<Rest>,
    events: Vec<Happening>,
    hash: Digest,
}

/// An object after the last cycle.
#[derive(Debug, Serialize)]
struct Rest {
    id: u32,
    x: f64,
    y: f64,
    moving: bool,
}

/// An event.
#[derive(Debug, Serialize)]
struct Happening {
    cycle: u32,
    time: f64,
    id: u32,
    kind: &'static str,
    other: Option<u32>,
}

impl From<&Event> for Happening {
    fn from(event: &Event) -> Self {
        Self {
            cycle: event.cycle.0,
            time: event.time,
            id: event.object.0,
            kind: match event.kind {
                EventKind::Arrived => "arrived",
                EventKind::Ordered => "ordered",
                EventKind::Object => "object",
                EventKind::Segment => "segment",
                EventKind::Edge => "edge",
            },
            other: event.other.map(|other| other.0),
        }
    }
}

/// Runs `maniple simulate`. The result is JSON in both formats: in lines for people, in one line for programs.
pub(crate) fn run(arguments: &Simulate) -> Result<(), Failure> {
    let text = files::read(&arguments.scene)?;
    let play = || {
        let played = Scene::read(&text).and_then(|scene| play(&scene, arguments.cycles));
        played.with_context(|| arguments.scene.display().to_string()).map_err(Failure::BadInput)
    };
    let outcome = match arguments.threads {
        None => play()?,
        Some(threads) => {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads as usize).build();
            pool.map_err(Failure::failed)?.install(play)?
        }
    };
    print(Format::of(&arguments.json), &outcome, lines)
}

/// JSON with one object or event a line.
fn lines(outcome: &Outcome) -> String {
    fn rows<T: Serialize>(rows: &[T]) -> String {
        let row = |row: &T| serde_json::to_string(row).unwrap_or_default();
        let rows: Vec<String> = rows.iter().map(|item| format!("    {}", row(item))).collect();
        if rows.is_empty() { "[]".to_owned() } else { format!("[\n{}\n  ]", rows.join(",\n")) }
    }
    format!(
        "{{\n  \"cycles\": {},\n  \"objects\": {},\n  \"events\": {},\n  \"hash\": \"{}\"\n}}\n",
        outcome.cycles,
        rows(&outcome.objects),
        rows(&outcome.events),
        outcome.hash
    )
}

fn play(scene: &Scene, cycles: Option<u32>) -> anyhow::Result<Outcome> {
    let mut world = scene.world()?;
    let mut moves: VecDeque<&Move> = scene.moves.iter().collect();
    let mut events = Vec::new();
    let is_over = |world: &World, moves: &VecDeque<&Move>| match cycles {
        Some(cycles) => world.cycle().0 >= cycles,
        None => world.is_at_rest() && moves.is_empty(),
    };
    while !is_over(&world, &moves) {
        if cycles.is_none() && world.cycle().0 == CYCLES_MAX {
            bail!("not all rest after {CYCLES_MAX} cycles; say with --cycles how many to run");
        }
        while let Some(order) = moves.pop_front_if(|order| order.cycle <= world.cycle().0) {
            give(&mut world, order)?;
        }
        events.extend(world.step().iter().map(Happening::from));
    }
    let rest = |id: ObjectId| {
        let center = world.circle(id)?.center;
        Some(Rest { id: id.0, x: center.x, y: center.y, moving: world.motion(id)?.is_moving() })
    };
    Ok(Outcome {
        cycles: world.cycle().0,
        objects: world.ids().into_iter().filter_map(rest).collect(),
        events,
        hash: Digest(world.digest()),
    })
}

fn give(world: &mut World, order: &Move) -> anyhow::Result<()> {
    let id = ObjectId(order.id);
    let start = order.start();
    let placement = if order.queue { Placement::Queue } else { Placement::Replace };
    let given = if order.s == 0.0 {
        world.halt(id, start)
    } else {
        world.go(id, &[Leg { goal: order.goal(), speed: order.s }], placement, start)
    };
    given.with_context(|| format!("the move of object {} in cycle {}", order.id, order.cycle))
}

impl Scene {
    /// Returns the world with the scene's walls and objects.
    fn world(&self) -> anyhow::Result<World> {
        let mut world = World::new(self.limits, self.stops, &self.walls)?;
        for object in &self.objects {
            let circle = Circle::new(glam::DVec2::new(object.x, object.y), object.r);
            let inserted = world.insert(ObjectId(object.id), circle, Layers::GROUND);
            inserted.with_context(|| format!("object {}", object.id))?;
        }
        Ok(world)
    }
}
