use std::sync::Arc;
use std::time::Duration;

use maniple_game::{Files, LoadedFile, Overrides, load};
use maniple_geometry::Cycle;
use maniple_view::{
    COMMANDS_A_CYCLE_MAX, ClockMode, Command, EndReason, Handle, Outcome, Refusal, Seat, Sequenced, View,
};

use super::Referee;
use crate::{FloodError, JoinError, Paused, QUEUED_MAX, RecordedEvent, ReplayError};

const A: Seat = Seat(0);
const B: Seat = Seat(1);

#[test]
fn the_first_delta_and_the_first_after_a_join_are_keyframes() {
    let mut referee = Referee::new(loaded("skip"), ClockMode::Lockstep).unwrap();
    let first = referee.take_delta(A).unwrap();
    assert_eq!((first.cycle, first.appeared.len()), (Cycle(0), 2));
    assert_eq!(referee.take_delta(A), None);
    referee.handle_join(A, "Ada").unwrap();
    assert_eq!(referee.take_delta(A).unwrap(), first);
    for _ in 0..3 {
        step(&mut referee);
    }
    referee.handle_leave(A);
    step(&mut referee);
    referee.handle_join(A, "someone else").unwrap();
    assert_eq!(referee.rules().players, ["Ada", ""]);
    let again = referee.take_delta(A).unwrap();
    let mut view = View::new(&referee.rules(), Arc::clone(referee.terrain()));
    view.apply(&again).unwrap();
    assert_eq!(&view, referee.view(A));
    assert_eq!(again, referee.keyframe(A));
}

#[test]
fn commands_are_answered_in_order_with_their_numbers_and_how_late_they_were() {
    let mut referee = started("skip");
    for _ in 0..5 {
        step(&mut referee);
    }
    let handle = own(&referee, A);
    let foreign = own(&referee, B);
    let stop = |seq, object| Sequenced { seq, command: Command::Stop { object } };
    referee.handle_commands(A, Cycle(5), vec![stop(7, handle), stop(3, foreign)]).unwrap();
    referee.handle_commands(A, Cycle(3), vec![stop(3, handle), stop(9, Handle(99))]).unwrap();
    referee.handle_commands(A, Cycle(500), vec![stop(4, handle)]).unwrap();
    referee.take_records();
    referee.step();
    let results: Vec<(u32, Outcome)> = referee
        .take_delta(A)
        .unwrap()
        .results
        .into_iter()
        .map(|result| (result.seq, result.outcome))
        .collect();
    let applied = |late| Outcome::Applied { cycle: Cycle(5), late };
    let unknown = || Outcome::Refused { reason: Refusal::UnknownHandle };
    assert_eq!(results, [(7, applied(0)), (3, unknown()), (3, applied(2)), (9, unknown()), (4, applied(0))]);
    assert_eq!(referee.take_delta(B).unwrap().results, []);
}

#[test]
fn more_commands_than_a_cycle_takes_are_refused_and_a_flood_is_dropped() {
    let mut referee = started("skip");
    let object = own(&referee, A);
    let many = |count| vec![Sequenced { seq: 1, command: Command::Stop { object } }; count];
    referee.handle_commands(A, Cycle(0), many(COMMANDS_A_CYCLE_MAX)).unwrap();
    referee.handle_commands(A, Cycle(0), many(1)).unwrap();
    assert_eq!(referee.handle_commands(A, Cycle(0), many(QUEUED_MAX)), Err(FloodError { cycle: Cycle(0) }));
    referee.take_records();
    referee.step();
    let results = referee.take_delta(A).unwrap().results;
    assert_eq!(results.len(), COMMANDS_A_CYCLE_MAX + 1);
    let max = u32::try_from(COMMANDS_A_CYCLE_MAX).unwrap();
    let last = &results[COMMANDS_A_CYCLE_MAX].outcome;
    assert_eq!(*last, Outcome::Refused { reason: Refusal::TooManyCommands { max } });
    referee.take_delta(B);
    referee.take_records();
    referee.handle_commands(A, Cycle(1), many(QUEUED_MAX)).unwrap();
}

#[test]
fn who_resigns_is_out_and_the_other_wins() {
    let mut referee = started("skip");
    let object = own(&referee, A);
    let commands = vec![
        Sequenced { seq: 1, command: Command::Resign },
        Sequenced { seq: 2, command: Command::Stop { object } },
        Sequenced { seq: 3, command: Command::Resign },
    ];
    referee.handle_commands(A, Cycle(0), commands).unwrap();
    referee.take_records();
    referee.step();
    let delta = referee.take_delta(A).unwrap();
    let out = Outcome::Refused { reason: Refusal::Out };
    assert_eq!(delta.results[0].outcome, Outcome::Applied { cycle: Cycle(0), late: 0 });
    assert_eq!((&delta.results[1].outcome, &delta.results[2].outcome), (&out, &out));
    assert_eq!(delta.died.len(), 1);
    assert_eq!(referee.take_delta(B).unwrap().died.len(), 1);
    let result = referee.result().unwrap();
    assert_eq!(
        (&result.winners[..], result.reason, result.cycles),
        (&[B][..], EndReason::Resigned, Cycle(1))
    );
    assert!(result.scores[0].resigned && !result.scores[1].resigned);
    assert_eq!((result.scores[0].name.as_str(), result.scores[1].tally.units), ("Ada", 1));
    assert_eq!(result.hash, referee.hash());
    assert!(!referee.is_ready());
    assert_eq!(referee.handle_commands(B, Cycle(1), vec![]), Ok(()));
}

#[test]
fn lock_step_waits_for_everyone_who_is_in() {
    let mut referee = Referee::new(loaded("skip"), ClockMode::Lockstep).unwrap();
    referee.handle_done(A, Cycle(0));
    referee.handle_done(B, Cycle(0));
    assert!(!referee.is_ready(), "nobody has joined");
    referee.handle_join(A, "Ada").unwrap();
    referee.handle_join(B, "Bob").unwrap();
    assert!(referee.is_ready());
    step(&mut referee);
    referee.handle_done(A, Cycle(0));
    referee.handle_done(B, Cycle(2));
    assert!(!referee.is_ready(), "neither is about cycle 1");
    referee.handle_done(A, Cycle(1));
    assert!(!referee.is_ready());
    referee.forfeit(B);
    assert!(referee.is_ready(), "who is out is not waited for");
}

#[test]
fn real_time_waits_for_nobody() {
    let mut referee = Referee::new(loaded("forfeit"), ClockMode::Realtime).unwrap();
    assert!(!referee.is_ready());
    referee.handle_join(A, "Ada").unwrap();
    referee.handle_join(B, "Bob").unwrap();
    referee.handle_time(Duration::from_secs(1000));
    assert!(referee.is_ready() && !referee.is_out(A));
    assert_eq!(referee.poll_timeout(), None);
    assert_eq!(referee.rate(), 8.0);
}

#[test]
fn who_stalls_is_skipped_until_the_bank_has_something_again() {
    let mut referee = stalled("skip");
    assert!(referee.is_ready() && !referee.is_out(B));
    step(&mut referee);
    assert!(!referee.is_ready());
    referee.handle_done(A, Cycle(1));
    assert_eq!(referee.poll_timeout(), Some(Duration::from_millis(100_125)));
    referee.handle_time(Duration::from_millis(100_124));
    assert!(!referee.is_ready());
    referee.handle_time(Duration::from_millis(100_125));
    assert!(referee.is_ready());
    assert_eq!(referee.poll_timeout(), None);
}

#[test]
fn who_stalls_is_forfeited_if_the_scenario_says_so() {
    let mut referee = stalled("forfeit");
    assert!(referee.is_ready() && referee.is_out(B));
    let forfeited = RecordedEvent::Forfeited { cycle: Cycle(0), seat: B };
    assert_eq!(referee.take_records().last(), Some(&forfeited));
    referee.step();
    assert_eq!(referee.result().unwrap().winners, [A]);
}

#[test]
fn time_before_all_have_come_costs_nobody() {
    let mut referee = Referee::new(loaded("forfeit"), ClockMode::Lockstep).unwrap();
    referee.handle_join(A, "Ada").unwrap();
    referee.handle_time(Duration::from_secs(500));
    assert_eq!(referee.poll_timeout(), None);
    referee.handle_join(B, "Bob").unwrap();
    assert_eq!(referee.poll_timeout(), Some(Duration::from_secs(502)));
    assert!(!referee.is_out(A) && !referee.is_ready());
}

#[test]
fn a_name_has_to_be_printable_and_short() {
    let mut referee = Referee::new(loaded("skip"), ClockMode::Lockstep).unwrap();
    for name in ["", "a\nb", &"x".repeat(65)] {
        assert_eq!(referee.handle_join(A, name), Err(JoinError::BadName { name: name.to_owned() }));
    }
    assert!(!referee.is_connected(A));
    referee.handle_join(A, &"x".repeat(64)).unwrap();
}

#[test]
fn a_record_that_was_tampered_with_is_found_out() {
    let mut records = Vec::new();
    let mut referee = started("skip");
    let go = Command::Move { object: own(&referee, A), x: 8.0, y: 3.0, s: None, queue: false, start: None };
    referee.handle_commands(A, Cycle(0), vec![Sequenced { seq: 1, command: go }]).unwrap();
    while referee.result().is_none() {
        records.extend(referee.take_records());
        for seat in [A, B] {
            referee.take_delta(seat);
        }
        referee.step();
    }
    records.extend(referee.take_records());
    assert_eq!(replay(&records), Ok(()));
    let check = |tamper: &dyn Fn(&mut Vec<RecordedEvent>), expected: &str| {
        let mut tampered = records.clone();
        tamper(&mut tampered);
        let error = replay(&tampered).unwrap_err().to_string();
        assert!(error.contains(expected), "{error}");
    };
    let commands =
        records.iter().position(|record| matches!(record, RecordedEvent::Commands { .. })).unwrap();
    check(&|records| drop(records.remove(commands)), "at the start of cycle 1 the state hashes to");
    check(&|records| drop(records.remove(commands + 5)), "the hash of another cycle");
    check(&|records| records[commands..commands + 4].rotate_left(1), "the state hashes to");
    check(&|records| records.insert(commands + 4, records[commands].clone()), "commands for another cycle");
    check(
        &|records| records.insert(0, RecordedEvent::Forfeited { cycle: Cycle(0), seat: Seat(2) }),
        "seat 2",
    );
    check(&|records| records.push(records[records.len() - 2].clone()), "the match came to Some");
    check(&|records| records.insert(5, records[records.len() - 1].clone()), "the match came to None");
}

#[test]
fn no_cycle_is_ready_and_no_bank_runs_while_all_want_a_pause() {
    for mode in [ClockMode::Realtime, ClockMode::Lockstep] {
        let mut referee = Referee::new(loaded("forfeit"), mode).unwrap();
        referee.handle_join(A, "Ada").unwrap();
        referee.handle_pause(A);
        assert_eq!(referee.pause().seats, [], "before all have come nobody can be asked");
        referee.handle_join(B, "Bob").unwrap();
        for seat in [A, B] {
            referee.take_delta(seat);
            referee.handle_done(seat, Cycle(0));
        }
        referee.handle_pause(A);
        assert!(referee.is_ready(), "{mode:?}");
        assert_eq!(referee.take_pause_change(), Some(Paused { seats: vec![A], on: false }));
        referee.handle_pause(B);
        assert!(!referee.is_ready(), "{mode:?}");
        assert_eq!(referee.take_pause_change(), Some(Paused { seats: vec![A, B], on: true }));
        referee.handle_time(Duration::from_secs(1000));
        assert_eq!((referee.poll_timeout(), referee.is_out(A), referee.is_out(B)), (None, false, false));
        referee.handle_go_on(B);
        assert_eq!(referee.take_pause_change(), Some(Paused { seats: vec![], on: false }));
        assert!(referee.is_ready(), "{mode:?}");
        step(&mut referee);
        assert_eq!(referee.cycle(), Cycle(1));
    }
}

#[test]
fn a_bank_is_as_full_after_a_pause_as_before() {
    let mut referee = started("forfeit");
    referee.handle_time(Duration::from_millis(1500));
    referee.handle_pause(A);
    referee.handle_pause(B);
    referee.handle_time(Duration::from_secs(100));
    referee.handle_go_on(A);
    assert_eq!(referee.poll_timeout(), Some(Duration::from_millis(100_500)));
    referee.handle_time(Duration::from_millis(100_400));
    assert!(!referee.is_out(B));
    referee.handle_time(Duration::from_millis(100_500));
    assert!(referee.is_out(B));
}

#[test]
fn who_is_out_or_away_has_no_say_in_a_pause() {
    let mut referee = started("skip");
    referee.handle_pause(A);
    referee.handle_leave(B);
    assert!(referee.pause().on, "the one who is there has asked");
    referee.handle_go_on(B);
    assert!(referee.pause().on, "nobody is at this seat");
    referee.handle_join(B, "Bob").unwrap();
    assert!(referee.pause().on, "who comes back finds the pause");
    referee.handle_go_on(B);
    assert!(!referee.pause().on);
    referee.handle_pause(A);
    referee.handle_pause(B);
    referee.handle_leave(A);
    assert!(referee.pause().on, "one is left who can end it");
    referee.handle_leave(B);
    assert!(!referee.pause().on, "nobody is left who could end it");
    referee.handle_join(A, "Ada").unwrap();
    referee.forfeit(A);
    referee.handle_pause(A);
    assert_eq!(referee.pause(), Paused { seats: vec![], on: false });
}

#[test]
fn a_pause_is_in_no_record_and_changes_no_hash() {
    let play = |pauses: bool| {
        let mut referee = started("skip");
        let go =
            Command::Move { object: own(&referee, A), x: 8.0, y: 3.0, s: None, queue: false, start: None };
        let mut records = Vec::new();
        for cycle in 0..10 {
            records.extend(referee.take_records());
            if pauses && cycle == 4 {
                referee.handle_pause(A);
                referee.handle_pause(B);
            }
            if cycle == 4 {
                let go = Sequenced { seq: 1, command: go.clone() };
                referee.handle_commands(A, Cycle(4), vec![go]).unwrap();
            }
            referee.handle_go_on(B);
            step(&mut referee);
        }
        (records, referee.hash())
    };
    assert_eq!(play(true), play(false));
}

fn replay(records: &[RecordedEvent]) -> Result<(), ReplayError> {
    let mut referee = Referee::new(loaded("skip"), ClockMode::Lockstep).unwrap();
    records.iter().try_for_each(|record| referee.handle_record(record))
}

/// Returns a match in which B has waited for longer than its time bank of two seconds and A has not.
fn stalled(stall: &str) -> Referee {
    let mut referee = started(stall);
    referee.handle_time(Duration::from_secs(100));
    referee
}

/// Returns a match that both players have joined, at time zero, with A done.
fn started(stall: &str) -> Referee {
    let mut referee = Referee::new(loaded(stall), ClockMode::Lockstep).unwrap();
    referee.handle_join(A, "Ada").unwrap();
    referee.handle_join(B, "Bob").unwrap();
    for seat in [A, B] {
        referee.take_delta(seat);
    }
    referee.handle_done(A, Cycle(0));
    referee
}

fn own(referee: &Referee, seat: Seat) -> Handle {
    let (handle, _) = referee.view(seat).objects_of(seat).next().unwrap();
    handle
}

fn step(referee: &mut Referee) {
    referee.take_records();
    for seat in [A, B] {
        referee.take_delta(seat);
    }
    referee.step();
    for seat in [A, B] {
        referee.take_delta(seat);
    }
}

fn loaded(stall: &str) -> maniple_game::Loaded {
    let scenario = format!(
        "name = 'tiny'\nmap = 'tiny.map'\nlength_seconds = 5\nobjective.kind = 'race'\n\
         clock = {{ time_bank_seconds = 2, stall = '{stall}' }}\n\
         unit.a = {{ radius = 0.25, speed = 4 }}\n\
         seat = [{{ groups = [{{ unit = 'a', count = 1 }}] }}, {{ groups = [{{ unit = 'a', count = 1 }}] }}]\n"
    );
    let map = format!("type octile\nheight 6\nwidth 24\nmap\n{}", "........................\n".repeat(6));
    let file = |path: &str, text: String| LoadedFile { path: path.to_owned(), bytes: text.into_bytes() };
    let files = Files(vec![file("tiny.toml", scenario), file("tiny.map", map)]);
    load(&files, "tiny.toml", &Overrides::default()).unwrap()
}
