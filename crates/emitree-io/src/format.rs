//! The format of an output file, chosen by the ending of its name.

use std::path::{Path, PathBuf};

/// A format that images can be written in.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Format {
    /// FITS: the image, its error and other maps, with units, coordinates and provenance.
    Fits,
    /// The array file of `numpy`: the bare numbers of one image.
    Npy,
    /// PNG: a picture for looking, not for numbers.
    Png,
}

impl Format {
    /// The endings that choose a format, lower case and without the dot.
    pub const ENDINGS: [(&'static str, Self); 4] =
        [("fits", Self::Fits), ("fit", Self::Fits), ("npy", Self::Npy), ("png", Self::Png)];

    /// The format that the ending of `path` stands for, upper or lower case.
    ///
    /// # Errors
    ///
    /// [`UnknownEnding`] with the endings that there are.
    ///
    /// ```
    /// use emitree_io::Format;
    ///
    /// assert_eq!(Format::from_path("run/image.fits"), Ok(Format::Fits));
    /// let error = Format::from_path("image.jpeg").unwrap_err();
    /// assert_eq!(
    ///     error.to_string(),
    ///     "`image.jpeg`: no format for this ending: expected .fits, .fit, .npy or .png"
    /// );
    /// ```
    pub fn from_path(path: impl AsRef<Path>) -> Result<Self, UnknownEnding> {
        let path = path.as_ref();
        let ending = path.extension().and_then(|ending| ending.to_str()).unwrap_or_default();
        Self::ENDINGS
            .into_iter()
            .find(|(name, _)| name.eq_ignore_ascii_case(ending))
            .map(|(_, format)| format)
            .ok_or_else(|| UnknownEnding { path: path.to_owned() })
    }
}

/// A file name whose ending stands for no format.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("`{}`: no format for this ending: expected .fits, .fit, .npy or .png", path.display())]
pub struct UnknownEnding {
    /// The path given.
    pub path: PathBuf,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn endings_choose_formats_in_any_case() {
        for (ending, format) in Format::ENDINGS {
            assert_eq!(Format::from_path(format!("a.b/c.{ending}")), Ok(format));
            assert_eq!(Format::from_path(format!("c.{}", ending.to_uppercase())), Ok(format));
        }
    }

    #[test]
    fn the_error_lists_every_ending() {
        for path in ["image", "image.", "fits", ".png", "image.png.bak", "a.fits/b"] {
            let message = Format::from_path(path).unwrap_err().to_string();
            assert!(message.starts_with(&format!("`{path}`")), "{message}");
            for (ending, _) in Format::ENDINGS {
                assert!(message.contains(&format!(".{ending}")), "{message}");
            }
        }
    }
}
