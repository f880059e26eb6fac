//! Test helper: returns `Ok` if every tag of a markup fragment is closed in order and every attribute is quoted.

const VOID: [&str; 3] = ["meta", "br", "hr"];

/// Checks nesting, quoting, unescaped brackets, and `NaN` or `inf` in coordinates.
pub(crate) fn check(markup: &str) -> Result<(), String> {
    let mut open: Vec<&str> = Vec::new();
    let mut rest = markup;
    while let Some(start) = rest.find('<') {
        let text = &rest[..start];
        if text.contains('>') && open.last() != Some(&"style") {
            return Err(format!("stray '>' in {text:?}"));
        }
        let end = rest[start..].find('>').ok_or("tag without end")? + start;
        let tag = &rest[start + 1..end];
        rest = &rest[end + 1..];
        if tag.starts_with('!') {
            continue;
        }
        if let Some(name) = tag.strip_prefix('/') {
            if open.pop() != Some(name) {
                return Err(format!("</{name}> closes another element"));
            }
            continue;
        }
        if tag.contains('<') || !tag.matches('"').count().is_multiple_of(2) {
            return Err(format!("bad quoting in <{tag}>"));
        }
        if tag.contains("NaN") || tag.contains("inf ") || tag.contains("-inf") {
            return Err(format!("value that is not finite in <{tag}>"));
        }
        let name = tag.split([' ', '/', '\n']).next().unwrap_or_default();
        if !tag.ends_with('/') && !VOID.contains(&name) {
            open.push(name);
        }
    }
    if open.is_empty() { Ok(()) } else { Err(format!("never closed: {open:?}")) }
}

#[test]
fn the_check_itself_finds_faults() {
    assert_eq!(check("<p class=\"a\">x<br>y<b>z</b></p><g/>"), Ok(()));
    for bad in ["<p>", "</p>", "<p><b></p></b>", "<p class=\"a>x</p>", "a > b<p></p>", "<path d=\"M NaN 0\"/>"] {
        assert!(check(bad).is_err(), "{bad}");
    }
}
