//! What seats do beside the script: the watcher by its view alone, the others as each world's own chance has it.

use std::collections::BTreeMap;

use glam::DVec2;
use maniple_geometry::{Cycle, ObjectId};
use maniple_view::{Command, Handle, Seat, Sighting, UnitType, UnitTypeId, View};

use super::dice::Dice;
use super::scene::{ARENAS, FAR, HEIGHT, Role, is_exact};

/// Where an object is told to go.
fn go(object: Handle, at: DVec2) -> Command {
    Command::Move { object, x: at.x, y: at.y, s: None, queue: false, start: None }
}

/// A seat's names for the objects that it sees, made by the rule of `docs/PROTOCOL.md`.
#[derive(Clone, Debug, Default)]
pub(super) struct Names {
    now: BTreeMap<ObjectId, Handle>,
    next: u32,
}

impl Names {
    /// Takes what the seat sees at the start of a cycle.
    pub(super) fn update(&mut self, cycle: Cycle, sightings: &[Sighting]) {
        let mut newcomers: Vec<&Sighting> =
            sightings.iter().filter(|it| !self.now.contains_key(&it.object)).collect();
        newcomers.sort_by(|a, b| order(a, b, cycle));
        self.now.retain(|object, _| sightings.iter().any(|it| it.object == *object));
        for newcomer in newcomers {
            self.now.insert(newcomer.object, Handle(self.next));
            self.next += 1;
        }
    }

    pub(super) fn of(&self, object: ObjectId) -> Option<Handle> {
        self.now.get(&object).copied()
    }
}

/// Compares newcomers: by (y, x, layer).
pub(super) fn order(a: &Sighting, b: &Sighting, cycle: Cycle) -> std::cmp::Ordering {
    let (one, other) = (a.base.position(cycle), b.base.position(cycle));
    one.y.total_cmp(&other.y).then(one.x.total_cmp(&other.x)).then(a.layers.cmp(&b.layers))
}

/// Handles that are of no use any more.
#[derive(Clone, Debug, Default)]
pub(super) struct Gone {
    pub(super) vanished: Vec<Handle>,
    pub(super) died: Vec<Handle>,
    /// The first handle that nobody has had.
    pub(super) next: u32,
}

/// The watcher, who knows its view and nothing else.
pub(super) struct Watcher {
    pub(super) seat: Seat,
    pub(super) dice: Dice,
    pub(super) unit_types: Vec<UnitType>,
}

impl Watcher {
    /// Returns what it tells its own.
    pub(super) fn orders(&mut self, view: &View) -> Vec<Command> {
        let [scout, hut] = ["scout", "hut"].map(|name| id(&self.unit_types, name));
        let own: Vec<(Handle, UnitTypeId)> = view
            .objects_of(self.seat)
            .map(|(handle, it)| (handle, it.unit_type))
            .filter(|&(_, unit_type)| unit_type != scout || view.cycle().0 > 20)
            .collect();
        let others: Vec<Handle> =
            view.objects().filter(|(_, it)| it.owner != Some(self.seat)).map(|(handle, _)| handle).collect();
        let mut orders = Vec::new();
        for _ in 0..self.dice.below(4) {
            if own.is_empty() {
                break;
            }
            let (object, unit_type) = self.dice.one(&own);
            let target = if others.is_empty() { Handle(u32::MAX) } else { self.dice.one(&others) };
            let kind = &self.unit_types[usize::from(unit_type.0)];
            let order = if kind.trains.is_empty() {
                self.order(object, target, hut)
            } else if self.dice.percent(80) {
                Command::Train { object, unit_type: self.dice.one(&kind.trains) }
            } else {
                Command::Cancel { object }
            };
            orders.push(order);
        }
        orders
    }

    fn order(&mut self, object: Handle, target: Handle, hut: UnitTypeId) -> Command {
        let at = DVec2::new(self.dice.between(1, 12), self.dice.between(1, HEIGHT - 1));
        let (x, y) = (at.x, at.y);
        match self.dice.below(14) {
            0..=2 => go(object, at),
            3..=5 => Command::Attack { object, target },
            6 => Command::AttackMove { object, x, y },
            7 => Command::Hold { object },
            8 => Command::AttackAt { object, x, y },
            9 | 10 => Command::Gather { object, patch: target },
            11 => Command::ReturnLoad { object },
            12 => Command::Build { object, unit_type: hut, x, y },
            _ => Command::Switch { object },
        }
    }

    /// Returns a command to an object that is not its own.
    pub(super) fn foreign_command(&mut self, object: Handle) -> Command {
        let (x, y) = self.dice.one(&[(f64::NAN, -1.0), (3.0, 3.0), (-0.0, 1e300)]);
        match self.dice.below(9) {
            0 => Command::Stop { object },
            1 => Command::Attack { object, target: Handle(0) },
            2 => Command::Hold { object },
            3 => Command::Train { object, unit_type: UnitTypeId(self.dice.one(&[0, 5, 999])) },
            4 => Command::Build { object, unit_type: UnitTypeId(3), x, y },
            5 => Command::Cancel { object },
            6 => Command::Switch { object },
            7 => Command::Path { object, points: Vec::new(), start: None },
            _ => Command::Move { object, x, y, s: Some(1e9), queue: true, start: Some((Cycle(0), 7.0)) },
        }
    }
}

/// What is done in one world alone.
pub(super) struct Secret<'a> {
    pub(super) dice: &'a mut Dice,
    pub(super) cycle: Cycle,
    pub(super) watcher: Seat,
    pub(super) objects: &'a [Sighting],
    pub(super) unit_types: &'a [UnitType],
    /// By seat.
    pub(super) names: &'a [Names],
    /// The roles, and where they have been told to go.
    pub(super) roles: &'a BTreeMap<ObjectId, (Role, Option<DVec2>)>,
}

impl Secret<'_> {
    /// Returns what other seats do that the watcher cannot see.
    pub(super) fn orders(&mut self) -> Vec<(Seat, Command)> {
        let mut orders = Vec::new();
        for _ in 0..1 + self.dice.below(5) {
            let it = self.dice.one(self.objects);
            let Some(seat) = it.owner.filter(|&owner| owner != self.watcher) else {
                continue;
            };
            let Some(object) = self.names[seat.index()].of(it.object) else {
                continue;
            };
            let order = match self.roles.get(&it.object) {
                Some(&(_, goal)) => self.hint(&it, object, goal),
                None => self.brawl(&it, object, seat),
            };
            orders.extend(order.map(|order| (seat, order)));
        }
        orders
    }

    /// Returns an order to somebody who may be in sight, of which nothing is to be seen.
    fn hint(&mut self, it: &Sighting, object: Handle, goal: Option<DVec2>) -> Option<Command> {
        let kind = &self.unit_types[usize::from(it.unit_type.0)];
        let at = it.base.position(self.cycle);
        let later = Some((Cycle(self.cycle.0 + 1000), 0.5));
        if kind.speed == 0.0 {
            let idol = id(self.unit_types, "idol");
            let train = Command::Train { object, unit_type: idol };
            return Some(if self.dice.percent(60) { train } else { Command::Cancel { object } });
        }
        if it.own.task != maniple_view::Task::None {
            return None;
        }
        if !it.base.is_moving() {
            return Some(match self.dice.below(3) {
                0 => Command::Stop { object },
                1 => go(object, at),
                _ => Command::Move { object, x: 40.0, y: 10.0, s: None, queue: false, start: later },
            });
        }
        let goal = goal?;
        let (way, velocity) = (goal - at, it.base.velocity);
        // Elsewhere a new order would begin at a place that is rounded.
        let is_on_lattice = (at * 16.0).fract() == DVec2::ZERO;
        let is_along = is_on_lattice && way.perp_dot(velocity) == 0.0 && way.dot(velocity) > 0.0;
        if !is_along || (way.x != 0.0 && way.y != 0.0) || !is_exact(way.length(), kind.speed) {
            return None;
        }
        let half = (at + goal) * 0.5;
        let is_half_exact =
            is_exact((half - at).length(), kind.speed) && is_exact((goal - half).length(), kind.speed);
        Some(if is_half_exact && self.dice.percent(30) {
            let points = [half, goal].map(|at| (at.x, at.y, None)).to_vec();
            Command::Path { object, points, start: None }
        } else {
            go(object, goal)
        })
    }

    /// Returns an order to somebody out of sight.
    fn brawl(&mut self, it: &Sighting, object: Handle, seat: Seat) -> Option<Command> {
        let at = it.base.position(self.cycle);
        let is_inside = |at: DVec2| {
            move |&(left, top, right, bottom): &(u32, u32, u32, u32)| {
                let [left, top, right, bottom] = [left, top, right, bottom].map(f64::from);
                left <= at.x && at.x <= right && top <= at.y && at.y <= bottom
            }
        };
        let (left, top, right, bottom) = *ARENAS.iter().find(|arena| is_inside(at)(arena))?;
        let kind = &self.unit_types[usize::from(it.unit_type.0)];
        if !kind.trains.is_empty() {
            let unit_type = self.dice.one(&kind.trains);
            return Some(if self.dice.percent(85) {
                Command::Train { object, unit_type }
            } else {
                Command::Cancel { object }
            });
        }
        let is_late = self.cycle.0 > 50;
        let targets: Vec<Handle> = self
            .objects
            .iter()
            .filter(|other| other.owner != Some(seat))
            .filter(|other| {
                let at = other.base.position(self.cycle);
                ARENAS.iter().any(is_inside(at)) || is_late && at.x > f64::from(FAR) + 1.0
            })
            .filter_map(|other| self.names[seat.index()].of(other.object))
            .collect();
        let to = DVec2::new(self.dice.between(left, right), self.dice.between(top, bottom));
        let (x, y) = (to.x, to.y);
        let target = if targets.is_empty() { Handle(u32::MAX) } else { self.dice.one(&targets) };
        Some(match self.dice.below(12) {
            0 | 1 => go(object, to),
            2..=4 => Command::Attack { object, target },
            5 => Command::Gather { object, patch: target },
            6 => Command::AttackMove { object, x, y },
            7 => Command::Hold { object },
            8 => Command::ReturnLoad { object },
            9 => Command::Switch { object },
            10 => Command::AttackAt { object, x, y },
            _ => Command::Build { object, unit_type: id(self.unit_types, "hut"), x, y },
        })
    }
}

/// Returns the number of a unit type.
fn id(unit_types: &[UnitType], name: &str) -> UnitTypeId {
    let place = unit_types.iter().position(|it| it.name == name).expect("the scene has it");
    UnitTypeId(u16::try_from(place).expect("there are few"))
}
