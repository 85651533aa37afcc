use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::time::Instant;

use super::*;
use crate::operation::Health;
use crate::operation::double::Double;

#[tokio::test]
async fn health_and_readiness_are_told_by_status_and_word() {
    for (health, alive, ready, word) in [
        (Health::Ready, 200, 200, "ready"),
        (Health::Starting, 200, 503, "starting"),
        (Health::Draining, 200, 503, "draining"),
        (Health::Stuck, 503, 503, "stuck"),
    ] {
        let address = open(health).await;
        for (path, status) in [("/healthz", alive), ("/readyz", ready)] {
            let said = ask(address, &get(path)).await;
            assert!(said.starts_with(&format!("HTTP/1.1 {status} ")), "{path}: {said}");
            assert!(said.ends_with(&format!("\r\n\r\n{word}\n")), "{path}: {said}");
        }
    }
}

#[tokio::test]
async fn metrics_are_open_metrics_and_matches_are_json() {
    let address = open(Health::Ready).await;
    let said = ask(address, &get("/metrics")).await;
    assert!(
        said.contains("content-type: application/openmetrics-text; version=1.0.0; charset=utf-8\r\n"),
        "{said}"
    );
    assert!(said.contains("\nmaniple_bytes_sent_total 5\n") && said.ends_with("# EOF\n"), "{said}");
    let said = ask(address, &get("/matches")).await;
    let body = said.split("\r\n\r\n").nth(1).unwrap();
    let expected = serde_json::json!([{
        "match": "0000000000000007", "scenario": "duel", "clock": "realtime", "phase": "running", "cycle": 12,
        "seats": 2, "players": 1, "spectators": 3, "timings_ms": {
            "cycle": { "p50": 0.125, "p99": 0.25, "max": 0.5 },
            "lateness": { "p50": 0.25, "p99": 0.5, "max": 1.0 },
            "jitter": { "p50": 0.375, "p99": 0.75, "max": 1.5 },
        },
    }]);
    assert_eq!(serde_json::from_str::<serde_json::Value>(body).unwrap(), expected);
}

#[tokio::test]
async fn other_paths_methods_and_languages_are_refused() {
    let address = open(Health::Ready).await;
    assert!(ask(address, &get("/")).await.starts_with("HTTP/1.1 404 "));
    let post = "POST /matches HTTP/1.1\r\nhost: x\r\ncontent-length: 0\r\n\r\n";
    assert!(ask(address, post).await.starts_with("HTTP/1.1 405 "));
    assert!(ask(address, "MANIPLE1\r\n\r\n").await.starts_with("HTTP/1.1 400 "));
    for (length, status) in [(HTTP_REQUEST_MAX - 100, 404), (HTTP_REQUEST_MAX, 431)] {
        let said = ask(address, &get(&format!("/{}", "x".repeat(length)))).await;
        assert!(said.starts_with(&format!("HTTP/1.1 {status} ")), "{length}: {said}");
    }
}

#[tokio::test(start_paused = true)]
async fn who_is_slow_is_cut_off_and_holds_nobody_up() {
    let address = open(Health::Ready).await;
    let mut slow = Vec::new();
    for _ in 0..HTTP_CONNECTIONS_MAX {
        let mut stream = TcpStream::connect(address).await.unwrap();
        stream.write_all(b"GET /he").await.unwrap();
        slow.push(stream);
    }
    let begun = Instant::now();
    let said = ask(address, &get("/healthz")).await;
    assert!(said.starts_with("HTTP/1.1 200 "), "{said}");
    assert!(
        (HTTP_TIMEOUT..2 * HTTP_TIMEOUT).contains(&begun.elapsed()),
        "all places were taken, and not for long"
    );
    for mut stream in slow {
        assert!(stream.read_u8().await.is_err(), "it was closed");
    }
}

async fn open(health: Health) -> SocketAddr {
    let server = HttpServer::bind("127.0.0.1:0".parse().unwrap()).await.unwrap();
    let address = server.local_addr().unwrap();
    let metrics = Arc::new(Metrics::default());
    metrics.bytes_sent.add(5);
    tokio::spawn(server.run(Arc::new(Double::new(health)), metrics));
    address
}

fn get(path: &str) -> String {
    format!("GET {path} HTTP/1.1\r\nhost: x\r\n\r\n")
}

async fn ask(address: SocketAddr, request: &str) -> String {
    let mut stream = TcpStream::connect(address).await.unwrap();
    stream.write_all(request.as_bytes()).await.unwrap();
    let mut said = Vec::new();
    // What is refused before it is read resets the connection behind the answer.
    let _ = stream.read_to_end(&mut said).await;
    String::from_utf8(said).unwrap()
}
