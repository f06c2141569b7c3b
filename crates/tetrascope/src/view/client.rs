//! One page: its input comes in, the newest pictures go out.
//!
//! A page says when a picture is on its screen, and only then gets the next: pictures do not queue
//! up in a tunnel, and the resolution of those to come follows from how long that takes.

use std::sync::Arc;
use std::time::{Duration, Instant};

use axum::extract::ws::{CloseFrame, Message as Frame, Utf8Bytes, WebSocket, close_code};
use futures_util::{SinkExt as _, StreamExt as _};
use serde_json::{Value, json};
use tokio::sync::{broadcast, mpsc};

use super::access::Rate;
use super::command::Message;
use super::describe;
use super::encoded::{Encoded, Kind};
use super::server::Hub;
use super::session::Session;

/// A page that does not say that a picture is shown gets the next after this time.
const FORGETFUL: Duration = Duration::from_secs(3);

/// Answers to one page that wait to be sent.
const ANSWERS: usize = 64;

/// Parts of a histogram.
const BINS: usize = 256;

/// Messages of the reading half to the writing half.
enum Inner {
    /// A picture is on the screen.
    Shown(u64),
    Answer(Value),
    /// The end, with words.
    Close(u16, &'static str),
}

/// Serves a page until it goes.
pub(crate) async fn run(
    mut socket: WebSocket,
    session: Arc<Session>,
    hub: Arc<Hub>,
    catalog: Value,
) {
    let Some(seat) = hub.enter() else {
        let words = "too many pages look at this viewer; close one of them";
        let _ = socket.send(close(close_code::AGAIN, words)).await;
        return;
    };
    let is_first = hub.clients() == 1;
    let hello = json!({
        "type": "hello",
        "client": seat.client,
        "run": hub.run.to_string(),
        "is_first": is_first,
        "catalog": catalog,
    });
    if socket.send(text(&hello)).await.is_err() {
        return;
    }
    let (mut sink, mut stream) = socket.split();
    let (inner, mut answers) = mpsc::channel::<Inner>(ANSWERS);

    let reading = async {
        let mut rate = Rate::new(Instant::now());
        while let Some(received) = stream.next().await {
            let message = match received {
                Ok(Frame::Text(message)) => message,
                Ok(Frame::Binary(_)) => {
                    let end = Inner::Close(close_code::UNSUPPORTED, "messages are text");
                    let _ = inner.send(end).await;
                    break;
                }
                Ok(Frame::Close(_)) => break,
                Ok(Frame::Ping(_) | Frame::Pong(_)) => continue,
                // Also one that is too long.
                Err(_) => {
                    let end = Inner::Close(close_code::SIZE, "a message is too long");
                    let _ = inner.send(end).await;
                    break;
                }
            };
            if !rate.take(Instant::now()) {
                let end = Inner::Close(close_code::POLICY, "too many messages");
                let _ = inner.send(end).await;
                break;
            }
            if let Some(shown) = shown_alone(&message) {
                let _ = inner.send(Inner::Shown(shown)).await;
                continue;
            }
            let (session, client) = (session.clone(), seat.client);
            let answer = move || answer(&session, client, &message);
            // Commands may look at a whole mesh.
            let answers = tokio::task::spawn_blocking(answer)
                .await
                .unwrap_or_default();
            for answer in answers {
                let _ = inner.send(Inner::Answer(answer)).await;
            }
        }
        // Lets the writer say why before both end.
        tokio::time::sleep(Duration::from_millis(100)).await;
    };

    let writing = async {
        let mut states = hub.states.subscribe();
        let mut pictures = hub.pictures.subscribe();
        let mut estimates = hub.estimates.subscribe();
        let mut news = hub.news.subscribe();
        let mut field = 0;
        let mut sent: Option<(u64, [u32; 2], Kind, Instant)> = None;
        // Tell what there is already.
        states.mark_changed();
        pictures.mark_changed();
        estimates.mark_changed();
        loop {
            let patience = sent.map(|(.., at)| (at + FORGETFUL).into());
            let forgetful = async {
                match patience {
                    Some(until) => tokio::time::sleep_until(until).await,
                    None => std::future::pending().await,
                }
            };
            tokio::select! {
                biased;
                inner = answers.recv() => match inner {
                    Some(Inner::Shown(id)) => {
                        if let Some((of, size, kind, at)) = sent
                            && of == id
                        {
                            if kind == Kind::Quick {
                                session.delivered(size, at.elapsed());
                            }
                            sent = None;
                        }
                    }
                    Some(Inner::Answer(answer)) => sink.send(text(&answer)).await?,
                    Some(Inner::Close(code, words)) => {
                        sink.send(close(code, words)).await?;
                        break;
                    }
                    None => break,
                },
                changed = states.changed() => {
                    if changed.is_err() {
                        break;
                    }
                    let state = states.borrow_and_update().clone();
                    let Some(state) = state else { continue };
                    // Tell news of a volume before its state.
                    if state["field_id"].as_u64() != Some(field) {
                        let now = session.state();
                        field = now.field.id;
                        sink.send(text(&describe::field(&now, session.steps()))).await?;
                    }
                    sink.send(text(&state)).await?;
                }
                changed = pictures.changed(), if sent.is_none() => {
                    if changed.is_err() {
                        break;
                    }
                    let picture = pictures.borrow_and_update().clone();
                    let Some(picture) = picture else { continue };
                    sent = Some((picture.id, picture.size, picture.kind, Instant::now()));
                    sink.send(binary(&picture)).await?;
                }
                changed = estimates.changed() => {
                    if changed.is_err() {
                        break;
                    }
                    let estimate = estimates.borrow_and_update().clone();
                    if let Some(estimate) = estimate {
                        sink.send(text(&estimate)).await?;
                    }
                }
                said = news.recv() => match said {
                    Ok(said) => {
                        let of = said["client"].as_u64();
                        if of.is_none_or(|of| of == seat.client) {
                            sink.send(text(&said)).await?;
                        }
                    }
                    Err(broadcast::error::RecvError::Lagged(_)) => {}
                    Err(broadcast::error::RecvError::Closed) => break,
                },
                () = forgetful => sent = None,
            }
        }
        sink.close().await?;
        Ok::<(), axum::Error>(())
    };
    tokio::select! {
        () = reading => {}
        _ = writing => {}
    }
    session.rest();
}

/// The picture of a message that says nothing but that it is shown.
fn shown_alone(message: &str) -> Option<u64> {
    let rest = message.strip_prefix("{\"shown\":")?.strip_suffix('}')?;
    rest.parse().ok()
}

/// Does what a message asks for, and answers.
fn answer(session: &Session, client: u64, message: &str) -> Vec<Value> {
    let message: Message = match serde_json::from_str(message) {
        Ok(message) => message,
        Err(error) => {
            return vec![json!({
                "type": "problem",
                "message": format!("a message of the page is not understood: {error}"),
                "help": "load the page again",
                "client": client,
            })];
        }
    };
    let mut answers = Vec::new();
    if let Some([low, high]) = message.histogram {
        let values = &session.state().field.values;
        if low.is_finite() && high.is_finite() && low <= high {
            answers.push(json!({
                "type": "histogram",
                "low": low,
                "high": high,
                "counts": values.histogram((low, high), BINS),
            }));
        }
    }
    if let Err(error) = session.take(client, &message) {
        answers.push(json!({
            "type": "problem",
            "message": error.to_string(),
            "help": crate::help(&error),
            "seq": message.seq,
            "client": client,
            // Put right what the page shows.
            "state": describe::state(&session.state(), None),
        }));
    }
    for note in describe::notes(&message) {
        answers.push(json!({"type": "note", "message": note, "client": client}));
    }
    answers
}

fn text(value: &Value) -> Frame {
    Frame::Text(Utf8Bytes::from(value.to_string()))
}

fn binary(picture: &Encoded) -> Frame {
    Frame::Binary(picture.bytes.clone().into())
}

fn close(code: u16, words: &'static str) -> Frame {
    Frame::Close(Some(CloseFrame {
        code,
        reason: Utf8Bytes::from_static(words),
    }))
}
