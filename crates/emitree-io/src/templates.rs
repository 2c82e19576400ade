//! Scenes to start from: the files of the folder `templates`, each with comments for its first reader.

/// A scene to start from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct SceneTemplate {
    /// The name by which it is chosen.
    pub name: &'static str,
    /// The text of the scene file.
    pub text: &'static str,
}

/// A template, by the name of its file.
macro_rules! template {
    ($name:literal) => {
        SceneTemplate { name: $name, text: include_str!(concat!("../templates/", $name, ".toml")) }
    };
}

static TEMPLATES: [SceneTemplate; 5] = [
    template!("first"),
    template!("planet"),
    template!("jump"),
    template!("spectrum"),
    template!("sky"),
];

/// What the texts call the file that they become.
const NAME: &str = "NAME";

/// All templates, the simplest one first.
///
/// ```
/// use emitree_io::{Scene, scene_templates};
///
/// for template in scene_templates() {
///     println!("{}: {}", template.name, template.summary());
///     Scene::parse(template.name, &template.text_for("scene.toml"), &[])?;
/// }
/// # Ok::<(), emitree_io::SceneError>(())
/// ```
pub fn scene_templates() -> &'static [SceneTemplate] {
    &TEMPLATES
}

impl SceneTemplate {
    /// What the scene is of: the first line of its text.
    pub fn summary(&self) -> &'static str {
        let first = self.text.lines().next().unwrap_or_default();
        first.trim_start_matches('#').trim()
    }

    /// The text for a file of this name, which its comments tell how to render.
    pub fn text_for(&self, file: &str) -> String {
        let stem = file.strip_suffix(".toml").unwrap_or(file);
        let stem = stem.rsplit(['/', '\\']).next().unwrap_or(stem);
        let is_output = |line: &str| line.contains(".fits,");
        let line = |line: &'static str| match line.strip_prefix('#') {
            Some(_) if is_output(line) => {
                let line = line.replacen(NAME, file, 1).replace(NAME, stem);
                line.replace(", with other endings", "")
            }
            Some(_) => line.replace(NAME, file),
            None => line.to_owned(),
        };
        self.text.lines().map(line).collect::<Vec<_>>().join("\n") + "\n"
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Scene;

    #[test]
    fn each_template_is_a_scene_with_a_summary_and_its_own_name() {
        for template in scene_templates() {
            let summary = template.summary();
            assert!(summary.ends_with('.') && summary.contains(": "), "{summary}");
            let text = template.text_for("my/scene.toml");
            assert!(!text.contains(NAME), "{text}");
            assert!(text.contains("emitree check my/scene.toml "), "{text}");
            let scene = Scene::parse("scene.toml", &text, &[]).unwrap();
            assert!(scene.render.ignored.is_empty());
            assert!(text.lines().filter(|line| line.starts_with('#')).count() > 5);
        }
    }

    #[test]
    fn the_files_of_a_rendering_are_named_as_they_will_be() {
        let text = scene_templates()[0].text_for("my/ball.toml");
        let line =
            "#   emitree render my/ball.toml     renders it to ball.fits, ball.npy and ball.png\n";
        assert!(text.contains(line), "{text}");
    }
}
