//! The world of a match: kinematics, and what the scenario adds to it.

mod command;
mod field;
mod order;
mod part;
mod snapshot;
mod state;
mod unit;

use std::borrow::Cow;
use std::sync::Arc;

use maniple_geometry::{Cycle, Moment, NumberError, ObjectId};
use maniple_kinematics::{self as kinematics, EventKind};
use maniple_view::{
    COMMANDS_A_CYCLE_MAX, Command, Digest, EndOfTask, Identity, Layer, Objective, Refusal, Rules, Seat,
    Sighting, Stop, Tally, Task, TerrainKnowledge, TileSet, WAYPOINTS_MAX,
};
use thiserror::Error;
use twox_hash::XxHash3_64;

use crate::load::Loaded;
use crate::placement::StartUnit;
use crate::rules::objective::{self, Ending, Left, Standing};
use crate::rules::{Race, combat, harvest, modes, neutral, production};
use crate::scenario::{self, TRAINING_MAX, UNITS_MAX};
use crate::vision::{Sight, Visible, Wall};

pub use part::Part;
pub use snapshot::{RestoreError, WorldSnapshot};
pub(crate) use state::{SeatState, State};
pub(crate) use unit::{Job, Stay, Unit};

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
    /// A rectangular building.
    #[error("building {object}: {problem}; move the spawn, or make the unit type smaller")]
    Building {
        /// Its number.
        object: ObjectId,
        /// What is wrong with it.
        problem: kinematics::WallError,
    },
}

/// The world of a match.
///
/// Commands change it between cycles, [`World::step`] goes on by one. Everything that a seat may know comes out of
/// [`World::sightings`], [`World::died`], [`World::shots`], [`World::ended`] and [`World::stock`].
pub struct World {
    state: State,
    /// Where the match is a race.
    race: Option<Race>,
    /// Who belongs to nobody and wanders.
    wanderers: Vec<ObjectId>,
    /// Who resigned in this cycle; their objects die at its end.
    leaving: Vec<Seat>,
    /// What happened in the last cycle.
    news: News,
    /// Every living object, by number.
    sightings: Vec<Sighting>,
    ending: Option<Ending>,
    hash: Digest,
}

/// What happened in a cycle.
#[derive(Debug, Default)]
struct News {
    /// By number.
    died: Vec<ObjectId>,
    shots: Vec<(ObjectId, Option<ObjectId>)>,
    ended: Vec<(ObjectId, Task, EndOfTask)>,
}

impl World {
    /// Returns the world at the start of cycle 0.
    ///
    /// # Errors
    /// See [`WorldError`]: a map or scenario beyond what kinematics can work with.
    pub fn new(loaded: &Loaded) -> Result<Self, WorldError> {
        let mut world = Self::empty(loaded)?;
        for unit in &loaded.setup.units {
            world.state.add(unit)?;
            if let Some(seat) = unit.seat {
                let seat = &mut world.state.seats[seat.index()];
                seat.has += 1;
                seat.tally.units += 1;
            }
        }
        world.take_stock();
        world.look();
        world.chain();
        Ok(world)
    }

    /// Returns the world at the start of cycle 0 before anything stands in it.
    fn empty(loaded: &Loaded) -> Result<Self, WorldError> {
        let state = State::new(loaded)?;
        let setup = &loaded.setup;
        let is_race = matches!(state.scenario.objective, scenario::Objective::Race { .. });
        let is_wanderer =
            |unit: &StartUnit| unit.seat.is_none() && state.unit_type(unit.unit_type).speed > 0.0;
        let start = (0..).map(ObjectId).zip(&setup.units);
        Ok(Self {
            race: is_race.then(|| Race::new(&setup.zones, setup.units.len())),
            wanderers: start.filter(|(_, unit)| is_wanderer(unit)).map(|(object, _)| object).collect(),
            leaving: Vec::new(),
            news: News::default(),
            sightings: Vec::new(),
            ending: None,
            hash: Digest(loaded.map.hash()),
            state,
        })
    }

    /// Applies a command of a seat to an object at the start of the next cycle to be simulated; `target` is the object in the
    /// seat's view that it is aimed at.
    ///
    /// # Errors
    /// Why it was refused; nothing has changed then. An object of another seat is an unknown handle.
    pub fn command(
        &mut self,
        seat: Seat,
        object: ObjectId,
        command: &Command,
        target: Option<ObjectId>,
    ) -> Result<(), Refusal> {
        if self.is_out(seat) || self.ending.is_some() {
            return Err(Refusal::Out);
        }
        if *command == Command::Resign {
            self.resign(seat);
            return Ok(());
        }
        let owned = self.state.units.find(object).filter(|unit| unit.owner == Some(seat) && unit.is_alive);
        owned.ok_or(Refusal::UnknownHandle)?;
        command::obey(&mut self.state, object, command, target)
    }

    /// Takes a seat out of the match; its objects die at the end of the next cycle to be simulated. Does nothing if
    /// it is out already, or the match has ended.
    pub fn resign(&mut self, seat: Seat) {
        if self.is_out(seat) || self.ending.is_some() {
            return;
        }
        self.state.seats[seat.index()].is_out = true;
        self.leaving.push(seat);
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
        let played = self.state.cycle();
        let hits = self.set_out();
        done(Part::Tasks);
        self.state.stops.clear();
        for event in self.state.field.step_by_parts(|part| done(Part::Kinematics(part))) {
            if event.rests {
                let moment = Moment { cycle: event.cycle, fraction: event.time };
                self.state.stops.insert(event.object, (moment, stop(event)));
            }
        }
        assert_eq!(self.state.cycle(), played.next(), "a step is one cycle");
        self.work(played, hits);
        self.bury();
        self.conclude();
        self.chain();
        done(Part::Rules);
        self.take_stock();
        done(Part::Sightings);
        if let Sight::Fog(_) = self.state.sight {
            self.look();
            done(Part::Vision);
        }
    }

    /// Returns the cycle at whose start the world is; the next to be simulated.
    #[must_use]
    pub fn cycle(&self) -> Cycle {
        self.state.cycle()
    }

    /// Returns all that a seat sees at the start of the present cycle, by object number.
    #[must_use]
    pub fn sightings(&self, seat: Seat) -> Cow<'_, [Sighting]> {
        match &self.state.sight {
            Sight::Perfect => Cow::Borrowed(&self.sightings),
            Sight::Fog(fog) => {
                let place = |object| self.sightings.binary_search_by_key(object, |sighting| sighting.object);
                let sighting = |object| self.sightings[place(object).expect("who is seen is alive")];
                fog.objects(seat).iter().map(sighting).collect()
            }
        }
    }

    /// Returns every living object as it truly is, by object number: for judges and for those who may know everything.
    #[must_use]
    pub fn objects(&self) -> &[Sighting] {
        &self.sightings
    }

    /// Returns the tiles that are visible to a seat at the start of the present cycle; `None`: all, there is no fog.
    #[must_use]
    pub fn visible(&self, seat: Seat) -> Option<&TileSet> {
        self.state.sight.visible(seat)
    }

    /// Returns the tiles that a seat knows at the start of the present cycle; `None`: all, from the start.
    #[must_use]
    pub fn known(&self, seat: Seat) -> Option<&TileSet> {
        self.state.sight.known(seat)
    }

    /// Returns the tiles that a seat sees for the first time, as column, row and characters to the right, and the walls that it knows
    /// of for the first time; see [`maniple_view::Delta`].
    #[must_use]
    pub fn explored(&self, seat: Seat) -> (&[(u32, u32, String)], &[Wall]) {
        self.state.sight.news(seat)
    }

    /// Returns the objects that died in the last cycle and that the seat saw at its start, by object number.
    #[must_use]
    pub fn died(&self, seat: Seat) -> Vec<ObjectId> {
        self.news.died.iter().filter(|&&object| self.state.sight.saw(seat, object)).copied().collect()
    }

    /// Returns all objects that died in the last cycle, by object number.
    #[must_use]
    pub fn dead(&self) -> &[ObjectId] {
        &self.news.died
    }

    /// Returns who fired in the last cycle, at whom; `None`: at a point. In no useful order.
    #[must_use]
    pub fn fired(&self) -> &[(ObjectId, Option<ObjectId>)] {
        &self.news.shots
    }

    /// Returns those of [`World::fired`] that a seat saw when they fired, which is at the start of the cycle; at `None`, too, if it did not
    /// see the target then.
    #[must_use]
    pub fn shots(&self, seat: Seat) -> Vec<(ObjectId, Option<ObjectId>)> {
        let saw = |object: &ObjectId| self.state.sight.saw(seat, *object);
        let seen = self.news.shots.iter().filter(|(shooter, _)| saw(shooter));
        seen.map(|&(shooter, target)| (shooter, target.filter(saw))).collect()
    }

    /// Returns whose tasks ended in the last cycle, and why, in the order in which they did.
    #[must_use]
    pub fn ended(&self) -> &[(ObjectId, Task, EndOfTask)] {
        &self.news.ended
    }

    /// Returns the resources of a seat.
    #[must_use]
    pub fn stock(&self, seat: Seat) -> u32 {
        self.state.seats[seat.index()].stock
    }

    /// Returns whether a seat has resigned or was forfeited.
    #[must_use]
    pub fn is_out(&self, seat: Seat) -> bool {
        self.state.seats[seat.index()].is_out
    }

    /// Returns how the match has ended; `None` while it goes on.
    #[must_use]
    pub fn ending(&self) -> Option<&Ending> {
        self.ending.as_ref()
    }

    /// Returns what a seat has done so far.
    #[must_use]
    pub fn tally(&self, seat: Seat) -> Tally {
        self.state.seats[seat.index()].tally
    }

    /// Returns the team of a seat.
    #[must_use]
    pub fn team(&self, seat: Seat) -> u16 {
        self.state.seats[seat.index()].team
    }

    /// Returns what counts for each seat by the objective, in order of the seats: more is better.
    #[must_use]
    pub fn points(&self) -> Vec<u64> {
        let objective = &self.state.scenario.objective;
        let left = objective::left(&self.state);
        let points = |(seat, left): (&SeatState, Left)| objective::points(objective, &seat.tally, left);
        self.state.seats.iter().zip(left).map(points).collect()
    }

    /// Returns the state hash: the xxh3-64 of the hash before, the cycle, the digest of kinematics and those of the objects and
    /// seats, little-endian; the first one is chained to the hash of the map.
    #[must_use]
    pub fn hash(&self) -> Digest {
        self.hash
    }

    /// Returns the rules of the match; `players` are the names, in order of the seats.
    #[must_use]
    pub fn rules(&self, players: Vec<String>) -> Rules {
        let scenario = &self.state.scenario;
        Rules {
            scenario: scenario.name.clone(),
            cycles_max: scenario.cycles_max.0,
            players,
            unit_types: scenario.unit_types.clone(),
            stops: scenario.stops,
            skin: self.state.field.skin(),
            waypoints_max: count(WAYPOINTS_MAX),
            commands_a_cycle_max: count(COMMANDS_A_CYCLE_MAX),
            objective: self.objective(),
            teams: self.state.seats.iter().map(|seat| seat.team).collect(),
            friendly_fire: scenario.combat.is_some_and(|combat| combat.friendly_fire),
            objects_max: UNITS_MAX,
            training_max: TRAINING_MAX,
            fog: scenario.vision.is_some(),
            terrain: scenario.vision.map_or(TerrainKnowledge::Known, |vision| vision.terrain),
            walls_block: scenario.vision.is_some_and(|vision| vision.walls_block),
            identity: scenario.vision.map_or(Identity::Fresh, |vision| vision.identity),
            positions: scenario.profile.positions,
        }
    }

    /// Returns the skin that follows from the limits of the world, in world units, whatever skin was asked for: what
    /// rounding can do is a fixed part of it.
    #[must_use]
    pub fn skin_of_limits(&self) -> f64 {
        self.state.field.skin_of_limits()
    }

    fn objective(&self) -> Objective {
        match self.state.scenario.objective {
            scenario::Objective::Race { .. } => {
                Objective::Race { zones: self.race.as_ref().map_or(Vec::new(), |race| race.zones().to_vec()) }
            }
            scenario::Objective::Resources { goal } => Objective::Resources { goal },
            scenario::Objective::Kills => Objective::Kills,
            scenario::Objective::Buildings => Objective::Buildings,
            scenario::Objective::LastStanding => Objective::LastStanding,
            scenario::Objective::Survive { team } => Objective::Survive { team },
        }
    }

    /// Lets all who have been told to do something go on at the start of a cycle; returns what is hit in it.
    fn set_out(&mut self) -> Vec<combat::Hit> {
        let state = &mut self.state;
        production::clear(state);
        state.units.settle();
        let scenario = Arc::clone(&state.scenario);
        let busy = state.units.busy();
        let hits = match scenario.combat {
            Some(_) => combat::fight(state, &busy),
            None => Vec::new(),
        };
        if scenario.harvest.is_some() {
            harvest::walk(state, &busy);
        }
        if scenario.production {
            production::walk(state, &busy);
        }
        if let Some(rule) = &scenario.neutral {
            neutral::wander(state, rule, &self.wanderers);
        }
        hits
    }

    /// Lets the work of the cycle `played` take effect, which is over.
    fn work(&mut self, played: Cycle, hits: Vec<combat::Hit>) {
        let state = &mut self.state;
        let scenario = Arc::clone(&state.scenario);
        state.units.settle();
        let busy = state.units.busy();
        if scenario.harvest.is_some() {
            harvest::work(state, played, &busy);
        }
        if scenario.production {
            production::work(state, &busy);
        }
        if scenario.modes {
            modes::complete(state, &busy);
        }
        if scenario.combat.is_some() {
            combat::land(state, hits);
        }
        if let Some(race) = &mut self.race {
            for (object, unit) in state.units.alive() {
                let Some(owner) = unit.owner.filter(|_| !race.is_settled(object)) else { continue };
                if race.handle_position(object, owner, state.center(object)) {
                    let tally = &mut state.seats[owner.index()].tally;
                    tally.arrived += 1;
                    tally.arrival_sum += u64::from(played.0);
                }
            }
        }
    }

    /// Lets the objects of those who leave die, and tells who attacked them.
    fn bury(&mut self) {
        let state = &mut self.state;
        if !self.leaving.is_empty() {
            let leaves = |unit: &Unit| unit.owner.is_some_and(|owner| self.leaving.contains(&owner));
            let gone: Vec<ObjectId> =
                state.units.alive().filter(|(_, unit)| leaves(unit)).map(|(object, _)| object).collect();
            for object in gone {
                state.remove(object);
            }
            self.leaving.clear();
        }
        if !state.died.is_empty() && state.scenario.combat.is_some() {
            state.units.settle();
            let busy = state.units.busy();
            combat::conclude(state, &busy);
        }
        self.news.died.clear();
        self.news.shots.clear();
        self.news.ended.clear();
        self.news.died.append(&mut state.died);
        self.news.shots.append(&mut state.shots);
        self.news.ended.append(&mut state.ended);
        self.news.died.sort_unstable();
        state.units.settle();
    }

    /// Says how the match has ended, if it has.
    fn conclude(&mut self) {
        let state = &self.state;
        let left = objective::left(state);
        let standing = Standing {
            objective: &state.scenario.objective,
            seats: &state.seats,
            left: &left,
            cycles: state.cycle(),
            cycles_max: state.scenario.cycles_max,
        };
        self.ending = standing.ending();
    }

    fn sighting(&self, object: ObjectId) -> Sighting {
        let state = &self.state;
        let unit = state.units.at(object);
        let (base, waypoints) = state.base(object);
        Sighting {
            object,
            unit_type: unit.unit_type,
            owner: unit.owner,
            layers: field::layers(state.unit_type(unit.unit_type).layer).0,
            base,
            stop: state.stops.get(&object).map(|&(_, stop)| stop),
            status: state.status(object),
            own: state.own(object, count(waypoints)),
        }
    }

    /// Takes stock of who is where.
    fn take_stock(&mut self) {
        let mut sightings = std::mem::take(&mut self.sightings);
        sightings.clear();
        sightings.extend(self.state.units.alive().map(|(object, _)| self.sighting(object)));
        self.sightings = sightings;
    }

    /// Takes stock of who sees whom, under fog.
    fn look(&mut self) {
        let state = &mut self.state;
        if let Sight::Perfect = state.sight {
            return;
        }
        let visible = |object: ObjectId| {
            let kind = state.kind(object);
            Visible {
                object,
                team: state.team(object),
                center: state.center(object),
                shape: kind.shape,
                sight: kind.sight,
                is_in_air: kind.layer == Layer::Air,
            }
        };
        let objects: Vec<Visible> = state.units.alive().map(|(object, _)| visible(object)).collect();
        state.sight.look(&objects);
    }

    fn chain(&mut self) {
        let state = &mut self.state;
        state.units.settle();
        let mut bytes = Vec::with_capacity(28 + state.seats.len() * SeatState::BYTES);
        bytes.extend_from_slice(&self.hash.0.to_le_bytes());
        bytes.extend_from_slice(&state.field.cycle().0.to_le_bytes());
        bytes.extend_from_slice(&state.field.digest().to_le_bytes());
        bytes.extend_from_slice(&state.units.sum().to_le_bytes());
        for seat in &state.seats {
            seat.write(&mut bytes);
        }
        self.hash = Digest(XxHash3_64::oneshot(&bytes));
    }
}

fn stop(event: &kinematics::Event) -> Stop {
    match event.kind {
        EventKind::Arrived => Stop::Arrived,
        EventKind::Ordered => Stop::Ordered,
        EventKind::Object => Stop::Object(event.other.filter(|_| !event.is_one_of_several)),
        EventKind::Segment => Stop::Segment,
        EventKind::Edge => Stop::Edge,
    }
}

fn count(number: usize) -> u32 {
    u32::try_from(number).expect("limits are far below 2^32")
}

#[cfg(test)]
pub(crate) mod tests;
