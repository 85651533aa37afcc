//! Corridors.

use super::Request;
use super::canvas::{Canvas, Material, Spot, square};
use super::dice::Dice;

/// How much wider a corridor is than the largest unit needs, in tiles: two smaller ones get past each other.
const CORRIDOR_EXTRA: i32 = 1;

/// How thick the walls are, in tiles.
const WALL: i32 = 1;

/// The share of the walls that are left open although there is another way.
const LOOPS: f64 = 0.12;

/// Draws the walls and returns what ways through them are made of.
///
/// Walls between cells are taken away in an order that the seed says, each together with its twin, if they join two parts
/// that hang together (Kruskal, 1956); and some of the others.
pub(super) fn draw(canvas: &mut Canvas, request: &Request, dice: Dice) -> Material {
    let corridor = request.lane().cast_signed() + CORRIDOR_EXTRA;
    let columns = cells(canvas.width(), corridor);
    let rows = cells(canvas.height(), corridor);
    let across = i32::try_from(columns.len()).unwrap_or(0);
    let down = i32::try_from(rows.len()).unwrap_or(0);
    let wall = if dice.below("hedges", 0, 3) == 0 { Material::Trees } else { Material::Rock };
    canvas.spots().for_each(|spot| canvas.put(spot, wall));
    let cell = |(column, row): Spot| {
        let (columns, rows) = (columns[column.cast_unsigned() as usize], rows[row.cast_unsigned() as usize]);
        ((columns.0, rows.0), (columns.1, rows.1))
    };
    for spot in square((0, 0), (across, down)) {
        let (min, max) = cell(spot);
        square(min, max).for_each(|tile| canvas.put(tile, Material::Ground));
    }
    let grid = Canvas::new(across.cast_unsigned(), down.cast_unsigned(), canvas.is_symmetric());
    for (from, to) in doors(&grid, dice) {
        let (first, second) = (cell(from), cell(to));
        let (min, max) = if from.1 == to.1 {
            ((first.1.0, first.0.1), (second.0.0, second.1.1))
        } else {
            ((first.0.0, first.1.1), (second.1.0, second.0.1))
        };
        square(min, max).for_each(|tile| canvas.put(tile, Material::Ground));
    }
    open_posts(canvas);
    Material::Ground
}

/// Returns where each column of cells begins and ends, the same from both sides; those in the middle can be wider.
fn cells(size: i32, corridor: i32) -> Vec<Spot> {
    let count = ((size + WALL) / (corridor + WALL)).max(1);
    let left = size - count * corridor - (count - 1) * WALL;
    let mut cells = Vec::new();
    let mut start = 0;
    for cell in 0..count {
        // What is left over goes in equal parts to the first and last cells, and to the middle if it is odd.
        let from_edge = cell.min(count - 1 - cell);
        let is_middle = 2 * cell + 1 == count;
        let odd = if is_middle { left % 2 } else { 0 };
        let pairs = left / 2;
        let extra = if is_middle && from_edge < pairs { 2 } else { i32::from(from_edge < pairs) };
        cells.push((start, start + corridor + extra + odd));
        start += corridor + extra + odd + WALL;
        if count % 2 == 0 && 2 * (cell + 1) == count {
            start += left % 2;
        }
    }
    cells
}

/// Returns the pairs of neighbouring cells without a wall between them.
fn doors(grid: &Canvas, dice: Dice) -> Vec<(Spot, Spot)> {
    let mut walls: Vec<(u64, Spot, Spot)> = Vec::new();
    for (x, y) in grid.spots() {
        for next in [(x + 1, y), (x, y + 1)].into_iter().filter(|&next| grid.is_inside(next)) {
            // The twin of a wall begins at the twin of its other end.
            let key = grid.index((x, y)).min(grid.index(grid.twin(next))) as u64;
            let kind = u64::from(next.1 > y);
            walls.push((key << 1 | kind, (x, y), next));
        }
    }
    let chance = |key: u64| dice.share("wall", key);
    walls.sort_by(|a, b| chance(a.0).total_cmp(&chance(b.0)).then(a.cmp(b)));
    let mut parts: Vec<usize> = grid.spots().map(|spot| grid.index(spot)).collect();
    let mut doors = Vec::new();
    let mut rest = walls.as_slice();
    while let Some(&(key, ..)) = rest.first() {
        let twins = rest.iter().take_while(|wall| wall.0 == key).count();
        let (group, others) = rest.split_at(twins);
        rest = others;
        let ends = |wall: &(u64, Spot, Spot)| (grid.index(wall.1), grid.index(wall.2));
        let is_joining = group.iter().any(|wall| {
            let (from, to) = ends(wall);
            part(&parts, from) != part(&parts, to)
        });
        if is_joining || dice.share("loop", key) < LOOPS {
            for wall in group {
                let (from, to) = ends(wall);
                let (from, to) = (part(&parts, from), part(&parts, to));
                parts[from] = to;
                doors.push((wall.1, wall.2));
            }
        }
    }
    doors
}

fn part(parts: &[usize], mut cell: usize) -> usize {
    while parts[cell] != cell {
        cell = parts[cell];
    }
    cell
}

/// Opens what is left between four doors: a post that parts nothing.
fn open_posts(canvas: &mut Canvas) {
    let before = canvas.clone();
    for spot in before.spots() {
        let around = square((spot.0 - 1, spot.1 - 1), (spot.0 + 2, spot.1 + 2));
        if around.filter(|&near| near != spot).all(|near| before.is_open(near)) {
            canvas.put(spot, Material::Ground);
        }
    }
}
