//! What an ELF file takes of the chip: bytes of flash and of static RAM.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::Path;

use anyhow::{Context, Result, ensure};
use object::Object as _;
use object::read::archive::ArchiveFile;
use object::read::elf::{ElfFile32, SectionHeader};
use object::{Endianness, ObjectSection, ObjectSymbol, elf};

/// Where RAM starts on every Cortex-M; code lies below.
const RAM: u32 = 0x2000_0000;

/// Bytes of the linked program. The stack is not in it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub struct Sizes {
    /// Everything stored: vector table, code, constants, and the start values of `.data`.
    pub flash: u64,
    /// Statics: `.data`, `.bss`, `.uninit`.
    pub ram: u64,
}

fn read(path: &Path) -> Result<Vec<u8>> {
    fs::read(path).with_context(|| format!("cannot read {}", path.display()))
}

fn firmware<'a>(bytes: &'a [u8], path: &Path) -> Result<ElfFile32<'a>> {
    ElfFile32::parse(bytes).with_context(|| format!("{} is not firmware", path.display()))
}

/// Adds up the sections that the chip holds.
pub fn sizes(path: &Path) -> Result<Sizes> {
    let bytes = read(path)?;
    let file = firmware(&bytes, path)?;
    let endian = file.endian();
    let mut sizes = Sizes::default();
    for section in file.sections() {
        let header = section.elf_section_header();
        if !header.sh_flags(endian).contains(elf::SHF_ALLOC) {
            continue;
        }
        sizes.add(header.sh_addr(endian), section.size(), header.sh_type(endian) != elf::SHT_NOBITS);
    }
    Ok(sizes)
}

/// Whether an ELF file has a section of this name.
pub fn has_section(path: &Path, name: &str) -> Result<bool> {
    let bytes = read(path)?;
    let file = firmware(&bytes, path)?;
    Ok(file.section_by_name(name).is_some())
}

/// Bytes of statics that start with other values than zero: they take flash, too.
pub fn initialised(path: &Path) -> Result<u64> {
    let bytes = read(path)?;
    let file = firmware(&bytes, path)?;
    Ok(file.section_by_name(".data").map_or(0, |section| section.size()))
}

/// Names of the linked symbols that hold a piece of text; linking has dropped what is not called.
pub fn symbols_with(path: &Path, piece: &str) -> Result<Vec<String>> {
    let bytes = read(path)?;
    let file = firmware(&bytes, path)?;
    let names: Vec<&str> = file.symbols().filter_map(|symbol| symbol.name().ok()).collect();
    // An ELF file without its symbols would pass any such check.
    ensure!(names.contains(&"main"), "{} has no symbols", path.display());
    Ok(names.into_iter().filter(|name| name.contains(piece)).map(ToOwned::to_owned).collect())
}

/// Names of the symbols of a static library that others may link with: global and defined.
pub fn global_symbols(path: &Path) -> Result<BTreeSet<String>> {
    let bytes = read(path)?;
    let archive = ArchiveFile::parse(&*bytes).with_context(|| format!("{} is no library", path.display()))?;
    let mut names = BTreeSet::new();
    for member in archive.members() {
        // What is no ELF file, such as a compiler's notes, defines no symbol for the linker.
        let Ok(file) = ElfFile32::<Endianness>::parse(member?.data(&*bytes)?) else { continue };
        let global = file.symbols().filter(|symbol| symbol.is_global() && symbol.is_definition());
        names.extend(global.filter_map(|symbol| symbol.name().ok()).map(ToOwned::to_owned));
    }
    Ok(names)
}

/// Sizes of those functions of a linked program that are global, in bytes.
pub fn global_sizes(path: &Path, names: &[&str]) -> Result<BTreeMap<String, u64>> {
    let bytes = read(path)?;
    let file = firmware(&bytes, path)?;
    let global = file.symbols().filter(|symbol| symbol.is_global() && symbol.is_definition());
    let sizes = global.filter_map(|symbol| Some((symbol.name().ok()?.to_owned(), symbol.size())));
    Ok(sizes.filter(|(name, _)| names.contains(&name.as_str())).collect())
}

/// Bytes of code and constants by the part of the program that they belong to: for functions of Rust the module below
/// the crate, for the interface of the C library `bw_`, for all others `other`.
pub fn parts(path: &Path) -> Result<BTreeMap<String, u64>> {
    let bytes = read(path)?;
    let file = firmware(&bytes, path)?;
    let mut parts = BTreeMap::new();
    for symbol in file.symbols().filter(|symbol| symbol.is_definition() && symbol.address() < u64::from(RAM)) {
        *parts.entry(part(symbol.name().unwrap_or_default())).or_default() += symbol.size();
    }
    Ok(parts)
}

/// The part of a mangled name, where crate and module stand behind their lengths: `…13bearing_watch5shaft…`.
fn part(name: &str) -> String {
    const CRATES: [&str; 2] = ["15bearing_watch_c", "13bearing_watch"];
    if name.starts_with("bw_") {
        return "bw_".into();
    }
    // The first crate in the name is that of the function; others are those of its types.
    let behind = CRATES.iter().filter_map(|of_crate| name.split_once(of_crate)).map(|(_, rest)| rest);
    let behind = behind.max_by_key(|rest| rest.len());
    let module = behind.and_then(|rest| {
        let digits = rest.len() - rest.trim_start_matches(|c: char| c.is_ascii_digit()).len();
        let (length, rest) = rest.split_at(digits);
        // A name that starts with a digit or an underscore has one more before it.
        rest.trim_start_matches('_').get(..length.parse().ok()?)
    });
    module.unwrap_or("other").into()
}

impl Sizes {
    const fn add(&mut self, address: u32, size: u64, stored: bool) {
        if stored {
            self.flash += size;
        }
        if address >= RAM {
            self.ram += size;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_mangled_name_tells_its_module() {
        let name = "_RNvMs_NtNtCs5K_13bearing_watch5shaft5stateINtB4_5ShaftNtNtCs1_15bearing_watch_c4plan5DriveE4step";
        assert_eq!(part("_RNvNtCs1_13bearing_watch13known_answers10transforms"), "known_answers");
        assert_eq!([part("bw_init"), part("memcpy"), part("_RNvCs1_4libm4expf")], ["bw_", "other", "other"]);
        assert_eq!(part(name), "shaft");
    }

    #[test]
    fn initialised_data_count_twice() {
        let mut sizes = Sizes::default();
        sizes.add(0x0800_0000, 1024, true); // .vector_table
        sizes.add(0x2000_0000, 8, true); // .data
        sizes.add(0x2000_0008, 100, false); // .bss
        assert_eq!(sizes, Sizes { flash: 1032, ram: 108 });
    }
}
