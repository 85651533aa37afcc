//! From what is written to what is checked.

use std::ops::Range;
use std::time::Duration;

use maniple_geometry::limits::{COORDINATE_MAX, RADIUS_MAX, SPEED_MAX};
use maniple_geometry::{Cycle, Limits, NumberError};
use maniple_view::{UnitType, UnitTypeId};
use toml::Spanned;

use super::nearest::{nearest, nearest_in_message};
use super::profile::profile;
use super::{
    Clock, GROUPS_MAX, Group, LENGTH_SECONDS_MAX, NAME_BYTES_MAX, Objective, Overrides, Problem,
    RATE_DEFAULT, RATE_MAX, RATE_MIN, SCENARIO_BYTES_MAX, SEATS_MAX, SIGHT_DEFAULT, SIGHT_MIN, Scenario,
    ScenarioError, SeatStart, TIME_BANK_SECONDS_DEFAULT, TIME_BANK_SECONDS_MAX, TIME_BANK_SECONDS_MIN,
    TerrainKnowledge, UNIT_TYPES_MAX, UNITS_MAX, Vision, ZONE_SIZE_DEFAULT, ZONE_SIZE_MAX, file,
};

/// Longest path of a map, in bytes.
const PATH_BYTES_MAX: usize = 1024;

/// A problem and the bytes of the text that it is about.
pub(super) type Found<T> = Result<T, (Range<usize>, Problem)>;

pub(super) fn read(name: &str, text: &str, overrides: &Overrides) -> Result<Scenario, ScenarioError> {
    checked(text, overrides).map_err(|(span, problem)| {
        let before = text.get(..span.start).unwrap_or_default();
        let line_start = before.rfind('\n').map_or(0, |place| place + 1);
        ScenarioError {
            file: name.to_owned(),
            line: before.matches('\n').count() + 1,
            column: before[line_start..].chars().count() + 1,
            problem,
        }
    })
}

fn checked(text: &str, overrides: &Overrides) -> Found<Scenario> {
    if text.len() > SCENARIO_BYTES_MAX {
        return Err((0..0, Problem::TooLong { found: text.len(), max: SCENARIO_BYTES_MAX }));
    }
    let file: file::File = toml::from_str(text).map_err(|error| {
        let nearest = nearest_in_message(error.message()).map(str::to_owned);
        let problem = Problem::Shape { message: error.message().to_owned(), nearest };
        (error.span().unwrap_or(0..0), problem)
    })?;
    let rate = number_or(file.rate.as_ref(), RATE_DEFAULT, "rate", RATE_MIN, RATE_MAX)?;
    let rate = overrides.rate.unwrap_or(rate);
    let unit_types = unit_types(&file.unit, rate, file.seat.span())?;
    Ok(Scenario {
        name: named(&file.name, "name", NAME_BYTES_MAX)?,
        map: named(&file.map, "map", PATH_BYTES_MAX)?,
        rate,
        cycles_max: cycles_max(&file.length_seconds, rate)?,
        seed: overrides.seed.unwrap_or(file.seed),
        stops: file.kinematics.stops,
        profile: overrides.applied(profile(&file.kinematics, &file.view)?),
        clock: clock(&file.clock)?,
        vision: file.vision.map(|vision| match vision.terrain {
            file::Terrain::Known => Vision { terrain: TerrainKnowledge::Known },
        }),
        objective: objective(&file.objective)?,
        seats: seats(&file.seat, &unit_types)?,
        unit_types,
    })
}

#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "at most LENGTH_SECONDS_MAX * RATE_MAX"
)]
fn cycles_max(length_seconds: &Spanned<f64>, rate: f64) -> Found<Cycle> {
    let seconds = number(length_seconds, "length_seconds", 1.0 / RATE_MAX, LENGTH_SECONDS_MAX)?;
    let cycles = (seconds * rate).round();
    Ok(Cycle(if cycles < 1.0 { 1 } else { cycles as u32 }))
}

fn clock(clock: &file::Clock) -> Found<Clock> {
    let seconds = number_or(
        clock.time_bank_seconds.as_ref(),
        TIME_BANK_SECONDS_DEFAULT,
        "time_bank_seconds",
        TIME_BANK_SECONDS_MIN,
        TIME_BANK_SECONDS_MAX,
    )?;
    Ok(Clock { time_bank: Duration::from_secs_f64(seconds), stall: clock.stall })
}

fn objective(objective: &file::Objective) -> Found<Objective> {
    match objective.kind {
        file::Kind::Race => {
            let size = objective.zone_size.as_ref();
            let zone_size = number_or(size, ZONE_SIZE_DEFAULT, "zone_size", 1.0, ZONE_SIZE_MAX)?;
            Ok(Objective::Race { zone_size })
        }
    }
}

fn unit_types(
    units: &std::collections::BTreeMap<String, Spanned<file::Unit>>,
    rate: f64,
    place: Range<usize>,
) -> Found<Vec<UnitType>> {
    count(units.len(), "the number of unit types", UNIT_TYPES_MAX, place)?;
    units.iter().map(|(name, unit)| unit_type(name, unit, rate)).collect()
}

fn unit_type(name: &str, unit: &Spanned<file::Unit>, rate: f64) -> Found<UnitType> {
    let limits = Limits::new(COORDINATE_MAX, RADIUS_MAX, SPEED_MAX)
        .expect("the largest limits of all are limits of a world");
    let span = unit.span();
    let unit = unit.get_ref();
    let bad = |field, value: &Spanned<f64>| {
        let span = value.span();
        move |problem: NumberError| (span, Problem::BadNumber { field, problem })
    };
    let radius = *unit.radius.get_ref();
    limits.check_radius(radius).map_err(bad("radius", &unit.radius))?;
    limits.check_speed(*unit.speed.get_ref()).map_err(bad("speed", &unit.speed))?;
    let speed = unit.speed.get_ref() / rate;
    limits.check_speed(speed).map_err(bad("speed divided by rate", &unit.speed))?;
    let sight = number_or(unit.sight.as_ref(), SIGHT_DEFAULT, "sight", SIGHT_MIN, COORDINATE_MAX)?;
    check_name(name, "the name of a unit type", NAME_BYTES_MAX, span)?;
    Ok(UnitType { name: name.to_owned(), radius, speed, sight })
}

fn seats(seats: &Spanned<Vec<file::Seat>>, unit_types: &[UnitType]) -> Found<Vec<SeatStart>> {
    count(seats.get_ref().len(), "the number of seats", SEATS_MAX, seats.span())?;
    seats.get_ref().iter().map(|seat| seat_start(seat, unit_types)).collect()
}

fn seat_start(seat: &file::Seat, unit_types: &[UnitType]) -> Found<SeatStart> {
    let place = seat.groups.span();
    let written = seat.groups.get_ref();
    count(written.len(), "the number of groups", GROUPS_MAX, place.clone())?;
    let groups = written.iter().map(|written| group(written, unit_types)).collect::<Found<Vec<Group>>>()?;
    let units: u64 = groups.iter().map(|group| u64::from(group.count)).sum();
    if units > u64::from(UNITS_MAX) {
        let problem = Problem::OutOfRange {
            field: "the number of units of the seat",
            value: units as f64,
            min: 1.0,
            max: f64::from(UNITS_MAX),
        };
        return Err((place, problem));
    }
    let bot = seat.bot.as_ref().map(|bot| named(bot, "bot", NAME_BYTES_MAX)).transpose()?;
    Ok(SeatStart { bot, groups })
}

fn group(group: &file::Group, unit_types: &[UnitType]) -> Found<Group> {
    let name = group.unit.get_ref();
    let Some(place) = unit_types.iter().position(|unit_type| unit_type.name == *name) else {
        let nearest = nearest(name, unit_types.iter().map(|unit_type| unit_type.name.as_str()));
        let problem = Problem::UnknownUnit { name: name.clone(), nearest: nearest.map(str::to_owned) };
        return Err((group.unit.span(), problem));
    };
    let count = *group.count.get_ref();
    if !(1..=UNITS_MAX).contains(&count) {
        let problem = Problem::OutOfRange {
            field: "count",
            value: f64::from(count),
            min: 1.0,
            max: f64::from(UNITS_MAX),
        };
        return Err((group.count.span(), problem));
    }
    let place = u16::try_from(place).expect("UNIT_TYPES_MAX fits into 16 bits");
    Ok(Group { unit_type: UnitTypeId(place), count })
}

/// Checks that there is at least one and not too many.
fn count(found: usize, field: &'static str, max: usize, span: Range<usize>) -> Found<()> {
    if (1..=max).contains(&found) {
        return Ok(());
    }
    Err((span, Problem::OutOfRange { field, value: found as f64, min: 1.0, max: max as f64 }))
}

fn number_or(
    value: Option<&Spanned<f64>>,
    default: f64,
    field: &'static str,
    min: f64,
    max: f64,
) -> Found<f64> {
    value.map_or(Ok(default), |value| number(value, field, min, max))
}

/// Returns the number if it is in range; not a number is in none.
pub(super) fn number(value: &Spanned<f64>, field: &'static str, min: f64, max: f64) -> Found<f64> {
    let span = value.span();
    let value = *value.get_ref();
    if value == 0.0 && value.is_sign_negative() {
        return Err((span, Problem::BadNumber { field, problem: NumberError::NegativeZero }));
    }
    if min <= value && value <= max {
        return Ok(value);
    }
    Err((span, Problem::OutOfRange { field, value, min, max }))
}

fn named(name: &Spanned<String>, field: &'static str, max: usize) -> Found<String> {
    check_name(name.get_ref(), field, max, name.span())?;
    Ok(name.get_ref().clone())
}

fn check_name(name: &str, field: &'static str, max: usize, span: Range<usize>) -> Found<()> {
    if name.is_empty() || name.len() > max || name.chars().any(char::is_control) {
        return Err((span, Problem::BadName { field, name: name.to_owned(), max }));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use maniple_view::{Positions, Profile, Scalar, Solver, Stops};

    use super::*;
    use crate::scenario::Stall;

    const WHOLE: &str = r#"
name = "Duel"
map = "../maps/choke.tmx"
rate = 4
length_seconds = 60
seed = 7

[kinematics]
stops = "approaching"
scalar = "f32"
solver = "stepped"
substeps = 4
certify = false
skin = 0.01

[view]
positions = "grid"
grid_bits = 10

[clock]
time_bank_seconds = 2.5
stall = "forfeit"

[vision]
terrain = "known"

[objective]
kind = "race"
zone_size = 6

[unit.scout]
radius = 0.25
speed = 2.0
sight = 5.0

[unit.rock]
radius = 1.0
speed = 0

[[seat]]
bot = "straight"
groups = [{ unit = "scout", count = 20 }]

[[seat]]
groups = [{ unit = "rock", count = 1 }, { unit = "scout", count = 2 }]
"#;

    #[test]
    fn a_whole_scenario_is_read_and_speeds_are_divided_by_the_rate() {
        let scenario = Scenario::read("duel.toml", WHOLE).unwrap();
        assert_eq!(scenario.name, "Duel");
        assert_eq!(scenario.map, "../maps/choke.tmx");
        assert_eq!(scenario.rate, 4.0);
        assert_eq!(scenario.cycles_max, Cycle(240));
        assert_eq!(scenario.seed, 7);
        assert_eq!(scenario.stops, Stops::Approaching);
        let profile = Profile {
            scalar: Scalar::F32,
            solver: Solver::Stepped { substeps: 4 },
            certify: false,
            skin: Some(0.01),
            positions: Positions::Grid { bits: 10 },
        };
        assert_eq!(scenario.profile, profile);
        assert_eq!(scenario.clock, Clock { time_bank: Duration::from_millis(2500), stall: Stall::Forfeit });
        assert_eq!(scenario.vision, Some(Vision { terrain: TerrainKnowledge::Known }));
        assert_eq!(scenario.objective, Objective::Race { zone_size: 6.0 });
        let names: Vec<&str> = scenario.unit_types.iter().map(|unit| unit.name.as_str()).collect();
        assert_eq!(names, ["rock", "scout"]);
        assert_eq!(scenario.unit_types[1].speed, 0.5);
        assert_eq!(scenario.unit_types[0].sight, SIGHT_DEFAULT);
        assert_eq!(scenario.seats[0].bot.as_deref(), Some("straight"));
        assert_eq!(scenario.seats[1].groups[1], Group { unit_type: UnitTypeId(1), count: 2 });
    }

    #[test]
    fn what_is_absent_has_its_documented_default() {
        let text = WHOLE
            .replace("rate = 4\n", "")
            .replace("seed = 7\n", "")
            .replace("[kinematics]\nstops = \"approaching\"\nscalar = \"f32\"\n", "")
            .replace("solver = \"stepped\"\nsubsteps = 4\ncertify = false\nskin = 0.01\n", "")
            .replace("[view]\npositions = \"grid\"\ngrid_bits = 10\n", "")
            .replace("[clock]\ntime_bank_seconds = 2.5\nstall = \"forfeit\"\n", "")
            .replace("[vision]\nterrain = \"known\"\n", "")
            .replace("zone_size = 6\n", "");
        let scenario = Scenario::read("duel.toml", &text).unwrap();
        assert_eq!(scenario.rate, RATE_DEFAULT);
        assert_eq!(scenario.cycles_max, Cycle(480));
        assert_eq!(scenario.seed, 0);
        assert_eq!(scenario.stops, Stops::Both);
        assert_eq!(scenario.profile, Profile::EXACT);
        assert_eq!(scenario.clock, Clock { time_bank: Duration::from_secs(10), stall: Stall::Skip });
        assert_eq!(scenario.vision, None);
        assert_eq!(scenario.objective, Objective::Race { zone_size: ZONE_SIZE_DEFAULT });
    }

    #[test]
    fn a_mistake_is_told_with_its_place_and_the_nearest_known_name() {
        let check = |from: &str, to: &str, expected: &str| {
            assert!(WHOLE.contains(from), "{from}");
            let error = Scenario::read("duel.toml", &WHOLE.replacen(from, to, 1)).unwrap_err();
            let text = error.to_string();
            assert!(text.contains(expected), "{text}\n  lacks {expected}");
        };
        check("length_seconds", "lenght_seconds", "duel.toml:5:1: unknown field `lenght_seconds`");
        check("length_seconds", "lenght_seconds", "did you mean `length_seconds`?");
        check("kind = \"race\"", "kind = \"rase\"", "did you mean `race`?");
        check("terrain = \"known\"", "terrain = \"explored\"", "expected `known`");
        check(
            "unit = \"scout\"",
            "unit = \"scuot\"",
            "no unit type is called \"scuot\"; did you mean `scout`?",
        );
        check("unit = \"scout\"", "unit = \"scuot\"", "duel.toml:42:20: ");
        check("radius = 0.25", "radius = -0.25", "duel.toml:32:10: radius is -0.25; it must be positive");
        check("radius = 0.25", "radius = nan", "radius is not a number");
        check("speed = 2.0", "speed = -1", "speed is -1; it must not be negative");
        check("sight = 5.0", "sight = 0", "sight is 0; it must be from");
        check("rate = 4", "rate = 0", "rate is 0; it must be from 0.0009765625 to 1000");
        check("rate = 4", "rate = 1001", "rate is 1001;");
        check("length_seconds = 60", "length_seconds = inf", "length_seconds is inf;");
        check("length_seconds = 60", "", "missing field `length_seconds`");
        check("seed = 7", "seed = -7", "duel.toml:6:8: invalid value: integer `-7`");
        check("count = 20", "count = 0", "count is 0; it must be from 1 to 4096");
        check("count = 20", "count = 5000", "count is 5000;");
        check("name = \"Duel\"", "name = \"\"", "name must have 1 to 64 bytes");
        check("name = \"Duel\"", "name = ", "duel.toml:2:");
        check("scalar = \"f32\"", "scalar = \"f16\"", "duel.toml:10:10: unknown variant `f16`");
        check("scalar = \"f32\"", "scaler = \"f32\"", "did you mean `scalar`?");
        check("solver = \"stepped\"", "solver = \"stepper\"", "did you mean `stepped`?");
        let needs = "duel.toml:11:10: solver = \"stepped\" needs substeps, from 1 to 1000; add it";
        check("substeps = 4\n", "", needs);
        let pointless = "duel.toml:12:12: substeps means nothing without solver = \"stepped\"; leave it out";
        check("solver = \"stepped\"", "solver = \"event\"", pointless);
        check("substeps = 4", "substeps = 0", "duel.toml:12:12: substeps is 0; it must be from 1 to 1000");
        check("substeps = 4", "substeps = 1001", "substeps is 1001;");
        check("substeps = 4", "substeps = 2.5", "duel.toml:12:12: invalid type: floating point");
        check("certify = false", "certify = \"off\"", "duel.toml:13:11: invalid type: string \"off\"");
        check("skin = 0.01", "skin = -0.01", "duel.toml:14:8: skin is -0.01; it must be from 0 to 1");
        check("skin = 0.01", "skin = 2", "skin is 2; it must be from 0 to 1");
        check("skin = 0.01", "skin = nan", "skin is NaN;");
        check("skin = 0.01", "skin = -0.0", "skin is -0; write 0");
        check("positions = \"grid\"", "positions = \"grit\"", "did you mean `grid`?");
        let needs = "duel.toml:17:13: positions = \"grid\" needs grid_bits, from 0 to 20; add it";
        check("grid_bits = 10\n", "", needs);
        check("positions = \"grid\"\n", "", "grid_bits means nothing without positions = \"grid\"");
        check(
            "grid_bits = 10",
            "grid_bits = 21",
            "duel.toml:18:13: grid_bits is 21; it must be from 0 to 20",
        );
        check("time_bank_seconds = 2.5", "time_bank_seconds = 4000", "from 0.001 to 3600");
    }

    #[test]
    fn a_scenario_without_seats_or_units_is_refused() {
        let head = "name = 'x'\nmap = 'x.map'\nlength_seconds = 1\nobjective.kind = 'race'\n";
        let check = |rest: &str, expected: &str| {
            let error = Scenario::read("x.toml", &format!("{head}{rest}")).unwrap_err().to_string();
            assert!(error.contains(expected), "{error}");
        };
        check("", "missing field `seat`");
        check("seat = []\nunit.a = { radius = 1, speed = 1 }", "the number of seats is 0");
        check("seat = [{ groups = [] }]\nunit.a = { radius = 1, speed = 1 }", "the number of groups is 0");
        check("seat = [{ groups = [{ unit = 'a', count = 1 }] }]", "the number of unit types is 0");
    }
}
