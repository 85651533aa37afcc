//! Pictures of maps and matches.

use anyhow::anyhow;
use glam::DVec2;
use maniple_geometry::Segment;
use maniple_tilemap::{Corner, Resource, Spawn, TileMap, TileShape};
use maniple_view::{Seat, Shape, View, Zone};
use tiny_skia::{
    Color, FillRule, LineCap, Paint, PathBuilder, Pixmap, PremultipliedColorU8, Rect, Stroke, Transform,
};

use crate::failure::Failure;

/// Pixels along the longer side where no scale is asked for.
const SIZE_WANTED: u32 = 1024;

/// Most pixels along a side: 8192, 256 MiB for a square.
const SIZE_MAX: u32 = 8192;

/// Colours of the seats, told apart by people who see colours differently too (Okabe and Ito, 2008).
const SEATS: [[u8; 3]; 8] = [
    [0, 114, 178],
    [213, 94, 0],
    [0, 158, 115],
    [204, 121, 167],
    [230, 159, 0],
    [86, 180, 233],
    [240, 228, 66],
    [120, 120, 120],
];

/// The colour of what belongs to nobody.
const NOBODY: [u8; 3] = [250, 250, 250];

const GROUND: [u8; 3] = [236, 232, 220];
const ROCK: [u8; 3] = [74, 78, 86];
const WALL: [u8; 3] = [20, 22, 26];
const WATER: [u8; 3] = [70, 112, 150];
const TREES: [u8; 3] = [66, 96, 66];
const FORD: [u8; 3] = [196, 206, 200];
const RAMP: [u8; 3] = [214, 200, 172];
const CRYSTAL: [u8; 3] = [150, 220, 225];
const SHROUD: [u8; 3] = [0, 0, 0];

/// The radius in which a resource is drawn, in tiles.
const RESOURCE_RADIUS: f64 = 0.375;

/// A picture of a map, to draw on. Drawing is in world units.
pub(crate) struct Picture {
    pixels: Pixmap,
    /// Pixels a world unit.
    scale: f32,
}

impl Picture {
    /// Draws the tiles and walls of a map; `scale` is in pixels a tile.
    pub(crate) fn of(map: &TileMap, scale: Option<u32>) -> Result<Self, Failure> {
        let mut picture = Self::blank(map, scale)?;
        picture.draw_tiles(map);
        let wall = |wall: &Segment| (wall.start.x, wall.start.y, wall.end.x, wall.end.y);
        picture.draw_walls(map.segments().iter().map(wall));
        Ok(picture)
    }

    /// Draws the tiles and walls of a map as far as a view knows them: fog is dark, shroud is black.
    pub(crate) fn of_view(map: &TileMap, view: &View, scale: Option<u32>) -> Result<Self, Failure> {
        let mut picture = Self::blank(map, scale)?;
        picture.draw_tiles(map);
        let edge = picture.edge(map);
        for y in 0..map.height() {
            for x in 0..map.width() {
                if view.terrain().tile(x, y).is_none() {
                    picture.fill_tile((x, y), edge, SHROUD);
                } else if !view.is_visible(x, y) {
                    picture.darken_tile((x, y), edge);
                }
            }
        }
        picture.draw_walls(view.terrain().segments.iter().copied());
        Ok(picture)
    }

    fn blank(map: &TileMap, scale: Option<u32>) -> Result<Self, Failure> {
        let longer = map.width().max(map.height());
        let scale = scale.unwrap_or_else(|| (SIZE_WANTED / longer).clamp(1, 32));
        let size = |tiles: u32| tiles.checked_mul(scale).filter(|&pixels| pixels <= SIZE_MAX);
        let pixels = size(map.width()).zip(size(map.height())).and_then(|(w, h)| Pixmap::new(w, h));
        let pixels = pixels.ok_or_else(|| {
            let largest = SIZE_MAX / longer;
            Failure::usage(format!(
                "--scale {scale}: the picture would have more than {SIZE_MAX} pixels along a side; \
                 the largest scale for this map is {largest}"
            ))
        })?;
        Ok(Self { pixels, scale: float(f64::from(scale)) })
    }

    /// Draws where seats begin.
    pub(crate) fn draw_spawns(&mut self, spawns: &[Spawn]) {
        for spawn in spawns {
            let seat = u16::try_from(spawn.player).unwrap_or(u16::MAX);
            self.draw_object(spawn.position, Shape::Circle { radius: 0.5 }, Some(Seat(seat)));
        }
    }

    /// Draws what can be gathered.
    pub(crate) fn draw_resources(&mut self, resources: &[Resource]) {
        for resource in resources {
            self.draw_shape(resource.position, Shape::Circle { radius: RESOURCE_RADIUS }, CRYSTAL);
        }
    }

    /// Draws the zone of a seat, transparent.
    pub(crate) fn draw_zone(&mut self, zone: &Zone) {
        let [red, green, blue] = color_of(zone.seat.0);
        let mut paint = Paint::default();
        paint.set_color_rgba8(red, green, blue, 70);
        let (min, max) = (zone.min, zone.max);
        if let Some(rectangle) = Rect::from_ltrb(float(min.x), float(min.y), float(max.x), float(max.y)) {
            self.pixels.fill_rect(rectangle, &paint, self.transform(), None);
        }
    }

    /// Draws an object of a seat; `None`: of nobody.
    pub(crate) fn draw_object(&mut self, center: DVec2, shape: Shape, owner: Option<Seat>) {
        self.draw_shape(center, shape, owner.map_or(NOBODY, |seat| color_of(seat.0)));
    }

    fn draw_shape(&mut self, center: DVec2, shape: Shape, color: [u8; 3]) {
        let (path, line) = match shape {
            Shape::Circle { radius } => {
                let path = PathBuilder::from_circle(float(center.x), float(center.y), float(radius));
                (path, radius * 0.2)
            }
            Shape::Rectangle { width, height } => {
                let (min, max) = (center - shape.half(), center + shape.half());
                let rectangle = Rect::from_ltrb(float(min.x), float(min.y), float(max.x), float(max.y));
                (rectangle.map(PathBuilder::from_rect), width.min(height) * 0.05)
            }
        };
        let Some(path) = path else { return };
        let transform = self.transform();
        self.pixels.fill_path(&path, &solid(color), FillRule::Winding, transform, None);
        let stroke = Stroke { width: float(line), ..Stroke::default() };
        self.pixels.stroke_path(&path, &solid(WALL), &stroke, transform, None);
    }

    /// Returns the picture as a PNG file.
    pub(crate) fn png(&self) -> Result<Vec<u8>, Failure> {
        self.pixels.encode_png().map_err(|error| Failure::failed(anyhow!("the picture: {error}")))
    }

    fn draw_tiles(&mut self, map: &TileMap) {
        self.pixels.fill(Color::from_rgba8(GROUND[0], GROUND[1], GROUND[2], 255));
        let edge = self.edge(map);
        for y in 0..map.height() {
            for x in 0..map.width() {
                let tile = map.tile(x, y);
                let terrain = map.terrains()[tile.terrain as usize].as_str();
                match tile.shape {
                    TileShape::Open => match terrain {
                        "ford" => self.fill_tile((x, y), edge, FORD),
                        "ramp" => self.fill_tile((x, y), edge, RAMP),
                        _ => {}
                    },
                    TileShape::Blocked => self.fill_tile((x, y), edge, blocked_color(terrain)),
                    TileShape::Diagonal(corner) => self.draw_triangle((x, y), corner),
                }
            }
        }
    }

    /// Returns the pixels along the edge of a tile.
    fn edge(&self, map: &TileMap) -> usize {
        self.pixels.width() as usize / map.width() as usize
    }

    /// Fills a tile of `edge` x `edge` pixels.
    fn fill_tile(&mut self, tile: (u32, u32), edge: usize, [red, green, blue]: [u8; 3]) {
        let color = PremultipliedColorU8::from_rgba(red, green, blue, 255);
        let color = color.unwrap_or(PremultipliedColorU8::TRANSPARENT);
        self.change_tile(tile, edge, |_| color);
    }

    /// Darkens a tile of `edge` x `edge` pixels.
    fn darken_tile(&mut self, tile: (u32, u32), edge: usize) {
        self.change_tile(tile, edge, |before| {
            let [red, green, blue] = [before.red() / 2, before.green() / 2, before.blue() / 2];
            PremultipliedColorU8::from_rgba(red, green, blue, before.alpha()).unwrap_or(before)
        });
    }

    fn change_tile(
        &mut self,
        (x, y): (u32, u32),
        edge: usize,
        change: impl Fn(PremultipliedColorU8) -> PremultipliedColorU8,
    ) {
        let width = self.pixels.width() as usize;
        let (left, top) = (x as usize * edge, y as usize * edge);
        for row in top..top + edge {
            let start = row * width + left;
            for pixel in &mut self.pixels.pixels_mut()[start..start + edge] {
                *pixel = change(*pixel);
            }
        }
    }

    fn draw_triangle(&mut self, (x, y): (u32, u32), blocked: Corner) {
        let (x, y) = (float(f64::from(x)), float(f64::from(y)));
        let corners = [(x, y), (x + 1.0, y), (x + 1.0, y + 1.0), (x, y + 1.0)];
        let opposite = match blocked {
            Corner::Northwest => 2,
            Corner::Northeast => 3,
            Corner::Southeast => 0,
            Corner::Southwest => 1,
        };
        let mut path = PathBuilder::new();
        let mut rest = (0..4).filter(|&place| place != opposite).map(|place| corners[place]);
        if let Some((x, y)) = rest.next() {
            path.move_to(x, y);
        }
        for (x, y) in rest {
            path.line_to(x, y);
        }
        path.close();
        if let Some(path) = path.finish() {
            let transform = self.transform();
            self.pixels.fill_path(&path, &solid(ROCK), FillRule::Winding, transform, None);
        }
    }

    /// Draws walls as x1, y1, x2, y2.
    fn draw_walls(&mut self, walls: impl Iterator<Item = (f64, f64, f64, f64)>) {
        let mut path = PathBuilder::new();
        for (x1, y1, x2, y2) in walls {
            path.move_to(float(x1), float(y1));
            path.line_to(float(x2), float(y2));
        }
        let pixels_wide = (self.scale * 0.12).max(1.0);
        let stroke =
            Stroke { width: pixels_wide / self.scale, line_cap: LineCap::Square, ..Stroke::default() };
        if let Some(path) = path.finish() {
            let transform = self.transform();
            self.pixels.stroke_path(&path, &solid(WALL), &stroke, transform, None);
        }
    }

    fn transform(&self) -> Transform {
        Transform::from_scale(self.scale, self.scale)
    }
}

fn blocked_color(terrain: &str) -> [u8; 3] {
    match terrain {
        "water" => WATER,
        "trees" => TREES,
        _ => ROCK,
    }
}

fn color_of(seat: u16) -> [u8; 3] {
    SEATS[usize::from(seat) % SEATS.len()]
}

fn solid([red, green, blue]: [u8; 3]) -> Paint<'static> {
    let mut paint = Paint { anti_alias: true, ..Paint::default() };
    paint.set_color_rgba8(red, green, blue, 255);
    paint
}

#[expect(clippy::cast_possible_truncation, reason = "a picture needs no more than single precision")]
fn float(number: f64) -> f32 {
    number as f32
}
