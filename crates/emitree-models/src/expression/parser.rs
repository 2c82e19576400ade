//! The grammar, by precedence climbing (Pratt 1973), straight into a [`Graph`].
//!
//! From the loosest to the tightest: comparisons, which do not chain; + and −; * and /; a leading
//! − or +; ^, from the right. So −x^2 is −(x^2), 2^−3 is allowed, and 2^3^2 is 2^(3^2).

use super::error::ExpressionError;
use super::graph::{Graph, NodeId};
use super::inputs::{Inputs, check_names};
use super::lexer::{Lexer, Token};
use super::operation::{Binary, FUNCTIONS, Function, ThirdAxis, Unary, Variable, function};
use crate::spelling::{closest, did_you_mean};
use crate::table::Table;
use core::f64::consts::PI;
use core::ops::Range;
use std::collections::{BTreeMap, BTreeSet};

/// Deepest nesting of parentheses, calls, signs and powers: far more than anyone writes, and far
/// less than the smallest stack of a thread holds.
const MAX_NESTING: usize = 128;

/// How tightly a leading sign binds: looser than ^, tighter than * and /.
const SIGN_BINDING: u8 = 7;

/// Names with a meaning of their own besides functions and parts of a sample.
const OTHER_NAMES: [&str; 2] = ["r", "pi"];

/// An expression's graph, the node of its value, and what it names.
#[derive(Debug)]
pub(super) struct Parsed {
    pub(super) graph: Graph,
    pub(super) root: NodeId,
    /// The names of the constants, fields and tables in it.
    pub(super) used: BTreeSet<String>,
    /// The place of the first `E`.
    pub(super) energy_span: Option<Range<usize>>,
}

/// Parses `text`, in which `constants` and `inputs` may be named: those of the constants in `parameters` are
/// parameters of the graph, with their numbers.
pub(super) fn parse(
    text: &str,
    constants: &BTreeMap<String, f64>,
    parameters: &[String],
    inputs: &Inputs,
) -> Result<Parsed, ExpressionError> {
    check_names(constants, inputs)?;
    let mut lexer = Lexer::new(text);
    let (token, span) = lexer.token()?;
    if token == Token::End {
        return Err(ExpressionError::new("the expression is empty", 0..text.len()));
    }
    let mut parser = Parser {
        lexer,
        token,
        span,
        constants,
        parameters,
        inputs,
        used: BTreeSet::new(),
        energy_span: None,
        graph: Graph::default(),
        nesting: 0,
    };
    let root = parser.expression(0)?;
    match parser.token {
        Token::End => {}
        Token::Close => {
            let message = "unbalanced parenthesis: this `)` closes nothing";
            return Err(ExpressionError::new(message, parser.span));
        }
        _ => return Err(parser.expected_operator()),
    }
    Ok(Parsed { graph: parser.graph, root, used: parser.used, energy_span: parser.energy_span })
}

/// An operator between two values.
#[derive(Clone, Copy)]
struct Infix {
    operation: Binary,
    /// a > b is evaluated as b < a.
    swapped: bool,
    /// How tightly it holds the value on its left and on its right.
    binding: (u8, u8),
}

/// Operators bind from the left if their right binding is the larger.
fn infix(token: Token<'_>) -> Option<Infix> {
    let (operation, swapped, binding) = match token {
        Token::Less => (Binary::Less, false, (1, 2)),
        Token::Greater => (Binary::Less, true, (1, 2)),
        Token::LessEqual => (Binary::LessEqual, false, (1, 2)),
        Token::GreaterEqual => (Binary::LessEqual, true, (1, 2)),
        Token::Equal => (Binary::Equal, false, (1, 2)),
        Token::NotEqual => (Binary::NotEqual, false, (1, 2)),
        Token::Plus => (Binary::Add, false, (3, 4)),
        Token::Minus => (Binary::Subtract, false, (3, 4)),
        Token::Star => (Binary::Multiply, false, (5, 6)),
        Token::Slash => (Binary::Divide, false, (5, 6)),
        Token::Caret => (Binary::Power, false, (10, 9)),
        _ => return None,
    };
    Some(Infix { operation, swapped, binding })
}

fn is_comparison(token: Token<'_>) -> bool {
    infix(token).is_some_and(|infix| infix.binding.0 == 1)
}

struct Parser<'a> {
    lexer: Lexer<'a>,
    /// The current token, and its place.
    token: Token<'a>,
    span: Range<usize>,
    constants: &'a BTreeMap<String, f64>,
    parameters: &'a [String],
    inputs: &'a Inputs,
    used: BTreeSet<String>,
    energy_span: Option<Range<usize>>,
    graph: Graph,
    nesting: usize,
}

impl<'a> Parser<'a> {
    /// Steps to the next token; returns the place of the one left behind.
    fn advance(&mut self) -> Result<Range<usize>, ExpressionError> {
        let (token, span) = self.lexer.token()?;
        self.token = token;
        Ok(core::mem::replace(&mut self.span, span))
    }

    /// A value and all operators after it that bind at least as tightly as `binding`.
    fn expression(&mut self, binding: u8) -> Result<NodeId, ExpressionError> {
        self.nesting += 1;
        if self.nesting > MAX_NESTING {
            let message = format!("nested more than {MAX_NESTING} deep");
            return Err(ExpressionError::new(message, self.span.clone()));
        }
        let mut left = self.value()?;
        while let Some(infix) = infix(self.token).filter(|infix| infix.binding.0 >= binding) {
            let compares = is_comparison(self.token);
            self.advance()?;
            let right = self.expression(infix.binding.1)?;
            if compares && is_comparison(self.token) {
                let error = ExpressionError::new("comparisons do not chain", self.span.clone());
                return Err(error.with_help("multiply them: (0 < x) * (x < 1)"));
            }
            let (a, b) = if infix.swapped { (right, left) } else { (left, right) };
            left = self.graph.binary(infix.operation, a, b);
        }
        self.nesting -= 1;
        Ok(left)
    }

    /// A number, a name, a call, a value with a sign, or something in parentheses.
    fn value(&mut self) -> Result<NodeId, ExpressionError> {
        match self.token {
            Token::Number(value) => {
                self.advance()?;
                Ok(self.graph.constant(value))
            }
            Token::Name(name) => {
                let span = self.advance()?;
                if self.token == Token::Open {
                    self.call(name, span)
                } else {
                    self.named(name, span)
                }
            }
            Token::Minus => {
                self.advance()?;
                let operand = self.expression(SIGN_BINDING)?;
                Ok(self.graph.unary(Unary::Negate, operand))
            }
            Token::Plus => {
                self.advance()?;
                self.expression(SIGN_BINDING)
            }
            Token::Open => {
                let open = self.advance()?;
                let inner = self.expression(0)?;
                self.close(open)?;
                Ok(inner)
            }
            _ => Err(self.expected_value()),
        }
    }

    /// Steps over the `)` that belongs to the `(` at `open`; returns its place.
    fn close(&mut self, open: Range<usize>) -> Result<Range<usize>, ExpressionError> {
        match self.token {
            Token::Close => self.advance(),
            Token::End => {
                let message = "unbalanced parenthesis: this `(` is never closed";
                Err(ExpressionError::new(message, open))
            }
            _ => Err(self.expected_operator()),
        }
    }

    /// A variable or a constant.
    fn named(&mut self, name: &str, span: Range<usize>) -> Result<NodeId, ExpressionError> {
        if let Some((_, variable)) = self.variables().find(|(known, _)| *known == name) {
            if variable == Variable::Energy {
                self.energy_span.get_or_insert(span);
            }
            return Ok(self.graph.variable(variable));
        }
        if let Some(&value) = self.constants.get(name) {
            self.used.insert(name.to_owned());
            let number = self.parameters.iter().position(|parameter| parameter == name);
            return Ok(match number {
                Some(number) => self.graph.parameter(number),
                None => self.graph.constant(value),
            });
        }
        if let Some(number) = self.inputs.field(name) {
            self.used.insert(name.to_owned());
            return Ok(self.graph.variable(Variable::Field(number)));
        }
        if let Some((_, table)) = self.inputs.table(name) {
            let error = ExpressionError::new(format!("`{name}` is a table"), span);
            let usage = usage_of(name, table);
            return Err(error.with_help(format!("arguments follow in parentheses: {usage}")));
        }
        match name {
            "r" => Ok(self.graph.radius()),
            "pi" => Ok(self.graph.constant(PI)),
            _ if function(name).is_some() => {
                let error = ExpressionError::new(format!("`{name}` is a function"), span);
                Err(error.with_help(format!("arguments follow in parentheses: {name}(…)")))
            }
            _ => Err(self.unknown_name(name, span)),
        }
    }

    /// A function's value; the token is the `(` after its name.
    fn call(&mut self, name: &str, span: Range<usize>) -> Result<NodeId, ExpressionError> {
        let table = self.inputs.table(name);
        let function = function(name);
        if function.is_none() && table.is_none() {
            return Err(self.unknown_function(name, span));
        }
        let open = self.advance()?;
        let mut arguments = Vec::new();
        while self.token != Token::Close {
            arguments.push(self.expression(0)?);
            if self.token != Token::Comma {
                break;
            }
            self.advance()?;
            if self.token == Token::Close {
                return Err(self.expected_value());
            }
        }
        let close = self.close(open)?;
        let span = span.start..close.end;
        match function {
            Some(function) => self.of_function(name, function, &arguments, span),
            None => self.of_table(name, &arguments, span),
        }
    }

    /// The value of a table, which is one of the inputs.
    fn of_table(
        &mut self,
        name: &str,
        arguments: &[NodeId],
        span: Range<usize>,
    ) -> Result<NodeId, ExpressionError> {
        let Some((number, table)) = self.inputs.table(name) else {
            return Err(self.unknown_function(name, span));
        };
        let count = table.names().len();
        if arguments.len() != count {
            let plural = if count == 1 { "" } else { "s" };
            let message = format!(
                "the table `{name}` takes {count} argument{plural}, not {}",
                arguments.len()
            );
            let error = ExpressionError::new(message, span);
            return Err(error.with_help(format!("write {}", usage_of(name, table))));
        }
        self.used.insert(name.to_owned());
        Ok(self.graph.look_up(number, None, arguments))
    }

    /// The value of a function of these arguments.
    fn of_function(
        &mut self,
        name: &str,
        function: Function,
        arguments: &[NodeId],
        span: Range<usize>,
    ) -> Result<NodeId, ExpressionError> {
        match (function, arguments) {
            (Function::If, &[condition, then, otherwise]) => {
                Ok(self.graph.select(condition, then, otherwise))
            }
            (Function::One(operation), &[a]) => Ok(self.graph.unary(operation, a)),
            (Function::Two(operation), &[a, b]) => Ok(self.graph.binary(operation, a, b)),
            (Function::Fold(operation), &[first, second, ref others @ ..]) => {
                let start = self.graph.binary(operation, first, second);
                let graph = &mut self.graph;
                Ok(others.iter().fold(start, |all, &next| graph.binary(operation, all, next)))
            }
            _ => {
                let (takes, usage) = match function {
                    Function::If => ("3 arguments", "if(condition, then, otherwise)".to_owned()),
                    Function::One(_) => ("1 argument", format!("{name}(x)")),
                    Function::Two(_) => ("2 arguments", format!("{name}(y, x)")),
                    Function::Fold(_) => ("2 or more arguments", format!("{name}(x, y)")),
                };
                let message = format!("`{name}` takes {takes}, not {}", arguments.len());
                let error = ExpressionError::new(message, span);
                Err(error.with_help(format!("write {usage}")))
            }
        }
    }

    /// The names of variables that are parts of a sample.
    fn variables(&self) -> impl Iterator<Item = (&'static str, Variable)> + use<> {
        self.inputs.third_axis().variables()
    }

    fn unknown_name(&self, name: &str, span: Range<usize>) -> ExpressionError {
        let variables = self.variables().map(|(variable, _)| variable).chain(["r", "pi"]);
        let constants = self.constants.keys().map(String::as_str);
        let fields = self.inputs.fields().iter().map(String::as_str);
        let listed = variables.chain(constants).chain(fields).collect::<Vec<_>>();
        let suggestion = match name {
            // Rather Euler's number than a slip of the energy's name.
            "e" if self.inputs.third_axis() == ThirdAxis::Energy => {
                ": write exp(1), or E for the energy".to_owned()
            }
            "e" => ": write exp(1)".to_owned(),
            "t" if !listed.contains(&"T") => {
                ": it is the time where there is a time axis, `[time]` in a scene".to_owned()
            }
            _ => did_you_mean(closest(name, listed.iter().copied())),
        };
        ExpressionError::new(format!("unknown name `{name}`{suggestion}"), span)
            .with_help(format!("known: {}", listed.join(", ")))
    }

    fn unknown_function(&self, name: &str, span: Range<usize>) -> ExpressionError {
        let is_value = OTHER_NAMES.contains(&name)
            || self.variables().any(|(variable, _)| variable == name)
            || self.constants.contains_key(name)
            || self.inputs.field(name).is_some();
        if is_value {
            let error = ExpressionError::new(format!("`{name}` is not a function"), span);
            return error.with_help(format!("a product is written with *: {name}*(…)"));
        }
        let suggestion = match name {
            "log" => ": write `ln` or `log10`".to_owned(),
            "pow" => ": write a^b".to_owned(),
            _ => did_you_mean(closest(name, self.functions())),
        };
        let listed = self.functions().join(", ");
        ExpressionError::new(format!("unknown function `{name}`{suggestion}"), span)
            .with_help(format!("known: {listed}"))
    }

    /// The names of functions and tables.
    fn functions(&self) -> Vec<&str> {
        let tables = self.inputs.tables().iter().map(|(name, _)| name.as_str());
        FUNCTIONS.iter().map(|&(known, _)| known).chain(tables).collect()
    }

    /// The error for a token that starts no value.
    fn expected_value(&self) -> ExpressionError {
        let found = match self.token {
            Token::End => "the end of the expression".to_owned(),
            _ => format!("`{}`", self.lexer.text(self.span.clone())),
        };
        let error =
            ExpressionError::new(format!("expected a value, found {found}"), self.span.clone());
        match self.token {
            Token::Star => error.with_help("powers are written with ^, not **"),
            _ => error,
        }
    }

    /// The error for a token after a complete value that is no operator.
    fn expected_operator(&self) -> ExpressionError {
        let found = self.lexer.text(self.span.clone());
        let error = ExpressionError::new(
            format!("expected an operator, found `{found}`"),
            self.span.clone(),
        );
        error.with_help(match self.token {
            Token::Comma => "commas only separate the arguments of a function",
            _ => "a product is written with *",
        })
    }
}

/// How a table is written: with the names of its axes.
fn usage_of(name: &str, table: &Table) -> String {
    format!("{name}({})", table.names().join(", "))
}

#[cfg(test)]
mod tests;
