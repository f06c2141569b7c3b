//! The thread that loads another field or time step, while what is there is still drawn.

use std::sync::Arc;
use std::time::Duration;

use tetrascope_core::Error;
use tetrascope_scene::VolumeSource;

use super::shared::Shared;
use super::state::{Field, Wanted};
use crate::volumes;

/// Wakes now and then, should nobody wake it.
const LONG: Duration = Duration::from_secs(3600);

pub(crate) fn work(shared: &Shared) {
    loop {
        let mut inbox = shared.lock();
        while inbox.wanted.is_none() && !inbox.is_closing {
            inbox = shared.wait(inbox, LONG);
        }
        if inbox.is_closing {
            return;
        }
        // The newest wish; older ones are gone.
        let Some((wanted, client)) = inbox.wanted.take() else {
            continue;
        };
        inbox.is_loading = true;
        let before = inbox.state.field.clone();
        drop(inbox);
        let result = load(shared, &before, &wanted)
            .and_then(|field| shared.take_field(Arc::new(field), &wanted, client));
        shared.update(|inbox| inbox.is_loading = false);
        if let Err(error) = result {
            shared.problem(&error, client);
        }
    }
}

/// Loads what is wanted; geometry that is the same is shared.
fn load(shared: &Shared, before: &Field, wanted: &Wanted) -> Result<Field, Error> {
    let mut source = before.source.clone();
    if let Some(name) = &wanted.field {
        source.field = Some(name.clone());
    }
    choose_step(&mut source, shared, wanted.step)?;
    let loaded = volumes::load_step(&source, Some(before.volume()))?;
    Ok(Field::new(loaded, source, wanted.step, shared.next_field()))
}

fn choose_step(source: &mut VolumeSource, shared: &Shared, number: usize) -> Result<(), Error> {
    let steps = &shared.steps;
    if steps.is_empty() && number == 0 {
        return Ok(());
    }
    let step = steps.get(number).ok_or_else(|| Error::Usage {
        what: format!("there is no time step {number}"),
        help: Some(format!("there are {}", steps.len())),
    })?;
    source.file = Some(step.file.clone());
    if step.number.is_some() {
        (source.step, source.time) = (step.number, None);
    }
    Ok(())
}
