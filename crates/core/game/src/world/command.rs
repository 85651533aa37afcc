//! What a seat tells its objects to do.

use glam::DVec2;
use maniple_geometry::ObjectId;
use maniple_view::{Command, Mode, Refusal};

use super::order::{self, Ground, Order};
use super::state::State;
use super::unit::{Body, Job};
use crate::rules::{combat, harvest, modes, production};

/// Lets an object obey, which is alive and the seat's own; `target` is the object in the seat's view that the command is aimed at.
pub(super) fn obey(
    state: &mut State,
    object: ObjectId,
    command: &Command,
    target: Option<ObjectId>,
) -> Result<(), Refusal> {
    check_free(state, object, command)?;
    let target = target.filter(|&target| {
        let owner = state.units.at(object).owner;
        owner.is_some_and(|owner| state.sees(owner, target))
    });
    let target = || target.ok_or(Refusal::UnknownTarget);
    match command {
        Command::Stop { .. } if state.speed(object) == 0.0 => return cease(state, object),
        Command::Move { .. } | Command::Path { .. } | Command::Stop { .. } | Command::Resign => {
            return steer(state, object, command);
        }
        Command::Train { unit_type, .. } => return production::train(state, object, *unit_type),
        Command::Cancel { .. } => return production::cancel(state, object),
        Command::Attack { .. } => combat::attack(state, object, target()?),
        Command::AttackAt { x, y, .. } => {
            let point = point(state, *x, *y)?;
            combat::attack_at(state, object, point)
        }
        Command::AttackMove { x, y, .. } => {
            let goal = point(state, *x, *y)?;
            combat::attack_move(state, object, goal)
        }
        Command::Hold { .. } => combat::hold(state, object),
        Command::Gather { .. } => harvest::gather(state, object, target()?),
        Command::ReturnLoad { .. } => harvest::return_load(state, object),
        Command::Build { unit_type, x, y, .. } => {
            let center = point(state, *x, *y)?;
            production::build(state, object, *unit_type, center)
        }
        Command::Switch { .. } => modes::switch(state, object),
    }?;
    forget_motions(state, object);
    Ok(())
}

/// Refuses what an object that is switching or not finished cannot do.
fn check_free(state: &State, object: ObjectId, command: &Command) -> Result<(), Refusal> {
    let is_free = match state.units.at(object).mode {
        Mode::Normal | Mode::Alternate => true,
        Mode::Switching | Mode::SwitchingBack => matches!(command, Command::Switch { .. }),
        Mode::Site => matches!(command, Command::Cancel { .. }),
    };
    if is_free { Ok(()) } else { Err(Refusal::Busy) }
}

/// Gives kinematics an order; whatever the object was told to do before, it does no more.
fn steer(state: &mut State, object: ObjectId, command: &Command) -> Result<(), Refusal> {
    let ground = ground(state);
    let taken = match order::parsed(command, state.speed(object), &ground)? {
        Order::Go { legs, placement, start } => state.field.go(object, &legs, placement, start),
        Order::Halt { start } => state.field.halt(object, start),
    };
    taken.map_err(order::refusal)?;
    if state.units.at(object).job != Job::None {
        state.set_job(object, Job::None);
    }
    Ok(())
}

/// Lets an object do nothing more that stands anyway, if it is one that can be told to do something.
fn cease(state: &mut State, object: ObjectId) -> Result<(), Refusal> {
    let kind = state.kind(object);
    if state.weapon(object).is_none() && kind.harvest.is_none() && kind.builds.is_empty() {
        return Err(Refusal::UnknownAction);
    }
    state.set_job(object, Job::None);
    Ok(())
}

/// Lets an object stand that has been told to do something else, and forget the motions that it had.
fn forget_motions(state: &mut State, object: ObjectId) {
    if state.units.at(object).body == Body::Circle {
        let halted = state.field.halt(object, None);
        assert_eq!(halted, Ok(()), "who is alive can be halted");
    }
}

fn point(state: &State, x: f64, y: f64) -> Result<DVec2, Refusal> {
    order::goal(x, y, &ground(state))
}

fn ground(state: &State) -> Ground {
    Ground { width: state.map.width(), height: state.map.height(), limits: *state.field.limits() }
}
