//! The server: HTTP for the page and what a person saves, a WebSocket for pictures and input.

use std::net::{IpAddr, SocketAddr};
use std::sync::atomic::{AtomicU64, AtomicUsize, Ordering};
use std::sync::{Arc, PoisonError, RwLock};
use std::time::Duration;

use axum::Router;
use axum::body::Body;
use axum::extract::ws::WebSocketUpgrade;
use axum::extract::{FromRequestParts as _, Request, State as Shared};
use axum::http::header::{self, HeaderMap, HeaderName, HeaderValue};
use axum::http::{Method, Response, StatusCode};
use serde_json::{Value, json};
use tetrascope_core::Error;
use tokio::sync::{broadcast, watch};

use super::access::{Access, Refusal};
use super::encoded::Encoded;
use super::picture::{PictureFormat, command_line, stem};
use super::session::{Event, Session};
use super::{client, describe, listener, page};

/// The longest message of a page: a scene file of the greatest length in JSON.
const LONGEST_MESSAGE: usize = 3 << 20;

/// More pages at once are refused.
const MOST_CLIENTS: usize = 8;

/// A picture that is to be saved is waited for so long.
const PATIENCE: Duration = Duration::from_secs(600);

/// The content policy of pages: they load only what is from here.
const POLICY: &str = "default-src 'none'; script-src 'self'; style-src 'self'; \
                      img-src 'self' blob:; connect-src 'self'; base-uri 'none'; \
                      form-action 'none'; frame-ancestors 'none'";

/// The newest event of each kind of a session, for all pages.
pub struct Hub {
    pub(crate) states: watch::Sender<Option<Value>>,
    pub(crate) pictures: watch::Sender<Option<Arc<Encoded>>>,
    pub(crate) estimates: watch::Sender<Option<Value>>,
    /// Events that are told once: problems, notes, progress.
    pub(crate) news: broadcast::Sender<Value>,
    /// Names this run, so that a page knows another one.
    pub(crate) run: u64,
    clients: AtomicUsize,
    next_client: AtomicU64,
}

impl Default for Hub {
    fn default() -> Hub {
        let now = std::time::SystemTime::now().duration_since(std::time::UNIX_EPOCH);
        Hub {
            states: watch::Sender::new(None),
            pictures: watch::Sender::new(None),
            estimates: watch::Sender::new(None),
            news: broadcast::Sender::new(256),
            run: now.map_or(0, |now| now.as_nanos() as u64 >> 10),
            clients: AtomicUsize::new(0),
            next_client: AtomicU64::new(0),
        }
    }
}

impl Hub {
    /// The function that a session calls with its events.
    pub fn teller(self: &Arc<Hub>) -> impl Fn(Event) + Send + Sync + use<> {
        let hub = self.clone();
        move |event| match event {
            Event::State(state, by, is_moving) => {
                let told = match is_moving {
                    true => describe::camera(&state, by),
                    false => describe::state(&state, by),
                };
                hub.states.send_replace(Some(told));
            }
            Event::Picture(picture) => {
                hub.pictures.send_replace(Some(picture));
            }
            Event::Estimate(estimate) => {
                let estimate = json!({"type": "estimate", "estimate": *estimate});
                hub.estimates.send_replace(Some(estimate));
            }
            Event::Progress(version, share) => hub.say(json!({
                "type": "progress",
                "version": version,
                "share": share,
            })),
            Event::Problem(message, help, client) => hub.say(json!({
                "type": "problem",
                "message": message,
                "help": help,
                "client": client,
            })),
            Event::Note(message, client) => hub.say(json!({
                "type": "note",
                "message": message,
                "client": client,
            })),
        }
    }

    fn say(&self, news: Value) {
        // Without a page there is nobody to tell.
        let _ = self.news.send(news);
    }

    /// How many pages there are.
    pub(crate) fn clients(&self) -> usize {
        self.clients.load(Ordering::Relaxed)
    }

    /// Lets a page in, unless there are too many.
    pub(crate) fn enter(self: &Arc<Hub>) -> Option<Seat> {
        let count = self.clients.fetch_add(1, Ordering::Relaxed);
        let seat = Seat {
            hub: self.clone(),
            client: self.next_client.fetch_add(1, Ordering::Relaxed) + 1,
        };
        (count < MOST_CLIENTS).then_some(seat)
    }
}

/// A page's place, free again when it is dropped.
pub(crate) struct Seat {
    hub: Arc<Hub>,
    pub(crate) client: u64,
}

impl Drop for Seat {
    fn drop(&mut self) {
        self.hub.clients.fetch_sub(1, Ordering::Relaxed);
    }
}

/// A server that has its address, and answers once it runs.
pub struct Server {
    listener: std::net::TcpListener,
    address: SocketAddr,
}

impl Server {
    /// Takes an address; port 0 is any that is free.
    ///
    /// # Errors
    /// [`Error::Usage`] where the address cannot be had.
    pub fn bind(host: IpAddr, port: u16) -> Result<Server, Error> {
        let bind = || -> std::io::Result<Server> {
            let listener = std::net::TcpListener::bind((host, port))?;
            listener.set_nonblocking(true)?;
            let address = listener.local_addr()?;
            Ok(Server { listener, address })
        };
        bind().map_err(|error| Error::Usage {
            what: format!("cannot listen at {host}, port {port}: {error}"),
            help: Some("give another --port, or none for any that is free".into()),
        })
    }

    /// Where it listens.
    pub fn address(&self) -> SocketAddr {
        self.address
    }

    /// The address of the page, with the token, for a browser on this machine.
    pub fn url(&self, access: &Access) -> String {
        let host = match self.address.ip() {
            ip if ip.is_unspecified() => "127.0.0.1".into(),
            IpAddr::V6(ip) => format!("[{ip}]"),
            ip => ip.to_string(),
        };
        format!(
            "http://{host}:{}/{}/",
            self.address.port(),
            access.token.text()
        )
    }
}

/// The data that every request sees.
#[derive(Clone)]
struct App {
    access: Arc<Access>,
    session: Arc<Session>,
    hub: Arc<Hub>,
    catalog: Arc<RwLock<Value>>,
}

/// Answers until the process ends.
///
/// # Errors
/// A system that gives no sockets.
pub fn serve(
    server: Server,
    access: Access,
    session: Arc<Session>,
    hub: Arc<Hub>,
) -> Result<(), Error> {
    let failed = |error: std::io::Error| Error::invalid(format!("the server ends: {error}"));
    hub.states.send_if_modified(|state| match state {
        Some(_) => false,
        None => {
            *state = Some(describe::state(&session.state(), None));
            true
        }
    });
    let app = App {
        access: Arc::new(access),
        catalog: Arc::new(RwLock::new(describe::catalog())),
        session,
        hub,
    };
    let runtime = tokio::runtime::Builder::new_current_thread()
        .enable_all()
        .build();
    runtime.map_err(failed)?.block_on(async {
        let listener = tokio::net::TcpListener::from_std(server.listener).map_err(failed)?;
        let listener = listener::Limited::new(listener);
        let router = Router::new().fallback(answer).with_state(app);
        axum::serve(listener, router).await.map_err(failed)
    })
}

/// Answers a request: whoever may not ask learns that alone.
async fn answer(Shared(app): Shared<App>, request: Request) -> Response<Body> {
    // What is kept while something is waited for does not borrow the request.
    let path = request.uri().path().to_owned();
    let mut parts = path.strip_prefix('/').unwrap_or(&path).splitn(2, '/');
    let (token, name) = (parts.next().unwrap_or(""), parts.next());
    let is_socket = name == Some("ws");
    let allowed = {
        let text = |name: HeaderName| header_text(request.headers(), name);
        let (host, origin) = (text(header::HOST), text(header::ORIGIN));
        app.access.check(host, origin, is_socket)
    };
    if let Err(refusal) = allowed {
        return refused(refusal);
    }
    if !app.access.token.is(token) {
        return refused(Refusal::Token);
    }
    let Some(name) = name else {
        // Without the slash, names beside the page would lack the token.
        let place = HeaderValue::from_str(&format!("/{token}/"));
        let mut response = plain(
            StatusCode::PERMANENT_REDIRECT,
            "The page has a / at its end.",
        );
        if let Ok(place) = place {
            response.headers_mut().insert(header::LOCATION, place);
        }
        return response;
    };
    if request.method() != Method::GET {
        return plain(
            StatusCode::METHOD_NOT_ALLOWED,
            "Nothing is sent here but by the page.",
        );
    }
    if is_socket {
        return socket(app, request).await;
    }
    if let Some((media, bytes)) = page::file(name) {
        return file(media, bytes.into(), None);
    }
    saved(&app, name).await
}

/// Opens a WebSocket.
async fn socket(app: App, request: Request) -> Response<Body> {
    let (mut parts, _) = request.into_parts();
    let upgrade = match WebSocketUpgrade::from_request_parts(&mut parts, &()).await {
        Ok(upgrade) => upgrade,
        Err(_) => return plain(StatusCode::BAD_REQUEST, "A WebSocket is opened here."),
    };
    let catalog = app
        .catalog
        .read()
        .unwrap_or_else(PoisonError::into_inner)
        .clone();
    let upgrade = upgrade
        .max_message_size(LONGEST_MESSAGE)
        .max_frame_size(LONGEST_MESSAGE);
    secured(upgrade.on_upgrade(move |socket| client::run(socket, app.session, app.hub, catalog)))
}

/// The file that a person saves.
async fn saved(app: &App, name: &str) -> Response<Body> {
    let state = app.session.state();
    let stem = stem(&state);
    let text = |extension: &str, text: String| {
        let media = "text/plain; charset=utf-8";
        file(media, text.into(), Some(format!("{stem}.{extension}")))
    };
    match name {
        "scene.toml" => return text("toml", state.scene.to_toml()),
        "scene.json" => {
            let scene = serde_json::to_string_pretty(&state.scene.to_file());
            return text("json", scene.expect("a scene is JSON"));
        }
        "preset.json" => return text("preset.json", state.look.preset.to_json()),
        "command.txt" => return text("sh", command_line(&state)),
        _ => {}
    }
    let format = name.strip_prefix("picture.");
    let format = PictureFormat::ALL
        .into_iter()
        .find(|(_, e, _)| Some(*e) == format);
    let Some((format, extension, media)) = format else {
        return plain(StatusCode::NOT_FOUND, "There is nothing here.");
    };
    let session = app.session.clone();
    let encode = move || session.complete(PATIENCE).and_then(|c| format.encode(&c));
    match tokio::task::spawn_blocking(encode).await {
        Ok(Ok(bytes)) => file(media, bytes.into(), Some(format!("{stem}.{extension}"))),
        Ok(Err(error)) => plain(StatusCode::CONFLICT, &error.to_string()),
        Err(_) => plain(
            StatusCode::INTERNAL_SERVER_ERROR,
            "The picture could not be made.",
        ),
    }
}

fn header_text(headers: &HeaderMap, name: HeaderName) -> Option<&str> {
    let mut values = headers.get_all(name).iter();
    let value = values.next()?;
    // Of two, each reader may believe another.
    match values.next() {
        None => value.to_str().ok(),
        Some(_) => Some(""),
    }
}

fn refused(refusal: Refusal) -> Response<Body> {
    plain(StatusCode::FORBIDDEN, refusal.words())
}

fn plain(status: StatusCode, words: &str) -> Response<Body> {
    let mut response = file(
        "text/plain; charset=utf-8",
        format!("{words}\n").into(),
        None,
    );
    *response.status_mut() = status;
    response
}

/// A file, to be shown, or to be saved by a name.
fn file(media: &'static str, bytes: Body, save_as: Option<String>) -> Response<Body> {
    let mut response = Response::new(bytes);
    let headers = response.headers_mut();
    headers.insert(header::CONTENT_TYPE, HeaderValue::from_static(media));
    let disposition = save_as.map(|name| format!("attachment; filename=\"{name}\""));
    if let Some(Ok(disposition)) = disposition.map(|d| HeaderValue::from_str(&d)) {
        headers.insert(header::CONTENT_DISPOSITION, disposition);
    }
    secured(response)
}

fn secured(mut response: Response<Body>) -> Response<Body> {
    let headers = response.headers_mut();
    for (name, value) in [
        (header::CONTENT_SECURITY_POLICY, POLICY),
        (header::X_CONTENT_TYPE_OPTIONS, "nosniff"),
        (header::REFERRER_POLICY, "no-referrer"),
        (header::CACHE_CONTROL, "no-store"),
        (
            HeaderName::from_static("cross-origin-resource-policy"),
            "same-origin",
        ),
        (
            HeaderName::from_static("cross-origin-opener-policy"),
            "same-origin",
        ),
    ] {
        headers.insert(name, HeaderValue::from_static(value));
    }
    response
}
