//! Who stands where, and what is done in both worlds of a scene.

#![expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "numbers of a scene are small, and coordinates not negative"
)]

use glam::DVec2;
use maniple_view::{Command, Handle, Seat};

use super::dice::Dice;
use super::scene::{Cast, FAR, HEIGHT, Role, is_exact};

/// Last cycle of a script.
const CYCLES: u32 = 110;

/// What somebody does at the start of a cycle.
#[derive(Clone, Debug)]
pub(super) struct Line {
    pub(super) at: u32,
    pub(super) role: Role,
    pub(super) order: Order,
    /// In one of the worlds, or, `None`, in both.
    pub(super) world: Option<usize>,
}

/// What somebody is told.
#[derive(Clone, Debug)]
pub(super) enum Order {
    Go(DVec2),
    Path(Vec<DVec2>),
    Hold,
    Resign,
}

impl Order {
    pub(super) fn command(&self, object: Handle) -> Command {
        match self {
            Self::Go(at) => Command::Move { object, x: at.x, y: at.y, s: None, queue: false, start: None },
            Self::Path(points) => Command::Path {
                object,
                points: points.iter().map(|at| (at.x, at.y, None)).collect(),
                start: None,
            },
            Self::Hold => Command::Hold { object },
            Self::Resign => Command::Resign,
        }
    }

    /// Returns where it ends.
    pub(super) fn goal(&self) -> Option<DVec2> {
        match self {
            Self::Go(at) => Some(*at),
            Self::Path(points) => points.last().copied(),
            Self::Hold | Self::Resign => None,
        }
    }
}

/// Fills a scene with those who stand in both worlds; returns what they do.
pub(super) fn fill(cast: &mut Cast) -> Vec<Line> {
    let mut script = Vec::new();
    add_own(cast);
    add_gate(cast, &mut script);
    add_neighbours(cast, &mut script);
    for lane in 0..4 {
        if lane == 0 && cast.plan.foes.len() > 1 && cast.dice.percent(60) {
            add_deserter(cast, &mut script);
        } else if cast.dice.percent(70) {
            add_courier(cast, lane, &mut script);
        }
    }
    if cast.plan.foes.len() > 1 && cast.dice.percent(15) {
        // Whoever of its objects is in sight dies in sight.
        let seat = cast.plan.foes[0];
        let role = cast.actors.iter().position(|actor| actor.seat == Some(seat));
        let at = 40 + cast.dice.below(30);
        script.extend(role.map(|role| Line { at, role, order: Order::Resign, world: None }));
    }
    script
}

/// Puts the watcher's objects, what they gather, and those who wander among them.
fn add_own(cast: &mut Cast) {
    let own = Some(cast.plan.watcher);
    let home = (1, 1, 9, HEIGHT - 1);
    let jet = if cast.plan.walls_block { 30 } else { 60 };
    for (unit_type, chance) in
        [("house", 90), ("hut", 40), ("worker", 90), ("worker", 60), ("tank", 90), ("tank", 50), ("jet", jet)]
    {
        if cast.dice.percent(chance) {
            cast.put_in(own, unit_type, home, 0);
        }
    }
    // Never without anybody.
    cast.put(own, "worker", [DVec2::new(2.0, 10.0); 2], 0);
    for unit_type in ["crystal", "crystal", "sheep", "sheep"] {
        if cast.dice.percent(60) {
            let amount = if unit_type == "crystal" { 3 + cast.dice.below(30) } else { 0 };
            cast.put_in(None, unit_type, (2, 1, 13, HEIGHT - 1), amount);
        }
    }
}

/// Lets a scout of the watcher run into two of different seats at the same moment.
fn add_gate(cast: &mut Cast, script: &mut Vec<Line>) {
    let posts = cast.plan.foes.iter().copied().chain(cast.plan.ally).collect::<Vec<Seat>>();
    let [one, .., other] = posts[..] else { return };
    let at = DVec2::new(cast.dice.between(2, 8), cast.dice.between(2, HEIGHT - 2));
    let aside = DVec2::new(3.0, 0.375);
    let roles = [
        (Some(cast.plan.watcher), at),
        (Some(one), at + aside),
        (Some(other), at + DVec2::new(aside.x, -aside.y)),
    ]
    .map(|(seat, at)| cast.put(seat, "scout", [at; 2], 0));
    let order = Order::Go(at + DVec2::new(6.0, 0.0));
    let at = cast.dice.below(8);
    script.extend(roles[0].map(|role| Line { at, role, order, world: None }));
}

/// Puts those of other seats near the watcher, most of them in sight.
fn add_neighbours(cast: &mut Cast, script: &mut Vec<Line>) {
    let near = (9, 1, 16, HEIGHT - 1);
    let seats = cast.plan.foes.iter().copied().chain(cast.plan.ally).collect::<Vec<Seat>>();
    for seat in seats {
        let is_ally = cast.plan.ally == Some(seat);
        let area = if is_ally { (1, 1, 9, HEIGHT - 1) } else { near };
        for (unit_type, chance) in [("house", 60), ("tank", 60), ("worker", 60), ("scout", 80), ("jet", 40)] {
            if !cast.dice.percent(chance) {
                continue;
            }
            let Some(role) = cast.put_in(Some(seat), unit_type, area, 0) else {
                continue;
            };
            if unit_type == "tank" && cast.dice.percent(40) {
                let at = cast.dice.below(50);
                script.push(Line { at, role, order: Order::Hold, world: None });
            } else if unit_type != "house" {
                stroll(cast, role, area, script);
            }
        }
    }
}

/// Lets somebody go here and there, along the axes where that takes no rounding.
fn stroll(cast: &mut Cast, role: Role, area: (u32, u32, u32, u32), script: &mut Vec<Line>) {
    let mut at = cast.actors[role].at[0];
    let mut cycle = cast.dice.below(12);
    while cycle < CYCLES {
        let (left, top, right, bottom) = area;
        let mut goal = DVec2::new(cast.dice.between(left, right), cast.dice.between(top, bottom));
        if cast.dice.percent(80) {
            goal.y = at.y;
        }
        if cast.dice.percent(50) {
            script.push(Line { at: cycle, role, order: Order::Go(goal), world: None });
            at = goal;
        }
        cycle += 6 + cast.dice.below(30);
    }
}

/// Puts somebody in sight who leaves, and is shot out of sight in one of the worlds.
fn add_deserter(cast: &mut Cast, script: &mut Vec<Line>) {
    let [one, other, ..] = cast.plan.foes[..] else { return };
    let y = 8.5;
    let start = DVec2::new(cast.dice.between(9, 13), y);
    let unit_type = cast.dice.one(&["scout", "jet"]);
    let Some(role) = cast.put(Some(one), unit_type, [start; 2], 0) else { return };
    let goal = DVec2::new(35.0, y);
    script.push(Line { at: cast.dice.below(8), role, order: Order::Go(goal), world: None });
    let Some(role) = cast.put(Some(other), "tank", [goal + DVec2::new(2.5, 0.0); 2], 0) else { return };
    let world = Some(cast.dice.below(2) as usize);
    script.push(Line { at: 1, role, order: Order::Hold, world });
}

/// Puts somebody out of sight who comes on a lane, goes, and comes again; what it did before it came is not the same in both worlds.
fn add_courier(cast: &mut Cast, lane: u32, script: &mut Vec<Line>) {
    let seat = cast.dice.one(&cast.plan.foes);
    let (unit_type, speed) = cast.dice.one(&[("scout", 0.5), ("jet", 1.0), ("tank", 0.375), ("worker", 0.5)]);
    let y = f64::from(8 + lane) + 0.5;
    let far = f64::from(FAR) + 1.0 + f64::from(cast.dice.below(3));
    let near = near_end(&mut cast.dice, far, speed);
    let pasts = [0, 1].map(|_| if speed == 0.375 { 0 } else { cast.dice.below(6) });
    let at = pasts.map(|cycles| DVec2::new(far + speed * f64::from(cycles), y));
    let Some(role) = cast.put(Some(seat), unit_type, at, 0) else {
        return;
    };
    let [inner, outer] = [near, far].map(|x| DVec2::new(x, y));
    let mut start = 6 + cast.dice.below(12);
    for (world, cycles) in pasts.into_iter().enumerate() {
        let is_straight = is_exact(far + speed * f64::from(cycles) - near, speed) && cast.dice.percent(50);
        let order =
            if is_straight || cycles == 0 { Order::Go(inner) } else { Order::Path(vec![outer, inner]) };
        script.push(Line { at: start - cycles, role, order, world: Some(world) });
    }
    let way = (((far - near) / speed).ceil()) as u32 + 1;
    loop {
        start += way + cast.dice.below(6);
        if start >= CYCLES {
            return;
        }
        script.push(Line { at: start, role, order: Order::Go(outer), world: None });
        start += way;
        if speed != 0.375 {
            hop(&mut cast.dice, (role, start), outer, script);
        }
        start += 9 + cast.dice.below(4);
        script.push(Line { at: start, role, order: Order::Go(inner), world: None });
    }
}

/// Lets somebody out of sight go two aside and come back, in one of the worlds.
fn hop(dice: &mut Dice, (role, start): (Role, u32), outer: DVec2, script: &mut Vec<Line>) {
    let aside = outer + DVec2::new(2.0, 0.0);
    let world = dice.one(&[None, Some(0), Some(1)]);
    if world.is_some() {
        script.push(Line { at: start, role, order: Order::Path(vec![aside, outer]), world });
    }
}

/// Returns where a courier turns back, so far that no rounding comes in.
fn near_end(dice: &mut Dice, far: f64, speed: f64) -> f64 {
    for _ in 0..100 {
        let near = dice.between(11, 17);
        if speed == 0.375 || is_exact(far - near, speed) {
            return near;
        }
    }
    far - 16.0
}
