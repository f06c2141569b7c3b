//! `.pvd`: a VTK XML file of the type `Collection`, with a `DataSet` element for each file.

use quick_xml::Reader;
use quick_xml::events::Event;
use tetrascope_core::Error;

use super::Entry;
use crate::source::Source;
use crate::vtu::{attributes, line, to_utf8};

pub(super) fn parse(source: Source) -> Result<Vec<Entry>, Error> {
    let source = to_utf8(source)?;
    let text = String::from_utf8_lossy(&source.bytes);
    let mut reader = Reader::from_str(&text);
    let mut entries = Vec::new();
    let (mut is_collection, mut is_whole) = (false, false);
    loop {
        let place = reader.buffer_position() as usize;
        let event = reader.read_event().map_err(|error| {
            source.error(
                line(&text, reader.error_position() as usize),
                format!("the XML is damaged: {error}"),
            )
        })?;
        match event {
            Event::Start(element) | Event::Empty(element) => {
                let name = element.local_name();
                if name.as_ref() == "Collection" {
                    is_collection = true;
                }
                if name.as_ref() != "DataSet" {
                    continue;
                }
                let mut attributes = attributes(&source, &element, place)?;
                let at = line(&text, place);
                let time = match attributes.get("timestep") {
                    Some(time) => Some(time.trim().parse().map_err(|_| {
                        source.error(at.clone(), format!("timestep is '{time}', not a number"))
                    })?),
                    None => None,
                };
                let name = attributes.remove("file").unwrap_or_default();
                entries.push(Entry { name, time, at });
            }
            // A collection needs none, and entities are made in one.
            Event::DocType(_) => {
                let what = "the XML has a document type, which is not read";
                return Err(source.error(line(&text, place), what));
            }
            Event::End(element) => is_whole |= element.local_name().as_ref() == "VTKFile",
            Event::Eof => break,
            _ => {}
        }
    }
    if !is_collection {
        return Err(source.error("", "there is no <Collection> element"));
    }
    if !is_whole {
        return Err(source.error_with_help(
            format!("byte {}", text.len()),
            "the file ends before </VTKFile>",
            "the file is truncated; copy or write it again",
        ));
    }
    if let (Some(entry), true) = (entries.iter().find(|e| e.time.is_none()), entries.len() > 1) {
        return Err(source.error(
            entry.at.clone(),
            format!("'{}' has no timestep", entry.name),
        ));
    }
    Ok(entries)
}
