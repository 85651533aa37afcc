//! Generated maps: whether the largest unit gets everywhere, judged by another way than the generator's; and the command.

use std::fmt::Write as _;

use glam::DVec2;
use maniple_tilemap::{Kind, Request, TileMap, generate};

use crate::commands::{fails, folder, json, run};
use crate::maps::{load, root};

/// Points of the slow check on the edge of a tile; one that moves goes from point to point.
const POINTS: u32 = 4;

/// The radius of a patch.
const PATCH_RADIUS: f64 = 0.375;

/// What rounding may take from a distance.
const ROUNDING: f64 = 1e-9;

const DUEL: Request = Request {
    kind: Kind::Plain,
    width: 64,
    height: 64,
    players: 2,
    spawns: 1,
    clusters: 5,
    patches: 6,
    amount: 1_000,
    radius: 0.5,
};

fn requests() -> impl Iterator<Item = Request> {
    let shapes = [
        DUEL,
        Request { spawns: 5, clusters: 0, ..DUEL },
        Request { height: 48, clusters: 4, ..DUEL },
        Request { width: 32, height: 32, players: 1, clusters: 4, ..DUEL },
        Request { width: 57, height: 72, clusters: 3, radius: 1.2, ..DUEL },
        Request { width: 80, height: 80, players: 4, clusters: 4, radius: 0.3, ..DUEL },
    ];
    shapes.into_iter().flat_map(|shape| Kind::ALL.map(|kind| Request { kind, ..shape }))
}

#[test]
fn the_largest_unit_gets_from_everywhere_to_everywhere_on_generated_maps() {
    for request in requests() {
        for seed in 1000..1006 {
            let map =
                generate(&request, seed).unwrap_or_else(|error| panic!("seed {seed}, {request:?}: {error}"));
            let what = format!("seed {seed}, {request:?}");
            let field = Field::of(&map, request.radius);
            let start = map.spawns()[0].position;
            let is_reached = field.flood(start);
            let is_near = |place: DVec2, distance: f64| field.near(&is_reached, place, distance);
            for spawn in map.spawns() {
                assert!(is_near(spawn.position, 0.0), "{what}: {spawn:?} cannot be reached");
            }
            for patch in map.resources() {
                let reach = request.radius + PATCH_RADIUS + 0.5;
                assert!(is_near(patch.position, reach), "{what}: {patch:?} cannot be reached");
            }
            // From the middle of a tile in the corner of a square as wide as a way to the nearest place of a unit in it.
            let beyond = if request.radius > 0.5 { (request.radius - 0.5) * 2.0_f64.sqrt() } else { 0.0 };
            let patches_near = f64::from(request.lane() + 2);
            for (x, y) in (0..map.height()).flat_map(|y| (0..map.width()).map(move |x| (x, y))) {
                let middle = DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5);
                let is_beside_patch =
                    map.resources().iter().any(|patch| (patch.position - middle).length() < patches_near);
                if map.is_passable(x, y) && !is_beside_patch {
                    assert!(is_near(middle, beyond + 0.25), "{what}: tile ({x}, {y}) cannot be reached");
                }
            }
        }
    }
}

#[test]
fn the_slow_check_finds_a_way_closed_and_a_way_open() {
    let text = |door: &str| {
        format!("type octile\nheight 5\nwidth 7\nmap\n...@...\n...@...\n{door}\n...@...\n...@...\n")
    };
    let folder = folder("slow_check");
    let check = |door: &str, radius: f64, expected: bool| {
        let file = crate::commands::file(&folder, "door.map", &text(door));
        let field = Field::of(&load(file.as_ref()), radius);
        let is_reached = field.flood(DVec2::new(1.5, 2.5));
        assert_eq!(field.near(&is_reached, DVec2::new(5.5, 2.5), 0.1), expected, "{door} {radius}");
    };
    check("...@...", 0.25, false);
    check(".......", 0.25, true);
    check(".......", 0.5, true);
    check(".......", 0.51, false);
}

#[test]
fn generated_maps_have_the_same_hash_on_every_machine() {
    let mut found = String::new();
    for kind in Kind::ALL {
        let map = generate(&Request { kind, ..DUEL }, 42).unwrap();
        writeln!(found, "{kind} {:016x}", map.hash()).unwrap();
    }
    let file = root().join("tests/golden/generated_maps.txt");
    if std::env::var("UPDATE_GOLDEN").is_ok_and(|value| value == "1") {
        std::fs::write(&file, &found).unwrap();
    }
    let expected = std::fs::read_to_string(&file).unwrap_or_default();
    assert_eq!(found, expected, "a seed gives another map; if that is meant, run with UPDATE_GOLDEN=1");
}

#[test]
fn map_generate_writes_a_map_that_is_read_back() {
    let folder = folder("map_generate");
    for kind in Kind::ALL {
        let out = folder.join(format!("{kind}.tmx")).display().to_string();
        let told = json(&[
            "map",
            "generate",
            kind.name(),
            "--seed",
            "42",
            "--clusters",
            "5",
            "--out",
            &out,
            "--json",
        ]);
        let map = load(out.as_ref());
        assert_eq!(map, generate(&Request { kind, ..DUEL }, 42).unwrap(), "{kind}");
        assert_eq!(told["hash"], format!("{:016x}", map.hash()), "{kind}");
        assert_eq!((&told["spawns"], &told["patches"]), (&2.into(), &30.into()), "{kind}");
        assert_eq!(
            (&told["width"], &told["height"], &told["seed"]),
            (&64.into(), &64.into(), &42.into()),
            "{kind}"
        );
        assert!(run(&["map", "check", &out, "--radius", "0.5"]).status.success(), "{kind}");
    }
    let out = folder.join("small.tmx").display().to_string();
    let all =
        ["map", "generate", "choke", "--seed", "1", "--size", "48x40", "--players", "1", "--spawns", "2"];
    let rest = ["--clusters", "2", "--patches", "3", "--amount", "7", "--radius", "0.8", "--out", &out];
    let text = String::from_utf8(run(&[all.as_slice(), &rest].concat()).stdout).unwrap();
    assert!(text.contains("choke, seed 1, 48 x 40 tiles") && text.contains("2 spawns, 6 patches"), "{text}");
    assert_eq!(load(out.as_ref()).resources()[0].amount, 7);
}

#[test]
fn map_generate_writes_a_moving_ai_map_of_what_it_can_hold() {
    let folder = folder("map_generate_octile");
    let out = folder.join("maze.MAP").display().to_string();
    let bare = ["map", "generate", "maze", "--seed", "1", "--players", "0", "--clusters", "0", "--out", &out];
    assert!(run(&bare).status.success());
    assert_eq!(load(out.as_ref()).width(), 64);
    let error = fails(&["map", "generate", "maze", "--seed", "1", "--out", &out], 2);
    assert!(error.contains("2 spawns, which a .map cannot hold; write a .tmx"), "{error}");
}

#[test]
fn map_generate_names_what_cannot_be_meant() {
    let folder = folder("map_generate_bad");
    let out = folder.join("bad.tmx").display().to_string();
    let check = |arguments: &[&str], code: i32, named: &str| {
        let error = fails(&[&["map", "generate"], arguments].concat(), code);
        assert!(error.contains(named), "{arguments:?}: {error}");
    };
    check(&["hills", "--seed", "1", "--out", &out], 2, "plain, obstacles, maze, islands, cliffs, choke");
    check(&["plain", "--out", &out], 2, "--seed");
    check(&["plain", "--seed", "1"], 2, "--out");
    check(&["plain", "--seed", "x", "--out", &out], 2, "--seed");
    check(&["plain", "--seed", "1", "--out", "bad.png"], 2, ".tmx (Tiled) or .map (MovingAI)");
    check(&["plain", "--seed", "1", "--out", &out, "--size", "64"], 2, "as in 64x48");
    check(&["plain", "--seed", "1", "--out", &out, "--size", "8x64"], 2, "from 16 to 512");
    check(&["plain", "--seed", "1", "--out", &out, "--players", "9"], 2, "players is 9");
    check(&["plain", "--seed", "1", "--out", &out, "--radius", "-1"], 2, "radius is -1");
    check(
        &["plain", "--seed", "1", "--out", &out, "--size", "16x16", "--spawns", "8"],
        2,
        "no room for 2 x 8 spawns",
    );
    check(&["plain", "--seed", "1", "--out", "/no/such/folder/bad.tmx"], 1, "/no/such/folder");
    assert!(!folder.join("bad.tmx").exists());
}

/// Points a quarter of a tile apart, and which of them a circle can be at and go between.
struct Field {
    columns: u32,
    rows: u32,
    /// By point: whether the circle cannot be there.
    is_point_blocked: Vec<bool>,
    /// By point and direction, right and down: whether it cannot go to the next point.
    is_step_blocked: Vec<[bool; 2]>,
}

impl Field {
    /// Tests every point, and every step between two, against each wall and patch near it.
    fn of(map: &TileMap, radius: f64) -> Self {
        let (columns, rows) = (map.width() * POINTS + 1, map.height() * POINTS + 1);
        let points = (columns * rows) as usize;
        let mut field = Self {
            columns,
            rows,
            is_point_blocked: vec![false; points],
            is_step_blocked: vec![[false; 2]; points],
        };
        for wall in map.segments() {
            field.block(wall.start, wall.end, radius);
        }
        for patch in map.resources() {
            field.block(patch.position, patch.position, radius + PATCH_RADIUS);
        }
        field
    }

    fn point(column: u32, row: u32) -> DVec2 {
        DVec2::new(f64::from(column), f64::from(row)) / f64::from(POINTS)
    }

    /// Returns the columns and rows of the points within a distance of the rectangle around two places, and some more.
    fn around(&self, start: DVec2, end: DVec2, distance: f64) -> Vec<(u32, u32)> {
        let is_near = |place: f64, from: f64, to: f64| {
            let (least, most) = if from < to { (from, to) } else { (to, from) };
            (least - distance - 0.5..=most + distance + 0.5).contains(&place)
        };
        let columns: Vec<u32> =
            (0..self.columns).filter(|&column| is_near(Self::point(column, 0).x, start.x, end.x)).collect();
        let rows = (0..self.rows).filter(|&row| is_near(Self::point(0, row).y, start.y, end.y));
        rows.flat_map(|row| columns.iter().map(move |&column| (column, row))).collect()
    }

    fn block(&mut self, start: DVec2, end: DVec2, distance: f64) {
        let least = distance - ROUNDING;
        for (column, row) in self.around(start, end, distance) {
            let index = (row * self.columns + column) as usize;
            let point = Self::point(column, row);
            self.is_point_blocked[index] |= to_segment(point, start, end) < least;
            for (direction, next) in [(0, (column + 1, row)), (1, (column, row + 1))] {
                let next = Self::point(next.0, next.1);
                // A step that does not cross the wall is nearest to it at an end of one of the two.
                let nearest = to_segment(start, point, next) < least || to_segment(end, point, next) < least;
                self.is_step_blocked[index][direction] |= nearest;
            }
        }
    }

    /// Returns which points the circle gets to.
    fn flood(&self, start: DVec2) -> Vec<bool> {
        let mut is_reached = vec![false; self.is_point_blocked.len()];
        let mut waiting = Vec::new();
        for (column, row) in self.around(start, start, 0.0) {
            let index = (row * self.columns + column) as usize;
            if Self::point(column, row) == start && !self.is_point_blocked[index] {
                is_reached[index] = true;
                waiting.push((column, row));
            }
        }
        while let Some((column, row)) = waiting.pop() {
            let steps = [
                ((column + 1, row), (column, row), 0),
                ((column, row + 1), (column, row), 1),
                ((column.wrapping_sub(1), row), (column.wrapping_sub(1), row), 0),
                ((column, row.wrapping_sub(1)), (column, row.wrapping_sub(1)), 1),
            ];
            for ((column, row), from, direction) in steps {
                if column >= self.columns || row >= self.rows {
                    continue;
                }
                let index = (row * self.columns + column) as usize;
                let is_blocked = self.is_step_blocked[(from.1 * self.columns + from.0) as usize][direction];
                if !is_blocked && !self.is_point_blocked[index] && !is_reached[index] {
                    is_reached[index] = true;
                    waiting.push((column, row));
                }
            }
        }
        is_reached
    }

    /// Whether a point that is reached lies within a distance of a place.
    fn near(&self, is_reached: &[bool], place: DVec2, distance: f64) -> bool {
        self.around(place, place, distance).into_iter().any(|(column, row)| {
            let apart = (Self::point(column, row) - place).length();
            apart <= distance && is_reached[(row * self.columns + column) as usize]
        })
    }
}

/// Returns the distance of a point from a segment, which may be a point itself.
fn to_segment(point: DVec2, start: DVec2, end: DVec2) -> f64 {
    let (along, offset) = (end - start, point - start);
    let square = along.length_squared();
    let share = if square == 0.0 { 0.0 } else { (offset.dot(along) / square).clamp(0.0, 1.0) };
    (offset - along * share).length()
}
