//! Where to look for enemies.

use glam::DVec2;
use maniple_view::View;

use super::block::Block;
use super::memory::Memory;
use super::scene::{Scene, middle, nearest};
use crate::keyed::{Purpose, fraction, keyed};
use crate::player::Start;

/// How near to where nobody was found somebody has to come, in world units.
const SEARCHED: f64 = 4.0;

/// Where enemies are or might be.
#[derive(Clone, Debug)]
pub(crate) struct Search {
    seed: u64,
    /// Where the seat began.
    home: DVec2,
    /// How many places were searched in vain.
    searches: u32,
}

impl Search {
    /// Returns a search that begins across the middle of the map from home, where the other one of two seats begins.
    pub(crate) fn new(seed: u64, home: DVec2) -> Self {
        Self { seed, home, searches: 0 }
    }

    /// Returns the search of a bot whose units begin where they are in a view.
    pub(crate) fn from_home(start: &Start, view: &View) -> Self {
        Self::new(start.seed, middle(&start.scene(view).own))
    }

    /// Returns where the seat began.
    pub(crate) fn home(&self) -> DVec2 {
        self.home
    }

    /// Returns the enemy in sight that is nearest to a point, or else the nearest building that is remembered; `None` where none
    /// is known.
    pub(crate) fn known(scene: &Scene<'_>, memory: &Memory, from: DVec2) -> Option<Block> {
        if let Some(enemy) = nearest(scene.enemies.iter(), from) {
            return Some(enemy.block());
        }
        let distance = |block: &Block| block.center.distance_squared(from);
        memory.blocks().min_by(|one, other| distance(one).total_cmp(&distance(other))).copied()
    }

    /// Returns where to look next on a map of this size, in world units: another place as soon as one of those who search, who
    /// are at `searchers`, has come there.
    pub(crate) fn place(&mut self, size: DVec2, searchers: impl IntoIterator<Item = DVec2>) -> Block {
        let place = self.next(size);
        if searchers.into_iter().any(|center| center.distance(place) < SEARCHED) {
            self.searches += 1;
        }
        Block { center: place, half: DVec2::ZERO }
    }

    fn next(&self, size: DVec2) -> DVec2 {
        if self.searches == 0 {
            return size - self.home;
        }
        let chance = |purpose| fraction(keyed(self.seed, 0, self.searches, purpose));
        DVec2::new(chance(Purpose::GoalX), chance(Purpose::GoalY)) * size
    }
}
