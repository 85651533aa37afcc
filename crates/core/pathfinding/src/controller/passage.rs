//! Who passes each place after whom: what of a plan in step has to be kept when its steps are not walked at the same moment.

use crate::in_step::Place;

/// A step of a unit: `(unit, index)` is that in which it leaves the place with this index on its way.
pub(crate) type Departure = (usize, usize);

/// The ways of all units, without their waits, and whom each waits for at each place of its way.
///
/// Where a place is entered only when who was there before has begun to leave it, units may walk the plan at any times (Hönig,
/// Kiesel, Tinka, Durham and Ayanian, *Persistent and Robust Execution of MAPF Schedules in Warehouses*, 2019: an action dependency
/// graph). They never come nearer to each other than in step: on edges that meet in a place the one is behind by a step at
/// least, and all go at the same speed.
#[derive(Clone, Debug)]
pub(crate) struct Passage {
    ways: Vec<Vec<Place>>,
    /// For each place of each way the departure that has to have begun before the unit sets out for it; `None`: nobody's.
    after: Vec<Vec<Option<Departure>>>,
    /// Who came to each place last.
    last: Vec<Option<Departure>>,
}

impl Passage {
    /// Returns the passage of units that stay where they are, on a board of so many places.
    pub(crate) fn new(places: usize, starts: &[Place]) -> Self {
        let mut last = vec![None; places];
        for (unit, place) in starts.iter().enumerate() {
            last[place.index()] = Some((unit, 0));
        }
        Self {
            ways: starts.iter().map(|&start| vec![start]).collect(),
            after: vec![vec![None]; starts.len()],
            last,
        }
    }

    /// Adds a step of all, to these places.
    pub(crate) fn push(&mut self, places: &[Place]) {
        let mut entered = Vec::new();
        for (unit, &place) in places.iter().enumerate() {
            let way = &mut self.ways[unit];
            if way[way.len() - 1] == place {
                continue;
            }
            let before = self.last[place.index()].filter(|&(other, _)| other != unit);
            self.after[unit].push(before);
            way.push(place);
            entered.push((place, (unit, way.len() - 1)));
        }
        for (place, departure) in entered {
            self.last[place.index()] = Some(departure);
        }
    }

    /// The way of a unit.
    pub(crate) fn way(&self, unit: usize) -> &[Place] {
        &self.ways[unit]
    }

    /// Whose departure a unit waits for before it sets out for the place with an index on its way.
    pub(crate) fn after(&self, unit: usize, index: usize) -> Option<Departure> {
        self.after[unit][index]
    }

    /// Where all are at the end.
    pub(crate) fn ends(&self) -> Vec<Place> {
        self.ways.iter().map(|way| way[way.len() - 1]).collect()
    }
}
