//! The race: who brings more units into its zone, and among equals sooner, wins.

use glam::DVec2;
use maniple_geometry::ObjectId;
use maniple_view::{Seat, Zone};

/// The state of a race.
///
/// A unit arrives when at the end of a cycle its centre lies in its seat's zone, border included; it counts once, whatever becomes of
/// it. Only units of the start count.
#[derive(Clone, Debug)]
pub(crate) struct Race {
    zones: Vec<Zone>,
    has_arrived: Vec<bool>,
}

impl Race {
    /// Returns the race of the first `units` objects to the zones of the seats.
    pub(crate) fn new(zones: &[Zone], units: usize) -> Self {
        Self { zones: zones.to_vec(), has_arrived: vec![false; units] }
    }

    /// Takes where a unit is at the end of a cycle; returns whether it has arrived just now.
    pub(crate) fn handle_position(&mut self, unit: ObjectId, owner: Seat, center: DVec2) -> bool {
        let Some(has_arrived) = self.has_arrived.get_mut(unit.0 as usize) else { return false };
        if *has_arrived || !self.zones[owner.index()].contains(center) {
            return false;
        }
        *has_arrived = true;
        true
    }

    /// Returns whether a unit has arrived already, or does not race.
    pub(crate) fn is_settled(&self, unit: ObjectId) -> bool {
        self.has_arrived.get(unit.0 as usize).copied().unwrap_or(true)
    }

    /// Returns which of the units of the start have arrived.
    pub(crate) fn arrived(&self) -> &[bool] {
        &self.has_arrived
    }

    /// Takes which of the units of the start have arrived; `None` where they are not as many.
    pub(crate) fn restore(&mut self, arrived: &[bool]) -> Option<()> {
        (arrived.len() == self.has_arrived.len()).then(|| self.has_arrived.copy_from_slice(arrived))
    }

    /// Returns the zones, in order of the seats.
    pub(crate) fn zones(&self) -> &[Zone] {
        &self.zones
    }
}
