//! Sets of nodes that are joined one after the other (union-find). Each node points to another of its
//! set, and the root to itself.

/// Root of a node's set. Paths become shorter on the way.
pub(super) fn root(parent: &mut [u32], mut node: u32) -> u32 {
    while parent[node as usize] != node {
        let up = parent[parent[node as usize] as usize];
        parent[node as usize] = up;
        node = up;
    }
    node
}

/// Joins the sets of two nodes. The smaller root stays.
pub(super) fn join(parent: &mut [u32], nodes: [u32; 2]) {
    let [a, b] = nodes.map(|node| root(parent, node));
    parent[a.max(b) as usize] = a.min(b);
}
