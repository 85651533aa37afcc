//! Whole matches in one process: shipped scenarios, bots, replays, and how matches end.

#![expect(clippy::unwrap_used, reason = "a helper that fails is a test that fails")]

use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

use maniple_bots::{Bot, bot_seed, make};
use maniple_game::{Files, Loaded, LoadedFile, Overrides, Scenario, load};
use maniple_geometry::Cycle;
use maniple_protocol::Packer;
use maniple_referee::{RecordedEvent, Referee};
use maniple_tilemap::Resolver;
use maniple_view::{
    Base, ClockMode, Command, Delta, Digest, EndReason, Handle, MatchResult, Outcome, Refusal, Rules, Seat,
    Sequenced, Stopped, View,
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
                f64::from(score.tally.arrived) >= least * f64::from(score.tally.units),
                "{path}: {:?}",
                played.result
            );
        }
    }
}

#[test]
fn a_schedule_brings_all_through_a_gap_where_reactions_bring_few() {
    let arrived = |bot| {
        let played = play(shipped("config/scenarios/choke.toml", None), &[bot]);
        played.result.scores[0].tally.arrived
    };
    assert_eq!(arrived("auto"), 100);
    for bot in ["alone", "follow", "replan"] {
        let arrived = arrived(bot);
        assert!(arrived < 50, "{bot}: {arrived}");
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
        let again = load(&files, path, &Overrides { seed: Some(8), ..Overrides::default() }).unwrap();
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

/// Every table of the example of docs/SCENARIOS.md, and what its list of keys calls it.
const TABLES: [(&str, &str); 14] = [
    ("[kinematics]", "in `[kinematics]`"),
    ("[view]", "in `[view]`"),
    ("[clock]", "in `[clock]`"),
    ("[vision]", "in `[vision]`"),
    ("[combat]", "in `[combat]`"),
    ("[harvest]", "in `[harvest]`"),
    ("[production]", ""),
    ("[modes]", ""),
    ("[neutral]", "in `[neutral]`"),
    ("[spectators]", "in `[spectators]`"),
    ("[objective]", "in `[objective]`"),
    ("[unit.worker]", "in `[unit.NAME]`"),
    ("[unit.tank.alternate]", "in `[unit.NAME.alternate]`"),
    ("[[seat]]", "in `[[seat]]`"),
];

/// The same of what the example has in braces, by how it begins.
const INLINE: [(&str, &str); 4] = [
    ("groups = [{", "in a group"),
    ("weapon = {", "in a weapon"),
    ("harvest = {", "in `[unit.NAME.harvest]`"),
    ("patch = {", "in `[unit.NAME.patch]`"),
];

#[test]
fn the_text_on_scenarios_has_an_example_that_loads_and_names_every_key() {
    let text = std::fs::read_to_string(Path::new(ROOT).join("docs/SCENARIOS.md")).unwrap();
    let example = text.split("```toml\n").nth(1).and_then(|rest| rest.split("```").next()).unwrap();
    Scenario::read("docs/SCENARIOS.md", example).unwrap();
    let in_table = TABLES
        .iter()
        .map(|(table, place)| (example.replacen(table, &format!("{table}\nno_such_key = 1"), 1), *place));
    let in_line = INLINE
        .iter()
        .map(|(start, place)| (example.replacen(start, &format!("{start} no_such_key = 1,"), 1), *place));
    let on_top = std::iter::once((format!("no_such_key = 1\n{example}"), ""));
    let generated = format!("{example}\n[generate]\nno_such_key = 1\n");
    let on_top = on_top.chain(std::iter::once((generated, "in `[generate]`")));
    let (mut keys, mut probes) = (0, 0);
    for (probe, place) in in_table.chain(in_line).chain(on_top) {
        assert_ne!(probe, example, "the example shows no key {place}");
        let message = Scenario::read("example", &probe).unwrap_err().to_string();
        let (_, known) = message.split_once("unknown field").expect("it is told that the key is unknown");
        for key in known.split('`').skip(3).step_by(2) {
            let row =
                if place.is_empty() { format!("\n| `{key}` |") } else { format!("\n| `{key}` {place} |") };
            assert!(text.contains(&row), "docs/SCENARIOS.md lacks a row{row}");
            keys += 1;
        }
        probes += 1;
    }
    assert!(probes == 20 && keys >= 89, "{probes} {keys}");
}

#[test]
fn the_text_on_scenarios_names_every_command_and_refusal() {
    let text = std::fs::read_to_string(Path::new(ROOT).join("docs/SCENARIOS.md")).unwrap();
    let known =
        |message: &str| -> Vec<String> { message.split('`').skip(3).step_by(2).map(str::to_owned).collect() };
    let commands = serde_json::from_str::<Command>("\"no_such_command\"").unwrap_err().to_string();
    let refusals = serde_json::from_str::<Refusal>("\"no_such_refusal\"").unwrap_err().to_string();
    let (commands, refusals) = (known(&commands), known(&refusals));
    assert!(commands.len() >= 14 && refusals.len() >= 20, "{commands:?} {refusals:?}");
    for name in commands.iter().chain(&refusals) {
        assert!(text.contains(&format!("\n| `{name}` |")), "docs/SCENARIOS.md lacks a row for {name}");
    }
}

#[test]
fn nobody_moves_and_the_match_ends_as_a_draw_at_its_length() {
    let played = play(tiny("", &open()), &["idle", "idle"]);
    assert_eq!(played.result.reason, EndReason::Length);
    assert_eq!((played.result.winners, played.result.cycles), (vec![], Cycle(160)));
    assert_eq!(played.hashes.len(), 161);
}

#[test]
fn who_brings_all_units_home_against_an_idle_seat_wins_at_the_length() {
    let played = play(tiny("", &open()), &["idle", "straight"]);
    assert_eq!(played.result.winners, [Seat(1)]);
    let score = &played.result.scores[1];
    assert_eq!((score.tally.arrived, score.tally.units), (3, 3));
    assert!(score.tally.arrival_sum > 0 && !score.resigned);
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
    assert_eq!((result.reason, &result.winners[..]), (EndReason::Resigned, &[Seat(1)][..]));
}

#[test]
fn a_start_lets_go_on_what_runs_and_a_queued_one_waits_for_the_arrival_too() {
    // The unit stands at (19.5, 17.9375) and goes half a unit a cycle: to the corner it takes 3.5 cycles, from there to
    // the left 4.
    let (corner, left, far) = ((19.5, 16.1875), (17.5, 16.1875), (19.5, 12.9375));
    let (up, aside, rest) = ((0.0, -0.5), (-0.5, 0.0), (0.0, 0.0));
    let object = Handle(3);
    let go = |(x, y), queue, start| Command::Move { object, x, y, s: None, queue, start };
    let path = |points: &[(f64, f64)], start| {
        let points = points.iter().map(|&(x, y)| (x, y, None)).collect();
        Command::Path { object, points, start }
    };
    let check = |case: &str, commands: &[Command], expected: &[(u32, f64, (f64, f64))]| {
        assert_eq!(motions(object, commands), expected, "{case}");
    };
    let at = |cycle, fraction| Some((Cycle(cycle), fraction));
    let turns_on_arrival = [(0, 0.0, up), (3, 0.5, aside), (7, 0.5, rest)];
    for start in [None, at(2, 0.75), at(3, 0.25)] {
        let queued = [go(corner, false, None), go(left, true, start)];
        check("queued, to start before the arrival", &queued, &turns_on_arrival);
    }
    let queued = [go(corner, false, None), go(left, true, at(5, 0.25))];
    let pauses = [(0, 0.0, up), (3, 0.5, rest), (5, 0.25, aside), (9, 0.25, rest)];
    check("queued, to start after the arrival", &queued, &pauses);
    let cut = [go(far, false, None), path(&[left, corner], at(3, 0.5))];
    let turns = [(0, 0.0, up), (3, 0.5, aside), (7, 0.5, (0.5, 0.0)), (11, 0.5, rest)];
    check("a path that starts while the unit is on its way", &cut, &turns);
    let waits = [(2, 0.25, up), (5, 0.75, aside), (9, 0.75, rest)];
    check("a path that starts while the unit rests", &[path(&[corner, left], at(2, 0.25))], &waits);
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
pub(crate) struct Game {
    pub(crate) referee: Referee,
    pub(crate) players: Vec<Player>,
    pub(crate) records: Vec<RecordedEvent>,
}

pub(crate) struct Player {
    bot: Box<dyn Bot + Send>,
    rules: Rules,
    packer: Packer,
    /// A copy of the view such as a client has.
    pub(crate) view: View,
    pub(crate) delta: Delta,
}

impl Game {
    pub(crate) fn new(loaded: Loaded, bots: &[&str]) -> Self {
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
                let view = View::new(&referee.rules(), Arc::clone(referee.terrain()));
                let (rules, packer) = (referee.rules(), Packer::new(&referee.rules()));
                Player { bot, rules, packer, view, delta: Delta::default() }
            })
            .collect();
        let mut game = Self { referee, players, records: Vec::new() };
        game.take();
        game
    }

    /// Plays a cycle; returns whether the match goes on.
    pub(crate) fn step(&mut self) -> bool {
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
            let packed = player.packer.pack(&player.delta);
            let unpacked = packed.unpack(&player.view, &player.rules).unwrap();
            assert_eq!(unpacked, player.delta);
            player.view.apply(&unpacked).unwrap();
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

/// Gives commands at the start of the tiny match; returns when its owner is told that an object went another way, and
/// with which velocity.
fn motions(object: Handle, commands: &[Command]) -> Vec<(u32, f64, (f64, f64))> {
    let mut game = Game::new(tiny("", &open()), &["idle", "idle"]);
    let list = (0..).zip(commands.to_vec()).map(|(seq, command)| Sequenced { seq, command }).collect();
    game.referee.handle_commands(Seat(0), Cycle(0), list).unwrap();
    let mut motions = Vec::new();
    for _ in 0..20 {
        game.step();
        let Delta { moved, stopped, results, .. } = &game.players[0].delta;
        assert!(
            results.iter().all(|result| matches!(result.outcome, Outcome::Applied { .. })),
            "{results:?}"
        );
        let base = |at: &Base| (at.cycle.0, at.fraction, at.velocity.into());
        motions.extend(moved.iter().filter(|moved| moved.object == object).map(|moved| base(&moved.base)));
        let rest = |stopped: &Stopped| (stopped.cycle.0, stopped.fraction, (0.0, 0.0));
        motions.extend(stopped.iter().filter(|stopped| stopped.object == object).map(rest));
    }
    motions
}

fn drain(referee: &mut Referee) {
    referee.take_records();
    for seat in [Seat(0), Seat(1)] {
        referee.take_delta(seat);
    }
}

/// The files of the repository.
struct Disk;

impl Resolver for Disk {
    fn resolve(&self, path: &str) -> Result<Vec<u8>, String> {
        std::fs::read(Path::new(ROOT).join(path)).map_err(|error| error.to_string())
    }
}

pub(crate) fn shipped(path: &str, seed: Option<u64>) -> Loaded {
    load(&Disk, path, &Overrides { seed, ..Overrides::default() }).unwrap_or_else(|error| panic!("{error}"))
}

/// Returns a match of two seats with three scouts each and 160 cycles.
pub(crate) fn tiny(tables: &str, rows: &str) -> Loaded {
    scouts(tables, rows, &[3, 3])
}

/// Returns a match of 160 cycles with so many scouts of each seat.
pub(crate) fn scouts(tables: &str, rows: &str, counts: &[usize]) -> Loaded {
    let groups: Vec<(&str, usize)> = counts.iter().map(|&count| ("scout", count)).collect();
    scouts_and(tables, rows, &groups)
}

/// Returns a match of 160 cycles with so many units of one type of each seat: scouts, or what the tables have.
pub(crate) fn scouts_and(tables: &str, rows: &str, groups: &[(&str, usize)]) -> Loaded {
    let group = |(unit, count): &(&str, usize)| {
        format!("[[seat]]\ngroups = [{{ unit = '{unit}', count = {count} }}]\n")
    };
    let seats = groups.iter().map(group);
    let scenario = format!(
        "name = 'tiny'\nmap = 'tiny.map'\nlength_seconds = 20\n{tables}\n[objective]\nkind = 'race'\nzone_size = 4\n\
         [unit.scout]\nradius = 0.25\nspeed = 4\nsight = 3\n{}",
        seats.collect::<String>()
    );
    let (width, height) = (rows.lines().next().map_or(0, str::len), rows.lines().count());
    let map = format!("type octile\nheight {height}\nwidth {width}\nmap\n{rows}");
    let file = |path: &str, text: String| LoadedFile { path: path.to_owned(), bytes: text.into_bytes() };
    let files = Files(vec![file("tiny.toml", scenario), file("tiny.map", map)]);
    load(&files, "tiny.toml", &Overrides::default()).unwrap()
}

/// Returns the rows of an open map, 24 by 24.
pub(crate) fn open() -> String {
    format!("{}\n", ".".repeat(24)).repeat(24)
}
