//! Links of an HDF5 file that its reader does not follow, for a word about each: soft ones, which name a path, and
//! external ones, which name another file.
//!
//! ```text
//! link message   06, length, flags │ 01, flags, type (1 soft, 64 external), …, name, target     of newer groups
//! symbol node    SNOD, …, entries: place of the name, 8 bytes, kind (2 soft), …, place of the target    of older ones
//! ```
//!
//! They are found by their form alone, wherever they are. Names of older groups are in a list of texts of each group; a
//! link has a name here if one list alone may have it. Groups of very many links keep them in another form, which is
//! not looked at.

use memchr::{memchr_iter, memmem};

/// Bytes of the largest file that is looked at.
pub(in crate::table) const LARGEST: u64 = 64 << 20;
/// Kinds of links.
const SOFT: u8 = 1;
const EXTERNAL: u8 = 64;
/// Bytes of an entry of a symbol node, and entries of one.
const ENTRY: usize = 40;
const ENTRIES: usize = 64;

/// What is said of a link: its place and the reason why it is left out.
pub(in crate::table) type Left = (String, String);

/// The links of a file, each once.
pub(in crate::table) fn links(bytes: &[u8]) -> Vec<Left> {
    let messages = memchr_iter(6, bytes).filter_map(|at| message(bytes, at));
    let mut all: Vec<Left> = messages.chain(of_nodes(bytes)).collect();
    all.sort_unstable();
    all.dedup();
    all
}

fn said(name: &str, kind: u8, target: &str) -> Left {
    let place = format!("link {name}");
    if kind == SOFT {
        return (place, format!("a soft link, which is not followed: its array is {target}"));
    }
    let file = target.trim_start_matches('\0').split('\0').next().unwrap_or_default();
    (place, format!("an external link, which is not followed: its array is in the file {file}; read that one"))
}

fn whole(bytes: &[u8], at: usize, length: usize) -> Option<usize> {
    let mut little = [0; 8];
    little.get_mut(..length)?.copy_from_slice(bytes.get(at..at + length)?);
    usize::try_from(u64::from_le_bytes(little)).ok()
}

/// The link of a message whose type is at this place.
fn message(bytes: &[u8], at: usize) -> Option<Left> {
    // Of newer headers, also with an order of creation, and of older ones, whose messages are padded.
    let forms = [(at + 1, at + 4, 0), (at + 1, at + 6, 0), (at + 2, at + 8, 7)];
    forms.into_iter().find_map(|(size, start, padding)| {
        let size = whole(bytes, size, 2)?;
        let body = bytes.get(start..start.checked_add(size)?)?;
        link(body, padding)
    })
}

/// A link by the body of its message.
fn link(body: &[u8], padding: usize) -> Option<Left> {
    let [1, flags, kind, ..] = *body else { return None };
    if flags & 0xE8 != 0x08 || ![SOFT, EXTERNAL].contains(&kind) {
        return None;
    }
    let order = if flags & 4 != 0 { 8 } else { 0 };
    let at = 3 + order + usize::from(flags & 16 != 0);
    let width = 1 << (flags & 3);
    let (name, at) = text(body, at + width, whole(body, at, width)?)?;
    let length = whole(body, at, 2)?;
    let end = (at + 2).checked_add(length)?;
    let fits = end <= body.len() && body.len() <= end + padding;
    let target = std::str::from_utf8(body.get(at + 2..end)?).ok()?;
    (fits && !target.is_empty()).then(|| said(name, kind, target))
}

/// A printable text of this length, and where it ends.
fn text(bytes: &[u8], at: usize, length: usize) -> Option<(&str, usize)> {
    let end = at.checked_add(length)?;
    let text = std::str::from_utf8(bytes.get(at..end)?).ok()?;
    (!text.is_empty() && !text.contains(char::is_control)).then_some((text, end))
}

/// The soft links of older groups.
fn of_nodes(bytes: &[u8]) -> Vec<Left> {
    let base = memmem::find(bytes, b"\x89HDF\r\n\x1a\n").unwrap_or(0);
    let lists: Vec<usize> =
        memmem::find_iter(bytes, b"HEAP").filter_map(|at| whole(bytes, at + 24, 8)?.checked_add(base)).collect();
    let is_soft = |entry: &usize| whole(bytes, entry + 16, 4) == Some(2);
    let entries = memmem::find_iter(bytes, b"SNOD").flat_map(|at| {
        let count = whole(bytes, at + 6, 2).filter(|count| *count <= ENTRIES && bytes.get(at + 4) == Some(&1));
        (0..count.unwrap_or(0)).map(move |k| at + 8 + ENTRY * k)
    });
    let named = |entry: usize| {
        let of_list = |list: &usize| {
            let text_at = |place: usize| {
                let at = list.checked_add(whole(bytes, place, if place == entry { 8 } else { 4 })?)?;
                let length = bytes.get(at..)?.iter().take(1 << 10).position(|byte| *byte == 0)?;
                text(bytes, at, length).map(|(text, _)| text)
            };
            Some((text_at(entry)?, text_at(entry + 24)?))
        };
        let mut fitting = lists.iter().filter_map(of_list);
        match (fitting.next(), fitting.next()) {
            (Some((name, target)), None) => said(name, SOFT, target),
            _ => said("of a group", SOFT, "elsewhere in the file"),
        }
    };
    entries.filter(is_soft).map(named).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A message of a link: the bytes behind its type.
    fn link_message(name: &str, kind: u8, target: &str, is_old: bool) -> Vec<u8> {
        let mut body = vec![1, 0x08, kind, name.len() as u8];
        body.extend(name.bytes());
        body.extend((target.len() as u16).to_le_bytes());
        body.extend(target.bytes());
        if is_old {
            body.resize(body.len().next_multiple_of(8), 0);
        }
        let size = (body.len() as u16).to_le_bytes();
        let head: Vec<u8> =
            if is_old { vec![6, 0, size[0], size[1], 0, 0, 0, 0] } else { vec![6, size[0], size[1], 0] };
        [head, body].concat()
    }

    #[test]
    fn messages_of_links_are_found_among_other_bytes() {
        for is_old in [false, true] {
            let soft = link_message("speed", SOFT, "/run/w", is_old);
            let external = link_message("i", EXTERNAL, "\0other.h5\0/i\0", is_old);
            let bytes = [vec![6; 40], soft, vec![0, 6, 1, 8], external, vec![1; 9]].concat();
            let found = links(&bytes);
            assert_eq!(found.iter().map(|(place, _)| place.as_str()).collect::<Vec<_>>(), ["link i", "link speed"]);
            assert!(found[0].1.contains("in the file other.h5") && found[1].1.ends_with("its array is /run/w"));
        }
        let hard = link_message("x", 0, "/y", false);
        assert_eq!(links(&[hard, (0..=255).collect()].concat()), []);
    }

    #[test]
    fn soft_links_of_older_groups_are_found_with_their_names() {
        let texts = b"\0\0\0\0\0\0\0\0speed\0\0\0/run/w\0\0";
        let mut list = b"HEAP\0\0\0\0".to_vec();
        // Length, free place, and the place of the texts.
        list.extend([texts.len() as u64, 0, 32].map(u64::to_le_bytes).concat());
        list.extend(texts);
        let entry = |name: u64, kind: u32, target: u32| {
            let mut entry = [name.to_le_bytes(), u64::MAX.to_le_bytes()].concat();
            entry.extend([kind, 0, target, 0, 0, 0].map(u32::to_le_bytes).concat());
            entry
        };
        let node = [b"SNOD\x01\0\x02\0".to_vec(), entry(8, 0, 0), entry(8, 2, 16)].concat();
        let found = links(&[list.clone(), node.clone()].concat());
        let reason = "a soft link, which is not followed: its array is /run/w".to_string();
        assert_eq!(found, [("link speed".to_string(), reason)]);
        // Another list of the same texts may be the one.
        let found = links(&[list.clone(), list, node].concat());
        assert_eq!((found.len(), found[0].0.as_str()), (1, "link of a group"));
    }
}
