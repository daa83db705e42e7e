//! Where the page is served and what it offers.

use std::net::{Ipv4Addr, SocketAddr};
use std::time::Duration;

use crate::error::ViewError;
use crate::offers::Offers;
use crate::token::Token;

/// Where the page is served and what it offers.
#[derive(Clone, Debug)]
pub struct ViewParams {
    /// Address and port; port 0 takes any free one.
    pub bind: SocketAddr,
    /// Further host names or addresses, without port, that browsers may ask for. Needed when `bind` is
    /// the unspecified address.
    pub allowed_hosts: Vec<String>,
    /// The token; `None` makes a new one.
    pub token: Option<Token>,
    /// What the page can ask for.
    pub offers: Offers,
    /// A page that answers no ping for so long is let go, and its place is free.
    pub patience: Duration,
}

impl Default for ViewParams {
    /// Loopback, port 7717, a new token, no offers, a patience of 30 s.
    fn default() -> Self {
        Self {
            bind: SocketAddr::from((Ipv4Addr::LOCALHOST, 7717)),
            allowed_hosts: Vec::new(),
            token: None,
            offers: Offers::default(),
            patience: Duration::from_secs(30),
        }
    }
}

impl ViewParams {
    pub(crate) fn check(&self) -> Result<(), ViewError> {
        if self.bind.ip().is_unspecified() && self.allowed_hosts.is_empty() {
            return Err(ViewError::NoHostNamed { address: self.bind });
        }
        if let Some(found) = self.allowed_hosts.iter().find(|host| !is_host(host)) {
            return Err(ViewError::BadHost { found: found.clone() });
        }
        if self.patience.is_zero() {
            return Err(ViewError::NoPatience);
        }
        self.offers.check()
    }
}

/// A name, an IPv4 address, or an IPv6 address in brackets.
fn is_host(host: &str) -> bool {
    let inner = host.strip_prefix('[').and_then(|rest| rest.strip_suffix(']'));
    match inner {
        Some(address) => address.parse::<std::net::Ipv6Addr>().is_ok(),
        None => {
            !host.is_empty()
                && host
                    .bytes()
                    .all(|byte| byte.is_ascii_alphanumeric() || byte == b'-' || byte == b'.')
        }
    }
}

#[cfg(test)]
mod tests {
    use super::ViewParams;
    use crate::error::ViewError;

    fn with_hosts(bind: &str, hosts: &[&str]) -> Result<(), ViewError> {
        let params = ViewParams {
            bind: bind.parse().unwrap(),
            allowed_hosts: hosts.iter().map(|&host| host.to_owned()).collect(),
            ..ViewParams::default()
        };
        params.check()
    }

    #[test]
    fn it_listens_on_loopback_by_default() {
        let bind = ViewParams::default().bind;
        assert!(bind.ip().is_loopback(), "{bind}");
    }

    #[test]
    fn every_network_needs_a_name() {
        assert!(matches!(with_hosts("0.0.0.0:80", &[]), Err(ViewError::NoHostNamed { .. })));
        assert!(with_hosts("0.0.0.0:80", &["lab-pc.local"]).is_ok());
        assert!(with_hosts("[::]:80", &["[fe80::1]"]).is_ok());
    }

    #[test]
    fn a_host_has_no_port_and_no_scheme() {
        for bad in ["", "http://a", "a:80", "a/b", "*", "[x]"] {
            let refused = with_hosts("127.0.0.1:0", &[bad]);
            assert!(matches!(refused, Err(ViewError::BadHost { .. })), "{bad}");
        }
    }
}
