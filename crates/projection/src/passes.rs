//! The passes of a frame, one per file.

pub(crate) mod cell;
pub(crate) mod faces;
pub(crate) mod lists;
pub(crate) mod order;
pub(crate) mod surface;
pub(crate) mod transform;
