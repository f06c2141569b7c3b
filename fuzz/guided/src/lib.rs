//! libFuzzer's entry for a target; see `tetrascope_fuzz::targets`.

use std::cell::OnceCell;

use tetrascope_fuzz::targets::{self, Bench, Target};

pub use libfuzzer_sys::fuzz_target;
pub use tetrascope_fuzz::PeakAlloc;

thread_local! {
    static BENCH: OnceCell<(&'static Target, Bench)> = const { OnceCell::new() };
}

/// Uses `bytes` as the target called `name` does.
///
/// # Panics
/// With what is wrong with the answer.
pub fn run(name: &str, bytes: &[u8]) {
    BENCH.with(|bench| {
        let (target, bench) = bench.get_or_init(|| {
            let target = targets::find(name).expect("this package lists what there is");
            (target, Bench::new().expect("a folder can be made"))
        });
        if let Err(wrong) = bench.run(target, bytes) {
            panic!("{wrong}");
        }
    });
}

/// The program for a target.
#[macro_export]
macro_rules! target {
    ($name:literal) => {
        #[global_allocator]
        static MEMORY: $crate::PeakAlloc = $crate::PeakAlloc;

        $crate::fuzz_target!(|bytes: &[u8]| $crate::run($name, bytes));
    };
}
