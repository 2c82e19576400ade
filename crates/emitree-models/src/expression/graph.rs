//! The expression as a graph in which equal parts are one node.
//!
//! Invariants: a node's operands come before it; no two nodes are equal; a node is a constant if
//! all its operands are, but for those of tables.

use super::operation::{Binary, Lookup, Unary, Variable};
use crate::table::Table;
use std::collections::HashMap;

/// Largest |n| for which xⁿ becomes products. Rounding grows as n/2 units in the last place, the
/// price of being ten times faster than the general power.
const MAX_INTEGER_POWER: f64 = 64.0;

/// A place in the graph.
pub(super) type NodeId = usize;

/// One operation, or an input; operands by their place in the graph.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Node {
    /// A number, by its bits: 0 and −0 are two constants.
    Constant(u64),
    Variable(Variable),
    /// A constant of this number that the graph is differentiated by, before it has its value.
    Parameter(usize),
    Unary(Unary, NodeId),
    Binary(Binary, NodeId, NodeId),
    /// if(condition, then, otherwise)
    Select(NodeId, NodeId, NodeId),
    /// Places beyond the number of arguments repeat the first of them.
    Table(Lookup, [NodeId; Table::MAX_AXES]),
}

/// A growing graph of nodes.
#[derive(Debug, Default)]
pub(super) struct Graph {
    nodes: Vec<Node>,
    known: HashMap<Node, NodeId>,
}

impl Graph {
    /// All nodes, operands before the nodes that use them.
    pub(super) fn nodes(&self) -> &[Node] {
        &self.nodes
    }

    /// The node's value if it does not depend on the sample.
    pub(super) fn value(&self, id: NodeId) -> Option<f64> {
        match self.nodes[id] {
            Node::Constant(bits) => Some(f64::from_bits(bits)),
            _ => None,
        }
    }

    /// The place of this node, which is added if it is new.
    fn share(&mut self, node: Node) -> NodeId {
        *self.known.entry(node).or_insert_with(|| {
            self.nodes.push(node);
            self.nodes.len() - 1
        })
    }

    pub(super) fn constant(&mut self, value: f64) -> NodeId {
        self.share(Node::Constant(value.to_bits()))
    }

    pub(super) fn variable(&mut self, variable: Variable) -> NodeId {
        self.share(Node::Variable(variable))
    }

    pub(super) fn parameter(&mut self, number: usize) -> NodeId {
        self.share(Node::Parameter(number))
    }

    /// The graph of the same `roots` in which parameters are constants of these values, and their places in it.
    pub(super) fn with_values(&self, roots: &[NodeId], values: &[f64]) -> (Self, Vec<NodeId>) {
        let mut graph = Self::default();
        let roots = graph.take_in(self, roots, values);
        (graph, roots)
    }

    /// Adds the nodes of another graph, whose parameters are constants of these values, and returns the places of
    /// its `roots` here.
    pub(super) fn take_in(
        &mut self,
        other: &Self,
        roots: &[NodeId],
        values: &[f64],
    ) -> Vec<NodeId> {
        let mut places: Vec<NodeId> = Vec::with_capacity(other.nodes.len());
        for node in &other.nodes {
            let place = match *node {
                Node::Constant(bits) => self.share(Node::Constant(bits)),
                Node::Variable(variable) => self.variable(variable),
                Node::Parameter(number) => self.constant(values[number]),
                Node::Unary(operation, a) => self.unary(operation, places[a]),
                Node::Binary(operation, a, b) => self.binary(operation, places[a], places[b]),
                Node::Select(c, a, b) => self.select(places[c], places[a], places[b]),
                Node::Table(lookup, arguments) => {
                    self.share(Node::Table(lookup, arguments.map(|a| places[a])))
                }
            };
            places.push(place);
        }
        roots.iter().map(|&root| places[root]).collect()
    }

    /// r = √(x² + y² + z²)
    pub(super) fn radius(&mut self) -> NodeId {
        let squares = [0, 1, 2].map(|axis| {
            let component = self.variable(Variable::Position(axis));
            self.binary(Binary::Multiply, component, component)
        });
        let sum = self.binary(Binary::Add, squares[0], squares[1]);
        let sum = self.binary(Binary::Add, sum, squares[2]);
        self.unary(Unary::Sqrt, sum)
    }

    pub(super) fn unary(&mut self, operation: Unary, a: NodeId) -> NodeId {
        match self.value(a) {
            Some(value) => self.constant(operation.scalar()(value)),
            None => self.share(Node::Unary(operation, a)),
        }
    }

    pub(super) fn binary(&mut self, operation: Binary, a: NodeId, b: NodeId) -> NodeId {
        let (left, right) = (self.value(a), self.value(b));
        if let (Some(left), Some(right)) = (left, right) {
            return self.constant(operation.scalar()(left, right));
        }
        match (operation, left, right) {
            // Exact for every value, unlike 0 * x and x + 0.
            (Binary::Multiply, Some(1.0), _) => b,
            (Binary::Multiply | Binary::Divide, _, Some(1.0)) => a,
            (Binary::Power, _, Some(power)) if is_small_integer(power) => {
                self.integer_power(a, power)
            }
            _ if operation.commutes() => self.share(Node::Binary(operation, a.min(b), a.max(b))),
            _ => self.share(Node::Binary(operation, a, b)),
        }
    }

    pub(super) fn select(&mut self, condition: NodeId, then: NodeId, otherwise: NodeId) -> NodeId {
        match self.value(condition) {
            Some(0.0) => otherwise,
            Some(_) => then,
            None if then == otherwise => then,
            None => self.share(Node::Select(condition, then, otherwise)),
        }
    }

    /// A table's value, or its derivative by one of its arguments, which are 1 to as many as it may have.
    pub(super) fn look_up(
        &mut self,
        table: usize,
        along: Option<usize>,
        arguments: &[NodeId],
    ) -> NodeId {
        let mut all = [arguments[0]; Table::MAX_AXES];
        all[..arguments.len()].copy_from_slice(arguments);
        self.share(Node::Table(Lookup { table, count: arguments.len(), along }, all))
    }

    /// xⁿ by squaring and multiplying, the bits of n from the lowest.
    fn integer_power(&mut self, base: NodeId, power: f64) -> NodeId {
        let mut rest = power.abs();
        let mut square = base;
        let mut product = None;
        while rest >= 1.0 {
            if rest % 2.0 >= 1.0 {
                product = Some(match product {
                    None => square,
                    Some(product) => self.binary(Binary::Multiply, product, square),
                });
            }
            rest = (rest / 2.0).floor();
            if rest >= 1.0 {
                square = self.binary(Binary::Multiply, square, square);
            }
        }
        let one = self.constant(1.0);
        match product {
            None => one,
            Some(product) if power < 0.0 => self.binary(Binary::Divide, one, product),
            Some(product) => product,
        }
    }
}

fn is_small_integer(power: f64) -> bool {
    power.abs() <= MAX_INTEGER_POWER && power.fract().abs() <= 0.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_parts_are_one_node() {
        let mut graph = Graph::default();
        let x = graph.variable(Variable::Position(0));
        let y = graph.variable(Variable::Position(1));
        assert_eq!(x, graph.variable(Variable::Position(0)));
        let sum = graph.binary(Binary::Add, x, y);
        assert_eq!(sum, graph.binary(Binary::Add, y, x));
        let difference = graph.binary(Binary::Subtract, x, y);
        assert_ne!(difference, graph.binary(Binary::Subtract, y, x));
        assert_eq!(graph.nodes().len(), 5);
    }

    #[test]
    fn constants_fold() {
        let mut graph = Graph::default();
        let two = graph.constant(2.0);
        let root = graph.unary(Unary::Sqrt, two);
        assert_eq!(graph.value(root), Some(2.0_f64.sqrt()));
        let power = graph.binary(Binary::Power, two, two);
        assert_eq!(graph.value(power), Some(4.0));
        let x = graph.variable(Variable::Position(0));
        assert_eq!(graph.select(two, x, root), x);
        let one = graph.constant(1.0);
        assert_eq!(graph.binary(Binary::Multiply, one, x), x);
        assert_eq!(graph.binary(Binary::Divide, x, one), x);
    }

    #[test]
    fn zero_and_minus_zero_stay_apart() {
        let mut graph = Graph::default();
        assert_ne!(graph.constant(0.0), graph.constant(-0.0));
    }

    #[test]
    fn small_integer_powers_are_products() {
        let products = |power: f64| {
            let mut graph = Graph::default();
            let x = graph.variable(Variable::Position(0));
            let power = graph.constant(power);
            graph.binary(Binary::Power, x, power);
            let multiplies = |node: &&Node| matches!(node, Node::Binary(Binary::Multiply, ..));
            let powers = |node: &&Node| matches!(node, Node::Binary(Binary::Power, ..));
            let count = |kind: &dyn Fn(&&Node) -> bool| graph.nodes().iter().filter(kind).count();
            (count(&multiplies), count(&powers))
        };
        assert_eq!(products(0.0), (0, 0));
        assert_eq!(products(1.0), (0, 0));
        assert_eq!(products(2.0), (1, 0));
        assert_eq!(products(-3.0), (2, 0));
        assert_eq!(products(7.0), (4, 0));
        assert_eq!(products(64.0), (6, 0));
        assert_eq!(products(65.0), (0, 1));
        assert_eq!(products(0.5), (0, 1));
    }
}
