//! Fighters: when they set out, where to, and at whom they fire.

use std::collections::BTreeMap;

use glam::DVec2;
use maniple_view::{Command, Handle, Mode, Task, View};

use super::ground::Ground;
use super::trips::{Step, Trips, path};
use crate::fighting::{Siege, Sieges, deploy, is_fighter, is_in_range};
use crate::keyed::{Purpose, keyed};
use crate::seeing::{Block, Item, Memory, Scene, Search, middle, nearest};

/// Fighters with which an army sets out first where more can be trained.
const ARMY_MIN: usize = 8;

/// By chance up to so many more.
const ARMY_SPREAD: u64 = 8;

/// How many more each time that it sets out.
const ARMY_MORE: usize = 4;

/// Largest number that is waited for.
const ARMY_MAX: usize = 36;

/// An army that has shrunk to less than this part of what it set out with turns back.
const ARMY_LEAST: usize = 4;

/// Enemies as near to a building as this, in world units, are a threat.
const THREAT: f64 = 16.0;

/// How far from home an army waits, as a part of the way to the middle of the map.
const RALLY: f64 = 0.3;

/// All fighters of the seat.
#[derive(Clone, Debug)]
pub(super) struct Army {
    seed: u64,
    search: Search,
    /// Whether more fighters can come.
    grows: bool,
    is_out: bool,
    /// With how many it sets out next.
    strength: usize,
    /// At whom each was told to fire.
    targets: BTreeMap<Handle, Handle>,
    sieges: Sieges,
}

/// What an army gives its orders from.
pub(super) struct Situation<'a, 'b> {
    pub(super) ground: &'b mut Ground,
    pub(super) trips: &'b mut Trips,
    pub(super) memory: &'b Memory,
    pub(super) view: &'a View,
    pub(super) scene: &'b Scene<'a>,
    /// Whether splash hurts the own team, too.
    pub(super) friendly_fire: bool,
}

impl Army {
    /// Returns an army; it sets out at once unless more fighters can come.
    pub(super) fn new(seed: u64, search: Search, grows: bool) -> Self {
        Self {
            seed,
            search,
            grows,
            is_out: !grows,
            strength: ARMY_MIN + more(seed, 0),
            targets: BTreeMap::new(),
            sieges: Sieges::default(),
        }
    }

    /// Tells all fighters what to do.
    pub(super) fn fight(&mut self, situation: &mut Situation<'_, '_>) -> Vec<Command> {
        let scene = situation.scene;
        self.targets.retain(|object, _| scene.own(*object).is_some());
        self.sieges.refresh(scene);
        let fighters: Vec<&Item<'_>> = scene.own.iter().filter(|item| is_fighter(item)).collect();
        if fighters.is_empty() {
            self.is_out &= !self.grows;
            return Vec::new();
        }
        self.muster(situation.view, fighters.len());
        let goal = self.goal(situation, &fighters);
        let mut commands = Vec::new();
        for item in fighters {
            match item.seen.status.mode {
                Mode::Normal => {
                    let command = (deploy(item, &scene.enemies, 0.0))
                        .or_else(|| self.engage(situation, item))
                        .or_else(|| self.advance(situation, item, &goal));
                    commands.extend(command);
                }
                Mode::Alternate => commands.extend(self.besiege(situation, item)),
                Mode::Switching | Mode::SwitchingBack | Mode::Site => {}
            }
        }
        commands
    }

    /// Decides whether the army is out.
    fn muster(&mut self, view: &View, fighters: usize) {
        if !self.grows {
            return;
        }
        if self.is_out && fighters * ARMY_LEAST < self.strength {
            self.is_out = false;
            self.strength = (self.strength + ARMY_MORE + more(self.seed, view.cycle().0)).min(ARMY_MAX);
        } else if fighters >= self.strength {
            self.is_out = true;
        }
    }

    /// Returns where all go: to who threatens a building, or, if the army is out, to the nearest enemy that is known, and
    /// where none is, to where one might be.
    fn goal(&mut self, situation: &Situation<'_, '_>, fighters: &[&Item<'_>]) -> Block {
        let scene = situation.scene;
        let is_threat = |enemy: &&Item<'_>| scene.is_near_buildings(enemy, THREAT);
        let home = self.search.home();
        let threat = if self.grows { nearest(scene.enemies.iter().filter(is_threat), home) } else { None };
        if let Some(threat) = threat {
            return threat.block();
        }
        let size = situation.ground.size();
        if !self.is_out {
            return Block { center: home + (size * 0.5 - home) * RALLY, half: DVec2::ZERO };
        }
        let center = middle(fighters.iter().copied());
        Search::known(scene, situation.memory, center)
            .unwrap_or_else(|| self.search.place(size, fighters.iter().map(|item| item.center)))
    }

    /// Fires at the weakest enemy in range.
    fn engage(&mut self, situation: &Situation<'_, '_>, item: &Item<'_>) -> Option<Command> {
        let weapon = item.kind.weapon.as_ref()?;
        let own = item.seen.own?;
        let in_range = |enemy: &&Item<'_>| is_in_range(item, enemy, weapon);
        let weakest = |enemy: &&Item<'_>| (!is_armed(enemy), enemy.seen.status.hit_points, enemy.object);
        let target = situation.scene.enemies.iter().filter(in_range).min_by_key(weakest)?;
        if own.ready.0 > situation.view.cycle().0 + 1 && own.task != Task::None {
            return None;
        }
        let is_told = own.task == Task::Attack && self.targets.get(&item.object) == Some(&target.object);
        if is_told {
            return None;
        }
        self.targets.insert(item.object, target.object);
        Some(Command::Attack { object: item.object, target: target.object })
    }

    /// Goes on towards the goal, ready to fight.
    fn advance(
        &mut self,
        situation: &mut Situation<'_, '_>,
        item: &Item<'_>,
        goal: &Block,
    ) -> Option<Command> {
        let own = item.seen.own?;
        let stands = !item.seen.base.is_moving() && matches!(own.task, Task::None | Task::Hold);
        let is_there = item.center.distance(goal.center) < 1.5;
        let object = item.object;
        if !stands || is_there {
            let is_idle = stands && own.task == Task::None;
            return is_idle.then_some(Command::Hold { object });
        }
        let to = |point: DVec2| Command::AttackMove { object, x: point.x, y: point.y };
        match situation.trips.step(situation.ground, situation.view, item, goal) {
            Step::Wait => None,
            Step::Now => Some(to(goal.center)),
            Step::Aside(point) => path(object, &[point]),
            Step::Along => situation.trips.way(situation.ground, item, goal).first().copied().map(to),
        }
    }

    /// Fires from the other mode at where it hits most; goes back when there has been nobody in range for a while.
    fn besiege(&mut self, situation: &Situation<'_, '_>, item: &Item<'_>) -> Option<Command> {
        let object = item.object;
        let Situation { view, scene, friendly_fire, .. } = situation;
        match self.sieges.next(item, scene, view.cycle(), *friendly_fire)? {
            Siege::Fire(point) => Some(Command::AttackAt { object, x: point.x, y: point.y }),
            Siege::Over => Some(Command::Switch { object }),
            Siege::Wait | Siege::Spare => None,
        }
    }
}

/// Returns by chance how many fighters more to wait for.
fn more(seed: u64, cycle: u32) -> usize {
    usize::try_from(keyed(seed, cycle, 0, Purpose::Strength) % ARMY_SPREAD).unwrap_or(0)
}

fn is_armed(item: &Item<'_>) -> bool {
    item.kind.weapon.is_some()
}
