//! The story that a client under test is led through: what both seats are ordered to do, whatever the client says.
//!
//! Orders in the client's name make its own objects stop for every reason; the client sees them move without having
//! asked. Handles are those of the seats' first keyframes: 0 the hq, 1 to 4 scouts, 5 and 6 workers, 7 the crystal.

use maniple_game::{Files, Loaded, LoadedFile, Overrides, load};
use maniple_view::{Command, Delta, Handle, Outcome, Refusal, Seat, StopReason, UnitTypeId};

use crate::failure::Failure;

/// The cycle whose delta is not sent where the connection is to be cut.
pub(crate) const CUT_CYCLE: u32 = 70;

/// The cycle from which on commands of the client are taken: before it each is refused, with each reason in turn.
const REFUSALS_END: u32 = 4;

/// When the other seat wishes for a pause, and when no more.
const WISH_CYCLES: (u32, u32) = (84, 87);

const SCENARIO: &str = "config/conformance/story.toml";

const SCOUT: UnitTypeId = UnitTypeId(1);
const TOWER: UnitTypeId = UnitTypeId(3);

/// Returns the start of the match; its files are in the program.
pub(crate) fn loaded() -> Result<Loaded, Failure> {
    let file = |path: &str, bytes: &[u8]| LoadedFile { path: path.to_owned(), bytes: bytes.to_vec() };
    let files = Files(vec![
        file(SCENARIO, include_bytes!("../../../../../../config/conformance/story.toml")),
        file(
            "config/conformance/story.tmx",
            include_bytes!("../../../../../../config/conformance/story.tmx"),
        ),
        file("maps/tiles.tsx", include_bytes!("../../../../../../maps/tiles.tsx")),
    ]);
    load(&files, SCENARIO, &Overrides::default()).map_err(Failure::bad_input)
}

/// Returns whether all commands of the client are refused in a cycle.
pub(crate) fn refuses(cycle: u32) -> bool {
    cycle < REFUSALS_END
}

/// Returns the reason for the n-th refusal.
pub(crate) fn refusal(number: usize) -> Refusal {
    let text = str::to_owned;
    let all = [
        Refusal::UnknownHandle,
        Refusal::OutOfWorld { width: 24, height: 14 },
        Refusal::BadNumber { field: text("x"), problem: text("is not finite") },
        Refusal::TooFast { max: 0.5 },
        Refusal::UnknownAction,
        Refusal::TooManyWaypoints { max: 64 },
        Refusal::EmptyPath,
        Refusal::TooManyCommands { max: 16_384 },
        Refusal::StartInPast { now: maniple_geometry::Cycle(1) },
        Refusal::Out,
        Refusal::UnknownTarget,
        Refusal::BadTarget,
        Refusal::Busy,
        Refusal::NotAffordable { cost: 20, stock: 10 },
        Refusal::Missing { unit_type: TOWER },
        Refusal::TrainingFull { max: 5 },
        Refusal::TooManyObjects { max: 4096 },
        Refusal::NothingToCancel,
        Refusal::BadPlace,
        Refusal::NothingToReturn,
    ];
    all[number % all.len()].clone()
}

/// Returns who is told at a cycle to wish for a pause; `None`: nothing is told of it.
pub(crate) fn wish(cycle: u32) -> Option<Vec<Seat>> {
    let (from, to) = WISH_CYCLES;
    match cycle {
        cycle if cycle == from => Some(vec![Seat(1)]),
        cycle if cycle == to => Some(Vec::new()),
        _ => None,
    }
}

/// Returns the orders of the story in a cycle.
pub(crate) fn orders(cycle: u32) -> Vec<(Seat, Command)> {
    let (client, other) = (Seat(0), Seat(1));
    let all =
        |seat, command: fn(Handle) -> Command| (1..=4).map(|unit| (seat, command(Handle(unit)))).collect();
    match cycle {
        // Arrived, ordered, object, edge and segment.
        6 => vec![go(client, 4, 5.0, 7.0)],
        8 => vec![go(client, 3, 3.0, 13.0), go(other, 1, 13.6, 7.0)],
        11 => vec![(client, Command::Stop { object: Handle(3) })],
        12 => vec![go(client, 1, 2.5, 8.5)],
        14 => vec![go(client, 2, 0.0, 7.0)],
        16 => vec![go(client, 4, 11.5, 6.5)],
        // Gather, train, build, switch.
        20 => vec![
            (client, Command::Gather { object: Handle(5), patch: Handle(7) }),
            (client, Command::Train { object: Handle(0), unit_type: SCOUT }),
            (client, Command::Build { object: Handle(6), unit_type: TOWER, x: 4.5, y: 9.5 }),
        ],
        22 => vec![(client, Command::Switch { object: Handle(3) })],
        30 => vec![(client, Command::Switch { object: Handle(3) })],
        // Into sight, and out of it.
        34 => vec![go(client, 4, 10.0, 3.5), go(other, 2, 13.0, 3.5)],
        48 => vec![go(other, 2, 21.0, 4.5), (client, Command::ReturnLoad { object: Handle(5) })],
        60 => vec![(client, Command::Gather { object: Handle(5), patch: Handle(7) })],
        // The fight.
        64 => all(other, |object| Command::AttackMove { object, x: 8.0, y: 3.0 }),
        65 => all(client, |object| Command::AttackMove { object, x: 10.0, y: 3.5 }),
        72 => vec![(client, Command::Hold { object: Handle(4) })],
        78 => all(other, |object| Command::AttackMove { object, x: 8.0, y: 10.0 }),
        96 => all(other, |object| Command::AttackMove { object, x: 6.0, y: 7.0 }),
        _ => Vec::new(),
    }
}

/// Returns how often each thing that can be told is in a delta.
pub(crate) fn told(delta: &Delta) -> Vec<(&'static str, usize)> {
    let stopped = |wanted: fn(&StopReason) -> bool| {
        delta.stopped.iter().filter(|stopped| stopped.reason.as_ref().is_some_and(wanted)).count()
    };
    let is_refused = |result: &&maniple_view::CommandResult| match result.outcome {
        Outcome::Refused { .. } => true,
        Outcome::Applied { .. } => false,
    };
    vec![
        ("appeared", delta.appeared.len()),
        ("moved", delta.moved.len()),
        ("stopped", delta.stopped.len()),
        ("arrived", stopped(|reason| *reason == StopReason::Arrived)),
        ("ordered", stopped(|reason| *reason == StopReason::Ordered)),
        ("object", stopped(|reason| matches!(reason, StopReason::Object { .. }))),
        ("segment", stopped(|reason| *reason == StopReason::Segment)),
        ("edge", stopped(|reason| *reason == StopReason::Edge)),
        ("vanished", delta.vanished.len()),
        ("died", delta.died.len()),
        ("status", delta.changed.iter().filter(|changed| changed.status.is_some()).count()),
        ("own", delta.changed.iter().filter(|changed| changed.own.is_some()).count()),
        ("shots", delta.shots.len()),
        ("ended_tasks", delta.ended.len()),
        ("sight", delta.sight.len()),
        ("revealed", delta.revealed.len()),
        ("walls", delta.walls.len()),
        ("stock", usize::from(delta.stock.is_some())),
        ("refused", delta.results.iter().filter(is_refused).count()),
    ]
}

fn go(seat: Seat, unit: u32, x: f64, y: f64) -> (Seat, Command) {
    (seat, Command::Move { object: Handle(unit), x, y, s: None, queue: false, start: None })
}

#[cfg(test)]
mod tests {
    use super::super::judge::Judge;

    #[test]
    fn a_client_that_says_nothing_but_done_is_told_everything_that_can_be() {
        let mut judge = Judge::new(false).unwrap();
        judge.welcome("idle").unwrap();
        for cycle in 0.. {
            judge.handle_done(maniple_geometry::Cycle(cycle));
            judge.step();
            if judge.has_ended() {
                break;
            }
        }
        let verdict = judge.verdict();
        assert!(verdict.passed && verdict.cycles == 120, "{verdict:?}");
        for (what, &times) in &verdict.told {
            // It gave no command that could be refused.
            assert_eq!(times > 0, *what != "refused", "{what}: {:?}", verdict.told);
        }
    }
}
