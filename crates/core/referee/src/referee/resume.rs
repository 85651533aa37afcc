//! Snapshots of a match, and how it goes on from one.

use std::sync::Arc;

use maniple_game::{Loaded, World};
use maniple_view::{ClockMode, Present, Seat, Tracker, Vantage};

use super::Referee;
use crate::seat::check_name;
use crate::snapshot::{ResumeError, SeatSnapshot, Snapshot};
use crate::stand::Stands;

impl Referee {
    /// Returns all that decides what the match does and tells next. It stands behind the records that were taken by now: those
    /// that come later lead on from it.
    ///
    /// # Panics
    /// If there are records that were not taken.
    #[must_use]
    pub fn snapshot(&self) -> Snapshot {
        assert!(self.records.is_empty(), "the records before a snapshot are taken before it");
        let seat = |state: &crate::seat::SeatState| SeatSnapshot {
            name: state.name.clone(),
            tracker: state.tracker.snapshot(),
        };
        Snapshot {
            origin: self.loaded.origin(),
            world: self.world.snapshot(),
            seats: self.seats.iter().map(seat).collect(),
            banks: self.banks.snapshot(),
            agreement: self.agreement.clone(),
            stands: self.stands.snapshot(),
            overseer: self.overseer.as_ref().map(Tracker::snapshot),
        }
    }

    /// Returns the match as it was when a snapshot was taken, but that nobody is connected: who had joined comes back by
    /// [`Referee::handle_join`]. Time goes on from [`Referee::time`]. No delta and no record waits to be taken.
    ///
    /// # Errors
    /// See [`ResumeError`]: a snapshot of another match, or one that was altered.
    pub fn resume(
        loaded: impl Into<Arc<Loaded>>,
        mode: ClockMode,
        snapshot: &Snapshot,
    ) -> Result<Self, ResumeError> {
        let loaded = loaded.into();
        snapshot.check_origin(&loaded)?;
        let world = World::restored(&loaded, &snapshot.world)?;
        let mut referee = Self::around(world, loaded, mode);
        let seats = referee.seats();
        let is_of_all = snapshot.seats.len() == seats && snapshot.agreement.is_of(seats);
        let banks = referee.banks.restore(&snapshot.banks).filter(|()| is_of_all);
        banks.ok_or(ResumeError::Seats { seats })?;
        referee.agreement.clone_from(&snapshot.agreement);
        for (seat, saved) in (0..).map(Seat).zip(&snapshot.seats) {
            referee.restore_seat(seat, saved)?;
        }
        referee.restore_stands(snapshot)?;
        referee.result = referee.outcome();
        Ok(referee)
    }

    fn restore_seat(&mut self, seat: Seat, saved: &SeatSnapshot) -> Result<(), ResumeError> {
        let SeatSnapshot { name, tracker } = saved;
        if !name.is_empty() {
            check_name(name).map_err(|_| ResumeError::Name { seat })?;
        }
        let state = &mut self.seats[seat.index()];
        state.name.clone_from(name);
        let sightings = self.world.sightings(seat);
        let present = Present {
            cycle: self.world.cycle(),
            sightings: &sightings,
            visible: self.world.visible(seat),
            known: self.world.known(seat),
            stock: self.world.stock(seat),
        };
        let vantage = Vantage::Seat(seat);
        state.tracker.restore(tracker, &present).map_err(|problem| ResumeError::View { vantage, problem })
    }

    fn restore_stands(&mut self, snapshot: &Snapshot) -> Result<(), ResumeError> {
        if let Some(saved) = &snapshot.overseer {
            let present = Present {
                cycle: self.world.cycle(),
                sightings: self.world.objects(),
                visible: None,
                known: None,
                stock: 0,
            };
            let vantage = Vantage::Everything;
            let mut overseer = self.overseer_at_start();
            let restored = overseer.restore(saved, &present);
            restored.map_err(|problem| ResumeError::View { vantage, problem })?;
            self.overseer = Some(overseer);
        }
        let mut stands = Stands::closed(snapshot.stands.is_too_much);
        for saved in &snapshot.stands.stands {
            let vantage = saved.vantage;
            let tracker = match vantage {
                Vantage::Seat(seat) => self.seats.get(seat.index()).map(|state| &state.tracker),
                Vantage::Everything => self.overseer.as_ref(),
            };
            let now = tracker.ok_or(ResumeError::Vantage(vantage))?.view();
            if !stands.put_back(saved, self.view_at_start(vantage), now)? {
                return Err(ResumeError::Vantage(vantage));
            }
        }
        self.stands = stands;
        Ok(())
    }
}
