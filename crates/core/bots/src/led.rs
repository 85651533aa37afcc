//! The bots that lead their units to their zone as groups, by a tactic.

use std::collections::BTreeMap;

use maniple_geometry::Scalar;
use maniple_pathfinding::Tactic;
use maniple_view::{Command, Delta, Layer, UnitTypeId, View, Zone};

use crate::moving::March;
use crate::player::{Play, Start};
use crate::post::Post;
use crate::seeing::{Item, Scene};
use crate::straight::slots;

/// Leads all its units to places in the seat's zone, those of one type as one group, by one of the tactics of
/// `maniple-pathfinding`; the bot has the name of its tactic. It plans on the terrain and around the buildings that are known at the
/// start.
#[derive(Clone, Debug)]
pub(crate) struct Led {
    marches: Vec<March>,
}

impl Led {
    pub(crate) fn begin(tactic: Tactic, start: &Start, view: &View) -> Self {
        let Some(zone) = start.rules.objective.zone_of(start.seat) else {
            return Self { marches: Vec::new() };
        };
        let mut post = Post::default();
        let scene = post.look(start, view);
        Self { marches: marches(tactic, &mut post, &scene, &zone) }
    }
}

impl Play for Led {
    fn play(&mut self, start: &Start, view: &View, _delta: &Delta) -> Vec<Command> {
        let scene = start.scene(view);
        self.marches.iter_mut().flat_map(|march| march.advance(view.cycle(), &scene, |_| true)).collect()
    }
}

/// Makes a group of the units of each type that moves, and shares the places in the zone out to them.
fn marches(tactic: Tactic, post: &mut Post, scene: &Scene<'_>, zone: &Zone) -> Vec<March> {
    let mut by_type: BTreeMap<UnitTypeId, Vec<&Item<'_>>> = BTreeMap::new();
    for item in scene.own.iter().filter(|item| item.kind.speed > 0.0) {
        by_type.entry(item.seen.unit_type).or_default().push(item);
    }
    let radius = |units: &[&Item<'_>]| units[0].kind.shape.radius();
    let widest = by_type.values().fold(0.0, |most: f64, units| most.greater(radius(units)));
    let mut free = slots(zone, widest).into_iter();
    let mut marches = Vec::new();
    for units in by_type.into_values() {
        // Who flies meets no wall, and no ground is planned for it; nor for what is too large.
        let kind = units[0].kind;
        let Some(ground) = post.roads.ground(radius(&units)).filter(|_| kind.layer == Layer::Ground) else {
            continue;
        };
        let goals = free.by_ref().filter(|&goal| ground.holds(goal)).take(units.len()).collect();
        marches.push(March::new((tactic, ground), &units, goals, kind.speed));
    }
    marches
}
