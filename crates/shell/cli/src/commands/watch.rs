//! `maniple watch`: a running match, as its spectators may see it.

use anyhow::Context;
use maniple_client::{Event, Spectator};
use maniple_view::{Seat, Vantage};

use crate::arguments::Watch;
use crate::failure::Failure;
use crate::output::{Format, Reader, note};
use crate::told::{print_cycle, print_end};

/// Runs `maniple watch`.
pub(crate) fn run(arguments: &Watch) -> Result<(), Failure> {
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build();
    runtime.map_err(Failure::failed)?.block_on(watch(arguments))
}

async fn watch(arguments: &Watch) -> Result<(), Failure> {
    let format = if arguments.json { Format::Json } else { Format::Text };
    let view = arguments.seat.map_or(Vantage::Everything, |seat| Vantage::Seat(Seat(seat)));
    let place = || format!("the match at {}", arguments.connect);
    let server = arguments.tls.server(arguments.connect)?;
    let server = arguments.match_id.map_or(server.clone(), |id| server.entering(id));
    let spectator = Spectator::watch(server, maniple_server::BUILD, view).await;
    let mut spectator = spectator.with_context(place).map_err(Failure::Failed)?;
    let delay = spectator.delay();
    note(&format!("watching {view}, {delay} cycles behind; nothing comes before the match is so old"));
    loop {
        match spectator.next().await.with_context(place).map_err(Failure::Failed)? {
            Event::Cycle(delta) => {
                if print_cycle(format, spectator.view(), &delta)? == Reader::HasGone {
                    return Ok(());
                }
            }
            Event::Pong { .. } | Event::Paused { .. } | Event::Warned { .. } => {}
            Event::Ended(result) => return print_end(format, &result),
        }
    }
}
