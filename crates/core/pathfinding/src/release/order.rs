//! Who goes next, and where.

use super::ends::Ends;
use super::traffic::reach_from;

/// How many of those who have not left stand in the way of somebody, or how many of their legs lead over a goal.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct Blocked {
    /// Circles of the same group.
    own: u32,
    /// Circles of other groups, which may have left in time.
    others: u32,
}

/// What the choice of who goes next looks at.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Care {
    /// The way is free of all who wait, and the goal lies on the way of none of them.
    Free,
    /// The way is free of all who wait.
    Open,
    /// The way is free of those of the own group who wait, and the goal lies on the way of none of them.
    OwnFree,
    /// The way is free of those of the own group who wait.
    OwnOpen,
    /// None.
    Any,
}

/// Who has not left, and what is in whose way.
#[derive(Clone, Debug)]
pub(crate) struct Order {
    /// By number, in the order in which they go if they can.
    waiting: Vec<usize>,
    /// The group of which one left last.
    begun: Option<usize>,
    /// For each start whether it is put off until another has left.
    put_off: Vec<bool>,
    /// For each start who stands in its legs.
    start_blocked: Vec<Blocked>,
    /// For each goal who stands in its legs.
    goal_blocked: Vec<Blocked>,
    /// For each start the starts in whose legs it stands, and the goals.
    stands_in: Vec<(Vec<usize>, Vec<usize>)>,
    /// For each goal how many legs that have not been taken lead over it.
    covered: Vec<Blocked>,
    /// For each start, and for each goal, the goals over which its legs lead.
    start_covers: Vec<Vec<usize>>,
    goal_covers: Vec<Vec<usize>>,
    /// The goals of each stream that have not been taken.
    free: Vec<Vec<usize>>,
    /// The group of each goal.
    group_of_goal: Vec<usize>,
}

impl Order {
    /// Returns the order, which does not know yet what is in whose way.
    pub(crate) fn new(ends: &Ends) -> Self {
        let (starts, goals) = (&ends.starts, &ends.goals);
        let mut group_of_goal = vec![0; goals.len()];
        for start in starts {
            for &goal in &ends.streams[start.stream] {
                group_of_goal[goal] = start.group;
            }
        }
        Self {
            waiting: (0..starts.len()).collect(),
            begun: None,
            put_off: vec![false; starts.len()],
            start_blocked: vec![Blocked::default(); starts.len()],
            goal_blocked: vec![Blocked::default(); goals.len()],
            stands_in: vec![(Vec::new(), Vec::new()); starts.len()],
            covered: vec![Blocked::default(); goals.len()],
            start_covers: vec![Vec::new(); starts.len()],
            goal_covers: vec![Vec::new(); goals.len()],
            free: ends.streams.clone(),
            group_of_goal,
        }
    }

    /// Looks at what is in the way of one end: the starts come first, then the goals; `reach` is how far the middles of two circles
    /// are apart at least. Returns how many looks that took; `None` where there is no such end.
    pub(crate) fn look(&mut self, ends: &Ends, number: usize, reach: f64) -> Option<u64> {
        let starts = ends.starts.len();
        if number < starts {
            self.look_from_start(ends, number, reach);
        } else if number - starts < ends.goals.len() {
            self.look_from_goal(ends, number - starts, reach);
        } else {
            return None;
        }
        Some((starts + ends.goals.len()) as u64)
    }

    fn look_from_start(&mut self, ends: &Ends, number: usize, reach: f64) {
        let start = &ends.starts[number];
        for (other, standing) in ends.starts.iter().enumerate() {
            let reach = reach_from(start.point, standing.point, reach);
            if other != number && start.trajectory.leads_over(standing.point, reach) {
                self.start_blocked[number].add(start.group == standing.group);
                self.stands_in[other].0.push(number);
            }
        }
        for (other, goal) in ends.goals.iter().enumerate() {
            let is_own = start.trajectory.goal() == goal.point;
            if !is_own && start.trajectory.leads_over(goal.point, reach) {
                self.covered[other].add(start.group == self.group_of_goal[other]);
                self.start_covers[number].push(other);
            }
        }
    }

    fn look_from_goal(&mut self, ends: &Ends, number: usize, reach: f64) {
        let goal = &ends.goals[number];
        for (other, standing) in ends.starts.iter().enumerate() {
            if goal.trajectory.leads_over(standing.point, reach) {
                self.goal_blocked[number].add(self.group_of_goal[number] == standing.group);
                self.stands_in[other].1.push(number);
            }
        }
        for (other, another) in ends.goals.iter().enumerate() {
            if other != number && goal.trajectory.leads_over(another.point, reach) {
                self.covered[other].add(self.group_of_goal[number] == self.group_of_goal[other]);
                self.goal_covers[number].push(other);
            }
        }
    }

    /// Returns who goes next and the goal to which, and with which care; `None` where nobody is left who was not put off.
    ///
    /// A group that has begun comes first, so that groups go through narrow places one after the other.
    pub(crate) fn next(&self, ends: &Ends, trusted: Care) -> Option<((usize, usize), Care)> {
        let of_all = |_: usize| true;
        let of_begun = |number: usize| Some(ends.starts[number].group) == self.begun;
        let find = |care, is_meant: &dyn Fn(usize) -> bool| {
            self.find(ends, care, is_meant).map(|found| (found, care))
        };
        let trusting = || {
            let find = |care| find(care, &of_begun).or_else(|| find(care, &of_all));
            (trusted == Care::OwnOpen).then(|| find(Care::OwnFree))?
        };
        find(Care::Free, &of_begun)
            .or_else(trusting)
            .or_else(|| find(Care::Open, &of_begun))
            .or_else(|| find(Care::Free, &of_all))
            .or_else(|| find(Care::Open, &of_all))
            .or_else(|| find(Care::OwnOpen, &of_begun))
            .or_else(|| find(Care::OwnOpen, &of_all))
            .or_else(|| find(Care::Any, &of_all))
    }

    /// Returns others of the same lane who could go with the same care, each with the first goal of its stream that it can go to.
    pub(crate) fn others(
        &self,
        ends: &Ends,
        first: usize,
        (care, count): (Care, usize),
    ) -> Vec<(usize, usize)> {
        let lane = |number: usize| {
            let start = &ends.starts[number];
            start.passage.map(|passage| (start.group, passage.lane))
        };
        let is_of_lane =
            |number: usize| number != first && lane(number).is_some() && lane(number) == lane(first);
        self.all(ends, care, &is_of_lane).take(count).collect()
    }

    /// Returns how many wait.
    pub(crate) fn waiting(&self) -> usize {
        self.waiting.len()
    }

    /// Returns whether all have left.
    pub(crate) fn is_empty(&self) -> bool {
        self.waiting.is_empty()
    }

    /// Returns the first of those who wait.
    pub(crate) fn first(&self, count: usize) -> Vec<usize> {
        self.waiting.iter().copied().take(count).collect()
    }

    /// Returns the goals of a stream that have not been taken.
    pub(crate) fn goals(&self, stream: usize) -> &[usize] {
        &self.free[stream]
    }

    /// Passes over a circle until another has left.
    pub(crate) fn put_off(&mut self, start: usize) {
        self.put_off[start] = true;
    }

    /// The first circle of those that wait and are meant who can go with this care, and the first goal of its stream that it can go
    /// to.
    fn find(&self, ends: &Ends, care: Care, is_meant: &dyn Fn(usize) -> bool) -> Option<(usize, usize)> {
        self.all(ends, care, is_meant).next()
    }

    /// All such circles.
    fn all<'a>(
        &'a self,
        ends: &'a Ends,
        care: Care,
        is_meant: &'a dyn Fn(usize) -> bool,
    ) -> impl Iterator<Item = (usize, usize)> + 'a {
        // By stream whether it has no such goal.
        let mut is_hopeless = vec![false; self.free.len()];
        self.waiting.iter().filter_map(move |&number| {
            let stream = ends.starts[number].stream;
            let can_go = care.takes(self.start_blocked[number]) && is_meant(number);
            if !can_go || is_hopeless[stream] || self.put_off[number] {
                return None;
            }
            let is_good =
                |&&goal: &&usize| care.takes(self.goal_blocked[goal]) && care.covers(self.covered[goal]);
            let goal = self.free[stream].iter().find(is_good);
            is_hopeless[stream] = goal.is_none();
            goal.map(|&goal| (number, goal))
        })
    }

    /// Notes that a circle has left for a goal.
    pub(crate) fn leave(&mut self, ends: &Ends, (start, goal): (usize, usize)) {
        let group = ends.starts[start].group;
        self.waiting.retain(|&waiting| waiting != start);
        self.put_off.fill(false);
        self.begun = Some(group);
        self.free[ends.starts[start].stream].retain(|&free| free != goal);
        for &other in &self.stands_in[start].0 {
            self.start_blocked[other].subtract(ends.starts[other].group == group);
        }
        for &other in &self.stands_in[start].1 {
            self.goal_blocked[other].subtract(self.group_of_goal[other] == group);
        }
        for &other in self.start_covers[start].iter().chain(&self.goal_covers[goal]) {
            self.covered[other].subtract(self.group_of_goal[other] == group);
        }
    }
}

impl Blocked {
    fn add(&mut self, is_own: bool) {
        *self.count(is_own) += 1;
    }

    fn subtract(&mut self, is_own: bool) {
        *self.count(is_own) -= 1;
    }

    fn count(&mut self, is_own: bool) -> &mut u32 {
        if is_own { &mut self.own } else { &mut self.others }
    }
}

impl Care {
    fn takes(self, blocked: Blocked) -> bool {
        match self {
            Self::Free | Self::Open => blocked == Blocked::default(),
            Self::OwnFree | Self::OwnOpen => blocked.own == 0,
            Self::Any => true,
        }
    }

    /// Whether a goal may be taken over which so many legs lead.
    fn covers(self, covered: Blocked) -> bool {
        match self {
            Self::Free => covered == Blocked::default(),
            Self::OwnFree => covered.own == 0,
            Self::Open | Self::OwnOpen | Self::Any => true,
        }
    }
}
