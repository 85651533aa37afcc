//! What README.md shows, as a reader would run it.

use std::io::{BufRead, BufReader, Write};
use std::process::{Command, Stdio};

use crate::commands::{ROOT, maniple};

#[test]
fn the_bot_in_twenty_lines_plays_a_match_to_its_end() {
    if Command::new("python3").arg("--version").stdout(Stdio::null()).status().is_err() {
        // Around the capture of the test harness: a test that did not run has to be seen.
        let _ = writeln!(std::io::stderr(), "SKIPPED: the bot of README.md needs python3, which is not here");
        return;
    }
    let readme = std::fs::read_to_string(format!("{ROOT}/README.md")).expect("README.md is there");
    let bot = readme.split("```python\n").nth(1).and_then(|rest| rest.split("```").next());
    let bot = bot.expect("README.md shows a bot");
    assert_eq!(bot.lines().count(), 20, "the bot has twenty lines");

    let serve = ["serve", "--clock", "lockstep", "--once", "--listen", "127.0.0.1:0"];
    let mut server = maniple(&serve).stdout(Stdio::piped()).spawn().expect("the program runs");
    let mut lines = BufReader::new(server.stdout.take().expect("piped")).lines();
    let mut told = || lines.next().expect("the server goes on").expect("the server prints text");
    let last = |line: String| line.rsplit(' ').next().unwrap_or_default().to_owned();
    let (address, _, ours, theirs) = (last(told()), told(), last(told()), last(told()));

    let other = ["bot", "straight", "--connect", &address, "--token", &theirs];
    let mut opponent = maniple(&other).stdout(Stdio::null()).spawn().expect("the program runs");
    let (host, port) = address.split_once(':').expect("an address has a port");
    let played = Command::new("python3").args(["-c", bot, host, port, &ours]).output().expect("python3 runs");
    assert!(played.status.success(), "{}", String::from_utf8_lossy(&played.stderr));
    let result = told();
    assert!(result.contains("wins after"), "{result}");
    assert!(opponent.wait().expect("the bot ends").success());
    assert!(server.wait().expect("the server ends").success());
}
