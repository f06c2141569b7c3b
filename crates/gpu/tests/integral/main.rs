//! The integral over a segment on the device, in closed form and from tables.

mod optics;
mod preintegration;
mod support;
