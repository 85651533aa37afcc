//! Connected components of the motion-sphere intersection graph, and what lies in each in which something may happen.

use maniple_geometry::Scalar;

use crate::event::EventKind;
use crate::graph::{Edge, FixedHit, Graph};
use crate::room::keep_room;
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
    /// For each node whether something may happen to it by itself; for a root whether that is so in its component.
    busy: Vec<bool>,
    homes: Vec<Home>,
    /// How many components there are, those in which nothing happens included.
    pub(crate) count: usize,
    /// The nodes of each block.
    pub(crate) nodes: Grouped<u32>,
    /// The pairs of each block whose spheres intersect, as places, and when they collide if nobody is stopped; infinity if
    /// they do not.
    pub(crate) edges: Grouped<(Edge, S)>,
    /// Collisions ahead with something at rest; the node is a place.
    pub(crate) fixed: Grouped<FixedHit<S>>,
    /// Places of those who end near something at rest, or turn.
    pub(crate) watched: Grouped<u32>,
    /// Places of those with something at rest near their way.
    pub(crate) beside: Grouped<u32>,
}

/// Where a node is.
#[derive(Clone, Copy, Debug, Default)]
struct Home {
    /// The block, or [`IDLE`].
    block: u32,
    /// The place in the block.
    place: u32,
}

/// The block of those to whom nothing can happen. It is filled like all others, since a branch that cannot be guessed
/// costs more than that, but never looked at.
const IDLE: u32 = 0;

impl<S: Scalar> Components<S> {
    pub(crate) fn new() -> Self {
        Self {
            parents: Vec::new(),
            busy: Vec::new(),
            homes: Vec::new(),
            count: 0,
            nodes: Grouped::default(),
            edges: Grouped::default(),
            fixed: Grouped::default(),
            watched: Grouped::default(),
            beside: Grouped::default(),
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

    /// Marks those to whom something may happen.
    fn mark(&mut self, nodes: usize, graphs: &[Graph<S>]) {
        self.busy.clear();
        self.busy.resize(nodes, false);
        for graph in graphs {
            for (&(a, _), &time) in graph.edges.iter().zip(&graph.times) {
                self.busy[a as usize] |= time < S::INFINITY;
            }
            let close = graph.close.iter().map(|edge| edge.0);
            for node in
                close.chain(graph.fixed.iter().map(|hit| hit.node)).chain(graph.watched.iter().copied())
            {
                self.busy[node as usize] = true;
            }
        }
    }

    /// Gives a block to each component in which something may happen, and a place in it to each of its nodes.
    ///
    /// The block follows from how many nodes have been placed when the root comes up, which is the first node of its
    /// component: so blocks are about equally large, and near in the plane what is near in the list.
    fn form_blocks(&mut self, nodes: usize) {
        for node in 0..nodes {
            // A parent is smaller than its child, so it is a child of the root itself by now.
            let root = self.parents[self.parents[node] as usize];
            self.parents[node] = root;
            self.busy[root as usize] |= self.busy[node];
        }
        self.nodes.begin(nodes / NODES_A_BLOCK as usize + 2);
        self.homes.resize(nodes, Home::default());
        let mut placed = 0;
        for (node, &root) in (0u32..).zip(&self.parents) {
            let is_busy = self.busy[root as usize];
            let opened = if is_busy { IDLE + 1 + placed / NODES_A_BLOCK } else { IDLE };
            let block = if node == root { opened } else { self.homes[root as usize].block };
            placed += u32::from(is_busy);
            self.homes[node as usize] = Home { block, place: self.nodes.count(block) };
        }
        let blocks = 1 + placed.div_ceil(NODES_A_BLOCK) as usize;
        self.nodes.keep(blocks);
        self.edges.begin(blocks);
        self.fixed.begin(blocks);
        self.watched.begin(blocks);
        self.beside.begin(blocks);
    }

    /// Returns the blocks.
    pub(crate) fn blocks(&self) -> std::ops::Range<usize> {
        IDLE as usize + 1..self.nodes.groups()
    }

    fn group(&mut self, graphs: &[Graph<S>]) {
        let Self { homes, nodes, edges, fixed, watched, beside, .. } = self;
        for graph in graphs {
            for &(a, _) in &graph.edges {
                edges.count(homes[a as usize].block);
            }
            for hit in &graph.fixed {
                fixed.count(homes[hit.node as usize].block);
            }
            for &node in &graph.watched {
                watched.count(homes[node as usize].block);
            }
            for &node in &graph.beside {
                beside.count(homes[node as usize].block);
            }
        }
        nodes.lay_out(0);
        edges.lay_out(((0, 0), S::INFINITY));
        let nobody = Halt::at_wall(EventKind::Edge);
        fixed.lay_out(FixedHit { node: 0, time: S::ZERO, halt: nobody });
        watched.lay_out(0);
        beside.lay_out(0);
        for (node, home) in (0u32..).zip(homes.iter()) {
            nodes.set(home.block, home.place, node);
        }
        nodes.close();
        for graph in graphs {
            for (&(a, b), &time) in graph.edges.iter().zip(&graph.times) {
                let home = homes[a as usize];
                edges.push(home.block, ((home.place, homes[b as usize].place), time));
            }
            for hit in &graph.fixed {
                let home = homes[hit.node as usize];
                fixed.push(home.block, FixedHit { node: home.place, ..*hit });
            }
            for &node in &graph.watched {
                watched.push(homes[node as usize].block, homes[node as usize].place);
            }
            for &node in &graph.beside {
                beside.push(homes[node as usize].block, homes[node as usize].place);
            }
        }
    }

    /// Joins the components of two nodes; returns whether they were two.
    ///
    /// Union-find by Rem's algorithm, which climbs from both nodes in turn, always from the one with the larger parent, and
    /// lets each on the way have the smaller parent: Patwary, Blair, Manne, *Experiments on union-find algorithms for the
    /// disjoint-set data structure*, 2010. A parent is never larger than its child.
    fn join(&mut self, mut a: u32, mut b: u32) -> bool {
        loop {
            let (mut above_a, mut above_b) = (self.parents[a as usize], self.parents[b as usize]);
            if above_a == above_b {
                return false;
            }
            if above_a < above_b {
                (a, b) = (b, a);
                (above_a, above_b) = (above_b, above_a);
            }
            self.parents[a as usize] = above_b;
            if above_a == a {
                return true;
            }
            a = above_a;
        }
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
            + self.busy.capacity()
            + self.nodes.bytes()
            + self.edges.bytes()
            + self.fixed.bytes()
            + self.watched.bytes()
            + self.beside.bytes()
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
        keep_room(&mut self.starts);
        keep_room(&mut self.items);
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
