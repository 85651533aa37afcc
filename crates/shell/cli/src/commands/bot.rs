//! `maniple bot`: a shipped bot at a seat of a running match.

use std::time::Duration;

use anyhow::Context;
use maniple_bots::bot_seed;
use maniple_client::{Client, ClientError, Destination, Login};
use maniple_view::{MatchResult, Seat};
use serde::Serialize;
use tokio::time::{Instant, sleep};

use crate::arguments::Bot;
use crate::commands::serve::summary;
use crate::failure::Failure;
use crate::output::{Format, note, print};

/// Seconds for which a bot tries to come back to its seat.
const RECONNECT_SECONDS: u64 = 60;

/// Time from one try to the next.
const RECONNECT_PAUSE: Duration = Duration::from_millis(200);

/// How the match ended for the bot.
#[derive(Debug, Serialize)]
struct Ended {
    seat: Seat,
    result: MatchResult,
}

/// Runs `maniple bot`.
pub(crate) fn run(arguments: &Bot) -> Result<(), Failure> {
    // A name that does not exist is told before anybody is bothered with a connection.
    maniple_bots::make(&arguments.name, 0).map_err(|error| Failure::usage(error.to_string()))?;
    let server = arguments.tls.server(arguments.connect)?;
    let server = arguments.match_id.map_or(server.clone(), |id| server.entering(id));
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build();
    let ended = runtime
        .map_err(Failure::failed)?
        .block_on(play(arguments, server))
        .with_context(|| format!("the match at {}", arguments.connect))
        .map_err(Failure::Failed)?;
    print(Format::of(&arguments.json), &ended, |ended| {
        format!("played seat {}: {}", ended.seat, summary(&ended.result))
    })
}

/// Plays the match to its end. A connection that breaks is made again, for a while: the server may have been killed, and goes on when it
/// starts again.
async fn play(arguments: &Bot, server: Destination) -> anyhow::Result<Ended> {
    let login = || Login {
        client: maniple_server::BUILD.to_owned(),
        player: arguments.name.clone(),
        token: arguments.token.clone(),
    };
    let mut client = Client::connect(server.clone(), login()).await?;
    let seat = client.seat();
    let mut bot = maniple_bots::make(&arguments.name, bot_seed(arguments.seed, seat))?;
    loop {
        bot.on_start(seat, client.rules(), client.terrain());
        let broken = match client.play(|view, delta| bot.on_cycle(view, delta)).await {
            Ok(result) => return Ok(Ended { seat, result }),
            Err(error @ (ClientError::Broken(_) | ClientError::Closed)) if !arguments.token.is_empty() => {
                error
            }
            Err(error) => return Err(error.into()),
        };
        note(&format!("{broken}; trying for {RECONNECT_SECONDS} s to come back"));
        client = reconnect(&server, login).await.ok_or(broken)?;
    }
}

/// Returns a new connection to the seat; `None` if there is none in time.
async fn reconnect(server: &Destination, login: impl Fn() -> Login) -> Option<Client> {
    let until = Instant::now() + Duration::from_secs(RECONNECT_SECONDS);
    while Instant::now() < until {
        if let Ok(client) = Client::connect(server.clone(), login()).await {
            return Some(client);
        }
        sleep(RECONNECT_PAUSE).await;
    }
    None
}
