//! The view sorted by whose things are.

use glam::DVec2;
use maniple_view::{
    Handle, Layer, Mode, Rules, Seat, Seen, Task, Terrain, UnitType, UnitTypeId, View, hull_distance,
};

use super::block::Block;

/// An object of the view, where it is now.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Item<'a> {
    pub(crate) object: Handle,
    pub(crate) seen: &'a Seen,
    pub(crate) kind: &'a UnitType,
    /// World units.
    pub(crate) center: DVec2,
}

impl Item<'_> {
    /// Returns how far it is to another one, hull to hull, in world units.
    pub(crate) fn distance(&self, other: &Item<'_>) -> f64 {
        hull_distance(other.center - self.center, &self.kind.shape, &other.kind.shape)
    }

    /// Returns what it covers.
    pub(crate) fn block(&self) -> Block {
        let half = self.kind.shape.half() + DVec2::splat(self.kind.shape.rounding());
        Block { center: self.center, half }
    }

    pub(crate) fn is_finished(&self) -> bool {
        self.seen.status.mode != Mode::Site
    }

    /// Returns whether it is a circle on the ground that rests, and so is gone around.
    pub(crate) fn is_in_the_way(&self) -> bool {
        let is_round = self.kind.shape.rounding() > 0.0;
        is_round && self.kind.layer == Layer::Ground && !self.seen.base.is_moving()
    }

    /// Returns whether it can be told to do something: it stands and has nothing to do.
    pub(crate) fn is_idle(&self) -> bool {
        !self.has_task() && !self.seen.base.is_moving()
    }

    /// Returns whether it was told to do something other than to move, and is still at it.
    pub(crate) fn has_task(&self) -> bool {
        self.seen.own.is_some_and(|own| own.task != Task::None)
    }

    pub(crate) fn load(&self) -> u32 {
        self.seen.own.map_or(0, |own| own.load)
    }
}

/// All that is in sight.
#[derive(Clone, Debug, Default)]
pub(crate) struct Scene<'a> {
    /// The seat's own.
    pub(crate) own: Vec<Item<'a>>,
    /// Those of the own team that belong to other seats.
    pub(crate) allies: Vec<Item<'a>>,
    /// What can be hurt, of other teams.
    pub(crate) enemies: Vec<Item<'a>>,
    /// What is nobody's.
    pub(crate) others: Vec<Item<'a>>,
}

impl<'a> Scene<'a> {
    pub(crate) fn of(view: &'a View, rules: &'a Rules, seat: Seat) -> Self {
        let mut scene = Self::default();
        let team = |seat: Seat| rules.teams.get(seat.index()).copied();
        for (object, seen) in view.objects() {
            let kind = &rules.unit_types[usize::from(seen.unit_type.0)];
            let item = Item { object, seen, kind, center: seen.base.position(view.cycle()) };
            match seen.owner {
                Some(owner) if owner == seat => scene.own.push(item),
                Some(owner) if team(owner) == team(seat) => scene.allies.push(item),
                Some(_) if kind.hit_points.is_some() => scene.enemies.push(item),
                Some(_) | None => scene.others.push(item),
            }
        }
        scene
    }

    pub(crate) fn all(&self) -> impl Iterator<Item = &Item<'a>> {
        self.own.iter().chain(&self.allies).chain(&self.enemies).chain(&self.others)
    }

    /// Returns the patches in sight.
    pub(crate) fn patches(&self) -> impl Iterator<Item = &Item<'a>> {
        self.others.iter().filter(|item| item.kind.patch_places.is_some())
    }

    /// Returns the seat's finished buildings that take loads.
    pub(crate) fn stores(&self) -> impl Iterator<Item = &Item<'a>> {
        self.own.iter().filter(|item| item.kind.takes_loads && item.is_finished())
    }

    /// Returns whether the seat has a finished object of a type.
    pub(crate) fn has_finished(&self, unit_type: UnitTypeId) -> bool {
        self.own.iter().any(|item| item.seen.unit_type == unit_type && item.is_finished())
    }

    /// Returns whether the seat has all that a unit type requires.
    pub(crate) fn meets_requirements(&self, kind: &UnitType) -> bool {
        kind.making.requires.iter().all(|&required| self.has_finished(required))
    }

    /// Returns whether something is nearer to a building of the seat than a distance, hull to hull, in world units.
    pub(crate) fn is_near_buildings(&self, other: &Item<'_>, distance: f64) -> bool {
        self.own.iter().any(|item| item.kind.is_building() && item.distance(other) < distance)
    }

    /// Returns what the seat's workers build, sorted.
    pub(crate) fn buildable(&self) -> Vec<UnitTypeId> {
        let mut buildings: Vec<UnitTypeId> =
            self.own.iter().flat_map(|item| item.kind.builds.clone()).collect();
        buildings.sort_unstable();
        buildings.dedup();
        buildings
    }

    /// Returns an object of the seat.
    pub(crate) fn own(&self, object: Handle) -> Option<&Item<'a>> {
        self.own.binary_search_by_key(&object, |item| item.object).ok().map(|place| &self.own[place])
    }
}

/// Returns the item that is nearest to a point, by distance of the centres; the first of several.
pub(crate) fn nearest<'a, 'b>(items: impl Iterator<Item = &'b Item<'a>>, point: DVec2) -> Option<&'b Item<'a>>
where
    'a: 'b,
{
    let distance = |item: &Item<'_>| item.center.distance_squared(point);
    items.min_by(|one, other| distance(one).total_cmp(&distance(other)))
}

/// Returns the middle of items; the origin where there are none.
pub(crate) fn middle<'a, 'b>(items: impl IntoIterator<Item = &'b Item<'a>>) -> DVec2
where
    'a: 'b,
{
    let (mut sum, mut count) = (DVec2::ZERO, 0.0);
    for item in items {
        sum += item.center;
        count += 1.0;
    }
    if count > 0.0 { sum / count } else { sum }
}

/// Returns the width and height of a terrain, in world units.
pub(crate) fn size(terrain: &Terrain) -> DVec2 {
    DVec2::new(f64::from(terrain.width), f64::from(terrain.height))
}
