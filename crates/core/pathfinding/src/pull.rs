//! From a way of many short steps to a few straight legs.

use glam::DVec2;

/// Leaves of the points of a way only those at which it has to turn, the first and the last included.
///
/// From each point it goes to the last one that is straight ahead, as far as a search in steps that double can tell: points
/// beyond one that is hidden are not looked at. Each point must be clear from the one before it.
#[doc(alias = "string_pulling")]
pub(crate) fn pull(is_clear: impl Fn(DVec2, DVec2) -> bool, points: &mut Vec<DVec2>) {
    let last = points.len() - 1;
    let (mut kept, mut from) = (1, 0);
    while from < last {
        let origin = points[from];
        let is_seen = |index: usize| is_clear(origin, points[index]);
        let (mut seen, mut hidden, mut stride) = (from + 1, last + 1, 2);
        while seen < last {
            let ahead = (from + stride).min(last);
            if !is_seen(ahead) {
                hidden = ahead;
                break;
            }
            seen = ahead;
            stride *= 2;
        }
        while hidden - seen > 1 && seen < last {
            let middle = seen + (hidden - seen) / 2;
            if is_seen(middle) {
                seen = middle;
            } else {
                hidden = middle;
            }
        }
        // What is overwritten lies before `seen` and is not needed any more.
        points[kept] = points[seen];
        kept += 1;
        from = seen;
    }
    points.truncate(kept);
}
