use tetrascope_core::FrameStats;
use tetrascope_core::colormap::srgb_to_linear;

use super::*;
use crate::whole_file::PREFIX;

fn frame(width: u32, height: u32, pixel: impl Fn(u32, u32) -> [f32; 4]) -> Frame {
    let pixels = (0..height)
        .flat_map(|row| (0..width).map(move |column| (column, row)))
        .map(|(column, row)| pixel(column, row))
        .collect();
    Frame::new((width, height), pixels, FrameStats::default())
}

fn sample() -> Frame {
    frame(5, 3, |column, row| {
        let a = row as f32 / 2.0;
        let t = column as f32 / 4.0;
        [a * t, a * (1.0 - t), a * 0.3, a]
    })
}

fn metadata() -> Vec<(String, String)> {
    [
        ("Software", "Tetrascope"),
        ("scene", "version = 1\n# σ, ≤ ½\n"),
    ]
    .map(|(key, text)| (key.to_owned(), text.to_owned()))
    .into()
}

fn decode_png(file: &[u8]) -> (Vec<[u8; 4]>, png::Info<'static>) {
    let mut reader = png::Decoder::new(Cursor::new(file))
        .read_info()
        .expect("a header");
    let mut bytes = vec![0; reader.output_buffer_size().expect("a small image")];
    reader.next_frame(&mut bytes).expect("texels");
    reader.finish().expect("the rest");
    let texels = bytes
        .chunks_exact(4)
        .map(|t| [t[0], t[1], t[2], t[3]])
        .collect();
    (texels, reader.info().clone())
}

#[test]
fn a_png_reads_back_as_straight_srgb() {
    let frame = sample();
    let (texels, info) = decode_png(&encode_png(&frame, &metadata()).expect("it is a frame"));
    assert_eq!((info.width, info.height), (5, 3));
    assert_eq!(info.color_type, png::ColorType::Rgba);
    assert!(info.srgb.is_some());
    for (texel, pixel) in texels.iter().zip(&frame.pixels) {
        let alpha = f64::from(texel[3]) / 255.0;
        // Half a level is the best that 8 bits can do.
        assert!((alpha - f64::from(pixel[3])).abs() <= 0.5 / 255.0 + 1e-9);
        for c in 0..3 {
            if pixel[3] == 0.0 {
                assert_eq!(texel[c], 0);
                continue;
            }
            let straight = f64::from(pixel[c]) / f64::from(pixel[3]);
            let expected = 255.0 * linear_to_srgb(straight);
            // The f32 division rounds by 6e-8, the steepest slope of sRGB is 13.
            assert!((f64::from(texel[c]) - expected).abs() <= 0.5 + 255.0 * 13.0 * 1e-7);
        }
    }
    assert_eq!(info.uncompressed_latin1_text[0].text, "Tetrascope");
    let scene = info.utf8_text[0].get_text().expect("it is UTF-8");
    assert_eq!(scene, "version = 1\n# σ, ≤ ½\n");
}

#[test]
fn levels_are_rounded_and_clamped() {
    // 0.5 in sRGB bytes is 187.516 → 188; truncation would give 187.
    assert_eq!(straight_srgb([0.5, 0.0, 1.0, 1.0]), [188, 0, 255, 255]);
    assert_eq!(straight_srgb([f32::NAN, -1.0, 0.0, 0.5]), [0, 0, 0, 128]);
    assert_eq!(straight_srgb([f32::INFINITY, 7.0, 0.0, 1.0])[3], 255);
    assert_eq!(straight_srgb([0.0; 4]), [0; 4]);
    // Premultiplied (0.25, 0.25, 0.25, 0.25) is white at a quarter.
    assert_eq!(straight_srgb([0.25; 4]), [255, 255, 255, 64]);
}

#[test]
fn light_without_opacity_looks_right_over_black() {
    let [r, g, b, a] = straight_srgb([0.5, 0.25, 0.0, 0.0]).map(|level| f64::from(level) / 255.0);
    // Half a level of alpha and of each color, whose slope in sRGB is at most 2.3 there.
    assert!((srgb_to_linear(r) * a - 0.5).abs() < 0.5 / 255.0 * 3.3);
    assert!((srgb_to_linear(g) * a - 0.25).abs() < 0.5 / 255.0 * 3.3);
    assert_eq!(b, 0.0);
}

#[test]
fn an_exr_reads_back_bit_for_bit() {
    use exr::prelude::*;
    let mut frame = sample();
    frame.pixels[3] = [1e-30, 65_504.5, -0.25, 1.0];
    let file = encode_exr(&frame, &metadata()).expect("it is a frame");
    let image = read()
        .no_deep_data()
        .largest_resolution_level()
        .rgba_channels(
            |size, _| vec![[0.0_f32; 4]; size.area()],
            |pixels: &mut Vec<[f32; 4]>, position, (r, g, b, a): (f32, f32, f32, f32)| {
                pixels[position.1 * 5 + position.0] = [r, g, b, a];
            },
        )
        .first_valid_layer()
        .all_attributes()
        .from_buffered(Cursor::new(file))
        .expect("it is an EXR file");
    assert_eq!(image.layer_data.channel_data.pixels, frame.pixels);
    assert_eq!(
        image.layer_data.channel_data.channels.0.sample_type,
        SampleType::F32
    );
    let attributes = &image.layer_data.attributes.other;
    let text = |key: &str| match attributes.get(&Text::from(key)) {
        Some(AttributeValue::Text(text)) => {
            String::from_utf8(text.as_slice().to_vec()).expect("UTF-8")
        }
        other => panic!("{key} is {other:?}"),
    };
    assert_eq!(text("tetrascope.Software"), "Tetrascope");
    assert_eq!(text("tetrascope.scene"), "version = 1\n# σ, ≤ ½\n");
}

#[test]
fn an_npy_has_a_padded_header_and_the_floats() {
    let frame = sample();
    let file = encode_npy(&frame).expect("it is a frame");
    assert_eq!(&file[..8], b"\x93NUMPY\x01\x00");
    let length = usize::from(u16::from_le_bytes([file[8], file[9]]));
    assert_eq!((10 + length) % 64, 0);
    let header = std::str::from_utf8(&file[10..10 + length]).expect("ASCII");
    assert!(header.starts_with("{'descr': '<f4', 'fortran_order': False, 'shape': (3, 5, 4), }"));
    assert!(header.ends_with('\n'));
    let values: Vec<f32> = file[10 + length..]
        .chunks_exact(4)
        .map(|b| f32::from_le_bytes([b[0], b[1], b[2], b[3]]))
        .collect();
    assert_eq!(values, frame.pixels.as_flattened());
}

#[test]
fn write_image_goes_by_the_extension() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    for name in ["a.png", "a.exr", "a.NPY"] {
        write_image(&folder.path().join(name), &sample(), &metadata()).expect("it is writable");
    }
    let sidecar = std::fs::read(folder.path().join("a.NPY.json")).expect("it was written");
    let sidecar: serde_json::Value = serde_json::from_slice(&sidecar).expect("it is JSON");
    assert_eq!(sidecar["Software"], "Tetrascope");
    let error = write_image(&folder.path().join("a.jpg"), &sample(), &[]).expect_err("no JPEG");
    assert_eq!(
        error.to_string(),
        "no image format 'jpg'; valid: png, exr, npy"
    );
    let mut names: Vec<_> = std::fs::read_dir(folder.path())
        .expect("it is readable")
        .map(|entry| entry.expect("it is readable").file_name())
        .collect();
    names.sort();
    assert_eq!(names, ["a.NPY", "a.NPY.json", "a.exr", "a.png"]);
}

#[test]
fn an_existing_file_survives_a_frame_that_cannot_be_written() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("a.png");
    std::fs::write(&path, "precious").expect("it is writable");
    let empty = frame(0, 0, |_, _| [0.0; 4]);
    assert!(write_image(&path, &empty, &[]).is_err());
    let long_key = [("k".repeat(80), String::new())];
    assert!(write_image(&path, &sample(), &long_key).is_err());
    assert_eq!(std::fs::read(&path).expect("it is there"), b"precious");
    write_image(&path, &sample(), &[]).expect("it is writable");
    assert_ne!(std::fs::read(&path).expect("it is there"), b"precious");
    let nowhere = folder.path().join("no folder/a.png");
    assert!(matches!(
        write_image(&nowhere, &sample(), &[]),
        Err(Error::Io { .. })
    ));
}

fn names(folder: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(folder).expect("it is readable");
    let name = |entry: std::io::Result<std::fs::DirEntry>| entry.expect("readable").file_name();
    let mut names: Vec<_> = entries
        .map(|entry| name(entry).to_string_lossy().into_owned())
        .collect();
    names.sort();
    names
}

// A folder in a file's place is found when the file is to take its name: after the other
// has, unless that is undone.
#[test]
fn of_two_files_both_are_replaced_or_none() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("a.npy");
    let beside = folder.path().join("a.npy.json");
    std::fs::write(&path, "old").expect("it is writable");
    std::fs::create_dir(&beside).expect("it is writable");
    assert!(check_path(&path).is_err(), "refused before the work");
    let error = write_image(&path, &sample(), &metadata()).expect_err("a folder is in the way");
    assert!(error.to_string().contains("a.npy.json"), "{error}");
    assert_eq!(std::fs::read(&path).expect("it is there"), b"old");
    assert_eq!(names(folder.path()), ["a.npy", "a.npy.json"]);
    // Nor does a file appear that was not there.
    std::fs::remove_file(&path).expect("it is there");
    assert!(write_image(&path, &sample(), &metadata()).is_err());
    assert_eq!(names(folder.path()), ["a.npy.json"]);
    std::fs::remove_dir(&beside).expect("it is empty");
    for text in ["first", "second"] {
        let metadata = [("k".to_owned(), text.to_owned())];
        write_image(&path, &sample(), &metadata).expect("nothing is in the way");
        let json = std::fs::read_to_string(&beside).expect("it is there");
        assert!(json.contains(text), "{json}");
    }
    assert_eq!(names(folder.path()), ["a.npy", "a.npy.json"]);
}

#[test]
fn messages_name_the_file_and_not_a_temporary_one() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("no folder/a.png");
    let error = write_image(&path, &sample(), &[]).expect_err("there is no such folder");
    let text = error.to_string();
    assert!(text.contains("a.png") && !text.contains(PREFIX), "{text}");
    assert!(text.contains("No such file") || cfg!(not(unix)), "{text}");
}

// The encoder's hash map has another order each time it is made.
#[test]
fn the_same_picture_is_the_same_exr_file() {
    let many: Vec<(String, String)> = (0..12)
        .map(|i| (format!("key{i}"), format!("text {i}")))
        .collect();
    let first = encode_exr(&sample(), &many).expect("it is a frame");
    for _ in 0..5 {
        assert!(encode_exr(&sample(), &many).expect("it is a frame") == first);
    }
}

#[test]
fn numbers_are_an_array_of_rows() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("slice.npy");
    let numbers = [1.0, 2.5, f32::NAN, -1.0, 0.0, 7.0];
    write_npy(&path, 3, &numbers, &[("field".into(), "heat".into())]).expect("written");
    let bytes = std::fs::read(&path).expect("there");
    let header = String::from_utf8_lossy(&bytes[10..bytes.len() - 24]).into_owned();
    assert!(
        header.contains("'shape': (2, 3)") && header.ends_with('\n'),
        "{header}"
    );
    assert_eq!((bytes.len() - 24) % 64, 0);
    let read = bytes[bytes.len() - 24..].chunks(4);
    let read: Vec<u32> = read
        .map(|b| u32::from_le_bytes(b.try_into().expect("four")))
        .collect();
    assert_eq!(read, numbers.map(f32::to_bits));
    let beside = std::fs::read_to_string(folder.path().join("slice.npy.json")).expect("there");
    assert!(beside.contains("heat"), "{beside}");
    for (width, count) in [(0, 6), (4, 6), (3, 0)] {
        write_npy(&path, width, &numbers[..count], &[]).expect_err("no full rows");
    }
}

#[test]
fn metadata_are_read_back_of_whole_files_alone() {
    let folder = tempfile::tempdir().expect("a folder");
    for extension in FORMATS {
        let path = folder.path().join("a").with_extension(extension);
        write_image(&path, &sample(), &metadata()).expect("written");
        let mut found = read_metadata(&path).expect("it is whole");
        found.sort();
        assert_eq!(found, metadata(), "{extension}");
        let described = match extension {
            "npy" => sidecar(&path),
            _ => path.clone(),
        };
        let bytes = std::fs::read(&described).expect("it is there");
        for length in [0, 20, bytes.len() / 2] {
            std::fs::write(&described, &bytes[..length]).expect("written");
            read_metadata(&path).expect_err("a part of a file");
        }
        std::fs::remove_file(&described).expect("removed");
        assert!(matches!(read_metadata(&path), Err(Error::Io { .. })));
    }
}
