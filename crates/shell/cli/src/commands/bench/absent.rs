//! `maniple bench absent`: what a part of the model costs a scene that does not need it.
//!
//! A march in an empty world is played twice side by side, once with a part that exists somewhere apart, where nobody who
//! marches ever comes. What the part costs then is what everybody would pay for it who does not use it.

use std::time::Duration;

use glam::DVec2;
use maniple_geometry::{Circle, Moment, ObjectId, Segment};
use maniple_kinematics::{Layers, Leg, Placement, Wall, WallKind};
use rayon::ThreadPoolBuilder;
use serde::Serialize;

use crate::arguments::BenchAbsent;
use crate::commands::bench::march::{Field, March, Scene};
use crate::commands::bench::{median, too_dense};
use crate::failure::Failure;
use crate::output::{Format, grouped, print, print_text};

/// Distance of what lies apart from the field, in world units.
const GAP: f64 = 8.0;

/// Circles at rest apart, and walls.
const RESTING: u32 = 100_000;
const WALLS: u32 = 1000;

/// A part of the model that a scene may or may not need.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
enum Part {
    /// None: the same march again, to see by how much two runs of the same differ.
    Nothing,
    Walls,
    Resting,
    /// A wall in another layer, so that layers have to be asked for.
    Layers,
    /// A dwarf that moves, so that there are two orders of magnitude of spheres.
    Radius,
    /// A circle at rest with an order for a time to come.
    Alarm,
}

/// What the march took.
#[derive(Clone, Debug, Serialize)]
struct Row {
    /// What exists apart.
    part: Part,
    objects: u32,
    /// Median of the cycles, without it.
    ns_per_object_cycle: f64,
    /// Median of the cycles, with it.
    ns_with: f64,
    /// Median over the cycles of the one time to the other.
    ratio: f64,
}

impl Part {
    const ALL: [Self; 6] =
        [Self::Nothing, Self::Walls, Self::Resting, Self::Layers, Self::Radius, Self::Alarm];

    fn text(self) -> String {
        match self {
            Self::Nothing => "nothing".to_owned(),
            Self::Walls => format!("{} walls", grouped(u64::from(WALLS))),
            Self::Resting => format!("{} circles at rest", grouped(u64::from(RESTING))),
            Self::Layers => "a wall in another layer".to_owned(),
            Self::Radius => "a dwarf that moves".to_owned(),
            Self::Alarm => "an order for a later cycle".to_owned(),
        }
    }

    /// Puts the part into the world of a march, apart from the field.
    fn add(self, march: &mut March<'_>, scene: &Scene) {
        let corner = DVec2::new(scene.field.size().x + GAP, GAP);
        let id = ObjectId(scene.objects());
        let world = &mut march.world;
        let wall = |place: u32, layers| {
            let start = corner + DVec2::new(f64::from(place % 500) * 3.0, f64::from(place / 500) * 3.0);
            let segment = Segment::new(start, start + DVec2::new(1.0, 0.0));
            Wall { segment, kind: WallKind::Segment, layers }
        };
        match self {
            // Circles at rest are part of the scene.
            Self::Nothing | Self::Resting => {}
            Self::Walls => {
                for place in 0..WALLS {
                    world.insert_wall(wall(place, Layers::GROUND)).expect("within the limits");
                }
            }
            Self::Layers => {
                world.insert_wall(wall(0, Layers::AIR)).expect("within the limits");
            }
            Self::Radius => {
                world.insert(id, Circle::new(corner, 0.02), Layers::GROUND).expect("nobody is there");
                let leg = Leg { goal: corner + DVec2::new(1000.0, 0.0), speed: 0.01 };
                world.go(id, &[leg], Placement::Replace, None).expect("within the limits");
            }
            Self::Alarm => {
                world.insert(id, Circle::new(corner, 0.4), Layers::GROUND).expect("nobody is there");
                let leg = Leg { goal: corner + DVec2::new(5.0, 0.0), speed: 0.1 };
                let start = Moment { cycle: maniple_geometry::Cycle(u32::MAX / 2), fraction: 0.0 };
                world.go(id, &[leg], Placement::Replace, Some(start)).expect("a time to come");
            }
        }
    }
}

/// Runs `maniple bench absent`.
pub(super) fn run(arguments: &BenchAbsent) -> Result<(), Failure> {
    let format = Format::of(&arguments.json);
    let BenchAbsent { objects, density, seed, .. } = *arguments;
    let field = Field::square(objects, density).emptied();
    let scene = |resting| Scene::place(field.clone(), objects, resting, seed).map_err(Failure::failed);
    let (bare, beside_resting) = (scene(0)?, scene(RESTING)?);
    if bare.objects() < objects {
        return Err(too_dense(objects, density, bare.objects()));
    }
    if format == Format::Text {
        print_text(&header(arguments))?;
    }
    let pool =
        ThreadPoolBuilder::new().num_threads(1).build().map_err(|error| Failure::Failed(error.into()))?;
    let mut rows = Vec::new();
    for part in Part::ALL {
        let other = if part == Part::Resting { &beside_resting } else { &bare };
        let row = pool.install(|| measure(part, (&bare, other), arguments.cycles));
        if format == Format::Text {
            print_text(&line(&row))?;
        }
        rows.push(row);
    }
    match format {
        Format::Text => Ok(()),
        Format::Json => print(format, &rows, |_| String::new()),
    }
}

/// Lets two scenes march side by side, the second with a part apart.
fn measure(part: Part, (bare, other): (&Scene, &Scene), cycles: u32) -> Row {
    let (mut without, mut with) = (March::new(bare), March::new(other));
    part.add(&mut with, other);
    without.warm_up();
    with.warm_up();
    let mut times: [Vec<Duration>; 2] = [Vec::new(), Vec::new()];
    let mut ratios = Vec::new();
    for cycle in 0..cycles {
        without.order();
        with.order();
        // Now the one goes first, now the other, so that the caches favour neither.
        let (first, second) = if cycle % 2 == 0 {
            let first = without.step();
            (first, with.step())
        } else {
            let second = with.step();
            (without.step(), second)
        };
        assert_eq!(first.collisions, second.collisions, "what lies apart changes nothing");
        ratios.push(second.took.as_secs_f64() / first.took.as_secs_f64());
        times[0].push(first.took);
        times[1].push(second.took);
    }
    ratios.sort_by(f64::total_cmp);
    let ns = |times: &mut [Duration]| 1e9 * median(times).as_secs_f64() / f64::from(bare.objects());
    let [without, with] = &mut times;
    Row {
        part,
        objects: bare.objects(),
        ns_per_object_cycle: ns(without),
        ns_with: ns(with),
        ratio: ratios[ratios.len() / 2],
    }
}

fn header(arguments: &BenchAbsent) -> String {
    format!(
        "{} circles that march, beside what they never meet; seed {}, medians of {} cycles\n{:<28} {:>10} {:>10} {:>7}\n",
        grouped(u64::from(arguments.objects)),
        arguments.seed,
        grouped(u64::from(arguments.cycles)),
        "apart from them",
        "ns without",
        "ns with",
        "ratio",
    )
}

fn line(row: &Row) -> String {
    format!(
        "{:<28} {:>10.1} {:>10.1} {:>7.3}\n",
        row.part.text(),
        row.ns_per_object_cycle,
        row.ns_with,
        row.ratio
    )
}
