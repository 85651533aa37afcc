//! What is built and trained, and where.

use glam::DVec2;
use maniple_geometry::Cycle;
use maniple_pathfinding::Ground;
use maniple_view::{Command, Handle, Mode, Rules, UnitTypeId, View};

use super::sites::Sites;
use super::worth::{best_fighter, kind, missing_for, trainers};
use crate::moving::around;
use crate::post::Post;
use crate::seeing::{Block, Item, Scene, nearest, nearest_point};

/// Workers that are wanted where workers can be trained.
const WORKERS_WANTED: usize = 20;

/// Most buildings that train the same.
const SAME_MAX: usize = 5;

/// Cycles after which a building that has no site yet is given up at its place.
const PATIENCE: u32 = 240;

/// Cycles from one attempt to build to the next: whoever stands in the way may go.
const RETRY: u32 = 8;

/// How near to the hull of a site its builder goes before it is told to build, in world units: from there it goes straight.
const NEAR: f64 = 1.0;

/// A building to be.
#[derive(Clone, Copy, Debug)]
struct Project {
    unit_type: UnitTypeId,
    center: DVec2,
    builder: Handle,
    /// The cycle in which it was thought of.
    since: u32,
    /// The cycle before which its builder is not told again.
    patience: u32,
}

/// The buildings of the seat, and what they train.
#[derive(Clone, Debug, Default)]
pub(crate) struct Town {
    project: Option<Project>,
    /// Where building has failed.
    spoiled: Vec<DVec2>,
}

/// What a town is planned from.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Plans<'a, 'b> {
    pub(crate) view: &'a View,
    pub(crate) rules: &'a Rules,
    pub(crate) scene: &'b Scene<'a>,
    /// Ways of workers that have to stay free, as their two ends.
    pub(crate) lanes: &'b [(DVec2, DVec2)],
}

impl Town {
    /// Returns whether a worker is to build.
    pub(crate) fn takes(&self, object: Handle) -> bool {
        self.project.is_some_and(|project| project.builder == object)
    }

    /// Returns the commands of a cycle to builders and buildings.
    pub(crate) fn grow(&mut self, post: &mut Post, plans: Plans<'_, '_>) -> Vec<Command> {
        let mut stock = plans.view.stock();
        let mut commands = self.build(post, plans);
        // What is saved for the building that is next.
        if let Some(project) = self.project {
            let is_founded = plans.scene.own.iter().any(|item| item.center == project.center);
            let cost = kind(plans.rules, project.unit_type).making.cost;
            stock = if is_founded { stock } else { stock.saturating_sub(cost) };
        }
        commands.extend(train(plans, stock));
        commands
    }

    fn build(&mut self, post: &mut Post, plans: Plans<'_, '_>) -> Vec<Command> {
        self.review(plans);
        if self.project.is_none() {
            self.project = self.plan(post, plans);
        }
        let Some(Project { unit_type, center, builder, patience, .. }) = self.project else {
            return Vec::new();
        };
        let Some(builder) = plans.scene.own(builder) else { return Vec::new() };
        let now = plans.view.cycle().0;
        if builder.has_task() || now < patience {
            return Vec::new();
        }
        let half = kind(plans.rules, unit_type).shape.half();
        let near = nearest_point(&Block { center, half }, builder.center);
        let radius = builder.kind.shape.radius();
        let command = if near.distance(builder.center) < radius + NEAR {
            self.project = self.project.map(|project| Project { patience: now + RETRY, ..project });
            Some(Command::Build { object: builder.object, unit_type, x: center.x, y: center.y })
        } else {
            let Some(ground) = post.roads.ground(radius) else { return Vec::new() };
            self.go((&ground, post), (plans.view.cycle(), plans.scene), builder, &Block { center, half })
        };
        command.and_then(|command| post.orders.give(builder, command)).into_iter().collect()
    }

    /// Sends a builder to the nearest side of a site that it can get to.
    fn go(
        &self,
        (ground, post): (&Ground, &Post),
        (cycle, scene): (Cycle, &Scene<'_>),
        builder: &Item<'_>,
        site: &Block,
    ) -> Option<Command> {
        let is_on_its_way = builder.seen.base.is_moving() && post.orders.has_path(builder);
        if is_on_its_way || !cycle.0.is_multiple_of(2) {
            return None;
        }
        let out = site.half + DVec2::splat(builder.kind.shape.radius() + NEAR * 0.5);
        let sides = [DVec2::X, -DVec2::X, DVec2::Y, -DVec2::Y].map(|side| site.center + out * side);
        let mut sides = sides.to_vec();
        let distance = |point: DVec2| point.distance_squared(builder.center);
        sides.sort_by(|&one, &other| distance(one).total_cmp(&distance(other)));
        let legs = sides.into_iter().find_map(|side| around(ground, scene, builder, side))?;
        let points = legs.iter().map(|leg| (leg.x, leg.y, None)).collect();
        Some(Command::Path { object: builder.object, points, start: None })
    }

    /// Forgets what is finished, and what will not be.
    fn review(&mut self, plans: Plans<'_, '_>) {
        let Some(project) = self.project else { return };
        let scene = plans.scene;
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
                let is_late = plans.view.cycle().0 > project.since + PATIENCE;
                if is_late {
                    self.spoiled.push(project.center);
                }
                if is_late || scene.own(project.builder).is_none() {
                    self.project = None;
                }
            }
        }
    }

    /// Returns the next building: a site without a builder, then what is missing for the best fighter, then another of those that train
    /// it if all are busy.
    fn plan(&self, post: &mut Post, plans: Plans<'_, '_>) -> Option<Project> {
        let Plans { view, rules, scene, lanes } = plans;
        let since = view.cycle().0;
        if let Some(site) = scene.own.iter().find(|item| item.seen.status.mode == Mode::Site) {
            let (unit_type, center) = (site.seen.unit_type, site.center);
            let builder = builder(scene, unit_type, center)?;
            return Some(Project { unit_type, center, builder, since, patience: since });
        }
        let unit_type = wanted(plans).filter(|&it| kind(rules, it).making.cost <= view.stock())?;
        let home = scene.stores().next().or(scene.own.first())?.center;
        let radius = scene.own.iter().find(|item| item.kind.builds.contains(&unit_type))?.kind.shape.radius();
        let ground = post.roads.ground(radius)?;
        let sites = Sites { ground: &ground, scene, lanes, spoiled: &self.spoiled };
        let center = sites.nearest(kind(rules, unit_type), home)?;
        let builder = builder(scene, unit_type, center)?;
        Some(Project { unit_type, center, builder, since, patience: since })
    }
}

/// Returns what to build next.
fn wanted(plans: Plans<'_, '_>) -> Option<UnitTypeId> {
    let Plans { rules, scene, .. } = plans;
    let fighter = best_fighter(rules, scene)?;
    if let Some(missing) = missing_for(rules, scene, fighter) {
        return Some(missing);
    }
    let trainer = trainers(rules, scene, fighter).next()?;
    let same = scene.own.iter().filter(|item| item.seen.unit_type == trainer);
    let is_busy = |item: &Item<'_>| item.seen.own.is_some_and(|own| own.training.is_some());
    let (count, busy) = same.fold((0, 0), |(count, busy), it| (count + 1, busy + usize::from(is_busy(it))));
    (count < SAME_MAX && count == busy).then_some(trainer)
}

/// Trains in all buildings that have nothing to do: workers until there are enough, else the best fighter.
fn train(plans: Plans<'_, '_>, mut stock: u32) -> Vec<Command> {
    let Plans { rules, scene, .. } = plans;
    let fighter = best_fighter(rules, scene);
    let has =
        |wanted: UnitTypeId| scene.own.iter().any(|item| item.seen.unit_type == wanted && item.is_finished());
    let in_training = |item: &&Item<'_>| {
        let trained = item.seen.own.and_then(|own| own.training);
        trained.is_some_and(|unit_type| kind(rules, unit_type).harvest.is_some())
    };
    let is_worker = |item: &&Item<'_>| item.kind.harvest.is_some();
    let mut workers =
        scene.own.iter().filter(is_worker).count() + scene.own.iter().filter(in_training).count();
    let mut commands = Vec::new();
    for item in scene.own.iter().filter(|item| item.is_finished()) {
        if item.seen.own.is_none_or(|own| own.training.is_some()) {
            continue;
        }
        let is_wanted = |unit_type: &UnitTypeId| {
            let kind = kind(rules, *unit_type);
            let is_useful =
                Some(*unit_type) == fighter || (kind.harvest.is_some() && workers < WORKERS_WANTED);
            is_useful && kind.making.cost <= stock && kind.making.requires.iter().all(|&it| has(it))
        };
        let Some(unit_type) = item.kind.trains.iter().copied().find(is_wanted) else { continue };
        stock -= kind(rules, unit_type).making.cost;
        workers += usize::from(kind(rules, unit_type).harvest.is_some());
        commands.push(Command::Train { object: item.object, unit_type });
    }
    commands
}

/// Returns the worker that can build it and is nearest, if possible with empty hands.
fn builder(scene: &Scene<'_>, unit_type: UnitTypeId, center: DVec2) -> Option<Handle> {
    let can = |item: &&Item<'_>| item.kind.builds.contains(&unit_type);
    let free = scene.own.iter().filter(can).filter(|item| item.load() == 0);
    nearest(free, center).or_else(|| nearest(scene.own.iter().filter(can), center)).map(|item| item.object)
}
