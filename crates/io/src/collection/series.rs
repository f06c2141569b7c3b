//! `.series`: JSON, `{"file-series-version": "1.0", "files": [{"name": …, "time": …}, …]}`.

use serde_json::Value;
use tetrascope_core::Error;

use super::Entry;
use crate::source::Source;

pub(super) fn parse(source: &Source) -> Result<Vec<Entry>, Error> {
    let bytes = source.bytes.as_slice();
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    let value: Value = serde_json::from_slice(bytes).map_err(|error| {
        let message = error.to_string();
        let what = message.split(" at line").next().unwrap_or_default();
        source.error(
            format!("line {}, column {}", error.line(), error.column()),
            format!("the JSON is damaged: {what}"),
        )
    })?;
    if let Some(version) = value.get("file-series-version")
        && !version.as_str().is_some_and(|v| v.starts_with("1."))
    {
        return Err(source.error(
            "file-series-version",
            format!("version {version} of a series is not read: 1.0 is"),
        ));
    }
    let files = value.get("files").and_then(Value::as_array);
    let files = files.ok_or_else(|| source.error("", "there is no list \"files\""))?;
    let entry = |(i, file): (usize, &Value)| {
        let at = format!("files[{i}]");
        let name = file.get("name").and_then(Value::as_str);
        let name = name.ok_or_else(|| source.error(at.clone(), "an entry without a name"))?;
        let time = match file.get("time") {
            None => None,
            Some(time) => Some(time.as_f64().ok_or_else(|| {
                source.error(at.clone(), format!("the time of '{name}' is not a number"))
            })?),
        };
        Ok(Entry {
            name: name.into(),
            time,
            at,
        })
    };
    files.iter().enumerate().map(entry).collect()
}
