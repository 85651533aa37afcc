//! What is built and trained.

use glam::DVec2;
use maniple_view::{Command, Handle, Mode, Rules, UnitType, UnitTypeId, View};

use super::ground::Ground;
use super::trips::{Step, Trips, path};
use crate::keyed::{Purpose, keyed};
use crate::seeing::{Block, Item, Scene, nearest};

/// Workers that are wanted where workers can be trained.
const WORKERS_WANTED: usize = 14;

/// Room that is left around a new building, in world units, so that units get through.
const STREET: f64 = 1.5;

/// Room that is left around patches, in world units, so that workers get to them.
const MINE_YARD: f64 = 3.0;

/// Farthest place of a new building from the one at home, in tiles.
const TOWN_REACH: i32 = 14;

/// Cycles after which a building that has no site yet is given up at its place.
const PATIENCE: u32 = 240;

/// Resources beyond the cost of a building from which on a second one of a kind is built.
const PLENTY: u32 = 500;

/// Most buildings of a kind.
const SAME_MAX: usize = 3;

/// A building to be.
#[derive(Clone, Copy, Debug)]
struct Project {
    unit_type: UnitTypeId,
    center: DVec2,
    builder: Handle,
    /// The cycle in which it was thought of.
    since: u32,
}

/// The buildings of the seat.
#[derive(Clone, Debug, Default)]
pub(super) struct Town {
    project: Option<Project>,
    /// Where building has failed.
    spoiled: Vec<DVec2>,
}

impl Town {
    /// Returns whether a worker is to build.
    pub(super) fn takes(&self, object: Handle) -> bool {
        self.project.is_some_and(|project| project.builder == object)
    }

    /// Goes on building.
    pub(super) fn build(
        &mut self,
        (ground, trips): (&mut Ground, &mut Trips),
        view: &View,
        rules: &Rules,
        scene: &Scene<'_>,
    ) -> Vec<Command> {
        self.review(view, scene);
        if self.project.is_none() {
            self.project = self.plan(ground, view, rules, scene);
        }
        let Some(project) = self.project else { return Vec::new() };
        let Some(builder) = scene.own(project.builder).filter(|builder| builder.is_idle()) else {
            return Vec::new();
        };
        let Project { unit_type, center, .. } = project;
        let half = rules.unit_types[usize::from(unit_type.0)].shape.half();
        let goal = Block { center, half };
        let object = builder.object;
        let build = Command::Build { object, unit_type, x: center.x, y: center.y };
        match trips.step(ground, view, builder, &goal) {
            Step::Wait => Vec::new(),
            Step::Now => vec![build],
            Step::Aside(point) => path(object, &[point]).into_iter().collect(),
            Step::Along => path(object, &trips.way(ground, builder, &goal)).into_iter().collect(),
        }
    }

    /// Forgets what is finished, and what will not be.
    fn review(&mut self, view: &View, scene: &Scene<'_>) {
        let Some(project) = self.project else { return };
        let there = scene.own.iter().find(|item| item.center == project.center && item.kind.speed == 0.0);
        match there {
            Some(item) if item.is_finished() => self.project = None,
            Some(item) => {
                if scene.own(project.builder).is_none() {
                    let builder = builder(scene, item.seen.unit_type, item.center);
                    self.project = builder.map(|builder| Project { builder, ..project });
                }
            }
            None => {
                let is_late = view.cycle().0 > project.since + PATIENCE;
                if is_late {
                    self.spoiled.push(project.center);
                }
                if is_late || scene.own(project.builder).is_none() {
                    self.project = None;
                }
            }
        }
    }

    /// Returns the next building: a site without a builder, then what trains, or what is required for it.
    fn plan(&self, ground: &Ground, view: &View, rules: &Rules, scene: &Scene<'_>) -> Option<Project> {
        let since = view.cycle().0;
        if let Some(site) = scene.own.iter().find(|item| item.seen.status.mode == Mode::Site) {
            let (unit_type, center) = (site.seen.unit_type, site.center);
            let builder = builder(scene, unit_type, center)?;
            return Some(Project { unit_type, center, builder, since });
        }
        let unit_type = wanted(rules, scene, view.stock())?;
        let kind = &rules.unit_types[usize::from(unit_type.0)];
        let home = scene.stores().next().or(scene.own.first())?;
        let center = self.place(ground, scene, kind, home.center)?;
        let builder = builder(scene, unit_type, center)?;
        Some(Project { unit_type, center, builder, since })
    }

    /// Returns the place nearest to home that has room around it.
    fn place(&self, ground: &Ground, scene: &Scene<'_>, kind: &UnitType, home: DVec2) -> Option<DVec2> {
        let half = kind.shape.half() + DVec2::splat(kind.shape.rounding());
        let mut best: Option<(f64, DVec2)> = None;
        for y in -TOWN_REACH..=TOWN_REACH {
            for x in -TOWN_REACH..=TOWN_REACH {
                let corner = DVec2::new((home.x + f64::from(x)).floor(), (home.y + f64::from(y)).floor());
                let center = corner + half;
                let distance = center.distance_squared(home);
                if best.is_some_and(|(nearest, _)| nearest <= distance) {
                    continue;
                }
                let with_street = Block { center, half: half + DVec2::splat(STREET) };
                let is_yard = |patch: &Item<'_>| {
                    let beyond = (patch.center - center).abs() - half;
                    beyond.x < MINE_YARD && beyond.y < MINE_YARD
                };
                let is_fit = ground.is_free(&with_street)
                    && !scene.patches().any(is_yard)
                    && !self.spoiled.contains(&center);
                if is_fit {
                    best = Some((distance, center));
                }
            }
        }
        best.map(|(_, center)| center)
    }
}

/// Trains units in all buildings that have nothing to do: workers until there are enough, else the dearest fighter that can be had,
/// of several one by chance.
pub(super) fn train(
    town: &Town,
    (seed, view): (u64, &View),
    rules: &Rules,
    scene: &Scene<'_>,
) -> Vec<Command> {
    let mut stock = view.stock();
    let in_training = |unit_type| {
        let trains = |item: &&Item<'_>| item.seen.own.is_some_and(|own| own.training == Some(unit_type));
        scene.own.iter().filter(trains).count()
    };
    let luck = |unit_type: UnitTypeId| keyed(seed, view.cycle().0, unit_type.0.into(), Purpose::Training);
    let mut commands = Vec::new();
    // What is saved for the building that is next.
    let saved = town.project.map_or(0, |project| {
        let is_founded = scene.own.iter().any(|item| item.center == project.center);
        if is_founded { 0 } else { rules.unit_types[usize::from(project.unit_type.0)].making.cost }
    });
    let mut workers = scene.own.iter().filter(|item| item.kind.harvest.is_some()).count();
    for item in scene.own.iter().filter(|item| item.is_finished()) {
        if item.seen.own.is_none_or(|own| own.training.is_some()) {
            continue;
        }
        let kind = |unit_type: UnitTypeId| &rules.unit_types[usize::from(unit_type.0)];
        let worker = item.kind.trains.iter().copied().find(|&unit_type| kind(unit_type).harvest.is_some());
        let fighters = item.kind.trains.iter().copied().filter(|&unit_type| {
            kind(unit_type).weapon.is_some()
                && kind(unit_type).harvest.is_none()
                && has_all(scene, kind(unit_type))
        });
        let is_short = |unit_type: &UnitTypeId| workers + in_training(*unit_type) < WORKERS_WANTED;
        let choice = match worker.filter(is_short) {
            Some(worker) => Some(worker),
            None => fighters
                .filter(|&unit_type| kind(unit_type).making.cost + saved <= stock)
                .max_by_key(|&unit_type| (kind(unit_type).making.cost, luck(unit_type))),
        };
        let Some(unit_type) = choice.filter(|&unit_type| kind(unit_type).making.cost <= stock) else {
            continue;
        };
        stock -= kind(unit_type).making.cost;
        workers += usize::from(kind(unit_type).harvest.is_some());
        commands.push(Command::Train { object: item.object, unit_type });
    }
    commands
}

/// Returns what to build next and can be paid for.
fn wanted(rules: &Rules, scene: &Scene<'_>, stock: u32) -> Option<UnitTypeId> {
    let builds = |item: &Item<'_>| item.kind.builds.clone();
    let mut known: Vec<UnitTypeId> = scene.own.iter().flat_map(builds).collect();
    known.sort_unstable();
    known.dedup();
    let kind = |unit_type: &UnitTypeId| &rules.unit_types[usize::from(unit_type.0)];
    let have =
        |unit_type: &UnitTypeId| scene.own.iter().filter(|item| item.seen.unit_type == *unit_type).count();
    let is_useful = |unit_type: &&UnitTypeId| {
        let kind = kind(unit_type);
        !kind.trains.is_empty() && has_all(scene, kind)
    };
    let can_pay = |unit_type: &&UnitTypeId| {
        let spare = if have(unit_type) == 0 { 0 } else { PLENTY };
        let trains_fighters = |it: &UnitTypeId| kind(it).weapon.is_some() && kind(it).harvest.is_none();
        let is_enough = have(unit_type) >= SAME_MAX
            || (have(unit_type) > 0 && !kind(unit_type).trains.iter().any(trains_fighters));
        !is_enough && kind(unit_type).making.cost + spare <= stock
    };
    known.iter().filter(is_useful).filter(can_pay).min_by_key(|unit_type| have(unit_type)).copied()
}

fn has_all(scene: &Scene<'_>, kind: &UnitType) -> bool {
    let has = |wanted: &UnitTypeId| {
        scene.own.iter().any(|item| item.seen.unit_type == *wanted && item.is_finished())
    };
    kind.making.requires.iter().all(has)
}

/// Returns the worker that can build it and is nearest, if possible with empty hands.
fn builder(scene: &Scene<'_>, unit_type: UnitTypeId, center: DVec2) -> Option<Handle> {
    let can = |item: &&Item<'_>| item.kind.builds.contains(&unit_type);
    let free = scene.own.iter().filter(can).filter(|item| item.load() == 0);
    nearest(free, center).or_else(|| nearest(scene.own.iter().filter(can), center)).map(|item| item.object)
}
