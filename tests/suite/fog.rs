//! What a seat is told, and what not: sight, orders of others, and worlds that differ only where it cannot see.

use maniple_geometry::Cycle;
use maniple_view::{Command, Delta, Handle, Outcome, Seat, Sequenced, View};

use crate::matches::{Game, open, shipped, tiny};

#[test]
fn in_fog_a_seat_sees_exactly_what_is_in_sight_of_its_own() {
    let mut game = Game::new(shipped("config/scenarios/diamond.toml", None), &["straight", "random"]);
    let (mut seen_most, mut hidden_most) = (0, 0);
    while game.step() {
        let [a, b] = [Seat(0), Seat(1)].map(|seat| (seat, &game.players[seat.index()].view));
        for ((seat, view), (other_seat, other)) in [(a, b), (b, a)] {
            let foreign = view.objects_of(other_seat).count();
            let expected = other.objects_of(other_seat).filter(|&(handle, _)| {
                view.objects_of(seat).any(|(own, _)| is_in_sight(&game, (view, own), (other, handle)))
            });
            assert_eq!(foreign, expected.count(), "cycle {} seat {seat}", view.cycle());
            seen_most = seen_most.max(foreign);
            hidden_most = hidden_most.max(other.objects_of(other_seat).count() - foreign);
        }
    }
    assert!(seen_most > 4 && hidden_most > 4, "{seen_most} {hidden_most}");
}

#[test]
fn what_a_seat_is_told_does_not_depend_on_what_it_cannot_see() {
    let plain = format!("{}\n", ".".repeat(200)).repeat(8);
    let [mut idle, mut random] =
        ["idle", "random"].map(|opponent| Game::new(tiny("[vision]", &plain), &["straight", opponent]));
    let is_alone = |game: &Game| game.players[0].view.objects_of(Seat(1)).next().is_none();
    while idle.step() && random.step() && is_alone(&idle) && is_alone(&random) {
        assert_eq!(idle.players[0].delta, random.players[0].delta);
        assert_ne!(idle.referee.hash(), random.referee.hash());
    }
    assert!(idle.referee.cycle() > Cycle(100), "they met in cycle {}", idle.referee.cycle());
}

#[test]
fn an_order_that_changes_nothing_to_be_seen_is_not_told_to_others() {
    let check = |command: &dyn Fn(Handle) -> Command| {
        let mut game = Game::new(tiny("", &open()), &["idle", "idle"]);
        let quiet =
            |delta: &Delta| delta.moved.is_empty() && delta.stopped.is_empty() && delta.changed.is_empty();
        let (object, _) = game.players[0].view.objects_of(Seat(0)).next().unwrap();
        let command = command(object);
        for _ in 0..3 {
            let cycle = game.referee.cycle();
            let list = vec![Sequenced { seq: 1, command: command.clone() }];
            game.referee.handle_commands(Seat(0), cycle, list).unwrap();
            game.step();
            assert!(
                matches!(game.players[0].delta.results[0].outcome, Outcome::Applied { .. }),
                "{command:?}"
            );
            assert!(quiet(&game.players[1].delta), "{command:?}: {:?}", game.players[1].delta);
        }
    };
    let go = |object, s, cycle| Command::Move {
        object,
        x: 12.0,
        y: 12.0,
        s,
        queue: false,
        start: Some((Cycle(cycle), 0.5)),
    };
    check(&|object| Command::Stop { object });
    check(&|object| go(object, Some(0.0), 2));
    check(&|object| go(object, None, 20));
    check(&|object| Command::Path { object, points: vec![(3.0, 3.0, None)], start: Some((Cycle(9), 0.0)) });
}

/// Returns whether the object `seen` of a view is in sight of the object `eye` of another.
fn is_in_sight(game: &Game, eye: (&View, Handle), seen: (&View, Handle)) -> bool {
    let types = game.referee.rules().unit_types;
    let [(from, eye_type), (to, seen_type)] = [eye, seen].map(|(view, handle)| {
        let unit_type = view.object(handle).unwrap().unit_type;
        (view.position(handle).unwrap(), types[usize::from(unit_type.0)].clone())
    });
    let reach = eye_type.radius + seen_type.radius + eye_type.sight;
    from.distance_squared(to) <= reach * reach
}
