//! The description of a stack's first page: which of its pages are slices, channels
//! and frames, and how far apart samples are.
//!
//! - ImageJ: lines of `key=value`; channels vary fastest, then slices, then frames. Stacks beyond
//!   4 GiB have one page, and the samples of all others stand behind its own.
//! - OME-XML: <https://docs.openmicroscopy.org/ome-model/6.3.1/ome-tiff/specification.html>.
//!   `DimensionOrder` says what varies fastest, `TiffData` which page is which plane.
//! - tifffile: JSON with the array's `shape`, of which the last two axes are pages.

use std::collections::{HashMap, HashSet};

use quick_xml::Reader;
use quick_xml::events::Event;
use serde_json::Value;
use tetrascope_core::Error;

use crate::source::Source;
use crate::vtu::attributes;

/// So many times each plane may be named: the last one counts.
const MOST_NAMED: usize = 16;

/// The attributes of an element, by name in lower case.
type Attributes = HashMap<String, String>;

/// An axis along which pages follow each other.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum PageAxis {
    Slices,
    Channels,
    Frames,
}

/// How the pages of a file make volumes.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Stack {
    /// Each axis of pages once, that which varies fastest first, with its size.
    pub(super) axes: [(PageAxis, usize); 3],
    /// Which page of the file each is; in the file's order if not given.
    pub(super) pages: Option<Vec<usize>>,
    /// Along x, y and z.
    pub(super) spacing: [Option<f64>; 3],
    /// The resolution of pages says the distances along x and y.
    pub(super) has_resolution: bool,
    pub(super) unit: Option<String>,
    /// The file has one page, and the samples of all others stand behind its own.
    pub(super) is_truncated: bool,
}

impl Stack {
    /// The stack of a file of so many `pages` whose first has this `description`.
    pub(super) fn new(
        source: &Source,
        description: &str,
        pages: usize,
        notes: &mut Vec<String>,
    ) -> Result<Stack, Error> {
        let text = description.trim_start();
        if text.starts_with("ImageJ=") {
            return Ok(imagej(text, pages, notes));
        }
        if text.starts_with('<') && text.contains("<OME") {
            return ome(source, text, pages, notes);
        }
        let shaped = text.starts_with('{').then(|| shaped(text, pages)).flatten();
        Ok(shaped.unwrap_or(Stack::plain(pages)))
    }

    /// A stack of pages that are slices.
    fn plain(pages: usize) -> Stack {
        Stack::of([
            (PageAxis::Channels, 1),
            (PageAxis::Slices, pages),
            (PageAxis::Frames, 1),
        ])
    }

    fn of(axes: [(PageAxis, usize); 3]) -> Stack {
        Stack {
            axes,
            pages: None,
            spacing: [None; 3],
            has_resolution: false,
            unit: None,
            is_truncated: false,
        }
    }

    pub(super) fn size(&self, axis: PageAxis) -> usize {
        let found = self.axes.iter().find(|(other, _)| *other == axis);
        found.map_or(1, |(_, size)| *size)
    }

    /// How many pages it has; none if they cannot be counted.
    fn count(&self) -> Option<usize> {
        let mut sizes = self.axes.iter().map(|(_, size)| *size);
        sizes.try_fold(1, |n: usize, size| n.checked_mul(size))
    }
}

/// `ImageJ=1.53t`, `images=15`, `channels=2`, `slices=5` …
fn imagej(text: &str, pages: usize, notes: &mut Vec<String>) -> Stack {
    let value = |key: &str| {
        let lines = text.lines().filter_map(|line| line.split_once('='));
        let mut values = lines.filter(|(k, _)| k.trim() == key);
        values.next().map(|(_, value)| value.trim())
    };
    let size = |key| value(key).and_then(|v| v.parse().ok()).filter(|n| *n > 0);
    let images: usize = size("images").unwrap_or(1);
    let (channels, frames) = (size("channels").unwrap_or(1), size("frames").unwrap_or(1));
    // A stack that is not a hyperstack says how many images it has.
    let slices = size("slices").unwrap_or(match channels.saturating_mul(frames) {
        1 => images,
        _ => 1,
    });
    let mut stack = Stack::of([
        (PageAxis::Channels, channels),
        (PageAxis::Slices, slices),
        (PageAxis::Frames, frames),
    ]);
    stack.is_truncated = pages == 1 && stack.count() == Some(images) && images > 1;
    if stack.count() != Some(pages) && !stack.is_truncated {
        notes.push(format!(
            "ImageJ's description is of {channels} channels, {slices} slices and {frames} frames, \
             but there are {pages} pages: all are taken for slices"
        ));
        stack.axes = Stack::plain(pages).axes;
    } else if slices == 1 && frames > 1 {
        notes.push(format!(
            "there is one slice: the {frames} frames are taken for slices"
        ));
        stack.axes[1].1 = frames;
        stack.axes[2].1 = 1;
    }
    if stack.is_truncated {
        notes.push(format!(
            "the file has one page; the samples of {images} images follow each other in it, as \
             ImageJ writes large stacks"
        ));
    }
    // Without a unit, the resolution is that of printing.
    let unit = value("unit").filter(|unit| !unit.is_empty() && *unit != "pixel");
    stack.unit = unit.map(|unit| match unit {
        "\\u00B5m" | "um" | "µm" => "micron".into(),
        other => other.chars().take(40).collect(),
    });
    stack.has_resolution = unit.is_some();
    stack.spacing[2] = value("spacing").and_then(|v| v.parse().ok()).map(f64::abs);
    stack
}

/// `{"shape": [2, 5, 4, 6]}`, as tifffile writes it for arrays.
fn shaped(text: &str, pages: usize) -> Option<Stack> {
    let json: Value = serde_json::from_str(text).ok()?;
    let shape = json.get("shape")?.as_array()?.iter();
    let shape: Option<Vec<u64>> = shape.map(Value::as_u64).collect();
    let shape = shape?;
    // Of z, then y and x, and perhaps the channels of a pixel: as many as make all pages.
    let mut frames = 1_usize;
    for (i, &size) in shape.iter().enumerate() {
        let slices = usize::try_from(size).ok()?;
        if frames.checked_mul(slices)? == pages && shape.len() - i <= 4 && slices > 1 {
            let mut stack = Stack::plain(slices);
            stack.axes[2].1 = frames;
            return Some(stack);
        }
        frames = frames.checked_mul(slices)?;
    }
    None
}

/// `<OME><Image><Pixels DimensionOrder="XYZCT" SizeX="…" …><TiffData IFD="0"/> …`
fn ome(source: &Source, text: &str, pages: usize, notes: &mut Vec<String>) -> Result<Stack, Error> {
    let damaged = |what: String| source.error("the OME-XML description", what);
    let mut reader = Reader::from_str(text);
    let mut pixels: Option<Attributes> = None;
    let mut samples = 1;
    let (mut planes, mut names) = (Vec::new(), HashSet::new());
    loop {
        let place = reader.buffer_position() as usize;
        let event = reader.read_event();
        match event.map_err(|error| damaged(format!("the XML is damaged: {error}")))? {
            Event::Start(element) | Event::Empty(element) => {
                let mut values = attributes(source, &element, place)?;
                match element.local_name().as_ref() {
                    "Pixels" if pixels.is_some() => {
                        notes.push("the file has several images: the first is read".into());
                        break;
                    }
                    "Pixels" => pixels = Some(values),
                    "Channel" => samples = number(&values, "samplesperpixel").unwrap_or(1),
                    "TiffData" => planes.push(values),
                    "UUID" => names.extend(values.remove("filename")),
                    _ => {}
                }
            }
            Event::DocType(_) => return Err(damaged("it has a document type".into())),
            Event::Eof => break,
            _ => {}
        }
    }
    let pixels = pixels.ok_or_else(|| damaged("there is no <Pixels>".into()))?;
    if names.len() > 1 {
        return Err(source.error_with_help(
            "the OME-XML description",
            format!("the planes are in {} files", names.len()),
            "save them in one file",
        ));
    }
    let mut stack = Stack::of(sizes(&pixels, samples.max(1)).map_err(damaged)?);
    let of_axes =
        |key: &str| ["x", "y", "z"].map(|axis| pixels.get(&format!("physicalsize{axis}{key}")));
    stack.spacing = of_axes("").map(|size| size?.parse().ok());
    let units = of_axes("unit").map(|unit| unit.map_or("µm", String::as_str));
    if units.iter().any(|other| *other != units[0]) {
        notes.push(format!(
            "lengths along x, y and z have different units: {units:?}"
        ));
    } else {
        let unit = if units[0] == "µm" {
            "micron"
        } else {
            units[0]
        };
        stack.unit = Some(unit.chars().take(40).collect());
    }
    let count = stack.count().filter(|count| *count <= pages);
    let count = count.ok_or_else(|| {
        let sizes = stack.axes;
        damaged(format!("planes of {sizes:?}, but there are {pages} pages"))
    })?;
    let order = planes_to_pages(&stack, &planes, count, pages).map_err(damaged)?;
    let in_order = order.iter().copied().eq(0..count);
    stack.pages = Some(order).filter(|_| !in_order || count < pages);
    Ok(stack)
}

fn number(values: &Attributes, key: &str) -> Option<usize> {
    values.get(key)?.trim().parse().ok()
}

/// The axes of pages of an OME image, of whose channels `samples` are in each pixel.
fn sizes(pixels: &Attributes, samples: usize) -> Result<[(PageAxis, usize); 3], String> {
    let order = pixels.get("dimensionorder").map_or("XYZCT", String::as_str);
    let size = |key: &str| number(pixels, key).filter(|n| *n > 0);
    let axis = |letter| {
        let (axis, key, samples) = match letter {
            'Z' => (PageAxis::Slices, "sizez", 1),
            'C' => (PageAxis::Channels, "sizec", samples),
            'T' => (PageAxis::Frames, "sizet", 1),
            _ => return None,
        };
        Some((axis, size(key)?.div_ceil(samples)))
    };
    let axes: Option<Vec<_>> = order.chars().skip(2).map(axis).collect();
    let axes = axes.filter(|axes| {
        let kinds: Vec<PageAxis> = axes.iter().map(|(axis, _)| *axis).collect();
        let all = [PageAxis::Slices, PageAxis::Channels, PageAxis::Frames];
        all.iter().all(|axis| kinds.contains(axis))
    });
    let axes = axes.and_then(|axes| axes.try_into().ok());
    axes.ok_or_else(|| {
        let order: String = order.chars().take(40).collect();
        format!("the dimension order '{order}' or a size is not known")
    })
}

/// The page of each of `count` planes, by the `TiffData` elements; or what is wrong with them.
fn planes_to_pages(
    stack: &Stack,
    elements: &[Attributes],
    count: usize,
    pages: usize,
) -> Result<Vec<usize>, String> {
    if elements.is_empty() {
        return Ok((0..count).collect());
    }
    let mut table = vec![None; count];
    let mut named = 0usize;
    for element in elements {
        let page = number(element, "ifd");
        let planes = number(element, "planecount");
        let planes = planes.unwrap_or(if page.is_some() { 1 } else { count });
        let (mut plane, mut step) = (0, 1);
        for &(axis, size) in &stack.axes {
            let key = match axis {
                PageAxis::Slices => "firstz",
                PageAxis::Channels => "firstc",
                PageAxis::Frames => "firstt",
            };
            let first = number(element, key).unwrap_or(0);
            if first >= size {
                return Err(format!(
                    "a <TiffData> begins at {first} of {size} along an axis"
                ));
            }
            plane += first * step;
            step *= size;
        }
        named = named.saturating_add(planes.min(count));
        if named / MOST_NAMED > count {
            return Err("<TiffData> elements name the same planes again and again".into());
        }
        let pages_of = (page.unwrap_or(0)..pages).take(planes);
        for (place, page) in table[plane..].iter_mut().zip(pages_of) {
            *place = Some(page);
        }
    }
    let missing = table.iter().filter(|page| page.is_none()).count();
    let found: Option<Vec<usize>> = table.into_iter().collect();
    found.ok_or_else(|| format!("{missing} of {count} planes have no page in the file"))
}
