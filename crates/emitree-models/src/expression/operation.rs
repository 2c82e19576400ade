//! The operations that an expression is made of, and the names of the functions among them.

use crate::elementary::{self, Elementary};

/// An input of the expression, one value a sample.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Variable {
    /// A component of the position.
    Position(u8),
    /// A component of the direction of emission.
    Direction(u8),
    /// The energy, in the unit of the energy axis.
    Energy,
    /// A field of this number, whose values are given.
    Field(usize),
}

/// The value of a table, or a derivative of it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) struct Lookup {
    /// The number of the table.
    pub(super) table: usize,
    /// The number of its arguments.
    pub(super) count: usize,
    /// The argument that it is differentiated by.
    pub(super) along: Option<usize>,
}

/// An operation on one value.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Unary {
    Negate,
    Abs,
    Sqrt,
    Exp,
    Ln,
    Log10,
    Sin,
    Cos,
    Tan,
    Asin,
    Acos,
    Atan,
    Sinh,
    Cosh,
    Tanh,
    Erf,
    Floor,
}

impl Unary {
    /// The function of many numbers that this is, if there is one.
    pub(super) fn elementary(self) -> Option<Elementary> {
        Some(match self {
            Self::Exp => Elementary::Exp,
            Self::Ln => Elementary::Ln,
            Self::Log10 => Elementary::Log10,
            Self::Sin => Elementary::Sin,
            Self::Cos => Elementary::Cos,
            _ => return None,
        })
    }

    /// The operation on a single number.
    pub(super) fn scalar(self) -> fn(f64) -> f64 {
        match self {
            Self::Negate => |a| -a,
            Self::Abs => f64::abs,
            Self::Sqrt => f64::sqrt,
            Self::Exp => elementary::exp,
            Self::Ln => elementary::ln,
            Self::Log10 => elementary::log10,
            Self::Sin => elementary::sin,
            Self::Cos => elementary::cos,
            Self::Tan => f64::tan,
            Self::Asin => f64::asin,
            Self::Acos => f64::acos,
            Self::Atan => f64::atan,
            Self::Sinh => f64::sinh,
            Self::Cosh => f64::cosh,
            Self::Tanh => f64::tanh,
            Self::Erf => libm::erf,
            Self::Floor => f64::floor,
        }
    }
}

/// An operation on two values. "Greater" is "less" with its sides swapped.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Binary {
    Add,
    Subtract,
    Multiply,
    Divide,
    Power,
    Atan2,
    Min,
    Max,
    Less,
    LessEqual,
    Equal,
    NotEqual,
}

impl Binary {
    /// The operation on two single numbers.
    pub(super) fn scalar(self) -> fn(f64, f64) -> f64 {
        match self {
            Self::Add => |a, b| a + b,
            Self::Subtract => |a, b| a - b,
            Self::Multiply => |a, b| a * b,
            Self::Divide => |a, b| a / b,
            Self::Power => elementary::pow,
            Self::Atan2 => f64::atan2,
            Self::Min => smaller,
            Self::Max => larger,
            Self::Less => |a, b| truth(a < b),
            Self::LessEqual => |a, b| truth(a <= b),
            Self::Equal => equal,
            Self::NotEqual => |a, b| 1.0 - equal(a, b),
        }
    }

    /// Whether the two sides may be swapped without changing a bit of the result.
    pub(super) fn commutes(self) -> bool {
        matches!(self, Self::Add | Self::Multiply | Self::Equal | Self::NotEqual)
    }
}

/// The value of a condition: 1 or 0.
pub(super) fn truth(condition: bool) -> f64 {
    if condition { 1.0 } else { 0.0 }
}

/// 1 if the two numbers are the same, to the last bit.
#[expect(clippy::float_cmp, reason = "the scene's == is the comparison of IEEE 754")]
pub(super) fn equal(a: f64, b: f64) -> f64 {
    truth(a == b)
}

/// The smaller of two numbers; a NaN is ignored. Of 0 and −0 it is the first, on every machine,
/// which the standard library leaves open.
pub(super) fn smaller(a: f64, b: f64) -> f64 {
    if b < a || a.is_nan() { b } else { a }
}

/// The larger of two numbers, as [`smaller`].
pub(super) fn larger(a: f64, b: f64) -> f64 {
    if b > a || a.is_nan() { b } else { a }
}

/// What a name before a parenthesis stands for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Function {
    /// if(condition, then, otherwise)
    If,
    /// One argument.
    One(Unary),
    /// Two arguments.
    Two(Binary),
    /// Two or more arguments, taken from the left.
    Fold(Binary),
}

/// All functions, in the order in which messages list them.
pub(super) const FUNCTIONS: [(&str, Function); 20] = [
    ("if", Function::If),
    ("min", Function::Fold(Binary::Min)),
    ("max", Function::Fold(Binary::Max)),
    ("abs", Function::One(Unary::Abs)),
    ("sqrt", Function::One(Unary::Sqrt)),
    ("exp", Function::One(Unary::Exp)),
    ("ln", Function::One(Unary::Ln)),
    ("log10", Function::One(Unary::Log10)),
    ("sin", Function::One(Unary::Sin)),
    ("cos", Function::One(Unary::Cos)),
    ("tan", Function::One(Unary::Tan)),
    ("asin", Function::One(Unary::Asin)),
    ("acos", Function::One(Unary::Acos)),
    ("atan", Function::One(Unary::Atan)),
    ("atan2", Function::Two(Binary::Atan2)),
    ("sinh", Function::One(Unary::Sinh)),
    ("cosh", Function::One(Unary::Cosh)),
    ("tanh", Function::One(Unary::Tanh)),
    ("erf", Function::One(Unary::Erf)),
    ("floor", Function::One(Unary::Floor)),
];

/// The function of this name.
pub(super) fn function(name: &str) -> Option<Function> {
    FUNCTIONS.iter().find(|(known, _)| *known == name).map(|&(_, function)| function)
}

/// Variables that are parts of a sample; `r` is made of them.
const VARIABLES: [(&str, Variable); 7] = [
    ("x", Variable::Position(0)),
    ("y", Variable::Position(1)),
    ("z", Variable::Position(2)),
    ("dx", Variable::Direction(0)),
    ("dy", Variable::Direction(1)),
    ("dz", Variable::Direction(2)),
    ("E", Variable::Energy),
];

/// What the third axis of an image is called.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) enum ThirdAxis {
    /// The energy, `E`.
    #[default]
    Energy,
    /// The time, `t`.
    Time,
}

impl ThirdAxis {
    /// The names of all variables that are parts of a sample.
    pub(super) fn variables(self) -> impl Iterator<Item = (&'static str, Variable)> {
        VARIABLES.into_iter().map(move |(name, variable)| match (self, variable) {
            (Self::Time, Variable::Energy) => ("t", variable),
            _ => (name, variable),
        })
    }
}
