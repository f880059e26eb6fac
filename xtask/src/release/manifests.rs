//! The files by which Zephyr, PlatformIO, the Arduino IDE and CMSIS packs take the unpacked archive, from one list.
//!
//! | for | files | checked by |
//! |---|---|---|
//! | Zephyr | `zephyr/module.yml`, `Kconfig`, `CMakeLists.txt` | kconfiglib, and CMake with stand-ins of its functions |
//! | PlatformIO | `library.json`, `platformio.py` | PlatformIO's own packer and build, which pip installs |
//! | Arduino | `library.properties`, `src/` | the keys of its specification, and a sketch with a stand-in core |
//! | CMSIS | `bearing-watch.pdsc` | an XML reader |
//! | ESP-IDF | `CMakeLists.txt`, `idf_component.yml` | its component manager, and CMake with stand-ins |
//!
//! Rust has no target of the Xtensa chips of ESP-IDF, and a chip without floating-point unit is too slow.

use super::description::Library;

/// The name of the package, and what it is in a sentence and in a paragraph.
const NAME: &str = "bearing-watch";
const SENTENCE: &str = "Detects bearing faults from the signals of a motor drive.";
const PARAGRAPH: &str = "A static library for Cortex-M4F and M7, without heap, global state and unbounded time. The \
                         program bearing-watch trains its models.";
const AUTHORS: &str = "bearing-watch contributors";
const LICENCE: &str = "MIT OR Apache-2.0";
const KEYWORDS: [&str; 4] = ["motor", "bearing", "fault-detection", "condition-monitoring"];

/// What the Arduino IDE calls the chips of the library: its folder in `src/`, by the names of cores and units.
pub const ARDUINO: [&str; 2] = ["cortex-m4/fpv4-sp-d16-hard", "cortex-m7/fpv5-sp-d16-hard"];

/// The files, with their places in the archive.
pub fn files(library: &Library<'_>) -> Vec<(String, String)> {
    let all = [
        ("zephyr/module.yml", zephyr_module()),
        ("zephyr/Kconfig", ZEPHYR_KCONFIG.to_owned()),
        ("zephyr/CMakeLists.txt", zephyr_cmake(library)),
        ("library.json", platformio(library)),
        ("platformio.py", platformio_script(library)),
        ("library.properties", arduino(library)),
        ("bearing-watch.pdsc", pdsc(library)),
        ("CMakeLists.txt", esp_idf_cmake(library)),
        ("idf_component.yml", esp_idf(library)),
    ];
    all.into_iter().map(|(name, text)| (name.to_owned(), text)).collect()
}

fn zephyr_module() -> String {
    format!("name: {NAME}\nbuild:\n  cmake: zephyr\n  kconfig: zephyr/Kconfig\n")
}

const ZEPHYR_KCONFIG: &str = "config BEARING_WATCH
	bool \"Detection of bearing faults\"
	depends on CPU_CORTEX_M4 || CPU_CORTEX_M7
	depends on FPU && FP_HARDABI
	help
	  Links the library bearing-watch. If interrupts and threads both
	  compute with floats, FPU_SHARING is needed, too.
";

fn zephyr_cmake(library: &Library<'_>) -> String {
    let chip = library.targets.chip;
    format!(
        "if(CONFIG_BEARING_WATCH)
    zephyr_include_directories(${{CMAKE_CURRENT_LIST_DIR}}/../include)
    zephyr_link_libraries(${{CMAKE_CURRENT_LIST_DIR}}/../lib/{chip}/libbearing_watch_c.a)
endif()
"
    )
}

fn platformio(library: &Library<'_>) -> String {
    let json = serde_json::json!({
        "name": NAME,
        "version": library.version,
        "description": SENTENCE,
        "keywords": KEYWORDS,
        "authors": [{ "name": AUTHORS }],
        "license": LICENCE,
        "frameworks": "*",
        "platforms": "*",
        "headers": "bearing_watch.h",
        "build": { "includeDir": "include", "srcFilter": "-<*>", "extraScript": "platformio.py" },
    });
    format!("{json:#}\n")
}

fn platformio_script(library: &Library<'_>) -> String {
    let chip = library.targets.chip;
    format!(
        "# Links the library of the archive, which is for chips that pass numbers in registers of a floating-point unit.
import sys
from os.path import join

Import(\"env\", \"pio_lib_builder\")
unit = [flag for flag in map(str, env[\"CCFLAGS\"]) if flag.startswith((\"-mfpu=\", \"-mfloat-abi=\"))]
if \"-mfloat-abi=hard\" not in unit:
    sys.stderr.write(\"error: bearing-watch needs build_flags = -mfpu=fpv4-sp-d16 -mfloat-abi=hard\\n\")
    env.Exit(1)
folder = join(pio_lib_builder.path, \"lib\", \"{chip}\")
env.Append(LIBPATH=[folder], LIBS=[\"bearing_watch_c\", \"m\"], LINKFLAGS=unit)
"
    )
}

fn arduino(library: &Library<'_>) -> String {
    let Library { version, .. } = library;
    format!(
        "name={NAME}\nversion={version}\nauthor={AUTHORS}\nmaintainer={AUTHORS}\nsentence={SENTENCE}\n\
         paragraph={PARAGRAPH}\ncategory=Signal Input/Output\nurl=https://crates.io/crates/bearing-watch-c\n\
         architectures=*\nincludes=bearing_watch.h\nprecompiled=true\nldflags=-lbearing_watch_c\n"
    )
}

fn pdsc(library: &Library<'_>) -> String {
    let Library { version, targets, .. } = library;
    format!(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>
<package schemaVersion=\"1.7.7\" xmlns:xs=\"http://www.w3.org/2001/XMLSchema-instance\">
  <vendor>bearing-watch</vendor>
  <name>{NAME}</name>
  <description>{SENTENCE}</description>
  <url></url>
  <license>LICENSE-MIT</license>
  <releases>
    <release version=\"{version}\">See CHANGELOG.md.</release>
  </releases>
  <conditions>
    <condition id=\"M4 or M7 with a unit of single precision\">
      <accept Dcore=\"Cortex-M4\" Dfpu=\"SP_FPU\"/>
      <accept Dcore=\"Cortex-M7\"/>
    </condition>
  </conditions>
  <components>
    <component Cclass=\"Machine Monitoring\" Cgroup=\"Bearings\" Cversion=\"{version}\" \
         condition=\"M4 or M7 with a unit of single precision\">
      <description>{PARAGRAPH}</description>
      <files>
        <file category=\"include\" name=\"include/\"/>
        <file category=\"header\" name=\"include/bearing_watch.h\"/>
        <file category=\"library\" name=\"lib/{chip}/libbearing_watch_c.a\"/>
        <file category=\"doc\" name=\"INTERFACE.md\"/>
      </files>
    </component>
  </components>
</package>
",
        chip = targets.chip
    )
}

fn esp_idf_cmake(library: &Library<'_>) -> String {
    format!(
        "# The archive as a component of ESP-IDF; other projects use find_package(bearing-watch).
if(NOT ESP_PLATFORM)
    message(FATAL_ERROR \"this file is for ESP-IDF: use find_package(bearing-watch)\")
endif()
idf_component_register(INCLUDE_DIRS include)
if(NOT CONFIG_IDF_TARGET_ARCH_RISCV OR NOT CONFIG_SOC_CPU_HAS_FPU)
    message(FATAL_ERROR \"bearing-watch needs a RISC-V chip with a floating-point unit, such as the ESP32-P4\")
endif()
add_prebuilt_library(bearing_watch_c lib/{}/libbearing_watch_c.a)
target_link_libraries(${{COMPONENT_LIB}} INTERFACE bearing_watch_c m)
",
        library.targets.riscv
    )
}

fn esp_idf(library: &Library<'_>) -> String {
    format!(
        "version: \"{}\"\ndescription: {SENTENCE}\nurl: https://crates.io/crates/bearing-watch-c\nlicense: {LICENCE}\n\
         targets:\n  - esp32p4\ndependencies:\n  idf: \">=5.3\"\n",
        library.version
    )
}

#[cfg(test)]
mod tests {
    use super::super::description::Targets;
    use super::*;

    const LIBRARY: Library<'_> = Library {
        version: "0.3.1",
        targets: Targets { host: "x86_64-unknown-linux-gnu", chip: "thumbv7em-none-eabihf", riscv: "riscv32" },
        system: "-lm",
    };

    fn text(name: &str) -> String {
        files(&LIBRARY).into_iter().find(|(own, _)| own == name).map(|(_, text)| text).unwrap_or_default()
    }

    #[test]
    fn all_name_the_same_library_and_version() {
        for name in ["zephyr/CMakeLists.txt", "platformio.py", "bearing-watch.pdsc"] {
            assert!(text(name).contains("thumbv7em-none-eabihf"), "{name}");
        }
        for name in ["library.json", "library.properties", "bearing-watch.pdsc", "idf_component.yml"] {
            assert!(text(name).contains("0.3.1"), "{name}");
        }
    }

    /// The keys that the specification of Arduino's libraries requires, once each and not empty.
    #[test]
    fn the_properties_of_arduino_have_the_required_keys() {
        let text = text("library.properties");
        for key in
            ["name", "version", "author", "maintainer", "sentence", "paragraph", "category", "url", "architectures"]
        {
            let values: Vec<&str> = text.lines().filter_map(|line| line.strip_prefix(&format!("{key}="))).collect();
            assert!(values.len() == 1 && !values[0].is_empty(), "{key}: {values:?}");
        }
        assert!(text.lines().all(|line| line.split_once('=').is_some()), "{text}");
    }
}
