//! The slow and obvious twin of the kinematic core: all pairs, no sectors, no components, one global list of hits.
//!
//! It shares only the geometry with the core (predicates and contact times, which have oracles of their own).

use std::collections::{BTreeMap, VecDeque};

use glam::DVec2;
use maniple_geometry::contact::{Mover, Window, circle_contact, is_advancing, segment_contact};
use maniple_geometry::limits::TINY;
use maniple_geometry::predicate::{circle_overlaps_segment, circles_overlap};
use maniple_geometry::{Cycle, ObjectId, Piece, Scalar};
use maniple_kinematics::{Event, EventKind, Stops, WallKind};

use super::scene::{Order, Scene};

#[derive(Clone, Copy, Debug)]
struct Leg {
    goal: DVec2,
    speed: f64,
    duration: f64,
}

#[derive(Clone, Debug)]
struct Waiting {
    leg: Option<(DVec2, f64)>,
    replaces: bool,
    start: Option<(u32, f64)>,
}

/// What an object is doing: the line it is on, since when, and to where.
#[derive(Clone, Copy, Debug)]
struct Doing {
    start: DVec2,
    velocity: DVec2,
    from: (u32, f64),
    leg: Option<Leg>,
}

impl Doing {
    fn resting(at: DVec2, from: (u32, f64)) -> Self {
        Self { start: at, velocity: DVec2::ZERO, from, leg: None }
    }

    fn elapsed(&self, cycle: u32) -> f64 {
        (f64::from(cycle) - f64::from(self.from.0)) - self.from.1
    }

    fn at(&self, cycle: u32) -> DVec2 {
        flushed(self.start + self.velocity * self.elapsed(cycle))
    }
}

#[derive(Clone, Debug)]
struct Object {
    radius: f64,
    layers: u32,
    doing: Doing,
    waiting: VecDeque<Waiting>,
}

/// A part of the way through a cycle.
#[derive(Clone, Debug)]
struct Part {
    piece: Piece,
    doing: Doing,
    used: usize,
    opening: Option<EventKind>,
}

/// An object in the course of a cycle.
#[derive(Clone, Debug)]
struct Run {
    parts: Vec<Part>,
    end: f64,
    held: Option<DVec2>,
    stopped: Option<(EventKind, Option<u32>)>,
    /// Whether other objects stopped it at the same time.
    is_one_of_several: bool,
    retreats: u32,
}

pub(crate) struct Twin<'a> {
    scene: &'a Scene,
    cycle: u32,
    objects: BTreeMap<u32, Object>,
}

impl<'a> Twin<'a> {
    pub(crate) fn new(scene: &'a Scene) -> Self {
        let object = |&(id, center, radius, layers): &(u32, DVec2, f64, u32)| {
            let doing = Doing::resting(center, (0, 0.0));
            (id, Object { radius, layers, doing, waiting: VecDeque::new() })
        };
        Self { scene, cycle: 0, objects: scene.objects.iter().map(object).collect() }
    }

    pub(crate) fn play(&mut self) -> Vec<Event> {
        let mut events = Vec::new();
        for _ in 0..self.scene.cycles {
            let (scene, now) = (self.scene, self.cycle);
            for order in scene.orders.iter().filter(|order| order.cycle == now) {
                self.give(order);
            }
            events.extend(self.step());
        }
        events
    }

    pub(crate) fn position(&self, id: u32) -> DVec2 {
        self.objects[&id].doing.at(self.cycle)
    }

    fn give(&mut self, order: &Order) {
        let now = (self.cycle, 0.0);
        let object = self.objects.get_mut(&order.id).unwrap();
        let mut start = order.start;
        if !order.queue {
            let replaced = start.unwrap_or(now);
            start = Some(replaced);
            let kept = if replaced <= now {
                0
            } else {
                let later = |waiting: &Waiting| waiting.replaces && waiting.start >= Some(replaced);
                object.waiting.iter().position(later).unwrap_or(object.waiting.len())
            };
            object.waiting.truncate(kept);
        }
        let mut replaces = !order.queue;
        if order.legs.is_empty() {
            object.waiting.push_back(Waiting { leg: None, replaces: true, start });
        }
        for &leg in &order.legs {
            object.waiting.push_back(Waiting { leg: Some(leg), replaces, start });
            replaces = false;
            start = None;
        }
    }

    fn step(&mut self) -> Vec<Event> {
        let mut runs: BTreeMap<u32, Run> = BTreeMap::new();
        for (&id, object) in &self.objects {
            let parts = parts(object, self.cycle);
            runs.insert(
                id,
                Run { parts, end: 1.0, held: None, stopped: None, is_one_of_several: false, retreats: 0 },
            );
        }
        self.collide(&mut runs);
        self.certify(&mut runs);
        let mut events = Vec::new();
        for (&id, run) in &runs {
            self.finish(id, run, &mut events);
        }
        events.sort_by(|a, b| a.time.total_cmp(&b.time).then(a.object.cmp(&b.object)));
        self.cycle += 1;
        events
    }

    fn collide(&self, runs: &mut BTreeMap<u32, Run>) {
        let pairs: Vec<(u32, u32)> =
            runs.keys().flat_map(|&a| runs.keys().filter(move |&&b| a < b).map(move |&b| (a, b))).collect();
        let mut hits: BTreeMap<(u32, u32), Option<f64>> =
            pairs.iter().map(|&(a, b)| ((a, b), self.first_hit(runs, (a, b), 0.0))).collect();
        let mut wall_hits: Vec<(u32, f64, WallKind)> = Vec::new();
        for &id in runs.keys() {
            for wall in &self.scene.walls {
                if self.objects[&id].layers & wall.layers.0 != 0
                    && let Some(time) = self.wall_hit(&runs[&id], id, &wall.segment)
                {
                    wall_hits.push((id, time, wall.kind));
                }
            }
        }
        loop {
            let times = hits.values().flatten().copied();
            let wall_times = wall_hits.iter().filter(|hit| runs[&hit.0].stopped.is_none()).map(|hit| hit.1);
            let Some(time) = times.chain(wall_times).min_by(f64::total_cmp) else { return };
            let mut causes: BTreeMap<u32, Vec<(EventKind, Option<u32>)>> = BTreeMap::new();
            for &(id, at, kind) in &wall_hits {
                if at == time && runs[&id].stopped.is_none() && moves(&runs[&id], time) {
                    let kind = if kind == WallKind::Edge { EventKind::Edge } else { EventKind::Segment };
                    causes.entry(id).or_default().push((kind, None));
                }
            }
            wall_hits.retain(|hit| hit.1 != time);
            let mut stale: Vec<(u32, u32)> = Vec::new();
            for (&(a, b), _) in hits.iter().filter(|(_, at)| **at == Some(time)) {
                stale.push((a, b));
                for (one, other) in [(a, b), (b, a)] {
                    if moves(&runs[&one], time) && self.is_concerned(&runs[&one], &runs[&other], time) {
                        causes.entry(one).or_default().push((EventKind::Object, Some(other)));
                    }
                }
            }
            for (id, mut found) in causes {
                found.sort_unstable();
                found.dedup();
                let run = runs.get_mut(&id).unwrap();
                run.held = Some(part_at(run, time).piece.position(time));
                run.end = time;
                run.stopped = Some(found[0]);
                run.is_one_of_several = found.get(1).is_some_and(|(kind, _)| *kind == EventKind::Object);
                stale.extend(pairs.iter().filter(|&&(a, b)| a == id || b == id));
            }
            for pair in stale {
                hits.insert(pair, self.first_hit(runs, pair, time));
            }
        }
    }

    fn is_concerned(&self, one: &Run, other: &Run, time: f64) -> bool {
        match self.scene.stops {
            Stops::Both => true,
            Stops::Approaching => is_advancing(&piece_at(one, time), &piece_at(other, time), time),
        }
    }

    fn first_hit(&self, runs: &BTreeMap<u32, Run>, (a, b): (u32, u32), from: f64) -> Option<f64> {
        if self.objects[&a].layers & self.objects[&b].layers == 0 {
            return None;
        }
        let radii = (self.objects[&a].radius, self.objects[&b].radius);
        // The core names the pair by its own numbers; the contact is the same to the bit either way.
        first_hit(&runs[&b], &runs[&a], (radii.1, radii.0), (from, self.scene.limits.skin()))
    }

    fn wall_hit(&self, run: &Run, id: u32, segment: &maniple_geometry::Segment) -> Option<f64> {
        let skin = self.scene.limits.skin();
        run.parts.iter().map(|part| part.piece).filter(|piece| piece.since < piece.until).find_map(|piece| {
            let mover = Mover { piece: &piece, radius: self.objects[&id].radius };
            segment_contact(mover, segment, Window { from: piece.since, to: piece.until, skin })
        })
    }

    fn certify(&self, runs: &mut BTreeMap<u32, Run>) {
        loop {
            let failed = self.failed(runs);
            if failed.is_empty() {
                return;
            }
            for id in failed {
                let run = runs.get_mut(&id).unwrap();
                if run.retreats == 0 && run.stopped.is_none() {
                    let mut moving = run.parts.iter().rev().filter(|part| part.piece.is_moving());
                    run.end = moving.next().map_or(0.0, |part| part.piece.until);
                }
                let mut step = 2.0 * f64::EPSILON;
                for _ in 0..run.retreats {
                    step *= 2.0;
                }
                run.end = if run.end - step > 0.0 { (run.end - step).flushed() } else { 0.0 };
                run.held = Some(part_at(run, run.end).piece.position(run.end));
                run.retreats += 1;
            }
        }
    }

    fn failed(&self, runs: &BTreeMap<u32, Run>) -> std::collections::BTreeSet<u32> {
        let mut failed = std::collections::BTreeSet::new();
        let can = |run: &Run| run.end > 0.0 && run.parts.iter().any(|part| part.piece.is_moving());
        for (&a, one) in runs {
            let (p, r) = (self.last(one), self.objects[&a].radius);
            for (&b, other) in runs.range(a + 1..) {
                let (q, s) = (self.last(other), self.objects[&b].radius);
                if self.objects[&a].layers & self.objects[&b].layers == 0 {
                    continue;
                }
                if circles_overlap::<f64>(p, r, q, s) {
                    let advances = |run: &Run, way: DVec2| {
                        can(run) && part_at(run, run.end).doing.velocity.dot(way) > 0.0
                    };
                    let (first, second) = (advances(one, q - p), advances(other, p - q));
                    failed.extend((if first || second { first } else { can(one) }).then_some(a));
                    failed.extend((if first || second { second } else { can(other) }).then_some(b));
                } else if one.retreats + other.retreats > 0 {
                    let from = one.end.min(other.end);
                    let quarter = self.scene.limits.skin::<f64>() / 4.0;
                    if from < 1.0 && first_hit(one, other, (r - quarter, s - quarter), (from, 0.0)).is_some()
                    {
                        failed.insert(if one.end > other.end { a } else { b });
                    }
                }
            }
            for wall in &self.scene.walls {
                let shares = self.objects[&a].layers & wall.layers.0 != 0;
                if shares && circle_overlaps_segment(p, r, &wall.segment) {
                    failed.insert(a);
                }
            }
        }
        failed
    }

    fn last(&self, run: &Run) -> DVec2 {
        run.held.unwrap_or_else(|| run.parts.last().unwrap().doing.at(self.cycle + 1))
    }

    fn finish(&mut self, id: u32, run: &Run, events: &mut Vec<Event>) {
        let cycle = Cycle(self.cycle);
        let mut tell = |time: f64, kind, other: Option<u32>, rests| {
            let (object, other) = (ObjectId(id), other.map(ObjectId));
            let is_one_of_several = kind == EventKind::Object && run.is_one_of_several;
            events.push(Event { cycle, time, object, kind, other, is_one_of_several, rests });
        };
        for part in run.parts.iter().filter(|part| part.piece.since <= run.end) {
            if let Some(kind) = part.opening {
                tell(part.piece.since, kind, None, !part.piece.is_moving());
            }
        }
        if let Some((kind, other)) = run.stopped {
            tell(run.end, kind, other, true);
        }
        let object = self.objects.get_mut(&id).unwrap();
        let part = part_at(run, run.end);
        match (run.held, run.stopped) {
            (Some(point), Some(_)) => {
                object.doing = Doing::resting(point, (self.cycle, run.end));
                object.waiting.clear();
            }
            (Some(point), None) => {
                object.doing = match part.doing.leg {
                    Some(leg) if leg.goal != point => {
                        departing(point, (leg.goal, leg.speed), (self.cycle + 1, 0.0))
                    }
                    Some(_) => {
                        tell(run.end, EventKind::Arrived, None, true);
                        Doing::resting(point, (self.cycle, run.end))
                    }
                    None => Doing::resting(point, (self.cycle, run.end)),
                };
                object.waiting.drain(..part.used);
            }
            (None, _) => {
                object.doing = part.doing;
                object.waiting.drain(..part.used);
            }
        }
    }
}

/// The way of an object through a cycle in which nothing is in its way.
fn parts(object: &Object, cycle: u32) -> Vec<Part> {
    let mut parts: Vec<Part> = Vec::new();
    let (mut now, mut used, mut opening) = (0.0, 0, None);
    let mut doing = object.doing;
    let mut point = doing.at(cycle);
    let push = |parts: &mut Vec<Part>, point, doing: Doing, times: (f64, f64), rest: (usize, _, _)| {
        let piece = Piece { point, velocity: doing.velocity, since: times.0, until: times.1, goal: rest.2 };
        parts.push(Part { piece, doing, used: rest.0, opening: rest.1 });
    };
    loop {
        // What comes next: the end of the leg, the first order that replaces, or the next in line if at rest.
        let when = |waiting: &Waiting| match waiting.start {
            None => Some(now),
            Some(start) if start.0 < cycle => Some(now),
            Some(start) if start.0 == cycle => Some(f64::max(start.1, now)),
            Some(_) => None,
        };
        let arrival = doing.leg.map(|leg| (leg.duration - doing.elapsed(cycle)).max(now).max(TINY));
        let replacing = object.waiting.iter().enumerate().skip(used).find(|(_, waiting)| waiting.replaces);
        let replacing = replacing.and_then(|(index, waiting)| when(waiting).map(|time| (time, index)));
        let in_line = object.waiting.get(used).and_then(&when).map(|time| (time, used));
        let next = match (arrival, replacing) {
            (Some(arrival), Some(cut)) if cut.0 < arrival => Some(cut),
            (Some(arrival), _) if arrival <= 1.0 => {
                let leg = doing.leg.unwrap();
                push(&mut parts, point, doing, (now, arrival), (used, opening.take(), Some(leg.goal)));
                point = leg.goal;
                now = arrival;
                doing = Doing::resting(point, (cycle, now));
                opening = Some(EventKind::Arrived);
                continue;
            }
            (Some(_), _) => None,
            (None, Some(cut)) if in_line.is_none_or(|in_line| cut.0 <= in_line.0) => Some(cut),
            (None, _) => in_line,
        };
        let Some((time, index)) = next else {
            push(&mut parts, point, doing, (now, 1.0), (used, opening.take(), None));
            return parts;
        };
        if time > now || doing.leg.is_some() {
            push(&mut parts, point, doing, (now, time), (used, opening.take(), None));
            point = parts.last().unwrap().piece.position(time);
        }
        now = time;
        used = index + 1;
        let event = match object.waiting[index].leg {
            None => doing.leg.map(|_| EventKind::Ordered),
            Some(leg) if leg.0 == point => Some(EventKind::Arrived),
            Some(leg) => {
                doing = departing(point, leg, (cycle, now));
                None
            }
        };
        if event.is_some() {
            if opening.is_some() {
                push(&mut parts, point, doing, (now, now), (used, opening.take(), None));
            }
            opening = event;
            doing = Doing::resting(point, (cycle, now));
        }
    }
}

fn departing(point: DVec2, (goal, speed): (DVec2, f64), from: (u32, f64)) -> Doing {
    let way = goal - point;
    let length = way.dot(way).sqrt();
    let velocity = flushed(way * (speed / length));
    Doing { start: point, velocity, from, leg: Some(Leg { goal, speed, duration: length / speed }) }
}

fn first_hit(one: &Run, other: &Run, radii: (f64, f64), (from, skin): (f64, f64)) -> Option<f64> {
    let mut windows: Vec<(f64, f64, Piece, Piece)> = Vec::new();
    for a in pieces(one) {
        for b in pieces(other) {
            let (start, end) = (from.max(a.since).max(b.since), a.until.min(b.until));
            if start < end {
                windows.push((start, end, a, b));
            }
        }
    }
    windows.sort_by(|a, b| a.0.total_cmp(&b.0));
    windows.iter().find_map(|(start, end, a, b)| {
        let movers = (Mover { piece: a, radius: radii.0 }, Mover { piece: b, radius: radii.1 });
        circle_contact(movers.0, movers.1, Window { from: *start, to: *end, skin })
    })
}

fn pieces(run: &Run) -> Vec<Piece> {
    let Some(point) = run.held else { return run.parts.iter().map(|part| part.piece).collect() };
    let mut pieces: Vec<Piece> = Vec::new();
    for part in run.parts.iter().filter(|part| part.piece.since < run.end) {
        let cut = Piece { until: run.end, goal: None, ..part.piece };
        pieces.push(if part.piece.until <= run.end { part.piece } else { cut });
    }
    pieces.push(Piece::at_rest(point, run.end, 1.0));
    pieces
}

fn part_at(run: &Run, time: f64) -> &Part {
    run.parts.iter().rev().find(|part| part.piece.since <= time).unwrap()
}

fn piece_at(run: &Run, time: f64) -> Piece {
    match run.held {
        Some(point) if time >= run.end => Piece::at_rest(point, run.end, 1.0),
        Some(_) | None => part_at(run, time).piece,
    }
}

fn moves(run: &Run, time: f64) -> bool {
    piece_at(run, time).is_moving()
}

fn flushed(vector: DVec2) -> DVec2 {
    DVec2::new(vector.x.flushed(), vector.y.flushed())
}
