//! The events of a block of components, earliest first.

use maniple_geometry::contact::{Mover, Straight, Window, circle_contact, is_advancing, still_contact};
use maniple_geometry::{Piece, Planar, Scalar};

use crate::agenda::Agenda;
use crate::components::Components;
use crate::graph::{Around, Edge, Setting};
use crate::outcome::Outcome;
use crate::room::{component_room, make_room};
use crate::runner::{Halt, Runner, Track};
use crate::settings::Method;
use crate::sphere::straight_reach;
use crate::track::{Stage, add_stages};

/// Who stops in a collision of two objects.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Stops {
    /// Both, if they move.
    #[default]
    Both,
    /// Only who moves towards the contact, so that nobody can be halted by being bumped from behind.
    Approaching,
}

/// What one thread needs to solve blocks of components, one after the other; kept for its memory.
#[derive(Clone, Debug)]
pub(crate) struct Solver<S: Scalar> {
    /// Everybody in the block.
    pub(crate) runners: Vec<Runner<S>>,
    /// The stages of the tracks that turn.
    pub(crate) arena: Vec<Stage<S>>,
    /// Pairs of runners whose spheres intersect.
    pub(crate) edges: Vec<Edge>,
    /// Who collides with something at rest, and why it stops then.
    fixed: Vec<(u32, Halt)>,
    /// When the edges collide, and behind them the fixed.
    agenda: Agenda<S>,
    /// For each runner the edges that it is in, those from one start to the next.
    links: Vec<u32>,
    link_starts: Vec<u32>,
    generation: Vec<u32>,
    pub(crate) halts: Vec<(u32, Halt)>,
    /// Edges of the stopped to those who go on, each with who was stopped.
    loose: Vec<(u32, u32)>,
    /// Runners with something at rest near their way.
    pub(crate) beside: Vec<u32>,
    /// Runners that do not just go straight on: they turn, were stopped, or pulled back.
    pub(crate) touched: Vec<u32>,
    pub(crate) suspects: Vec<u32>,
    pub(crate) failed: Vec<u32>,
    pub(crate) pulled: Vec<u32>,
    /// What became of the runners of all blocks that were solved in this cycle.
    pub(crate) outcome: Outcome<S>,
}

impl<S: Scalar> Solver<S> {
    pub(crate) fn new() -> Self {
        Self {
            runners: Vec::new(),
            arena: Vec::new(),
            edges: Vec::new(),
            fixed: Vec::new(),
            agenda: Agenda::new(),
            links: Vec::new(),
            link_starts: Vec::new(),
            generation: Vec::new(),
            halts: Vec::new(),
            loose: Vec::new(),
            beside: Vec::new(),
            touched: Vec::new(),
            suspects: Vec::new(),
            failed: Vec::new(),
            pulled: Vec::new(),
            outcome: Outcome::new(),
        }
    }

    /// Takes the memory that the components of a world with so many active objects may need.
    pub(crate) fn make_room(&mut self, active: usize) {
        let room = component_room(active);
        make_room(&mut self.runners, 2 * room);
        make_room(&mut self.arena, room);
        make_room(&mut self.edges, 2 * room);
        make_room(&mut self.fixed, room);
        make_room(&mut self.links, 4 * room);
        make_room(&mut self.link_starts, 2 * room);
        make_room(&mut self.generation, room);
        make_room(&mut self.halts, room);
        make_room(&mut self.loose, room);
        make_room(&mut self.beside, room);
        make_room(&mut self.touched, room);
        make_room(&mut self.suspects, room);
        make_room(&mut self.failed, room);
        make_room(&mut self.pulled, room);
        self.agenda.make_room(3 * room);
    }

    /// Stops whoever collides in a block, sees to it that the rounded result overlaps nowhere, and adds what became of
    /// everybody to the outcome.
    pub(crate) fn solve(&mut self, components: &Components<S>, block: usize, setting: &Setting<'_, S>) {
        self.begin(components, block, setting);
        match setting.settings.method {
            Method::Event => self.take_events(setting),
            Method::Stepped { substeps } => self.step_through(substeps, setting),
        }
        if setting.settings.certify {
            self.certify(setting);
        }
        for &index in &self.touched {
            self.outcome.add(&self.runners[index as usize], &self.arena, setting);
        }
    }

    /// Stops whoever collides, earliest first.
    ///
    /// # Panics
    /// Where it takes more generations than [`Solver::generations_max`], which would be a mistake of ours.
    fn take_events(&mut self, setting: &Setting<'_, S>) {
        let mut left = self.generations_max();
        self.generation.clear();
        while let Some(time) = self.agenda.take_first(&mut self.generation) {
            assert!(left > 0, "every generation stops somebody or is done with a hit for good");
            left -= 1;
            self.find_halts(setting.settings.stops, time);
            self.stop_all(time);
            self.predict_anew(time, setting.skin);
            self.generation.clear();
        }
    }

    /// Returns a bound of how many generations a block takes: `n + f + e (2 + s)`, with `n` runners, `f` fixed, `e` edges and
    /// `s` stages in the arena.
    ///
    /// A generation that stops somebody does so for the rest of the cycle: at most `n`. In any other, nobody stops for any of
    /// its hits, and each of these is done with:
    /// - with something at rest: it is never put on the agenda again, so there are at most `f`;
    /// - an edge of which one is halted: it is predicted anew only when the other halts, and then not at all: one an edge;
    /// - an edge of which neither is halted: the hit was found on a piece of each. If one of the pieces has ended, it does not
    ///   come back. If not, nobody moves towards the other there (`v · d > 0`, decided exactly), so `d · w >= 0`, and these two
    ///   pieces have no contact from then on. So there is one for each two pieces that hold at the same time, fewer than the two
    ///   have pieces: 2 if both go straight, 1 and the stages of the other if one does, `s` at most if both turn.
    fn generations_max(&self) -> usize {
        self.runners.len() + self.fixed.len() + self.edges.len() * (2 + self.arena.len())
    }

    /// Bytes on the heap.
    pub(crate) fn bytes(&self) -> usize {
        let words = self.links.capacity() + self.link_starts.capacity() + self.generation.capacity();
        let words = words + self.touched.capacity() + self.beside.capacity() + 2 * self.loose.capacity();
        size_of::<u32>()
            * (words + self.suspects.capacity() + self.failed.capacity() + self.pulled.capacity())
            + size_of::<Runner<S>>() * self.runners.capacity()
            + size_of::<Stage<S>>() * self.arena.capacity()
            + size_of::<Edge>() * self.edges.capacity()
            + size_of::<(u32, Halt)>() * (self.fixed.capacity() + self.halts.capacity())
            + self.agenda.bytes()
            + self.outcome.bytes()
    }

    /// Returns the edges that a runner is in.
    pub(crate) fn links_of(&self, runner: u32) -> &[u32] {
        &self.links[self.link_range(runner)]
    }

    fn link_range(&self, runner: u32) -> std::ops::Range<usize> {
        let place = runner as usize;
        self.link_starts[place] as usize..self.link_starts[place + 1] as usize
    }

    /// Takes over what is known to lie ahead of the runners of a block.
    fn begin(&mut self, components: &Components<S>, block: usize, setting: &Setting<'_, S>) {
        self.arena.clear();
        self.touched.clear();
        self.runners.clear();
        let slot = |&node: &u32| {
            let (band, place) = setting.bands.find(node, 0);
            band.tags[place].slot()
        };
        setting.objects.fetch(components.nodes.group(block).iter().map(slot));
        for &node in components.nodes.group(block) {
            self.add_runner(node, setting);
        }
        let turning = self.touched.len();
        for &runner in components.watched.group(block) {
            self.runners[runner as usize].ends_near = true;
        }
        self.beside.clear();
        self.beside.extend_from_slice(components.beside.group(block));
        let edges = components.edges.group(block);
        self.edges.clear();
        self.edges.extend(edges.iter().map(|edge| edge.0));
        let fixed = components.fixed.group(block);
        self.fixed.clear();
        self.fixed.extend(fixed.iter().map(|hit| (hit.node, hit.halt)));
        let times = edges.iter().map(|edge| edge.1).chain(fixed.iter().map(|hit| hit.time));
        self.agenda.begin(times.chain(std::iter::repeat_n(S::INFINITY, turning)));
        self.link();
        if turning > 0 && !setting.is_stepped() {
            self.predict_turning(setting);
        }
    }

    fn item_of_fixed(&self, place: u32) -> u32 {
        u32::try_from(self.edges.len()).expect("edges are numbered with 32 bits") + place
    }

    fn add_runner(&mut self, node: u32, setting: &Setting<'_, S>) {
        let (band, place) = setting.bands.find(node, 0);
        let (tag, Straight { point, velocity, radius }) = (band.tags[place], band.straights[place]);
        let slot = tag.slot();
        let (track, last_motion) = if tag.turns() {
            let from = self.arena.len();
            add_stages(&setting.objects.plan(slot), setting.cycle, &mut self.arena);
            let place = |length: usize| u32::try_from(length).expect("few stages");
            let last = self.arena[self.arena.len() - 1].motion;
            self.touched.push(place(self.runners.len()));
            (Track::Turning(place(from), place(self.arena.len())), last)
        } else {
            (Track::Straight { point, velocity }, setting.objects.states[slot as usize].motion())
        };
        self.runners.push(Runner {
            slot,
            id: setting.objects.intents[slot as usize].id,
            radius,
            track,
            last: last_motion.position(setting.cycle.next()).flushed(),
            end: S::ONE,
            is_held: false,
            halt: None,
            retreats: 0,
            ends_near: false,
        });
    }

    /// Predicts what the graph leaves to the solver: the collisions of those who turn, who are all that is touched yet.
    fn predict_turning(&mut self, setting: &Setting<'_, S>) {
        let turns = |runner: &Runner<S>| matches!(runner.track, Track::Turning(..));
        for edge in (0u32..).take(self.edges.len()) {
            let (a, b) = self.edges[edge as usize];
            if turns(&self.runners[a as usize]) || turns(&self.runners[b as usize]) {
                self.predict(edge, S::ZERO, setting.skin);
            }
        }
        for place in 0..self.touched.len() {
            let index = self.touched[place];
            let this = self.runners[index as usize];
            let mut around = Around::new(this.slot, this.radius, setting);
            for stage in this.stages(&self.arena).iter().filter(|stage| stage.piece.is_moving()) {
                let piece = &stage.piece;
                let way = piece.position(piece.until) - piece.point;
                let reach = f64::from(straight_reach(way, this.radius, setting.objects.margin));
                around.meet(piece, reach, setting);
            }
            if let Some((time, halt)) = around.first {
                let place = u32::try_from(self.fixed.len()).expect("fewer than runners");
                self.fixed.push((index, halt));
                self.agenda.put(self.item_of_fixed(place), time);
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
        let mut sum = 0;
        for start in link_starts.iter_mut() {
            sum += *start;
            *start = sum;
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

    /// Who stops in a generation, and why; the order of the hits does not matter. Taking all of one time together makes
    /// a tie rule unnecessary.
    fn find_halts(&mut self, stops: Stops, time: S) {
        let Self { generation, halts, runners, arena, fixed, edges, .. } = self;
        halts.clear();
        for &item in generation.iter() {
            match edges.get(item as usize) {
                None => {
                    let (runner, halt) = fixed[item as usize - edges.len()];
                    let this = &runners[runner as usize];
                    if this.halt.is_none() && this.is_moving(time, arena) {
                        halts.push((runner, halt));
                    }
                }
                Some(&(a, b)) => {
                    let (first, second) = (&runners[a as usize], &runners[b as usize]);
                    if is_stopped_by((first, second), stops, time, arena) {
                        halts.push((a, Halt::beside(second.id)));
                    }
                    if is_stopped_by((second, first), stops, time, arena) {
                        halts.push((b, Halt::beside(first.id)));
                    }
                }
            }
        }
    }

    /// Stops those of a generation, each for the reason that comes first, and leaves each of them once in the list.
    pub(crate) fn stop_all(&mut self, time: S) {
        let Self { halts, runners, touched, arena, .. } = self;
        let mut kept = 0;
        for place in 0..halts.len() {
            let (runner, halt) = halts[place];
            let this = &mut runners[runner as usize];
            // Who was stopped before is not in the list, so whoever has a halt has it from this generation.
            if let Some(other) = this.halt {
                this.halt = Some(other.merged(halt));
                continue;
            }
            if matches!(this.track, Track::Straight { .. }) {
                touched.push(runner);
            }
            this.stop(time, halt, arena);
            halts[kept] = (runner, halt);
            kept += 1;
        }
        halts.truncate(kept);
    }

    /// Predicts the next collisions of the stopped with their neighbours, and of pairs whose collision stopped neither.
    fn predict_anew(&mut self, time: S, skin: S) {
        self.find_loose();
        for index in 0..self.loose.len() {
            let (edge, stopped) = self.loose[index];
            let (a, b) = self.edges[edge as usize];
            let other = &self.runners[(a ^ b ^ stopped) as usize];
            if let Track::Straight { point, velocity } = other.track {
                let moving = Straight { point, velocity, radius: other.radius };
                let still = self.runners[stopped as usize].held();
                let next = still_contact(&still, &moving, (time, skin));
                if next < S::INFINITY {
                    self.agenda.put(edge, next);
                }
            } else {
                self.predict(edge, time, skin);
            }
        }
        for index in 0..self.generation.len() {
            let item = self.generation[index];
            if let Some(&(a, b)) = self.edges.get(item as usize)
                && self.runners[a as usize].halt.is_none()
                && self.runners[b as usize].halt.is_none()
            {
                self.predict(item, time, skin);
            }
        }
    }

    /// Takes all edges of those who have just been stopped off the agenda, and lists those to neighbours who go on. Who
    /// does cannot be guessed, so all are written down, and some over again.
    fn find_loose(&mut self) {
        let Self { loose, halts, link_starts, links, edges, runners, agenda, .. } = self;
        let mut count = 0;
        for &(stopped, _) in halts.iter() {
            let range = link_starts[stopped as usize] as usize..link_starts[stopped as usize + 1] as usize;
            if loose.len() < count + range.len() {
                loose.resize(count + range.len(), (0, 0));
            }
            for &edge in &links[range] {
                let (a, b) = edges[edge as usize];
                agenda.take_off(edge);
                loose[count] = (edge, stopped);
                count += usize::from(runners[(a ^ b ^ stopped) as usize].halt.is_none());
            }
        }
        loose.truncate(count);
    }

    /// Puts the first collision of an edge, of whom not both have been stopped, from a time on into the agenda.
    fn predict(&mut self, edge: u32, from: S, skin: S) {
        let (a, b) = self.edges[edge as usize];
        let (first, second) = (&self.runners[a as usize], &self.runners[b as usize]);
        if let Some(time) = first_contact(first, second, (from, skin), &self.arena) {
            self.agenda.put(edge, time);
        }
    }
}

pub(crate) fn is_stopped_by<S: Scalar>(
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
