//! How the bots play the four ORTS games against each other; docs/BOTS.md has figures of many seeds.

use std::collections::BTreeMap;

use maniple_game::{Overrides, load};
use maniple_referee::RecordedEvent;
use maniple_view::{Command, Handle, Seat, View};

use crate::matches::{Game, shipped};

/// Cycles of the matches that are not played to their end.
const OPENING: u32 = 400;

/// Cycles in which it is counted who gathers more: a third of the match.
const HARVEST: u32 = 1600;

/// What `gather` has to deliver in these.
const GATHERED: u32 = 2500;

/// The cycle at which it has another base where the resources near the first run out.
const SECOND_BASE: u32 = 2000;

#[test]
fn rush_beats_who_does_not_fight() {
    for other in ["random", "straight"] {
        assert_eq!(wins("orts4", ["rush", other], 1..=2), 4, "against {other}");
    }
    assert_eq!(wins("orts2", ["rush", "random"], 1..=1), 2);
}

#[test]
fn focus_beats_rush_with_most_seeds() {
    let won = wins("orts4", ["focus", "rush"], 1..=3);
    assert!(won >= 5, "{won} of 6");
    let won = wins("orts2", ["focus", "rush"], 2..=3);
    assert!(won >= 3, "{won} of 4");
}

#[test]
fn gather_delivers_more_than_commander() {
    let gathered = |bot: &str| {
        let mut game = Game::new(shipped("config/scenarios/orts1.toml", Some(1)), &[bot]);
        while game.referee.cycle().0 < HARVEST && game.step() {}
        game.players[0].view.stock()
    };
    let (most, other) = (gathered("gather"), gathered("commander"));
    assert!(most >= GATHERED && most > other, "gather {most}, commander {other}");
}

#[test]
fn macro_beats_who_comes_early_and_who_comes_late_with_most_seeds() {
    for other in ["rush", "commander"] {
        let won = wins("orts3", ["macro", other], 3..=4);
        assert!(won >= 3, "{won} of 4 against {other}");
    }
}

/// With a quarter of the resources beside the first base.
#[test]
fn macro_builds_another_base_before_the_patches_of_the_first_are_empty() {
    let path = "config/scenarios/orts3.toml";
    let mut files = shipped(path, None).files;
    for file in &mut files.0 {
        let text = String::from_utf8(file.bytes.clone()).unwrap();
        file.bytes = text.replace("amount = 2000", "amount = 500").into_bytes();
    }
    let stores = |seed: u64| {
        let loaded = load(&files, path, &Overrides { seed: Some(seed), ..Overrides::default() }).unwrap();
        let store = loaded.scenario.unit_types.iter().position(|kind| kind.takes_loads);
        let mut game = Game::new(loaded, &["macro", "commander"]);
        while game.referee.cycle().0 < SECOND_BASE && game.step() {}
        let own = game.players[0].view.objects_of(Seat(0));
        own.filter(|(_, seen)| Some(usize::from(seen.unit_type.0)) == store).count()
    };
    let stores: Vec<usize> = (1..=3).map(stores).collect();
    assert!(stores.iter().any(|&count| count > 1), "{stores:?}");
}

#[test]
fn the_same_seed_gives_the_same_commands_and_nothing_is_said_again_to_who_obeys() {
    for (game, bots) in
        [("orts2", ["rush", "focus"]), ("orts3", ["macro", "macro"]), ("orts1", ["gather"; 2])]
    {
        let commands = opening(game, &bots);
        assert!(commands.len() > 20, "{game}: {}", commands.len());
        assert_eq!(commands, opening(game, &bots), "{game}");
        let mut last: BTreeMap<(Seat, Handle), (u32, &Command)> = BTreeMap::new();
        for (cycle, seat, command, rests) in &commands {
            let Some(object) = command.object() else { continue };
            let before = last.insert((*seat, object), (*cycle, command));
            let has_stopped = *rests && matches!(command, Command::Path { .. });
            let is_again =
                before.is_some_and(|(at, before)| at + 1 == *cycle && before == command) && !has_stopped;
            assert!(!is_again, "{game}: {command:?} in cycle {cycle} and the one before");
        }
    }
}

/// Returns how many matches the first bot wins, with each seed from each seat.
fn wins(name: &str, bots: [&str; 2], seeds: impl Iterator<Item = u64>) -> usize {
    let mut won = 0;
    for seed in seeds {
        for (seat, bots) in [(Seat(0), bots), (Seat(1), [bots[1], bots[0]])] {
            let mut game = Game::new(shipped(&format!("config/scenarios/{name}.toml"), Some(seed)), &bots);
            while game.step() {}
            let winners = game.referee.result().map(|result| result.winners.clone()).unwrap_or_default();
            println!("{name}, seed {seed}, {bots:?}: {winners:?}");
            won += usize::from(winners == [seat]);
        }
    }
    won
}

/// Returns the commands of the first cycles of a match with the seed 3, with the cycle, the seat, and whether the object rests.
fn opening(name: &str, bots: &[&str]) -> Vec<(u32, Seat, Command, bool)> {
    let loaded = shipped(&format!("config/scenarios/{name}.toml"), Some(3));
    let seats = loaded.scenario.seats.len();
    let mut game = Game::new(loaded, &bots[..seats]);
    let mut commands = Vec::new();
    while game.referee.cycle().0 < OPENING {
        let cycle = game.referee.cycle().0;
        let views: Vec<View> = game.players.iter().map(|player| player.view.clone()).collect();
        let rests = |seat: Seat, command: &Command| {
            let seen = command.object().and_then(|object| views[seat.index()].object(object));
            seen.is_some_and(|seen| !seen.base.is_moving())
        };
        if !game.step() {
            break;
        }
        for record in game.records.drain(..) {
            if let RecordedEvent::Commands { seat, commands: list, .. } = record {
                let with_rest = |command: Command| (cycle, seat, command.clone(), rests(seat, &command));
                commands.extend(list.into_iter().map(|sequenced| with_rest(sequenced.command)));
            }
        }
    }
    commands
}
