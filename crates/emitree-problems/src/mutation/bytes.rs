//! Mutations of the bytes of a file, whatever its format.

use super::Mutator;
use core::ops::Range;

/// The most changes in one mutant: more would mostly be found by the first one.
const MOST_CHANGES: u32 = 4;
/// The longest part that is removed, doubled or zeroed, unless it is a block of FITS.
const LONGEST_PART: usize = 64;
/// Bytes of a block of FITS.
const BLOCK: usize = 2880;

impl Mutator {
    /// These bytes with one to four changes: bits, numbers in either order of bytes, numbers that are
    /// written as digits, parts that are missing, doubled or zeroed.
    pub fn bytes(&mut self, original: &[u8]) -> Vec<u8> {
        let mut bytes = original.to_vec();
        for _ in 0..self.random.whole(1..=MOST_CHANGES) {
            self.change_bytes(&mut bytes);
        }
        bytes
    }

    fn change_bytes(&mut self, bytes: &mut Vec<u8>) {
        let at = self.below(bytes.len());
        match self.random.whole(0..=9) {
            0 | 1 => {
                let bit = 1 << self.random.whole(0..=7);
                bytes.iter_mut().skip(at).take(1).for_each(|byte| *byte ^= bit);
            }
            2 => {
                let width = 1 << self.random.whole(0..=3);
                let number = self.integer().to_le_bytes();
                self.write(bytes, at, &number[..width]);
            }
            3 => {
                let number = self.number();
                if self.one_in(2) {
                    self.write(bytes, at, &number.to_le_bytes());
                } else {
                    #[expect(clippy::cast_possible_truncation, reason = "any bits will do")]
                    self.write(bytes, at, &(number as f32).to_le_bytes());
                }
            }
            4 | 5 => self.change_digits(bytes, at),
            6 => bytes.truncate(at),
            7 => drop(bytes.drain(self.part(at, bytes.len()))),
            8 => {
                let part = bytes[self.part(at, bytes.len())].to_vec();
                bytes.splice(at..at, part);
            }
            _ => bytes[self.part(at, bytes.len())].fill(0),
        }
    }

    /// Overwrites what is at a place, in either order of bytes.
    fn write(&mut self, bytes: &mut [u8], at: usize, number: &[u8]) {
        let mut number = number.to_vec();
        if self.one_in(2) {
            number.reverse();
        }
        bytes.iter_mut().skip(at).zip(number).for_each(|(byte, new)| *byte = new);
    }

    /// Replaces the next number that is written as text by another one, which takes the place of blanks
    /// before it if it is longer: cards of FITS keep their length.
    fn change_digits(&mut self, bytes: &mut [u8], at: usize) {
        let Some(start) = bytes.iter().skip(at).position(u8::is_ascii_digit).map(|k| at + k) else {
            return;
        };
        let end = start + bytes[start..].iter().take_while(|byte| byte.is_ascii_digit()).count();
        let blanks = bytes[..start].iter().rev().take_while(|&&byte| byte == b' ').count();
        let room = end - start + blanks.saturating_sub(1);
        let text = if self.one_in(3) {
            format!("{:e}", self.number())
        } else {
            self.integer().to_string()
        };
        let text = &text.as_bytes()[..text.len().min(room)];
        bytes[end - room..end].fill(b' ');
        bytes[end - text.len()..end].copy_from_slice(text);
    }

    /// A part from a place on: some bytes, or a block of FITS.
    fn part(&mut self, at: usize, length: usize) -> Range<usize> {
        if self.one_in(4) && length >= BLOCK {
            let start = at / BLOCK * BLOCK;
            return start..(start + BLOCK).min(length);
        }
        let end = at + 1 + self.below(LONGEST_PART);
        at..end.min(length)
    }
}
