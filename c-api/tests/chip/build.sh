# Programs in C and C++ for the drive's chip, with the C library LIBRARY, in the folder OUT, from the root:
#
#     build.sh LIBRARY OUT example NAME MODEL c|c++     an example with the model of a folder, as OUT/NAME
#     build.sh LIBRARY OUT whole_drive                  prints the bytes of flash that a whole drive adds to a program
#     build.sh LIBRARY OUT orders                       a program has the same functions of newlib with the library, in
#                                                       any order on the linker's command line, as without it
set -eu
library=$1 out=$2 action=$3
chip="-mcpu=cortex-m4 -mthumb -mfpu=fpv4-sp-d16 -mfloat-abi=hard"
linked="--specs=nano.specs -nostartfiles -Wl,--gc-sections,-z,noexecstack,--no-warn-rwx-segments -T c-api/examples/stm32f405.ld"
mkdir -p "$out"

# compile SOURCE MODEL OBJECT FLAGS…; the header of a library for one plan lies beside it.
compile() {
    source=$1 model=$2 object=$3
    shift 3
    # shellcheck disable=SC2086
    arm-none-eabi-gcc $chip -Wall -Wextra -Wpedantic -Werror -O2 -ffunction-sections -fdata-sections -Ic-api/include \
        "-I$model" "-I$(dirname "$library")" "$@" -c "c-api/$source" -o "$object"
}

# link LINKER OBJECT WORDS…, without start-up code; LIBRARY is the one that is checked. g++ links with the library of
# C++, which its package does not have and the program does not need.
link() {
    linker=$1 object=$2 words=$(echo "$3" | sed "s|PROGRAM|$2|g; s|LIBRARY|$library|g")
    for empty in libstdc++.a libstdc++_nano.a; do echo '!<arch>' > "$out/$empty"; done
    # shellcheck disable=SC2086
    "arm-none-eabi-$linker" $chip $linked -Wl,-e,main "-L$out" $words -o "$out/program"
}
flash() { arm-none-eabi-size "$out/program" | awk 'NR == 2 { print $1 + $2 }'; }

case $action in
example)
    name=$4 model=$5 language="-std=c99" data=held_out.s
    # Without the library of C++, which the package of the compiler does not have.
    [ "$6" = c ] || language="-x c++ -std=c++17 -nostdinc++ -fno-exceptions -fno-rtti"
    # shellcheck disable=SC2086
    compile "examples/$name.c" "$model" "$out/$name.o" $language
    compile examples/board.c "$model" "$out/board.o" -std=c99
    set -- "$out/$name.o" "$out/board.o"
    [ "$name" != signed ] || data=signed_model.s
    case $model in *standard_rig) compile "examples/$data" "$model" "$out/data.o" && set -- "$@" "$out/data.o" ;; esac
    # Output by semihosting.
    # shellcheck disable=SC2086
    arm-none-eabi-gcc $chip --specs=rdimon.specs $linked "$@" "$library" -o "$out/$name"
    ;;
whole_drive)
    model=examples/support/actuator
    compile tests/chip/whole_drive.c $model "$out/alone.o" -std=c99 -DALONE
    compile tests/chip/whole_drive.c $model "$out/whole.o" -std=c99
    link gcc "$out/alone.o" "PROGRAM -lm -lc"
    alone=$(flash)
    link gcc "$out/whole.o" "PROGRAM -lm -lc LIBRARY"
    echo $(($(flash) - alone))
    ;;
orders)
    model=examples/support/standard_rig
    # Sizes of functions that Rust brings along too.
    functions() { arm-none-eabi-nm -S "$out/program" | awk '$4 ~ /^(sinf|cosf|memcpy|__aeabi_dmul)$/ { print $2, $4 }' | sort; }
    compile tests/chip/beside_newlib.c $model "$out/alone.o" -std=c99 -DALONE
    compile tests/chip/beside_newlib.c $model "$out/beside.o" -std=c99
    link gcc "$out/alone.o" "PROGRAM -lm -lc"
    expected=$(functions) alone=$(flash) least=999999 most=0
    [ "$(echo "$expected" | wc -l)" = 4 ] || { echo "the program has $expected" >&2; exit 1; }
    while read -r linker words; do
        link "$linker" "$out/beside.o" "$words"
        [ "$(functions)" = "$expected" ] || { echo "$linker $words: $(functions) instead of $expected" >&2; exit 1; }
        added=$(($(flash) - alone))
        [ $added -gt $least ] || least=$added
        [ $added -lt $most ] || most=$added
    done <<'END'
gcc PROGRAM -lm -lc LIBRARY
gcc PROGRAM LIBRARY -lm -lc
gcc -Wl,--start-group LIBRARY -lm -lc PROGRAM -Wl,--end-group
g++ PROGRAM LIBRARY
g++ LIBRARY PROGRAM LIBRARY
END
    # Functions have other addresses, and steps between them other lengths.
    [ "$least" -gt 0 ] && [ $((most - least)) -le 64 ] || { echo "it adds $least to $most bytes" >&2; exit 1; }
    echo "$most bytes of flash"
    ;;
esac
