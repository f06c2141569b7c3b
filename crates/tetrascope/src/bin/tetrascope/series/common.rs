//! The parts that all frames of a series share: one scene, and one field under one name.

use tetrascope::core::{Error, Volume};
use tetrascope::io::Step;
use tetrascope::scene::{Scene, Survey, VolumeSource};
use tetrascope::volumes::{self, FieldSummary, Loaded};

use super::steps::{choose, describe};
use super::{Steps, at};
use crate::output::{Output, Stop};
use crate::scene::Request;

/// The facts that are found once, from all steps.
pub(crate) struct Common {
    /// The scene of the first step; that of another has its file and its number.
    pub(crate) scene: Scene,
    field: Field,
}

/// The field that is drawn.
struct Field {
    /// The field's name in the first step's file, which is meant for all others.
    name: String,
    /// A number of the file is a value and this.
    offset: f64,
}

impl Common {
    /// Reads every step, or the first alone if nothing is to be chosen from them; prints what
    /// was chosen.
    pub(crate) fn find(request: &Request, steps: &Steps, output: &Output) -> Result<Common, Stop> {
        let first = steps.first();
        if request.file.is_complete() {
            let (loaded, _) = request.load(output).map_err(at(first, None))?;
            let mut scene = request.resolve(&loaded.volume, output)?;
            let field = Field::of(&loaded);
            scene.source.field = Some(field.name.clone());
            return Ok(Common { scene, field });
        }
        let count = steps.list.len();
        let watch = output.watch(count);
        let all = match count {
            1 => "1 step".into(),
            _ => format!("{count} steps"),
        };
        watch.line(format_args!("reading {all} for what frames share"));
        let mut survey = Survey::new(&request.file);
        let mut source = request.file.volume.clone();
        let mut field: Option<Field> = None;
        let mut previous: Option<Volume> = None;
        for (number, step) in steps.list.iter().enumerate() {
            watch.begin(&format!("reading {}", describe(step)));
            choose(&mut source, step);
            let loaded =
                load(&source, previous.take().as_ref(), field.as_ref()).map_err(at(step, None))?;
            watch.detail(format_args!(
                "  {number}: {}, {}",
                step.file.display(),
                loaded.description
            ));
            for note in &loaded.notes {
                match number {
                    0 => watch.note(format_args!("  {note}")),
                    _ => watch.detail(format_args!("    {note}")),
                }
            }
            let field = field.get_or_insert_with(|| Field::of(&loaded));
            source.field = Some(field.name.clone());
            survey.add(&loaded.volume);
            previous = Some(loaded.volume);
            watch.end();
        }
        drop(watch);
        let resolved = request.file.resolve_for_all(&survey);
        let mut scene = request.complete(resolved)?;
        scene.source = source;
        choose(&mut scene.source, first);
        let field = field.expect("there is a step");
        output.note(format_args!("  field '{}' of {all}", field.name));
        for line in &scene.defaults {
            output.note(format_args!("  {line}"));
        }
        Ok(Common { scene, field })
    }

    /// The scene of a step.
    pub(crate) fn scene_of(&self, step: &Step) -> Scene {
        let mut scene = self.scene.clone();
        choose(&mut scene.source, step);
        scene
    }

    /// Loads a step with the field of the series.
    pub(crate) fn load(
        &self,
        source: &VolumeSource,
        previous: Option<&Volume>,
    ) -> Result<Loaded, Error> {
        load(source, previous, Some(&self.field))
    }
}

impl Field {
    fn of(loaded: &Loaded) -> Field {
        let drawn = |field: &&FieldSummary| field.drawn;
        let drawn = loaded.fields.iter().find(drawn);
        let twins = loaded.fields.iter().filter(|f| f.name == loaded.field);
        Field {
            name: match drawn {
                Some(drawn) if twins.count() > 1 => {
                    format!("{}:{}", drawn.association, drawn.name)
                }
                _ => loaded.field.clone(),
            },
            offset: drawn.map_or(0.0, |drawn| drawn.offset),
        }
    }
}

/// Loads a step of which values must mean the same as in those before it.
fn load(
    source: &VolumeSource,
    previous: Option<&Volume>,
    field: Option<&Field>,
) -> Result<Loaded, Error> {
    let loaded = volumes::load_step(source, previous)?;
    if let Some(field) = field {
        let offset = Field::of(&loaded).offset;
        if offset != field.offset {
            return Err(Error::Invalid {
                what: format!(
                    "values are kept less {offset} to keep their digits, and those of the first step less {}",
                    field.offset
                ),
                help: Some("draw each step in a scene of its own with --each-step".into()),
            });
        }
    }
    Ok(loaded)
}
