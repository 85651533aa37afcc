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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Ground;
    use crate::in_step::{Board, Instance, Outcome, Plan, Rings, Tree, scattered as ends_at_random};
    use crate::tests::{Dice, scattered};

    /// The plan of agents on a random map, with or without rings.
    fn plan(board: &Board, agents: usize, rings: Rings, seed: u64) -> Plan {
        let (starts, goals) = ends_at_random(board, agents, seed);
        let instance = Instance::new(board, starts, goals).unwrap();
        let mut tree = Tree::new(instance.problem(), rings, seed);
        let Some(Outcome::Solved(plan)) = tree.advance(instance.problem(), 20_000) else {
            panic!("seed {seed}")
        };
        plan.check(&instance).unwrap();
        plan
    }

    fn board(seed: u64) -> Board {
        let mut dice = Dice(seed);
        Board::new(&Ground::new(&scattered(&mut dice, 12, 0.15), 0.35).unwrap()).unwrap()
    }

    fn passage(board: &Board, plan: &Plan) -> Passage {
        let mut passage = Passage::new(board.len(), plan.at(0));
        for step in 1..=plan.steps() {
            passage.push(plan.at(step));
        }
        passage
    }

    /// Walks a passage in random order; returns how many have come to their ends.
    fn walk(passage: &Passage, units: usize, seed: u64) -> usize {
        let mut dice = Dice(seed);
        let mut at = vec![0; units];
        loop {
            let can_go = |&unit: &usize| {
                at[unit] + 1 < passage.way(unit).len()
                    && passage.after(unit, at[unit] + 1).is_none_or(|(other, index)| at[other] > index)
            };
            let ready: Vec<usize> = (0..units).filter(can_go).collect();
            if ready.is_empty() {
                return (0..units).filter(|&unit| at[unit] + 1 == passage.way(unit).len()).count();
            }
            let unit = ready[usize::try_from(dice.roll() % ready.len() as u64).unwrap()];
            at[unit] += 1;
            let place = passage.way(unit)[at[unit]];
            assert!(
                (0..units).all(|other| other == unit || passage.way(other)[at[other]] != place),
                "seed {seed}"
            );
        }
    }

    #[test]
    fn in_whatever_order_units_go_nobody_meets_and_all_arrive() {
        for seed in 0..40 {
            let board = board(seed);
            let plan = plan(&board, 40, Rings::Avoided, seed);
            assert_eq!(walk(&passage(&board, &plan), 40, seed), 40, "seed {seed}");
        }
    }

    /// What rings are avoided for: with them all wait for each other.
    #[test]
    fn with_rings_some_plans_could_not_be_walked_in_any_order() {
        let stuck = (0..40).filter(|&seed| {
            let board = board(seed);
            let plan = plan(&board, 40, Rings::Allowed, seed);
            walk(&passage(&board, &plan), 40, seed) < 40
        });
        assert!(stuck.count() > 3);
    }
}
