//! Every crate in the dependency tree, on all platforms and with all features, has a permissive licence.
//!
//! Development dependencies are held to the same list: it is the simpler rule, and they all meet it.

use serde_json::Value;
use std::{iter::Peekable, process::Command, str::SplitWhitespace};

/// SPDX identifiers that ask for no more than attribution. Weak copyleft (MPL-2.0, LGPL) is left out on purpose:
/// a dependency that offers nothing else deserves a decision, not a default.
const ALLOWED: [&str; 10] =
    ["0BSD", "Apache-2.0", "BSD-2-Clause", "BSD-3-Clause", "BSL-1.0", "CC0-1.0", "ISC", "MIT", "Unicode-3.0", "Zlib"];

#[test]
fn every_dependency_has_an_allowed_licence() {
    let packages = packages();
    assert!(packages.len() > 1, "cargo metadata lists no dependencies, so nothing was checked");

    let refused: Vec<String> = packages.iter().filter_map(refusal).collect();
    assert!(
        refused.is_empty(),
        "{} of {} crates have no licence on the list in {}:\n  {}",
        refused.len(),
        packages.len(),
        file!(),
        refused.join("\n  ")
    );
}

#[test]
fn expressions_follow_spdx_precedence() {
    for allowed in [
        "MIT",
        "GPL-3.0-only OR MIT",
        "Unlicense/MIT",
        "(MIT OR GPL-3.0-only) AND Unicode-3.0",
        "GPL-3.0-only AND LGPL-3.0-only OR MIT",
        "MIT OR GPL-3.0-only AND LGPL-3.0-only",
        "Apache-2.0 WITH LLVM-exception",
    ] {
        assert!(is_allowed(allowed), "{allowed:?} was refused");
    }
    for refused in [
        "GPL-3.0-only",
        "MIT AND GPL-3.0-only",
        "(MIT OR Zlib) AND GPL-3.0-only",
        "GPL-2.0-only WITH Classpath-exception-2.0",
    ] {
        assert!(!is_allowed(refused), "{refused:?} was allowed");
    }
}

#[test]
fn malformed_expressions_are_refused() {
    for malformed in ["", "MIT OR", "MIT Zlib", "(MIT", "MIT)", "MIT WITH", "AND MIT", "mit"] {
        assert!(!is_allowed(malformed), "{malformed:?} was allowed");
    }
}

/// The packages that the lock file names. Cargo downloads those it lacks, such as other platforms' crates.
fn packages() -> Vec<Value> {
    let output = Command::new(env!("CARGO"))
        .args(["metadata", "--format-version", "1", "--all-features", "--locked", "--manifest-path"])
        .arg(concat!(env!("CARGO_MANIFEST_DIR"), "/Cargo.toml"))
        .output()
        .expect("cargo can be started");
    assert!(output.status.success(), "cargo metadata failed:\n{}", String::from_utf8_lossy(&output.stderr));

    let mut metadata: Value = serde_json::from_slice(&output.stdout).expect("cargo metadata prints JSON");
    match metadata["packages"].take() {
        Value::Array(packages) => packages,
        other => panic!("cargo metadata's \"packages\" is not a list but {other}"),
    }
}

/// Says which package is refused and why; `None` if its licence is allowed.
fn refusal(package: &Value) -> Option<String> {
    let (name, version) = (&package["name"], &package["version"]);
    match package["license"].as_str() {
        Some(expression) if is_allowed(expression) => None,
        Some(expression) => Some(format!("{name} {version}: {expression}")),
        None => Some(format!("{name} {version}: no SPDX expression")),
    }
}

type Tokens<'a> = Peekable<SplitWhitespace<'a>>;

/// Whether a user may choose allowed licences only. Takes the old "MIT/Apache-2.0" to mean OR.
fn is_allowed(expression: &str) -> bool {
    let spaced = expression.replace('/', " OR ").replace('(', " ( ").replace(')', " ) ");
    let mut tokens = spaced.split_whitespace().peekable();
    any_of(&mut tokens) == Some(true) && tokens.next().is_none()
}

/// Alternatives joined by OR; `None` if malformed. Reads on after the first allowed one, to find where it ends.
fn any_of(tokens: &mut Tokens) -> Option<bool> {
    let mut allowed = all_of(tokens)?;
    while tokens.next_if_eq(&"OR").is_some() {
        allowed |= all_of(tokens)?;
    }
    Some(allowed)
}

/// Terms joined by AND, which binds tighter than OR; `None` if malformed.
fn all_of(tokens: &mut Tokens) -> Option<bool> {
    let mut allowed = term(tokens)?;
    while tokens.next_if_eq(&"AND").is_some() {
        allowed &= term(tokens)?;
    }
    Some(allowed)
}

/// A group in brackets, or a licence with or without an exception. An exception only adds permissions, so the
/// licence decides.
fn term(tokens: &mut Tokens) -> Option<bool> {
    match tokens.next()? {
        "(" => {
            let allowed = any_of(tokens)?;
            (tokens.next()? == ")").then_some(allowed)
        }
        licence => {
            if tokens.next_if_eq(&"WITH").is_some() {
                tokens.next()?;
            }
            Some(ALLOWED.contains(&licence))
        }
    }
}
