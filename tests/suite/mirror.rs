//! The view of a client over TCP, and the server's, cycle by cycle.

use maniple_bots::Bot;
use maniple_client::{Client, Event};
use maniple_game::Loaded;
use maniple_protocol::read_replay;
use maniple_referee::Referee;
use maniple_view::{ClockMode, Seat, View};

use crate::arena::{Arena, bot, loaded};

#[tokio::test(flavor = "multi_thread")]
async fn who_stops_reading_for_a_while_or_comes_back_mirrors_the_view_of_the_server_in_each_cycle() {
    let scenario = loaded("rate = 200\nlength_seconds = 1.5");
    let arena = Arena::open(&scenario, ClockMode::Realtime);
    let mut client = arena.client(0).await;
    let mut other = arena.client(1).await;
    let mut mirrored = Vec::new();
    let mut bot = bot("random", 0);
    bot.on_start(client.seat(), client.rules(), client.terrain());
    follow(&mut client, &mut *bot, 20, &mut mirrored).await;
    // The other reads on, and is far ahead.
    while other.view().cycle().0 < 200 {
        other.next().await.unwrap();
    }
    follow(&mut client, &mut *bot, 230, &mut mirrored).await;
    drop(client);
    let mut client = arena.client(0).await;
    bot.on_start(client.seat(), client.rules(), client.terrain());
    follow(&mut client, &mut *bot, u32::MAX, &mut mirrored).await;
    let outcome = arena.outcome().await;
    let views = views_of_the_server(&scenario, &outcome.replay, Seat(0));
    assert!(mirrored.len() > 250, "{}", mirrored.len());
    for view in mirrored {
        assert_eq!(&view, &views[view.cycle().0 as usize]);
    }
}

/// Returns the server's view of a seat by cycle.
pub(crate) fn views_of_the_server(scenario: &Loaded, replay: &[u8], seat: Seat) -> Vec<View> {
    let replay = read_replay(replay).unwrap();
    let mut referee = Referee::new(scenario.clone(), ClockMode::Realtime).unwrap();
    let mut views = vec![referee.view(seat).clone()];
    for event in maniple_server::events(&replay) {
        referee.handle_record(&event).unwrap();
        if referee.cycle() > views[views.len() - 1].cycle() {
            views.push(referee.view(seat).clone());
        }
    }
    views
}

/// Plays until the delta of cycle `last` has come, or to the end; keeps the view after each delta.
pub(crate) async fn follow(
    client: &mut Client,
    bot: &mut (dyn Bot + Send),
    last: u32,
    views: &mut Vec<View>,
) {
    while client.view().cycle().0 < last {
        match client.next().await.unwrap() {
            Event::Cycle(delta) => {
                views.push(client.view().clone());
                let commands = bot.on_cycle(client.view(), &delta);
                client.send(commands).await.unwrap();
            }
            Event::Pong { .. } | Event::Paused { .. } | Event::Warned { .. } => {}
            Event::Ended(_) => return,
        }
    }
}
