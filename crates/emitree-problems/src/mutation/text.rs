//! Mutations of the text of a scene.

use super::Mutator;

/// The most changes in one mutant.
const MOST_CHANGES: u32 = 3;

/// Values of other kinds than the one that is expected.
const OTHER_KINDS: [&str; 12] = [
    "\"text\"",
    "\"\"",
    "true",
    "[]",
    "[[1, 2], [3]]",
    "[1.0, 2.0, 3.0, 4.0]",
    "{}",
    "{ a = 1 }",
    "1979-05-27",
    "-7",
    "0.5",
    "\"1e400\"",
];

impl Mutator {
    /// This scene with one to three changes: numbers at the ends of their range, keys or tables that
    /// are missing or there twice, values of another kind, letters.
    pub fn scene(&mut self, original: &str) -> String {
        let mut lines: Vec<String> = original.lines().map(str::to_owned).collect();
        for _ in 0..self.random.whole(1..=MOST_CHANGES) {
            self.change_scene(&mut lines);
        }
        lines.join("\n") + "\n"
    }

    fn change_scene(&mut self, lines: &mut Vec<String>) {
        let written = |line: &&(usize, &String)| {
            let text = line.1.trim();
            !text.is_empty() && !text.starts_with('#')
        };
        let candidates: Vec<usize> =
            lines.iter().enumerate().filter(|line| written(&line)).map(|(at, _)| at).collect();
        let Some(&at) = self.choice(&candidates) else { return };
        let has_value = lines[at].contains('=');
        match self.random.whole(0..=11) {
            0..=5 => lines[at] = self.change_number(&lines[at]),
            6 | 7 if has_value => {
                let key = lines[at].split('=').next().unwrap_or_default().trim_end().to_owned();
                let value = self.choice(&OTHER_KINDS).copied().unwrap_or_default();
                lines[at] = format!("{key} = {value}");
            }
            8 => drop(lines.remove(at)),
            9 => {
                let place = candidates[self.below(candidates.len())];
                lines.insert(place, lines[at].clone());
            }
            10 => {
                let other = candidates[self.below(candidates.len())];
                lines.swap(at, other);
            }
            _ => lines[at] = self.change_letter(&lines[at]),
        }
    }

    /// The line with one of its numbers replaced.
    fn change_number(&mut self, line: &str) -> String {
        let starts: Vec<usize> = line
            .char_indices()
            .zip(core::iter::once(' ').chain(line.chars()))
            .filter(|((_, letter), before)| {
                letter.is_ascii_digit() && !before.is_alphanumeric() && !"._".contains(*before)
            })
            .map(|((at, _), _)| at)
            .collect();
        let Some(&start) = self.choice(&starts) else { return line.to_owned() };
        let length =
            line[start..].chars().take_while(|c| c.is_ascii_alphanumeric() || "._".contains(*c));
        let end = start + length.count();
        let number = match self.random.whole(0..=2) {
            0 => self.integer().to_string(),
            1 => format!("{:e}", self.number()).replace("NaN", "nan"),
            _ => {
                let old: f64 = line[start..end].replace('_', "").parse().unwrap_or(1.0);
                format!("{:e}", old * self.random.log_between(1e-3, 1e3))
            }
        };
        // A sign that is there already must not become two.
        let before = if number.starts_with('-') {
            line[..start].strip_suffix('-').unwrap_or(&line[..start])
        } else {
            &line[..start]
        };
        format!("{before}{number}{}", &line[end..])
    }

    fn change_letter(&mut self, line: &str) -> String {
        let mut letters: Vec<char> = line.chars().collect();
        let at = self.below(letters.len());
        let other = self.choice(&['x', '(', ')', '"', '[', '=', '.', 'é', '\u{0}', '^', ',']);
        match (other, self.one_in(2)) {
            (Some(&other), true) => letters.insert(at, other),
            _ if !letters.is_empty() => drop(letters.remove(at)),
            _ => {}
        }
        letters.into_iter().collect()
    }
}
