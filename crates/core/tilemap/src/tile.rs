//! One square of the map.

/// A corner of a tile, as seen on a screen (y points down).
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Corner {
    /// Top left.
    Northwest,
    /// Top right.
    Northeast,
    /// Bottom left.
    Southwest,
    /// Bottom right.
    Southeast,
}

impl Corner {
    /// Returns the short name.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Northwest => "nw",
            Self::Northeast => "ne",
            Self::Southwest => "sw",
            Self::Southeast => "se",
        }
    }

    /// Returns the corner that the short name `nw`, `ne`, `sw` or `se` stands for; `None` for any other text.
    pub(crate) fn from_name(name: &str) -> Option<Self> {
        match name {
            "nw" => Some(Self::Northwest),
            "ne" => Some(Self::Northeast),
            "sw" => Some(Self::Southwest),
            "se" => Some(Self::Southeast),
            _ => None,
        }
    }

    /// Returns where the corner goes when the tile is mirrored at its diagonal from top left to bottom right.
    pub(crate) fn transposed(self) -> Self {
        match self {
            Self::Northwest => Self::Northwest,
            Self::Northeast => Self::Southwest,
            Self::Southwest => Self::Northeast,
            Self::Southeast => Self::Southeast,
        }
    }

    /// Returns where the corner goes when left and right are swapped.
    pub(crate) fn flipped_horizontally(self) -> Self {
        match self {
            Self::Northwest => Self::Northeast,
            Self::Northeast => Self::Northwest,
            Self::Southwest => Self::Southeast,
            Self::Southeast => Self::Southwest,
        }
    }

    /// Returns where the corner goes when top and bottom are swapped.
    pub(crate) fn flipped_vertically(self) -> Self {
        match self {
            Self::Northwest => Self::Southwest,
            Self::Northeast => Self::Southeast,
            Self::Southwest => Self::Northwest,
            Self::Southeast => Self::Northeast,
        }
    }
}

/// Which part of a tile is blocked.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum TileShape {
    /// Nothing is blocked.
    Open,
    /// All of it is blocked.
    Blocked,
    /// The triangle at this corner is blocked, half of the tile; its hypotenuse is a wall.
    Diagonal(Corner),
}

impl TileShape {
    /// Returns what is blocked where two layers lie on top of each other.
    ///
    /// Triangles at two different corners block the whole tile: what they leave open is at most a quarter of it.
    pub(crate) fn united(self, other: Self) -> Self {
        match (self, other) {
            (Self::Open, shape) | (shape, Self::Open) => shape,
            (Self::Diagonal(a), Self::Diagonal(b)) if a == b => self,
            (Self::Blocked | Self::Diagonal(_), Self::Blocked | Self::Diagonal(_)) => Self::Blocked,
        }
    }

    /// Returns whether the tile is blocked along its upper edge.
    pub(crate) fn blocks_north(self) -> bool {
        match self {
            Self::Open => false,
            Self::Blocked => true,
            Self::Diagonal(corner) => matches!(corner, Corner::Northwest | Corner::Northeast),
        }
    }

    /// Returns whether the tile is blocked along its lower edge.
    pub(crate) fn blocks_south(self) -> bool {
        match self {
            Self::Open => false,
            Self::Blocked => true,
            Self::Diagonal(corner) => matches!(corner, Corner::Southwest | Corner::Southeast),
        }
    }

    /// Returns whether the tile is blocked along its left edge.
    pub(crate) fn blocks_west(self) -> bool {
        match self {
            Self::Open => false,
            Self::Blocked => true,
            Self::Diagonal(corner) => matches!(corner, Corner::Northwest | Corner::Southwest),
        }
    }

    /// Returns whether the tile is blocked along its right edge.
    pub(crate) fn blocks_east(self) -> bool {
        match self {
            Self::Open => false,
            Self::Blocked => true,
            Self::Diagonal(corner) => matches!(corner, Corner::Northeast | Corner::Southeast),
        }
    }
}

/// A square of the map.
#[doc(alias = "cell")]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Tile {
    /// What of it is blocked.
    pub shape: TileShape,
    /// The index of its terrain's name in [`crate::TileMap::terrains`].
    pub terrain: u8,
}
