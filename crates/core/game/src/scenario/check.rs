//! From what is written to what is checked.

use std::ops::Range;
use std::time::Duration;

use maniple_geometry::NumberError;
use maniple_view::UnitType;
use toml::Spanned;

use super::map::map_source;
use super::nearest::nearest_in_message;
use super::profile::profile;
use super::spectators::spectators;
use super::units::{Modules, Reader, cycles, id};
use super::{
    COUNT_MAX, Clock, Combat, GROUPS_MAX, Group, HarvestRule, LENGTH_SECONDS_MAX, NAME_BYTES_MAX, Neutral,
    Objective, Overrides, PAUSE_SECONDS_DEFAULT, Problem, RATE_DEFAULT, RATE_MAX, RATE_MIN,
    SCENARIO_BYTES_MAX, SEATS_MAX, SECONDS_MAX, Scenario, ScenarioError, SeatStart, TEAM_MAX,
    TIME_BANK_SECONDS_DEFAULT, TIME_BANK_SECONDS_MAX, TIME_BANK_SECONDS_MIN, UNIT_FILES_MAX, UNIT_TYPES_MAX,
    UNITS_MAX, Vision, WANDER_DEFAULT, WANDER_MAX, WANDER_MIN, ZONE_SIZE_DEFAULT, ZONE_SIZE_MAX, file,
};
use crate::rules::approach::TOUCH;
use crate::rules::production::SITE_GAP;

/// Longest path of a file, in bytes.
pub(super) const PATH_BYTES_MAX: usize = 1024;

/// A problem and the bytes of the text that it is about.
pub(super) type Found<T> = Result<T, (Range<usize>, Problem)>;

/// A text and the name of its file.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Source<'a> {
    pub(crate) name: &'a str,
    pub(crate) text: &'a str,
}

impl Source<'_> {
    /// Returns a problem with its place.
    fn error(&self, (span, problem): (Range<usize>, Problem)) -> ScenarioError {
        let before = self.text.get(..span.start).unwrap_or_default();
        let line_start = before.rfind('\n').map_or(0, |place| place + 1);
        ScenarioError {
            file: self.name.to_owned(),
            line: before.matches('\n').count() + 1,
            column: before[line_start..].chars().count() + 1,
            problem,
        }
    }

    fn parsed<T: serde::de::DeserializeOwned>(&self) -> Result<T, ScenarioError> {
        if self.text.len() > SCENARIO_BYTES_MAX {
            let problem = Problem::TooLong { found: self.text.len(), max: SCENARIO_BYTES_MAX };
            return Err(self.error((0..0, problem)));
        }
        toml::from_str(self.text).map_err(|error| {
            let nearest = nearest_in_message(error.message()).map(str::to_owned);
            let problem = Problem::Shape { message: error.message().to_owned(), nearest };
            self.error((error.span().unwrap_or(0..0), problem))
        })
    }
}

/// A scenario as it is written, before the files of its unit types are there.
pub(crate) struct Draft<'a> {
    source: Source<'a>,
    file: file::File,
}

impl<'a> Draft<'a> {
    pub(crate) fn parse(source: Source<'a>) -> Result<Self, ScenarioError> {
        let file: file::File = source.parsed()?;
        let draft = Self { source, file };
        let units = &draft.file.units;
        if let Some(first) = units.get(UNIT_FILES_MAX) {
            let (value, max) = (units.len() as f64, UNIT_FILES_MAX as f64);
            let problem =
                Problem::OutOfRange { field: "the number of files of unit types", value, min: 0.0, max };
            return Err(source.error((first.span(), problem)));
        }
        for path in units {
            named(path, "units", PATH_BYTES_MAX).map_err(|problem| source.error(problem))?;
        }
        Ok(draft)
    }

    /// Returns the paths of the files of unit types, relative to the scenario's folder.
    pub(crate) fn unit_files(&self) -> impl Iterator<Item = &str> {
        self.file.units.iter().map(|path| path.get_ref().as_str())
    }

    /// Returns the scenario, with what is asked for instead of what it says; `units` are the texts of the files of unit
    /// types.
    pub(crate) fn checked(
        &self,
        units: &[Source<'_>],
        overrides: &Overrides,
    ) -> Result<Scenario, ScenarioError> {
        let at_place = |problem| self.source.error(problem);
        let rate = number_or(self.file.rate.as_ref(), RATE_DEFAULT, "rate", RATE_MIN, RATE_MAX);
        let rate = overrides.rate.unwrap_or(rate.map_err(at_place)?);
        let unit_types = self.unit_types(units, rate)?;
        scenario(&self.file, unit_types, rate, overrides).map_err(at_place)
    }

    /// Returns all unit types, by name.
    fn unit_types(&self, sources: &[Source<'_>], rate: f64) -> Result<Vec<UnitType>, ScenarioError> {
        let files = sources.iter().map(Source::parsed).collect::<Result<Vec<file::UnitFile>, _>>()?;
        let mut written: Vec<(&str, &Spanned<file::Unit>, Source<'_>)> =
            self.file.unit.iter().map(|(name, unit)| (name.as_str(), unit, self.source)).collect();
        for (file, source) in files.iter().zip(sources) {
            written.extend(file.unit.iter().map(|(name, unit)| (name.as_str(), unit, *source)));
        }
        written.sort_by_key(|(name, ..)| *name);
        for pair in written.windows(2) {
            let [(name, _, first), (other, unit, second)] = pair else { continue };
            if name == other {
                let problem = Problem::Twice { name: (*name).to_owned(), other: first.name.to_owned() };
                return Err(second.error((unit.span(), problem)));
            }
        }
        count(written.len(), "the number of unit types", UNIT_TYPES_MAX, self.file.seat.span())
            .map_err(|problem| self.source.error(problem))?;
        let names: Vec<String> = written.iter().map(|(name, ..)| (*name).to_owned()).collect();
        let modules = Modules {
            combat: self.file.combat.is_some(),
            harvest: self.file.harvest.is_some(),
            production: self.file.production.is_some(),
            modes: self.file.modes.is_some(),
        };
        let reader = Reader { rate, modules, names: &names };
        let unit_type = |(name, unit, source): &(&str, &Spanned<file::Unit>, Source<'_>)| {
            reader.unit_type(name, unit).map_err(|problem| source.error(problem))
        };
        let unit_types = written.iter().map(unit_type).collect::<Result<Vec<UnitType>, _>>()?;
        if self.file.vision.is_some() {
            for ((name, unit, source), unit_type) in written.iter().zip(&unit_types) {
                if unit_type.sight < sight_to_build(unit_type, &unit_types) {
                    let problem =
                        "builds what is larger than it sees; give it more sight, or no such building";
                    let name = (*name).to_owned();
                    return Err(source.error((unit.span(), Problem::Unfit { name, problem })));
                }
            }
        }
        Ok(unit_types)
    }
}

/// Returns how far a builder must see to see whoever stands where it builds: one that it does not see must not tell it anything.
fn sight_to_build(builder: &UnitType, unit_types: &[UnitType]) -> f64 {
    let mut wanted = 0.0;
    for building in &builder.builds {
        let across = 2.0 * unit_types[usize::from(building.0)].shape.radius() + TOUCH + SITE_GAP;
        if across > wanted {
            wanted = across;
        }
    }
    wanted
}

fn scenario(
    file: &file::File,
    unit_types: Vec<UnitType>,
    rate: f64,
    overrides: &Overrides,
) -> Found<Scenario> {
    let names: Vec<String> = unit_types.iter().map(|unit_type| unit_type.name.clone()).collect();
    let seats = seats(&file.seat, &names)?;
    if let (None, file::Kind::Kills | file::Kind::Buildings) = (&file.combat, file.objective.get_ref().kind) {
        let field = "an objective of kills or buildings";
        return Err((file.objective.span(), Problem::Pointless { field, choice: "a table [combat]" }));
    }
    Ok(Scenario {
        name: named(&file.name, "name", NAME_BYTES_MAX)?,
        map: map_source(file, &unit_types)?,
        rate,
        cycles_max: cycles_max(&file.length_seconds, rate)?,
        seed: overrides.seed.unwrap_or(file.seed),
        stops: file.kinematics.stops,
        profile: overrides.applied(profile(&file.kinematics, &file.view)?),
        clock: clock(&file.clock)?,
        vision: file.vision.as_ref().map(|vision| Vision {
            terrain: vision.terrain,
            walls_block: vision.walls_block,
            identity: vision.identity,
        }),
        combat: file.combat.as_ref().map(|combat| Combat { friendly_fire: combat.friendly_fire }),
        harvest: file
            .harvest
            .as_ref()
            .map(|rule| harvest(rule.get_ref(), &unit_types, &names))
            .transpose()?,
        production: file.production.is_some(),
        modes: file.modes.is_some(),
        neutral: file.neutral.as_ref().map(|rule| neutral(rule, rate, &names)).transpose()?,
        spectators: file.spectators.as_ref().map(|rule| spectators(rule, rate)).transpose()?,
        objective: objective(&file.objective, &seats)?,
        seats,
        unit_types,
    })
}

fn cycles_max(length_seconds: &Spanned<f64>, rate: f64) -> Found<maniple_geometry::Cycle> {
    let seconds = number(length_seconds, "length_seconds", 1.0 / RATE_MAX, LENGTH_SECONDS_MAX)?;
    Ok(maniple_geometry::Cycle(cycles(seconds, rate)))
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

fn harvest(rule: &file::Harvest, unit_types: &[UnitType], names: &[String]) -> Found<HarvestRule> {
    let patch = id(&rule.patch, names)?;
    if unit_types[usize::from(patch.0)].patch_places.is_none() {
        let name = rule.patch.get_ref().clone();
        let problem = "is no resource patch; give it [unit.NAME.patch] with places, or name another";
        return Err((rule.patch.span(), Problem::Unfit { name, problem }));
    }
    Ok(HarvestRule { patch })
}

fn neutral(rule: &file::Neutral, rate: f64, names: &[String]) -> Found<Neutral> {
    let pause = rule.pause_seconds.as_ref();
    let pause = number_or(pause, PAUSE_SECONDS_DEFAULT, "pause_seconds", 0.0, SECONDS_MAX)?;
    Ok(Neutral {
        groups: groups(&rule.groups, names)?,
        wander: number_or(rule.wander.as_ref(), WANDER_DEFAULT, "wander", WANDER_MIN, WANDER_MAX)?,
        pause: cycles(pause, rate),
    })
}

fn objective(objective: &Spanned<file::Objective>, seats: &[SeatStart]) -> Found<Objective> {
    let (place, objective) = (objective.span(), objective.get_ref());
    let pointless = |span: Option<Range<usize>>, field, choice| {
        span.map_or(Ok(()), |span| Err((span, Problem::Pointless { field, choice })))
    };
    let kind = objective.kind;
    if kind != file::Kind::Race {
        let span = objective.zone_size.as_ref().map(Spanned::span);
        pointless(span, "zone_size", "kind = \"race\"")?;
    }
    if kind != file::Kind::Resources {
        pointless(objective.goal.as_ref().map(Spanned::span), "goal", "kind = \"resources\"")?;
    }
    if kind != file::Kind::Survive {
        pointless(objective.team.as_ref().map(Spanned::span), "team", "kind = \"survive\"")?;
    }
    Ok(match kind {
        file::Kind::Race => {
            let size = objective.zone_size.as_ref();
            Objective::Race {
                zone_size: number_or(size, ZONE_SIZE_DEFAULT, "zone_size", 1.0, ZONE_SIZE_MAX)?,
            }
        }
        file::Kind::Resources => {
            let goal = objective.goal.as_ref().map(|goal| whole(goal, "goal", 1, u32::MAX));
            Objective::Resources { goal: goal.transpose()? }
        }
        file::Kind::Kills => Objective::Kills,
        file::Kind::Buildings => Objective::Buildings,
        file::Kind::LastStanding => Objective::LastStanding,
        file::Kind::Survive => {
            let why = "name the team that has to survive";
            let missing = (place, Problem::Missing { wanted: "team", why });
            let team = objective.team.as_ref().ok_or(missing)?;
            if seats.iter().all(|seat| seat.team != *team.get_ref()) {
                let why = "a seat has to be in the team that is to survive";
                return Err((team.span(), Problem::Missing { wanted: "a seat of this team", why }));
            }
            Objective::Survive { team: *team.get_ref() }
        }
    })
}

fn seats(seats: &Spanned<Vec<file::Seat>>, names: &[String]) -> Found<Vec<SeatStart>> {
    count(seats.get_ref().len(), "the number of seats", SEATS_MAX, seats.span())?;
    (0..).zip(seats.get_ref()).map(|(number, seat)| seat_start(number, seat, names)).collect()
}

fn seat_start(number: u16, seat: &file::Seat, names: &[String]) -> Found<SeatStart> {
    let team = seat.team.as_ref().map(|team| {
        let value = u32::from(*team.get_ref());
        let problem = Problem::OutOfRange {
            field: "team",
            value: f64::from(value),
            min: 0.0,
            max: f64::from(TEAM_MAX),
        };
        if *team.get_ref() <= TEAM_MAX { Ok(*team.get_ref()) } else { Err((team.span(), problem)) }
    });
    Ok(SeatStart {
        bot: seat.bot.as_ref().map(|bot| named(bot, "bot", NAME_BYTES_MAX)).transpose()?,
        team: team.transpose()?.unwrap_or(number),
        stock: seat.stock.as_ref().map_or(Ok(0), |stock| whole(stock, "stock", 0, COUNT_MAX))?,
        groups: groups(&seat.groups, names)?,
    })
}

fn groups(written: &Spanned<Vec<file::Group>>, names: &[String]) -> Found<Vec<Group>> {
    let place = written.span();
    let written = written.get_ref();
    count(written.len(), "the number of groups", GROUPS_MAX, place.clone())?;
    let group = |written: &file::Group| {
        let count = whole(&written.count, "count", 1, UNITS_MAX)?;
        Ok(Group { unit_type: id(&written.unit, names)?, count })
    };
    let groups = written.iter().map(group).collect::<Found<Vec<Group>>>()?;
    let units: u64 = groups.iter().map(|group| u64::from(group.count)).sum();
    if units > u64::from(UNITS_MAX) {
        let problem = Problem::OutOfRange {
            field: "the number of units of the groups",
            value: units as f64,
            min: 1.0,
            max: f64::from(UNITS_MAX),
        };
        return Err((place, problem));
    }
    Ok(groups)
}

/// Checks that there is at least one and not too many.
pub(super) fn count(found: usize, field: &'static str, max: usize, span: Range<usize>) -> Found<()> {
    if (1..=max).contains(&found) {
        return Ok(());
    }
    Err((span, Problem::OutOfRange { field, value: found as f64, min: 1.0, max: max as f64 }))
}

pub(super) fn number_or(
    value: Option<&Spanned<f64>>,
    default: f64,
    field: &'static str,
    min: f64,
    max: f64,
) -> Found<f64> {
    value.map_or(Ok(default), |value| number(value, field, min, max))
}

/// Returns the whole number if it is in range.
pub(super) fn whole(value: &Spanned<u32>, field: &'static str, min: u32, max: u32) -> Found<u32> {
    let span = value.span();
    let value = *value.get_ref();
    if (min..=max).contains(&value) {
        return Ok(value);
    }
    let (value, min, max) = (f64::from(value), f64::from(min), f64::from(max));
    Err((span, Problem::OutOfRange { field, value, min, max }))
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

pub(super) fn named(name: &Spanned<String>, field: &'static str, max: usize) -> Found<String> {
    check_name(name.get_ref(), field, max, name.span())?;
    Ok(name.get_ref().clone())
}

pub(super) fn check_name(name: &str, field: &'static str, max: usize, span: Range<usize>) -> Found<()> {
    if name.is_empty() || name.len() > max || name.chars().any(char::is_control) {
        return Err((span, Problem::BadName { field, name: name.to_owned(), max }));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use maniple_geometry::Cycle;
    use maniple_view::{Identity, Positions, Profile, Scalar, Solver, Stops, TerrainKnowledge, UnitTypeId};

    use super::*;
    use crate::scenario::{MapSource, SIGHT_DEFAULT, Stall};

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
terrain = "explored"
walls_block = true
identity = "persistent"

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
        assert_eq!(scenario.map, MapSource::File("../maps/choke.tmx".to_owned()));
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
        let (terrain, identity) = (TerrainKnowledge::Explored, Identity::Persistent);
        assert_eq!(scenario.vision, Some(Vision { terrain, walls_block: true, identity }));
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
            .replace("[vision]\nterrain = \"explored\"\nwalls_block = true\nidentity = \"persistent\"\n", "")
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
        check("terrain = \"explored\"", "terrain = \"explorred\"", "did you mean `explored`?");
        check("walls_block = true", "wall_block = true", "did you mean `walls_block`?");
        check("walls_block = true", "walls_block = 1", "duel.toml:26:15: invalid type: integer `1`");
        check("identity = \"persistent\"", "identity = \"same\"", "duel.toml:27:12: unknown variant `same`");
        check(
            "unit = \"scout\"",
            "unit = \"scuot\"",
            "no unit type is called \"scuot\"; did you mean `scout`?",
        );
        check("unit = \"scout\"", "unit = \"scuot\"", "duel.toml:44:20: ");
        check("radius = 0.25", "radius = -0.25", "duel.toml:34:10: radius is -0.25; it must be positive");
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
