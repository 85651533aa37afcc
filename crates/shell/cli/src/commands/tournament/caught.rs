//! Panics that end what panicked, and nothing else.

use std::cell::{Cell, RefCell};
use std::panic::{self, AssertUnwindSafe, PanicHookInfo};
use std::sync::Once;

thread_local! {
    /// How many calls of [`caught`] this thread is in.
    static DEPTH: Cell<u32> = const { Cell::new(0) };
    /// What the last panic of this thread said.
    static SAID: RefCell<String> = const { RefCell::new(String::new()) };
}

/// Returns what a function returns, or, if it panics, what the panic says and where, as in `no zone
/// (src/bot.rs:12:5)`. Nothing of it goes to standard error.
///
/// What the function has changed may be half done when it panics; the caller drops it, or never looks at it again.
///
/// # Errors
/// The words of the panic.
pub(super) fn caught<T>(act: impl FnOnce() -> T) -> Result<T, String> {
    listen();
    DEPTH.set(DEPTH.get() + 1);
    let outcome = panic::catch_unwind(AssertUnwindSafe(act));
    DEPTH.set(DEPTH.get() - 1);
    outcome.map_err(|_| SAID.take())
}

/// Sees to it that panics within [`caught`] are kept, and all others said as before.
fn listen() {
    static LISTENS: Once = Once::new();
    LISTENS.call_once(|| {
        let before = panic::take_hook();
        panic::set_hook(Box::new(
            move |panic| {
                if DEPTH.get() == 0 { before(panic) } else { SAID.set(words(panic)) }
            },
        ));
    });
}

fn words(panic: &PanicHookInfo<'_>) -> String {
    let message = panic.payload_as_str().unwrap_or("a panic without words");
    match panic.location() {
        Some(place) => format!("{message} ({place})"),
        None => message.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_panic_is_told_with_its_place_and_an_inner_one_ends_the_inner_alone() {
        assert_eq!(caught(|| 7), Ok(7));
        let outer = caught(|| {
            let inner = caught(|| panic!("inner {}", 1));
            assert!(inner.is_err_and(|said| said.starts_with("inner 1 (") && said.contains("caught.rs:")));
            8
        });
        assert_eq!(outer, Ok(8));
        assert!(
            caught(|| caught(|| ()).map(|()| panic!("outer"))).is_err_and(|said| said.starts_with("outer ("))
        );
    }
}
