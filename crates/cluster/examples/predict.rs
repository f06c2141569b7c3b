//! Predicts what 1 to 1 024 ranks take for a picture, from what was measured of a few: `cargo run -p tetrascope-cluster --example predict`.
//!
//! The numbers of the machine were measured as RESULTS.md says; those of the network are assumptions.

use tetrascope_cluster::Exchange;
use tetrascope_cluster::model::{Machine, Work};

fn main() {
    let machine = Machine::MEASURED;
    for is_weak in [false, true] {
        let name = match is_weak {
            true => "weak scaling, 1 million cells at each rank",
            false => "strong scaling, 8 million cells",
        };
        println!("{name}, 1024x1024 pixels, emission and absorption");
        println!(
            "ranks  exchange      cast s  exchange s  gather s  composite %  bytes sent per rank  per pixel"
        );
        for ranks in [1, 2, 4, 8, 16, 32, 64, 128, 256, 512, 1024] {
            let work = Work {
                cells: if is_weak { 1e6 * ranks as f64 } else { 8e6 },
                ..Work::SPHERE
            };
            let mut ways = vec![("direct", Exchange::direct(ranks))];
            if ranks > 8 {
                let radix = Exchange::radix(ranks, 8).expect("2 or more");
                ways.push(("radix 8", radix));
            }
            for (way, exchange) in ways {
                let found = work.predict(&machine, &exchange);
                println!(
                    "{ranks:5}  {way:8}  {:10.4}  {:10.4}  {:8.4}  {:11.1}  {:19.0}  {:9.3}",
                    found.cast,
                    found.exchange + found.agree,
                    found.gather,
                    100.0 * found.composite() / found.seconds(),
                    found.bytes,
                    found.bytes / (1024.0 * 1024.0),
                );
            }
        }
    }
}
