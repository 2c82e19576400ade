//! The bytes of arrays in XML: as they are or in base64, compressed or not.

use super::super::budget::Budget;
use super::super::error::GridReadError;
use super::malformed;
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use flate2::read::ZlibDecoder;
use std::io::Read;

/// How a file stores arrays.
#[derive(Clone, Copy, Debug)]
pub(super) struct Storage {
    pub(super) is_big_endian: bool,
    /// Bytes of the lengths before an array: 4 or 8.
    pub(super) bytes_of_length: usize,
    /// Whether arrays are in blocks of zlib.
    pub(super) is_compressed: bool,
}

/// Where the bytes of an array are.
#[derive(Debug)]
pub(super) enum Bytes<'a> {
    /// As they are, at the start of these.
    Plain(&'a [u8]),
    /// In base64, at the start of this text.
    Base64 {
        text: &'a [u8],
        /// Bytes of a group of four letters that are still to be taken.
        left: Vec<u8>,
    },
}

impl Bytes<'_> {
    /// The next bytes, which take no more memory than is left.
    fn take(&mut self, count: usize, budget: Budget) -> Result<Vec<u8>, GridReadError> {
        let cut = || malformed("its numbers are cut off");
        let (text, left) = match self {
            Bytes::Plain(bytes) => {
                let (taken, rest) = bytes.split_at_checked(count).ok_or_else(cut)?;
                *bytes = rest;
                return Ok(taken.to_vec());
            }
            Bytes::Base64 { text, left } => (text, left),
        };
        // Four letters for three bytes.
        if count / 3 > text.len() / 4 + 1 {
            return Err(cut());
        }
        budget.check(&[count], 1, 0)?;
        let mut taken = std::mem::take(left);
        taken.reserve(count.saturating_sub(taken.len()) + 2);
        while taken.len() < count {
            let mut group = [0; 4];
            for letter in &mut group {
                let blanks = text.iter().take_while(|byte| byte.is_ascii_whitespace()).count();
                let (&next, rest) = text[blanks..].split_first().ok_or_else(cut)?;
                (*letter, *text) = (next, rest);
            }
            // Lengths and numbers may be texts of their own, each with its padding.
            let mut decoded = [0; 3];
            let count = STANDARD.decode_slice(group, &mut decoded).map_err(|_| {
                malformed(format!(
                    "{} is no base64",
                    String::from_utf8_lossy(&group).escape_debug()
                ))
            })?;
            taken.extend_from_slice(&decoded[..count]);
        }
        *left = taken.split_off(count);
        Ok(taken)
    }

    /// An array of so many bytes.
    pub(super) fn array(
        mut self,
        expected: usize,
        storage: Storage,
        budget: Budget,
    ) -> Result<Vec<u8>, GridReadError> {
        let agrees = |found: usize| match found == expected {
            true => Ok(()),
            false => Err(malformed(format!(
                "an array has {found} bytes: expected {expected}, as its type and the extent have"
            ))),
        };
        let mut length = || -> Result<usize, GridReadError> {
            let bytes = self.take(storage.bytes_of_length, budget)?;
            Ok(whole(&bytes, storage.is_big_endian))
        };
        if !storage.is_compressed {
            agrees(length()?)?;
            return self.take(expected, budget);
        }
        let (count, of_block, of_last) = (length()?, length()?, length()?);
        // A last block of 0 bytes is a whole one.
        let whole_blocks = if of_last > 0 { count.saturating_sub(1) } else { count };
        let rest = if count > 0 { of_last } else { 0 };
        agrees(whole_blocks.saturating_mul(of_block).saturating_add(rest))?;
        if count > expected {
            return Err(malformed(format!("an array of {expected} bytes has {count} blocks")));
        }
        let lengths = (0..count).map(|_| length()).collect::<Result<Vec<usize>, _>>()?;
        budget.check(&[expected], 1, 0)?;
        let mut found = Vec::with_capacity(expected);
        for (number, length) in lengths.into_iter().enumerate() {
            let bytes = if number < whole_blocks { of_block } else { of_last };
            let block = self.take(length, budget)?;
            let before = found.len();
            // No more than the block may have, however much is in it.
            let mut decoder = ZlibDecoder::new(block.as_slice()).take(bytes as u64 + 1);
            decoder
                .read_to_end(&mut found)
                .map_err(|error| malformed(format!("block {number} of an array: {error}")))?;
            if found.len() - before != bytes {
                let found = found.len() - before;
                return Err(malformed(format!(
                    "block {number} of an array has {found} bytes: expected {bytes}"
                )));
            }
        }
        Ok(found)
    }
}

/// A whole number of 4 or 8 bytes.
fn whole(bytes: &[u8], is_big_endian: bool) -> usize {
    let digit = |number: u64, &byte: &u8| number << 8 | u64::from(byte);
    let number = match is_big_endian {
        true => bytes.iter().fold(0, digit),
        false => bytes.iter().rev().fold(0, digit),
    };
    usize::try_from(number).unwrap_or(usize::MAX)
}
