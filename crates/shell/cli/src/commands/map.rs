//! `maniple map`: what a map is like, and maps from a seed.

mod generate;

use std::fmt::Write as _;

use maniple_tilemap::{FindingKind, TileMap, check, loops, regions};
use serde::Serialize;

use crate::arguments::{MapCheck, MapCommand, MapInfo, MapRender};
use crate::failure::Failure;
use crate::files;
use crate::output::{Format, grouped, print};
use crate::picture::Picture;

/// Runs `maniple map`.
pub(crate) fn run(command: &MapCommand) -> Result<(), Failure> {
    match command {
        MapCommand::Info(arguments) => info(arguments),
        MapCommand::Check(arguments) => checked(arguments),
        MapCommand::Render(arguments) => render(arguments),
        MapCommand::Generate(arguments) => generate::run(arguments),
    }
}

/// The figures of a map.
#[derive(Debug, Serialize)]
struct Info {
    width: u32,
    height: u32,
    passable_tiles: u64,
    segments: usize,
    /// Tile edges.
    wall_length: f64,
    loops: usize,
    /// 4-connected regions of passable tiles.
    regions: usize,
    largest_region_tiles: u32,
    spawns: usize,
}

impl Info {
    fn of(map: &TileMap) -> Self {
        let segments = map.segments();
        let regions = regions(map);
        let tiles = (0..map.height()).flat_map(|y| (0..map.width()).map(move |x| (x, y)));
        Self {
            width: map.width(),
            height: map.height(),
            passable_tiles: tiles.filter(|&(x, y)| map.is_passable(x, y)).count() as u64,
            segments: segments.len(),
            wall_length: segments.iter().map(maniple_geometry::Segment::length).sum::<f64>() + 0.0,
            loops: loops(&map.border()),
            regions: regions.count(),
            largest_region_tiles: regions.sizes().iter().copied().max().unwrap_or(0),
            spawns: map.spawns().len(),
        }
    }

    fn text(&self) -> String {
        format!(
            "{} x {} tiles, {} of them passable\n\
             {} wall segments, {:.1} tile edges long, in {} loops\n\
             {} regions, the largest with {} tiles\n\
             {} spawns\n",
            self.width,
            self.height,
            grouped(self.passable_tiles),
            grouped(self.segments as u64),
            self.wall_length,
            grouped(self.loops as u64),
            grouped(self.regions as u64),
            grouped(u64::from(self.largest_region_tiles)),
            self.spawns,
        )
    }
}

fn info(arguments: &MapInfo) -> Result<(), Failure> {
    let map = files::map(&arguments.file)?;
    print(Format::of(&arguments.json), &Info::of(&map), Info::text)
}

/// One finding, as it is printed.
#[derive(Debug, Serialize)]
struct Finding {
    kind: String,
    x: u32,
    y: u32,
    text: String,
}

impl Finding {
    fn of(finding: maniple_tilemap::Finding) -> Self {
        Self {
            kind: snake_case(&format!("{:?}", finding.kind)),
            x: finding.tile.0,
            y: finding.tile.1,
            text: finding.text,
        }
    }
}

#[derive(Debug, Serialize)]
struct Findings {
    findings: Vec<Finding>,
    foreign_objects: usize,
    /// The foreign objects. To ignore them is what a map of another game asks for, so they are no failure.
    ignored: Vec<Finding>,
}

impl Findings {
    fn of(map: &TileMap, radius: Option<f64>) -> Self {
        let (ignored, odd): (Vec<_>, Vec<_>) =
            check(map, radius).into_iter().partition(|finding| finding.kind == FindingKind::ForeignObject);
        let printed =
            |findings: Vec<maniple_tilemap::Finding>| findings.into_iter().map(Finding::of).collect();
        Self { findings: printed(odd), foreign_objects: ignored.len(), ignored: printed(ignored) }
    }

    fn text(&self) -> String {
        let mut text = String::new();
        for finding in self.findings.iter().chain(&self.ignored) {
            let _ = writeln!(text, "tile ({}, {}): {}", finding.x, finding.y, finding.text);
        }
        if self.findings.is_empty() {
            text += "nothing odd\n";
        }
        let _ = writeln!(text, "foreign_objects: {}", self.foreign_objects);
        text
    }
}

fn checked(arguments: &MapCheck) -> Result<(), Failure> {
    let map = files::map(&arguments.file)?;
    let found = Findings::of(&map, arguments.radius);
    print(Format::of(&arguments.json), &found, Findings::text)?;
    match found.findings.len() {
        0 => Ok(()),
        1 => Err(Failure::failed(anyhow::Error::msg("1 finding"))),
        count => Err(Failure::failed(anyhow::anyhow!("{count} findings"))),
    }
}

fn render(arguments: &MapRender) -> Result<(), Failure> {
    let map = files::map(&arguments.file)?;
    let mut picture = Picture::of(&map, arguments.scale)?;
    picture.draw_resources(map.resources());
    picture.draw_spawns(map.spawns());
    files::write(&arguments.out, &picture.png()?)
}

fn snake_case(name: &str) -> String {
    let mut text = String::new();
    for letter in name.chars() {
        if letter.is_ascii_uppercase() && !text.is_empty() {
            text.push('_');
        }
        text.push(letter.to_ascii_lowercase());
    }
    text
}
