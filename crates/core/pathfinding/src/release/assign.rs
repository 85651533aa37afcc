//! Who goes to which goal, where goals are interchangeable.

use glam::DVec2;

/// As many pairs as are assigned at once; more are halved first, along the axis in which they lie farther apart.
const AT_ONCE_MAX: usize = 96;

/// Returns for each start the place of its goal, so that the sum of the squared distances is small: the smallest for few,
/// and for many that of halves. Nobody crosses the way of another where the sum is smallest.
///
/// Turpin, Michael and Kumar, *CAPT: Concurrent Assignment and Planning of Trajectories for Multiple Robots*, IJRR 33,
/// 2014: with squared distances, circles that are far enough apart at both ends and leave and arrive together never meet.
pub(crate) fn by_distance(starts: &[DVec2], goals: &[DVec2]) -> Vec<usize> {
    let mut assignment = Assignment::new(starts, goals);
    while assignment.advance(|start, goal| starts[start].distance_squared(goals[goal])).is_some() {}
    assignment.assigned
}

/// An assignment of starts to as many goals that is made part by part: the sum of some costs is the smallest for few, and for many that of
/// halves that lie together.
#[derive(Clone, Debug, Default)]
pub(crate) struct Assignment {
    /// For each start the place of its goal.
    pub(crate) assigned: Vec<usize>,
    /// The starts and as many goals that are left to be assigned to each other.
    parts: Vec<(Vec<usize>, Vec<usize>)>,
}

impl Assignment {
    pub(crate) fn new(starts: &[DVec2], goals: &[DVec2]) -> Self {
        let mut from: Vec<usize> = (0..starts.len()).collect();
        let mut to: Vec<usize> = (0..starts.len()).collect();
        let mut parts = Vec::new();
        halve((starts, &mut from), (goals, &mut to), &mut parts);
        Self { assigned: vec![0; starts.len()], parts }
    }

    /// Assigns the starts of one part more, and returns how many looks that took at most; `None` where all are assigned.
    pub(crate) fn advance(&mut self, cost: impl Fn(usize, usize) -> f64) -> Option<u64> {
        let (from, to) = self.parts.pop()?;
        let count = from.len();
        let costs: Vec<f64> = from
            .iter()
            .flat_map(|&start| to.iter().map(move |&goal| (start, goal)))
            .map(|(start, goal)| cost(start, goal))
            .collect();
        for (row, column) in
            cheapest(count, |row, column| costs[row * count + column]).into_iter().enumerate()
        {
            self.assigned[from[row]] = to[column];
        }
        Some((count as u64).pow(2) + (count as u64).pow(3) / 8)
    }
}

fn halve(
    (starts, from): (&[DVec2], &mut [usize]),
    (goals, to): (&[DVec2], &mut [usize]),
    parts: &mut Vec<(Vec<usize>, Vec<usize>)>,
) {
    if from.len() <= AT_ONCE_MAX {
        if !from.is_empty() {
            parts.push((from.to_vec(), to.to_vec()));
        }
        return;
    }
    let is_wide = spread(starts, from, |point| point.x) + spread(goals, to, |point| point.x)
        > spread(starts, from, |point| point.y) + spread(goals, to, |point| point.y);
    let by = |points: &[DVec2], a: usize, b: usize| {
        let (a_point, b_point) = (points[a], points[b]);
        let order = if is_wide {
            a_point.x.total_cmp(&b_point.x).then(a_point.y.total_cmp(&b_point.y))
        } else {
            a_point.y.total_cmp(&b_point.y).then(a_point.x.total_cmp(&b_point.x))
        };
        order.then(a.cmp(&b))
    };
    from.sort_unstable_by(|&a, &b| by(starts, a, b));
    to.sort_unstable_by(|&a, &b| by(goals, a, b));
    let middle = from.len() / 2;
    let ((first, rest), (goals_first, goals_rest)) = (from.split_at_mut(middle), to.split_at_mut(middle));
    halve((starts, first), (goals, goals_first), parts);
    halve((starts, rest), (goals, goals_rest), parts);
}

/// How far apart the points with these places are along an axis.
fn spread(points: &[DVec2], places: &[usize], axis: impl Fn(DVec2) -> f64) -> f64 {
    let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
    for &place in places {
        let value = axis(points[place]);
        low = if value < low { value } else { low };
        high = if value > high { value } else { high };
    }
    high - low
}

/// Returns for each row its column in the cheapest assignment of all rows to as many columns.
///
/// The Hungarian method with potentials and shortest augmenting paths, in the third power of the number: Jonker and Volgenant,
/// *A Shortest Augmenting Path Algorithm for Dense and Sparse Linear Assignment Problems*, Computing 38, 1987.
pub(crate) fn cheapest(count: usize, cost: impl Fn(usize, usize) -> f64) -> Vec<usize> {
    // Row and column 0 stand for nobody.
    let (mut row_price, mut column_price) = (vec![0.0; count + 1], vec![0.0; count + 1]);
    let (mut row_of, mut before) = (vec![0; count + 1], vec![0; count + 1]);
    for row in 1..=count {
        row_of[0] = row;
        let mut column = 0;
        let mut least = vec![f64::INFINITY; count + 1];
        let mut is_done = vec![false; count + 1];
        while row_of[column] != 0 {
            is_done[column] = true;
            let (current, mut step, mut next) = (row_of[column], f64::INFINITY, 0);
            for other in 1..=count {
                if is_done[other] {
                    continue;
                }
                let reduced = cost(current - 1, other - 1) - row_price[current] - column_price[other];
                if reduced < least[other] {
                    least[other] = reduced;
                    before[other] = column;
                }
                if least[other] < step {
                    step = least[other];
                    next = other;
                }
            }
            for other in 0..=count {
                if is_done[other] {
                    row_price[row_of[other]] += step;
                    column_price[other] -= step;
                } else {
                    least[other] -= step;
                }
            }
            column = next;
        }
        while column != 0 {
            row_of[column] = row_of[before[column]];
            column = before[column];
        }
    }
    let mut assigned = vec![0; count];
    for column in 1..=count {
        assigned[row_of[column] - 1] = column - 1;
    }
    assigned
}

/// Where a start or a goal lies, seen from a narrow place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Sight {
    /// How far it is, in world units of way.
    pub(crate) distance: f64,
    /// In which direction: -1 is wholly to the left of who goes through, 1 wholly to the right.
    pub(crate) bearing: f64,
}

/// Returns the lane of each place: of so many at a time, who is farther to the left takes a lane farther to the left, so that nobody of
/// them crosses the stream of another lane, and as many take each lane. `first` are the places in the order in which they are taken.
pub(crate) fn lanes(seen: &[Sight], mut first: Vec<usize>, (count, at_a_time): (usize, usize)) -> Vec<usize> {
    let mut lanes = vec![0; seen.len()];
    for places in first.chunks_mut(at_a_time.max(1)) {
        places.sort_unstable_by(|&a, &b| seen[a].bearing.total_cmp(&seen[b].bearing).then(a.cmp(&b)));
        for (rank, &place) in places.iter().enumerate() {
            lanes[place] = rank * count / places.len();
        }
    }
    lanes
}
