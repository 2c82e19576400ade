use super::*;
use emitree::{EnergyAxis, EnergyScale};
use fits_well::FitsReader;
use fits_well::header::CommentaryName;

fn image() -> Image {
    let pixels = [0.25, 1.25, f64::NAN, 1000.25, -0.0, f64::INFINITY];
    Image::from_pixels(2, 3, pixels.to_vec())
}

fn file(image: &Image) -> FitsFile<'_> {
    FitsFile {
        primary: FitsImage::new("RADIANCE", image, Some("m-2 sr-1 s-1")),
        extensions: Vec::new(),
        wcs: None,
        energies: None,
        provenance: Vec::new(),
        history: String::new(),
        date: None,
    }
}

#[test]
fn pixels_come_back_bit_for_bit_in_the_same_order() {
    let (image, small) = (image(), Image::from_pixels(1, 1, vec![5.0]));
    let mut file = file(&image);
    file.wcs = Some(Wcs::canonical(2, 3));
    file.extensions.push(FitsImage::new("EVALUATIONS", &small, None));
    file.extensions.push(FitsImage::new("ERROR", &image, None));
    let bytes = file.encode().unwrap();
    let mut reader = FitsReader::open(std::io::Cursor::new(bytes)).unwrap();
    for (hdu, expected) in [(0, &image), (1, &small), (2, &image)] {
        let mut hdu = reader.image(hdu).unwrap();
        assert_eq!(hdu.metadata().shape, [expected.width(), expected.height()]);
        let read = hdu.read(..).unwrap();
        let View::F64(pixels) = read.samples().view() else { panic!("64-bit floats") };
        let bits = |pixels: &[f64]| pixels.iter().map(|p| p.to_bits()).collect::<Vec<_>>();
        assert_eq!(bits(pixels), bits(expected.pixels()));
    }
}

#[test]
fn only_extensions_of_the_same_shape_get_coordinates() {
    let (image, small) = (image(), Image::zeros(1, 1));
    let mut file = file(&image);
    file.wcs = Some(Wcs::canonical(2, 3));
    let header = |image| file.header(&FitsImage::new("X", image, None)).unwrap();
    assert_eq!(header(&image).get_text("CTYPE1").unwrap(), Some("X"));
    assert_eq!(header(&small).get_text("CTYPE1").unwrap(), None);
}

#[test]
fn wrong_and_taken_keywords_are_named() {
    let image = image();
    let message = |keyword: &str| {
        let mut file = file(&image);
        file.provenance = vec![Card::new(keyword, 1, ""), Card::new("TWICE", 1, "")];
        file.encode().unwrap_err().to_string()
    };
    for keyword in ["BITPIX", "NAXIS1", "BUNIT", "CREATOR", "TWICE", "CHECKSUM"] {
        let taken = format!("FITS keyword `{keyword}` is written already: expected another one");
        assert_eq!(message(keyword), taken);
    }
    for keyword in ["lower", "TOOLONGNAME", "ÄÖ", "", "HISTORY"] {
        let message = message(keyword);
        assert!(message.starts_with(&format!("FITS keyword `{keyword}`: ")), "{message}");
        assert!(message.contains("expected 1 to 8 of A-Z"), "{message}");
    }
}

#[test]
fn any_scene_makes_a_history() {
    let image = image();
    let lines = ["= 3", "  indented", "'quoted'", "END", "CONTINUE  'x'", "", "/ slash", "a\r"];
    let mut file = file(&image);
    file.history = lines.join("\n");
    let bytes = file.encode().unwrap();
    let reader = FitsReader::open(std::io::Cursor::new(bytes)).unwrap();
    let header = &reader.hdus()[0].header;
    let history: Vec<_> = header.commentary(CommentaryName::HISTORY).collect();
    assert_eq!(history[..7], lines[..7]);
    assert_eq!(history[7], "a");
}

#[test]
fn cubes_have_a_third_axis_and_a_table_of_bins() {
    let axis = EnergyAxis::new(1.0, 4.0, 2, EnergyScale::Log).unwrap();
    let energies = Energies::new(axis, "keV").unwrap();
    let (low, high) = (image(), Image::from_pixels(2, 3, vec![7.0; 6]));
    let cube = Cube::from_bands(vec![low.clone(), high.clone()]);
    let mut file = file(&low);
    file.primary = FitsImage::cube("RADIANCE", &cube, None);
    file.extensions.push(FitsImage::new("BAND", &high, None));
    file.wcs = Some(Wcs::canonical(2, 3));
    file.energies = Some(&energies);
    let bytes = file.encode().unwrap();
    let mut reader = FitsReader::open(std::io::Cursor::new(bytes)).unwrap();
    assert_eq!(reader.hdus().len(), 3);
    let text =
        |hdu: usize, key: &str| reader.hdus()[hdu].header.get_text(key).unwrap().map(str::to_owned);
    assert_eq!(text(0, "CTYPE3").as_deref(), Some("ENER-LOG"));
    assert_eq!(text(0, "CUNIT3").as_deref(), Some("J"));
    assert_eq!((text(1, "CTYPE2").as_deref(), text(1, "CTYPE3")), (Some("Y"), None));
    assert_eq!(text(2, "EXTNAME").as_deref(), Some("ENERGIES"));
    assert_eq!(text(2, "TUNIT2").as_deref(), Some("keV"));
    let mut hdu = reader.image(0).unwrap();
    assert_eq!(hdu.metadata().shape, [3, 2, 2]);
    let read = hdu.read(..).unwrap();
    let View::F64(voxels) = read.samples().view() else { panic!("64-bit floats") };
    let bits = |voxel: f64| voxel.to_bits();
    assert!(voxels.iter().copied().map(bits).eq(cube.voxels().map(bits)));
}
