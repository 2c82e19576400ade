//! The .npz file of `numpy`: a zip archive of .npy files.

use super::Texts;
use crate::npy::{encode, encode_npy_integers, encode_npy_text};
use emitree::result::FoundSurfaces;
use std::io::{Cursor, Write};
use zip::result::ZipResult;
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, ZipWriter};

pub(super) fn archive(surfaces: &FoundSurfaces, texts: &Texts<'_>) -> ZipResult<Vec<u8>> {
    let FoundSurfaces { positions, normals, jumps, uncertainties, triangles, .. } = surfaces;
    let vectors =
        |vectors: &[[f64; 3]]| encode(&[vectors.len(), 3], vectors.as_flattened().iter().copied());
    let numbers = |numbers: &[f64]| encode(&[numbers.len()], numbers.iter().copied());
    let vertices = triangles.as_flattened().iter().map(|vertex| i64::from(*vertex));
    let mut arrays = vec![
        ("position", vectors(positions)),
        ("normal", vectors(normals)),
        ("jump", numbers(jumps)),
        ("uncertainty", numbers(uncertainties)),
        ("triangles", encode_npy_integers(&[triangles.len(), 3], vertices)),
    ];
    arrays.extend(texts.iter().map(|(name, text)| (*name, encode_npy_text(text))));
    let mut archive = ZipWriter::new(Cursor::new(Vec::new()));
    let options = SimpleFileOptions::default().compression_method(CompressionMethod::Deflated);
    let mut add = |name: &str, bytes: &[u8]| -> ZipResult<()> {
        archive.start_file(format!("{name}.npy"), options)?;
        Ok(archive.write_all(bytes)?)
    };
    arrays.iter().try_for_each(|(name, bytes)| add(name, bytes))?;
    Ok(archive.finish()?.into_inner())
}
