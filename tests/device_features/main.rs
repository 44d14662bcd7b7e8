//! What only some devices and backends can be asked. Each test says what it needs, and is ignored for that reason where
//! the device lacks it.

#[path = "../gpu/common.rs"]
#[expect(dead_code, reason = "shared with the tests that every device can be asked")]
mod common;
mod memory;
mod multiview;

use libtest_mimic::{Arguments, Completion, Trial};
use std::process::ExitCode;

fn main() -> ExitCode {
    let arguments = Arguments::from_args();
    libtest_mimic::run(&arguments, [memory::trials(), multiview::trials()].into_iter().flatten().collect()).exit_code()
}

/// A test that may find that the device lacks something; the error says what.
fn trial(name: &str, test: fn() -> Result<(), String>) -> Trial {
    Trial::ignorable_test(name, move || {
        Ok(match test() {
            Ok(()) => Completion::Completed,
            Err(lacking) => Completion::ignored_with(lacking),
        })
    })
}
