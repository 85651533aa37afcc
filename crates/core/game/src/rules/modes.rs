//! Modes: units that switch between two states, and stand while they do.

use maniple_geometry::{Cycle, ObjectId};
use maniple_view::{Mode, Refusal};

use crate::world::{Job, State};

/// Tells an object to switch. One that is switching goes back, which takes as long as it has been at it.
pub(crate) fn switch(state: &mut State, object: ObjectId) -> Result<(), Refusal> {
    let total = state.kind(object).alternate.as_ref().ok_or(Refusal::UnknownAction)?.switch_cycles;
    let now = state.cycle();
    let unit = state.units.at(object);
    let spent = total - unit.mode_until.0.saturating_sub(now.0);
    let (mode, cycles) = match unit.mode {
        Mode::Normal => (Mode::Switching, total),
        Mode::Switching => (Mode::SwitchingBack, spent),
        Mode::Alternate => (Mode::SwitchingBack, total),
        Mode::SwitchingBack => (Mode::Switching, spent),
        Mode::Site => return Err(Refusal::Busy),
    };
    state.set_job(object, Job::None);
    let unit = state.units.edit(object);
    unit.mode = mode;
    unit.mode_until = Cycle(now.0.saturating_add(cycles));
    Ok(())
}

/// Lets all switches end that are over at the start of the present cycle.
pub(crate) fn complete(state: &mut State, busy: &[ObjectId]) {
    let now = state.cycle();
    for &object in busy {
        let unit = state.units.at(object);
        let mode = match unit.mode {
            Mode::Switching => Mode::Alternate,
            Mode::SwitchingBack => Mode::Normal,
            Mode::Normal | Mode::Alternate | Mode::Site => continue,
        };
        if unit.mode_until <= now {
            state.units.edit(object).mode = mode;
        }
    }
}
