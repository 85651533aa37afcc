//! The configuration of the daemon, as its operators give it.

use std::process::{Command, Output, Stdio};

use serde_json::{Value, json};

use crate::commands::{fails, file, folder, json, maniple, opened};

const SHIPPED: &str = "config/server.toml";

#[test]
fn the_shipped_configuration_is_right() {
    let output = maniple(&["serve", "--config", SHIPPED, "--check"]).output().unwrap();
    assert!(output.status.success());
    assert_eq!(String::from_utf8_lossy(&output.stdout), format!("the configuration is right: {SHIPPED}\n"));
    assert_eq!(json(&["serve", "--check", "--json"]), json!({"file": null, "files": []}));
}

#[test]
fn a_wrong_configuration_is_no_start() {
    let folder = folder("wrong_configuration");
    let wrong = file(&folder, "server.toml", "[limits]\n\nconections = 1\n");
    let expected = format!("error: {wrong}, line 3: [limits] has no key conections; it has connections");
    for more in [&[][..], &["--check"], &["--print-config"]] {
        let error = fails(&[&["serve", "--config", &wrong], more].concat(), 3);
        assert!(error.starts_with(&expected), "{error}");
    }
    let error = fails(&["serve", "--config", "no/server.toml", "--check"], 3);
    assert!(error.starts_with("error: no/server.toml: "), "{error}");
    let error = fails(&["serve", "--set", "limits.connections=0", "--check"], 2);
    assert!(error.contains("a whole number from 1 to 65536"), "{error}");
    fails(&["serve", "--set", "limits.connections", "--check"], 2);
    let output = with(maniple(&["serve", "--check"]), "MANIPLE_LIMITS_CONNECTIONS", "few");
    let error = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(3), "{error}");
    assert!(
        error.contains("environment MANIPLE_LIMITS_CONNECTIONS: limits.connections = \"few\""),
        "{error}"
    );
}

#[test]
fn files_that_the_configuration_names_are_checked_with_it() {
    let folder = folder("checked_files");
    let nothing = file(&folder, "nothing.pem", "");
    for (setting, expected) in [
        (
            format!("listen.tls_key={nothing}"),
            "listen.tls_key needs listen.tls_certificate, which is not given; give it, or leave both away"
                .to_owned(),
        ),
        ("lobby.scenarios=duel=none.toml".to_owned(), "lobby.scenarios.duel: none.toml".to_owned()),
        (format!("journal.directory={nothing}"), format!("{nothing} is no folder; name one, or none")),
    ] {
        let output = maniple(&["serve", "--check", "--set", &setting]).output().unwrap();
        let error = String::from_utf8_lossy(&output.stderr);
        assert!(!output.status.success() && error.contains(&expected), "{setting}: {error}");
    }
    let pair = [format!("listen.tls_key={nothing}"), format!("listen.tls_certificate={nothing}")];
    let error = fails(&["serve", "--check", "--set", &pair[0], "--set", &pair[1]], 3);
    assert!(error.contains(&format!("there is no certificate in {nothing}; it needs a block")), "{error}");
    let token = format!("listen.admin_token_file={nothing}");
    let error = fails(&["serve", "--check", "--set", "listen.admin_socket=a.sock", "--set", &token], 3);
    assert!(error.contains("listen.admin_socket: ") && error.contains(&nothing), "{error}");
    let error = fails(&["serve", "--check", "--scenario", "none.toml"], 3);
    assert!(error.starts_with("error: none.toml: "), "{error}");
    let right = "lobby.scenarios=duel=config/scenarios/duel.toml,wide=config/scenarios/orts1.toml";
    let checked = json(&["serve", "--check", "--json", "--set", right]);
    assert_eq!(checked["files"], json!(["config/scenarios/duel.toml", "config/scenarios/orts1.toml"]));
}

#[test]
fn every_value_is_printed_with_its_source_and_can_be_read_back() {
    let folder = folder("printed_configuration");
    let given = file(&folder, "server.toml", "[limits]\nmatches = 5\nconnections = 6\n");
    let mut print =
        maniple(&["serve", "--config", &given, "--print-config", "--listen", "127.0.0.1:9", "--json"]);
    print.args(["--set", "limits.connections_per_address=3"]);
    let held: Value = serde_json::from_slice(&with(print, "MANIPLE_LIMITS_CONNECTIONS", "7").stdout).unwrap();
    let held = held.as_array().unwrap();
    for expected in [
        json!({"key": "listen.address", "value": "\"127.0.0.1:9\"", "source": {"flag": {"flag": "--listen"}}}),
        json!({"key": "listen.http", "value": "\"\"", "source": "default"}),
        json!({"key": "limits.matches", "value": "5", "source": {"file": {"path": given, "line": 2}}}),
        json!({"key": "limits.connections", "value": "7",
            "source": {"environment": {"variable": "MANIPLE_LIMITS_CONNECTIONS"}}}),
        json!({"key": "limits.connections_per_address", "value": "3",
            "source": {"flag": {"flag": "--set limits.connections_per_address"}}}),
    ] {
        assert!(held.contains(&expected), "{expected} is not in {held:?}");
    }
    let text = maniple(&["serve", "--config", &given, "--print-config"]).output().unwrap().stdout;
    let text = String::from_utf8(text).unwrap();
    assert!(text.contains(&format!("connections = 6 # {given}, line 3\n")), "{text}");
    let again = file(&folder, "printed.toml", &text);
    let again = maniple(&["serve", "--config", &again, "--print-config"]).output().unwrap().stdout;
    let without_sources =
        |text: &str| text.lines().map(|line| line.split(" # ").next().unwrap().to_owned()).collect();
    let (first, second): (Vec<String>, Vec<String>) =
        (without_sources(&text), without_sources(&String::from_utf8(again).unwrap()));
    assert_eq!(first, second);
}

#[test]
fn logs_are_json_on_request() {
    for (flags, variable) in [(&["--log-format", "json"][..], "text"), (&[], "json")] {
        let arguments = [flags, &["--log", "info", "serve", "--listen", "127.0.0.1:0", "--json"]].concat();
        let mut server = maniple(&arguments)
            .env("MANIPLE_LOG_FORMAT", variable)
            .stderr(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .unwrap();
        let (address, _) = opened(&mut server);
        fails(&["bot", "idle", "--connect", &address, "--token", &"0".repeat(32)], 1);
        server.kill().unwrap();
        let log = String::from_utf8(server.wait_with_output().unwrap().stderr).unwrap();
        let events: Vec<Value> = log.lines().filter_map(|line| serde_json::from_str(line).ok()).collect();
        let refused = |event: &Value| event["level"] == "INFO" && event["fields"]["message"] == "refused";
        assert!(events.iter().any(refused) && !log.contains(" INFO "), "{log}");
    }
    let error = fails(&["--log-format", "xml", "map", "info", "maps/choke.tmx"], 2);
    assert!(error.contains("flag --log-format: log.format = \"xml\": it has to be one of"), "{error}");
}

fn with(mut command: Command, variable: &str, value: &str) -> Output {
    command.env(variable, value).stdin(Stdio::null()).output().unwrap()
}
