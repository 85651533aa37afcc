//! Fights: weapons, ranges, damage and death.
//!
//! A shot is fired at the start of a cycle at what is in range then, and takes effect at its end, when all damage of the cycle is summed up:
//! who is killed in a cycle has still fired in it, and the order of seats gives nobody an advantage.

use std::collections::BTreeMap;
use std::sync::Arc;

use glam::DVec2;
use maniple_geometry::{Cycle, ObjectId};
use maniple_view::{EndOfTask, Falloff, Mode, Refusal, Seat, Shape, Splash, Weapon, hull_distance};

use super::approach::{Approach, Goal, approach, is_blocked};
use super::crowd::Crowd;
use crate::keyed::{Purpose, keyed};
use crate::world::{Job, State};

/// Damage that takes effect at the end of the cycle.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Hit {
    victim: ObjectId,
    /// Before armour.
    damage: u32,
    /// Who did it.
    by: Option<Seat>,
}

/// What a shot is fired at.
#[derive(Clone, Copy, Debug)]
enum Mark {
    Object(ObjectId),
    Point(DVec2),
}

/// What goes off around a point.
#[derive(Clone, Copy, Debug)]
struct Burst {
    point: DVec2,
    damage: u32,
    splash: Splash,
}

/// Tells an object to attack another one that its seat sees.
pub(crate) fn attack(state: &mut State, object: ObjectId, target: ObjectId) -> Result<(), Refusal> {
    let weapon = state.weapon(object).ok_or(Refusal::UnknownAction)?;
    if state.team(object) == state.team(target) || !can_hit(state, weapon, target) {
        return Err(Refusal::BadTarget);
    }
    state.set_job(object, Job::Attack { target });
    Ok(())
}

/// Tells an object to fire at a point.
pub(crate) fn attack_at(state: &mut State, object: ObjectId, point: DVec2) -> Result<(), Refusal> {
    let weapon = state.weapon(object).ok_or(Refusal::UnknownAction)?;
    weapon.splash.ok_or(Refusal::UnknownAction)?;
    state.set_job(object, Job::AttackAt { point });
    Ok(())
}

/// Tells an object to fight its way to a point.
pub(crate) fn attack_move(state: &mut State, object: ObjectId, goal: DVec2) -> Result<(), Refusal> {
    if state.weapon(object).is_none() || state.speed(object) == 0.0 {
        return Err(Refusal::UnknownAction);
    }
    state.set_job(object, Job::AttackMove { goal });
    Ok(())
}

/// Tells an object to stand and fight.
pub(crate) fn hold(state: &mut State, object: ObjectId) -> Result<(), Refusal> {
    state.weapon(object).ok_or(Refusal::UnknownAction)?;
    state.set_job(object, Job::Hold);
    Ok(())
}

/// Lets all who fight go on at the start of a cycle; returns what they hit.
pub(crate) fn fight(state: &mut State, busy: &[ObjectId]) -> Vec<Hit> {
    let mut hits = Vec::new();
    let fights = |object: &ObjectId| match state.units.at(*object).job {
        Job::Attack { .. } | Job::AttackAt { .. } | Job::AttackMove { .. } | Job::Hold => true,
        Job::None | Job::Gather { .. } | Job::ReturnLoad { .. } | Job::Build { .. } => false,
    };
    let fighters: Vec<ObjectId> = busy.iter().copied().filter(fights).collect();
    if fighters.is_empty() {
        return hits;
    }
    let crowd = Crowd::of(state);
    let scenario = Arc::clone(&state.scenario);
    for object in fighters {
        let unit = state.units.at(object);
        let kind = &scenario.unit_types[usize::from(unit.unit_type.0)];
        let weapon = match unit.mode {
            Mode::Normal => kind.weapon.as_ref(),
            Mode::Alternate => kind.alternate.as_ref().and_then(|other| other.weapon.as_ref()),
            Mode::Switching | Mode::SwitchingBack | Mode::Site => None,
        };
        let Some(weapon) = weapon else { continue };
        let shooter = Shooter { object, weapon, crowd: &crowd };
        match unit.job {
            Job::Attack { target } => shooter.attack(state, target, &mut hits),
            Job::AttackAt { point } => shooter.attack_at(state, point, &mut hits),
            Job::AttackMove { goal } => shooter.attack_move(state, goal, &mut hits),
            Job::Hold => {
                state.halt(object);
                shooter.fire_at_will(state, &mut hits);
            }
            Job::None | Job::Gather { .. } | Job::ReturnLoad { .. } | Job::Build { .. } => {}
        }
    }
    hits
}

/// Lets all damage of a cycle take effect; who has no hit points left is dead.
pub(crate) fn land(state: &mut State, mut hits: Vec<Hit>) {
    hits.sort_by_key(|hit| hit.victim);
    let mut dead = Vec::new();
    for of_one in hits.chunk_by(|one, other| one.victim == other.victim) {
        let victim = of_one[0].victim;
        let armor = armor(state, victim);
        let mut by: BTreeMap<Option<Seat>, u64> = BTreeMap::new();
        for hit in of_one.iter().filter(|hit| hit.damage > 0) {
            *by.entry(hit.by).or_default() += u64::from(hit.damage.saturating_sub(armor).max(1));
        }
        let total: u64 = by.values().sum();
        if total == 0 {
            continue;
        }
        let unit = state.units.edit(victim);
        unit.hit_points = unit.hit_points.saturating_sub(u32::try_from(total).unwrap_or(u32::MAX));
        if unit.hit_points == 0 {
            dead.push((victim, killer(state, victim, &by)));
        }
    }
    for (victim, killer) in dead {
        count(state, victim, killer);
        state.remove(victim);
    }
}

/// Tells those whose target has died in the cycle: they saw it at its start, or they would not have it any more.
pub(crate) fn conclude(state: &mut State, busy: &[ObjectId]) {
    for &object in busy {
        let Job::Attack { target } = state.units.at(object).job else { continue };
        if !state.units.is_alive(target) {
            state.halt(object);
            state.end_job(object, EndOfTask::Done);
        }
    }
}

/// An object that fights, with the weapon of its mode.
struct Shooter<'a> {
    object: ObjectId,
    weapon: &'a Weapon,
    crowd: &'a Crowd,
}

impl Shooter<'_> {
    fn attack(&self, state: &mut State, target: ObjectId, hits: &mut Vec<Hit>) {
        let object = self.object;
        let sees = state.units.at(object).owner.is_some_and(|owner| state.sight.sees(owner, target));
        if !sees {
            state.halt(object);
            state.end_job(object, EndOfTask::Lost);
            return;
        }
        if !state.units.is_alive(target) {
            return;
        }
        let goal = Goal::object(state, target, self.weapon.range);
        match approach(state, object, &goal) {
            Approach::There => self.fire(state, Mark::Object(target), hits),
            Approach::Coming => {}
            Approach::Blocked => state.end_job(object, EndOfTask::Blocked),
        }
    }

    fn attack_at(&self, state: &mut State, point: DVec2, hits: &mut Vec<Hit>) {
        let goal = Goal { center: point, shape: Shape::Circle { radius: 0.0 }, reach: self.weapon.range };
        match approach(state, self.object, &goal) {
            Approach::There => self.fire(state, Mark::Point(point), hits),
            Approach::Coming => {}
            Approach::Blocked => state.end_job(self.object, EndOfTask::Blocked),
        }
    }

    fn attack_move(&self, state: &mut State, goal: DVec2, hits: &mut Vec<Hit>) {
        let object = self.object;
        if let Some(target) = self.nearest_enemy(state) {
            state.halt(object);
            self.fire(state, Mark::Object(target), hits);
            return;
        }
        let end = if state.center(object) == goal {
            EndOfTask::Done
        } else if is_blocked(state, object) {
            EndOfTask::Blocked
        } else {
            state.send(object, goal);
            return;
        };
        state.end_job(object, end);
        state.set_job(object, Job::Hold);
    }

    fn fire_at_will(&self, state: &mut State, hits: &mut Vec<Hit>) {
        if state.cycle() < state.units.at(self.object).ready {
            return;
        }
        if let Some(target) = self.nearest_enemy(state) {
            self.fire(state, Mark::Object(target), hits);
        }
    }

    /// Returns the enemy in range that is nearest, hull to hull; of several by (y, x, layer), which says nothing but what is seen.
    fn nearest_enemy(&self, state: &State) -> Option<ObjectId> {
        let center = state.center(self.object);
        let shape = state.kind(self.object).shape;
        let owner = state.units.at(self.object).owner?;
        let mut best: Option<(f64, DVec2, ObjectId)> = None;
        for other in self.crowd.near(center, self.weapon.range + shape.radius()) {
            if !state.are_enemies(self.object, other) || !can_hit(state, self.weapon, other) {
                continue;
            }
            let place = state.center(other);
            let distance = apart(place - center, &shape, &state.kind(other).shape);
            if distance > self.weapon.range || distance < self.weapon.range_min || !state.sees(owner, other) {
                continue;
            }
            let is_better = best.is_none_or(|(nearest, at, who)| {
                distance
                    .total_cmp(&nearest)
                    .then(place.y.total_cmp(&at.y))
                    .then(place.x.total_cmp(&at.x))
                    .then(state.kind(other).layer.cmp(&state.kind(who).layer))
                    .is_lt()
            });
            if is_better {
                best = Some((distance, place, other));
            }
        }
        best.map(|(.., target)| target)
    }

    /// Fires if the weapon is ready and the mark is not too near.
    fn fire(&self, state: &mut State, mark: Mark, hits: &mut Vec<Hit>) {
        let (object, now) = (self.object, state.cycle());
        if now < state.units.at(object).ready {
            return;
        }
        let (point, shape, target) = match mark {
            Mark::Object(target) => (state.center(target), state.kind(target).shape, Some(target)),
            Mark::Point(point) => (point, Shape::Circle { radius: 0.0 }, None),
        };
        let distance = apart(point - state.center(object), &state.kind(object).shape, &shape);
        if distance < self.weapon.range_min {
            return;
        }
        let Weapon { damage_min, damage_max, cooldown, .. } = *self.weapon;
        let spread = u64::from(damage_max - damage_min) + 1;
        let more = u32::try_from(state.random(object, Purpose::Damage) % spread).unwrap_or(0);
        let damage = damage_min + more;
        state.units.edit(object).ready = Cycle(now.0.saturating_add(cooldown));
        state.shots.push((object, target));
        let by = state.units.at(object).owner;
        match (self.weapon.splash, target) {
            (Some(splash), _) => self.burst(state, &Burst { point, damage, splash }, hits),
            (None, Some(victim)) => hits.push(Hit { victim, damage, by }),
            (None, None) => {}
        }
    }

    /// Hits everybody around a point whom the weapon hits; those of the own team only where the scenario says so.
    fn burst(&self, state: &State, burst: &Burst, hits: &mut Vec<Hit>) {
        let Burst { point, damage, splash } = *burst;
        let by = state.units.at(self.object).owner;
        let spares_friends = state.scenario.combat.is_none_or(|combat| !combat.friendly_fire);
        for victim in self.crowd.near(point, splash.radius) {
            let is_friend = state.team(victim) == state.team(self.object);
            if !can_hit(state, self.weapon, victim) || (is_friend && spares_friends) {
                continue;
            }
            let spot = Shape::Circle { radius: 0.0 };
            let distance = hull_distance(state.center(victim) - point, &spot, &state.kind(victim).shape);
            if distance <= splash.radius {
                hits.push(Hit { victim, damage: fallen_off(damage, distance, splash), by });
            }
        }
    }
}

/// Returns how far it is from hull to hull; who flies over something is at no distance from it.
fn apart(offset: DVec2, one: &Shape, other: &Shape) -> f64 {
    let distance = hull_distance(offset, one, other);
    if distance > 0.0 { distance } else { 0.0 }
}

/// Returns the damage at a distance from the point that is hit; negative distances count as 0.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "between 0 and the damage")]
fn fallen_off(damage: u32, distance: f64, splash: Splash) -> u32 {
    match splash.falloff {
        Falloff::None => damage,
        Falloff::Linear if distance <= 0.0 => damage,
        Falloff::Linear => (f64::from(damage) * (1.0 - distance / splash.radius)).floor() as u32,
    }
}

/// Returns whether a weapon can hurt an object, wherever it is.
fn can_hit(state: &State, weapon: &Weapon, target: ObjectId) -> bool {
    let kind = state.kind(target);
    kind.hit_points.is_some() && weapon.targets.contains(&kind.layer)
}

/// Returns the armour of an object in its present mode; while it switches that of the mode from which it does.
fn armor(state: &State, object: ObjectId) -> u32 {
    let kind = state.kind(object);
    match state.units.at(object).mode {
        Mode::Normal | Mode::Switching | Mode::Site => kind.armor,
        Mode::Alternate | Mode::SwitchingBack => {
            kind.alternate.as_ref().map_or(kind.armor, |other| other.armor)
        }
    }
}

/// Returns who did most damage to a dead object; of several who did as much, one by chance.
fn killer(state: &State, victim: ObjectId, by: &BTreeMap<Option<Seat>, u64>) -> Option<Seat> {
    let luck = |seat: Option<Seat>| {
        let unit = state.units.at(victim);
        let salt = seat.map_or(0, |seat| u32::from(seat.0) + 1);
        keyed(
            state.scenario.seed ^ u64::from(salt) << 32,
            state.cycle(),
            unit.owner,
            unit.index,
            Purpose::Kill,
        )
    };
    by.iter().max_by_key(|&(&seat, &damage)| (damage, luck(seat))).and_then(|(&seat, _)| seat)
}

/// Counts a death; one's own side and nobody's units are no kills.
fn count(state: &mut State, victim: ObjectId, killer: Option<Seat>) {
    let is_building = state.kind(victim).is_building();
    let now = state.cycle();
    let Some(owner) = state.units.at(victim).owner else { return };
    let team = state.seats[owner.index()].team;
    let lost = &mut state.seats[owner.index()].tally;
    if is_building {
        lost.buildings_lost += 1;
    } else {
        lost.units_lost += 1;
    }
    let Some(killer) = killer.filter(|killer| state.seats[killer.index()].team != team) else { return };
    let won = &mut state.seats[killer.index()].tally;
    if is_building {
        won.buildings_destroyed += 1;
        won.last_building = now;
    } else {
        won.units_destroyed += 1;
    }
}
