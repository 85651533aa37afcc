//! The four ORTS games, as the bots play them that the scenarios name.

use std::collections::{BTreeMap, BTreeSet};

use maniple_referee::RecordedEvent;
use maniple_view::{Command, EndReason, MatchResult, Outcome, Seat};

use crate::commands::{folder, json};
use crate::matches::{Game, shipped};

/// How many seeds of each game are played, from 1 on.
const SEEDS: u64 = 20;

/// How many of them the objective has to decide before the time is up.
const DECIDED: usize = 15;

/// What one seat has to gather in the first game, with each seed.
const GATHERED: u64 = 2000;

#[test]
fn orts1_gathers_enough_with_each_seed() {
    let played = play("orts1");
    for (seed, result) in (1..).zip(&played.results) {
        let gathered = result.scores[0].tally.gathered;
        assert!(gathered >= GATHERED, "seed {seed}: {gathered}");
        assert_eq!(result.winners, [Seat(0)], "seed {seed}");
    }
    assert_commands(&played, &["path", "gather", "return_load"]);
}

#[test]
fn orts2_is_decided_by_its_objective_before_time() {
    let played = play("orts2");
    assert_decided(&played);
    assert_commands(&played, &["attack", "attack_move", "path"]);
}

#[test]
fn orts3_is_decided_by_its_objective_before_time() {
    let played = play("orts3");
    assert_decided(&played);
    let fights = ["attack", "attack_at", "attack_move", "hold", "switch"];
    let works = ["path", "gather", "return_load", "build", "train"];
    assert_commands(&played, &[&fights[..], &works[..]].concat());
}

#[test]
fn orts4_is_decided_by_its_objective_before_time() {
    let played = play("orts4");
    assert_decided(&played);
    assert_commands(&played, &["attack", "attack_at", "attack_move", "switch"]);
}

#[test]
fn replays_of_the_four_games_verify() {
    let folder = folder("orts");
    for name in ["orts1", "orts2", "orts3", "orts4"] {
        let replay = folder.join(format!("{name}.replay")).display().to_string();
        let scenario = format!("{}/config/scenarios/{name}.toml", crate::commands::ROOT);
        let played = json(&["match", &scenario, "--seed", "7", "--replay", &replay, "--json"]);
        let verdict = json(&["replay", "verify", &replay, "--json"]);
        assert_eq!((&verdict["verified"], &verdict["hash"]), (&true.into(), &played["hash"]), "{name}");
    }
}

#[test]
fn each_seed_has_a_map_of_its_own() {
    let hashes: BTreeSet<u64> =
        (1..=SEEDS).map(|seed| shipped("config/scenarios/orts2.toml", Some(seed)).map.hash()).collect();
    assert_eq!(hashes.len(), usize::try_from(SEEDS).unwrap());
}

/// The matches of a game.
struct Played {
    /// By seed, from 1 on.
    results: Vec<MatchResult>,
    /// How many commands of each name were applied, and how many refused, in all.
    commands: BTreeMap<String, (u64, u64)>,
}

fn play(name: &str) -> Played {
    let mut played = Played { results: Vec::new(), commands: BTreeMap::new() };
    for seed in 1..=SEEDS {
        let loaded = shipped(&format!("config/scenarios/{name}.toml"), Some(seed));
        let bots: Vec<String> =
            loaded.scenario.seats.iter().map(|seat| seat.bot.clone().expect("it names a bot")).collect();
        let bots: Vec<&str> = bots.iter().map(String::as_str).collect();
        let mut game = Game::new(loaded, &bots);
        while game.step() {
            count(&mut game, &mut played.commands);
        }
        let result = game.referee.result().unwrap().clone();
        println!("{name}, seed {seed}: {:?} {:?} after {}", result.winners, result.reason, result.cycles);
        played.results.push(result);
    }
    println!("{name}: {:?}", played.commands);
    played
}

/// Counts the commands of the last cycle by name and outcome.
fn count(game: &mut Game, commands: &mut BTreeMap<String, (u64, u64)>) {
    let mut given: BTreeMap<Seat, Vec<Command>> = BTreeMap::new();
    for record in game.records.drain(..) {
        if let RecordedEvent::Commands { seat, commands, .. } = record {
            given.entry(seat).or_default().extend(commands.into_iter().map(|sequenced| sequenced.command));
        }
    }
    for (seat, player) in (0..).map(Seat).zip(&game.players) {
        let given = given.remove(&seat).unwrap_or_default();
        assert_eq!(given.len(), player.delta.results.len());
        for (command, result) in given.iter().zip(&player.delta.results) {
            let counted = commands.entry(name(command)).or_default();
            match result.outcome {
                Outcome::Applied { .. } => counted.0 += 1,
                Outcome::Refused { .. } => counted.1 += 1,
            }
        }
    }
}

/// Returns the name of a command in the protocol.
fn name(command: &Command) -> String {
    let value = serde_json::to_value(command).unwrap();
    let key = value.as_object().and_then(|object| object.keys().next().cloned());
    key.or_else(|| value.as_str().map(str::to_owned)).unwrap()
}

fn assert_decided(played: &Played) {
    let decided = played.results.iter().filter(|result| result.reason == EndReason::Objective).count();
    assert!(decided >= DECIDED, "{decided} of {SEEDS} were decided");
    let winners: BTreeSet<Vec<Seat>> = played.results.iter().map(|result| result.winners.clone()).collect();
    assert!(winners.contains(&vec![Seat(0)]) && winners.contains(&vec![Seat(1)]), "one seat always wins");
}

/// Each of these was used, and nearly all commands made sense.
fn assert_commands(played: &Played, names: &[&str]) {
    for &name in names {
        assert!(played.commands.get(name).is_some_and(|counted| counted.0 > 0), "nobody was told to {name}");
    }
    let (applied, refused) = played.commands.values().fold((0, 0), |sum, it| (sum.0 + it.0, sum.1 + it.1));
    assert!(refused * 100 <= applied, "{refused} refused, {applied} applied");
}
