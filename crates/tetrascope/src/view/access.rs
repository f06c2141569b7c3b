//! Who may ask: the token, the headers of a request, rates.
//!
//! A page of another site that runs in the same browser can send requests here. It does not know
//! the token; should it, the `Origin` of its WebSocket gives it away, and a name of its own that it
//! lets mean this machine (DNS rebinding) is not among the names in `Host`.

use std::net::IpAddr;
use std::time::Instant;

use tetrascope_core::Error;

/// A secret in the address.
#[derive(Clone)]
pub struct Token(String);

/// Random bytes of a token: 2¹²⁸ are not guessed.
const TOKEN_BYTES: usize = 16;

/// The shortest token that is taken from a person, characters.
const SHORTEST: usize = 22;

/// The longest.
const LONGEST: usize = 128;

impl Token {
    /// A new one, from the system's source of randomness.
    ///
    /// # Errors
    /// Where the system has none.
    pub fn random() -> Result<Token, Error> {
        let mut bytes = [0; TOKEN_BYTES];
        getrandom::fill(&mut bytes).map_err(|error| {
            Error::invalid(format!("the system gives no random numbers: {error}"))
        })?;
        Ok(Token(
            bytes.iter().map(|byte| format!("{byte:02x}")).collect(),
        ))
    }

    /// One that a person has chosen, so that an address stays the same.
    ///
    /// # Errors
    /// [`Error::Usage`] for one that could be guessed or does not fit an address.
    pub fn given(text: &str) -> Result<Token, Error> {
        let fits = |c: char| c.is_ascii_alphanumeric() || c == '-' || c == '_';
        if (SHORTEST..=LONGEST).contains(&text.len()) && text.chars().all(fits) {
            return Ok(Token(text.into()));
        }
        Err(Error::Usage {
            what: "the token does not fit".into(),
            help: Some(format!(
                "give {SHORTEST} to {LONGEST} letters, digits, - and _, chosen at random"
            )),
        })
    }

    /// The text, for the address.
    pub fn text(&self) -> &str {
        &self.0
    }

    /// Whether this is the token; takes the same time whichever characters differ.
    pub(crate) fn is(&self, text: &str) -> bool {
        let (own, other) = (self.0.as_bytes(), text.as_bytes());
        let differ = own.iter().zip(other).fold(0, |all, (a, b)| all | (a ^ b));
        std::hint::black_box(differ) == 0 && own.len() == other.len()
    }
}

/// Who may ask, and by which names this machine is known.
#[derive(Clone)]
pub struct Access {
    /// The secret.
    pub token: Token,
    /// Names beside those of the loopback, in lower case; empty where nobody else may ask.
    pub names: Vec<String>,
    /// Whether the server can be reached from other machines, which know it by an address.
    pub is_wide: bool,
}

/// Why a request is refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Refusal {
    Token,
    Host,
    Origin,
}

impl Refusal {
    pub(crate) fn words(self) -> &'static str {
        match self {
            Refusal::Token => {
                "This address lacks the token, or has another one. The viewer has printed the \
                 whole address where it was started."
            }
            Refusal::Host => {
                "The viewer does not go by this name. Use localhost, an address, or the name \
                 given with --host."
            }
            Refusal::Origin => "Another site's page may not use the viewer.",
        }
    }
}

impl Access {
    /// Looks at what a browser says: the host that it asked, and the page that asks, which a
    /// request for the WebSocket must name.
    pub(crate) fn check(
        &self,
        host: Option<&str>,
        origin: Option<&str>,
        is_socket: bool,
    ) -> Result<(), Refusal> {
        let host = host.ok_or(Refusal::Host)?;
        if !self.is_ours(host) {
            return Err(Refusal::Host);
        }
        match origin {
            None if is_socket => Err(Refusal::Origin),
            None => Ok(()),
            // The scheme is that of a proxy, if there is one.
            Some(origin) => {
                let plain = origin.strip_prefix("http://");
                let authority = plain.or(origin.strip_prefix("https://"));
                match authority.is_some_and(|a| a.eq_ignore_ascii_case(host)) {
                    true => Ok(()),
                    false => Err(Refusal::Origin),
                }
            }
        }
    }

    /// Whether `Host` names this machine; a tunnel may have another port.
    fn is_ours(&self, host: &str) -> bool {
        let Some(name) = name_of(host) else {
            return false;
        };
        let name = name.to_ascii_lowercase();
        if name == "localhost" || self.names.contains(&name) {
            return true;
        }
        let address = name.trim_start_matches('[').trim_end_matches(']');
        // A name can be made to mean another machine, an address cannot.
        match address.parse::<IpAddr>() {
            Ok(address) => address.is_loopback() || self.is_wide,
            Err(_) => false,
        }
    }
}

/// The name in "name:port"; `None` for what is neither.
fn name_of(host: &str) -> Option<&str> {
    let is_port = |text: &str| !text.is_empty() && text.bytes().all(|b| b.is_ascii_digit());
    if host.starts_with('[') {
        let (name, rest) = host.split_at(host.find(']')? + 1);
        let port = rest.strip_prefix(':');
        return (rest.is_empty() || port.is_some_and(is_port)).then_some(name);
    }
    match host.split_once(':') {
        None => Some(host),
        Some((name, port)) => is_port(port).then_some(name),
    }
}

/// How many messages come: a bucket that fills at a rate and holds so many.
pub(crate) struct Rate {
    left: f64,
    last: Instant,
}

impl Rate {
    /// Messages in a second: twice what the fastest screens show.
    const PER_SECOND: f64 = 500.0;

    /// At once.
    const BURST: f64 = 1000.0;

    pub(crate) fn new(now: Instant) -> Rate {
        Rate {
            left: Rate::BURST,
            last: now,
        }
    }

    /// Counts one message; whether it may be taken.
    pub(crate) fn take(&mut self, now: Instant) -> bool {
        let passed = now.saturating_duration_since(self.last).as_secs_f64();
        self.last = now;
        self.left = (self.left + passed * Rate::PER_SECOND).min(Rate::BURST);
        if self.left < 1.0 {
            return false;
        }
        self.left -= 1.0;
        true
    }
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use super::*;

    fn access() -> Access {
        Access {
            token: Token::random().expect("random numbers"),
            names: Vec::new(),
            is_wide: false,
        }
    }

    #[test]
    fn tokens_differ_and_only_the_whole_one_is_it() {
        let [a, b] = [(); 2].map(|()| Token::random().expect("random numbers"));
        assert_ne!(a.text(), b.text());
        assert_eq!(a.text().len(), 32);
        assert!(a.is(a.text()) && !a.is(b.text()) && !a.is(""));
        assert!(!a.is(&a.text()[1..]) && !a.is(&format!("{}0", a.text())));
        assert!(!a.is(&a.text()[..31]));
        for weak in ["", "secret", "a/b/c/d/e/f/g/h/i/j/k/l/m", &"x".repeat(129)] {
            assert!(Token::given(weak).is_err(), "{weak}");
        }
        assert!(Token::given("0123456789_abcdefghi-J").is_ok());
    }

    #[test]
    fn names_of_this_machine_alone_are_taken_with_any_port() {
        let mut access = access();
        let is_ours = |access: &Access, host: &str| access.check(Some(host), None, false).is_ok();
        for host in [
            "localhost",
            "localhost:8080",
            "127.0.0.1:1",
            "[::1]:80",
            "LOCALHOST:5",
        ] {
            assert!(is_ours(&access, host), "{host}");
        }
        let others = [
            "evil.example",
            "localhost.evil.example:80",
            "127.0.0.1.evil.example",
            "192.168.0.7:80",
            "node7:80",
            "localhost:",
            "localhost:80:80",
            "localhost:evil",
            "[::1]evil",
            "[::1",
            "",
        ];
        for host in others {
            assert!(!is_ours(&access, host), "{host}");
        }
        access.is_wide = true;
        access.names.push("node7".into());
        assert!(is_ours(&access, "192.168.0.7:80") && is_ours(&access, "Node7:80"));
        assert!(!is_ours(&access, "evil.example"));
        assert_eq!(access.check(None, None, false), Err(Refusal::Host));
    }

    #[test]
    fn a_socket_is_opened_by_our_own_page_alone() {
        let access = access();
        let check = |origin| access.check(Some("localhost:80"), origin, true);
        assert_eq!(check(Some("http://localhost:80")), Ok(()));
        assert_eq!(check(Some("https://localhost:80")), Ok(()));
        for origin in [
            None,
            Some("null"),
            Some(""),
            Some("http://localhost:81"),
            Some("http://evil.example"),
            Some("http://localhost:80.evil.example"),
            Some("file://localhost:80"),
        ] {
            assert_eq!(check(origin), Err(Refusal::Origin), "{origin:?}");
        }
        let plain = access.check(Some("localhost:80"), Some("http://evil.example"), false);
        assert_eq!(plain, Err(Refusal::Origin));
    }

    #[test]
    fn a_flood_is_noticed_and_a_hand_is_not() {
        let start = Instant::now();
        let mut rate = Rate::new(start);
        let hand = |i: u64| start + Duration::from_millis(4 * i);
        assert!((0..5000).all(|i| rate.take(hand(i))));
        let mut rate = Rate::new(start);
        let taken = (0..5000).filter(|_| rate.take(start)).count();
        assert_eq!(taken, 1000);
        assert!(!rate.take(start) && rate.take(start + Duration::from_millis(2)));
    }
}
