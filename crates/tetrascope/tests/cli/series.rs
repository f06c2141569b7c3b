//! Series of files: what their frames share, in which order, and what is left when one fails.

use std::fs;

use super::program::{Folder, Run};

const SMALL: &str = "--size 16 -q";

/// A mesh of one hexahedron of this height; its field goes from `low` to `high`.
pub(crate) fn mesh(height: f64, low: f64, high: f64) -> String {
    mesh_with("T", height, low, high)
}

fn mesh_with(field: &str, height: f64, low: f64, high: f64) -> String {
    let middle = 0.3 * low + 0.7 * high;
    format!(
        "# vtk DataFile Version 3.0\none\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 8 double\n\
         0 0 0  1 0 0  1 1 0  0 1 0  0 0 {height}  1 0 {height}  1 1 {height}  0 1 {height}\n\
         CELLS 1 9\n8 0 1 2 3 4 5 6 7\nCELL_TYPES 1\n12\nPOINT_DATA 8\n\
         SCALARS {field} double\nLOOKUP_TABLE default\n\
         {low} {middle} {middle} {low} {high} {middle} {high} {low}\n"
    )
}

/// A grid of 2×2×3 samples from `low` to `high`.
fn grid(low: f64, high: f64) -> String {
    let values: Vec<String> = (0..12)
        .map(|i| (low + (high - low) * f64::from(i) / 11.0).to_string())
        .collect();
    let values = values.join(" ");
    format!(
        "<VTKFile type=\"ImageData\"><ImageData WholeExtent=\"0 1 0 1 0 2\"><Piece Extent=\"0 1 0 1 0 2\">\
         <PointData Scalars=\"T\"><DataArray type=\"Float32\" Name=\"T\" format=\"ascii\">{values}\
         </DataArray></PointData></Piece></ImageData></VTKFile>"
    )
}

/// Three steps, one after the other in the order of their numbers alone. All have a range and
/// a height of their own.
fn steps() -> Folder {
    let folder = Folder::new();
    folder
        .write("step_1.vtk", mesh(1.0, 0.0, 1.0))
        .write("step_2.vtk", mesh(2.0, -1.0, 0.5))
        .write("step_10.vtk", mesh(1.5, 0.5, 3.0));
    folder
}

const NAMES: [&str; 3] = ["step_1.vtk", "step_2.vtk", "step_10.vtk"];

/// The files of a run's frames, as its JSON names them.
fn files(run: &Run) -> Vec<String> {
    let report = run.json();
    let frames = report["frames"].as_array().expect("frames");
    let file = |frame: &serde_json::Value| frame["file"].as_str().expect("a file").to_owned();
    frames.iter().map(file).collect()
}

/// The first and the last scalar of the transfer function that all frames share.
fn range(run: &Run) -> (f64, f64) {
    let report = run.json();
    let knots = report["scene"]["appearance"]["transfer_function"]
        .as_array()
        .expect("knots")
        .clone();
    let scalar = |knot: &serde_json::Value| knot["scalar"].as_f64().expect("a number");
    (scalar(&knots[0]), scalar(&knots[knots.len() - 1]))
}

/// The error and the help of a run that failed after it had printed frames.
#[track_caller]
fn failed(run: Run, code: i32) -> (String, String) {
    Run {
        stdout: String::new(),
        ..run
    }
    .failed(code)
}

#[test]
fn steps_are_drawn_in_natural_order_with_one_range() {
    let folder = steps();
    folder
        .write(
            "all.pvd",
            "<VTKFile type=\"Collection\"><Collection>\
             <DataSet timestep=\"0.5\" file=\"step_2.vtk\"/>\
             <DataSet timestep=\"7\" file=\"step_10.vtk\"/>\
             <DataSet timestep=\"0\" file=\"step_1.vtk\"/></Collection></VTKFile>",
        )
        .write(
            "all.vtk.series",
            "{\"file-series-version\": \"1.0\", \"files\": [\
             {\"name\": \"step_1.vtk\", \"time\": 0}, {\"name\": \"step_2.vtk\", \"time\": 0.5},\
             {\"name\": \"step_10.vtk\", \"time\": 7}]}",
        );
    let mut frames: Vec<Vec<u8>> = Vec::new();
    for input in [
        "step_*.vtk",
        "s*_*0.vtk step_?.vtk",
        "step_1.vtk step_2.vtk step_10.vtk",
        "all.pvd",
        "all.vtk.series",
    ] {
        let line = format!("render {input} --size 16 --json -o f_%02d.npy");
        let run = folder.run(&line).succeeded();
        assert_eq!(range(&run), (-1.0, 3.0), "{input}");
        if input.starts_with("s*") {
            assert_eq!(files(&run), [NAMES[2], NAMES[0], NAMES[1]]);
            continue;
        }
        assert_eq!(files(&run), NAMES, "{input}");
        let drawn = [0, 1, 2].map(|i| folder.read(&format!("f_{i:02}.npy")));
        match frames.is_empty() {
            true => frames = drawn.into(),
            false => assert_eq!(frames, drawn, "{input}"),
        }
    }
    let run = folder
        .run("render all.pvd --size 16 -o g_%d.png")
        .succeeded();
    assert_eq!(run.stdout, "g_0.png\ng_1.png\ng_2.png\n");
    assert!(
        run.stderr.contains("\ng_1.png: step_2.vtk, time 0.5 ("),
        "{}",
        run.stderr
    );
    assert!(
        run.stderr.contains("range: [-1, 3], the field's"),
        "{}",
        run.stderr
    );
    assert!(run.stderr.contains("3 of 3 frames drawn"), "{}", run.stderr);
    let run = folder
        .run("render all.pvd --size 16 -q -o g_%d.png")
        .succeeded();
    assert_eq!(run.stderr, "");
}

#[test]
fn what_a_shell_sorts_by_letters_is_noticed() {
    let folder = steps();
    let warning = |files: &str| {
        let line = format!("render {files} {SMALL} -o f_%d.png");
        folder.run(&line).succeeded().stderr
    };
    let shuffled = warning("step_1.vtk step_10.vtk step_2.vtk");
    assert!(
        shuffled.contains("not the order of their numbers"),
        "{shuffled}"
    );
    assert_eq!(warning("step_1.vtk step_2.vtk step_10.vtk"), "");
    assert_eq!(warning("step_10.vtk step_2.vtk step_1.vtk"), "");
}

/// Each frame is what `render` makes of its file in the scene of all, to the last bit.
fn frames_are_single_pictures(folder: &Folder, pattern: &str, names: &[&str], options: &str) {
    let scene = folder.run(&format!("print-scene {pattern} --size 24 -q"));
    folder.write("scene.toml", scene.succeeded().stdout);
    let line = format!("render {pattern} --size 24 -q {options} -o f_%d.npy");
    folder.run(&line).succeeded();
    for (i, name) in names.iter().enumerate() {
        let line = format!("render {name} --scene scene.toml -q {options} -o single.npy");
        folder.run(&line).succeeded();
        let frame = folder.read(&format!("f_{i}.npy"));
        assert_eq!(frame, folder.read("single.npy"), "{name} {options}");
        // Drawn again in the scene that is printed, where nothing is to be found out.
        let line = format!("render {pattern} --scene scene.toml -q {options} -o g_%d.npy");
        folder.run(&line).succeeded();
        assert_eq!(
            frame,
            folder.read(&format!("g_{i}.npy")),
            "{name} {options}"
        );
    }
}

#[test]
fn frames_are_what_single_renders_draw() {
    let folder = steps();
    // The same mesh twice: it is not uploaded again.
    folder.write("step_11.vtk", mesh(1.5, 2.5, 3.0));
    let names = [&NAMES[..], &["step_11.vtk"]].concat();
    let grids = ["a1.vti", "a2.vti", "a3.vti"];
    for (i, name) in grids.iter().enumerate() {
        folder.write(name, grid(-(i as f64), 2.0));
    }
    frames_are_single_pictures(&folder, "step_*.vtk", &names, "");
    frames_are_single_pictures(&folder, "a*.vti", &grids, "");
    if cfg!(feature = "projection") {
        let probe = folder.run("adapters");
        if probe.code == 4 {
            println!("skipped: {}", probe.stderr.trim());
            return;
        }
        frames_are_single_pictures(&folder, "step_*.vtk", &names, "--algorithm projection");
        frames_are_single_pictures(&folder, "a*.vti", &grids, "--algorithm slicing");
    }
}

#[test]
fn each_step_may_have_a_scene_of_its_own() {
    let folder = steps();
    let line = format!("render step_*.vtk {SMALL} --each-step -o f_%d.npy");
    folder.run(&line).succeeded();
    for (i, name) in NAMES.iter().enumerate() {
        folder
            .run(&format!("render {name} {SMALL} -o single.npy"))
            .succeeded();
        assert_eq!(
            folder.read(&format!("f_{i}.npy")),
            folder.read("single.npy")
        );
    }
}

#[test]
fn a_part_of_the_steps_has_the_range_and_the_numbers_of_all() {
    let folder = steps();
    let line = format!("render step_*.vtk {SMALL}");
    folder.run(&format!("{line} -o f_%d.png")).succeeded();
    let run = folder
        .run(&format!("{line} --steps 1.. -o g_%d.png"))
        .succeeded();
    assert_eq!(run.stdout, "g_1.png\ng_2.png\n");
    for i in [1, 2] {
        assert_eq!(
            folder.read(&format!("f_{i}.png")),
            folder.read(&format!("g_{i}.png"))
        );
    }
    let (error, help) = folder
        .run(&format!("{line} --steps 2..3 -o g_%d.png"))
        .failed(2);
    assert!(error.contains("3 steps, 0 to 2"), "{error}");
    assert!(help.contains("--steps 2..2"), "{help}");
}

#[test]
fn what_is_there_is_left_out_and_the_rest_is_as_it_would_have_been() {
    let folder = steps();
    for extension in ["png", "npy"] {
        let name = |i: usize| format!("f_{i}.{extension}");
        let line = format!("render step_*.vtk --size 16 -o f_%d.{extension}");
        folder.run(&line).succeeded();
        let whole: Vec<_> = (0..3).map(|i| folder.read(&name(i))).collect();
        // Without the steps at the ends of the range, and the first.
        for removed in [&[0, 2][..], &[1], &[0, 1, 2], &[]] {
            for &i in removed {
                fs::remove_file(folder.path(&name(i))).expect("it was there");
            }
            let run = folder.run(&format!("{line} --resume")).succeeded();
            let drawn: Vec<String> = removed.iter().map(|&i| name(i) + "\n").collect();
            assert_eq!(run.stdout, drawn.concat());
            let count = format!("{} of 3 frames drawn", removed.len());
            assert!(run.stderr.contains(&count), "{}", run.stderr);
            if removed.len() < 3 {
                let there = format!("{} were there", 3 - removed.len());
                assert!(run.stderr.contains(&there), "{}", run.stderr);
            }
            for (i, expected) in whole.iter().enumerate() {
                assert_eq!(&folder.read(&name(i)), expected, "{removed:?}");
            }
        }
    }
    // An array without its sidecar is not a picture.
    fs::remove_file(folder.path("f_1.npy.json")).expect("it was there");
    let run = folder.run("render step_*.vtk --size 16 -o f_%d.npy --resume");
    assert_eq!(run.succeeded().stdout, "f_1.npy\n");
}

#[test]
fn what_is_there_but_is_another_picture_is_not_taken_for_a_frame() {
    let folder = steps();
    let line = "render step_*.vtk --size 16 -q -o f_%d.png";
    folder.run(line).succeeded();
    let whole = [0, 1, 2].map(|i| folder.read(&format!("f_{i}.png")));
    for (options, words) in [
        (
            "--colormap inferno",
            "f_0.png is there, but is a frame of another scene",
        ),
        ("--each-step", "of another scene"),
        ("--algorithm raycast-peel", "by another algorithm"),
    ] {
        if options.ends_with("peel") && !cfg!(feature = "raycast-peel") {
            continue;
        }
        let (error, help) = folder.run(&format!("{line} --resume {options}")).failed(2);
        assert!(error.contains(words), "{error}");
        assert!(help.contains("without --resume"), "{help}");
    }
    // A step that comes before moves the others.
    folder.write("step_0.vtk", mesh(1.0, 0.0, 1.0));
    let (error, _) = folder.run(&format!("{line} --resume")).failed(2);
    assert!(error.contains("of another file"), "{error}");
    fs::remove_file(folder.path("step_0.vtk")).expect("it was there");
    // From another folder it is the same.
    let root = folder.root().display();
    let run = folder.run(&format!(
        "render {root}/step_*.vtk --size 16 -q -o f_%d.png --resume"
    ));
    assert_eq!(run.succeeded().stdout, "");
    // A half of a file is no frame; neither is that of a step that has changed.
    folder.write("f_1.png", &whole[1][..whole[1].len() / 2]);
    let run = folder.run(&format!("{line} --resume")).succeeded();
    assert_eq!(run.stdout, "f_1.png\n");
    assert_eq!(folder.read("f_1.png"), whole[1]);
    folder.write("step_1.vtk", mesh(1.0, 0.25, 1.0));
    let run = folder.run(&format!("{line} --resume")).succeeded();
    assert_eq!(run.stdout, "f_0.png\n");
    assert_ne!(folder.read("f_0.png"), whole[0]);
}

#[cfg(unix)]
#[test]
fn a_run_that_was_interrupted_goes_on_and_leaves_no_half_file() {
    use std::os::unix::process::ExitStatusExt as _;
    use std::process::{Command, Stdio};
    use std::time::Duration;
    let folder = Folder::new();
    for i in 0..40 {
        folder.write(&format!("s{i}.vtk"), mesh(1.0, f64::from(i), 50.0));
    }
    let line = "render s*.vtk --size 64 -q -o";
    folder.run(&format!("{line} whole_%d.png")).succeeded();
    for (after, signal, number) in [(0, "INT", 2), (3, "TERM", 15), (11, "INT", 2)] {
        let mut run = super::program::program()
            .current_dir(folder.root())
            .args(format!("{line} f_%d.png --resume").split_whitespace())
            .stdout(Stdio::null())
            .spawn()
            .expect("the program starts");
        while !folder.path(&format!("f_{after}.png")).exists() {
            std::thread::sleep(Duration::from_millis(1));
        }
        let mut kill = Command::new("kill");
        kill.args(["-s", signal, &run.id().to_string()]);
        // Where it has come to its end, there is nothing to interrupt.
        let _ = kill.status().expect("it starts");
        let status = run.wait().expect("it ends");
        assert!(
            status.success() || status.signal() == Some(number),
            "{status}"
        );
        let files = folder.files();
        assert!(!files.iter().any(|name| name.starts_with('.')), "{files:?}");
    }
    folder.run(&format!("{line} f_%d.png --resume")).succeeded();
    for i in 0..40 {
        assert_eq!(
            folder.read(&format!("f_{i}.png")),
            folder.read(&format!("whole_{i}.png"))
        );
    }
}

#[test]
fn a_step_that_fails_is_named_and_what_was_drawn_stays() {
    let folder = steps();
    // With a complete scene nothing is read before it is drawn.
    let scene = folder
        .run("print-scene step_*.vtk -q --size 16")
        .succeeded();
    folder.write("scene.toml", scene.stdout);
    for (bad, words) in [
        (
            mesh_with("other", 1.0, 0.0, 1.0),
            "no field 'T'; there are other [0, 1] (point), in step_3.vtk",
        ),
        (
            "# vtk DataFile Version 3.0\nx\nASCII\n".into(),
            "in step_3.vtk",
        ),
        ("nothing".into(), "in step_3.vtk"),
        (grid(0.0, 1.0).replace("\"T\"", "\"p\""), "no field 'T'"),
    ] {
        folder.write("step_3.vtk", bad);
        for name in ["f_0.png", "f_1.png"] {
            let _ = fs::remove_file(folder.path(name));
        }
        let run = folder.run("render step_*.vtk --scene scene.toml -q -o f_%d.png");
        assert_eq!(run.stdout, "f_0.png\nf_1.png\n");
        let (error, help) = failed(run, 3);
        assert!(
            error.contains(words) && error.contains("step_3.vtk"),
            "{error}"
        );
        assert!(help.contains("--resume goes on"), "{help}");
        assert!(folder.files().iter().any(|name| name == "f_1.png"));
        assert!(!folder.files().iter().any(|name| name == "f_2.png"));
        // Where ranges are to be found, before the first frame.
        let run = folder.run("render step_*.vtk --size 16 -q -o g_%d.png");
        let (error, help) = run.failed(3);
        assert!(error.contains("step_3.vtk"), "{error}");
        assert!(!help.contains("--resume"), "{help}");
    }
    folder.write("step_3.vtk", mesh(1.0, 0.0, 1.0));
    let run = folder.run("render step_*.vtk --scene scene.toml -q -o f_%d.png --resume");
    assert_eq!(run.succeeded().stdout, "f_2.png\nf_3.png\n");
}

#[test]
fn mistakes_are_refused_before_anything_is_drawn() {
    let folder = steps();
    folder
        .write("step_1.png", "")
        .write(
            "gap.pvd",
            "<VTKFile type=\"Collection\"><Collection>\
             <DataSet timestep=\"0\" file=\"step_1.vtk\"/>\
             <DataSet timestep=\"1\" file=\"gone\u{9b}.vtk\"/></Collection></VTKFile>",
        )
        .write(
            "parts.pvd",
            "<VTKFile type=\"Collection\"><Collection>\
             <DataSet timestep=\"0\" part=\"0\" file=\"step_1.vtk\"/>\
             <DataSet timestep=\"0\" part=\"1\" file=\"step_2.vtk\"/></Collection></VTKFile>",
        )
        .write(
            "self.pvd",
            "<VTKFile type=\"Collection\"><Collection>\
             <DataSet timestep=\"0\" file=\"self.pvd\"/></Collection></VTKFile>",
        );
    let before = folder.files();
    let frames = "-o f_%d.png";
    for (line, code, words, hint) in [
        (
            "step_*.vtk -o a.png",
            2,
            "'a.png' is one name",
            "-o a_%04d.png",
        ),
        (
            "step_*.vtk -o a_%s.png",
            2,
            "neither %d nor %04d nor %%",
            "-o a_%04d.png",
        ),
        (
            "step_*.vtk -o a_%4d.png",
            2,
            "neither %d nor",
            "-o a_%04d.png",
        ),
        (
            "step_*.vtk",
            2,
            "need a name with a number",
            "-o frame_%04d.png",
        ),
        ("step_*.vtk -o a_%d.gif", 2, "no image format 'gif'", ""),
        (
            "step_*.vtk -o no/a_%d.png",
            1,
            "cannot write no/a_0.png",
            "",
        ),
        (
            &format!("stop_*.vtk {frames}"),
            3,
            "no file matches 'stop_*.vtk'",
            "step_1.vtk, step_2.vtk, step_10.vtk",
        ),
        (
            &format!("step_*.vti {frames}"),
            3,
            "no file matches 'step_*.vti'",
            "step_1.png, step_1.vtk, step_2.vtk, step_10.vtk",
        ),
        (&format!("no/step_*.vtk {frames}"), 3, "cannot open no", ""),
        (
            &format!("s*/step_*.vtk {frames}"),
            2,
            "is a pattern of folders",
            "file's name alone",
        ),
        (
            &format!("step_1.vtk step_3.vtk {frames}"),
            3,
            "cannot open step_3.vtk",
            "",
        ),
        (
            &format!("step_1.vtk step_1.vtk {frames}"),
            2,
            "'step_1.vtk' is named twice",
            "",
        ),
        (
            &format!("gap.pvd step_1.vtk {frames}"),
            2,
            "a series of its own",
            "alone",
        ),
        (
            &format!("gap.pvd {frames}"),
            3,
            "the file 'gone\\u{9b}.vtk' is not there, in gap.pvd",
            "folder",
        ),
        (
            &format!("parts.pvd {frames}"),
            3,
            "both for the time 0",
            "one file",
        ),
        (
            &format!("self.pvd {frames}"),
            3,
            "lists other files itself",
            "",
        ),
        (&format!("none.pvd {frames}"), 3, "cannot open none.pvd", ""),
        (
            &format!("step_*.vtk --field P {frames}"),
            3,
            "no field 'P'",
            "--field 'T'",
        ),
        (
            "step_1.vtk --resume -o a.png",
            2,
            "are for a series",
            "pattern",
        ),
        (
            "sphere --each-step -o a_%d.png",
            2,
            "are for a series",
            "pattern",
        ),
    ] {
        let line = format!("render --size 16 -q {line}");
        let (error, help) = folder.run(&line).failed(code);
        assert!(error.contains(words), "{line}: {error}");
        assert!(help.contains(hint), "{line}: {help}");
        assert_eq!(folder.files(), before, "{line}");
    }
    let (_, help) = folder.run("info gap.pvd").failed(3);
    assert!(
        help.contains("`tetrascope render FILE -o frame_%04d.png`"),
        "{help}"
    );
}

// Doubles that 32 bits cannot tell apart are kept less an offset, each file its own.
#[test]
fn values_that_mean_something_else_in_each_step_are_refused() {
    let folder = Folder::new();
    for i in [1, 2] {
        let low = 1e9 * f64::from(i);
        let grid = grid(low, low + 0.1).replace("Float32", "Float64");
        folder.write(&format!("a{i}.vti"), grid);
    }
    let line = format!("render a?.vti {SMALL} -o f_%d.png");
    let (error, help) = folder.run(&line).failed(3);
    assert!(
        error.contains("less 2000000000") && error.ends_with("in a2.vti"),
        "{error}"
    );
    assert!(help.contains("--each-step"), "{help}");
    folder.run(&format!("{line} --each-step")).succeeded();
}

#[test]
fn one_file_with_a_numbered_frame_is_a_series_of_one() {
    let folder = steps();
    let run = folder.run(&format!("render step_1.vtk {SMALL} -o f_%03d.png"));
    assert_eq!(run.succeeded().stdout, "f_000.png\n");
}
