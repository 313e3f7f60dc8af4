//! Circles and order of a directed graph.

use std::collections::{BTreeMap, BTreeSet};

/// Groups of two nodes or more that reach one another, each sorted.
pub fn circles<T: Ord + Clone>(edges: &BTreeMap<T, BTreeSet<T>>) -> Vec<Vec<T>> {
    let mut groups = components(edges);
    groups.retain(|group| group.len() > 1);
    groups
}

/// All nodes, each before those that its edges lead to; nodes of a circle follow one another.
pub fn order<T: Ord + Clone>(edges: &BTreeMap<T, BTreeSet<T>>) -> Vec<T> {
    components(edges).into_iter().rev().flatten().collect()
}

/// Strongly connected components (Tarjan's algorithm), each sorted, those that edges lead to first.
fn components<T: Ord + Clone>(edges: &BTreeMap<T, BTreeSet<T>>) -> Vec<Vec<T>> {
    let mut search = Search {
        edges,
        order: BTreeMap::new(),
        lowest: BTreeMap::new(),
        stack: Vec::new(),
        found: Vec::new(),
    };
    for node in edges.keys() {
        if !search.order.contains_key(node) {
            search.visit(node);
        }
    }
    search.found
}

struct Search<'a, T> {
    edges: &'a BTreeMap<T, BTreeSet<T>>,
    /// When each node was first visited.
    order: BTreeMap<&'a T, usize>,
    /// Earliest visited node that is on the stack and reached from it.
    lowest: BTreeMap<&'a T, usize>,
    stack: Vec<&'a T>,
    found: Vec<Vec<T>>,
}

impl<'a, T: Ord + Clone> Search<'a, T> {
    fn visit(&mut self, node: &'a T) -> usize {
        let number = self.order.len();
        self.order.insert(node, number);
        self.lowest.insert(node, number);
        self.stack.push(node);
        let mut lowest = number;
        for next in self.edges.get(node).into_iter().flatten() {
            if !self.order.contains_key(next) {
                lowest = lowest.min(self.visit(next));
            } else if self.stack.contains(&next) {
                lowest = lowest.min(self.order[next]);
            }
        }
        self.lowest.insert(node, lowest);
        if lowest == number {
            let start = self
                .stack
                .iter()
                .position(|n| *n == node)
                .unwrap_or_default();
            let mut group: Vec<T> = self.stack.split_off(start).into_iter().cloned().collect();
            group.sort();
            self.found.push(group);
        }
        lowest
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn graph(edges: &[(u8, u8)]) -> BTreeMap<u8, BTreeSet<u8>> {
        let mut graph: BTreeMap<u8, BTreeSet<u8>> = BTreeMap::new();
        for (from, to) in edges {
            graph.entry(*from).or_default().insert(*to);
        }
        graph
    }

    #[test]
    fn circles_are_found_and_nothing_else() {
        assert!(circles(&graph(&[(1, 2), (2, 3), (1, 3), (4, 1)])).is_empty());
        let found = circles(&graph(&[
            (1, 2),
            (2, 3),
            (3, 1),
            (3, 4),
            (4, 5),
            (5, 4),
            (6, 1),
        ]));
        assert_eq!(found, [vec![4, 5], vec![1, 2, 3]]);
    }

    #[test]
    fn order_puts_nodes_before_those_that_edges_lead_to() {
        assert_eq!(order(&graph(&[(1, 2), (3, 1), (2, 4)])), [3, 1, 2, 4]);
    }
}
