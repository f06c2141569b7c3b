//! One page of what is not as reviewed, and a sheet of all pictures.

use std::path::Path;

use image::RgbaImage;
use serde::Serialize;
use tetrascope::core::Error;

use super::compare::{Left, Store, difference_in_steps, steps_map};
use super::texts::Text;
use crate::output::write;
use crate::page::{address, html};
use crate::picture::png;

/// The data of the template.
#[derive(Serialize)]
struct Page {
    pictures: Vec<Picture>,
    texts: Vec<Difference>,
    sheet: Vec<Card>,
}

/// A picture that differs or is missing.
#[derive(Serialize)]
struct Picture {
    name: String,
    verdict: String,
    may_be_blessed: bool,
    expected: Option<String>,
    difference: Option<String>,
    actual: String,
}

/// A text that differs or is missing.
#[derive(Serialize)]
struct Difference {
    name: String,
    expected: Option<String>,
    actual: String,
}

/// A reviewed picture.
#[derive(Serialize)]
struct Card {
    name: String,
    image: String,
}

/// Writes the page; how many pictures and texts are not as reviewed.
///
/// # Errors
/// Files that cannot be read or written.
pub fn write_page(store: &Store, texts: &[Text], path: &Path) -> Result<usize, Error> {
    let mut page = Page {
        pictures: store.left()?.iter().map(picture).collect(),
        texts: Vec::new(),
        sheet: Vec::new(),
    };
    for text in texts {
        page.texts
            .extend(text.difference()?.map(|(expected, actual)| Difference {
                name: text.name(),
                expected,
                actual,
            }));
    }
    for name in store.reviewed()? {
        let file = store.path(&name);
        let bytes = std::fs::read(&file).map_err(|source| Error::Io {
            action: "cannot read",
            path: file,
            source,
        })?;
        let image = address(&bytes);
        page.sheet.push(Card { name, image });
    }
    write(path, page.to_html())?;
    Ok(page.pictures.len() + page.texts.len())
}

fn picture(left: &Left) -> Picture {
    let expected = left.expected.as_ref();
    let of = |image: &RgbaImage| address(&png(image));
    Picture {
        name: left.name.clone(),
        verdict: match expected.map(|expected| difference_in_steps(expected, &left.actual)) {
            None => "was not reviewed".into(),
            Some(None) => "has another size".into(),
            Some(Some(steps)) => format!("differs by up to {steps} steps of 255"),
        },
        may_be_blessed: left.may_be_blessed,
        expected: expected.map(of),
        difference: expected.map(|expected| of(&steps_map(expected, &left.actual))),
        actual: of(&left.actual),
    }
}

impl Page {
    fn to_html(&self) -> String {
        html(include_str!("page.html"), self, |_| ())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::snapshots::compare::tests::{gray, store};
    use crate::snapshots::texts;

    #[test]
    fn the_page_shows_what_differs_and_needs_no_other_file() {
        let (folder, store) = store();
        for name in ["same", "changed"] {
            _ = store.check(name, &gray(100), 0, true);
        }
        store.bless().expect("writable");
        _ = store.check("same", &gray(100), 0, true);
        _ = store.check("changed", &gray(90), 3, true);
        _ = store.check("new", &gray(1), 3, false);
        let text = folder.path().join("usage.snap.new");
        std::fs::write(text, "---\nsource: a.rs\n---\n<b>bold</b>\n").expect("written");
        let texts = texts::all(folder.path()).expect("readable");
        let path = folder.path().join("index.html");
        assert_eq!(write_page(&store, &texts, &path).expect("writable"), 3);
        let page = std::fs::read_to_string(&path).expect("written");
        for words in [
            "differs by up to 10 steps of 255",
            "was not reviewed",
            "&lt;b&gt;bold&lt;",
            "usage",
        ] {
            assert!(page.contains(words), "{words}: {page}");
        }
        // Expected, difference and actual; actual alone; and the two that are reviewed.
        assert_eq!(page.matches("<img").count(), 3 + 1 + 2);
        assert_eq!(page.matches("src=\"data:image/png;base64,").count(), 6);
        assert!(
            !page.contains("<script") && !page.contains("http"),
            "{page}"
        );
        // Where nothing is left, nothing differs.
        _ = store.check("changed", &gray(100), 0, true);
        store.bless().expect("writable");
        assert_eq!(write_page(&store, &[], &path).expect("writable"), 0);
    }
}
