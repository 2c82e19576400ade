//! Runs a tape on many samples, block by block.
//!
//! A block is large enough that the cost of choosing an instruction vanishes against its loop, and
//! small enough that all registers of an ordinary expression stay in the fastest cache. Every
//! operation acts on each sample alone, so that a value does not depend on its neighbours.

use super::error::FieldFailure;
use super::inputs::Inputs;
use super::lanes::{Lanes, binary, copy, load, replace_where, unary};
use super::operation::{Lookup, Variable};
use super::tape::{Operand, Operation, Tape};
use crate::table::{BeyondTable, OutsideTable, Table};
use core::cell::Cell;
use core::ops::Range;
use emitree::Samples;
use std::sync::Arc;

/// Samples in a block: 2 kB a register.
pub(super) const BLOCK: usize = 256;

/// Registers of one thread, kept from one call to the next.
type Registers = Vec<Box<[f64]>>;

thread_local! {
    static REGISTERS: Cell<Registers> = const { Cell::new(Vec::new()) };
}

/// What a tape reads besides samples: the values of each field at all samples, and the tables.
#[derive(Clone, Copy, Default)]
pub(super) struct Given<'a> {
    fields: &'a [&'a [f64]],
    tables: &'a [(String, Arc<Table>)],
}

impl<'a> Given<'a> {
    /// The values of the fields of these inputs, and their tables.
    pub(super) fn new(inputs: &'a Inputs, fields: &'a [&'a [f64]]) -> Self {
        Self { fields, tables: inputs.tables() }
    }

    fn field(&self, number: usize, places: &Range<usize>) -> &'a [f64] {
        &self.fields[number][places.clone()]
    }
}

/// Writes the tape's value number `k` at sample `i` to `outputs[k][i]`.
pub(super) fn evaluate(
    tape: &Tape,
    samples: &Samples<'_>,
    given: Given<'_>,
    outputs: &mut [&mut [f64]],
) {
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
        let places = first..first + block.len();
        run(tape, &block, given, &places, &mut registers);
        for (result, out) in tape.results.iter().zip(outputs.iter_mut()) {
            if let Operand::Register(register) = *result {
                out[places.clone()].copy_from_slice(&registers[register][..places.len()]);
            }
        }
        first = places.end;
    }
    REGISTERS.set(registers);
}

/// Refuses rates that are not numbers since an argument is outside of a table.
pub(super) fn check(
    tape: &Tape,
    samples: &Samples<'_>,
    given: Given<'_>,
    rates: &[f64],
) -> Result<(), FieldFailure> {
    if !given.tables.iter().any(|(_, table)| table.beyond() == BeyondTable::Error) {
        return Ok(());
    }
    match rates.iter().position(|rate| rate.is_nan()) {
        Some(at) => outside(tape, samples, given, at).map_or(Ok(()), |cause| {
            Err(FieldFailure::Table { position: samples.positions()[at], cause })
        }),
        None => Ok(()),
    }
}

/// The first table that sample number `at` is outside of, if that is an error.
fn outside(
    tape: &Tape,
    samples: &Samples<'_>,
    given: Given<'_>,
    at: usize,
) -> Option<OutsideTable> {
    let place = at..at + 1;
    let energies = samples.energies().get(place.clone()).unwrap_or_default();
    let positions = &samples.positions()[place.clone()];
    let sample = Samples::new(positions, &samples.directions()[place.clone()]);
    let sample = sample.at_energies(energies);
    let instructions = &tape.instructions;
    instructions.iter().enumerate().find_map(|(number, instruction)| {
        let Operation::Table(lookup, arguments) = instruction.operation else { return None };
        // Up to here, since registers are written again later.
        let before = Tape {
            instructions: instructions[..number].to_vec(),
            registers: tape.registers,
            results: Vec::new(),
        };
        let mut registers = vec![vec![0.0; 1].into_boxed_slice(); tape.registers];
        run(&before, &sample, given, &place, &mut registers);
        let (name, table) = &given.tables[lookup.table];
        let outside = table.outside(arguments.map(|a| lanes_of(a, &registers, 1).at(0)))?;
        Some(OutsideTable { table: Some(name.clone()), ..outside })
    })
}

/// Runs the tape on one block of at most [`BLOCK`] samples, those at `places` among all.
fn run(
    tape: &Tape,
    block: &Samples<'_>,
    given: Given<'_>,
    places: &Range<usize>,
    registers: &mut Registers,
) {
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
            Operation::Load(Variable::Field(number)) => {
                out.copy_from_slice(given.field(number, places));
            }
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
            Operation::Table(lookup, arguments) => {
                let arguments = arguments.map(|a| lanes_of(a, registers, lanes));
                look_up(&given.tables[lookup.table].1, lookup, out, arguments);
            }
        }
        registers[instruction.to] = taken;
    }
}

/// Writes a table's values, or its derivatives by one argument.
fn look_up(
    table: &Table,
    lookup: Lookup,
    out: &mut [f64],
    arguments: [Lanes<'_>; Table::MAX_AXES],
) {
    for (lane, out) in out.iter_mut().enumerate() {
        let arguments = arguments.map(|argument| argument.at(lane));
        *out = match lookup.along {
            None => table.interpolated(arguments),
            Some(along) => table.slope(arguments, along),
        };
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
