//! Who may see the page: requests by an allowed host name, from no other page.

use std::net::{IpAddr, SocketAddr};

use axum::http::header::{
    CACHE_CONTROL, CONTENT_SECURITY_POLICY, HOST, HeaderMap, HeaderName, HeaderValue, ORIGIN,
    REFERRER_POLICY, X_CONTENT_TYPE_OPTIONS,
};

/// The page loads its own scripts and styles, talks to its own server, and nothing else.
const POLICY: &str = "default-src 'none'; script-src 'self'; style-src 'self'; \
     connect-src 'self'; img-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'";
/// The same for the page of one limb of several, which the robot's page has in a frame.
const FRAMED_POLICY: &str = "default-src 'none'; script-src 'self'; style-src 'self'; \
     connect-src 'self'; img-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'self'";
/// The robot's page has frames of its own server, and talks to nobody.
const ROBOT_POLICY: &str = "default-src 'none'; script-src 'self'; style-src 'self'; \
     frame-src 'self'; img-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'";

/// What an answer may do in a browser.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Policy {
    /// Everything but the two pages below.
    Plain,
    /// A limb's page, in a frame of the robot's.
    Framed,
    /// The page of a robot, with its limbs in frames.
    Robot,
}

/// The hosts, with port, that the page may be asked by.
#[derive(Debug)]
pub(crate) struct Guard {
    hosts: Vec<String>,
}

impl Guard {
    /// For a server that listens at `address`, with further host names.
    pub(crate) fn new(address: SocketAddr, further: &[String]) -> Self {
        let mut names: Vec<String> = further.to_vec();
        if !address.ip().is_unspecified() {
            names.push(host_of(address.ip()));
        }
        if address.ip().is_loopback() {
            names.extend(["localhost", "127.0.0.1", "[::1]"].map(str::to_owned));
        }
        let port = address.port();
        let mut hosts: Vec<String> =
            names.iter().map(|name| format!("{}:{port}", name.to_ascii_lowercase())).collect();
        if port == 80 {
            hosts.extend(names.iter().map(|name| name.to_ascii_lowercase()));
        }
        Self { hosts }
    }

    /// Whether a request with these headers is answered; a page of another origin that points a name
    /// of its own at this machine is not.
    pub(crate) fn allows(&self, headers: &HeaderMap) -> bool {
        let Some(host) = only(headers, &HOST) else {
            return false;
        };
        if !self.knows(host) {
            return false;
        }
        if !headers.contains_key(ORIGIN) {
            return true;
        }
        only(headers, &ORIGIN)
            .and_then(|origin| origin.strip_prefix("http://"))
            .is_some_and(|origin| self.knows(origin))
    }

    fn knows(&self, host: &str) -> bool {
        self.hosts.iter().any(|known| known.eq_ignore_ascii_case(host))
    }
}

/// The headers of every answer.
pub(crate) fn headers(policy: Policy) -> [(HeaderName, HeaderValue); 5] {
    let policy = match policy {
        Policy::Plain => POLICY,
        Policy::Framed => FRAMED_POLICY,
        Policy::Robot => ROBOT_POLICY,
    };
    [
        (CONTENT_SECURITY_POLICY, HeaderValue::from_static(policy)),
        (X_CONTENT_TYPE_OPTIONS, HeaderValue::from_static("nosniff")),
        (REFERRER_POLICY, HeaderValue::from_static("no-referrer")),
        (CACHE_CONTROL, HeaderValue::from_static("no-store")),
        (
            HeaderName::from_static("cross-origin-resource-policy"),
            HeaderValue::from_static("same-origin"),
        ),
    ]
}

/// An address as it stands in a URL.
pub(crate) fn host_of(address: IpAddr) -> String {
    match address {
        IpAddr::V4(address) => address.to_string(),
        IpAddr::V6(address) => format!("[{address}]"),
    }
}

/// The value of a header that is there once.
fn only<'a>(headers: &'a HeaderMap, name: &HeaderName) -> Option<&'a str> {
    let mut values = headers.get_all(name).iter();
    let first = values.next()?.to_str().ok()?;
    values.next().is_none().then_some(first)
}

#[cfg(test)]
mod tests {
    use axum::http::header::{HOST, HeaderMap, HeaderValue, ORIGIN};

    use super::Guard;

    fn allows(address: &str, further: &[&str], hosts: &[&str], origins: &[&str]) -> bool {
        let further: Vec<String> = further.iter().map(|&name| name.to_owned()).collect();
        let mut headers = HeaderMap::new();
        for host in hosts {
            headers.append(HOST, HeaderValue::from_str(host).unwrap());
        }
        for origin in origins {
            headers.append(ORIGIN, HeaderValue::from_str(origin).unwrap());
        }
        Guard::new(address.parse().unwrap(), &further).allows(&headers)
    }

    #[track_caller]
    fn check(hosts: &[&str], origins: &[&str], expected: bool) {
        let found = allows("127.0.0.1:7717", &[], hosts, origins);
        assert_eq!(found, expected, "{hosts:?} {origins:?}");
    }

    #[test]
    fn own_names_with_the_port() {
        check(&["127.0.0.1:7717"], &[], true);
        check(&["LOCALHOST:7717"], &["http://localhost:7717"], true);
        check(&["[::1]:7717"], &["http://127.0.0.1:7717"], true);
    }

    #[test]
    fn other_names_and_ports_are_refused() {
        check(&[], &[], false);
        check(&["127.0.0.1"], &[], false);
        check(&["127.0.0.1:7718"], &[], false);
        check(&["evil.example:7717"], &[], false);
        check(&["127.0.0.1:7717.evil.example"], &[], false);
        check(&["127.0.0.1:7717", "evil.example"], &[], false);
    }

    #[test]
    fn other_origins_are_refused() {
        for origin in [
            "null",
            "http://evil.example",
            "http://evil.example:7717",
            "https://127.0.0.1:7717",
            "http://127.0.0.1",
            "http://127.0.0.1:7717.evil.example",
            "",
        ] {
            check(&["127.0.0.1:7717"], &[origin], false);
        }
        let twice = ["http://127.0.0.1:7717", "http://evil.example"];
        check(&["127.0.0.1:7717"], &twice, false);
    }

    #[test]
    fn beyond_loopback_only_what_is_named() {
        let ask = |host: &str| allows("0.0.0.0:80", &["Lab-PC.local"], &[host], &[]);
        assert!(ask("lab-pc.local:80") && ask("lab-pc.local"));
        assert!(!ask("localhost:80") && !ask("0.0.0.0:80") && !ask("127.0.0.1:80"));
        assert!(allows("192.168.1.5:7717", &[], &["192.168.1.5:7717"], &[]));
    }
}
