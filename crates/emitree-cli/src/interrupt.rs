//! Ctrl-C and SIGTERM: the rendering ends after the current call of g, and leaves no file behind.

use std::sync::OnceLock;
use std::sync::atomic::{AtomicBool, Ordering};

static INTERRUPTED: AtomicBool = AtomicBool::new(false);
static HANDLER: OnceLock<()> = OnceLock::new();

/// From now on Ctrl-C (or a request to terminate) is only noted; a second one ends the program at once.
pub(crate) fn catch() {
    HANDLER.get_or_init(|| {
        // Without a handler Ctrl-C just ends the program: temporary files may stay behind.
        let _ = ctrlc::set_handler(|| {
            if INTERRUPTED.swap(true, Ordering::Relaxed) {
                std::process::exit(130);
            }
        });
    });
}

/// Whether Ctrl-C was pressed since [`catch`].
pub(crate) fn requested() -> bool {
    INTERRUPTED.load(Ordering::Relaxed)
}
