# The sketch of the archive, compiled as the Arduino IDE does, with a stand-in of the core beside this file.
set -eu
sketch=bearing-watch/examples/BearingWatch examples=$CHECKOUT/c-api/examples core=$CHECKOUT/c-api/tests/arduino
flags="-mcpu=cortex-m4 -mthumb -mfpu=fpv4-sp-d16 -mfloat-abi=hard -O2 -Wall -Wextra -Werror -ffunction-sections"
includes="-Ibearing-watch/src -I$sketch -I$core -I$examples"
# The IDE puts the header of the core before the sketch.
{ echo '#include <Arduino.h>'; cat "$sketch/BearingWatch.ino"; } > sketch.cpp
# shellcheck disable=SC2086
arm-none-eabi-g++ $flags $includes -std=gnu++17 -fno-exceptions -fno-rtti -fno-threadsafe-statics -c sketch.cpp \
    "$core/core.cpp"
# shellcheck disable=SC2086
arm-none-eabi-gcc $flags $includes --specs=nano.specs --specs=rdimon.specs -nostartfiles \
    -Wl,--gc-sections,-z,noexecstack,--no-warn-rwx-segments sketch.o core.o -T "$examples/stm32f405.ld" \
    "$examples/board.c" "$examples/held_out.s" "-Wa,-I$CHECKOUT/examples/support/standard_rig" \
    -Lbearing-watch/src/cortex-m4/fpv4-sp-d16-hard -lbearing_watch_c -lm -o sketch
