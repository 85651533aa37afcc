//! A way for one around all who rest.

use glam::DVec2;
use maniple_pathfinding::{Crowd, Detours, Ground, MARGIN, Planner};

use crate::seeing::{Item, Scene};

/// Returns the goals of legs to a point, around all who rest; `None` where these close every way, or there is none.
pub(crate) fn around(ground: &Ground, scene: &Scene<'_>, item: &Item<'_>, goal: DVec2) -> Option<Vec<DVec2>> {
    let stands = |other: &&Item<'_>| other.object != item.object && other.is_in_the_way();
    let mut crowd = Crowd::new();
    for (number, other) in scene.all().filter(stands).enumerate() {
        crowd.insert(number, other.center, ground.radius() + other.kind.shape.radius() + MARGIN);
    }
    Detours::new(ground).path(&crowd, item.center, goal).ok().flatten().filter(|legs| !legs.is_empty())
}

/// Returns the goals of legs to a point, whoever stands in the way; `None` where there is no way.
pub(crate) fn straight_on(ground: &Ground, item: &Item<'_>, goal: DVec2) -> Option<Vec<DVec2>> {
    let mut planner = Planner::new(ground);
    planner.path(item.center, goal).ok().map(<[DVec2]>::to_vec).filter(|legs| !legs.is_empty())
}
