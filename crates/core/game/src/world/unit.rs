//! What a match knows of each object, besides where it is.

use std::collections::BTreeSet;

use glam::DVec2;
use maniple_geometry::{Cycle, ObjectId};
use maniple_kinematics::WallId;
use maniple_view::{Action, Mode, Own, Seat, Status, Task, UnitTypeId};
use serde::{Deserialize, Serialize};
use twox_hash::XxHash3_64;

/// An object of the match: a unit, a building, a resource patch.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Unit {
    /// Whose it is; `None`: nobody's.
    pub(crate) owner: Option<Seat>,
    /// How many its owner had before it, dead or alive: what randomness is keyed with.
    pub(crate) index: u32,
    pub(crate) unit_type: UnitTypeId,
    pub(crate) is_alive: bool,
    pub(crate) body: Body,
    /// Only counts for types that can be hurt.
    pub(crate) hit_points: u32,
    /// Resources that are left in a patch.
    pub(crate) amount: u32,
    pub(crate) mode: Mode,
    /// When a switch that is under way will be over.
    pub(crate) mode_until: Cycle,
    pub(crate) job: Job,
    /// Where the job has sent it.
    pub(crate) aim: Option<DVec2>,
    pub(crate) load: u32,
    /// The first cycle in which it can fire again.
    pub(crate) ready: Cycle,
    /// Cycles of work on the next resource.
    pub(crate) worked: u32,
    /// Cycles of work on what is in training, or on the site that it is.
    pub(crate) made: u32,
    /// What it trains, the first one now.
    pub(crate) training: Vec<UnitTypeId>,
    /// Whether somebody worked on it in the last cycle; only for sites.
    pub(crate) is_worked_on: bool,
}

/// How an object takes up its place.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub(crate) enum Body {
    /// A circle of kinematics.
    Circle,
    /// Four walls of kinematics.
    Rectangle {
        /// World units.
        center: DVec2,
        /// Their numbers follow from what was built before, and a snapshot has none.
        #[serde(skip)]
        walls: Vec<WallId>,
        /// When it came to stand there.
        since: Cycle,
    },
}

/// What an object has been told to do, other than to move.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub(crate) enum Job {
    None,
    Attack {
        target: ObjectId,
    },
    AttackAt {
        point: DVec2,
    },
    AttackMove {
        goal: DVec2,
    },
    Hold,
    Gather {
        patch: ObjectId,
        stay: Stay,
    },
    ReturnLoad {
        /// The building that it goes to.
        to: ObjectId,
    },
    Build {
        unit_type: UnitTypeId,
        center: DVec2,
        /// The site that it works on; `None` before it is there.
        site: Option<ObjectId>,
    },
}

/// How far somebody is who gathers.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub(crate) enum Stay {
    /// On the way.
    Coming,
    /// There since a moment, and waiting for a place.
    Waiting { since: Cycle, fraction: f64 },
    /// There, and gathering.
    Working,
}

impl Job {
    /// Returns whether it is to gather at a patch.
    pub(crate) fn is_gathering_at(&self, wanted: ObjectId) -> bool {
        matches!(self, Self::Gather { patch, .. } if *patch == wanted)
    }

    /// Returns what its owner is told of it.
    pub(crate) fn task(&self) -> Task {
        match self {
            Self::None => Task::None,
            Self::Attack { .. } => Task::Attack,
            Self::AttackAt { .. } => Task::AttackAt,
            Self::AttackMove { .. } => Task::AttackMove,
            Self::Hold => Task::Hold,
            Self::Gather { .. } => Task::Gather,
            Self::ReturnLoad { .. } => Task::ReturnLoad,
            Self::Build { .. } => Task::Build,
        }
    }

    /// Returns what is seen of it.
    fn action(&self) -> Action {
        match self {
            Self::Gather { stay: Stay::Working, .. } => Action::Gather,
            Self::Build { site: Some(_), .. } => Action::Build,
            Self::None
            | Self::Attack { .. }
            | Self::AttackAt { .. }
            | Self::AttackMove { .. }
            | Self::Hold
            | Self::Gather { stay: Stay::Coming | Stay::Waiting { .. }, .. }
            | Self::ReturnLoad { .. }
            | Self::Build { site: None, .. } => Action::None,
        }
    }

    /// Writes it for the state hash.
    fn write(&self, bytes: &mut Vec<u8>) {
        let mut number = |value: u64| bytes.extend_from_slice(&value.to_le_bytes());
        number(self.task() as u64);
        match *self {
            Self::None | Self::Hold => {}
            Self::Attack { target } => number(target.0.into()),
            Self::AttackAt { point: goal } | Self::AttackMove { goal } => {
                number(goal.x.to_bits());
                number(goal.y.to_bits());
            }
            Self::Gather { patch, stay } => {
                number(patch.0.into());
                match stay {
                    Stay::Coming => number(0),
                    Stay::Waiting { since, fraction } => {
                        number(1 + (u64::from(since.0) << 2));
                        number(fraction.to_bits());
                    }
                    Stay::Working => number(2),
                }
            }
            Self::ReturnLoad { to } => number(to.0.into()),
            Self::Build { unit_type, center, site } => {
                number(unit_type.0.into());
                number(center.x.to_bits());
                number(center.y.to_bits());
                number(site.map_or(u64::MAX, |site| site.0.into()));
            }
        }
    }
}

impl Unit {
    /// Returns a unit that has just come to be, and does nothing.
    pub(crate) fn new(owner: Option<Seat>, index: u32, unit_type: UnitTypeId, body: Body) -> Self {
        Self {
            owner,
            index,
            unit_type,
            is_alive: true,
            body,
            hit_points: 0,
            amount: 0,
            mode: Mode::Normal,
            mode_until: Cycle(0),
            job: Job::None,
            aim: None,
            load: 0,
            ready: Cycle(0),
            worked: 0,
            made: 0,
            training: Vec::new(),
            is_worked_on: false,
        }
    }

    /// Returns whether it has something to do in the next cycle besides its motions.
    fn is_busy(&self) -> bool {
        let is_switching = matches!(self.mode, Mode::Switching | Mode::SwitchingBack | Mode::Site);
        self.is_alive && (self.job != Job::None || is_switching || !self.training.is_empty())
    }

    /// Returns what is to be seen of it.
    pub(crate) fn status(&self, can_be_hurt: bool, is_patch: bool) -> Status {
        Status {
            hit_points: can_be_hurt.then_some(self.hit_points),
            amount: is_patch.then_some(self.amount),
            mode: self.mode,
            action: self.job.action(),
        }
    }

    /// Returns what its owner knows of it, its motions apart; `making_cycles` is what it takes to make what it trains, or
    /// what the site will be.
    pub(crate) fn own(&self, now: Cycle, making_cycles: u32) -> Own {
        let left = making_cycles.saturating_sub(self.made);
        let is_worked_at = match self.mode {
            Mode::Normal | Mode::Alternate => !self.training.is_empty(),
            Mode::Switching | Mode::SwitchingBack => false,
            Mode::Site => self.is_worked_on,
        };
        let is_being_made = is_worked_at && left > 0;
        Own {
            queued: 0,
            task: self.job.task(),
            load: self.load,
            ready: self.ready,
            training: self.training.first().copied(),
            waiting: u32::try_from(self.training.len().saturating_sub(1)).unwrap_or(u32::MAX),
            due: is_being_made.then(|| Cycle(now.0.saturating_add(left))),
        }
    }

    /// Returns its part of the state hash.
    fn digest(&self, id: ObjectId) -> u64 {
        let mut bytes = Vec::with_capacity(160);
        let owner = self.owner.map_or(u16::MAX, |seat| seat.0);
        for number in [
            id.0,
            u32::from(owner) << 16 | u32::from(self.unit_type.0),
            self.index,
            self.hit_points,
            self.amount,
            self.mode as u32,
            self.mode_until.0,
            self.load,
            self.ready.0,
            self.worked,
            self.made,
            u32::from(self.is_worked_on),
        ] {
            bytes.extend_from_slice(&number.to_le_bytes());
        }
        for unit_type in &self.training {
            bytes.extend_from_slice(&unit_type.0.to_le_bytes());
        }
        if let Body::Rectangle { center, .. } = self.body {
            bytes.extend_from_slice(&center.x.to_le_bytes());
            bytes.extend_from_slice(&center.y.to_le_bytes());
        }
        self.job.write(&mut bytes);
        XxHash3_64::oneshot(&bytes)
    }
}

/// All objects of a match, by number; a dead one keeps its place.
#[derive(Debug, Default)]
pub(crate) struct Units {
    units: Vec<Unit>,
    /// The digest of each, as it is in the sum; 0 for the dead.
    digests: Vec<u64>,
    /// Those that may differ from their digest.
    touched: Vec<ObjectId>,
    is_touched: Vec<bool>,
    alive: BTreeSet<ObjectId>,
    /// Those with something to do besides their motions.
    busy: BTreeSet<ObjectId>,
    /// Wrapping sum of the digests of the living: rest costs nothing.
    sum: u64,
}

impl Units {
    /// Returns all objects, dead or alive, by number.
    pub(crate) fn all(&self) -> &[Unit] {
        &self.units
    }

    /// Adds an object that may be dead and returns its number.
    pub(crate) fn put_back(&mut self, unit: Unit) -> ObjectId {
        let is_alive = unit.is_alive;
        let id = self.push(unit);
        if !is_alive {
            self.alive.remove(&id);
        }
        id
    }

    /// Adds a living object and returns its number.
    pub(crate) fn push(&mut self, unit: Unit) -> ObjectId {
        let id = self.next_id();
        self.units.push(unit);
        self.digests.push(0);
        self.is_touched.push(false);
        self.alive.insert(id);
        self.touch(id);
        id
    }

    /// Returns the number that the next object will have.
    pub(crate) fn next_id(&self) -> ObjectId {
        ObjectId(u32::try_from(self.units.len()).expect("a match makes fewer than 2^32 objects"))
    }

    /// Returns an object to change it.
    pub(crate) fn edit(&mut self, id: ObjectId) -> &mut Unit {
        self.touch(id);
        &mut self.units[id.0 as usize]
    }

    /// Takes that an object is dead.
    pub(crate) fn kill(&mut self, id: ObjectId) {
        let unit = self.edit(id);
        assert!(unit.is_alive, "an object dies once");
        unit.is_alive = false;
        unit.job = Job::None;
        unit.training.clear();
        self.alive.remove(&id);
    }

    /// Brings the sum and the list of the busy up to date with all changes.
    pub(crate) fn settle(&mut self) {
        for id in self.touched.drain(..) {
            let place = id.0 as usize;
            let unit = &self.units[place];
            let digest = if unit.is_alive { unit.digest(id) } else { 0 };
            self.sum = self.sum.wrapping_sub(self.digests[place]).wrapping_add(digest);
            self.digests[place] = digest;
            self.is_touched[place] = false;
            if unit.is_busy() {
                self.busy.insert(id);
            } else {
                self.busy.remove(&id);
            }
        }
    }

    /// Returns an object, dead or alive; `None` if there never was one.
    pub(crate) fn find(&self, id: ObjectId) -> Option<&Unit> {
        self.units.get(id.0 as usize)
    }

    /// Returns an object, dead or alive, that there is.
    pub(crate) fn at(&self, id: ObjectId) -> &Unit {
        &self.units[id.0 as usize]
    }

    /// Returns whether an object is alive.
    pub(crate) fn is_alive(&self, id: ObjectId) -> bool {
        self.find(id).is_some_and(|unit| unit.is_alive)
    }

    /// Returns the living, by number.
    pub(crate) fn alive(&self) -> impl Iterator<Item = (ObjectId, &Unit)> {
        self.alive.iter().map(|&id| (id, self.at(id)))
    }

    /// Returns those with something to do besides their motions, by number, as they were when [`Units::settle`] last ran.
    pub(crate) fn busy(&self) -> Vec<ObjectId> {
        self.busy.iter().copied().collect()
    }

    /// Returns the wrapping sum of the digests, as it was when [`Units::settle`] last ran.
    pub(crate) fn sum(&self) -> u64 {
        self.sum
    }

    fn touch(&mut self, id: ObjectId) {
        if !std::mem::replace(&mut self.is_touched[id.0 as usize], true) {
            self.touched.push(id);
        }
    }
}
