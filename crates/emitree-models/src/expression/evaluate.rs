//! Runs a tape on many samples, block by block.
//!
//! A block is large enough that the cost of choosing an instruction vanishes against its loop, and
//! small enough that all registers of an ordinary expression stay in the fastest cache. Every
//! operation acts on each sample alone, so that a value does not depend on its neighbours.

use super::lanes::{Lanes, binary, copy, load, replace_where, unary};
use super::operation::Variable;
use super::tape::{Operand, Operation, Tape};
use core::cell::Cell;
use emitree::Samples;

/// Samples in a block: 2 kB a register.
pub(super) const BLOCK: usize = 256;

/// Registers of one thread, kept from one call to the next.
type Registers = Vec<Box<[f64]>>;

thread_local! {
    static REGISTERS: Cell<Registers> = const { Cell::new(Vec::new()) };
}

/// Writes the tape's value number `k` at sample `i` to `outputs[k][i]`.
pub(super) fn evaluate(tape: &Tape, samples: &Samples<'_>, outputs: &mut [&mut [f64]]) {
    let mut is_constant = true;
    for (result, out) in tape.results.iter().zip(outputs.iter_mut()) {
        match result {
            Operand::Constant(value) => out.fill(*value),
            Operand::Register(_) => is_constant = false,
        }
    }
    if is_constant {
        return;
    }
    let mut registers = REGISTERS.take();
    if registers.len() < tape.registers {
        registers.resize_with(tape.registers, || vec![0.0; BLOCK].into_boxed_slice());
    }
    let positions = samples.positions().chunks(BLOCK);
    let directions = samples.directions().chunks(BLOCK);
    // A batch without energies has none in any block.
    let energies = samples.energies().chunks(BLOCK).chain(core::iter::repeat(&[][..]));
    let mut first = 0;
    for ((positions, directions), energies) in positions.zip(directions).zip(energies) {
        let block = Samples::new(positions, directions).at_energies(energies);
        run(tape, &block, &mut registers);
        let places = first..first + block.len();
        for (result, out) in tape.results.iter().zip(outputs.iter_mut()) {
            if let Operand::Register(register) = *result {
                out[places.clone()].copy_from_slice(&registers[register][..places.len()]);
            }
        }
        first = places.end;
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
            Operation::Unary(operation, a) => unary(operation, out, lanes_of(a, registers, lanes)),
            Operation::Binary(operation, a, b) => {
                let (a, b) = (lanes_of(a, registers, lanes), lanes_of(b, registers, lanes));
                binary(operation, out, a, b);
            }
            Operation::Select(condition, then, otherwise) => {
                copy(out, lanes_of(otherwise, registers, lanes));
                let condition = lanes_of(condition, registers, lanes);
                replace_where(out, condition, lanes_of(then, registers, lanes));
            }
        }
        registers[instruction.to] = taken;
    }
}

fn lanes_of(operand: Operand, registers: &Registers, lanes: usize) -> Lanes<'_> {
    match operand {
        Operand::Register(register) => Lanes::Each(&registers[register][..lanes]),
        Operand::Constant(value) => Lanes::Same(value),
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
