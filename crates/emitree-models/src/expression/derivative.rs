//! Derivatives of a graph with respect to parameters, as nodes of the same graph.
//!
//! Forward differentiation, node by node: the derivative of a node is made of those of its operands, which
//! are shared as all equal parts are. `None` is a derivative that is 0 everywhere.
//!
//! Of a table it is that of the interpolant, in the cell above at a node.
//!
//! At a kink the derivative is that of one side: `abs` has that of its argument at 0, `min` and `max` that of
//! their first argument where both are equal, `if` that of the branch that it takes, and `floor` and
//! comparisons have 0, also where they jump.

use super::graph::{Graph, Node, NodeId};
use super::operation::{Binary, Unary};
use core::f64::consts::{FRAC_2_SQRT_PI, LN_10};

/// The derivative of a node, if it is not 0 everywhere.
type Derivative = Option<NodeId>;

/// The derivatives of `root` by the parameters of these numbers.
pub(super) fn derivatives(graph: &mut Graph, root: NodeId, parameters: usize) -> Vec<NodeId> {
    let nodes = graph.nodes()[..=root].to_vec();
    let mut found = Vec::with_capacity(parameters);
    for parameter in 0..parameters {
        let mut of_nodes: Vec<Derivative> = Vec::with_capacity(nodes.len());
        for (id, node) in nodes.iter().enumerate() {
            let derivative = match *node {
                Node::Constant(_) | Node::Variable(_) => None,
                Node::Parameter(number) => (number == parameter).then(|| graph.constant(1.0)),
                Node::Unary(operation, a) => {
                    of_nodes[a].and_then(|da| graph.of_unary(operation, id, a, da))
                }
                Node::Binary(operation, a, b) => {
                    graph.of_binary(operation, [id, a, b], [of_nodes[a], of_nodes[b]])
                }
                Node::Select(condition, a, b) => graph.choice(condition, of_nodes[a], of_nodes[b]),
                Node::Table(lookup, arguments) => {
                    let arguments = &arguments[..lookup.count];
                    arguments.iter().enumerate().fold(None, |sum, (along, &argument)| {
                        let of_argument = of_nodes[argument].map(|da| {
                            let slope = graph.look_up(lookup.table, Some(along), arguments);
                            graph.product(slope, da)
                        });
                        graph.total(sum, of_argument)
                    })
                }
            };
            of_nodes.push(derivative);
        }
        let zero = graph.constant(0.0);
        found.push(of_nodes.last().copied().flatten().unwrap_or(zero));
    }
    found
}

impl Graph {
    /// The derivative of an operation on `a`, whose derivative is `da`; `id` is its value.
    fn of_unary(&mut self, operation: Unary, id: NodeId, a: NodeId, da: NodeId) -> Derivative {
        let one = self.constant(1.0);
        Some(match operation {
            Unary::Negate => self.unary(Unary::Negate, da),
            Unary::Abs => {
                let zero = self.constant(0.0);
                let is_below = self.binary(Binary::Less, a, zero);
                let negative = self.unary(Unary::Negate, da);
                self.select(is_below, negative, da)
            }
            Unary::Sqrt => {
                // Where the argument is 0 and does not change, neither does its root.
                let twice = self.sum(id, id);
                let quotient = self.binary(Binary::Divide, da, twice);
                self.unless_zero(da, quotient)
            }
            Unary::Exp => self.product(id, da),
            Unary::Ln => self.binary(Binary::Divide, da, a),
            Unary::Log10 => {
                let ln_10 = self.constant(LN_10);
                let scaled = self.product(a, ln_10);
                self.binary(Binary::Divide, da, scaled)
            }
            Unary::Sin => {
                let cosine = self.unary(Unary::Cos, a);
                self.product(cosine, da)
            }
            Unary::Cos => {
                let sine = self.unary(Unary::Sin, a);
                let product = self.product(sine, da);
                self.unary(Unary::Negate, product)
            }
            Unary::Tan => {
                let square = self.product(id, id);
                let slope = self.sum(one, square);
                self.product(slope, da)
            }
            Unary::Asin | Unary::Acos => {
                // (1 − a)(1 + a) has no cancellation near 1.
                let (below, above) = (self.binary(Binary::Subtract, one, a), self.sum(one, a));
                let product = self.product(below, above);
                let root = self.unary(Unary::Sqrt, product);
                let quotient = self.binary(Binary::Divide, da, root);
                match operation {
                    Unary::Asin => quotient,
                    _ => self.unary(Unary::Negate, quotient),
                }
            }
            Unary::Atan => {
                let square = self.product(a, a);
                let sum = self.sum(one, square);
                self.binary(Binary::Divide, da, sum)
            }
            Unary::Sinh => {
                let slope = self.unary(Unary::Cosh, a);
                self.product(slope, da)
            }
            Unary::Cosh => {
                let slope = self.unary(Unary::Sinh, a);
                self.product(slope, da)
            }
            Unary::Tanh => {
                // 1/cosh² has no cancellation where tanh is almost 1.
                let cosh = self.unary(Unary::Cosh, a);
                let quotient = self.binary(Binary::Divide, da, cosh);
                self.binary(Binary::Divide, quotient, cosh)
            }
            Unary::Erf => {
                let square = self.product(a, a);
                let negative = self.unary(Unary::Negate, square);
                let peak = self.unary(Unary::Exp, negative);
                let factor = self.constant(FRAC_2_SQRT_PI);
                let slope = self.product(factor, peak);
                self.product(slope, da)
            }
            Unary::Floor => return None,
        })
    }

    /// The derivative of an operation on two values; `id` is its value.
    fn of_binary(
        &mut self,
        operation: Binary,
        [id, a, b]: [NodeId; 3],
        [da, db]: [Derivative; 2],
    ) -> Derivative {
        if da.is_none() && db.is_none() {
            return None;
        }
        match operation {
            Binary::Add => self.total(da, db),
            Binary::Subtract => {
                let negative = db.map(|db| self.unary(Unary::Negate, db));
                match (da, db) {
                    (Some(da), Some(db)) => Some(self.binary(Binary::Subtract, da, db)),
                    _ => da.or(negative),
                }
            }
            Binary::Multiply => {
                let of_a = da.map(|da| self.product(da, b));
                let of_b = db.map(|db| self.product(a, db));
                self.total(of_a, of_b)
            }
            Binary::Divide => {
                // (da − (a/b) db)/b
                let of_b = db.map(|db| {
                    let product = self.product(id, db);
                    self.unary(Unary::Negate, product)
                });
                let sum = self.total(da, of_b)?;
                Some(self.binary(Binary::Divide, sum, b))
            }
            Binary::Power => {
                let of_a = da.map(|da| self.by_base(a, b, da));
                let of_b = db.map(|db| self.by_exponent(id, a, db));
                self.total(of_a, of_b)
            }
            Binary::Atan2 => {
                // Of (y, x): (x dy − y dx)/(x² + y²).
                let (y, x) = (a, b);
                let of_y = da.map(|dy| self.product(x, dy));
                let of_x = db.map(|dx| {
                    let product = self.product(y, dx);
                    self.unary(Unary::Negate, product)
                });
                let sum = self.total(of_y, of_x)?;
                let squares = [x, y].map(|side| self.product(side, side));
                let square = self.sum(squares[0], squares[1]);
                Some(self.binary(Binary::Divide, sum, square))
            }
            Binary::Min | Binary::Max => {
                let takes_b = match operation {
                    Binary::Min => self.binary(Binary::Less, b, a),
                    _ => self.binary(Binary::Less, a, b),
                };
                // A NaN is ignored.
                let is_nan = self.binary(Binary::NotEqual, a, a);
                let of_others = self.choice(is_nan, db, da);
                self.choice(takes_b, db, of_others)
            }
            Binary::Less | Binary::LessEqual | Binary::Equal | Binary::NotEqual => None,
        }
    }

    /// b·a^(b−1)·da; 0 where b is 0, also at a = 0.
    fn by_base(&mut self, a: NodeId, b: NodeId, da: NodeId) -> NodeId {
        let one = self.constant(1.0);
        let less = self.binary(Binary::Subtract, b, one);
        let power = self.binary(Binary::Power, a, less);
        let slope = self.product(b, power);
        let slope = self.unless_zero(b, slope);
        self.product(slope, da)
    }

    /// a^b·ln(a)·db; 0 where the power is 0, as its limit at a = 0 is.
    fn by_exponent(&mut self, power: NodeId, a: NodeId, db: NodeId) -> NodeId {
        let ln = self.unary(Unary::Ln, a);
        let slope = self.product(power, ln);
        let slope = self.unless_zero(power, slope);
        self.product(slope, db)
    }

    /// A value where another is not 0, else 0.
    fn unless_zero(&mut self, other: NodeId, value: NodeId) -> NodeId {
        let zero = self.constant(0.0);
        self.select(other, value, zero)
    }

    /// The derivative of one of two branches.
    fn choice(&mut self, condition: NodeId, then: Derivative, otherwise: Derivative) -> Derivative {
        if then.is_none() && otherwise.is_none() {
            return None;
        }
        let zero = self.constant(0.0);
        Some(self.select(condition, then.unwrap_or(zero), otherwise.unwrap_or(zero)))
    }

    fn total(&mut self, a: Derivative, b: Derivative) -> Derivative {
        match (a, b) {
            (Some(a), Some(b)) => Some(self.sum(a, b)),
            (a, b) => a.or(b),
        }
    }

    fn sum(&mut self, a: NodeId, b: NodeId) -> NodeId {
        self.binary(Binary::Add, a, b)
    }

    fn product(&mut self, a: NodeId, b: NodeId) -> NodeId {
        self.binary(Binary::Multiply, a, b)
    }
}
