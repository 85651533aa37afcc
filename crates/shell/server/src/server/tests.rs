use maniple_protocol::{Encoding, PROTOCOL, ServerMessage, decode_server};
use tokio::io::{AsyncBufReadExt, AsyncReadExt, AsyncWriteExt, BufReader, DuplexStream, duplex, split};
use tokio::time::{Instant, sleep};

use super::*;
use crate::connection::{DISCARD_SILENCE, TURN_AWAY_TIMEOUT};
use crate::operation::{Entry, Operated};
use crate::queue::FLUSH_TIMEOUT;
use crate::socket::{SEND_BUFFER_SIZE, UNSENT_MAX};

/// Simulated time in which everything here has happened long ago, or never will.
const FOR_EVER: Duration = Duration::from_secs(3600);

#[tokio::test(start_paused = true)]
async fn a_hello_has_so_much_time_however_it_comes() {
    for first in ["", "{", "MNPL"] {
        let (mut reader, mut writer) = split(come(&house(1, 1), 1024));
        let begun = Instant::now();
        let dribble = async {
            writer.write_all(first.as_bytes()).await.unwrap();
            while !first.is_empty() && writer.write_all(b" ").await.is_ok() {
                sleep(HELLO_TIMEOUT / 2).await;
            }
            std::future::pending::<()>().await;
        };
        let mut said = Vec::new();
        tokio::select! {
            read = timeout(FOR_EVER, reader.read_to_end(&mut said)) => drop(read.expect("it is closed").unwrap()),
            () = dribble => {}
        }
        assert_eq!(begun.elapsed(), HELLO_TIMEOUT, "{first}");
        if first != "MNPL" {
            assert_eq!(refused(&said), Refused::Timeout { seconds: 5 }, "{first}");
        }
    }
}

#[tokio::test(start_paused = true)]
async fn who_does_not_take_an_answer_is_given_up() {
    for (says, limit) in [
        (format!("{{\"list\":{{\"protocol\":{PROTOCOL}}}}}\n"), FLUSH_TIMEOUT + DISCARD_SILENCE),
        ("{\"ping\":{\"id\":1}}\n".to_owned(), FLUSH_TIMEOUT + DISCARD_SILENCE),
    ] {
        let house = house(1, 1);
        let mut deaf = come(&house, 8);
        deaf.write_all(says.as_bytes()).await.unwrap();
        assert_eq!(time_until_one_may_come(&house).await, limit, "{says}");
    }
}

#[tokio::test(start_paused = true)]
async fn who_is_one_too_many_is_told_and_has_no_time_to_lose() {
    let (house, begun) = (house(2, 1), Instant::now());
    let _first = come(&house, 1024);
    let mut second = come(&house, 1024);
    assert_eq!(refused(&all_said(&mut second).await), Refused::AddressFull { limit: 1 });
    assert_eq!(begun.elapsed(), TURN_AWAY_TIMEOUT);
    assert_eq!(time_until_one_may_come(&house).await, TURN_AWAY_TIMEOUT, "it does not go by itself");
}

#[tokio::test(start_paused = true)]
async fn who_is_one_too_many_and_takes_no_answer_is_given_up() {
    let house = house(2, 1);
    let _first = come(&house, 1024);
    let _deaf = come(&house, 1);
    let limit = TURN_AWAY_TIMEOUT + FLUSH_TIMEOUT + TURN_AWAY_TIMEOUT;
    assert_eq!(time_until_one_may_come(&house).await, limit);
}

#[tokio::test(start_paused = true)]
async fn limits_can_be_changed_in_both_directions_and_who_is_in_stays_in() {
    let house = house(1, 9);
    let limits = |connections| Limits { connections, ..house.lobby().limits() };
    let mut first = come(&house, 1024);
    assert!(!is_in(&mut come(&house, 1024)).await, "there is one place");
    house.change_limits(limits(3));
    let (mut second, third) = (come(&house, 1024), come(&house, 1024));
    assert!(is_in(&mut second).await && !is_in(&mut come(&house, 1024)).await, "there are three");
    house.change_limits(limits(1));
    assert!(is_in(&mut first).await && is_in(&mut second).await, "who is in stays in");
    drop((second, third));
    sleep(Duration::from_millis(1)).await;
    assert!(!is_in(&mut come(&house, 1024)).await, "there is one place again");
    drop(first);
    sleep(Duration::from_millis(1)).await;
    assert!(is_in(&mut come(&house, 1024)).await);
    // Those of an address and of matches are looked up each time.
    house.change_limits(Limits { connections: 9, connections_per_address: 0, matches: 7, ..limits(1) });
    assert_eq!(refused(&all_said(&mut come(&house, 1024)).await), Refused::AddressFull { limit: 0 });
    assert_eq!(house.lobby().limits().matches, 7);
}

#[tokio::test(start_paused = true)]
async fn who_is_banned_before_its_hello_is_put_out_at_once_and_comes_back_when_it_may() {
    let house = house(9, 9);
    let mut early = come(&house, 1024);
    assert!(is_in(&mut early).await);
    let begun = Instant::now();
    house.ban(peer().ip(), Entry::Denied).unwrap();
    assert_eq!(refused(&all_said(&mut early).await), Refused::Operator);
    assert_eq!(begun.elapsed(), Duration::ZERO);
    assert_eq!(refused(&all_said(&mut come(&house, 1024)).await), Refused::Operator);
    house.ban(peer().ip(), Entry::Allowed).unwrap();
    assert!(is_in(&mut come(&house, 1024)).await);
}

#[tokio::test]
async fn who_finds_no_place_waits_at_the_socket_until_there_is_one() {
    let server = Arc::new(Server::open("127.0.0.1:0".parse().unwrap(), house(1, 9)).unwrap());
    let address = server.local_addr().unwrap();
    let serving =
        tokio::spawn(async move { server.serve(std::future::pending(), std::future::pending()).await });
    let mut first = BufReader::new(TcpStream::connect(address).await.unwrap());
    let mut second = TcpStream::connect(address).await.unwrap();
    let list = format!("{{\"list\":{{\"protocol\":{PROTOCOL}}}}}\n");
    second.write_all(list.as_bytes()).await.unwrap();
    let mut line = String::new();
    for _ in 0..10 {
        first.write_all(list.as_bytes()).await.unwrap();
        assert!(first.read_line(&mut line).await.unwrap() > 0);
        let found = second.try_read(&mut [0]).map_err(|error| error.kind());
        assert_eq!(found, Err(io::ErrorKind::WouldBlock), "there is one place");
    }
    drop(first);
    assert!(BufReader::new(second).read_line(&mut line).await.unwrap() > 0);
    serving.abort();
}

#[cfg(target_os = "linux")]
#[tokio::test]
async fn connections_have_the_buffers_that_let_a_slow_client_be_noticed() {
    let inherited = std::net::TcpListener::bind("127.0.0.1:0").unwrap();
    for server in [
        Server::open("127.0.0.1:0".parse().unwrap(), house(1, 1)).unwrap(),
        Server::over(inherited, house(1, 1)).unwrap(),
    ] {
        let _client = TcpStream::connect(server.local_addr().unwrap()).await.unwrap();
        let (stream, ..) = server.accept().await;
        let socket = socket2::SockRef::from(&stream);
        // Linux keeps twice what it was told.
        assert_eq!(socket.send_buffer_size().unwrap(), 2 * SEND_BUFFER_SIZE);
        assert_eq!((socket.tcp_notsent_lowat().unwrap(), stream.nodelay().unwrap()), (UNSENT_MAX, true));
    }
}

/// Returns a house without a match, played in the time of the runtime.
fn house(connections: usize, connections_per_address: usize) -> House {
    let limits = Limits { connections, connections_per_address, ..Limits::default() };
    House::new(limits, BTreeMap::new(), None, 0).unwrap()
}

fn peer() -> SocketAddr {
    "192.0.2.1:9".parse().unwrap()
}

/// Lets somebody come over a connection that holds so many bytes in each direction.
fn come(house: &House, room: usize) -> DuplexStream {
    let (nearby, far) = duplex(room);
    house.receive(nearby, peer(), &CancellationToken::new());
    far
}

/// Returns whether the lobby answers.
async fn is_in(stream: &mut DuplexStream) -> bool {
    let list = format!("{{\"list\":{{\"protocol\":{PROTOCOL}}}}}\n");
    if stream.write_all(list.as_bytes()).await.is_err() {
        return false;
    }
    let mut line = String::new();
    BufReader::new(stream).read_line(&mut line).await.unwrap() > 0 && line.starts_with("{\"matches\":")
}

async fn all_said(stream: &mut DuplexStream) -> Vec<u8> {
    let mut said = Vec::new();
    timeout(FOR_EVER, stream.read_to_end(&mut said)).await.expect("it is closed").unwrap();
    said
}

fn refused(said: &[u8]) -> Refused {
    match decode_server(Encoding::Json, said.trim_ascii_end()) {
        Ok(ServerMessage::Refused { reason }) => reason,
        other => panic!("{other:?}"),
    }
}

async fn time_until_one_may_come(house: &House) -> Duration {
    let begun = Instant::now();
    let free = timeout(FOR_EVER, house.slots.acquire()).await.expect("there is a place again").unwrap();
    drop(free);
    begun.elapsed()
}
