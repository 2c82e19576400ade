//! The frames of `--progressive`: successive images in a folder.

use super::rendered::Rendered;
use crate::failure::Failure;
use emitree::progress::Frame;
use emitree::radiance::image_of_tree;
use emitree::result::RenderedTree;
use emitree::{Cube, Image};
use emitree_io::{
    Bands, Format, OutputFile, OutputSet, PictureStyle, Product, ProductMap, Scene, ValueRange,
    commit_all,
};
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

/// What the names of frames start with.
const FRAME: &str = "frame-";

/// Writes the intermediate images of a rendering, each as soon as it exists.
pub(crate) struct FrameWriter<'a> {
    folder: &'a Path,
    scene: &'a Scene,
    // A callback is shared between threads, so what it leaves behind is behind a lock.
    state: Mutex<State>,
}

#[derive(Default)]
struct State {
    frames: usize,
    written: Vec<PathBuf>,
    failure: Option<Failure>,
}

impl<'a> FrameWriter<'a> {
    pub(crate) fn new(folder: &'a Path, scene: &'a Scene) -> Self {
        Self { folder, scene, state: Mutex::default() }
    }

    /// Writes a frame; breaks off if that fails, and [`finish`](Self::finish) returns the error.
    pub(crate) fn write(&self, frame: &Frame<'_>) -> ControlFlow<()> {
        self.write_images(frame.image, frame.error, frame.evaluations)
    }

    fn write_images(&self, image: &Image, error: &Image, evaluations: u64) -> ControlFlow<()> {
        // Bytes are made before the lock is taken: it is held while files are written only.
        // Frames of a cube are the images of its whole energy band.
        let shown = |image: &Image| {
            let image = self.scene.in_band_unit(image.clone());
            Cube::from_bands(vec![self.scene.in_quantity(&image)])
        };
        let [image, error] = [image, error].map(shown);
        let bytes = self.encode(&image, &error);
        let mut state = self.state.lock().unwrap_or_else(PoisonError::into_inner);
        match bytes.and_then(|bytes| self.store(&mut state, evaluations, bytes)) {
            Ok(()) => ControlFlow::Continue(()),
            Err(failure) => {
                state.failure.get_or_insert(failure);
                ControlFlow::Break(())
            }
        }
    }

    /// The files of a frame, by the endings of their names. Colours are those of the frame's own
    /// range: that of the last image is not known yet.
    fn encode(&self, image: &Cube, error: &Cube) -> Result<[(&'static str, Vec<u8>); 3], Failure> {
        let scene = self.scene;
        let unit = if scene.axis().is_some() { scene.band_unit() } else { scene.image_unit() };
        Ok([
            (".npy", encode(image, unit, Format::Npy, scene, None)?),
            ("-error.npy", encode(error, unit, Format::Npy, scene, None)?),
            (".png", encode(image, unit, Format::Png, scene, None)?),
        ])
    }

    fn store<const N: usize>(
        &self,
        state: &mut State,
        evaluations: u64,
        files: [(&str, Vec<u8>); N],
    ) -> Result<(), Failure> {
        let number = state.frames;
        let path =
            |ending| self.folder.join(format!("{FRAME}{number:02}-{evaluations:08}{ending}"));
        let outputs = OutputSet::create(files.each_ref().map(|(ending, _)| path(*ending)))?;
        let bytes = files.map(|(_, bytes)| bytes);
        state.written.extend(commit_all(outputs.into_iter().zip(bytes))?);
        state.frames += 1;
        Ok(())
    }

    /// The names of the files written, or what went wrong first.
    pub(crate) fn finish(self) -> Result<Vec<PathBuf>, Failure> {
        let State { written, failure, .. } =
            self.state.into_inner().unwrap_or_else(PoisonError::into_inner);
        failure.map_or(Ok(written), Err)
    }
}

/// The bytes of a frame; colours of a picture in `range`, or in the map's own.
fn encode(
    map: &Cube,
    unit: &str,
    format: Format,
    scene: &Scene,
    range: Option<ValueRange>,
) -> Result<Vec<u8>, Failure> {
    let (name, bands) = (scene.quantity.name(), Bands::Image);
    let product = Product::new(scene, ProductMap { name, map, unit, bands });
    Ok(format.encode(&product, PictureStyle::Bare { range })?)
}

/// Writes the images with more and more coefficients of a tree, all in the colours of the last.
pub(super) fn write_progression(
    folder: &Path,
    scene: &Scene,
    rendered: &Rendered,
) -> Result<Vec<PathBuf>, Failure> {
    let Some(RenderedTree { tree, .. }) = &rendered.tree else { return Ok(Vec::new()) };
    let images: Vec<&Image> = rendered.values.bands().iter().collect();
    let range = ValueRange::of(&images);
    let shape = [scene.height, scene.width];
    let mut written = Vec::new();
    for (i, frame) in tree.progression::<2>(2).enumerate() {
        let image = image_of_tree(&frame.tree, scene.camera.projection(), shape);
        let image = Cube::from_bands(vec![scene.in_quantity(&image)]);
        for (format, ending) in [(Format::Png, "png"), (Format::Npy, "npy")] {
            let name = format!("{FRAME}{i:02}-{:08}.{ending}", frame.coefficients);
            let file = OutputFile::create(folder.join(name))?;
            written.push(file.path().to_owned());
            file.commit(&encode(&image, scene.image_unit(), format, scene, Some(range))?)?;
        }
    }
    Ok(written)
}

/// Makes the folder of the frames, and checks that it can be written and that no frames of another
/// run would stand among the new ones.
pub(super) fn prepare_folder(folder: &Path) -> Result<(), Failure> {
    let refuse = |why: String| {
        Err(Failure::Request(format!("--progressive: the folder {} {why}", folder.display())))
    };
    if let Err(error) = std::fs::create_dir_all(folder) {
        return refuse(format!("can't be made: {error}"));
    }
    OutputFile::create(folder.join(FRAME))?;
    let entries = match std::fs::read_dir(folder) {
        Ok(entries) => entries,
        Err(error) => return refuse(format!("can't be read: {error}")),
    };
    if entries.flatten().any(|entry| is_frame_of(&entry.path(), folder)) {
        return refuse("has frames already: expected a new or empty one".to_owned());
    }
    Ok(())
}

/// Whether a path is named like a frame and is in the folder of the frames.
pub(super) fn is_frame_of(path: &Path, folder: &Path) -> bool {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    // The parent of a bare name is the empty path, which stands for this folder.
    let parent = path.parent().filter(|parent| !parent.as_os_str().is_empty());
    name.starts_with(FRAME) && same_file(parent.unwrap_or(Path::new(".")), folder)
}

/// Whether two paths lead to the same file.
pub(crate) fn same_file(a: &Path, b: &Path) -> bool {
    match (std::fs::canonicalize(a), std::fs::canonicalize(b)) {
        (Ok(a), Ok(b)) => a == b,
        _ => false,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use emitree_io::encode_npy_image;

    fn scene() -> Scene {
        let text = r#"
            emission.expression = "x"
            projection.type = "canonical"
            image = { width = 3, height = 2 }
        "#;
        Scene::parse("scene.toml", text, &[]).unwrap()
    }

    #[test]
    fn each_frame_is_there_at_once_with_its_error() {
        let folder = tempfile::tempdir().unwrap();
        let scene = scene();
        let writer = FrameWriter::new(folder.path(), &scene);
        let image = |value| Image::from_pixels(2, 3, vec![value; 6]);
        for (files, evaluations, value) in [(3, 729, 1.0), (6, 123_456_789, 2.0)] {
            assert!(writer.write_images(&image(value), &image(0.1), evaluations).is_continue());
            assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), files);
        }
        let npy = std::fs::read(folder.path().join("frame-01-123456789.npy")).unwrap();
        assert_eq!(npy, encode_npy_image(&image(2.0)));
        let error = std::fs::read(folder.path().join("frame-00-00000729-error.npy")).unwrap();
        assert_eq!(error, encode_npy_image(&image(0.1)));
        let names = writer.finish().unwrap();
        let expected = ["00-00000729", "01-123456789"].map(|name| {
            [".npy", "-error.npy", ".png"].map(|ending| format!("frame-{name}{ending}"))
        });
        assert_eq!(
            names,
            expected.as_flattened().iter().map(|n| folder.path().join(n)).collect::<Vec<_>>()
        );
    }

    #[test]
    fn a_frame_that_fails_ends_the_rendering_with_its_own_failure() {
        let folder = tempfile::tempdir().unwrap();
        let scene = scene();
        let writer = FrameWriter::new(folder.path(), &scene);
        let image = Image::zeros(2, 3);
        assert!(writer.write_images(&image, &image, 729).is_continue());
        // The error map can't be written: neither is the image.
        let obstacle = folder.path().join("frame-01-00001000-error.npy");
        std::fs::create_dir(&obstacle).unwrap();
        assert!(writer.write_images(&image, &image, 1000).is_break());
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 3 + 1);
        let failure = writer.finish().unwrap_err();
        let expected = "is a directory: expected a new or an ordinary file";
        assert_eq!(failure.to_string(), format!("`{}` {expected}", obstacle.display()));
    }
}
