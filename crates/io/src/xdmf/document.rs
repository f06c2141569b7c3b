//! The elements of a file, and the few forms of XPath that writers of XDMF use.

use std::cell::Cell;
use std::sync::Arc;

use quick_xml::Reader;
use quick_xml::events::{BytesStart, Event};
use tetrascope_core::Error;

use crate::grid::header::clip;
use crate::source::Source;
use crate::vtu::{attributes, line};

/// Elements of a file.
const MOST_ELEMENTS: usize = 1 << 19;

/// Elements in each other.
const MOST_DEPTH: usize = 64;

/// Elements that all paths together may visit.
const MOST_VISITS: u64 = 1 << 28;

/// An element by its number in the file.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) struct Id(usize);

struct Element {
    name: Box<str>,
    /// Keys in lower case.
    attributes: crate::vtu::Attributes,
    children: Vec<Id>,
    /// Where its own text is.
    text: std::ops::Range<usize>,
    /// Where it begins.
    place: usize,
}

/// A file.
pub(super) struct Document {
    pub(super) source: Arc<Source>,
    elements: Vec<Element>,
    visits: Cell<u64>,
}

impl Document {
    pub(super) fn parse(source: Source) -> Result<Document, Error> {
        let mut document = Document {
            source: Arc::new(source),
            elements: Vec::new(),
            visits: Cell::new(0),
        };
        let source = document.source.clone();
        let text = std::str::from_utf8(&source.bytes).map_err(|error| {
            source.error(
                format!("byte {}", error.valid_up_to()),
                "the XML is not UTF-8 text",
            )
        })?;
        document.read(text)?;
        let is_xdmf = document
            .elements
            .first()
            .is_some_and(|root| &*root.name == "Xdmf");
        match is_xdmf {
            true => Ok(document),
            false => Err(source.error("byte 0", "the first element is not <Xdmf>")),
        }
    }

    fn read(&mut self, text: &str) -> Result<(), Error> {
        let source = self.source.clone();
        let mut reader = Reader::from_str(text);
        let mut open: Vec<Id> = Vec::new();
        loop {
            let place = reader.buffer_position() as usize;
            let wrong = |what: &str| source.error(line(text, place), what);
            let event = reader.read_event().map_err(|error| {
                let place = reader.error_position() as usize;
                let error: String = error.to_string().chars().take(200).collect();
                let error = error.replace(char::is_control, " ");
                source.error(line(text, place), format!("the XML is damaged: {error}"))
            })?;
            match event {
                Event::Start(element) => {
                    let id = self.add(&element, place, open.last())?;
                    open.push(id);
                    if open.len() > MOST_DEPTH {
                        return Err(wrong("elements are nested too deeply"));
                    }
                }
                Event::Empty(element) => {
                    self.add(&element, place, open.last())?;
                }
                Event::End(_) => {
                    open.pop();
                }
                Event::Text(words) => {
                    let end = reader.buffer_position() as usize;
                    let is_blank = words.trim_ascii().is_empty();
                    if let (Some(id), false) = (open.last(), is_blank) {
                        self.put_text(*id, place..end);
                    }
                }
                Event::CData(words) => {
                    let start = place + "<![CDATA[".len();
                    if let Some(id) = open.last() {
                        self.put_text(*id, start..start + words.len());
                    }
                }
                Event::GeneralRef(_) => {
                    return Err(source.error_with_help(
                        line(text, place),
                        "there is an entity in the text, which is not read",
                        "write what it stands for in its place",
                    ));
                }
                Event::Eof => break,
                _ => {}
            }
        }
        if !open.is_empty() || self.elements.is_empty() {
            return Err(source.error_with_help(
                format!("byte {}", text.len()),
                "the file ends before </Xdmf>",
                "the file is truncated; copy or write it again",
            ));
        }
        Ok(())
    }

    fn add(
        &mut self,
        element: &BytesStart,
        place: usize,
        parent: Option<&Id>,
    ) -> Result<Id, Error> {
        let id = Id(self.elements.len());
        if id.0 >= MOST_ELEMENTS {
            let what = format!("more than {MOST_ELEMENTS} elements are not read");
            return Err(self.source.error(format!("byte {place}"), what));
        }
        self.elements.push(Element {
            name: element.local_name().as_ref().into(),
            attributes: attributes(&self.source, element, place)?,
            children: Vec::new(),
            text: 0..0,
            place,
        });
        if let Some(parent) = parent {
            self.elements[parent.0].children.push(id);
        }
        Ok(id)
    }

    /// Keeps the first text of an element.
    fn put_text(&mut self, id: Id, range: std::ops::Range<usize>) {
        let text = &mut self.elements[id.0].text;
        if text.end == 0 {
            *text = range;
        }
    }

    /// An error about an element.
    pub(super) fn error(&self, id: Id, what: impl Into<String>) -> Error {
        self.source.error(self.at(id), what)
    }

    /// Where an element is, in words.
    pub(super) fn at(&self, id: Id) -> String {
        let text = String::from_utf8_lossy(&self.source.bytes);
        let place = line(&text, self.elements[id.0].place);
        format!("{place}, <{}>", clip(self.name(id)))
    }

    /// Where an element begins.
    pub(super) fn byte(&self, id: Id) -> usize {
        self.elements[id.0].place
    }

    /// The elements that stand in another themselves.
    pub(super) fn own(&self, id: Id) -> &[Id] {
        &self.elements[id.0].children
    }

    pub(super) fn root(&self) -> Id {
        Id(0)
    }

    pub(super) fn name(&self, id: Id) -> &str {
        &self.elements[id.0].name
    }

    /// The first of these attributes that is there; their keys are in lower case.
    pub(super) fn attribute(&self, id: Id, keys: &[&str]) -> Option<&str> {
        let attributes = &self.elements[id.0].attributes;
        let found = keys.iter().find_map(|key| attributes.get(*key));
        found.map(|value| value.trim())
    }

    /// Where the text of an element is in the file.
    pub(super) fn text_range(&self, id: Id) -> std::ops::Range<usize> {
        self.elements[id.0].text.clone()
    }

    /// The text of an element.
    pub(super) fn text(&self, id: Id) -> &str {
        let text = std::str::from_utf8(&self.source.bytes[self.text_range(id)]);
        text.unwrap_or_default().trim() // `parse` has checked it
    }

    /// The elements in another, with those that `xi:include` puts there.
    pub(super) fn children(&self, id: Id) -> Result<Vec<Id>, Error> {
        let mut children = Vec::new();
        for &child in &self.elements[id.0].children {
            if self.name(child) != "include" {
                children.push(child);
                continue;
            }
            if self
                .attribute(child, &["href"])
                .is_some_and(|name| !name.is_empty())
            {
                return Err(self.error(child, "elements of other files are not read"));
            }
            let pointer = self.attribute(child, &["xpointer"]).unwrap_or_default();
            children.extend(self.find(child, pointer)?);
        }
        Ok(children)
    }

    /// The elements of a name in another, each as what it refers to.
    pub(super) fn named(&self, id: Id, name: &str) -> Result<Vec<Id>, Error> {
        let children = self.children(id)?.into_iter();
        let named = children.filter(|&child| self.name(child) == name);
        named.map(|child| self.referred(child)).collect()
    }

    /// The element that stands for another: itself, or that of its `Reference`.
    fn referred(&self, mut id: Id) -> Result<Id, Error> {
        const MOST: usize = 8;
        for _ in 0..MOST {
            let Some(reference) = self.attribute(id, &["reference"]) else {
                return Ok(id);
            };
            let path = match reference.eq_ignore_ascii_case("XML") {
                true => self.text(id),
                false => reference,
            };
            let found = self.find(id, path)?;
            id = *found.first().ok_or_else(|| {
                self.error(id, format!("the file has no element '{}'", clip(path)))
            })?;
        }
        Err(self.error(
            id,
            format!("more than {MOST} references one after the other"),
        ))
    }

    /// The elements that a path means, which element `from` names: `/Xdmf/Domain/Grid[2]`,
    /// `//Grid[@Name="a"]/*[self::Topology or self::Geometry]`, the same in `xpointer(…)`, and
    /// `element(/1/1/2)`.
    fn find(&self, from: Id, path: &str) -> Result<Vec<Id>, Error> {
        let wrong = || {
            self.source.error_with_help(
                self.at(from),
                format!("the path '{}' is not read", clip(path)),
                "write what it means in its place",
            )
        };
        let inside = |name: &str| path.strip_prefix(name)?.strip_suffix(')');
        let is_sequence = path.starts_with("element(");
        let steps = inside("element(")
            .or_else(|| inside("xpointer("))
            .unwrap_or(path);
        let (mut found, mut rest) = (Vec::new(), steps);
        let mut is_first = true;
        while !rest.is_empty() {
            rest = rest.strip_prefix('/').ok_or_else(wrong)?;
            let (is_deep, after) = match rest.strip_prefix('/') {
                Some(after) => (true, after),
                None => (false, rest),
            };
            let (step, after) = cut(after);
            rest = after;
            let parents = match (is_first, is_deep) {
                (true, false) => vec![vec![Id(0)]],
                (true, true) => vec![(0..self.elements.len()).map(Id).collect()],
                (false, false) => {
                    let children = |id: &Id| self.elements[id.0].children.clone();
                    found.iter().map(children).collect()
                }
                (false, true) => return Err(wrong()),
            };
            is_first = false;
            let mut next = Vec::new();
            for candidates in parents {
                let visits = self.visits.get() + candidates.len() as u64;
                self.visits.set(visits);
                if visits > MOST_VISITS {
                    return Err(self.error(from, "the paths of the file take too long to follow"));
                }
                let chosen = match is_sequence {
                    true => step.parse().ok().map(|number| nth(candidates, number)),
                    false => self.step(candidates, step),
                };
                next.extend(chosen.ok_or_else(wrong)?);
            }
            found = next;
        }
        match is_first {
            true => Err(wrong()),
            false => Ok(found),
        }
    }

    /// Those of `candidates` that a step of a path means; `None` if it is not understood.
    fn step(&self, mut candidates: Vec<Id>, step: &str) -> Option<Vec<Id>> {
        let (name, mut rest) = step.split_at(step.find('[').unwrap_or(step.len()));
        if name.is_empty() {
            return None;
        }
        let name = name.rsplit(':').next().unwrap_or(name);
        candidates.retain(|&id| name == "*" || self.name(id) == name);
        while let Some(after) = rest.strip_prefix('[') {
            let (predicate, after) = after.split_once(']')?;
            rest = after;
            let predicate = predicate.trim();
            if let Ok(number) = predicate.parse() {
                candidates = nth(candidates, number);
            } else if let Some(test) = predicate.strip_prefix('@') {
                let (key, value) = test.split_once('=')?;
                let key = key.trim().to_ascii_lowercase();
                let value = value.trim().trim_matches(['"', '\'']);
                candidates.retain(|&id| self.attribute(id, &[&key]) == Some(value));
            } else {
                let names = predicate.split(" or ");
                let names: Option<Vec<&str>> = names
                    .map(|name| name.trim().strip_prefix("self::"))
                    .collect();
                let names = names?;
                candidates.retain(|&id| names.contains(&self.name(id)));
            }
        }
        rest.is_empty().then_some(candidates)
    }
}

/// The one of a number, from 1.
fn nth(ids: Vec<Id>, number: usize) -> Vec<Id> {
    let index = number.checked_sub(1);
    let found = index.and_then(|index| ids.get(index));
    found.into_iter().copied().collect()
}

/// A path's first step, up to a `/` that is in no brackets, and the rest.
fn cut(path: &str) -> (&str, &str) {
    let mut depth = 0_i32;
    let end = path.find(|c| {
        depth += i32::from(c == '[') - i32::from(c == ']');
        c == '/' && depth == 0
    });
    path.split_at(end.unwrap_or(path.len()))
}
