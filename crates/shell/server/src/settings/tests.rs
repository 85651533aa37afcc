use std::ffi::OsString;
use std::path::Path;

use super::*;

const SHIPPED: &str = include_str!("../../../../../config/server.toml");

#[test]
fn without_any_source_the_defaults_hold() {
    let settings = resolve(None, &[], &[]).unwrap().settings().unwrap();
    assert_eq!(settings.listen.address.to_string(), "127.0.0.1:7171");
    assert_eq!((settings.listen.tls, settings.listen.admin, settings.listen.http), (None, None, None));
    assert_eq!(settings.lobby.create, MayCreate::Anyone);
    assert_eq!(settings.limits, Limits::default());
    assert_eq!(settings.journal.sync_interval, crate::SYNC_INTERVAL);
    assert_eq!(settings.journal.directory, None);
    assert_eq!(settings.log, Log { filter: "warn".to_owned(), format: LogFormat::Text });
}

#[test]
fn the_shipped_file_explains_every_key_and_changes_nothing() {
    let shipped = resolve(Some(SHIPPED), &[], &[]).unwrap();
    assert_eq!(shipped.settings(), Configuration::default().settings());
    for (key, value, origin) in shipped.values() {
        assert!(matches!(origin, Origin::File { .. }), "{} is not in the file", key.path());
        let line = SHIPPED.lines().position(|line| line == format!("{} = {value}", key.name));
        let comment = comment_above(line.unwrap_or_else(|| panic!("no line for {}", key.path())));
        assert!(comment.contains(key.meaning), "{}: {comment:?}", key.path());
        let mut limit = key.kind.to_string();
        limit[..1].make_ascii_uppercase();
        assert!(comment.contains(&format!("{limit}.")), "{}: {comment:?}", key.path());
    }
}

#[test]
fn flags_hold_over_the_environment_over_the_file_over_the_defaults() {
    let file = "[limits]\nconnections = 10\nmatches = 11\nconnections_per_address = 12\n";
    let environment = [("MANIPLE_LIMITS_MATCHES", "21"), ("MANIPLE_LIMITS_CONNECTIONS_PER_ADDRESS", "22")];
    let flags = [Flag::set("limits.connections_per_address=32").unwrap()];
    let configuration = resolve(Some(file), &environment, &flags).unwrap();
    let limits = configuration.limits();
    assert_eq!((limits.connections, limits.matches, limits.connections_per_address), (10, 21, 32));
    for (key, origin) in [
        (key::CONNECTIONS, "server.toml, line 2"),
        (key::MATCHES, "environment MANIPLE_LIMITS_MATCHES"),
        (key::CONNECTIONS_PER_ADDRESS, "flag --set limits.connections_per_address"),
        (key::FILTER, "default"),
    ] {
        assert_eq!(configuration.origin(&key).to_string(), origin);
    }
}

#[test]
fn what_is_printed_reads_back_as_the_same() {
    let flags = [
        ("listen.http", "[::1]:9"),
        ("listen.admin_socket", "/run/a \"quoted\" socket"),
        ("lobby.scenarios", "duel=d.toml,rush hour=r.toml"),
        ("lobby.create", "admin"),
        ("limits.connections", "7"),
    ];
    let flags = flags.map(|(key, value)| Flag::set(&format!("{key}={value}")).unwrap());
    let given = resolve(None, &[], &flags).unwrap();
    let printed = given.text();
    assert_eq!(resolve(Some(&printed), &[], &[]).unwrap().settings(), given.settings());
    assert!(printed.contains("connections = 7 # flag --set limits.connections\n"), "{printed}");
}

#[test]
fn every_mistake_in_a_file_names_line_key_limit_and_remedy() {
    for (file, error) in [
        ("\n[limits\n", "server.toml, line 2: unclosed table, expected `]`; the file has to be TOML"),
        ("[limits]\nmatches = 1\nmatches = 2", "server.toml, line 3: duplicate key; the file has to be TOML"),
        (
            "\n[limts]\n",
            "server.toml, line 2: there is no section [limts]; the sections are listen, lobby, limits, journal, log",
        ),
        (
            "connections = 1",
            "server.toml, line 1: connections stands in no section; write it below one of listen, lobby, limits, \
             journal, log, as in [limits]",
        ),
        (
            "[limits]\n\nconections = 1",
            "server.toml, line 3: [limits] has no key conections; it has connections, connections_per_address, matches, matches_per_address, begin_seconds",
        ),
        (
            "[limits]\nconnections = 0",
            "server.toml, line 2: limits.connections = 0: it has to be a whole number from 1 to 65536",
        ),
        (
            "[limits]\nconnections = 65537",
            "server.toml, line 2: limits.connections = 65537: it has to be a whole number from 1 to 65536",
        ),
        (
            "[limits]\nconnections = \"many\"",
            "server.toml, line 2: limits.connections = \"many\": it has to be a whole number from 1 to 65536",
        ),
        (
            "[listen]\naddress = \"localhost\"",
            "server.toml, line 2: listen.address = \"localhost\": it has to be an IP address and a port, as \
             \"127.0.0.1:7171\" or \"[::]:7171\"",
        ),
        (
            "[listen]\nhttp = 80",
            "server.toml, line 2: listen.http = 80: it has to be an IP address and a port, as \"127.0.0.1:7171\" or \
             \"[::]:7171\", or \"\" for none",
        ),
        (
            "[lobby]\ncreate = \"all\"",
            "server.toml, line 2: lobby.create = \"all\": it has to be one of \"anyone\", \"admin\"",
        ),
        (
            "[lobby]\nscenarios = [\"duel\"]",
            "server.toml, line 2: lobby.scenarios = [\"duel\"]: it has to be names and files: in a file { duel = \
             \"duel.toml\" }, elsewhere duel=duel.toml,rush=rush.toml",
        ),
        (
            "[listen]\ntls_key = \"k.pem\"",
            "server.toml, line 2: listen.tls_key needs listen.tls_certificate, which is not given; give it, or leave both \
             away",
        ),
        (
            "[listen]\ntls_certificate = \"c.pem\"",
            "server.toml, line 2: listen.tls_certificate needs listen.tls_key, which is not given; give it, or leave both \
             away",
        ),
        (
            "[listen]\nadmin_token_file = \"t\"",
            "server.toml, line 2: listen.admin_token_file needs listen.admin_socket, which is not given; give it, or leave \
             both away",
        ),
    ] {
        let found = resolve(Some(file), &[], &[]).and_then(|configuration| configuration.settings());
        assert_eq!(found.unwrap_err().to_string(), error);
    }
}

#[test]
fn every_mistake_in_the_environment_names_the_variable() {
    for (variable, value, error) in [
        (
            "MANIPLE_LIMITS_CONECTIONS",
            "1",
            "environment MANIPLE_LIMITS_CONECTIONS: [limits] has no key conections; it has connections, \
             connections_per_address, matches, matches_per_address, begin_seconds",
        ),
        (
            "MANIPLE_LOG_FORMAT",
            "xml",
            "environment MANIPLE_LOG_FORMAT: log.format = \"xml\": it has to be one of \"text\", \"json\"",
        ),
        (
            "MANIPLE_LIMITS_MATCHES",
            "-1",
            "environment MANIPLE_LIMITS_MATCHES: limits.matches = \"-1\": it has to be a whole number from 1 to 65536",
        ),
    ] {
        assert_eq!(resolve(None, &[(variable, value)], &[]).unwrap_err().to_string(), error);
    }
    for other in ["MANIPLE_TOKEN", "MANIPLE_LONG", "OTHER_LIMITS_CONNECTIONS", "PATH"] {
        assert!(resolve(None, &[(other, "x")], &[]).is_ok(), "{other} is of another program");
    }
}

#[test]
fn every_mistake_in_a_flag_names_the_flag() {
    assert_eq!(
        Flag::set("limits.connections").unwrap_err().to_string(),
        "--set limits.connections: write it as --set limits.connections=100"
    );
    let flag = Flag::named("--listen", &key::ADDRESS, "here".to_owned());
    assert_eq!(
        resolve(None, &[], &[flag]).unwrap_err().to_string(),
        "flag --listen: listen.address = \"here\": it has to be an IP address and a port, as \"127.0.0.1:7171\" or \
         \"[::]:7171\""
    );
    for (text, error) in [
        (
            "connections=1",
            "flag --set connections: connections stands in no section; write it below one of listen, lobby, limits, \
             journal, log, as in [limits]",
        ),
        (
            "limts.connections=1",
            "flag --set limts.connections: there is no section [limts]; the sections are listen, lobby, limits, journal, log",
        ),
        (
            "lobby.scenarios=a=1,a=2",
            "flag --set lobby.scenarios: lobby.scenarios = \"a=1,a=2\": it has to be names and files: in a file { duel = \
             \"duel.toml\" }, elsewhere duel=duel.toml,rush=rush.toml",
        ),
    ] {
        assert_eq!(resolve(None, &[], &[Flag::set(text).unwrap()]).unwrap_err().to_string(), error);
    }
}

#[test]
fn the_token_of_the_administration_is_beside_its_socket_unless_told() {
    let admin = |flags: &[&str]| {
        let flags: Vec<Flag> = flags.iter().map(|flag| Flag::set(flag).unwrap()).collect();
        let admin = resolve(None, &[], &flags).unwrap().settings().unwrap().listen.admin.unwrap();
        admin.token.display().to_string()
    };
    assert_eq!(admin(&["listen.admin_socket=/run/m.sock"]), "/run/m.sock.token");
    assert_eq!(admin(&["listen.admin_socket=/run/m.sock", "listen.admin_token_file=t"]), "t");
}

fn resolve(
    file: Option<&str>,
    environment: &[(&str, &str)],
    flags: &[Flag],
) -> Result<Configuration, SettingsError> {
    let file = file.map(|text| (Path::new("server.toml"), text));
    let environment = environment.iter().map(|(name, value)| (OsString::from(name), OsString::from(value)));
    Configuration::resolve(file, environment, flags)
}

/// Returns the comment above a line of the shipped file, as one line.
fn comment_above(line: usize) -> String {
    let lines: Vec<&str> = SHIPPED.lines().take(line).collect();
    let comment = lines.iter().rev().take_while(|line| line.starts_with("# "));
    let mut comment: Vec<&str> = comment.map(|line| &line[2..]).collect();
    comment.reverse();
    comment.join(" ")
}
