//! Lets spectators watch a match, some cycles behind its players.

use std::sync::Arc;

use maniple_game::scenario::Views;
use maniple_geometry::Cycle;
use maniple_view::{Delta, Observation, Rules, Seat, Terrain, TerrainKnowledge, Tracker, Vantage, View};

use super::Referee;
use crate::stand::{Stand, WatchError};

impl Referee {
    /// Lets the match be watched as far as its scenario permits. From then on a copy of what each view that may be watched
    /// is told is held back, whether anybody watches it or not: who comes late shall get the view of then. Where the scenario
    /// permits nothing this costs nothing.
    ///
    /// # Panics
    /// When cycles were played already.
    pub fn open_stands(&mut self) {
        let Some(rule) = self.loaded.scenario.spectators else { return };
        for seat in self.seats_all() {
            self.open_stand(Vantage::Seat(seat), rule.delay);
        }
        match rule.views {
            Views::All => self.open_stand(Vantage::Everything, rule.delay),
            Views::Seats => {}
        }
    }

    /// Lets a view be watched, whatever the scenario says, so many cycles later: for those who have the replay, and with it
    /// everything.
    ///
    /// # Panics
    /// When cycles were played already, or the match has no such seat.
    pub fn open_stand(&mut self, vantage: Vantage, delay: u32) {
        assert_eq!(self.cycle(), Cycle(0), "who watches sees a match from its start");
        let view = self.view_at_start(vantage);
        let first = match vantage {
            Vantage::Seat(seat) => self.keyframe(seat),
            Vantage::Everything => {
                self.overseer = Some(self.overseer_at_start());
                self.look_at_everything()
            }
        };
        self.stands.open(vantage, delay, view, first);
    }

    /// Returns the view that spectators see.
    ///
    /// # Errors
    /// Why it cannot be watched.
    pub fn stand(&self, vantage: Vantage) -> Result<&Stand, WatchError> {
        self.stands.stand(vantage, self.seats())
    }

    /// Returns the rules as they are for a view: from where everything is seen, nothing is hidden.
    #[must_use]
    pub fn rules_of(&self, vantage: Vantage) -> Rules {
        let rules = self.rules();
        match vantage {
            Vantage::Seat(_) => rules,
            Vantage::Everything => {
                Rules { fog: false, terrain: TerrainKnowledge::Known, walls_block: false, ..rules }
            }
        }
    }

    /// Returns the terrain that is known from the start in a view.
    #[must_use]
    pub fn terrain_of(&self, vantage: Vantage) -> Arc<Terrain> {
        match vantage {
            Vantage::Seat(_) => Arc::clone(self.terrain()),
            Vantage::Everything => Arc::new(Terrain::of(&self.loaded.map)),
        }
    }

    /// Returns a view before anything was told.
    pub(super) fn view_at_start(&self, vantage: Vantage) -> View {
        View::new(&self.rules_of(vantage), self.terrain_of(vantage))
    }

    /// Returns who sees everything, before the first look.
    pub(super) fn overseer_at_start(&self) -> Tracker {
        let positions = self.loaded.scenario.profile.positions;
        let view = self.view_at_start(Vantage::Everything);
        Tracker::new(Vantage::Everything, self.world.skin_of_limits(), positions, view)
    }

    /// Hands on what a seat is told.
    pub(super) fn tell_spectators(&mut self, seat: Seat, delta: &Delta) {
        self.stands.push(Vantage::Seat(seat), || delta.clone());
    }

    /// Hands on what is to be told of everything, where that may be watched.
    pub(super) fn tell_spectators_of_everything(&mut self) {
        if self.stand(Vantage::Everything).is_err() {
            self.overseer = None;
            return;
        }
        let delta = self.look_at_everything();
        self.stands.push(Vantage::Everything, || delta);
    }

    /// Returns what has changed of everything since the last look.
    fn look_at_everything(&mut self) -> Delta {
        let world = &self.world;
        let observation = Observation {
            sightings: world.objects(),
            visible: None,
            revealed: &[],
            walls: &[],
            died: world.dead(),
            shots: world.fired(),
            ended: world.ended(),
            stock: 0,
        };
        let overseer = self.overseer.as_mut().expect("only called where everything may be watched");
        overseer.update(world.cycle(), observation, Vec::new())
    }
}
