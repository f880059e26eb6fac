# The archive as a module of Zephyr, in a folder that has it and the files of its document: its options by the reader of
# Zephyr's own builds, and the firmware by CMake with stand-ins of Zephyr's functions.
set -eu
# Zephyr's own options that the module depends on, of a Cortex-M4F.
cat > Kconfig <<'END'
config CPU_CORTEX_M4
	bool
	default y
config CPU_CORTEX_M7
	bool
config FPU
	bool "Floating-point unit"
config FP_HARDABI
	bool "Numbers in its registers"
config FPU_SHARING
	bool "Registers of each thread"
osource "bearing-watch/zephyr/Kconfig"
END
read_options() {
    "$PYTHON" -c "import kconfiglib
options = kconfiglib.Kconfig('Kconfig', warn_to_stderr=False)
options.load_config('$1')
print(options.syms['BEARING_WATCH'].str_value, *options.warnings)"
}
[ "$(read_options prj.conf)" = y ]
# Without the floating-point unit it cannot be selected.
grep -v '^CONFIG_FPU=y' prj.conf > without.conf
[ "$(read_options without.conf)" = n ]

cp -r bearing-watch/firmware .
sed '/^add_executable(/,$d' bearing-watch/firmware/CMakeLists.txt > firmware/CMakeLists.txt
cat >> firmware/CMakeLists.txt <<'END'
add_executable(${CMAKE_PROJECT_NAME} main.c recorded_drive.c board.c rows.s)
target_include_directories(${CMAKE_PROJECT_NAME} PRIVATE model)
function(zephyr_include_directories)
    target_include_directories(${CMAKE_PROJECT_NAME} PRIVATE ${ARGV})
endfunction()
function(zephyr_link_libraries)
    target_link_libraries(${CMAKE_PROJECT_NAME} m c ${ARGV})
endfunction()
set(CONFIG_BEARING_WATCH y)
add_subdirectory(../bearing-watch/zephyr zephyr-module)
END
cd firmware
cmake -S . -B build
cmake --build build
