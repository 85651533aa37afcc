//! Many matches on one server.

use std::collections::BTreeMap;
use std::future::pending;
use std::io::{self, Write};
use std::sync::Arc;
use std::time::Duration;

use maniple_client::{Client, ClientError, Destination, Event, Lobby, Login, Spectator};
use maniple_game::{Files, LoadedFile, Overrides, load};
use maniple_protocol::Refused;
use maniple_referee::Referee;
use maniple_server::{
    ASKS_MAX, Access, House, Journals, Limits, Match, Offer, RunError, SYNC_INTERVAL, Server,
};
use maniple_view::{ClockMode, Digest, Seat, Vantage};
use tokio::sync::oneshot;
use tokio::task::{JoinHandle, JoinSet};
use tokio::time::timeout;

use crate::arena::{bot, tiny};
use crate::commands::folder;

/// Time for what comes soon or never.
const PATIENCE: Duration = Duration::from_secs(60);

/// A server with a lobby.
struct Inn {
    address: String,
    server: Arc<Server>,
    close: oneshot::Sender<()>,
    serving: JoinHandle<()>,
}

impl Inn {
    fn open(limits: Limits) -> Self {
        Self::open_for(House::new(limits, offers(), None, 2).unwrap())
    }

    fn open_for(house: House) -> Self {
        let server = Arc::new(Server::open("127.0.0.1:0".parse().unwrap(), house).unwrap());
        let address = server.local_addr().unwrap().to_string();
        let (close, closed) = oneshot::channel();
        let serving = tokio::spawn({
            let server = Arc::clone(&server);
            async move {
                let shutdown = async {
                    if closed.await.is_err() {
                        pending::<()>().await;
                    }
                };
                server.serve(shutdown, pending()).await;
            }
        });
        Self { address, server, close, serving }
    }

    async fn lobby(&self) -> Lobby {
        Lobby::connect(&self.address).await.unwrap()
    }

    async fn sit(&self, id: Digest, token: &str) -> Result<Client, ClientError> {
        Client::connect(Destination::of_match(&self.address, id), login(token)).await
    }
}

/// Offers a short race in lock-step, and the same for ever in real time.
fn offers() -> BTreeMap<String, Offer> {
    let offer = |name: &str, clock: &str| {
        let (scenario, map) = tiny(clock);
        let scenario = scenario.replace(
            "name = 'tiny'",
            &format!("name = '{name}'\nspectators = {{ views = 'all', delay_seconds = 0 }}"),
        );
        let file = |path: &str, text: String| LoadedFile { path: path.to_owned(), bytes: text.into_bytes() };
        let files = Files(vec![file("tiny.toml", scenario), file("tiny.map", map)]);
        (name.to_owned(), Offer { files, scenario: "tiny.toml".to_owned() })
    };
    [offer("short", "length_seconds = 3"), offer("long", "rate = 50\nlength_seconds = 3600")].into()
}

fn login(token: &str) -> Login {
    Login { client: "suite".to_owned(), player: "Ada".to_owned(), token: token.to_owned() }
}

#[tokio::test(flavor = "multi_thread")]
async fn matches_are_created_listed_played_beside_each_other_and_forgotten() {
    let inn = Inn::open(Limits::default());
    let mut lobby = inn.lobby().await;
    let matches = lobby.list().await.unwrap();
    assert_eq!((matches.scenarios, matches.list), (vec!["long".to_owned(), "short".to_owned()], vec![]));
    let mut created = Vec::new();
    for open in [true, false, false] {
        created.push(lobby.create("short", ClockMode::Lockstep, open).await.unwrap());
    }
    assert!(created[0].tokens.is_empty());
    assert_eq!(created[1].tokens.len(), 2);
    let listed = lobby.list().await.unwrap().list;
    assert_eq!(listed.len(), 3);
    let open = listed.iter().find(|listed| listed.match_id == created[0].match_id).unwrap();
    assert!(open.seats.iter().all(|seat| seat.open && !seat.taken) && !open.has_begun);
    assert!(open.spectators.is_some_and(|spectators| spectators.everything));
    // The second seat of the open one, by wish.
    let at = Destination::of_match(&inn.address, created[0].match_id).at(Seat(1));
    let second = Client::connect(at, login("")).await.unwrap();
    assert_eq!(second.seat(), Seat(1));
    let seats = lobby.list().await.unwrap().list;
    let seats = &seats.iter().find(|listed| listed.match_id == created[0].match_id).unwrap().seats;
    assert_eq!(seats.iter().map(|seat| seat.taken).collect::<Vec<_>>(), [false, true]);
    // A token of another match opens nothing here.
    let wrong = inn.sit(created[1].match_id, &created[2].tokens[0]).await.err();
    assert!(matches!(wrong, Some(ClientError::Refused(Refused::Token))), "{wrong:?}");
    let mut players = JoinSet::new();
    players.spawn(play(second));
    players.spawn(play(inn.sit(created[0].match_id, "").await.unwrap()));
    for game in &created[1..] {
        for token in &game.tokens {
            players.spawn(play(inn.sit(game.match_id, token).await.unwrap()));
        }
    }
    while let Some(played) = players.join_next().await {
        assert_eq!(played.unwrap(), 24, "cycles");
    }
    inn.close.send(()).unwrap();
    inn.serving.await.unwrap();
    assert_eq!(inn.server.house().lobby().matches(), 0);
}

/// Plays a match to its end; returns how many cycles it had.
async fn play(mut client: Client) -> u32 {
    let mut bot = bot("straight", client.seat().0);
    bot.on_start(client.seat(), client.rules(), client.terrain());
    client.play(|view, delta| bot.on_cycle(view, delta)).await.unwrap().cycles.0
}

#[tokio::test(flavor = "multi_thread")]
async fn what_cannot_be_had_is_refused_with_its_reason() {
    let limits = Limits { matches: 3, matches_per_address: 2, ..Limits::default() };
    let inn = Inn::open(limits);
    let refused = |error: Option<ClientError>| match error {
        Some(ClientError::Refused(reason)) => reason,
        other => panic!("{other:?}"),
    };
    let unknown = inn.lobby().await.create("chess", ClockMode::Lockstep, true).await.err();
    assert_eq!(refused(unknown), Refused::NoScenario);
    for destination in [Destination::from(&inn.address), Destination::of_match(&inn.address, Digest(7))] {
        let nowhere = Client::connect(destination.clone(), login("")).await.err();
        assert_eq!(refused(nowhere), Refused::NoMatch);
        let nothing = Spectator::watch(destination, "suite", Vantage::Everything).await.err();
        assert_eq!(refused(nothing), Refused::NoMatch);
    }
    let mut lobby = inn.lobby().await;
    let first = lobby.create("short", ClockMode::Lockstep, true).await.unwrap();
    lobby.create("short", ClockMode::Lockstep, true).await.unwrap();
    let third = lobby.create("short", ClockMode::Lockstep, true).await.err();
    assert_eq!(refused(third), Refused::AddressFull { limit: 2 });
    let nobody =
        Client::connect(Destination::of_match(&inn.address, first.match_id).at(Seat(2)), login("")).await;
    assert_eq!(refused(nobody.err()), Refused::NoSuchSeat { seats: 2 });
    let mut curious = inn.lobby().await;
    for _ in 0..=ASKS_MAX {
        curious.list().await.unwrap();
    }
    assert_eq!(refused(curious.list().await.err()), Refused::AsksTooMuch { limit: ASKS_MAX });
    inn.server.house().lobby().drain();
    let late = inn.lobby().await.create("short", ClockMode::Lockstep, true).await.err();
    assert_eq!(refused(late), Refused::Draining);
}

#[tokio::test(flavor = "multi_thread")]
async fn an_address_has_so_many_connections_and_all_together_so_many_matches() {
    let limits = Limits { connections_per_address: 2, matches: 1, ..Limits::default() };
    let inn = Inn::open(limits);
    let (mut one, _other) = (inn.lobby().await, inn.lobby().await);
    one.create("short", ClockMode::Lockstep, true).await.unwrap();
    let full = one.create("short", ClockMode::Lockstep, true).await.err();
    assert!(matches!(full, Some(ClientError::Refused(Refused::MatchesFull { limit: 1 }))), "{full:?}");
    drop(one);
    // The last two, of which the one that was refused is still leaving.
    let mut third = inn.lobby().await;
    let refused = third.list().await.err();
    assert!(refused.is_none() || is_refused(refused.as_ref(), &Refused::AddressFull { limit: 2 }));
    let mut crowd = Vec::new();
    for _ in 0..4 {
        crowd.push(inn.lobby().await);
    }
    let mut reasons = Vec::new();
    for lobby in &mut crowd {
        reasons.push(lobby.list().await.err());
    }
    assert!(is_refused(reasons[3].as_ref(), &Refused::AddressFull { limit: 2 }), "{reasons:?}");
}

fn is_refused(error: Option<&ClientError>, expected: &Refused) -> bool {
    matches!(error, Some(ClientError::Refused(reason)) if reason == expected)
}

#[tokio::test(flavor = "multi_thread")]
async fn a_match_whose_players_do_not_come_is_given_up() {
    let limits = Limits { begin_within: Duration::from_millis(300), ..Limits::default() };
    let inn = Inn::open(limits);
    let created = inn.lobby().await.create("short", ClockMode::Lockstep, true).await.unwrap();
    let mut alone = inn.sit(created.match_id, "").await.unwrap();
    let gone = loop {
        // Nothing else would end the wait for a refusal that never comes.
        match timeout(PATIENCE, alone.next()).await.expect("it is given up") {
            Ok(Event::Cycle(_) | Event::Pong { .. } | Event::Paused { .. } | Event::Warned { .. }) => {}
            Ok(Event::Ended(_)) => panic!("it has not begun"),
            Err(error) => break error,
        }
    };
    assert!(is_refused(Some(&gone), &Refused::NotBegun { seconds: 0 }), "{gone}");
    while inn.server.house().lobby().matches() > 0 {
        tokio::task::yield_now().await;
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn a_match_that_the_disk_does_not_take_is_not_created_and_the_next_may_be() {
    let kept = folder("lobby_disk").join("kept");
    let journals = Journals::open(&kept, SYNC_INTERVAL).unwrap();
    let inn = Inn::open_for(House::new(Limits::default(), offers(), Some(journals), 2).unwrap());
    // As where there is no room for a folder.
    std::fs::remove_dir_all(&kept).unwrap();
    let refused = inn.lobby().await.create("short", ClockMode::Lockstep, true).await.err();
    assert!(is_refused(refused.as_ref(), &Refused::Draining), "{refused:?}");
    assert_eq!(inn.server.house().lobby().matches(), 0);
    std::fs::create_dir(&kept).unwrap();
    inn.lobby().await.create("short", ClockMode::Lockstep, true).await.unwrap();
    assert_eq!(inn.server.house().lobby().matches(), 1);
}

#[tokio::test(flavor = "multi_thread")]
async fn a_panic_ends_its_own_match_and_no_other() {
    /// Panics where the match writes what has happened.
    struct Trap(usize);
    impl Write for Trap {
        fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
            assert!(self.0 < 20_000, "a mistake that is made on purpose");
            self.0 += bytes.len();
            Ok(bytes.len())
        }

        fn flush(&mut self) -> io::Result<()> {
            Ok(())
        }
    }
    let house = House::new(Limits::default(), offers(), None, 1).unwrap();
    let server = Arc::new(Server::open("127.0.0.1:0".parse().unwrap(), house).unwrap());
    let address = server.local_addr().unwrap().to_string();
    let start = load(&offers()["long"].files, "tiny.toml", &Overrides::default()).unwrap();
    let referee = Referee::new(start, ClockMode::Lockstep).unwrap();
    let game = Match::new(referee, vec![Access::Open; 2]).unwrap().recorded_to(Trap(0));
    let running = tokio::spawn({
        let server = Arc::clone(&server);
        async move { server.run(game, pending()).await }
    });
    let other =
        Lobby::connect(&address).await.unwrap().create("short", ClockMode::Lockstep, true).await.unwrap();
    let mut players = JoinSet::new();
    for _ in 0..2 {
        let to = Destination::of_match(&address, other.match_id);
        players.spawn(play(Client::connect(to, login("")).await.unwrap()));
    }
    let mut doomed = JoinSet::new();
    for _ in 0..2 {
        let client = Client::connect(&address, login("")).await.unwrap();
        doomed.spawn(play_until_refused(client));
    }
    while let Some(refused) = doomed.join_next().await {
        assert_eq!(refused.unwrap(), Refused::Broken);
    }
    match running.await.unwrap() {
        Err(RunError::Panicked { message }) => assert_eq!(message, "a mistake that is made on purpose"),
        other => panic!("{other:?}"),
    }
    while let Some(played) = players.join_next().await {
        assert_eq!(played.unwrap(), 24);
    }
}

/// Plays a match until the server ends it; returns why it did.
async fn play_until_refused(mut client: Client) -> Refused {
    let mut bot = bot("random", client.seat().0);
    bot.on_start(client.seat(), client.rules(), client.terrain());
    match client.play(|view, delta| bot.on_cycle(view, delta)).await {
        Err(ClientError::Refused(reason)) => reason,
        other => panic!("{other:?}"),
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn spectators_watch_a_match_of_the_lobby_and_a_shutdown_waits_for_its_end() {
    let inn = Inn::open(Limits::default());
    let created = inn.lobby().await.create("short", ClockMode::Lockstep, true).await.unwrap();
    let to = Destination::of_match(&inn.address, created.match_id);
    let mut spectator = Spectator::watch(to.clone(), "suite", Vantage::Everything).await.unwrap();
    let (one, other) =
        (inn.sit(created.match_id, "").await.unwrap(), inn.sit(created.match_id, "").await.unwrap());
    inn.close.send(()).unwrap();
    let players = [tokio::spawn(play(one)), tokio::spawn(play(other))];
    let mut cycles = 0;
    let result = loop {
        match spectator.next().await.unwrap() {
            Event::Cycle(_) => cycles += 1,
            Event::Ended(result) => break result,
            Event::Pong { .. } | Event::Paused { .. } | Event::Warned { .. } => {}
        }
    };
    assert_eq!((result.cycles.0, cycles), (24, 25));
    for player in players {
        assert_eq!(player.await.unwrap(), 24);
    }
    inn.serving.await.unwrap();
}
