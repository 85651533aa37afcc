//! All that decides what a match does next, as plain data, and a world from it.
//!
//! What follows from this and from what the match was made of is made anew: walls of buildings, what is in sight, who is
//! busy, the sums of the hash. What happened in the last cycle has been told.

use std::collections::{BTreeMap, BTreeSet};

use maniple_geometry::{Cycle, Moment, ObjectId};
use maniple_kinematics as kinematics;
use maniple_view::{Digest, Mode, Seat, Shape, Stop, Tally};
use serde::{Deserialize, Serialize};
use thiserror::Error;

use super::order::{self, Ground};
use super::unit::Body;
use super::{Ending, Job, SeatState, State, Unit, World, WorldError, field};
use crate::load::Loaded;
use crate::scenario::{TRAINING_MAX, UNITS_MAX};

/// Largest of what is counted in 32 bits, so that counting on never ends in the middle of a match.
const COUNT_MAX: u32 = 1 << 31;

/// Largest of what is summed up in 64 bits, for the same reason.
const SUM_MAX: u64 = 1 << 62;

/// All that decides what a match does next, at the start of a cycle.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct WorldSnapshot {
    field: kinematics::WorldSnapshot,
    /// By number, dead or alive.
    units: Vec<Unit>,
    seats: Vec<SeatState>,
    /// Who came to rest in the last cycle, when and why.
    stops: BTreeMap<ObjectId, (Moment, Stop)>,
    /// What each team has explored, in the order of their numbers, as runs of tiles.
    explored: Vec<Vec<(u32, u32)>>,
    /// Which units of the start have reached their zone; nothing where the match is no race.
    arrived: Vec<bool>,
    /// Who was taken out since the last cycle.
    leaving: Vec<Seat>,
    ending: Option<Ending>,
    hash: Digest,
}

/// A snapshot that is none of the match.
#[derive(Debug, Error)]
pub enum RestoreError {
    /// The world itself, or a building.
    #[error(transparent)]
    World(#[from] WorldError),
    /// An object that moves as none can, or where another one is.
    #[error(transparent)]
    Field(#[from] kinematics::RestoreError),
    /// What is known of an object.
    #[error("object {object}: {problem}")]
    Object {
        /// The object.
        object: ObjectId,
        /// What is wrong with it.
        problem: &'static str,
    },
    /// What is known of a seat.
    #[error("seat {seat}: {problem}")]
    Seat {
        /// The seat.
        seat: Seat,
        /// What is wrong with it.
        problem: &'static str,
    },
    /// The match as a whole.
    #[error("{0}")]
    Match(&'static str),
}

impl WorldSnapshot {
    /// Returns the cycle at whose start it was taken.
    #[must_use]
    pub fn cycle(&self) -> Cycle {
        self.field.cycle
    }

    /// Returns the state hash at the start of that cycle.
    #[must_use]
    pub fn hash(&self) -> Digest {
        self.hash
    }
}

impl World {
    /// Returns all that decides what the match does next.
    ///
    /// # Panics
    /// When a command was given since the last step: a snapshot is of the start of a cycle.
    #[must_use]
    pub fn snapshot(&self) -> WorldSnapshot {
        let state = &self.state;
        assert!(
            state.shots.is_empty() && state.ended.is_empty() && state.given_up.is_empty(),
            "a snapshot is taken before the commands of a cycle"
        );
        WorldSnapshot {
            field: state.field.snapshot(),
            units: state.units.all().iter().map(Unit::without_walls).collect(),
            seats: state.seats.clone(),
            stops: state.stops.clone(),
            explored: state.sight.explored(),
            arrived: self.race.as_ref().map_or(Vec::new(), |race| race.arrived().to_vec()),
            leaving: self.leaving.clone(),
            ending: self.ending.clone(),
            hash: self.hash,
        }
    }

    /// Returns the world of a snapshot, in the match that it was taken in.
    ///
    /// # Errors
    /// See [`RestoreError`].
    pub fn restored(loaded: &Loaded, snapshot: &WorldSnapshot) -> Result<Self, RestoreError> {
        let mut world = Self::empty(loaded)?;
        let seats = world.state.seats.len();
        let is_seat = |seat: &Seat| seat.index() < seats;
        let winners = snapshot.ending.iter().flat_map(|ending| &ending.winners);
        if !winners.chain(&snapshot.leaving).all(is_seat) {
            return Err(RestoreError::Match("it names a seat that the match does not have"));
        }
        if snapshot.cycle() > world.state.scenario.cycles_max {
            return Err(RestoreError::Match("its cycle lies behind the end of the match"));
        }
        world.state.restore(snapshot)?;
        let arrived = match &mut world.race {
            Some(race) => race.restore(&snapshot.arrived),
            None => snapshot.arrived.is_empty().then_some(()),
        };
        arrived.ok_or(RestoreError::Match("others race than units of the start"))?;
        world.leaving.clone_from(&snapshot.leaving);
        world.ending.clone_from(&snapshot.ending);
        world.hash = snapshot.hash;
        world.take_stock();
        world.look();
        Ok(world)
    }
}

impl Unit {
    /// Returns it without the numbers of its walls, which differ with what was built before.
    fn without_walls(&self) -> Self {
        match self.body {
            Body::Circle => self.clone(),
            Body::Rectangle { center, since, .. } => {
                Self { body: Body::Rectangle { center, walls: Vec::new(), since }, ..self.clone() }
            }
        }
    }
}

impl State {
    /// Goes on where a snapshot was taken, from a state in which nothing stands.
    fn restore(&mut self, snapshot: &WorldSnapshot) -> Result<(), RestoreError> {
        self.check_seats(snapshot)?;
        let mut circles = BTreeSet::new();
        let mut had = vec![0; self.seats.len()];
        for (object, unit) in (0..).map(ObjectId).zip(&snapshot.units) {
            let bad = |problem| RestoreError::Object { object, problem };
            self.check_unit(object, snapshot).map_err(bad)?;
            let had = unit.owner.map_or(&mut self.nobodys, |owner| &mut had[owner.index()]);
            if unit.index != *had {
                return Err(bad("its owner had more or fewer before it"));
            }
            *had += 1;
            if unit.is_alive && unit.body == Body::Circle {
                circles.insert(object);
            }
            let body = self.built(object, unit)?;
            self.units.put_back(Unit { body, ..unit.clone() });
        }
        self.units.settle();
        self.field.restore(&snapshot.field)?;
        if !snapshot.field.objects.keys().eq(circles.iter()) {
            return Err(RestoreError::Match("others move than those who are alive"));
        }
        for (seat, saved) in (0..).map(Seat).zip(&snapshot.seats) {
            let bad = |problem| RestoreError::Seat { seat, problem };
            if (saved.had, saved.has) != (had[seat.index()], self.has(seat)) {
                return Err(bad("it has more or fewer objects than it says"));
            }
        }
        self.seats.clone_from(&snapshot.seats);
        if snapshot.stops.keys().any(|&object| self.units.find(object).is_none()) {
            return Err(RestoreError::Match("somebody stopped who never was"));
        }
        self.stops.clone_from(&snapshot.stops);
        self.sight.restore(&snapshot.explored).ok_or(RestoreError::Match("it explores another map"))
    }

    /// Builds the walls of a rectangle again and returns the body of an object.
    fn built(&mut self, object: ObjectId, unit: &Unit) -> Result<Body, RestoreError> {
        let Body::Rectangle { center, since, .. } = unit.body else { return Ok(Body::Circle) };
        let kind = &self.scenario.unit_types[usize::from(unit.unit_type.0)];
        let walls = self.field.insert_sides(center, kind.shape.half(), kind.layer);
        let walls = walls.map_err(|problem| WorldError::Building { object, problem })?;
        Ok(Body::Rectangle { center, walls, since })
    }

    /// Returns how many objects a seat has, those in training included.
    fn has(&self, seat: Seat) -> u32 {
        let own = self.units.alive().filter(|(_, unit)| unit.owner == Some(seat));
        let count = own.map(|(_, unit)| 1 + unit.training.len()).sum::<usize>();
        u32::try_from(count).unwrap_or(u32::MAX)
    }

    fn check_seats(&self, snapshot: &WorldSnapshot) -> Result<(), RestoreError> {
        if snapshot.seats.len() != self.seats.len() {
            return Err(RestoreError::Match("the match has another number of seats"));
        }
        for (seat, (saved, start)) in (0..).map(Seat).zip(snapshot.seats.iter().zip(&self.seats)) {
            let bad = |problem| Err(RestoreError::Seat { seat, problem });
            if saved.team != start.team {
                return bad("its team is another one");
            }
            let Tally { units, arrived, arrival_sum, gathered, made, .. } = saved.tally;
            let Tally { units_destroyed, buildings_destroyed, units_lost, buildings_lost, .. } = saved.tally;
            let destroyed = [units_destroyed, buildings_destroyed, units_lost, buildings_lost];
            let mut counts = [units, arrived, made].into_iter().chain(destroyed);
            if saved.has > UNITS_MAX
                || counts.any(|count| count > COUNT_MAX)
                || arrival_sum.max(gathered) > SUM_MAX
            {
                return bad("it counts higher than a match can");
            }
        }
        Ok(())
    }

    /// Checks what is known of an object, but for where it is.
    fn check_unit(&self, object: ObjectId, snapshot: &WorldSnapshot) -> Result<(), &'static str> {
        let unit = &snapshot.units[object.0 as usize];
        let kind = self.scenario.unit_types.get(usize::from(unit.unit_type.0));
        let kind = kind.ok_or("there is no such unit type")?;
        if unit.owner.is_some_and(|owner| owner.index() >= self.seats.len()) {
            return Err("its owner is no seat of the match");
        }
        if !unit.is_alive {
            let has_nothing = unit.job == Job::None && unit.training.is_empty() && unit.body == Body::Circle;
            return if has_nothing { Ok(()) } else { Err("it is dead and has something to do") };
        }
        match (&kind.shape, &unit.body) {
            (Shape::Circle { radius }, Body::Circle) => {
                let moving = snapshot.field.objects.get(&object).ok_or("it is alive and nowhere")?;
                if moving.radius != self.field.rounded(*radius) || moving.layers != field::layers(kind.layer)
                {
                    return Err("its radius or layer is not that of its unit type");
                }
            }
            (Shape::Rectangle { .. }, Body::Rectangle { .. }) => {}
            (Shape::Circle { .. }, Body::Rectangle { .. }) | (Shape::Rectangle { .. }, Body::Circle) => {
                return Err("its shape is not that of its unit type");
            }
        }
        let switch = kind.alternate.as_ref().map(|other| other.switch_cycles);
        let left = unit.mode_until.0.saturating_sub(snapshot.cycle().0);
        let can_be = match unit.mode {
            Mode::Normal | Mode::Site => switch.is_none_or(|switch| left <= switch),
            Mode::Alternate | Mode::Switching | Mode::SwitchingBack => {
                switch.is_some_and(|switch| left <= switch)
            }
        };
        if !can_be {
            return Err("its mode is none of its unit type, or lasts longer than a switch");
        }
        if unit.made.max(unit.worked).max(unit.load) > COUNT_MAX {
            return Err("it counts higher than a match can");
        }
        if unit.training.len() > TRAINING_MAX as usize
            || unit.training.iter().any(|trained| !kind.trains.contains(trained))
        {
            return Err("it trains what its unit type does not, or too many");
        }
        self.check_job(unit, &snapshot.units)
    }

    fn check_job(&self, unit: &Unit, units: &[Unit]) -> Result<(), &'static str> {
        let ground =
            Ground { width: self.map.width(), height: self.map.height(), limits: *self.field.limits() };
        let is_on_map = |point: glam::DVec2| order::goal(point.x, point.y, &ground).is_ok();
        let find = |object: ObjectId| units.get(object.0 as usize);
        let kind_of = |unit: &Unit| self.scenario.unit_types.get(usize::from(unit.unit_type.0));
        let is_meant = match unit.job {
            Job::None | Job::Hold => true,
            Job::Attack { target: other } | Job::ReturnLoad { to: other } => find(other).is_some(),
            Job::AttackAt { point: goal } | Job::AttackMove { goal } => is_on_map(goal),
            Job::Gather { patch, .. } => {
                find(patch).and_then(kind_of).is_some_and(|kind| kind.patch_places.is_some())
            }
            Job::Build { unit_type, center, site } => {
                kind_of(unit).is_some_and(|kind| kind.builds.contains(&unit_type))
                    && is_on_map(center)
                    && site.is_none_or(|site| find(site).is_some())
            }
        };
        if is_meant { Ok(()) } else { Err("it is to do what no command says") }
    }
}
