//! The events of one component, earliest first.

use std::cmp::{Ordering, Reverse};
use std::collections::{BTreeMap, BinaryHeap};

use maniple_geometry::contact::{Mover, Window, circle_contact, is_advancing, segment_contact};
use maniple_geometry::{Cycle, Scalar};

use crate::event::EventKind;
use crate::runner::{Halt, Runner};
use crate::wall::{Wall, WallKind};

/// Who stops in a collision of two objects.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Stops {
    /// Both, if they move.
    #[default]
    Both,
    /// Only who moves towards the contact, so that nobody can be halted by being bumped from behind.
    Approaching,
}

/// What is the same for all components of a cycle.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Setting<'a, S: Scalar> {
    pub(crate) cycle: Cycle,
    pub(crate) walls: &'a [Wall<S>],
    pub(crate) skin: S,
    pub(crate) stops: Stops,
}

/// Objects that may influence each other in a cycle, and who is near whom.
#[derive(Clone, Debug, Default)]
pub(crate) struct Component<S: Scalar> {
    /// Those that move, then those that rest and are near one that moves.
    pub(crate) runners: Vec<Runner<S>>,
    /// Pairs of runners, the first of which moves.
    pub(crate) edges: Vec<(u32, u32)>,
    /// Runners that move and walls near them.
    pub(crate) walls: Vec<(u32, u32)>,
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
    Wall(WallKind),
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

impl<S: Scalar> Component<S> {
    /// Stops whoever collides, at the exact time, and then sees to it that the rounded result overlaps nowhere.
    pub(crate) fn solve(&mut self, setting: &Setting<'_, S>) {
        let neighbours = self.neighbours();
        let mut queue = BinaryHeap::new();
        for &(a, b) in &self.edges {
            queue.extend(self.predict((a, b), S::ZERO, setting.skin).map(Reverse));
        }
        for &(runner, wall) in &self.walls {
            queue.extend(self.predict_wall(runner, &setting.walls[wall as usize], setting.skin).map(Reverse));
        }
        // Every generation stops at least one object for the rest of the cycle or drops a hit between two that
        // have both come to rest, so there are no more than objects and hits.
        while let Some(Reverse(Hit { time, .. })) = queue.peek().copied() {
            let generation = self.take_generation(&mut queue, time);
            let halts = self.halts(&generation, setting.stops, time);
            for (&runner, &halt) in &halts {
                self.runners[runner as usize].stop(time, halt);
            }
            for pair in self.changed_pairs(&generation, &halts, &neighbours) {
                queue.extend(self.predict(pair, time, setting.skin).map(Reverse));
            }
        }
        self.certify(setting, &neighbours);
    }

    /// For each runner the edges that it is in, as places in the list of edges.
    fn neighbours(&self) -> Vec<Vec<u32>> {
        let mut neighbours = vec![Vec::new(); self.runners.len()];
        for (edge, &(a, b)) in (0u32..).zip(&self.edges) {
            neighbours[a as usize].push(edge);
            neighbours[b as usize].push(edge);
        }
        neighbours
    }

    /// All hits of one time that are still valid. Taking them together makes a tie rule unnecessary.
    fn take_generation(&self, queue: &mut BinaryHeap<Reverse<Hit<S>>>, time: S) -> Vec<Hit<S>> {
        let mut generation = Vec::new();
        while let Some(Reverse(hit)) = queue.peek().copied().filter(|Reverse(hit)| hit.time == time) {
            queue.pop();
            let stopped = |runner: u32| self.runners[runner as usize].halt.is_some();
            let now = match hit.target {
                Target::Runner(other) => (stopped(hit.runner), stopped(other)),
                Target::Wall(_) => (stopped(hit.runner), false),
            };
            if hit.stopped == now {
                generation.push(hit);
            }
        }
        generation
    }

    /// Who stops in a generation, and why. By runner, so that the order of the hits does not matter.
    fn halts(&self, generation: &[Hit<S>], stops: Stops, time: S) -> BTreeMap<u32, Halt> {
        let mut halts: BTreeMap<u32, Halt> = BTreeMap::new();
        let mut note = |runner: u32, halt: Halt| {
            halts.entry(runner).and_modify(|noted| *noted = noted.merged(halt)).or_insert(halt);
        };
        for hit in generation {
            match hit.target {
                Target::Wall(kind) => {
                    if self.runners[hit.runner as usize].is_moving(time) {
                        note(hit.runner, Halt { kind: wall_event(kind), other: None });
                    }
                }
                Target::Runner(other) => {
                    for (runner, partner) in [(hit.runner, other), (other, hit.runner)] {
                        if self.is_stopped_by(runner, partner, stops, time) {
                            let other = Some(self.runners[partner as usize].id);
                            note(runner, Halt { kind: EventKind::Object, other });
                        }
                    }
                }
            }
        }
        halts
    }

    fn is_stopped_by(&self, runner: u32, partner: u32, stops: Stops, time: S) -> bool {
        let (runner, partner) = (&self.runners[runner as usize], &self.runners[partner as usize]);
        let is_concerned = match stops {
            Stops::Both => true,
            Stops::Approaching => is_advancing(&runner.live(time), &partner.live(time), time),
        };
        is_concerned && runner.is_moving(time)
    }

    /// The pairs whose next collision has to be predicted anew: those of the stopped, and those whose hit was taken.
    fn changed_pairs(
        &self,
        generation: &[Hit<S>],
        halts: &BTreeMap<u32, Halt>,
        neighbours: &[Vec<u32>],
    ) -> Vec<(u32, u32)> {
        let of_stopped = halts.keys().flat_map(|&runner| &neighbours[runner as usize]);
        let mut pairs: Vec<(u32, u32)> = of_stopped.map(|&edge| self.edges[edge as usize]).collect();
        pairs.extend(generation.iter().filter_map(|hit| match hit.target {
            Target::Runner(other) => Some((hit.runner, other)),
            Target::Wall(_) => None,
        }));
        pairs.sort_unstable();
        pairs.dedup();
        pairs
    }

    /// The first collision of two runners from a time on.
    fn predict(&self, (a, b): (u32, u32), from: S, skin: S) -> Option<Hit<S>> {
        let (first, second) = (&self.runners[a as usize], &self.runners[b as usize]);
        let time = first_contact(first, second, from, skin)?;
        let stopped = (first.halt.is_some(), second.halt.is_some());
        Some(Hit { time, runner: a, target: Target::Runner(b), stopped })
    }

    fn predict_wall(&self, runner: u32, wall: &Wall<S>, skin: S) -> Option<Hit<S>> {
        let this = &self.runners[runner as usize];
        let contact = |piece| {
            let mover = Mover { piece: &piece, radius: this.radius };
            segment_contact(mover, &wall.segment, Window { from: piece.since, to: piece.until, skin })
        };
        let time = this.pieces_from(S::ZERO).find_map(contact)?;
        Some(Hit { time, runner, target: Target::Wall(wall.kind), stopped: (false, false) })
    }
}

/// The first time from `from` on at which two runners collide.
pub(crate) fn first_contact<S: Scalar>(first: &Runner<S>, second: &Runner<S>, from: S, skin: S) -> Option<S> {
    let (mut ones, mut others) = (first.pieces_from(from), second.pieces_from(from));
    let (mut one, mut other) = (ones.next()?, others.next()?);
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

fn wall_event(kind: WallKind) -> EventKind {
    match kind {
        WallKind::Segment => EventKind::Segment,
        WallKind::Edge => EventKind::Edge,
    }
}
