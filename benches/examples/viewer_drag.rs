//! Drags in the viewer as a page does, and prints how fast pictures come.
//!
//!     tetrascope view mesh.vtu --no-open --algorithm raycast-cpu      # prints an address
//!     cargo run --release -p tetrascope-benches --example viewer_drag -- ADDRESS [SECONDS] [WIDTHxHEIGHT]
//!
//! The camera is turned 60 times in a second for so many seconds (10), after two seconds of rest, so that
//! the complete picture is there. A picture counts as shown when it has arrived: what a browser takes to
//! unpack it and to show it is not in these figures. Printed are pictures in a second, the time from
//! an input to the first picture that shows it or a later one (median and 95th percentile), the longest time
//! between two pictures, and for each algorithm its pictures, their sizes and what drawing and packing took
//! in the median.

use std::io::ErrorKind;
use std::net::TcpStream;
use std::time::{Duration, Instant};

use serde_json::{Value, json};
use tungstenite::client::IntoClientRequest as _;
use tungstenite::stream::MaybeTlsStream;
use tungstenite::{Error, Message, WebSocket};

type Socket = WebSocket<MaybeTlsStream<TcpStream>>;

/// Time between inputs.
const INPUT: Duration = Duration::from_micros(16_667);

/// The number of a drag's first input.
const FIRST: u64 = 1000;

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let Some(address) = arguments.first() else {
        eprintln!("give the address that `tetrascope view` has printed");
        std::process::exit(2);
    };
    let seconds = arguments.get(1).and_then(|s| s.parse().ok());
    let length = Duration::from_secs_f64(seconds.unwrap_or(10.0));
    let size = arguments.get(2).and_then(|s| s.split_once('x'));
    let (width, height) = size.unwrap_or(("1024", "768"));
    let mut socket = open(address);
    let command = format!(
        "{{\"seq\": 1, \"command\": {{\"do\": \"size\", \"width\": {width}, \"height\": {height}}}}}"
    );
    say(&mut socket, command);
    let mut camera = Value::Null;
    let rested = Instant::now() + Duration::from_secs(2);
    let mut is_complete = false;
    while !is_complete || Instant::now() < rested {
        match next(&mut socket) {
            Some(Told::Text(told)) if told["type"] == "state" => camera = told["camera"].clone(),
            Some(Told::Text(told)) if told["type"] == "problem" => panic!("{told}"),
            Some(Told::Picture(header)) => {
                is_complete = header["kind"] == "complete" && header["seq"] == 1;
            }
            _ => {}
        }
    }
    let drag = drag(&mut socket, &camera, length);
    drag.print(length);
    say(
        &mut socket,
        format!("{{\"seq\": 2, \"command\": {}}}", turned(&camera, 0.0)),
    );
}

/// A message of the server.
enum Told {
    Text(Value),
    /// The header of a picture, which has been confirmed.
    Picture(Value),
}

fn open(address: &str) -> Socket {
    let url = format!("{}ws", address.replacen("http", "ws", 1));
    let mut request = url.into_client_request().expect("an address");
    let host = request.headers()["host"].to_str().expect("text").to_owned();
    let origin = format!("http://{host}").parse().expect("a header");
    request.headers_mut().insert("origin", origin);
    let (socket, _) = tungstenite::connect(request).expect("the viewer answers");
    if let MaybeTlsStream::Plain(stream) = socket.get_ref() {
        let short = Some(Duration::from_millis(1));
        stream.set_read_timeout(short).expect("a timeout");
        stream.set_nodelay(true).expect("an option");
    }
    socket
}

fn say(socket: &mut Socket, text: String) {
    socket.send(Message::text(text)).expect("it is sent");
}

/// The next message, if one comes within a moment.
fn next(socket: &mut Socket) -> Option<Told> {
    match socket.read() {
        Ok(Message::Text(text)) => Some(Told::Text(serde_json::from_str(&text).expect("JSON"))),
        Ok(Message::Binary(bytes)) => {
            let (length, rest) = bytes.split_at(4);
            let length = u32::from_le_bytes(length.try_into().expect("four bytes"));
            let header = &rest[..length as usize];
            let header: Value = serde_json::from_slice(header).expect("JSON");
            say(socket, format!("{{\"shown\":{}}}", header["id"]));
            Some(Told::Picture(header))
        }
        Ok(_) => None,
        Err(Error::Io(error))
            if matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut) =>
        {
            None
        }
        Err(error) => panic!("the viewer is gone: {error}"),
    }
}

/// The camera, turned about the z axis through what it looks at, in radians.
fn turned(camera: &Value, angle: f64) -> String {
    let number = |part: &str, i: usize| camera[part][i].as_f64().expect("a number");
    let (sin, cos) = angle.sin_cos();
    let turn = |[x, y, z]: [f64; 3]| [x * cos - y * sin, x * sin + y * cos, z];
    let focal: [f64; 3] = std::array::from_fn(|i| number("focal_point", i));
    let arm = turn(std::array::from_fn(|i| number("position", i) - focal[i]));
    let up = turn(std::array::from_fn(|i| number("view_up", i)));
    let position: [f64; 3] = std::array::from_fn(|i| focal[i] + arm[i]);
    let mut camera = camera.clone();
    (camera["position"], camera["view_up"]) = (json!(position), json!(up));
    json!({"do": "camera", "camera": camera}).to_string()
}

/// The pictures of a drag, as they arrived.
struct Drag {
    headers: Vec<Value>,
    arrivals: Vec<Instant>,
    latencies: Vec<f64>,
}

fn drag(socket: &mut Socket, camera: &Value, length: Duration) -> Drag {
    let start = Instant::now();
    let mut sent: Vec<Instant> = Vec::new();
    let mut shown = 0;
    let mut drag = Drag {
        headers: Vec::new(),
        arrivals: Vec::new(),
        latencies: Vec::new(),
    };
    while start.elapsed() < length {
        if start.elapsed() >= INPUT * sent.len() as u32 {
            let command = turned(camera, 0.02 * sent.len() as f64);
            let seq = FIRST + sent.len() as u64;
            let message = format!("{{\"seq\": {seq}, \"moving\": true, \"command\": {command}}}");
            sent.push(Instant::now());
            say(socket, message);
        }
        let Some(Told::Picture(header)) = next(socket) else {
            continue;
        };
        let seq = header["seq"].as_u64().unwrap_or(0);
        if seq < FIRST {
            continue;
        }
        let now = Instant::now();
        // All inputs up to this one are shown now.
        let until = (seq - FIRST + 1) as usize;
        let newly = sent[..until].iter().skip(shown);
        drag.latencies
            .extend(newly.map(|at| 1e3 * (now - *at).as_secs_f64()));
        shown = shown.max(until);
        drag.headers.push(header);
        drag.arrivals.push(now);
    }
    drag
}

impl Drag {
    fn print(&self, length: Duration) {
        let count = self.headers.len();
        let gaps = self
            .arrivals
            .windows(2)
            .map(|pair| 1e3 * (pair[1] - pair[0]).as_secs_f64());
        println!(
            "{:.1} pictures in a second ({count} in {:.0} s); latency {:.0} ms, 95th percentile {:.0} ms; \
             at most {:.0} ms between pictures",
            count as f64 / length.as_secs_f64(),
            length.as_secs_f64(),
            quantile(&self.latencies, 0.5),
            quantile(&self.latencies, 0.95),
            gaps.fold(0.0, f64::max),
        );
        let mut names: Vec<&str> = self
            .headers
            .iter()
            .filter_map(|h| h["algorithm"].as_str())
            .collect();
        names.sort_unstable();
        names.dedup();
        for name in names {
            let of = self.headers.iter().filter(|h| h["algorithm"] == name);
            let of: Vec<&Value> = of.collect();
            let all =
                |key: &str| -> Vec<f64> { of.iter().filter_map(|h| h[key].as_f64()).collect() };
            let mut sizes: Vec<(u64, String)> = of
                .iter()
                .map(|h| {
                    let side = |i: usize| h["size"][i].as_u64().unwrap_or(0);
                    (side(0) * side(1), format!("{}x{}", side(0), side(1)))
                })
                .collect();
            sizes.sort_unstable();
            println!(
                "  {name}: {} pictures, {} (from {} to {}), drawn in {:.1} ms, packed in {:.1} ms",
                of.len(),
                sizes[sizes.len() / 2].1,
                sizes[0].1,
                sizes[sizes.len() - 1].1,
                quantile(&all("draw_ms"), 0.5),
                quantile(&all("encode_ms"), 0.5),
            );
        }
    }
}

fn quantile(numbers: &[f64], share: f64) -> f64 {
    let mut sorted = numbers.to_vec();
    sorted.sort_by(f64::total_cmp);
    let at = share * sorted.len().saturating_sub(1) as f64;
    sorted.get(at.round() as usize).copied().unwrap_or(f64::NAN)
}
