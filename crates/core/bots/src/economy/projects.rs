//! Buildings to be: one after the other, each with its builder.

use glam::DVec2;
use maniple_view::{Handle, Mode, UnitTypeId};

use crate::player::Start;
use crate::seeing::{Item, Scene, nearest};

/// Cycles after which a building that has no site yet is given up at its place.
const PATIENCE: u32 = 240;

/// A building to be.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Project {
    pub(crate) unit_type: UnitTypeId,
    pub(crate) center: DVec2,
    pub(crate) builder: Handle,
    /// The cycle in which it was thought of.
    pub(crate) since: u32,
}

/// The building that is next, and where none can be.
#[derive(Clone, Debug, Default)]
pub(crate) struct Projects {
    current: Option<Project>,
    /// Where building has failed.
    spoiled: Vec<DVec2>,
}

impl Projects {
    /// Returns whether a worker is to build.
    pub(crate) fn takes(&self, object: Handle) -> bool {
        self.current.is_some_and(|project| project.builder == object)
    }

    /// Returns what is built in a cycle, and its builder; `None` where there is nothing to build.
    ///
    /// Where nothing is under way that is a site without a builder, or else what `plan` says: which building, and where its centre is; it is
    /// told where building has failed.
    pub(crate) fn next<'a, 'b>(
        &mut self,
        now: u32,
        scene: &'b Scene<'a>,
        plan: impl FnOnce(&[DVec2]) -> Option<(UnitTypeId, DVec2)>,
    ) -> Option<(Project, &'b Item<'a>)> {
        self.review(now, scene);
        if self.current.is_none() {
            let site = scene.own.iter().find(|item| item.seen.status.mode == Mode::Site);
            let site = site.map(|site| (site.seen.unit_type, site.center));
            self.current = site.or_else(|| plan(&self.spoiled)).and_then(|(unit_type, center)| {
                let builder = builder(scene, unit_type, center)?;
                Some(Project { unit_type, center, builder, since: now })
            });
        }
        let project = self.current?;
        scene.own(project.builder).map(|builder| (project, builder))
    }

    /// Gives up what is under way: nothing can be built there.
    pub(crate) fn give_up(&mut self) {
        self.spoiled.extend(self.current.take().map(|project| project.center));
    }

    /// Returns the resources that are saved for the building that is next.
    pub(crate) fn saved(&self, start: &Start, scene: &Scene<'_>) -> u32 {
        self.current.map_or(0, |project| {
            let is_founded = scene.own.iter().any(|item| item.center == project.center);
            if is_founded { 0 } else { start.kind(project.unit_type).making.cost }
        })
    }

    /// Forgets what is finished, and what will not be.
    fn review(&mut self, now: u32, scene: &Scene<'_>) {
        let Some(project) = self.current else { return };
        let there = scene.own.iter().find(|item| item.center == project.center && item.kind.speed == 0.0);
        match there {
            Some(item) if item.is_finished() => self.current = None,
            Some(item) => {
                if scene.own(project.builder).is_none() {
                    let builder = builder(scene, item.seen.unit_type, item.center);
                    self.current = builder.map(|builder| Project { builder, ..project });
                }
            }
            None => {
                let is_late = now > project.since + PATIENCE;
                if is_late {
                    self.give_up();
                } else if scene.own(project.builder).is_none() {
                    self.current = None;
                }
            }
        }
    }
}

/// Returns the worker that can build it and is nearest, if possible with empty hands.
fn builder(scene: &Scene<'_>, unit_type: UnitTypeId, center: DVec2) -> Option<Handle> {
    let can = |item: &&Item<'_>| item.kind.builds.contains(&unit_type);
    let free = scene.own.iter().filter(can).filter(|item| item.load() == 0);
    nearest(free, center).or_else(|| nearest(scene.own.iter().filter(can), center)).map(|item| item.object)
}
