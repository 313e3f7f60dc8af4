//! Access rules: allowed hosts and origins, sources of pages, and the headers of every answer.

use axum::Router;
use axum::extract::{Request, State};
use axum::http::header::{
    CACHE_CONTROL, CONTENT_SECURITY_POLICY, HOST, HeaderName, HeaderValue, ORIGIN, REFERRER_POLICY,
    X_CONTENT_TYPE_OPTIONS, X_FRAME_OPTIONS,
};
use axum::http::{HeaderMap, StatusCode};
use axum::middleware::{Next, from_fn_with_state};
use axum::response::{IntoResponse, Response};

use crate::server::basemap::Basemap;

/// The rules for every request and answer.
#[derive(Clone, Debug)]
pub struct Guard {
    hosts: [String; 2],
    policy: HeaderValue,
}

impl Guard {
    /// The rules of a server at a port of this machine.
    pub fn new(port: u16, basemap: Option<&Basemap>) -> Self {
        let pictures = basemap.and_then(Basemap::origin);
        let pictures = pictures.map_or_else(String::new, |origin| format!(" {origin}"));
        let policy = format!(
            "default-src 'none'; script-src 'self'; style-src 'self'; connect-src 'self'; \
             img-src 'self' blob:{pictures}; base-uri 'none'; form-action 'none'; \
             frame-ancestors 'none'"
        );
        Self {
            hosts: [format!("127.0.0.1:{port}"), format!("localhost:{port}")],
            // The address of the map tiles consists of letters, digits and a few marks.
            policy: HeaderValue::from_str(&policy)
                .unwrap_or(HeaderValue::from_static("default-src 'none'")),
        }
    }

    /// These addresses under these rules.
    pub fn around(self, router: Router) -> Router {
        router.layer(from_fn_with_state(self, check))
    }

    /// Whether a request names this server and comes from its own pages or from none.
    fn admits(&self, headers: &HeaderMap) -> bool {
        let text = |name: HeaderName| headers.get(name).map(|value| value.to_str().unwrap_or("?"));
        let is_own = |host: &str| self.hosts.iter().any(|own| own == host);
        let from_here = |origin: &str| origin.strip_prefix("http://").is_some_and(is_own);
        let site = text(HeaderName::from_static("sec-fetch-site"));
        text(HOST).is_some_and(is_own)
            && text(ORIGIN).is_none_or(from_here)
            && site.is_none_or(|site| ["same-origin", "none"].contains(&site))
    }
}

async fn check(State(guard): State<Guard>, request: Request, next: Next) -> Response {
    let mut response = if guard.admits(request.headers()) {
        next.run(request).await
    } else {
        let refusal = "this server answers only to its own pages on this machine";
        (StatusCode::FORBIDDEN, refusal).into_response()
    };
    let headers = response.headers_mut();
    if !headers.contains_key(CONTENT_SECURITY_POLICY) {
        headers.insert(CONTENT_SECURITY_POLICY, guard.policy);
    }
    for (name, value) in [
        (X_CONTENT_TYPE_OPTIONS, "nosniff"),
        (X_FRAME_OPTIONS, "DENY"),
        (REFERRER_POLICY, "no-referrer"),
        (CACHE_CONTROL, "no-store"),
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_own_hosts_and_origins_are_admitted() {
        let guard = Guard::new(4100, None);
        let admits = |pairs: &[(&'static str, &'static str)]| {
            let headers = pairs.iter().map(|(name, value)| {
                (
                    HeaderName::from_static(name),
                    HeaderValue::from_static(value),
                )
            });
            guard.admits(&headers.collect())
        };
        assert!(admits(&[("host", "127.0.0.1:4100")]));
        assert!(admits(&[
            ("host", "localhost:4100"),
            ("origin", "http://localhost:4100"),
            ("sec-fetch-site", "same-origin")
        ]));
        for wrong in [
            &[][..],
            &[("host", "evil.example:4100")],
            &[("host", "127.0.0.1:4101")],
            &[
                ("host", "127.0.0.1:4100"),
                ("origin", "http://evil.example"),
            ],
            &[("host", "127.0.0.1:4100"), ("origin", "null")],
            &[
                ("host", "127.0.0.1:4100"),
                ("origin", "https://127.0.0.1:4100"),
            ],
            &[("host", "127.0.0.1:4100"), ("sec-fetch-site", "cross-site")],
            &[("host", "127.0.0.1:4100"), ("sec-fetch-site", "same-site")],
        ] {
            assert!(!admits(wrong), "{wrong:?}");
        }
    }

    #[test]
    fn map_tiles_widen_the_policy_by_their_origin_alone() {
        let map = Basemap::find("https://tiles.example:8443/v1/{z}/{x}/{y}.png").unwrap();
        let guard = Guard::new(4100, Some(&map));
        let policy = guard.policy.to_str().unwrap();
        assert!(policy.contains("img-src 'self' blob: https://tiles.example:8443;"));
    }
}
