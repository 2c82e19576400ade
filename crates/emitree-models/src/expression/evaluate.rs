//! Runs a tape on many samples, block by block.
//!
//! A block is large enough that the cost of choosing an instruction vanishes against its loop, and
//! small enough that all registers of an ordinary expression stay in the fastest cache. Every
//! operation acts on each sample alone, so that a value does not depend on its neighbours.

use super::operation::{Binary, Unary, Variable, equal, larger, smaller, truth};
use super::tape::{Operand, Operation, Register, Tape};
use core::cell::Cell;
use emitree::Samples;

/// Samples in a block: 2 kB a register.
pub(super) const BLOCK: usize = 256;

/// Registers of one thread, kept from one call to the next.
type Registers = Vec<Box<[f64]>>;

thread_local! {
    static REGISTERS: Cell<Registers> = const { Cell::new(Vec::new()) };
}

/// Writes the tape's value at sample `i` to `rates[i]`.
pub(super) fn evaluate(tape: &Tape, samples: &Samples<'_>, rates: &mut [f64]) {
    let result = match tape.result {
        Operand::Constant(value) => return rates.fill(value),
        Operand::Register(register) => register,
    };
    let mut registers = REGISTERS.take();
    if registers.len() < tape.registers {
        registers.resize_with(tape.registers, || vec![0.0; BLOCK].into_boxed_slice());
    }
    let positions = samples.positions().chunks(BLOCK);
    let directions = samples.directions().chunks(BLOCK);
    // A batch without energies has none in any block.
    let energies = samples.energies().chunks(BLOCK).chain(core::iter::repeat(&[][..]));
    let blocks = positions.zip(directions).zip(energies);
    for (((positions, directions), energies), rates) in blocks.zip(rates.chunks_mut(BLOCK)) {
        let block = Samples::new(positions, directions).at_energies(energies);
        run(tape, &block, &mut registers);
        rates.copy_from_slice(&registers[result][..rates.len()]);
    }
    REGISTERS.set(registers);
}

/// Runs the tape on one block of at most [`BLOCK`] samples.
fn run(tape: &Tape, block: &Samples<'_>, registers: &mut Registers) {
    let lanes = block.len();
    for instruction in &tape.instructions {
        // The register to write is never one to read: taking it out satisfies the borrow checker
        // at the cost of moving a pointer.
        let mut taken = core::mem::take(&mut registers[instruction.to]);
        let out = &mut taken[..lanes];
        match instruction.operation {
            Operation::Load(Variable::Position(axis)) => load(out, block.positions(), axis),
            Operation::Load(Variable::Direction(axis)) => load(out, block.directions(), axis),
            Operation::Load(Variable::Energy) => load_energies(out, block.energies()),
            Operation::Unary(operation, a) => unary(operation, out, Lanes::of(a, registers, lanes)),
            Operation::Binary(operation, a, b) => {
                let (a, b) = (Lanes::of(a, registers, lanes), Lanes::of(b, registers, lanes));
                binary(operation, out, a, b);
            }
            Operation::Select(condition, then, otherwise) => {
                map(out, Lanes::of(otherwise, registers, lanes), |b| b);
                let condition = Lanes::of(condition, registers, lanes);
                replace_where(out, condition, Lanes::of(then, registers, lanes));
            }
        }
        registers[instruction.to] = taken;
    }
}

/// An operand over a block: a value for each sample, or the same for all.
#[derive(Clone, Copy)]
enum Lanes<'a> {
    Each(&'a [f64]),
    Same(f64),
}

impl<'a> Lanes<'a> {
    fn of(operand: Operand, registers: &'a Registers, lanes: usize) -> Self {
        let each = |register: Register| &registers[register][..lanes];
        match operand {
            Operand::Register(register) => Self::Each(each(register)),
            Operand::Constant(value) => Self::Same(value),
        }
    }
}

fn load(out: &mut [f64], vectors: &[[f64; 3]], axis: u8) {
    for (out, vector) in out.iter_mut().zip(vectors) {
        *out = vector[usize::from(axis)];
    }
}

/// Without an energy axis there is no energy, and it is not a number.
fn load_energies(out: &mut [f64], energies: &[f64]) {
    if energies.is_empty() {
        out.fill(f64::NAN);
    } else {
        out.copy_from_slice(energies);
    }
}

/// Cheap operations are written out, so that their loops become vector instructions.
fn unary(operation: Unary, out: &mut [f64], a: Lanes<'_>) {
    match operation {
        Unary::Negate => map(out, a, |a| -a),
        Unary::Abs => map(out, a, f64::abs),
        Unary::Sqrt => map(out, a, f64::sqrt),
        _ => map(out, a, operation.scalar()),
    }
}

fn binary(operation: Binary, out: &mut [f64], a: Lanes<'_>, b: Lanes<'_>) {
    match operation {
        Binary::Add => map2(out, a, b, |a, b| a + b),
        Binary::Subtract => map2(out, a, b, |a, b| a - b),
        Binary::Multiply => map2(out, a, b, |a, b| a * b),
        Binary::Divide => map2(out, a, b, |a, b| a / b),
        Binary::Min => map2(out, a, b, smaller),
        Binary::Max => map2(out, a, b, larger),
        Binary::Less => map2(out, a, b, |a, b| truth(a < b)),
        Binary::LessEqual => map2(out, a, b, |a, b| truth(a <= b)),
        Binary::Equal => map2(out, a, b, equal),
        Binary::NotEqual => map2(out, a, b, |a, b| 1.0 - equal(a, b)),
        Binary::Power | Binary::Atan2 => map2(out, a, b, operation.scalar()),
    }
}

fn map(out: &mut [f64], a: Lanes<'_>, f: impl Fn(f64) -> f64) {
    match a {
        Lanes::Each(a) => out.iter_mut().zip(a).for_each(|(out, &a)| *out = f(a)),
        Lanes::Same(a) => out.fill(f(a)),
    }
}

fn map2(out: &mut [f64], a: Lanes<'_>, b: Lanes<'_>, f: impl Fn(f64, f64) -> f64) {
    match (a, b) {
        (Lanes::Each(a), Lanes::Each(b)) => {
            out.iter_mut().zip(a.iter().zip(b)).for_each(|(out, (&a, &b))| *out = f(a, b));
        }
        (_, Lanes::Same(b)) => map(out, a, |a| f(a, b)),
        (Lanes::Same(a), _) => map(out, b, |b| f(a, b)),
    }
}

/// Replaces the values where the condition holds.
fn replace_where(out: &mut [f64], condition: Lanes<'_>, then: Lanes<'_>) {
    let choose = |condition: f64, then: f64, otherwise: f64| {
        if condition == 0.0 { otherwise } else { then }
    };
    match (condition, then) {
        (Lanes::Each(condition), Lanes::Each(then)) => {
            for (out, (&condition, &then)) in out.iter_mut().zip(condition.iter().zip(then)) {
                *out = choose(condition, then, *out);
            }
        }
        (Lanes::Each(condition), Lanes::Same(then)) => {
            for (out, &condition) in out.iter_mut().zip(condition) {
                *out = choose(condition, then, *out);
            }
        }
        (Lanes::Same(condition), _) => {
            if condition != 0.0 {
                map(out, then, |then| then);
            }
        }
    }
}
