//! From what a view evaluates where an object is.

use glam::DVec2;
use maniple_geometry::{Cycle, Moment};
use serde::{Deserialize, Serialize};

/// How far a view may put an object of another seat from where the world has it, in skins: 4096.
///
/// An order that keeps to its line and speed starts anew from a rounded position. That shifts the motion by up to half
/// a unit in the last place of a coordinate, each time to the same side if it comes to the worst; and a player may
/// renew an order in every cycle. A skin is at least 16 such units, so 4096 skins have room for 2^16 renewals on one
/// way, and for the velocity, which is rounded too: by three parts in 2^53, so that a way across the world ends less
/// than a skin aside. Measured are 507 skins at most. With a map of 512 tiles 4096 skins are 7e-9 world units: nobody
/// sees them, and no rule depends on a view.
pub const DEVIATION_SKINS_MAX: f64 = 4096.0;

/// How far it may be at most, in world units, where skins are thick: in single precision 4096 of them are several tiles. A
/// 64th of a tile is hardly seen, and leaves room for 512 renewals of an order on a map of 512 tiles.
pub const DEVIATION_MAX: f64 = 1.0 / 64.0;

/// Where an object was at a moment, and its velocity since: all that a view needs to know where it is.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Base {
    /// The centre at `cycle` and `fraction`, in world units.
    pub point: DVec2,
    /// The cycle of the moment.
    pub cycle: Cycle,
    /// The fraction of that cycle, `0.0..=1.0`.
    pub fraction: f64,
    /// World units a cycle; zero for an object at rest.
    pub velocity: DVec2,
}

impl Base {
    /// Returns the base of an object that rests at `point`.
    #[must_use]
    pub fn at_rest(point: DVec2, moment: Moment) -> Self {
        Self { point, cycle: moment.cycle, fraction: moment.fraction, velocity: DVec2::ZERO }
    }

    /// Returns the moment at which the object is at its point.
    #[must_use]
    pub fn moment(&self) -> Moment {
        Moment { cycle: self.cycle, fraction: self.fraction }
    }

    /// Returns the base with the same line, but evaluated at the start of `cycle`: it does not tell since when
    /// the object moves.
    #[must_use]
    pub fn refreshed(&self, cycle: Cycle) -> Self {
        Self { point: self.position(cycle), cycle, fraction: 0.0, velocity: self.velocity }
    }

    /// Returns whether to the eye an object that moves by this base moves by `truth`, from the start of `cycle` until
    /// that of the next: it rests at the same point, or it moves and is never more than `deviation_max` world units
    /// aside.
    #[must_use]
    pub fn predicts(&self, truth: &Self, cycle: Cycle, deviation_max: f64) -> bool {
        if !self.is_moving() || !truth.is_moving() {
            return self.is_moving() == truth.is_moving() && self.point == truth.point;
        }
        self.stays_near(truth, cycle, deviation_max)
    }

    /// Returns whether from the start of `cycle` until that of the next the two positions are never more than
    /// `deviation_max` world units apart.
    ///
    /// The difference of two straight motions is straight, so it is largest at one of the ends. After a cycle it is
    /// `d + w`, with the offset `d` at the start and the relative velocity `w`.
    pub(crate) fn stays_near(&self, truth: &Self, cycle: Cycle, deviation_max: f64) -> bool {
        let offset = self.position(cycle) - truth.position(cycle);
        let offset_next = offset + (self.velocity - truth.velocity);
        let is_near = |offset: DVec2| offset.length_squared() <= deviation_max * deviation_max;
        is_near(offset) && is_near(offset_next)
    }

    /// Returns whether the object moves.
    #[must_use]
    pub fn is_moving(&self) -> bool {
        self.velocity != DVec2::ZERO
    }

    /// Returns the centre at the start of `cycle`: `p + v * ((k - k0) - f0)`.
    ///
    /// This order, without fused multiply-add, is part of the protocol: every client gets the same bits. An
    /// object at rest is at its point, whatever the cycle.
    #[must_use]
    pub fn position(&self, cycle: Cycle) -> DVec2 {
        let elapsed = self.moment().until(cycle);
        self.point + self.velocity * elapsed
    }
}

#[cfg(test)]
mod tests {
    use maniple_geometry::Limits;

    use super::*;

    #[test]
    fn a_base_predicts_what_is_seen_where_it_says_until_the_next_cycle() {
        let base = |point, velocity: (f64, f64)| Base {
            point: DVec2::from(point),
            cycle: Cycle(3),
            fraction: 0.5,
            velocity: DVec2::from(velocity),
        };
        let check = |old: Base, truth: Base, expected: bool| {
            assert_eq!(old.predicts(&truth, Cycle(5), 0.25), expected, "{old:?} {truth:?}");
            assert_eq!(truth.predicts(&old, Cycle(5), 0.25), expected, "{truth:?} {old:?}");
        };
        let (rest, right) = ((0.0, 0.0), (1.0, 0.0));
        check(base((4.0, 2.0), rest), Base { cycle: Cycle(4), ..base((4.0, 2.0), rest) }, true);
        check(base((4.0, 2.0), rest), base((4.0, 2.0 + 1e-15), rest), false);
        check(base((4.0, 2.0), rest), base((4.0, 2.0), (1e-9, 0.0)), false);
        check(base((4.0, 2.0), right), base((4.0, 2.25), right), true);
        check(base((4.0, 2.0), right), base((4.2, 2.2), right), false);
        check(base((4.0, 2.0), right), Base { cycle: Cycle(4), ..base((5.0, 2.0), right) }, true);
        check(base((4.0, 2.0), right), Base { cycle: Cycle(4), ..base((4.0, 2.0), right) }, false);
        // 1.5 cycles after the base it is 0.15 aside, a cycle later 0.25 or more.
        check(base((4.0, 2.0), right), base((4.0, 2.0), (1.0, 0.0999)), true);
        check(base((4.0, 2.0), right), base((4.0, 2.0), (1.0, 0.1001)), false);
    }
    #[test]
    fn an_order_renewed_in_each_of_65536_cycles_stays_below_the_deviation() {
        let skin: f64 = Limits::new(512.0, 0.5, 0.5).unwrap().skin();
        for (start, goal) in
            [((0.7, 300.3), (511.3, 300.3)), ((3.1, 7.3), (501.7, 388.9)), ((500.9, 501.3), (500.3, 3.7))]
        {
            let (start, goal) = (DVec2::from(start), DVec2::from(goal));
            let speed = start.distance(goal) / 65_600.0;
            let order = |point: DVec2, cycle| {
                let way = goal - point;
                Base { point, cycle, fraction: 0.0, velocity: way * (speed / way.length()) }
            };
            let old = order(start, Cycle(0));
            let mut truth = old;
            let mut skins_most: f64 = 0.0;
            for cycle in (1..=65_536).map(Cycle) {
                truth = order(truth.position(cycle), cycle);
                assert!(old.predicts(&truth, cycle, DEVIATION_SKINS_MAX * skin), "cycle {cycle}");
                let skins = old.position(cycle).distance(truth.point) / skin;
                if skins > skins_most {
                    skins_most = skins;
                }
            }
            println!("{start} to {goal}: {skins_most} skins");
        }
    }
}
