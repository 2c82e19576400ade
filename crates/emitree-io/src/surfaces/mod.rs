//! Files of found surfaces: one row for each format, and one file each; chosen by the ending of a name.

mod npz;
mod vtp;

use crate::account::Account;
use crate::format::{EncodeError, UnknownEnding};
use crate::words::alternatives;
use emitree::result::FoundSurfaces;
use std::path::Path;

/// A format that found surfaces can be written in.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum SurfaceFormat {
    /// Polygons of VTK in XML, for `ParaView` and `PyVista`.
    Vtp,
    /// Arrays of `numpy` by name.
    Npz,
}

impl SurfaceFormat {
    /// All formats, in the order of messages.
    pub const ALL: [Self; 2] = [Self::Vtp, Self::Npz];

    /// The ending of names that chooses it, lower case and without the dot.
    pub fn ending(self) -> &'static str {
        match self {
            Self::Vtp => "vtp",
            Self::Npz => "npz",
        }
    }

    /// The format that the ending of `path` stands for, upper or lower case.
    ///
    /// # Errors
    ///
    /// [`UnknownEnding`] with the endings that there are.
    ///
    /// ```
    /// use emitree_io::SurfaceFormat;
    ///
    /// assert_eq!(SurfaceFormat::from_path("shock.vtp"), Ok(SurfaceFormat::Vtp));
    /// let error = SurfaceFormat::from_path("shock.stl").unwrap_err();
    /// let message = "`shock.stl`: no format for this ending: expected .vtp or .npz";
    /// assert_eq!(error.to_string(), message);
    /// ```
    pub fn from_path(path: impl AsRef<Path>) -> Result<Self, UnknownEnding> {
        let path = path.as_ref();
        let ending = path.extension().and_then(|ending| ending.to_str()).unwrap_or_default();
        let has_ending = |format: &Self| format.ending().eq_ignore_ascii_case(ending);
        Self::ALL.into_iter().find(has_ending).ok_or_else(|| UnknownEnding {
            path: path.to_owned(),
            expected: alternatives(Self::ALL.map(|format| format!(".{}", format.ending()))),
        })
    }

    /// The bytes of a file with the surfaces of a rendering, as
    /// [`RenderedScene::surfaces`](crate::RenderedScene::surfaces) has them, and their units.
    ///
    /// # Errors
    ///
    /// [`EncodeError::Archive`]: arrays that an archive can't hold.
    pub fn encode(
        self,
        surfaces: &FoundSurfaces,
        account: &Account,
    ) -> Result<Vec<u8>, EncodeError> {
        let texts = texts(account);
        match self {
            Self::Vtp => Ok(vtp::encode(surfaces, &texts)),
            Self::Npz => npz::archive(surfaces, &texts)
                .map_err(|error| EncodeError::Archive { reason: error.to_string() }),
        }
    }
}

/// Names and values of what a file says beside its numbers.
type Texts<'a> = [(&'static str, &'a str); 4];

fn texts(account: &Account) -> Texts<'_> {
    let length_unit = account.length_unit.as_deref().unwrap_or_default();
    [
        ("length_unit", length_unit),
        ("jump_unit", &account.rate_unit),
        ("scene", &account.scene),
        ("version", &account.version),
    ]
}

#[cfg(test)]
mod tests;
