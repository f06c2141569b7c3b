//! Checks of the repository's Markdown files: links, headings, settings, commands.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::process::Command;

use tetrascope::{Settings, algorithm, algorithms};

use crate::machine::root;

/// A Markdown file of the repository.
struct Document {
    path: PathBuf,
    text: String,
}

/// All that git knows of.
fn documents() -> Vec<Document> {
    let listed = Command::new("git")
        .args(["ls-files", "-z", "--cached", "--others"])
        .args(["--exclude-standard", "*.md"])
        .current_dir(root())
        .output()
        .expect("git lists files");
    let names = String::from_utf8(listed.stdout).expect("names are UTF-8");
    let names = names.split('\0').filter(|name| !name.is_empty());
    let found: Vec<Document> = names
        .map(|name| root().join(name))
        .filter(|path| path.is_file())
        .map(|path| Document {
            text: std::fs::read_to_string(&path).expect("a readable file"),
            path,
        })
        .collect();
    assert!(found.iter().any(|d| d.path.ends_with("README.md")));
    found
}

impl Document {
    fn read(name: &str) -> Document {
        let path = root().join(name);
        let text = std::fs::read_to_string(&path).expect("a readable file");
        Document { path, text }
    }

    /// The targets of `[text](target)`, and of pictures.
    fn links(&self) -> impl Iterator<Item = &str> {
        let ends = self.text.split("](").skip(1);
        ends.filter_map(|rest| rest.split_once(')').map(|(target, _)| target))
    }

    /// The anchors of its headings, as GitHub makes them.
    fn anchors(&self) -> BTreeSet<String> {
        let mut is_code = false;
        let headings = self.text.lines().filter(|line| {
            is_code ^= line.starts_with("```");
            !is_code && line.starts_with('#')
        });
        headings
            .map(|line| anchor(line.trim_start_matches('#')))
            .collect()
    }
}

fn anchor(heading: &str) -> String {
    let kept = heading.trim().to_lowercase();
    let kept = kept
        .chars()
        .filter(|c| c.is_alphanumeric() || " -_".contains(*c));
    kept.map(|c| if c == ' ' { '-' } else { c }).collect()
}

/// The text between pairs of single backticks in a line.
fn code(text: &str) -> impl Iterator<Item = &str> {
    text.lines()
        .flat_map(|line| line.split('`').skip(1).step_by(2))
}

/// Whether it is like `key=value`, and not an environment variable.
fn is_setting(code: &str) -> bool {
    code.contains('=') && code.starts_with(|c: char| c.is_ascii_lowercase())
}

#[test]
fn links_lead_to_files_and_headings() {
    let mut broken = Vec::new();
    let mut checked = 0;
    for document in documents() {
        for link in document.links() {
            if link.contains("://") || link.starts_with("mailto:") {
                continue;
            }
            checked += 1;
            let (path, anchor) = link.split_once('#').unwrap_or((link, ""));
            let target = match path.is_empty() {
                true => document.path.clone(),
                false => document.path.parent().expect("a folder").join(path),
            };
            let is_there = match anchor.is_empty() {
                true => target.exists(),
                false => std::fs::read_to_string(&target).is_ok_and(|text| {
                    let path = target.clone();
                    Document { path, text }.anchors().contains(anchor)
                }),
            };
            if !is_there {
                broken.push(format!("{}: {link}", document.path.display()));
            }
        }
    }
    assert!(broken.is_empty(), "{}", broken.join("\n"));
    assert!(checked > 50, "{checked} links");
}

#[test]
fn anchors_are_those_of_github() {
    assert_eq!(anchor(" No ray is lost"), "no-ray-is-lost");
    assert_eq!(
        anchor(" What is not exact, says so"),
        "what-is-not-exact-says-so"
    );
    let document = Document {
        path: PathBuf::new(),
        text: "# A\n```\n# not this\n```\n## B c\n".into(),
    };
    assert_eq!(document.anchors(), ["a", "b-c"].map(String::from).into());
}

#[test]
fn settings_in_the_papers_pages_are_settings() {
    let mut checked = 0;
    for algorithm in algorithms() {
        let name = format!("docs/papers/{}.md", algorithm.name);
        if !root().join(&name).is_file() {
            continue;
        }
        let page = Document::read(&name);
        for setting in code(&page.text).filter(|code| is_setting(code)) {
            let parsed = Settings::parse(algorithm, setting.split(','));
            assert!(parsed.is_ok(), "{name}: {setting}: {:?}", parsed.err());
            checked += 1;
        }
    }
    assert!(checked > 20, "{checked} settings");
}

#[test]
fn every_algorithm_of_a_paper_has_a_page_and_a_row_in_the_readme() {
    let readme = Document::read("README.md").text;
    for algorithm in algorithms() {
        let in_backticks = format!("`{}`", algorithm.name);
        assert!(readme.contains(&in_backticks), "{in_backticks}");
        let on_cpu = !algorithm.needs_gpu;
        let page = format!("docs/papers/{}.md", algorithm.name);
        assert!(on_cpu || root().join(&page).is_file(), "{page}");
    }
    algorithm("raycast-peel").expect("the one that the readme recommends");
}

#[test]
fn the_readme_is_short() {
    let words = Document::read("README.md").text.split_whitespace().count();
    assert!(words <= 800, "{words} words: long tables go to RESULTS.md");
}

#[test]
fn commands_of_the_harness_exist() {
    let main = Path::new(env!("CARGO_MANIFEST_DIR")).join("src/front.rs");
    let front = std::fs::read_to_string(main).expect("the front's source");
    let help = front.split("Usage: cargo xtask COMMAND").nth(1);
    let help = help.and_then(|rest| rest.split("`cargo xtask COMMAND --help`").next());
    let known: BTreeSet<&str> = help
        .expect("the list of commands")
        .lines()
        .filter_map(|line| line.strip_prefix("  ")?.split_whitespace().next())
        .collect();
    assert!(known.contains("compare") && known.contains("gallery"));
    for document in documents() {
        for rest in document.text.split("cargo xtask ").skip(1) {
            let command: String = rest
                .chars()
                .take_while(|c| c.is_ascii_lowercase())
                .collect();
            let is_known = command.is_empty() || known.contains(&*command);
            assert!(
                is_known,
                "{}: cargo xtask {command}",
                document.path.display()
            );
        }
    }
}
