//! How to help, in the words of the command line.

use tetrascope_core::{Error, text};
use tetrascope_scene::nearest;

/// The spellings of a library's hints at the command line.
const SPELLINGS: [(&str, &str); 21] = [
    ("`dims` and `type`", "--dims 256x256x128 --type u8"),
    ("leave out `solution`", "leave out --solution"),
    ("`solution`", "--solution FILE"),
    ("allow more `memory`", "allow more --memory"),
    (
        "draw it as a series",
        "draw it as a series with `tetrascope render FILE -o frame_%04d.png`",
    ),
    (
        "the list of formats has all",
        "`tetrascope formats` lists all",
    ),
    (
        "draw it as it is",
        "draw it as it is with `tetrascope render`",
    ),
    ("`scene`", "--scene"),
    ("`clip_planes`", "--clip"),
    (
        "choose another field",
        "choose another field with --field; `tetrascope info` lists them",
    ),
    (
        "let the camera fit the volume",
        "let the camera fit the volume with --camera fit+iso",
    ),
    (
        "start from a complete scene",
        "`tetrascope print-scene sphere` prints a complete scene to start from",
    ),
    (
        "look at what the file holds",
        "`tetrascope info` lists what the file holds",
    ),
    (
        "give a value in between",
        "give a value in between, for example with --isovalue",
    ),
    (
        "add a `file` or a `dataset`",
        "add file or dataset under [volume], or name one on the command line",
    ),
    ("the `camera` fit+iso", "--camera fit+iso"),
    ("`camera`", "--camera"),
    ("`unit_distance`", "--unit-distance"),
    ("`range`", "--range"),
    ("`background`", "--background"),
    ("`colormap`", "--colormap"),
];

/// The hint for a person at the command line about `error`, one line.
pub fn help(error: &Error) -> Option<String> {
    match error {
        Error::NoSuchField { name, available } => {
            let names: Vec<&str> = available.iter().map(|field| bare(field)).collect();
            let example = nearest(name, &names).or(names.first().copied())?;
            let example = text::name(example);
            Some(format!(
                "choose one with --field, for example --field '{example}'"
            ))
        }
        Error::Unknown { name, valid, .. } => {
            let meant = text::name(nearest(name, valid)?);
            Some(format!("did you mean '{meant}'?"))
        }
        Error::TooLarge { .. } | Error::OutOfMemory { .. } => Some(
            "ask for a smaller image or mesh, or fewer samples; `render --algorithm reference` needs no GPU"
                .into(),
        ),
        Error::Unsupported { .. } => {
            Some("`tetrascope algorithms` lists what each algorithm draws".into())
        }
        error => Some(spelled(error.help()?)),
    }
}

fn spelled(help: String) -> String {
    SPELLINGS
        .iter()
        .fold(help, |help, (neutral, ours)| help.replace(neutral, ours))
}

/// The name in "name [0, 1]".
fn bare(field: &str) -> &str {
    field.split(" [").next().unwrap_or(field)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_misspelt_name_is_corrected() {
        let unknown = Error::Unknown {
            kind: "data set",
            name: "orbitla".into(),
            valid: ["sphere", "orbital"].map(String::from).to_vec(),
        };
        assert_eq!(help(&unknown).as_deref(), Some("did you mean 'orbital'?"));
        let field = |name: &str, available: &[&str]| {
            help(&Error::NoSuchField {
                name: name.into(),
                available: available.iter().map(|&field| field.into()).collect(),
            })
        };
        let near = field("presure", &["T [0, 1] (points)", "pressure [2, 3] (cells)"]);
        assert!(near.is_some_and(|help| help.ends_with("--field 'pressure'")));
        let first = field("x", &["T [0, 1] (points)", "pressure [2, 3] (cells)"]);
        assert!(first.is_some_and(|help| help.ends_with("--field 'T'")));
        assert_eq!(field("x", &[]), None);
    }

    #[test]
    fn parameters_are_spelled_as_options() {
        let spelled = |help: &str| spelled(help.into());
        assert_eq!(
            spelled("give the grid's file first and this one with `solution`"),
            "give the grid's file first and this one with --solution FILE"
        );
        assert_eq!(
            spelled("give `dims` and `type`"),
            "give --dims 256x256x128 --type u8"
        );
        assert_eq!(spelled("add `alpha`"), "add `alpha`");
    }
}
