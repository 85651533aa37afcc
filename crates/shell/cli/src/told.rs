//! What is told of a view cycle by cycle, as lines.

use anyhow::Context;
use maniple_protocol::{Encoding, ServerMessage, encode_server};
use maniple_view::{Delta, MatchResult, View};

use crate::commands::serve::summary;
use crate::failure::Failure;
use crate::output::{Format, Reader, print_piece};

/// Prints a delta after which a view is like this: a line for people, or the message of the server.
pub(crate) fn print_cycle(format: Format, view: &View, delta: &Delta) -> Result<Reader, Failure> {
    match format {
        Format::Text => print_piece(&line(view, delta)),
        Format::Json => print_message(&ServerMessage::Delta(delta.clone())),
    }
}

/// Prints how the match has ended.
pub(crate) fn print_end(format: Format, result: &MatchResult) -> Result<(), Failure> {
    match format {
        Format::Text => print_piece(&summary(result))?,
        Format::Json => print_message(&ServerMessage::Ended { result: result.clone() })?,
    };
    Ok(())
}

fn print_message(message: &ServerMessage) -> Result<Reader, Failure> {
    let line = encode_server(Encoding::Json, message).map_err(Failure::failed)?;
    print_piece(std::str::from_utf8(&line).context("JSON is text").map_err(Failure::Failed)?)
}

fn line(view: &View, delta: &Delta) -> String {
    let counts = [
        (delta.appeared.len(), "appeared"),
        (delta.moved.len(), "moved"),
        (delta.stopped.len(), "stopped"),
        (delta.vanished.len(), "vanished"),
        (delta.died.len(), "died"),
        (delta.changed.len(), "changed"),
        (delta.shots.len(), "shots"),
        (delta.results.len(), "commands answered"),
    ];
    let some = counts.into_iter().filter(|(count, _)| *count > 0);
    let news: Vec<String> = some.map(|(count, what)| format!("{count} {what}")).collect();
    let news = if news.is_empty() { "nothing new".to_owned() } else { news.join(", ") };
    format!("cycle {}: {} objects; {news}\n", delta.cycle, view.objects().count())
}
