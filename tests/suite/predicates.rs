//! The exact decisions of the geometry agree with rational arithmetic, where doubles cannot tell any more.

use glam::DVec2;
use maniple_geometry::contact::{Mover, Window, circle_contact, is_advancing, segment_contact};
use maniple_geometry::predicate::{circle_overlaps_segment, circles_overlap};
use maniple_geometry::{Piece, Scalar, Segment};

use crate::kinematics::Random;
use crate::rational::{Exact, Rational, cross, number, square_distance};

/// Questions of each class in the ordinary run; `MANIPLE_LONG=1` asks a hundred times as many.
const QUESTIONS: u64 = 20_000;

/// Where a piece is at a time, without rounding.
fn place(piece: &Piece, time: f64) -> Exact {
    match piece.goal {
        Some(goal) if time >= piece.until => Exact::of(goal),
        _ => Exact::of(piece.point).plus(&Exact::of(piece.velocity), &(number(time) - number(piece.since))),
    }
}

fn questions(class: &str) -> impl Iterator<Item = Random> {
    let seed = 77;
    let count = if std::env::var_os("MANIPLE_LONG").is_some() { 100 * QUESTIONS } else { QUESTIONS };
    println!("class {class}: seed {seed}, {count} questions");
    (0..count).map(move |number| Random(seed + number))
}

/// A number that is up to 8 units in the last place away.
fn nudged(random: &mut Random, mut value: f64) -> f64 {
    for _ in 0..random.below(9) {
        value = value.next_up();
    }
    for _ in 0..random.below(9) {
        value = value.next_down();
    }
    value.flushed()
}

fn point(random: &mut Random, size: f64) -> DVec2 {
    DVec2::new(random.between(-size, size), random.between(-size, size))
}

/// The magnitude of coordinates: small, ordinary, or far out.
fn size(random: &mut Random) -> f64 {
    random.pick(&[1e-3, 1.0, 100.0, 1e6, 1e9])
}

#[test]
fn circles_overlap_exactly_when_they_do() {
    let mut answers = [0, 0];
    for mut random in questions("circles that touch up to 8 ulp") {
        let size = size(&mut random);
        let p = point(&mut random, size);
        let (r, s) = (random.between(0.1, 2.0), random.between(0.1, 2.0));
        // Pythagorean directions, so that touching exactly is possible.
        let way = random.pick(&[(1.0, 0.0), (0.0, 1.0), (0.6, 0.8), (-0.28, 0.96)]);
        let q = p + DVec2::from(way) * (r + s);
        let q = DVec2::new(nudged(&mut random, q.x), nudged(&mut random, q.y));
        let d = Exact::of(q).minus(&Exact::of(p));
        let reach = number(r) + number(s);
        let expected = d.dot(&d) < &reach * &reach;
        assert_eq!(circles_overlap::<f64>(p, r, q, s), expected, "{p} {r} {q} {s}");
        answers[usize::from(expected)] += 1;
    }
    assert!(answers.iter().all(|&count| count > QUESTIONS / 10), "{answers:?}");
}

#[test]
fn a_circle_overlaps_a_segment_exactly_when_it_does() {
    let mut answers = [0, 0];
    for mut random in questions("circles that touch a segment up to 8 ulp") {
        let size = size(&mut random);
        let (a, b) = (point(&mut random, size), point(&mut random, size));
        let r = random.between(0.01, 1.0) * size;
        let e = b - a;
        let foot = a + e * random.between(-0.2, 1.2);
        let p = foot + DVec2::new(-e.y, e.x) * (r / e.dot(e).sqrt());
        let p = DVec2::new(nudged(&mut random, p.x), nudged(&mut random, p.y));
        let distance = square_distance(&Exact::of(p), &Exact::of(a), &Exact::of(b));
        let expected = distance < number(r) * number(r);
        assert_eq!(circle_overlaps_segment(p, r, &Segment::new(a, b)), expected, "{p} {r} {a} {b}");
        answers[usize::from(expected)] += 1;
    }
    assert!(answers.iter().all(|&count| count > QUESTIONS / 10), "{answers:?}");
}

/// Two pieces of which the second passes the first at about `reach`, aimed at the last bits.
fn grazing(random: &mut Random, reach: f64) -> (Piece, Piece, (f64, f64)) {
    let size = size(random).min(1e6);
    let times = random.pick(&[(0.0, 1.0), (0.0, 0.5), (0.25, 1.0)]);
    let since = |random: &mut Random| if random.chance(0.5) { 0.0 } else { times.0 * random.unit() };
    let w = point(random, 4.0);
    let normal = DVec2::new(-w.y, w.x) / w.dot(w).sqrt();
    let when = if random.chance(0.3) { times.1 } else { random.between(times.0, times.1) };
    let a = point(random, size);
    let v = if random.chance(0.5) { DVec2::ZERO } else { point(random, 3.0) };
    let first = Piece { point: a, velocity: v, since: since(random), until: 1.0, goal: None };
    let begin = since(random);
    let nearest = a + v * (when - first.since) + normal * reach;
    let velocity = w + v;
    let start = nearest - velocity * (when - begin);
    let start = DVec2::new(nudged(random, start.x), nudged(random, start.y));
    let end = start + velocity * (times.1 - begin);
    let ends_in_goal = random.chance(0.3);
    let goal = ends_in_goal.then(|| DVec2::new(nudged(random, end.x), nudged(random, end.y)));
    let until = if ends_in_goal { times.1 } else { 1.0 };
    (first, Piece { point: start, velocity, since: begin, until, goal }, times)
}

#[test]
fn circles_collide_exactly_when_they_come_nearer_than_touching() {
    let mut answers = [0, 0];
    for mut random in questions("circles that graze up to 8 ulp") {
        let (r, s) = (random.between(0.1, 2.0), random.between(0.1, 2.0));
        let (a, b, (from, to)) = grazing(&mut random, r + s);
        let reach = number(r) + number(s);
        let reach = &reach * &reach;
        let d = place(&b, from).minus(&place(&a, from));
        if d.dot(&d) < reach {
            continue;
        }
        let w = Exact::of(b.velocity).minus(&Exact::of(a.velocity));
        let along = d.dot(&w);
        let nearest = -&along / w.dot(&w);
        let after = place(&b, to).minus(&place(&a, to));
        let passes = nearest > Rational::ZERO && nearest < number(to) - number(from);
        let least = if passes { d.dot(&d) + &along * nearest } else { after.dot(&after) };
        // A goal that was rounded away from its line only counts where the line approaches.
        let expected = (least < reach || after.dot(&after) < reach)
            && along < Rational::ZERO
            && w.dot(&w) * &reach > d.cross(&w) * d.cross(&w);
        let window = Window { from, to, skin: 1e-7 };
        let found = circle_contact(Mover { piece: &a, radius: r }, Mover { piece: &b, radius: s }, window);
        let swapped = circle_contact(Mover { piece: &b, radius: s }, Mover { piece: &a, radius: r }, window);
        assert_eq!(found.map(f64::to_bits), swapped.map(f64::to_bits), "swapped: {a:?} {b:?}");
        assert_eq!(found.is_some(), expected, "{a:?} {r} {b:?} {s} {from}..{to}");
        assert!(found.is_none_or(|time| from <= time && time <= to), "{found:?}");
        answers[usize::from(expected)] += 1;
    }
    assert!(answers.iter().all(|&count| count > QUESTIONS / 10), "{answers:?}");
}

#[test]
fn circles_collide_in_single_precision_exactly_when_they_come_nearer_than_touching() {
    let narrow = |number: f64| f32::from_f64(number);
    let mut answers = [0, 0];
    for mut random in questions("circles that come to touch at the end of the window, in single precision") {
        let (r, s) = (narrow(random.between(0.1, 2.0)), narrow(random.between(0.1, 2.0)));
        let (from, to) = (narrow(random.between(0.0, 0.5)), 1.0);
        let velocity = point(&mut random, 4.0);
        let away = point(&mut random, 1.0);
        let last = away * (f64::from(r + s) / away.dot(away).sqrt());
        let moving = |point: DVec2, velocity: DVec2| Piece::<f32> {
            point: point.as_vec2(),
            velocity: velocity.as_vec2(),
            since: 0.0,
            until: 1.0,
            goal: None,
        };
        let (one, other) = (moving(DVec2::ZERO, DVec2::ZERO), moving(last - velocity, velocity));
        let at = |time: f32| {
            let (point, velocity) = (other.point.as_dvec2(), other.velocity.as_dvec2());
            Exact::of(point).plus(&Exact::of(velocity), &number(f64::from(time)))
        };
        let reach = number(f64::from(r)) + number(f64::from(s));
        let reach = &reach * &reach;
        let (before, after, w) = (at(from), at(to), Exact::of(other.velocity.as_dvec2()));
        if before.dot(&before) < reach {
            continue;
        }
        let expected = before.dot(&w) < Rational::ZERO
            && w.dot(&w) * &reach > before.cross(&w) * before.cross(&w)
            && (after.dot(&w) >= Rational::ZERO || after.dot(&after) < reach);
        let window = Window { from, to, skin: 1e-3 };
        let found =
            circle_contact(Mover { piece: &one, radius: r }, Mover { piece: &other, radius: s }, window);
        assert_eq!(found.is_some(), expected, "{one:?} {r} {other:?} {s} {from}..{to}");
        answers[usize::from(expected)] += 1;
    }
    assert!(answers.iter().all(|&count| count > QUESTIONS / 20), "{answers:?}");
}

#[test]
fn a_circle_collides_with_a_segment_exactly_when_it_comes_nearer_than_touching() {
    let mut answers = [0, 0];
    for mut random in questions("circles that graze a segment up to 8 ulp") {
        let r = random.between(0.1, 2.0);
        let (still, piece, (from, to)) = grazing(&mut random, r);
        let piece = Piece { goal: None, ..piece };
        if !piece.is_moving() || piece.since > from {
            continue;
        }
        // Where the way grazes the wall ends, or goes by: along the way, across its end, or anyhow.
        let touched = still.position(from);
        let across = piece.position(to) - touched;
        let way = match random.below(4) {
            0 => piece.velocity,
            1 => DVec2::new(-across.y, across.x),
            _ => point(&mut random, 3.0),
        };
        let other = touched + way * random.between(0.1, 2.0);
        let end = if random.chance(0.5) { touched } else { touched - way * random.between(0.1, 2.0) };
        let segment = Segment::new(end, other);
        let (before, after) = (place(&piece, from), place(&piece, to));
        let (a, b) = (Exact::of(end), Exact::of(other));
        let reach = number(r) * number(r);
        if square_distance(&before, &a, &b) < reach {
            continue;
        }
        let expected = cross(&before, &after, &a, &b)
            || square_distance(&after, &a, &b) < reach
            || square_distance(&a, &before, &after) < reach
            || square_distance(&b, &before, &after) < reach;
        let window = Window { from, to, skin: 1e-7 };
        let found = segment_contact(Mover { piece: &piece, radius: r }, &segment, window);
        assert_eq!(found.is_some(), expected, "{piece:?} {r} {segment:?} {from}..{to}");
        answers[usize::from(expected)] += 1;
    }
    assert!(answers.iter().all(|&count| count > QUESTIONS / 20), "{answers:?}");
}

#[test]
fn who_advances_is_decided_exactly() {
    let mut answers = [0, 0];
    for mut random in questions("velocities at right angles up to 8 ulp") {
        let size = size(&mut random);
        let (p, q) = (point(&mut random, size), point(&mut random, size));
        let d = q - p;
        let v = DVec2::new(nudged(&mut random, -d.y), nudged(&mut random, d.x));
        let time = if random.chance(0.5) { 0.0 } else { random.unit() };
        let first = Piece { point: p, velocity: v, since: 0.0, until: 1.0, goal: None };
        let second = Piece::at_rest(q, 0.0, 1.0);
        let offset = place(&second, time).minus(&place(&first, time));
        let expected = Exact::of(v).dot(&offset) > Rational::ZERO;
        assert_eq!(is_advancing(&first, &second, time), expected, "{first:?} {second:?} {time}");
        answers[usize::from(expected)] += 1;
    }
    assert!(answers.iter().all(|&count| count > QUESTIONS / 10), "{answers:?}");
}
