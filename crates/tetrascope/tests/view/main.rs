//! The viewer: who may ask, what is drawn, and its page in a browser.

mod access;
mod browser;
mod devtools;
mod hands;
mod page;
mod program;
mod saved;
mod session;
