//! `maniple bot`: a shipped bot at a seat of a running match.

use anyhow::Context;
use maniple_bots::bot_seed;
use maniple_client::{Client, Destination, Login};
use maniple_view::{MatchResult, Seat};
use serde::Serialize;

use crate::arguments::Bot;
use crate::commands::serve::summary;
use crate::failure::Failure;
use crate::output::{Format, print};

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

async fn play(arguments: &Bot, server: Destination) -> anyhow::Result<Ended> {
    let login = Login {
        client: maniple_server::BUILD.to_owned(),
        player: arguments.name.clone(),
        token: arguments.token.clone(),
    };
    let mut client = Client::connect(server, login).await?;
    let seat = client.seat();
    let mut bot = maniple_bots::make(&arguments.name, bot_seed(arguments.seed, seat))?;
    bot.on_start(seat, client.rules(), client.terrain());
    let result = client.play(|view, delta| bot.on_cycle(view, delta)).await?;
    Ok(Ended { seat, result })
}
