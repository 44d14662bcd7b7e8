//! Tests that need a graphics device, in one program so that they share it. Without a device they fail and say how
//! to get a software one.

mod analytic;
mod axis;
mod caching;
mod claims;
mod common;
mod creases;
mod culling;
mod custom;
mod deforming;
mod degenerate;
mod device_loss;
mod encoders;
mod exact;
mod filters;
mod hard_cases;
mod limits;
mod mapping;
mod masked;
mod memory;
mod misuse;
mod numbers;
mod rasteriser;
mod seam;
mod twin;
mod walk;
mod watertight;
