//! Matches at random, with every rule there is: whatever seats do, nothing breaks, nothing is lost, and it comes out the same again.

use std::collections::BTreeMap;

use maniple_geometry::{Cycle, ObjectId};
use maniple_view::{Command, EndOfTask, Handle, Layer, Mode, Refusal, Seat, Sighting, Task, UnitTypeId};

use super::stage::{Plan, Stage, Stand, nobodys, own};

pub(super) const TABLES: &str = "
[combat]
friendly_fire = true
[harvest]
patch = 'ore'
[production]
[modes]
[neutral]
groups = [{ unit = 'sheep', count = 1 }]
wander = 3
pause_seconds = 1
[unit.worker]
radius = 0.25
speed = 4
sight = 7
hit_points = 40
cost = 10
make_seconds = 1
harvest = { load_max = 4, seconds_each = 0.25 }
builds = ['house', 'hut']
[unit.tank]
radius = 0.3
speed = 3
sight = 5
hit_points = 60
armor = 1
cost = 20
make_seconds = 1
requires = ['hut']
weapon = { range = 3, cooldown_seconds = 0.5, damage_min = 0, damage_max = 9 }
[unit.tank.alternate]
name = 'siege'
switch_seconds = 1
speed = 0
armor = 3
weapon = { range = 6, range_min = 1, cooldown_seconds = 1, damage_min = 10, damage_max = 20, splash_radius = 1.5, splash_falloff = 'linear' }
[unit.jet]
radius = 0.3
speed = 6
layer = 'air'
hit_points = 30
cost = 20
make_seconds = 0.5
weapon = { range = 2, cooldown_seconds = 0.5, damage_min = 5, damage_max = 5, splash_radius = 0.5 }
[unit.house]
width = 2
height = 1.5
speed = 0
hit_points = 120
takes_loads = true
cost = 30
make_seconds = 2
trains = ['worker', 'tank', 'jet']
[unit.hut]
radius = 0.5
speed = 0
hit_points = 50
cost = 15
make_seconds = 1
takes_loads = true
requires = ['house']
weapon = { range = 4, cooldown_seconds = 0.5, damage_min = 3, damage_max = 6, targets = ['air'] }
[unit.ore]
radius = 0.4
speed = 0
patch = { places = 2 }
[unit.sheep]
radius = 0.25
speed = 2
hit_points = 10
";

const ROWS: &str = "........................\n........................\n........................\n\
                    ...........@@...........\n..@.......@.........@...\n........................\n\
                    ........................\n....@..............@....\n.......@@......@@.......\n\
                    ........................\n........................\n........................\n";

/// What has happened in matches: how often each command was taken, and each task ended for each reason.
#[derive(Default)]
struct Coverage {
    taken: BTreeMap<&'static str, u32>,
    ended: Vec<(Task, EndOfTask)>,
    died: usize,
    sites: usize,
}

#[test]
fn whatever_seats_do_nothing_breaks_nothing_is_lost_and_it_comes_out_the_same_again() {
    let mut coverage = Coverage::default();
    let settings = [
        ("", 1e-9),
        ("[vision]", 1e-9),
        ("[kinematics]\nstops = 'approaching'\n[vision]", 1e-9),
        ("[kinematics]\nscalar = 'f32'", 1e-4),
        ("[kinematics]\nsolver = 'stepped'\nsubsteps = 4\n[vision]", 1e-9),
        ("[kinematics]\nskin = 0.03125", 1e-9),
        ("[kinematics]\nskin = 1", 1e-9),
    ];
    for (place, (setting, deviation)) in settings.into_iter().enumerate() {
        for seed in 0..2 {
            let seed = seed + 100 * place as u64;
            println!("{setting:?} with seed {seed}");
            let told = play(setting, deviation, seed, &mut coverage);
            repeat(setting, deviation, seed, &told);
        }
    }
    for command in [
        "move",
        "path",
        "stop",
        "attack",
        "attack_at",
        "attack_move",
        "hold",
        "gather",
        "return_load",
        "build",
        "train",
        "cancel",
        "switch",
        "resign",
    ] {
        assert!(coverage.taken.contains_key(command), "{command} was never taken: {:?}", coverage.taken);
    }
    for why in [
        EndOfTask::Done,
        EndOfTask::Blocked,
        EndOfTask::Lost,
        EndOfTask::Empty,
        EndOfTask::NoRoom,
        EndOfTask::NotAffordable,
    ] {
        assert!(coverage.ended.iter().any(|&(_, ended)| ended == why), "no task has ended as {why:?}");
    }
    for task in [Task::Attack, Task::AttackMove, Task::Gather, Task::ReturnLoad, Task::Build] {
        assert!(coverage.ended.contains(&(task, EndOfTask::Done)), "{task:?} was never done");
    }
    assert!(coverage.died > 100 && coverage.sites > 20, "{} {}", coverage.died, coverage.sites);
}

/// What was told in each cycle, how it was answered, and the hash after it.
type Told = Vec<(Vec<(u16, Command, Result<(), Refusal>)>, u64)>;

fn stage(setting: &str, deviation: f64, seed: u64) -> Stage {
    let mut stands: Vec<Stand<'_>> = Vec::new();
    for (seat, (x, y)) in (0..).zip([(3.0, 2.0), (20.0, 2.0), (12.0, 10.0)]) {
        stands.extend([own(seat, "house", x, y), own(seat, "hut", x - 2.0, y), own(seat, "jet", x, y)]);
        stands.extend((0..3).map(|place| own(seat, "worker", x + f64::from(place) - 1.0, y + 1.75)));
        stands.extend((0..2).map(|place| own(seat, "tank", x + f64::from(place), y - 1.25)));
    }
    stands.extend([
        nobodys("ore", 6.0, 5.5, 30),
        nobodys("ore", 17.0, 5.5, 30),
        nobodys("ore", 12.0, 6.5, 9),
    ]);
    stands.extend([nobodys("sheep", 9.5, 9.0, 0), nobodys("sheep", 18.0, 9.0, 0)]);
    let tables = format!("{setting}\n{TABLES}");
    let seats = ["stock = 250\nteam = 7", "stock = 250", "stock = 250\nteam = 7"];
    let stage = Plan { tables: &tables, seats: &seats, rows: ROWS, seed }.stage(&stands);
    Stage { deviation, ..stage }
}

/// Plays at random and checks each cycle.
fn play(setting: &str, deviation: f64, seed: u64, coverage: &mut Coverage) -> Told {
    let mut stage = stage(setting, deviation, seed);
    let mut dice = Dice::new(seed);
    let mut told = Told::new();
    while stage.world.ending().is_none() {
        let mut commands = Vec::new();
        for seat in [0, 1, 2] {
            while dice.below(3) == 0 {
                let command = dice.command(&stage, seat);
                let answer = tell_and_check(&mut stage, seat, &command);
                if answer.is_ok() {
                    *coverage.taken.entry(name(&command)).or_default() += 1;
                }
                commands.push((seat, command, answer));
            }
        }
        let before = stage.all();
        let stocks = [0, 1, 2].map(|seat| stage.stock(seat));
        stage.step(1);
        check_resources(&stage, &before, stocks);
        coverage.died += before.keys().filter(|id| !stage.all().contains_key(id)).count();
        coverage.sites += founded(&stage, &before).count();
        told.push((commands, stage.world.hash().0));
    }
    coverage.ended.extend(stage.ended.iter().map(|&(.., task, why)| (task, why)));
    told
}

/// Plays the same again, with the commands of a cycle in another order of the seats.
fn repeat(setting: &str, deviation: f64, seed: u64, told: &Told) {
    let mut stage = stage(setting, deviation, seed);
    for (cycle, (commands, hash)) in told.iter().enumerate() {
        for seat in [2, 0, 1] {
            for (_, command, answer) in commands.iter().filter(|(by, ..)| *by == seat) {
                assert_eq!(&stage.tell_as(seat, command), answer, "cycle {cycle}, seat {seat}: {command:?}");
            }
        }
        stage.world.step();
        assert_eq!(stage.world.hash().0, *hash, "cycle {cycle}");
    }
}

/// Gives a command; nothing but training and giving up touches the stock of a seat, by what it costs.
fn tell_and_check(stage: &mut Stage, seat: u16, command: &Command) -> Result<(), Refusal> {
    let before = [0, 1, 2].map(|seat| stage.stock(seat));
    let answer = stage.tell_as(seat, command);
    let after = [0, 1, 2].map(|seat| stage.stock(seat));
    for other in 0..3 {
        assert!(u32::from(seat) == other || before[other as usize] == after[other as usize], "{command:?}");
    }
    let (before, after) = (before[usize::from(seat)], after[usize::from(seat)]);
    let cost = |unit_type: UnitTypeId| stage.unit_types[usize::from(unit_type.0)].making.cost;
    if let (Command::Train { unit_type, .. }, Ok(())) = (command, &answer) {
        assert_eq!(before - after, cost(*unit_type));
    } else if let (Command::Cancel { .. }, Ok(())) = (command, &answer) {
        assert!(stage.unit_types.iter().any(|kind| kind.making.cost == after - before), "{command:?}");
    } else {
        assert_eq!(before, after, "{command:?} {answer:?}");
    }
    answer
}

/// Checks that every resource that is gone from one place in a cycle has come to another one.
fn check_resources(stage: &Stage, before: &BTreeMap<ObjectId, Sighting>, stocks: [u32; 3]) {
    let after = stage.all();
    let ended = stage.world.ended();
    for seat in [0, 1, 2] {
        let brought =
            ended.iter().filter(|&&(_, task, why)| (task, why) == (Task::ReturnLoad, EndOfTask::Done));
        let brought = brought.map(|(id, ..)| &before[id]).filter(|carrier| carrier.owner == Some(Seat(seat)));
        let brought: u32 = brought.map(|carrier| carrier.own.load).sum();
        let sites = founded(stage, before).filter(|site| site.owner == Some(Seat(seat)));
        let paid: u32 = sites.map(|site| stage.kind(&site).making.cost).sum();
        assert_eq!(stage.stock(seat) + paid, stocks[usize::from(seat)] + brought, "seat {seat}");
    }
    let is_gone = |id: &ObjectId| stage.seats.iter().any(|&seat| stage.world.died(seat).contains(id));
    let taken = |(id, was): (&ObjectId, &Sighting)| {
        let left = after.get(id).map_or(was.status.amount.filter(|_| !is_gone(id)), |now| now.status.amount);
        was.status.amount.unwrap_or(0) - left.unwrap_or(0)
    };
    let taken: u32 = before.iter().map(taken).sum();
    let carried: u32 = after
        .iter()
        .map(|(id, it)| it.own.load.saturating_sub(before.get(id).map_or(0, |it| it.own.load)))
        .sum();
    let dead =
        before.iter().filter(|(id, it)| !after.contains_key(id) && stage.kind(it).harvest.is_some()).count();
    assert!(
        carried <= taken && taken <= carried + u32::try_from(dead).unwrap(),
        "{taken} taken, {carried} carried, {dead} dead"
    );
    for (id, now) in &after {
        let was = before.get(id).and_then(|was| was.status.hit_points);
        assert!(was.is_none() || now.status.hit_points <= was, "{id:?} has healed");
        let at = now.base.position(stage.world.cycle());
        assert!((0.0..=24.0).contains(&at.x) && (0.0..=12.0).contains(&at.y), "{id:?} is out of the world");
    }
}

/// Returns the sites that are there, and were not before.
fn founded<'a>(
    stage: &Stage,
    before: &'a BTreeMap<ObjectId, Sighting>,
) -> impl Iterator<Item = Sighting> + 'a {
    let new = |(id, it): (ObjectId, Sighting)| {
        (!before.contains_key(&id) && it.status.mode == Mode::Site).then_some(it)
    };
    stage.all().into_iter().filter_map(new)
}

/// Numbers that look random (Steele, Lea and Flood, *Fast splittable pseudorandom number generators*, 2014).
pub(super) struct Dice(u64);

impl Dice {
    pub(super) fn new(seed: u64) -> Self {
        Self(seed)
    }

    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mixed = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        mixed ^ (mixed >> 31)
    }

    pub(super) fn below(&mut self, end: u32) -> u32 {
        u32::try_from(self.next() % u64::from(end)).unwrap()
    }

    pub(super) fn one<T: Copy>(&mut self, of: &[T]) -> T {
        of[self.below(u32::try_from(of.len()).unwrap()) as usize]
    }

    /// Returns a coordinate, mostly within the world.
    pub(super) fn coordinate(&mut self, end: u32) -> f64 {
        match self.below(40) {
            0 => self.one(&[0.0, -0.0, f64::from(end), -1.0, 1e300, f64::NAN, f64::INFINITY]),
            1..10 => f64::from(self.below(end)) + 0.5,
            _ => f64::from(end) * (self.next() >> 11) as f64 / (1_u64 << 53) as f64,
        }
    }

    /// Returns an object: mostly one for which something holds, sometimes any, or none.
    fn object(&mut self, stage: &Stage, is_meant: impl Fn(&Sighting) -> bool) -> Handle {
        let all = stage.all();
        let meant: Vec<u32> = all.values().filter(|it| is_meant(it)).map(|it| it.object.0).collect();
        if meant.is_empty() || self.below(12) == 0 {
            return Handle(self.below(60));
        }
        Handle(self.one(&meant))
    }

    /// Returns one of these types, and sometimes any.
    fn unit_type(&mut self, stage: &Stage, names: &[&str]) -> UnitTypeId {
        match self.below(8) {
            0 => UnitTypeId(self.one(&[0, 1, 2, 3, 4, 5, 6, 7, 99])),
            _ => stage.unit_type(self.one(names)),
        }
    }

    fn command(&mut self, stage: &Stage, seat: u16) -> Command {
        let is_own = |it: &Sighting| it.owner == Some(Seat(seat));
        let (x, y) = (self.coordinate(24), self.coordinate(12));
        let s = if self.below(4) == 0 { Some(self.coordinate(1)) } else { None };
        let soon = Cycle(stage.world.cycle().0 + self.below(6));
        let start = if self.below(4) == 0 { Some((soon, self.coordinate(1))) } else { None };
        let queue = self.below(3) == 0;
        let armed = |it: &Sighting| is_own(it) && stage.kind(it).weapon.is_some();
        let works = |it: &Sighting| is_own(it) && stage.kind(it).harvest.is_some();
        match self.below(60) {
            0..5 => Command::Move { object: self.object(stage, is_own), x, y, s, queue, start },
            5..7 => {
                let points =
                    (0..self.below(4)).map(|_| (self.coordinate(24), self.coordinate(12), None)).collect();
                Command::Path { object: self.object(stage, is_own), points, start }
            }
            7 => Command::Stop { object: self.object(stage, is_own) },
            8..14 => {
                let target = self.object(stage, |it| it.owner != Some(Seat(seat)));
                Command::Attack { object: self.object(stage, armed), target }
            }
            14..17 => Command::AttackAt { object: self.object(stage, armed), x, y },
            17..22 => Command::AttackMove { object: self.object(stage, armed), x, y },
            22..25 => Command::Hold { object: self.object(stage, armed) },
            25..33 => {
                let patch = self.object(stage, |it| it.status.amount.is_some());
                Command::Gather { object: self.object(stage, works), patch }
            }
            33..39 => Command::ReturnLoad { object: self.object(stage, |it| works(it) && it.own.load > 0) },
            39..45 => {
                let unit_type = self.unit_type(stage, &["house", "hut"]);
                let object = self.object(stage, works);
                match stage.see(object.0).filter(|_| self.below(5) > 0).map(|_| stage.place(object.0)) {
                    Some(here) => {
                        let (x, y) = (here.x - 3.0 + self.coordinate(6), here.y - 2.0 + self.coordinate(4));
                        Command::Build { object, unit_type, x, y }
                    }
                    None => Command::Build { object, unit_type, x, y },
                }
            }
            45..51 => {
                let object = self.object(stage, |it| is_own(it) && !stage.kind(it).trains.is_empty());
                let unit_type = self.unit_type(stage, &["worker", "tank", "jet"]);
                Command::Train { object, unit_type }
            }
            51..53 => {
                let object = self.object(stage, |it| is_own(it) && it.status.mode == Mode::Site);
                Command::Cancel { object }
            }
            53..55 => {
                Command::Cancel { object: self.object(stage, |it| is_own(it) && it.own.training.is_some()) }
            }
            55..59 => {
                let object = self.object(stage, |it| armed(it) && stage.kind(it).layer == Layer::Ground);
                Command::Switch { object }
            }
            _ if self.below(20) == 0 => Command::Resign,
            _ => Command::Hold { object: self.object(stage, armed) },
        }
    }
}

fn name(command: &Command) -> &'static str {
    match command {
        Command::Move { .. } => "move",
        Command::Path { .. } => "path",
        Command::Stop { .. } => "stop",
        Command::Resign => "resign",
        Command::Attack { .. } => "attack",
        Command::AttackAt { .. } => "attack_at",
        Command::AttackMove { .. } => "attack_move",
        Command::Hold { .. } => "hold",
        Command::Gather { .. } => "gather",
        Command::ReturnLoad { .. } => "return_load",
        Command::Build { .. } => "build",
        Command::Train { .. } => "train",
        Command::Cancel { .. } => "cancel",
        Command::Switch { .. } => "switch",
    }
}
