//! Unit types: from what is written to what is checked.

use std::ops::Range;

use maniple_geometry::limits::{COORDINATE_MAX, RADIUS_MAX, SPEED_MAX};
use maniple_geometry::{Limits, NumberError};
use maniple_view::{Alternate, Falloff, Harvest, Layer, Making, Shape, Splash, UnitType, UnitTypeId, Weapon};
use toml::Spanned;

use super::check::{Found, check_name, number, number_or, whole};
use super::nearest::nearest;
use super::{
    COUNT_MAX, MAKE_SECONDS_DEFAULT, NAME_BYTES_MAX, Problem, RANGE_MIN, SECONDS_MAX, SIDE_MAX, SIDE_MIN,
    SIGHT_DEFAULT, SIGHT_MIN, file,
};

/// What a scenario models of unit types; the rest is left out of them.
#[derive(Clone, Copy, Debug)]
pub(super) struct Modules {
    pub(super) combat: bool,
    pub(super) harvest: bool,
    pub(super) production: bool,
    pub(super) modes: bool,
}

/// What turns the written into the checked.
pub(super) struct Reader<'a> {
    /// Cycles a second.
    pub(super) rate: f64,
    pub(super) modules: Modules,
    /// The names of all unit types; a [`UnitTypeId`] is the place in this list.
    pub(super) names: &'a [String],
}

impl Reader<'_> {
    /// Returns a unit type, with only what is modelled. All of it is checked.
    pub(super) fn unit_type(&self, name: &str, unit: &Spanned<file::Unit>) -> Found<UnitType> {
        let span = unit.span();
        let unit = unit.get_ref();
        check_name(name, "the name of a unit type", NAME_BYTES_MAX, span.clone())?;
        let shape = shape(unit, &span)?;
        let speed = self.speed(&unit.speed)?;
        if speed > 0.0 && matches!(shape, Shape::Rectangle { .. }) {
            return Err((unit.speed.span(), Problem::Conflict { one: "a speed", other: "width and height" }));
        }
        let Modules { combat, harvest, production, modes } = self.modules;
        let weapon = unit.weapon.as_ref().map(|weapon| self.weapon(weapon)).transpose()?;
        let alternate = unit.alternate.as_ref().map(|alternate| self.alternate(alternate)).transpose()?;
        let hit_points = whole_or_none(unit.hit_points.as_ref(), "hit_points", 1)?;
        let armor = whole_or_none(unit.armor.as_ref(), "armor", 0)?.unwrap_or(0);
        let carrier = unit.harvest.as_ref().map(|carrier| self.carrier(carrier)).transpose()?;
        let patch =
            unit.patch.as_ref().map(|patch| whole(&patch.places, "places", 1, COUNT_MAX)).transpose()?;
        if let (Some(_), Some(hit_points)) = (patch, &unit.hit_points) {
            return Err((hit_points.span(), Problem::Conflict { one: "hit_points", other: "patch" }));
        }
        if patch.is_some() && speed > 0.0 {
            return Err((unit.speed.span(), Problem::Conflict { one: "a speed", other: "patch" }));
        }
        let (making, trains, builds) = (self.making(unit)?, self.ids(&unit.trains)?, self.ids(&unit.builds)?);
        let sight = number_or(unit.sight.as_ref(), SIGHT_DEFAULT, "sight", SIGHT_MIN, COORDINATE_MAX)?;
        Ok(UnitType {
            name: name.to_owned(),
            shape,
            layer: unit.layer,
            speed,
            sight,
            hit_points: hit_points.filter(|_| combat),
            armor: if combat { armor } else { 0 },
            weapon: weapon.filter(|_| combat),
            alternate: alternate
                .filter(|_| modes)
                .map(|alternate| Alternate { weapon: alternate.weapon.filter(|_| combat), ..alternate }),
            harvest: carrier.filter(|_| harvest),
            patch_places: patch.filter(|_| harvest),
            takes_loads: unit.takes_loads && harvest,
            making: if production { making } else { Making::default() },
            trains: if production { trains } else { Vec::new() },
            builds: if production { builds } else { Vec::new() },
        })
    }

    /// Returns the speed in world units a cycle.
    fn speed(&self, speed: &Spanned<f64>) -> Found<f64> {
        let limits = limits();
        let bad = |field| move |problem: NumberError| (speed.span(), Problem::BadNumber { field, problem });
        limits.check_speed(*speed.get_ref()).map_err(bad("speed"))?;
        let speed_a_cycle = speed.get_ref() / self.rate;
        limits.check_speed(speed_a_cycle).map_err(bad("speed divided by rate"))?;
        Ok(speed_a_cycle)
    }

    /// Returns a time in cycles, at least one.
    fn cycles(&self, seconds: &Spanned<f64>, field: &'static str) -> Found<u32> {
        number(seconds, field, 0.0, SECONDS_MAX).map(|seconds| cycles(seconds, self.rate))
    }

    fn weapon(&self, weapon: &file::Weapon) -> Found<Weapon> {
        let range = number(&weapon.range, "range", RANGE_MIN, COORDINATE_MAX)?;
        let damage_min = whole(&weapon.damage_min, "damage_min", 0, COUNT_MAX)?;
        let targets = match &weapon.targets {
            None => vec![Layer::Ground, Layer::Air],
            Some(targets) if targets.get_ref().is_empty() => {
                let why = "name \"ground\" or \"air\", or leave targets out for both";
                return Err((targets.span(), Problem::Missing { wanted: "a layer", why }));
            }
            Some(targets) => {
                let mut layers = targets.get_ref().clone();
                layers.sort_unstable();
                layers.dedup();
                layers
            }
        };
        Ok(Weapon {
            range,
            range_min: number_or(weapon.range_min.as_ref(), 0.0, "range_min", 0.0, range)?,
            cooldown: self.cycles(&weapon.cooldown_seconds, "cooldown_seconds")?,
            damage_min,
            damage_max: whole(&weapon.damage_max, "damage_max", damage_min.max(1), COUNT_MAX)?,
            splash: splash(weapon)?,
            targets,
        })
    }

    fn alternate(&self, alternate: &file::Alternate) -> Found<Alternate> {
        let name = alternate.name.get_ref();
        check_name(name, "the name of a mode", NAME_BYTES_MAX, alternate.name.span())?;
        Ok(Alternate {
            name: name.clone(),
            switch_cycles: self.cycles(&alternate.switch_seconds, "switch_seconds")?,
            speed: self.speed(&alternate.speed)?,
            armor: whole_or_none(alternate.armor.as_ref(), "armor", 0)?.unwrap_or(0),
            weapon: alternate.weapon.as_ref().map(|weapon| self.weapon(weapon)).transpose()?,
        })
    }

    fn carrier(&self, carrier: &file::Carrier) -> Found<Harvest> {
        Ok(Harvest {
            load_max: whole(&carrier.load_max, "load_max", 1, COUNT_MAX)?,
            cycles_each: self.cycles(&carrier.seconds_each, "seconds_each")?,
        })
    }

    fn making(&self, unit: &file::Unit) -> Found<Making> {
        let cycles = match &unit.make_seconds {
            Some(seconds) => self.cycles(seconds, "make_seconds")?,
            None => cycles(MAKE_SECONDS_DEFAULT, self.rate),
        };
        let cost = whole_or_none(unit.cost.as_ref(), "cost", 0)?.unwrap_or(0);
        Ok(Making { cost, cycles, requires: self.ids(&unit.requires)? })
    }

    fn ids(&self, names: &[Spanned<String>]) -> Found<Vec<UnitTypeId>> {
        names.iter().map(|name| id(name, self.names)).collect()
    }
}

/// Returns the number of the unit type with a name.
pub(super) fn id(name: &Spanned<String>, names: &[String]) -> Found<UnitTypeId> {
    let wanted = name.get_ref();
    let Some(place) = names.iter().position(|known| known == wanted) else {
        let nearest = nearest(wanted, names.iter().map(String::as_str));
        let problem = Problem::UnknownUnit { name: wanted.clone(), nearest: nearest.map(str::to_owned) };
        return Err((name.span(), problem));
    };
    Ok(UnitTypeId(u16::try_from(place).expect("UNIT_TYPES_MAX fits into 16 bits")))
}

/// Returns a time in whole cycles, at least one.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "at most SECONDS_MAX * RATE_MAX")]
pub(super) fn cycles(seconds: f64, rate: f64) -> u32 {
    let cycles = (seconds * rate).round();
    if cycles < 1.0 { 1 } else { cycles as u32 }
}

fn shape(unit: &file::Unit, place: &Range<usize>) -> Found<Shape> {
    let conflict = |span, one, other| Err((span, Problem::Conflict { one, other }));
    match (&unit.radius, &unit.width, &unit.height) {
        (Some(radius), None, None) => {
            let problem = |problem| (radius.span(), Problem::BadNumber { field: "radius", problem });
            limits().check_radius(*radius.get_ref()).map_err(problem)?;
            Ok(Shape::Circle { radius: *radius.get_ref() })
        }
        (None, Some(width), Some(height)) => Ok(Shape::Rectangle {
            width: number(width, "width", SIDE_MIN, SIDE_MAX)?,
            height: number(height, "height", SIDE_MIN, SIDE_MAX)?,
        }),
        (Some(_), Some(width), _) => conflict(width.span(), "width", "radius"),
        (Some(_), None, Some(height)) => conflict(height.span(), "height", "radius"),
        (None, _, _) => {
            let why = "a circle has a radius, a rectangle width and height, in world units";
            Err((place.clone(), Problem::Missing { wanted: "radius, or width and height,", why }))
        }
    }
}

fn splash(weapon: &file::Weapon) -> Found<Option<Splash>> {
    match (&weapon.splash_radius, &weapon.splash_falloff) {
        (None, None) => Ok(None),
        (None, Some(falloff)) => {
            Err((falloff.span(), Problem::Pointless { field: "splash_falloff", choice: "splash_radius" }))
        }
        (Some(radius), falloff) => Ok(Some(Splash {
            radius: number(radius, "splash_radius", RANGE_MIN, COORDINATE_MAX)?,
            falloff: falloff.as_ref().map_or(Falloff::None, |falloff| *falloff.get_ref()),
        })),
    }
}

fn whole_or_none(value: Option<&Spanned<u32>>, field: &'static str, min: u32) -> Found<Option<u32>> {
    value.map(|value| whole(value, field, min, COUNT_MAX)).transpose()
}

/// Returns the limits that every unit type is within.
fn limits() -> Limits {
    Limits::new(COORDINATE_MAX, RADIUS_MAX, SPEED_MAX)
        .expect("the largest limits of all are limits of a world")
}
