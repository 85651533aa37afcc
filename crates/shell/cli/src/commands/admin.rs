//! `maniple admin`: what can be done to a running daemon.

use std::fmt::Write as _;
use std::path::PathBuf;

use maniple_server::operation::administration::{AdminClient, read_admin_token};
use serde_json::Value;

use crate::arguments::Admin;
use crate::failure::Failure;
use crate::output::{Format, print};

/// Runs `maniple admin`.
pub(crate) fn run(arguments: &Admin) -> Result<(), Failure> {
    let token = match &arguments.token {
        Some(token) => token.clone(),
        None => {
            let beside = || {
                let mut path = arguments.socket.clone().into_os_string();
                path.push(".token");
                PathBuf::from(path)
            };
            let path = arguments.token_file.clone().unwrap_or_else(beside);
            read_admin_token(&path).map_err(Failure::bad_input)?.to_string()
        }
    };
    let mut client = AdminClient::connect(&arguments.socket).map_err(Failure::failed)?;
    let told = client.ask(&token, arguments.verb.verb()).map_err(Failure::failed)?;
    print(Format::of(&arguments.json), &told, text)
}

/// Returns what the daemon told, for people.
fn text(told: &Value) -> String {
    let mut text = String::new();
    if let Some(matches) = told["matches"].as_array() {
        for row in matches {
            let word = |name: &str| row[name].as_str().unwrap_or_default().to_owned();
            let _ = writeln!(
                text,
                "{} {} {} {} cycle {} players {}/{} spectators {}",
                word("match"),
                word("scenario"),
                word("clock"),
                word("phase"),
                row["cycle"],
                row["players"],
                row["seats"],
                row["spectators"],
            );
        }
        let _ = writeln!(text, "{} matches", matches.len());
    } else if let Some(tokens) = told["created"]["tokens"].as_array() {
        let _ = writeln!(text, "match {}", told["created"]["match"].as_str().unwrap_or_default());
        for (seat, token) in tokens.iter().enumerate() {
            let _ = writeln!(text, "seat {seat} token {}", token.as_str().unwrap_or_default());
        }
    } else if let Some(limits) = told["limits"].as_object() {
        for (name, limit) in limits {
            let _ = writeln!(text, "limits.{name} = {limit}");
        }
    } else {
        text.push_str("done\n");
    }
    text
}
