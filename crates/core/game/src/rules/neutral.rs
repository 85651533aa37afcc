//! Units of nobody, which wander at random from the seed of the match.

use glam::DVec2;
use maniple_geometry::ObjectId;

use crate::keyed::{Purpose, fraction};
use crate::room::nearest_within;
use crate::scenario::Neutral;
use crate::world::State;

/// Lets those who rest set out at random, each once in `pause` cycles in the mean, to a point of the square around it.
pub(crate) fn wander(state: &mut State, rule: &Neutral, wanderers: &[ObjectId]) {
    for &object in wanderers {
        if !state.units.is_alive(object) || state.is_moving(object) {
            continue;
        }
        if !state.random(object, Purpose::Departure).is_multiple_of(u64::from(rule.pause)) {
            continue;
        }
        let offset = |purpose| rule.wander * (2.0 * fraction(state.random(object, purpose)) - 1.0);
        let offset = DVec2::new(offset(Purpose::GoalX), offset(Purpose::GoalY));
        let end = DVec2::new(f64::from(state.map.width()), f64::from(state.map.height()));
        // Never -0, which is no coordinate.
        let goal = nearest_within(state.center(object) + offset, DVec2::ZERO, end) + DVec2::ZERO;
        state.send(object, goal);
    }
}
