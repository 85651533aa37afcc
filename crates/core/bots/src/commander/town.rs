//! What is built and trained.

use glam::DVec2;
use maniple_view::{Command, Handle, UnitType, UnitTypeId, View};

use super::ground::Ground;
use super::trips::{Step, Trips, path};
use crate::economy::{Means, Projects, train};
use crate::keyed::{Purpose, keyed};
use crate::player::Start;
use crate::seeing::{Block, Item, Scene};

/// Workers that are wanted where workers can be trained.
const WORKERS_WANTED: usize = 14;

/// Room that is left around a new building, in world units, so that units get through.
const STREET: f64 = 1.5;

/// Room that is left around patches, in world units, so that workers get to them.
const MINE_YARD: f64 = 3.0;

/// Farthest place of a new building from the one at home, in tiles.
const TOWN_REACH: i32 = 14;

/// Resources beyond the cost of a building from which on a second one of a kind is built.
const PLENTY: u32 = 500;

/// Most buildings of a kind.
const SAME_MAX: usize = 3;

/// The buildings of the seat.
#[derive(Clone, Debug, Default)]
pub(super) struct Town {
    projects: Projects,
}

impl Town {
    /// Returns whether a worker is to build.
    pub(super) fn takes(&self, object: Handle) -> bool {
        self.projects.takes(object)
    }

    /// Goes on building what trains, or what is required for it.
    pub(super) fn build(
        &mut self,
        (ground, trips): (&mut Ground, &mut Trips),
        start: &Start,
        view: &View,
        scene: &Scene<'_>,
    ) -> Option<Command> {
        let (project, builder) = self.projects.next(view.cycle().0, scene, |spoiled| {
            let unit_type = wanted(start, scene, view.stock())?;
            Some((unit_type, place(ground, scene, start.kind(unit_type), spoiled)?))
        })?;
        if !builder.is_idle() {
            return None;
        }
        let (unit_type, center, object) = (project.unit_type, project.center, builder.object);
        let goal = Block { center, half: start.kind(unit_type).shape.half() };
        match trips.step(ground, view, builder, &goal) {
            Step::Wait => None,
            Step::Now => Some(Command::Build { object, unit_type, x: center.x, y: center.y }),
            Step::Aside(point) => path(object, &[point]),
            Step::Along => path(object, &trips.way(ground, builder, &goal)),
        }
    }

    /// Trains workers until there are enough, else the dearest fighter that can be had, of several one by chance.
    pub(super) fn train(&self, start: &Start, view: &View, scene: &Scene<'_>) -> Vec<Command> {
        let saved = self.projects.saved(start, scene);
        let luck =
            |unit_type: UnitTypeId| keyed(start.seed, view.cycle().0, unit_type.0.into(), Purpose::Training);
        let choose = |trains: &[UnitTypeId], means: Means| {
            let cost = |unit_type: UnitTypeId| start.kind(unit_type).making.cost;
            let worker = trains.iter().copied().find(|&it| start.kind(it).harvest.is_some());
            if worker.is_some() && means.workers < WORKERS_WANTED {
                return worker;
            }
            let fighters = trains.iter().copied().filter(|&it| is_fighter(start.kind(it)));
            let affordable = fighters.filter(|&fighter| cost(fighter) + saved <= means.stock);
            affordable.max_by_key(|&fighter| (cost(fighter), luck(fighter)))
        };
        train(start, scene, view.stock(), choose)
    }
}

/// Returns the place nearest to home that has room around it.
fn place(ground: &Ground, scene: &Scene<'_>, kind: &UnitType, spoiled: &[DVec2]) -> Option<DVec2> {
    let home = scene.stores().next().or(scene.own.first())?.center;
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
            let is_fit =
                ground.is_free(&with_street) && !scene.patches().any(is_yard) && !spoiled.contains(&center);
            if is_fit {
                best = Some((distance, center));
            }
        }
    }
    best.map(|(_, center)| center)
}

/// Returns what to build next and can be paid for.
fn wanted(start: &Start, scene: &Scene<'_>, stock: u32) -> Option<UnitTypeId> {
    let have =
        |unit_type: &UnitTypeId| scene.own.iter().filter(|item| item.seen.unit_type == *unit_type).count();
    let is_useful = |unit_type: &UnitTypeId| {
        let kind = start.kind(*unit_type);
        !kind.trains.is_empty() && scene.meets_requirements(kind)
    };
    let can_pay = |unit_type: &UnitTypeId| {
        let kind = start.kind(*unit_type);
        let spare = if have(unit_type) == 0 { 0 } else { PLENTY };
        let trains_fighters = kind.trains.iter().any(|&it| is_fighter(start.kind(it)));
        let is_enough = have(unit_type) >= SAME_MAX || (have(unit_type) > 0 && !trains_fighters);
        !is_enough && kind.making.cost + spare <= stock
    };
    let known = scene.buildable().into_iter();
    known.filter(is_useful).filter(can_pay).min_by_key(have)
}

fn is_fighter(kind: &UnitType) -> bool {
    kind.weapon.is_some() && kind.harvest.is_none()
}
