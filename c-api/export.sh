#!/bin/sh
# Makes a static library whose only global symbols are the functions `bw_…`:
#
#     sh export.sh PREFIX LIBRARY OUT      PREFIX of the binary utilities: arm-none-eabi- for chips, '' for this machine
#
# LD_FLAGS has what the linker must be told of the chip, as `-m elf32lriscv` for RISC-V of 32 bits.
#
# The library that cargo makes also defines, as weak symbols, functions such as `sinf`, `memcpy` and `__aeabi_dmul`,
# which Rust brings along. Where it comes before the C library on the linker's command line, as always with g++, they
# would serve the whole program: several times slower, and without a message.
#
# Of a library for one plan it also writes bearing_watch_plan.h beside OUT: the sizes of its memory, for bearing_watch.h.
set -eu
prefix=$1 library=$2 out=$3
object=${out%.a}.o
# Sections are not merged, also those of texts: --gc-sections of the program's link still leaves out what is not called.
roots=$("${prefix}nm" -g --defined-only "$library" 2>/dev/null | sed -n 's/^.* T \(bw_[a-z0-9_]*\)$/-u \1/p' | sort -u)
# shellcheck disable=SC2086
"${prefix}ld" ${LD_FLAGS:-} -r --gc-sections --unique='.rodata.str*' $roots "$library" -o "$object"
# Bitcode of the compiler's own library, which is not code of the program, cannot be joined.
"${prefix}objcopy" --wildcard --keep-global-symbol='bw_*' --remove-section=.llvmbc --remove-section=.llvmcmd "$object"
rm -f "$out"
"${prefix}ar" rcsD "$out" "$object"
rm "$object"
size() { "${prefix}nm" "$library" 2>/dev/null | sed -n "s/^0*\([0-9a-f][0-9a-f]*\) A bw_size_of_$1\$/0x\1/p" | head -n 1; }
state=$(size state)
plan=$(dirname "$out")/bearing_watch_plan.h
rm -f "$plan"
if [ -n "$state" ]; then
    {
        echo "/* What this library needs, which has a model of its own. Made by export.sh. */"
        echo "#define BW_LIBRARY_HAS_MODEL 1"
        echo "#define BW_PLAN_STATE_SIZE $((state))u"
        echo "#define BW_PLAN_FRONT_END_SIZE $(($(size front_end)))u"
    } > "$plan"
fi
