//! Tests of the pictures of a session, without a network.

use std::cell::RefCell;
use std::sync::mpsc::{Receiver, Sender, channel};
use std::sync::{Arc, Mutex};

use tetrascope::core::VolumeRenderer as _;
use tetrascope::io::image::encode_png;
use tetrascope::scene::{SceneFile, VolumeSource};
use tetrascope::view::{
    Encoded, Estimate, Event, Kind, Message, Session, Start, State, command_line,
};
use tetrascope::{Context, Settings, algorithm, volumes};

use crate::program::{PATIENCE, PROGRAM, decode};

/// A session and what it tells.
struct Told {
    session: Session,
    events: Receiver<Event>,
    /// The last complete picture: it may come before the state that it shows, as they are of other threads.
    last: RefCell<Option<Arc<Encoded>>>,
}

fn start(change: impl FnOnce(&mut SceneFile)) -> Told {
    let mut scene = volumes::scene(tetrascope::datasets::find("sphere").expect("a data set"));
    scene.volume.cells = Some(2000);
    (scene.image.width, scene.image.height) = (Some(96), Some(64));
    change(&mut scene);
    start_scene(scene)
}

fn start_scene(scene: SceneFile) -> Told {
    let loaded = volumes::load(&scene.volume).expect("a volume");
    let algorithm = algorithm("raycast-cpu").expect("it is there");
    let start = Start {
        scene,
        loaded,
        steps: Vec::new(),
        algorithm,
        settings: Settings::defaults(algorithm),
        measurements: None,
    };
    let (sender, events): (Sender<Event>, _) = channel();
    let sender = Mutex::new(sender);
    let tell = move |event| {
        // The test may have what it wants.
        let _ = sender.lock().expect("nothing panics").send(event);
    };
    Told {
        session: Session::start(start, tell).expect("it starts"),
        events,
        last: RefCell::new(None),
    }
}

impl Told {
    fn ask(&self, json: &str) -> Result<(), String> {
        let message: Message = serde_json::from_str(json).map_err(|error| error.to_string())?;
        self.session
            .take(1, &message)
            .map_err(|error| error.to_string())
    }

    fn command(&self, json: &str) {
        let message = format!("{{\"seq\": 1, \"command\": {json}}}");
        self.ask(&message)
            .unwrap_or_else(|error| panic!("{json}: {error}"));
    }

    fn next(&self) -> Event {
        let event = self.events.recv_timeout(PATIENCE);
        let event = event.expect("something happens");
        if let Event::Picture(picture) = &event
            && picture.kind == Kind::Complete
        {
            self.last.replace(Some(picture.clone()));
        }
        event
    }

    /// The complete picture of the newest state.
    fn complete(&self) -> Arc<Encoded> {
        loop {
            let newest = self.session.state().version;
            if let Some(picture) = &*self.last.borrow()
                && picture.version == newest
            {
                return picture.clone();
            }
            if let Event::Problem(problem, ..) = self.next() {
                panic!("{problem}");
            }
        }
    }

    fn estimate(&self) -> Arc<Estimate> {
        loop {
            if let Event::Estimate(estimate) = self.next() {
                return estimate;
            }
        }
    }
}

/// The picture that the library draws of a state.
fn drawn(state: &State) -> Vec<u8> {
    let build = state.algorithm.build;
    let scene = &state.scene;
    let volume = state.field.volume();
    let renderer = build(&Context::new(), volume, &scene.appearance, &state.settings);
    let frame = renderer
        .expect("it draws")
        .render(&scene.view)
        .expect("a frame");
    decode(&encode_png(&frame, &[]).expect("a file")).1
}

fn camera(x: f64) -> String {
    format!(
        "{{\"do\": \"camera\", \"camera\": {{\"position\": [{x}, 3, 1], \
         \"focal_point\": [0, 0, 0], \"view_up\": [0, 0, 1], \"view_angle\": 30}}}}"
    )
}

#[test]
fn the_complete_picture_is_the_one_that_render_draws() {
    let told = start(|_| ());
    let picture = told.complete();
    assert_eq!(picture.size, [96, 64]);
    assert_eq!(decode(picture.png()).1, drawn(&told.session.state()));
    told.command(&camera(2.0));
    told.command("{\"do\": \"size\", \"width\": 150, \"height\": 70}");
    told.command("{\"do\": \"depth-cue\", \"strength\": 0.5}");
    told.command("{\"do\": \"clip\", \"planes\": [{\"point\": [0, 0, 0], \"normal\": [1, 0, 0]}]}");
    let picture = told.complete();
    assert_eq!(picture.size, [150, 70]);
    let pixels = decode(picture.png()).1;
    assert_eq!(pixels, drawn(&told.session.state()));
    assert!(pixels.iter().any(|byte| *byte != 0), "something shows");
}

#[test]
fn a_newer_view_replaces_an_older_one_and_nothing_is_queued() {
    let told = start(|scene| {
        (scene.image.width, scene.image.height) = (Some(700), Some(500));
    });
    let first = told.complete().version;
    for i in 0..300 {
        let x = f64::from(i) / 100.0;
        let message = format!(
            "{{\"seq\": {i}, \"moving\": true, \"command\": {}}}",
            camera(x)
        );
        told.ask(&message).expect("a camera");
    }
    let last = told.session.state().version;
    assert_eq!(last, first + 300);
    told.ask("{\"seq\": 300}").expect("the hand rests");
    let (mut versions, mut quick) = (vec![first], 0);
    let complete = loop {
        let Event::Picture(picture) = told.next() else {
            continue;
        };
        assert!(
            picture.version >= versions[versions.len() - 1],
            "an older one comes later"
        );
        versions.push(picture.version);
        match picture.kind {
            Kind::Quick => quick += 1,
            Kind::Complete if picture.version == last => break picture,
            // On a fast machine the quick picture is the complete one.
            Kind::Complete => assert!(picture.header["more"]["why"].is_string()),
            _ => {}
        }
    };
    // Commands came faster than any machine draws: most were never drawn.
    assert!(quick < 250, "{quick} pictures of 300 views");
    assert_eq!(decode(complete.png()).1, drawn(&told.session.state()));
    // What comes after the last one is of no older view.
    versions.dedup();
    assert!(versions.len() < 250, "{}", versions.len());
}

#[test]
fn what_is_wrong_is_refused_and_changes_nothing() {
    let told = start(|_| ());
    let before = told.session.state();
    for wrong in [
        "{\"do\": \"size\", \"width\": 0, \"height\": 5}",
        "{\"do\": \"size\", \"width\": 60000, \"height\": 60000}",
        "{\"do\": \"range\", \"low\": 2, \"high\": 1}",
        "{\"do\": \"unit-distance\", \"length\": 0}",
        "{\"do\": \"unit-distance\", \"length\": 1e-300}",
        "{\"do\": \"depth-cue\", \"strength\": 7}",
        "{\"do\": \"algorithm\", \"name\": \"raycast\"}",
        "{\"do\": \"algorithm\", \"name\": \"raycast-cpu\", \"settings\": {\"x\": \"1\"}}",
        "{\"do\": \"camera\", \"camera\": {\"position\": [0, 0, 0], \"focal_point\": [0, 0, 0]}}",
        "{\"do\": \"background\", \"color\": [-1, 0, 0, 1]}",
        "{\"do\": \"points\", \"preset\": {\"name\": \"\", \"color_space\": \"RGB\", \"colors\": [], \"opacities\": []}}",
        "{\"do\": \"import-preset\", \"text\": \"[]\"}",
        "{\"do\": \"import-scene\", \"text\": \"version = 9\"}",
        "{\"do\": \"clip\", \"planes\": [{\"point\": [0, 0, 0], \"normal\": [0, 0, 0]}]}",
        "{\"do\": \"algorithm\", \"name\": \"slicing\"}",
    ] {
        let message = format!("{{\"seq\": 1, \"command\": {wrong}}}");
        let error = told.ask(&message).expect_err(wrong);
        assert!(!error.is_empty() && !error.contains('\n'), "{error}");
    }
    let planes = vec!["{\"point\": [0, 0, 0], \"normal\": [1, 0, 0]}"; 17].join(", ");
    assert!(
        told.ask(&format!(
            "{{\"command\": {{\"do\": \"clip\", \"planes\": [{planes}]}}}}"
        ))
        .is_err()
    );
    let after = told.session.state();
    assert_eq!(
        (before.version, &before.scene),
        (after.version, &after.scene)
    );
}

#[test]
fn points_presets_and_ranges_make_the_function_that_is_drawn() {
    let told = start(|scene| scene.appearance = Default::default());
    let knots = |told: &Told| {
        told.session
            .state()
            .scene
            .appearance
            .transfer_function
            .clone()
    };
    let (low, high) = knots(&told).range();
    // Opacities alone: the map keeps its name and its colors.
    told.command(&format!(
        "{{\"do\": \"points\", \"keep_colors\": true, \"preset\": {{\"name\": \"\", \
         \"color_space\": \"RGB\", \"colors\": [], \"opacities\": \
         [{{\"scalar\": {low}, \"opacity\": 0.5}}, {{\"scalar\": {high}, \"opacity\": 0}}]}}}}"
    ));
    let state = told.session.state();
    let saved = serde_json::to_value(state.saved()).expect("JSON");
    assert_eq!(saved["colormap"], "viridis");
    let function = knots(&told);
    let (_, extinction) = function.sample(low).expect("a number");
    let unit = saved["unit_distance"].as_f64().expect("a number");
    assert!((1.0 - (-extinction * unit).exp() - 0.5).abs() < 1e-9);
    assert_eq!(function.knots().last().map(|k| k.extinction), Some(0.0));
    // A range moves knots, a unit distance scales extinctions: both leave the shape to the bit.
    told.command("{\"do\": \"range\", \"low\": 10, \"high\": 30}");
    let moved = knots(&told);
    assert_eq!(moved.range(), (10.0, 30.0));
    let extinctions = |f: &tetrascope::core::TransferFunction| -> Vec<f64> {
        f.knots().iter().map(|k| k.extinction).collect()
    };
    assert_eq!(extinctions(&moved), extinctions(&function));
    told.command(&format!(
        "{{\"do\": \"unit-distance\", \"length\": {}}}",
        2.0 * unit
    ));
    let halves: Vec<f64> = extinctions(&moved).iter().map(|e| e / 2.0).collect();
    assert_eq!(extinctions(&knots(&told)), halves);
    // ParaView's preset, at its own values.
    let preset = r#"[{"ColorSpace": "RGB", "RGBPoints": [0, 1, 0, 0, 1, 0, 0, 1], "Points": [0, 0, 0.5, 0, 1, 1, 0.5, 0]}]"#;
    let text = serde_json::to_string(preset).expect("JSON");
    told.command(&format!("{{\"do\": \"import-preset\", \"text\": {text}}}"));
    assert_eq!(knots(&told).range(), (0.0, 1.0));
    let first = knots(&told).knots()[0];
    assert_eq!(first.color.to_array(), [1.0, 0.0, 0.0]);
    // Whatever the ranges were before, the picture is that of a new renderer.
    let picture = told.complete();
    assert_eq!(decode(picture.png()).1, drawn(&told.session.state()));
}

#[test]
fn a_saved_view_is_restored_by_another_session() {
    let told = start(|_| ());
    told.command(&camera(-4.0));
    told.command("{\"do\": \"colormap\", \"name\": \"magma\"}");
    told.command("{\"do\": \"model\", \"name\": \"isosurfaces\"}");
    told.command("{\"do\": \"isosurfaces\", \"surfaces\": [{\"value\": 0.3}, {\"value\": 0.6}]}");
    told.command("{\"do\": \"algorithm\", \"name\": \"reference\"}");
    told.command("{\"do\": \"orthographic\", \"on\": true}");
    let state = told.session.state();
    let saved = serde_json::to_string(&state.saved()).expect("JSON");
    assert!(
        saved.len() < 20_000,
        "an address holds it: {} bytes",
        saved.len()
    );
    let other = start(|_| ());
    other.command(&format!("{{\"do\": \"restore\", \"saved\": {saved}}}"));
    let restored = other.session.state();
    assert_eq!(restored.scene.view, state.scene.view);
    assert_eq!(restored.scene.appearance, state.scene.appearance);
    assert_eq!(restored.algorithm.name, "reference");
    assert_eq!(
        serde_json::to_string(&restored.saved()).expect("JSON"),
        saved
    );
    other.command("{\"do\": \"reset\"}");
    assert_eq!(
        other.session.state().scene.appearance,
        start(|_| ()).session.state().scene.appearance
    );
}

#[test]
fn the_error_is_measured_and_the_difference_is_drawn() {
    let told = start(|_| ());
    let complete = told.complete();
    let estimate = told.estimate();
    let error = estimate.error.as_ref().expect("the truth draws spheres");
    // Rounding of f32 alone.
    assert!(error.upper < 1e-5 && error.sampled > 1000, "{error:?}");
    assert_eq!(estimate.version, complete.version);
    told.ask("{\"seq\": 2, \"difference\": true}")
        .expect("it is asked for");
    let picture = loop {
        match told.next() {
            Event::Picture(picture) if picture.kind == Kind::Difference => break picture,
            Event::Problem(problem, ..) => panic!("{problem}"),
            _ => {}
        }
    };
    let more = &picture.header["more"];
    let [rmse, greatest] = ["rmse", "greatest"].map(|key| more[key].as_f64().expect("a number"));
    assert!(rmse > 0.0 && rmse <= greatest && greatest < 1e-5, "{more}");
}

/// The command that the viewer prints draws its picture, to the last bit.
#[cfg(unix)]
#[test]
fn the_command_line_draws_the_picture() {
    let told = start(|_| ());
    told.command(&camera(2.5));
    told.command("{\"do\": \"colormap\", \"name\": \"plasma\"}");
    told.command(
        "{\"do\": \"algorithm\", \"name\": \"raycast-cpu\", \"settings\": {\"stop-opacity\": \"0.9\"}}",
    );
    let picture = told.complete();
    let command = command_line(&told.session.state());
    assert!(command.contains("--set stop-opacity=0.9"), "{command}");
    let folder = tempfile::tempdir().expect("a folder");
    let path = std::path::Path::new(PROGRAM)
        .parent()
        .expect("a folder")
        .to_owned();
    let search = std::env::var_os("PATH").unwrap_or_default();
    let all = std::env::join_paths([path].into_iter().chain(std::env::split_paths(&search)));
    let run = std::process::Command::new("sh")
        .arg("-c")
        .arg(&command)
        .current_dir(folder.path())
        .env("PATH", all.expect("paths"))
        .output()
        .expect("a shell");
    assert!(
        run.status.success(),
        "{}",
        String::from_utf8_lossy(&run.stderr)
    );
    let file = std::fs::read(folder.path().join("sphere.png")).expect("it is named so");
    assert_eq!(decode(&file), decode(picture.png()));
}

/// A file's fields, one after the other; geometry is shared.
#[test]
fn another_field_has_its_own_look() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("two.vtk");
    let points = "POINTS 4 double\n0 0 0 1 0 0 0 1 0 0 0 1\n";
    let cells = "CELLS 1 5\n4 0 1 2 3\nCELL_TYPES 1\n10\nPOINT_DATA 4\n";
    let field = |name: &str, values: &str| {
        format!("SCALARS {name} double 1\nLOOKUP_TABLE default\n{values}\n")
    };
    let fields = field("warm", "0 1 2 3") + &field("cold", "-50 -40 -30 -20");
    let header = "# vtk DataFile Version 3.0\ntwo\nASCII\nDATASET UNSTRUCTURED_GRID\n";
    std::fs::write(&path, format!("{header}{points}{cells}{fields}")).expect("written");
    let mut scene = SceneFile::new(VolumeSource {
        file: Some(path),
        ..VolumeSource::default()
    });
    (scene.image.width, scene.image.height) = (Some(32), Some(32));
    let told = start_scene(scene);
    told.complete();
    told.command("{\"do\": \"colormap\", \"name\": \"inferno\"}");
    told.command("{\"do\": \"field\", \"name\": \"cold\"}");
    loop {
        match told.next() {
            Event::State(state, ..) if state.field.name() == "cold" => break,
            Event::Problem(problem, ..) => panic!("{problem}"),
            _ => {}
        }
    }
    let state = told.session.state();
    assert_eq!(
        state.scene.appearance.transfer_function.range(),
        (-50.0, -20.0)
    );
    let saved = serde_json::to_value(state.saved()).expect("JSON");
    assert_eq!(saved["colormap"], "inferno");
    let picture = told.complete();
    assert_eq!(decode(picture.png()).1, drawn(&told.session.state()));
    // One that is not there is said, and what is there stays.
    told.command("{\"do\": \"field\", \"name\": \"hot\"}");
    loop {
        if let Event::Problem(problem, ..) = told.next() {
            assert!(
                problem.contains("hot") && problem.contains("warm"),
                "{problem}"
            );
            break;
        }
    }
    assert_eq!(told.session.state().field.name(), "cold");
}
