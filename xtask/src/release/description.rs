//! The files by which pkg-config and CMake find the unpacked library, wherever it lies.

/// The compiler targets that the archive has a library for.
#[derive(Clone, Copy, Debug)]
pub struct Targets<'a> {
    /// Of the machine that made the archive.
    pub host: &'a str,
    /// Of the drive's chip.
    pub chip: &'a str,
    /// Of a chip of ESP-IDF.
    pub riscv: &'a str,
}

/// What a file says.
#[derive(Clone, Copy, Debug)]
pub struct Library<'a> {
    pub version: &'a str,
    pub targets: Targets<'a>,
    /// What a program for the host links with besides, as `-lm -lc`.
    pub system: &'a str,
}

/// `bearing-watch.pc`: for the host, or for the target of `--define-variable=target=…`.
pub fn pkg_config(library: &Library<'_>) -> String {
    let Library { version, targets, system } = library;
    format!(
        "prefix=${{pcfiledir}}/../..
target={}
includedir=${{prefix}}/include
libdir=${{prefix}}/lib/${{target}}

Name: bearing-watch
Description: Detection of bearing faults from the signals of a motor drive
Version: {version}
Cflags: -I${{includedir}}
Libs: -L${{libdir}} -lbearing_watch_c
Libs.private: {system}
",
        targets.host
    )
}

/// `bearing-watch-config.cmake`: the target `bearing-watch::bearing-watch` for the system of the project.
pub fn cmake_config(library: &Library<'_>) -> String {
    let Library { targets: Targets { host, chip, .. }, system, .. } = library;
    let processor = host.split('-').next().unwrap_or_default();
    let system: Vec<&str> = system.split_whitespace().filter_map(|flag| flag.strip_prefix("-l")).collect();
    format!(
        "# Defines bearing-watch::bearing-watch. BEARING_WATCH_TARGET names a folder of lib/ where the system does not.
set(_bearing_watch_system)
if(NOT BEARING_WATCH_TARGET)
    if(CMAKE_SYSTEM_NAME STREQUAL \"Linux\" AND CMAKE_SYSTEM_PROCESSOR STREQUAL \"{processor}\")
        set(BEARING_WATCH_TARGET {host})
    elseif(CMAKE_SYSTEM_NAME STREQUAL \"Generic\")
        set(BEARING_WATCH_TARGET {chip})
    endif()
endif()
if(BEARING_WATCH_TARGET STREQUAL \"{host}\")
    set(_bearing_watch_system {})
endif()
get_filename_component(_bearing_watch_prefix \"${{CMAKE_CURRENT_LIST_DIR}}/../../..\" ABSOLUTE)
set(_bearing_watch_file \"${{_bearing_watch_prefix}}/lib/${{BEARING_WATCH_TARGET}}/libbearing_watch_c.a\")
if(NOT BEARING_WATCH_TARGET OR NOT EXISTS \"${{_bearing_watch_file}}\")
    set(bearing-watch_FOUND FALSE)
    set(bearing-watch_NOT_FOUND_MESSAGE
        \"no library for ${{CMAKE_SYSTEM_NAME}} on ${{CMAKE_SYSTEM_PROCESSOR}}; there are {host} and {chip}\")
elseif(NOT TARGET bearing-watch::bearing-watch)
    add_library(bearing-watch::bearing-watch STATIC IMPORTED)
    set_target_properties(bearing-watch::bearing-watch PROPERTIES
        IMPORTED_LOCATION \"${{_bearing_watch_file}}\"
        INTERFACE_INCLUDE_DIRECTORIES \"${{_bearing_watch_prefix}}/include\"
        INTERFACE_LINK_LIBRARIES \"${{_bearing_watch_system}}\")
endif()
unset(_bearing_watch_prefix)
unset(_bearing_watch_file)
unset(_bearing_watch_system)
",
        system.join(" ")
    )
}

/// `bearing-watch-config-version.cmake`: a version serves requests for it and for older ones that it is compatible
/// with. Below 1.0, those are of the same minor version.
pub fn cmake_version(version: &str) -> String {
    let mut numbers = version.split('.');
    let (major, minor) = (numbers.next().unwrap_or_default(), numbers.next().unwrap_or_default());
    let same = if major == "0" {
        format!("PACKAGE_FIND_VERSION_MAJOR EQUAL 0 AND PACKAGE_FIND_VERSION_MINOR EQUAL {minor}")
    } else {
        format!("PACKAGE_FIND_VERSION_MAJOR EQUAL {major}")
    };
    format!(
        "set(PACKAGE_VERSION \"{version}\")
set(PACKAGE_VERSION_COMPATIBLE FALSE)
if(NOT PACKAGE_FIND_VERSION OR ({same}
        AND NOT PACKAGE_FIND_VERSION VERSION_GREATER PACKAGE_VERSION))
    set(PACKAGE_VERSION_COMPATIBLE TRUE)
endif()
if(PACKAGE_FIND_VERSION STREQUAL PACKAGE_VERSION)
    set(PACKAGE_VERSION_EXACT TRUE)
endif()
"
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    const LIBRARY: Library<'_> = Library {
        version: "0.3.1",
        targets: Targets { host: "x86_64-unknown-linux-gnu", chip: "thumbv7em-none-eabihf", riscv: "riscv32" },
        system: "-lgcc_s -lm -lc",
    };

    #[test]
    fn pkg_config_finds_all_from_its_own_place() {
        let text = pkg_config(&LIBRARY);
        for line in [
            "prefix=${pcfiledir}/../..",
            "target=x86_64-unknown-linux-gnu",
            "libdir=${prefix}/lib/${target}",
            "Version: 0.3.1",
            "Libs: -L${libdir} -lbearing_watch_c",
            "Libs.private: -lgcc_s -lm -lc",
        ] {
            assert!(text.lines().any(|own| own == line), "{line}\n{text}");
        }
    }

    #[test]
    fn cmake_names_both_systems_and_their_libraries() {
        let text = cmake_config(&LIBRARY);
        assert!(text.contains("STREQUAL \"Linux\" AND CMAKE_SYSTEM_PROCESSOR STREQUAL \"x86_64\""), "{text}");
        assert!(text.contains("set(BEARING_WATCH_TARGET thumbv7em-none-eabihf)"), "{text}");
        assert!(text.contains("set(_bearing_watch_system gcc_s m c)"), "{text}");
    }

    #[test]
    fn versions_below_one_serve_their_own_minor_version() {
        let below = cmake_version("0.3.1");
        assert!(below.contains("PACKAGE_FIND_VERSION_MINOR EQUAL 3"), "{below}");
        let above = cmake_version("2.4.0");
        assert!(above.contains("PACKAGE_FIND_VERSION_MAJOR EQUAL 2") && !above.contains("MINOR"), "{above}");
    }
}
