//! One step for all: who goes first takes a place, and pushes away who is there.

use crate::in_step::board::{Board, Place};
use crate::in_step::distances::Distances;
use crate::in_step::keyed::keyed;

/// No agent.
pub(crate) const NOBODY: u32 = u32::MAX;

/// Most places that an agent can choose from: four neighbours, and to stay.
const CHOICES_MAX: usize = 5;

/// Who is in a place before the step, and who after it.
#[derive(Clone, Copy, Debug)]
struct Slot {
    before: u32,
    after: u32,
}

const EMPTY: Slot = Slot { before: NOBODY, after: NOBODY };

/// Whether agents may all follow each other around a ring in one step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Rings {
    /// They may, as all begin at the same moment.
    Allowed,
    /// They may not: somebody always leaves for a place that nobody has to leave first, so that steps can be walked one after the
    /// other, each when those before it have been seen.
    Avoided,
}

/// What a step is made from.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Scene<'a> {
    pub(crate) board: &'a Board,
    pub(crate) distances: &'a Distances,
    /// Where the agents are.
    pub(crate) now: &'a [Place],
    /// Decides ties, together with the agent.
    pub(crate) seed: u64,
    /// The number of the step; decides ties, too.
    pub(crate) step: u64,
}

impl Scene<'_> {
    /// How far the goal of an agent is from a place.
    pub(crate) fn distance(&self, agent: u32, place: Place) -> u32 {
        self.distances.of(agent as usize)[place.index()]
    }

    /// Where an agent is.
    pub(crate) fn at(&self, agent: u32) -> Place {
        self.now[agent as usize]
    }
}

/// An agent that looks for a place, while those whom it pushes look for theirs.
#[derive(Clone, Copy, Debug)]
struct Chooser {
    agent: u32,
    /// The places, best first.
    choices: [Place; CHOICES_MAX],
    count: usize,
    tried: usize,
    /// Who follows into the place that this one leaves, so that the two get past each other; or [`NOBODY`].
    partner: u32,
}

/// What became of a choice.
enum Choice {
    /// The place is free.
    Taken,
    /// Somebody is there who has not chosen yet.
    Pushes(u32),
    /// No place is left.
    Exhausted,
}

/// Makes one step for all agents, by priority inheritance with backtracking (Okumura, Machida, Défago and Tamura, *Priority
/// Inheritance with Backtracking for Iterative Multi-agent Path Finding*, 2022, algorithm 1), with the swap of Okumura, *Improving
/// LaCAM for Scalable Eventually Optimal Multi-Agent Pathfinding*, 2023. Keeps its memory.
#[derive(Clone, Debug)]
pub(crate) struct Generator {
    rings: Rings,
    slots: Vec<Slot>,
    /// Where the agents go; [`Place::NOWHERE`] while that is open.
    next: Vec<Place>,
    choosers: Vec<Chooser>,
}

impl Generator {
    pub(crate) fn new(board: &Board, agents: usize, rings: Rings) -> Self {
        let (slots, next) = (vec![EMPTY; board.len()], vec![Place::NOWHERE; agents]);
        Self { rings, slots, next, choosers: Vec::new() }
    }

    /// Begins a step.
    pub(crate) fn begin(&mut self, scene: &Scene<'_>) {
        for (agent, place) in (0..).zip(scene.now) {
            self.slots[place.index()].before = agent;
        }
    }

    /// Lets an agent go to a place before all choose. Returns whether nobody is in its way.
    pub(crate) fn fix(&mut self, scene: &Scene<'_>, agent: u32, place: Place) -> bool {
        let is_fit = self.fits(scene, agent, place);
        if is_fit {
            self.take(agent, place);
        }
        is_fit
    }

    /// Lets an agent choose, and whoever it pushes. Returns whether it found a place; else it stays where it is, which is well for
    /// all who chose after any fixed ones, but not if one of those is to come to that place.
    pub(crate) fn choose(&mut self, scene: &Scene<'_>, agent: u32) -> bool {
        if self.next[agent as usize] != Place::NOWHERE {
            return true;
        }
        self.choosers.clear();
        let first = self.chooser(scene, agent);
        self.choosers.push(first);
        loop {
            match self.try_next(scene) {
                Choice::Taken => {
                    while let Some(chooser) = self.choosers.pop() {
                        self.pull(scene, &chooser);
                    }
                    return true;
                }
                Choice::Pushes(other) => {
                    let pushed = self.chooser(scene, other);
                    self.choosers.push(pushed);
                }
                Choice::Exhausted => {
                    let chooser = self.choosers.pop().expect("somebody was choosing");
                    self.take(chooser.agent, scene.at(chooser.agent));
                    if self.choosers.is_empty() {
                        return false;
                    }
                }
            }
        }
    }

    /// Ends a step: returns where all go, and forgets what they chose.
    ///
    /// # Panics
    /// If somebody has not chosen.
    pub(crate) fn finish(&mut self, now: &[Place]) -> Vec<Place> {
        let next = self.next.clone();
        assert!(!next.contains(&Place::NOWHERE), "everybody has chosen");
        self.reset(now);
        next
    }

    /// Forgets what all chose.
    pub(crate) fn reset(&mut self, now: &[Place]) {
        for (next, now) in self.next.iter_mut().zip(now) {
            if *next != Place::NOWHERE {
                self.slots[next.index()] = EMPTY;
            }
            self.slots[now.index()] = EMPTY;
            *next = Place::NOWHERE;
        }
    }

    /// Returns who is in a place before the step, or [`NOBODY`].
    pub(crate) fn occupant(&self, place: Place) -> u32 {
        self.slots[place.index()].before
    }

    /// Returns whether an agent has chosen.
    pub(crate) fn has_chosen(&self, agent: u32) -> bool {
        self.next[agent as usize] != Place::NOWHERE
    }

    fn take(&mut self, agent: u32, place: Place) {
        self.next[agent as usize] = place;
        self.slots[place.index()].after = agent;
    }

    /// Whether nobody comes to the place, nor from there to where the agent is.
    fn fits(&self, scene: &Scene<'_>, agent: u32, place: Place) -> bool {
        let slot = self.slots[place.index()];
        slot.after == NOBODY
            && (slot.before == NOBODY
                || self.next[slot.before as usize] != scene.at(agent)
                || slot.before == agent)
            && (self.rings == Rings::Allowed || !self.closes_a_ring(scene, agent, place))
    }

    /// Whether who is in a place goes where another is, and so on, up to where the agent is.
    fn closes_a_ring(&self, scene: &Scene<'_>, agent: u32, mut place: Place) -> bool {
        let start = scene.at(agent);
        while place != start {
            let occupant = self.occupant(place);
            if occupant == NOBODY {
                return false;
            }
            let next = self.next[occupant as usize];
            if next == Place::NOWHERE || next == place {
                return false;
            }
            place = next;
            if place == start {
                return true;
            }
        }
        false
    }

    fn try_next(&mut self, scene: &Scene<'_>) -> Choice {
        loop {
            let chooser = self.choosers.last_mut().expect("somebody is choosing");
            if chooser.tried == chooser.count {
                return Choice::Exhausted;
            }
            let (agent, place) = (chooser.agent, chooser.choices[chooser.tried]);
            chooser.tried += 1;
            if !self.fits(scene, agent, place) {
                continue;
            }
            self.take(agent, place);
            let other = self.occupant(place);
            if other == NOBODY || self.has_chosen(other) {
                return Choice::Taken;
            }
            return Choice::Pushes(other);
        }
    }

    /// Lets the partner of a chooser follow into the place that it leaves.
    fn pull(&mut self, scene: &Scene<'_>, chooser: &Chooser) {
        let left = scene.at(chooser.agent);
        let is_first = chooser.tried == 1;
        if is_first
            && chooser.partner != NOBODY
            && !self.has_chosen(chooser.partner)
            && self.slots[left.index()].after == NOBODY
            && (self.rings == Rings::Allowed || !self.closes_a_ring(scene, chooser.partner, left))
        {
            self.take(chooser.partner, left);
        }
    }

    /// The choices of an agent: nearest to the goal first; the other way round where it has to back off for a partner.
    fn chooser(&self, scene: &Scene<'_>, agent: u32) -> Chooser {
        let now = scene.at(agent);
        let around = scene.board.neighbours(now);
        let distances = scene.distances.of(agent as usize);
        let mut ties = keyed(scene.seed, u64::from(agent), scene.step);
        let mut keys = [(u64::MAX, Place::NOWHERE); CHOICES_MAX];
        let count = around.len() + 1;
        for (key, &place) in keys.iter_mut().zip(around.iter().chain(std::iter::once(&now))) {
            *key = (u64::from(distances[place.index()]) << 12 | ties & 0xfff, place);
            ties >>= 12;
        }
        keys[..count].sort_unstable();
        let mut choices = keys.map(|(_, place)| place);
        let partner = self.partner(scene, agent, choices[0]);
        if partner != NOBODY {
            choices[..count].reverse();
        }
        Chooser { agent, choices, count, tried: 0, partner }
    }
}
