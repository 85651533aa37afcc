//! What is built and trained, and where.

use glam::DVec2;
use maniple_geometry::Cycle;
use maniple_pathfinding::Ground;
use maniple_view::{Command, Handle, UnitTypeId, View};

use super::bases::next_base;
use super::projects::{Project, Projects};
use super::sites::Sites;
use super::training::{Means, train};
use super::worth::{best_fighter, missing_for, trainers};
use crate::moving::around;
use crate::player::Start;
use crate::post::Post;
use crate::seeing::{Block, Item, Scene, nearest_point};

/// Workers that are wanted where workers can be trained.
const WORKERS_WANTED: usize = 20;

/// Most buildings that train the same.
const SAME_MAX: usize = 5;

/// Cycles from one attempt to build to the next: whoever stands in the way may go.
const RETRY: u32 = 8;

/// How often a builder is told to build at a place before another one is looked for.
const TRIES_MAX: u32 = 5;

/// How far from a site everybody has to be, its builder among them, hull to hull in world units: twice what the rules ask for.
pub(super) const ROOM: f64 = 1.0 / 32.0;

/// How near to the hull of a site its builder goes before it is told to build, in world units: from there it goes straight.
const NEAR: f64 = 1.0;

/// The buildings of the seat, and what they train.
#[derive(Clone, Debug, Default)]
pub(crate) struct Town {
    projects: Projects,
    /// The cycle in which a builder was told to build last.
    told: Option<u32>,
    /// How often it was told so at one place.
    tries: u32,
}

/// What a town is planned from.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Plans<'a, 'b> {
    pub(crate) start: &'a Start,
    pub(crate) view: &'a View,
    pub(crate) scene: &'b Scene<'a>,
    /// Ways of workers that have to stay free, as their two ends.
    pub(crate) lanes: &'b [(DVec2, DVec2)],
}

impl Town {
    /// Returns whether a worker is to build.
    pub(crate) fn takes(&self, object: Handle) -> bool {
        self.projects.takes(object)
    }

    /// Returns the commands of a cycle to builders and buildings: workers are trained until there are enough, then the best fighter.
    pub(crate) fn grow(&mut self, post: &mut Post, plans: Plans<'_, '_>) -> Vec<Command> {
        let Plans { start, view, scene, .. } = plans;
        let mut commands: Vec<Command> = self.build(post, plans).into_iter().collect();
        let stock = view.stock().saturating_sub(self.projects.saved(start, scene));
        let fighter = best_fighter(start, scene);
        let choose = |trains: &[UnitTypeId], means: Means| {
            let is_wanted = |unit_type: &UnitTypeId| {
                let kind = start.kind(*unit_type);
                let is_useful =
                    Some(*unit_type) == fighter || (kind.harvest.is_some() && means.workers < WORKERS_WANTED);
                is_useful && kind.making.cost <= means.stock
            };
            trains.iter().copied().find(is_wanted)
        };
        commands.extend(train(start, scene, stock, choose));
        commands
    }

    fn build(&mut self, post: &mut Post, plans: Plans<'_, '_>) -> Option<Command> {
        let Plans { start, view, scene, .. } = plans;
        let now = view.cycle().0;
        let (project, builder) = self.projects.next(now, scene, |spoiled| plan(post, plans, spoiled))?;
        let is_patient = self.told.is_some_and(|told| told >= project.since && now < told + RETRY);
        if builder.has_task() || is_patient {
            return None;
        }
        if self.tries == TRIES_MAX {
            self.tries = 0;
            self.projects.give_up();
            return None;
        }
        let Project { unit_type, center, .. } = project;
        let site = Block { center, half: start.kind(unit_type).shape.half() };
        let near = nearest_point(&site, builder.center);
        let radius = builder.kind.shape.radius();
        let gap = near.distance(builder.center) - radius;
        let command = if gap > ROOM && gap < NEAR {
            self.tries = if self.told.is_some_and(|told| told >= project.since) { self.tries + 1 } else { 1 };
            self.told = Some(now);
            Command::Build { object: builder.object, unit_type, x: center.x, y: center.y }
        } else {
            let ground = post.roads.ground(radius)?;
            go((&ground, post), (view.cycle(), scene), builder, &site)?
        };
        post.orders.give(builder, command)
    }
}

/// Sends a builder to the nearest side of a site that it can get to.
fn go(
    (ground, post): (&Ground, &Post),
    (cycle, scene): (Cycle, &Scene<'_>),
    builder: &Item<'_>,
    site: &Block,
) -> Option<Command> {
    let is_on_its_way = builder.seen.base.is_moving() && post.orders.goal(builder).is_some();
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

/// Returns the next building and where its centre is: a base where resources run out, else what is missing for the best fighter, then another of
/// those that train it if all are busy. `None` as long as it cannot be paid.
fn plan(post: &mut Post, plans: Plans<'_, '_>, spoiled: &[DVec2]) -> Option<(UnitTypeId, DVec2)> {
    let Plans { start, view, scene, lanes } = plans;
    let home = scene.stores().next().or(scene.own.first())?.center;
    let base = next_base(start, scene, &post.memory);
    let (unit_type, home) = base.or_else(|| Some((wanted(start, scene)?, home)))?;
    if start.kind(unit_type).making.cost > view.stock() {
        return None;
    }
    let radius = scene.own.iter().find(|item| item.kind.builds.contains(&unit_type))?.kind.shape.radius();
    let ground = post.roads.ground(radius)?;
    let sites = Sites { ground: &ground, scene, lanes, spoiled };
    Some((unit_type, sites.nearest(start.kind(unit_type), home)?))
}

/// Returns what to build next.
fn wanted(start: &Start, scene: &Scene<'_>) -> Option<UnitTypeId> {
    let fighter = best_fighter(start, scene)?;
    if let Some(missing) = missing_for(start, scene, fighter) {
        return Some(missing);
    }
    let trainer = trainers(start, scene, fighter).next()?;
    let same = scene.own.iter().filter(|item| item.seen.unit_type == trainer);
    let is_busy = |item: &Item<'_>| item.seen.own.is_some_and(|own| own.training.is_some());
    let (count, busy) = same.fold((0, 0), |(count, busy), it| (count + 1, busy + usize::from(is_busy(it))));
    let is_wanted = count < SAME_MAX && count == busy;
    is_wanted.then(|| missing_for(start, scene, trainer).unwrap_or(trainer))
}
