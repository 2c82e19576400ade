//! Scene files: what glows, which camera looks at it, how many pixels, by which method.
//!
//! The format is TOML; the guide has all keys. Options of the command line are scenes of one line
//! that are merged into the file, so every value is checked in one place and every error names the
//! place that the value came from.

mod camera;
mod document;
mod emission;
mod error;
mod seed;
mod settings;
mod source;
mod table;

pub use camera::Camera;
pub use emission::SceneEmission;
pub use error::SceneError;
pub use settings::RenderSettings;

use document::Node;
use source::{Place, Source};
use std::path::Path;
use std::sync::Arc;
use table::Table;

/// A value that replaces one of the scene file: an option of the command line.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Override {
    /// The key with its path, such as `render.method`.
    pub key: String,
    /// The value as TOML writes it; anything that is not TOML is taken as a string.
    pub value: String,
    /// The option that it comes from, such as `--method`, for messages.
    pub option: String,
}

/// A scene, read and checked.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Scene {
    /// The name of the file.
    pub name: String,
    /// The text of the file, as it is.
    pub text: String,
    /// What the command line changed, as `key = value`.
    pub overrides: Vec<String>,
    /// What glows.
    pub emission: SceneEmission,
    /// The camera.
    pub camera: Camera,
    /// The length unit, if the scene or its model has one.
    pub length_unit: Option<String>,
    /// Rows of the image.
    pub height: usize,
    /// Columns of the image.
    pub width: usize,
    /// How it is rendered.
    pub render: RenderSettings,
}

impl Scene {
    /// Reads the scene file at `path`, with values replaced by `overrides`, the later ones last.
    ///
    /// # Errors
    ///
    /// [`SceneError`] names the file or the option, the line, the text and what was expected.
    pub fn open(path: &Path, overrides: &[Override]) -> Result<Self, SceneError> {
        let text =
            std::fs::read_to_string(path).map_err(|cause| SceneError::unreadable(path, &cause))?;
        Self::parse(&path.display().to_string(), &text, overrides)
    }

    /// Reads a scene from its text; `name` is what messages call it.
    ///
    /// ```
    /// use emitree_io::Scene;
    ///
    /// let text = r#"
    ///     emission.expression = "exp(-100 * (x - 0.5)^2)"
    ///     projection.type = "canonical"
    ///     image = { width = 32, height = 16 }
    /// "#;
    /// let scene = Scene::parse("example", text, &[])?;
    /// assert_eq!((scene.height, scene.width), (16, 32));
    /// assert_eq!(scene.render.method.name(), "vol");
    /// # Ok::<(), emitree_io::SceneError>(())
    /// ```
    ///
    /// # Errors
    ///
    /// As [`open`](Self::open).
    pub fn parse(name: &str, text: &str, overrides: &[Override]) -> Result<Self, SceneError> {
        let source = Arc::new(Source { name: name.to_owned(), text: text.to_owned() });
        let mut root = Node::parse(&source)?;
        for change in overrides {
            root.merge(change.parse()?);
        }
        let whole = root.place.clone();
        let start = Place { span: 0..0, ..whole };
        let mut table = Table::new(root)?;
        let Some(emission) = table.table("emission")? else {
            return Err(SceneError::at(&start, "the scene has no `[emission]`")
                .label("expected a table `[emission]` with `expression` or `model`"));
        };
        let emission = emission::read(emission)?;
        let (camera, length_unit) = camera::read(table.table("projection")?, &start)?;
        if let Some(occulter) = table.take("occulter") {
            return Err(SceneError::at(&occulter.place, "`[[occulter]]` is not available yet")
                .label("expected a scene without opaque bodies in this version"));
        }
        if let Some(energy) = table.take("energy") {
            return Err(SceneError::at(&energy.place, "`[energy]` is not available yet")
                .label("expected a scene without an energy axis in this version"));
        }
        let (height, width) = image_shape(table.table("image")?, &start)?;
        let seeds = table.tables("seed", "tables `[[seed]]`, each with `position` and `radius`")?;
        let seeds = seed::read(seeds)?;
        let render = table.table("render")?.unwrap_or_else(|| Table::absent("render", &start));
        let render = settings::read(render, seeds)?;
        table.finish()?;

        let length_unit = match (emission.length_unit(), length_unit) {
            (Some(needed), Some((given, place))) if needed != given => {
                return Err(SceneError::at(&place, format!("`length_unit` is \"{given}\""))
                    .label(format!("expected \"{needed}\", the length unit of the model")));
            }
            (needed, given) => given.map(|(unit, _)| unit).or(needed.map(str::to_owned)),
        };
        let overrides = overrides.iter().map(|o| format!("{} = {}", o.key, o.value)).collect();
        Ok(Self {
            name: name.to_owned(),
            text: text.to_owned(),
            overrides,
            emission,
            camera,
            length_unit,
            height,
            width,
            render,
        })
    }
}

fn image_shape(table: Option<Table>, start: &Place) -> Result<(usize, usize), SceneError> {
    const EXPECTED: &str = "a number of pixels, 1 to 2^24";
    let Some(mut table) = table else {
        return Err(SceneError::at(start, "the scene has no `[image]`")
            .label("expected a table `[image]` with `width` and `height`"));
    };
    let mut pixels = |key| {
        let node = table.require(key, EXPECTED)?;
        match node.count(EXPECTED)? {
            pixels @ 1..=0x100_0000 => Ok(pixels),
            other => Err(node.refuse(&other.to_string(), EXPECTED)),
        }
    };
    let (width, height) = (pixels("width")?, pixels("height")?);
    table.finish()?;
    Ok((height, width))
}

/// What the names of sources that are options of the command line start with.
const OPTION_PREFIX: &str = "option --";

fn is_option(source: &Source) -> bool {
    source.name.starts_with(OPTION_PREFIX)
}

impl Override {
    /// The scene of one line that this is.
    fn parse(&self) -> Result<Node, SceneError> {
        let source = |text| {
            let name = format!("{OPTION_PREFIX}{}", self.option.trim_start_matches('-'));
            Arc::new(Source { name, text })
        };
        let as_written = source(format!("{} = {}", self.key, self.value));
        let as_text =
            || source(format!("{} = {}", self.key, toml::Value::from(self.value.as_str())));
        if self.value.contains('\n') {
            return Node::parse(&as_text());
        }
        // Words need no quotes on a command line; a number, a list or a table that is wrong is wrong.
        let is_number = |value: &str| value.chars().all(|c| "0123456789+-_.eE".contains(c));
        let is_word = |value: &str| !value.starts_with(['"', '\'', '[', '{']) && !is_number(value);
        Node::parse(&as_written).or_else(|error| {
            if !is_word(&self.value) {
                return Err(error);
            }
            // If even a string can't be put there, it is the key that is wrong.
            Node::parse(&as_text()).map_err(|_| error)
        })
    }
}

#[cfg(test)]
mod tests;
