//! The settings that are compared.

use maniple_kinematics::{Method, Settings, Stops};
use serde::Serialize;

/// The numbers that a world is kept in.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub(super) enum Precision {
    F64,
    F32,
}

impl Precision {
    pub(super) fn text(self) -> &'static str {
        match self {
            Self::F64 => "f64",
            Self::F32 => "f32",
        }
    }
}

/// How positions are sent.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Positions {
    /// As the doubles that they are.
    Exact,
    /// As multiples of 2 to minus this power.
    Grid(u8),
}

impl Positions {
    pub(super) fn text(self) -> String {
        match self {
            Self::Exact => "exact".to_owned(),
            Self::Grid(bits) => format!("2^-{bits}"),
        }
    }

    /// Returns what a client gets of a coordinate.
    pub(super) fn seen(self, coordinate: f64) -> f64 {
        match self {
            Self::Exact => coordinate,
            Self::Grid(bits) => {
                let lines = f64::from(1u32 << bits);
                (coordinate * lines + 0.5).floor() / lines
            }
        }
    }

    /// Returns how many bytes a coordinate takes: a double has 8; the number of a line is a varint (`docs/PROTOCOL.md`), with the
    /// sign in its lowest bit (zigzag).
    pub(super) fn bytes(self, coordinate: f64) -> u64 {
        match self {
            Self::Exact => 8,
            Self::Grid(bits) => {
                let line = (coordinate * f64::from(1u32 << bits) + 0.5).floor();
                let zigzag = if line < 0.0 { -2.0 * line - 1.0 } else { 2.0 * line };
                if zigzag <= 250.0 {
                    1
                } else if zigzag <= f64::from(u16::MAX) {
                    3
                } else if zigzag <= f64::from(u32::MAX) {
                    5
                } else {
                    9
                }
            }
        }
    }
}

/// A setting.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Setting {
    /// What it is called in the table and in the picture.
    pub(super) label: &'static str,
    pub(super) precision: Precision,
    pub(super) method: Method,
    pub(super) certify: bool,
    /// World units; `None` for the one that follows from the limits.
    pub(super) skin: Option<f64>,
    /// How many base cycles a cycle lasts.
    pub(super) stretch: u8,
    pub(super) positions: Positions,
}

/// The one that keeps all promises; all others are compared with it.
const EXACT: Setting = Setting {
    label: "exact",
    precision: Precision::F64,
    method: Method::Event,
    certify: true,
    skin: None,
    stretch: 1,
    positions: Positions::Exact,
};

/// What most engines do.
const fn stepped(label: &'static str, substeps: u32) -> Setting {
    Setting { label, method: Method::Stepped { substeps }, certify: false, ..EXACT }
}

impl Setting {
    /// Not the whole product, which would be 480, but each knob turned alone, and what one would combine.
    pub(super) const ALL: [Self; 20] = [
        EXACT,
        Self { label: "uncertified", certify: false, ..EXACT },
        Self { label: "f32", precision: Precision::F32, ..EXACT },
        Self { label: "f32 uncertified", precision: Precision::F32, certify: false, ..EXACT },
        Self { label: "skin 1e-6", skin: Some(1e-6), ..EXACT },
        Self { label: "skin 1e-3", skin: Some(1e-3), ..EXACT },
        stepped("k=1", 1),
        stepped("k=2", 2),
        stepped("k=4", 4),
        stepped("k=8", 8),
        stepped("k=16", 16),
        Self { certify: true, ..stepped("k=1 certified", 1) },
        Self { certify: true, ..stepped("k=4 certified", 4) },
        Self { precision: Precision::F32, ..stepped("k=1 f32", 1) },
        Self { precision: Precision::F32, ..stepped("k=4 f32", 4) },
        Self { label: "rate 1/2", stretch: 2, ..EXACT },
        Self { label: "rate 1/4", stretch: 4, ..EXACT },
        Self { stretch: 4, ..stepped("k=4 rate 1/4", 4) },
        Self { label: "grid 2^-12", positions: Positions::Grid(12), ..EXACT },
        Self { label: "grid 2^-8", positions: Positions::Grid(8), ..EXACT },
    ];

    /// Returns what the world is told.
    pub(super) fn of_world(&self) -> Settings {
        Settings { stops: Stops::Both, method: self.method, certify: self.certify, skin: self.skin }
    }

    /// Returns whether a world does the same under both.
    pub(super) fn runs_like(&self, other: &Self) -> bool {
        Self { label: other.label, positions: other.positions, ..*self } == *other
    }

    /// Returns how many times a cycle who overlaps is looked for; `None` where collisions are found at their time.
    pub(super) fn substeps(&self) -> Option<u32> {
        match self.method {
            Method::Event => None,
            Method::Stepped { substeps } => Some(substeps),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_number_on_a_grid_takes_the_bytes_of_a_varint_with_its_sign() {
        let check = |coordinate: f64, bytes: u64, seen: f64| {
            let grid = Positions::Grid(8);
            assert_eq!((grid.bytes(coordinate), grid.seen(coordinate)), (bytes, seen), "{coordinate}");
        };
        check(0.0, 1, 0.0);
        check(125.0 / 256.0, 1, 125.0 / 256.0);
        check(126.0 / 256.0, 3, 126.0 / 256.0);
        check(-125.0 / 256.0, 1, -125.0 / 256.0);
        check(-126.0 / 256.0, 3, -126.0 / 256.0);
        check(127.999, 5, 128.0);
        check(0.3, 1, 77.0 / 256.0);
        assert_eq!(Positions::Exact.bytes(0.3), 8);
        assert_eq!(Positions::Grid(12).bytes(1e6), 9);
    }

    #[test]
    fn labels_name_one_setting_each() {
        for (place, setting) in Setting::ALL.iter().enumerate() {
            assert!(Setting::ALL[..place].iter().all(|other| other.label != setting.label));
            assert!(
                Setting::ALL[..place]
                    .iter()
                    .all(|other| *other != Setting { label: other.label, ..*setting })
            );
        }
        assert_eq!(Setting::ALL.iter().filter(|setting| setting.runs_like(&EXACT)).count(), 3);
    }
}
