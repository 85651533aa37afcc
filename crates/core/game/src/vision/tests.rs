use std::collections::BTreeSet;

use maniple_geometry::Segment;
use maniple_view::{Identity, Shape};

use super::*;
use crate::scenario::SIGHT_MIN;

#[test]
fn the_tiles_that_an_object_sees_are_those_to_which_a_line_leads() {
    let (mut hidden, mut faces) = (0, 0);
    for seed in 0..400 {
        let mut random = Random(seed);
        let map = random.map(24, 17);
        let blocked = blocked(&map);
        let object = random.object(&map, 0);
        for blocked in [None, Some(&blocked)] {
            let mut found = TileSet::new(map.width(), map.height());
            let mut stamp = Stamp::default();
            let scene = Scene { map: &map, blocked };
            assert!(stamp.look(&object, &scene, &mut Shadows::default()));
            assert!(!stamp.look(&object, &scene, &mut Shadows::default()));
            stamp.insert_into(&mut found);
            let slow = slow_tiles(&object, &map, blocked);
            for (x, y) in tiles(&map) {
                assert_eq!(found.contains(x, y), slow.contains(&(x, y)), "seed {seed} ({x}, {y}) {object:?}");
            }
            if blocked.is_some() {
                hidden += slow_tiles(&object, &map, None).len() - slow.len();
                faces += slow.iter().filter(|&&(x, y)| !map.is_passable(x, y)).count();
            }
        }
    }
    assert!(hidden > 1000 && faces > 1000, "{hidden} {faces}");
}

#[test]
fn seeing_from_open_ground_to_open_ground_is_mutual() {
    for seed in 0..40 {
        let mut random = Random(seed);
        let map = random.map(13, 11);
        let blocked = blocked(&map);
        let scene = Scene { map: &map, blocked: Some(&blocked) };
        let open: Vec<(u32, u32)> = tiles(&map).filter(|&(x, y)| map.is_passable(x, y)).collect();
        let seen: Vec<TileSet> = open
            .iter()
            .map(|&(x, y)| {
                let center = DVec2::new(f64::from(x) + 0.25, f64::from(y) + 0.75);
                let mut tiles = TileSet::new(map.width(), map.height());
                let mut stamp = Stamp::default();
                stamp.look(&scout(0, 0, center), &scene, &mut Shadows::default());
                stamp.insert_into(&mut tiles);
                tiles
            })
            .collect();
        for (one, from) in open.iter().zip(&seen) {
            for (other, back) in open.iter().zip(&seen) {
                assert_eq!(from.contains(other.0, other.1), back.contains(one.0, one.1), "seed {seed}");
            }
        }
    }
}

#[test]
fn walls_hide_what_is_behind_them_and_nothing_else() {
    let rows = ["........", "...@@...", "........", "........", "........"];
    let check = |eye: (f64, f64), is_in_air: bool, expected: [&str; 5]| {
        let map = map(&rows);
        let vision =
            Vision { terrain: TerrainKnowledge::Known, walls_block: true, identity: Identity::Fresh };
        let mut sight = Sight::Fog(Box::new(Fog::new(&vision, &Arc::new(map), &[0])));
        sight.look(&[Visible { is_in_air, ..scout(0, 0, DVec2::from(eye)) }]);
        let visible = sight.visible(Seat(0)).unwrap();
        let character = |x, y| if visible.contains(x, y) { '*' } else { ' ' };
        let found: Vec<String> = (0..5).map(|y| (0..8).map(|x| character(x, y)).collect()).collect();
        assert_eq!(found, expected, "{eye:?}");
    };
    check((3.5, 3.5), false, ["***   **", "********", "********", "********", "********"]);
    check((3.5, 3.5), true, ["********"; 5]);
    check((0.5, 1.5), false, ["******* ", "*****   ", "******* ", "********", "******* "]);
}

#[test]
fn who_touches_a_tile_is_on_it_from_whichever_side() {
    let map = map(&["...", "...", "..."]);
    let mut middle = TileSet::new(3, 3);
    middle.insert_run(4, 1);
    for (away, expected) in [(0.75, true), (0.751, false)] {
        for (x, y) in [(-away, 0.0), (away, 0.0), (0.0, -away), (0.0, away)] {
            let object = scout(0, 0, DVec2::new(1.5 + x, 1.5 + y));
            assert_eq!(is_on(&object, &middle, &map), expected, "{x} {y}");
        }
    }
}

#[test]
fn without_walls_it_makes_no_difference_whether_they_block() {
    for seed in 0..60 {
        let mut random = Random(seed);
        let map = Arc::new(map(&["...................."; 20]));
        let objects: Vec<Visible> = (0..30).map(|number| random.object(&map, number)).collect();
        let [mut plain, mut blocking] = [false, true].map(|walls_block| {
            let vision = Vision { terrain: TerrainKnowledge::Known, walls_block, identity: Identity::Fresh };
            Sight::Fog(Box::new(Fog::new(&vision, &map, &[0, 1, 2])))
        });
        plain.look(&objects);
        blocking.look(&objects);
        for seat in [0, 1, 2].map(Seat) {
            assert_eq!(plain.visible(seat), blocking.visible(seat), "seed {seed}");
            for object in &objects {
                let id = object.object;
                assert_eq!(plain.sees(seat, id), blocking.sees(seat, id), "seed {seed}");
                let visible = plain.visible(seat).unwrap();
                assert!(!plain.sees(seat, id) || is_on(object, visible, &map), "seed {seed}");
            }
        }
    }
}

#[test]
fn a_team_sees_what_its_own_see_and_knows_what_it_has_seen() {
    for seed in 0..60 {
        let mut random = Random(seed);
        let map = Arc::new(random.map(31, 23));
        let vision = Vision {
            terrain: TerrainKnowledge::Explored,
            walls_block: seed % 2 == 0,
            identity: Identity::Fresh,
        };
        let blocked = blocked(&map);
        let blocked = vision.walls_block.then_some(&blocked);
        // Seats 0 and 2 are a team.
        let mut sight = Sight::Fog(Box::new(Fog::new(&vision, &map, &[5, 1, 5])));
        let mut objects: Vec<Visible> = (0..6).map(|number| random.object(&map, number)).collect();
        for object in &mut objects {
            object.team = [Some(5), Some(1), None][random.index(3)];
        }
        let (mut known, mut walls) = (BTreeSet::new(), BTreeSet::new());
        for look in 0..12 {
            for object in &mut objects {
                if random.below(2) == 0 {
                    object.center = random.point(&map);
                }
            }
            if random.below(4) == 0 && !objects.is_empty() {
                objects.remove(random.index(objects.len()));
            }
            sight.look(&objects);
            let own = objects.iter().filter(|object| object.team == Some(5));
            let expected: BTreeSet<(u32, u32)> =
                own.flat_map(|object| slow_tiles(object, &map, blocked)).collect();
            let visible = sight.visible(Seat(0)).unwrap();
            assert_eq!(
                tiles(&map).filter(|&(x, y)| visible.contains(x, y)).collect::<BTreeSet<_>>(),
                expected
            );
            assert_eq!(sight.visible(Seat(2)), Some(visible));
            let (revealed, new_walls) = sight.news(Seat(0));
            assert_eq!(sight.news(Seat(2)), (revealed, new_walls));
            for (x, y, characters) in revealed {
                for (x, character) in (*x..).zip(characters.chars()) {
                    assert!(known.insert((x, *y)), "seed {seed}: ({x}, {y}) was known");
                    assert_eq!(character == '.', map.is_passable(x, *y), "seed {seed}");
                }
            }
            for wall in new_walls {
                assert!(walls.insert(bits(wall)), "seed {seed}: wall {wall:?} was known");
            }
            assert!(known.is_superset(&expected), "seed {seed}, look {look}");
            assert_eq!(walls, slow_walls(&map, &known), "seed {seed}, look {look}");
        }
    }
}

/// The walls with all their tiles among these.
fn slow_walls(map: &TileMap, known: &BTreeSet<(u32, u32)>) -> BTreeSet<[u64; 4]> {
    let (width, height) = (map.width(), map.height());
    let is_known = |x: i64, y: i64| {
        let on_map = (0..i64::from(width)).contains(&x) && (0..i64::from(height)).contains(&y);
        !on_map || known.contains(&(u32::try_from(x).unwrap(), u32::try_from(y).unwrap()))
    };
    let mut walls = Vec::new();
    for (x, y) in (0..=height).flat_map(|y| (0..=width).map(move |x| (x, y))) {
        let (column, row) = (i64::from(x), i64::from(y));
        if x < width && is_known(column, row) && is_known(column, row - 1) {
            walls.extend(map.wall_above(x, y));
        }
        if y < height && is_known(column, row) && is_known(column - 1, row) {
            walls.extend(map.wall_left_of(x, y));
        }
    }
    let ends = |wall: Segment| bits(&(wall.start.x, wall.start.y, wall.end.x, wall.end.y));
    walls.into_iter().map(ends).collect()
}

fn bits(&(x1, y1, x2, y2): &Wall) -> [u64; 4] {
    [x1, y1, x2, y2].map(f64::to_bits)
}

/// The tiles that an object sees, each looked at on its own.
fn slow_tiles(object: &Visible, map: &TileMap, blocked: Option<&TileSet>) -> BTreeSet<(u32, u32)> {
    let (half, radius) = (object.shape.half(), object.shape.rounding());
    let ((left, top), (right, bottom)) =
        (map.tile_at(object.center - half), map.tile_at(object.center + half));
    let is_within = |(x, y): (u32, u32), reach: f64| {
        (top..=bottom).any(|own_y| {
            (left..=right).any(|own_x| {
                let [across, down] =
                    [x.abs_diff(own_x), y.abs_diff(own_y)].map(|apart| f64::from(apart.saturating_sub(1)));
                across * across + down * down <= reach * reach
            })
        })
    };
    let reached: Vec<(u32, u32)> =
        tiles(map).filter(|&tile| is_within(tile, radius + object.sight)).collect();
    let Some(blocked) = blocked.filter(|_| !object.is_in_air) else { return reached.into_iter().collect() };
    let eye = map.tile_at(object.center);
    let is_clear = |tile: &(u32, u32)| is_clear(eye, *tile, blocked) || is_within(*tile, radius + SIGHT_MIN);
    let clear: BTreeSet<(u32, u32)> = reached.iter().copied().filter(is_clear).collect();
    let is_face = |&(x, y): &(u32, u32)| {
        let is_beside = |&&(a, b): &&(u32, u32)| a.abs_diff(x) <= 1 && b.abs_diff(y) <= 1;
        blocked.contains(x, y) && clear.iter().filter(is_beside).any(|&(a, b)| !blocked.contains(a, b))
    };
    reached.iter().copied().filter(|tile| clear.contains(tile) || is_face(tile)).collect()
}

/// Walks the line of sight from tile to tile.
fn is_clear(from: (u32, u32), to: (u32, u32), blocked: &TileSet) -> bool {
    let at = |(x, y): (u32, u32)| (i64::from(x), i64::from(y));
    let ((x, y), (to_x, to_y)) = (at(from), at(to));
    let (across, down) = (to_x - x, to_y - y);
    let is_wide = across.abs() > down.abs();
    let (long, short) = if is_wide { (across, down) } else { (down, across) };
    let steps = long.abs();
    let is_blocked = |along: i64, aside: i64| {
        let (x, y) = if is_wide { (x + along, y + aside) } else { (x + aside, y + along) };
        blocked.contains(u32::try_from(x).unwrap(), u32::try_from(y).unwrap())
    };
    (1..steps).all(|step| {
        let along = step * long.signum();
        // `short step / steps` lies between, or on, the two nearest whole numbers to it.
        let twice = 2 * short * step;
        let low =
            (twice - steps).div_euclid(2 * steps) + i64::from((twice - steps).rem_euclid(2 * steps) != 0);
        let high = (twice + steps).div_euclid(2 * steps);
        !(is_blocked(along, low) && is_blocked(along, high))
    })
}

fn tiles(map: &TileMap) -> impl Iterator<Item = (u32, u32)> + use<> {
    let (width, height) = (map.width(), map.height());
    (0..height).flat_map(move |y| (0..width).map(move |x| (x, y)))
}

fn scout(number: u32, team: u16, center: DVec2) -> Visible {
    let shape = Shape::Circle { radius: 0.25 };
    Visible { object: ObjectId(number), team: Some(team), center, shape, sight: 6.0, is_in_air: false }
}

fn map<R: AsRef<str>>(rows: &[R]) -> TileMap {
    struct Nothing;
    impl maniple_tilemap::Resolver for Nothing {
        fn resolve(&self, _path: &str) -> Result<Vec<u8>, String> {
            Err("no file".to_owned())
        }
    }
    let rows: Vec<&str> = rows.iter().map(AsRef::as_ref).collect();
    let (width, height) = (rows[0].len(), rows.len());
    let text = format!("type octile\nheight {height}\nwidth {width}\nmap\n{}\n", rows.join("\n"));
    maniple_tilemap::read("a.map", text.as_bytes(), &Nothing).unwrap()
}

/// A stream of numbers from a seed.
struct Random(u64);

impl Random {
    fn below(&mut self, end: u64) -> u64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 33) % end
    }

    fn index(&mut self, end: usize) -> usize {
        usize::try_from(self.below(end as u64)).unwrap()
    }

    fn fraction(&mut self) -> f64 {
        self.below(1 << 20) as f64 / f64::from(1 << 20)
    }

    /// A map of at most this size, from all but open to all but full.
    fn map(&mut self, width: u64, height: u64) -> TileMap {
        let (width, height, full) = (1 + self.below(width), 1 + self.below(height), self.below(60));
        let rows: Vec<String> = (0..height)
            .map(|_| (0..width).map(|_| if self.below(100) < full { '@' } else { '.' }).collect())
            .collect();
        map(&rows)
    }

    fn point(&mut self, map: &TileMap) -> DVec2 {
        let [width, height] = [map.width(), map.height()].map(f64::from);
        DVec2::new(width * self.fraction(), height * self.fraction())
    }

    fn object(&mut self, map: &TileMap, number: u32) -> Visible {
        let shape = match self.below(4) {
            0 => Shape::Rectangle { width: 0.5 + 4.0 * self.fraction(), height: 0.5 + 3.0 * self.fraction() },
            1 => Shape::Circle { radius: 3.0 * self.fraction() },
            _ => Shape::Circle { radius: 0.4 },
        };
        // Whole reaches, too: a tile at exactly that distance belongs to it.
        let sight = if self.below(3) == 0 {
            1.0 + self.below(9) as f64 - shape.rounding()
        } else {
            9.0 * self.fraction()
        };
        Visible {
            object: ObjectId(number),
            team: Some(u16::try_from(self.below(3)).unwrap()),
            center: self.point(map),
            shape,
            sight: if sight < SIGHT_MIN { SIGHT_MIN } else { sight },
            is_in_air: self.below(6) == 0,
        }
    }
}
