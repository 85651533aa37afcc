//! Several deltas in one, for who is too slow for each.

use std::collections::{BTreeMap, BTreeSet, VecDeque};

use maniple_geometry::Cycle;

use crate::delta::{Appeared, Changed, Delta, Ended, Moved, Shot, Stopped};
use crate::identity::{Digest, Handle};
use crate::outcome::CommandResult;

/// Deltas of one view that follow each other, merged into one: applied to the view before the first, it gives the view after the
/// last, and the same check.
///
/// It grows backwards in time, from the last delta on: so one pass over the deltas of the last cycles gives, on its way, what each
/// receiver has to be told, wherever it stands.
///
/// Nothing is lost that a player has to be told. Results, shots and ended tasks run on from cycle to cycle; a shot or a task may name an
/// object that is gone by the end, or that came and went in between. Who died is told of as dead if the view held it at the beginning. Of motions and
/// changes of an object only the last remains, and who appeared appears as it is at the end.
#[derive(Clone, Debug, Default)]
pub struct Merge {
    cycle: Cycle,
    check: Digest,
    stock: Option<u32>,
    fates: BTreeMap<Handle, Fate>,
    /// Where runs of tiles that change their visibility begin or end; in order it is a beginning, an end, and so on.
    bounds: BTreeSet<u32>,
    revealed: VecDeque<(u32, u32, String)>,
    walls: VecDeque<(f64, f64, f64, f64)>,
    results: VecDeque<CommandResult>,
    shots: VecDeque<Shot>,
    ended: VecDeque<Ended>,
}

/// What becomes of an object in all the cycles together.
#[derive(Clone, Copy, Debug, Default)]
struct Fate {
    /// The view held it at the beginning, and it left.
    left: Option<Leaving>,
    /// It is in the view at the end, and was not, or not always.
    appeared: Option<Appeared>,
    motion: Option<Motion>,
    changed: Option<Changed>,
    /// It came and died in between: only who knew it before is told.
    is_dead: bool,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Leaving {
    Vanished,
    Died,
}

#[derive(Clone, Copy, Debug)]
enum Motion {
    Moved(Moved),
    Stopped(Stopped),
}

impl Merge {
    /// Returns the merge of one delta.
    #[must_use]
    pub fn new(last: &Delta) -> Self {
        let mut merge = Self { cycle: last.cycle, check: last.check, ..Self::default() };
        merge.precede(last);
        merge
    }

    /// Takes the delta of the cycle before the earliest that it holds.
    pub fn precede(&mut self, earlier: &Delta) {
        self.stock = self.stock.or(earlier.stock);
        self.toggle(&earlier.sight);
        put_before(&mut self.revealed, &earlier.revealed);
        put_before(&mut self.walls, &earlier.walls);
        put_before(&mut self.results, &earlier.results);
        put_before(&mut self.shots, &earlier.shots);
        put_before(&mut self.ended, &earlier.ended);
        // Backwards too within the delta: what is applied last comes first.
        for new in &earlier.appeared {
            self.fate(new.object).precede_appeared(new);
        }
        for changed in &earlier.changed {
            self.fate(changed.object).precede_changed(changed);
        }
        for stopped in &earlier.stopped {
            self.fate(stopped.object).precede_motion(Motion::Stopped(*stopped));
        }
        for moved in &earlier.moved {
            self.fate(moved.object).precede_motion(Motion::Moved(*moved));
        }
        for &object in &earlier.vanished {
            self.fate(object).precede_leaving(Leaving::Vanished);
        }
        for &object in &earlier.died {
            self.fate(object).precede_leaving(Leaving::Died);
        }
    }

    /// Returns the one delta.
    #[must_use]
    pub fn delta(&self) -> Delta {
        let mut delta = Delta {
            cycle: self.cycle,
            results: self.results.iter().cloned().collect(),
            sight: self.sight(),
            revealed: self.revealed.iter().cloned().collect(),
            walls: self.walls.iter().copied().collect(),
            shots: self.shots.iter().copied().collect(),
            ended: self.ended.iter().copied().collect(),
            stock: self.stock,
            check: self.check,
            ..Delta::default()
        };
        for (&object, fate) in &self.fates {
            match fate.left {
                Some(Leaving::Vanished) => delta.vanished.push(object),
                Some(Leaving::Died) => delta.died.push(object),
                None => {}
            }
            match fate.motion {
                Some(Motion::Moved(moved)) => delta.moved.push(moved),
                Some(Motion::Stopped(stopped)) => delta.stopped.push(stopped),
                None => {}
            }
            delta.changed.extend(fate.changed);
            delta.appeared.extend(fate.appeared);
        }
        delta
    }

    fn fate(&mut self, object: Handle) -> &mut Fate {
        self.fates.entry(object).or_default()
    }

    /// A tile that changes twice is as before, and so is a bound that is there twice.
    fn toggle(&mut self, runs: &[(u32, u32)]) {
        let mut at = 0u32;
        for &(skip, count) in runs {
            let first = at.wrapping_add(skip);
            at = first.wrapping_add(count);
            for bound in [first, at] {
                if !self.bounds.remove(&bound) {
                    self.bounds.insert(bound);
                }
            }
        }
    }

    fn sight(&self) -> Vec<(u32, u32)> {
        let bounds: Vec<u32> = self.bounds.iter().copied().collect();
        let mut at = 0;
        let run = |bounds: &[u32; 2]| {
            let [first, end] = *bounds;
            let run = (first - at, end - first);
            at = end;
            run
        };
        bounds.as_chunks().0.iter().map(run).collect()
    }
}

impl Fate {
    fn precede_appeared(&mut self, new: &Appeared) {
        match self.left.take() {
            // It came and went, and if it came once more, that is how it is.
            Some(leaving) => self.is_dead |= leaving == Leaving::Died,
            None => {
                let mut new = *new;
                match self.motion.take() {
                    Some(Motion::Moved(moved)) => new.base = moved.base,
                    Some(Motion::Stopped(stopped)) => new.base = stopped.base(),
                    None => {}
                }
                if let Some(changed) = self.changed.take() {
                    new.status = changed.status.unwrap_or(new.status);
                    new.own = changed.own.or(new.own);
                }
                self.appeared = Some(new);
            }
        }
    }

    fn precede_changed(&mut self, earlier: &Changed) {
        if self.left.is_some() {
            return;
        }
        let later = self.changed.get_or_insert(*earlier);
        later.status = later.status.or(earlier.status);
        later.own = later.own.or(earlier.own);
    }

    fn precede_motion(&mut self, earlier: Motion) {
        if self.left.is_none() {
            self.motion.get_or_insert(earlier);
        }
    }

    fn precede_leaving(&mut self, leaving: Leaving) {
        self.left = Some(if self.is_dead { Leaving::Died } else { leaving });
        self.is_dead = false;
    }
}

fn put_before<T: Clone>(later: &mut VecDeque<T>, earlier: &[T]) {
    for item in earlier.iter().rev() {
        later.push_front(item.clone());
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec2;

    use super::*;
    use crate::base::Base;
    use crate::identity::UnitTypeId;
    use crate::outcome::Outcome;
    use crate::status::{EndOfTask, Status, Task};

    #[test]
    fn who_came_and_went_is_not_told_and_who_was_there_is_told_as_dead() {
        // Handle 0 is there from the start, dies, 1 comes and goes, 2 comes, moves and is hurt, 3 comes and dies.
        let deltas = [
            Delta { appeared: vec![new(1), new(2), new(3)], ..at(1) },
            Delta { vanished: vec![Handle(1)], moved: vec![moved(0, 2), moved(2, 2)], ..at(2) },
            Delta { died: vec![Handle(0), Handle(3)], changed: vec![hurt(2)], ..at(3) },
        ];
        let merged = merge(&deltas);
        let expected = Appeared { base: moved(2, 2).base, status: hurt(2).status.unwrap(), ..new(2) };
        assert_eq!(merged, Delta { appeared: vec![expected], died: vec![Handle(0)], ..at(3) });
    }

    #[test]
    fn who_comes_back_with_its_old_name_goes_and_comes() {
        let back = |object| Appeared { unit_type: UnitTypeId(7), ..new(object) };
        let deltas = [
            Delta { vanished: vec![Handle(4), Handle(5)], ..at(1) },
            Delta { appeared: vec![back(4), back(5)], ..at(2) },
            Delta { died: vec![Handle(5)], ..at(3) },
        ];
        let expected =
            Delta { vanished: vec![Handle(4)], died: vec![Handle(5)], appeared: vec![back(4)], ..at(3) };
        assert_eq!(merge(&deltas), expected);
    }

    #[test]
    fn of_motions_and_changes_the_last_counts_and_news_run_on() {
        let stop =
            Stopped { object: Handle(0), point: DVec2::ONE, cycle: Cycle(1), fraction: 0.5, reason: None };
        let result = |seq| CommandResult { seq, outcome: Outcome::Applied { cycle: Cycle(0), late: 0 } };
        let shot = |object| Shot { object: Handle(object), target: None };
        let ended = |object| Ended { object: Handle(object), task: Task::Hold, why: EndOfTask::Done };
        let deltas = [
            Delta {
                results: vec![result(5), result(6)],
                moved: vec![moved(0, 1)],
                stopped: vec![Stopped { object: Handle(1), ..stop }],
                shots: vec![shot(9)],
                ended: vec![ended(2)],
                stock: Some(7),
                ..at(1)
            },
            Delta {
                results: vec![result(1)],
                moved: vec![moved(1, 2)],
                stopped: vec![stop],
                shots: vec![shot(1), shot(9)],
                ended: vec![ended(1)],
                ..at(2)
            },
        ];
        let expected = Delta {
            results: vec![result(5), result(6), result(1)],
            shots: vec![shot(9), shot(1), shot(9)],
            ended: vec![ended(2), ended(1)],
            stock: Some(7),
            ..deltas[1].clone()
        };
        assert_eq!(merge(&deltas), expected);
    }

    #[test]
    fn tiles_that_change_twice_are_as_before() {
        for (runs, expected) in [
            ([vec![(3, 4)], vec![(3, 4)]], vec![]),
            ([vec![(3, 4)], vec![(7, 2)]], vec![(3, 6)]),
            ([vec![(0, 10)], vec![(2, 3)]], vec![(0, 2), (3, 5)]),
            ([vec![(0, 2), (2, 2)], vec![(1, 4)]], vec![(0, 1), (1, 2), (1, 1)]),
        ] {
            let deltas = runs.map(|sight| Delta { sight, ..at(1) });
            assert_eq!(merge(&deltas).sight, expected, "{deltas:?}");
        }
    }

    fn merge(deltas: &[Delta]) -> Delta {
        let (last, before) = deltas.split_last().unwrap();
        let mut merge = Merge::new(last);
        before.iter().rev().for_each(|delta| merge.precede(delta));
        merge.delta()
    }

    fn at(cycle: u32) -> Delta {
        Delta { cycle: Cycle(cycle), check: Digest(u64::from(cycle)), ..Delta::default() }
    }

    fn base(cycle: u32) -> Base {
        Base { point: DVec2::X, cycle: Cycle(cycle), fraction: 0.0, velocity: DVec2::Y }
    }

    fn new(object: u32) -> Appeared {
        Appeared {
            object: Handle(object),
            unit_type: UnitTypeId(0),
            owner: None,
            base: base(0),
            status: Status::default(),
            own: None,
        }
    }

    fn moved(object: u32, cycle: u32) -> Moved {
        Moved { object: Handle(object), base: base(cycle) }
    }

    fn hurt(object: u32) -> Changed {
        let status = Status { hit_points: Some(3), ..Status::default() };
        Changed { object: Handle(object), status: Some(status), own: None }
    }
}
