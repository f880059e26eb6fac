//! What an ELF file takes of the chip, and the symbols that it has.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use anyhow::{Context, Result, ensure};
use object::read::elf::{ElfFile32, SectionHeader};
use object::{Object as _, ObjectSection as _, ObjectSymbol as _, elf};

/// Where RAM starts on every Cortex-M; code lies below.
const RAM: u32 = 0x2000_0000;

/// Bytes of the linked program. The stack is not in it.
#[derive(Clone, Copy, Debug, Default)]
pub struct Sizes {
    /// Everything stored: vector table, code, constants, and the start values of `.data`.
    pub flash: u64,
    /// Statics: `.data`, `.bss`, `.uninit`.
    pub ram: u64,
    /// Bytes of statics that start with other values than zero: they take flash, too.
    pub initialised: u64,
}

/// Hands over the file.
fn with<T>(path: &Path, work: impl FnOnce(&ElfFile32<'_>) -> Result<T>) -> Result<T> {
    let bytes = fs::read(path).with_context(|| format!("cannot read {}", path.display()))?;
    work(&ElfFile32::parse(&*bytes).with_context(|| format!("{} is not firmware", path.display()))?)
}

/// Adds up the sections that the chip holds.
pub fn sizes(path: &Path) -> Result<Sizes> {
    with(path, |file| {
        let (endian, mut sizes) = (file.endian(), Sizes::default());
        for section in file.sections() {
            let header = section.elf_section_header();
            if header.sh_flags(endian).contains(elf::SHF_ALLOC) {
                let (stored, ram) = (header.sh_type(endian) != elf::SHT_NOBITS, header.sh_addr(endian) >= RAM);
                sizes.flash += if stored { section.size() } else { 0 };
                sizes.ram += if ram { section.size() } else { 0 };
                sizes.initialised += if section.name() == Ok(".data") { section.size() } else { 0 };
            }
        }
        Ok(sizes)
    })
}

/// Whether an ELF file has a section of this name.
pub fn has_section(path: &Path, name: &str) -> Result<bool> {
    with(path, |file| Ok(file.section_by_name(name).is_some()))
}

/// Fails if the program calls the panic machinery; linking has dropped what is not called.
pub fn ensure_no_panic(path: &Path) -> Result<&'static str> {
    with(path, |file| {
        let names: Vec<&str> = file.symbols().filter_map(|symbol| symbol.name().ok()).collect();
        // An ELF file without its symbols would pass.
        ensure!(names.contains(&"main"), "{} has no symbols", path.display());
        let panics: Vec<_> = names.into_iter().filter(|name| name.contains("core9panicking")).collect();
        ensure!(panics.is_empty(), "it calls {}", panics.join(", "));
        Ok("")
    })
}

/// The names and addresses of the tests for probe-rs: the symbols of a section of its own are called as JSON says of
/// each, and the section has their addresses.
pub fn tests(path: &Path) -> Result<BTreeMap<String, u32>> {
    with(path, |file| {
        let list = file.section_by_name(".embedded_test").context("the program has no list of tests")?;
        let (data, mut tests) = (list.data()?, BTreeMap::new());
        for symbol in file.symbols().filter(|symbol| symbol.section_index() == Some(list.index())) {
            let about = symbol.name().ok().and_then(|name| serde_json::from_str::<serde_json::Value>(name).ok());
            let Some(name) = about.as_ref().and_then(|about| about["name"].as_str()) else { continue };
            let word = data.get(usize::try_from(symbol.address())?..).and_then(<[u8]>::first_chunk::<4>);
            tests.insert(name.to_owned(), u32::from_le_bytes(*word.context("a test without an address")?));
        }
        Ok(tests)
    })
}
