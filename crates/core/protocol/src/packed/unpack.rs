//! The receiver's side.

use maniple_view::{Appeared, Base, Delta, Handle, Moved, Rules, Stopped, View};

use super::bits::Reader;
use super::motion::{Known, Layout, MotionReader};
use super::{PackedDelta, PackedError, PackedProblem, Rest};

impl PackedDelta {
    /// Returns the delta: the same bits that the server has. `view` is the receiver's, before the delta.
    ///
    /// # Errors
    /// Motions that are none, or that do not fit the view; see [`PackedError`].
    pub fn unpack(self, view: &View, rules: &Rules) -> Result<Delta, PackedError> {
        let Self { cycle, rest, motions, check } = self;
        let rest = rest.map_or_else(Rest::default, |rest| *rest);
        let layout = Layout::of(rules);
        let mut reader = MotionReader { layout: &layout, cycle, bytes: Reader::new(&motions) };
        let mut delta = Delta { cycle, check, ..Delta::default() };
        let read = read_motions(&mut reader, view, &rest, &mut delta);
        read.map_err(|problem| PackedError { cycle, offset: reader.bytes.offset(), problem })?;
        let Rest {
            results,
            sight,
            revealed,
            walls,
            appeared: _,
            vanished,
            died,
            changed,
            shots,
            ended,
            stock,
        } = rest;
        Ok(Delta { results, sight, revealed, walls, vanished, died, changed, shots, ended, stock, ..delta })
    }
}

fn read_motions(
    reader: &mut MotionReader<'_>,
    view: &View,
    rest: &Rest,
    delta: &mut Delta,
) -> Result<(), PackedProblem> {
    if rest.appeared.is_empty() && reader.bytes.is_at_end() {
        return Ok(());
    }
    for &(object, unit_type, owner, status, own) in &rest.appeared {
        let base = reader.read_base(object, unit_type, None)?;
        delta.appeared.push(Appeared { object, unit_type, owner, base, status, own });
    }
    let mut next = 0;
    for _ in 0..reader.bytes.unsigned()? {
        let object = read_handle(&mut reader.bytes, &mut next)?;
        let Known { unit_type, base } = known(view, object)?;
        delta.moved.push(Moved { object, base: reader.read_base(object, unit_type, Some(&base))? });
    }
    next = 0;
    while !reader.bytes.is_at_end() {
        let object = read_handle(&mut reader.bytes, &mut next)?;
        let (base, reason) = reader.read_stop(&known(view, object)?.base)?;
        let Base { point, cycle, fraction, .. } = base;
        delta.stopped.push(Stopped { object, point, cycle, fraction, reason });
    }
    Ok(())
}

/// Reads how many handles lie between; `next` is the first that can come.
fn read_handle(bytes: &mut Reader<'_>, next: &mut u64) -> Result<Handle, PackedProblem> {
    let object = next.checked_add(bytes.unsigned()?).and_then(|object| u32::try_from(object).ok());
    let object = object.ok_or(PackedProblem::TooLarge)?;
    *next = u64::from(object) + 1;
    Ok(Handle(object))
}

fn known(view: &View, object: Handle) -> Result<Known, PackedProblem> {
    let seen = view.object(object).ok_or(PackedProblem::UnknownObject { object })?;
    Ok(Known { unit_type: seen.unit_type, base: seen.base })
}
