//! Where the map of a scenario comes from.

use maniple_tilemap::{
    GENERATED_AMOUNT_MAX, GENERATED_CLUSTERS_MAX, GENERATED_PATCHES_MAX, GENERATED_PLAYERS_MAX,
    GENERATED_RADIUS_MAX, GENERATED_SIDE_MAX, GENERATED_SIDE_MIN, GENERATED_SPAWNS_MAX, Kind, Request,
};
use maniple_view::{Layer, UnitType};
use toml::Spanned;

use super::check::{Found, PATH_BYTES_MAX, count, named, whole};
use super::nearest::nearest;
use super::{
    CLUSTERS_DEFAULT, MapSource, PATCH_AMOUNT_DEFAULT, PATCHES_DEFAULT, Problem, SPAWNS_DEFAULT, file,
};

/// Returns where the map comes from: a file, or the seed of the match.
pub(super) fn map_source(file: &file::File, unit_types: &[UnitType]) -> Found<MapSource> {
    match (&file.map, &file.generate) {
        (Some(map), None) => Ok(MapSource::File(named(map, "map", PATH_BYTES_MAX)?)),
        (None, Some(generate)) => {
            let players = players(&file.seat)?;
            Ok(MapSource::Generated(request(generate.get_ref(), players, radius(unit_types))?))
        }
        (Some(map), Some(_)) => Err((map.span(), Problem::Conflict { one: "map", other: "[generate]" })),
        (None, None) => {
            let why = "name a file of a map, or say with [generate] what map the seed gives";
            Err((file.name.span(), Problem::Missing { wanted: "map, or [generate],", why }))
        }
    }
}

/// Returns what map is to be made for so many players, with ways for a unit of this radius.
fn request(generate: &file::Generate, players: u32, radius: f64) -> Found<Request> {
    let number = |value: Option<&Spanned<u32>>, default, field, (min, max)| {
        value.map_or(Ok(default), |value| whole(value, field, min, max))
    };
    let side = |value, field| whole(value, field, GENERATED_SIDE_MIN, GENERATED_SIDE_MAX);
    Ok(Request {
        kind: kind(&generate.kind)?,
        width: side(&generate.width, "width")?,
        height: side(&generate.height, "height")?,
        players,
        spawns: number(generate.spawns.as_ref(), SPAWNS_DEFAULT, "spawns", (1, GENERATED_SPAWNS_MAX))?,
        clusters: number(
            generate.clusters.as_ref(),
            CLUSTERS_DEFAULT,
            "clusters",
            (0, GENERATED_CLUSTERS_MAX),
        )?,
        patches: number(generate.patches.as_ref(), PATCHES_DEFAULT, "patches", (1, GENERATED_PATCHES_MAX))?,
        amount: number(generate.amount.as_ref(), PATCH_AMOUNT_DEFAULT, "amount", (0, GENERATED_AMOUNT_MAX))?,
        radius,
    })
}

fn kind(name: &Spanned<String>) -> Found<Kind> {
    name.get_ref().parse().map_err(|_| {
        let nearest = nearest(name.get_ref(), Kind::NAMES).map(str::to_owned);
        let problem =
            Problem::UnknownKind { name: name.get_ref().clone(), known: Kind::NAMES.join(", "), nearest };
        (name.span(), problem)
    })
}

fn players(seats: &Spanned<Vec<file::Seat>>) -> Found<u32> {
    let players = seats.get_ref().len();
    count(players, "the number of seats on a generated map", GENERATED_PLAYERS_MAX as usize, seats.span())?;
    Ok(u32::try_from(players).unwrap_or(GENERATED_PLAYERS_MAX))
}

/// Returns the radius of the largest unit that moves on the ground; ways for larger ones than a generator can make stay
/// as narrow as it can.
fn radius(unit_types: &[UnitType]) -> f64 {
    let mut largest = RADIUS_LEAST;
    for unit_type in unit_types {
        let moves = unit_type.speed > 0.0 && unit_type.layer == Layer::Ground;
        let radius = unit_type.shape.radius();
        if moves && radius > largest {
            largest = radius;
        }
    }
    if largest > GENERATED_RADIUS_MAX { GENERATED_RADIUS_MAX } else { largest }
}

/// Ways are made for no smaller units than these, in world units.
const RADIUS_LEAST: f64 = 0.25;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Scenario;

    const WHOLE: &str = "name = 'x'\nlength_seconds = 1\nobjective.kind = 'last_standing'\n\
        seat = [{ groups = [{ unit = 'a', count = 1 }] }, { groups = [{ unit = 'a', count = 1 }] }]\n\
        [generate]\nkind = 'maze'\nwidth = 32\nheight = 48\n\
        [unit.a]\nradius = 0.75\nspeed = 1\n\
        [unit.house]\nwidth = 4\nheight = 4\nspeed = 0\n\
        [unit.plane]\nradius = 2\nspeed = 1\nlayer = 'air'\n";

    #[test]
    fn a_map_is_asked_for_with_a_player_a_seat_and_ways_for_the_largest_unit_on_the_ground() {
        let scenario = Scenario::read("x.toml", WHOLE).unwrap();
        let request = Request {
            kind: Kind::Maze,
            width: 32,
            height: 48,
            players: 2,
            spawns: SPAWNS_DEFAULT,
            clusters: CLUSTERS_DEFAULT,
            patches: PATCHES_DEFAULT,
            amount: PATCH_AMOUNT_DEFAULT,
            radius: 0.75,
        };
        assert_eq!(scenario.map, MapSource::Generated(request));
    }

    #[test]
    fn a_wrong_request_is_told_with_its_place() {
        let check = |from: &str, to: &str, expected: &str| {
            assert!(WHOLE.contains(from), "{from}");
            let error = Scenario::read("x.toml", &WHOLE.replacen(from, to, 1)).unwrap_err().to_string();
            assert!(error.contains(expected), "{error}\n  lacks {expected}");
        };
        check("'maze'", "'mase'", "x.toml:6:8: no kind of map is called \"mase\"; did you mean `maze`?");
        check("'maze'", "'sea of sand'", "known are plain, obstacles, maze, islands, cliffs, choke");
        check("width = 32", "width = 15", "x.toml:7:9: width is 15; it must be from 16 to 512");
        check("height = 48", "", "missing field `height`");
        check("height = 48", "height = 48\nspawns = 9", "spawns is 9; it must be from 1 to 8");
        check("height = 48", "height = 48\nclusters = 65", "clusters is 65;");
        check("height = 48", "height = 48\npatches = 0", "patches is 0;");
        check("name = 'x'", "name = 'x'\nmap = 'x.map'", "x.toml:2:7: ");
        let none = WHOLE.replacen("[generate]\nkind = 'maze'\nwidth = 32\nheight = 48\n", "", 1);
        let error = Scenario::read("x.toml", &none).unwrap_err().to_string();
        assert!(error.starts_with("x.toml:1:8: map, or [generate],"), "{error}");
    }
}
