//! Harvest: resource patches with places, loads, and where they are delivered.

use std::collections::BTreeMap;

use maniple_geometry::{Cycle, ObjectId};
use maniple_view::{EndOfTask, Mode, Refusal};

use super::approach::{Approach, Goal, TOUCH, approach};
use crate::keyed::Purpose;
use crate::world::{Job, State, Stay};

/// Tells an object to gather at a patch that its seat sees.
pub(crate) fn gather(state: &mut State, object: ObjectId, patch: ObjectId) -> Result<(), Refusal> {
    if state.kind(object).harvest.is_none() {
        return Err(Refusal::UnknownAction);
    }
    if state.kind(patch).patch_places.is_none() {
        return Err(Refusal::BadTarget);
    }
    state.set_job(object, Job::Gather { patch, stay: Stay::Coming });
    Ok(())
}

/// Tells an object to deliver its load.
pub(crate) fn return_load(state: &mut State, object: ObjectId) -> Result<(), Refusal> {
    if state.kind(object).harvest.is_none() {
        return Err(Refusal::UnknownAction);
    }
    if state.units.at(object).load == 0 {
        return Err(Refusal::NothingToReturn);
    }
    let to = nearest_taker(state, object).ok_or(Refusal::NothingToReturn)?;
    state.set_job(object, Job::ReturnLoad { to });
    Ok(())
}

/// Lets all who gather or deliver go on at the start of a cycle.
pub(crate) fn walk(state: &mut State, busy: &[ObjectId]) {
    for &object in busy {
        match state.units.at(object).job {
            Job::Gather { patch, stay } => walk_to_patch(state, object, patch, stay),
            Job::ReturnLoad { to } => walk_home(state, object, to),
            Job::None
            | Job::Attack { .. }
            | Job::AttackAt { .. }
            | Job::AttackMove { .. }
            | Job::Hold
            | Job::Build { .. } => {}
        }
    }
}

fn walk_to_patch(state: &mut State, object: ObjectId, patch: ObjectId, stay: Stay) {
    if is_full(state, object) {
        state.halt(object);
        return state.end_job(object, EndOfTask::Done);
    }
    if state.units.at(object).owner.is_none_or(|owner| !state.sees(owner, patch)) {
        state.halt(object);
        return state.end_job(object, EndOfTask::Lost);
    }
    if stay == Stay::Coming
        && approach(state, object, &Goal::object(state, patch, TOUCH)) == Approach::Blocked
    {
        state.end_job(object, EndOfTask::Blocked);
    }
}

fn walk_home(state: &mut State, object: ObjectId, to: ObjectId) {
    let to = if takes_loads(state, object, to) { Some(to) } else { nearest_taker(state, object) };
    let Some(to) = to else {
        state.halt(object);
        return state.end_job(object, EndOfTask::Lost);
    };
    if state.units.at(object).job != (Job::ReturnLoad { to }) {
        state.set_job(object, Job::ReturnLoad { to });
    }
    if approach(state, object, &Goal::object(state, to, TOUCH)) == Approach::Blocked {
        state.end_job(object, EndOfTask::Blocked);
    }
}

/// Lets all who gather or deliver work in the cycle `played`, which is over.
pub(crate) fn work(state: &mut State, played: Cycle, busy: &[ObjectId]) {
    let mut patches: BTreeMap<ObjectId, Vec<ObjectId>> = BTreeMap::new();
    for &object in busy {
        match state.units.at(object).job {
            Job::Gather { patch, stay } => {
                if stay == Stay::Coming {
                    arrive(state, played, object, patch);
                }
                patches.entry(patch).or_default().push(object);
            }
            Job::ReturnLoad { to } => deliver(state, object, to),
            Job::None
            | Job::Attack { .. }
            | Job::AttackAt { .. }
            | Job::AttackMove { .. }
            | Job::Hold
            | Job::Build { .. } => {}
        }
    }
    for (patch, gatherers) in patches {
        take(state, patch, &gatherers);
        give_places(state, patch, &gatherers);
    }
}

/// Notes since when somebody waits who has come to a patch.
fn arrive(state: &mut State, played: Cycle, object: ObjectId, patch: ObjectId) {
    if state.is_moving(object) || !Goal::object(state, patch, TOUCH).is_in_reach(state, object) {
        return;
    }
    let fraction = state.stops.get(&object).map_or(0.0, |(moment, _)| moment.fraction);
    let stay = Stay::Waiting { since: played, fraction };
    state.units.edit(object).job = Job::Gather { patch, stay };
}

fn deliver(state: &mut State, object: ObjectId, to: ObjectId) {
    let is_there = !state.is_moving(object)
        && takes_loads(state, object, to)
        && Goal::object(state, to, TOUCH).is_in_reach(state, object);
    let Some(owner) = state.units.at(object).owner else { return };
    if is_there {
        let load = std::mem::take(&mut state.units.edit(object).load);
        let seat = &mut state.seats[owner.index()];
        seat.stock = seat.stock.saturating_add(load);
        seat.tally.gathered += u64::from(load);
        state.end_job(object, EndOfTask::Done);
    }
}

/// Lets those who work at a patch take what they have worked for. Of several who are ready for less than is left, a keyed hash says
/// who gets it.
fn take(state: &mut State, patch: ObjectId, gatherers: &[ObjectId]) {
    let mut ready = Vec::new();
    for &object in gatherers {
        let works = matches!(state.units.at(object).job, Job::Gather { stay: Stay::Working, .. });
        let Some(harvest) = state.kind(object).harvest.filter(|_| works) else { continue };
        let unit = state.units.edit(object);
        unit.worked += 1;
        if unit.worked >= harvest.cycles_each {
            ready.push((state.random(object, Purpose::Precedence), object));
        }
    }
    ready.sort_unstable();
    for (_, object) in ready {
        let left = &mut state.units.edit(patch).amount;
        if *left == 0 {
            break;
        }
        *left -= 1;
        let unit = state.units.edit(object);
        unit.load += 1;
        unit.worked = 0;
        if is_full(state, object) {
            state.end_job(object, EndOfTask::Done);
        }
    }
    if state.units.at(patch).amount > 0 {
        return;
    }
    for &object in gatherers {
        if state.units.at(object).job.is_gathering_at(patch) {
            state.halt(object);
            state.end_job(object, EndOfTask::Empty);
        }
    }
    state.remove(patch);
}

/// Lets as many begin as there are places: who has waited longest, to the fraction of a cycle, and of several by a keyed hash.
fn give_places(state: &mut State, patch: ObjectId, gatherers: &[ObjectId]) {
    let places = state.kind(patch).patch_places.unwrap_or(0) as usize;
    let mut working = 0;
    let mut waiting = Vec::new();
    for &object in gatherers {
        match state.units.at(object).job {
            Job::Gather { stay: Stay::Working, .. } => working += 1,
            Job::Gather { stay: Stay::Waiting { since, fraction }, .. } => {
                waiting.push((since, fraction, state.random(object, Purpose::Precedence), object));
            }
            Job::Gather { stay: Stay::Coming, .. }
            | Job::None
            | Job::Attack { .. }
            | Job::AttackAt { .. }
            | Job::AttackMove { .. }
            | Job::Hold
            | Job::ReturnLoad { .. }
            | Job::Build { .. } => {}
        }
    }
    waiting.sort_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)).then((a.2, a.3).cmp(&(b.2, b.3))));
    for (.., object) in waiting.into_iter().take(places.saturating_sub(working)) {
        let unit = state.units.edit(object);
        unit.job = Job::Gather { patch, stay: Stay::Working };
        unit.worked = 0;
    }
}

fn is_full(state: &State, object: ObjectId) -> bool {
    let load_max = state.kind(object).harvest.map_or(0, |harvest| harvest.load_max);
    state.units.at(object).load >= load_max
}

/// Returns whether an object is a finished building of the same seat that takes loads.
fn takes_loads(state: &State, object: ObjectId, building: ObjectId) -> bool {
    let unit = state.units.at(building);
    unit.is_alive
        && unit.mode != Mode::Site
        && unit.owner == state.units.at(object).owner
        && state.kind(building).takes_loads
}

/// Returns the nearest building to which an object can bring its load, hull to hull; of several by (y, x).
fn nearest_taker(state: &State, object: ObjectId) -> Option<ObjectId> {
    let takers =
        state.units.alive().map(|(building, _)| building).filter(|&it| takes_loads(state, object, it));
    takers.min_by(|&one, &other| {
        let (at_one, at_other) = (state.center(one), state.center(other));
        (state.distance(object, one).total_cmp(&state.distance(object, other)))
            .then(at_one.y.total_cmp(&at_other.y))
            .then(at_one.x.total_cmp(&at_other.x))
    })
}
