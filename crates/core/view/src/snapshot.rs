//! What a tracker remembers, as plain data, and a tracker from it.
//!
//! A view is kept as its keyframe. The true motions are those of the world, which is restored first: all that a view
//! holds is in sight.

use std::collections::BTreeMap;

use maniple_geometry::{Cycle, ObjectId};
use serde::{Deserialize, Serialize};
use thiserror::Error;

use crate::base::Base;
use crate::delta::Delta;
use crate::identity::Handle;
use crate::tile_set::TileSet;
use crate::tracker::{Sighting, Tracked, Tracker};
use crate::view::MismatchError;

/// Largest handle that comes next, so that counting on never ends in the middle of a match: nobody sees two thousand
/// million objects appear.
const NEXT_HANDLE_MAX: u32 = 1 << 31;

/// All that decides what a view is told next, besides the world.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TrackerSnapshot {
    /// The handle that the next object gets which was never seen.
    pub next_handle: u32,
    /// The objects in the view.
    pub seen: BTreeMap<Handle, ObjectId>,
    /// The handles of those that went out of sight, where they will be known again.
    pub remembered: BTreeMap<ObjectId, Handle>,
    /// What turns the view at the start into the present one.
    pub view: Delta,
}

/// A snapshot of a tracker that does not belong to the world beside it.
#[derive(Clone, Copy, Debug, Error, PartialEq)]
pub enum RestoreError {
    /// A keyframe that is none.
    #[error("the view: {0}")]
    View(#[from] MismatchError),
    /// A view of another cycle than that of the world.
    #[error("the view is of cycle {found}, the world of cycle {expected}")]
    Cycle {
        /// The cycle of the world.
        expected: Cycle,
        /// The cycle of the view.
        found: Cycle,
    },
    /// Other objects in the view than there are in sight.
    #[error("the view holds {found} objects, in sight are {expected}")]
    Objects {
        /// How many objects are in sight.
        expected: usize,
        /// How many the view holds.
        found: usize,
    },
    /// An object whose entry in the view is not of who is in sight.
    #[error("the view holds object {object} as another than it is, or not at all")]
    Object {
        /// The object.
        object: ObjectId,
    },
    /// A handle that will be given again.
    #[error("handle {handle} is taken, and the next one would be {next}")]
    Handle {
        /// The handle.
        handle: Handle,
        /// The next one.
        next: u32,
    },
    /// More handles than a match gives.
    #[error("{next} handles were given; at most {NEXT_HANDLE_MAX} can be")]
    TooManyHandles {
        /// How many were.
        next: u32,
    },
    /// Handles that are remembered though their objects are in sight, or twice.
    #[error("object {object} is remembered by a handle that is taken, or is in sight")]
    Remembered {
        /// The object.
        object: ObjectId,
    },
    /// Other tiles are visible or known in the view than in the world, or other resources are told of.
    #[error("the view has other visible tiles, known tiles or resources than the world")]
    Sight,
}

/// What a seat notices at the start of the cycle of a snapshot.
#[derive(Clone, Copy, Debug)]
pub struct Present<'a> {
    /// The cycle.
    pub cycle: Cycle,
    /// All that it sees.
    pub sightings: &'a [Sighting],
    /// The tiles that are visible to it; `None`: there is no fog.
    pub visible: Option<&'a TileSet>,
    /// The tiles that it knows; `None`: all, from the start.
    pub known: Option<&'a TileSet>,
    /// Resources of the seat.
    pub stock: u32,
}

impl Tracker {
    /// Returns all that decides what the view is told next, besides the world.
    #[must_use]
    pub fn snapshot(&self) -> TrackerSnapshot {
        TrackerSnapshot {
            next_handle: self.next_handle,
            seen: self.seen.clone(),
            remembered: self.remembered.clone(),
            view: self.view.keyframe(),
        }
    }

    /// Goes on where a snapshot was taken, from a tracker that has seen nothing yet.
    ///
    /// # Errors
    /// See [`RestoreError`].
    pub fn restore(&mut self, snapshot: &TrackerSnapshot, present: &Present<'_>) -> Result<(), RestoreError> {
        let Present { cycle, sightings, visible, known, stock } = *present;
        self.view.apply(&snapshot.view)?;
        if self.view.cycle() != cycle {
            return Err(RestoreError::Cycle { expected: cycle, found: self.view.cycle() });
        }
        let is_same = self.view.stock() == stock && self.view.has_sight(visible);
        if !is_same || !self.view.has_knowledge(known) {
            return Err(RestoreError::Sight);
        }
        let handles: BTreeMap<ObjectId, Handle> =
            snapshot.seen.iter().map(|(&handle, &object)| (object, handle)).collect();
        let (expected, found) = (sightings.len(), self.view.objects().count());
        if found != expected || handles.len() != expected || snapshot.seen.len() != expected {
            return Err(RestoreError::Objects { expected, found });
        }
        for sighting in sightings {
            let object = sighting.object;
            let tracked = handles.get(&object).and_then(|&handle| self.tracked_as(handle, sighting));
            self.tracked.insert(object, tracked.ok_or(RestoreError::Object { object })?);
        }
        self.seen.clone_from(&snapshot.seen);
        let own = self.tracked.iter().filter(|(_, tracked)| tracked.is_own);
        self.owned = own.map(|(&object, tracked)| (tracked.handle, object)).collect();
        self.next_handle = snapshot.next_handle;
        self.remember(&snapshot.remembered)
    }

    /// Returns what is remembered of an object in sight; `None` where its entry in the view is another's.
    fn tracked_as(&self, handle: Handle, sighting: &Sighting) -> Option<Tracked> {
        let Sighting { unit_type, owner, base: truth, status, own, .. } = *sighting;
        let is_own = self.owns(owner);
        let seen = self.view.object(handle)?;
        let is_it = seen.unit_type == unit_type
            && seen.owner == owner
            && seen.status == status
            && seen.own == is_own.then_some(own)
            && is_base(&seen.base);
        is_it.then_some(Tracked { handle, truth, told: seen.base, status, own, is_own })
    }

    fn remember(&mut self, remembered: &BTreeMap<ObjectId, Handle>) -> Result<(), RestoreError> {
        let mut taken: Vec<Handle> = self.seen.keys().copied().collect();
        for (&object, &handle) in remembered {
            if self.tracked.contains_key(&object) || self.seen.contains_key(&handle) {
                return Err(RestoreError::Remembered { object });
            }
            taken.push(handle);
        }
        let next = self.next_handle;
        if next > NEXT_HANDLE_MAX {
            return Err(RestoreError::TooManyHandles { next });
        }
        if let Some(&handle) = taken.iter().find(|handle| handle.0 >= next) {
            return Err(RestoreError::Handle { handle, next });
        }
        self.remembered.clone_from(remembered);
        let mut handles: Vec<(Handle, ObjectId)> =
            remembered.iter().map(|(&object, &handle)| (handle, object)).collect();
        handles.sort_unstable();
        match handles.windows(2).find(|pair| pair[0].0 == pair[1].0) {
            Some(pair) => Err(RestoreError::Remembered { object: pair[1].1 }),
            None => Ok(()),
        }
    }
}

/// Returns whether all numbers of a base are finite.
fn is_base(base: &Base) -> bool {
    base.point.is_finite() && base.velocity.is_finite() && base.fraction.is_finite()
}
