//! Spectators: they get what a seat got or everything, byte for byte, some cycles later, and nothing younger.

#![allow(clippy::unwrap_used, reason = "a helper that fails is a test that fails")]

use std::io::{BufRead, BufReader};
use std::process::{Child, Stdio};

use maniple_client::{ClientError, Event, Spectator};
use maniple_game::Loaded;
use maniple_geometry::Cycle;
use maniple_protocol::{ClientMessage, Encoding, Refused, ServerMessage};
use maniple_referee::WatchError;
use maniple_view::{
    ClockMode, Command, Delta, Handle, MatchResult, Seat, Seen, Sequenced, Sighting, Vantage, View,
};
use tokio::io::AsyncWriteExt;
use tokio::net::TcpSocket;

use crate::arena::{Arena, loaded, tiny};
use crate::commands::{fails, file, folder, maniple, run, serve};
use crate::matches::{Game, open, shipped};
use crate::network::ping_until_closed;
use crate::show::{Show, Tap, hello, opening, watch};

/// Cycles by which spectators are behind.
const DELAY: u32 = 8;

/// All views may be watched, a second behind.
const WATCHED: &str = "rate = 8\nlength_seconds = 30\nclock = { time_bank_seconds = 3600 }\n\
                       spectators = { views = 'all', delay_seconds = 1 }";

const A: Vantage = Vantage::Seat(Seat(0));
const B: Vantage = Vantage::Seat(Seat(1));

#[test]
fn a_stand_shows_what_the_seat_was_told_and_how_its_view_was() {
    for (mut game, cycles) in whole_games() {
        for vantage in [A, B] {
            game.referee.open_stand(vantage, DELAY);
        }
        // By seat and cycle.
        let mut told: [Vec<Delta>; 2] = [vec![], vec![]];
        let mut views: [Vec<View>; 2] = [vec![], vec![]];
        let mut late: Option<View> = None;
        for cycle in 0..cycles {
            for (seat, player) in game.players.iter().enumerate() {
                told[seat].push(player.delta.clone());
                views[seat].push(player.view.clone());
                let stand = game.referee.stand(Vantage::Seat(Seat(seat.try_into().unwrap()))).unwrap();
                let Some(then) = cycle.checked_sub(DELAY as usize) else {
                    assert!(stand.shown().is_empty() && stand.keyframe().is_none());
                    continue;
                };
                assert_eq!(stand.shown(), &told[seat][then..=then], "seat {seat}, cycle {cycle}");
                assert_eq!(stand.view(), &views[seat][then]);
                assert_eq!(stand.cycle().0 as usize, then);
                // Who comes in the middle goes on from the keyframe.
                if seat == 1 && cycle >= cycles / 2 {
                    match &mut late {
                        None => {
                            let mut view = at_the_start(&game, B);
                            view.apply(&stand.keyframe().unwrap()).unwrap();
                            late = Some(view);
                        }
                        Some(view) => view.apply(&stand.shown()[0]).unwrap(),
                    }
                    assert_eq!(late.as_ref(), Some(&views[1][then]));
                }
            }
            assert!(game.step(), "the game lasts longer");
        }
    }
}

#[test]
fn everything_holds_each_object_as_it_is_and_what_only_its_owner_knows() {
    let (mut hidden, mut died, mut shots) = (0, 0, 0);
    for (mut game, cycles) in whole_games() {
        game.referee.open_stand(Vantage::Everything, 0);
        let mut view = at_the_start(&game, Vantage::Everything);
        for cycle in 0..cycles {
            let stand = game.referee.stand(Vantage::Everything).unwrap();
            let [delta] = stand.shown() else { panic!("a delta a cycle") };
            view.apply(delta).unwrap();
            assert_eq!(&view, stand.view());
            assert!(view.is_visible(0, 0) && view.terrain().tile(0, 0).is_some());
            let objects = game.referee.world().objects();
            assert_eq!(view.objects().count(), objects.len(), "cycle {cycle}");
            for object in objects {
                let is_it = |(_, seen): (Handle, &Seen)| is_told_of(object, seen, view.cycle());
                assert!(view.objects().any(is_it), "cycle {cycle}: {object:?}");
            }
            hidden = hidden.max(objects.len() - game.players[0].view.objects().count());
            (died, shots) = (died + delta.died.len(), shots + delta.shots.len());
            assert!(game.step(), "the game lasts longer");
        }
    }
    assert!(hidden > 10 && died > 10 && shots > 10, "{hidden} {died} {shots}");
}

#[tokio::test(flavor = "multi_thread")]
async fn spectators_get_the_very_bytes_of_a_seat_later_and_nothing_younger() {
    let scenario = loaded(WATCHED);
    let mut show = Show::open(&scenario).await;
    let mut early = Vec::new();
    for vantage in [A, B, Vantage::Everything] {
        for encoding in [Encoding::Json, Encoding::Binary] {
            early.push(Tap::watch(&show.arena, encoding, vantage).await);
        }
    }
    for tap in &early {
        assert_eq!((tap.welcome.cycle.0, tap.welcome.delay), (0, Some(DELAY)));
    }
    show.play_to(3).await;
    for tap in &mut early {
        assert_eq!(tap.news().await, [] as [u32; 0], "the match is younger than the delay");
    }
    show.play_to(20).await;
    for tap in &mut early {
        assert_eq!(tap.news().await, (0..=20 - DELAY).collect::<Vec<u32>>());
    }
    show.play_to(21).await;
    let mut late = Vec::new();
    for (vantage, encoding) in
        [(A, Encoding::Json), (B, Encoding::Binary), (Vantage::Everything, Encoding::Json)]
    {
        let mut tap = Tap::watch(&show.arena, encoding, vantage).await;
        assert_eq!(tap.welcome.cycle.0, 21 - DELAY);
        assert_eq!(tap.news().await, [21 - DELAY], "it begins with the keyframe");
        if let Some(seat) = vantage.seat() {
            assert_eq!(tap.view, show.views[seat.index()][21 - DELAY as usize]);
        }
        late.push(tap);
    }
    show.pause().await;
    for tap in early.iter_mut().chain(&mut late) {
        let expected: &[u32] = if tap.told.len() > 1 { &[21 - DELAY] } else { &[] };
        assert_eq!(tap.news().await, expected, "nothing is told of a pause");
    }
    show.go_on().await;
    early.extend(late);
    let (told, views, outcome) = show.play_out(&mut early).await;
    for mut tap in early {
        tap.read_to_the_end().await;
        let what = format!("{:?} {}", tap.encoding, tap.vantage);
        assert_eq!(tap.result, outcome.result, "{what}");
        let Some(seat) = tap.vantage.seat() else { continue };
        assert_eq!(Some(&tap.view), views[seat.index()].last(), "{what}");
        // A seat's connection has one encoding; the other is that of the same deltas.
        if (seat == Seat(0)) == (tap.encoding == Encoding::Json) {
            let first = told[seat.index()].len() - tap.told.len();
            let skip = usize::from(first > 0);
            check_bytes(&told[seat.index()][first + skip..], &tap.told[skip..], &what);
        }
    }
}

/// Compares what a seat was told with what a spectator was.
fn check_bytes(seat: &[Vec<u8>], spectator: &[Vec<u8>], what: &str) {
    let differs = seat.iter().zip(spectator).position(|(one, other)| one != other);
    if let Some(place) = differs {
        let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
        panic!("{what}, message {place}: {} and {}", text(&seat[place]), text(&spectator[place]));
    }
    assert_eq!(seat.len(), spectator.len(), "{what}");
}

#[tokio::test(flavor = "multi_thread")]
async fn so_they_do_on_a_grid() {
    let scenario = loaded(&format!("{WATCHED}\nview = {{ positions = 'grid', grid_bits = 8 }}"));
    let show = Show::open(&scenario).await;
    let mut taps = Vec::new();
    for (vantage, encoding) in
        [(A, Encoding::Json), (B, Encoding::Binary), (Vantage::Everything, Encoding::Binary)]
    {
        taps.push(Tap::watch(&show.arena, encoding, vantage).await);
    }
    let (told, views, _) = show.play_out(&mut taps).await;
    for mut tap in taps {
        tap.read_to_the_end().await;
        if let Some(seat) = tap.vantage.seat() {
            check_bytes(&told[seat.index()], &tap.told, &tap.vantage.to_string());
            assert_eq!(Some(&tap.view), views[seat.index()].last());
        }
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn a_replay_prints_the_very_messages_of_a_seat_and_of_who_watched_everything() {
    let folder = folder("replay_view");
    let mut show = Show::open(&loaded(WATCHED)).await;
    let everything = Tap::watch(&show.arena, Encoding::Json, Vantage::Everything).await;
    show.play_to(1).await;
    let mut watching = [everything];
    let (told, _, outcome) = show.play_out(&mut watching).await;
    let [mut everything] = watching;
    everything.read_to_the_end().await;
    let path = folder.join("show.replay").display().to_string();
    std::fs::write(&path, &outcome.replay).unwrap();
    let printed = |arguments: &[&str]| {
        let output = run(&[&["replay", "view", &path], arguments].concat());
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        String::from_utf8(output.stdout).unwrap()
    };
    let text = |bodies: &[Vec<u8>]| -> Vec<String> {
        bodies.iter().map(|body| String::from_utf8(body.clone()).unwrap()).collect()
    };
    let of_a = printed(&["--seat", "0", "--json"]);
    let mut lines: Vec<&str> = of_a.lines().collect();
    let end = lines.pop().unwrap();
    assert_eq!(lines, text(&told[0]));
    assert!(end.starts_with("{\"ended\":"), "{end}");
    let of_all = printed(&["--json"]);
    assert_eq!(of_all.lines().take(everything.told.len()).collect::<Vec<_>>(), text(&everything.told));

    let piece = printed(&["--seat", "0", "--from", "5", "--to", "9", "--json"]);
    let piece: Vec<&str> = piece.lines().collect();
    assert_eq!(piece.len(), 5);
    assert_eq!(piece[1..], text(&told[0][6..10]));
    let ServerMessage::Delta(keyframe) = serde_json::from_str(piece[0]).unwrap() else {
        panic!("{}", piece[0])
    };
    let appeared = |cycle: usize| keyframe.appeared.len() >= 5 && keyframe.cycle.0 as usize == cycle;
    assert!(appeared(5), "{}", piece[0]);

    // Whoever reads no more, as `head`, ends it.
    let mut child = maniple(&["replay", "view", &path]).stdout(Stdio::piped()).spawn().unwrap();
    let mut first = String::new();
    BufReader::new(child.stdout.take().unwrap()).read_line(&mut first).unwrap();
    assert!(first.starts_with("cycle 0: 10 objects") && child.wait().unwrap().success(), "{first}");

    let lines = printed(&["--seat", "1", "--to", "2"]);
    assert_eq!(lines.lines().count(), 3);
    assert!(lines.starts_with("cycle 0: 5 objects; 5 appeared\n"), "{lines}");
    let error = fails(&["replay", "view", &path, "--seat", "2"], 2);
    assert!(error.contains("seats 0 to 1"), "{error}");
    let error = fails(&["replay", "view", &path, "--from", "9999"], 2);
    assert!(error.contains("cycles 0 to"), "{error}");
    fails(&["replay", "view", &path, "--from", "3", "--to", "2"], 2);

    // A picture of what a seat saw is another one than that of all there was.
    let picture = |arguments: &[&str]| {
        let out = folder.join("picture.png").display().to_string();
        let all = [&["replay", "render", &path, "--cycle", "9", "--out", &out], arguments].concat();
        assert!(run(&all).status.success());
        std::fs::read(out).unwrap()
    };
    let pictures = [picture(&[]), picture(&["--seat", "0"]), picture(&["--seat", "1"])];
    assert!(pictures[0] != pictures[1] && pictures[1] != pictures[2] && pictures[0] != pictures[2]);
    let error = fails(&["replay", "render", &path, "--cycle", "9", "--seat", "2", "--out", "x.png"], 2);
    assert!(error.contains("seats 0 to 1"), "{error}");
}

#[tokio::test(flavor = "multi_thread")]
async fn what_the_scenario_does_not_permit_is_refused() {
    let clock = "rate = 8\nlength_seconds = 30\nclock = { time_bank_seconds = 3600 }";
    let seats = format!("{clock}\nspectators = {{ views = 'seats' }}");
    let seat = |seat| Vantage::Seat(Seat(seat));
    let all = Vantage::Everything;
    let cases = [
        (clock, A, Some(Refused::NoSpectators)),
        (clock, all, Some(Refused::NoSpectators)),
        (&seats, B, None),
        (&seats, all, Some(Refused::SeatsOnly)),
        (&seats, seat(2), Some(Refused::NoSuchSeat { seats: 2 })),
        (WATCHED, all, None),
        (WATCHED, seat(u16::MAX), Some(Refused::NoSuchSeat { seats: 2 })),
    ];
    for (scenario, view, expected) in cases {
        let arena = Arena::open(&loaded(scenario), ClockMode::Lockstep);
        let found = match Spectator::watch(&arena.address, "suite", view).await {
            Ok(_) => None,
            Err(ClientError::Refused(reason)) => Some(reason),
            Err(error) => panic!("{error}"),
        };
        assert_eq!(found, expected, "{view}");
        arena.shut_down().await;
    }
    // A referee that nobody was asked to open is not watched at all.
    let game = Game::new(loaded(WATCHED), &["idle", "idle"]);
    assert_eq!(game.referee.stand(A).err(), Some(WatchError::NotPermitted));
}

#[tokio::test(flavor = "multi_thread")]
async fn a_spectator_has_no_say_and_holds_nobody_up() {
    let show = Show::open(&loaded(WATCHED)).await;
    let commands = ClientMessage::Commands {
        seen_cycle: Default::default(),
        list: vec![Sequenced { seq: 1, command: Command::Stop { object: Handle(0) } }],
    };
    let done = ClientMessage::Done { cycle: Default::default() };
    let pause = ClientMessage::Pause { on: true };
    let hello = ClientMessage::Hello(hello(&show.arena, 0));
    let cases = [
        (commands, Refused::Spectator),
        (ClientMessage::Commands { seen_cycle: Default::default(), list: vec![] }, Refused::Spectator),
        (done, Refused::Spectator),
        (pause, Refused::Spectator),
        (hello, Refused::Handshake),
    ];
    for encoding in [Encoding::Json, Encoding::Binary] {
        for (message, expected) in &cases {
            let mut tap = Tap::watch(&show.arena, encoding, A).await;
            tap.say(message).await;
            // So that it is answered even if the message is not.
            tap.say(&ClientMessage::Ping { id: 1 }).await;
            let (_, answer) = tap.next().await.unwrap();
            assert_eq!(answer, ServerMessage::Refused { reason: expected.clone() });
        }
    }
    // One that reads nothing is cut off, and the match plays on as if it were not there.
    let socket = TcpSocket::new_v4().unwrap();
    socket.set_recv_buffer_size(4096).unwrap();
    let mut deaf = socket.connect(show.arena.address.parse().unwrap()).await.unwrap();
    deaf.write_all(&opening(Encoding::Json, &watch(A))).await.unwrap();
    ping_until_closed(&mut deaf).await;
    let expected = headless(&loaded(WATCHED));
    assert_eq!(show.play_out(&mut []).await.2.result.unwrap().hash, expected.hash);
}

#[tokio::test(flavor = "multi_thread")]
async fn what_is_held_back_of_a_match_that_is_broken_off_is_never_told() {
    let mut show = Show::open(&loaded(WATCHED)).await;
    let mut tap = Tap::watch(&show.arena, Encoding::Binary, Vantage::Everything).await;
    show.play_to(12).await;
    assert_eq!(tap.news().await, (0..=12 - DELAY).collect::<Vec<u32>>());
    show.arena.shut_down().await;
    let (_, last) = tap.next().await.unwrap();
    assert_eq!(last, ServerMessage::Refused { reason: Refused::Shutdown });
}

#[tokio::test(flavor = "multi_thread")]
async fn there_is_an_end_to_the_number_of_spectators() {
    let arena = Arena::open_with(&loaded(WATCHED), ClockMode::Lockstep, |game| game.watched_by_at_most(64));
    let mut joining = tokio::task::JoinSet::new();
    for _ in 0..=64 {
        let address = arena.address.clone();
        joining.spawn(async move { Spectator::watch(&address, "suite", A).await });
    }
    let (mut watching, mut refused) = (Vec::new(), Vec::new());
    while let Some(joined) = joining.join_next().await {
        match joined.unwrap() {
            Ok(spectator) => watching.push(spectator),
            Err(ClientError::Refused(reason)) => refused.push(reason),
            Err(error) => panic!("{error}"),
        }
    }
    let full = Refused::SpectatorsFull { limit: 64 };
    assert_eq!(refused, std::slice::from_ref(&full));
    let another = Spectator::watch(&arena.address, "suite", B).await.err();
    assert!(matches!(another, Some(ClientError::Refused(reason)) if reason == full));
    drop(watching.pop());
    // Until the server has noticed that one is gone, it says the same again.
    while Spectator::watch(&arena.address, "suite", A).await.is_err() {}
    arena.shut_down().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn the_client_mirrors_a_real_time_match_without_delay() {
    let scenario = "rate = 200\nlength_seconds = 0.2\nspectators = { views = 'all', delay_seconds = 0 }";
    let arena = Arena::open(&loaded(scenario), ClockMode::Realtime);
    let mut spectator = Spectator::watch(&arena.address, "suite", Vantage::Everything).await.unwrap();
    assert_eq!((spectator.delay(), spectator.welcome().seat), (0, None));
    assert!(!spectator.rules().fog, "nothing is hidden");
    spectator.ping(7).await.unwrap();
    let players = [arena.client(0).await, arena.client(1).await];
    let (mut cycles, mut pongs) = (Vec::new(), 0);
    let result = loop {
        match spectator.next().await.unwrap() {
            Event::Cycle(delta) => cycles.push(delta.cycle.0),
            Event::Pong { id, .. } => pongs += id,
            Event::Paused { .. } | Event::Warned { .. } => panic!("nobody asked"),
            Event::Ended(result) => break result,
        }
    };
    assert_eq!((cycles, pongs), ((0..=40).collect::<Vec<u32>>(), 7));
    assert_eq!(spectator.view().objects().count(), 10);
    drop(players);
    assert_eq!(arena.outcome().await.result, Some(result));
}

#[tokio::test(flavor = "multi_thread")]
async fn before_there_is_something_to_see_a_pong_says_nothing_of_the_clock() {
    let scenario = "rate = 20\nlength_seconds = 3600\nspectators = { views = 'all', delay_seconds = 60 }";
    let arena = Arena::open(&loaded(scenario), ClockMode::Realtime);
    let mut spectator = Spectator::watch(&arena.address, "suite", Vantage::Everything).await.unwrap();
    let (mut player, _other) = (arena.client(0).await, arena.client(1).await);
    for id in 0..3 {
        player.next().await.unwrap();
        spectator.ping(id).await.unwrap();
        assert_eq!(spectator.next().await.unwrap(), Event::Pong { id, cycle: 0, fraction: 0.0 });
    }
    arena.shut_down().await;
}

#[test]
fn the_command_watches_a_match_to_its_end() {
    let folder = folder("watch");
    let (scenario, map) = tiny(WATCHED);
    file(&folder, "tiny.map", &map);
    let scenario = file(&folder, "tiny.toml", &scenario);
    let (mut server, address, tokens) = serve(&["--scenario", &scenario, "--clock", "lockstep", "--once"]);
    let watch = |arguments: &[&str]| -> Child {
        let mut command = maniple(&[&["watch", "--connect", &address], arguments].concat());
        let mut child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
        let mut said = String::new();
        BufReader::new(child.stderr.as_mut().unwrap()).read_line(&mut said).unwrap();
        assert!(said.starts_with("watching ") && said.contains("8 cycles behind"), "{said}");
        child
    };
    let spectators = [watch(&["--json"]), watch(&["--seat", "1", "--json"]), watch(&["--seat", "0"])];
    let bots: Vec<Child> = tokens
        .iter()
        .map(|token| {
            let mut bot = maniple(&["bot", "straight", "--connect", &address, "--token", token, "--json"]);
            bot.stdout(Stdio::piped()).spawn().unwrap()
        })
        .collect();
    let mut results = Vec::new();
    for bot in bots {
        let played: serde_json::Value =
            serde_json::from_slice(&bot.wait_with_output().unwrap().stdout).unwrap();
        results.push(played["result"].clone());
    }
    let cycles = usize::try_from(results[0]["cycles"].as_u64().unwrap()).unwrap();
    for (place, spectator) in spectators.into_iter().enumerate() {
        let printed = spectator.wait_with_output().unwrap();
        assert!(printed.status.success());
        let printed = String::from_utf8(printed.stdout).unwrap();
        let lines: Vec<&str> = printed.lines().collect();
        assert_eq!(lines.len(), cycles + 2, "{printed}");
        let last = lines.last().unwrap();
        if place == 2 {
            assert!(last.contains(results[0]["hash"].as_str().unwrap()), "{last}");
        } else {
            let ended: serde_json::Value = serde_json::from_str(last).unwrap();
            assert_eq!(ended["ended"]["result"], results[0]);
        }
    }
    assert!(server.wait().unwrap().success());
    fails(&["watch", "--connect", "127.0.0.1:1"], 1);
}

/// Games with fog, fights and work, at their start, and how many cycles of them are looked at.
pub(crate) fn whole_games() -> Vec<(Game, usize)> {
    let whole = |name: &str, cycles| {
        let bots = ["commander", "commander"];
        (Game::new(shipped(&format!("config/scenarios/{name}.toml"), None), &bots), cycles)
    };
    let explored = crate::matches::tiny("[vision]\nterrain = 'explored'", &open());
    vec![whole("orts3", 300), whole("orts4", 300), (Game::new(explored, &["random", "straight"]), 100)]
}

/// Returns the view with which who comes begins.
pub(crate) fn at_the_start(game: &Game, vantage: Vantage) -> View {
    View::new(&game.referee.rules_of(vantage), game.referee.terrain_of(vantage))
}

/// Returns whether this is what is to be told of an object: where it is to a millionth, and to the bit all else.
fn is_told_of(object: &Sighting, seen: &Seen, cycle: Cycle) -> bool {
    let own = object.owner.is_some().then_some(object.own);
    let is_there = seen.base.position(cycle).distance(object.base.position(cycle)) < 1e-6;
    is_there
        && (seen.unit_type, seen.owner, seen.status, seen.own)
            == (object.unit_type, object.owner, object.status, own)
}

/// Returns how the match of a show comes out in one process.
fn headless(loaded: &Loaded) -> MatchResult {
    let mut game = Game::new(loaded.clone(), &["straight", "random"]);
    while game.step() {}
    game.referee.result().unwrap().clone()
}
