//! Objects for tests.

use glam::DVec2;
use maniple_geometry::{Cycle, Moment};
use maniple_view::{Base, Handle, Layer, Making, Own, Seen, Shape, Status, UnitType, UnitTypeId, Weapon};

use crate::seeing::Item;

/// Returns a type with a weapon of this range and 100 hit points, that goes a quarter of a world unit a cycle.
pub(crate) fn armed(range: f64) -> UnitType {
    let weapon = Weapon {
        range,
        range_min: 0.0,
        cooldown: 12,
        damage_min: 15,
        damage_max: 25,
        splash: None,
        targets: vec![Layer::Ground],
    };
    UnitType {
        name: "armed".to_owned(),
        shape: Shape::Circle { radius: 0.5 },
        layer: Layer::Ground,
        speed: 0.25,
        sight: 8.0,
        hit_points: Some(100),
        armor: 0,
        weapon: Some(weapon),
        alternate: None,
        harvest: None,
        patch_places: None,
        takes_loads: false,
        making: Making::default(),
        trains: vec![],
        builds: vec![],
    }
}

/// Returns what is seen of an object that rests at (x, 5) with so many hit points.
pub(crate) fn resting(x: f64, hit_points: u32) -> Seen {
    let moment = Moment { cycle: Cycle(0), fraction: 0.0 };
    Seen {
        unit_type: UnitTypeId(0),
        owner: None,
        base: Base::at_rest(DVec2::new(x, 5.0), moment),
        status: Status { hit_points: Some(hit_points), ..Status::default() },
        own: Some(Own::default()),
    }
}

/// Returns the item of an object that rests.
pub(crate) fn item<'a>(object: u32, seen: &'a Seen, kind: &'a UnitType) -> Item<'a> {
    Item { object: Handle(object), seen, kind, center: seen.base.point }
}
