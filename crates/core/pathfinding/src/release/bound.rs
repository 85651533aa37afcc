//! How long a move of a group takes at least.

use glam::DVec2;
use maniple_geometry::Scalar;

use super::ends::middle_of;
use super::lanes::Lanes;
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
    let mean = |points: &[DVec2]| points.iter().sum::<DVec2>() / points.len() as f64;
    let displacement = mean(&group.starts).distance(mean(&group.goals));
    let through = through(&mut planner, group)?;
    Ok(farthest.greater(displacement).greater(through) / speed)
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

/// How far one goes at least in the time that all need through the narrowest place; 0 where nothing is narrow.
fn through(planner: &mut Planner<'_>, group: &Group) -> Result<f64, PlanError> {
    let trunk = trunk(planner, group)?;
    let Some(density) = trunk.lanes.density else { return Ok(0.0) };
    let (first, last) = (trunk.lanes.first(), trunk.lanes.last());
    let (mut first_in, mut last_out) = (f64::INFINITY, f64::INFINITY);
    for &start in &group.starts {
        let seen = trunk.sight_of_start(planner, start)?;
        first_in = first.map_or(0.0, |cut| cut.distance_at_least(start, seen.distance)).lesser(first_in);
    }
    for &goal in &group.goals {
        let seen = trunk.sight_of_goal(planner, goal)?;
        last_out = last.map_or(0.0, |cut| cut.distance_at_least(goal, seen.distance)).lesser(last_out);
    }
    let behind = group.starts.len().saturating_sub(trunk.lanes.count);
    Ok(first_in + last_out + behind as f64 / density + trunk.length_of_cuts())
}
