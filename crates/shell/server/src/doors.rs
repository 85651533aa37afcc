//! Who may take which seat, and how often.

use std::time::Duration;

use maniple_protocol::Refused;
use maniple_view::Seat;
use tokio::sync::{Mutex, Semaphore};
use tokio::time::{Instant, sleep_until};

use crate::audience::spectators_full;
use crate::token::Token;

/// Least time between two players at one door. A welcome holds the whole terrain, so whoever came again and again with
/// a good token would hold up the cycles of all.
pub const JOIN_INTERVAL: Duration = Duration::from_millis(200);

/// Least time between two spectators of a match. Who comes in the same cycle gets the same bytes, so it is their number alone that must
/// not hold up a cycle: a thousand a second take a few milliseconds of it.
pub const WATCH_INTERVAL: Duration = Duration::from_millis(1);

/// Who may take a seat.
#[derive(Clone, Copy, Debug)]
pub enum Access {
    /// Whoever comes without a token while nobody sits there.
    Open,
    /// Whoever has the token; a seat that is taken is taken over.
    Token(Token),
}

/// The doors of a match: one for each seat, one for those who come without a token, and one for spectators.
#[derive(Debug)]
pub(crate) struct Doors {
    access: Vec<Access>,
    /// When the next may go through; by seat.
    with_token: Vec<Mutex<Instant>>,
    without_token: Mutex<Instant>,
    to_watch: Mutex<Instant>,
    /// Room for spectators who wait: without a limit they could take the connections of players.
    waiting_room: Semaphore,
    spectators_max: usize,
}

impl Doors {
    /// Returns the doors to seats with these rights of access, and for so many spectators.
    pub(crate) fn new(access: Vec<Access>, spectators_max: usize) -> Self {
        let now = || Mutex::new(Instant::now());
        let with_token = access.iter().map(|_| now()).collect();
        Self {
            access,
            with_token,
            without_token: now(),
            to_watch: now(),
            waiting_room: Semaphore::new(spectators_max),
            spectators_max,
        }
    }

    /// Waits until whoever has this token may go on: in the order in which they came. A token that opens nothing is
    /// not worth a wait.
    pub(crate) async fn wait_turn(&self, token: &str) {
        let door = if token.is_empty() {
            &self.without_token
        } else if let Ok(seat) = self.seat_of_token(token) {
            &self.with_token[seat.index()]
        } else {
            return;
        };
        go_through(door, JOIN_INTERVAL).await;
    }

    /// Waits until a spectator may go on: in the order in which they came.
    ///
    /// # Errors
    /// As many as can watch wait already.
    pub(crate) async fn wait_turn_to_watch(&self) -> Result<(), Refused> {
        let Ok(_place) = self.waiting_room.try_acquire() else {
            return Err(spectators_full(self.spectators_max));
        };
        go_through(&self.to_watch, WATCH_INTERVAL).await;
        Ok(())
    }

    /// Returns the seat that a token opens.
    ///
    /// Compares with every seat's token, found or not, so that the time tells nothing.
    ///
    /// # Errors
    /// The reason that the client is told.
    pub(crate) fn seat_of_token(&self, token: &str) -> Result<Seat, Refused> {
        let token: Token = token.parse().map_err(|_| Refused::Token)?;
        let mut found = Err(Refused::Token);
        for (seat, access) in self.seats().zip(&self.access) {
            match access {
                Access::Token(own) if own.is_same(token) => found = Ok(seat),
                Access::Token(_) | Access::Open => {}
            }
        }
        found
    }

    /// Returns the seats that need no token.
    pub(crate) fn open_seats(&self) -> impl Iterator<Item = Seat> {
        let is_open = |access: &Access| match access {
            Access::Open => true,
            Access::Token(_) => false,
        };
        self.seats().zip(&self.access).filter(move |(_, access)| is_open(access)).map(|(seat, _)| seat)
    }

    /// Returns how many may watch at the same time.
    pub(crate) fn spectators_max(&self) -> usize {
        self.spectators_max
    }

    /// Returns all seats.
    pub(crate) fn seats(&self) -> impl Iterator<Item = Seat> + use<> {
        (0..).map(Seat).take(self.access.len())
    }
}

/// Waits until the door is free, and keeps it shut behind for a while.
async fn go_through(door: &Mutex<Instant>, interval: Duration) {
    let mut free_at = door.lock().await;
    sleep_until(*free_at).await;
    *free_at = Instant::now() + interval;
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use tokio::task::JoinSet;

    use super::*;

    #[test]
    fn a_token_opens_its_seat() {
        let (a, b) = (Token::random().unwrap(), Token::random().unwrap());
        let doors = Doors::new(vec![Access::Token(a), Access::Open, Access::Token(b)], 8);
        assert_eq!(doors.seat_of_token(&a.to_string()), Ok(Seat(0)));
        assert_eq!(doors.seat_of_token(&b.to_string()), Ok(Seat(2)));
        for token in [Token::random().unwrap().to_string(), "nonsense".to_owned(), String::new()] {
            assert_eq!(doors.seat_of_token(&token), Err(Refused::Token));
        }
        assert_eq!(doors.open_seats().collect::<Vec<_>>(), [Seat(1)]);
    }

    #[tokio::test(start_paused = true)]
    async fn a_door_lets_one_through_at_a_time_and_does_not_hold_up_another() {
        let (a, b) = (Token::random().unwrap(), Token::random().unwrap());
        let doors = Doors::new(vec![Access::Token(a), Access::Token(b)], 8);
        let start = Instant::now();
        for turn in 0..3 {
            doors.wait_turn(&a.to_string()).await;
            assert!(
                (JOIN_INTERVAL * turn..JOIN_INTERVAL * (turn + 1)).contains(&start.elapsed()),
                "turn {turn}"
            );
        }
        let before = start.elapsed();
        doors.wait_turn(&b.to_string()).await;
        doors.wait_turn("").await;
        doors.wait_turn("nonsense").await;
        assert_eq!(doors.wait_turn_to_watch().await, Ok(()));
        assert_eq!(start.elapsed(), before);
        assert_eq!(doors.wait_turn_to_watch().await, Ok(()));
        assert_eq!(start.elapsed(), before + WATCH_INTERVAL, "spectators have one door");
    }

    #[tokio::test(start_paused = true)]
    async fn no_more_spectators_wait_than_may_watch() {
        let doors = Arc::new(Doors::new(vec![Access::Open], 8));
        assert_eq!(doors.wait_turn_to_watch().await, Ok(()), "the door shuts behind the first");
        let mut waiting = JoinSet::new();
        for _ in 0..8 + 3 {
            let doors = Arc::clone(&doors);
            waiting.spawn(async move { doors.wait_turn_to_watch().await });
        }
        let outcomes = waiting.join_all().await;
        assert_eq!(outcomes.iter().filter(|outcome| outcome.is_err()).count(), 3);
        assert_eq!(doors.wait_turn_to_watch().await, Ok(()));
    }
}
