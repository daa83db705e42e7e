//! What is served where: the page of one limb, or that of a robot with its limbs' pages.

use std::sync::{Arc, OnceLock};

use axum::Router;
use axum::extract::ws::WebSocketUpgrade;
use axum::extract::{Path, Request, State};
use axum::http::{StatusCode, Uri, header::CONTENT_TYPE};
use axum::middleware::{Next, from_fn_with_state};
use axum::response::{IntoResponse, Redirect, Response};
use axum::routing::get;

use crate::assets::{self, HTML};
use crate::client;
use crate::feed::Feed;
use crate::guard::{self, Guard, Policy};
use crate::robot_page::{limb_path, robot_page};

/// Largest message of a page, bytes.
const MAX_INBOUND: usize = 64 << 10;

/// What a server shows, and to whom.
pub(crate) struct Site {
    guard: Guard,
    /// The page of all limbs, where there are several.
    robot: Option<String>,
    limbs: Vec<LimbPage>,
}

/// A limb's page.
struct LimbPage {
    name: String,
    feed: OnceLock<Arc<Feed>>,
}

impl Site {
    /// Of one limb, whose name is empty.
    pub(crate) fn of_limb(guard: Guard) -> Self {
        Self { guard, robot: None, limbs: vec![LimbPage::new("")] }
    }

    /// Of a robot.
    pub(crate) fn of_robot(guard: Guard, robot: &str, limbs: &[String]) -> Self {
        let page = robot_page(robot, limbs);
        let limbs = limbs.iter().map(|name| LimbPage::new(name)).collect();
        Self { guard, robot: Some(page), limbs }
    }

    /// Begins a limb's page; false where there is no such limb, or its page is there already.
    pub(crate) fn begin(&self, name: &str, feed: Arc<Feed>) -> bool {
        self.limb(name).is_some_and(|limb| limb.feed.set(feed).is_ok())
    }

    /// What limbs show, of those whose page has begun.
    pub(crate) fn feeds(&self) -> impl Iterator<Item = &Arc<Feed>> {
        self.limbs.iter().filter_map(|limb| limb.feed.get())
    }

    fn limb(&self, name: &str) -> Option<&LimbPage> {
        self.limbs.iter().find(|limb| limb.name == name)
    }

    /// What an answer to this path may do.
    fn policy(&self, path: &str) -> Policy {
        match &self.robot {
            Some(_) if path == "/" => Policy::Robot,
            Some(_) if self.limbs.iter().any(|limb| limb_path(&limb.name) == path) => {
                Policy::Framed
            }
            _ => Policy::Plain,
        }
    }
}

impl LimbPage {
    fn new(name: &str) -> Self {
        Self { name: name.to_owned(), feed: OnceLock::new() }
    }
}

/// Who answers which path.
pub(crate) fn router(site: Arc<Site>) -> Router {
    let router = Router::new();
    let router = match &site.robot {
        None => router.route("/live", get(live)),
        Some(_) => router
            .route("/", get(robot))
            .route("/limb/{limb}", get(limb_folder))
            .route("/limb/{limb}/", get(limb_page))
            .route("/limb/{limb}/live", get(limb_live))
            .route("/limb/{limb}/{*file}", get(limb_file)),
    };
    router
        .fallback_service(get(asset))
        .layer(from_fn_with_state(Arc::clone(&site), guarded))
        .with_state(site)
}

/// Refuses what is not asked of this host by its own page, and puts the policy on every answer.
async fn guarded(State(site): State<Arc<Site>>, request: Request, next: Next) -> Response {
    let (mut response, policy) = if site.guard.allows(request.headers()) {
        let policy = site.policy(request.uri().path());
        (next.run(request).await, policy)
    } else {
        let refused = (StatusCode::FORBIDDEN, "this host or origin is not allowed\n");
        (refused.into_response(), Policy::Plain)
    };
    response.headers_mut().extend(guard::headers(policy));
    response
}

async fn asset(uri: Uri) -> Response {
    file(uri.path())
}

async fn live(State(site): State<Arc<Site>>, upgrade: WebSocketUpgrade) -> Response {
    connect(&site, "", upgrade)
}

async fn robot(State(site): State<Arc<Site>>) -> Response {
    let page = site.robot.clone().unwrap_or_default();
    ([(CONTENT_TYPE, HTML)], page).into_response()
}

/// Without the slash the page's own files are not found.
async fn limb_folder(State(site): State<Arc<Site>>, Path(name): Path<String>) -> Response {
    match site.limb(&name) {
        Some(limb) => Redirect::to(&limb_path(&limb.name)).into_response(),
        None => no_limb(),
    }
}

async fn limb_page(State(site): State<Arc<Site>>, Path(name): Path<String>) -> Response {
    site.limb(&name).map_or_else(no_limb, |_| file("/"))
}

async fn limb_file(
    State(site): State<Arc<Site>>,
    Path((name, path)): Path<(String, String)>,
) -> Response {
    site.limb(&name).map_or_else(no_limb, |_| file(&format!("/{path}")))
}

async fn limb_live(
    State(site): State<Arc<Site>>,
    Path(name): Path<String>,
    upgrade: WebSocketUpgrade,
) -> Response {
    connect(&site, &name, upgrade)
}

fn file(path: &str) -> Response {
    match assets::find(path) {
        Some(asset) => ([(CONTENT_TYPE, asset.media_type)], asset.body()).into_response(),
        None => (StatusCode::NOT_FOUND, "no such file\n").into_response(),
    }
}

fn no_limb() -> Response {
    (StatusCode::NOT_FOUND, "no such limb\n").into_response()
}

/// A page's connection.
fn connect(site: &Site, limb: &str, upgrade: WebSocketUpgrade) -> Response {
    let Some(limb) = site.limb(limb) else {
        return no_limb();
    };
    let Some(feed) = limb.feed.get() else {
        return (StatusCode::SERVICE_UNAVAILABLE, "this limb is not there yet\n").into_response();
    };
    let Some(place) = feed.place() else {
        return (StatusCode::SERVICE_UNAVAILABLE, "too many pages are open\n").into_response();
    };
    upgrade
        .max_message_size(MAX_INBOUND)
        .max_frame_size(MAX_INBOUND)
        .on_upgrade(move |socket| client::serve(place, socket))
}
