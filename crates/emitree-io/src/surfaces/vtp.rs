//! The .vtp file of VTK: polygons in XML, with arrays in base64.
//!
//! The format is described in [VTK File Formats](https://docs.vtk.org/en/latest/vtk_file_formats/index.html):
//! each array is the number of its bytes and the bytes, both little-endian.

use super::Texts;
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use emitree::result::FoundSurfaces;
use std::fmt::Write;

pub(super) fn encode(surfaces: &FoundSurfaces, texts: &Texts<'_>) -> Vec<u8> {
    let FoundSurfaces { positions, normals, jumps, uncertainties, triangles, .. } = surfaces;
    let vectors =
        |vectors: &[[f64; 3]]| base64(vectors.as_flattened().iter().copied().map(f64::to_le_bytes));
    let numbers = |numbers: &[f64]| base64(numbers.iter().copied().map(f64::to_le_bytes));
    let vertices = triangles.as_flattened().iter().map(|vertex| i64::from(*vertex).to_le_bytes());
    let ends = (1_i64..).take(triangles.len()).map(|number| (3 * number).to_le_bytes());
    let data_array = |type_and_name: &str, components: usize, data: &str| {
        format!(
            "<DataArray {type_and_name} NumberOfComponents=\"{components}\" format=\"binary\">{data}\
             </DataArray>\n"
        )
    };
    let mut text = String::from(
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"PolyData\" version=\"1.0\" \
         byte_order=\"LittleEndian\" header_type=\"UInt64\">\n<PolyData>\n<FieldData>\n",
    );
    for (name, value) in texts {
        text.push_str(&string_array(name, value));
    }
    text.push_str("</FieldData>\n");
    // Writing to a string does not fail.
    let _ = writeln!(
        text,
        "<Piece NumberOfPoints=\"{}\" NumberOfVerts=\"0\" NumberOfLines=\"0\" NumberOfStrips=\"0\" \
         NumberOfPolys=\"{}\">",
        positions.len(),
        triangles.len()
    );
    text.push_str("<PointData Scalars=\"jump\" Normals=\"normal\">\n");
    text.push_str(&data_array("type=\"Float64\" Name=\"normal\"", 3, &vectors(normals)));
    text.push_str(&data_array("type=\"Float64\" Name=\"jump\"", 1, &numbers(jumps)));
    text.push_str(&data_array("type=\"Float64\" Name=\"uncertainty\"", 1, &numbers(uncertainties)));
    text.push_str("</PointData>\n<Points>\n");
    text.push_str(&data_array("type=\"Float64\" Name=\"position\"", 3, &vectors(positions)));
    text.push_str("</Points>\n<Polys>\n");
    text.push_str(&data_array("type=\"Int64\" Name=\"connectivity\"", 1, &base64(vertices)));
    text.push_str(&data_array("type=\"Int64\" Name=\"offsets\"", 1, &base64(ends)));
    text.push_str("</Polys>\n</Piece>\n</PolyData>\n</VTKFile>\n");
    text.into_bytes()
}

/// A text as VTK has it: the codes of its bytes, and 0 at the end.
fn string_array(name: &str, value: &str) -> String {
    let codes: Vec<String> = value.bytes().map(|code| format!("{code} ")).collect();
    format!(
        "<Array type=\"String\" Name=\"{name}\" NumberOfTuples=\"1\" format=\"ascii\">{}0</Array>\n",
        codes.concat()
    )
}

/// The number of bytes, and the bytes.
fn base64(numbers: impl Iterator<Item = [u8; 8]>) -> String {
    let mut bytes = vec![0; 8];
    bytes.extend(numbers.flatten());
    let length = bytes.len() as u64 - 8;
    bytes[..8].copy_from_slice(&length.to_le_bytes());
    STANDARD.encode(bytes)
}
