//! Whole matches in one process: shipped scenarios, bots, replays, fog, and how matches end.

#![expect(clippy::unwrap_used, reason = "a helper that fails is a test that fails")]

use std::path::Path;
use std::time::Duration;

use maniple_bots::{Bot, bot_seed, make};
use maniple_game::{Files, Loaded, LoadedFile, Scenario, load};
use maniple_geometry::Cycle;
use maniple_referee::{RecordedEvent, Referee};
use maniple_tilemap::Resolver;
use maniple_view::{
    ClockMode, Command, Delta, Digest, EndReason, Handle, MatchResult, Outcome, Refusal, Seat, Sequenced,
    View,
};

const ROOT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../..");

/// The scenarios that ship with Maniple, and the smallest part of its units that `straight` brings into each zone.
const SHIPPED: [(&str, f64); 3] = [
    ("config/scenarios/caves.toml", 0.75),
    ("config/scenarios/diamond.toml", 0.75),
    ("config/scenarios/duel.toml", 0.75),
];

#[test]
fn straight_brings_most_units_home_in_each_shipped_scenario() {
    for (path, least) in SHIPPED {
        let played = play(shipped(path, None), &["straight", "straight"]);
        for score in &played.result.scores {
            println!("{path}: {score:?} after {}", played.result.cycles);
            assert!(
                f64::from(score.arrived) >= least * f64::from(score.units),
                "{path}: {:?}",
                played.result
            );
        }
    }
}

#[test]
fn the_same_seed_gives_the_same_match_and_another_seed_another() {
    for (path, _) in SHIPPED {
        let bots = ["random", "straight"];
        let first = play(shipped(path, Some(5)), &bots);
        let second = play(shipped(path, Some(5)), &bots);
        assert_eq!(first.hashes, second.hashes, "{path}");
        assert_eq!(first.result, second.result, "{path}");
        let other = play(shipped(path, Some(6)), &bots);
        assert_ne!(first.result.hash, other.result.hash, "{path}");
    }
}

#[test]
fn a_match_is_played_again_from_its_files_and_records_alone() {
    for (path, _) in SHIPPED {
        let loaded = shipped(path, Some(8));
        let files = loaded.files.clone();
        let played = play(loaded, &["straight", "random"]);
        let again = load(&files, path, None, Some(8)).unwrap();
        let mut referee = Referee::new(again, ClockMode::Realtime).unwrap();
        for record in &played.records {
            referee.handle_record(record).unwrap();
        }
        assert_eq!(referee.result(), Some(&played.result), "{path}");
    }
}

#[test]
fn every_shipped_scenario_names_bots_that_exist() {
    for (path, _) in SHIPPED {
        for seat in &shipped(path, None).scenario.seats {
            let name = seat.bot.as_deref().expect("a shipped scenario can be played by bots alone");
            assert!(make(name, 0).is_ok(), "{path}: {name}");
        }
    }
}

#[test]
fn the_text_on_scenarios_has_an_example_that_loads_and_names_every_key() {
    let text = std::fs::read_to_string(Path::new(ROOT).join("docs/SCENARIOS.md")).unwrap();
    let example = text.split("```toml\n").nth(1).and_then(|rest| rest.split("```").next()).unwrap();
    Scenario::read("docs/SCENARIOS.md", example).unwrap();
    let tables = ["[kinematics]", "[clock]", "[vision]", "[objective]", "[unit.scout]", "[[seat]]"];
    let mut probes: Vec<String> =
        tables.iter().map(|table| example.replacen(table, &format!("{table}\nno_such_key = 1"), 1)).collect();
    probes.push(format!("no_such_key = 1\n{example}"));
    probes.push(example.replacen("{ unit", "{ no_such_key = 1, unit", 1));
    for probe in probes {
        let message = Scenario::read("example", &probe).unwrap_err().to_string();
        let (_, known) = message.split_once("expected ").expect("an unknown key is told with the known ones");
        for key in known.split('`').skip(1).step_by(2) {
            assert!(text.contains(&format!("\n| `{key}`")), "{key} is not in the table");
        }
    }
}

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

#[test]
fn nobody_moves_and_the_match_ends_as_a_draw_at_its_length() {
    let played = play(tiny("", &open()), &["idle", "idle"]);
    assert_eq!(played.result.reason, EndReason::Length);
    assert_eq!((played.result.winner, played.result.cycles), (None, Cycle(160)));
    assert_eq!(played.hashes.len(), 161);
}

#[test]
fn who_brings_all_units_home_against_an_idle_seat_wins_at_the_length() {
    let played = play(tiny("", &open()), &["idle", "straight"]);
    assert_eq!(played.result.winner, Some(Seat(1)));
    let score = &played.result.scores[1];
    assert_eq!((score.arrived, score.units), (3, 3));
    assert!(score.arrival_sum > 0 && !score.resigned);
}

#[test]
fn two_racers_that_arrive_end_the_match_before_its_length() {
    let played = play(tiny("", &open()), &["straight", "straight"]);
    assert_eq!(played.result.reason, EndReason::Objective, "{:?}", played.result);
    assert!(played.result.cycles < Cycle(160));
}

#[test]
fn who_resigns_loses_and_is_refused_from_then_on() {
    let mut game = Game::new(tiny("", &open()), &["idle", "straight"]);
    for _ in 0..10 {
        assert!(game.step());
    }
    let seen = game.referee.cycle();
    let list = vec![
        Sequenced { seq: 1, command: Command::Resign },
        Sequenced { seq: 2, command: Command::Stop { object: Handle(0) } },
    ];
    game.referee.handle_commands(Seat(0), seen, list).unwrap();
    assert!(!game.step());
    let results = &game.players[0].delta.results;
    assert_eq!(results[0].outcome, Outcome::Applied { cycle: seen, late: 0 });
    assert_eq!(results[1].outcome, Outcome::Refused { reason: Refusal::Out });
    assert_eq!(game.players[0].delta.died.len(), 3);
    assert_eq!(game.players[1].delta.died.len(), 3);
    let result = game.referee.result().unwrap();
    assert_eq!((result.reason, result.winner), (EndReason::Resigned, Some(Seat(1))));
}

#[test]
fn a_seat_that_stalls_is_skipped_or_forfeited_on_a_virtual_clock() {
    let check = |stall: &str, expected: EndReason| {
        let clock = format!("clock = {{ time_bank_seconds = 1, stall = '{stall}' }}");
        let mut referee = Referee::new(tiny(&clock, &open()), ClockMode::Lockstep).unwrap();
        for seat in [Seat(0), Seat(1)] {
            referee.handle_join(seat, "player").unwrap();
        }
        let mut now = Duration::ZERO;
        while referee.result().is_none() {
            referee.handle_done(Seat(0), referee.cycle());
            if let Some(timeout) = referee.poll_timeout() {
                assert!(!referee.is_ready());
                assert!(timeout > now);
                now = timeout;
                referee.handle_time(now);
            }
            assert!(referee.is_ready());
            drain(&mut referee);
            referee.step();
        }
        let result = referee.result().unwrap();
        assert_eq!(result.reason, expected, "{stall}");
        assert_eq!(result.scores[1].resigned, stall == "forfeit");
        // A full bank of a second, then each of the other cycles as long as in real time.
        let cycles = result.cycles.0;
        let expected = Duration::from_secs(1) + (cycles - 1) * Duration::from_millis(125);
        assert_eq!(now, expected, "{stall}");
    };
    check("skip", EndReason::Length);
    check("forfeit", EndReason::Resigned);
}

/// A match and the bots that play it.
struct Game {
    referee: Referee,
    players: Vec<Player>,
    records: Vec<RecordedEvent>,
}

struct Player {
    bot: Box<dyn Bot + Send>,
    /// A copy of the view such as a client has.
    view: View,
    delta: Delta,
}

impl Game {
    fn new(loaded: Loaded, bots: &[&str]) -> Self {
        let seed = loaded.scenario.seed;
        let mut referee = Referee::new(loaded, ClockMode::Lockstep).unwrap();
        assert_eq!(referee.seats(), bots.len());
        let seats = || (0..).map(Seat);
        for (seat, bot) in seats().zip(bots) {
            referee.handle_join(seat, bot).unwrap();
        }
        let players = seats()
            .zip(bots)
            .map(|(seat, name)| {
                let mut bot = make(name, bot_seed(seed, seat)).unwrap();
                bot.on_start(seat, &referee.rules(), referee.terrain());
                Player { bot, view: View::new(), delta: Delta::default() }
            })
            .collect();
        let mut game = Self { referee, players, records: Vec::new() };
        game.take();
        game
    }

    /// Plays a cycle; returns whether the match goes on.
    fn step(&mut self) -> bool {
        for (seat, player) in (0..).map(Seat).zip(&mut self.players) {
            let cycle = player.view.cycle();
            let commands = player.bot.on_cycle(&player.view, &player.delta);
            let numbered = (0..).zip(commands).map(|(seq, command)| Sequenced { seq, command }).collect();
            self.referee.handle_commands(seat, cycle, numbered).unwrap();
            self.referee.handle_done(seat, cycle);
        }
        assert!(self.referee.is_ready());
        self.referee.step();
        self.take();
        self.referee.result().is_none()
    }

    /// Takes out what the step made; the views of both sides have to be the same.
    fn take(&mut self) {
        self.records.append(&mut self.referee.take_records());
        for (seat, player) in (0..).map(Seat).zip(&mut self.players) {
            player.delta = self.referee.take_delta(seat).expect("each step makes a delta");
            player.view.apply(&player.delta).unwrap();
            assert_eq!(&player.view, self.referee.view(seat));
        }
    }
}

struct Played {
    result: MatchResult,
    hashes: Vec<Digest>,
    records: Vec<RecordedEvent>,
}

fn play(loaded: Loaded, bots: &[&str]) -> Played {
    let mut game = Game::new(loaded, bots);
    while game.step() {}
    let hash = |record: &RecordedEvent| {
        if let RecordedEvent::Hash { hash, .. } = record { Some(*hash) } else { None }
    };
    Played {
        result: game.referee.result().unwrap().clone(),
        hashes: game.records.iter().filter_map(hash).collect(),
        records: game.records,
    }
}

fn drain(referee: &mut Referee) {
    referee.take_records();
    for seat in [Seat(0), Seat(1)] {
        referee.take_delta(seat);
    }
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

/// The files of the repository.
struct Disk;

impl Resolver for Disk {
    fn resolve(&self, path: &str) -> Result<Vec<u8>, String> {
        std::fs::read(Path::new(ROOT).join(path)).map_err(|error| error.to_string())
    }
}

fn shipped(path: &str, seed: Option<u64>) -> Loaded {
    load(&Disk, path, None, seed).unwrap_or_else(|error| panic!("{error}"))
}

/// Returns a match of two seats with three scouts each and 160 cycles.
fn tiny(tables: &str, rows: &str) -> Loaded {
    let scenario = format!(
        "name = 'tiny'\nmap = 'tiny.map'\nlength_seconds = 20\n{tables}\n[objective]\nkind = 'race'\nzone_size = 4\n\
         [unit.scout]\nradius = 0.25\nspeed = 4\nsight = 3\n\
         [[seat]]\ngroups = [{{ unit = 'scout', count = 3 }}]\n\
         [[seat]]\ngroups = [{{ unit = 'scout', count = 3 }}]\n"
    );
    let (width, height) = (rows.lines().next().map_or(0, str::len), rows.lines().count());
    let map = format!("type octile\nheight {height}\nwidth {width}\nmap\n{rows}");
    let file = |path: &str, text: String| LoadedFile { path: path.to_owned(), bytes: text.into_bytes() };
    let files = Files(vec![file("tiny.toml", scenario), file("tiny.map", map)]);
    load(&files, "tiny.toml", None, None).unwrap()
}

/// Returns the rows of an open map, 24 by 24.
fn open() -> String {
    format!("{}\n", ".".repeat(24)).repeat(24)
}
