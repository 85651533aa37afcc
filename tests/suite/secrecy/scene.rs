//! Generated pairs of worlds: a part of the map that the watcher sees, and one that it does not, in which they differ.

#![expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "numbers of a scene are small, and coordinates not negative"
)]

use std::collections::BTreeMap;

use glam::DVec2;
use maniple_game::{Files, Loaded, LoadedFile, Overrides, StartUnit, load};
use maniple_view::{Seat, UnitType, UnitTypeId};

use super::dice::Dice;
use super::script::{self, Line};

/// Tiles of a map, across and down.
pub(super) const WIDTH: u32 = 56;
pub(super) const HEIGHT: u32 = 20;

/// Columns right of which the watcher sees nothing at the start.
pub(super) const FAR: u32 = 28;

/// What is hidden at the start but for those on the lanes: left, top, right and bottom of two rectangles.
pub(super) const ARENAS: [(u32, u32, u32, u32); 2] = [(30, 1, 54, 6), (30, 14, 54, 19)];

/// The role of an object that stands in both worlds at the start: its place in the list of roles.
pub(super) type Role = usize;

/// Who stands in both worlds at the start.
#[derive(Clone, Debug)]
pub(super) struct Actor {
    pub(super) seat: Option<Seat>,
    pub(super) unit_type: &'static str,
    pub(super) amount: u32,
    /// In each of the worlds.
    pub(super) at: [DVec2; 2],
}

/// A pair of worlds, and what is done in both.
pub(super) struct Scene {
    pub(super) loaded: [Loaded; 2],
    pub(super) watcher: Seat,
    pub(super) actors: Vec<Actor>,
    /// By role, the number of the object in each of the worlds.
    pub(super) numbers: [Vec<u32>; 2],
    pub(super) script: Vec<Line>,
    /// What the file says, for a report.
    pub(super) text: String,
}

/// What is chosen for a scene as a whole.
pub(super) struct Plan {
    pub(super) explored: bool,
    pub(super) walls_block: bool,
    pub(super) seats: u16,
    pub(super) watcher: Seat,
    /// Of the watcher's team.
    pub(super) ally: Option<Seat>,
    pub(super) foes: Vec<Seat>,
    tables: String,
    sight: f64,
}

impl Plan {
    fn new(dice: &mut Dice) -> Self {
        let seats = u16::try_from(2 + dice.below(3)).expect("there are few");
        let mut others: Vec<Seat> = (0..seats).map(Seat).collect();
        let watcher = others.remove(dice.below(u32::from(seats)) as usize);
        let ally = (seats > 2 && dice.percent(60)).then(|| others.remove(0));
        let (explored, walls_block) = (dice.percent(40), dice.percent(40));
        let mut tables = format!(
            "[vision]\nterrain = '{}'\nwalls_block = {walls_block}\n[combat]\nfriendly_fire = {}\n",
            if explored { "explored" } else { "known" },
            dice.percent(30),
        );
        if dice.percent(30) {
            tables += &format!("[view]\npositions = 'grid'\ngrid_bits = {}\n", dice.below(12));
        }
        let scalar = dice.one(&["f64", "f64", "f32"]);
        let stops = dice.one(&["both", "approaching"]);
        tables += &format!("[kinematics]\nscalar = '{scalar}'\nstops = '{stops}'\n");
        Self { explored, walls_block, seats, watcher, ally, foes: others, tables, sight: dice.between(3, 6) }
    }

    /// Returns the scenario; the stock of the other seats is their secret.
    fn scenario(&self, seed: u64, secret: &mut Dice) -> String {
        let team = |seat: Seat| {
            if Some(seat) == self.ally { self.watcher.0 } else { seat.0 }
        };
        let stock = |seat: Seat, secret: &mut Dice| {
            if seat == self.watcher { 200 } else { 100 + secret.below(20_000) }
        };
        let seats: String = (0..self.seats)
            .map(Seat)
            .map(|seat| {
                format!(
                    "[[seat]]\nteam = {}\nstock = {}\ngroups = [{{ unit = 'scout', count = 1 }}]\n",
                    team(seat),
                    stock(seat, secret)
                )
            })
            .collect();
        let unit_types = UNIT_TYPES.replace("SIGHT", &self.sight.to_string());
        format!(
            "name = 'secrecy'\nmap = 'scene.map'\nlength_seconds = 1000\nseed = {seed}\n{}[harvest]\npatch = 'crystal'\n\
             [production]\n[modes]\n[neutral]\ngroups = [{{ unit = 'sheep', count = 1 }}]\nwander = 2\n\
             pause_seconds = 1\n[objective]\nkind = 'resources'\n{unit_types}{seats}",
            self.tables
        )
    }
}

/// Makers train an idol for longer than any scene lasts; only hidden seats have a bolt, the fastest of all.
const UNIT_TYPES: &str = "\
[unit.worker]
radius = 0.25
speed = 4
sight = SIGHT
hit_points = 40
cost = 10
make_seconds = 2
builds = ['hut']
harvest = { load_max = 5, seconds_each = 0.25 }
weapon = { range = 0.5, cooldown_seconds = 0.5, damage_min = 1, damage_max = 6 }
[unit.tank]
radius = 0.4375
speed = 3
sight = SIGHT
hit_points = 60
armor = 1
cost = 20
make_seconds = 2
[unit.tank.weapon]
range = 4
cooldown_seconds = 0.5
damage_min = 2
damage_max = 20
splash_radius = 1
splash_falloff = 'linear'
[unit.tank.alternate]
name = 'siege'
switch_seconds = 1
speed = 0
[unit.tank.alternate.weapon]
range = 5
range_min = 1
cooldown_seconds = 1
damage_min = 5
damage_max = 30
splash_radius = 1
[unit.jet]
radius = 0.3125
speed = 8
sight = SIGHT
layer = 'air'
hit_points = 30
cost = 20
make_seconds = 2
weapon = { range = 2, cooldown_seconds = 0.25, damage_min = 0, damage_max = 9 }
[unit.scout]
radius = 0.25
speed = 4
sight = SIGHT
hit_points = 50
[unit.bolt]
radius = 0.125
speed = 23
sight = 2
[unit.house]
width = 2
height = 2
speed = 0
sight = 5
hit_points = 200
takes_loads = true
cost = 50
trains = ['worker', 'tank', 'jet', 'idol']
[unit.hut]
width = 1
height = 1
speed = 0
sight = 4
hit_points = 60
cost = 15
make_seconds = 1
[unit.idol]
radius = 0.25
speed = 1
cost = 5
make_seconds = 3600
[unit.crystal]
radius = 0.375
speed = 0
patch = { places = 2 }
[unit.sheep]
radius = 0.25
speed = 2
hit_points = 30
";

impl Scene {
    /// Returns the scene of a seed.
    pub(super) fn new(seed: u64) -> Self {
        let mut dice = Dice::new(seed, 0);
        let plan = Plan::new(&mut dice);
        let mut secrets = [Dice::new(seed, 1), Dice::new(seed, 2)];
        let text = secrets.each_mut().map(|secret| plan.scenario(seed, secret));
        let land = near_land(&mut dice);
        let places = [0, 1].map(|world| Places::new(&land, &unit_types(&text[world])));
        let mut cast = Cast { plan, places, actors: Vec::new(), dice };
        let script = script::fill(&mut cast);
        if cast.plan.explored {
            cast.wall_up(&mut secrets);
        }
        let extras = [0, 1].map(|world| cast.extras(world, &mut secrets[world]));
        let Cast { plan, actors, places, .. } = cast;
        let rows = places.map(|places| places.rows);
        let mut loaded = [0, 1].map(|world| read(&text[world], &rows[world]));
        let mut numbers = [Vec::new(), Vec::new()];
        for world in [0, 1] {
            let order = order(&actors, &extras[world], world, &mut secrets[world]);
            let types = &loaded[world].scenario.unit_types;
            let id = |name: &str| types.iter().position(|it| it.name == name).expect("it is in the list");
            let start = |it: &Actor| StartUnit {
                seat: it.seat,
                unit_type: UnitTypeId(u16::try_from(id(it.unit_type)).expect("there are few")),
                position: it.at[world],
                amount: it.amount,
            };
            let all: Vec<&Actor> = actors.iter().chain(&extras[world]).collect();
            let units = order.iter().map(|&place| start(all[place])).collect();
            let number = |role: Role| order.iter().position(|&place| place == role);
            numbers[world] =
                (0..actors.len()).map(|role| u32::try_from(number(role).unwrap()).unwrap()).collect();
            loaded[world].setup.units = units;
        }
        let text = format!("{}{}\n{}", text[0], map(&rows[0]), map(&rows[1]));
        Self { loaded, watcher: plan.watcher, actors, numbers, script, text }
    }
}

/// A scene that is being made.
pub(super) struct Cast {
    pub(super) plan: Plan,
    places: [Places; 2],
    pub(super) actors: Vec<Actor>,
    pub(super) dice: Dice,
}

impl Cast {
    /// Puts somebody at a place in each world; `None` where one of them has no room there.
    pub(super) fn put(
        &mut self,
        seat: Option<Seat>,
        unit_type: &'static str,
        at: [DVec2; 2],
        amount: u32,
    ) -> Option<Role> {
        if ![0, 1].iter().all(|&world| self.places[world].has_room(unit_type, at[world])) {
            return None;
        }
        for (places, at) in self.places.iter_mut().zip(at) {
            places.take(unit_type, at);
        }
        self.actors.push(Actor { seat, unit_type, amount, at });
        Some(self.actors.len() - 1)
    }

    /// Puts somebody somewhere in a rectangle, at the same place in each world, if there is room.
    pub(super) fn put_in(
        &mut self,
        seat: Option<Seat>,
        unit_type: &'static str,
        (left, top, right, bottom): (u32, u32, u32, u32),
        amount: u32,
    ) -> Option<Role> {
        (0..20).find_map(|_| {
            let at = DVec2::new(self.dice.between(left, right), self.dice.between(top, bottom));
            self.put(seat, unit_type, [at, at], amount)
        })
    }

    /// Blocks tiles that nobody of the watcher's team sees at the start, some just beyond what it sees, in each world others.
    fn wall_up(&mut self, secrets: &mut [Dice; 2]) {
        let team = [Some(self.plan.watcher), self.plan.ally];
        let is_of_team = |actor: &&Actor| actor.seat.is_some() && team.contains(&actor.seat);
        for (places, secret) in self.places.iter_mut().zip(secrets) {
            let eyes: Vec<(DVec2, f64)> = self
                .actors
                .iter()
                .filter(is_of_team)
                .map(|actor| (actor.at[0], places.unit_types[actor.unit_type].sight))
                .collect();
            for _ in 0..60 {
                let x = secret.below(WIDTH);
                let y = secret.one(&[0, 1, 2, 3, 4, 5, 6, 13, 14, 15, 16, 17, 18, 19u32]);
                let middle = DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5);
                // Farther than sight, by both radii and what squares are more than their centres.
                let is_hidden = eyes.iter().all(|(eye, sight)| eye.distance(middle) > sight + 4.0);
                let is_free =
                    places.taken.iter().all(|(other, radius)| other.distance(middle) > radius + 0.8);
                if is_hidden && is_free {
                    places.rows[y as usize][x as usize] = b'@';
                }
            }
        }
    }

    /// Puts those into a world who are hidden there, and others in the other world.
    fn extras(&mut self, world: usize, secret: &mut Dice) -> Vec<Actor> {
        let mut extras = Vec::new();
        for arena in ARENAS {
            for &seat in &self.plan.foes {
                let units = ["house", "worker", "worker", "tank", "tank", "jet", "bolt", "hut"];
                for unit_type in units {
                    if unit_type == "bolt" && world == 0 || secret.percent(25) {
                        continue;
                    }
                    self.places[world].settle(&mut extras, secret, (Some(seat), unit_type), arena);
                }
            }
            for unit_type in ["sheep", "sheep", "crystal"] {
                if secret.percent(70) {
                    self.places[world].settle(&mut extras, secret, (None, unit_type), arena);
                }
            }
        }
        let seat = Some(secret.one(&self.plan.foes));
        let types: &[&str] = &["scout", "tank", "sheep"];
        let unit_type = secret.one(types);
        if self.plan.walls_block && secret.percent(70) && self.places[world].has_room(unit_type, POCKET) {
            self.places[world].take(unit_type, POCKET);
            let seat = if unit_type == "sheep" { None } else { seat };
            extras.push(Actor { seat, unit_type, amount: 0, at: [POCKET; 2] });
        }
        extras
    }
}

/// The middle of a tile that is closed in by others.
const POCKET: DVec2 = DVec2::new(12.5, 3.5);

/// Where there is room in a world.
struct Places {
    rows: Vec<Vec<u8>>,
    unit_types: BTreeMap<String, UnitType>,
    /// Centres and radii.
    taken: Vec<(DVec2, f64)>,
}

impl Places {
    fn new(rows: &[Vec<u8>], unit_types: &[UnitType]) -> Self {
        let named = |it: &UnitType| (it.name.clone(), it.clone());
        Self { rows: rows.to_vec(), unit_types: unit_types.iter().map(named).collect(), taken: Vec::new() }
    }

    fn has_room(&self, unit_type: &str, at: DVec2) -> bool {
        let shape = self.unit_types[unit_type].shape;
        let reach = shape.half() + shape.rounding() + 0.0625;
        let (low, high) = ((at - reach).floor(), (at + reach).floor());
        let is_open = |x: i32, y: i32| {
            let row = usize::try_from(y).ok().and_then(|y| self.rows.get(y));
            row.zip(usize::try_from(x).ok()).and_then(|(row, x)| row.get(x)) == Some(&b'.')
        };
        (low.y as i32..=high.y as i32).all(|y| (low.x as i32..=high.x as i32).all(|x| is_open(x, y)))
            && self.taken.iter().all(|(other, radius)| other.distance(at) > radius + shape.radius() + 0.0625)
    }

    fn take(&mut self, unit_type: &str, at: DVec2) {
        self.taken.push((at, self.unit_types[unit_type].shape.radius()));
    }

    /// Finds room in an arena.
    fn settle(
        &mut self,
        extras: &mut Vec<Actor>,
        secret: &mut Dice,
        (seat, unit_type): (Option<Seat>, &'static str),
        (left, top, right, bottom): (u32, u32, u32, u32),
    ) {
        for _ in 0..10 {
            let at = DVec2::new(secret.between(left, right), secret.between(top, bottom));
            if self.has_room(unit_type, at) {
                self.take(unit_type, at);
                let amount = if unit_type == "crystal" { 5 + secret.below(40) } else { 0 };
                return extras.push(Actor { seat, unit_type, amount, at: [at; 2] });
            }
        }
    }
}

/// Returns the order in which all are put into a world. The seats take turns at random in the second, so that the numbers of the
/// objects differ; those of a seat are in the order of the list, for chance is keyed with it.
fn order(actors: &[Actor], extras: &[Actor], world: usize, secret: &mut Dice) -> Vec<usize> {
    let mut queues: BTreeMap<Option<Seat>, Vec<usize>> = BTreeMap::new();
    for (place, actor) in actors.iter().chain(extras).enumerate() {
        queues.entry(actor.seat).or_default().push(place);
    }
    let mut queues: Vec<Vec<usize>> = queues.into_values().collect();
    if world == 0 {
        return queues.concat();
    }
    let mut order = Vec::new();
    while !queues.is_empty() {
        let queue = secret.below(u32::try_from(queues.len()).expect("there are few")) as usize;
        order.push(queues[queue].remove(0));
        queues.retain(|queue| !queue.is_empty());
    }
    order
}

/// Returns the rows of a map with walls where the watcher is, and a pocket that nobody gets into.
fn near_land(dice: &mut Dice) -> Vec<Vec<u8>> {
    let mut rows = vec![vec![b'.'; WIDTH as usize]; HEIGHT as usize];
    for _ in 0..dice.below(5) {
        let (x, y) = (dice.below(20) as usize, dice.one(&[1, 2, 5, 6, 13, 14, 15, 16]));
        let (width, height) = dice.one(&[(1, 1), (4, 1), (1, 3)]);
        for row in &mut rows[y..y + height] {
            row[x..x + width].fill(b'@');
        }
    }
    let (x, y) = (POCKET.x as usize, POCKET.y as usize);
    for row in &mut rows[y - 1..=y + 1] {
        row[x - 1..=x + 1].fill(b'@');
    }
    rows[y][x] = b'.';
    rows
}

fn unit_types(scenario: &str) -> Vec<UnitType> {
    read(scenario, &vec![vec![b'.'; WIDTH as usize]; HEIGHT as usize]).scenario.unit_types.clone()
}

/// Returns the rows of a map as text.
fn map(rows: &[Vec<u8>]) -> String {
    rows.iter().map(|row| format!("{}\n", String::from_utf8_lossy(row))).collect()
}

fn read(scenario: &str, rows: &[Vec<u8>]) -> Loaded {
    let map = format!("type octile\nheight {HEIGHT}\nwidth {WIDTH}\nmap\n{}", map(rows));
    let file = |path: &str, text: String| LoadedFile { path: path.to_owned(), bytes: text.into_bytes() };
    let files = Files(vec![file("scene.toml", scenario.to_owned()), file("scene.map", map)]);
    load(&files, "scene.toml", &Overrides::default()).unwrap_or_else(|error| panic!("{error}\n{scenario}"))
}

/// Returns whether a way of such a length is gone without rounding, in doubles and in single precision.
pub(super) fn is_exact(length: f64, speed: f64) -> bool {
    let single = |value: f64| value as f32;
    length > 0.0
        && length * (speed / length) == speed
        && single(length) * (single(speed) / single(length)) == single(speed)
}
