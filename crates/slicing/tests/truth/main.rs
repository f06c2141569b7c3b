//! Pictures of slices against integrals that are known.

mod analytic;
mod bricks;
mod cells;
mod convergence;
mod coverage;
mod device;
mod features;
mod frames;
mod loops;
mod rays;
mod real_data;
mod support;
mod surfaces;
