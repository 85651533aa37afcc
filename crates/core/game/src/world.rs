//! The world of a match: kinematics, and what the scenario adds to it.

mod field;
mod order;
mod part;

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::sync::Arc;

use maniple_geometry::{Cycle, NumberError, ObjectId};
use maniple_kinematics::{self as kinematics, EventKind};
use maniple_tilemap::TileMap;
use maniple_view::{
    COMMANDS_A_CYCLE_MAX, Command, Digest, Objective, Refusal, Rules, Seat, Sighting, Stop, UnitTypeId,
    WAYPOINTS_MAX,
};
use thiserror::Error;
use twox_hash::XxHash3_64;

use crate::load::Loaded;
use crate::placement::StartUnit;
use crate::rules::{Ending, Race, Tally};
use crate::scenario::Scenario;
use crate::vision::{Visible, seen_by_each};
use crate::world::field::{Field, LAYERS};

pub use part::Part;

/// Why a start is not one of a world.
#[derive(Debug, Error)]
pub enum WorldError {
    /// A limit that follows from map and scenario is none.
    #[error("the {name} {problem}; the size of the map and the unit types decide it")]
    Limits {
        /// Which limit.
        name: &'static str,
        /// What is wrong with it.
        problem: NumberError,
    },
    /// A wall of the map.
    #[error("a wall of the map: {0}; move the wall in the map")]
    Wall(kinematics::WallError),
    /// A unit.
    #[error("unit {object}: {problem}; move the spawn, or give the unit type a smaller radius")]
    Unit {
        /// Its number.
        object: ObjectId,
        /// What is wrong with it.
        problem: kinematics::InsertError,
    },
}

/// The world of a match.
///
/// Commands change it between cycles, [`World::step`] goes on by one. Everything that a seat may know comes out of
/// [`World::sightings`] and [`World::died`].
pub struct World {
    map: Arc<TileMap>,
    scenario: Arc<Scenario>,
    kinematics: Field,
    /// By object number; a dead one keeps its place.
    objects: Vec<Object>,
    race: Race,
    /// Who resigned in this cycle; their objects die at its end.
    leaving: Vec<Seat>,
    stops: BTreeMap<ObjectId, Stop>,
    died: Vec<ObjectId>,
    /// Every living object, by number.
    sightings: Vec<Sighting>,
    sight: Sight,
    ending: Option<Ending>,
    /// Wrapping sum of one hash for each living object, arrival, and seat that is out: rest costs nothing.
    sum: u64,
    hash: Digest,
}

#[derive(Clone, Copy, Debug)]
struct Object {
    owner: Seat,
    unit_type: UnitTypeId,
    is_alive: bool,
}

/// What each seat sees, and saw at the start of the last cycle, in ascending order.
enum Sight {
    /// Everything.
    Perfect,
    Fog {
        now: Vec<Vec<ObjectId>>,
        before: Vec<Vec<ObjectId>>,
    },
}

/// What goes into the sum of the state; the number keeps equal fields of different kinds apart.
#[derive(Clone, Copy)]
enum Fact {
    Lives = 1,
    Arrived = 2,
    Out = 3,
}

impl World {
    /// Returns the world at the start of cycle 0.
    ///
    /// # Errors
    /// See [`WorldError`]: a map or scenario beyond what kinematics can work with.
    pub fn new(loaded: &Loaded) -> Result<Self, WorldError> {
        let scenario = &loaded.scenario;
        let kinematics = Field::new(loaded)?;
        let objects: Vec<Object> = loaded.setup.units.iter().map(Object::new).collect();
        let race = Race::new(&loaded.setup.zones, objects.iter().map(|object| object.owner));
        let sight = match scenario.vision {
            None => Sight::Perfect,
            Some(_) => {
                let nothing = vec![Vec::new(); scenario.seats.len()];
                Sight::Fog { now: nothing.clone(), before: nothing }
            }
        };
        let mut world = Self {
            map: Arc::clone(&loaded.map),
            scenario: Arc::clone(scenario),
            kinematics,
            objects,
            race,
            leaving: Vec::new(),
            stops: BTreeMap::new(),
            died: Vec::new(),
            sightings: Vec::new(),
            sight,
            ending: None,
            sum: 0,
            hash: Digest(loaded.map.hash()),
        };
        for (number, object) in (0..).zip(&world.objects) {
            let fact =
                fact(Fact::Lives, number, u32::from(object.owner.0) << 16 | u32::from(object.unit_type.0));
            world.sum = world.sum.wrapping_add(fact);
        }
        world.take_stock();
        if let Sight::Fog { .. } = world.sight {
            world.look();
        }
        world.chain();
        Ok(world)
    }

    /// Applies a command of a seat to an object at the start of the next cycle to be simulated.
    ///
    /// # Errors
    /// Why it was refused; nothing has changed then. An object of another seat is an unknown handle.
    pub fn command(&mut self, seat: Seat, object: ObjectId, command: &Command) -> Result<(), Refusal> {
        if self.is_out(seat) || self.ending.is_some() {
            return Err(Refusal::Out);
        }
        if *command == Command::Resign {
            self.resign(seat);
            return Ok(());
        }
        let owned = self.objects.get(object.0 as usize).filter(|known| known.owner == seat && known.is_alive);
        let known = *owned.ok_or(Refusal::UnknownHandle)?;
        let speed_max = self.scenario.unit_types[usize::from(known.unit_type.0)].speed;
        let ground = order::Ground {
            width: self.map.width(),
            height: self.map.height(),
            limits: *self.kinematics.limits(),
        };
        let order = order::parsed(command, speed_max, &ground)?;
        let taken = match order {
            order::Order::Go { legs, placement, start } => {
                self.kinematics.go(object, &legs, placement, start)
            }
            order::Order::Halt { start } => self.kinematics.halt(object, start),
        };
        taken.map_err(order::refusal)
    }

    /// Takes a seat out of the match; its objects die at the end of the next cycle to be simulated. Does nothing if
    /// it is out already, or the match has ended.
    pub fn resign(&mut self, seat: Seat) {
        if self.is_out(seat) || self.ending.is_some() {
            return;
        }
        self.race.handle_out(seat);
        self.leaving.push(seat);
        self.sum = self.sum.wrapping_add(fact(Fact::Out, u32::from(seat.0), self.kinematics.cycle().0));
    }

    /// Simulates one cycle.
    ///
    /// # Panics
    /// After the match has ended.
    pub fn step(&mut self) {
        self.step_by_parts(|_| {});
    }

    /// As [`World::step`], and says after each part of the work that it is done, so that a caller who has a clock can see
    /// what a cycle spends its time on.
    pub fn step_by_parts(&mut self, mut done: impl FnMut(Part)) {
        assert!(self.ending.is_none(), "a match that has ended goes on no more");
        let played = self.kinematics.cycle();
        self.stops.clear();
        for event in self.kinematics.step_by_parts(|part| done(Part::Kinematics(part))) {
            if event.rests {
                self.stops.insert(event.object, stop(event));
            }
        }
        assert_eq!(self.kinematics.cycle(), played.next(), "a step is one cycle");
        self.count_arrivals(played);
        self.bury();
        self.ending = self.race.ending(self.kinematics.cycle(), self.scenario.cycles_max);
        self.chain();
        done(Part::Rules);
        self.take_stock();
        done(Part::Sightings);
        if let Sight::Fog { .. } = self.sight {
            self.look();
            done(Part::Vision);
        }
    }

    /// Returns the cycle at whose start the world is; the next to be simulated.
    #[must_use]
    pub fn cycle(&self) -> Cycle {
        self.kinematics.cycle()
    }

    /// Returns all that a seat sees at the start of the present cycle, by object number.
    #[must_use]
    pub fn sightings(&self, seat: Seat) -> Cow<'_, [Sighting]> {
        match &self.sight {
            Sight::Perfect => Cow::Borrowed(&self.sightings),
            Sight::Fog { now, .. } => {
                let place = |object| self.sightings.binary_search_by_key(object, |sighting| sighting.object);
                let sighting = |object| self.sightings[place(object).expect("who is seen is alive")];
                now[seat.index()].iter().map(sighting).collect()
            }
        }
    }

    /// Returns the objects that died in the last cycle and that the seat saw at its start, by object number.
    #[must_use]
    pub fn died(&self, seat: Seat) -> Vec<ObjectId> {
        match &self.sight {
            Sight::Perfect => self.died.clone(),
            Sight::Fog { before, .. } => {
                let before = &before[seat.index()];
                self.died.iter().filter(|object| before.binary_search(object).is_ok()).copied().collect()
            }
        }
    }

    /// Returns whether a seat has resigned or was forfeited.
    #[must_use]
    pub fn is_out(&self, seat: Seat) -> bool {
        self.race.tallies()[seat.index()].is_out
    }

    /// Returns how the match has ended; `None` while it goes on.
    #[must_use]
    pub fn ending(&self) -> Option<Ending> {
        self.ending
    }

    /// Returns what each seat has achieved so far, in order of the seats.
    #[must_use]
    pub fn tallies(&self) -> &[Tally] {
        self.race.tallies()
    }

    /// Returns the state hash: the xxh3-64 of the hash before, the cycle, the digest of kinematics and the sum of
    /// the game's own state, little-endian; the first one is chained to the hash of the map.
    #[must_use]
    pub fn hash(&self) -> Digest {
        self.hash
    }

    /// Returns the rules of the match; `players` are the names, in order of the seats.
    #[must_use]
    pub fn rules(&self, players: Vec<String>) -> Rules {
        Rules {
            scenario: self.scenario.name.clone(),
            cycles_max: self.scenario.cycles_max.0,
            players,
            unit_types: self.scenario.unit_types.clone(),
            stops: self.scenario.stops,
            skin: self.kinematics.skin(),
            waypoints_max: count(WAYPOINTS_MAX),
            commands_a_cycle_max: count(COMMANDS_A_CYCLE_MAX),
            objective: Objective::Race { zones: self.race.zones().to_vec() },
            fog: self.scenario.vision.is_some(),
            positions: self.scenario.profile.positions,
        }
    }

    /// Returns the skin that follows from the limits of the world, in world units, whatever skin was asked for: what
    /// rounding can do is a fixed part of it.
    #[must_use]
    pub fn skin_of_limits(&self) -> f64 {
        self.kinematics.skin_of_limits()
    }

    fn alive(&self) -> impl Iterator<Item = (ObjectId, &Object)> {
        (0..).map(ObjectId).zip(&self.objects).filter(|(_, object)| object.is_alive)
    }

    fn sighting(&self, object: ObjectId) -> Sighting {
        let known = &self.objects[object.0 as usize];
        let (base, waypoints) = self.kinematics.base(object);
        Sighting {
            object,
            unit_type: known.unit_type,
            owner: known.owner,
            layers: LAYERS.0,
            base,
            stop: self.stops.get(&object).copied(),
            queued: count(waypoints),
        }
    }

    fn count_arrivals(&mut self, played: Cycle) {
        for (object, known) in (0..).map(ObjectId).zip(&self.objects) {
            if !known.is_alive || self.race.has_arrived(object) {
                continue;
            }
            let center = self.kinematics.center(object);
            if self.race.handle_position(played, object, known.owner, center) {
                self.sum = self.sum.wrapping_add(fact(Fact::Arrived, object.0, played.0));
            }
        }
    }

    /// Lets the objects of those who leave die.
    fn bury(&mut self) {
        self.died.clear();
        if self.leaving.is_empty() {
            return;
        }
        for (number, object) in (0..).zip(&mut self.objects) {
            if !object.is_alive || !self.leaving.contains(&object.owner) {
                continue;
            }
            object.is_alive = false;
            let lived = u32::from(object.owner.0) << 16 | u32::from(object.unit_type.0);
            self.sum = self.sum.wrapping_sub(fact(Fact::Lives, number, lived));
            self.kinematics.remove(ObjectId(number));
            self.died.push(ObjectId(number));
        }
        self.leaving.clear();
    }

    /// Takes stock of who is where.
    fn take_stock(&mut self) {
        let mut sightings = std::mem::take(&mut self.sightings);
        sightings.clear();
        sightings.extend(self.alive().map(|(object, _)| self.sighting(object)));
        self.sightings = sightings;
    }

    /// Takes stock of who sees whom, under fog.
    fn look(&mut self) {
        let objects: Vec<Visible> = self
            .alive()
            .map(|(object, known)| {
                let unit_type = &self.scenario.unit_types[usize::from(known.unit_type.0)];
                Visible {
                    object,
                    owner: known.owner,
                    center: self.kinematics.center(object),
                    radius: unit_type.radius,
                    sight: unit_type.sight,
                }
            })
            .collect();
        let seen = seen_by_each(self.scenario.seats.len(), &objects);
        if let Sight::Fog { now, before } = &mut self.sight {
            *before = std::mem::replace(now, seen);
        }
    }

    fn chain(&mut self) {
        let mut bytes = [0; 28];
        bytes[..8].copy_from_slice(&self.hash.0.to_le_bytes());
        bytes[8..12].copy_from_slice(&self.kinematics.cycle().0.to_le_bytes());
        bytes[12..20].copy_from_slice(&self.kinematics.digest().to_le_bytes());
        bytes[20..].copy_from_slice(&self.sum.to_le_bytes());
        self.hash = Digest(XxHash3_64::oneshot(&bytes));
    }
}

impl Object {
    fn new(unit: &StartUnit) -> Self {
        Self { owner: unit.seat, unit_type: unit.unit_type, is_alive: true }
    }
}

fn stop(event: &kinematics::Event) -> Stop {
    match event.kind {
        EventKind::Arrived => Stop::Arrived,
        EventKind::Ordered => Stop::Ordered,
        EventKind::Object => Stop::Object(event.other.expect("a collision of objects has another object")),
        EventKind::Segment => Stop::Segment,
        EventKind::Edge => Stop::Edge,
    }
}

fn fact(fact: Fact, subject: u32, value: u32) -> u64 {
    let mut bytes = [0; 9];
    bytes[0] = fact as u8;
    bytes[1..5].copy_from_slice(&subject.to_le_bytes());
    bytes[5..].copy_from_slice(&value.to_le_bytes());
    XxHash3_64::oneshot(&bytes)
}

fn count(number: usize) -> u32 {
    u32::try_from(number).expect("limits are far below 2^32")
}

#[cfg(test)]
pub(crate) mod tests;
