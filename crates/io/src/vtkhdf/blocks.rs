//! Blocks of a collection: the meshes among them become one.

use std::collections::HashSet;

use tetrascope_core::Error;

use super::mesh::{join, parts};
use super::{Kind, MOST_PARTS, Step, Steps};
use crate::MeshData;
use crate::hdf5::Group;
use crate::pieces::Fields;
use crate::steps::{StepChoice, choose, note};

/// The group of soft links that says how blocks are nested.
const ASSEMBLY: &str = "Assembly";

/// Groups in each other.
const MOST_DEPTH: usize = 32;

/// Reads the blocks of a collection.
pub(super) fn read(root: &Group, choice: Option<StepChoice>) -> Result<MeshData, Error> {
    let blocks = blocks(root)?;
    let common = common_steps(&blocks)?;
    let times = common.map_or(Vec::new(), |steps| steps.times);
    let chosen = choose(&root.file.path, choice, &times)?;
    let mut data = MeshData::default();
    data.notes
        .extend(chosen.and_then(|step| note(&times, step)));
    let (mut all, mut implied) = (Vec::new(), false);
    for Block { name, group, steps } in blocks {
        let kind = match Kind::of(&group) {
            Ok(kind @ (Kind::Unstructured | Kind::Structured | Kind::Rectilinear)) => kind,
            Ok(Kind::Image | Kind::Blocks) | Err(Error::Format { .. }) => {
                let kind = group.text("Type")?.unwrap_or_default();
                let kind: String = kind.chars().take(40).collect();
                let note = format!("'{name}' left out: it holds a {kind}, and meshes are joined");
                data.notes.push(note);
                continue;
            }
            Err(error) => return Err(error),
        };
        implied |= kind == Kind::Rectilinear;
        let step: Step = steps.as_ref().zip(chosen);
        all.extend(parts(&group, kind, step, Some(name), &mut data)?);
        if all.len() as u64 > MOST_PARTS {
            return Err(root.error(format!("more than {MOST_PARTS} parts are not read")));
        }
    }
    if all.is_empty() {
        return Err(root.error("the file has no block that holds a mesh with cells"));
    }
    join(root, implied, all, Fields::All, data)
}

/// The steps of a collection, if it has any.
pub(super) fn steps(root: &Group) -> Result<Option<Steps>, Error> {
    common_steps(&blocks(root)?)
}

struct Block {
    name: String,
    group: Group,
    steps: Option<Steps>,
}

/// The steps that the blocks share; some may have none.
fn common_steps(blocks: &[Block]) -> Result<Option<Steps>, Error> {
    let mut common: Option<&Steps> = None;
    for block in blocks {
        let (Some(steps), first) = (&block.steps, common) else {
            continue;
        };
        if first.is_some_and(|first| first.times != steps.times) {
            return Err(block
                .group
                .error("its time steps are not those of other blocks"));
        }
        common = Some(steps);
    }
    Ok(common.cloned())
}

/// The blocks of a collection, each once.
fn blocks(root: &Group) -> Result<Vec<Block>, Error> {
    let mut known = HashSet::new();
    let mut found = Vec::new();
    // They are beside the assembly, which has links to them.
    find(root, 0, &mut known, &mut found)?;
    if found.is_empty()
        && let Some(assembly) = root.group(ASSEMBLY)?
    {
        find(&assembly, MOST_DEPTH, &mut known, &mut found)?;
    }
    found.sort_by_key(|(index, _)| *index); // stable
    Ok(found.into_iter().map(|(_, block)| block).collect())
}

/// Finds the groups with a type in `group`, and in `depth` further levels of those without.
fn find(
    group: &Group,
    depth: usize,
    known: &mut HashSet<u64>,
    found: &mut Vec<(u64, Block)>,
) -> Result<(), Error> {
    let (names, _) = group.members()?;
    for name in names {
        let Some(member) = group.group(&name)?.filter(|_| name != ASSEMBLY) else {
            continue;
        };
        if !known.insert(member.address()) {
            continue;
        }
        if known.len() as u64 > MOST_PARTS {
            return Err(group.error(format!("more than {MOST_PARTS} groups are not read")));
        }
        if member.text("Type")?.is_some() {
            let index = member.numbers("Index")?.unwrap_or_default();
            let steps = Steps::of(&member)?;
            let block = Block {
                name,
                group: member,
                steps,
            };
            found.push((index.first().map_or(0, |&index| index as u64), block));
        } else if depth > 0 {
            find(&member, depth - 1, known, found)?;
        }
    }
    Ok(())
}
