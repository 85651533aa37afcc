//! Narrow places on a path, and the lanes in which circles go through them side by side.

use glam::DVec2;
use maniple_geometry::{Scalar, Segment};

use super::bundle::Bundle;
use super::fan;
use super::schedule::{Goals, Group};
use crate::ground::Ground;
use crate::planner::length;

/// Distance of the points of a path at which its width is looked at, in world units.
const STEP: f64 = 0.25;

/// How far to each side the width is looked at, in world units; what is wider is not narrow.
const REACH: f64 = 8.0;

/// How often the search for the wall on a side is halved: to less than a thousandth of a world unit.
const HALVINGS: u32 = 14;

/// How exactly the wall on a side is known, in world units.
const RESOLUTION: f64 = REACH / (1u64 << HALVINGS) as f64;

/// How far from a wall it is known for sure whether a line ends before it, in world units: 2^-20, far above rounding.
const SURE: f64 = 1.0 / (1u64 << 20) as f64;

/// Directions in which the width is looked at: every 22.5 degrees, by their slopes, nearly.
const DIRECTIONS: [(f64, f64); 8] =
    [(1.0, 0.0), (12.0, 5.0), (1.0, 1.0), (5.0, 12.0), (0.0, 1.0), (-5.0, 12.0), (-1.0, 1.0), (-12.0, 5.0)];

/// The largest cosine between the path and a direction across it: 45 degrees.
const ACROSS_COSINE_MAX: f64 = 0.71;

/// Places that are wider than the narrowest by at most so many world units are as narrow.
const AS_NARROW: f64 = 0.05;

/// More lanes than these are not worth the work: so wide a place is none to be narrow.
const LANES_MAX: usize = 12;

/// Circles that have to stand exactly in the gaps of others would have no room for what is rounded.
const SLACK: f64 = 1.0005;

/// How far lanes are apart so that circles in one need not look at those in the next, in reaches.
const APART: f64 = 1.05;

/// How lanes lead through narrow places.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Passing {
    /// In as many as let most circles through.
    Densest,
    /// In as many, but on beats.
    OnBeats,
    /// In as many as are wholly apart.
    Apart,
    /// Each group on its right side, so that groups that meet pass each other.
    KeepRight,
    /// In half as many as let most circles through.
    Half,
    /// In one.
    OneByOne,
}

impl Passing {
    pub(crate) const ALL: [Self; 6] =
        [Self::Densest, Self::OnBeats, Self::Apart, Self::KeepRight, Self::Half, Self::OneByOne];
}

/// A line across a path on which the middle of a circle has room.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Cut {
    /// The end to the left of who goes along the path, as on a screen.
    pub(crate) left: DVec2,
    pub(crate) right: DVec2,
}

impl Cut {
    fn width(&self) -> f64 {
        self.left.distance(self.right)
    }

    pub(crate) fn middle(&self) -> DVec2 {
        0.5 * (self.left + self.right)
    }

    /// Returns its right part, as wide as it is said.
    fn right_part(&self, width: f64) -> Self {
        Self { left: self.right.lerp(self.left, width / self.width()), right: self.right }
    }

    /// Returns its middle part, as wide as it is said: lanes are parallel between cuts that are equally wide.
    fn narrowed(&self, width: f64) -> Self {
        let (middle, share) = (self.middle(), width / self.width().greater(width));
        Self { left: middle.lerp(self.left, share), right: middle.lerp(self.right, share) }
    }

    /// The direction in which it is passed, a unit vector.
    pub(crate) fn forwards(&self) -> DVec2 {
        -(self.right - self.left).perp().normalize_or_zero()
    }

    /// In which direction a point lies: -1 is wholly to the left, 1 wholly to the right.
    ///
    /// It is seen from half the width beyond the cut: from there the lanes fan out, so that ways of different lanes do not cross.
    pub(crate) fn bearing(&self, point: DVec2) -> f64 {
        let across = self.right - self.left;
        let away = point - self.middle();
        let side = if across.perp_dot(away) < 0.0 { -0.5 } else { 0.5 };
        let away = away + across.perp() * side;
        let scale = across.length() * away.length();
        if scale > 0.0 { across.dot(away) / scale } else { 0.0 }
    }

    /// How far a point is from the cut at least, from whose middle it is so far away.
    pub(crate) fn distance_at_least(&self, point: DVec2, from_middle: f64) -> f64 {
        let line: Segment = Segment::new(self.left, self.right);
        line.nearest(point).distance(point).greater(from_middle - 0.5 * self.width())
    }

    /// The point of a lane of `lanes`, counted from the left.
    fn point(&self, lane: usize, lanes: usize) -> DVec2 {
        let share = if lanes == 1 { 0.5 } else { lane as f64 / (lanes - 1) as f64 };
        self.left + (self.right - self.left) * share
    }
}

/// The narrow places of a path, each by its cuts in the order in which they are passed, and how many lanes lead through all of them; or
/// lanes side by side, between the cuts where they begin and where they end.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Lanes {
    cuts: Vec<Cut>,
    /// At least one.
    pub(crate) count: usize,
    /// Circles a world unit of way that pass, all lanes together; `None` where nothing is narrow.
    pub(crate) density: Option<f64>,
}

impl Lanes {
    /// Returns the lanes through the narrow places that a group passes on a path that keeps clear of walls, from its middle to that of
    /// its goals; `reach` is how far the middles of two circles are apart at least.
    pub(crate) fn new(ground: &Ground, group: &Group, path: &[DVec2], reach: f64) -> Self {
        let cuts = cuts(ground, group, path);
        let narrowest = cuts.iter().flatten().map(Cut::width).fold(f64::INFINITY, Scalar::lesser);
        let (count, density) = best(narrowest, reach);
        if count > LANES_MAX {
            return Self::none();
        }
        let widest = narrowest + AS_NARROW;
        let is_narrow = |cut: &Option<Cut>| cut.is_some_and(|cut| cut.width() <= widest);
        let mut kept = Vec::new();
        for (index, cut) in cuts.iter().enumerate() {
            let is_end = |neighbour: Option<usize>| {
                !neighbour.and_then(|neighbour| cuts.get(neighbour)).is_some_and(is_narrow)
            };
            if is_narrow(cut) && (is_end(index.checked_sub(1)) || is_end(Some(index + 1))) {
                kept.extend(cut.map(|cut| cut.narrowed(narrowest)));
            }
        }
        Self { cuts: kept, count, density: Some(density) }
    }

    /// Returns the lanes of a bundle, between where it begins and where it ends.
    pub(crate) fn of_bundle(bundle: &Bundle) -> Self {
        Self { cuts: bundle.cuts().to_vec(), count: bundle.lanes.len(), density: None }
    }

    /// Returns no lanes, as where nothing is narrow.
    pub(crate) fn none() -> Self {
        Self { cuts: Vec::new(), count: 1, density: None }
    }

    /// Returns the same passed in another way; `None` where that is no other.
    pub(crate) fn passed(&self, passing: Passing, reach: f64) -> Option<Self> {
        let width = self.cuts.iter().map(Cut::width).fold(f64::INFINITY, Scalar::lesser);
        let fewer = |count: usize| (count < self.count).then(|| Self { count, ..self.clone() });
        match passing {
            Passing::Densest => Some(self.clone()),
            Passing::OnBeats => {
                (self.count > 1 && width / ((self.count - 1) as f64) < reach).then(|| self.clone())
            }
            Passing::Apart => {
                let is_apart = |&lanes: &usize| lanes == 1 || width >= APART * reach * (lanes - 1) as f64;
                fewer((1..self.count).rev().find(is_apart)?)
            }
            Passing::KeepRight => {
                self.density?;
                let right = (width >= SLACK * reach).then_some(0.5 * (width - SLACK * reach))?;
                let (count, density) = best(right, reach);
                let cuts = self.cuts.iter().map(|cut| cut.right_part(right)).collect();
                Some(Self { cuts, count, density: Some(density) })
            }
            Passing::Half => fewer(self.count.div_ceil(2)),
            Passing::OneByOne => fewer(1),
        }
    }

    /// Returns how far circles in a lane are behind each other where all keep to beats.
    pub(crate) fn spacing(&self, reach: f64) -> f64 {
        let width = self.cuts.iter().map(Cut::width).fold(f64::INFINITY, Scalar::lesser);
        let staggered = self.count as f64 / density(width, self.count, reach);
        staggered.greater(fan::spacing(reach)) * SLACK
    }

    /// Returns whether these are the lanes of a bundle.
    pub(crate) fn is_side_by_side(&self) -> bool {
        self.density.is_none() && !self.cuts.is_empty()
    }

    /// The first cut; `None` where nothing is narrow.
    pub(crate) fn first(&self) -> Option<&Cut> {
        self.cuts.first()
    }

    /// The last cut.
    pub(crate) fn last(&self) -> Option<&Cut> {
        self.cuts.last()
    }

    /// The points at which a lane passes the cuts, in their order.
    pub(crate) fn points(&self, lane: usize) -> impl Iterator<Item = DVec2> {
        self.cuts.iter().map(move |cut| cut.point(lane, self.count))
    }
}

/// Returns where a path leaves the last of its narrowest places; `None` where nothing is narrow.
pub(crate) fn last_narrow_place(ground: &Ground, from: DVec2, legs: &[DVec2]) -> Option<DVec2> {
    let path: Vec<DVec2> = std::iter::once(from).chain(legs.iter().copied()).collect();
    let nobody = Group { starts: Vec::new(), goals: Vec::new(), whose: Goals::Own };
    let lanes = Lanes::new(ground, &nobody, &path, 2.0 * ground.radius());
    lanes.last().map(Cut::middle)
}

/// How many lanes side by side let most circles through a cut of a width, and how many circles a world unit of way these are.
///
/// With `k` lanes their distance is `h = width / (k - 1)`. Circles in one lane are `reach` apart; those in neighbouring lanes
/// stand in the gaps, so that circles in one lane are at least `2 √(reach² - h²)` apart; lanes that are next but one must
/// not touch, which needs `h >= reach / 2` from the third on.
pub(crate) fn best(width: f64, reach: f64) -> (usize, f64) {
    let (mut count, mut most) = (1, 1.0 / reach);
    if !width.is_finite() {
        return (usize::MAX, f64::INFINITY);
    }
    for lanes in 2..=LANES_MAX + 1 {
        if lanes > 2 && width < reach * 0.5 * (lanes - 1) as f64 {
            break;
        }
        let dense = density(width, lanes, reach);
        if dense > most {
            (count, most) = (lanes, dense);
        }
    }
    (count, most)
}

/// How many circles a world unit of way pass in so many lanes.
fn density(width: f64, lanes: usize, reach: f64) -> f64 {
    if lanes == 1 {
        return 1.0 / reach;
    }
    let apart = width / (lanes - 1) as f64;
    let stagger = reach * reach - apart * apart;
    let spacing = if stagger > 0.0 { (2.0 * stagger.sqrt()).greater(reach) } else { reach };
    lanes as f64 / spacing
}

/// The narrowest cut at each of the points along a path; `None` where it is wide, or not all of the group pass.
fn cuts(ground: &Ground, group: &Group, path: &[DVec2]) -> Vec<Option<Cut>> {
    let whole = length(path[0], &path[1..]);
    let (first, last) = (path[0], path[path.len() - 1]);
    let (start_extent, goal_extent) = (extent(&group.starts, first), extent(&group.goals, last));
    let mut cuts = Vec::new();
    let mut narrowest = f64::INFINITY;
    let mut before = 0.0;
    for leg in path.windows(2) {
        let length = leg[0].distance(leg[1]);
        let mut along = 0.0;
        while along < length {
            let unit = (leg[1] - leg[0]) / length;
            let (point, place) = (leg[0] + unit * along, before + along);
            let is_beyond = |end: &DVec2| (*end - point).dot(unit) > 0.0;
            // In the middle of a group some would have to go back to it.
            let is_passed = (place > start_extent || !group.starts.iter().any(is_beyond))
                && (whole - place > goal_extent || group.goals.iter().all(is_beyond));
            // Where it is for sure too wide to be among the narrowest it need not be looked at.
            let is_wide = 2.0 * (ground.walls.clear_around(point) - RESOLUTION) > narrowest + AS_NARROW;
            let cut = if is_passed && !is_wide { cut(ground, point, unit) } else { None };
            narrowest = cut.map_or(f64::INFINITY, |cut| cut.width()).lesser(narrowest);
            cuts.push(cut);
            along += STEP;
        }
        before += length;
    }
    cuts
}

/// How far the farthest of some points is from another.
pub(crate) fn extent(points: &[DVec2], from: DVec2) -> f64 {
    points.iter().map(|point| point.distance(from)).fold(0.0, Scalar::greater)
}

/// The narrowest cut at a point of a path with a direction of length 1; `None` where it is wide.
fn cut(ground: &Ground, middle: DVec2, unit: DVec2) -> Option<Cut> {
    if !ground.holds(middle) {
        return Some(Cut { left: middle, right: middle });
    }
    let mut narrowest: Option<Cut> = None;
    for (x, y) in DIRECTIONS {
        let direction = DVec2::new(x, y).normalize();
        if direction.dot(unit).abs() > ACROSS_COSINE_MAX {
            continue;
        }
        // With y down, left of the way is where the cross product is negative.
        let direction = if unit.perp_dot(direction) < 0.0 { direction } else { -direction };
        let longest = narrowest.map_or(2.0 * REACH, |cut| cut.width());
        let Some(left) = end(ground, middle, direction, longest) else { continue };
        let Some(right) = end(ground, middle, -direction, longest - left) else { continue };
        narrowest = Some(Cut { left: middle + direction * left, right: middle - direction * right });
    }
    narrowest
}

/// How far it is to the wall in a direction from a point that holds a circle; `None` where it is farther than `longest` or [`REACH`].
fn end(ground: &Ground, from: DVec2, direction: DVec2, longest: f64) -> Option<f64> {
    let (mut near, mut far) = (0.0, longest.lesser(REACH));
    let is_clear = |so_far: f64| ground.is_clear(from, from + direction * so_far);
    let wall = ground.walls.way_ahead(from, direction, far + SURE);
    let is_open = wall.is_infinite() && ground.is_within(from + direction * far);
    if is_open || is_clear(far) {
        return None;
    }
    for _ in 0..HALVINGS {
        let middle = 0.5 * (near + far);
        // Far enough from where the wall is it need not be asked.
        let is_known = wall.is_finite() && (middle - wall).abs() > SURE;
        if if is_known { middle < wall } else { is_clear(middle) } {
            near = middle;
        } else {
            far = middle;
        }
    }
    Some(near)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::planner::Planner;
    use crate::tests::{Dice, scattered};

    /// The slow twin of [`end`]: asks every time.
    fn end_by_asking(ground: &Ground, from: DVec2, direction: DVec2, longest: f64) -> Option<f64> {
        let (mut near, mut far) = (0.0, longest.lesser(REACH));
        let is_clear = |so_far: f64| ground.is_clear(from, from + direction * so_far);
        if is_clear(far) {
            return None;
        }
        for _ in 0..HALVINGS {
            let middle = 0.5 * (near + far);
            *(if is_clear(middle) { &mut near } else { &mut far }) = middle;
        }
        Some(near)
    }

    #[test]
    fn the_wall_on_a_side_is_where_lines_are_not_clear_any_more() {
        let (mut open, mut closed) = (0, 0);
        for seed in 0..20 {
            let mut dice = Dice(seed);
            let map = scattered(&mut dice, 20, 0.06);
            let ground = Ground::new(&map, 0.35).unwrap();
            for _ in 0..300 {
                let (from, longest) = (dice.place(&map, &ground), 12.0 * dice.share());
                let (x, y) = DIRECTIONS[usize::try_from(dice.roll() % 8).unwrap()];
                let direction = DVec2::new(x, y).normalize();
                let found = end(&ground, from, direction, longest);
                let expected = end_by_asking(&ground, from, direction, longest);
                assert_eq!(found, expected, "seed {seed}, {from}, {direction}, {longest}");
                *(if found.is_none() { &mut open } else { &mut closed }) += 1;
            }
        }
        assert!(open > 1000 && closed > 1000, "{open} {closed}");
    }

    #[test]
    fn only_what_is_wider_than_the_narrowest_is_not_looked_at() {
        let nobody = Group { starts: Vec::new(), goals: Vec::new(), whose: Goals::Own };
        let (mut looked_at, mut passed_over) = (0, 0);
        for seed in 0..60 {
            let mut dice = Dice(seed);
            let map = scattered(&mut dice, 60, 0.012);
            let ground = Ground::new(&map, 0.35).unwrap();
            let mut planner = Planner::new(&ground);
            let (from, to) = (dice.place(&map, &ground), dice.place(&map, &ground));
            let Ok(legs) = planner.path(from, to) else { continue };
            let path = [&[from], legs].concat();
            let found = cuts(&ground, &nobody, &path);
            let mut all = Vec::new();
            for leg in path.windows(2) {
                let length = leg[0].distance(leg[1]);
                let unit = (leg[1] - leg[0]) / length;
                let count = (0..).take_while(|&step| f64::from(step) * STEP < length);
                all.extend(count.map(|step| cut(&ground, leg[0] + unit * (f64::from(step) * STEP), unit)));
            }
            assert_eq!(found.len(), all.len(), "seed {seed}");
            let narrowest = all.iter().flatten().map(Cut::width).fold(f64::INFINITY, Scalar::lesser);
            for (found, expected) in found.iter().zip(&all) {
                if found == expected {
                    looked_at += usize::from(found.is_some());
                    continue;
                }
                let is_wide = expected.is_some_and(|cut| cut.width() > narrowest + AS_NARROW);
                assert!(found.is_none() && is_wide, "seed {seed}: {found:?}, {expected:?}, {narrowest}");
                passed_over += 1;
            }
        }
        assert!(looked_at > 300 && passed_over > 50, "{looked_at} {passed_over}");
    }

    /// How far the middles of two circles are apart at least.
    const APART_BY: f64 = 0.7;

    fn lanes(width: f64) -> Lanes {
        let cut = Cut { left: DVec2::new(0.5 * width, 0.0), right: DVec2::new(-0.5 * width, 0.0) };
        let (count, density) = best(width, APART_BY);
        Lanes { cuts: vec![cut], count, density: Some(density) }
    }

    #[test]
    fn groups_that_keep_right_pass_each_other() {
        for width in [0.71, 1.3, 2.3, 4.3] {
            let there = lanes(width).passed(Passing::KeepRight, APART_BY).unwrap();
            // Who comes back sees the same place the other way around.
            let back = Lanes {
                cuts: vec![Cut { left: -there.cuts[0].left, right: -there.cuts[0].right }],
                ..there.clone()
            };
            for (lane, other) in
                (0..there.count).flat_map(|lane| (0..back.count).map(move |other| (lane, other)))
            {
                let (one, another) = (there.points(lane).next().unwrap(), back.points(other).next().unwrap());
                assert!(one.distance(another) >= APART_BY, "{width}: {one} {another}");
            }
        }
        assert_eq!(lanes(0.69).passed(Passing::KeepRight, APART_BY), None);
    }

    #[test]
    fn a_place_is_passed_in_another_way_only_if_there_is_one() {
        let counts = |width: f64| {
            Passing::ALL.map(|passing| lanes(width).passed(passing, APART_BY).map(|lanes| lanes.count))
        };
        // Two lanes in which circles stand in each other's gaps; one; three, two that are apart, and each way two of those.
        assert_eq!(counts(0.3), [Some(2), Some(2), Some(1), None, Some(1), Some(1)]);
        assert_eq!(counts(0.05), [Some(2), Some(2), Some(1), None, Some(1), Some(1)]);
        assert_eq!(counts(0.0), [Some(1), None, None, None, None, None]);
        assert_eq!(counts(1.3), [Some(3), Some(3), Some(2), Some(2), Some(2), Some(1)]);
    }
}
