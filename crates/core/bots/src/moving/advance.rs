//! All fighters on their way to one point, a group of each type.

use std::collections::BTreeMap;

use glam::DVec2;
use maniple_geometry::{Cycle, Scalar};
use maniple_pathfinding::Tactic;
use maniple_view::{Command, Handle, Layer, UnitTypeId};

use super::march::March;
use super::roads::Roads;
use super::slots::slots_around;
use crate::seeing::{Item, Scene, middle, nearest};

/// How far the point may move, in world units, before all get other goals.
const DRIFT: f64 = 2.0;

/// Cycles between two times at which all get other goals, at least: ways are not planned in each cycle.
const STEADY: u32 = 8;

/// Cycles for which a unit is let be to which no way is known: to find that there is none is the dearest search.
const LET_BE: u32 = 16;

/// The marches of several types to places around one point.
#[derive(Clone, Debug, Default)]
pub(crate) struct Advance {
    point: DVec2,
    since: u32,
    marches: Vec<March>,
    /// Who marches, by handle.
    units: Vec<Handle>,
    /// The cycle before which somebody is let be.
    let_be: BTreeMap<Handle, u32>,
}

impl Advance {
    /// Leads units, by handle, to places around a point, and returns the orders to those who are `free`. Whose weapon has the shortest
    /// range goes nearest to it. Goals are shared out anew when the point has moved, or others march than before.
    pub(crate) fn lead(
        &mut self,
        roads: &mut Roads,
        (cycle, scene): (Cycle, &Scene<'_>),
        (units, free): (&[&Item<'_>], &[Handle]),
        point: DVec2,
    ) -> Vec<Command> {
        let handles: Vec<Handle> = units.iter().map(|item| item.object).collect();
        let now = cycle.0;
        let is_other = handles.iter().any(|object| self.units.binary_search(object).is_err())
            || self.point.distance(point) > DRIFT;
        if self.units.is_empty() || (is_other && now >= self.since + STEADY) {
            *self = Self { point, since: now, units: handles, ..Self::default() };
            self.share_out(roads, units);
        }
        self.let_be.retain(|_, &mut until| now < until);
        let is_free = |object| free.binary_search(&object).is_ok() && !self.let_be.contains_key(&object);
        let mut commands = Vec::new();
        let mut stuck = Vec::new();
        for march in &mut self.marches {
            commands.extend(march.advance(cycle, scene, is_free));
            stuck.extend(march.stuck(cycle));
        }
        self.let_be.extend(stuck.into_iter().map(|object| (object, now + LET_BE)));
        commands
    }

    /// Makes a march of the units of each type.
    fn share_out(&mut self, roads: &mut Roads, units: &[&Item<'_>]) {
        let mut by_type: BTreeMap<UnitTypeId, Vec<&Item<'_>>> = BTreeMap::new();
        for &item in units.iter().filter(|item| item.kind.layer == Layer::Ground && item.kind.speed > 0.0) {
            by_type.entry(item.seen.unit_type).or_default().push(item);
        }
        let mut groups: Vec<Vec<&Item<'_>>> = by_type.into_values().collect();
        let range = |group: &[&Item<'_>]| group[0].kind.weapon.as_ref().map_or(0.0, |weapon| weapon.range);
        groups.sort_by(|one, other| range(one).total_cmp(&range(other)));
        let widest = groups.iter().fold(0.0, |most: f64, group| most.greater(group[0].kind.shape.radius()));
        let Some(ground) = roads.ground(widest) else { return };
        let from = middle(groups.iter().flatten().copied());
        let from = nearest_to(groups.iter().flatten().copied(), from);
        let count = groups.iter().map(Vec::len).sum();
        let mut slots = slots_around(roads, &ground, (from, self.point), count).into_iter();
        for group in groups {
            let kind = group[0].kind;
            let Some(ground) = roads.ground(kind.shape.radius()) else { continue };
            let goals = slots.by_ref().take(group.len()).collect();
            self.marches.push(March::new((Tactic::Replan, ground), &group, goals, kind.speed));
        }
    }
}

/// Returns where the one is that is nearest to a point; the point itself where there is none.
fn nearest_to<'a, 'b>(items: impl Iterator<Item = &'b Item<'a>>, point: DVec2) -> DVec2
where
    'a: 'b,
{
    nearest(items, point).map_or(point, |item| item.center)
}
