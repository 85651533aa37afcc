//! What is odd about a map that can be read.

use glam::DVec2;
use maniple_geometry::Segment;

use crate::{Corner, Spawn, TileMap, TileShape, gaps, regions};

/// What kind of oddity it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum FindingKind {
    /// A circle of the given radius does not fit between two walls although the tiles between them are passable.
    NarrowGap,
    /// A spawn lies where it is blocked.
    SpawnInWall,
    /// A spawn is nearer to a wall than the given radius.
    SpawnNearWall,
    /// A region cannot be reached from the largest one.
    RegionCutOff,
    /// An object of the file is ignored.
    ForeignObject,
}

/// Something odd about a map.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Finding {
    /// What kind it is.
    pub kind: FindingKind,
    /// Where it is: column and row of a tile within the map.
    pub tile: (u32, u32),
    /// A sentence for people, without the place.
    pub text: String,
}

/// Returns what is odd about a map: by kind, then row by row.
///
/// `radius` is that of the largest circle that shall get everywhere, in world units; with `None`, or one that is
/// not positive, gaps and the distance of spawns to walls are not looked at. Gaps between tiles that hang together
/// are one finding, at the narrowest; for gaps, half-blocked tiles count as blocked, and two corners are compared
/// up to 16 tiles apart. A gap at a free wall is its narrowest one.
#[must_use]
pub fn check(map: &TileMap, radius: Option<f64>) -> Vec<Finding> {
    let segments = map.segments();
    let mut findings = Vec::new();
    // Written so that what is not a number is none either.
    let radius = radius.filter(|&radius| radius > 0.0);
    if let Some(radius) = radius {
        narrow_gaps(map, &segments, radius, &mut findings);
    }
    for spawn in map.spawns() {
        findings.extend(spawn_finding(map, &segments, spawn, radius));
    }
    cut_off(map, &mut findings);
    findings.extend(map.foreign().iter().map(|foreign| Finding {
        kind: FindingKind::ForeignObject,
        tile: map.tile_at(foreign.position),
        text: format!("object {} is ignored: {}", foreign.object, foreign.reason),
    }));
    findings.sort_by_key(|finding| (finding.kind, finding.tile.1, finding.tile.0));
    findings
}

fn narrow_gaps(map: &TileMap, segments: &[Segment], radius: f64, findings: &mut Vec<Finding>) {
    let width = 2.0 * radius;
    let between = gaps::between_tiles(map, width);
    findings.extend(between.into_iter().map(|gap| Finding {
        kind: FindingKind::NarrowGap,
        tile: gap.tile,
        text: format!(
            "a gap {:.3} wide ({} tiles that hang together are too narrow); radius {radius} needs {width}",
            gap.width, gap.tiles
        ),
    }));
    let at_walls = gaps::at_free_walls(map, segments, width);
    findings.extend(at_walls.into_iter().map(|gap| Finding {
        kind: FindingKind::NarrowGap,
        tile: gap.tile,
        text: format!("a gap {:.3} wide at a free wall; radius {radius} needs {width}", gap.width),
    }));
}

fn spawn_finding(map: &TileMap, segments: &[Segment], spawn: &Spawn, radius: Option<f64>) -> Option<Finding> {
    let tile = map.tile_at(spawn.position);
    if is_blocked(map, spawn.position) {
        let text = format!("a spawn of player {} is in a wall", spawn.player);
        return Some(Finding { kind: FindingKind::SpawnInWall, tile, text });
    }
    let radius = radius?;
    let mut distance = f64::INFINITY;
    for segment in segments {
        let to_wall = (gaps::nearest(segment, spawn.position) - spawn.position).length();
        distance = if to_wall < distance { to_wall } else { distance };
    }
    let text = format!("a spawn of player {} is {distance:.3} from a wall, radius {radius}", spawn.player);
    (distance < radius).then_some(Finding { kind: FindingKind::SpawnNearWall, tile, text })
}

/// Whether a point lies in a blocked tile, or within the blocked half of one.
fn is_blocked(map: &TileMap, point: DVec2) -> bool {
    let (x, y) = map.tile_at(point);
    let (right, down) = (point.x - f64::from(x), point.y - f64::from(y));
    match map.tile(x, y).shape {
        TileShape::Open => false,
        TileShape::Blocked => true,
        TileShape::Diagonal(Corner::Northwest) => right + down < 1.0,
        TileShape::Diagonal(Corner::Southeast) => right + down > 1.0,
        TileShape::Diagonal(Corner::Northeast) => right > down,
        TileShape::Diagonal(Corner::Southwest) => right < down,
    }
}

fn cut_off(map: &TileMap, findings: &mut Vec<Finding>) {
    let regions = regions(map);
    let Some(largest) = regions.largest() else { return };
    let mut spawns = vec![0; regions.count()];
    for spawn in map.spawns() {
        let (x, y) = map.tile_at(spawn.position);
        if let Some(label) = regions.label(x, y) {
            spawns[label as usize] += 1;
        }
    }
    for (label, (&size, &tile)) in (0..).zip(regions.sizes().iter().zip(regions.firsts())) {
        if label != largest {
            let spawns = spawns[label as usize];
            let text =
                format!("a region of {size} tiles with {spawns} spawns is cut off from the largest one");
            findings.push(Finding { kind: FindingKind::RegionCutOff, tile, text });
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::map::Builder;

    /// The kinds and tiles of what is odd about an open map of 6 x 4 tiles with one blocked at (3, 1), one blocked
    /// at its upper left half at (1, 1), and a spawn at this place.
    fn findings(x: f64, y: f64, radius: Option<f64>) -> Vec<(FindingKind, (u32, u32))> {
        let mut builder = Builder::new(6, 4);
        builder.put(3, 1, TileShape::Blocked, None);
        builder.put(1, 1, TileShape::Diagonal(Corner::Northwest), None);
        builder.add_spawn(Spawn { player: 0, position: DVec2::new(x, y) });
        builder.add_free_wall(Segment::new(DVec2::new(4.5, 3.0), DVec2::new(5.0, 3.5)));
        check(&builder.finish(), radius).into_iter().map(|finding| (finding.kind, finding.tile)).collect()
    }

    #[test]
    fn spawns_in_walls_and_near_them_are_found() {
        let near = |tile| vec![(FindingKind::SpawnNearWall, tile)];
        let inside = |tile| vec![(FindingKind::SpawnInWall, tile)];
        for (x, y, radius, expected) in [
            (2.5, 2.5, None, vec![]),
            (2.5, 1.5, Some(0.4), vec![]),
            (3.5, 1.5, None, inside((3, 1))),
            (1.4, 1.4, None, inside((1, 1))),
            (1.6, 1.6, None, vec![]),
            (1.6, 1.6, Some(0.2), near((1, 1))),
            (2.7, 1.5, Some(0.31), near((2, 1))),
            (5.7, 0.5, Some(0.31), near((5, 0))),
            (4.6, 3.1, Some(0.1), near((4, 3))),
            (6.0, 4.0, Some(0.1), near((5, 3))),
        ] {
            let mut found = findings(x, y, radius);
            found.retain(|(kind, _)| *kind != FindingKind::NarrowGap);
            assert_eq!(found, expected, "({x}, {y}) {radius:?}");
        }
    }

    #[test]
    fn a_gap_between_a_free_wall_and_the_edge_is_found() {
        let gaps = |radius| findings(2.5, 2.5, Some(radius));
        assert_eq!(gaps(0.24), []);
        assert_eq!(gaps(0.26), [(FindingKind::NarrowGap, (5, 3))]);
    }

    #[test]
    fn regions_other_than_the_largest_are_cut_off() {
        let mut builder = Builder::new(5, 2);
        for (x, y) in [(1, 0), (1, 1), (3, 0), (4, 1)] {
            builder.put(x, y, TileShape::Blocked, None);
        }
        let found = check(&builder.finish(), None);
        let tiles: Vec<_> = found.iter().map(|finding| (finding.kind, finding.tile)).collect();
        assert_eq!(tiles, [(FindingKind::RegionCutOff, (0, 0)), (FindingKind::RegionCutOff, (4, 0))]);
    }

    #[test]
    fn odd_radii_find_nothing_and_stop() {
        for radius in [f64::NAN, 0.0, -1.0] {
            assert_eq!(findings(2.5, 2.5, Some(radius)), []);
        }
        assert!(!findings(2.5, 2.5, Some(f64::INFINITY)).is_empty());
    }
}
