//! The events of one component, earliest first.

use std::cmp::{Ordering, Reverse};
use std::collections::BinaryHeap;

use maniple_geometry::contact::{Mover, Window, circle_contact, is_advancing};
use maniple_geometry::{Piece, Planar, Scalar};

use crate::components::Components;
use crate::event::EventKind;
use crate::graph::{Around, Edge, Setting};
use crate::outcome::Outcome;
use crate::runner::{Halt, Runner, Track};
use crate::sphere::straight_reach;
use crate::state::Tag;
use crate::track::{Stage, add_stages};

/// Components whose runners are made one right after the other, so that the memory answers all at once.
const COMPONENTS_AT_ONCE: usize = 32;

/// Who stops in a collision of two objects.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Stops {
    /// Both, if they move.
    #[default]
    Both,
    /// Only who moves towards the contact, so that nobody can be halted by being bumped from behind.
    Approaching,
}

/// A collision to come, valid as long as neither partner has been stopped since it was predicted.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Hit<S: Scalar> {
    time: S,
    runner: u32,
    target: Target,
    /// Which of the partners had been stopped when the hit was predicted.
    stopped: (bool, bool),
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Target {
    Runner(u32),
    /// Something at rest: the place in the list of first collisions with such.
    Fixed(u32),
}

impl<S: Scalar> Eq for Hit<S> {}

impl<S: Scalar> PartialOrd for Hit<S> {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl<S: Scalar> Ord for Hit<S> {
    fn cmp(&self, other: &Self) -> Ordering {
        let by_time = self.time.partial_cmp(&other.time).expect("times are numbers");
        by_time.then((self.runner, self.target).cmp(&(other.runner, other.target)))
    }
}

/// What one thread needs to solve components, one after the other; kept for its memory.
#[derive(Clone, Debug)]
pub(crate) struct Solver<S: Scalar> {
    pub(crate) runners: Vec<Runner<S>>,
    /// The runners of some components, as they begin.
    block: Vec<Runner<S>>,
    /// The stages of the tracks that turn.
    pub(crate) arena: Vec<Stage<S>>,
    /// Pairs of runners whose spheres intersect.
    pub(crate) edges: Vec<Edge>,
    /// For each runner the edges that it is in: those from one start to the next.
    links: Vec<u32>,
    link_starts: Vec<u32>,
    fixed: Vec<Halt>,
    queue: BinaryHeap<Reverse<Hit<S>>>,
    generation: Vec<Hit<S>>,
    halts: Vec<(u32, Halt)>,
    changed: Vec<u32>,
    pub(crate) suspects: Vec<u32>,
    pub(crate) failed: Vec<u32>,
    /// What became of the runners of all components that were solved in this cycle.
    pub(crate) outcome: Outcome<S>,
}

impl<S: Scalar> Solver<S> {
    pub(crate) fn new() -> Self {
        Self {
            runners: Vec::new(),
            block: Vec::new(),
            arena: Vec::new(),
            edges: Vec::new(),
            links: Vec::new(),
            link_starts: Vec::new(),
            fixed: Vec::new(),
            queue: BinaryHeap::new(),
            generation: Vec::new(),
            halts: Vec::new(),
            changed: Vec::new(),
            suspects: Vec::new(),
            failed: Vec::new(),
            outcome: Outcome::new(),
        }
    }

    /// Solves some components, one after the other.
    pub(crate) fn solve(
        &mut self,
        components: &Components<S>,
        range: std::ops::Range<usize>,
        setting: &Setting<'_, S>,
    ) {
        for first in range.clone().step_by(COMPONENTS_AT_ONCE) {
            let block = first..range.end.min(first + COMPONENTS_AT_ONCE);
            self.arena.clear();
            self.block.clear();
            for &node in block.clone().flat_map(|component| components.nodes.group(component)) {
                self.add_runner(setting.bands.tag_of(node, 0), setting);
            }
            let mut done = 0;
            for component in block {
                let end = done + components.nodes.group(component).len();
                self.runners.clear();
                self.runners.extend_from_slice(&self.block[done..end]);
                self.solve_component(components, component, setting);
                done = end;
            }
        }
    }

    /// Stops whoever collides in a component, at the exact time, sees to it that the rounded result overlaps nowhere,
    /// and adds what became of everybody to the outcome.
    fn solve_component(&mut self, components: &Components<S>, component: usize, setting: &Setting<'_, S>) {
        self.begin(components, component, setting);
        self.link();
        // Every generation stops at least one object for the rest of the cycle or drops a hit between two that
        // have both come to rest, so there are no more than objects and hits.
        while let Some(Reverse(Hit { time, .. })) = self.queue.peek().copied() {
            self.take_generation(time);
            self.find_halts(setting.stops, time);
            for &(runner, halt) in &self.halts {
                self.runners[runner as usize].stop(time, halt, &self.arena);
            }
            self.find_changed();
            for index in 0..self.changed.len() {
                let edge = self.edges[self.changed[index] as usize];
                self.predict(edge, time, setting.skin);
            }
        }
        self.certify(setting);
        for runner in &self.runners {
            self.outcome.add(runner, &self.arena, setting);
        }
    }

    /// Bytes on the heap.
    pub(crate) fn bytes(&self) -> usize {
        let words = self.links.capacity() + self.link_starts.capacity() + self.changed.capacity();
        size_of::<u32>() * (words + self.suspects.capacity() + self.failed.capacity())
            + size_of::<Runner<S>>() * (self.runners.capacity() + self.block.capacity())
            + size_of::<Stage<S>>() * self.arena.capacity()
            + size_of::<Edge>() * self.edges.capacity()
            + size_of::<Hit<S>>() * (self.queue.capacity() + self.generation.capacity())
            + size_of::<Halt>() * self.fixed.capacity()
            + size_of::<(u32, Halt)>() * self.halts.capacity()
            + self.outcome.bytes()
    }

    /// Returns the edges of a runner, as places in the list of edges.
    pub(crate) fn links_of(&self, runner: u32) -> &[u32] {
        let (from, to) = (self.link_starts[runner as usize], self.link_starts[runner as usize + 1]);
        &self.links[from as usize..to as usize]
    }

    /// Takes over what is known to lie ahead of the runners of a component.
    fn begin(&mut self, components: &Components<S>, component: usize, setting: &Setting<'_, S>) {
        self.fixed.clear();
        self.edges.clear();
        self.edges.extend_from_slice(components.edges.group(component));
        for &((a, b), time) in components.hits.group(component) {
            let hit = Hit { time, runner: a, target: Target::Runner(b), stopped: (false, false) };
            self.queue.push(Reverse(hit));
        }
        for hit in components.fixed.group(component) {
            self.add_fixed(hit.node, hit.time, hit.halt);
        }
        for &runner in components.watched.group(component) {
            self.runners[runner as usize].ends_near = true;
        }
        if !self.arena.is_empty() {
            self.predict_turning(setting);
        }
    }

    fn add_runner(&mut self, tag: Tag, setting: &Setting<'_, S>) {
        let slot = tag.slot();
        let state = &setting.objects.states[slot as usize];
        let (track, last_motion) = if tag.turns() {
            let from = self.arena.len();
            add_stages(&setting.objects.plan(slot), setting.cycle, &mut self.arena);
            let place = |length: usize| u32::try_from(length).expect("few stages");
            (Track::Turning(place(from), place(self.arena.len())), self.arena[self.arena.len() - 1].motion)
        } else {
            let motion = state.motion();
            let point = state.position(setting.cycle);
            (Track::Straight { point, velocity: motion.velocity }, motion)
        };
        self.block.push(Runner {
            slot,
            id: setting.objects.intents[slot as usize].id,
            radius: state.radius,
            layers: setting.objects.layers[slot as usize],
            track,
            last: last_motion.position(setting.cycle.next()).flushed(),
            end: S::ONE,
            is_held: false,
            halt: None,
            retreats: 0,
            ends_near: false,
        });
    }

    fn add_fixed(&mut self, runner: u32, time: S, halt: Halt) {
        let place = u32::try_from(self.fixed.len()).expect("fewer than runners");
        self.fixed.push(halt);
        let target = Target::Fixed(place);
        self.queue.push(Reverse(Hit { time, runner, target, stopped: (false, false) }));
    }

    /// Predicts what the graph leaves to the solver: the collisions of those who turn.
    fn predict_turning(&mut self, setting: &Setting<'_, S>) {
        let turns = |runner: &Runner<S>| matches!(runner.track, Track::Turning(..));
        for index in 0..self.edges.len() {
            let (a, b) = self.edges[index];
            if turns(&self.runners[a as usize]) || turns(&self.runners[b as usize]) {
                self.predict((a, b), S::ZERO, setting.skin);
            }
        }
        for runner in (0u32..).take(self.runners.len()) {
            let this = self.runners[runner as usize];
            if !turns(&this) {
                continue;
            }
            let mut around = Around::new(this.slot, this.radius, setting);
            for stage in this.stages(&self.arena).iter().filter(|stage| stage.piece.is_moving()) {
                let piece = &stage.piece;
                let way = (piece.position(piece.until) - piece.point) * S::ONE;
                let reach = f64::from(straight_reach(way, this.radius, setting.objects.margin));
                around.meet(piece, reach, setting);
            }
            if let Some((time, halt)) = around.first {
                self.add_fixed(runner, time, halt);
            }
        }
    }

    /// Lists for each runner the edges that it is in.
    fn link(&mut self) {
        let Self { edges, links, link_starts, runners, .. } = self;
        link_starts.clear();
        link_starts.resize(runners.len() + 2, 0);
        for &(a, b) in edges.iter() {
            link_starts[a as usize + 2] += 1;
            link_starts[b as usize + 2] += 1;
        }
        for place in 2..link_starts.len() {
            link_starts[place] += link_starts[place - 1];
        }
        links.clear();
        links.resize(2 * edges.len(), 0);
        for (edge, &(a, b)) in (0u32..).zip(edges.iter()) {
            for runner in [a, b] {
                let place = &mut link_starts[runner as usize + 1];
                links[*place as usize] = edge;
                *place += 1;
            }
        }
    }

    /// All hits of one time that are still valid. Taking them together makes a tie rule unnecessary.
    fn take_generation(&mut self, time: S) {
        self.generation.clear();
        while let Some(Reverse(hit)) = self.queue.peek().copied().filter(|Reverse(hit)| hit.time == time) {
            self.queue.pop();
            let stopped = |runner: u32| self.runners[runner as usize].halt.is_some();
            let now = match hit.target {
                Target::Runner(other) => (stopped(hit.runner), stopped(other)),
                Target::Fixed(_) => (stopped(hit.runner), false),
            };
            if hit.stopped == now {
                self.generation.push(hit);
            }
        }
    }

    /// Who stops in a generation, and why; the order of the hits does not matter.
    fn find_halts(&mut self, stops: Stops, time: S) {
        let Self { generation, halts, runners, arena, fixed, .. } = self;
        halts.clear();
        for hit in generation.iter() {
            match hit.target {
                Target::Fixed(place) => {
                    if runners[hit.runner as usize].is_moving(time, arena) {
                        halts.push((hit.runner, fixed[place as usize]));
                    }
                }
                Target::Runner(other) => {
                    for (runner, partner) in [(hit.runner, other), (other, hit.runner)] {
                        let pair = (&runners[runner as usize], &runners[partner as usize]);
                        if is_stopped_by(pair, stops, time, arena) {
                            halts.push((runner, Halt { kind: EventKind::Object, other: Some(pair.1.id) }));
                        }
                    }
                }
            }
        }
        halts.sort_unstable_by_key(|halt| halt.0);
        halts.dedup_by(|next, kept| {
            let same = next.0 == kept.0;
            if same {
                kept.1 = kept.1.merged(next.1);
            }
            same
        });
    }

    /// The edges whose next collision has to be predicted anew: those of the stopped, and those whose hit was taken.
    fn find_changed(&mut self) {
        self.changed.clear();
        for index in 0..self.halts.len() {
            let (from, to) = {
                let runner = self.halts[index].0 as usize;
                (self.link_starts[runner] as usize, self.link_starts[runner + 1] as usize)
            };
            self.changed.extend_from_slice(&self.links[from..to]);
        }
        for index in 0..self.generation.len() {
            let hit = self.generation[index];
            if let Target::Runner(other) = hit.target
                && !self.halts.iter().any(|halt| halt.0 == hit.runner || halt.0 == other)
            {
                let edge = self.links_of(hit.runner).iter().copied().find(|&edge| {
                    let (a, b) = self.edges[edge as usize];
                    (a, b) == (hit.runner, other) || (b, a) == (hit.runner, other)
                });
                self.changed.extend(edge);
            }
        }
        if self.halts.len() > 1 {
            self.changed.sort_unstable();
            self.changed.dedup();
        }
    }

    /// Adds the first collision of two runners from a time on to the queue.
    fn predict(&mut self, (a, b): Edge, from: S, skin: S) {
        let (first, second) = (&self.runners[a as usize], &self.runners[b as usize]);
        if first.halt.is_some() && second.halt.is_some() {
            return;
        }
        if let Some(time) = first_contact(first, second, (from, skin), &self.arena) {
            let stopped = (first.halt.is_some(), second.halt.is_some());
            self.queue.push(Reverse(Hit { time, runner: a, target: Target::Runner(b), stopped }));
        }
    }
}

fn is_stopped_by<S: Scalar>(
    (runner, partner): (&Runner<S>, &Runner<S>),
    stops: Stops,
    time: S,
    arena: &[Stage<S>],
) -> bool {
    let is_concerned = match stops {
        Stops::Both => true,
        Stops::Approaching => is_advancing(&runner.live(time, arena), &partner.live(time, arena), time),
    };
    is_concerned && runner.is_moving(time, arena)
}

/// The first time from `from` on at which two runners collide.
pub(crate) fn first_contact<S: Scalar>(
    first: &Runner<S>,
    second: &Runner<S>,
    (from, skin): (S, S),
    arena: &[Stage<S>],
) -> Option<S> {
    if let (Some(one), Some(other)) = (first.only_piece_from(from), second.only_piece_from(from)) {
        let movers =
            (Mover { piece: &one, radius: first.radius }, Mover { piece: &other, radius: second.radius });
        return circle_contact(movers.0, movers.1, Window { from, to: S::ONE, skin });
    }
    let (mut ones, mut others) = (first.pieces_from(from, arena), second.pieces_from(from, arena));
    let (mut one, mut other): (Piece<S>, Piece<S>) = (ones.next()?, others.next()?);
    loop {
        let window = Window {
            from: from.greater(one.since).greater(other.since),
            to: one.until.lesser(other.until),
            skin,
        };
        if window.from < window.to {
            let movers =
                (Mover { piece: &one, radius: first.radius }, Mover { piece: &other, radius: second.radius });
            let contact = circle_contact(movers.0, movers.1, window);
            if contact.is_some() {
                return contact;
            }
        }
        if one.until <= other.until {
            one = ones.next()?;
        } else {
            other = others.next()?;
        }
    }
}
