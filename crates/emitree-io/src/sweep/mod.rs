//! Sweeps over scenes: the values of some keys, the scenes that have them, and the names of their files.
//!
//! * `values`: the values of one key, as the command line writes them;
//! * `template`: names of files by values;
//! * `report`: the report of all images;
//! * `error`: what can be wrong.

mod error;
mod report;
mod template;
mod values;

pub use error::SweepError;
pub use report::{SweepReport, SweptImage};
pub use template::NameTemplate;
pub use values::SweptKey;

use crate::scene::Override;

/// The most images of a sweep.
const MOST_IMAGES: usize = 100_000;

/// All combinations of the values of some keys of a scene; those of the last key change first.
///
/// ```
/// use emitree_io::{SceneSweep, SweptKey};
///
/// let keys = ["emission.constants.a=1:3:3", "image.width=32,64"];
/// let keys = keys.map(SweptKey::parse).into_iter().collect::<Result<_, _>>()?;
/// let sweep = SceneSweep::new(keys)?;
/// assert_eq!(sweep.len(), 6);
/// assert_eq!(sweep.values(1), [1.0, 64.0]);
/// assert_eq!(sweep.label(1), "emission.constants.a = 1, image.width = 64");
/// # Ok::<(), emitree_io::SweepError>(())
/// ```
#[derive(Clone, Debug)]
pub struct SceneSweep {
    keys: Vec<SweptKey>,
    count: usize,
}

impl SceneSweep {
    /// The sweep over these keys.
    ///
    /// # Errors
    ///
    /// [`SweepError`]: no key, a key that is there twice, more than 100,000 images.
    pub fn new(keys: Vec<SweptKey>) -> Result<Self, SweepError> {
        if keys.is_empty() {
            return Err(SweepError::NoKey);
        }
        for (number, key) in keys.iter().enumerate() {
            if keys.iter().take(number).any(|before| before.name() == key.name()) {
                return Err(SweepError::KeyTwice { key: key.name().to_owned() });
            }
        }
        let product = |count: usize, key: &SweptKey| count.saturating_mul(key.values().len());
        let count = keys.iter().fold(1, product);
        match count <= MOST_IMAGES {
            true => Ok(Self { keys, count }),
            false => Err(SweepError::TooMany { count, most: MOST_IMAGES }),
        }
    }

    /// The keys, in their order.
    pub fn keys(&self) -> &[SweptKey] {
        &self.keys
    }

    /// The number of images.
    pub fn len(&self) -> usize {
        self.count
    }

    /// Whether there are no images: never.
    pub fn is_empty(&self) -> bool {
        self.count == 0
    }

    /// The value of each key in an image, by its number from 0.
    pub fn values(&self, image: usize) -> Vec<f64> {
        let mut rest = image;
        let mut values: Vec<f64> = Vec::with_capacity(self.keys.len());
        for key in self.keys.iter().rev() {
            let of_key = key.values();
            values.extend(of_key.get(rest % of_key.len()));
            rest /= of_key.len();
        }
        values.reverse();
        values
    }

    /// What an image replaces in the scene.
    pub fn overrides(&self, image: usize) -> Vec<Override> {
        let of_key = |(key, value): (&SweptKey, f64)| Override {
            key: key.name().to_owned(),
            value: as_text(value),
            option: "over".to_owned(),
        };
        self.keys.iter().zip(self.values(image)).map(of_key).collect()
    }

    /// The keys and values of an image, for messages.
    pub fn label(&self, image: usize) -> String {
        let of_key =
            |(key, value): (&SweptKey, f64)| format!("{} = {}", key.name(), as_text(value));
        let of_keys: Vec<String> = self.keys.iter().zip(self.values(image)).map(of_key).collect();
        of_keys.join(", ")
    }
}

/// A number as TOML: whole ones without a point, so that they may be those of pixels.
fn as_text(value: f64) -> String {
    if value.abs() < 1e15 { format!("{value}") } else { format!("{value:e}") }
}

#[cfg(test)]
mod tests;
