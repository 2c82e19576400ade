//! Counts in messages and tables. `xtask` compiles this file too.

/// A count with its thousands set apart.
///
/// ```
/// assert_eq!(emitree_io::grouped(19_136), "19,136");
/// ```
pub fn grouped(count: u64) -> String {
    let digits = count.to_string();
    let mut text = String::new();
    for (i, digit) in digits.chars().enumerate() {
        if i > 0 && (digits.len() - i).is_multiple_of(3) {
            text.push(',');
        }
        text.push(digit);
    }
    text
}
