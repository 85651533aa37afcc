//! One cycle: spheres, sectors, graph, components, queue; then everyone moves.
//!
//! The order of the steps is that of Buro's lecture *Path Planning Odds and Ends* (CMPUT 350, University of Alberta).

use std::cmp::Reverse;

use maniple_geometry::{Planar, Scalar};
use rayon::prelude::*;

use crate::batch::Frame;
use crate::digest::chained;
use crate::event::Event;
use crate::graph::{Graph, Setting};
use crate::solve::Solver;
use crate::state::{NO_QUEUE, Phase};
use crate::world::{Activity, World};

/// Cycles between two tidyings: objects have gone a few sectors by then.
const TIDY_CYCLES: u32 = 32;

/// With fewer active objects than this, all are near in memory in any order.
const TIDY_ACTIVE_MIN: usize = 4096;

/// The parts of a cycle, in their order.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Part {
    /// Who is woken, and now and then the order of the objects in memory.
    Order,
    /// Motion spheres.
    Spheres,
    /// Sectors.
    Sectors,
    /// The intersection graph, with the collisions that lie ahead.
    Graph,
    /// Its connected components.
    Components,
    /// The collisions of each, earliest first, and the certificate.
    Queue,
    /// What became of everybody, and the order of the events.
    Outcome,
}

impl Part {
    /// All of them.
    pub const ALL: [Self; 7] = [
        Self::Order,
        Self::Spheres,
        Self::Sectors,
        Self::Graph,
        Self::Components,
        Self::Queue,
        Self::Outcome,
    ];
}

impl<S: Scalar> World<S> {
    /// Simulates one cycle and returns what happened in it, by time and id.
    pub fn step(&mut self) -> &[Event] {
        self.step_by_parts(|_| {})
    }

    /// As [`World::step`], and says after each part of the work that it is done, so that a caller who has a clock can see
    /// what a cycle spends its time on.
    pub fn step_by_parts(&mut self, mut done: impl FnMut(Part)) -> &[Event] {
        self.wake();
        self.tidy();
        done(Part::Order);
        self.gather();
        done(Part::Spheres);
        self.fill_sectors();
        done(Part::Sectors);
        self.make_graph();
        done(Part::Graph);
        self.find_components();
        done(Part::Components);
        self.solve();
        done(Part::Queue);
        self.commit();
        self.digest = chained(self.digest, self.cycle, self.objects.sum);
        self.cycle = self.cycle.next();
        done(Part::Outcome);
        &self.events
    }

    /// Takes those who are going to move out of the lists of those at rest.
    fn wake(&mut self) {
        while let Some(&Reverse((cycle, slot))) = self.alarms.peek().filter(|alarm| alarm.0.0 <= self.cycle.0)
        {
            self.alarms.pop();
            let state = &self.objects.states[slot as usize];
            if state.wakes == cycle && state.phase == Phase::Resting {
                self.activate(slot);
            }
        }
        for slot in self.fresh.drain(..) {
            let state = &mut self.objects.states[slot as usize];
            if state.phase == Phase::Fresh {
                self.resting.remove(slot, &self.objects.states);
                self.objects.states[slot as usize].phase = Phase::Active;
            }
        }
    }

    /// Puts those who are active into the order of their sectors now and then, so that who is near in the plane is near
    /// in memory.
    fn tidy(&mut self) {
        let active: usize = self.batches.iter().map(|batch| batch.slots.len()).sum();
        if active < TIDY_ACTIVE_MIN || self.cycle.0 < self.tidy_at {
            return;
        }
        self.tidy_at = self.cycle.0.saturating_add(TIDY_CYCLES);
        let states = &self.objects.states;
        let is_active = |slot: u32| states[slot as usize].phase == Phase::Active;
        let Tidying { homes, from, to } = &mut self.tidying;
        homes.clear();
        homes.extend(0..u32::try_from(states.len()).expect("slots have 32 bits"));
        from.clear();
        let slots = self.bands.all().iter().flat_map(|band| &band.tags).map(|tag| tag.slot());
        from.extend(slots.filter(|&slot| is_active(slot)));
        to.clear();
        to.extend_from_slice(from);
        to.sort_unstable();
        for (&slot, &home) in from.iter().zip(to.iter()) {
            homes[slot as usize] = home;
        }
        self.objects.rearrange(to, homes);
        for batch in &mut self.batches {
            batch.slots.sort_unstable();
        }
    }

    /// Makes the motion spheres; who rests from now on goes back to the lists of those at rest.
    pub(crate) fn gather(&mut self) {
        let threads = self.threads();
        self.share_out(threads);
        let first = self.batches.iter().find_map(|batch| batch.slots.first());
        let anchor =
            first.map_or(glam::DVec2::ZERO, |&slot| self.objects.states[slot as usize].start.to_dvec2());
        self.bands.anchor = anchor;
        let frame = Frame { cycle: self.cycle, anchor, margin: self.objects.margin };
        let objects = &self.objects;
        each(&mut self.batches, |batch| batch.gather(objects, frame));
        for batch in &mut self.batches {
            for slot in batch.vacated.drain(..) {
                self.objects.vacate(slot);
            }
            for slot in batch.settled.drain(..) {
                let state = &mut self.objects.states[slot as usize];
                state.phase = Phase::Resting;
                if self.objects.intents[slot as usize].queue != NO_QUEUE {
                    self.alarms.push(Reverse((state.wakes, slot)));
                }
                self.resting.insert(slot, &self.objects.states);
            }
        }
    }

    /// Puts the motion spheres into sectors, each beside its object, so that no pair has to look for it elsewhere.
    pub(crate) fn fill_sectors(&mut self) {
        let (threads, cycle, objects) = (self.threads(), self.cycle, &self.objects);
        self.bands
            .fill(&mut self.batches, threads, |tag| objects.states[tag.slot() as usize].straight(cycle));
    }

    /// Makes the graph.
    fn make_graph(&mut self) {
        let bands = self.bands.all().len();
        if self.graphs.len() < bands {
            self.graphs.resize_with(bands, Graph::new);
        }
        let mut graphs = std::mem::take(&mut self.graphs);
        let setting = self.setting();
        let numbered = |(band, graph): (usize, &mut Graph<S>)| graph.connect(band, &setting);
        if bands == 1 {
            numbered((0, &mut graphs[0]));
        } else {
            graphs[..bands].par_iter_mut().enumerate().for_each(numbered);
        }
        self.graphs = graphs;
    }

    /// Finds the components of the graph in which something may happen.
    fn find_components(&mut self) {
        let bands = self.bands.all().len();
        let nodes: usize = self.bands.all().iter().map(|band| band.tags.len()).sum();
        self.components.find(nodes, &self.graphs[..bands]);
        self.activity = Activity {
            runners: nodes,
            pairs_tested: self.graphs[..bands].iter().map(|graph| graph.tested).sum(),
            components: self.components.count,
            retreats: 0,
        };
    }

    /// Solves the components; each solver the blocks of a stretch.
    fn solve(&mut self) {
        let blocks = self.components.blocks();
        let solvers = self.threads().min(blocks.len()).max(1);
        if self.solvers.len() < solvers {
            self.solvers.resize_with(solvers, Solver::new);
        }
        let mut crew = std::mem::take(&mut self.solvers);
        for solver in &mut crew[..solvers] {
            solver.make_room(self.activity.runners);
        }
        if solvers == 1 {
            // Components share nothing, so what became of one block can be taken over while its objects are in the cache.
            let solver = &mut crew[0];
            for block in blocks {
                solver.solve(&self.components, block, &self.setting());
                solver.outcome.apply(&mut self.objects, self.cycle);
                solver.outcome.note_applied();
            }
        } else {
            let setting = self.setting();
            let stretch = blocks.len().div_ceil(solvers);
            let work = |(number, solver): (usize, &mut Solver<S>)| {
                for block in blocks.clone().skip(number * stretch).take(stretch) {
                    solver.solve(&self.components, block, &setting);
                }
            };
            crew[..solvers].par_iter_mut().enumerate().for_each(work);
        }
        self.solvers = crew;
    }

    /// Takes over what became of everybody, and puts the events into their order meanwhile.
    fn commit(&mut self) {
        let cycle = self.cycle;
        let threads = self.threads();
        let Self { solvers, objects, events, event_sorter, .. } = self;
        let outcomes: &[Solver<S>] = solvers;
        let mut take_over = || {
            for Solver { outcome, .. } in outcomes {
                outcome.apply(objects, cycle);
            }
        };
        let mut tell = || {
            events.clear();
            for Solver { outcome, .. } in outcomes {
                outcome.tell(events, cycle);
            }
            event_sorter.sort(events);
        };
        if threads == 1 {
            take_over();
            tell();
        } else {
            rayon::join(take_over, tell);
        }
        for solver in solvers {
            self.activity.retreats += solver.outcome.retreats;
            solver.outcome.clear();
        }
    }

    fn setting(&self) -> Setting<'_, S> {
        Setting {
            cycle: self.cycle,
            objects: &self.objects,
            resting: &self.resting,
            walls: &self.walls,
            bands: &self.bands,
            skin: self.skin,
            rounding: self.limits.skin(),
            settings: self.settings,
            is_layered: self.is_layered,
        }
    }
}

/// What a tidying needs; kept for its memory.
#[derive(Clone, Debug, Default)]
pub(crate) struct Tidying {
    homes: Vec<u32>,
    from: Vec<u32>,
    to: Vec<u32>,
}

/// Does something with each of a few items, in as many threads; without any trouble where there is one.
pub(crate) fn each<T: Send>(items: &mut [T], work: impl Fn(&mut T) + Sync + Send) {
    match items {
        [item] => work(item),
        items => items.par_iter_mut().for_each(work),
    }
}
