//! One cycle: spheres, sectors, graph, components, queue; then everyone moves.
//!
//! The order of the steps is that of Buro's lecture *Path Planning Odds and Ends* (CMPUT 350, University of Alberta).

use std::collections::BTreeMap;

use maniple_geometry::{Moment, Motion, Piece, Scalar};
use rayon::prelude::*;

use crate::components::components;
use crate::digest::chained;
use crate::event::{Event, EventKind};
use crate::plan::Plan;
use crate::runner::Runner;
use crate::solve::{Component, Setting};
use crate::sphere::MotionSphere;
use crate::track::{Stage, departure, stages};
use crate::world::{Activity, World, number};

impl<S: Scalar> World<S> {
    /// Simulates one cycle and returns what happened in it, by time and id.
    pub fn step(&mut self) -> &[Event] {
        let runners = self.runners();
        let mut components = self.partition(runners);
        let setting = Setting { cycle: self.cycle, walls: &self.walls, skin: self.skin, stops: self.stops };
        components.par_iter_mut().for_each(|(component, _)| component.solve(&setting));

        self.events.clear();
        for (component, movers) in &components {
            for runner in &component.runners[..*movers] {
                self.activity.retreats += runner.retreats as usize;
                self.commit(runner);
            }
        }
        self.events.sort_by(|a, b| a.time.total_cmp(&b.time).then(a.object.cmp(&b.object)));
        self.digest = chained(self.digest, self.cycle, self.sum);
        self.cycle = self.cycle.next();
        &self.events
    }

    /// The objects to which something happens in this cycle if nothing is in their way.
    fn runners(&self) -> Vec<Runner<S>> {
        let runs =
            |stages: &[Stage<S>]| stages.len() > 1 || stages[0].piece.is_moving() || stages[0].consumed > 0;
        let run = |&slot: &usize| {
            let stages = stages(&self.plans[slot], self.cycle);
            let shape = (self.radii[slot], self.layers[slot]);
            runs(&stages).then(|| Runner::new(slot, self.ids[slot], shape, stages))
        };
        self.active.iter().filter_map(run).collect()
    }

    /// Puts the runners, and those at rest near them, into components; each with the number of its runners.
    fn partition(&mut self, runners: Vec<Runner<S>>) -> Vec<(Component<S>, usize)> {
        let graph = self.graph(&runners);
        let (component_of, count) = components(runners.len(), &graph.pairs);
        let mut parts: Vec<(Component<S>, usize)> =
            (0..count).map(|_| (Component { runners: vec![], edges: vec![], walls: vec![] }, 0)).collect();
        let mut place = Vec::with_capacity(runners.len());
        for (runner, &component) in runners.into_iter().zip(&component_of) {
            let (part, movers) = &mut parts[component as usize];
            place.push(number(part.runners.len()));
            part.runners.push(runner);
            *movers += 1;
        }
        for (a, b) in graph.pairs {
            let edges = &mut parts[component_of[a as usize] as usize].0.edges;
            edges.push((place[a as usize], place[b as usize]));
        }
        let mut bystanders: BTreeMap<(u32, u32), u32> = BTreeMap::new();
        for (runner, slot) in graph.beside {
            let component = component_of[runner as usize];
            let part = &mut parts[component as usize].0;
            let at = *bystanders.entry((component, slot)).or_insert_with(|| {
                part.runners.push(self.bystander(slot as usize));
                number(part.runners.len() - 1)
            });
            part.edges.push((place[runner as usize], at));
        }
        for (runner, wall) in graph.walls {
            parts[component_of[runner as usize] as usize].0.walls.push((place[runner as usize], wall));
        }
        self.activity.components = count;
        parts
    }

    /// The motion-sphere intersection graph, from the sectors. Runners are sorted by slot.
    fn graph(&mut self, runners: &[Runner<S>]) -> Graph {
        let margin = self.skin + self.skin;
        let spheres: Vec<MotionSphere<S>> = runners
            .iter()
            .map(|runner| MotionSphere::around(&runner.stages, runner.radius, margin))
            .collect();
        for (place, sphere) in (0u32..).zip(&spheres) {
            self.moving.insert(place, sphere.center, sphere.radius);
        }
        let mut graph = Graph::default();
        self.activity = Activity { runners: runners.len(), ..Activity::default() };
        for (place, (runner, sphere)) in (0u32..).zip(runners.iter().zip(&spheres)) {
            for other in self.moving.near(sphere).into_iter().filter(|&other| other > place) {
                self.activity.pairs_tested += 1;
                let shares = runner.layers.share(runners[other as usize].layers);
                if shares && sphere.intersects(&spheres[other as usize]) {
                    graph.pairs.push((place, other));
                }
            }
            let runs = |slot: u32| runners.binary_search_by_key(&(slot as usize), |other| other.slot).is_ok();
            for slot in self.resting.near(sphere).into_iter().filter(|&slot| !runs(slot)) {
                self.activity.pairs_tested += 1;
                let center = self.position(slot as usize);
                let still = MotionSphere { center, radius: self.radii[slot as usize] };
                if runner.layers.share(self.layers[slot as usize]) && sphere.intersects(&still) {
                    graph.beside.push((place, slot));
                }
            }
            let walls = self.wall_sectors.near(sphere);
            let shares = |wall: &u32| runner.layers.share(self.walls[*wall as usize].layers);
            graph.walls.extend(walls.into_iter().filter(shares).map(|wall| (place, wall)));
        }
        for (place, sphere) in (0u32..).zip(&spheres) {
            self.moving.remove(place, sphere.center, sphere.radius);
        }
        graph
    }

    /// An object at rest that a runner may collide with.
    fn bystander(&self, slot: usize) -> Runner<S> {
        let plan = &self.plans[slot];
        let stage = Stage {
            piece: Piece::at_rest(plan.motion.start, S::ZERO, S::ONE),
            motion: plan.motion,
            course: None,
            consumed: 0,
            opening: None,
        };
        Runner::new(slot, self.ids[slot], (self.radii[slot], self.layers[slot]), vec![stage])
    }

    /// Takes over what became of a runner.
    fn commit(&mut self, runner: &Runner<S>) {
        let slot = runner.slot;
        self.report(runner);
        let before = self.plans[slot].motion;
        let was_resting = !before.is_moving();
        let stage = runner.stage_at(runner.end);
        match (runner.held, runner.halt) {
            (Some(point), Some(_)) => {
                let moment = Moment { cycle: self.cycle, fraction: runner.end.to_f64() };
                self.plans[slot] = Plan::at_rest(point, moment);
            }
            (held, _) => {
                let (motion, course) = match (held, stage.course) {
                    (None, _) => (stage.motion, stage.course),
                    (Some(point), Some(course)) if course.leg.goal != point => {
                        let (motion, course) =
                            departure(point, course.leg, Moment::start_of(self.cycle.next()));
                        (motion, Some(course))
                    }
                    (Some(point), course) => {
                        // Pulled back by so little that the rounded point is the goal: it has arrived.
                        self.events.extend(course.map(|_| Event {
                            cycle: self.cycle,
                            time: runner.end.to_f64(),
                            object: runner.id,
                            kind: EventKind::Arrived,
                            other: None,
                            rests: true,
                        }));
                        let moment = Moment { cycle: self.cycle, fraction: runner.end.to_f64() };
                        (Motion::at_rest(point, moment), None)
                    }
                };
                let plan = &mut self.plans[slot];
                plan.motion = motion;
                plan.course = course;
                plan.queue.drain(..stage.consumed);
            }
        }
        self.settle(slot, was_resting.then_some(before.start));
    }

    /// Brings the books about a slot up to date after its plan changed; `rested_at` is where it rested before.
    fn settle(&mut self, slot: usize, rested_at: Option<S::Vector>) {
        let radius = self.radii[slot];
        let motion = self.plans[slot].motion;
        let rests_at = (!motion.is_moving()).then_some(motion.start);
        if rested_at != rests_at {
            if let Some(point) = rested_at {
                self.resting.remove(number(slot), point, radius);
            }
            if let Some(point) = rests_at {
                self.resting.insert(number(slot), point, radius);
            }
        }
        if self.plans[slot].is_idle() {
            self.active.remove(&slot);
        }
        self.rehash(slot);
    }

    /// Adds what happened to a runner to the events.
    fn report(&mut self, runner: &Runner<S>) {
        let cycle = self.cycle;
        let event = |time: S, kind, other, rests| Event {
            cycle,
            time: time.to_f64(),
            object: runner.id,
            kind,
            other,
            rests,
        };
        for stage in runner.stages.iter().filter(|stage| stage.piece.since <= runner.end) {
            let opening =
                stage.opening.map(|kind| event(stage.piece.since, kind, None, !stage.piece.is_moving()));
            self.events.extend(opening);
        }
        self.events.extend(runner.halt.map(|halt| event(runner.end, halt.kind, halt.other, true)));
    }
}

/// Who is near whom in a cycle. Runners are named by their place among the runners.
#[derive(Debug, Default)]
struct Graph {
    /// Two runners, the smaller place first.
    pairs: Vec<(u32, u32)>,
    /// A runner and the slot of an object at rest.
    beside: Vec<(u32, u32)>,
    /// A runner and the number of a wall.
    walls: Vec<(u32, u32)>,
}
