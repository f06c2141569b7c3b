use super::*;

/// A folder with empty files of these names.
fn folder(names: &[&str]) -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a folder");
    for name in names {
        std::fs::write(folder.path().join(name), "").expect("written");
    }
    folder
}

fn read_as(
    folder: &tempfile::TempDir,
    name: &str,
    text: impl AsRef<[u8]>,
) -> Result<Vec<Step>, Error> {
    let path = folder.path().join(name);
    std::fs::write(&path, text).expect("written");
    assert!(is_collection(&path));
    read_collection(&path)
}

fn pvd(entries: &str) -> String {
    format!(
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\"><Collection>{entries}</Collection></VTKFile>\n"
    )
}

fn names(steps: &[Step]) -> Vec<(String, Option<f64>)> {
    let name = |step: &Step| {
        step.file
            .file_name()
            .expect("a name")
            .to_string_lossy()
            .into()
    };
    steps.iter().map(|step| (name(step), step.time)).collect()
}

#[test]
fn both_formats_give_files_by_time() {
    let folder = folder(&["a.vtu", "b & c.vtu"]);
    let steps = read_as(
        &folder,
        "x.pvd",
        pvd(
            "<DataSet timestep=\"1e1\" group=\"\" part=\"0\" file=\"a.vtu\"/>
             <DataSet timestep=\"-0.5\" file=\"b &amp; c.vtu\"></DataSet>",
        ),
    );
    let steps = steps.expect("a collection");
    let expected = [
        ("b & c.vtu".into(), Some(-0.5)),
        ("a.vtu".into(), Some(10.0)),
    ];
    assert_eq!(names(&steps), expected);
    assert!(
        steps
            .iter()
            .all(|step| step.file.starts_with(folder.path()))
    );
    let steps = read_as(
        &folder,
        "x.vtu.series",
        "{\"file-series-version\": \"1.0\", \"files\": [
            {\"name\": \"a.vtu\", \"time\": 10}, {\"name\": \"./b & c.vtu\", \"time\": -0.5}]}",
    );
    assert_eq!(names(&steps.expect("a series")), expected);
    // Without times the order is the file's, and one step needs none.
    let untimed = "{\"files\": [{\"name\": \"b & c.vtu\"}, {\"name\": \"a.vtu\"}]}";
    let steps = read_as(&folder, "x.series", untimed).expect("a series");
    assert_eq!(
        names(&steps),
        [("b & c.vtu".into(), None), ("a.vtu".into(), None)]
    );
    let steps = read_as(&folder, "x.PVD", pvd("<DataSet file=\"a.vtu\"/>"));
    assert_eq!(names(&steps.expect("one step")), [("a.vtu".into(), None)]);
}

#[test]
fn files_below_the_folder_are_found_and_files_elsewhere_are_refused() {
    let folder = folder(&["a.vtu"]);
    std::fs::create_dir(folder.path().join("lists")).expect("made");
    std::fs::write(folder.path().join("lists/b.vtu"), "").expect("written");
    let below = pvd("<DataSet timestep=\"0\" file=\"./lists/b.vtu\"/>");
    let steps = read_as(&folder, "x.pvd", below).expect("it is there");
    assert!(steps[0].file.is_file());
    let path = folder.path().join("lists/x.pvd");
    let absolute = folder.path().join("a.vtu").display().to_string();
    for name in [
        "../a.vtu",
        "../lists/b.vtu",
        "./../a.vtu",
        "/dev/zero",
        &absolute,
    ] {
        let entry = format!("<DataSet timestep=\"0\" file=\"{name}\"/>");
        std::fs::write(&path, pvd(&entry)).expect("written");
        let error = read_collection(&path).expect_err(name);
        let words = format!("'{name}' is not in the collection's folder");
        assert!(error.to_string().contains(&words), "{error}");
    }
}

#[test]
fn what_is_not_a_series_is_refused_in_words() {
    let folder = folder(&["a.vtu", "b.vtu"]);
    let data = |time: &str, file: &str| format!("<DataSet timestep=\"{time}\" file=\"{file}\"/>");
    let a = data("0", "a.vtu");
    for (entries, words) in [
        (String::new(), "lists no file"),
        (
            a.clone() + &data("0.0", "b.vtu"),
            "'a.vtu' and 'b.vtu' are both for the time 0",
        ),
        (a.clone() + &data("1", "a.vtu"), "'a.vtu' is listed twice"),
        (a.clone() + &data("1", "x.pvd"), "'x.pvd' lists other files"),
        (
            a.clone() + &data("1", "p.series"),
            "'p.series' lists other files",
        ),
        (
            a.clone() + &data("1", "c.vtu") + &data("2", "d.vtu"),
            "the file 'c.vtu' is not there, nor are 1 other",
        ),
        (a.clone() + &data("1", "."), "the file '.' is not there"),
        (data("nan", "a.vtu"), "not a finite number"),
        (data("1e999", "a.vtu"), "not a finite number"),
        (data("soon", "a.vtu"), "timestep is 'soon'"),
        (
            a.clone() + "<DataSet file=\"b.vtu\"/>",
            "'b.vtu' has no timestep",
        ),
        (
            a.clone() + "<DataSet timestep=\"1\"/>",
            "an entry without a file",
        ),
        (data("0", "&long;"), "an attribute of <DataSet> is damaged"),
        ("<DataSet timestep=\"0".into(), "XML is damaged"),
        (a + "</Collection>", "XML is damaged"),
    ] {
        let error = read_as(&folder, "x.pvd", pvd(&entries)).expect_err(words);
        assert!(matches!(error, Error::Format { .. }), "{error}");
        assert!(error.to_string().contains(words), "{error}");
    }
    for (text, words) in [
        ("", "the file is empty"),
        (
            "<VTKFile type=\"UnstructuredGrid\"></VTKFile>",
            "no <Collection>",
        ),
        (
            "<VTKFile><Collection></Collection>",
            "ends before </VTKFile>",
        ),
        (
            "<!DOCTYPE x [<!ENTITY a \"aa\">]><VTKFile><Collection/></VTKFile>",
            "document type",
        ),
        ("\u{1b}[31m", "no <Collection>"),
    ] {
        let error = read_as(&folder, "x.pvd", text)
            .expect_err(words)
            .to_string();
        assert!(error.contains(words), "{error}");
    }
    for (text, words) in [
        ("", "the file is empty"),
        ("[", "the JSON is damaged"),
        ("[]", "no list \"files\""),
        ("{\"files\": 3}", "no list \"files\""),
        ("{\"files\": []}", "lists no file"),
        ("{\"files\": [3]}", "an entry without a name"),
        (
            "{\"files\": [{\"name\": \"a.vtu\", \"time\": \"x\"}]}",
            "is not a number",
        ),
        (
            "{\"files\": [{\"name\": \"a.vtu\", \"time\": 1e999}]}",
            "JSON is damaged",
        ),
        (
            "{\"files\": [{\"name\": \"a.vtu\", \"time\": 1}, {\"name\": \"b.vtu\"}]}",
            "has no time",
        ),
        (
            "{\"files\": [{\"name\": \"a.vtu.series\"}]}",
            "lists other files",
        ),
        (
            "{\"files\": [{\"name\": \"c\\u001b[31m.vtu\"}]}",
            "c\\u{1b}[31m.vtu' is not there",
        ),
        (
            "{\"file-series-version\": \"2.0\", \"files\": []}",
            "version \"2.0\"",
        ),
    ] {
        let error = read_as(&folder, "x.series", text)
            .expect_err(words)
            .to_string();
        assert!(error.contains(words), "{error}");
    }
    let deep = "[".repeat(1 << 20);
    read_as(&folder, "x.series", deep).expect_err("too deep");
}

#[test]
fn a_collection_is_read_to_a_bound() {
    let folder = folder(&[]);
    let long = vec![b' '; MAX_COLLECTION_BYTES as usize + 1];
    for name in ["x.pvd", "x.series"] {
        let error = read_as(&folder, name, &long)
            .expect_err("too long")
            .to_string();
        assert!(error.contains("more than 4194304 bytes"), "{error}");
    }
}
