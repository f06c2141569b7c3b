//! A page of the browser, by the Chrome DevTools protocol.

use std::net::TcpStream;
use std::time::{Duration, Instant};

use serde_json::{Value, json};
use tungstenite::stream::MaybeTlsStream;
use tungstenite::{Message, WebSocket};

use crate::program::PATIENCE;

/// A tab.
pub(crate) struct Tab {
    socket: WebSocket<MaybeTlsStream<TcpStream>>,
    session: String,
    next: u64,
}

impl Tab {
    /// Opens a page.
    pub(crate) fn open(endpoint: &str, url: &str) -> Tab {
        let (socket, _) = tungstenite::connect(endpoint).expect("the browser answers");
        if let MaybeTlsStream::Plain(stream) = socket.get_ref() {
            stream.set_read_timeout(Some(PATIENCE)).expect("a timeout");
        }
        let mut tab = Tab {
            socket,
            session: String::new(),
            next: 0,
        };
        let target = tab.call("Target.createTarget", json!({"url": "about:blank"}));
        let target = json!({"targetId": target["targetId"], "flatten": true});
        let session = tab.call("Target.attachToTarget", target);
        tab.session = session["sessionId"].as_str().expect("a session").into();
        tab.call("Page.enable", json!({}));
        tab.call("Runtime.enable", json!({}));
        let screen = json!({"width": 1280, "height": 720, "deviceScaleFactor": 1, "mobile": false});
        tab.call("Emulation.setDeviceMetricsOverride", screen);
        tab.go(url);
        tab
    }

    pub(crate) fn go(&mut self, url: &str) {
        self.call("Page.navigate", json!({"url": url}));
    }

    /// Calls a method of the protocol.
    pub(crate) fn call(&mut self, method: &str, parameters: Value) -> Value {
        self.next += 1;
        let id = self.next;
        let mut message = json!({"id": id, "method": method, "params": parameters});
        if !self.session.is_empty() {
            message["sessionId"] = json!(self.session);
        }
        self.socket
            .send(Message::text(message.to_string()))
            .expect("it is sent");
        loop {
            let Message::Text(text) = self.socket.read().expect("the browser answers") else {
                continue;
            };
            let answer: Value = serde_json::from_str(&text).expect("JSON");
            if answer["id"] == id {
                assert!(answer["error"].is_null(), "{method}: {}", answer["error"]);
                return answer["result"].clone();
            }
            let exception = &answer["params"]["exceptionDetails"];
            assert!(exception.is_null(), "the page fails: {exception}");
        }
    }

    /// The value of an expression in the page.
    pub(crate) fn value(&mut self, expression: &str) -> Value {
        let result = self.call(
            "Runtime.evaluate",
            json!({"expression": expression, "awaitPromise": true, "returnByValue": true}),
        );
        let exception = &result["exceptionDetails"];
        assert!(exception.is_null(), "{expression}: {exception}");
        result["result"]["value"].clone()
    }

    /// Waits until an expression in the page is true.
    pub(crate) fn until(&mut self, expression: &str) {
        let start = Instant::now();
        // While a page loads, nothing of it is there yet.
        let tried = format!(
            "(() => {{ try {{ return Boolean({expression}); }} catch {{ return false; }} }})()"
        );
        while self.value(&tried) != true {
            assert!(start.elapsed() < PATIENCE, "never: {expression}");
            std::thread::sleep(Duration::from_millis(20));
        }
    }

    /// Presses, moves in steps and releases the mouse; `between` runs while it is pressed.
    pub(crate) fn drag(&mut self, from: [f64; 2], to: [f64; 2], mut between: impl FnMut(&mut Tab)) {
        const STEPS: u32 = 12;
        let event = |kind: &str, [x, y]: [f64; 2]| json!({"type": kind, "x": x, "y": y, "button": "left", "buttons": 1, "clickCount": 1});
        self.call("Input.dispatchMouseEvent", event("mousePressed", from));
        for step in 1..=STEPS {
            let s = f64::from(step) / f64::from(STEPS);
            let place = [0, 1].map(|i| from[i] * (1.0 - s) + to[i] * s);
            self.call("Input.dispatchMouseEvent", event("mouseMoved", place));
            between(self);
        }
        self.call("Input.dispatchMouseEvent", event("mouseReleased", to));
    }

    /// Types a key without text.
    pub(crate) fn key(&mut self, key: &str) {
        for kind in ["rawKeyDown", "keyUp"] {
            self.call("Input.dispatchKeyEvent", json!({"type": kind, "key": key}));
        }
    }

    /// The screen, as a PNG file in base64.
    pub(crate) fn screenshot(&mut self) -> String {
        let shot = self.call("Page.captureScreenshot", json!({"format": "png"}));
        shot["data"].as_str().expect("a picture").into()
    }
}
