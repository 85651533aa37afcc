//! The kinematic world of a match, in the numbers that its profile asks for.

use glam::DVec2;
use maniple_geometry::limits::{RADIUS_MIN, SPEED_MIN};
use maniple_geometry::{Circle, Cycle, Limits, Moment, ObjectId, Planar, Scalar, Segment};
use maniple_kinematics::{
    Event, InsertError, Layers, Leg, Method, OrderError, Part, Placement, RestoreError, Settings, Stops,
    Wall, WallError, WallId, WallKind, World, WorldSnapshot,
};
use maniple_tilemap::TileMap;
use maniple_view::{self as view, Base, Layer, Solver, UnitType};

use super::WorldError;
use crate::load::Loaded;
use crate::scenario::Scenario;

/// Returns the layers of kinematics that a unit is in.
pub(crate) fn layers(layer: Layer) -> Layers {
    match layer {
        Layer::Ground => Layers::GROUND,
        Layer::Air => Layers::AIR,
    }
}

/// A kinematic world in one of the scalars. Whatever comes out is in doubles, and nothing is lost on the way.
pub(crate) enum Field {
    Double(World<f64>),
    Single(World<f32>),
}

/// Does the same with the world of either scalar.
macro_rules! either {
    ($field:expr, $world:ident => $what:expr) => {
        match $field {
            Field::Double($world) => $what,
            Field::Single($world) => $what,
        }
    };
}

impl Field {
    /// Returns the world with all walls of a match, and nobody in it.
    pub(crate) fn new(loaded: &Loaded) -> Result<Self, WorldError> {
        Ok(match loaded.scenario.profile.scalar {
            view::Scalar::F64 => Self::Double(filled(loaded)?),
            view::Scalar::F32 => Self::Single(filled(loaded)?),
        })
    }

    /// See [`World::go`].
    pub(crate) fn go(
        &mut self,
        object: ObjectId,
        legs: &[Leg],
        placement: Placement,
        start: Option<Moment>,
    ) -> Result<(), OrderError> {
        match self {
            Self::Double(world) => world.go(object, legs, placement, start),
            Self::Single(world) => {
                let leg = |leg: &Leg| Leg {
                    goal: Planar::from_dvec2(leg.goal),
                    speed: Scalar::from_f64(leg.speed),
                };
                let legs: Vec<Leg<f32>> = legs.iter().map(leg).collect();
                world.go(object, &legs, placement, start)
            }
        }
    }

    /// See [`World::halt`].
    pub(crate) fn halt(&mut self, object: ObjectId, start: Option<Moment>) -> Result<(), OrderError> {
        either!(self, world => world.halt(object, start))
    }

    /// See [`World::insert`].
    pub(crate) fn insert(
        &mut self,
        object: ObjectId,
        center: DVec2,
        radius: f64,
        layer: Layer,
    ) -> Result<(), InsertError> {
        match self {
            Self::Double(world) => world.insert(object, Circle::new(center, radius), layers(layer)),
            Self::Single(world) => {
                let circle = Circle::new(Planar::from_dvec2(center), Scalar::from_f64(radius));
                world.insert(object, circle, layers(layer))
            }
        }
    }

    /// Puts the four sides of a rectangle into the world.
    pub(crate) fn insert_sides(
        &mut self,
        center: DVec2,
        half: DVec2,
        layer: Layer,
    ) -> Result<Vec<WallId>, WallError> {
        let corner = |x: f64, y: f64| center + half * DVec2::new(x, y);
        let corners = [corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)];
        let mut walls = Vec::with_capacity(corners.len());
        for (place, &start) in corners.iter().enumerate() {
            let end = corners[(place + 1) % corners.len()];
            match either!(self, world => world.insert_wall(side(start, end, layer))) {
                Ok(wall) => walls.push(wall),
                Err(problem) => {
                    self.remove_walls(&walls);
                    return Err(problem);
                }
            }
        }
        Ok(walls)
    }

    /// Takes walls that are there out of the world.
    pub(crate) fn remove_walls(&mut self, walls: &[WallId]) {
        for &wall in walls {
            let is_there = either!(self, world => world.remove_wall(wall).is_some());
            assert!(is_there, "a side stays until its rectangle goes");
        }
    }

    /// Takes an object that is there out of the world.
    pub(crate) fn remove(&mut self, object: ObjectId) {
        either!(self, world => world.remove(object)).expect("who is alive is in the world");
    }

    /// See [`World::snapshot`].
    pub(crate) fn snapshot(&self) -> WorldSnapshot {
        either!(self, world => world.snapshot())
    }

    /// See [`World::restore`].
    pub(crate) fn restore(&mut self, snapshot: &WorldSnapshot) -> Result<(), RestoreError> {
        either!(self, world => world.restore(snapshot))
    }

    /// Returns a radius as the scalar has it.
    pub(crate) fn rounded(&self, radius: f64) -> f64 {
        match self {
            Self::Double(_) => radius,
            Self::Single(_) => f32::from_f64(radius).to_f64(),
        }
    }

    /// See [`World::step_by_parts`].
    pub(crate) fn step_by_parts(&mut self, done: impl FnMut(Part)) -> &[Event] {
        either!(self, world => world.step_by_parts(done))
    }

    pub(crate) fn cycle(&self) -> Cycle {
        either!(self, world => world.cycle())
    }

    pub(crate) fn digest(&self) -> u64 {
        either!(self, world => world.digest())
    }

    pub(crate) fn limits(&self) -> &Limits {
        either!(self, world => world.limits())
    }

    /// Returns the skin, in world units.
    pub(crate) fn skin(&self) -> f64 {
        either!(self, world => world.skin().to_f64())
    }

    /// Returns the skin that follows from the limits, in world units, whatever skin was asked for.
    pub(crate) fn skin_of_limits(&self) -> f64 {
        match self {
            Self::Double(world) => world.limits().skin(),
            Self::Single(world) => world.limits().skin::<f32>().to_f64(),
        }
    }

    /// Returns where an object is that is there.
    pub(crate) fn center(&self, object: ObjectId) -> DVec2 {
        let center = either!(self, world => world.circle(object).map(|circle| circle.center.to_dvec2()));
        center.expect("who is alive is in the world")
    }

    /// Returns how an object moves that is there, and how many motions wait behind.
    pub(crate) fn base(&self, object: ObjectId) -> (Base, usize) {
        let found = either!(self, world => {
            let base = world.motion(object).map(|motion| Base {
                point: motion.start.to_dvec2(),
                cycle: motion.from.cycle,
                fraction: motion.from.fraction,
                velocity: motion.velocity.to_dvec2(),
            });
            base.zip(world.waypoints(object))
        });
        found.expect("who is alive is in the world")
    }
}

fn filled<S: Scalar>(loaded: &Loaded) -> Result<World<S>, WorldError> {
    let scenario = &loaded.scenario;
    let limits = limits::<S>(&loaded.map, scenario)?;
    let flies = scenario.unit_types.iter().any(|unit_type| unit_type.layer == Layer::Air);
    World::new(limits, settings(scenario), &walls(&loaded.map, flies)).map_err(WorldError::Wall)
}

fn side<S: Scalar>(start: DVec2, end: DVec2, layer: Layer) -> Wall<S> {
    let segment = Segment::new(S::Vector::from_dvec2(start), S::Vector::from_dvec2(end));
    Wall { segment, kind: WallKind::Segment, layers: layers(layer) }
}

fn settings(scenario: &Scenario) -> Settings {
    let profile = &scenario.profile;
    Settings {
        stops: match scenario.stops {
            view::Stops::Both => Stops::Both,
            view::Stops::Approaching => Stops::Approaching,
        },
        method: match profile.solver {
            Solver::Event => Method::Event,
            Solver::Stepped { substeps } => Method::Stepped { substeps },
        },
        certify: profile.certify,
        skin: profile.skin,
    }
}

/// Returns the limits that take in every radius and speed, as they are and as the scalar rounds them.
fn limits<S: Scalar>(map: &TileMap, scenario: &Scenario) -> Result<Limits, WorldError> {
    let mut radius_max = RADIUS_MIN;
    let mut speed_max = SPEED_MIN;
    for unit_type in &scenario.unit_types {
        radius_max = widest::<S>(radius_max, unit_type.shape.rounding());
        speed_max = widest::<S>(speed_max, speed(unit_type));
    }
    let coordinate_max = f64::from(map.width().max(map.height()));
    Limits::new(coordinate_max, radius_max, speed_max)
        .map_err(|(name, problem)| WorldError::Limits { name, problem })
}

fn widest<S: Scalar>(so_far: f64, value: f64) -> f64 {
    so_far.greater(value).greater(S::from_f64(value).to_f64())
}

/// Returns the largest speed in any mode.
fn speed(unit_type: &UnitType) -> f64 {
    unit_type.alternate.as_ref().map_or(unit_type.speed, |other| unit_type.speed.greater(other.speed))
}

/// Returns the walls of a map; where somebody flies, with the edge of the map in the air.
fn walls<S: Scalar>(map: &TileMap, flies: bool) -> Vec<Wall<S>> {
    let (width, height) = (f64::from(map.width()), f64::from(map.height()));
    let wall = |segment: Segment| {
        let (start, end) = (segment.start, segment.end);
        let is_edge = (start.x == end.x && (start.x == 0.0 || start.x == width))
            || (start.y == end.y && (start.y == 0.0 || start.y == height));
        let kind = if is_edge { WallKind::Edge } else { WallKind::Segment };
        let segment = Segment::new(S::Vector::from_dvec2(start), S::Vector::from_dvec2(end));
        Wall { segment, kind, layers: Layers::GROUND }
    };
    let mut walls: Vec<Wall<S>> = map.segments().into_iter().map(wall).collect();
    if flies {
        let corners = [(0.0, 0.0), (width, 0.0), (width, height), (0.0, height)].map(DVec2::from);
        for (place, &start) in corners.iter().enumerate() {
            let segment = side(start, corners[(place + 1) % corners.len()], Layer::Air).segment;
            walls.push(Wall { segment, kind: WallKind::Edge, layers: Layers::AIR });
        }
    }
    walls
}
