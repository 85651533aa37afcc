//! Who is where, and when.

use crate::in_step::board::Place;

/// A step that never comes.
pub(crate) const FOREVER: u32 = u32::MAX;

/// An agent is in a place, from a step to another, both included.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Stay {
    from: u32,
    until: u32,
    agent: u32,
}

/// The steps at which a place is free, between two stays; both ends included.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Gap {
    /// How many stays come before it.
    pub(crate) number: u32,
    pub(crate) from: u32,
    pub(crate) until: u32,
}

/// The stays in each place, by time; no two at once.
#[derive(Clone, Debug)]
pub(crate) struct Reservations {
    stays: Vec<Vec<Stay>>,
}

impl Reservations {
    pub(crate) fn new(places: usize) -> Self {
        Self { stays: vec![Vec::new(); places] }
    }

    /// Forgets everything.
    pub(crate) fn clear(&mut self) {
        for stays in &mut self.stays {
            stays.clear();
        }
    }

    /// Reserves a way from step 0 on, at whose end the agent stays until `until`.
    ///
    /// # Panics
    /// If somebody else is there.
    pub(crate) fn add(&mut self, agent: u32, way: &[Place], until: u32) {
        for_each_stay(agent, way, until, |place, stay| {
            let stays = &mut self.stays[place.index()];
            let at = stays.partition_point(|other| other.from < stay.from);
            assert!(at == 0 || stays[at - 1].until < stay.from, "the place is free");
            assert!(at == stays.len() || stay.until < stays[at].from, "the place stays free");
            stays.insert(at, stay);
        });
    }

    /// Takes a way back.
    ///
    /// # Panics
    /// If it was not reserved.
    pub(crate) fn remove(&mut self, agent: u32, way: &[Place], until: u32) {
        for_each_stay(agent, way, until, |place, stay| {
            let stays = &mut self.stays[place.index()];
            let at = stays.partition_point(|other| other.from < stay.from);
            assert_eq!(stays[at], stay, "it was reserved");
            stays.remove(at);
        });
    }

    /// Returns the first step from which on a place is free for ever; [`FOREVER`] if it never is.
    pub(crate) fn free_from(&self, place: Place) -> u32 {
        self.stays[place.index()].last().map_or(0, |stay| stay.until.saturating_add(1))
    }

    /// Returns who is in a place after a step; `None` where nobody is.
    pub(crate) fn at(&self, place: Place, step: u32) -> Option<u32> {
        let stays = &self.stays[place.index()];
        let next = stays.partition_point(|stay| stay.from <= step);
        let stay = stays[..next].last()?;
        (stay.until >= step).then_some(stay.agent)
    }

    /// Returns whoever is in a way that begins at step 0 and at whose end one stays, or changes places with who goes it; by number.
    pub(crate) fn conflicts(&self, way: &[Place]) -> Vec<u32> {
        let mut agents = Vec::new();
        let mut before = way[0];
        for (step, &place) in (0..).zip(way) {
            let meets = self.at(place, step);
            let swaps = self
                .at(before, step)
                .filter(|_| step > 0 && self.at(place, step - 1) == self.at(before, step));
            agents.extend(meets.into_iter().chain(swaps));
            before = place;
        }
        let end = u32::try_from(way.len() - 1).expect("ways are shorter than 2^32 steps");
        let stays = &self.stays[before.index()];
        agents.extend(stays.iter().filter(|stay| stay.until >= end).map(|stay| stay.agent));
        agents.sort_unstable();
        agents.dedup();
        agents
    }

    /// Returns the agents that are ever in a place, by time.
    pub(crate) fn visitors(&self, place: Place) -> impl Iterator<Item = u32> {
        self.stays[place.index()].iter().map(|stay| stay.agent)
    }

    /// Returns the gaps of a place that have steps of `from..=until`, by time.
    pub(crate) fn gaps(&self, place: Place, from: u32, until: u32) -> impl Iterator<Item = Gap> {
        let stays = &self.stays[place.index()][..];
        let first = stays.partition_point(|stay| stay.until < from);
        let gap = move |number: usize| {
            let begin = if number == 0 { 0 } else { stays[number - 1].until.saturating_add(1) };
            let end = stays.get(number).map_or(Some(FOREVER), |stay| stay.from.checked_sub(1));
            Some((number, begin, end?)).filter(|&(_, begin, end)| begin <= end && begin != FOREVER)
        };
        (first..=stays.len())
            .take_while(move |&number| number == first || stays[number - 1].until < until)
            .filter_map(gap)
            .map(|(number, from, until)| Gap {
                number: u32::try_from(number).expect("stays are fewer than steps"),
                from,
                until,
            })
    }

    /// Returns whether who leaves `from` at the end of a gap of it and comes to `to` at the beginning of one changes places with
    /// somebody.
    pub(crate) fn is_swap(&self, (from, left): (Place, &Gap), (to, entered): (Place, &Gap)) -> bool {
        if left.until == FOREVER || left.until + 1 != entered.from {
            return false;
        }
        let comes = self.stays[from.index()][left.number as usize].agent;
        let goes = self.stays[to.index()][entered.number as usize - 1].agent;
        comes == goes
    }
}

fn for_each_stay(agent: u32, way: &[Place], until: u32, mut act: impl FnMut(Place, Stay)) {
    let mut from = 0;
    for (step, places) in (1..).zip(way.windows(2)) {
        if places[0] != places[1] {
            act(places[0], Stay { from, until: step - 1, agent });
            from = step;
        }
    }
    let last = way.last().expect("a way has a start");
    act(*last, Stay { from, until, agent });
}
