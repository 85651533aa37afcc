//! All that a match consists of between two cycles, for the rules to work on.

use std::collections::BTreeMap;
use std::sync::Arc;

use glam::DVec2;
use maniple_geometry::{Cycle, Moment, ObjectId};
use maniple_kinematics::{Leg, Placement, WallError};
use maniple_tilemap::{Regions, TileMap, regions};
use maniple_view::{
    Base, EndOfTask, Mode, Own, Seat, Shape, Status, Stop, Tally, Task, UnitType, UnitTypeId, Weapon,
    hull_distance,
};
use serde::{Deserialize, Serialize};

use super::WorldError;
use super::field::Field;
use super::unit::{Body, Job, Unit, Units};
use crate::keyed::{Purpose, keyed};
use crate::load::Loaded;
use crate::placement::StartUnit;
use crate::room::tile_of;
use crate::scenario::{Scenario, SeatStart};
use crate::vision::{Fog, Sight};

/// The state of a match.
pub(crate) struct State {
    pub(crate) map: Arc<TileMap>,
    /// Where the ground hangs together; only where units are made.
    regions: Option<Regions>,
    pub(crate) scenario: Arc<Scenario>,
    pub(crate) field: Field,
    pub(crate) units: Units,
    pub(crate) seats: Vec<SeatState>,
    /// How many objects there have been that are nobody's.
    pub(crate) nobodys: u32,
    pub(crate) sight: Sight,
    /// Who came to rest in the last cycle, when and why.
    pub(crate) stops: BTreeMap<ObjectId, (Moment, Stop)>,
    /// Who fired in the last cycle, at whom; `None`: at a point.
    pub(crate) shots: Vec<(ObjectId, Option<ObjectId>)>,
    /// Whose tasks ended in the last cycle.
    pub(crate) ended: Vec<(ObjectId, Task, EndOfTask)>,
    /// The sites that are given up in this cycle.
    pub(crate) given_up: Vec<ObjectId>,
    /// Who died in the last cycle, by number.
    pub(crate) died: Vec<ObjectId>,
}

/// What a match knows of a seat.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct SeatState {
    pub(crate) team: u16,
    pub(crate) stock: u32,
    pub(crate) is_out: bool,
    pub(crate) tally: Tally,
    /// How many objects it has had, dead or alive.
    pub(crate) had: u32,
    /// How many objects it has, those in training included.
    pub(crate) has: u32,
}

impl SeatState {
    /// How many bytes one is in the state hash.
    pub(crate) const BYTES: usize = 2 * 8 + 13 * 4;

    /// Writes it for the state hash.
    pub(crate) fn write(&self, bytes: &mut Vec<u8>) {
        let Tally { units, arrived, arrival_sum, gathered, made, .. } = self.tally;
        let Tally { units_destroyed, buildings_destroyed, units_lost, buildings_lost, last_building, .. } =
            self.tally;
        for number in [arrival_sum, gathered] {
            bytes.extend_from_slice(&number.to_le_bytes());
        }
        for number in [
            u32::from(self.team),
            self.stock,
            u32::from(self.is_out),
            self.had,
            self.has,
            units,
            arrived,
            made,
            units_destroyed,
            buildings_destroyed,
            units_lost,
            buildings_lost,
            last_building.0,
        ] {
            bytes.extend_from_slice(&number.to_le_bytes());
        }
    }
}

impl State {
    /// Returns the state of a match before anything stands in it.
    pub(crate) fn new(loaded: &Loaded) -> Result<Self, WorldError> {
        let scenario = &loaded.scenario;
        let seat = |start: &SeatStart| SeatState {
            team: start.team,
            stock: start.stock,
            is_out: false,
            tally: Tally::default(),
            had: 0,
            has: 0,
        };
        Ok(Self {
            map: Arc::clone(&loaded.map),
            regions: scenario.production.then(|| regions(&loaded.map)),
            field: Field::new(loaded)?,
            units: Units::default(),
            seats: scenario.seats.iter().map(seat).collect(),
            nobodys: 0,
            sight: match scenario.vision {
                None => Sight::Perfect,
                Some(vision) => {
                    let teams: Vec<u16> = scenario.seats.iter().map(|seat| seat.team).collect();
                    Sight::Fog(Box::new(Fog::new(&vision, &loaded.map, &teams)))
                }
            },
            stops: BTreeMap::new(),
            shots: Vec::new(),
            ended: Vec::new(),
            given_up: Vec::new(),
            died: Vec::new(),
            scenario: Arc::clone(scenario),
        })
    }

    /// Returns the region of open ground that a point of the map is in, where units are made; `None` on a wall.
    pub(crate) fn region(&self, point: DVec2) -> Option<u32> {
        let (x, y) = tile_of(point)?;
        self.regions.as_ref().filter(|_| x < self.map.width() && y < self.map.height())?.label(x, y)
    }

    /// Puts an object into the world that stands still and is finished.
    pub(crate) fn add(&mut self, start: &StartUnit) -> Result<ObjectId, WorldError> {
        let StartUnit { seat, unit_type, position, amount } = *start;
        let id = self.units.next_id();
        let kind = &self.scenario.unit_types[usize::from(unit_type.0)];
        let unit_problem = |problem| WorldError::Unit { object: id, problem };
        let body = match kind.shape {
            Shape::Circle { radius } => {
                self.field.insert(id, position, radius, kind.layer).map_err(unit_problem)?;
                Body::Circle
            }
            Shape::Rectangle { .. } => {
                let walls = self.field.insert_sides(position, kind.shape.half(), kind.layer);
                let problem = |problem: WallError| WorldError::Building { object: id, problem };
                Body::Rectangle { center: position, walls: walls.map_err(problem)?, since: self.cycle() }
            }
        };
        let hit_points = kind.hit_points.unwrap_or(0);
        // Not the number of the object: it follows from how many others there are.
        let had = match seat {
            Some(seat) => &mut self.seats[seat.index()].had,
            None => &mut self.nobodys,
        };
        let unit = Unit::new(seat, *had, unit_type, body);
        *had += 1;
        Ok(self.units.push(Unit { hit_points, amount, ..unit }))
    }

    /// Takes a living object out of the world.
    pub(crate) fn remove(&mut self, id: ObjectId) {
        match std::mem::replace(&mut self.units.edit(id).body, Body::Circle) {
            Body::Circle => self.field.remove(id),
            Body::Rectangle { walls, .. } => self.field.remove_walls(&walls),
        }
        let unit = self.units.at(id);
        if let Some(owner) = unit.owner {
            let lost = 1 + u32::try_from(unit.training.len()).unwrap_or(u32::MAX);
            let seat = &mut self.seats[owner.index()];
            assert!(seat.has >= lost, "a seat has what it loses");
            seat.has -= lost;
        }
        self.units.kill(id);
        self.died.push(id);
    }

    /// Sends an object straight to a point at its full speed.
    pub(crate) fn send(&mut self, id: ObjectId, goal: DVec2) {
        let speed = self.speed(id);
        if speed == 0.0 || self.units.at(id).aim == Some(goal) && self.is_moving(id) {
            return;
        }
        let sent = self.field.go(id, &[Leg { goal, speed }], Placement::Replace, None);
        assert_eq!(sent, Ok(()), "a way to a point between two objects is within the world");
        self.units.edit(id).aim = Some(goal);
    }

    /// Lets an object stand.
    pub(crate) fn halt(&mut self, id: ObjectId) {
        if self.is_moving(id) {
            let halted = self.field.halt(id, None);
            assert_eq!(halted, Ok(()), "who is alive can be halted");
        }
        if self.units.at(id).aim.is_some() {
            self.units.edit(id).aim = None;
        }
    }

    /// Lets an object do something else than before.
    pub(crate) fn set_job(&mut self, id: ObjectId, job: Job) {
        let unit = self.units.edit(id);
        unit.job = job;
        unit.aim = None;
    }

    /// Ends what an object has been told to do, and tells its owner.
    pub(crate) fn end_job(&mut self, id: ObjectId, why: EndOfTask) {
        let task = self.units.at(id).job.task();
        self.set_job(id, Job::None);
        self.ended.push((id, task, why));
    }

    /// Returns the cycle at whose start the world is.
    pub(crate) fn cycle(&self) -> Cycle {
        self.field.cycle()
    }

    /// Returns the type of an object.
    pub(crate) fn kind(&self, id: ObjectId) -> &UnitType {
        self.unit_type(self.units.at(id).unit_type)
    }

    pub(crate) fn unit_type(&self, unit_type: UnitTypeId) -> &UnitType {
        &self.scenario.unit_types[usize::from(unit_type.0)]
    }

    /// Returns the largest speed of an object in its present mode, in world units a cycle.
    pub(crate) fn speed(&self, id: ObjectId) -> f64 {
        let kind = self.kind(id);
        match self.units.at(id).mode {
            Mode::Normal => kind.speed,
            Mode::Alternate => kind.alternate.as_ref().map_or(0.0, |other| other.speed),
            Mode::Switching | Mode::SwitchingBack | Mode::Site => 0.0,
        }
    }

    /// Returns the weapon of an object in its present mode.
    pub(crate) fn weapon(&self, id: ObjectId) -> Option<&Weapon> {
        let kind = self.kind(id);
        match self.units.at(id).mode {
            Mode::Normal => kind.weapon.as_ref(),
            Mode::Alternate => kind.alternate.as_ref().and_then(|other| other.weapon.as_ref()),
            Mode::Switching | Mode::SwitchingBack | Mode::Site => None,
        }
    }

    /// Returns where an object is that is alive.
    pub(crate) fn center(&self, id: ObjectId) -> DVec2 {
        match &self.units.at(id).body {
            Body::Circle => self.field.center(id),
            Body::Rectangle { center, .. } => *center,
        }
    }

    /// Returns how an object moves that is alive, and how many motions wait behind.
    pub(crate) fn base(&self, id: ObjectId) -> (Base, usize) {
        match &self.units.at(id).body {
            Body::Circle => self.field.base(id),
            Body::Rectangle { center, since, .. } => (Base::at_rest(*center, Moment::start_of(*since)), 0),
        }
    }

    pub(crate) fn is_moving(&self, id: ObjectId) -> bool {
        self.base(id).0.is_moving()
    }

    /// Returns how far it is from hull to hull of two living objects, in world units.
    pub(crate) fn distance(&self, one: ObjectId, other: ObjectId) -> f64 {
        hull_distance(self.center(other) - self.center(one), &self.kind(one).shape, &self.kind(other).shape)
    }

    /// Returns the team of an object; `None`: it is nobody's.
    pub(crate) fn team(&self, id: ObjectId) -> Option<u16> {
        self.units.at(id).owner.map(|owner| self.seats[owner.index()].team)
    }

    /// Returns whether two objects belong to different teams; nobody's are no enemies.
    pub(crate) fn are_enemies(&self, one: ObjectId, other: ObjectId) -> bool {
        match (self.team(one), self.team(other)) {
            (Some(one), Some(other)) => one != other,
            (None, _) | (_, None) => false,
        }
    }

    /// Returns random bits for an object in the present cycle.
    pub(crate) fn random(&self, id: ObjectId, purpose: Purpose) -> u64 {
        let unit = self.units.at(id);
        keyed(self.scenario.seed, self.cycle(), unit.owner, unit.index, purpose)
    }

    /// Returns what is to be seen of a living object.
    pub(crate) fn status(&self, id: ObjectId) -> Status {
        let kind = self.kind(id);
        self.units.at(id).status(kind.hit_points.is_some(), kind.patch_places.is_some())
    }

    /// Returns what its owner knows of a living object.
    pub(crate) fn own(&self, id: ObjectId, queued: u32) -> Own {
        let unit = self.units.at(id);
        let made = unit.training.first().copied().unwrap_or(unit.unit_type);
        Own { queued, ..unit.own(self.cycle(), self.unit_type(made).making.cycles) }
    }

    /// Returns whether a seat, or another of its team, sees an object at the start of the present cycle.
    pub(crate) fn sees(&self, seat: Seat, object: ObjectId) -> bool {
        self.units.is_alive(object) && self.sight.sees(seat, object)
    }
}
