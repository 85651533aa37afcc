//! Results on standard output.

use std::io::{ErrorKind, Write};

use serde::Serialize;

use crate::failure::Failure;

/// Whether a result is for people or for programs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Format {
    /// Lines for people.
    Text,
    /// One JSON value and nothing else.
    Json,
}

impl Format {
    /// Returns what `--json` asks for.
    pub(crate) fn of(json: &JsonFlag) -> Self {
        if json.json { Self::Json } else { Self::Text }
    }
}

/// The flag `--json`.
#[derive(Clone, Copy, Debug, clap::Args)]
pub(crate) struct JsonFlag {
    /// Print JSON and nothing else on standard output
    #[arg(long)]
    json: bool,
}

/// Prints a result: as JSON, or as the text that `text` makes of it.
pub(crate) fn print<T: Serialize>(
    format: Format,
    value: &T,
    text: impl FnOnce(&T) -> String,
) -> Result<(), Failure> {
    let printed = match format {
        Format::Text => text(value),
        Format::Json => serde_json::to_string(value).map_err(Failure::failed)? + "\n",
    };
    print_text(&printed)
}

/// Prints a text. A reader that has gone away, as behind `| head`, is no failure.
pub(crate) fn print_text(text: &str) -> Result<(), Failure> {
    print_piece(text).map(|_| ())
}

/// Prints one of many texts. Returns whether to go on: whether there is a reader still.
pub(crate) fn print_piece(text: &str) -> Result<Reader, Failure> {
    let mut out = std::io::stdout().lock();
    match out.write_all(text.as_bytes()).and_then(|()| out.flush()) {
        Ok(()) => Ok(Reader::Reads),
        Err(error) if error.kind() == ErrorKind::BrokenPipe => Ok(Reader::HasGone),
        Err(error) => Err(Failure::failed(error)),
    }
}

/// Who reads standard output.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Reader {
    /// It wants more.
    Reads,
    /// Nobody does any more: what is still to be said can be left unsaid.
    HasGone,
}

/// Tells something beside the result, on standard error. Nobody has to read it, so that it cannot be written is no
/// failure.
pub(crate) fn note(text: &str) {
    let _ = writeln!(std::io::stderr(), "{text}");
}

/// Returns a number with a comma between thousands.
pub(crate) fn grouped(number: u64) -> String {
    let digits = number.to_string();
    let mut text = String::new();
    for (place, digit) in digits.chars().enumerate() {
        if place > 0 && (digits.len() - place).is_multiple_of(3) {
            text.push(',');
        }
        text.push(digit);
    }
    text
}
