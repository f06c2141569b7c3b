#!/usr/bin/env bash
# obvhs builds a BVH over boxes in a row in as many passes as half of the boxes.
#
# Guess:    PLOC joins a fixed share of all boxes in each pass, so a row of n boxes takes some log n passes.
# Behavior: where boxes in a row are alike, each of them has the same cost with both neighbors and all choose the one
#           before, so that one pair is joined in a pass. Boxes that are larger by up to 1/256, each by another share,
#           need no more passes than others: a way out.
# Seen:     obvhs 0.4.0 with rustc 1.95, build_bvh2 with BvhBuildParams::medium_build().
# Output:   512 boxes alike: a depth of at most 265
#           1024 boxes alike: a depth of at most 522
#           1024 boxes, no two alike: a depth of at most 96
#
# `max_depth` is what the builder says of its result: it counts its passes. Fails if a row of equal boxes is no deeper than
# one of boxes that differ.
set -euo pipefail

folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
mkdir "$folder/src"
cat >"$folder/Cargo.toml" <<'TOML'
[package]
name = "row"
version = "0.0.0"
edition = "2024"

[dependencies]
obvhs = "=0.4.0"
glam = "*"
TOML
cat >"$folder/src/main.rs" <<'RUST'
use glam::Vec3A;
use obvhs::BvhBuildParams;
use obvhs::aabb::Aabb;
use obvhs::bvh2::builder::build_bvh2;

struct Cell(Aabb);

impl obvhs::Boundable for Cell {
    fn aabb(&self) -> Aabb {
        self.0
    }
}

/// Unit boxes side by side, each larger by a share of `loose`.
fn depth(count: usize, loose: f32) -> usize {
    let cell = |i: usize| {
        let min = Vec3A::new(i as f32, 0.0, 0.0);
        let by = loose * (i as f32 * 0.618_034).fract();
        Cell(Aabb::new(min - by, min + Vec3A::ONE + by))
    };
    let cells: Vec<Cell> = (0..count).map(cell).collect();
    let mut time = Default::default();
    build_bvh2(&cells, BvhBuildParams::medium_build(), &mut time).max_depth
}

fn main() {
    let [half, whole, loose] = [depth(512, 0.0), depth(1024, 0.0), depth(1024, 1.0 / 256.0)];
    println!("512 boxes alike: a depth of at most {half}");
    println!("1024 boxes alike: a depth of at most {whole}");
    println!("1024 boxes, no two alike: a depth of at most {loose}");
    assert!(whole > 3 * half / 2 && whole > 3 * loose, "passes no longer grow with boxes");
}
RUST
cargo run --quiet --release --manifest-path "$folder/Cargo.toml"
