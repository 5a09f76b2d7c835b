//! Thin entry point: parse, call, map to an exit code.
fn main() {
    use std::io::Write;
    let text = if std::env::args().nth(1).as_deref() == Some("schema") {
        fbimpact::scenario::schema::text()
    } else {
        fbimpact::scenario::reference::markdown()
    };
    let _ = std::io::stdout().write_all(text.as_bytes());
}
