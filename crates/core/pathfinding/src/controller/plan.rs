//! A walk under way, of which a unit is told as far as an order holds it.

use glam::DVec2;
use maniple_geometry::{Scalar, Segment};

use super::scene::{GRACE, LEGS_MAX, Order, Seen, is_there};
use crate::planner::length;
use crate::release::Moving;

/// A walk under way.
#[derive(Clone, Debug)]
pub(crate) struct Plan {
    pub(crate) goal: usize,
    from: DVec2,
    legs: Vec<DVec2>,
    /// How many of them it has been told of.
    ordered: usize,
    /// How often it has been told of more, since they grew.
    told: u32,
    /// In cycles since cycle 0.
    pub(crate) departure: f64,
    pub(crate) arrival: f64,
}

impl Plan {
    /// Returns a walk from a point along legs, at least one, that departs at a moment with a speed.
    pub(crate) fn new(
        goal: usize,
        (from, legs): (DVec2, Vec<DVec2>),
        (departure, speed): (f64, f64),
    ) -> Self {
        let arrival = departure + length(from, &legs) / speed;
        let ordered = legs.len().min(LEGS_MAX);
        Self { goal, from, legs, ordered, told: 0, departure, arrival }
    }

    /// Returns the order to depart, with as many legs as one holds.
    pub(crate) fn first_order(&self, unit: usize) -> Order {
        Order { unit, legs: self.legs[..self.ordered].to_vec(), start: Some(self.departure) }
    }

    /// Returns an order with the legs that are left, from the one on which the unit is now; `None` where it needs none, or where that leg may
    /// have ended when the order applies: to turn back to its end would take time that the others rely on.
    pub(crate) fn next_order(
        &mut self,
        unit: usize,
        now: f64,
        (speed, repeats): (f64, u32),
    ) -> Option<Order> {
        if self.ordered == self.legs.len() || now < self.departure {
            return None;
        }
        let starts = std::iter::once(&self.from).chain(&self.legs);
        let ends = starts.zip(&self.legs).scan(self.departure, |end, (from, to)| {
            *end += from.distance(*to) / speed;
            Some(*end)
        });
        let (leg, end) = ends.enumerate().find(|&(_, end)| end > now)?;
        let to = (leg + LEGS_MAX).min(self.legs.len());
        let is_worth_it = to == self.legs.len() || self.ordered - leg <= LEGS_MAX / 2;
        if !is_worth_it || end <= now + f64::from(GRACE) {
            return None;
        }
        self.told += 1;
        if self.told > repeats {
            (self.ordered, self.told) = (to, 0);
        }
        Some(Order { unit, legs: self.legs[leg..to].to_vec(), start: None })
    }

    /// The way that is left, from where the unit is seen.
    pub(crate) fn ahead(&self, seen: Seen) -> Vec<DVec2> {
        let mut points = vec![seen.position];
        if is_there(seen.position, self.from) {
            points.extend(&self.legs);
            return points;
        }
        // It is on the leg whose line is nearest.
        let starts = std::iter::once(&self.from).chain(&self.legs);
        let distance = |(start, end): (&DVec2, &DVec2)| {
            let line: Segment = (*start, *end).into();
            line.nearest(seen.position).distance_squared(seen.position)
        };
        let distances: Vec<f64> = starts.zip(&self.legs).map(distance).collect();
        let nearest = (0..distances.len()).min_by(|&a, &b| distances[a].total_cmp(&distances[b]));
        points.extend(&self.legs[nearest.unwrap_or(0)..]);
        points
    }

    pub(crate) fn moving(&self, base: f64, (speed, radius): (f64, f64)) -> Moving {
        Moving { from: self.from, legs: self.legs.clone(), departure: self.departure - base, speed, radius }
    }
}

/// Whether a way leads nearer to a point than so many world units; but for its first point, if it moves away from there.
pub(crate) fn leads_over(way: &[DVec2], (point, reach): (DVec2, f64)) -> bool {
    let reach = way[0].distance(point).lesser(reach) - 1e-9;
    way.windows(2).any(|leg| {
        let line: Segment = (leg[0], leg[1]).into();
        line.nearest(point).distance_squared(point) < reach * reach
    })
}

/// The point so far along a way, or its end.
pub(crate) fn along(way: &[DVec2], mut distance: f64) -> DVec2 {
    for leg in way.windows(2) {
        let length = leg[0].distance(leg[1]);
        if length >= distance {
            return leg[0] + (leg[1] - leg[0]) * (distance / length.greater(f64::MIN_POSITIVE));
        }
        distance -= length;
    }
    way[way.len() - 1]
}
