use glam::DVec2;
use maniple_geometry::Cycle;
use maniple_view::{Base, MismatchError, Moved, Positions, Rules, StopReason, Stopped, View};

use super::*;
use crate::arbitrary::Random;
use crate::codec;

const GRID: Positions = Positions::Grid { bits: 8 };

#[test]
fn deltas_come_back_to_the_same_bits() {
    for seed in 0..400 {
        for positions in [Positions::Exact, GRID, Positions::Grid { bits: 0 }] {
            let mut story = Story::new(seed, positions);
            for _ in 0..12 {
                let delta = story.next();
                let mut bytes = Vec::new();
                codec::encode_onto(&mut bytes, &story.packer.pack(&delta));
                let packed: PackedDelta = codec::decode(&bytes).unwrap();
                let found = packed.unpack(&story.view, &story.rules).unwrap();
                assert_eq!(format!("{found:?}"), format!("{delta:?}"), "seed {seed}, {positions:?}");
                story.view.apply(&found).unwrap();
            }
        }
    }
}

#[test]
fn the_usual_motions_take_the_documented_bytes() {
    let check =
        |positions: Positions, case: &str, expected: usize, change: &dyn Fn(Base) -> Result<Base, Base>| {
            let mut story = Story::new(1, positions);
            let speed = story.rules.unit_types[0].speed;
            let velocity = DVec2::new(0.6, -0.8) * speed;
            let base = Base { point: DVec2::new(10.25, 7.5), cycle: Cycle(300), fraction: 0.0, velocity };
            let base = positions.rounded(base);
            let appeared = story.appeared(0, base);
            story.take(Delta { cycle: Cycle(300), appeared: vec![appeared], ..Delta::default() });
            let mut delta = Delta { cycle: Cycle(341), ..Delta::default() };
            match change(base) {
                Ok(base) => delta.moved.push(Moved { object: Handle(0), base: positions.rounded(base) }),
                Err(base) => {
                    let Base { point, cycle, fraction, .. } = positions.rounded(base);
                    let reason = Some(StopReason::Arrived);
                    delta.stopped.push(Stopped { object: Handle(0), point, cycle, fraction, reason });
                }
            }
            let motions = story.packer.pack(&delta).motions;
            assert_eq!(motions.len() - 1, expected, "{case}, {positions:?}: {motions:02x?}");
        };
    for (positions, [turn, slow_turn, bend, stop]) in
        [(Positions::Exact, [11, 18, 21, 12]), (GRID, [6, 6, 8, 4])]
    {
        let turned = |base: Base, fraction| {
            let point = base.position(Cycle(340)) + base.velocity * fraction;
            let velocity = DVec2::new(base.velocity.y, base.velocity.x);
            Base { point, cycle: Cycle(340), fraction, velocity }
        };
        check(positions, "a turn when a cycle begins", turn, &|base| Ok(turned(base, 0.0)));
        check(positions, "at a speed of its own", slow_turn, &|base| {
            let base = turned(base, 0.0);
            Ok(Base { velocity: base.velocity * 0.7, ..base })
        });
        check(positions, "a turn within a cycle", bend, &|base| Ok(turned(base, 0.7)));
        check(positions, "a stop", stop, &|base| Err(Base { velocity: DVec2::ZERO, ..turned(base, 0.7) }));
    }
}

#[test]
fn forged_motions_are_errors_and_never_panics() {
    for seed in 0..3000 {
        let mut random = Random::new(seed);
        let positions = [Positions::Exact, GRID][random.below(2)];
        let mut story = Story::new(seed, positions);
        let first = story.next();
        story.take(first);
        let delta = story.next();
        let mut packed = story.packer.pack(&delta);
        if packed.motions.is_empty() {
            continue;
        }
        let place = random.below(packed.motions.len());
        match random.below(3) {
            0 => packed.motions.truncate(place),
            1 => packed.motions[place] = random.number().to_le_bytes()[0],
            _ => packed.motions = random.bytes(60),
        }
        if let Ok(found) = packed.unpack(&story.view, &story.rules) {
            let _ = story.view.clone().apply(&found);
        }
    }
}

#[test]
fn what_is_wrong_is_named() {
    let check = |motions: &[u8], offset: usize, problem: PackedProblem| {
        let story = Story::new(1, GRID);
        let packed = PackedDelta { cycle: Cycle(5), motions: motions.to_vec(), ..PackedDelta::default() };
        let error = PackedError { cycle: Cycle(5), offset, problem };
        assert_eq!(packed.unpack(&story.view, &story.rules), Err(error));
    };
    check(&[1], 1, PackedProblem::End);
    check(&[1, 7], 2, PackedProblem::UnknownObject { object: Handle(7) });
    check(&[0, 7], 2, PackedProblem::UnknownObject { object: Handle(7) });
    check(&[1, 0xff, 0xff, 0xff, 0xff, 0x1f], 6, PackedProblem::TooLarge);
    let object = Handle(0);
    let check_known = |motions: &[u8], offset: usize, problem: PackedProblem| {
        let mut story = Story::new(1, GRID);
        let base = Base::at_rest(DVec2::ONE, maniple_geometry::Moment::start_of(Cycle(4)));
        let appeared = story.appeared(0, base);
        story.take(Delta { cycle: Cycle(4), appeared: vec![appeared], ..Delta::default() });
        let packed = PackedDelta { cycle: Cycle(5), motions: motions.to_vec(), ..PackedDelta::default() };
        let error = PackedError { cycle: Cycle(5), offset, problem };
        assert_eq!(packed.unpack(&story.view, &story.rules), Err(error));
    };
    check_known(&[1, 0, 0x0c], 3, PackedProblem::Flags { flags: 0x0c });
    check_known(&[0, 0, 0x70], 3, PackedProblem::Flags { flags: 0x70 });
    check_known(&[1, 0, 0x20, 1, 0], 3, PackedProblem::UnknownSpeed { object });
    check_known(&[1, 0, 0x03, 6, 0, 0, 0], 5, PackedProblem::BeforeStart { ago: 6 });
}

/// A match as a receiver is told of it, with a mirrored view.
struct Story {
    random: Random,
    rules: Rules,
    packer: Packer,
    view: View,
    next_handle: u32,
}

impl Story {
    fn new(seed: u64, positions: Positions) -> Self {
        let mut random = Random::new(seed);
        let mut rules = Rules { positions, fog: false, ..random.welcome().rules };
        rules.unit_types = (0..3).map(|_| random.unit_type()).collect();
        for (number, unit_type) in (1u32..).zip(&mut rules.unit_types) {
            unit_type.speed = f64::from(number) * 0.21;
            unit_type.alternate = None;
        }
        let packer = Packer::new(&rules);
        Self { random, rules, packer, view: View::default(), next_handle: 0 }
    }

    fn appeared(&mut self, object: u32, base: Base) -> Appeared {
        let status = self.random.status();
        Appeared { object: Handle(object), unit_type: UnitTypeId(0), owner: None, base, status, own: None }
    }

    /// Packs a delta and applies it.
    fn take(&mut self, mut delta: Delta) {
        seal(&mut delta, &self.view);
        self.packer.pack(&delta);
        self.view.apply(&delta).unwrap();
    }

    /// Returns a delta that fits the view, of any numbers that may be.
    fn next(&mut self) -> Delta {
        let cycle = Cycle(self.view.cycle().0 + 1 + u32::try_from(self.random.below(300)).unwrap());
        let mut delta = Delta { cycle, stock: self.random.maybe(Random::u32), ..Delta::default() };
        let objects: Vec<(Handle, Base, UnitTypeId)> =
            self.view.objects().map(|(handle, seen)| (handle, seen.base, seen.unit_type)).collect();
        for (object, before, unit_type) in objects {
            let base = self.base(cycle, Some(&before), unit_type);
            let Base { point, cycle, fraction, .. } = base;
            match self.random.below(6) {
                0 if base.is_moving() => delta.moved.push(Moved { object, base }),
                1 => {
                    let reason = self.random.maybe(Random::stop_reason);
                    delta.stopped.push(Stopped { object, point, cycle, fraction, reason });
                }
                2 => delta.vanished.push(object),
                3 => delta.died.push(object),
                _ => {}
            }
        }
        for _ in 0..self.random.below(6) {
            self.next_handle += 1 + u32::try_from(self.random.below(3) * 60).unwrap();
            let unit_type = UnitTypeId(u16::try_from(self.random.below(3)).unwrap());
            let base = self.base(cycle, None, unit_type);
            let appeared = self.appeared(self.next_handle, base);
            delta.appeared.push(Appeared { unit_type, ..appeared });
        }
        seal(&mut delta, &self.view);
        delta
    }

    fn base(&mut self, cycle: Cycle, before: Option<&Base>, unit_type: UnitTypeId) -> Base {
        let random = &mut self.random;
        let ago = [0, 1, 1, random.below(400)][random.below(4)];
        let moment = Cycle(cycle.0.saturating_sub(u32::try_from(ago).unwrap()));
        let fraction = [0.0, 0.25, 1.0, 0.1][random.below(4)];
        let small = |random: &mut Random| {
            let double = random.double();
            if double.abs() < 1e6 { double } else { 1.5 }
        };
        let point = match before {
            Some(before) if random.coin() => before.position(moment) + before.velocity * fraction,
            _ => DVec2::new(small(random), small(random)),
        };
        let speed = self.rules.unit_types[usize::from(unit_type.0)].speed;
        let aim = DVec2::new(small(random), small(random));
        let velocity = match random.below(4) {
            0 => DVec2::ZERO,
            1 => aim,
            _ => aim * (speed / aim.length()),
        };
        let velocity = if velocity.is_finite() { velocity } else { DVec2::X };
        self.rules.positions.rounded(Base { point, cycle: moment, fraction, velocity })
    }
}

/// Gives a delta the check of the view that it leads to.
fn seal(delta: &mut Delta, view: &View) {
    delta.check = match view.clone().apply(delta) {
        Err(MismatchError::Check { found, .. }) => found,
        Ok(()) => delta.check,
        Err(error) => panic!("{error}"),
    };
}
