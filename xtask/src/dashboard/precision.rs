//! The work-precision diagrams of the last `cargo xtask compare`, from its `report.json`.

use std::path::Path;

use serde::Serialize;
use tetrascope::core::Error;

use crate::diagrams::{Diagrams, LegendItem};
use crate::report::Report;

/// All diagrams, and what they are of.
#[derive(Debug, Serialize)]
pub struct Precision {
    /// The git revision that was compared.
    pub revision: Option<String>,
    /// When, in UTC.
    pub date: String,
    /// The graphics adapter.
    pub adapter: Option<String>,
    /// Every algorithm that is drawn.
    pub legend: Vec<LegendItem>,
    /// By scene: its name and its diagrams.
    pub scenes: Vec<(String, Diagrams)>,
}

/// The diagrams of a report; `None` where there is no such file or nothing that can be compared.
///
/// # Errors
/// A file that cannot be read or is not a report of this version.
pub fn read(path: &Path) -> Result<Option<Precision>, Error> {
    let bytes = match std::fs::read(path) {
        Ok(bytes) => bytes,
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => return Ok(None),
        Err(source) => {
            return Err(Error::Io {
                action: "cannot read",
                path: path.into(),
                source,
            });
        }
    };
    let report = Report::from_json(&bytes).map_err(|what| Error::Format {
        path: path.into(),
        at: "its beginning".into(),
        what,
        help: Some("run `cargo xtask compare` again, or delete the file".into()),
    })?;
    Ok(of(report))
}

fn of(report: Report) -> Option<Precision> {
    let scenes = report.scenes.iter();
    let scenes = scenes.filter_map(|scene| Some((scene.name.clone(), Diagrams::of(scene)?)));
    let scenes: Vec<(String, Diagrams)> = scenes.collect();
    let mut names: Vec<&str> = Vec::new();
    for item in scenes.iter().flat_map(|(_, diagrams)| &diagrams.legend) {
        if !names.contains(&item.name.as_str()) {
            names.push(&item.name);
        }
    }
    let legend = names.into_iter().map(LegendItem::of).collect();
    (!scenes.is_empty()).then_some(Precision {
        revision: report.program.revision,
        date: report.program.started,
        adapter: report.machine.adapter,
        legend,
        scenes,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::tests::report;

    #[test]
    fn a_report_becomes_diagrams() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let path = folder.path().join("report.json");
        assert!(read(&path).expect("no file is no error").is_none());
        std::fs::write(&path, report("<ball>").to_json()).expect("written");
        let precision = read(&path)
            .expect("a report")
            .expect("a picture is compared");
        assert_eq!(precision.legend.len(), 1);
        assert_eq!(precision.legend[0].name, "projection");
        let (scene, diagrams) = &precision.scenes[0];
        assert_eq!((scene.as_str(), diagrams.time.len()), ("<ball>", 1));
        let svg = &diagrams.time[0].1;
        assert!(svg.contains("projection centroid: RMSE 1.50e-4") && svg.contains("&lt;ball&gt;"));
    }

    #[test]
    fn what_is_no_report_says_how_to_make_one() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let path = folder.path().join("report.json");
        std::fs::write(&path, "{}").expect("written");
        let error = read(&path).expect_err("no report");
        assert!(error.to_string().contains("not a report"), "{error}");
        assert!(error.help().is_some_and(|help| help.contains("compare")));
    }
}
