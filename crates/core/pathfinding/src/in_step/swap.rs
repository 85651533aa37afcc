//! Whether two have to get past each other, and whether they can.

use crate::in_step::board::Place;
use crate::in_step::generator::{Generator, NOBODY, Scene};

/// How it goes on behind a place that somebody is pushed along.
enum Way {
    /// There are two ways or more, so that two get past each other.
    Widens,
    /// There is one.
    Onward(Place),
    /// There is none.
    Ends,
}

impl Generator {
    /// Returns with whom an agent has to change places to come nearer to its goal, in a passage so narrow that it must back off
    /// for that; or [`NOBODY`] (Okumura 2023, section 3.2).
    pub(crate) fn partner(&self, scene: &Scene<'_>, agent: u32, best: Place) -> u32 {
        let now = scene.at(agent);
        if best == now {
            return NOBODY;
        }
        let ahead = self.occupant(best);
        if ahead != NOBODY
            && !self.has_chosen(ahead)
            && self.is_swap_needed(scene, (agent, now), (ahead, best))
            && self.is_swap_possible(scene, best, now)
        {
            return ahead;
        }
        // Somebody behind has to get past, and the two have already begun to back off.
        for &place in scene.board.neighbours(now) {
            let behind = self.occupant(place);
            if behind != NOBODY
                && place != best
                && self.is_swap_needed(scene, (behind, now), (agent, best))
                && self.is_swap_possible(scene, best, now)
            {
                return behind;
            }
        }
        NOBODY
    }

    /// Whether a pusher that drives another before it can only reach its goal if they change places.
    fn is_swap_needed(&self, scene: &Scene<'_>, pusher: (u32, Place), pushed: (u32, Place)) -> bool {
        let ((pusher, mut from), (pushed, mut to)) = (pusher, pushed);
        let distance = |agent, place| scene.distance(agent, place);
        while distance(pusher, to) < distance(pusher, from) {
            match self.way(scene, from, to) {
                Way::Widens => return false,
                Way::Ends => break,
                Way::Onward(next) => (from, to) = (to, next),
            }
        }
        distance(pushed, from) < distance(pushed, to)
            && (distance(pusher, from) == 0 || distance(pusher, to) < distance(pusher, from))
    }

    /// Whether somewhere behind, away from `ahead`, there is room for two to change places.
    fn is_swap_possible(&self, scene: &Scene<'_>, ahead: Place, now: Place) -> bool {
        let (mut from, mut to) = (ahead, now);
        // A passage that comes back to where it began is a ring.
        while to != ahead {
            match self.way(scene, from, to) {
                Way::Widens => return true,
                Way::Ends => return false,
                Way::Onward(next) => (from, to) = (to, next),
            }
        }
        false
    }

    /// How it goes on behind `to` for who comes from `from`. A dead end with somebody in it who is at the goal there is no way.
    fn way(&self, scene: &Scene<'_>, from: Place, to: Place) -> Way {
        let mut onward = None;
        for &next in scene.board.neighbours(to) {
            let occupant = self.occupant(next);
            let is_taken = scene.board.neighbours(next).len() == 1
                && occupant != NOBODY
                && scene.distance(occupant, next) == 0;
            if next == from || is_taken {
                continue;
            }
            if onward.is_some() {
                return Way::Widens;
            }
            onward = Some(next);
        }
        onward.map_or(Way::Ends, Way::Onward)
    }
}
