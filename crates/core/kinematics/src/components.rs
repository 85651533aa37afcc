//! Connected components of the motion-sphere intersection graph, and what lies in each in which something may happen.

use maniple_geometry::Scalar;

use crate::event::EventKind;
use crate::graph::{Edge, FixedHit, Graph};
use crate::runner::Halt;

/// Components are solved together in blocks of about so many nodes: few enough to stay in the nearest caches, enough that
/// what is done once a block hardly counts.
const NODES_A_BLOCK: u32 = 256;

/// The components in which something may happen: a collision, a turn, or an end so close to something that it has to
/// be certified. In all others everybody goes straight on, and nothing is done for them.
///
/// They come in *blocks* of whole components. Components share nothing, so a block is solved like one.
#[derive(Clone, Debug)]
#[doc(alias = "island")]
pub(crate) struct Components<S: Scalar> {
    /// For each node another one of its component, nearer to the root, which is its own parent.
    parents: Vec<u32>,
    homes: Vec<Home>,
    /// How many components there are, those in which nothing happens included.
    pub(crate) count: usize,
    /// The nodes of each block.
    pub(crate) nodes: Grouped<u32>,
    /// The pairs of each block whose spheres intersect, as places.
    pub(crate) edges: Grouped<Edge>,
    /// Collisions ahead in each block if nobody is stopped: when, and which of all edges.
    pub(crate) hits: Grouped<(S, u32)>,
    /// Collisions ahead with something at rest; the node is a place.
    pub(crate) fixed: Grouped<FixedHit<S>>,
    /// Places of those who end near something at rest, or turn.
    pub(crate) watched: Grouped<u32>,
}

/// Where a node is.
#[derive(Clone, Copy, Debug)]
struct Home {
    /// The block, or `IDLE`; before blocks are formed, `BUSY` for the root of a component in which something may happen.
    block: u32,
    /// The place in the block.
    place: u32,
}

const IDLE: u32 = u32::MAX;
const BUSY: u32 = u32::MAX - 1;

impl<S: Scalar> Components<S> {
    pub(crate) fn new() -> Self {
        Self {
            parents: Vec::new(),
            homes: Vec::new(),
            count: 0,
            nodes: Grouped::default(),
            edges: Grouped::default(),
            hits: Grouped::default(),
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
        self.form_blocks(nodes);
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

    /// Marks the roots of components in which something may happen.
    fn mark(&mut self, nodes: usize, graphs: &[Graph<S>]) {
        self.homes.clear();
        self.homes.resize(nodes, Home { block: IDLE, place: 0 });
        for graph in graphs {
            let pairs = graph.hits.iter().map(|hit| graph.edges[hit.0 as usize].0);
            let close = graph.close.iter().map(|edge| edge.0);
            let lone = graph.fixed.iter().map(|hit| hit.node).chain(graph.watched.iter().copied());
            for node in pairs.chain(close).chain(lone) {
                let root = self.root_halving(node);
                self.homes[root as usize].block = BUSY;
            }
        }
    }

    /// Gives a block to each component in which something may happen, and a place in it to each of its nodes.
    ///
    /// The block follows from how many nodes have been placed when the root comes up, which is the first node of its
    /// component: so blocks are about equally large, and near in the plane what is near in the list.
    fn form_blocks(&mut self, nodes: usize) {
        self.nodes.begin(nodes / NODES_A_BLOCK as usize + 1);
        let mut placed = 0;
        for node in 0..nodes {
            // A parent is smaller than its child, so it is a child of the root itself by now.
            let root = self.parents[self.parents[node] as usize];
            self.parents[node] = root;
            let mut block = self.homes[root as usize].block;
            if block == IDLE {
                continue;
            }
            if block == BUSY {
                block = placed / NODES_A_BLOCK;
            }
            placed += 1;
            self.homes[node] = Home { block, place: self.nodes.count(block) };
        }
        let blocks = placed.div_ceil(NODES_A_BLOCK) as usize;
        self.nodes.keep(blocks);
        self.edges.begin(blocks);
        self.hits.begin(blocks);
        self.fixed.begin(blocks);
        self.watched.begin(blocks);
    }

    fn group(&mut self, graphs: &[Graph<S>]) {
        let Self { homes, nodes, edges, hits, fixed, watched, .. } = self;
        for graph in graphs {
            for &(a, _) in &graph.edges {
                let block = homes[a as usize].block;
                if block != IDLE {
                    edges.count(block);
                }
            }
            for hit in &graph.hits {
                hits.count(homes[graph.edges[hit.0 as usize].0 as usize].block);
            }
            for hit in &graph.fixed {
                fixed.count(homes[hit.node as usize].block);
            }
            for &node in &graph.watched {
                watched.count(homes[node as usize].block);
            }
        }
        nodes.lay_out(0);
        edges.lay_out((0, 0));
        hits.lay_out((S::ZERO, 0));
        let nobody = Halt { kind: EventKind::Edge, other: None };
        fixed.lay_out(FixedHit { node: 0, time: S::ZERO, halt: nobody });
        watched.lay_out(0);
        for (node, home) in (0u32..).zip(homes.iter()) {
            if home.block != IDLE {
                nodes.set(home.block, home.place, node);
            }
        }
        nodes.close();
        for graph in graphs {
            let mut ahead = graph.hits.iter().peekable();
            for (number, &(a, b)) in (0u32..).zip(&graph.edges) {
                let home = homes[a as usize];
                if home.block == IDLE {
                    continue;
                }
                let place = edges.push(home.block, (home.place, homes[b as usize].place));
                if let Some(&(_, time)) = ahead.next_if(|hit| hit.0 == number) {
                    hits.push(home.block, (time, place));
                }
            }
            for hit in &graph.fixed {
                let home = homes[hit.node as usize];
                fixed.push(home.block, FixedHit { node: home.place, ..*hit });
            }
            for &node in &graph.watched {
                watched.push(homes[node as usize].block, homes[node as usize].place);
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
        size_of::<u32>() * self.parents.capacity()
            + size_of::<Home>() * self.homes.capacity()
            + self.nodes.bytes()
            + self.edges.bytes()
            + self.hits.bytes()
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

    /// Returns the place of a group's first item among the items of all groups.
    pub(crate) fn first(&self, group: usize) -> u32 {
        self.starts[group]
    }

    fn begin(&mut self, groups: usize) {
        self.starts.clear();
        self.starts.resize(groups + 2, 0);
    }

    /// Drops all groups but the first few, before any item is put in.
    fn keep(&mut self, groups: usize) {
        self.starts.truncate(groups + 2);
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

    /// Puts an item into a group; returns its place among the items of all groups.
    fn push(&mut self, group: u32, item: T) -> u32 {
        let place = &mut self.starts[group as usize + 1];
        self.items[*place as usize] = item;
        *place += 1;
        *place - 1
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
