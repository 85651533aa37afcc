use std::fs;
use std::io::ErrorKind::UnexpectedEof;
use std::os::unix::fs::PermissionsExt;
use std::path::PathBuf;
use std::time::Duration;

use serde_json::{Value, json};
use tokio::io::{AsyncBufReadExt, AsyncReadExt, AsyncWriteExt, BufReader};
use tokio::net::UnixStream;
use tokio::time::Instant;

use super::*;
use crate::operation::Health;
use crate::operation::double::Double;

const ID: &str = "0000000000000007";

const LIMITS: Limits = Limits {
    connections: 1,
    connections_per_address: 2,
    matches: 3,
    matches_per_address: 4,
    begin_within: Duration::from_secs(5),
};

#[test]
fn every_verb_is_done_with_the_token() {
    let (daemon, administration, token) = administration();
    for (verb, told, done) in [
        (json!("list"), None, None),
        (
            json!({"create": {"scenario": "duel", "clock": "lockstep", "seats": "tokens"}}),
            Some(json!({"created": {"match": ID, "tokens": ["one", "other"]}})),
            Some("create Lockstep Tokens".to_owned()),
        ),
        (
            json!({"pause": {"match": ID, "clock": "halt"}}),
            Some(json!("done")),
            Some(format!("pause {ID} Halt")),
        ),
        (
            json!({"pause": {"match": ID, "clock": "go_on"}}),
            Some(json!("done")),
            Some(format!("pause {ID} GoOn")),
        ),
        (json!({"end": {"match": ID}}), Some(json!("done")), Some(format!("end {ID}"))),
        (json!({"kick": {"match": ID, "seat": 0}}), Some(json!("done")), Some(format!("kick {ID} 0"))),
        (
            json!({"ban": {"address": "192.0.2.1", "entry": "denied"}}),
            Some(json!("done")),
            Some("ban 192.0.2.1 Denied".to_owned()),
        ),
        (
            json!({"ban": {"address": "2001:db8::1", "entry": "allowed"}}),
            Some(json!("done")),
            Some("ban 2001:db8::1 Allowed".to_owned()),
        ),
        (json!("drain"), Some(json!("done")), Some("drain".to_owned())),
        (
            json!("reload"),
            Some(json!({"limits": {
                "connections": 1, "connections_per_address": 2, "matches": 3, "matches_per_address": 4,
                "begin_seconds": 5,
            }})),
            Some(format!("limits {LIMITS:?}")),
        ),
    ] {
        let answer = ask(&administration, &json!({"token": token.to_string(), "do": verb}));
        match told {
            Some(told) => assert_eq!(answer, json!({"ok": told})),
            None => assert_eq!(answer["ok"]["matches"][0]["match"], ID),
        }
        assert_eq!(daemon.done(), done.into_iter().collect::<Vec<_>>(), "{verb}");
    }
}

#[test]
fn no_verb_is_done_without_the_token() {
    let (daemon, administration, token) = administration();
    let off_by_a_bit = {
        let mut digits = token.to_string();
        let last = digits.pop().unwrap().to_digit(16).unwrap();
        digits.push(char::from_digit(last ^ 1, 16).unwrap());
        digits
    };
    let other = Token::random().unwrap().to_string();
    for guess in ["", "x", &other, &off_by_a_bit, &token.to_string()[..31], &format!("{token} ")] {
        for verb in [json!("list"), json!("drain"), json!({"end": {"match": ID}}), json!("reload")] {
            let answer = ask(&administration, &json!({"token": guess, "do": verb}));
            assert_eq!(answer["error"], "token", "{guess} {verb}");
            assert!(answer.get("ok").is_none());
        }
    }
    assert_eq!(daemon.done(), [""; 0]);
}

#[test]
fn what_cannot_be_done_says_why_and_what_to_do() {
    let (daemon, administration, token) = administration();
    let nowhere = "00000000000000ff";
    for (verb, error, message) in [
        (
            json!({"end": {"match": nowhere}}),
            json!({"operation": {"reason": {"no_such_match": {"id": nowhere}}}}),
            "there is no match 00000000000000ff; `list` has those that there are",
        ),
        (
            json!({"create": {"scenario": "rush", "clock": "realtime", "seats": "open"}}),
            json!({"operation": {"reason": {"not_created": {"reason": "no_scenario"}}}}),
            "clients of this server create no match of this scenario; choose one of those that `list` names",
        ),
        (
            json!({"kick": {"match": ID, "seat": 1}}),
            json!({"operation": {"reason": {"nobody_there": {"seat": 1}}}}),
            "nobody is at seat 1",
        ),
        (
            json!({"kick": {"match": ID, "seat": 2}}),
            json!({"operation": {"reason": {"no_such_seat": {"seats": 2}}}}),
            "the match has 2 seats, counted from 0, and not this one; name one of them",
        ),
    ] {
        let answer = ask(&administration, &json!({"token": token.to_string(), "do": verb}));
        assert_eq!(answer, json!({"error": error, "message": message}));
    }
    assert_eq!(daemon.done(), [""; 0]);
}

#[test]
fn what_is_no_request_is_refused() {
    let (daemon, administration, token) = administration();
    for line in [
        String::new(),
        "list".to_owned(),
        format!("{{\"token\": \"{token}\"}}"),
        format!("{{\"token\": \"{token}\", \"do\": \"explode\"}}"),
        format!("{{\"token\": \"{token}\", \"do\": \"drain\", \"now\": true}}"),
        format!("{{\"token\": \"{token}\", \"do\": {{\"end\": {{\"match\": \"7\"}}}}}}"),
        format!(
            "{{\"token\": \"{token}\", \"do\": {{\"ban\": {{\"address\": \"here\", \"entry\": \"denied\"}}}}}}"
        ),
    ] {
        let Answer::Refused { error, message } = answer(&administration, line.as_bytes()) else {
            panic!("{line} was done");
        };
        assert!(matches!(error, AdminError::Malformed { .. }), "{line}");
        assert!(message.starts_with("this is no request: "), "{message}");
        assert!(!message.contains(&token.to_string()), "{message}");
    }
    assert_eq!(daemon.done(), [""; 0]);
}

#[test]
fn limits_that_cannot_be_read_change_nothing() {
    let daemon = Arc::new(Double::new(Health::Ready));
    let token = Token::random().unwrap();
    let reload = Box::new(|| Err("server.toml, line 2: no".to_owned()));
    let administration = Administration::new(daemon.clone(), Arc::default(), token, reload);
    let answer = ask(&administration, &json!({"token": token.to_string(), "do": "reload"}));
    assert_eq!(answer["message"], "nothing is changed: server.toml, line 2: no");
    assert_eq!(daemon.done(), [""; 0]);
}

#[tokio::test]
async fn over_the_socket_lines_are_answered_by_lines() {
    let folder = Folder::new("lines");
    let (daemon, administration, token) = administration();
    let path = folder.0.join("admin.sock");
    let server = AdminServer::bind(&path).unwrap();
    assert_eq!(fs::metadata(&path).unwrap().permissions().mode() & 0o777, 0o600);
    let running = tokio::spawn(server.run(Arc::new(administration)));
    let mut stream = BufReader::new(UnixStream::connect(&path).await.unwrap());
    for _ in 0..2 {
        let request = json!({"token": token.to_string(), "do": "drain"});
        stream.write_all(format!("{request}\n").as_bytes()).await.unwrap();
        assert_eq!(line(&mut stream).await, json!({"ok": "done"}));
    }
    assert_eq!(daemon.done(), ["drain", "drain"]);
    let there = path.clone();
    let asked = spawn_blocking(move || {
        let mut client = AdminClient::connect(&there).unwrap();
        let matches = client.ask(&token.to_string(), Verb::List).unwrap();
        assert_eq!(matches["matches"][0]["scenario"], "duel");
        client.ask("guess", Verb::List).unwrap_err().to_string()
    });
    assert!(asked.await.unwrap().starts_with("the token is not that of the administration"));
    running.abort();
    assert!(running.await.unwrap_err().is_cancelled());
    assert!(!path.exists(), "the socket goes with the server");
    let gone = AdminClient::connect(&path).unwrap_err().to_string();
    assert!(gone.starts_with(&format!("no daemon answers at {}: ", path.display())), "{gone}");
}

#[tokio::test(start_paused = true)]
async fn a_line_that_is_too_long_is_the_last() {
    let folder = Folder::new("long");
    let (_, administration, token) = administration();
    let path = folder.0.join("admin.sock");
    let running = tokio::spawn(AdminServer::bind(&path).unwrap().run(Arc::new(administration)));
    // With as much as may be, it is read.
    let mut stream = BufReader::new(UnixStream::connect(&path).await.unwrap());
    let request = json!({"token": token.to_string(), "do": "drain"}).to_string();
    let padded = format!("{request:ADMIN_LINE_MAX$}\n");
    stream.write_all(padded.as_bytes()).await.unwrap();
    assert_eq!(line(&mut stream).await, json!({"ok": "done"}));
    let padded = format!("{request:width$}\n", width = ADMIN_LINE_MAX + 1);
    stream.write_all(padded.as_bytes()).await.unwrap();
    assert_eq!(line(&mut stream).await["error"], json!({"too_long": {"limit": ADMIN_LINE_MAX}}));
    let mut rest = String::new();
    assert_eq!(stream.read_line(&mut rest).await.unwrap(), 0, "{rest}");
    // Nobody waits for the end of one that is too long already.
    let mut stream = BufReader::new(UnixStream::connect(&path).await.unwrap());
    stream.write_all(&[b' '; ADMIN_LINE_MAX + 2]).await.unwrap();
    assert_eq!(line(&mut stream).await["error"], json!({"too_long": {"limit": ADMIN_LINE_MAX}}));
    running.abort();
}

#[tokio::test(start_paused = true)]
async fn who_says_nothing_at_the_socket_is_cut_off_and_holds_nobody_up_for_longer() {
    let folder = Folder::new("silent");
    let (_, administration, token) = administration();
    let path = folder.0.join("admin.sock");
    let running = tokio::spawn(AdminServer::bind(&path).unwrap().run(Arc::new(administration)));
    let mut silent = Vec::new();
    for _ in 0..ADMIN_CONNECTIONS_MAX {
        let mut stream = UnixStream::connect(&path).await.unwrap();
        stream.write_all(b"{\"token\": \"").await.unwrap();
        silent.push(stream);
    }
    let begun = Instant::now();
    let mut stream = BufReader::new(UnixStream::connect(&path).await.unwrap());
    let request = json!({"token": token.to_string(), "do": "drain"});
    stream.write_all(format!("{request}\n").as_bytes()).await.unwrap();
    assert_eq!(line(&mut stream).await, json!({"ok": "done"}));
    assert!(
        (ADMIN_TIMEOUT..2 * ADMIN_TIMEOUT).contains(&begun.elapsed()),
        "all places were taken, and not for long"
    );
    for mut stream in silent {
        assert!(matches!(stream.read_u8().await.map_err(|error| error.kind()), Err(UnexpectedEof)));
    }
    running.abort();
}

#[tokio::test(start_paused = true)]
async fn who_takes_no_answer_of_the_administration_is_cut_off() {
    let folder = Folder::new("deaf");
    let (_, administration, token) = administration();
    let path = folder.0.join("admin.sock");
    let running = tokio::spawn(AdminServer::bind(&path).unwrap().run(Arc::new(administration)));
    let mut deaf = UnixStream::connect(&path).await.unwrap();
    let request = format!("{}\n", json!({"token": token.to_string(), "do": "list"}));
    let begun = Instant::now();
    // Until both directions are full, and then until the server gives up.
    while deaf.write_all(request.as_bytes()).await.is_ok() {}
    assert!((ADMIN_TIMEOUT..2 * ADMIN_TIMEOUT).contains(&begun.elapsed()), "{:?}", begun.elapsed());
    running.abort();
}

#[tokio::test]
async fn a_socket_that_was_left_behind_is_cleared_and_nothing_else_is() {
    let folder = Folder::new("left");
    let path = folder.0.join("admin.sock");
    // A listener of the standard library does not clear away: as a daemon that was killed.
    drop(std::os::unix::net::UnixListener::bind(&path).unwrap());
    let server = AdminServer::bind(&path).unwrap();
    assert!(matches!(AdminServer::bind(&path), Err(AdminSocketError::InUse { .. })));
    drop(server);
    fs::write(&path, "precious").unwrap();
    assert!(matches!(AdminServer::bind(&path), Err(AdminSocketError::NoSocket { .. })));
    assert_eq!(fs::read_to_string(&path).unwrap(), "precious");
    assert!(matches!(AdminServer::bind(&folder.0.join("no/such.sock")), Err(AdminSocketError::Bind { .. })));
}

#[test]
fn the_token_is_made_once_and_for_the_owner_alone() {
    let folder = Folder::new("token");
    let path = folder.0.join("token");
    let made = admin_token(&path).unwrap();
    assert_eq!(fs::metadata(&path).unwrap().permissions().mode() & 0o777, 0o600);
    assert!(admin_token(&path).unwrap().is_same(made));
    fs::set_permissions(&path, fs::Permissions::from_mode(0o640)).unwrap();
    let error = admin_token(&path).unwrap_err().to_string();
    assert_eq!(error, format!("others than the owner may read {0}; run `chmod 600` on it", path.display()));
    fs::set_permissions(&path, fs::Permissions::from_mode(0o600)).unwrap();
    fs::write(&path, "secret").unwrap();
    assert!(matches!(admin_token(&path), Err(AdminSocketError::NoToken { .. })));
    assert!(matches!(admin_token(&folder.0.join("no/token")), Err(AdminSocketError::TokenFile { .. })));
}

fn administration() -> (Arc<Double>, Administration, Token) {
    let daemon = Arc::new(Double::new(Health::Ready));
    let token = Token::random().unwrap();
    let administration = Administration::new(daemon.clone(), Arc::default(), token, Box::new(|| Ok(LIMITS)));
    (daemon, administration, token)
}

fn ask(administration: &Administration, request: &Value) -> Value {
    serde_json::to_value(answer(administration, request.to_string().as_bytes())).unwrap()
}

fn answer(administration: &Administration, line: &[u8]) -> Answer {
    let runtime = tokio::runtime::Builder::new_current_thread().build().unwrap();
    runtime.block_on(administration.answer(line))
}

async fn line(stream: &mut BufReader<UnixStream>) -> Value {
    let mut line = String::new();
    stream.read_line(&mut line).await.unwrap();
    serde_json::from_str(&line).unwrap_or_else(|error| panic!("{line}: {error}"))
}

/// A folder of a test's own, which is gone when it is dropped.
struct Folder(PathBuf);

impl Folder {
    fn new(name: &str) -> Self {
        let folder = std::env::temp_dir().join(format!("maniple-admin-{name}-{}", std::process::id()));
        fs::create_dir_all(&folder).unwrap();
        Self(folder)
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}
