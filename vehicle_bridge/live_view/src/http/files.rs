//! The page, which is part of the program: a browser needs nothing else.

/// Path, type and content of every file.
const FILES: [(&str, &str, &str); 9] = [
    ("/", "text/html; charset=utf-8", include_str!("../../page/index.html")),
    ("/style.css", "text/css; charset=utf-8", include_str!("../../page/style.css")),
    ("/app.js", JS, include_str!("../../page/app.js")),
    ("/state.js", JS, include_str!("../../page/state.js")),
    ("/map.js", JS, include_str!("../../page/map.js")),
    ("/charts.js", JS, include_str!("../../page/charts.js")),
    ("/tables.js", JS, include_str!("../../page/tables.js")),
    ("/operator.js", JS, include_str!("../../page/operator.js")),
    ("/icon.svg", "image/svg+xml", include_str!("../../page/icon.svg")),
];
const JS: &str = "text/javascript; charset=utf-8";

/// Type and content of the file at a path.
pub(super) fn find(path: &str) -> Option<(&'static str, &'static str)> {
    let path = path.split('?').next().unwrap_or_default();
    FILES.iter().find(|(name, ..)| *name == path).map(|(_, kind, text)| (*kind, *text))
}
