//! How long a move of a group takes at least.

use glam::DVec2;
use maniple_geometry::Scalar;

use super::ends::{mean_of, middle_of};
use super::lanes::{Cut, Lanes};
use super::schedule::{Goals, Group};
use super::trunk::Trunk;
use crate::error::PlanError;
use crate::field::Field;
use crate::ground::Ground;
use crate::planner::{Planner, length};

/// Returns how many cycles a group needs at least at a speed in world units a cycle: a yardstick for schedules.
///
/// The longest of: the longest of the own ways, or, where goals are interchangeable, the nearest way from who is farthest, and by how much
/// all together come nearer to the goal that is farthest, by their number, and the same seen from there; how far the middle of all moves;
/// and, where all have to pass a narrow place, the way of the nearest to it, the time in which all pass in the densest packing of
/// circles in rows, and the way from there to the nearest goal. Ways are those of the planner, which are short but not shortest: whoever
/// goes around others may find one that is a little shorter.
///
/// # Errors
/// An end without a path.
pub fn bound(ground: &Ground, group: &Group, speed: f64) -> Result<f64, PlanError> {
    if group.starts.is_empty() {
        return Ok(0.0);
    }
    let mut planner = Planner::new(ground);
    let farthest = match group.whose {
        Goals::Own => {
            let mut farthest = 0.0;
            for (&start, &goal) in group.starts.iter().zip(&group.goals) {
                farthest = length(start, planner.path(start, goal)?).greater(farthest);
            }
            farthest
        }
        Goals::Interchangeable => {
            let away = away(&mut planner, &group.starts, &group.goals)?;
            away.greater(self::away(&mut planner, &group.goals, &group.starts)?)
        }
    };
    let displacement = mean_of(&group.starts).distance(mean_of(&group.goals));
    let through = Narrow::new(&mut planner, group)?.map_or(0.0, |narrow| narrow.course());
    Ok(farthest.greater(displacement).greater(through) / speed)
}

/// Returns how many cycles groups need at least that go at once: the longest that one of them needs alone, or, where several pass one
/// narrow place, in whichever directions, the time in which all pass it in the densest packing of circles in rows, with the shortest
/// ways to it and from it. A row is passed in one direction at a time, so that groups that meet pass no denser than one.
///
/// # Errors
/// An end without a path.
pub fn bound_of_groups(ground: &Ground, groups: &[Group], speed: f64) -> Result<f64, PlanError> {
    let mut longest = 0.0;
    for group in groups {
        longest = bound(ground, group, speed)?.greater(longest);
    }
    let mut planner = Planner::new(ground);
    let mut places: Vec<Narrow> = Vec::new();
    for group in groups.iter().filter(|group| !group.starts.is_empty()) {
        let Some(narrow) = Narrow::new(&mut planner, group)? else { continue };
        match places.iter_mut().find(|place| place.is_same(&narrow)) {
            Some(place) => *place = place.joined(&narrow),
            None => places.push(narrow),
        }
    }
    let through = places.iter().map(Narrow::course).fold(0.0, Scalar::greater);
    Ok(longest.greater(through / speed))
}

/// How far somebody goes at least from some points to others, whoever goes where: from the one that is farthest from the middle of the
/// others to the nearest of them; and since nobody comes nearer to that one, or goes away from it, by more than its way is long, by how
/// much farther the others are from it in the mean.
fn away(planner: &mut Planner<'_>, ones: &[DVec2], others: &[DVec2]) -> Result<f64, PlanError> {
    let mut ways = |from: &[DVec2], to: DVec2| -> Result<Vec<f64>, PlanError> {
        let field = Field::new(planner.ground(), to)?;
        from.iter().map(|&from| Ok(length(from, planner.path_by(&field, from)?))).collect()
    };
    let to_middle = ways(ones, middle_of(others))?;
    let farthest = (0..ones.len()).max_by(|&a, &b| to_middle[a].total_cmp(&to_middle[b]));
    let Some(farthest) = farthest.map(|index| ones[index]) else { return Ok(0.0) };
    let (to_others, to_ones) = (ways(others, farthest)?, ways(ones, farthest)?);
    let nearest = to_others.iter().copied().fold(f64::INFINITY, Scalar::lesser);
    let mean = |lengths: &[f64]| lengths.iter().sum::<f64>() / lengths.len() as f64;
    Ok(nearest.greater(mean(&to_others) - mean(&to_ones)))
}

/// Returns how many circles of a group can pass the narrowest place on its way in a cycle, at a speed in world units a cycle: in the
/// densest packing in rows; `None` where nothing is narrow.
///
/// # Errors
/// An end without a path.
pub fn throughput_max(ground: &Ground, group: &Group, speed: f64) -> Result<Option<f64>, PlanError> {
    if group.starts.is_empty() {
        return Ok(None);
    }
    let trunk = trunk(&mut Planner::new(ground), group)?;
    Ok(trunk.lanes.density.map(|density| density * speed))
}

/// The way of a group, with as many lanes as fit.
fn trunk(planner: &mut Planner<'_>, group: &Group) -> Result<Trunk, PlanError> {
    let ground = planner.ground();
    let (from, to) = (middle_of(&group.starts), middle_of(&group.goals));
    let lanes_of = |path: &[DVec2]| Lanes::new(ground, group, path, 2.0 * ground.radius());
    Trunk::new(planner, (from, to), lanes_of)
}

/// How near two cuts are to each other that lie in one narrow place, in world units: they are looked for at points of two paths.
const SAME: f64 = 0.5;

/// The narrowest place on the way of a group, and how its circles lie around it.
#[derive(Clone, Copy, Debug)]
struct Narrow {
    /// The first cut and the last one.
    cuts: [Cut; 2],
    lanes: usize,
    density: f64,
    /// How far it is from the first cut to the last one, in world units.
    length: f64,
    /// How far it is from the nearest start to the first cut, and from the last cut to the nearest goal, at least.
    before: f64,
    behind: f64,
    circles: usize,
}

impl Narrow {
    /// `None` where nothing is narrow.
    fn new(planner: &mut Planner<'_>, group: &Group) -> Result<Option<Self>, PlanError> {
        let trunk = trunk(planner, group)?;
        let lanes = &trunk.lanes;
        let (Some(density), Some(&first), Some(&last)) = (lanes.density, lanes.first(), lanes.last()) else {
            return Ok(None);
        };
        let (mut before, mut behind) = (f64::INFINITY, f64::INFINITY);
        for &start in &group.starts {
            let seen = trunk.sight_of_start(planner, start)?;
            before = first.distance_at_least(start, seen.distance).lesser(before);
        }
        for &goal in &group.goals {
            let seen = trunk.sight_of_goal(planner, goal)?;
            behind = last.distance_at_least(goal, seen.distance).lesser(behind);
        }
        let (cuts, circles, length) = ([first, last], group.starts.len(), trunk.length_of_cuts());
        Ok(Some(Self { cuts, lanes: lanes.count, density, length, before, behind, circles }))
    }

    /// How far one goes at least in the time that all need who pass.
    fn course(&self) -> f64 {
        let followers = self.circles.saturating_sub(self.lanes);
        self.before + self.length + followers as f64 / self.density + self.behind
    }

    /// Returns whether both are one place, in whichever direction it is passed.
    fn is_same(&self, other: &Self) -> bool {
        let near = |one: &Cut, another: &Cut| one.middle().distance(another.middle()) < SAME;
        self.cuts.iter().any(|cut| other.cuts.iter().any(|another| near(cut, another)))
    }

    /// Returns the place as both groups pass it.
    fn joined(&self, other: &Self) -> Self {
        Self {
            lanes: self.lanes.max(other.lanes),
            density: self.density.greater(other.density),
            length: self.length.lesser(other.length),
            before: self.before.lesser(other.before),
            behind: self.behind.lesser(other.behind),
            circles: self.circles + other.circles,
            ..*self
        }
    }
}
