//! Small matches in which everybody stands where a test wants it; what must hold in every match is checked after every cycle.

use std::collections::BTreeMap;

use glam::DVec2;
use maniple_geometry::ObjectId;
use maniple_view::{
    Command, EndOfTask, EndReason, Handle, Mode, Refusal, Seat, Sighting, Task, UnitType, UnitTypeId,
    hull_distance,
};

use crate::{Files, LoadedFile, Overrides, StartUnit, World, load};

/// What a stage is made of. Cycles are an eighth of a second.
pub(crate) struct Plan<'a> {
    /// Rules and unit types. Where no objective is among them, most resources win after a minute.
    pub(crate) tables: &'a str,
    /// The keys of each seat, besides its groups.
    pub(crate) seats: &'a [&'a str],
    /// The map.
    pub(crate) rows: &'a str,
    pub(crate) seed: u64,
}

impl Default for Plan<'_> {
    fn default() -> Self {
        Self { tables: "", seats: &["", ""], rows: OPEN, seed: 1 }
    }
}

/// A map 24 wide and 12 high without a wall.
pub(crate) const OPEN: &str = "........................\n........................\n........................\n\
                               ........................\n........................\n........................\n\
                               ........................\n........................\n........................\n\
                               ........................\n........................\n........................\n";

/// Who stands where: the seat, the unit type, the place, the resources in it.
pub(crate) type Stand<'a> = (Option<u16>, &'a str, (f64, f64), u32);

/// Returns where a unit of a seat stands.
pub(crate) fn own(seat: u16, unit_type: &str, x: f64, y: f64) -> Stand<'_> {
    (Some(seat), unit_type, (x, y), 0)
}

/// Returns where something of nobody stands, with so many resources.
pub(crate) fn nobodys(unit_type: &str, x: f64, y: f64, amount: u32) -> Stand<'_> {
    (None, unit_type, (x, y), amount)
}

impl Plan<'_> {
    /// Returns the match at its start; the place in `stands` is the number of the object.
    pub(crate) fn stage(&self, stands: &[Stand<'_>]) -> Stage {
        let mut scenario = format!(
            "name = 'stage'\nmap = 'stage.map'\nrate = 8\nlength_seconds = 60\nseed = {}\n{}\n\
             [unit.post]\nradius = 0.25\nspeed = 0\n",
            self.seed, self.tables
        );
        if !scenario.contains("[objective]") {
            scenario.push_str("[objective]\nkind = 'resources'\n");
        }
        for seat in self.seats {
            scenario.push_str(&format!("[[seat]]\n{seat}\ngroups = [{{ unit = 'post', count = 1 }}]\n"));
        }
        let width = self.rows.lines().next().map_or(0, str::len);
        let height = self.rows.lines().count();
        let map = format!("type octile\nheight {height}\nwidth {width}\nmap\n{}", self.rows);
        let file = |path: &str, text: String| LoadedFile { path: path.to_owned(), bytes: text.into_bytes() };
        let files = Files(vec![file("stage.toml", scenario), file("stage.map", map)]);
        let mut loaded = load(&files, "stage.toml", &Overrides::default()).unwrap();
        let unit_types = loaded.scenario.unit_types.clone();
        let start = |&(seat, name, (x, y), amount): &Stand<'_>| StartUnit {
            seat: seat.map(Seat),
            unit_type: named(&unit_types, name),
            position: DVec2::new(x, y),
            amount,
        };
        loaded.setup.units = stands.iter().map(start).collect();
        let seats = (0..).map(Seat).take(self.seats.len()).collect();
        let world = World::new(&loaded).unwrap();
        Stage { world, unit_types, seats, deviation: 1e-9, ended: Vec::new(), shots: Vec::new() }
    }
}

/// A match, and what has happened in it.
pub(crate) struct Stage {
    pub(crate) world: World,
    pub(crate) unit_types: Vec<UnitType>,
    pub(crate) seats: Vec<Seat>,
    /// By how much what is told of a motion may differ from the world, which rounds each position.
    pub(crate) deviation: f64,
    /// All tasks that have ended: in which cycle, whose, what and why.
    pub(crate) ended: Vec<(u32, u32, Task, EndOfTask)>,
    /// All shots: in which cycle, who, at whom.
    pub(crate) shots: Vec<(u32, u32, Option<u32>)>,
}

impl Stage {
    /// Lets the owner of an object tell it something; what it is aimed at is the handle in the command.
    pub(crate) fn tell(&mut self, command: &Command) -> Result<(), Refusal> {
        let object = ObjectId(command.object().unwrap().0);
        let owner = self.see(object.0).and_then(|sighting| sighting.owner).unwrap();
        self.tell_as(owner.0, command)
    }

    /// Lets a seat give a command.
    pub(crate) fn tell_as(&mut self, seat: u16, command: &Command) -> Result<(), Refusal> {
        let object = command.object().map_or(ObjectId(0), |handle| ObjectId(handle.0));
        let target = command.target().map(|handle| ObjectId(handle.0));
        self.world.command(Seat(seat), object, command, target)
    }

    /// Plays so many cycles, or until the match has ended.
    pub(crate) fn step(&mut self, cycles: u32) {
        for _ in 0..cycles {
            if self.world.ending().is_some() {
                return;
            }
            let played = self.world.cycle().0;
            let before = self.all();
            self.world.step();
            self.check(&before);
            self.ended.extend(self.world.ended().iter().map(|&(id, task, why)| (played, id.0, task, why)));
            let shot =
                |&(id, target): &(ObjectId, Option<ObjectId>)| (played, id.0, target.map(|target| target.0));
            self.shots.extend(self.world.fired().iter().map(shot));
        }
    }

    /// Plays until something holds, and returns how many cycles that took.
    pub(crate) fn step_until(&mut self, holds: impl Fn(&Self) -> bool) -> u32 {
        let start = self.world.cycle().0;
        while !holds(self) {
            assert!(
                self.world.cycle().0 < start + 400 && self.world.ending().is_none(),
                "it never came about"
            );
            self.step(1);
        }
        self.world.cycle().0 - start
    }

    /// Plays until the present task of an object has ended, and returns why.
    pub(crate) fn outcome(&mut self, object: u32) -> EndOfTask {
        let known = self.ended.len();
        let is_new = |stage: &Self| stage.ended[known..].iter().any(|&(_, id, ..)| id == object);
        self.step_until(is_new);
        let of_object = self.ended[known..].iter().find(|&&(_, id, ..)| id == object);
        of_object.map(|&(.., why)| why).unwrap()
    }

    /// Returns a living object.
    pub(crate) fn see(&self, object: u32) -> Option<Sighting> {
        self.all().get(&ObjectId(object)).copied()
    }

    /// Returns all living objects that anybody sees.
    pub(crate) fn all(&self) -> BTreeMap<ObjectId, Sighting> {
        let seen = self.seats.iter().flat_map(|&seat| self.world.sightings(seat).into_owned());
        seen.map(|sighting| (sighting.object, sighting)).collect()
    }

    /// Returns what a living object can still take.
    pub(crate) fn hit_points(&self, object: u32) -> u32 {
        self.see(object).unwrap().status.hit_points.unwrap()
    }

    pub(crate) fn mode(&self, object: u32) -> Mode {
        self.see(object).unwrap().status.mode
    }

    pub(crate) fn task(&self, object: u32) -> Task {
        self.see(object).unwrap().own.task
    }

    pub(crate) fn load(&self, object: u32) -> u32 {
        self.see(object).unwrap().own.load
    }

    pub(crate) fn place(&self, object: u32) -> DVec2 {
        self.see(object).unwrap().base.position(self.world.cycle())
    }

    pub(crate) fn is_moving(&self, object: u32) -> bool {
        self.see(object).unwrap().base.is_moving()
    }

    pub(crate) fn stock(&self, seat: u16) -> u32 {
        self.world.stock(Seat(seat))
    }

    /// Returns how the match has ended: why, and who has won.
    pub(crate) fn ending(&self) -> Option<(EndReason, Vec<u16>)> {
        let winners = |winners: &[Seat]| winners.iter().map(|seat| seat.0).collect();
        self.world.ending().map(|ending| (ending.reason, winners(&ending.winners)))
    }

    pub(crate) fn unit_type(&self, name: &str) -> UnitTypeId {
        named(&self.unit_types, name)
    }

    pub(crate) fn kind(&self, sighting: &Sighting) -> &UnitType {
        &self.unit_types[usize::from(sighting.unit_type.0)]
    }

    /// Checks what must hold after every cycle of every match; `before` are the objects before it.
    fn check(&self, before: &BTreeMap<ObjectId, Sighting>) {
        let now = self.world.cycle();
        let all = self.all();
        let living: Vec<(&Sighting, DVec2)> =
            all.values().map(|sighting| (sighting, sighting.base.position(now))).collect();
        for (place, &(one, at)) in living.iter().enumerate() {
            let kind = self.kind(one);
            let hit_points = one.status.hit_points;
            assert_eq!(hit_points.is_some(), kind.hit_points.is_some(), "{one:?}");
            assert!(hit_points.is_none_or(|hit_points| hit_points > 0), "dead and there: {one:?}");
            assert!(hit_points <= kind.hit_points, "more than it can have: {one:?}");
            assert!(one.own.load <= kind.harvest.map_or(0, |harvest| harvest.load_max), "{one:?}");
            for &(other, there) in &living[..place] {
                let other_kind = self.kind(other);
                if kind.layer == other_kind.layer {
                    let distance = hull_distance(there - at, &kind.shape, &other_kind.shape);
                    assert!(distance > -self.deviation, "overlap by {distance}: {one:?} {other:?}");
                }
            }
        }
        self.check_news(before, &all);
    }

    /// Checks that all news is of objects that there were, and that who died is gone.
    fn check_news(&self, before: &BTreeMap<ObjectId, Sighting>, after: &BTreeMap<ObjectId, Sighting>) {
        for &(id, target) in self.world.fired() {
            let shooter = before.get(&id).expect("who fires was there");
            assert!(self.kind(shooter).weapon.is_some() || self.kind(shooter).alternate.is_some());
            assert!(target.is_none_or(|target| before.contains_key(&target)), "{id:?} fires at nobody");
        }
        for &(id, task, _) in self.world.ended() {
            let known = before.get(&id).or(after.get(&id));
            assert!(known.is_some_and(|known| known.owner.is_some()), "{id:?} was nobody");
            assert_ne!(task, Task::None);
        }
        for &seat in &self.seats {
            for id in self.world.died(seat) {
                assert!(before.contains_key(&id) && !after.contains_key(&id), "{id:?} has not died");
            }
        }
    }
}

fn named(unit_types: &[UnitType], name: &str) -> UnitTypeId {
    let place = unit_types.iter().position(|unit_type| unit_type.name == name).unwrap();
    UnitTypeId(u16::try_from(place).unwrap())
}

pub(crate) fn go(object: u32, x: f64, y: f64) -> Command {
    Command::Move { object: Handle(object), x, y, s: None, queue: false, start: None }
}

pub(crate) fn stop(object: u32) -> Command {
    Command::Stop { object: Handle(object) }
}

pub(crate) fn attack(object: u32, target: u32) -> Command {
    Command::Attack { object: Handle(object), target: Handle(target) }
}

pub(crate) fn attack_at(object: u32, x: f64, y: f64) -> Command {
    Command::AttackAt { object: Handle(object), x, y }
}

pub(crate) fn attack_move(object: u32, x: f64, y: f64) -> Command {
    Command::AttackMove { object: Handle(object), x, y }
}

pub(crate) fn hold(object: u32) -> Command {
    Command::Hold { object: Handle(object) }
}

pub(crate) fn gather(object: u32, patch: u32) -> Command {
    Command::Gather { object: Handle(object), patch: Handle(patch) }
}

pub(crate) fn return_load(object: u32) -> Command {
    Command::ReturnLoad { object: Handle(object) }
}

pub(crate) fn build(object: u32, unit_type: UnitTypeId, x: f64, y: f64) -> Command {
    Command::Build { object: Handle(object), unit_type, x, y }
}

pub(crate) fn train(object: u32, unit_type: UnitTypeId) -> Command {
    Command::Train { object: Handle(object), unit_type }
}

pub(crate) fn cancel(object: u32) -> Command {
    Command::Cancel { object: Handle(object) }
}

pub(crate) fn switch(object: u32) -> Command {
    Command::Switch { object: Handle(object) }
}
