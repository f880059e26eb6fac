//! The tests for boards, `frameworks/on-board`: built as a user builds them for probe-rs, and run in the emulator, which
//! gets the address of a test as probe-rs gives it.

use std::collections::BTreeMap;
use std::fs;

use anyhow::{Context, Result, ensure};
use object::read::elf::ElfFile32;
use object::{Endianness, Object as _, ObjectSection as _, ObjectSymbol as _};
use serde_json::Value;

use crate::board::DRIVE;
use crate::toolchain::Way;
use crate::{firmware, qemu, workspace};

/// The section with the addresses of the tests, whose symbols are called as JSON says of each.
const LIST: &str = ".embedded_test";

/// Builds and runs all tests; returns their names.
pub fn run(way: Way) -> Result<String> {
    let elf = firmware::build_suite(way, &workspace::root().join("frameworks/on-board"), "suite")?;
    let tests = tests(&fs::read(&elf).with_context(|| format!("cannot read {}", elf.display()))?)?;
    ensure!(tests.len() > 3, "tests are missing: {:?}", tests.keys());
    for (name, address) in &tests {
        qemu::run_test(&elf, DRIVE.machine, &address.to_string()).with_context(|| name.clone())?;
    }
    let (_, wrong) = tests.first_key_value().context("no test")?;
    // An address that the emulator cannot call must not pass for a test.
    ensure!(qemu::run_test(&elf, DRIVE.machine, &format!("x{wrong}")).is_err(), "a wrong command passes");
    Ok(tests.keys().map(String::as_str).collect::<Vec<_>>().join(", "))
}

/// The address of each test.
fn tests(bytes: &[u8]) -> Result<BTreeMap<String, u32>> {
    let file = ElfFile32::<Endianness>::parse(bytes)?;
    let list = file.section_by_name(LIST).context("the program has no list of tests")?;
    let data = list.data()?;
    let mut tests = BTreeMap::new();
    for symbol in file.symbols().filter(|symbol| symbol.section_index() == Some(list.index())) {
        let Some(about) = symbol.name().ok().and_then(|name| serde_json::from_str::<Value>(name).ok()) else {
            continue;
        };
        let name = about.get("name").and_then(Value::as_str).context("a test without a name")?;
        let at = usize::try_from(symbol.address())?;
        let word = data.get(at..).and_then(|rest| rest.first_chunk::<4>()).context("a test without an address")?;
        tests.insert(name.to_owned(), u32::from_le_bytes(*word));
    }
    Ok(tests)
}
