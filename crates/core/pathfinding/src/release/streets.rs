//! Who goes along which stretches: many circles share most of theirs.

use glam::DVec2;
use hashbrown::HashTable;
use maniple_geometry::Scalar;

use super::conflict::Contact;
use super::stretch::{Bounds, Stretch};
use super::trajectory::{Times, Trajectory};

/// Somebody on a stretch.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Use {
    /// The number of the circle.
    pub(crate) circle: usize,
    /// When it is there, in cycles since the beginning of the schedule.
    pub(crate) times: Times,
}

/// A stretch along which somebody goes.
#[derive(Clone, Debug)]
struct Street {
    stretch: Stretch,
    uses: Vec<Use>,
    /// Its contacts with other streets, by their numbers, and with itself; of so many of the first streets.
    contacts: Vec<(usize, Contact)>,
    looked_at: usize,
}

/// Where a street is, and until when somebody is on it, in cycles since the beginning of the schedule.
#[derive(Clone, Copy, Debug)]
struct Extent {
    bounds: Bounds,
    until: f64,
}

/// All stretches along which somebody goes, each of them once: whether two circles come too near to each other there depends on the two
/// stretches alone, and when they do on their times.
#[derive(Clone, Debug)]
pub(crate) struct Streets {
    /// How near middles may come to each other, in world units.
    reach: f64,
    streets: Vec<Street>,
    /// Where and when each is used.
    extents: Vec<Extent>,
    /// The numbers of streets by their stretches. It is only ever asked for one, so that its order cannot be seen.
    numbers: HashTable<usize>,
}

impl Streets {
    /// Returns none; the middles of all who go along them may come as near to each other as `reach`.
    pub(crate) fn new(reach: f64) -> Self {
        Self { reach, streets: Vec::new(), extents: Vec::new(), numbers: HashTable::new() }
    }

    /// Takes in that a circle with a number of its own goes along a trajectory.
    pub(crate) fn take_in(&mut self, circle: usize, trajectory: &Trajectory, departure: f64) {
        for piece in trajectory.pieces() {
            let number = self.number(&piece.stretch).unwrap_or_else(|| self.add(piece.stretch));
            let times = piece.times.later(departure);
            self.streets[number].uses.push(Use { circle, times });
            let until = &mut self.extents[number].until;
            *until = until.greater(times.last + piece.stretch.duration);
        }
    }

    /// Tells everybody who comes too near to a stretch along which somebody goes already, and the contact of that one with theirs. Returns
    /// how many looks that took; `None` where nobody goes along it.
    pub(crate) fn meet_on_street(
        &mut self,
        stretch: &Stretch,
        mut tell: impl FnMut(&Use, Contact),
    ) -> Option<u64> {
        let number = self.number(stretch)?;
        let mut looks = self.complete(number);
        for &(other, contact) in &self.streets[number].contacts {
            looks += self.streets[other].uses.len() as u64;
            self.streets[other].uses.iter().for_each(|used| tell(used, contact));
        }
        Some(looks)
    }

    /// Tells the same for any stretch, but not of streets that everybody has left by a moment, in cycles since the beginning of the
    /// schedule.
    pub(crate) fn meet(&self, stretch: &Stretch, after: f64, mut tell: impl FnMut(&Use, Contact)) -> u64 {
        let mut looks = self.streets.len() as u64 / 8;
        for (street, extent) in self.streets.iter().zip(&self.extents) {
            if extent.until <= after {
                continue;
            }
            if let Some(contact) = self.contact(stretch, (street, extent)) {
                looks += 1 + street.uses.len() as u64;
                street.uses.iter().for_each(|used| tell(used, contact));
            }
        }
        looks
    }

    /// Looks for the contacts of a street with those that have come since it was done last.
    fn complete(&mut self, number: usize) -> u64 {
        let Street { stretch, looked_at, .. } = self.streets[number];
        let others = self.streets.iter().zip(&self.extents).enumerate().skip(looked_at);
        let found = others.filter_map(|(other, street)| Some((other, self.contact(&stretch, street)?)));
        let found: Vec<(usize, Contact)> = found.collect();
        let looks = (self.streets.len() - looked_at) as u64 / 8 + found.len() as u64;
        self.streets[number].contacts.extend(found);
        self.streets[number].looked_at = self.streets.len();
        looks
    }

    fn contact(&self, stretch: &Stretch, (street, extent): (&Street, &Extent)) -> Option<Contact> {
        if stretch.bounds.is_far(&extent.bounds, self.reach) {
            return None;
        }
        Contact::of(stretch, &street.stretch, self.reach)
    }

    fn number(&self, stretch: &Stretch) -> Option<usize> {
        self.numbers.find(hash_of(stretch), |&number| self.streets[number].stretch == *stretch).copied()
    }

    fn add(&mut self, stretch: Stretch) -> usize {
        let number = self.streets.len();
        self.streets.push(Street { stretch, uses: Vec::new(), contacts: Vec::new(), looked_at: 0 });
        self.extents.push(Extent { bounds: stretch.bounds, until: f64::NEG_INFINITY });
        let streets = &self.streets;
        self.numbers.insert_unique(hash_of(&stretch), number, |&number| hash_of(&streets[number].stretch));
        number
    }
}

/// A hash of the ends of a stretch.
fn hash_of(stretch: &Stretch) -> u64 {
    let DVec2 { x, y } = stretch.point;
    [x, y, stretch.end.x, stretch.end.y].iter().fold(0, |hash: u64, coordinate| {
        let mixed = (hash ^ coordinate.to_bits()).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        mixed ^ mixed >> 29
    })
}
