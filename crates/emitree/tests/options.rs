//! Options without effect are errors that name them.

use emitree::error::OptionError;
use emitree::los::LosOptions;
use emitree::progress::Frame;
use emitree::tree::BuildOptions;
use emitree::{
    Canonical, FromFn, Image, Projection, RenderError, RenderOptions, Session, VolOptions, render,
};
use std::ops::ControlFlow;

fn refused(options: &RenderOptions<'_>) -> String {
    let dome = FromFn(|[x, y, z]: [f64; 3], _: [f64; 3]| 1.0 + x * y * z);
    let rendering = render(&dome, &Canonical, [4, 4], options);
    rendering.map_or_else(|error| error.to_string(), |_| "rendered".to_owned())
}

#[test]
fn intermediate_images_are_of_vol() {
    let frame = |_: &Frame<'_>| ControlFlow::Continue(());
    let los = RenderOptions::new(LosOptions::default()).with_frame(&frame);
    let text = "`frame` is given, and method `los` has no intermediate images: expected none, or \
                method `vol`";
    assert_eq!(refused(&los), text);
    let paper = RenderOptions::new(BuildOptions::default()).with_frame(&frame);
    assert_eq!(refused(&paper), text.replace("los", "paper"));
    let vol = RenderOptions::new(VolOptions::default()).with_frame(&frame);
    assert_eq!(refused(&vol), "rendered");
}

#[test]
fn energies_of_lines_are_for_cubes() {
    let lines = RenderOptions::new(VolOptions::default().with_line_energies([1.0]));
    assert_eq!(
        refused(&lines),
        "`line_energies` are given without an energy axis: expected none, or an energy axis"
    );
}

#[test]
fn sessions_call_nothing() {
    let progress = |_: u64| ControlFlow::Continue(());
    let options = RenderOptions::new(VolOptions::default()).with_progress(&progress);
    let camera: &dyn Projection = &Canonical;
    let expected = OptionError::CallbackOfSession("progress");
    let refused = Session::<Image>::new(camera, [4, 4], &options).err();
    assert_eq!(refused, Some(RenderError::Option(expected)));
    assert_eq!(expected.name(), "progress");
    assert_eq!(
        expected.to_string(),
        "`progress` is given, and a session calls no callbacks: expected none"
    );
}
