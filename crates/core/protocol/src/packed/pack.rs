//! The sender's side.

use std::collections::BTreeMap;

use maniple_view::{Base, Delta, Handle, Rules};

use super::bits::write_unsigned;
use super::motion::{Known, Layout, MotionWriter};
use super::{PackedDelta, Rest};

/// Packs the deltas of one connection, and remembers what its receiver has been told.
#[derive(Clone, Debug)]
pub struct Packer {
    layout: Layout,
    known: BTreeMap<Handle, Known>,
}

impl Packer {
    /// Returns the packer of a connection that has been told nothing yet: its first delta is a keyframe.
    #[must_use]
    pub fn new(rules: &Rules) -> Self {
        Self { layout: Layout::of(rules), known: BTreeMap::new() }
    }

    /// Returns the next delta in few bytes.
    ///
    /// # Panics
    /// If the delta does not follow the ones before, or has no numbers of the grid that the rules name.
    pub fn pack(&mut self, delta: &Delta) -> PackedDelta {
        let motions = self.motions(delta, Receiver::UpToDate);
        self.take_in(delta);
        packed(delta, motions)
    }

    /// Returns in few bytes what a receiver that has missed some of the last deltas is told in their place, once they are packed
    /// for others: it can be read whatever the receiver last knew of the motions that change.
    ///
    /// # Panics
    /// If the merged delta does not end with the last that was packed.
    #[must_use]
    pub fn pack_merged(&self, merged: &Delta) -> PackedDelta {
        packed(merged, self.motions(merged, Receiver::Behind))
    }

    fn motions(&self, delta: &Delta, receiver: Receiver) -> Vec<u8> {
        if delta.appeared.is_empty() && delta.moved.is_empty() && delta.stopped.is_empty() {
            return Vec::new();
        }
        let known = |object: Handle| self.known.get(&object).expect("a delta changes what was told before");
        let mut writer = MotionWriter { layout: &self.layout, cycle: delta.cycle, bytes: Vec::new() };
        for new in &delta.appeared {
            writer.write_base(&new.base, new.unit_type, None);
        }
        write_unsigned(&mut writer.bytes, delta.moved.len() as u64);
        let mut last = None;
        for moved in &delta.moved {
            write_gap(&mut writer.bytes, &mut last, moved.object);
            let known = known(moved.object);
            writer.write_base(&moved.base, known.unit_type, receiver.base(known));
        }
        last = None;
        for stopped in &delta.stopped {
            write_gap(&mut writer.bytes, &mut last, stopped.object);
            writer.write_stop(&stopped.base(), receiver.base(known(stopped.object)), stopped.reason);
        }
        writer.bytes
    }

    fn take_in(&mut self, delta: &Delta) {
        for object in delta.vanished.iter().chain(&delta.died) {
            self.known.remove(object);
        }
        let moved = delta.moved.iter().map(|moved| (moved.object, moved.base));
        let stopped = delta.stopped.iter().map(|stopped| (stopped.object, stopped.base()));
        for (object, base) in moved.chain(stopped) {
            if let Some(known) = self.known.get_mut(&object) {
                known.base = base;
            }
        }
        for new in &delta.appeared {
            self.known.insert(new.object, Known { unit_type: new.unit_type, base: new.base });
        }
    }
}

/// Whose deltas are packed.
#[derive(Clone, Copy, Debug)]
enum Receiver {
    UpToDate,
    Behind,
}

impl Receiver {
    /// Returns what it knows for certain of a motion.
    fn base(self, known: &Known) -> Option<&Base> {
        match self {
            Self::UpToDate => Some(&known.base),
            Self::Behind => None,
        }
    }
}

fn packed(delta: &Delta, motions: Vec<u8>) -> PackedDelta {
    let rest = Rest::of(delta);
    let rest = (rest != Rest::default()).then(|| Box::new(rest));
    PackedDelta { cycle: delta.cycle, rest, motions, check: delta.check }
}

/// Writes how many handles lie between an object and the one before in its list, and lets it be the one before.
fn write_gap(bytes: &mut Vec<u8>, last: &mut Option<Handle>, object: Handle) {
    let first_free = last.map_or(0, |last| u64::from(last.0) + 1);
    let gap = u64::from(object.0).checked_sub(first_free).expect("lists of a delta are by handle");
    write_unsigned(bytes, gap);
    *last = Some(object);
}
