//! Memory for what a cycle needs anew, so that a warm cycle takes none.

/// Returns the room of lists that are filled for each component, in a world with so many active objects: one component
/// larger than any before would take memory in the middle of a match. A quarter of all in one chain is rare.
pub(crate) fn component_room(active: usize) -> usize {
    (active / 4).clamp(512, 8192)
}

/// Sees to it that a list has a capacity of at least so much.
pub(crate) fn make_room<T>(list: &mut Vec<T>, capacity: usize) {
    list.reserve_exact(capacity.saturating_sub(list.len()));
}

/// Entries to spare in any list that differs from cycle to cycle: short ones differ by more than their length.
const SPARE: usize = 128;

/// Sees to it that a list that was filled in a cycle has room to spare, since the number differs from cycle to cycle: where
/// less than a sixteenth is left, there will be as much again.
pub(crate) fn keep_room<T>(list: &mut Vec<T>) {
    if list.capacity() < list.len() + list.len() / 16 + SPARE / 8 {
        list.reserve_exact(list.len() + SPARE);
    }
}
