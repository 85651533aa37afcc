//! The bots that lead their units to their zone as groups, by a tactic.

use std::collections::BTreeMap;

use glam::DVec2;
use maniple_geometry::{Circle, Cycle};
use maniple_pathfinding::{Controller, Ground, Order, Scene, Seen, Tactic};
use maniple_view::{Command, Delta, Handle, Layer, Rules, Seat, Terrain, UnitType, UnitTypeId, View, Zone};

use crate::bot::Bot;
use crate::straight::slots;

/// Leads all its units to places in the seat's zone, those of one type as one group, by one of the tactics of
/// `maniple-pathfinding`; the bot has the name of its tactic. It plans on the terrain that is known at the start.
#[derive(Clone, Debug)]
pub struct Led {
    tactic: Tactic,
    seat: Seat,
    unit_types: Vec<UnitType>,
    zone: Option<Zone>,
    terrain: Terrain,
    /// From the first view on.
    groups: Vec<Group>,
    has_begun: bool,
}

/// All units of one type.
#[derive(Clone, Debug)]
struct Group {
    ground: Ground,
    controller: Controller,
    units: Vec<Handle>,
    /// Where each was seen last; one that is no more counts as resting there.
    seen: Vec<Seen>,
}

impl Led {
    /// Returns the bot; it has to be started.
    #[must_use]
    pub fn new(tactic: Tactic) -> Self {
        Self {
            tactic,
            seat: Seat(0),
            unit_types: Vec::new(),
            zone: None,
            terrain: Terrain::default(),
            groups: Vec::new(),
            has_begun: false,
        }
    }

    /// Makes a group of the units of each type that moves, and shares the places in the zone out to them.
    fn begin(&mut self, view: &View) {
        self.has_begun = true;
        let (Some(zone), Some(map)) = (self.zone, self.terrain.map()) else { return };
        let mut by_type: BTreeMap<UnitTypeId, Vec<Handle>> = BTreeMap::new();
        for (object, seen) in view.objects_of(self.seat) {
            by_type.entry(seen.unit_type).or_default().push(object);
        }
        by_type.retain(|&unit_type, _| self.unit_types[usize::from(unit_type.0)].speed > 0.0);
        let radius = |unit_type: UnitTypeId| self.unit_types[usize::from(unit_type.0)].shape.radius();
        let widest =
            by_type.keys().map(|&unit_type| radius(unit_type)).fold(0.0, |a, b| if b > a { b } else { a });
        let mut free = slots(&zone, widest).into_iter();
        for (unit_type, units) in by_type {
            // Who flies meets no wall, and no ground is planned for it; nor for what is too large.
            let kind = &self.unit_types[usize::from(unit_type.0)];
            let Ok(ground) = Ground::new(&map, radius(unit_type)) else { continue };
            if kind.layer != Layer::Ground {
                continue;
            }
            let goals = free.by_ref().filter(|&goal| ground.holds(goal)).take(units.len()).collect();
            let controller = Controller::new(self.tactic, goals, kind.speed);
            let seen = units.iter().map(|&object| seen(view, object)).collect();
            let seen = Option::unwrap_or_default(seen);
            self.groups.push(Group { ground, controller, units, seen });
        }
    }
}

impl Bot for Led {
    fn name(&self) -> &'static str {
        self.tactic.name()
    }

    fn on_start(&mut self, seat: Seat, rules: &Rules, terrain: &Terrain) {
        let zone = rules.objective.zone_of(seat);
        *self = Self {
            seat,
            unit_types: rules.unit_types.clone(),
            zone,
            terrain: terrain.clone(),
            ..Self::new(self.tactic)
        };
    }

    fn on_cycle(&mut self, view: &View, _delta: &Delta) -> Vec<Command> {
        if !self.has_begun {
            self.begin(view);
        }
        let cycle = view.cycle();
        let mut commands = Vec::new();
        for group in &mut self.groups {
            for (&object, last) in group.units.iter().zip(&mut group.seen) {
                let now = Seen { is_moving: false, ..*last };
                *last = seen(view, object).unwrap_or(now);
            }
            let is_other = |object: Handle| group.units.binary_search(&object).is_err();
            let others: Vec<Circle> = view
                .objects()
                .filter(|(object, seen)| !seen.base.is_moving() && is_other(*object))
                .filter_map(|(_, seen)| {
                    let kind = &self.unit_types[usize::from(seen.unit_type.0)];
                    let is_near_ground = kind.layer == Layer::Ground;
                    is_near_ground.then(|| Circle::new(seen.base.position(cycle), kind.shape.radius()))
                })
                .collect();
            let scene = Scene { cycle: cycle.0, units: &group.seen, others: &others };
            let orders = group.controller.advance(&group.ground, &scene);
            commands.extend(orders.into_iter().map(|order| command(group.units[order.unit], order)));
        }
        commands
    }
}

fn seen(view: &View, object: Handle) -> Option<Seen> {
    let seen = view.object(object)?;
    let position: DVec2 = seen.base.position(view.cycle());
    Some(Seen { position, is_moving: seen.base.is_moving() })
}

#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "a moment of a schedule is not negative, and a match is shorter than 2^32 cycles"
)]
fn command(object: Handle, order: Order) -> Command {
    if order.legs.is_empty() {
        return Command::Stop { object };
    }
    let points = order.legs.iter().map(|leg| (leg.x, leg.y, None)).collect();
    let start = order.start.map(|start| (Cycle(start as u32), start - start.floor()));
    Command::Path { object, points, start }
}
