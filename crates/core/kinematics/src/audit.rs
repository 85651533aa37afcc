//! The check of a whole state, apart from the machinery of a cycle: exact, over all objects.

use maniple_geometry::predicate::{circle_overlaps_segment, circles_overlap};
use maniple_geometry::{Cycle, Planar, Scalar};

use crate::error::Overlap;
use crate::objects::Objects;
use crate::wall::WallId;
use crate::walls::Walls;

/// Returns all overlaps at the start of a cycle.
///
/// A sweep along x: the circles by their left ends, each compared with those before it that reach that far. Radii of all
/// sizes are looked back for as far as the largest reaches, so one giant makes it slow, never wrong.
pub(crate) fn overlaps<S: Scalar>(objects: &Objects<S>, walls: &Walls<S>, cycle: Cycle) -> Vec<Overlap> {
    let mut circles: Vec<(f64, u32)> = Vec::with_capacity(objects.len());
    let mut widest = 0.0;
    let extent = |slot: u32| {
        let state = &objects.states[slot as usize];
        (state.position(cycle), state.radius)
    };
    for slot in objects.slots() {
        let (center, radius) = extent(slot);
        circles.push(((center.x() - radius).to_f64(), slot));
        if radius.to_f64() > widest {
            widest = radius.to_f64();
        }
    }
    circles.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    let mut overlaps = Vec::new();
    for (place, &(left, slot)) in circles.iter().enumerate() {
        let (p, r) = extent(slot);
        let id = objects.intents[slot as usize].id;
        // Rounded outwards, since the left ends are rounded.
        let reach = 2.0 * widest + (left.abs() + widest) * 1e-6;
        for &(_, other) in circles[..place].iter().rev().take_while(|circle| left - circle.0 <= reach) {
            let (q, s) = extent(other);
            if objects.layers[slot as usize].share(objects.layers[other as usize])
                && circles_overlap::<S>(p, r, q, s)
            {
                let other = objects.intents[other as usize].id;
                overlaps.push(Overlap::Objects(id.min(other), id.max(other)));
            }
        }
        let margin = objects.margin.to_f64();
        walls.near_numbered(p.to_dvec2(), r.to_f64() + margin, |number, wall| {
            if objects.layers[slot as usize].share(wall.layers)
                && circle_overlaps_segment(p, r, &wall.segment)
            {
                overlaps.push(Overlap::Wall(id, WallId(number)));
            }
        });
    }
    overlaps.sort_unstable();
    overlaps.dedup();
    overlaps
}
