//! What another solver made of a cycle, held against the oracle.

use crate::exact::{Exact, Vector, exact, least_square, nearest, rounded, square_between};
use crate::scene::{Obstacle, Scene};
use crate::solve::{Ending, Solution, gap};
use crate::track::{Track, near, windows};

/// What a solver made of an object in a cycle: straight from where it was to `point`, where it is from `until` on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Actual {
    /// Where the centre is at the end of the cycle, in world units.
    pub point: [f64; 2],
    /// When it got there, as a fraction of the cycle; 1 where it goes on.
    pub until: f64,
    /// Whether it collided.
    pub is_stopped: bool,
}

/// How a solver did in a cycle.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Verdict {
    /// The objects that should have collided and did not.
    pub missed: Vec<usize>,
    /// The objects that collided and should not have.
    pub spurious: Vec<usize>,
    /// Mean distance of an object from where it should be at the end, in world units; 0 without objects.
    pub deviation_mean: f64,
    /// The largest such distance.
    pub deviation_max: f64,
    /// The pairs that overlap at the end, exactly: nearer than touching by anything at all. Each pair once, its smaller
    /// number first.
    pub overlapping: Vec<(usize, Obstacle)>,
    /// The deepest penetration at the end, in world units; 0 where nothing overlaps.
    pub deepest_at_end: f64,
    /// The deepest penetration at any time of the cycle, the start included, in world units.
    pub deepest: f64,
    /// The pairs that went through each other, or cut each other's corner: deeper than the tolerance at some time, but at
    /// neither end of the cycle.
    pub tunnelled: Vec<(usize, Obstacle)>,
}

/// Returns how a solver did in a cycle that began as `scene` says and ended as `actual` says, for each object.
///
/// `tolerance` is the depth in world units, zero or more, up to which going through each other is rounding: the path of an
/// object is taken from its rounded ends.
///
/// # Panics
/// Where the lists are not about the same objects, or a number is not finite.
#[must_use]
pub fn judge(scene: &Scene, solution: &Solution, actual: &[Actual], tolerance: f64) -> Verdict {
    assert_eq!(scene.objects.len(), actual.len(), "one result for each object");
    assert_eq!(scene.objects.len(), solution.outcomes.len(), "one outcome for each object");
    let mut verdict = Verdict::default();
    let mut sum = 0.0;
    for (object, (outcome, actual)) in solution.outcomes.iter().zip(actual).enumerate() {
        let should_stop = matches!(outcome.ending, Ending::Stopped(_));
        if should_stop && !actual.is_stopped {
            verdict.missed.push(object);
        } else if actual.is_stopped && !should_stop {
            verdict.spurious.push(object);
        }
        let deviation = rounded(&outcome.point.minus(&Vector::new(actual.point)).square()).sqrt();
        sum += deviation;
        verdict.deviation_max = verdict.deviation_max.max(deviation);
    }
    if !actual.is_empty() {
        verdict.deviation_mean = sum / f64::from(u32::try_from(actual.len()).expect("objects have u32 ids"));
    }
    let tracks: Vec<Track> = scene
        .objects
        .iter()
        .zip(actual)
        .map(|(object, actual)| taken(object.center, object.radius, actual))
        .collect();
    for (object, other) in near(scene, &tracks) {
        let depths = match other {
            Obstacle::Object(other) => depths_of_pair(&tracks[object], &tracks[other]),
            Obstacle::Wall(wall) => {
                let wall = &scene.walls[wall];
                depths_in_wall(&tracks[object], &[wall.start, wall.end].map(Vector::new))
            }
        };
        if depths.at_end > 0.0 {
            verdict.overlapping.push((object, other));
        }
        if depths.within > tolerance && depths.at_start <= tolerance && depths.at_end <= tolerance {
            verdict.tunnelled.push((object, other));
        }
        verdict.deepest_at_end = verdict.deepest_at_end.max(depths.at_end);
        verdict.deepest = verdict.deepest.max(depths.within);
    }
    verdict
}

/// The way that an object took.
fn taken(center: [f64; 2], radius: f64, actual: &Actual) -> Track {
    let (start, rest, end) = (Vector::new(center), Vector::new(actual.point), exact(actual.until));
    let velocity =
        if end.is_zero() { Vector::new([0.0; 2]) } else { rest.minus(&start).times(&(Exact::ONE / &end)) };
    Track { radius: exact(radius), start, velocity, end, rest, is_stopped: false, leverage: 0.0 }
}

/// How deep a pair penetrates, in world units: 0 or less where it does not.
struct Depths {
    at_start: f64,
    /// The most at any time.
    within: f64,
    at_end: f64,
}

fn depths_of_pair(a: &Track, b: &Track) -> Depths {
    let reach = &a.radius + &b.radius;
    let offset = |time: &Exact| b.at(time).minus(&a.at(time));
    let least = windows(&Exact::ZERO, a, b).into_iter().map(|(from, to)| {
        let velocity = b.velocity_at(&from).minus(&a.velocity_at(&from));
        least_square(&offset(&from), &velocity, &(&to - &from), offset(&to).square())
    });
    let least = least.min().expect("a cycle takes time");
    let depth = |square: &Exact| -gap(square, &reach);
    Depths {
        at_start: depth(&b.start.minus(&a.start).square()),
        within: depth(&least),
        at_end: depth(&b.rest.minus(&a.rest).square()),
    }
}

fn depths_in_wall(track: &Track, wall: &[Vector; 2]) -> Depths {
    let depth = |square: &Exact| -gap(square, &track.radius);
    let at = |point: &Vector| depth(&nearest(point, wall).minus(point).square());
    let way = [track.start.clone(), track.rest.clone()];
    Depths { at_start: at(&track.start), within: depth(&square_between(&way, wall)), at_end: at(&track.rest) }
}
