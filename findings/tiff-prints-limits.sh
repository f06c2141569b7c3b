#!/usr/bin/env bash
# The tiff crate prints to stderr, beside its error, where a text is longer than a limit.
#
# Guess:    a decoder in a library says what is wrong by the error that it returns, and nothing else.
# Behavior: for a tag of text that is longer than `decoding_buffer_size`, a line with a path of the build and the error is
#           printed to stderr, as by `dbg!`. Programs that keep stderr for their own words, or for JSON, read such tags
#           another way, or with limits beyond any text.
# Seen:     tiff 0.11.3 with rustc 1.95, TIFF of 2×2 pixels with a description of 99 letters, a limit of 64 bytes.
# Output:   the error: decoder limits exceeded
#           stderr, without the path: TiffError::LimitsExceeded = LimitsExceeded
set -euo pipefail

folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
mkdir "$folder/src"
cat >"$folder/Cargo.toml" <<'TOML'
[package]
name = "limits"
version = "0.0.0"
edition = "2024"

[dependencies]
tiff = "=0.11.3"
TOML
cat >"$folder/src/main.rs" <<'RUST'
use std::io::Cursor;

use tiff::decoder::{Decoder, Limits};
use tiff::encoder::{TiffEncoder, colortype};
use tiff::tags::Tag;

fn main() {
    let mut file = Cursor::new(Vec::new());
    let mut encoder = TiffEncoder::new(&mut file).expect("a file");
    let mut image = encoder.new_image::<colortype::Gray8>(2, 2).expect("an image");
    let text = "a".repeat(99);
    image.encoder().write_tag(Tag::ImageDescription, text.as_str()).expect("a tag");
    image.write_data(&[1, 2, 3, 4]).expect("pixels");
    file.set_position(0);
    let mut limits = Limits::default();
    limits.decoding_buffer_size = 64;
    let mut decoder = Decoder::new(file).expect("a valid file").with_limits(limits);
    match decoder.get_tag_ascii_string(Tag::ImageDescription) {
        Ok(text) => println!("read: {} letters", text.len()),
        Err(error) => println!("the error: {error}"),
    }
}
RUST
cd "$folder"
cargo build --quiet
target=${CARGO_TARGET_DIR:-target}
out=$("$target/debug/limits" 2>errors)
printed=$(sed 's/^\[[^]]*\] //' errors)
echo "$out"
echo "stderr, without the path: $printed"
[ "$out" = "the error: decoder limits exceeded" ] && [ "$printed" = "TiffError::LimitsExceeded = LimitsExceeded" ]
