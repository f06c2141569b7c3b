#!/usr/bin/env bash
# hayro-jpeg2000 reads the signed numbers of a JPEG 2000 image as unsigned ones.
#
# Guess:    a part whose numbers are signed, as SIZ says, is decoded to these numbers; CT images in DICOM are such.
# Behavior: half of the range is added to every number, signed or not, and nothing tells that they were signed.
#           Bit 7 of the part's byte 42 + 3 i in the code stream says so (ISO/IEC 15444-1, A.5.1): subtract what was added.
# Seen:     hayro-jpeg2000 0.5.0 with rustc 1.95; the image written by imagecodecs 2026.3.6 (OpenJPEG) from numpy 2.4.6.
# Output:   OpenJPEG: -1000 to 1000
#           hayro-jpeg2000: 31768 to 33768
#
# Fails if the numbers are those that were written.
set -euo pipefail

folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet imagecodecs==2026.3.6 numpy==2.4.6
"$folder/venv/bin/python" - "$folder" <<'PYTHON'
import sys

import imagecodecs
import numpy as np

image = np.linspace(-1000, 1000, 64 * 64).round().astype(np.int16).reshape(64, 64)
packed = imagecodecs.jpeg2k_encode(image, reversible=True, codecformat="j2k")
back = imagecodecs.jpeg2k_decode(packed)
assert (back == image).all()
print(f"OpenJPEG: {back.min()} to {back.max()}")
open(f"{sys.argv[1]}/signed.j2k", "wb").write(packed)
PYTHON
mkdir "$folder/src"
cat >"$folder/Cargo.toml" <<'TOML'
[package]
name = "signed"
version = "0.0.0"
edition = "2024"

[dependencies]
hayro-jpeg2000 = { version = "=0.5.0", default-features = false, features = ["std"] }
TOML
cat >"$folder/src/main.rs" <<'RUST'
use hayro_jpeg2000::{DecodeSettings, DecoderContext, Image};

fn main() {
    let path = std::env::args().nth(1).expect("a file");
    let bytes = std::fs::read(path).expect("it is there");
    let image = Image::new(&bytes, &DecodeSettings::default()).expect("it is read");
    let mut context = DecoderContext::default();
    let decoded = image.decode(&mut context).expect("it is decoded");
    let samples = decoded.components()[0].samples();
    let least = samples.iter().copied().fold(f32::INFINITY, f32::min);
    let greatest = samples.iter().copied().fold(f32::NEG_INFINITY, f32::max);
    println!("hayro-jpeg2000: {least} to {greatest}");
    assert!(least != -1000.0 && greatest - least == 2000.0, "signed numbers are read");
}
RUST
cargo run --quiet --manifest-path "$folder/Cargo.toml" -- "$folder/signed.j2k"
