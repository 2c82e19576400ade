use super::*;
use fits_well::FitsReader;
use fits_well::header::CommentaryName;

fn image() -> Image {
    let pixels = [0.25, 1.25, f64::NAN, 1000.25, -0.0, f64::INFINITY];
    Image::from_pixels(2, 3, pixels.to_vec())
}

fn file(image: &Image) -> FitsFile<'_> {
    FitsFile {
        primary: FitsImage { name: "RADIANCE", image, unit: Some("m-2 sr-1 s-1") },
        extensions: Vec::new(),
        wcs: None,
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
    file.extensions.push(FitsImage { name: "EVALUATIONS", image: &small, unit: None });
    file.extensions.push(FitsImage { name: "ERROR", image: &image, unit: None });
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
    let header = |image| file.header(&FitsImage { name: "X", image, unit: None }).unwrap();
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
