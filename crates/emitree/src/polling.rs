//! Futures without an executor: a method is advanced by whoever has the rates that it waits for.

use core::future::Future;
use core::pin::Pin;
use core::task::{Context, Poll, Waker};

/// Runs a method up to its next request or its end.
pub(crate) fn advance<T>(method: Pin<&mut (impl Future<Output = T> + ?Sized)>) -> Poll<T> {
    method.poll(&mut Context::from_waker(Waker::noop()))
}

/// The result of a function that never has to wait.
pub(crate) fn at_once<T>(function: impl Future<Output = T>) -> T {
    let mut function = core::pin::pin!(function);
    loop {
        if let Poll::Ready(result) = advance(function.as_mut()) {
            return result;
        }
    }
}
