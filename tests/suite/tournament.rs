//! Many matches in one process.

use std::path::Path;
use std::process::Output;

use serde_json::{Value, json};

use crate::commands::{ROOT, fails, file, folder, json, maniple, run};

/// A few cycles, so that a match takes no time worth speaking of.
const SHORT: [&str; 3] = ["match", "--cycles", "40"];

#[test]
fn two_matches_share_a_seed_with_the_seats_switched() {
    let bots = ["--bot", "straight", "--bot", "random", "--seed", "7"];
    let played = json(&[&SHORT[..], &bots, &["--count", "5", "--jobs", "2", "--json"]].concat());
    assert_eq!((&played["seed"], &played["count"], &played["played"]), (&7.into(), &5.into(), &5.into()));
    let seating = |row: &Value| {
        let player = |seat: usize| row["seats"][seat]["player"].as_str().expect("a name").to_owned();
        (row["match"].clone(), row["seed"].clone(), player(0), player(1))
    };
    let rows = played["matches"].as_array().expect("rows");
    let expected = [(0, 7, false), (1, 7, true), (2, 8, false), (3, 8, true), (4, 9, false)];
    for (row, (number, seed, switched)) in rows.iter().zip(expected) {
        let (first, second) = if switched { ("random", "straight") } else { ("straight", "random") };
        assert_eq!(seating(row), (number.into(), seed.into(), first.to_owned(), second.to_owned()));
        // Alone it is the same match.
        let (seed, seats) = (seed.to_string(), ["--bot", first, "--bot", second, "--json"]);
        let alone = json(&[&SHORT[..], &["--seed", &seed], &seats].concat());
        assert_eq!((&alone["hash"], &alone["cycles"]), (&row["hash"], &row["cycles"]), "{row}");
        for (seat, score) in alone["scores"].as_array().expect("scores").iter().enumerate() {
            assert_eq!(score["points"], row["seats"][seat]["points"]);
            let won = alone["winners"].as_array().expect("seats").contains(&seat.into());
            assert_eq!(row["seats"][seat]["won"], won);
        }
    }
    assert_eq!(rows.len(), 5);
}

#[test]
fn wins_count_for_the_bot_and_for_the_seat() {
    // Idle bots stay where they are; whoever moves wins from either seat.
    let arguments =
        ["match", "--cycles", "200", "--bot", "straight", "--bot", "idle", "--count", "6", "--json"];
    let played = json(&arguments);
    let (bot, other) = (&played["players"][0], &played["players"][1]);
    assert_eq!((&bot["player"], &bot["wins"], &bot["losses"]), (&"straight".into(), &6.into(), &0.into()));
    assert_eq!((&other["player"], &other["wins"], &other["losses"]), (&"idle".into(), &0.into(), &6.into()));
    assert_eq!((&bot["score"], &other["score"], &bot["win_rate"]), (&1.0.into(), &0.0.into(), &1.0.into()));
    // Wilson (1927) for 6 of 6: 1 / (1 + z²/6).
    let low = bot["win_rate_interval"][0].as_f64().expect("a number");
    assert!((low - 0.609_67).abs() < 1e-5 && bot["win_rate_interval"][1] == 1.0, "{bot}");
    assert!(bot["points"]["mean"].as_f64() > Some(0.0) && bot["points"]["deviation"].is_f64(), "{bot}");
    for seat in [0, 1] {
        let standing = &played["seats"][seat];
        assert_eq!((&standing["seat"], &standing["wins"]), (&seat.into(), &3.into()), "{standing}");
        assert_eq!((&standing["late"], &standing["crashes"]), (&0.into(), &0.into()));
    }
    assert_eq!((&played["failed"], &played["draws"]), (&0.into(), &0.into()));
}

#[test]
fn sixty_four_matches_run_at_once_and_the_result_does_not_depend_on_it() {
    let csv = |name: &str| folder("jobs").join(name).display().to_string();
    let played = |jobs: &str| {
        let file = csv("matches.csv");
        let output = run(&[
            &SHORT[..],
            &["--count", "64", "--json", "--bot", "straight", "--bot", "straight"],
            &["--jobs", jobs, "--csv", &file],
        ]
        .concat());
        let text = String::from_utf8(output.stdout).expect("text");
        let (result, timing) = text.split_once(",\"timing\":").expect("timing at the end");
        assert!(timing.contains(&format!("\"jobs\":{jobs},")), "{timing}");
        (result.to_owned(), std::fs::read_to_string(&file).expect("it is written"))
    };
    let first = played("1");
    assert!(first.0.contains("straight (1)") && first.0.contains("straight (2)"), "{}", first.0);
    for jobs in ["3", "64"] {
        assert!(first == played(jobs), "with {jobs} jobs something is different");
    }
}

#[test]
fn the_table_says_who_is_better_and_how_to_look_at_it() {
    let folder = folder("table");
    let text = |arguments: &[&str]| {
        let output = maniple(arguments).current_dir(&folder).output().expect("the program runs");
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        assert!(!String::from_utf8_lossy(&output.stderr).contains("matches/s"), "no bar without a terminal");
        String::from_utf8(output.stdout).expect("text")
    };
    let count = ["--bot", "idle", "--bot", "random", "--count", "4", "--rate", "10", "--scalar", "f32"];
    let table = text(&[&SHORT[..], &count].concat());
    for named in ["4 of 4 matches", "player", "at seat", "idle", "random", "95 % interval", "crashes", "late"]
    {
        assert!(table.contains(named), "{table} does not name {named}");
    }
    let next = table.lines().find_map(|line| line.strip_prefix("next: maniple ")).expect("a hint");
    assert_eq!(
        next,
        "match --rate 10 --scalar f32 --cycles 40 --seed 1 --bot idle --bot random --replay match.replay"
    );
    text(&next.split(' ').collect::<Vec<_>>());
    assert!(folder.join("match.replay").exists());
}

#[test]
fn each_match_has_a_row_of_csv_and_a_replay_that_verifies() {
    let folder = folder("rows");
    let (csv, replays) =
        (folder.join("matches.csv").display().to_string(), folder.join("a/b").display().to_string());
    let kept = ["--count", "3", "--seed", "5", "--csv", &csv, "--replays", &replays, "--json"];
    let played = json(&[&SHORT[..], &["--bot", "random"], &kept].concat());
    let text = std::fs::read_to_string(&csv).expect("it is written");
    let lines: Vec<Vec<&str>> = text.lines().map(|line| line.split(',').collect()).collect();
    assert_eq!(lines[0][..7], ["match", "seed", "winner", "reason", "cycles", "hash", "failure"]);
    assert_eq!(lines[0][7..9], ["seat_0_player", "seat_0_won"]);
    assert_eq!((lines.len(), lines[0].len()), (4, 7 + 2 * 6));
    for (number, row) in played["matches"].as_array().expect("rows").iter().enumerate() {
        let cells = &lines[number + 1];
        let seed = [5, 5, 6][number];
        assert_eq!(cells[..2], [number.to_string(), seed.to_string()]);
        assert_eq!(cells[3..5], [row["reason"].as_str().expect("a word"), &row["cycles"].to_string()]);
        assert_eq!(cells[5], row["hash"].as_str().expect("a hash"));
        assert_eq!(cells[7], row["seats"][0]["player"].as_str().expect("a name"));
        let replay = format!("{replays}/{seed}-{number}.replay");
        assert_eq!(row["replay"], replay);
        let verdict = json(&["replay", "verify", &replay, "--json"]);
        assert_eq!((&verdict["verified"], &verdict["hash"]), (&true.into(), &row["hash"]));
    }
}

#[test]
fn bots_take_turns_at_all_seats_of_a_larger_match_and_one_seat_has_nothing_to_switch() {
    let folder = folder("seats");
    file(
        &folder,
        "open.map",
        &format!("type octile\nheight 16\nwidth 16\nmap\n{}", "................\n".repeat(16)),
    );
    let scenario = |seats: usize| {
        let seat = "{ bot = 'idle', groups = [{ unit = 'a', count = 1 }] }";
        let text = format!(
            "name = 'open'\nmap = 'open.map'\nseed = 2\nrate = 8\nlength_seconds = 2\nseat = [{}]\n\
             objective = {{ kind = 'race', zone_size = 3 }}\nunit.a = {{ radius = 0.3, speed = 4, sight = 5 }}\n",
            vec![seat; seats].join(", ")
        );
        file(&folder, &format!("{seats}.toml"), &text)
    };
    let seatings = |seats: usize, bots: &[&str]| {
        let path = scenario(seats);
        let played = json(&[&["match", &path, "--count", "4", "--json"], bots].concat());
        let row = |row: &Value| {
            let seats = row["seats"].as_array().expect("seats").iter();
            let players: Vec<&str> = seats.map(|seat| seat["player"].as_str().expect("a name")).collect();
            json!([row["seed"], players.join(" ")])
        };
        Value::Array(played["matches"].as_array().expect("rows").iter().map(row).collect())
    };
    assert_eq!(seatings(1, &[]), json!([[2, "idle"], [3, "idle"], [4, "idle"], [5, "idle"]]));
    assert_eq!(
        seatings(4, &["--bot", "random", "--bot", "straight"]),
        json!([
            [2, "random straight idle (1) idle (2)"],
            [2, "idle (2) random straight idle (1)"],
            [2, "idle (1) idle (2) random straight"],
            [2, "straight idle (1) idle (2) random"]
        ])
    );
}

#[test]
fn what_cannot_be_meant_of_many_matches_is_a_usage_error() {
    let check = |arguments: &[&str], code: i32, named: &str| {
        let error = fails(&[&SHORT[..], arguments].concat(), code);
        assert!(error.contains(named), "{error} does not name {named}");
    };
    check(&["--count", "0"], 2, "1..=1000000");
    check(&["--count", "1000001"], 2, "1..=1000000");
    check(&["--count", "2", "--jobs", "0"], 2, "1..=256");
    check(&["--count", "2", "--jobs", "257"], 2, "1..=256");
    check(&["--jobs", "2"], 2, "--count");
    check(&["--csv", "x"], 2, "--count");
    check(&["--replays", "x"], 2, "--count");
    check(&["--count", "2", "--replay", "x"], 2, "--replay");
    check(&["--count", "2", "--explain"], 2, "--explain");
    check(
        &["--count", "2", "--bot", "strait"],
        2,
        "alone, auto, commander, focus, follow, gather, idle, macro, random, replan, rush, straight",
    );
    check(&["--count", "2", "--csv", "/no/such/folder/x.csv"], 1, "/no/such/folder/x.csv");
    check(&["--count", "2", "--replays", "Cargo.toml/x"], 1, "Cargo.toml/x");
    check(&["--count", "2", "--map", "no/such.map"], 3, "no/such.map");
}

#[test]
fn a_match_that_cannot_be_kept_is_told_and_counts_for_nobody() {
    let folder = folder("unkept");
    // Where the replay of the second match was to be, there is a folder.
    std::fs::create_dir_all(folder.join("1-1.replay")).expect("the folder can be made");
    let arguments = ["--count", "3", "--jobs", "1", "--replays", &folder.display().to_string(), "--json"];
    let output = run(&[&SHORT[..], &arguments].concat());
    let (played, error) = both(&output);
    assert_eq!(output.status.code(), Some(1), "{error}");
    assert!(error.contains("1 of 3 matches") && error.contains("match 1, seed 1"), "{error}");
    assert_eq!((&played["played"], &played["failed"]), (&2.into(), &1.into()));
    assert!(played["matches"][1]["failure"].as_str().expect("a failure").contains("1-1.replay"));
    assert_eq!(played["matches"][1]["hash"], Value::Null);
}

#[cfg(unix)]
#[test]
fn an_interrupt_ends_many_matches_with_what_was_played_so_far() {
    use std::io::Read;
    use std::process::{Command, Stdio};
    use std::time::Duration;

    let folder = folder("interrupted_matches");
    let replays = folder.display().to_string();
    let arguments = ["--count", "1000000", "--replays", &replays, "--json"];
    let mut command = maniple(&[&SHORT[..], &arguments].concat());
    let mut running = command.stdout(Stdio::piped()).stderr(Stdio::null()).spawn().expect("the program runs");
    while !Path::new(&replays).join("1-0.replay").exists() {
        assert!(running.try_wait().expect("it runs").is_none(), "a million matches take longer");
        std::thread::sleep(Duration::from_millis(5));
    }
    let kill = Command::new("kill").args(["-INT", &running.id().to_string()]).status().expect("kill runs");
    assert!(kill.success());
    let mut text = String::new();
    running.stdout.take().expect("a pipe").read_to_string(&mut text).expect("text");
    assert_eq!(running.wait().expect("it ends").code(), Some(130));
    let played: Value = serde_json::from_str(&text).expect("JSON");
    let rows = played["matches"].as_array().expect("rows");
    assert_eq!((&played["interrupted"], &played["played"]), (&true.into(), &rows.len().into()));
    assert!(rows.len() < 1_000_000);
}

/// Returns the JSON on standard output, and standard error.
fn both(output: &Output) -> (Value, String) {
    let played = serde_json::from_slice(&output.stdout).expect("JSON");
    (played, String::from_utf8_lossy(&output.stderr).into_owned())
}

#[test]
fn the_shipped_scenarios_have_a_bot_for_every_seat_of_a_tournament() {
    for scenario in std::fs::read_dir(Path::new(ROOT).join("config/scenarios")).expect("they ship").flatten()
    {
        let path = scenario.path().display().to_string();
        let played = json(&["match", &path, "--cycles", "5", "--count", "2", "--json"]);
        assert_eq!(played["played"], 2, "{path}");
    }
}
