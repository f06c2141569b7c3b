//! The steps of a series: which files, in which order.

use std::collections::HashSet;
use std::path::{Path, PathBuf};

use tetrascope::core::Error;
use tetrascope::io::{Step, is_collection, read_collection, read_steps};
use tetrascope::scene::VolumeSource;

use super::frame_name::FrameName;
use super::{natural, pattern};
use crate::args::RenderArgs;

/// The steps of a series, at least one.
pub(crate) struct Steps {
    pub(crate) list: Vec<Step>,
    /// Whether several files are named in another order than that of their numbers.
    pub(crate) is_shuffled: bool,
}

impl Steps {
    /// The series that `render` is asked for; `None` if that is one volume.
    ///
    /// One file is a series if its frame is to have a number: of its own time steps, if it holds
    /// several and none is chosen; or a shell may have found one alone where it looked for several.
    pub(crate) fn find_for(args: &RenderArgs) -> Result<Option<Steps>, Error> {
        if let Some(steps) = Steps::find(&args.scene.volume)? {
            return Ok(Some(steps));
        }
        let is_numbered = |path: &PathBuf| FrameName::parse(path).is_ok();
        let series = &args.series;
        let is_asked = series.resume || series.each_step || series.steps.is_some();
        if let [file] = args.scene.volume.as_slice()
            && file.is_file()
            && (is_asked || args.output.as_ref().is_some_and(is_numbered))
        {
            let options = &args.scene.options;
            let times = match (options.source.step, options.source.time) {
                // Reading the file says what is wrong with it.
                (None, None) => read_steps(file).unwrap_or_default(),
                _ => Vec::new(),
            };
            if times.len() > 1 {
                return Ok(Some(Steps::within(file, times)));
            }
            if args.output.as_ref().is_some_and(is_numbered) {
                return Ok(Some(Steps::of_files(vec![file.clone()])?));
            }
        }
        if is_asked {
            return Err(Error::Usage {
                what: "--resume, --steps and --each-step are for a series of files".into(),
                help: Some(
                    "name several files, a quoted pattern, a .pvd or .series file, or a file with several time steps".into(),
                ),
            });
        }
        Ok(None)
    }

    /// The series that words on the command line stand for; `None` if they are one volume.
    pub(crate) fn find(words: &[PathBuf]) -> Result<Option<Steps>, Error> {
        if let [word] = words {
            if pattern::is_pattern(word) {
                return Steps::of_files(pattern::expand(word)?).map(Some);
            }
            if !is_collection(word) {
                return Ok(None);
            }
            return Ok(Some(Steps {
                list: read_collection(word)?,
                is_shuffled: false,
            }));
        }
        if words.is_empty() {
            return Ok(None);
        }
        let mut files = Vec::new();
        for word in words {
            match pattern::is_pattern(word) {
                true => files.extend(pattern::expand(word)?),
                false => files.push(word.clone()),
            }
        }
        Steps::of_files(files).map(Some)
    }

    /// The time steps of one file.
    pub(crate) fn within(file: &Path, times: Vec<f64>) -> Steps {
        let step = |(number, time)| Step {
            file: file.to_owned(),
            time: Some(time),
            number: Some(number),
        };
        Steps {
            list: times.into_iter().enumerate().map(step).collect(),
            is_shuffled: false,
        }
    }

    fn of_files(files: Vec<PathBuf>) -> Result<Steps, Error> {
        let mut known = HashSet::new();
        for file in &files {
            if is_collection(file) {
                return Err(Error::Usage {
                    what: format!("'{}' is a series of its own", file.display()),
                    help: Some("name it alone".into()),
                });
            }
            if !known.insert(file) {
                return Err(Error::Usage {
                    what: format!("'{}' is named twice", file.display()),
                    help: None,
                });
            }
            if let Err(source) = std::fs::metadata(file) {
                return Err(Error::Io {
                    action: "cannot open",
                    path: file.clone(),
                    source,
                });
            }
        }
        let names: Vec<_> = files.iter().map(|file| file.to_string_lossy()).collect();
        let is_shuffled = {
            let mut pairs = names.windows(2);
            let order = |pair: &[std::borrow::Cow<str>]| natural::compare(&pair[0], &pair[1]);
            let first = pairs.next().map(order);
            // Backwards is on purpose.
            pairs.any(|pair| Some(order(pair)) != first)
        };
        let step = |file| Step {
            file,
            time: None,
            number: None,
        };
        Ok(Steps {
            list: files.into_iter().map(step).collect(),
            is_shuffled,
        })
    }

    /// The first step.
    pub(crate) fn first(&self) -> &Step {
        &self.list[0]
    }

    /// The numbers of the steps to draw: those from the first to the last of `range`.
    pub(crate) fn numbers(&self, range: Option<(usize, usize)>) -> Result<Vec<usize>, Error> {
        let (first, last) = range.unwrap_or((0, usize::MAX));
        let count = self.list.len();
        let end = count - 1;
        if first > end || (last > end && last != usize::MAX) {
            return Err(Error::Usage {
                what: format!("there are {count} steps, 0 to {end}"),
                help: Some(format!("give --steps {}..{end}", first.min(end))),
            });
        }
        Ok((first..=last.min(end)).collect())
    }
}

/// Makes `step` what `source` names.
pub(crate) fn choose(source: &mut VolumeSource, step: &Step) {
    source.file = Some(step.file.clone());
    if step.number.is_some() {
        source.step = step.number;
    }
}

/// A step in words: its file and its time.
pub(crate) fn describe(step: &Step) -> String {
    let file = step.file.display();
    match step.time {
        Some(time) => format!("{file}, time {time}"),
        None => file.to_string(),
    }
}

/// The name of the frames of a series, which must be given.
pub(crate) fn frame_name(output: Option<&Path>) -> Result<FrameName, Error> {
    match output {
        Some(path) => FrameName::parse(path),
        None => Err(Error::Usage {
            what: "the frames of a series need a name with a number".into(),
            help: Some("give -o frame_%04d.png".into()),
        }),
    }
}
