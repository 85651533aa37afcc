//! Plans on real maps, for the agents that are published with them.

use super::solve;
use crate::Ground;
use crate::in_step::{Algorithm, Board, Instance};
use crate::tests::real::{load, scenes_in, shared_maps};

/// Agents of each file; a file may have fewer.
const AGENTS: usize = 120;

#[test]
fn published_agents_have_valid_plans() {
    let Some(folder) = shared_maps("plans on real maps") else { return };
    let files = scenes_in(&folder.join("mapf"));
    assert!(files.len() >= 14, "only {} files", files.len());
    for file in files {
        let (map, queries) = load(&file);
        let board = Board::new(&Ground::new(&map, 0.35).unwrap()).unwrap();
        let place = |(x, y): (u32, u32)| board.place(x, y).unwrap();
        let chosen = &queries[..AGENTS.min(queries.len())];
        let starts = chosen.iter().map(|query| place(query.start)).collect();
        let goals = chosen.iter().map(|query| place(query.goal)).collect();
        let instance = Instance::new(&board, starts, goals).unwrap();
        for (query, agent) in chosen.iter().zip(0..) {
            let steps = f64::from(instance.distances().steps(agent, place(query.start)).unwrap());
            assert!(
                query.length <= steps + 1e-4 * steps && steps <= 1.4143 * query.length + 1e-3,
                "{query:?}"
            );
        }
        let outcome = solve(Algorithm::Lacam, &instance, 1, 20_000);
        assert!(outcome.is_some_and(|outcome| outcome.plan().is_some()), "{}", file.display());
    }
}
