//! The ground while it is drawn.

/// Column and row; they may lie outside of the map.
pub(super) type Spot = (i32, i32);

/// What a tile is made of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Material {
    /// Open.
    Ground,
    /// Open: a way through the water.
    Ford,
    /// Open: a way through a ridge.
    Ramp,
    /// Blocked.
    Rock,
    /// Blocked.
    Trees,
    /// Blocked.
    Water,
}

impl Material {
    pub(super) fn is_open(self) -> bool {
        match self {
            Self::Ground | Self::Ford | Self::Ramp => true,
            Self::Rock | Self::Trees | Self::Water => false,
        }
    }

    /// Returns the name of the terrain.
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Ground => "ground",
            Self::Ford => "ford",
            Self::Ramp => "ramp",
            Self::Rock => "rock",
            Self::Trees => "trees",
            Self::Water => "water",
        }
    }
}

/// The tiles of a map to draw on. On a symmetric one, whatever is drawn is drawn again half a turn away.
#[derive(Clone, Debug)]
pub(super) struct Canvas {
    width: i32,
    height: i32,
    is_symmetric: bool,
    materials: Vec<Material>,
    /// Which tiles have to stay open.
    is_kept: Vec<bool>,
}

impl Canvas {
    /// Returns open ground; the size has been checked.
    pub(super) fn new(width: u32, height: u32, is_symmetric: bool) -> Self {
        let tiles = width as usize * height as usize;
        Self {
            width: width.cast_signed(),
            height: height.cast_signed(),
            is_symmetric,
            materials: vec![Material::Ground; tiles],
            is_kept: vec![false; tiles],
        }
    }

    /// Keeps the tiles from `min` up to but without `max` open; they may reach over the edge of the map.
    pub(super) fn keep(&mut self, min: Spot, max: Spot) {
        for spot in square(min, max) {
            if self.is_inside(spot) {
                let index = self.index(spot);
                self.is_kept[index] = true;
            }
        }
    }

    /// Sets a tile and its twin; nothing outside of the map, and nothing blocked where it has to stay open.
    pub(super) fn put(&mut self, spot: Spot, material: Material) {
        if !self.is_inside(spot) {
            return;
        }
        for spot in [spot, self.twin(spot)] {
            let index = self.index(spot);
            if material.is_open() || !self.is_kept[index] {
                self.materials[index] = material;
            }
        }
    }

    /// Opens what is blocked of the square of `size` tiles with its upper left tile at `spot`.
    pub(super) fn open(&mut self, spot: Spot, size: i32, material: Material) {
        for spot in square(spot, (spot.0 + size, spot.1 + size)) {
            if !self.is_open(spot) {
                self.put(spot, material);
            }
        }
    }

    /// Opens a way of squares from one spot to another, each beside the one before over an edge.
    pub(super) fn open_way(&mut self, from: Spot, to: Spot, (size, material): (i32, Material)) {
        let mut spot = (from.0 - size / 2, from.1 - size / 2);
        let goal = (to.0 - size / 2, to.1 - size / 2);
        let (across, down) = (goal.0 - spot.0, goal.1 - spot.1);
        self.open(spot, size, material);
        while spot != goal {
            let (left, rest) = ((goal.0 - spot.0).abs(), (goal.1 - spot.1).abs());
            // The axis with the larger share of its way still to go.
            if left * down.abs() >= rest * across.abs() && left > 0 {
                spot.0 += (goal.0 - spot.0).signum();
            } else {
                spot.1 += (goal.1 - spot.1).signum();
            }
            self.open(spot, size, material);
        }
    }

    pub(super) fn width(&self) -> i32 {
        self.width
    }

    pub(super) fn height(&self) -> i32 {
        self.height
    }

    pub(super) fn is_symmetric(&self) -> bool {
        self.is_symmetric
    }

    /// Returns the tile that has to be like this one: half a turn away, or itself on a map without symmetry.
    pub(super) fn twin(&self, (x, y): Spot) -> Spot {
        if self.is_symmetric { (self.width - 1 - x, self.height - 1 - y) } else { (x, y) }
    }

    /// Returns a number that a tile shares with its twin only.
    pub(super) fn key(&self, spot: Spot) -> u64 {
        self.index(spot).min(self.index(self.twin(spot))) as u64
    }

    pub(super) fn is_inside(&self, (x, y): Spot) -> bool {
        (0..self.width).contains(&x) && (0..self.height).contains(&y)
    }

    /// Returns the place of a tile of the map in a list of all tiles, row by row.
    pub(super) fn index(&self, (x, y): Spot) -> usize {
        (y * self.width + x).cast_unsigned() as usize
    }

    /// Returns what a tile is made of; outside of the map it is rock.
    pub(super) fn material(&self, spot: Spot) -> Material {
        if self.is_inside(spot) { self.materials[self.index(spot)] } else { Material::Rock }
    }

    pub(super) fn is_open(&self, spot: Spot) -> bool {
        self.material(spot).is_open()
    }

    /// Whether a tile of the map has to stay open.
    pub(super) fn is_kept(&self, spot: Spot) -> bool {
        self.is_inside(spot) && self.is_kept[self.index(spot)]
    }

    /// Returns how many tiles are blocked.
    pub(super) fn blocked(&self) -> i32 {
        let blocked = self.materials.iter().filter(|material| !material.is_open()).count();
        i32::try_from(blocked).unwrap_or(i32::MAX)
    }

    /// Returns all tiles row by row.
    pub(super) fn spots(&self) -> impl Iterator<Item = Spot> + use<> {
        square((0, 0), (self.width, self.height))
    }
}

/// Returns the tiles from `min` up to but without `max`, row by row.
pub(super) fn square(min: Spot, max: Spot) -> impl Iterator<Item = Spot> {
    (min.1..max.1).flat_map(move |y| (min.0..max.0).map(move |x| (x, y)))
}
