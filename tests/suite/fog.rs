//! What a seat is told, and what not: sight, orders of others, and worlds that differ only where it cannot see.

use std::sync::Arc;

use glam::DVec2;
use maniple_game::{Files, Loaded, LoadedFile, Overrides, load};
use maniple_geometry::Cycle;
use maniple_protocol::{Encoding, ServerMessage, encode_server};
use maniple_view::{
    Command, DEVIATION_SKINS_MAX, Delta, Handle, Outcome, Refusal, Seat, Seen, Sequenced, Shot,
    TerrainKnowledge, UnitTypeId, View, Waypoint,
};

use crate::matches::{Game, open, scouts, scouts_and, shipped, tiny};

#[test]
fn in_fog_a_seat_sees_exactly_what_is_in_sight_of_its_own() {
    let mut game = Game::new(shipped("config/scenarios/diamond.toml", None), &["straight", "random"]);
    let deviation_max = DEVIATION_SKINS_MAX * game.referee.rules().skin;
    let (mut seen_most, mut hidden_most) = (0, 0);
    while game.step() {
        let [a, b] = [Seat(0), Seat(1)].map(|seat| (seat, &game.players[seat.index()].view));
        for ((seat, view), (other_seat, other)) in [(a, b), (b, a)] {
            let foreign = view.objects_of(other_seat).count();
            let expected = other.objects_of(other_seat).filter(|&(handle, _)| {
                view.objects_of(seat).any(|(own, _)| is_in_sight(&game, (view, own), (other, handle)))
            });
            assert_eq!(foreign, expected.count(), "cycle {} seat {seat}", view.cycle());
            for (handle, _) in view.objects_of(other_seat) {
                let seen = view.position(handle).unwrap();
                let mut truths = other.objects_of(other_seat).map(|(own, _)| other.position(own).unwrap());
                assert!(truths.any(|truth| truth.distance(seen) <= deviation_max), "cycle {}", view.cycle());
            }
            seen_most = seen_most.max(foreign);
            hidden_most = hidden_most.max(other.objects_of(other_seat).count() - foreign);
        }
    }
    assert!(seen_most > 4 && hidden_most > 4, "{seen_most} {hidden_most}");
}

#[test]
fn a_seat_is_told_of_shots_of_those_alone_whom_it_saw_before() {
    // Guns fire farther than eyes see, and fire on while eyes come to see them.
    let tables = "[vision]\n[combat]\n[unit.gun]\nradius = 0.25\nspeed = 1\nsight = 15\nhit_points = 10\n\
                  weapon = { range = 14, cooldown_seconds = 0.125, damage_min = 1, damage_max = 1 }\n\
                  [unit.eye]\nradius = 0.25\nspeed = 4\nsight = 3\nhit_points = 10000\n";
    let (mut told, mut untold) = (0, 0);
    let mut game =
        Game::new(scouts_and(tables, &open(), &[("eye", 6), ("gun", 6)]), &["random", "commander"]);
    for _ in 0..160 {
        let before = game.players[0].view.clone();
        if !game.step() {
            break;
        }
        let (view, delta) = (&game.players[0].view, &game.players[0].delta);
        for Shot { object, .. } in &delta.shots {
            assert!(before.object(*object).is_some(), "cycle {}: {object}", view.cycle());
        }
        told += delta.shots.len();
        untold += delta.appeared.len();
    }
    assert!(told > 100 && untold > 5, "{told} {untold}");
}

#[test]
fn worlds_that_differ_only_out_of_sight_are_told_byte_for_byte_alike() {
    tell_alike("[vision]", [&plain(), &plain()]);
    tell_alike("[vision]\nidentity = 'persistent'", [&plain(), &plain()]);
}

#[test]
fn so_they_are_in_single_precision_and_with_positions_on_a_grid() {
    tell_alike("[vision]\n[kinematics]\nscalar = 'f32'", [&plain(), &plain()]);
    tell_alike("[vision]\n[view]\npositions = 'grid'\ngrid_bits = 6", [&plain(), &plain()]);
}

#[test]
fn so_they_are_where_terrain_that_was_never_seen_differs() {
    // Two of them side by side with tiles that are seen: what lies between must not be told.
    let beside = [(39, 0), (40, 1)];
    let other =
        rows(|x, y| beside.contains(&(x, y)) || y == 0 && x > 42 && x < 49 || y == 7 && (x == 47 || x == 48));
    tell_alike("[vision]\nterrain = 'explored'", [&plain(), &other]);
    tell_alike(
        "[vision]\nterrain = 'explored'\n[view]\npositions = 'grid'\ngrid_bits = 6",
        [&plain(), &other],
    );
}

#[test]
fn so_they_are_where_it_differs_behind_a_wall() {
    let wall = |x: usize, y: usize| y == 6 && (30..41).contains(&x);
    let here = rows(wall);
    let other = rows(|x, y| wall(x, y) || y == 7 && (32..35).contains(&x));
    tell_alike("[vision]\nwalls_block = true", [&here, &here]);
    tell_alike("[vision]\nwalls_block = true\nterrain = 'explored'", [&here, &other]);
}

/// Plays the story in a world where nothing else happens, and in one where much does that seat 0 cannot see, each with its map.
fn tell_alike(tables: &str, maps: [&str; 2]) {
    let [mut quiet, mut busy] =
        [(3, maps[0]), (4, maps[1])].map(|(count, rows)| Story::new(tables, count, rows));
    assert_eq!(quiet.game.referee.rules(), busy.game.referee.rules());
    assert_eq!(quiet.game.referee.terrain(), busy.game.referee.terrain());
    let (mut appeared, mut vanished, mut died, mut behind) = (0, 0, 0, 0);
    for cycle in 0..130 {
        quiet.play(&told_story(cycle));
        busy.play(&[told_story(cycle), busy.hidden_story(cycle)].concat());
        let delta = &quiet.game.players[0].delta;
        for encoding in [Encoding::Json, Encoding::Binary] {
            let [a, b] = [&quiet, &busy].map(|story| {
                let deltas = [story.game.players[0].delta.clone(), story.game.referee.keyframe(Seat(0))];
                deltas.map(|delta| encode_server(encoding, &ServerMessage::Delta(delta)).unwrap())
            });
            assert!(a == b, "cycle {cycle}: {delta:?} {:?}", busy.game.players[0].delta);
        }
        assert_ne!(quiet.game.referee.hash(), busy.game.referee.hash());
        let refused = Outcome::Refused { reason: Refusal::UnknownHandle };
        let refusals = delta.results.iter().filter(|result| result.outcome == refused).count();
        assert_eq!(refusals, 2 * FOREIGN.count(), "cycle {cycle}");
        appeared += delta.appeared.len();
        vanished += delta.vanished.len();
        died += delta.died.len();
        behind += busy.near_but_hidden();
    }
    assert_eq!(
        behind > 20,
        quiet.game.referee.rules().walls_block,
        "{behind} times somebody was behind a wall"
    );
    assert_eq!(
        (appeared, vanished, died),
        (3, 2, 1),
        "twice the one, who left twice, and once the other, who died"
    );
    let is_explored = quiet.game.referee.rules().terrain == TerrainKnowledge::Explored;
    let shroud = quiet.game.players[0].view.terrain().tiles.concat().matches('?').count();
    assert_eq!(is_explored, (150..400).contains(&shroud), "{shroud} tiles were never seen");
}

#[test]
fn whoever_connects_again_gets_all_that_was_seen() {
    let wall = rows(|x, y| (x == 20 || x == 40) && y != 5 || x % 7 == 3 && y == 2);
    for (tables, rows) in [
        ("[vision]", &wall),
        ("[vision]\nwalls_block = true", &wall),
        ("[vision]\nterrain = 'explored'", &wall),
        (
            "[vision]\nterrain = 'explored'\nwalls_block = true\n[view]\npositions = 'grid'\ngrid_bits = 4",
            &wall,
        ),
    ] {
        let mut game = Game::new(scouts(tables, rows, &[6, 6]), &["random", "straight"]);
        let (mut foggy, mut walls) = (0, 0);
        while game.step() {
            for (seat, player) in (0..).map(Seat).zip(&game.players) {
                let mut fresh = View::new(&game.referee.rules(), Arc::clone(game.referee.terrain()));
                fresh.apply(&game.referee.keyframe(seat)).unwrap();
                assert_eq!(fresh, player.view, "{tables}");
                walls += player.delta.walls.len();
            }
            foggy += game.players[0].delta.sight.len();
        }
        let view = &game.players[0].view;
        let every = (0..8).flat_map(|y| (0..60).map(move |x| (x, y)));
        let visible = every.clone().filter(|&(x, y)| view.is_visible(x, y)).count();
        let known = every.clone().filter(|&(x, y)| view.terrain().tile(x, y).is_some()).count();
        for (x, y) in every {
            assert!(
                !view.is_visible(x, y) || view.terrain().tile(x, y).is_some(),
                "{tables}: what is visible is known"
            );
        }
        let is_explored = tables.contains("explored");
        assert!(
            0 < visible && visible < known && (known < 480) == is_explored,
            "{tables}: {visible} {known}"
        );
        assert!(foggy > 100 && (walls > 20) == is_explored, "{tables}: {foggy} {walls}");
    }
}

#[test]
fn the_answer_to_an_order_to_build_says_nothing_of_ground_that_was_never_seen() {
    for (terrain, answers_differ) in [("known", true), ("explored", false)] {
        let other = rows(|x, y| !(5..55).contains(&x) && y > 0);
        let answers = [plain(), other].map(|rows| {
            let mut game = Game::new(builder(terrain, &rows), &["idle"]);
            let (object, from) = game.players[0]
                .view
                .objects()
                .map(|(handle, seen)| (handle, seen.base.point))
                .next()
                .unwrap();
            let far = if from.x < 30.0 { 57.5 } else { 2.5 };
            let build = |x, y| Command::Build { object, unit_type: UnitTypeId(0), x, y };
            let list = (0..).zip([build(far, 4.0), build(from.x, 0.5)]);
            let list = list.map(|(seq, command)| Sequenced { seq, command }).collect();
            game.referee.handle_commands(Seat(0), Cycle(0), list).unwrap();
            game.step();
            let results = &game.players[0].delta.results;
            let refused = Outcome::Refused { reason: Refusal::BadPlace };
            assert_eq!(
                results[1].outcome, refused,
                "{terrain}: beyond the edge of the map, where all is known"
            );
            results[0].outcome.clone()
        });
        assert!(matches!(answers[0], Outcome::Applied { .. }), "{terrain}: {answers:?}");
        assert_eq!(answers[0] != answers[1], answers_differ, "{terrain}");
    }
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

#[test]
fn an_order_that_keeps_to_its_line_is_not_told_to_others() {
    let check = |case: &str, plain: &[(u32, Command)], other: &[(u32, Command)]| {
        let [plain, other] = [plain, other].map(|orders| told_of(orders, 120));
        assert_eq!(plain, other, "{case}");
    };
    for (x, y) in [(START.0, START.1 - 9.0), (15.4, 8.6), (11.1, 16.2)] {
        let on = |part: f64| (START.0 + part * (x - START.0), START.1 + part * (y - START.1));
        let plain = [(0, go(on(1.0)))];
        check("a farther goal", &plain, &[(0, go(on(0.5))), (3, go(on(1.0)))]);
        let points = [0.25, 0.5, 1.0].map(|part| (on(part).0, on(part).1, None)).to_vec();
        check("waypoints on the way", &plain, &[(0, Command::Path { object: RUNNER, points, start: None })]);
        let renewed: Vec<(u32, Command)> = (0..10).map(|cycle| (cycle, go(on(1.0)))).collect();
        check("an order a cycle", &plain, &renewed);
    }
    check("rest at its own place", &[], &[(2, go(START))]);
    let into = go(NEIGHBOUR);
    let bumped = [(0, into.clone())];
    assert!(told_of(&bumped, 120).len() <= 2, "it stops at its neighbour");
    check("refused at once", &bumped, &[(0, into.clone()), (20, into.clone()), (21, into)]);
}

#[test]
fn an_order_that_leaves_its_line_or_speed_is_told_at_once() {
    let (x, y) = (START.0, START.1 - 9.0);
    let slower = |s| Command::Move { object: RUNNER, x, y, s: Some(s), queue: false, start: None };
    for (case, other) in [
        ("aside", go((x + 1e-6, y))),
        ("back", go(START)),
        ("slower", slower(0.4999)),
        ("halt", Command::Stop { object: RUNNER }),
    ] {
        let told = told_of(&[(0, go((x, y))), (5, other)], 6);
        assert_eq!(told.iter().map(|&(cycle, ..)| cycle).collect::<Vec<u32>>(), [1, 6], "{case}");
    }
}

/// The unit of seat 0 in the tiny match that has open ground before it.
const RUNNER: Handle = Handle(3);

/// Where it starts.
const START: (f64, f64) = (19.5, 17.9375);

/// Where its neighbour stands.
const NEIGHBOUR: (f64, f64) = (19.5, 18.5);

fn go((x, y): (f64, f64)) -> Command {
    Command::Move { object: RUNNER, x, y, s: None, queue: false, start: None }
}

/// Plays so many cycles of the tiny match with these orders of seat 0, each in its cycle; returns when seat 1 was told
/// that something moved, and what stopped where.
fn told_of(orders: &[(u32, Command)], cycles: u32) -> Vec<(u32, usize, Vec<DVec2>)> {
    let mut game = Game::new(tiny("", &open()), &["idle", "idle"]);
    let view = &game.players[0].view;
    assert_eq!(view.position(RUNNER), Some(DVec2::from(START)));
    assert!(view.objects_of(Seat(0)).any(|(_, seen)| seen.base.point == DVec2::from(NEIGHBOUR)));
    let mut told = Vec::new();
    for cycle in 0..cycles {
        let commands = orders.iter().filter(|(when, _)| *when == cycle).map(|(_, command)| command.clone());
        let list: Vec<Sequenced> =
            (0..).zip(commands).map(|(seq, command)| Sequenced { seq, command }).collect();
        game.referee.handle_commands(Seat(0), Cycle(cycle), list).unwrap();
        game.step();
        let results = &game.players[0].delta.results;
        assert!(
            results.iter().all(|result| matches!(result.outcome, Outcome::Applied { .. })),
            "{results:?}"
        );
        let Delta { moved, stopped, .. } = &game.players[1].delta;
        if !moved.is_empty() || !stopped.is_empty() {
            told.push((cycle + 1, moved.len(), stopped.iter().map(|stopped| stopped.point).collect()));
        }
    }
    told
}

/// A match of three seats in fog on a map 60 wide. Seat 0 stands at x = 36 from cycle 33 on and sees as far as x = 40.
struct Story {
    game: Game,
    /// The units of each seat, and where they started.
    units: Vec<Vec<(Handle, (f64, f64))>>,
}

/// A seat, where its unit started, and the goals to which it goes; without goals the seat resigns.
type Line = (Seat, (f64, f64), Vec<(f64, f64)>);

/// The unit of seat 0 that sees the others.
const WATCHER: (f64, f64) = (19.5, 4.5);

/// The unit of seat 1 that comes, goes, comes again, bumps into the watcher, and is left.
const HERALD: (f64, f64) = (58.9375, 1.0625);

/// The unit of seat 2 that comes and dies.
const VISITOR: (f64, f64) = (41.5, 6.9375);

/// Handles that never are those of the seat's own units: of objects that are seen, were seen, are dead, or never were.
const FOREIGN: std::ops::Range<u32> = 2..12;

impl Story {
    /// Returns the match at its start, with the tables of its scenario and the rows of its map; seat 2 has so many units.
    fn new(tables: &str, count: usize, rows: &str) -> Self {
        let [mut loaded, open] = [rows, &plain()].map(|rows| scouts(tables, rows, &[2, 5, count]));
        // Where all start and whose zones are where would follow from the whole map.
        loaded.setup = open.setup;
        let game = Game::new(loaded, &["idle"; 3]);
        let start = |(handle, seen): (Handle, &Seen)| (handle, seen.base.point.into());
        let units = game.players.iter().map(|player| player.view.objects().map(start).collect()).collect();
        Self { game, units }
    }

    /// Plays a cycle in which seat 0 also gives orders to whatever is not its own.
    fn play(&mut self, lines: &[Line]) {
        let mut commands = vec![Vec::new(); 3];
        for (seat, start, goals) in lines {
            let units = &self.units[seat.index()];
            let (object, _) = *units.iter().find(|(_, point)| point == start).expect("a unit started there");
            let points: Vec<Waypoint> = goals.iter().map(|&(x, y)| (x, y, None)).collect();
            let path = Command::Path { object, points, start: None };
            commands[seat.index()].push(if goals.is_empty() { Command::Resign } else { path });
        }
        for object in FOREIGN.map(Handle) {
            let (x, y) = (f64::NAN, -1.0);
            commands[0].push(Command::Move { object, x, y, s: None, queue: false, start: None });
            commands[0].push(Command::Stop { object });
        }
        for (seat, commands) in (0..).map(Seat).zip(commands) {
            let list = (0..).zip(commands).map(|(seq, command)| Sequenced { seq, command }).collect();
            self.game.referee.handle_commands(seat, self.game.referee.cycle(), list).unwrap();
        }
        assert!(self.game.step());
        for player in &self.game.players[1..] {
            let results = &player.delta.results;
            assert!(
                results.iter().all(|result| matches!(result.outcome, Outcome::Applied { .. })),
                "{results:?}"
            );
        }
    }

    /// Returns how many are in sight of seat 0 from hull to hull, but not in its view.
    fn near_but_hidden(&self) -> usize {
        let view = &self.game.players[0].view;
        let foreign = [1, 2].map(|seat| (Seat(seat), &self.game.players[usize::from(seat)].view));
        let near = foreign.map(|(seat, other)| {
            let is_near = |handle| {
                let mut own = view.objects_of(Seat(0));
                own.any(|(eye, _)| is_in_sight(&self.game, (view, eye), (other, handle)))
            };
            other.objects_of(seat).filter(|&(handle, _)| is_near(handle)).count()
        });
        let seen = view.objects().count() - view.objects_of(Seat(0)).count();
        near.iter().sum::<usize>() - seen
    }

    /// Returns what else is done where seat 0 cannot see it, or so that it cannot.
    fn hidden_story(&self, cycle: u32) -> Vec<Line> {
        let mut lines = Vec::new();
        let hides = self.game.referee.rules().walls_block;
        let mut roam = |seat: Seat, but: (f64, f64), (x, y): (f64, f64), (width, height): (u32, u32)| {
            for (index, &(_, start)) in
                (0..).zip(&self.units[seat.index()]).filter(|(_, (_, start))| *start != but)
            {
                let [across, down] =
                    [(width, 3), (height, 7)].map(|(size, by)| f64::from((cycle * by + index) % size));
                lines.push((seat, start, vec![(x + across, y + down)]));
            }
        };
        if cycle % 4 == 2 && (30..).contains(&cycle) {
            roam(Seat(1), HERALD, (50.5, 0.5), (9, 7));
        }
        if hides && cycle % 40 == 2 && cycle < 100 {
            // They start in the row behind the wall, and stay in it.
            roam(Seat(2), VISITOR, (36.5, 7.5), (2, 1));
        } else if !hides && cycle % 4 == 2 && (10..100).contains(&cycle) {
            roam(Seat(2), VISITOR, (44.5, 6.5), (5, 2));
        }
        let herald = |goals: &[(f64, f64)]| (Seat(1), HERALD, goals.to_vec());
        match cycle {
            45..50 | 52..60 => lines.push(herald(&[(36.0, 3.0)])),
            80 => lines.push(herald(&[(40.0, 3.0), (38.0, 3.0), (37.0, 3.0), (36.0, 3.0)])),
            110..115 => lines.push(herald(&[(36.0, 4.25)])),
            _ => {}
        }
        lines
    }
}

/// Returns the rows of a map of 60 x 8 tiles with these blocked.
fn rows(is_blocked: impl Fn(usize, usize) -> bool) -> String {
    let tile = |x, y| if is_blocked(x, y) { '@' } else { '.' };
    (0..8).map(|y| (0..60).map(|x| tile(x, y)).chain(['\n']).collect::<String>()).collect()
}

/// Returns a match of one seat with one unit that can build.
fn builder(terrain: &str, rows: &str) -> Loaded {
    let scenario = format!(
        "name = 'tiny'\nmap = 'tiny.map'\nlength_seconds = 20\n[vision]\nterrain = '{terrain}'\n[production]\n\
         [objective]\nkind = 'resources'\n[unit.house]\nwidth = 2\nheight = 2\nspeed = 0\n\
         [unit.worker]\nradius = 0.25\nspeed = 4\nsight = 5\nbuilds = ['house']\n\
         [[seat]]\ngroups = [{{ unit = 'worker', count = 1 }}]\n"
    );
    let map = format!("type octile\nheight 8\nwidth 60\nmap\n{rows}");
    let file = |path: &str, text: String| LoadedFile { path: path.to_owned(), bytes: text.into_bytes() };
    let files = Files(vec![file("tiny.toml", scenario), file("tiny.map", map)]);
    load(&files, "tiny.toml", &Overrides::default()).unwrap()
}

fn plain() -> String {
    rows(|_, _| false)
}

/// Returns what is done in a cycle in each of the worlds.
fn told_story(cycle: u32) -> Vec<Line> {
    let herald = |goals: &[(f64, f64)]| (Seat(1), HERALD, goals.to_vec());
    match cycle {
        0 => vec![
            (Seat(0), WATCHER, vec![(36.0, 4.5)]),
            (Seat(2), VISITOR, vec![(41.5, 5.5), (38.0, 5.5)]),
            herald(&[(58.9375, 3.0), (52.0, 3.0), (36.0, 3.0)]),
        ],
        60 => vec![herald(&[(44.0, 3.0)])],
        80 => vec![herald(&[(36.0, 3.0)])],
        100 => vec![(Seat(2), VISITOR, Vec::new())],
        105 => vec![herald(&[(36.0, 4.25)])],
        115 => vec![(Seat(0), WATCHER, vec![(28.0, 4.5)])],
        _ => Vec::new(),
    }
}

/// Returns whether the object `seen` of a view is in sight of the object `eye` of another.
fn is_in_sight(game: &Game, eye: (&View, Handle), seen: (&View, Handle)) -> bool {
    let types = game.referee.rules().unit_types;
    let [(from, eye_type), (to, seen_type)] = [eye, seen].map(|(view, handle)| {
        let unit_type = view.object(handle).unwrap().unit_type;
        (view.position(handle).unwrap(), types[usize::from(unit_type.0)].clone())
    });
    let reach = eye_type.shape.radius() + seen_type.shape.radius() + eye_type.sight;
    from.distance_squared(to) <= reach * reach
}
