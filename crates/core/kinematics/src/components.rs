//! Connected components of the motion-sphere intersection graph, and what lies in each in which something may happen.

use maniple_geometry::Scalar;

use crate::event::EventKind;
use crate::graph::{Edge, FixedHit, Graph};
use crate::runner::Halt;

/// As a mark or a place: none yet.
const NONE: u32 = u32::MAX;

/// The components in which something may happen: a collision, a turn, or an end so close to something that it has to
/// be certified. In all others everybody goes straight on, and nothing is done for them.
#[derive(Clone, Debug)]
#[doc(alias = "island")]
pub(crate) struct Components<S: Scalar> {
    /// For each node another one of its component, nearer to the root, which is its own parent.
    parents: Vec<u32>,
    /// For each node the number of its component, if something may happen there.
    marks: Vec<u32>,
    /// For each node its place in its component.
    places: Vec<u32>,
    /// How many components there are, those in which nothing happens included.
    pub(crate) count: usize,
    /// The nodes of each.
    pub(crate) nodes: Grouped<u32>,
    /// The pairs of each whose spheres intersect, as places, and when they collide if nobody is stopped.
    pub(crate) edges: Grouped<(Edge, Option<S>)>,
    /// Collisions ahead with something at rest; the node is a place.
    pub(crate) fixed: Grouped<FixedHit<S>>,
    /// Places of those who end near something at rest, or turn.
    pub(crate) watched: Grouped<u32>,
}

impl<S: Scalar> Components<S> {
    pub(crate) fn new() -> Self {
        Self {
            parents: Vec::new(),
            marks: Vec::new(),
            places: Vec::new(),
            count: 0,
            nodes: Grouped::default(),
            edges: Grouped::default(),
            fixed: Grouped::default(),
            watched: Grouped::default(),
        }
    }

    /// Finds the components of so many nodes.
    pub(crate) fn find(&mut self, nodes: usize, graphs: &[Graph<S>]) {
        self.parents.clear();
        self.parents.extend(0..u32::try_from(nodes).expect("objects have u32 ids"));
        self.count = nodes;
        for &(a, b) in graphs.iter().flat_map(|graph| &graph.edges) {
            self.count -= usize::from(self.join(a, b));
        }
        self.mark(nodes, graphs);
        self.group(graphs);
    }

    /// Returns the number of nodes in the largest component.
    pub(crate) fn largest(&self) -> usize {
        let mut sizes = vec![0; self.parents.len()];
        for node in (0u32..).take(self.parents.len()) {
            sizes[self.root(node) as usize] += 1;
        }
        sizes.into_iter().max().unwrap_or(0)
    }

    /// Gives numbers to the components in which something may happen, and says for each node which is its own.
    fn mark(&mut self, nodes: usize, graphs: &[Graph<S>]) {
        self.marks.clear();
        self.marks.resize(nodes, NONE);
        let mut marked = 0;
        for graph in graphs {
            let pairs = graph.hits.iter().map(|hit| graph.edges[hit.0 as usize].0);
            let close = graph.close.iter().map(|edge| edge.0);
            let lone = graph.fixed.iter().map(|hit| hit.node).chain(graph.watched.iter().copied());
            for node in pairs.chain(close).chain(lone) {
                let root = self.root_halving(node);
                let mark = &mut self.marks[root as usize];
                if *mark == NONE {
                    *mark = marked;
                    marked += 1;
                }
            }
        }
        self.nodes.begin(marked as usize);
        self.edges.begin(marked as usize);
        self.fixed.begin(marked as usize);
        self.watched.begin(marked as usize);
        // Only those of marked nodes are ever read.
        self.places.resize(nodes, NONE);
        for node in 0..nodes {
            // A parent is smaller than its child, so it is a child of the root itself by now.
            let root = self.parents[self.parents[node] as usize];
            self.parents[node] = root;
            let mark = self.marks[root as usize];
            if mark != NONE {
                self.marks[node] = mark;
                self.places[node] = self.nodes.count(mark);
            }
        }
    }

    fn group(&mut self, graphs: &[Graph<S>]) {
        let Self { marks, places, nodes, edges, fixed, watched, .. } = self;
        for graph in graphs {
            for &(a, _) in &graph.edges {
                if marks[a as usize] != NONE {
                    edges.count(marks[a as usize]);
                }
            }
            for hit in &graph.fixed {
                fixed.count(marks[hit.node as usize]);
            }
            for &node in &graph.watched {
                watched.count(marks[node as usize]);
            }
        }
        nodes.lay_out(0);
        edges.lay_out(((0, 0), None));
        let nobody = Halt { kind: EventKind::Edge, other: None };
        fixed.lay_out(FixedHit { node: 0, time: S::ZERO, halt: nobody });
        watched.lay_out(0);
        for (node, (&mark, &place)) in (0u32..).zip(marks.iter().zip(places.iter())) {
            if mark != NONE {
                nodes.set(mark, place, node);
            }
        }
        nodes.close();
        for graph in graphs {
            let mut ahead = graph.hits.iter().peekable();
            for (number, &(a, b)) in (0u32..).zip(&graph.edges) {
                let mark = marks[a as usize];
                if mark == NONE {
                    continue;
                }
                let time = ahead.next_if(|hit| hit.0 == number).map(|hit| hit.1);
                edges.push(mark, ((places[a as usize], places[b as usize]), time));
            }
            for hit in &graph.fixed {
                fixed.push(marks[hit.node as usize], FixedHit { node: places[hit.node as usize], ..*hit });
            }
            for &node in &graph.watched {
                watched.push(marks[node as usize], places[node as usize]);
            }
        }
    }

    /// Joins the components of two nodes; returns whether they were two. Union-find with path halving, always towards
    /// the smaller node (Tarjan and van Leeuwen 1984): near-linear in the number of edges.
    fn join(&mut self, a: u32, b: u32) -> bool {
        let (a, b) = (self.root_halving(a), self.root_halving(b));
        let (small, large) = if a < b { (a, b) } else { (b, a) };
        self.parents[large as usize] = small;
        small != large
    }

    fn root_halving(&mut self, mut node: u32) -> u32 {
        while self.parents[node as usize] != node {
            let above = self.parents[self.parents[node as usize] as usize];
            self.parents[node as usize] = above;
            node = above;
        }
        node
    }

    fn root(&self, mut node: u32) -> u32 {
        while self.parents[node as usize] != node {
            node = self.parents[node as usize];
        }
        node
    }

    /// Bytes on the heap.
    pub(crate) fn bytes(&self) -> usize {
        size_of::<u32>() * (self.parents.capacity() + self.marks.capacity() + self.places.capacity())
            + self.nodes.bytes()
            + self.edges.bytes()
            + self.fixed.bytes()
            + self.watched.bytes()
    }
}

/// Items in groups, those of a group one behind the other: a counting sort that is done in two passes from outside.
#[derive(Clone, Debug)]
pub(crate) struct Grouped<T> {
    /// For each group where it begins; while items are put in, where the next one goes.
    starts: Vec<u32>,
    items: Vec<T>,
}

impl<T> Default for Grouped<T> {
    fn default() -> Self {
        Self { starts: vec![0], items: Vec::new() }
    }
}

impl<T: Copy> Grouped<T> {
    /// Returns how many groups there are.
    pub(crate) fn groups(&self) -> usize {
        self.starts.len().saturating_sub(2)
    }

    /// Returns the items of a group.
    pub(crate) fn group(&self, group: usize) -> &[T] {
        &self.items[self.starts[group] as usize..self.starts[group + 1] as usize]
    }

    fn begin(&mut self, groups: usize) {
        self.starts.clear();
        self.starts.resize(groups + 2, 0);
    }

    /// Announces an item; returns how many of the group came before it.
    fn count(&mut self, group: u32) -> u32 {
        let count = &mut self.starts[group as usize + 2];
        *count += 1;
        *count - 1
    }

    fn lay_out(&mut self, filler: T) {
        let mut sum = 0;
        for start in &mut self.starts {
            sum += *start;
            *start = sum;
        }
        self.items.clear();
        self.items.resize(sum as usize, filler);
    }

    fn push(&mut self, group: u32, item: T) {
        let place = &mut self.starts[group as usize + 1];
        self.items[*place as usize] = item;
        *place += 1;
    }

    /// Puts an item into a place of its group, in groups that are not pushed to.
    fn set(&mut self, group: u32, place: u32, item: T) {
        self.items[(self.starts[group as usize + 1] + place) as usize] = item;
    }

    /// Ends a filling by [`Grouped::set`], which does not move the ends of groups on as pushing does.
    fn close(&mut self) {
        self.starts.copy_within(1.., 0);
    }

    fn bytes(&self) -> usize {
        size_of::<u32>() * self.starts.capacity() + size_of::<T>() * self.items.capacity()
    }
}
