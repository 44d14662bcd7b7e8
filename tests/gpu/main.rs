//! Tests that need a graphics device, in one program so that they share it. Without a device they fail and say how
//! to get a software one.

mod analytic;
mod axis;
mod common;
mod degenerate;
mod filters;
mod hard_cases;
mod mapping;
mod misuse;
mod routing;
mod seam;
mod watertight;
