//! Large areas with few passages between them.

use super::canvas::{Canvas, Material};
use super::dice::Dice;
use super::noise::line_noise;
use super::{Request, obstacles};

/// From which length of the map on there can be a third area, in tiles.
const LENGTH_OF_THREE: i32 = 96;

/// Half of the thickness of a band between areas, in tiles, without what the noise adds on each side.
const HALF_THICKNESS: f64 = 1.5;
const ROUGHNESS: f64 = 3.0;

/// How far a band wanders to each side, in tiles, and over how many tiles.
const WANDERING: f64 = 7.0;
const PITCH: i32 = 14;

/// Over how many tiles a band comes back to the centre of a symmetric map.
const CENTRE: f64 = 8.0;

/// How much wider a passage is than the largest unit needs, in tiles.
const PASSAGE_EXTRA: (i32, i32) = (1, 3);

/// How many tiles of a band there are for each passage, about.
const TILES_A_PASSAGE: i32 = 32;

/// Blocks within the areas, in hundredths of the map.
const SCATTERED: i32 = 4;

/// Draws bands between areas with passages through them, and blocks within the areas. Returns what ways through
/// them are made of.
pub(super) fn draw(canvas: &mut Canvas, request: &Request, dice: Dice) -> Material {
    let band = Band::new(canvas, dice);
    for spot in canvas.spots() {
        if band.is_within(canvas, spot) {
            canvas.put(spot, band.material);
        }
    }
    band.open_passages(canvas, request);
    obstacles::scatter(canvas, request, dice, SCATTERED);
    Material::Ground
}

/// The bands, along the shorter axis of the map; with three areas there are two of them.
struct Band {
    dice: Dice,
    material: Material,
    /// How long the map is from area to area, and how wide across, in tiles.
    length: i32,
    width: i32,
    /// How far a band lies from the middle, in tiles.
    offset: f64,
}

impl Band {
    fn new(canvas: &Canvas, dice: Dice) -> Self {
        let (length, width) = (canvas.width().max(canvas.height()), canvas.width().min(canvas.height()));
        let is_three = length >= LENGTH_OF_THREE && dice.below("areas", 0, 2) == 0;
        let offset = if is_three { f64::from(length) / 6.0 } else { 0.0 };
        let materials = [Material::Rock, Material::Water, Material::Trees];
        let material = materials[dice.below("band", 0, 3).cast_unsigned() as usize];
        Self { dice, material, length, width, offset }
    }

    /// Returns (along, across) of a tile, from the middle of the map in half tiles.
    fn place(canvas: &Canvas, (x, y): (i32, i32)) -> (i32, i32) {
        let (along, across) = (2 * x + 1 - canvas.width(), 2 * y + 1 - canvas.height());
        if canvas.width() >= canvas.height() { (along, across) } else { (across, along) }
    }

    /// Returns the tile at (along, across) from the middle in half tiles.
    fn spot(canvas: &Canvas, (along, across): (i32, i32)) -> (i32, i32) {
        let (x, y) = if canvas.width() >= canvas.height() { (along, across) } else { (across, along) };
        ((x + canvas.width()).div_euclid(2), (y + canvas.height()).div_euclid(2))
    }

    /// Returns the middle of the first band and how far it reaches to either side, in tiles, at a place across.
    ///
    /// The half of the map before its middle says; the other half is its twin.
    fn at(&self, across: i32) -> (f64, f64, f64) {
        let tile = across.div_euclid(2);
        let wander = (line_noise(self.dice, "band wanders", tile, PITCH) - 0.5) * 2.0 * WANDERING;
        let from_middle = f64::from(across.abs()) / 2.0;
        let near_centre = if self.offset == 0.0 && from_middle < CENTRE { from_middle / CENTRE } else { 1.0 };
        let rough = |purpose| line_noise(self.dice, purpose, tile, 3) * ROUGHNESS;
        let half = HALF_THICKNESS;
        (wander * near_centre - self.offset, half + rough("band before"), half + rough("band behind"))
    }

    /// Whether a tile lies in the first band; what the canvas makes of it half a turn away is the second one, or the other
    /// half of the only one.
    fn is_within(&self, canvas: &Canvas, spot: (i32, i32)) -> bool {
        let (along, across) = Self::place(canvas, spot);
        let is_in = |along: i32, across: i32| {
            let (middle, before, behind) = self.at(across);
            let from_middle = f64::from(along) / 2.0 - middle;
            -before <= from_middle && from_middle <= behind
        };
        let is_second = !canvas.is_symmetric() && self.offset > 0.0 && is_in(-along, -across);
        let is_half = self.offset == 0.0 && canvas.is_symmetric();
        is_second || (!is_half || across <= 0) && is_in(along, across)
    }

    /// Opens the passages: straight ways along the map, from one side of the band to the other.
    fn open_passages(&self, canvas: &mut Canvas, request: &Request) {
        let is_half = self.offset == 0.0 && canvas.is_symmetric();
        let tiles = if is_half { self.width / 2 } else { self.width };
        let count = (tiles + TILES_A_PASSAGE / 2) / TILES_A_PASSAGE;
        let bands: &[i32] = if self.offset > 0.0 && !canvas.is_symmetric() { &[1, -1] } else { &[1] };
        for &side in bands {
            for number in 0..count.max(1) {
                let index = u64::from(number.cast_unsigned()) << 1 | u64::from(side < 0);
                let size =
                    request.lane().cast_signed() + self.dice.between("passage size", index, PASSAGE_EXTRA);
                // Each passage lies in a part of its own, away from the ends of it.
                let part = tiles / count.max(1);
                let within = (size.min(part / 4), (part - 1 - size.min(part / 4)).max(0));
                let across = number * part + self.dice.between("passage", index, within) - self.width / 2;
                self.open_passage(canvas, (2 * across * side, side), size);
            }
        }
    }

    fn open_passage(&self, canvas: &mut Canvas, (across, side): (i32, i32), size: i32) {
        let (middle, ..) = self.at(across * side);
        let reach = HALF_THICKNESS + ROUGHNESS + 3.0;
        let steps = (-self.length..=self.length).filter(|&along| {
            let from_middle = f64::from(along * side) / 2.0 - middle;
            -reach <= from_middle && from_middle <= reach
        });
        let ends: Vec<i32> = steps.collect();
        if let (Some(&first), Some(&last)) = (ends.first(), ends.last()) {
            let (from, to) = (Self::spot(canvas, (first, across)), Self::spot(canvas, (last, across)));
            canvas.open_way(from, to, (size, Material::Ground));
        }
    }
}
