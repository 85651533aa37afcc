//! From a player's command to an order of kinematics, or the reason why not.

use glam::DVec2;
use maniple_geometry::{Limits, Moment, NumberError};
use maniple_kinematics::{Leg, OrderError, Placement};
use maniple_view::{Command, Refusal, Start, WAYPOINTS_MAX, Waypoint};

/// What kinematics is told to do with an object.
pub(super) enum Order {
    Go { legs: Vec<Leg>, placement: Placement, start: Option<Moment> },
    Halt { start: Option<Moment> },
}

/// What bounds the numbers of a command.
pub(super) struct Ground {
    /// World units.
    pub(super) width: u32,
    /// World units.
    pub(super) height: u32,
    pub(super) limits: Limits,
}

/// Returns the order of a command to an object that goes at most at `speed_max`, in world units a cycle.
pub(super) fn parsed(command: &Command, speed_max: f64, ground: &Ground) -> Result<Order, Refusal> {
    if speed_max == 0.0 {
        return Err(Refusal::UnknownAction);
    }
    match command {
        Command::Move { x, y, s, queue, start, .. } => {
            let placement = if *queue { Placement::Queue } else { Placement::Replace };
            moved((*x, *y, *s), placement, *start, &Bounds { speed_max, ground })
        }
        Command::Path { points, start, .. } => path(points, *start, &Bounds { speed_max, ground }),
        Command::Stop { .. } => Ok(Order::Halt { start: None }),
        Command::Resign
        | Command::Attack { .. }
        | Command::AttackAt { .. }
        | Command::AttackMove { .. }
        | Command::Hold { .. }
        | Command::Gather { .. }
        | Command::ReturnLoad { .. }
        | Command::Build { .. }
        | Command::Train { .. }
        | Command::Cancel { .. }
        | Command::Switch { .. } => Err(Refusal::UnknownAction),
    }
}

/// Returns the reason for which kinematics refused an order.
pub(super) fn refusal(error: OrderError) -> Refusal {
    match error {
        OrderError::UnknownObject => Refusal::UnknownHandle,
        OrderError::BadNumber { field, problem } => bad(field, problem),
        OrderError::StartInPast { now } => Refusal::StartInPast { now },
        OrderError::TooManyWaypoints { max } => {
            Refusal::TooManyWaypoints { max: u32::try_from(max).unwrap_or(u32::MAX) }
        }
        OrderError::EmptyPath => Refusal::EmptyPath,
    }
}

struct Bounds<'a> {
    speed_max: f64,
    ground: &'a Ground,
}

fn moved(
    (x, y, s): Waypoint,
    placement: Placement,
    start: Option<Start>,
    bounds: &Bounds<'_>,
) -> Result<Order, Refusal> {
    let goal = goal(x, y, bounds.ground)?;
    let speed = speed(s, bounds)?;
    let start = moment(start, bounds.ground)?;
    if speed > 0.0 {
        return Ok(Order::Go { legs: vec![Leg { goal, speed }], placement, start });
    }
    match placement {
        Placement::Replace => Ok(Order::Halt { start }),
        Placement::Queue => Err(bad("s", "is 0, which stops at once; a stop cannot be queued")),
    }
}

fn path(points: &[Waypoint], start: Option<Start>, bounds: &Bounds<'_>) -> Result<Order, Refusal> {
    if points.is_empty() {
        return Err(Refusal::EmptyPath);
    }
    if points.len() > WAYPOINTS_MAX {
        return Err(Refusal::TooManyWaypoints { max: u32::try_from(WAYPOINTS_MAX).unwrap_or(u32::MAX) });
    }
    let leg = |&(x, y, s): &Waypoint| {
        let goal = goal(x, y, bounds.ground)?;
        let speed = speed(s, bounds)?;
        if speed == 0.0 { Err(bad("s", "is 0; a waypoint needs a speed")) } else { Ok(Leg { goal, speed }) }
    };
    let legs = points.iter().map(leg).collect::<Result<Vec<Leg>, Refusal>>()?;
    let start = moment(start, bounds.ground)?;
    Ok(Order::Go { legs, placement: Placement::Replace, start })
}

/// A goal on the edge of the world is within it, though no circle gets there.
pub(super) fn goal(x: f64, y: f64, ground: &Ground) -> Result<DVec2, Refusal> {
    let Ground { width, height, limits, .. } = *ground;
    let out = Refusal::OutOfWorld { width, height };
    for (field, value, end) in [("x", x, width), ("y", y, height)] {
        match limits.check_coordinate(value) {
            Ok(()) if 0.0 <= value && value <= f64::from(end) => {}
            Ok(()) | Err(NumberError::TooLarge { .. }) => return Err(out),
            Err(problem) => return Err(bad(field, problem)),
        }
    }
    Ok(DVec2::new(x, y))
}

fn speed(speed: Option<f64>, bounds: &Bounds<'_>) -> Result<f64, Refusal> {
    let Some(speed) = speed else { return Ok(bounds.speed_max) };
    let too_fast = Refusal::TooFast { max: bounds.speed_max };
    match bounds.ground.limits.check_speed(speed) {
        Ok(()) if speed <= bounds.speed_max => Ok(speed),
        Ok(()) | Err(NumberError::TooLarge { .. }) => Err(too_fast),
        Err(problem) => Err(bad("s", problem)),
    }
}

/// Whether the start lies in the past is for kinematics to say.
fn moment(start: Option<Start>, ground: &Ground) -> Result<Option<Moment>, Refusal> {
    let Some((cycle, fraction)) = start else { return Ok(None) };
    ground.limits.check_fraction(fraction).map_err(|problem| bad("start", problem))?;
    Ok(Some(Moment { cycle, fraction }))
}

fn bad(field: &str, problem: impl std::fmt::Display) -> Refusal {
    Refusal::BadNumber { field: field.to_owned(), problem: problem.to_string() }
}
