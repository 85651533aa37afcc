//! How many steps it is from everywhere to the goals.

use crate::in_step::board::{Board, Place};

/// The distance of a place from which the goal cannot be reached.
pub(crate) const FAR: u32 = u32::MAX;

/// The steps from every place to the goal of each agent, as if it were alone; agents with the same goal share a table.
#[derive(Clone, Debug)]
pub struct Distances {
    places: usize,
    /// Where the table of each agent begins.
    of_agent: Vec<usize>,
    tables: Vec<u32>,
}

impl Distances {
    /// Returns the distances to goals, one for each agent: a breadth-first search from each goal that is another.
    ///
    /// # Panics
    /// With a goal of another board.
    #[must_use]
    pub fn new(board: &Board, goals: &[Place]) -> Self {
        let mut order: Vec<usize> = (0..goals.len()).collect();
        order.sort_by_key(|&agent| (goals[agent], agent));
        let places = board.len();
        let mut of_agent = vec![0; goals.len()];
        let different = order.chunk_by(|&a, &b| goals[a] == goals[b]);
        let mut tables = vec![FAR; places * different.clone().count()];
        let mut queue = Vec::with_capacity(places);
        for (number, sharing) in different.enumerate() {
            let begin = number * places;
            flood(board, goals[sharing[0]], &mut tables[begin..begin + places], &mut queue);
            for &agent in sharing {
                of_agent[agent] = begin;
            }
        }
        Self { places, of_agent, tables }
    }

    /// Returns the distances to no goal yet.
    pub(crate) fn none(board: &Board) -> Self {
        Self { places: board.len(), of_agent: Vec::new(), tables: Vec::new() }
    }

    /// Adds an agent and the distances to its goal.
    pub(crate) fn push(&mut self, board: &Board, goal: Place) {
        let begin = self.tables.len();
        self.of_agent.push(begin);
        self.tables.resize(begin + self.places, FAR);
        flood(board, goal, &mut self.tables[begin..], &mut Vec::new());
    }

    /// Returns how many agents there are.
    pub(crate) fn agents(&self) -> usize {
        self.of_agent.len()
    }

    /// Returns the distances of agents each of which has the goal of one of these.
    pub(crate) fn shared_out(mut self, goals: &[usize]) -> Self {
        self.of_agent = goals.iter().map(|&goal| self.of_agent[goal]).collect();
        self
    }

    /// Returns how many tables there are: one for each different goal.
    #[must_use]
    pub fn tables(&self) -> usize {
        self.tables.len().checked_div(self.places).unwrap_or(0)
    }

    /// Returns how many steps an agent's goal is from a place; `None` where it cannot be reached.
    #[must_use]
    pub fn steps(&self, agent: usize, from: Place) -> Option<u32> {
        let distance = self.of(agent)[from.index()];
        (distance != FAR).then_some(distance)
    }

    /// Returns the distances of an agent by the index of the place; [`FAR`] where the goal cannot be reached.
    pub(crate) fn of(&self, agent: usize) -> &[u32] {
        let begin = self.of_agent[agent];
        &self.tables[begin..begin + self.places]
    }
}

/// Writes the distance to a goal into a table that is [`FAR`] everywhere.
fn flood(board: &Board, goal: Place, table: &mut [u32], queue: &mut Vec<Place>) {
    queue.clear();
    queue.push(goal);
    table[goal.index()] = 0;
    let mut done = 0;
    while done < queue.len() {
        let place = queue[done];
        done += 1;
        let distance = table[place.index()] + 1;
        for &next in board.neighbours(place) {
            if table[next.index()] == FAR {
                table[next.index()] = distance;
                queue.push(next);
            }
        }
    }
}
