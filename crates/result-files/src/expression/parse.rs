//! From text to a tree.

use super::fault::{ExpressionFault, FaultAt};
use super::function::Function;
use super::token::{Token, tokens};

/// Expressions within expressions at most: no text takes the stack.
const DEEPEST: usize = 100;

/// A parsed expression.
#[derive(Debug, Clone, PartialEq)]
pub struct Expression {
    /// As given.
    pub text: String,
    /// What it says.
    pub tree: Node,
}

/// A part of an expression.
#[derive(Debug, Clone, PartialEq)]
pub enum Node {
    /// A number.
    Number(f64),
    /// A path from the root of the result, and where it begins.
    Path(Vec<Step>, usize),
    /// What steps take of a value.
    Part(Box<Node>, Vec<Step>),
    /// A function of values, and where it stands.
    Call(Function, Vec<Node>, usize),
    /// The negative of a value.
    Negative(Box<Node>),
    /// A value and those that follow it, each with the sign before it and where that stands, from left to right: however many they
    /// are, the tree is no deeper.
    Chain(Box<Node>, Vec<(char, Node, usize)>),
}

/// A step from a value to a part of it, with its place.
#[derive(Debug, Clone, PartialEq)]
pub struct Step {
    /// Number of its first character.
    pub at: usize,
    /// What it takes.
    pub taken: Taken,
}

/// What a step takes.
#[derive(Debug, Clone, PartialEq)]
pub enum Taken {
    /// A member, a column, a component.
    Name(String),
    /// One row or component; from the end if it is negative.
    Index(i64),
    /// Rows from one to before another.
    Range(Option<i64>, Option<i64>),
}

/// Parses `text`.
///
/// # Errors
/// [`ExpressionFault`] with the place and what was expected there.
pub fn parse(text: &str) -> Result<Expression, ExpressionFault> {
    let fail = |fault| ExpressionFault::new(text, fault);
    let tokens = tokens(text).map_err(fail)?;
    let mut parser = Parser { tokens: &tokens, at: 0, end: text.chars().count(), depth: 0 };
    let tree = parser.sum().map_err(fail)?;
    match parser.tokens.get(parser.at) {
        None => Ok(Expression { text: text.to_owned(), tree }),
        Some((at, token)) => {
            Err(fail((*at, format!("{} is too much; wanted is an operator or the end", token.shown()))))
        }
    }
}

struct Parser<'a> {
    tokens: &'a [(usize, Token)],
    at: usize,
    end: usize,
    depth: usize,
}

impl Parser<'_> {
    fn peek(&self) -> Option<&Token> {
        self.tokens.get(self.at).map(|(_, token)| token)
    }

    fn place(&self) -> usize {
        self.tokens.get(self.at).map_or(self.end, |(at, _)| *at)
    }

    fn take(&mut self, sign: char) -> bool {
        let is_there = self.peek() == Some(&Token::Sign(sign));
        self.at += usize::from(is_there);
        is_there
    }

    fn expect(&mut self, sign: char) -> Result<(), FaultAt> {
        if self.take(sign) { Ok(()) } else { Err(self.unexpected(&format!("\"{sign}\""))) }
    }

    fn unexpected(&self, wanted: &str) -> FaultAt {
        let found = self.peek().map_or_else(|| "the end".to_owned(), Token::shown);
        (self.place(), format!("{found} in place of {wanted}"))
    }

    fn deeper<T>(&mut self, inner: impl FnOnce(&mut Self) -> Result<T, FaultAt>) -> Result<T, FaultAt> {
        if self.depth == DEEPEST {
            return Err((self.place(), format!("more than {DEEPEST} expressions within each other")));
        }
        self.depth += 1;
        let found = inner(self);
        self.depth -= 1;
        found
    }

    fn sum(&mut self) -> Result<Node, FaultAt> {
        self.deeper(|parser| parser.chain(&['+', '-'], Self::product))
    }

    fn product(&mut self) -> Result<Node, FaultAt> {
        self.chain(&['*', '/'], Self::factor)
    }

    /// Parts with one of `signs` between them, from left to right.
    fn chain(
        &mut self,
        signs: &[char],
        part: fn(&mut Self) -> Result<Node, FaultAt>,
    ) -> Result<Node, FaultAt> {
        let (first, mut rest) = (part(self)?, Vec::new());
        loop {
            let at = self.place();
            let Some(sign) = signs.iter().copied().find(|sign| self.take(*sign)) else { break };
            rest.push((sign, part(self)?, at));
        }
        Ok(if rest.is_empty() { first } else { Node::Chain(Box::new(first), rest) })
    }

    fn factor(&mut self) -> Result<Node, FaultAt> {
        if self.take('-') {
            return self.deeper(|parser| Ok(Node::Negative(Box::new(parser.factor()?))));
        }
        let base = self.postfix()?;
        let at = self.place();
        if !self.take('^') {
            return Ok(base);
        }
        let exponent = self.deeper(Self::factor)?;
        Ok(Node::Chain(Box::new(base), vec![('^', exponent, at)]))
    }

    fn postfix(&mut self) -> Result<Node, FaultAt> {
        let at = self.place();
        let atom = match self.peek().cloned() {
            Some(Token::Number(x)) => {
                self.at += 1;
                Node::Number(x)
            }
            Some(Token::Sign('(')) => {
                self.at += 1;
                let inner = self.sum()?;
                self.expect(')')?;
                inner
            }
            Some(Token::Name(name)) => {
                self.at += 1;
                if self.take('(') {
                    self.call(&name, at)?
                } else {
                    let mut steps = vec![Step { at, taken: Taken::Name(name) }];
                    steps.extend(self.steps()?);
                    return Ok(Node::Path(steps, at));
                }
            }
            _ => return Err(self.unexpected("a number, a name, a function or \"(\"")),
        };
        let steps = self.steps()?;
        Ok(if steps.is_empty() { atom } else { Node::Part(Box::new(atom), steps) })
    }

    fn call(&mut self, name: &str, at: usize) -> Result<Node, FaultAt> {
        let Some(function) = Function::find(name) else {
            let known: Vec<&str> = Function::ALL.iter().map(|f| f.name()).collect();
            return Err((at, format!("there is no function \"{name}\"; there are {}", known.join(", "))));
        };
        let mut arguments = vec![self.sum()?];
        while self.take(',') {
            arguments.push(self.sum()?);
        }
        self.expect(')')?;
        let wanted = function.n_arguments();
        if arguments.len() != wanted {
            return Err((at, format!("{name} takes {wanted} values, here are {}", arguments.len())));
        }
        Ok(Node::Call(function, arguments, at))
    }

    fn steps(&mut self) -> Result<Vec<Step>, FaultAt> {
        let mut steps = Vec::new();
        loop {
            let at = self.place();
            if self.take('.') {
                let Some(Token::Name(name)) = self.peek().cloned() else {
                    return Err(self.unexpected("a name"));
                };
                self.at += 1;
                steps.push(Step { at: at + 1, taken: Taken::Name(name) });
            } else if self.take('[') {
                let taken = self.index()?;
                self.expect(']')?;
                steps.push(Step { at, taken });
            } else {
                return Ok(steps);
            }
        }
    }

    fn index(&mut self) -> Result<Taken, FaultAt> {
        let first = self.integer()?;
        if self.take(':') {
            return Ok(Taken::Range(first, self.integer()?));
        }
        first.map(Taken::Index).ok_or_else(|| self.unexpected("a whole number or a range such as 10:20"))
    }

    /// A whole number, if one stands here.
    fn integer(&mut self) -> Result<Option<i64>, FaultAt> {
        let at = self.place();
        let sign = if self.take('-') { -1.0 } else { 1.0 };
        match self.peek() {
            Some(Token::Number(x)) if x.fract() == 0.0 && *x < 1e15 => {
                let value = (sign * x) as i64;
                self.at += 1;
                Ok(Some(value))
            }
            Some(Token::Number(x)) => Err((at, format!("{x} is no whole number"))),
            _ if sign < 0.0 => Err(self.unexpected("a whole number")),
            _ => Ok(None),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn fault(text: &str) -> (usize, String) {
        let fault = parse(text).expect_err(text);
        (fault.at, fault.message)
    }

    fn name(text: &str) -> Step {
        Step { at: 0, taken: Taken::Name(text.into()) }
    }

    #[test]
    fn signs_bind_as_in_books() {
        let tree = |text: &str| parse(text).expect(text).tree;
        let binary = |sign, a, b, at| Node::Chain(Box::new(a), vec![(sign, b, at)]);
        let n = Node::Number;
        assert_eq!(tree("1+2*3"), binary('+', n(1.0), binary('*', n(2.0), n(3.0), 3), 1));
        let rest = vec![('-', n(2.0), 1), ('-', n(3.0), 3)];
        assert_eq!(tree("1-2-3"), Node::Chain(Box::new(n(1.0)), rest));
        assert_eq!(tree("-2^2"), Node::Negative(Box::new(binary('^', n(2.0), n(2.0), 2))));
        assert_eq!(tree("2^-1"), binary('^', n(2.0), Node::Negative(Box::new(n(1.0))), 1));
        let path = vec![
            name("a"),
            Step { at: 1, taken: Taken::Index(-1) },
            Step { at: 6, taken: Taken::Name("z".into()) },
        ];
        assert_eq!(tree("a[-1].z"), Node::Path(path, 0));
        assert_eq!(
            tree("a[:5]"),
            Node::Path(vec![name("a"), Step { at: 1, taken: Taken::Range(None, Some(5)) }], 0)
        );
    }

    #[test]
    fn faults_say_where_and_what_is_wanted() {
        for (text, at, words) in [
            ("", 0, "the end in place of a number"),
            ("max(a", 5, "\")\""),
            ("a b", 2, "too much"),
            ("a[", 2, "whole number"),
            ("a[1.5]", 2, "1.5 is no whole number"),
            ("a[-]", 3, "whole number"),
            ("a.", 2, "a name"),
            ("mix(a)", 0, "max"),
            ("at(a)", 0, "takes 2 values"),
            ("1 +", 3, "the end"),
            ("a)", 1, "too much"),
        ] {
            let (found, message) = fault(text);
            assert!(found == at && message.contains(words), "{text}: {found}: {message}");
        }
        // As long as one likes, the stack of a test is 2 MB.
        for signs in ["+1", "*1", "-1", "/1"] {
            assert!(parse(&format!("1{}", signs.repeat(1_000_000))).is_ok(), "{signs}");
        }
        for open in ["(", "-", "2^", "max("] {
            assert!(fault(&open.repeat(100_000)).1.contains("within each other"), "{open}");
        }
    }
}
