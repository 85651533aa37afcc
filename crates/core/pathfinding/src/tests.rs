//! Tests of the whole crate: paths are walked by the kinematics, and every fast answer has a slow obvious twin.

mod controller;
mod crowds;
mod errors;
mod formations;
mod obstacles;
mod optimum;
pub(crate) mod real;
pub(crate) mod release;
mod search;
mod tangents;
mod trial;
mod trouble;
mod twins;
mod walk;

use glam::DVec2;
use maniple_tilemap::{Kind, Request, Resolver, TileMap, generate, read};

use crate::Ground;

/// Random numbers from a seed: splitmix64 (Steele, Lea and Flood, 2014).
pub(crate) struct Dice(pub(crate) u64);

impl Dice {
    pub(crate) fn roll(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mixed = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        mixed ^ (mixed >> 31)
    }

    /// A number of `0.0..1.0`.
    pub(crate) fn share(&mut self) -> f64 {
        (self.roll() >> 11) as f64 / (1u64 << 53) as f64
    }

    /// A point of the map.
    pub(crate) fn point(&mut self, map: &TileMap) -> DVec2 {
        DVec2::new(self.share() * f64::from(map.width()), self.share() * f64::from(map.height()))
    }

    /// A point that holds the circle.
    pub(crate) fn place(&mut self, map: &TileMap, ground: &Ground) -> DVec2 {
        for _ in 0..100_000 {
            let point = self.point(map);
            if ground.holds(point) {
                return point;
            }
        }
        panic!("nowhere is room")
    }
}

/// No file refers to another.
pub(crate) struct Nothing;

impl Resolver for Nothing {
    fn resolve(&self, path: &str) -> Result<Vec<u8>, String> {
        Err(format!("there is no {path}"))
    }
}

/// A generated map of a kind with ways for a radius.
pub(crate) fn generated(kind: Kind, side: u32, radius: f64, seed: u64) -> TileMap {
    let request = Request {
        kind,
        width: side,
        height: side,
        players: 2,
        spawns: 1,
        clusters: 0,
        patches: 1,
        amount: 0,
        radius,
    };
    generate(&request, seed).unwrap()
}

/// A map as MovingAI writes it: `.` is open.
pub(crate) fn drawn(rows: &[&str]) -> TileMap {
    let size = format!("type octile\nheight {}\nwidth {}\nmap\n", rows.len(), rows[0].len());
    read("drawn.map", (size + &rows.join("\n") + "\n").as_bytes(), &Nothing).unwrap()
}

/// A map of random tiles, of which a share is blocked.
pub(crate) fn scattered(dice: &mut Dice, side: u32, blocked: f64) -> TileMap {
    let mut row =
        || -> String { (0..side).map(|_| if dice.share() < blocked { '@' } else { '.' }).collect() };
    let rows: Vec<String> = (0..side).map(|_| row()).collect();
    drawn(&rows.iter().map(String::as_str).collect::<Vec<_>>())
}

/// A map with a random part of half-blocked tiles and free walls, by way of Tiled's format.
pub(crate) fn slanted(dice: &mut Dice, side: u32) -> TileMap {
    let tile = |(id, corner)| {
        format!(
            "<tile id=\"{id}\"><properties><property name=\"diagonal\" value=\"{corner}\"/></properties></tile>"
        )
    };
    let open = "<tile id=\"0\"><properties><property name=\"terrain\" value=\"grass\"/></properties></tile>";
    let tiles: String = (1..).zip(["nw", "ne", "sw", "se"]).map(tile).collect();
    let data: Vec<String> = (0..side * side)
        .map(|_| if dice.share() < 0.1 { (2 + dice.roll() % 4).to_string() } else { "1".to_owned() })
        .collect();
    let text = format!(
        "<map version=\"1.10\" orientation=\"orthogonal\" renderorder=\"right-down\" width=\"{side}\" height=\"{side}\" \
         tilewidth=\"32\" tileheight=\"32\" infinite=\"0\"><tileset firstgid=\"1\" name=\"t\" tilewidth=\"32\" \
         tileheight=\"32\" tilecount=\"5\" columns=\"5\">{open}{tiles}</tileset>\
         <layer id=\"1\" name=\"ground\" width=\"{side}\" height=\"{side}\"><data encoding=\"csv\">{}</data></layer>\
         <objectgroup id=\"2\" name=\"walls\">{}</objectgroup></map>",
        data.join(","),
        walls(dice, side)
    );
    read("slanted.tmx", text.as_bytes(), &Nothing).unwrap()
}

fn walls(dice: &mut Dice, side: u32) -> String {
    let mut wall = |id: u32| {
        let mut number = || dice.share() * 32.0 * f64::from(side);
        let (x, y, to_x, to_y) = (number(), number(), number() / 8.0, number() / 8.0);
        let (to_x, to_y) = (
            if x + to_x > 32.0 * f64::from(side) { -to_x } else { to_x },
            if y + to_y > 32.0 * f64::from(side) { -to_y } else { to_y },
        );
        format!(
            "<object id=\"{id}\" type=\"wall\" x=\"{x}\" y=\"{y}\"><polyline points=\"0,0 {to_x},{to_y}\"/></object>"
        )
    };
    (1..4).map(&mut wall).collect()
}
