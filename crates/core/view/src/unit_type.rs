//! The constants of a unit type.

use glam::DVec2;
use serde::{Deserialize, Serialize};

use crate::identity::UnitTypeId;

/// The constants of a unit type. What a scenario does not model is absent.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct UnitType {
    /// Its name.
    pub name: String,
    /// What it covers.
    pub shape: Shape,
    /// Where it goes.
    pub layer: Layer,
    /// Largest speed, in world units a cycle; 0 is a unit that cannot move.
    pub speed: f64,
    /// How far it sees, hull to hull, in world units.
    pub sight: f64,
    /// What it can take; `None`: it cannot be hurt.
    pub hit_points: Option<u32>,
    /// What is taken off the damage of each hit, which is at least 1.
    pub armor: u32,
    /// What it fights with; `None`: it does not.
    pub weapon: Option<Weapon>,
    /// The other mode that it can switch to; `None`: it has one mode.
    pub alternate: Option<Alternate>,
    /// How it gathers; `None`: it does not.
    pub harvest: Option<Harvest>,
    /// How many may gather here at once; `None`: it is no resource patch.
    pub patch_places: Option<u32>,
    /// Whether loads can be brought here.
    pub takes_loads: bool,
    /// What it takes to make one.
    pub making: Making,
    /// What it can train.
    pub trains: Vec<UnitTypeId>,
    /// What it can build.
    pub builds: Vec<UnitTypeId>,
}

impl UnitType {
    /// Returns whether it is a building: immobile, and can be destroyed.
    #[must_use]
    pub fn is_building(&self) -> bool {
        self.speed == 0.0 && self.hit_points.is_some()
    }
}

/// What a unit type covers; its centre is where the object is.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Shape {
    /// A disc.
    Circle {
        /// World units.
        radius: f64,
    },
    /// A rectangle with its sides along the axes; always immobile.
    Rectangle {
        /// World units.
        width: f64,
        /// World units.
        height: f64,
    },
}

impl Shape {
    /// Returns the radius of the smallest circle around it, in world units.
    #[must_use]
    pub fn radius(&self) -> f64 {
        match *self {
            Self::Circle { radius } => radius,
            Self::Rectangle { .. } => self.half().length(),
        }
    }

    /// Returns half of its width and height, without what is round: nothing for a circle.
    #[must_use]
    pub fn half(&self) -> DVec2 {
        match *self {
            Self::Circle { .. } => DVec2::ZERO,
            Self::Rectangle { width, height } => DVec2::new(width, height) * 0.5,
        }
    }

    /// Returns the radius of what is round: nothing for a rectangle.
    #[must_use]
    pub fn rounding(&self) -> f64 {
        match *self {
            Self::Circle { radius } => radius,
            Self::Rectangle { .. } => 0.0,
        }
    }
}

/// Returns how far it is from the hull of one shape to that of another, in world units, where `offset` lies between
/// their centres; negative where they overlap.
///
/// With half sides `h` (0 for circles) and radii `r` (0 for rectangles) it is `|max(|offset| - h1 - h2, 0)| - r1 - r2`: for
/// two circles the distance of the centres less both radii, for a circle and a rectangle that from the nearest point.
#[must_use]
pub fn hull_distance(offset: DVec2, one: &Shape, other: &Shape) -> f64 {
    let beyond = offset.abs() - one.half() - other.half();
    let outside = DVec2::new(positive(beyond.x), positive(beyond.y));
    outside.length() - one.rounding() - other.rounding()
}

fn positive(value: f64) -> f64 {
    if value > 0.0 { value } else { 0.0 }
}

/// Where a unit goes. Only what shares a layer collides.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Layer {
    /// Between walls.
    #[default]
    Ground,
    /// Over walls and whatever is on the ground; only the edge of the map ends it.
    Air,
}

/// What a unit fights with.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Weapon {
    /// How far it reaches, hull to hull, in world units; the end belongs to it.
    pub range: f64,
    /// How near it cannot hit, hull to hull, in world units; what is nearer than this is out of range.
    pub range_min: f64,
    /// Cycles from one shot to the next; at least one.
    pub cooldown: u32,
    /// The least damage of a shot.
    pub damage_min: u32,
    /// The largest damage of a shot; each number between is as likely.
    pub damage_max: u32,
    /// What is hit around the target; `None`: the target alone.
    pub splash: Option<Splash>,
    /// The layers in which it hits.
    pub targets: Vec<Layer>,
}

/// What a shot hits around its point.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Splash {
    /// How far from the point to the hull, in world units; the end belongs to it.
    pub radius: f64,
    /// How the damage falls off.
    pub falloff: Falloff,
}

/// How damage falls off with the distance from the point that is hit to a hull.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Falloff {
    /// Not at all.
    #[default]
    None,
    /// In proportion: all of it at the point, nothing at the splash radius; rounded down.
    Linear,
}

/// The other mode of a unit type.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Alternate {
    /// Its name.
    pub name: String,
    /// Cycles that a switch takes, in either direction; meanwhile the unit stands and does nothing.
    pub switch_cycles: u32,
    /// Largest speed, in world units a cycle.
    pub speed: f64,
    /// Instead of that of the first mode.
    pub armor: u32,
    /// Instead of that of the first mode.
    pub weapon: Option<Weapon>,
}

/// How a unit gathers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Harvest {
    /// The largest load.
    pub load_max: u32,
    /// Cycles from one resource to the next; at least one.
    pub cycles_each: u32,
}

/// What it takes to make a unit.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Making {
    /// Resources.
    pub cost: u32,
    /// Cycles; at least one for what can be made.
    pub cycles: u32,
    /// Finished buildings that the seat must have when it orders one.
    pub requires: Vec<UnitTypeId>,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn distances_are_from_hull_to_hull() {
        let circle = |radius| Shape::Circle { radius };
        let rectangle = Shape::Rectangle { width: 4.0, height: 2.0 };
        let check = |offset: (f64, f64), one: Shape, other: Shape, expected: f64| {
            for offset in [DVec2::from(offset), -DVec2::from(offset)] {
                assert_eq!(hull_distance(offset, &one, &other), expected, "{offset} {one:?} {other:?}");
                assert_eq!(hull_distance(offset, &other, &one), expected, "{offset} {other:?} {one:?}");
            }
        };
        check((3.0, 4.0), circle(1.0), circle(0.5), 3.5);
        check((1.0, 0.0), circle(1.0), circle(0.5), -0.5);
        check((0.0, 3.0), circle(0.5), rectangle, 1.5);
        check((1.5, 3.0), circle(0.5), rectangle, 1.5);
        check((5.0, 5.0), circle(1.0), rectangle, 4.0);
        check((5.0, 0.5), rectangle, rectangle, 1.0);
        check((0.5, 0.5), circle(1.0), rectangle, -1.0);
        assert_eq!(Shape::Rectangle { width: 6.0, height: 8.0 }.radius(), 5.0);
        assert_eq!(circle(0.25).radius(), 0.25);
    }
}
