//! All by one schedule, and anew whoever falls out of it.

use glam::DVec2;
use maniple_geometry::Circle;

use super::Progress;
use super::plan::{Plan, along, leads_over};
use super::scene::{Delivery, GRACE, LEAD, Order, Scene, is_there};
use super::squads::{Squad, Squads};
use crate::ground::{Ground, MARGIN};
use crate::planner::Planner;
use crate::release::{Goals, Group, Moving, Releasing, Request, Walk, by_distance};
use crate::work::{PATH, Work};

/// Cycles from one attempt to schedule those who wait to the next, at first and at most: each that brings nothing doubles them.
const RETRY_MIN: u32 = 8;
const RETRY_MAX: u32 = 128;

/// From how many on those who wait are scheduled as one group, in lanes, if others have left; fewer may be anywhere, and go each by
/// itself to the goal that is assigned to it. At the beginning all are one group.
const GROUP_MIN: usize = 32;

/// How often a unit that has arrived may be roused to make room for another, so that no two make room for each other for ever.
const ROUSED_MAX: u32 = 4;

/// What a unit is doing.
#[derive(Clone, Debug)]
enum State {
    /// It has no plan, and rests or is coming to rest; from this cycle on it can be taken to rest.
    Idle { since: u32 },
    /// It has a plan.
    Planned(Plan),
    /// It rests at this place among the goals.
    Arrived(usize),
    /// No way leads to a goal.
    Unreachable,
}

/// What is done where there is no schedule for everybody.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Partly {
    /// Nobody goes, since another way may be better.
    Never,
    /// As many go as can.
    Allowed,
}

/// A schedule that is being looked for.
#[derive(Clone, Debug)]
struct Planning {
    /// For whom.
    ready: Vec<usize>,
    /// For each group the places of its goals.
    places: Vec<Vec<usize>>,
    /// The cycle in which it begins.
    base: u32,
    /// Whether it cannot begin later, since others are on their way.
    is_waited_for: bool,
    /// Whether nobody may be left.
    is_of_all: bool,
    /// The cycle in which it was begun to be looked for.
    begun: u32,
    releasing: Releasing,
}

/// Leads by schedules.
#[derive(Clone, Debug)]
pub(crate) struct Scheduled {
    goals: Vec<DVec2>,
    squads: Vec<Squad>,
    speed: f64,
    partly: Partly,
    /// Whether schedules for all are found; tests of what comes behind them take that away.
    finds_schedules: bool,
    /// How often an order is given again before its departure.
    repeats: u32,
    /// The cycles in which these orders are given again.
    again: Vec<(u32, Order)>,
    /// What is being planned.
    planning: Option<Box<Planning>>,
    /// Cycles that planning among others who move is given.
    allowance: u32,
    /// Whether there is no schedule for all who wait.
    has_failed: bool,
    /// Whether the last attempt came to nothing, and nobody is on its way.
    is_stuck: bool,
    /// Empty before the first cycle.
    states: Vec<State>,
    /// How often each has been roused.
    roused: Vec<u32>,
    /// How many of those who wait have been looked at for whom somebody may be roused.
    looked: usize,
    /// The cycle of the next attempt to schedule those who wait, and the cycles to the one after it.
    next: u32,
    retry: u32,
}

impl Scheduled {
    pub(crate) fn new(squads: Squads, speed: f64, delivery: Delivery) -> Self {
        let Squads { goals, squads } = squads;
        // One group has nobody to meet: it can go in parts as well as at once, and with fewer orders than in step.
        let partly = if squads.len() == 1 { Partly::Allowed } else { Partly::Never };
        Self {
            goals,
            squads,
            speed,
            partly,
            finds_schedules: true,
            repeats: delivery.repeats(),
            again: Vec::new(),
            planning: None,
            allowance: 0,
            has_failed: false,
            is_stuck: false,
            states: Vec::new(),
            roused: Vec::new(),
            looked: 0,
            next: 0,
            retry: RETRY_MIN,
        }
    }

    /// Returns the same that finds no schedule for all, as where there is none.
    #[cfg(test)]
    pub(crate) fn without_schedules(self) -> Self {
        Self { finds_schedules: false, ..self }
    }

    /// Returns the same that lets go whoever can.
    pub(crate) fn partly(mut self) -> Self {
        self.partly = Partly::Allowed;
        self
    }

    pub(crate) fn advance(&mut self, ground: &Ground, scene: &Scene<'_>, work: &mut Work) -> Vec<Order> {
        if self.states.is_empty() {
            self.states = vec![State::Idle { since: 0 }; scene.units.len()];
            self.roused = vec![0; scene.units.len()];
        }
        let mut orders = Vec::new();
        let dropped = self.look(scene);
        if dropped > 0 {
            (self.next, self.retry) = (scene.cycle, RETRY_MIN);
            self.planning = None;
        }
        self.repeat(scene.cycle, &mut orders);
        self.go_on(scene.cycle, &mut orders);
        let before = orders.len();
        self.stop_those_in_the_way(ground, scene, &mut orders);
        if orders.len() > before {
            self.next = scene.cycle + GRACE;
            self.planning = None;
        }
        if self.planning.is_none() && scene.cycle >= self.next {
            self.schedule(ground, scene);
        }
        self.plan(ground, (scene, work), &mut orders);
        orders
    }

    /// Returns whether the last attempt came to nothing, and nobody is on its way.
    pub(crate) fn is_stuck(&self) -> bool {
        self.is_stuck
    }

    /// From now on lets go whoever can, and tries at once; others have led the units, and to no end.
    pub(crate) fn go_partly(&mut self, scene: &Scene<'_>) {
        for (state, seen) in self.states.iter_mut().zip(scene.units) {
            if let State::Arrived(goal) = state
                && !is_there(seen.position, self.goals[*goal])
            {
                *state = State::Idle { since: scene.cycle };
            }
        }
        self.partly = Partly::Allowed;
        self.next = scene.cycle;
    }

    /// Takes in that others have led the units, each to a goal, or to none.
    pub(crate) fn take_over(&mut self, cycle: u32, goals: &[Option<usize>]) {
        let state = |goal: &Option<usize>| goal.map_or(State::Idle { since: cycle }, State::Arrived);
        self.states = goals.iter().map(state).collect();
        self.again.clear();
        (self.planning, self.has_failed) = (None, false);
        (self.next, self.retry, self.is_stuck) = (cycle, RETRY_MIN, false);
    }

    /// Returns whether everybody has arrived.
    pub(crate) fn have_all_arrived(&self) -> bool {
        self.states.iter().all(|state| matches!(state, State::Arrived(_)))
    }

    /// Gives those orders again whose time it is, if their units are still to depart.
    fn repeat(&mut self, cycle: u32, orders: &mut Vec<Order>) {
        let states = &self.states;
        self.again.retain(|(due, order)| {
            let is_to_depart =
                matches!(&states[order.unit], State::Planned(plan) if Some(plan.departure) == order.start);
            let is_in_time = order.start.is_some_and(|start| start >= f64::from(cycle + LEAD));
            if *due == cycle && is_to_depart && is_in_time {
                orders.push(order.clone());
            }
            *due > cycle && is_to_depart
        });
    }

    /// Gives those the rest of their legs who have more than one order holds.
    fn go_on(&mut self, cycle: u32, orders: &mut Vec<Order>) {
        let (speed, repeats) = (self.speed, self.repeats);
        for (unit, state) in self.states.iter_mut().enumerate() {
            if let State::Planned(plan) = state {
                orders.extend(plan.next_order(unit, f64::from(cycle), (speed, repeats)));
            }
        }
    }

    pub(crate) fn progress(&self, unit: usize) -> Progress {
        match self.states.get(unit) {
            None | Some(State::Idle { .. }) => Progress::Waiting,
            Some(State::Planned(_)) => Progress::Going,
            Some(State::Arrived(_)) => Progress::Arrived,
            Some(State::Unreachable) => Progress::Unreachable,
        }
    }

    /// Takes in who has arrived, and returns how many have fallen out of their plans, or were moved away from where they had arrived.
    fn look(&mut self, scene: &Scene<'_>) -> usize {
        let now = f64::from(scene.cycle);
        let grace = f64::from(GRACE);
        let mut dropped = 0;
        for (state, seen) in self.states.iter_mut().zip(scene.units) {
            if seen.is_moving {
                continue;
            }
            if let State::Arrived(goal) = state
                && !is_there(seen.position, self.goals[*goal])
            {
                *state = State::Idle { since: scene.cycle };
                dropped += 1;
            }
            let State::Planned(plan) = state else { continue };
            let goal = self.goals[plan.goal];
            if is_there(seen.position, goal) && now >= plan.arrival - grace {
                *state = State::Arrived(plan.goal);
            } else if now > plan.departure + grace {
                *state = State::Idle { since: scene.cycle };
                dropped += 1;
            }
        }
        dropped
    }

    /// Stops everybody whose way leads over one who rests without a plan, and whose way leads over these, and so on.
    fn stop_those_in_the_way(&mut self, ground: &Ground, scene: &Scene<'_>, orders: &mut Vec<Order>) {
        let reach = 2.0 * ground.radius() + MARGIN;
        let is_idle = |state: &State| matches!(state, State::Idle { .. } | State::Unreachable);
        let idle = self.states.iter().zip(scene.units).filter(|(state, _)| is_idle(state));
        let mut rests: Vec<(DVec2, f64)> = idle.map(|(_, seen)| (seen.position, reach)).collect();
        rests
            .extend(scene.others.iter().map(|other| (other.center, ground.radius() + other.radius + MARGIN)));
        let mut looked_at = 0;
        while let Some(&rest) = rests.get(looked_at) {
            looked_at += 1;
            for (unit, state) in self.states.iter_mut().enumerate() {
                let State::Planned(plan) = state else { continue };
                let ahead = plan.ahead(scene.units[unit]);
                if leads_over(&ahead, rest) {
                    // By the time the order applies it may be anywhere up to here.
                    let there = along(&ahead, self.speed * f64::from(GRACE));
                    rests.extend([(scene.units[unit].position, reach), (there, reach)]);
                    orders.retain(|order| order.unit != unit);
                    orders.push(Order::stop(unit));
                    *state = State::Idle { since: scene.cycle + GRACE };
                }
            }
        }
    }

    /// Begins to schedule those who rest without a plan.
    fn schedule(&mut self, ground: &Ground, scene: &Scene<'_>) {
        self.is_stuck = false;
        let is_ready = |unit: &usize| {
            let state = &self.states[*unit];
            matches!(state, State::Idle { since } if *since <= scene.cycle) && !scene.units[*unit].is_moving
        };
        let mut ready: Vec<usize> = (0..self.states.len()).filter(is_ready).collect();
        let free = self.free_goals();
        self.refuse_unreachable(ground, scene, (&mut ready, &free));
        let is_of_all =
            !self.has_failed && self.states.iter().all(|state| matches!(state, State::Idle { .. }));
        let least = if is_of_all { 1 } else { GROUP_MIN };
        let groups = self.groups(scene, (&mut ready, &free), least);
        if ready.is_empty() {
            self.put_off(scene.cycle);
            return;
        }
        let base = scene.cycle + LEAD + self.repeats + self.allowance;
        let (still, moving) = self.those_around(ground, scene, (&ready, base));
        let (groups, places): (Vec<Group>, Vec<Vec<usize>>) = groups.into_iter().unzip();
        let request = Request { groups: &groups, speed: self.speed, still: &still, moving: &moving };
        // The shared way of those who are left may not exist although each of them has one.
        let releasing = if is_of_all { Releasing::new(&request) } else { Releasing::of_some(&request) };
        let is_waited_for = !moving.is_empty();
        self.planning = Some(Box::new(Planning {
            ready,
            places,
            base,
            is_waited_for,
            is_of_all,
            begun: scene.cycle,
            releasing,
        }));
    }

    /// Goes on with what is being planned, and gives the orders when it is done.
    fn plan(&mut self, ground: &Ground, (scene, work): (&Scene<'_>, &mut Work), orders: &mut Vec<Order>) {
        let Some(planning) = &mut self.planning else { return };
        let Some(ended) = planning.releasing.go_on(ground, work) else { return };
        let Some(planning) = self.planning.take() else { return };
        let Planning { ready, places, base, is_waited_for, is_of_all, begun, .. } = *planning;
        let finds = self.finds_schedules;
        let ended = ended.ok().filter(|ended| !is_of_all || (finds && ended.stuck.is_none()));
        let earliest = scene.cycle + LEAD + self.repeats;
        if is_of_all && ended.is_none() {
            self.has_failed = self.partly == Partly::Allowed;
            self.is_stuck = self.partly == Partly::Never;
            if self.is_stuck {
                self.put_off(scene.cycle);
            }
            return;
        }
        self.has_failed = false;
        if is_waited_for && base < earliest {
            // It took longer than it was given: those who are on their way are elsewhere now.
            self.allowance = 2 * (scene.cycle - begun);
            return;
        }
        self.allowance = 0;
        let base = if is_waited_for { base } else { earliest };
        let walks = ended.map(|ended| ended.walks).unwrap_or_default();
        let places = walks.iter().zip(&places).flat_map(|(walks, places)| walks.iter().map(move |_| places));
        let places: Vec<&Vec<usize>> = places.collect();
        let mut departed = 0;
        for ((&unit, walk), places) in ready.iter().zip(walks.iter().flatten()).zip(places) {
            let Some(walk) = walk else { continue };
            departed += 1;
            self.depart(unit, (places[walk.goal], walk.clone()), (scene, base), orders);
        }
        if departed > 0 {
            (self.next, self.retry) = (scene.cycle + RETRY_MIN, RETRY_MIN);
            return;
        }
        self.put_off(scene.cycle);
        if self.rouse(ground, (scene, work), &ready) {
            self.next = scene.cycle + 1;
        } else {
            self.is_stuck = !self.states.iter().any(|state| matches!(state, State::Planned(_)));
        }
    }

    /// Who rests and who is on its way while those who are ready are scheduled, with times from a cycle on.
    fn those_around(
        &self,
        ground: &Ground,
        scene: &Scene<'_>,
        (ready, base): (&[usize], u32),
    ) -> (Vec<Circle>, Vec<Moving>) {
        let mut is_to_go = vec![false; self.states.len()];
        for &unit in ready {
            is_to_go[unit] = true;
        }
        let (mut still, mut moving) = (scene.others.to_vec(), Vec::new());
        for (unit, (state, seen)) in self.states.iter().zip(scene.units).enumerate() {
            match state {
                State::Planned(plan) => {
                    moving.push(plan.moving(f64::from(base), (self.speed, ground.radius())));
                }
                State::Idle { .. } if is_to_go[unit] => {}
                State::Idle { .. } | State::Arrived(_) | State::Unreachable => {
                    still.push(Circle::new(seen.position, ground.radius()));
                }
            }
        }
        (still, moving)
    }

    /// Rouses those who have arrived in the way of the first of those who wait; returns whether there are any.
    ///
    /// Goals fill up in another order than was planned where somebody comes late: then the free ones lie behind taken ones.
    fn rouse(&mut self, ground: &Ground, (scene, work): (&Scene<'_>, &mut Work), waiting: &[usize]) -> bool {
        let reach = 2.0 * ground.radius() + MARGIN;
        let mut planner = Planner::new(ground);
        let free = self.free_goals();
        // Who was looked at last time comes last.
        let first = self.looked % waiting.len();
        for &unit in waiting[first..].iter().chain(&waiting[..first]) {
            if !work.is_left() {
                break;
            }
            self.looked += 1;
            let from = scene.units[unit].position;
            for &goal in self.goals_of(unit, &free) {
                work.add(PATH);
                let Ok(legs) = planner.path(from, self.goals[goal]) else { continue };
                let way: Vec<DVec2> = std::iter::once(from).chain(legs.iter().copied()).collect();
                let is_in_the_way = |other: &usize| {
                    let is_arrived = matches!(self.states[*other], State::Arrived(_));
                    let position = scene.units[*other].position;
                    is_arrived && self.roused[*other] < ROUSED_MAX && leads_over(&way, (position, reach))
                };
                let others: Vec<usize> = (0..self.states.len()).filter(is_in_the_way).collect();
                for &other in &others {
                    self.roused[other] += 1;
                    self.states[other] = State::Idle { since: scene.cycle };
                }
                if !others.is_empty() {
                    return true;
                }
            }
        }
        false
    }

    fn put_off(&mut self, cycle: u32) {
        self.next = cycle + self.retry;
        self.retry = (2 * self.retry).min(RETRY_MAX);
    }

    /// The places of goals that nobody has or is going to, in their order.
    fn free_goals(&self) -> Vec<usize> {
        let mut is_free = vec![true; self.goals.len()];
        for state in &self.states {
            match state {
                State::Planned(Plan { goal, .. }) | State::Arrived(goal) => is_free[*goal] = false,
                State::Idle { .. } | State::Unreachable => {}
            }
        }
        (0..self.goals.len()).filter(|&goal| is_free[goal]).collect()
    }

    /// Those of some goals to which a unit may go.
    fn goals_of<'a>(&self, unit: usize, goals: &'a [usize]) -> &'a [usize] {
        let squad = self.squads.partition_point(|squad| squad.units.end <= unit);
        self.squads.get(squad).map_or(&[], |squad| squad.part_of(goals))
    }

    /// Takes out those who have no way to any free goal.
    fn refuse_unreachable(
        &mut self,
        ground: &Ground,
        scene: &Scene<'_>,
        (ready, free): (&mut Vec<usize>, &[usize]),
    ) {
        let mut planner = Planner::new(ground);
        ready.retain(|&unit| {
            let from = scene.units[unit].position;
            let goals = self.goals_of(unit, free);
            let is_reachable = |&goal: &usize| {
                let goal = self.goals[goal];
                ground.holds(goal) && planner.connects(from, goal)
            };
            let is_reachable = goals.iter().any(is_reachable);
            if !is_reachable && !goals.is_empty() {
                self.states[unit] = State::Unreachable;
            }
            is_reachable
        });
    }

    /// The units that are ready as groups, of `least` or of one each, with as many goals, and the places of these: those that are
    /// nearest. Leaves as many ready of each squad as there are goals for it.
    fn groups(
        &self,
        scene: &Scene<'_>,
        (ready, free): (&mut Vec<usize>, &[usize]),
        least: usize,
    ) -> Vec<(Group, Vec<usize>)> {
        let mut groups = Vec::new();
        let mut kept = Vec::new();
        for squad in &self.squads {
            let (mut units, mut goals) = (squad.members_of(ready).to_vec(), squad.part_of(free).to_vec());
            if squad.whose == Goals::Own {
                let goal_of = |unit: usize| squad.goals.start + (unit - squad.units.start);
                units.retain(|&unit| goals.binary_search(&goal_of(unit)).is_ok());
                goals = units.iter().map(|&unit| goal_of(unit)).collect();
            }
            units.truncate(goals.len());
            if !units.is_empty() {
                groups.extend(self.groups_of(scene, (&units, goals), (squad.whose, least)));
                kept.extend(units);
            }
        }
        *ready = kept;
        groups
    }

    /// Units of one squad as one group, if there are that many, or as a group each.
    fn groups_of(
        &self,
        scene: &Scene<'_>,
        (units, mut free): (&[usize], Vec<usize>),
        (whose, least): (Goals, usize),
    ) -> Vec<(Group, Vec<usize>)> {
        let starts: Vec<DVec2> = units.iter().map(|&unit| scene.units[unit].position).collect();
        if whose == Goals::Interchangeable {
            let middle = starts.iter().sum::<DVec2>() / starts.len() as f64;
            let distance = |goal: usize| self.goals[goal].distance_squared(middle);
            free.sort_by(|&a, &b| distance(a).total_cmp(&distance(b)).then(a.cmp(&b)));
            free.truncate(starts.len());
        }
        let goals: Vec<DVec2> = free.iter().map(|&goal| self.goals[goal]).collect();
        if starts.len() >= least {
            return vec![(Group { starts, goals, whose }, free)];
        }
        let places = match whose {
            Goals::Interchangeable => by_distance(&starts, &goals),
            Goals::Own => (0..starts.len()).collect(),
        };
        let single = |(&start, &place): (&DVec2, &usize)| {
            let group = Group { starts: vec![start], goals: vec![goals[place]], whose: Goals::Own };
            (group, vec![free[place]])
        };
        starts.iter().zip(&places).map(single).collect()
    }

    fn depart(
        &mut self,
        unit: usize,
        (goal, walk): (usize, Walk),
        (scene, base): (&Scene<'_>, u32),
        orders: &mut Vec<Order>,
    ) {
        let from = scene.units[unit].position;
        if walk.legs.is_empty() {
            self.states[unit] = State::Arrived(goal);
            return;
        }
        let departure = f64::from(base) + walk.departure;
        let plan = Plan::new(goal, (from, walk.legs), (departure, self.speed));
        let order = plan.first_order(unit);
        self.again.extend((1..=self.repeats).map(|later| (scene.cycle + later, order.clone())));
        orders.push(order);
        self.states[unit] = State::Planned(plan);
    }
}
