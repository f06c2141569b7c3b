//! See `cli.rs`.

use std::process::ExitCode;

fn main() -> ExitCode {
    tetrascope_fuzz::main()
}
