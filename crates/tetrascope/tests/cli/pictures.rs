//! Tests of the files that `render` writes.

use tetrascope::scene::SceneFile;

use super::program::Folder;

const SMALL: &str = "sphere --cells 600 --size 24x16";

/// The text chunks of a PNG file.
fn texts(bytes: &[u8]) -> Vec<(String, String)> {
    let decoder = png::Decoder::new(std::io::Cursor::new(bytes));
    let mut reader = decoder.read_info().expect("a PNG file");
    reader.finish().expect("to its end");
    let info = reader.info();
    let latin = info.uncompressed_latin1_text.iter();
    let latin = latin.map(|chunk| (chunk.keyword.clone(), chunk.text.clone()));
    let compressed = info.compressed_latin1_text.iter().map(|chunk| {
        let text = chunk.get_text().expect("it decompresses");
        (chunk.keyword.clone(), text)
    });
    let utf8 = info.utf8_text.iter().map(|chunk| {
        let text = chunk.get_text().expect("it decompresses");
        (chunk.keyword.clone(), text)
    });
    latin.chain(compressed).chain(utf8).collect()
}

#[test]
fn the_picture_is_named_after_its_source_and_its_path_printed() {
    let folder = Folder::new();
    let run = folder.run(&format!("render {SMALL}")).succeeded();
    assert_eq!(run.stdout, "sphere.png\n");
    assert_eq!(folder.files(), ["sphere.png"]);
    for line in [
        "loading data set sphere",
        "tetrahedra",
        "drawing 24x16 pixels",
    ] {
        assert!(run.stderr.contains(line), "{line}: {}", run.stderr);
    }
    assert!(
        !run.stderr.contains('\x1b'),
        "no colors into a file: {}",
        run.stderr
    );
    let quiet = folder.run(&format!("render {SMALL} -q")).succeeded();
    assert_eq!(quiet.stderr, "");
}

#[test]
fn the_same_scene_is_the_same_file_whatever_the_threads() {
    let folder = Folder::new();
    for (name, threads) in [("a", 1), ("b", 1), ("c", 3)] {
        let line = format!("render {SMALL} -q --threads {threads} -o {name}.png");
        folder.run(&line).succeeded();
        folder
            .run(&format!(
                "render {SMALL} -q --threads {threads} -o {name}.npy"
            ))
            .succeeded();
    }
    for extension in ["png", "npy"] {
        let first = folder.read(&format!("a.{extension}"));
        assert_eq!(first, folder.read(&format!("b.{extension}")), "{extension}");
        assert_eq!(first, folder.read(&format!("c.{extension}")), "{extension}");
    }
}

#[test]
fn a_picture_carries_all_that_it_takes_to_make_it_again() {
    let folder = Folder::new();
    for name in ["a.png", "a.npy"] {
        let line = format!("render {SMALL} --algorithm reference -o {name}");
        folder.run(&line).succeeded();
    }
    let texts = texts(&folder.read("a.png"));
    let text = |key: &str| {
        let found = texts.iter().find(|(k, _)| k.ends_with(key));
        &found.unwrap_or_else(|| panic!("no {key} in {texts:?}")).1
    };
    assert_eq!(
        text("Software"),
        concat!("tetrascope ", env!("CARGO_PKG_VERSION"))
    );
    assert_eq!(text("Algorithm"), "reference");
    assert_eq!(text("Adapter"), "CPU");
    assert!(text("Mesh").contains("tetrahedra"), "{}", text("Mesh"));
    assert!(
        text("Statistics").contains("error_bound"),
        "{}",
        text("Statistics")
    );

    let scene = SceneFile::parse(text("Scene"), "a.toml".as_ref()).expect("a scene");
    assert_eq!(scene.volume.cells, Some(600));
    folder.write("again.toml", text("Scene"));
    folder
        .run("render --scene again.toml --algorithm reference -o again.npy")
        .succeeded();
    assert_eq!(folder.read("again.npy"), folder.read("a.npy"));
}

#[test]
fn the_json_report_says_what_was_done_and_how_long_it_took() {
    let folder = Folder::new();
    let run = folder
        .run(&format!(
            "render {SMALL} --algorithm reference --json -o a.exr"
        ))
        .succeeded();
    assert_eq!(run.stderr, "");
    let report = run.json();
    assert_eq!(report["output"], "a.exr");
    assert_eq!(report["algorithm"], "reference");
    assert_eq!(report["width"], 24);
    assert_eq!(report["warnings"], serde_json::json!([]));
    assert_eq!(report["scene"]["volume"]["dataset"], "sphere");
    for step in ["load", "prepare", "render", "write"] {
        assert!(report["seconds"][step].is_f64(), "{step}: {report}");
    }
    assert!(
        report["statistics"]["error_bound"]
            .as_f64()
            .expect("a bound")
            < 1e-5
    );
    assert_eq!(folder.files(), ["a.exr"]);
}

#[test]
fn float_pictures_have_the_right_shape() {
    let folder = Folder::new();
    folder
        .run(&format!("render {SMALL} -q -o a.npy"))
        .succeeded();
    let bytes = folder.read("a.npy");
    let header = String::from_utf8_lossy(&bytes[..128]).into_owned();
    assert!(
        header.contains("(16, 24, 4)") && header.contains("<f4"),
        "{header}"
    );
    let alpha = |x: usize, y: usize| {
        let at = bytes.len() - 16 * (24 * 16) + 16 * (24 * y + x) + 12;
        f32::from_le_bytes(bytes[at..at + 4].try_into().expect("four bytes"))
    };
    assert_eq!(alpha(0, 0), 0.0, "nothing in the corner");
    assert!(
        alpha(12, 8) > 0.1,
        "something in the middle: {}",
        alpha(12, 8)
    );
}

#[test]
fn an_empty_picture_says_why() {
    let folder = Folder::new();
    folder.write(
        "away.toml",
        "version = 1\nvolume.dataset = \"sphere\"\nvolume.cells = 600\n\
         [camera]\nposition = [50, 50, 50]\nfocal_point = [90, 90, 90]\n",
    );
    for (line, word) in [
        ("--scene away.toml", "the camera sees no cell"),
        (
            "sphere --cells 600 --unit-distance 1e9",
            "opacity is too low",
        ),
    ] {
        let run = folder
            .run(&format!("render {line} --size 8 -q -o out.png"))
            .succeeded();
        assert!(
            run.stderr.starts_with("warning: the picture is empty"),
            "{}",
            run.stderr
        );
        assert!(run.stderr.contains(word), "{}", run.stderr);
        assert!(run.stderr.contains("  help: "), "{}", run.stderr);
        assert_eq!(run.stdout, "out.png\n");
        let run = folder.run(&format!("render {line} --size 8 --json -o out.png"));
        let report = run.succeeded().json();
        let message = report["warnings"][0]["message"]
            .as_str()
            .expect("a warning");
        assert!(message.contains(word), "{report}");
    }
}

#[cfg(feature = "projection")]
#[test]
fn both_algorithms_draw_the_same_picture() {
    let folder = Folder::new();
    let probe = folder.run("adapters");
    if probe.code == 4 {
        println!("skipped: {}", probe.stderr.trim());
        return;
    }
    let line = format!("render {SMALL} --model emission -q -o");
    folder.run(&format!("{line} a.npy")).succeeded();
    let run = folder
        .run(&format!("{line} b.npy --algorithm projection --json"))
        .succeeded();
    let adapter = run.json()["adapter"].clone();
    assert!(adapter.is_string(), "{adapter}");
    let floats = |name: &str| -> Vec<f32> {
        let bytes = folder.read(name);
        let texels = &bytes[bytes.len() - 16 * 24 * 16..];
        let texels = texels.chunks_exact(4);
        texels
            .map(|b| f32::from_le_bytes(b.try_into().expect("four")))
            .collect()
    };
    let (a, b) = (floats("a.npy"), floats("b.npy"));
    let squares = a.iter().zip(&b).map(|(a, b)| f64::from(a - b).powi(2));
    let rmse = (squares.sum::<f64>() / a.len() as f64).sqrt();
    // What the comparison demands of the commutative models.
    assert!(rmse < 1e-4, "{rmse} on {adapter}");
}
