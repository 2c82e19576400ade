//! The expression as a list of instructions on a small file of registers.
//!
//! Invariants: an instruction writes no register that it reads; every register read was written
//! before; constants are part of the instructions and take no register.

use super::graph::{Graph, Node, NodeId};
use super::operation::{Binary, Lookup, Unary, Variable};
use crate::table::Table;

/// A register: one value for each sample of a block.
pub(super) type Register = usize;

/// What an instruction reads.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Operand {
    Register(Register),
    Constant(f64),
}

/// What an instruction computes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Operation {
    Load(Variable),
    Unary(Unary, Operand),
    Binary(Binary, Operand, Operand),
    /// if(condition, then, otherwise)
    Select(Operand, Operand, Operand),
    /// A table's value or slope; see [`Node::Table`].
    Table(Lookup, [Operand; Table::MAX_AXES]),
}

/// One step: an operation and the register that it writes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Instruction {
    pub(super) to: Register,
    pub(super) operation: Operation,
}

/// Instructions in order, the number of registers that they need, and where the values are then.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Tape {
    pub(super) instructions: Vec<Instruction>,
    pub(super) registers: usize,
    pub(super) results: Vec<Operand>,
}

impl Tape {
    /// The instructions for the values of `roots`: only what they depend on, a register given up as
    /// soon as its last reader has read it. All parameters have values.
    pub(super) fn new(graph: &Graph, roots: &[NodeId]) -> Self {
        let nodes = graph.nodes();
        let last_reader = last_readers(nodes, roots);
        let mut place = vec![Operand::Constant(f64::NAN); nodes.len()];
        let mut instructions = Vec::new();
        let mut free: Vec<Register> = Vec::new();
        let mut registers = 0;
        for (id, node) in nodes.iter().enumerate() {
            if last_reader[id].is_none() {
                continue;
            }
            let operation = match *node {
                Node::Constant(bits) => {
                    place[id] = Operand::Constant(f64::from_bits(bits));
                    continue;
                }
                // A parameter without a value is no number.
                Node::Parameter(_) => continue,
                Node::Variable(variable) => Operation::Load(variable),
                Node::Unary(operation, a) => Operation::Unary(operation, place[a]),
                Node::Binary(operation, a, b) => Operation::Binary(operation, place[a], place[b]),
                Node::Select(c, a, b) => Operation::Select(place[c], place[a], place[b]),
                Node::Table(lookup, arguments) => {
                    Operation::Table(lookup, arguments.map(|argument| place[argument]))
                }
            };
            // Taken before the operands' registers are given up: never one of them.
            let to = free.pop().unwrap_or_else(|| {
                registers += 1;
                registers - 1
            });
            place[id] = Operand::Register(to);
            instructions.push(Instruction { to, operation });
            for (i, operand) in operands(node).enumerate() {
                // An operand that is read twice, as in x*x, is given up once.
                let again = operands(node).take(i).any(|earlier| earlier == operand);
                let done = last_reader[operand] == Some(id) && !again;
                if let (true, Operand::Register(register)) = (done, place[operand]) {
                    free.push(register);
                }
            }
        }
        let results = roots.iter().map(|&root| place[root]).collect();
        Self { instructions, registers, results }
    }
}

/// The last node that reads each node; `None` for nodes that no root depends on.
fn last_readers(nodes: &[Node], roots: &[NodeId]) -> Vec<Option<NodeId>> {
    let mut last = vec![None; nodes.len()];
    roots.iter().for_each(|&root| last[root] = Some(nodes.len()));
    for id in (0..nodes.len()).rev() {
        if last[id].is_some() {
            for operand in operands(&nodes[id]) {
                last[operand] = last[operand].or(Some(id));
            }
        }
    }
    last
}

fn operands(node: &Node) -> impl Iterator<Item = NodeId> {
    let operands = match *node {
        Node::Constant(_) | Node::Variable(_) | Node::Parameter(_) => [None; 3],
        Node::Unary(_, a) => [Some(a), None, None],
        Node::Binary(_, a, b) => [Some(a), Some(b), None],
        Node::Select(c, a, b) => [Some(c), Some(a), Some(b)],
        Node::Table(_, [a, b, c]) => [Some(a), Some(b), Some(c)],
    };
    operands.into_iter().flatten()
}

#[cfg(test)]
mod tests {
    use super::super::inputs::Inputs;
    use super::super::parser::parse;
    use super::*;
    use std::collections::BTreeMap;

    fn tape(text: &str) -> Tape {
        let constants = BTreeMap::from([("a".to_owned(), 100.0)]);
        let parsed = parse(text, &constants, &[], &Inputs::default()).unwrap();
        Tape::new(&parsed.graph, &[parsed.root])
    }

    /// (instructions, registers)
    fn size(text: &str) -> (usize, usize) {
        let tape = tape(text);
        (tape.instructions.len(), tape.registers)
    }

    #[test]
    fn constants_take_no_instruction() {
        assert_eq!(size("sqrt(2)/3 + a"), (0, 0));
        let value = Operand::Constant(2.0_f64.sqrt() / 3.0 + 100.0);
        assert_eq!(tape("sqrt(2)/3 + a").results, [value]);
        assert_eq!(size("x"), (1, 1));
        assert_eq!(size("a*x + 1"), (3, 2));
        assert_eq!(size("if(1 < 2, x, exp(y))"), (1, 1));
    }

    #[test]
    fn equal_parts_are_computed_once() {
        assert_eq!(size("exp(-x^2)"), (4, 2));
        assert_eq!(size("exp(-x^2) + sin(exp(-(x*x)))"), (6, 3));
        assert_eq!(size("(x + y)*(y + x)"), (4, 3));
        // Three loads, three squares, two sums, one root.
        assert_eq!(size("r"), (9, 4));
        assert_eq!(size("(x^2 + y^2 + z^2)/r"), (10, 3));
    }

    #[test]
    fn equation_8_needs_few_registers() {
        let text = "(sin(5*x)*sin(7*y)*sin(11*z)/10)^2 + exp(-a*(x-sqrt(2)/3)^2/sqrt(2) \
                    - a*(y-sqrt(7)/5)^2*sqrt(2) - a*(z-sqrt(6)/5)^2*sqrt(3))";
        assert_eq!(size(text), (29, 6));
    }

    #[test]
    fn no_instruction_writes_what_it_reads() {
        let tape = tape("if(x < y, x*x + min(x, y, z), atan2(y, x)^x) - (x/y - y/x)^3/(x*y)");
        let mut written = vec![false; tape.registers];
        for Instruction { to, operation } in tape.instructions {
            let reads = match operation {
                Operation::Load(_) => vec![],
                Operation::Unary(_, a) => vec![a],
                Operation::Binary(_, a, b) => vec![a, b],
                Operation::Select(c, a, b) => vec![c, a, b],
                Operation::Table(_, arguments) => arguments.to_vec(),
            };
            for operand in reads {
                if let Operand::Register(register) = operand {
                    assert_ne!(register, to);
                    assert!(written[register]);
                }
            }
            written[to] = true;
        }
    }

    /// All arguments wait in registers for the first comparison: giving one up must not depend on the rest.
    #[test]
    fn a_hundred_thousand_arguments_are_no_more_than_that() {
        let count = 100_000;
        let arguments: Vec<String> = (1..=count).map(|k| format!("x*{k}")).collect();
        let start = std::time::Instant::now();
        let tape = tape(&format!("max({})", arguments.join(", ")));
        // A load, a product for each but the first, and a comparison for each but one.
        assert_eq!(tape.instructions.len(), 1 + 2 * (count - 1));
        // Some 0.1 s; 20 s when all registers that were free were compared with each one given up.
        assert!(start.elapsed().as_secs() < 5, "{:?}", start.elapsed());
    }

    #[test]
    fn a_long_sum_of_shared_parts_reuses_registers() {
        let text = (1..200).map(|k| format!("sin({k}*x)*x")).collect::<Vec<_>>().join(" + ");
        assert_eq!(tape(&text).registers, 4);
    }
}
