//! The scenes of the comparison: where everybody starts, and where everybody is ordered to.
//!
//! A function of the seed: an order depends on the object, on how many it has had, and on where it is. So under every
//! setting the same orders are given until runs part.

use std::path::{Path, PathBuf};

use glam::DVec2;
use maniple_geometry::{Circle, Limits, ObjectId, Planar, Segment};
use maniple_kinematics::{Layers, Leg, Stops, Wall, World};
use maniple_tilemap::TileMap;

use crate::commands::bench::march::{Field, Purpose, Scene, unit};
use crate::failure::Failure;
use crate::files;

/// Radius of every circle, in world units: 51/128, which single precision holds exactly, and a little less than that of the
/// marching circles, so that their places stay free when they are rounded.
pub(super) const RADIUS: f64 = 0.398_437_5;

/// Smallest and largest speed of a circle, in world units a cycle.
const SPEEDS: (f64, f64) = (0.1, 1.0);

/// As [`SPEEDS`], of the fast: up to 25 diameters a cycle.
const SPEEDS_FAST: (f64, f64) = (2.0, 20.0);

/// How far the far field is from the origin, along both axes, in world units. Neighbouring numbers of single precision are a
/// sixteenth apart there.
const FAR: f64 = 1e6;

/// Width of the gap of the choke point, in world units: five abreast.
const GAP: f64 = 4.0;

/// Everybody gathers within this distance of the middle, along both axes, in world units.
const GATHERING: f64 = 2.0;

/// The map that is in the program.
const MAP: &str = "maps/caves.map";

/// The share of the ground of a map that circles cover at most.
const DENSITY_ON_MAPS: f64 = 0.25;

/// A scene that has a name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Name {
    Open,
    Crowd,
    Choke,
    Gathering,
    Fast,
    Far,
    Map,
}

impl Name {
    pub(super) const ALL: [Self; 7] =
        [Self::Open, Self::Crowd, Self::Choke, Self::Gathering, Self::Fast, Self::Far, Self::Map];

    pub(super) fn text(self) -> &'static str {
        match self {
            Self::Open => "open",
            Self::Crowd => "crowd",
            Self::Choke => "choke",
            Self::Gathering => "gathering",
            Self::Fast => "fast",
            Self::Far => "far",
            Self::Map => "map",
        }
    }

    /// Returns what is to be seen, in words.
    pub(super) fn description(self) -> &'static str {
        match self {
            Self::Open => "an open field, 5 % covered",
            Self::Crowd => "a crowd, 25 % covered",
            Self::Choke => "both ways through a gap in a wall, 15 % covered",
            Self::Gathering => "everybody to one point, 15 % covered",
            Self::Fast => "speeds of 2 to 20 a cycle, 5 % covered",
            Self::Far => "the open field at 1e6, 1e6",
            Self::Map => MAP,
        }
    }

    /// The share of the field that is covered.
    fn density(self) -> f64 {
        match self {
            Self::Open | Self::Fast | Self::Far => 0.05,
            Self::Choke | Self::Gathering => 0.15,
            Self::Crowd | Self::Map => 0.25,
        }
    }
}

/// What is asked for: a scene of a name, or a map in a file.
#[derive(Clone, Debug)]
pub(super) enum Source {
    Named(Name),
    File(PathBuf),
}

impl Source {
    /// Returns the scene that a text means.
    ///
    /// # Errors
    /// A text that is neither a name nor the path of a map.
    pub(super) fn parse(text: &str) -> Result<Self, Failure> {
        if let Some(name) = Name::ALL.into_iter().find(|name| name.text() == text) {
            return Ok(Self::Named(name));
        }
        let path = Path::new(text);
        if path.extension().is_some_and(|extension| extension == "map" || extension == "tmx") {
            return Ok(Self::File(path.to_owned()));
        }
        let names = Name::ALL.map(Name::text).join(", ");
        Err(Failure::usage(format!(
            "--scene {text}: no scene of this name and no .map or .tmx file; the scenes are {names}"
        )))
    }

    pub(super) fn text(&self) -> String {
        match self {
            Self::Named(name) => name.text().to_owned(),
            Self::File(path) => path.display().to_string(),
        }
    }

    pub(super) fn description(&self) -> String {
        match self {
            Self::Named(name) => name.description().to_owned(),
            Self::File(path) => format!("the map {}", path.display()),
        }
    }

    fn name(&self) -> Name {
        match self {
            Self::Named(name) => *name,
            Self::File(_) => Name::Map,
        }
    }

    fn field(&self, objects: u32) -> Result<Field, Failure> {
        let name = self.name();
        Ok(match self {
            Self::File(path) => Field::of_map(&files::map(path)?),
            Self::Named(Name::Map) => Field::of_map(&shipped()?),
            Self::Named(Name::Choke) => {
                let field = Field::square(objects, name.density());
                let (middle, side) = (field.size().x / 2.0, field.size().y);
                let half = GAP.min(side / 2.0) / 2.0;
                let part = |from, to| Segment::new(DVec2::new(middle, from), DVec2::new(middle, to));
                field.walled(&[part(0.0, middle - half), part(middle + half, side)])
            }
            Self::Named(Name::Open | Name::Crowd | Name::Gathering | Name::Fast | Name::Far) => {
                Field::square(objects, name.density())
            }
        })
    }
}

fn shipped() -> Result<TileMap, Failure> {
    let bytes = include_bytes!("../../../../../../../maps/caves.map");
    maniple_tilemap::read(MAP, bytes, &files::Disk).map_err(Failure::failed)
}

/// A scene at its start. All its numbers are as single precision holds them, so that every setting starts with the same.
#[derive(Clone, Debug)]
pub(super) struct Arena {
    scene: Scene,
    name: Name,
    seed: u64,
    origin: DVec2,
    pub(super) starts: Vec<DVec2>,
    pub(super) walls: Vec<Wall>,
}

impl Arena {
    /// Returns a scene with so many objects, or with as many of them as find room.
    ///
    /// # Errors
    /// A file that is no map, or a map in which nobody finds room.
    pub(super) fn new(source: &Source, objects: u32, seed: u64) -> Result<Self, Failure> {
        let name = source.name();
        let origin = if name == Name::Far { DVec2::splat(FAR) } else { DVec2::ZERO };
        let field = source.field(objects)?;
        let objects = match name {
            Name::Map => objects.min(field.capacity(DENSITY_ON_MAPS)),
            Name::Open | Name::Crowd | Name::Choke | Name::Gathering | Name::Fast | Name::Far => objects,
        };
        let bad = |error| match source {
            Source::Named(_) => Failure::failed(error),
            Source::File(path) => Failure::bad_input(error).within(path),
        };
        let moved = |wall: &Wall| {
            let Segment { start, end } = wall.segment;
            Wall { segment: Segment::new(single(start + origin), single(end + origin)), ..*wall }
        };
        let walls = field.walls().iter().map(moved).collect();
        let scene = Scene::place(field, objects, 0, seed).map_err(bad)?;
        let mut arena = Self { scene, name, seed, origin, starts: Vec::new(), walls };
        let mut world: World = World::new(arena.limits(1.0), Stops::Both, &arena.walls).map_err(bad)?;
        for start in arena.scene.starts.iter().map(|&start| single(start + origin)) {
            let id = ObjectId(u32::try_from(arena.starts.len()).expect("fewer objects than ids"));
            if world.insert(id, Circle::new(start, RADIUS), Layers::GROUND).is_ok() {
                arena.starts.push(start);
            }
        }
        if arena.starts.is_empty() {
            return Err(Failure::bad_input(anyhow::anyhow!("{}: no circle finds room", source.text())));
        }
        Ok(arena)
    }

    /// Returns how many objects there are.
    pub(super) fn objects(&self) -> u32 {
        u32::try_from(self.starts.len()).expect("fewer objects than ids")
    }

    /// Returns what a world declares whose cycles are so many times longer.
    pub(super) fn limits(&self, stretch: f64) -> Limits {
        let reach = self.origin.x + self.scene.field.size().max_element() + 1.0;
        Limits::new(reach, RADIUS, self.speeds().1 * stretch).expect("no larger than a scenario may be")
    }

    /// Returns the next order of an object that has had so many, and is at `center`; the speed is that a base cycle.
    pub(super) fn order(&self, object: ObjectId, draws: &mut u64, center: DVec2) -> Leg {
        let share = |purpose, draw| unit(self.seed, purpose, &[u64::from(object.0), draw]);
        let (low, high) = self.speeds();
        let speed = low + (high - low) * share(Purpose::Speed, *draws);
        let local = center - self.origin;
        let at = |draw| DVec2::new(share(Purpose::GoalX, draw), share(Purpose::GoalY, draw));
        let size = self.scene.field.size();
        let goal = match self.name {
            Name::Open | Name::Crowd | Name::Fast | Name::Far | Name::Map => {
                let inside = local.clamp(DVec2::ZERO, size);
                self.scene.goal(object, draws, inside)
            }
            Name::Gathering => {
                let goal = size / 2.0 + (at(*draws) * 2.0 - 1.0) * GATHERING.min(size.x / 4.0);
                *draws += 1;
                goal
            }
            Name::Choke => {
                let (middle, share) = (size / 2.0, at(*draws));
                *draws += 1;
                let is_in_gap = (local.x - middle.x).abs() < RADIUS;
                if is_in_gap {
                    let right = share.x < 0.5;
                    DVec2::new(size.x * if right { 0.9 } else { 0.1 }, size.y * share.y)
                } else {
                    let half = GAP.min(size.y / 2.0) / 2.0 - RADIUS;
                    DVec2::new(middle.x, middle.y + half * (2.0 * share.y - 1.0))
                }
            }
        };
        // No -0, which the border refuses.
        Leg { goal: goal + self.origin + 0.0, speed }
    }

    fn speeds(&self) -> (f64, f64) {
        match self.name {
            Name::Fast => SPEEDS_FAST,
            Name::Open | Name::Crowd | Name::Choke | Name::Gathering | Name::Far | Name::Map => SPEEDS,
        }
    }
}

/// The nearest point that single precision holds.
fn single(point: DVec2) -> DVec2 {
    glam::Vec2::from_dvec2(point).to_dvec2()
}
