//! Workers that gather: each goes to and fro in a berth of its own.

use std::collections::BTreeMap;
use std::sync::Arc;

use glam::DVec2;
use maniple_geometry::Cycle;
use maniple_pathfinding::Ground;
use maniple_view::{Command, Handle};

use super::berths::{Berth, berths};
use crate::keyed::{Purpose, keyed};
use crate::moving::{around, straight_on};
use crate::post::Post;
use crate::seeing::{Item, Scene};

/// Hull to hull, in world units: so near a worker gathers and delivers.
const REACH: f64 = 1.0 / 16.0;

/// Most cycles that a worker waits after it was stopped, so that two do not go on at once.
const WAIT_MAX: u64 = 4;

/// Cycles between two times at which berths are looked for: where there are more workers than places it is in vain.
const LOOK_EVERY: u32 = 8;

/// How often in a row a worker is stopped before it takes another berth.
const STOPS_MAX: u32 = 12;

/// All workers that gather.
#[derive(Clone, Debug)]
pub(crate) struct Miners {
    seed: u64,
    berths: BTreeMap<Handle, Berth>,
    stops: BTreeMap<Handle, Stops>,
}

/// How often in a row a worker was stopped, and until when it waits.
#[derive(Clone, Copy, Debug, Default)]
struct Stops {
    count: u32,
    wait_until: u32,
}

impl Miners {
    pub(crate) fn new(seed: u64) -> Self {
        Self { seed, berths: BTreeMap::new(), stops: BTreeMap::new() }
    }

    /// Returns the commands of a cycle to workers that shall gather.
    pub(crate) fn work(
        &mut self,
        post: &mut Post,
        cycle: Cycle,
        scene: &Scene<'_>,
        workers: &[&Item<'_>],
    ) -> Vec<Command> {
        let is_worker = |object: &Handle| workers.iter().any(|worker| worker.object == *object);
        let is_there = |object: Handle| scene.patches().any(|patch| patch.object == object);
        let has_store = |object: Handle| scene.stores().any(|store| store.object == object);
        self.berths
            .retain(|worker, berth| is_worker(worker) && is_there(berth.patch) && has_store(berth.store));
        self.stops.retain(|worker, _| is_worker(worker));
        let Some(radius) = workers.first().map(|worker| worker.kind.shape.radius()) else {
            return Vec::new();
        };
        let Some(ground) = post.roads.ground(radius) else { return Vec::new() };
        if cycle.0.is_multiple_of(LOOK_EVERY) {
            self.share_out(&ground, scene, workers);
        }
        let mut commands = Vec::new();
        for &worker in workers {
            let command = self.next((post, &ground), cycle, scene, worker);
            commands.extend(command.and_then(|command| post.orders.give(worker, command)));
        }
        commands
    }

    /// Returns the ways of the workers, as their two ends.
    pub(crate) fn lanes(&self) -> Vec<(DVec2, DVec2)> {
        self.berths.values().map(|berth| (berth.place, berth.dock)).collect()
    }

    /// Gives a berth to each worker that has none: the shortest to the one that is nearest.
    fn share_out(&mut self, ground: &Arc<Ground>, scene: &Scene<'_>, workers: &[&Item<'_>]) {
        let mut idle: Vec<&Item<'_>> =
            workers.iter().copied().filter(|worker| !self.berths.contains_key(&worker.object)).collect();
        if idle.is_empty() {
            return;
        }
        let patches: Vec<&Item<'_>> = scene.patches().collect();
        let stores: Vec<&Item<'_>> = scene.stores().collect();
        let taken: Vec<Berth> = self.berths.values().copied().collect();
        for berth in berths(ground, &patches, &stores, &taken) {
            let distance = |worker: &&Item<'_>| worker.center.distance_squared(berth.place);
            let nearest = (0..idle.len()).min_by(|&a, &b| distance(&idle[a]).total_cmp(&distance(&idle[b])));
            let Some(nearest) = nearest else { break };
            self.berths.insert(idle.remove(nearest).object, berth);
        }
    }

    /// Returns what a worker does next; `None`: what it does.
    fn next(
        &mut self,
        (post, ground): (&Post, &Ground),
        cycle: Cycle,
        scene: &Scene<'_>,
        worker: &Item<'_>,
    ) -> Option<Command> {
        let object = worker.object;
        let harvest = worker.kind.harvest?;
        let berth = self.berths.get(&object).copied();
        let is_full = worker.load() >= harvest.load_max || (berth.is_none() && worker.load() > 0);
        let (goal, beside, command) = match (berth, is_full) {
            (Some(berth), false) => {
                let patch = scene.others.iter().find(|patch| patch.object == berth.patch)?;
                (berth.place, patch, Command::Gather { object, patch: berth.patch })
            }
            (Some(berth), true) => (berth.dock, scene.own(berth.store)?, Command::ReturnLoad { object }),
            (None, true) => {
                let store = crate::seeing::nearest(scene.stores(), worker.center)?;
                (store.center, store, Command::ReturnLoad { object })
            }
            (None, false) => return None,
        };
        if worker.has_task() {
            return None;
        }
        // The last step is left to the task: it begins in the cycle in which the worker arrives.
        let is_beside = worker.distance(beside) <= REACH || worker.center.distance(goal) <= worker.kind.speed;
        if is_beside {
            self.stops.remove(&object);
            return Some(command);
        }
        let is_on_its_way = worker.seen.base.is_moving() && post.orders.goal(worker) == Some(goal);
        if is_on_its_way { None } else { self.go((ground, cycle), scene, worker, goal) }
    }

    /// Sends a worker that rests on its way; where somebody is in it, around or after a while.
    fn go(
        &mut self,
        (ground, cycle): (&Ground, Cycle),
        scene: &Scene<'_>,
        worker: &Item<'_>,
        goal: DVec2,
    ) -> Option<Command> {
        let object = worker.object;
        let stops = self.stops.entry(object).or_default();
        if cycle.0 < stops.wait_until {
            return None;
        }
        let wait = u32::try_from(keyed(self.seed, cycle.0, object.0, Purpose::Wait) % WAIT_MAX).unwrap_or(0);
        stops.count += 1;
        stops.wait_until = cycle.0 + 1 + wait;
        if stops.count > STOPS_MAX {
            *stops = Stops::default();
            self.berths.remove(&object);
            return None;
        }
        let goes_on = stops.count.is_multiple_of(4);
        let legs = around(ground, scene, worker, goal)
            .or_else(|| if goes_on { straight_on(ground, worker, goal) } else { None })?;
        let points = legs.iter().map(|leg| (leg.x, leg.y, None)).collect();
        Some(Command::Path { object, points, start: None })
    }
}
