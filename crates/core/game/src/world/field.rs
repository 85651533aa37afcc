//! The kinematic world of a match, in the numbers that its profile asks for.

use glam::DVec2;
use maniple_geometry::limits::SPEED_MIN;
use maniple_geometry::{Circle, Cycle, Limits, Moment, ObjectId, Planar, Scalar, Segment};
use maniple_kinematics::{
    Event, Layers, Leg, Method, OrderError, Part, Placement, Settings, Stops, Wall, WallKind, World,
};
use maniple_tilemap::TileMap;
use maniple_view::{self as view, Base, Solver};

use super::WorldError;
use crate::load::Loaded;
use crate::scenario::Scenario;

/// The layers of every unit.
pub(super) const LAYERS: Layers = Layers::GROUND;

/// A kinematic world in one of the scalars. Whatever comes out is in doubles, and nothing is lost on the way.
pub(super) enum Field {
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
    /// Returns the world with all walls and units of a match.
    pub(super) fn new(loaded: &Loaded) -> Result<Self, WorldError> {
        Ok(match loaded.scenario.profile.scalar {
            view::Scalar::F64 => Self::Double(filled(loaded)?),
            view::Scalar::F32 => Self::Single(filled(loaded)?),
        })
    }

    /// See [`World::go`].
    pub(super) fn go(
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
    pub(super) fn halt(&mut self, object: ObjectId, start: Option<Moment>) -> Result<(), OrderError> {
        either!(self, world => world.halt(object, start))
    }

    /// Takes an object that is there out of the world.
    pub(super) fn remove(&mut self, object: ObjectId) {
        either!(self, world => world.remove(object)).expect("who is alive is in the world");
    }

    /// See [`World::step_by_parts`].
    pub(super) fn step_by_parts(&mut self, done: impl FnMut(Part)) -> &[Event] {
        either!(self, world => world.step_by_parts(done))
    }

    pub(super) fn cycle(&self) -> Cycle {
        either!(self, world => world.cycle())
    }

    pub(super) fn digest(&self) -> u64 {
        either!(self, world => world.digest())
    }

    pub(super) fn limits(&self) -> &Limits {
        either!(self, world => world.limits())
    }

    /// Returns the skin, in world units.
    pub(super) fn skin(&self) -> f64 {
        either!(self, world => world.skin().to_f64())
    }

    /// Returns the skin that follows from the limits, in world units, whatever skin was asked for.
    pub(super) fn skin_of_limits(&self) -> f64 {
        match self {
            Self::Double(world) => world.limits().skin(),
            Self::Single(world) => world.limits().skin::<f32>().to_f64(),
        }
    }

    /// Returns where an object is that is there.
    pub(super) fn center(&self, object: ObjectId) -> DVec2 {
        let center = either!(self, world => world.circle(object).map(|circle| circle.center.to_dvec2()));
        center.expect("who is alive is in the world")
    }

    /// Returns how an object moves that is there, and how many motions wait behind.
    pub(super) fn base(&self, object: ObjectId) -> (Base, usize) {
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
    let mut world = World::new(limits, settings(scenario), &walls(&loaded.map)).map_err(WorldError::Wall)?;
    for (object, unit) in (0..).map(ObjectId).zip(&loaded.setup.units) {
        let radius = S::from_f64(scenario.unit_types[usize::from(unit.unit_type.0)].radius);
        let circle = Circle::new(S::Vector::from_dvec2(unit.position), radius);
        (world.insert(object, circle, LAYERS)).map_err(|problem| WorldError::Unit { object, problem })?;
    }
    Ok(world)
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
    let mut radius_max = 0.0;
    let mut speed_max = SPEED_MIN;
    for unit_type in &scenario.unit_types {
        radius_max = widest::<S>(radius_max, unit_type.radius);
        speed_max = widest::<S>(speed_max, unit_type.speed);
    }
    let coordinate_max = f64::from(map.width().max(map.height()));
    Limits::new(coordinate_max, radius_max, speed_max)
        .map_err(|(name, problem)| WorldError::Limits { name, problem })
}

fn widest<S: Scalar>(so_far: f64, value: f64) -> f64 {
    so_far.greater(value).greater(S::from_f64(value).to_f64())
}

fn walls<S: Scalar>(map: &TileMap) -> Vec<Wall<S>> {
    let (width, height) = (f64::from(map.width()), f64::from(map.height()));
    let wall = |segment: Segment| {
        let (start, end) = (segment.start, segment.end);
        let is_edge = (start.x == end.x && (start.x == 0.0 || start.x == width))
            || (start.y == end.y && (start.y == 0.0 || start.y == height));
        let kind = if is_edge { WallKind::Edge } else { WallKind::Segment };
        let segment = Segment::new(S::Vector::from_dvec2(start), S::Vector::from_dvec2(end));
        Wall { segment, kind, layers: LAYERS }
    };
    map.segments().into_iter().map(wall).collect()
}
