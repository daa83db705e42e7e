//! Who can reach what a command serves.

use std::fmt::Display;
use std::net::ToSocketAddrs;

use anyhow::{Result, ensure};

/// What may happen to lines that are sent to whoever connects.
pub(super) const IS_READ: &str =
    "whoever reaches this machine could read everything, without a password";

/// Refuses an address beyond this machine, saying the danger, unless that is wanted. An address that means nothing is
/// left to whoever binds to it.
pub(super) fn check_reach(
    option: &str,
    address: impl ToSocketAddrs + Display,
    danger: &str,
    is_wanted: bool,
) -> Result<()> {
    let reached = address.to_socket_addrs().into_iter().flatten();
    let is_local = reached.map(|a| a.ip()).all(|ip| ip.is_loopback());
    ensure!(
        is_local || is_wanted,
        "{option} {address}: {danger}; \
         serve 127.0.0.1 and forward that, as by ssh -L, or say --insecure-bind"
    );
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_this_machine_is_served_unasked() {
        for address in ["127.0.0.1:7650", "[::1]:7650", "127.3.2.1:0", "nonsense"] {
            assert!(check_reach("--serve", address, IS_READ, false).is_ok(), "{address}");
        }
        for address in ["0.0.0.0:7650", "[::]:7650", "192.168.1.2:80"] {
            let refused = check_reach("--serve", address, IS_READ, false).unwrap_err();
            assert!(refused.to_string().contains("--insecure-bind"), "{refused}");
            assert!(check_reach("--serve", address, IS_READ, true).is_ok());
        }
    }
}
