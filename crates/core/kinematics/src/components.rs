//! Connected components of the motion-sphere intersection graph.

/// Returns for each of `count` nodes the number of its component, and how many there are; components are numbered in
/// the order of their first nodes.
///
/// Union-find with path halving, always towards the smaller node (Tarjan and van Leeuwen 1984): near-linear in the
/// number of edges.
#[doc(alias = "island")]
pub(crate) fn components(count: usize, edges: &[(u32, u32)]) -> (Vec<u32>, usize) {
    let nodes = 0..u32::try_from(count).expect("objects have u32 ids");
    let mut parent: Vec<u32> = nodes.clone().collect();
    for &(a, b) in edges {
        let (a, b) = (root(&mut parent, a), root(&mut parent, b));
        let (small, large) = if a < b { (a, b) } else { (b, a) };
        parent[large as usize] = small;
    }
    let mut number = vec![0; count];
    let mut found = 0;
    for node in nodes {
        let top = root(&mut parent, node);
        if top == node {
            number[node as usize] = found;
            found += 1;
        } else {
            number[node as usize] = number[top as usize];
        }
    }
    (number, found as usize)
}

fn root(parent: &mut [u32], mut node: u32) -> u32 {
    while parent[node as usize] != node {
        let above = parent[parent[node as usize] as usize];
        parent[node as usize] = above;
        node = above;
    }
    node
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nodes_are_in_one_component_when_a_path_joins_them() {
        let check = |count, edges: &[(u32, u32)], expected: &[u32]| {
            assert_eq!(components(count, edges).0, expected, "{edges:?}");
        };
        check(0, &[], &[]);
        check(3, &[], &[0, 1, 2]);
        check(4, &[(0, 3), (3, 1)], &[0, 0, 1, 0]);
        check(5, &[(4, 3), (2, 1), (3, 2)], &[0, 1, 1, 1, 1]);
    }
}
