//! The race: who brings more units into its zone, and among equals sooner, wins.

use std::cmp::Reverse;

use glam::DVec2;
use maniple_geometry::{Cycle, ObjectId};
use maniple_view::{EndReason, Seat, Zone};

use super::{Ending, Tally};

/// The state of a race.
///
/// A unit arrives when at the end of a cycle its centre lies in its seat's zone, border included; it counts once,
/// whatever becomes of it.
#[derive(Clone, Debug)]
pub(crate) struct Race {
    zones: Vec<Zone>,
    tallies: Vec<Tally>,
    has_arrived: Vec<bool>,
}

impl Race {
    /// Returns the race of units with these owners, in order of their numbers, to the zones of the seats.
    pub(crate) fn new(zones: &[Zone], owners: impl Iterator<Item = Seat>) -> Self {
        let mut tallies = vec![Tally::default(); zones.len()];
        let mut units = 0;
        for owner in owners {
            tallies[owner.index()].units += 1;
            units += 1;
        }
        Self { zones: zones.to_vec(), tallies, has_arrived: vec![false; units] }
    }

    /// Takes where a unit is at the end of `cycle`; returns whether it has arrived just now.
    pub(crate) fn handle_position(
        &mut self,
        cycle: Cycle,
        unit: ObjectId,
        owner: Seat,
        center: DVec2,
    ) -> bool {
        let has_arrived = &mut self.has_arrived[unit.0 as usize];
        if *has_arrived || !self.zones[owner.index()].contains(center) {
            return false;
        }
        *has_arrived = true;
        let tally = &mut self.tallies[owner.index()];
        tally.arrived += 1;
        tally.arrival_sum += u64::from(cycle.0);
        assert!(tally.arrived <= tally.units, "a unit counts once");
        true
    }

    /// Takes that a seat is out of the match.
    pub(crate) fn handle_out(&mut self, seat: Seat) {
        self.tallies[seat.index()].is_out = true;
    }

    /// Returns whether a unit has arrived already.
    pub(crate) fn has_arrived(&self, unit: ObjectId) -> bool {
        self.has_arrived[unit.0 as usize]
    }

    /// Returns what each seat has achieved, in order of the seats.
    pub(crate) fn tallies(&self) -> &[Tally] {
        &self.tallies
    }

    /// Returns the zones, in order of the seats.
    pub(crate) fn zones(&self) -> &[Zone] {
        &self.zones
    }

    /// Returns how the match has ended after `cycles` of at most `cycles_max`; `None` while it goes on.
    ///
    /// Seats that are out count before units that have arrived, and those before the length.
    pub(crate) fn ending(&self, cycles: Cycle, cycles_max: Cycle) -> Option<Ending> {
        let mut seats_in = self.tallies.iter().filter(|tally| !tally.is_out);
        let is_over = match (seats_in.next(), seats_in.next()) {
            (None, _) => true,
            (Some(_), None) => self.tallies.len() > 1,
            (Some(_), Some(_)) => false,
        };
        let have_all_arrived = self.tallies.iter().all(|tally| tally.is_out || tally.arrived == tally.units);
        let reason = if is_over {
            EndReason::Resigned
        } else if have_all_arrived {
            EndReason::Objective
        } else if cycles >= cycles_max {
            EndReason::Length
        } else {
            return None;
        };
        Some(Ending { winner: self.winner(), reason, cycles })
    }

    /// Returns the seat that is still in and has more units arrived, or as many with a smaller sum of cycles, than
    /// each other; `None` where two are equal or all are out.
    fn winner(&self) -> Option<Seat> {
        let mut order: Vec<(Reverse<u32>, u64, Seat)> = (0..)
            .map(Seat)
            .zip(&self.tallies)
            .filter(|(_, tally)| !tally.is_out)
            .map(|(seat, tally)| (Reverse(tally.arrived), tally.arrival_sum, seat))
            .collect();
        order.sort_unstable();
        match order[..] {
            [] => None,
            [(_, _, seat)] => Some(seat),
            [first, second, ..] => ((first.0, first.1) != (second.0, second.1)).then_some(first.2),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const INSIDE: DVec2 = DVec2::new(0.5, 0.5);
    const OUTSIDE: DVec2 = DVec2::new(5.0, 0.5);

    #[test]
    fn a_unit_counts_once_with_the_cycle_of_its_arrival() {
        let mut race = race(&[0, 0]);
        assert!(!race.handle_position(Cycle(3), ObjectId(0), Seat(0), OUTSIDE));
        assert!(race.handle_position(Cycle(4), ObjectId(0), Seat(0), INSIDE));
        assert!(!race.handle_position(Cycle(5), ObjectId(0), Seat(0), INSIDE));
        assert_eq!(race.tallies()[0], Tally { arrived: 1, arrival_sum: 4, units: 2, is_out: false });
        assert!(race.has_arrived(ObjectId(0)) && !race.has_arrived(ObjectId(1)));
    }

    #[test]
    fn the_ending_follows_from_who_is_out_who_arrived_and_the_length() {
        let check = |arrivals: &[(u32, u16, u32)], out: &[u16], cycles, expected| {
            let mut race = race(&[0, 0, 1, 1]);
            for &(unit, seat, cycle) in arrivals {
                race.handle_position(Cycle(cycle), ObjectId(unit), Seat(seat), INSIDE);
            }
            for &seat in out {
                race.handle_out(Seat(seat));
            }
            let ending = race.ending(Cycle(cycles), Cycle(100));
            assert_eq!(ending.map(|ending| (ending.reason, ending.winner)), expected, "{arrivals:?} {out:?}");
        };
        let (objective, length, resigned) = (EndReason::Objective, EndReason::Length, EndReason::Resigned);
        let all = [(0, 0, 1), (1, 0, 2), (2, 1, 1), (3, 1, 3)];
        check(&[], &[], 10, None);
        check(&[], &[], 100, Some((length, None)));
        check(&[(0, 0, 1)], &[], 100, Some((length, Some(Seat(0)))));
        check(&[(0, 0, 1), (2, 1, 1)], &[], 100, Some((length, None)));
        check(&all, &[], 10, Some((objective, Some(Seat(0)))));
        check(&all, &[0], 10, Some((resigned, Some(Seat(1)))));
        check(&[], &[0, 1], 10, Some((resigned, None)));
        check(&all[..2], &[], 10, None);
    }

    #[test]
    fn a_seat_alone_plays_on_until_it_arrives_or_resigns() {
        let mut alone = race(&[0]);
        assert_eq!(alone.ending(Cycle(1), Cycle(9)), None);
        alone.handle_position(Cycle(1), ObjectId(0), Seat(0), INSIDE);
        assert_eq!(alone.ending(Cycle(2), Cycle(9)).map(|ending| ending.reason), Some(EndReason::Objective));
        alone.handle_out(Seat(0));
        assert_eq!(alone.ending(Cycle(2), Cycle(9)).map(|ending| ending.winner), Some(None));
    }

    /// Returns a race of units with these owners to a zone at the origin.
    fn race(owners: &[u16]) -> Race {
        let seats = owners.iter().max().unwrap() + 1;
        let zones: Vec<Zone> =
            (0..seats).map(|seat| Zone { seat: Seat(seat), min: DVec2::ZERO, max: DVec2::ONE }).collect();
        Race::new(&zones, owners.iter().map(|&owner| Seat(owner)))
    }
}
