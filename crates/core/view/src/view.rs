//! What one player knows.

use std::collections::BTreeMap;
use std::sync::Arc;

use glam::DVec2;
use maniple_geometry::Cycle;
use thiserror::Error;

use crate::base::Base;
use crate::delta::{Appeared, Delta};
use crate::fnv::Fnv;
use crate::ground::Ground;
use crate::identity::{Digest, Handle, Seat, UnitTypeId};
use crate::rules::{Rules, Terrain};
use crate::status::{Own, Status};
use crate::tile_set::TileSet;

/// An object as a view holds it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Seen {
    /// Its type.
    pub unit_type: UnitTypeId,
    /// Whose it is; `None`: nobody's.
    pub owner: Option<Seat>,
    /// From what its position is evaluated.
    pub base: Base,
    /// What is to be seen of it.
    pub status: Status,
    /// What only its owner knows; `None` for objects of others.
    pub own: Option<Own>,
}

/// A delta that does not fit the view it is applied to.
#[derive(Clone, Copy, Debug, Error, PartialEq, Eq)]
pub enum MismatchError {
    /// The delta changes an object that the view does not hold.
    #[error("the delta of cycle {cycle} changes object {object}, which the view does not hold")]
    UnknownObject {
        /// The cycle of the delta.
        cycle: Cycle,
        /// The object.
        object: Handle,
    },
    /// The delta lets an object appear that the view holds already.
    #[error("the delta of cycle {cycle} lets object {object} appear, which the view holds already")]
    AppearedTwice {
        /// The cycle of the delta.
        cycle: Cycle,
        /// The object.
        object: Handle,
    },
    /// The delta changes the visible tiles beyond the last one, or in a match without fog.
    #[error("the delta of cycle {cycle} changes visible tiles beyond the map, or there is no fog")]
    Sight {
        /// The cycle of the delta.
        cycle: Cycle,
    },
    /// The delta reveals tiles that are none, are known already or lie outside of the map.
    #[error(
        "the delta of cycle {cycle} reveals tiles from ({x}, {y}) on that are none, known or outside of the map"
    )]
    Revealed {
        /// The cycle of the delta.
        cycle: Cycle,
        /// Column of the first.
        x: u32,
        /// Row.
        y: u32,
    },
    /// The view after the delta has another hash than the server's.
    #[error("after the delta of cycle {cycle} the view hashes to {found}, the server's to {expected}")]
    Check {
        /// The cycle of the delta.
        cycle: Cycle,
        /// The hash that the delta carries.
        expected: Digest,
        /// The hash of the view.
        found: Digest,
    },
}

/// All that one player knows of a match, at the start of a cycle.
///
/// Server and client hold one each and change them with the same deltas by the same code.
#[doc(alias = "observation")]
#[derive(Clone, Debug, Default, PartialEq)]
pub struct View {
    cycle: Cycle,
    objects: BTreeMap<Handle, Seen>,
    stock: u32,
    ground: Ground,
    /// Wrapping sum of the hashes of the objects.
    sum: u64,
}

impl View {
    /// Returns a view that holds nothing but the terrain that is known from the start. [`View::default`] has no terrain, either, and no fog.
    #[must_use]
    pub fn new(rules: &Rules, terrain: Arc<Terrain>) -> Self {
        Self { ground: Ground::new(rules, terrain), ..Self::default() }
    }

    #[cfg(test)]
    pub(crate) fn with_ground(ground: Ground) -> Self {
        Self { ground, ..Self::default() }
    }

    /// Changes the view by a delta and compares the hash.
    ///
    /// # Errors
    /// A delta that does not fit: see [`MismatchError`]. The view is then of no use any more.
    pub fn apply(&mut self, delta: &Delta) -> Result<(), MismatchError> {
        self.apply_unchecked(delta)?;
        let found = self.check();
        if found == delta.check {
            Ok(())
        } else {
            Err(MismatchError::Check { cycle: delta.cycle, expected: delta.check, found })
        }
    }

    /// Changes the view by a delta whose hash is not known yet.
    pub(crate) fn apply_unchecked(&mut self, delta: &Delta) -> Result<(), MismatchError> {
        let cycle = delta.cycle;
        self.cycle = cycle;
        self.stock = delta.stock.unwrap_or(self.stock);
        self.ground.apply(delta)?;
        for &object in delta.vanished.iter().chain(&delta.died) {
            let seen = self.objects.remove(&object).ok_or(MismatchError::UnknownObject { cycle, object })?;
            self.sum = self.sum.wrapping_sub(hash(object, &seen));
        }
        for moved in &delta.moved {
            self.change(cycle, moved.object, |seen| seen.base = moved.base)?;
        }
        for stopped in &delta.stopped {
            self.change(cycle, stopped.object, |seen| seen.base = stopped.base())?;
        }
        for changed in &delta.changed {
            self.change(cycle, changed.object, |seen| {
                seen.status = changed.status.unwrap_or(seen.status);
                seen.own = changed.own.or(seen.own);
            })?;
        }
        for new in &delta.appeared {
            let Appeared { unit_type, owner, base, status, own, .. } = *new;
            let seen = Seen { unit_type, owner, base, status, own };
            if self.objects.insert(new.object, seen).is_some() {
                return Err(MismatchError::AppearedTwice { cycle, object: new.object });
            }
            self.sum = self.sum.wrapping_add(hash(new.object, &seen));
        }
        Ok(())
    }

    /// Returns the cycle at whose start the view is like this.
    #[must_use]
    pub fn cycle(&self) -> Cycle {
        self.cycle
    }

    /// Returns the objects in sight, by handle.
    pub fn objects(&self) -> impl Iterator<Item = (Handle, &Seen)> {
        self.objects.iter().map(|(&handle, seen)| (handle, seen))
    }

    /// Returns the objects of a seat, by handle.
    pub fn objects_of(&self, seat: Seat) -> impl Iterator<Item = (Handle, &Seen)> {
        self.objects().filter(move |(_, seen)| seen.owner == Some(seat))
    }

    /// Returns the resources of the seat.
    #[must_use]
    pub fn stock(&self) -> u32 {
        self.stock
    }

    /// Returns whether a tile is visible: what is there is seen, but for objects beyond the exact sight of who sees it. Outside of the map no
    /// tile is; without fog all others are.
    #[must_use]
    pub fn is_visible(&self, x: u32, y: u32) -> bool {
        self.ground.is_visible(x, y)
    }

    /// Returns the terrain as far as it is known.
    #[must_use]
    pub fn terrain(&self) -> &Terrain {
        self.ground.terrain()
    }

    /// Returns the delta that turns the view at the start, [`View::new`], into this one.
    #[must_use]
    pub fn keyframe(&self) -> Delta {
        let appeared = |(object, seen): (Handle, &Seen)| {
            let Seen { unit_type, owner, base, status, own } = *seen;
            Appeared { object, unit_type, owner, base, status, own }
        };
        let mut delta = Delta {
            cycle: self.cycle,
            appeared: self.objects().map(appeared).collect(),
            stock: Some(self.stock).filter(|&stock| stock > 0),
            check: self.check(),
            ..Delta::default()
        };
        self.ground.write_keyframe(&mut delta);
        delta
    }

    /// Returns what has to be toggled so that these tiles are visible: see [`Delta::sight`].
    pub(crate) fn changes_of_sight(&self, visible: Option<&TileSet>) -> Vec<(u32, u32)> {
        self.ground.changes(visible)
    }

    /// Returns whether these tiles are visible, and no others.
    pub(crate) fn has_sight(&self, visible: Option<&TileSet>) -> bool {
        self.changes_of_sight(visible).is_empty()
    }

    /// Returns whether these tiles are known, and no others; `None`: all are, from the start.
    pub(crate) fn has_knowledge(&self, known: Option<&TileSet>) -> bool {
        let Some(known) = known else { return true };
        let terrain = self.terrain();
        let is_same = |x: u32, y: u32| terrain.tile(x, y).is_some() == known.contains(x, y);
        (0..terrain.height).all(|y| (0..terrain.width).all(|x| is_same(x, y)))
    }

    /// Returns an object; `None` where it is not in sight.
    #[must_use]
    pub fn object(&self, object: Handle) -> Option<&Seen> {
        self.objects.get(&object)
    }

    /// Returns where an object is now; `None` where it is not in sight.
    #[must_use]
    pub fn position(&self, object: Handle) -> Option<DVec2> {
        self.objects.get(&object).map(|seen| seen.base.position(self.cycle))
    }

    /// Returns the hash of the view: FNV-1a over the cycle, the stock and the wrapping sum of one hash an object,
    /// a visible tile under fog, and a known tile and a wall where terrain is explored.
    ///
    /// FNV-1a (Fowler, Noll and Vo, 1991) because any language can compute it in five lines; it guards against
    /// mistakes, not against malice.
    #[must_use]
    pub fn check(&self) -> Digest {
        let mut fnv = Fnv::new();
        fnv.write(&self.cycle.0.to_le_bytes());
        fnv.write(&self.stock.to_le_bytes());
        fnv.write(&self.sum.wrapping_add(self.ground.sum()).to_le_bytes());
        Digest(fnv.hash())
    }

    fn change(
        &mut self,
        cycle: Cycle,
        object: Handle,
        change: impl FnOnce(&mut Seen),
    ) -> Result<(), MismatchError> {
        let seen = self.objects.get_mut(&object).ok_or(MismatchError::UnknownObject { cycle, object })?;
        self.sum = self.sum.wrapping_sub(hash(object, seen));
        change(seen);
        self.sum = self.sum.wrapping_add(hash(object, seen));
        Ok(())
    }
}

/// FNV-1a over all that is known of an object, little-endian, in the order of the fields.
///
/// Nobody as owner counts as 2^16 - 1. Hit points, amount and the cycle in which something is due count as 2^32 - 1 where they are
/// absent, a type in training as 2^16 - 1. Modes, actions and tasks count as their place in their lists. What only the owner knows is
/// left out where it is not known.
fn hash(object: Handle, seen: &Seen) -> u64 {
    let mut fnv = Fnv::new();
    fnv.write(&object.0.to_le_bytes());
    fnv.write(&seen.unit_type.0.to_le_bytes());
    fnv.write(&seen.owner.map_or(u16::MAX, |seat| seat.0).to_le_bytes());
    fnv.write(&seen.base.point.x.to_le_bytes());
    fnv.write(&seen.base.point.y.to_le_bytes());
    fnv.write(&seen.base.cycle.0.to_le_bytes());
    fnv.write(&seen.base.fraction.to_le_bytes());
    fnv.write(&seen.base.velocity.x.to_le_bytes());
    fnv.write(&seen.base.velocity.y.to_le_bytes());
    fnv.write(&seen.status.hit_points.unwrap_or(u32::MAX).to_le_bytes());
    fnv.write(&seen.status.amount.unwrap_or(u32::MAX).to_le_bytes());
    fnv.write(&[seen.status.mode as u8, seen.status.action as u8]);
    if let Some(own) = &seen.own {
        fnv.write(&own.queued.to_le_bytes());
        fnv.write(&[own.task as u8]);
        fnv.write(&own.load.to_le_bytes());
        fnv.write(&own.ready.0.to_le_bytes());
        fnv.write(&own.training.map_or(u16::MAX, |unit_type| unit_type.0).to_le_bytes());
        fnv.write(&own.waiting.to_le_bytes());
        fnv.write(&own.due.map_or(u32::MAX, |cycle| cycle.0).to_le_bytes());
    }
    fnv.hash()
}
