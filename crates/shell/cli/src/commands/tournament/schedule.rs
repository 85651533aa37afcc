//! Who sits where, in which match, with which seed.

use std::fmt;
use std::sync::Arc;

use serde::{Serialize, Serializer};

/// What a player is called in the results: the name of its bot, with a number where others have the same.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Player(Arc<str>);

impl fmt::Display for Player {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(&self.0)
    }
}

impl Serialize for Player {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(&self.0)
    }
}

/// Returns the players for the bots with these names, in the same order.
pub(super) fn players(bots: &[String]) -> Vec<Player> {
    let player = |(place, bot): (usize, &String)| {
        let same = |bots: &[String]| bots.iter().filter(|other| *other == bot).count();
        Player(match same(bots) {
            1 => bot.as_str().into(),
            _ => format!("{bot} ({})", same(&bots[..=place])).into(),
        })
    };
    bots.iter().enumerate().map(player).collect()
}

/// The first seed, and the number of seats and so of players.
#[derive(Clone, Copy, Debug)]
pub(super) struct Schedule {
    pub(super) seed: u64,
    pub(super) seats: usize,
}

impl Schedule {
    /// Returns the seed of a match. As many matches one after the other as there are seats share one.
    pub(super) fn seed(self, number: u32) -> u64 {
        self.seed.wrapping_add(u64::from(number) / self.seats as u64)
    }

    /// Returns which player sits at each seat in a match: the one of the seat's number in the first match of a seed,
    /// and in each further one all sit one seat further.
    pub(super) fn seating(self, number: u32) -> Vec<usize> {
        let shift = number as usize % self.seats;
        (0..self.seats).map(|seat| (seat + self.seats - shift) % self.seats).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_player_sits_at_every_seat_once_with_each_seed() {
        let check = |seats: usize, expected: &[(u64, &[usize])]| {
            let schedule = Schedule { seed: u64::MAX, seats };
            for (number, (seed, seating)) in (0..).zip(expected) {
                assert_eq!(
                    (schedule.seed(number), &schedule.seating(number)[..]),
                    (*seed, *seating),
                    "{number}"
                );
            }
        };
        check(1, &[(u64::MAX, &[0]), (0, &[0]), (1, &[0])]);
        check(2, &[(u64::MAX, &[0, 1]), (u64::MAX, &[1, 0]), (0, &[0, 1]), (0, &[1, 0])]);
        check(3, &[(u64::MAX, &[0, 1, 2]), (u64::MAX, &[2, 0, 1]), (u64::MAX, &[1, 2, 0]), (0, &[0, 1, 2])]);
    }

    #[test]
    fn bots_of_the_same_name_get_numbers() {
        let names = |bots: &[&str]| {
            let bots: Vec<String> = bots.iter().map(|bot| (*bot).to_owned()).collect();
            players(&bots).iter().map(Player::to_string).collect::<Vec<String>>()
        };
        assert_eq!(names(&["idle", "random"]), ["idle", "random"]);
        assert_eq!(names(&["idle", "random", "idle"]), ["idle (1)", "random", "idle (2)"]);
    }
}
