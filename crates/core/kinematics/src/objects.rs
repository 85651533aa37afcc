//! The objects of a world by slot, and their slots by id.

use hashbrown::HashTable;
use maniple_geometry::{Cycle, Moment, Motion, ObjectId, Scalar};

use crate::digest::object_hash;
use crate::plan::{Course, Leg, Plan, Planned, Queues};
use crate::sphere::straight_reach;
use crate::state::{Intent, NO_QUEUE, Phase, State};
use crate::wall::Layers;

/// The objects: arrays with one entry a slot.
#[derive(Clone, Debug)]
pub(crate) struct Objects<S: Scalar> {
    pub(crate) states: Vec<State<S>>,
    pub(crate) intents: Vec<Intent<S>>,
    pub(crate) layers: Vec<Layers>,
    pub(crate) queues: Queues<S>,
    /// Slots by id. It is only ever asked for one, so that its order cannot be seen.
    table: HashTable<u32>,
    free: Vec<u32>,
    /// Wrapping sum of the hashes of all objects.
    pub(crate) sum: u64,
    /// By how much motion spheres are larger than needed, for the skin.
    pub(crate) margin: S,
}

impl<S: Scalar> Objects<S> {
    pub(crate) fn new(margin: S) -> Self {
        Self {
            states: Vec::new(),
            intents: Vec::new(),
            layers: Vec::new(),
            queues: Queues::new(),
            table: HashTable::new(),
            free: Vec::new(),
            sum: 0,
            margin,
        }
    }

    pub(crate) fn reserve(&mut self, objects: usize) {
        self.states.reserve_exact(objects);
        self.intents.reserve_exact(objects);
        self.layers.reserve_exact(objects);
        let intents = &self.intents;
        self.table.reserve(objects, |&slot| spread(intents[slot as usize].id));
    }

    /// Puts an object in and returns its slot; its id is not there yet.
    pub(crate) fn insert(&mut self, id: ObjectId, state: State<S>, layers: Layers) -> u32 {
        let leg = Leg { goal: state.start, speed: S::ZERO };
        let intent = Intent { id, queue: NO_QUEUE, leg, hash: 0 };
        let slot = match self.free.pop() {
            Some(slot) => {
                self.states[slot as usize] = state;
                self.intents[slot as usize] = intent;
                self.layers[slot as usize] = layers;
                slot
            }
            None => {
                self.states.push(state);
                self.intents.push(intent);
                self.layers.push(layers);
                u32::try_from(self.states.len() - 1).expect("ids have 32 bits, so slots have")
            }
        };
        let intents = &self.intents;
        self.table.insert_unique(spread(id), slot, |&slot| spread(intents[slot as usize].id));
        self.rehash(slot);
        slot
    }

    /// Takes an object out; its slot is not free before [`Objects::vacate`].
    pub(crate) fn remove(&mut self, slot: u32) {
        let intent = &mut self.intents[slot as usize];
        if let Ok(entry) = self.table.find_entry(spread(intent.id), |&held| held == slot) {
            entry.remove();
        }
        self.sum = self.sum.wrapping_sub(intent.hash);
        intent.hash = 0;
        self.queues.release(intent.queue);
        intent.queue = NO_QUEUE;
    }

    /// Gives the slot of an object that was taken out to others.
    pub(crate) fn vacate(&mut self, slot: u32) {
        self.states[slot as usize].phase = Phase::Vacant;
        self.free.push(slot);
    }

    /// Returns the slot of an object; `None` for an unknown one.
    pub(crate) fn slot(&self, id: ObjectId) -> Option<u32> {
        self.table.find(spread(id), |&slot| self.intents[slot as usize].id == id).copied()
    }

    /// Returns whether there is a layer in which both of two objects are.
    pub(crate) fn share_layer(&self, one: u32, other: u32) -> bool {
        self.layers[one as usize].share(self.layers[other as usize])
    }

    /// Returns what is kept of an object.
    pub(crate) fn of(&self, slot: u32) -> (&State<S>, &Intent<S>) {
        (&self.states[slot as usize], &self.intents[slot as usize])
    }

    /// Returns what an object does and is going to do.
    pub(crate) fn plan(&self, slot: u32) -> Plan<'_, S> {
        let (state, intent) = (&self.states[slot as usize], &self.intents[slot as usize]);
        let course = state.is_moving().then(|| Course::along(intent.leg, state.start));
        Plan { motion: state.motion(), course, queue: self.queues.waiting(intent.queue) }
    }

    /// Lets an object go along a leg with a motion.
    pub(crate) fn set_out(&mut self, slot: u32, motion: &Motion<S>, leg: Leg<S>) {
        let state = &mut self.states[slot as usize];
        state.set_motion(motion);
        state.reach = straight_reach(motion.velocity, state.radius, self.margin);
        state.rested_before = false;
        self.intents[slot as usize].leg = leg;
    }

    /// Lets an object rest.
    pub(crate) fn set_at_rest(&mut self, slot: u32, point: S::Vector, from: Moment) {
        let state = &mut self.states[slot as usize];
        *state = State { phase: state.phase, ..State::at_rest(point, from, state.radius) };
        self.intents[slot as usize].leg = Leg { goal: point, speed: S::ZERO };
    }

    /// Forgets all waiting legs but the first `kept` and appends others.
    pub(crate) fn extend_queue(&mut self, slot: u32, kept: usize, new: impl Iterator<Item = Planned<S>>) {
        let intent = &mut self.intents[slot as usize];
        let mut new = new.peekable();
        if intent.queue != NO_QUEUE || new.peek().is_some() {
            intent.queue = self.queues.extend(intent.queue, kept, new);
        }
    }

    /// Takes the first `count` of the waiting legs out.
    pub(crate) fn consume(&mut self, slot: u32, count: usize) {
        let intent = &mut self.intents[slot as usize];
        intent.queue = self.queues.consume(intent.queue, count);
    }

    /// Lets an object rest that has collided, and forget what waits.
    pub(crate) fn halt(&mut self, slot: u32, point: S::Vector, from: Moment, hash: u64) {
        self.set_at_rest(slot, point, from);
        self.clear_queue(slot);
        self.set_hash(slot, hash);
    }

    /// Forgets what waits.
    pub(crate) fn clear_queue(&mut self, slot: u32) {
        let intent = &mut self.intents[slot as usize];
        self.queues.release(intent.queue);
        intent.queue = NO_QUEUE;
    }

    /// Brings the hash of an object, the sum, and the cycle in which it wakes up to date after a change.
    pub(crate) fn settle(&mut self, slot: u32, now: Cycle) {
        let wakes = self.plan(slot).wakes(now);
        self.states[slot as usize].wakes = wakes;
        self.rehash(slot);
    }

    fn rehash(&mut self, slot: u32) {
        let (state, layers) = (&self.states[slot as usize], self.layers[slot as usize]);
        let hash = object_hash(self.intents[slot as usize].id, (state.radius, layers), &self.plan(slot));
        self.set_hash(slot, hash);
    }

    /// Takes over the hash of an object, and brings the sum up to date.
    pub(crate) fn set_hash(&mut self, slot: u32, hash: u64) {
        let intent = &mut self.intents[slot as usize];
        self.sum = self.sum.wrapping_sub(intent.hash).wrapping_add(hash);
        intent.hash = hash;
    }

    /// Asks for objects, one right after the other, so that the memory answers all at once when they are changed next.
    pub(crate) fn fetch(&self, slots: impl Iterator<Item = u32>) {
        let mut seen = 0;
        for slot in slots {
            seen ^= self.states[slot as usize].wakes ^ self.intents[slot as usize].queue;
        }
        std::hint::black_box(seen);
    }

    /// Returns the ids, sorted.
    pub(crate) fn ids(&self) -> Vec<ObjectId> {
        let mut ids: Vec<ObjectId> = self.slots().map(|slot| self.intents[slot as usize].id).collect();
        ids.sort_unstable();
        ids
    }

    /// Returns the slots of all objects.
    pub(crate) fn slots(&self) -> impl Iterator<Item = u32> + '_ {
        let is_there = |state: &State<S>| !matches!(state.phase, Phase::Vacant | Phase::Leaving);
        (0u32..).zip(&self.states).filter(move |(_, state)| is_there(state)).map(|(slot, _)| slot)
    }

    pub(crate) fn len(&self) -> usize {
        self.table.len()
    }

    /// Moves objects to other slots. `homes` says for each slot where its object goes; those of `moved` go to one of
    /// these slots each, all others stay. Afterwards everybody in `homes` is at home.
    pub(crate) fn rearrange(&mut self, moved: &[u32], homes: &mut [u32]) {
        for slot in self.table.iter_mut() {
            *slot = homes[*slot as usize];
        }
        for &slot in moved {
            let here = slot as usize;
            while homes[here] != slot {
                let home = homes[here] as usize;
                self.states.swap(here, home);
                self.intents.swap(here, home);
                self.layers.swap(here, home);
                homes.swap(here, home);
            }
        }
    }

    /// Bytes on the heap, queued waypoints apart.
    pub(crate) fn bytes(&self) -> usize {
        size_of::<State<S>>() * self.states.capacity()
            + size_of::<Intent<S>>() * self.intents.capacity()
            + size_of::<Layers>() * self.layers.capacity()
            + size_of::<u32>() * self.free.capacity()
            + self.table.allocation_size()
    }
}

/// Spreads ids over the table: the multiplier is 2^64 divided by the golden ratio (Knuth, *The Art of Computer
/// Programming*, vol. 3, §6.4).
fn spread(id: ObjectId) -> u64 {
    u64::from(id.0).wrapping_mul(0x9e37_79b9_7f4a_7c15)
}
