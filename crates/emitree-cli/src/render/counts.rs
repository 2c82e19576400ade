//! The counts of the instrument of a scene.

use crate::arguments::RenderArguments;
use crate::failure::Failure;
use emitree::{Cube, RenderError};
use emitree_instrument::{Channel, Observation, StepSum, draw_counts};
use emitree_io::{Account, Bands, CountsReport, Format, Scene};

/// The counts of an instrument, and how they came about.
#[derive(Clone, Debug)]
pub(crate) struct Counts {
    /// The expected counts.
    pub(crate) expected: Cube,
    /// The counts that were drawn from them, if they were requested.
    pub(crate) drawn: Option<Cube>,
    /// Their channels.
    channels: Vec<Channel>,
    /// The sums at each step from the radiance to the expected counts.
    pub(crate) steps: Vec<StepSum>,
}

impl Counts {
    /// Of a cube of radiance, before it is in the quantity of the scene; none if the scene has no
    /// instrument, or if no output contains counts.
    ///
    /// A failure comes beside what can be had without it, and is none of the rendering.
    pub(super) fn of(
        arguments: &RenderArguments,
        scene: &Scene,
        radiance: &Cube,
    ) -> (Option<Self>, Option<Failure>) {
        let Some(instrument) = scene.instrument.as_ref().filter(|_| are_needed(arguments)) else {
            return (None, None);
        };
        let observation = match scene.expected_counts(radiance) {
            Some(Ok(observation)) => observation,
            Some(Err(error)) => return (None, Some(error.into())),
            None => return (None, None),
        };
        let is_drawn = !arguments.counts.is_empty();
        let drawn = is_drawn.then(|| draw_counts(&observation.counts, instrument.seed));
        let (drawn, failure) = match drawn.transpose() {
            Ok(drawn) => (drawn, None),
            Err(error) => (None, Some(error.into())),
        };
        let Observation { counts: expected, channels, steps, .. } = observation;
        (Some(Self { expected, drawn, channels, steps }), failure)
    }

    /// What the bands of the counts are.
    pub(super) fn bands(&self) -> Bands<'_> {
        Bands::Counts { channels: &self.channels }
    }

    /// The counts in the report.
    pub(super) fn report(&self, account: &Account) -> CountsReport {
        CountsReport::new(account, &self.expected, self.drawn.as_ref(), &self.steps)
    }
}

/// Whether a file, the report or the summary contains counts.
fn are_needed(arguments: &RenderArguments) -> bool {
    let has_files = !arguments.expected_counts.is_empty() || !arguments.counts.is_empty();
    has_files || arguments.report.is_some() || !arguments.running.quiet
}

/// The sum of a map over all channels, and over the pixels in the field.
pub(crate) fn total(map: &Cube) -> f64 {
    map.voxels().filter(|count| !count.is_nan()).sum()
}

/// Refuses counts of a scene that has none, or that a file or the memory has no room for: `formats` are
/// those of the files, `allowed` the memory that they may take, in bytes.
pub(super) fn check(
    arguments: &RenderArguments,
    scene: &Scene,
    formats: &[Format],
    allowed: u64,
) -> Result<(), Failure> {
    let asked =
        [("--expected-counts", &arguments.expected_counts), ("--counts", &arguments.counts)];
    let (Some(instrument), Some(energies)) = (&scene.instrument, &scene.energy) else {
        return match asked.iter().find(|(_, files)| !files.is_empty()) {
            None => Ok(()),
            Some((option, _)) => Err(Failure::Request(format!(
                "{option}: the scene has no `[instrument]`, and nothing counts its photons: expected \
                 a scene with one"
            ))),
        };
    };
    if !are_needed(arguments) {
        return Ok(());
    }
    let (height, width, bins) = (scene.height, scene.width, energies.axis().bins());
    let channels = instrument.channels(bins);
    if let Some((format, most)) = fewest_maps_of_sky(scene, formats)
        && channels > most
    {
        let why = format!("a table of {format} has no columns for");
        return Err(Failure::Request(format!(
            "counts: {why} {channels} channels of a sky: expected {most} or less, or .npy"
        )));
    }
    let pixels = (height as u64).saturating_mul(width as u64);
    let cubes = |bands: usize| pixels.saturating_mul(bands as u64).saturating_mul(8);
    // The radiance and its error; what is drawn; and each file before it is written, one of them twice.
    let files = arguments.expected_counts.len() + arguments.counts.len();
    let copies = files + usize::from(files > 0) + usize::from(!arguments.counts.is_empty());
    let needed = instrument
        .memory_bytes([bins, height, width])
        .saturating_add(cubes(bins).saturating_mul(2))
        .saturating_add(cubes(channels).saturating_mul(copies as u64));
    if needed > allowed {
        let what = format!("counting {height} x {width} pixels in {channels} channels");
        return Err(Failure::Render(RenderError::TooLarge { what, needed, allowed }));
    }
    Ok(())
}

/// The format that has room for the fewest maps of a sky, or bands of them, and how many these are; none
/// if the scene is no sky, or if all formats have room for any number.
pub(super) fn fewest_maps_of_sky(
    scene: &Scene,
    formats: &[Format],
) -> Option<(&'static str, usize)> {
    let rows = formats.iter().map(|format| format.description());
    let limits = rows.filter_map(|row| Some((row.name, row.most_maps_of_sky?)));
    limits.min_by_key(|&(_, most)| most).filter(|_| scene.camera.description().is_sky())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::arguments::{Arguments, Command};
    use clap::Parser;

    const SCENE: &str = r#"
        emission = { expression = "1", unit = "ph cm-3 s-1 sr-1 keV-1" }
        image = { width = 40, height = 25 }
        energy = { min = 0.5, max = 1.5, bins = 10 }
        instrument = { effective_area = 50.0, exposure = 1e4 }
        [projection]
        type = "equirectangular"
        position = [0, 0, 0]
        target = [1, 0, 0]
        field_of_view = [1, 1]
        far = 1
        length_unit = "cm"
    "#;

    fn failure(options: &[&str], allowed: u64) -> Option<String> {
        let words = ["emitree", "render", "scene.toml"].iter().chain(options);
        let Command::Render(arguments) = Arguments::parse_from(words).command else {
            panic!("a rendering");
        };
        let scene = Scene::parse("scene.toml", SCENE, &[]).unwrap();
        let found = check(&arguments, &scene, &[Format::Npy], allowed);
        found.err().map(|failure| failure.to_string())
    }

    /// 10 bins of 1000 pixels of 8 bytes are 80 kB: photons, radiance and error, and for `--counts` what
    /// is drawn and twice its file; three maps for solid angles have 8 kB each.
    #[test]
    fn memory_is_that_of_all_cubes() {
        assert_eq!(failure(&[], 264_000), None);
        assert_eq!(failure(&["--counts", "a.npy"], 504_000), None);
        let expected = "counting 25 x 40 pixels in 10 channels would take 257.8 KiB of memory: at most \
                        257.8 KiB are allowed";
        assert_eq!(failure(&[], 263_999).unwrap(), expected);
        assert!(failure(&["--counts", "a.npy"], 503_999).unwrap().contains("492.2 KiB"));
        assert_eq!(failure(&["-q"], 0), None);
        assert!(failure(&["-q", "--report", "r.json"], 263_999).is_some());
        assert_eq!(failure(&["--expected-counts", "a.npy"], 424_000), None);
        assert!(failure(&["--expected-counts", "a.npy"], 423_999).is_some());
    }
}
