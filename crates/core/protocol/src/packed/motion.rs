//! One motion: when, where and how fast, each as short as the receiver's knowledge allows.

use glam::DVec2;
use maniple_geometry::Cycle;
use maniple_view::{Base, Handle, Rules, StopReason, UnitTypeId};

use super::PackedProblem;
use super::bits::{Reader, write_signed, write_unsigned};
use super::numbers::Numbers;

// When: bits 0 and 1 of the flags.
const AT_LAST_CYCLE: u8 = 0;
const IN_LAST_CYCLE: u8 = 1;
const AT_CYCLE: u8 = 2;
const AT_ANY_TIME: u8 = 3;

// Where: bits 2 and 3.
const ON_LINE: u8 = 0;
const NEAR_LINE: u8 = 1;
const ANYWHERE: u8 = 2;

// How fast: bits 4 and 5; of a stop bits 4 to 6 say why.
const AT_ANY_VELOCITY: u8 = 0;
const AT_SPEED: u8 = 1;
const AT_OTHER_SPEED: u8 = 2;
const AT_REST: u8 = 3;
/// Bit 6: y is given, and x follows from the speed; else the other way round.
const Y_IS_GIVEN: u8 = 0x40;
/// Bit 7: what follows from the speed is negative.
const IS_NEGATIVE: u8 = 0x80;

/// Differences of this size and more are not worth two bytes each.
const DIFFERENCE_MAX: u64 = 1 << 40;

/// What a receiver knows of an object before a delta.
#[derive(Clone, Copy, Debug)]
pub(super) struct Known {
    pub(super) unit_type: UnitTypeId,
    pub(super) base: Base,
}

/// How motions are written in a match, and what everybody knows of them.
#[derive(Clone, Debug)]
pub(super) struct Layout {
    places: Numbers,
    velocities: Numbers,
    /// Of each unit type, and of its other mode.
    speeds: Vec<(f64, Option<f64>)>,
}

impl Layout {
    pub(super) fn of(rules: &Rules) -> Self {
        let speeds = |unit_type: &maniple_view::UnitType| {
            (unit_type.speed, unit_type.alternate.as_ref().map(|alternate| alternate.speed))
        };
        Self {
            places: Numbers::of_places(rules.positions),
            velocities: Numbers::of_velocities(rules.positions),
            speeds: rules.unit_types.iter().map(speeds).collect(),
        }
    }

    fn speed(&self, unit_type: UnitTypeId, is_other: bool) -> Option<f64> {
        let &(speed, other) = self.speeds.get(usize::from(unit_type.0))?;
        if is_other { other } else { Some(speed) }
    }
}

/// Writes the motions of one delta.
pub(super) struct MotionWriter<'a> {
    pub(super) layout: &'a Layout,
    pub(super) cycle: Cycle,
    pub(super) bytes: Vec<u8>,
}

impl MotionWriter<'_> {
    /// Writes a base of an object of this type; of its motion before, if it has one, the receiver knows.
    pub(super) fn write_base(&mut self, base: &Base, unit_type: UnitTypeId, before: Option<&Base>) {
        let mut fields = Vec::new();
        let flags = self.when(base, &mut fields)
            | self.place(base, before, &mut fields) << 2
            | self.velocity(base.velocity, unit_type, &mut fields);
        self.bytes.push(flags);
        self.bytes.append(&mut fields);
    }

    /// Writes where an object came to rest, and why; of its motion before, if one is given, the receiver knows.
    pub(super) fn write_stop(&mut self, base: &Base, before: Option<&Base>, reason: Option<StopReason>) {
        let mut fields = Vec::new();
        let mut flags = self.when(base, &mut fields) | self.place(base, before, &mut fields) << 2;
        flags |= match reason {
            None => 0,
            Some(StopReason::Arrived) => 1,
            Some(StopReason::Ordered) => 2,
            Some(StopReason::Segment) => 3,
            Some(StopReason::Edge) => 4,
            Some(StopReason::Object { other: None }) => 5,
            Some(StopReason::Object { other: Some(other) }) => {
                write_unsigned(&mut fields, u64::from(other.0));
                6
            }
        } << 4;
        self.bytes.push(flags);
        self.bytes.append(&mut fields);
    }

    fn when(&self, base: &Base, fields: &mut Vec<u8>) -> u8 {
        let is_at_start = base.fraction.to_bits() == 0;
        let ago = self.cycle.0.wrapping_sub(base.cycle.0);
        match (ago, is_at_start) {
            (1, true) => AT_LAST_CYCLE,
            (0, true) => AT_CYCLE,
            (1, false) => {
                self.layout.places.write_fraction(fields, base.fraction);
                IN_LAST_CYCLE
            }
            _ => {
                write_unsigned(fields, u64::from(ago));
                self.layout.places.write_fraction(fields, base.fraction);
                AT_ANY_TIME
            }
        }
    }

    fn place(&self, base: &Base, before: Option<&Base>, fields: &mut Vec<u8>) -> u8 {
        let places = self.layout.places;
        if let Some(expected) = before.map(|before| expected(before, base, places)) {
            let (x, y) =
                (places.difference(expected.x, base.point.x), places.difference(expected.y, base.point.y));
            if (x, y) == (0, 0) {
                return ON_LINE;
            }
            if x.unsigned_abs() < DIFFERENCE_MAX && y.unsigned_abs() < DIFFERENCE_MAX {
                write_signed(fields, x);
                write_signed(fields, y);
                return NEAR_LINE;
            }
        }
        places.write(fields, base.point.x);
        places.write(fields, base.point.y);
        ANYWHERE
    }

    /// The smaller component is given: the larger one follows from it and the speed with hardly an error.
    fn velocity(&self, velocity: DVec2, unit_type: UnitTypeId, fields: &mut Vec<u8>) -> u8 {
        let velocities = self.layout.velocities;
        if velocity.x.to_bits() == 0 && velocity.y.to_bits() == 0 {
            return AT_REST << 4;
        }
        let y_is_given = velocity.y.abs() < velocity.x.abs();
        let (given, other) = if y_is_given { (velocity.y, velocity.x) } else { (velocity.x, velocity.y) };
        for (is_other_mode, flag) in [(false, AT_SPEED), (true, AT_OTHER_SPEED)] {
            let Some(speed) = self.layout.speed(unit_type, is_other_mode) else { continue };
            let difference = velocities.difference(follows(speed, given, velocities), other.abs());
            if difference.unsigned_abs() >= 64 {
                continue;
            }
            velocities.write(fields, given);
            write_signed(fields, difference);
            let axis = if y_is_given { Y_IS_GIVEN } else { 0 };
            return flag << 4 | axis | if other.is_sign_negative() { IS_NEGATIVE } else { 0 };
        }
        velocities.write(fields, velocity.x);
        velocities.write(fields, velocity.y);
        AT_ANY_VELOCITY << 4
    }
}

/// Reads the motions of one delta.
pub(super) struct MotionReader<'a> {
    pub(super) layout: &'a Layout,
    pub(super) cycle: Cycle,
    pub(super) bytes: Reader<'a>,
}

impl MotionReader<'_> {
    /// Reads what [`MotionWriter::write_base`] has written of an object.
    pub(super) fn read_base(
        &mut self,
        object: Handle,
        unit_type: UnitTypeId,
        before: Option<&Base>,
    ) -> Result<Base, PackedProblem> {
        let flags = self.bytes.byte()?;
        let base = self.read_place(flags, before)?;
        let velocity = self.read_velocity(flags, object, unit_type)?;
        Ok(Base { velocity, ..base })
    }

    /// Reads what [`MotionWriter::write_stop`] has written.
    pub(super) fn read_stop(&mut self, before: &Base) -> Result<(Base, Option<StopReason>), PackedProblem> {
        let flags = self.bytes.byte()?;
        let base = self.read_place(flags, Some(before))?;
        let reason = match flags >> 4 {
            0 => None,
            1 => Some(StopReason::Arrived),
            2 => Some(StopReason::Ordered),
            3 => Some(StopReason::Segment),
            4 => Some(StopReason::Edge),
            5 => Some(StopReason::Object { other: None }),
            6 => Some(StopReason::Object { other: Some(Handle(self.bytes.small()?)) }),
            _ => return Err(PackedProblem::Flags { flags }),
        };
        Ok((base, reason))
    }

    /// Reads when and where: a base at rest.
    fn read_place(&mut self, flags: u8, before: Option<&Base>) -> Result<Base, PackedProblem> {
        let places = self.layout.places;
        let (ago, fraction) = match flags & 3 {
            AT_LAST_CYCLE => (1, 0.0),
            IN_LAST_CYCLE => (1, places.read_fraction(&mut self.bytes)?),
            AT_CYCLE => (0, 0.0),
            _ => (self.bytes.small()?, places.read_fraction(&mut self.bytes)?),
        };
        let cycle = self.cycle.0.checked_sub(ago).ok_or(PackedProblem::BeforeStart { ago })?;
        let mut base = Base { point: DVec2::ZERO, cycle: Cycle(cycle), fraction, velocity: DVec2::ZERO };
        let expected = before.map(|before| expected(before, &base, places));
        base.point = match (flags >> 2 & 3, expected) {
            (ON_LINE, Some(expected)) => expected,
            (NEAR_LINE, Some(expected)) => {
                let (x, y) = (self.bytes.signed()?, self.bytes.signed()?);
                DVec2::new(places.beyond(expected.x, x), places.beyond(expected.y, y))
            }
            (ANYWHERE, _) => DVec2::new(places.read(&mut self.bytes)?, places.read(&mut self.bytes)?),
            _ => return Err(PackedProblem::Flags { flags }),
        };
        Ok(base)
    }

    fn read_velocity(
        &mut self,
        flags: u8,
        object: Handle,
        unit_type: UnitTypeId,
    ) -> Result<DVec2, PackedProblem> {
        let velocities = self.layout.velocities;
        let how = flags >> 4 & 3;
        match how {
            AT_ANY_VELOCITY => {
                return Ok(DVec2::new(velocities.read(&mut self.bytes)?, velocities.read(&mut self.bytes)?));
            }
            AT_REST => return Ok(DVec2::ZERO),
            _ => {}
        }
        let speed = self.layout.speed(unit_type, how == AT_OTHER_SPEED);
        let speed = speed.ok_or(PackedProblem::UnknownSpeed { object })?;
        let given = velocities.read(&mut self.bytes)?;
        let other = velocities.beyond(follows(speed, given, velocities), self.bytes.signed()?);
        let other = if flags & IS_NEGATIVE == 0 { other } else { -other };
        Ok(if flags & Y_IS_GIVEN == 0 { DVec2::new(given, other) } else { DVec2::new(other, given) })
    }
}

/// Returns where an object is expected at the moment of its new base if it went on: `p + v * (((k - k0) - f0) + f)`, in this order.
fn expected(before: &Base, base: &Base, places: Numbers) -> DVec2 {
    let elapsed = before.moment().until(base.cycle) + base.fraction;
    let point = before.point + before.velocity * elapsed;
    DVec2::new(places.nearest(point.x), places.nearest(point.y))
}

/// Returns the size of the other component of a velocity: `sqrt(s s - g g)`, and 0 where g alone is more than the speed.
fn follows(speed: f64, given: f64, velocities: Numbers) -> f64 {
    let square = speed * speed - given * given;
    if square > 0.0 { velocities.nearest(square.sqrt()) } else { 0.0 }
}
