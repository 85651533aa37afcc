//! The daemon as those see it who operate it: HTTP, administration, TLS, and the service manager.

#![cfg(unix)]

use std::fs;
use std::io::{BufRead, BufReader, Read, Write};
use std::net::{SocketAddr, TcpListener, TcpStream};
use std::os::fd::OwnedFd;
use std::os::unix::net::UnixDatagram;
use std::path::Path;
use std::process::{Child, Command, Output, Stdio};
use std::time::Duration;

use maniple_client::{Client, ClientError, Destination, Lobby, Login};
use maniple_protocol::Refused;
use maniple_view::{ClockMode, Seat};
use serde_json::{Value, json};

use crate::commands::{ROOT, fails, file, folder, maniple};

/// Time for what comes at once; a daemon that does not say it is broken.
const PATIENCE: Duration = Duration::from_secs(60);

#[test]
fn the_daemon_tells_over_http_how_it_is() {
    let daemon = Daemon::start(maniple(&[
        "serve",
        "--listen",
        "127.0.0.1:0",
        "--json",
        "--set",
        "listen.http=127.0.0.1:0",
    ]));
    let http = daemon.opened["http"].as_str().unwrap();
    assert!(get(http, "/healthz").ends_with("\r\n\r\nready\n"));
    assert!(get(http, "/readyz").starts_with("HTTP/1.1 200 "));
    let matches = || -> Value {
        serde_json::from_str(get(http, "/matches").split("\r\n\r\n").nth(1).unwrap()).unwrap()
    };
    until(|| matches() != json!([]));
    let matches = matches();
    assert_eq!(matches[0]["match"], daemon.opened["match"]);
    assert_eq!((&matches[0]["phase"], &matches[0]["players"]), (&json!("open"), &json!(0)));
    fails(&["bot", "idle", "--connect", &daemon.address(), "--token", &"0".repeat(32)], 1);
    let metrics = get(http, "/metrics");
    assert!(metrics.contains("\nmaniple_refused_total{reason=\"token\"} 1\n"), "{metrics}");
    assert!(metrics.contains("\nmaniple_matches 1\n"), "{metrics}");
}

#[test]
fn a_stopped_daemon_lets_a_match_that_has_begun_come_to_its_end_unless_it_is_told_again() {
    let folder = folder("stopped");
    let duel = fs::read_to_string(format!("{ROOT}/config/scenarios/duel.toml")).unwrap();
    let lines =
        duel.lines().filter(|line| !line.starts_with("rate =") && !line.starts_with("length_seconds ="));
    let duel: Vec<&str> = lines.collect();
    for (seconds, is_told_again, code) in [(4, false, 0), (86_400, true, 130)] {
        let text = format!("rate = 100\nlength_seconds = {seconds}\n{}", duel.join("\n"));
        let scenario = file(&folder, "duel.toml", &text);
        let serve = ["serve", "--listen", "127.0.0.1:0", "--json", "--scenario", &scenario];
        let mut serve = maniple(&serve);
        serve.args(["--map", "maps/choke.tmx", "--set", "listen.http=127.0.0.1:0"]);
        let mut daemon = Daemon::start(serve);
        let address = daemon.address();
        let bot = |token: &String| {
            let bot = ["bot", "idle", "--connect", &address, "--token", token];
            maniple(&bot).stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap()
        };
        let bots: Vec<Child> = daemon.tokens().iter().map(bot).collect();
        let http = daemon.opened["http"].as_str().unwrap().to_owned();
        let listed = || -> Value {
            serde_json::from_str(get(&http, "/matches").split("\r\n\r\n").nth(1).unwrap()).unwrap()
        };
        until(|| listed()[0]["phase"] == "running");
        if is_told_again {
            let jitter = |quantile: &str| listed()[0]["timings_ms"]["jitter"][quantile].as_f64().unwrap();
            until(|| jitter("max") > 0.0 && jitter("p50") > 0.0);
        }
        signal(&daemon.child, "-TERM");
        if is_told_again {
            until(|| get(&http, "/readyz").starts_with("HTTP/1.1 503 "));
            signal(&daemon.child, "-TERM");
        }
        assert_eq!(daemon.child.wait().unwrap().code(), Some(code));
        for mut bot in bots {
            assert_eq!(bot.wait().unwrap().success(), !is_told_again);
        }
    }
}

#[test]
fn a_match_over_tls_is_played_and_counted() {
    let folder = folder("tls_match");
    let made = rcgen::generate_simple_self_signed(["127.0.0.1".to_owned()]).unwrap();
    let certificate = file(&folder, "certificate.pem", &made.cert.pem());
    let key = file(&folder, "key.pem", &made.signing_key.serialize_pem());
    let settings = [
        format!("listen.tls_certificate={certificate}"),
        format!("listen.tls_key={key}"),
        "listen.http=127.0.0.1:0".to_owned(),
    ];
    let mut serve = maniple(&["serve", "--listen", "127.0.0.1:0", "--json", "--clock", "lockstep"]);
    for setting in &settings {
        serve.args(["--set", setting]);
    }
    let daemon = Daemon::start(serve);
    let (address, tokens) = (daemon.address(), daemon.tokens());
    // Who does not encrypt is not heard. The token opens nothing: who got in would not come back.
    let nobody = "0".repeat(32);
    fails(&["bot", "idle", "--connect", &address, "--token", &nobody], 1);
    let mut plain = TcpStream::connect(&address).unwrap();
    plain.write_all(b"{\"ping\":{\"id\":1}}\n").unwrap();
    let mut said = Vec::new();
    // What was not read resets the connection behind the answer.
    let _ = plain.read_to_end(&mut said);
    assert!(!said.contains(&b'{'), "{}", String::from_utf8_lossy(&said));
    // Neither certificate nor name may be another.
    let other = rcgen::generate_simple_self_signed(["127.0.0.1".to_owned()]).unwrap();
    let other = file(&folder, "other.pem", &other.cert.pem());
    for (authority, name) in [(&other, "127.0.0.1"), (&certificate, "localhost")] {
        let bot = ["bot", "idle", "--connect", &address, "--token", &nobody, "--tls", "--ca", authority];
        let error = fails(&[&bot[..], &["--server-name", name]].concat(), 1);
        assert!(error.contains("no TLS with 127.0.0.1"), "{name}: {error}");
    }
    let error = fails(&["bot", "idle", "--connect", &address, "--tls", "--ca", "none.pem"], 3);
    assert!(error.contains("none.pem cannot be read"), "{error}");
    let play = |token: &str| {
        let mut bot = maniple(&[
            "bot",
            "straight",
            "--connect",
            &address,
            "--token",
            token,
            "--tls",
            "--ca",
            &certificate,
        ]);
        bot.args(["--json"]).stdout(Stdio::piped()).spawn().unwrap()
    };
    let bots = [play(&tokens[0]), play(&tokens[1])];
    let results = bots.map(|bot| {
        let output = bot.wait_with_output().unwrap();
        assert!(output.status.success());
        serde_json::from_slice::<Value>(&output.stdout).unwrap()["result"].clone()
    });
    assert_eq!(results[0], results[1]);
    let cycles = results[0]["cycles"].as_u64().unwrap();
    let metrics = || get(daemon.opened["http"].as_str().unwrap(), "/metrics");
    let ended = |how: &str| figure(&metrics(), &format!("maniple_matches_ended_total{{how=\"{how}\"}}"));
    until(|| ended("won") + ended("drawn") == 1);
    let metrics = metrics();
    assert_eq!(figure(&metrics, "maniple_cycle_seconds_count"), cycles, "{metrics}");
    assert!(figure(&metrics, "maniple_command_results_total{kind=\"applied\"}") > 0, "{metrics}");
    assert!(figure(&metrics, "maniple_bytes_sent_total") > figure(&metrics, "maniple_bytes_received_total"));
}

#[expect(clippy::too_many_lines, reason = "the life of one daemon, from its beginning to its end")]
#[test]
fn the_administration_acts_on_a_running_daemon() {
    let folder = folder("administration");
    // A path of a socket has about a hundred bytes at most, so it is given from the folder.
    let serve = [
        "serve",
        "--listen",
        "127.0.0.1:0",
        "--json",
        "--set",
        "listen.admin_socket=a.sock",
        "--config",
        "server.toml",
    ];
    file(&folder, "server.toml", "[limits]\nconnections = 100\n");
    let mut command = maniple(&serve);
    command.current_dir(&folder);
    let mut daemon = Daemon::start(command);
    let id = daemon.opened["match"].as_str().unwrap().to_owned();
    let admin = |arguments: &[&str]| {
        let mut command = maniple(&["admin", "--socket", "a.sock", "--json"]);
        let output =
            command.args(arguments).current_dir(&folder).env_remove("MANIPLE_ADMIN_TOKEN").output().unwrap();
        let error = String::from_utf8(output.stderr).unwrap();
        if output.status.success() {
            Ok(serde_json::from_slice::<Value>(&output.stdout).unwrap())
        } else {
            Err(error)
        }
    };
    until(|| admin(&["list"]).unwrap()["matches"] != json!([]));
    let list = admin(&["list"]).unwrap();
    assert_eq!((&list["matches"][0]["match"], &list["matches"][0]["phase"]), (&json!(id), &json!("open")));
    for (arguments, expected) in [
        (&["kick", &id, "1"][..], "nobody is at seat 1"),
        (&["kick", &id, "2"], "the match has 2 seats"),
        (&["end", "00000000000000aa"], "there is no match 00000000000000aa"),
        (&["--token", "guess", "drain"], "the token is not that of the administration"),
    ] {
        let error = admin(arguments).unwrap_err();
        assert!(error.contains(expected), "{arguments:?}: {error}");
    }
    // Who is at a seat is put out, and may come back.
    let tokens = daemon.tokens();
    let bot = || {
        let bot = ["bot", "idle", "--connect", &daemon.address(), "--token", &tokens[0]];
        maniple(&bot).stderr(Stdio::piped()).spawn().unwrap()
    };
    let first = bot();
    until(|| admin(&["list"]).unwrap()["matches"][0]["players"] == 1);
    assert_eq!(admin(&["kick", &id, "0"]).unwrap(), json!("done"));
    let output = ended(first);
    assert!(
        String::from_utf8_lossy(&output.stderr)
            .contains("whoever runs the server has closed this connection"),
        "{output:?}"
    );
    // A banned address is put out and does not come back, until it may.
    let mut second = bot();
    until(|| admin(&["list"]).unwrap()["matches"][0]["players"] == 1);
    assert_eq!(admin(&["ban", "127.0.0.1"]).unwrap(), json!("done"));
    until(|| admin(&["list"]).unwrap()["matches"][0]["players"] == 0);
    // It would try for a minute to come back.
    second.kill().unwrap();
    second.wait().unwrap();
    assert_eq!(ended(bot()).status.code(), Some(1));
    assert_eq!(admin(&["ban", "127.0.0.1", "--off"]).unwrap(), json!("done"));
    let third = bot();
    until(|| admin(&["list"]).unwrap()["matches"][0]["players"] == 1);
    // Limits are read again, and mistakes change nothing.
    file(&folder, "server.toml", "[limits]\nconnections = 200\n");
    assert_eq!(admin(&["reload"]).unwrap()["limits"]["connections"], 200);
    file(&folder, "server.toml", "[limits]\nconnections = 0\n");
    assert!(admin(&["reload"]).unwrap_err().contains("server.toml, line 2: limits.connections = 0"));
    // The clock of a match that runs is halted, and goes on.
    let other = ["bot", "idle", "--connect", &daemon.address(), "--token", &tokens[1]];
    let fourth = maniple(&other).stderr(Stdio::piped()).spawn().unwrap();
    until(|| admin(&["list"]).unwrap()["matches"][0]["phase"] == "running");
    assert_eq!(admin(&["pause", &id]).unwrap(), json!("done"));
    until(|| admin(&["list"]).unwrap()["matches"][0]["phase"] == "paused");
    assert_eq!(admin(&["pause", &id, "--off"]).unwrap(), json!("done"));
    until(|| admin(&["list"]).unwrap()["matches"][0]["phase"] == "running");
    // It ends when the match does, and takes no more.
    assert_eq!(admin(&["drain"]).unwrap(), json!("done"));
    assert_eq!(admin(&["end", &id]).unwrap(), json!("done"));
    for bot in [third, fourth] {
        assert!(!ended(bot).status.success());
    }
    until(|| daemon.child.try_wait().unwrap().is_some());
    assert!(!folder.join("a.sock").exists());
    assert!(admin(&["list"]).unwrap_err().contains("no daemon answers at a.sock"));
}

#[test]
fn the_service_manager_is_told_when_the_daemon_begins_works_and_ends() {
    let folder = folder("service_manager");
    let path = short_path("notify");
    let manager = UnixDatagram::bind(&path).unwrap();
    manager.set_read_timeout(Some(PATIENCE)).unwrap();
    let mut serve = maniple(&["serve", "--listen", "127.0.0.1:0", "--json"]);
    serve.env("NOTIFY_SOCKET", &path).env("WATCHDOG_USEC", "200000").current_dir(&folder);
    let mut daemon = Daemon::start(serve);
    let said = || {
        let mut said = [0; 256];
        let count = manager.recv(&mut said).expect("the daemon says something");
        String::from_utf8_lossy(&said[..count]).into_owned()
    };
    // It may say that it works before clients can connect, and not for long.
    let first = (0..1000).map(|_| said()).find(|said| said != "WATCHDOG=1\n");
    let first = first.expect("it says that it is ready");
    assert!(first.starts_with("READY=1\n") && first.contains(&daemon.address()), "{first}");
    for _ in 0..3 {
        assert_eq!(said(), "WATCHDOG=1\n");
    }
    signal(&daemon.child, "-TERM");
    while said() != "STOPPING=1\n" {}
    daemon.child.wait().unwrap();
    fs::remove_file(&path).unwrap();
}

#[test]
fn a_socket_of_the_service_manager_is_the_port() {
    let socket = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = socket.local_addr().unwrap();
    let daemon = Daemon::start(activated(OwnedFd::from(socket), 1, &[]));
    assert_eq!(daemon.address(), address.to_string());
    fails(&["bot", "idle", "--connect", &daemon.address(), "--token", &"0".repeat(32)], 1);
    // What is no port is told.
    let (socket, _other) = UnixDatagram::pair().unwrap();
    let output = activated(OwnedFd::from(socket), 1, &["--once"]).output().unwrap();
    let error = String::from_utf8_lossy(&output.stderr);
    assert!(error.contains("the socket that the service manager hands over cannot be used"), "{error}");
    let socket = TcpListener::bind("127.0.0.1:0").unwrap();
    let output = activated(OwnedFd::from(socket), 2, &["--once"]).output().unwrap();
    let error = String::from_utf8_lossy(&output.stderr);
    assert!(error.contains("hands over 2 sockets, but there is use for one"), "{error}");
}

#[test]
fn where_the_administration_alone_creates_matches_clients_do_not() {
    let folder = folder("admin_creates");
    let duel = format!("{ROOT}/config/scenarios/duel.toml");
    let scenarios = format!("lobby.scenarios=duel={duel}");
    let mut command =
        maniple(&["serve", "--listen", "127.0.0.1:0", "--json", "--set", "listen.admin_socket=a.sock"]);
    command.args(["--set", &scenarios, "--set", "lobby.create=admin"]).current_dir(&folder);
    let daemon = Daemon::start(command);
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build().unwrap();
    runtime.block_on(async {
        let mut lobby = Lobby::connect(&daemon.address()).await.unwrap();
        assert_eq!(lobby.list().await.unwrap().scenarios, [""; 0]);
        let refused = lobby.create("duel", ClockMode::Lockstep, false).await.unwrap_err();
        assert!(matches!(refused, ClientError::Refused(Refused::NoScenario)), "{refused}");
    });
    let admin = |arguments: &[&str]| {
        let mut command = maniple(&["admin", "--socket", "a.sock", "--json"]);
        command.args(arguments).current_dir(&folder).env_remove("MANIPLE_ADMIN_TOKEN").output().unwrap()
    };
    let created = admin(&["create", "duel", "--clock", "lockstep"]);
    let created: Value = serde_json::from_slice(&created.stdout).unwrap();
    let id = created["created"]["match"].as_str().unwrap().parse().unwrap();
    let login = |seat: usize| Login {
        token: created["created"]["tokens"][seat].as_str().unwrap().to_owned(),
        player: "Ada".to_owned(),
        ..Login::default()
    };
    runtime.block_on(async {
        let destination = || Destination::of_match(daemon.address(), id);
        let (one, other) =
            (Client::connect(destination(), login(0)).await, Client::connect(destination(), login(1)).await);
        assert_eq!((one.unwrap().seat(), other.unwrap().seat()), (Seat(0), Seat(1)));
    });
    let error = String::from_utf8(admin(&["create", "rush"]).stderr).unwrap();
    assert!(error.contains("choose one of those that `list` names"), "{error}");
}

/// A daemon that is killed when it is dropped.
struct Daemon {
    child: Child,
    opened: Value,
}

impl Daemon {
    fn start(mut serve: Command) -> Self {
        let mut child = serve.stdout(Stdio::piped()).spawn().unwrap();
        let mut lines = BufReader::new(child.stdout.take().unwrap()).lines();
        let opened = serde_json::from_str(&lines.next().unwrap().unwrap()).unwrap();
        std::thread::spawn(move || lines.for_each(drop));
        Self { child, opened }
    }

    fn address(&self) -> String {
        self.opened["address"].as_str().unwrap().to_owned()
    }

    fn tokens(&self) -> Vec<String> {
        let seats = self.opened["seats"].as_array().unwrap();
        seats.iter().map(|seat| seat["token"].as_str().unwrap().to_owned()).collect()
    }
}

impl Drop for Daemon {
    fn drop(&mut self) {
        // It may have ended by itself.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// Returns a daemon that is handed its first sockets as a service manager does it: from descriptor 3 on.
fn activated(socket: OwnedFd, count: usize, more: &[&str]) -> Command {
    let serve = format!("export LISTEN_FDS={count} LISTEN_PID=$$; exec \"$0\" \"$@\" 3<&0 4<&0 </dev/null");
    let program = env!("CARGO_BIN_EXE_maniple");
    let mut command = Command::new("sh");
    command.args(["-c", &serve, program, "serve", "--json"]).args(more).stdin(socket).current_dir(ROOT);
    command
}

fn signal(child: &Child, name: &str) {
    assert!(Command::new("kill").args([name, &child.id().to_string()]).status().unwrap().success());
}

/// Returns a path for a socket, which has to be short.
fn short_path(name: &str) -> std::path::PathBuf {
    let path = std::env::temp_dir().join(format!("maniple-{name}-{}", std::process::id()));
    let _ = fs::remove_file(&path);
    assert!(Path::new(&path).as_os_str().len() < 100);
    path
}

/// Waits for a program that ends at once; one that does not is broken.
fn ended(mut child: Child) -> Output {
    let begun = std::time::Instant::now();
    while child.try_wait().unwrap().is_none() {
        if begun.elapsed() >= PATIENCE {
            child.kill().unwrap();
            panic!("it does not end: {:?}", child.wait_with_output().unwrap());
        }
        std::thread::sleep(Duration::from_millis(20));
    }
    child.wait_with_output().unwrap()
}

/// Waits until something holds that is bound to.
fn until(mut holds: impl FnMut() -> bool) {
    let begun = std::time::Instant::now();
    while !holds() {
        assert!(begun.elapsed() < PATIENCE, "it does not come");
        std::thread::sleep(Duration::from_millis(20));
    }
}

fn get(address: &str, path: &str) -> String {
    let address: SocketAddr = address.parse().unwrap();
    let mut stream = TcpStream::connect(address).unwrap();
    write!(stream, "GET {path} HTTP/1.1\r\nhost: x\r\n\r\n").unwrap();
    let mut said = String::new();
    stream.read_to_string(&mut said).unwrap();
    said
}

/// Returns the figure with this name and these labels.
fn figure(metrics: &str, name: &str) -> u64 {
    let line = metrics.lines().find_map(|line| line.strip_prefix(name)?.strip_prefix(' '));
    line.unwrap_or_else(|| panic!("no {name} in {metrics}")).parse().unwrap()
}
