//! The threads that draw: quickly, and completely.

use std::sync::{Arc, PoisonError};
use std::time::{Duration, Instant};

use serde_json::json;
use tetrascope_core::{Error, Frame, View};

use super::encoded::{Caption, Encoded, Kind};
use super::quick;
use super::renderers::Setup;
use super::session::Event;
use super::shared::{Complete, Shared};
use super::state::State;

/// Wakes now and then, should nobody wake it.
const LONG: Duration = Duration::from_secs(3600);

/// Where a complete picture is expected to take longer, one of half the size comes before.
const PATIENCE: Duration = Duration::from_millis(400);

/// A state that is to be drawn.
struct Job {
    state: Arc<State>,
    input: Option<(u64, u64)>,
    /// When its input came.
    since: Instant,
}

/// Draws each newest state at the resolution at which frames come fast enough.
pub(crate) fn quick(shared: &Shared) {
    while let Some(job) = next_quick(shared) {
        let state = &job.state;
        let measured = shared
            .measured
            .lock()
            .unwrap_or_else(PoisonError::into_inner);
        let quick = quick::choose(state, &measured);
        drop(measured);
        let full = [state.scene.view.width, state.scene.view.height];
        let size = shared.lock_pace().size(full);
        let begun = Instant::now();
        let slot = shared.renderers.slot(&quick.setup, &shared.used(state));
        let mut slot = slot.lock().unwrap_or_else(PoisonError::into_inner);
        // What a complete picture was stopped by.
        slot.stop().clear();
        let is_complete = size == full && quick.setup == Setup::of(state);
        let drawn = slot.draw(state, &sized(&state.scene.view, size), is_complete);
        drop(slot);
        let draw = begun.elapsed();
        let sent = drawn.and_then(|frame| {
            let kind = if is_complete {
                Kind::Complete
            } else {
                Kind::Quick
            };
            let more = json!({"why": quick.why});
            send(
                shared,
                &job,
                &quick.setup,
                &frame,
                (kind, begun, draw),
                more,
            )?;
            Ok(is_complete.then(|| complete_of(shared, &job, &quick.setup, frame)))
        });
        match sent {
            Ok(complete) => {
                shared.lock_pace().drew(size, begun.elapsed());
                shared.update(|inbox| {
                    inbox.quick = state.version;
                    if let Some(complete) = complete {
                        inbox.finished = state.version;
                        inbox.complete = Some(complete);
                    }
                });
            }
            Err(Error::Stopped) => {}
            Err(error) => {
                shared.problem(&error, None);
                shared.update(|inbox| inbox.quick = state.version);
            }
        }
    }
}

/// Draws each newest state completely, once no hand moves; an input ends that.
pub(crate) fn complete(shared: &Shared) {
    // Seconds of the last complete picture, by its setup and pixels.
    let mut last: Option<(Setup, f64, f64)> = None;
    while let Some(job) = next_complete(shared) {
        let state = &job.state;
        let setup = Setup::of(state);
        let view = &state.scene.view;
        let full = [view.width, view.height];
        let pixels = f64::from(full[0]) * f64::from(full[1]);
        let expected = match &last {
            Some((of, seconds, at)) if *of == setup => seconds * pixels / at,
            _ => f64::INFINITY,
        };
        let half = full.map(|side| side.div_ceil(2));
        let mut stages = vec![full];
        if expected > PATIENCE.as_secs_f64() {
            stages.insert(0, half);
        }
        let mut result = Ok(());
        for size in stages {
            let begun = Instant::now();
            let drawn = draw_stoppable(shared, &job, &setup, size);
            let draw = begun.elapsed();
            result = drawn.and_then(|frame| {
                let is_complete = size == full;
                let kind = if is_complete {
                    Kind::Complete
                } else {
                    Kind::Refining
                };
                send(shared, &job, &setup, &frame, (kind, begun, draw), json!({}))?;
                if is_complete {
                    last = Some((setup.clone(), draw.as_secs_f64(), pixels));
                    let complete = complete_of(shared, &job, &setup, frame);
                    shared.update(|inbox| inbox.complete = Some(complete));
                }
                Ok(())
            });
            if result.is_err() {
                break;
            }
        }
        match result {
            Err(Error::Stopped) => {}
            result => {
                if let Err(error) = result {
                    shared.problem(&error, None);
                }
                shared.update(|inbox| inbox.finished = state.version);
            }
        }
    }
}

/// Waits for a state that was not drawn yet; `None` at the end.
fn next_quick(shared: &Shared) -> Option<Job> {
    let mut inbox = shared.lock();
    while inbox.quick == inbox.state.version && !inbox.is_closing {
        inbox = shared.wait(inbox, LONG);
    }
    (!inbox.is_closing).then(|| Job {
        state: inbox.state.clone(),
        input: inbox.input,
        since: inbox.touched,
    })
}

/// Waits for a state whose quick picture is there, and until no hand moves; `None` at the end.
fn next_complete(shared: &Shared) -> Option<Job> {
    let mut inbox = shared.lock();
    loop {
        if inbox.is_closing {
            return None;
        }
        let version = inbox.state.version;
        let is_open = inbox.finished != version && inbox.quick == version;
        match (is_open, inbox.rests()) {
            (true, Ok(())) => break,
            (true, Err(left)) => inbox = shared.wait(inbox, left),
            (false, _) => inbox = shared.wait(inbox, LONG),
        }
    }
    Some(Job {
        state: inbox.state.clone(),
        input: inbox.input,
        since: inbox.touched,
    })
}

/// Draws a picture that an input may stop.
fn draw_stoppable(
    shared: &Shared,
    job: &Job,
    setup: &Setup,
    size: [u32; 2],
) -> Result<Frame, Error> {
    let state = &job.state;
    let slot = shared.renderers.slot(setup, &shared.used(state));
    let mut slot = slot.lock().unwrap_or_else(PoisonError::into_inner);
    let stop = slot.stop().clone();
    shared.update(|inbox| {
        // An input that came before is not missed, and one that comes now finds the request.
        if inbox.state.version != state.version || inbox.is_closing {
            return Err(Error::Stopped);
        }
        stop.clear();
        inbox.full_stop = Some(stop.clone());
        Ok(())
    })?;
    let drawn = slot.draw(state, &sized(&state.scene.view, size), true);
    shared.update(|inbox| inbox.full_stop = None);
    drawn
}

fn complete_of(shared: &Shared, job: &Job, setup: &Setup, frame: Frame) -> Complete {
    let adapter = shared.renderers.adapter();
    Complete {
        adapter: adapter.filter(|_| setup.algorithm.needs_gpu),
        state: job.state.clone(),
        frame: Arc::new(frame),
        setup: setup.clone(),
    }
}

fn sized(view: &View, [width, height]: [u32; 2]) -> View {
    View {
        width,
        height,
        ..*view
    }
}

/// Encodes a picture and tells of it.
fn send(
    shared: &Shared,
    job: &Job,
    setup: &Setup,
    frame: &Frame,
    (kind, begun, draw): (Kind, Instant, Duration),
    more: serde_json::Value,
) -> Result<(), Error> {
    let view = &job.state.scene.view;
    let caption = Caption {
        id: shared.next_picture(),
        version: job.state.version,
        kind,
        full: [view.width, view.height],
        setup,
        input: job.input,
        waited: begun.saturating_duration_since(job.since),
        draw,
        adapter: shared.renderers.adapter(),
        more,
    };
    let encoded = Encoded::new(frame, caption)?;
    (shared.tell)(Event::Picture(Arc::new(encoded)));
    Ok(())
}
