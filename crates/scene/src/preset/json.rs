//! ParaView's JSON presets: a list of objects, of which each is a preset.
//!
//! | key | meaning |
//! |---|---|
//! | `Name` | what it is called |
//! | `ColorSpace` | RGB, HSV, Lab, Diverging or Step; others are refused |
//! | `RGBPoints` | scalar, red, green, blue, again and again; sRGB from 0 to 1 |
//! | `Points` | scalar, opacity, midpoint, sharpness, again and again |
//!
//! Colors by category and scalars on a logarithmic scale are refused. What else changes a picture
//! in ParaView and none of ours is said.

use serde_json::{Map, Value, json};
use tetrascope_core::{Error, text};

use super::{ColorPoint, ColorSpace, MAX_PRESET_POINTS, OpacityPoint, Preset, wrong};
use crate::MAX_SCENE_BYTES;

/// A preset from a file, and what of the file is not in it.
#[derive(Clone, Debug, PartialEq)]
pub struct ReadPreset {
    /// The preset.
    pub preset: Preset,
    /// Whether the file has opacities; without, they rise from 0 to 1 over its range.
    pub has_opacities: bool,
    /// The parts that were passed over, a sentence each.
    pub notes: Vec<String>,
}

/// Keys that change nothing here.
const HARMLESS: [&str; 11] = [
    "Name",
    "ColorSpace",
    "RGBPoints",
    "Points",
    "Creator",
    "License",
    "Source",
    "DefaultMap",
    "Category",
    "Groups",
    "Description",
];

impl Preset {
    /// Reads a ParaView preset; of a list, the first.
    ///
    /// # Errors
    /// [`Error::Invalid`] for text that is not a preset, for a color space that is not honored, for
    /// categories and logarithmic scales, and for more points than [`MAX_PRESET_POINTS`].
    pub fn from_json(json: &str) -> Result<ReadPreset, Error> {
        if json.len() as u64 > MAX_SCENE_BYTES {
            return Err(wrong(
                format!("a preset of {} bytes", json.len()),
                "presets have at most 1 MiB",
            ));
        }
        let value: Value = serde_json::from_str(json).map_err(|error| {
            wrong(
                format!("the preset is not JSON: {error}"),
                "export one in ParaView's color map editor, as JSON",
            )
        })?;
        let mut notes = Vec::new();
        let object = match &value {
            Value::Array(list) => {
                if list.len() > 1 {
                    let count = list.len();
                    notes.push(format!(
                        "the file holds {count} presets; the first is taken"
                    ));
                }
                list.first()
            }
            other => Some(other),
        };
        let Some(object) = object.and_then(Value::as_object) else {
            return Err(wrong(
                "the JSON holds no preset".into(),
                "a preset is an object with `RGBPoints`, or a list of such objects",
            ));
        };
        let color_space = color_space(object)?;
        refuse_what_is_not_drawn(object)?;
        let mut colors = colors(object)?;
        colors.sort_by(|a, b| a.scalar.total_cmp(&b.scalar));
        let mut opacities = opacities(object)?;
        opacities.sort_by(|a, b| a.scalar.total_cmp(&b.scalar));
        let has_opacities = !opacities.is_empty();
        if !has_opacities {
            notes.push("the preset has no opacities: they rise from 0 to 1 over its range".into());
            let (low, high) = (colors[0].scalar, colors[colors.len() - 1].scalar);
            opacities = match low < high {
                true => vec![OpacityPoint::new(low, 0.0), OpacityPoint::new(high, 1.0)],
                false => vec![OpacityPoint::new(low, 0.5)],
            };
        }
        if object.contains_key("NanColor") {
            notes.push("`NanColor` is passed over: what has no value is transparent".into());
        }
        let others = object
            .keys()
            .filter(|key| !HARMLESS.contains(&key.as_str()) && key.as_str() != "NanColor");
        let others: Vec<String> = others
            .take(8)
            .map(|key| text::name(key).into_owned())
            .collect();
        if !others.is_empty() {
            notes.push(format!("these keys are passed over: {}", others.join(", ")));
        }
        let name = object
            .get("Name")
            .and_then(Value::as_str)
            .unwrap_or("preset");
        let preset = Preset {
            name: text::name(name).into_owned(),
            color_space,
            colors,
            opacities,
        };
        preset.validate()?;
        Ok(ReadPreset {
            preset,
            has_opacities,
            notes,
        })
    }

    /// The preset as ParaView reads it.
    pub fn to_json(&self) -> String {
        let colors = self.colors.iter();
        let colors = colors.flat_map(|p| [p.scalar, p.color[0], p.color[1], p.color[2]]);
        let opacities = self.opacities.iter();
        let opacities = opacities.flat_map(|p| [p.scalar, p.opacity, p.midpoint, p.sharpness]);
        let preset = json!([{
            "Name": self.name,
            "Creator": "tetrascope",
            "ColorSpace": self.color_space.name(),
            "RGBPoints": colors.collect::<Vec<f64>>(),
            "Points": opacities.collect::<Vec<f64>>(),
        }]);
        format!("{preset:#}\n")
    }
}

fn color_space(object: &Map<String, Value>) -> Result<ColorSpace, Error> {
    let name = match object.get("ColorSpace") {
        None => return Ok(ColorSpace::Rgb),
        Some(name) => name.as_str().unwrap_or_default(),
    };
    let name = if name == "CIELAB" { "Lab" } else { name };
    let found = ColorSpace::ALL
        .into_iter()
        .find(|space| space.name() == name);
    found.ok_or_else(|| {
        let names = ColorSpace::ALL.map(ColorSpace::name).join(", ");
        wrong(
            format!(
                "colors in the space '{}' are not interpolated",
                text::name(name)
            ),
            &format!("choose one of {names} in ParaView, or export more points in RGB"),
        )
    })
}

fn refuse_what_is_not_drawn(object: &Map<String, Value>) -> Result<(), Error> {
    let is_on = |key: &str| {
        let value = object.get(key);
        value.is_some_and(|v| v.as_bool() == Some(true) || v.as_f64().is_some_and(|n| n != 0.0))
    };
    if object.contains_key("IndexedColors") && !object.contains_key("RGBPoints") {
        return Err(wrong(
            "the preset colors categories, not a scalar".into(),
            "export a preset with `RGBPoints`",
        ));
    }
    for (key, what) in [
        ("UseLogScale", "scalars on a logarithmic scale"),
        ("IndexedLookup", "categories"),
        ("UseAboveRangeColor", "another color above the range"),
        ("UseBelowRangeColor", "another color below the range"),
    ] {
        if is_on(key) {
            return Err(wrong(
                format!("the preset has {what}, which is not drawn"),
                &format!("turn `{key}` off in ParaView"),
            ));
        }
    }
    Ok(())
}

fn colors(object: &Map<String, Value>) -> Result<Vec<ColorPoint>, Error> {
    let points = fours(object, "RGBPoints")?;
    if points.is_empty() {
        return Err(wrong(
            "the preset has no `RGBPoints`".into(),
            "export one in ParaView's color map editor, as JSON",
        ));
    }
    let points = points.into_iter();
    Ok(points
        .map(|[scalar, color @ ..]| ColorPoint { scalar, color })
        .collect())
}

fn opacities(object: &Map<String, Value>) -> Result<Vec<OpacityPoint>, Error> {
    let points = fours(object, "Points")?.into_iter();
    let point = |[scalar, opacity, midpoint, sharpness]: [f64; 4]| OpacityPoint {
        scalar,
        opacity,
        midpoint,
        sharpness,
    };
    Ok(points.map(point).collect())
}

/// The numbers under a key, four by four; none without the key.
fn fours(object: &Map<String, Value>, key: &str) -> Result<Vec<[f64; 4]>, Error> {
    let list = match object.get(key) {
        None | Some(Value::Null) => return Ok(Vec::new()),
        Some(Value::Array(list)) => list,
        Some(_) => return Err(wrong(format!("`{key}` is not a list"), "give numbers")),
    };
    if !list.len().is_multiple_of(4) || list.len() > 4 * MAX_PRESET_POINTS {
        return Err(wrong(
            format!("`{key}` has {} numbers", list.len()),
            "there are four for each point, and fewer than 4096 points",
        ));
    }
    let number = |value: &Value| value.as_f64().filter(|n| n.is_finite());
    let four = |(i, four): (usize, &[Value])| {
        let numbers: Option<Vec<f64>> = four.iter().map(number).collect();
        let numbers = numbers.and_then(|n| <[f64; 4]>::try_from(n).ok());
        numbers.ok_or_else(|| {
            let what = format!("point {i} of `{key}` is not four finite numbers");
            wrong(what, "give numbers")
        })
    };
    list.chunks(4).enumerate().map(four).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    // In the form in which ParaView exports a preset with its opacities.
    const EXPORTED: &str = r#"[
        {
            "ColorSpace": "Diverging",
            "Creator": "someone",
            "DefaultMap": true,
            "Name": "Preset",
            "NanColor": [1.0, 1.0, 0.0],
            "Points": [10.0, 0.0, 0.5, 0.0, 37.5, 0.4, 0.25, 0.6, 276.83, 1.0, 0.5, 0.0],
            "RGBPoints": [10.0, 0.231373, 0.298039, 0.752941, 143.4, 0.865, 0.865, 0.865,
                          276.83, 0.705882, 0.0156863, 0.14902]
        }
    ]"#;

    #[test]
    fn an_exported_preset_is_read_and_written_as_it_was() {
        let read = Preset::from_json(EXPORTED).expect("a preset");
        assert!(read.has_opacities);
        let preset = &read.preset;
        assert_eq!((preset.colors.len(), preset.opacities.len()), (3, 3));
        assert_eq!(preset.color_space, ColorSpace::Diverging);
        assert_eq!(
            (preset.opacities[1].midpoint, preset.opacities[1].sharpness),
            (0.25, 0.6)
        );
        assert!(
            read.notes.iter().any(|n| n.contains("NanColor")),
            "{:?}",
            read.notes
        );
        let again = Preset::from_json(&preset.to_json()).expect("our own");
        assert_eq!(again.preset, *preset);
        assert!(again.notes.is_empty(), "{:?}", again.notes);
        assert!(preset.transfer_function(1.0).is_ok());
    }

    #[test]
    fn nothing_is_passed_over_in_silence() {
        let with = |key: &str, value: &str| {
            EXPORTED.replacen("\"DefaultMap\": true", &format!("{key}: {value}"), 1)
        };
        for (key, value) in [
            ("\"UseLogScale\"", "1"),
            ("\"UseAboveRangeColor\"", "true"),
            ("\"IndexedLookup\"", "1"),
        ] {
            let error = Preset::from_json(&with(key, value)).expect_err("not drawn");
            assert!(
                error.help().is_some_and(|h| h.contains("ParaView")),
                "{error}"
            );
        }
        let read = Preset::from_json(&with("\"Shine\"", "1")).expect("a preset");
        assert!(
            read.notes.iter().any(|n| n.contains("Shine")),
            "{:?}",
            read.notes
        );
        for space in ["Lab/CIEDE2000", "Prolab", "", "rgb"] {
            let text = EXPORTED.replacen("Diverging", space, 1);
            let error = Preset::from_json(&text)
                .expect_err("another space")
                .to_string();
            assert!(error.contains("space"), "{error}");
        }
        assert!(Preset::from_json(&EXPORTED.replacen("Diverging", "CIELAB", 1)).is_ok());
    }

    #[test]
    fn what_is_no_preset_is_refused_in_a_line() {
        let many = format!("[{{\"RGBPoints\": [{}]}}]", vec!["0"; 20_000].join(","));
        let long = " ".repeat(2 << 20);
        for wrong in [
            "",
            "{",
            "[]",
            "7",
            "[[]]",
            "{}",
            "{\"RGBPoints\": []}",
            "{\"RGBPoints\": [1, 2, 3]}",
            "{\"RGBPoints\": [0, 0, 0, \"0\"]}",
            "{\"RGBPoints\": [0, 0, 0, 7]}",
            "{\"RGBPoints\": [1e999, 0, 0, 0]}",
            "{\"RGBPoints\": {}}",
            "{\"RGBPoints\": [0, 0, 0, 0], \"Points\": [0, 2, 0.5, 0]}",
            "{\"RGBPoints\": [0, 0, 0, 0], \"Points\": [0, 1]}",
            "{\"IndexedColors\": [1, 0, 0]}",
            &many,
            &long,
        ] {
            let error = Preset::from_json(wrong).expect_err("no preset");
            assert!(
                !error.to_string().contains('\n') && error.help().is_some(),
                "{error}"
            );
        }
        // Nested deeper than a stack holds.
        assert!(Preset::from_json(&"[".repeat(100_000)).is_err());
    }

    #[test]
    fn points_in_any_order_are_sorted_and_colors_alone_are_enough() {
        let read = Preset::from_json("{\"RGBPoints\": [5, 1, 1, 1, 2, 0, 0, 0]}");
        let read = read.expect("a preset");
        assert!(!read.has_opacities);
        let preset = read.preset;
        assert_eq!(preset.range(), (2.0, 5.0));
        assert_eq!(
            preset.opacities,
            [OpacityPoint::new(2.0, 0.0), OpacityPoint::new(5.0, 1.0)]
        );
    }
}
