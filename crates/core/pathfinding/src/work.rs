//! How much is planned in a cycle, by what is looked at and never by a clock.

/// What a path along walls counts: about as many looks as it takes as long as.
pub(crate) const PATH: u64 = 1 << 11;

/// What has been looked at, and how much may be. One *look* is the least thing that is counted: a pair of straight pieces that are
/// compared, a point of a lattice, an agent that is moved by a step; some tens of nanoseconds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Work {
    budget: u64,
    done: u64,
}

impl Work {
    /// Returns no work done yet.
    pub(crate) fn new(budget: u64) -> Self {
        Self { budget, done: 0 }
    }

    /// Whether another step may begin; it ends however much it is.
    pub(crate) fn is_left(&self) -> bool {
        self.done < self.budget
    }

    pub(crate) fn add(&mut self, looks: u64) {
        self.done += looks;
    }

    pub(crate) fn done(&self) -> u64 {
        self.done
    }
}
