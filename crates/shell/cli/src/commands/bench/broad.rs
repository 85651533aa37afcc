//! `maniple bench broad`: ways to find the pairs that may meet in a cycle, and what each costs over the number of objects.

use std::time::{Duration, Instant};

use glam::DVec2;
use maniple_geometry::Circle;
use maniple_geometry::contact::{Straight, straight_contact};
use maniple_kinematics::BroadPhase;
use serde::Serialize;

use crate::arguments::BenchBroad;
use crate::commands::bench::march::{Field, March, Scene};
use crate::commands::bench::{median, too_dense};
use crate::failure::Failure;
use crate::output::{Format, grouped, print, print_text};

/// Most objects of which every pair is tested: 50 million pairs take half a second, ten times the objects a minute.
const ALL_PAIRS_MAX: u32 = 10_000;

/// A method is repeated for so long, so that what comes between counts little.
const RUN_TIME: Duration = Duration::from_millis(100);

/// A method is repeated at least so often.
const RUNS_MIN: usize = 3;

/// Height of the rows in which the circles lie in memory, in world units: about that of a sector.
const ROW: f64 = 2.0;

/// A way to find the pairs that may meet.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
enum Method {
    /// The exact contact of every pair.
    AllPairs,
    /// The bounding boxes of the motions of every pair.
    Boxes,
    /// The motion spheres of every pair.
    Spheres,
    /// The motion spheres of neighbouring sectors.
    Sectors,
}

/// What a method took.
#[derive(Clone, Debug, Serialize)]
struct Row {
    method: Method,
    objects: u32,
    pairs_tested: u64,
    /// Pairs that pass the test of the method.
    pairs_found: u64,
    /// Median of the runs.
    ns_per_object: f64,
}

/// Runs `maniple bench broad`.
pub(super) fn run(arguments: &BenchBroad) -> Result<(), Failure> {
    let format = Format::of(&arguments.json);
    if format == Format::Text {
        print_text(&header(arguments))?;
    }
    let mut rows: Vec<Row> = Vec::new();
    for &objects in &arguments.objects {
        let mut cycle = Cycle::of(objects, arguments)?;
        for method in Method::ALL {
            if method.tests_every_pair() && objects > ALL_PAIRS_MAX {
                continue;
            }
            let row = cycle.measure(method, objects);
            if format == Format::Text {
                print_text(&line(&row))?;
            }
            rows.push(row);
        }
    }
    if let Some(text) = left_out(&arguments.objects) {
        eprintln!("{text}");
    }
    match format {
        Format::Text => Ok(()),
        Format::Json => print(format, &rows, |_| String::new()),
    }
}

impl Method {
    const ALL: [Self; 4] = [Self::AllPairs, Self::Boxes, Self::Spheres, Self::Sectors];

    fn tests_every_pair(self) -> bool {
        match self {
            Self::AllPairs | Self::Boxes | Self::Spheres => true,
            Self::Sectors => false,
        }
    }

    /// Returns the name, as in JSON.
    fn name(self) -> &'static str {
        match self {
            Self::AllPairs => "all_pairs",
            Self::Boxes => "boxes",
            Self::Spheres => "spheres",
            Self::Sectors => "sectors",
        }
    }
}

/// A cycle that lies ahead, and the memory of the methods, which is taken once as in a world.
struct Cycle {
    /// Row by row: a world also keeps those near in memory that are near in the plane.
    straights: Vec<Straight>,
    skin: f64,
    boxes: Vec<Bounds>,
    spheres: Vec<Circle>,
    broad_phase: BroadPhase,
}

/// How many pairs were tested, and how many passed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Pairs {
    tested: u64,
    found: u64,
}

impl Cycle {
    /// Returns a cycle of a march that has warmed up.
    fn of(objects: u32, arguments: &BenchBroad) -> Result<Self, Failure> {
        let density = arguments.density;
        let field = Field::square(objects, density);
        let scene = Scene::place(field, objects, 0, arguments.seed).map_err(Failure::failed)?;
        if scene.objects() < objects {
            return Err(too_dense(objects, density, scene.objects()));
        }
        let mut march = March::new(&scene);
        march.warm_up();
        march.order();
        let mut straights = march.straights();
        let key = |of: &Straight| ((of.point.y / ROW).floor(), of.point.x);
        straights.sort_by(|a, b| {
            let ((row, x), (other_row, other_x)) = (key(a), key(b));
            row.total_cmp(&other_row).then(x.total_cmp(&other_x))
        });
        Ok(Self {
            straights,
            skin: march.world.skin(),
            boxes: Vec::new(),
            spheres: Vec::new(),
            broad_phase: BroadPhase::new(),
        })
    }

    fn measure(&mut self, method: Method, objects: u32) -> Row {
        let begun = Instant::now();
        let mut times = Vec::new();
        let mut pairs = Pairs { tested: 0, found: 0 };
        while times.len() < RUNS_MIN || begun.elapsed() < RUN_TIME {
            let run = Instant::now();
            pairs = self.find(method);
            times.push(run.elapsed());
        }
        Row {
            method,
            objects,
            pairs_tested: pairs.tested,
            pairs_found: pairs.found,
            ns_per_object: 1e9 * median(&mut times).as_secs_f64() / f64::from(objects),
        }
    }

    /// Finds the pairs by a method; boxes and spheres are made anew, as in each cycle.
    fn find(&mut self, method: Method) -> Pairs {
        let (skin, margin) = (self.skin, 2.0 * self.skin);
        match method {
            Method::AllPairs => every_pair(&self.straights, |a, b| straight_contact(a, b, skin).is_some()),
            Method::Boxes => {
                self.boxes.clear();
                self.boxes.extend(self.straights.iter().map(|straight| Bounds::of(straight, margin)));
                every_pair(&self.boxes, Bounds::meets)
            }
            Method::Spheres => {
                self.make_spheres(margin);
                every_pair(&self.spheres, spheres_intersect)
            }
            Method::Sectors => {
                self.make_spheres(margin);
                let near = self.broad_phase.near_pairs(&self.spheres);
                Pairs { tested: near.tested as u64, found: near.found as u64 }
            }
        }
    }

    fn make_spheres(&mut self, margin: f64) {
        self.spheres.clear();
        self.spheres.extend(self.straights.iter().map(|straight| motion_sphere(straight, margin)));
    }
}

/// Tests every pair.
fn every_pair<T>(items: &[T], passes: impl Fn(&T, &T) -> bool) -> Pairs {
    let mut found = 0;
    for (place, first) in items.iter().enumerate() {
        found += items[place + 1..].iter().filter(|second| passes(first, second)).count();
    }
    let count = items.len() as u64;
    Pairs { tested: count * (count - 1) / 2, found: found as u64 }
}

/// The smallest box with sides along the axes that holds a motion.
#[derive(Clone, Copy, Debug)]
struct Bounds {
    low: DVec2,
    high: DVec2,
}

impl Bounds {
    fn of(straight: &Straight, margin: f64) -> Self {
        let (from, to) = (straight.point, straight.point + straight.velocity);
        let reach = DVec2::splat(straight.radius + margin);
        Self { low: from.min(to) - reach, high: from.max(to) + reach }
    }

    fn meets(&self, other: &Self) -> bool {
        self.low.x <= other.high.x
            && other.low.x <= self.high.x
            && self.low.y <= other.high.y
            && other.low.y <= self.high.y
    }
}

/// The circle that holds every point that a circle passes: around the middle of the way.
fn motion_sphere(straight: &Straight, margin: f64) -> Circle {
    let half = straight.velocity * 0.5;
    Circle::new(straight.point + half, half.length() + straight.radius + margin)
}

/// `|c - d|² <= (R + S)²`, which needs no root.
fn spheres_intersect(a: &Circle, b: &Circle) -> bool {
    let (offset, reach) = (b.center - a.center, a.radius + b.radius);
    offset.dot(offset) <= reach * reach
}

/// Returns what to say of the rows that are not there; `None` where all are.
fn left_out(objects: &[u32]) -> Option<String> {
    let counts: Vec<String> = objects
        .iter()
        .filter(|&&count| count > ALL_PAIRS_MAX)
        .map(|&count| grouped(u64::from(count)))
        .collect();
    let methods: Vec<&str> =
        Method::ALL.into_iter().filter(|method| method.tests_every_pair()).map(Method::name).collect();
    (!counts.is_empty()).then(|| {
        format!(
            "left out: {} with {} objects; they test every pair, so they run with up to {} only",
            methods.join(", "),
            counts.join(" and "),
            grouped(u64::from(ALL_PAIRS_MAX)),
        )
    })
}

fn header(arguments: &BenchBroad) -> String {
    format!(
        "pairs that may meet in a cycle of circles that march; density {}, seed {}, median time, one thread\n\
         {:>9} {:>9} {:>13} {:>11} {:>11}\n",
        arguments.density, arguments.seed, "method", "objects", "pairs tested", "pairs found", "ns/object",
    )
}

fn line(row: &Row) -> String {
    format!(
        "{:>9} {:>9} {:>13} {:>11} {:>11.1}\n",
        row.method.name(),
        grouped(u64::from(row.objects)),
        grouped(row.pairs_tested),
        grouped(row.pairs_found),
        row.ns_per_object,
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    fn straight(x: f64, y: f64, velocity: (f64, f64)) -> Straight {
        Straight { point: DVec2::new(x, y), velocity: velocity.into(), radius: 0.5 }
    }

    #[test]
    fn each_method_finds_what_passes_its_own_test() {
        let straights = vec![
            straight(0.0, 0.0, (1.0, 0.0)),
            straight(2.0, 0.0, (-1.0, 0.0)),
            straight(0.5, 1.9, (0.0, -0.5)),
            straight(100.0, 0.0, (0.0, 1.0)),
        ];
        let mut cycle = Cycle {
            straights,
            skin: 1e-12,
            boxes: Vec::new(),
            spheres: Vec::new(),
            broad_phase: BroadPhase::new(),
        };
        let mut check =
            |method, found| assert_eq!(cycle.find(method), Pairs { tested: 6, found }, "{method:?}");
        check(Method::AllPairs, 1);
        check(Method::Boxes, 1);
        check(Method::Spheres, 2);
        assert_eq!(cycle.find(Method::Sectors).found, 2);
    }

    #[test]
    fn what_is_left_out_is_said_with_the_limit() {
        assert_eq!(left_out(&[1, ALL_PAIRS_MAX]), None);
        let text = left_out(&[10, 20_000, 100_000]).expect("two are left out");
        for named in ["all_pairs, boxes, spheres", "20,000 and 100,000", "up to 10,000"] {
            assert!(text.contains(named), "{text} does not name {named}");
        }
    }
}
