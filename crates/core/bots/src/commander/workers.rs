//! Workers: to a patch, and home with the load.

use std::collections::BTreeMap;

use maniple_view::{Command, Handle, View};

use super::ground::Ground;
use super::trips::{Step, Trips, path};
use crate::seeing::{Item, Scene, nearest};

/// How much farther away, in world units, a patch may be for each worker less that goes there.
const CROWDING: f64 = 2.0;

/// Which worker goes to which patch.
#[derive(Clone, Debug, Default)]
pub(super) struct Workers {
    patches: BTreeMap<Handle, Handle>,
}

impl Workers {
    /// Tells all workers that stand around what to do; `is_taken` are those that have something else to do.
    pub(super) fn work(
        &mut self,
        (ground, trips): (&mut Ground, &mut Trips),
        view: &View,
        scene: &Scene<'_>,
        is_taken: impl Fn(Handle) -> bool,
    ) -> Vec<Command> {
        self.patches.retain(|worker, patch| scene.own(*worker).is_some() && view.object(*patch).is_some());
        let mut commands = Vec::new();
        for item in &scene.own {
            let Some(harvest) = item.kind.harvest else { continue };
            if !item.is_idle() || is_taken(item.object) {
                continue;
            }
            let patch = if item.load() < harvest.load_max { self.patch(scene, item) } else { None };
            let (goal, command) = match patch {
                Some(patch) => (patch.block(), Command::Gather { object: item.object, patch: patch.object }),
                None if item.load() > 0 => {
                    let Some(store) = nearest(scene.stores(), item.center) else { continue };
                    (store.block(), Command::ReturnLoad { object: item.object })
                }
                None => continue,
            };
            match trips.step(ground, view, item, &goal) {
                Step::Wait => {}
                Step::Now => commands.push(command),
                Step::Aside(point) => commands.extend(path(item.object, &[point])),
                Step::Along => commands.extend(path(item.object, &trips.way(ground, item, &goal))),
            }
        }
        commands
    }

    /// Returns the patch that a worker goes to: near a building that takes loads, and not too crowded.
    fn patch<'a, 'b>(&mut self, scene: &'b Scene<'a>, item: &Item<'_>) -> Option<&'b Item<'a>> {
        if let Some(&patch) = self.patches.get(&item.object) {
            return scene.patches().find(|other| other.object == patch);
        }
        let cost = |patch: &Item<'_>| {
            let from = nearest(scene.stores(), patch.center).map_or(item.center, |store| store.center);
            let workers = self.patches.values().filter(|&&other| other == patch.object).count();
            from.distance(patch.center) + CROWDING * workers as f64
        };
        let costs: Vec<(f64, &Item<'_>)> = scene.patches().map(|patch| (cost(patch), patch)).collect();
        let (_, patch) = costs.into_iter().min_by(|one, other| one.0.total_cmp(&other.0))?;
        self.patches.insert(item.object, patch.object);
        Some(patch)
    }
}
