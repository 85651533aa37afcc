//! The view sorted by what a commander does with it.

use glam::DVec2;
use maniple_view::{Handle, Mode, Rules, Seat, Seen, UnitType, View, hull_distance};

use super::ground::Block;

/// An object of the view, where it is now.
#[derive(Clone, Copy, Debug)]
pub(super) struct Item<'a> {
    pub(super) object: Handle,
    pub(super) seen: &'a Seen,
    pub(super) kind: &'a UnitType,
    /// World units.
    pub(super) center: DVec2,
}

impl Item<'_> {
    /// Returns how far it is to another one, hull to hull, in world units.
    pub(super) fn distance(&self, other: &Item<'_>) -> f64 {
        hull_distance(other.center - self.center, &self.kind.shape, &other.kind.shape)
    }

    /// Returns what it covers.
    pub(super) fn block(&self) -> Block {
        let half = self.kind.shape.half() + DVec2::splat(self.kind.shape.rounding());
        Block { center: self.center, half }
    }

    pub(super) fn is_finished(&self) -> bool {
        self.seen.status.mode != Mode::Site
    }

    /// Returns whether it can be told to do something: it stands and has nothing to do.
    pub(super) fn is_idle(&self) -> bool {
        let task = self.seen.own.map_or(maniple_view::Task::None, |own| own.task);
        task == maniple_view::Task::None && !self.seen.base.is_moving()
    }

    pub(super) fn load(&self) -> u32 {
        self.seen.own.map_or(0, |own| own.load)
    }
}

/// All that is in sight.
#[derive(Clone, Debug, Default)]
pub(super) struct Scene<'a> {
    /// The seat's own.
    pub(super) own: Vec<Item<'a>>,
    /// Those of the own team that belong to other seats.
    pub(super) allies: Vec<Item<'a>>,
    /// What can be hurt, of other teams.
    pub(super) enemies: Vec<Item<'a>>,
    /// What is nobody's.
    pub(super) others: Vec<Item<'a>>,
}

impl<'a> Scene<'a> {
    pub(super) fn of(view: &'a View, rules: &'a Rules, seat: Seat) -> Self {
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

    pub(super) fn all(&self) -> impl Iterator<Item = &Item<'a>> {
        self.own.iter().chain(&self.allies).chain(&self.enemies).chain(&self.others)
    }

    /// Returns the patches in sight.
    pub(super) fn patches(&self) -> impl Iterator<Item = &Item<'a>> {
        self.others.iter().filter(|item| item.kind.patch_places.is_some())
    }

    /// Returns the seat's finished buildings that take loads.
    pub(super) fn stores(&self) -> impl Iterator<Item = &Item<'a>> {
        self.own.iter().filter(|item| item.kind.takes_loads && item.is_finished())
    }

    /// Returns an object of the seat.
    pub(super) fn own(&self, object: Handle) -> Option<&Item<'a>> {
        self.own.binary_search_by_key(&object, |item| item.object).ok().map(|place| &self.own[place])
    }
}

/// Returns the item that is nearest to a point, by distance of the centres; the first of several.
pub(super) fn nearest<'a, 'b>(items: impl Iterator<Item = &'b Item<'a>>, point: DVec2) -> Option<&'b Item<'a>>
where
    'a: 'b,
{
    let distance = |item: &Item<'_>| item.center.distance_squared(point);
    items.min_by(|one, other| distance(one).total_cmp(&distance(other)))
}
