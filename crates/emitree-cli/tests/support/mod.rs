//! A temporary folder with a scene, and the binary running in it.
#![allow(clippy::unwrap_used, reason = "what fails here fails the test")]

use std::path::PathBuf;
use std::process::{Child, Command, Stdio};

/// Eq. (8) of the paper, one thing a line.
pub(crate) const HOLMSTROM: &str = r#"
[emission]
expression = "(sin(5*x) * sin(7*y) * sin(11*z) / 10)^2 + exp(-alpha*((x - sqrt(2)/3)^2/sqrt(2) + (y - sqrt(7)/5)^2*sqrt(2) + (z - sqrt(6)/5)^2*sqrt(3)))"
constants = { alpha = 100.0 }

[projection]
type = "canonical"


[image]
width = 64
height = 64

[render]
method = "paper"
threshold = 0.01
"#;

/// A scene of the folder `examples`.
pub(crate) fn example(name: &str) -> String {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../examples");
    std::fs::read_to_string(std::path::Path::new(folder).join(name)).unwrap()
}

pub(crate) struct Folder(tempfile::TempDir);

/// What a run of the binary left.
pub(crate) struct Run {
    pub(crate) code: Option<i32>,
    pub(crate) stdout: String,
    pub(crate) stderr: String,
}

impl Folder {
    pub(crate) fn with_scene(scene: &str) -> Self {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("scene.toml"), scene).unwrap();
        Self(folder)
    }

    fn command(&self, arguments: &str) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_emitree"));
        command.args(arguments.split_whitespace()).current_dir(&self.0);
        command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
        command
    }

    /// Runs the binary with these arguments, none of which has a space.
    pub(crate) fn emitree(&self, arguments: &str) -> Run {
        Run::of(&mut self.command(arguments))
    }

    /// Runs the binary as [`emitree`](Self::emitree) does, in a shell that can't write files of more
    /// than a few KiB.
    pub(crate) fn emitree_with_small_files(&self, arguments: &str) -> Run {
        let limited = r#"trap "" XFSZ; ulimit -f 8; exec "$0" "$@""#;
        let mut command = Command::new("sh");
        command.args(["-c", limited, env!("CARGO_BIN_EXE_emitree")]);
        command.args(arguments.split_whitespace()).current_dir(&self.0);
        Run::of(&mut command)
    }

    pub(crate) fn start(&self, arguments: &str) -> Child {
        self.command(arguments).spawn().unwrap()
    }

    pub(crate) fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    pub(crate) fn bytes(&self, name: &str) -> Vec<u8> {
        std::fs::read(self.path(name)).unwrap()
    }

    pub(crate) fn json(&self, name: &str) -> serde_json::Value {
        serde_json::from_slice(&self.bytes(name)).unwrap()
    }

    /// The names of all files, hidden ones too.
    pub(crate) fn names(&self) -> Vec<String> {
        let entries = std::fs::read_dir(&self.0).unwrap();
        let mut names: Vec<String> =
            entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    }

    /// The names of the files in one of its folders that end so.
    pub(crate) fn names_in(&self, folder: &str, ending: &str) -> Vec<String> {
        let entries = std::fs::read_dir(self.path(folder)).unwrap();
        let mut names: Vec<String> = entries
            .map(|entry| entry.unwrap().file_name().into_string().unwrap())
            .filter(|name| name.ends_with(ending))
            .collect();
        names.sort();
        names
    }

    pub(crate) fn holds(&self, expected: &[&str]) {
        assert_eq!(self.names(), expected);
    }
}

impl Run {
    fn of(command: &mut Command) -> Self {
        let output = command.output().unwrap();
        Self {
            code: output.status.code(),
            stdout: String::from_utf8(output.stdout).unwrap(),
            stderr: String::from_utf8(output.stderr).unwrap(),
        }
    }

    pub(crate) fn succeeds(&self) {
        self.fails_with(0);
    }

    pub(crate) fn fails_with(&self, code: i32) {
        assert_eq!(self.code, Some(code), "stdout:\n{}\nstderr:\n{}", self.stdout, self.stderr);
    }
}

/// The numbers of an NPY file.
pub(crate) fn pixels(npy: &[u8]) -> Vec<f64> {
    let header = usize::from(u16::from_le_bytes([npy[8], npy[9]]));
    npy[10 + header..].chunks_exact(8).map(|b| f64::from_le_bytes(b.try_into().unwrap())).collect()
}

/// Width, height and RGB bytes of a PNG file.
pub(crate) fn decode_png(bytes: &[u8]) -> (usize, usize, Vec<u8>) {
    let mut decoder = png::Decoder::new(std::io::Cursor::new(bytes));
    decoder.set_transformations(png::Transformations::EXPAND | png::Transformations::STRIP_16);
    let mut reader = decoder.read_info().unwrap();
    let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
    let info = reader.next_frame(&mut pixels).unwrap();
    let channels = info.color_type.samples();
    let rgb = pixels.chunks_exact(channels).flat_map(|p| p[..3].to_vec()).collect();
    (info.width as usize, info.height as usize, rgb)
}
