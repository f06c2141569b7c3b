//! Pictures: ray casting against the ground truth, and its two forms against each other.

mod common;

mod layers;
mod long;
mod look;
mod models;
mod parts;
mod ping_pong;
mod real_data;
mod reference;
mod tables;
