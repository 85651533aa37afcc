//! The bot that goes straight for its zone.

use std::collections::BTreeMap;

use glam::DVec2;
use maniple_geometry::Scalar;
use maniple_view::{Command, Delta, Handle, View, Zone};

use crate::keyed::{Purpose, fraction, keyed};
use crate::player::{Play, Start};
use crate::seeing::size;

/// Distance of goals in a zone beyond touching, as a part of a unit's diameter.
const SLOT_GAP: f64 = 0.25;

/// Most goals in a zone: as many as a seat may have units, so that a huge zone does not fill the memory.
const SLOTS_MAX: usize = 4096;

/// Half the edge of the square in which the first detour ends, in world units; each further one is as much wider.
const DETOUR_REACH: f64 = 1.0;

/// Failures after which detours get no wider.
const DETOURS_MAX: u32 = 32;

/// Sends each of its units straight to a place of its own in the seat's zone, and again when it was stopped: every
/// other time to another place, and in between on a detour, the wider the more often it was stopped.
///
/// It knows no walls; that it gets around them is luck and patience. Without detours not one unit arrives in the
/// scenarios that ship with Maniple, with them nearly all: see `docs/decisions/0008-detours-of-straight.md`.
#[derive(Clone, Debug)]
pub(crate) struct Straight {
    seed: u64,
    size: DVec2,
    zone: Option<Zone>,
    slots: Vec<DVec2>,
    /// Orders given to each unit that has not arrived.
    tries: BTreeMap<Handle, u32>,
}

impl Straight {
    pub(crate) const NAME: &str = "straight";

    pub(crate) fn begin(start: &Start, view: &View) -> Self {
        let movers = start.rules.unit_types.iter().filter(|kind| kind.speed > 0.0);
        let widest = movers.fold(0.0, |most: f64, kind| most.greater(kind.shape.radius()));
        let zone = start.rules.objective.zone_of(start.seat);
        Self {
            seed: start.seed,
            size: size(view.terrain()),
            zone,
            slots: zone.map(|zone| slots(&zone, widest)).unwrap_or_default(),
            tries: BTreeMap::new(),
        }
    }

    /// Returns where a unit goes that was sent `tries` times before; `index` of `units` is its place among its own.
    fn goal(&self, view: &View, object: Handle, tries: u32, (index, units): (usize, usize)) -> DVec2 {
        if tries == 0 {
            return self.slots[index * self.slots.len() / units];
        }
        if tries % 2 == 1 {
            return self.detour(view, object, tries);
        }
        let slots = self.slots.len() as u64;
        let slot = keyed(self.seed, view.cycle().0, object.0, Purpose::Slot) % slots;
        self.slots[usize::try_from(slot).unwrap_or(0)]
    }

    fn detour(&self, view: &View, object: Handle, tries: u32) -> DVec2 {
        let here = view.position(object).unwrap_or(DVec2::ZERO);
        let reach = DETOUR_REACH * f64::from((tries / 2 + 1).min(DETOURS_MAX));
        let offset =
            |purpose| reach * (2.0 * fraction(keyed(self.seed, view.cycle().0, object.0, purpose)) - 1.0);
        DVec2::new(
            within(here.x + offset(Purpose::DetourX), self.size.x),
            within(here.y + offset(Purpose::DetourY), self.size.y),
        )
    }
}

impl Play for Straight {
    fn play(&mut self, start: &Start, view: &View, _delta: &Delta) -> Vec<Command> {
        let Some(zone) = self.zone else { return Vec::new() };
        let units = view.objects_of(start.seat).count();
        let mut commands = Vec::new();
        for (index, (object, seen)) in view.objects_of(start.seat).enumerate() {
            let is_at_work = seen.base.is_moving() || start.kind(seen.unit_type).speed == 0.0;
            if is_at_work || zone.contains(seen.base.position(view.cycle())) {
                continue;
            }
            let tries = self.tries.get(&object).copied().unwrap_or(0);
            let DVec2 { x, y } = self.goal(view, object, tries, (index, units));
            self.tries.insert(object, tries.saturating_add(1));
            commands.push(Command::Move { object, x, y, s: None, queue: false, start: None });
        }
        commands
    }
}

/// Returns the points of a lattice within a zone, as wide as the largest unit with a gap, by (y, x); its centre where
/// not even one unit fits.
pub(crate) fn slots(zone: &Zone, radius: f64) -> Vec<DVec2> {
    let spacing = 2.0 * radius * (1.0 + SLOT_GAP);
    let (columns, rows) = (along(zone.max.x - zone.min.x, spacing), along(zone.max.y - zone.min.y, spacing));
    let step = DVec2::new(
        (zone.max.x - zone.min.x) / f64::from(columns),
        (zone.max.y - zone.min.y) / f64::from(rows),
    );
    let point =
        |row: u32, column: u32| zone.min + step * (DVec2::new(f64::from(column), f64::from(row)) + 0.5);
    (0..rows).flat_map(|row| (0..columns).map(move |column| point(row, column))).take(SLOTS_MAX).collect()
}

/// Returns how many spacings fit along a length; at least one.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "not negative; saturates")]
fn along(length: f64, spacing: f64) -> u32 {
    if spacing > 0.0 { ((length / spacing) as u32).max(1) } else { 1 }
}

fn within(value: f64, end: f64) -> f64 {
    if value < 0.0 {
        0.0
    } else if value > end {
        end
    } else {
        value
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use maniple_view::{
        Appeared, Base, Identity, Objective, Own, Positions, Rules, Seat, Status, Stops, Terrain,
        TerrainKnowledge, UnitTypeId,
    };

    use super::*;
    use crate::bot::Bot;
    use crate::player::Player;
    use crate::test_items::armed;

    #[test]
    fn places_in_a_zone_are_apart_and_inside() {
        let zone = Zone { seat: Seat(0), min: DVec2::new(3.0, 4.0), max: DVec2::new(7.0, 6.0) };
        let slots = slots(&zone, 0.4);
        assert_eq!(slots.len(), 8);
        for (place, slot) in slots.iter().enumerate() {
            assert!(zone.contains(*slot));
            assert!(slots[..place].iter().all(|other| other.distance(*slot) >= 1.0));
        }
        let narrow = Zone { seat: Seat(0), min: DVec2::ZERO, max: DVec2::new(0.5, 0.5) };
        assert_eq!(super::slots(&narrow, 1.0), [DVec2::new(0.25, 0.25)]);
    }

    #[test]
    fn who_rests_outside_is_sent_and_who_is_inside_or_moves_is_let_be() {
        let terrain =
            Terrain { width: 20, height: 10, tiles: vec![".".repeat(20); 10], segments: Vec::new() };
        let mut bot = Player::new(Straight::NAME, 3, Straight::begin);
        bot.on_start(Seat(0), &rules(), &terrain);
        let base =
            Base { point: DVec2::ZERO, cycle: View::default().cycle(), fraction: 0.0, velocity: DVec2::ZERO };
        let at = |object: u32, x: f64, velocity: DVec2| Appeared {
            object: Handle(object),
            unit_type: UnitTypeId(0),
            owner: Some(Seat(0)),
            base: Base { velocity, point: DVec2::new(x, 5.0), ..base },
            status: Status::default(),
            own: Some(Own::default()),
        };
        let mut view = View::new(&rules(), Arc::new(terrain));
        let mut delta = Delta {
            appeared: vec![at(0, 1.0, DVec2::ZERO), at(1, 17.0, DVec2::ZERO), at(2, 2.0, DVec2::X)],
            ..Delta::default()
        };
        delta.check = {
            let mut copy = view.clone();
            let _ = copy.apply(&delta);
            copy.check()
        };
        view.apply(&delta).unwrap();
        let commands = bot.on_cycle(&view, &delta);
        assert_eq!(commands.len(), 1);
        assert!(
            matches!(commands[0], Command::Move { object: Handle(0), x, y, .. } if x > 16.0 && y > 4.0 && y < 6.0),
            "{commands:?}"
        );
        let again = bot.on_cycle(&view, &delta);
        assert!(matches!(again[0], Command::Move { object: Handle(0), x, .. } if x <= 2.0), "{again:?}");
    }

    fn rules() -> Rules {
        Rules {
            scenario: "tiny".to_owned(),
            cycles_max: 100,
            players: vec![],
            unit_types: vec![armed(1.0)],
            stops: Stops::Both,
            skin: 0.0,
            waypoints_max: 64,
            commands_a_cycle_max: 100,
            objective: Objective::Race {
                zones: vec![Zone { seat: Seat(0), min: DVec2::new(16.0, 4.0), max: DVec2::new(18.0, 6.0) }],
            },
            teams: vec![0],
            friendly_fire: false,
            objects_max: 100,
            training_max: 5,
            fog: false,
            terrain: TerrainKnowledge::Known,
            walls_block: false,
            identity: Identity::Fresh,
            positions: Positions::Exact,
        }
    }
}
