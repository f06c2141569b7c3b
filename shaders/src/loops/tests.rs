//! The table against the files.

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::path::Path;

use naga::{Arena, Expression, Function, Handle, Module, Statement};

use super::*;
use crate::PROGRAMS;

/// The files of `wgsl/` with their text.
fn files() -> Vec<(String, String)> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("wgsl");
    let entries = |path: &Path| {
        let entries = std::fs::read_dir(path).expect("the crate has shaders");
        entries.map(|entry| entry.expect("readable").path())
    };
    let mut files = Vec::new();
    for file in entries(&root).flat_map(|folder| entries(&folder).collect::<Vec<_>>()) {
        let name = file
            .strip_prefix(&root)
            .expect("below it")
            .to_string_lossy();
        let text = std::fs::read_to_string(&file).expect("WGSL is text");
        files.push((name.replace('\\', "/"), text));
    }
    files
}

fn has_function(text: &str, function: &str) -> bool {
    let begins = format!("fn {function}(");
    text.lines().any(|line| line.starts_with(&begins))
}

/// Whether a pipeline's constants alone decide it.
fn is_fixed(expressions: &Arena<Expression>, condition: Handle<Expression>) -> bool {
    match expressions[condition] {
        Expression::Override(_) | Expression::Constant(_) | Expression::Literal(_) => true,
        Expression::Unary { expr, .. } => is_fixed(expressions, expr),
        Expression::Binary { left, right, .. } => {
            is_fixed(expressions, left) && is_fixed(expressions, right)
        }
        _ => false,
    }
}

/// The most passes that the loops of a block take, loop by loop of the function in `table`.
struct Counter<'a> {
    module: &'a Module,
    /// The files that the program is made of.
    parts: Vec<&'a (String, String)>,
    /// The passes of each function.
    known: RefCell<BTreeMap<String, u64>>,
}

/// Loops of a function that were met, and the passes up to now.
struct Met {
    loops: usize,
    passes: u64,
}

impl Counter<'_> {
    fn new<'a>(module: &'a Module, files: &'a [(String, String)], source: &str) -> Counter<'a> {
        let is_part = |f: &&(String, String)| source.contains(f.1.as_str());
        Counter {
            module,
            parts: files.iter().filter(is_part).collect(),
            known: RefCell::default(),
        }
    }

    /// The file of the program that has this function.
    fn file_of(&self, function: &str) -> &str {
        let mut found = self.parts.iter().filter(|f| has_function(&f.1, function));
        let (name, _) = found.next().expect("every function is in a file");
        assert!(found.next().is_none(), "{function} is in two files");
        name
    }

    fn loops_of(&self, function: &str) -> Vec<Loop> {
        let file = self.file_of(function);
        let of = |l: &&Loop| l.file == file && l.function == function;
        LOOPS.iter().filter(of).copied().collect()
    }

    /// The passes of all loops of a function and of those that it calls.
    fn function(&self, name: &str, function: &Function) -> u64 {
        if let Some(known) = self.known.borrow().get(name) {
            return *known;
        }
        let table = self.loops_of(name);
        let mut met = Met {
            loops: 0,
            passes: 0,
        };
        self.block(function, &function.body, &table, &mut met);
        assert_eq!(
            met.loops,
            table.len(),
            "loops of {name} in {}, and how many of them `LOOPS` lists",
            self.file_of(name)
        );
        self.known.borrow_mut().insert(name.into(), met.passes);
        met.passes
    }

    fn block(&self, function: &Function, block: &[Statement], table: &[Loop], met: &mut Met) {
        for (index, statement) in block.iter().enumerate() {
            match statement {
                Statement::Block(inner) => self.block(function, inner, table, met),
                Statement::If {
                    condition,
                    accept,
                    reject,
                } => {
                    let before = met.passes;
                    self.block(function, accept, table, met);
                    let accepted = met.passes;
                    // Neighbors may take both sides, but not of what a pipeline decides.
                    let either = is_fixed(&function.expressions, *condition);
                    if either {
                        met.passes = before;
                    }
                    self.block(function, reject, table, met);
                    // What a pipeline returns from does nothing behind.
                    let returns = either && matches!(accept.last(), Some(Statement::Return { .. }));
                    if returns {
                        self.block(function, &block[index + 1..], table, met);
                    }
                    if either {
                        met.passes = met.passes.max(accepted);
                    }
                    if returns {
                        return;
                    }
                }
                Statement::Switch { cases, .. } => {
                    for case in cases {
                        self.block(function, &case.body, table, met);
                    }
                }
                Statement::Call { function, .. } => {
                    let called = &self.module.functions[*function];
                    let called = self.function(called.name.as_deref().unwrap_or(""), called);
                    met.passes = met.passes.saturating_add(called);
                }
                Statement::Loop {
                    body, continuing, ..
                } => {
                    let own = table.get(met.loops).map(|l| l.passes);
                    let name = || function.name.as_deref().unwrap_or("an entry point");
                    let own = own.unwrap_or_else(|| panic!("`LOOPS` lacks a loop of {}", name()));
                    met.loops += 1;
                    let before = std::mem::take(&mut met.passes);
                    self.block(function, body, table, met);
                    self.block(function, continuing, table, met);
                    let inner = met.passes;
                    let all = match own {
                        AtMost(n) => n.saturating_mul(1 + inner).saturating_add(1),
                        InAll(n) => n,
                        Counted => 0,
                    };
                    met.passes = before.saturating_add(all);
                }
                _ => {}
            }
        }
    }
}

/// The most passes of each entry point.
fn entry_points() -> BTreeMap<(&'static str, String), u64> {
    let files = files();
    let mut all = BTreeMap::new();
    for (program, source) in PROGRAMS {
        let module = naga::front::wgsl::parse_str(source).expect("every program is valid");
        let counter = Counter::new(&module, &files, source);
        for (_, function) in module.functions.iter() {
            counter.function(function.name.as_deref().unwrap_or(""), function);
        }
        for entry in &module.entry_points {
            let passes = counter.function(&entry.name, &entry.function);
            all.insert((program, entry.name.clone()), passes);
        }
    }
    all
}

/// Every loop is in the table, and no entry point can come to more passes than a device
/// allows.
#[test]
fn every_loop_is_bounded() {
    for ((program, entry), passes) in entry_points() {
        println!("{program} {entry}: {passes}");
        assert!(passes <= MOST_PASSES, "{program} {entry}: {passes} passes");
    }
}

/// Every line of the table is a loop of a function that there is.
#[test]
fn the_table_lists_no_loop_that_is_gone() {
    let files = files();
    for l in LOOPS {
        let text = files.iter().find(|(name, _)| name == l.file);
        let (_, text) = text.unwrap_or_else(|| panic!("there is no {}", l.file));
        let there = has_function(text, l.function);
        assert!(there, "{} has no {}", l.file, l.function);
        assert!(!l.bound.is_empty());
    }
}

/// A loop that the table does not know, and one that grows too far, are seen.
#[test]
fn the_test_can_fail() {
    let files = vec![(
        "slicing/surface.wgsl".to_string(),
        "fn place_between(n: u32) -> u32 { var m = 0u; for (var i = 0u; i < n; i++) { m += 1u; \
         for (var j = 0u; j < n; j++) { m += 1u; } } return m; }"
            .to_string(),
    )];
    let source = &files[0].1;
    let module = naga::front::wgsl::parse_str(source).expect("valid");
    let counter = Counter::new(&module, &files, source);
    let (_, function) = module.functions.iter().next().expect("there is one");
    let count = || counter.function("place_between", function);
    let unlisted = std::panic::catch_unwind(std::panic::AssertUnwindSafe(count));
    assert!(unlisted.is_err(), "the inner loop is not in the table");
    let twice = [of("", "", AtMost(300), ""), of("", "", AtMost(299), "")];
    let mut met = Met {
        loops: 0,
        passes: 0,
    };
    counter.block(function, &function.body, &twice, &mut met);
    assert_eq!(met.passes, 300 * (1 + 300) + 1);
    assert!(met.passes > MOST_PASSES);
}
