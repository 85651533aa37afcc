//! The scene of `maniple simulate`, as it is written in JSON.

use std::collections::BTreeSet;

use anyhow::{anyhow, bail};
use glam::DVec2;
use maniple_geometry::limits::{SPEED_MAX, SPEED_MIN};
use maniple_geometry::{Cycle, Limits, Moment, NumberError, Segment};
use maniple_kinematics::{Layers, Stops, Wall, WallKind};
use serde::Deserialize;

/// Largest radius of every scene, in world units: 2^10.
const RADIUS_MAX: f64 = (1u32 << 10) as f64;

/// A checked scene.
#[derive(Debug)]
pub(super) struct Scene {
    pub(super) limits: Limits,
    pub(super) stops: Stops,
    /// The segments, and the bounds as the edge.
    pub(super) walls: Vec<Wall>,
    pub(super) objects: Vec<Object>,
    /// By cycle; those of one cycle in the order of the file.
    pub(super) moves: Vec<Move>,
}

/// The scene as it is written.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct RawScene {
    bounds: [f64; 4],
    #[serde(default)]
    segments: Vec<[f64; 4]>,
    objects: Vec<Object>,
    #[serde(default)]
    moves: Vec<Move>,
    #[serde(default)]
    stops: RawStops,
}

#[derive(Clone, Copy, Debug, Default, Deserialize)]
#[serde(rename_all = "snake_case")]
enum RawStops {
    #[default]
    Both,
    Approaching,
}

/// An object.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Object {
    pub(super) id: u32,
    pub(super) x: f64,
    pub(super) y: f64,
    pub(super) r: f64,
}

/// An order to an object.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Move {
    pub(super) cycle: u32,
    pub(super) id: u32,
    x: f64,
    y: f64,
    pub(super) s: f64,
    #[serde(default)]
    pub(super) queue: bool,
    start: Option<(u32, f64)>,
}

impl Move {
    pub(super) fn goal(&self) -> DVec2 {
        DVec2::new(self.x, self.y)
    }

    pub(super) fn start(&self) -> Option<Moment> {
        self.start.map(|(cycle, fraction)| Moment { cycle: Cycle(cycle), fraction })
    }
}

impl Scene {
    /// Returns the scene in the text of a file.
    pub(super) fn read(text: &[u8]) -> anyhow::Result<Self> {
        let mut json = serde_json::Deserializer::from_slice(text);
        let raw: RawScene = serde_path_to_error::deserialize(&mut json).map_err(|error| {
            let place = named(error.path().to_string(), text);
            anyhow::Error::new(error.into_inner()).context(place)
        })?;
        json.end()?;
        let [x0, y0, x1, y1] = raw.bounds;
        if x0 >= x1 || y0 >= y1 {
            bail!("bounds: [x0, y0, x1, y1] must have x0 < x1 and y0 < y1");
        }
        let mut scene = Self {
            limits: declared_limits(&raw)?,
            stops: match raw.stops {
                RawStops::Both => Stops::Both,
                RawStops::Approaching => Stops::Approaching,
            },
            walls: Vec::with_capacity(raw.segments.len() + 4),
            objects: raw.objects,
            moves: raw.moves,
        };
        for (place, &[ax, ay, bx, by]) in raw.segments.iter().enumerate() {
            scene.check_numbers(&[("x1", ax), ("y1", ay), ("x2", bx), ("y2", by)], || {
                format!("segment {place}")
            })?;
            scene.push_wall((ax, ay), (bx, by), WallKind::Segment);
        }
        scene.check_numbers(&[("x0", x0), ("y0", y0), ("x1", x1), ("y1", y1)], || "bounds".to_owned())?;
        for (from, to) in
            [((x1, y0), (x0, y0)), ((x1, y1), (x1, y0)), ((x0, y1), (x1, y1)), ((x0, y0), (x0, y1))]
        {
            scene.push_wall(from, to, WallKind::Edge);
        }
        scene.check_objects(raw.bounds)?;
        scene.check_moves()?;
        scene.moves.sort_by_key(|order| order.cycle);
        Ok(scene)
    }

    fn push_wall(&mut self, from: (f64, f64), to: (f64, f64), kind: WallKind) {
        let segment = Segment::new(from.into(), to.into());
        self.walls.push(Wall { segment, kind, layers: Layers(u32::MAX) });
    }

    fn check_numbers(&self, numbers: &[(&str, f64)], place: impl Fn() -> String) -> anyhow::Result<()> {
        for &(field, value) in numbers {
            self.limits.check_coordinate(value).map_err(|error| {
                let is_beyond = matches!(error, NumberError::TooLarge { .. });
                let remedy = if is_beyond { ", which is that of the bounds; widen them" } else { "" };
                anyhow!("{}: {field} {error}{remedy}", place())
            })?;
        }
        Ok(())
    }

    fn check_objects(&self, [x0, y0, x1, y1]: [f64; 4]) -> anyhow::Result<()> {
        for object in &self.objects {
            let Object { id, x, y, .. } = *object;
            self.check_numbers(&[("x", x), ("y", y)], || format!("object {id}"))?;
            for (field, value, low, high) in [("x", x, x0, x1), ("y", y, y0, y1)] {
                if value < low || high < value {
                    bail!("object {id}: {field} is {value}, outside of the bounds {low} to {high}");
                }
            }
        }
        Ok(())
    }

    fn check_moves(&self) -> anyhow::Result<()> {
        let ids: BTreeSet<u32> = self.objects.iter().map(|object| object.id).collect();
        for order in &self.moves {
            let Move { cycle, id, .. } = *order;
            let place = || format!("the move of object {id} in cycle {cycle}");
            if !ids.contains(&id) {
                bail!("the move in cycle {cycle}: id {id} is no object of the scene");
            }
            self.check_numbers(&[("x", order.x), ("y", order.y)], place)?;
            self.limits.check_speed(order.s).map_err(|error| anyhow!("{}: s {error}", place()))?;
            if order.queue && order.s == 0.0 {
                bail!("{}: s is 0, which stops at once; a stop cannot be queued: leave out `queue`", place());
            }
            if let Some((start, fraction)) = order.start {
                let checked = self.limits.check_fraction(fraction);
                checked.map_err(|error| anyhow!("{}: start[1] {error}", place()))?;
                if start < cycle {
                    bail!("{}: start[0] is {start}, before that cycle", place());
                }
            }
        }
        Ok(())
    }
}

/// Returns the limits that follow from what a scene declares, and from nothing that happens in it: coordinates up to
/// the largest of the bounds, speeds up to the largest of the moves. So the skin, which follows from the limits, is as
/// small as the scene.
fn declared_limits(raw: &RawScene) -> anyhow::Result<Limits> {
    let reach = raw.bounds.into_iter().map(f64::abs).fold(0.0, f64::max);
    // One that no scene may have is found when the moves are checked, and told with its place.
    let speed = raw.moves.iter().map(|order| order.s).fold(SPEED_MIN, f64::max).min(SPEED_MAX);
    Limits::new(reach, RADIUS_MAX, speed).map_err(|(_, error)| anyhow!("bounds: a coordinate {error}"))
}

/// The ids of a scene. Whatever else is in it is skipped, so that a number that cannot be read is no hindrance.
#[derive(Debug, Deserialize)]
struct Ids {
    #[serde(default)]
    objects: Vec<Id>,
    #[serde(default)]
    moves: Vec<Id>,
}

#[derive(Debug, Deserialize)]
struct Id {
    id: Option<serde_json::Number>,
}

/// The place of an error, with the id of the object where the text gives one.
fn named(path: String, text: &[u8]) -> String {
    let id = path.split_once('[').and_then(|(list, rest)| {
        let index: usize = rest.split_once(']')?.0.parse().ok()?;
        let Ids { objects, moves } = serde_json::from_slice(text).ok()?;
        let ids = match list {
            "objects" => objects,
            "moves" => moves,
            _ => return None,
        };
        ids.get(index)?.id.clone()
    });
    match id {
        Some(id) => format!("{path} (object {id})"),
        None => path,
    }
}
