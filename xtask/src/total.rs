//! The total of many test runs: the closing lines of cargo's test runner, added up to one.

use std::fmt;
use std::ops::AddAssign;

/// The numbers in the closing lines of test runners.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Total {
    /// How many closing lines are in it.
    pub(crate) binaries: u32,
    /// Whether all of them are `ok`.
    pub(crate) ok: bool,
    passed: u64,
    failed: u64,
    ignored: u64,
    measured: u64,
    filtered_out: u64,
    seconds: f64,
}

impl Default for Total {
    /// The total of nothing.
    fn default() -> Self {
        Self {
            binaries: 0,
            ok: true,
            passed: 0,
            failed: 0,
            ignored: 0,
            measured: 0,
            filtered_out: 0,
            seconds: 0.0,
        }
    }
}

impl Total {
    /// Reads a closing line; `None` for any other line.
    pub(crate) fn of_line(line: &str) -> Option<Self> {
        let (verdict, counts) = line.trim_end().strip_prefix("test result: ")?.split_once(". ")?;
        let mut total = Self {
            binaries: 1,
            // With colours around it, too.
            ok: verdict.contains("ok"),
            ..Self::default()
        };
        for count in counts.split("; ") {
            if let Some(time) = count.strip_prefix("finished in ") {
                total.seconds = time.strip_suffix('s')?.parse().ok()?;
                continue;
            }
            let (number, what) = count.split_once(' ')?;
            let field = match what {
                "passed" => &mut total.passed,
                "failed" => &mut total.failed,
                "ignored" => &mut total.ignored,
                "measured" => &mut total.measured,
                "filtered out" => &mut total.filtered_out,
                _ => return None,
            };
            *field = number.parse().ok()?;
        }
        Some(total)
    }
}

impl AddAssign for Total {
    fn add_assign(&mut self, other: Self) {
        self.binaries += other.binaries;
        self.ok &= other.ok;
        self.passed += other.passed;
        self.failed += other.failed;
        self.ignored += other.ignored;
        self.measured += other.measured;
        self.filtered_out += other.filtered_out;
        self.seconds += other.seconds;
    }
}

impl fmt::Display for Total {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "test result: {}. {} passed; {} failed; {} ignored; {} measured; {} filtered out; \
             finished in {:.2}s",
            if self.ok { "ok" } else { "FAILED" },
            self.passed,
            self.failed,
            self.ignored,
            self.measured,
            self.filtered_out,
            self.seconds,
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn total(output: &str) -> String {
        let mut total = Total::default();
        for line in output.lines().filter_map(Total::of_line) {
            total += line;
        }
        total.to_string()
    }

    #[test]
    fn binaries_and_doctests_are_added_up() {
        let output = "
running 2 tests
test total::tests::lines ... ok
test total::tests::other ... ignored

test result: ok. 1 passed; 0 failed; 1 ignored; 0 measured; 2 filtered out; finished in 0.40s

   Doc-tests emitree
test crates/emitree/src/cell.rs - cell::CellIndex (line 8) ... ok

test result: ok. 10 passed; 0 failed; 0 ignored; 3 measured; 0 filtered out; finished in 1.75s

all doctests ran in 2.05s; merged doctests compilation took 0.30s
";
        assert_eq!(
            total(output),
            "test result: ok. 11 passed; 0 failed; 1 ignored; 3 measured; 2 filtered out; \
             finished in 2.15s"
        );
    }

    #[test]
    fn one_failure_fails_the_total() {
        let output = "
test result: FAILED. 1 passed; 2 failed; 0 ignored; 0 measured; 0 filtered out; finished in 0.10s
test result: ok. 4 passed; 0 failed; 0 ignored; 0 measured; 0 filtered out; finished in 0.10s
";
        assert_eq!(
            total(output),
            "test result: FAILED. 5 passed; 2 failed; 0 ignored; 0 measured; 0 filtered out; \
             finished in 0.20s"
        );
    }

    #[test]
    fn colours_do_not_matter() {
        let line = "test result: \u{1b}[31mFAILED\u{1b}(B\u{1b}[m. 0 passed; 1 failed; 0 ignored; \
                    0 measured; 0 filtered out; finished in 0.00s\n";
        assert!(Total::of_line(line).is_some_and(|total| !total.ok && total.failed == 1));
    }

    #[test]
    fn a_total_reads_as_what_it_is() {
        let line = "test result: ok. 312 passed; 0 failed; 7 ignored; 0 measured; 1 filtered out; \
                    finished in 42.10s";
        assert_eq!(total(line), line);
    }

    #[test]
    fn other_lines_are_not_counted() {
        for line in [
            "",
            "test result ... ok",
            "test result: ok. and so on",
            "the last line is: test result: ok. 1 passed; 0 failed",
            "test result: ok. many passed; finished in 0.00s",
        ] {
            assert_eq!(Total::of_line(line), None, "{line}");
        }
    }
}
