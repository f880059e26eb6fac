# Links the library of the archive, which is for chips that pass numbers in registers of a floating-point unit.
import sys
from os.path import join

Import("env", "pio_lib_builder")
unit = [flag for flag in map(str, env["CCFLAGS"]) if flag.startswith(("-mfpu=", "-mfloat-abi="))]
if "-mfloat-abi=hard" not in unit:
    sys.stderr.write("error: bearing-watch needs build_flags = -mfpu=fpv4-sp-d16 -mfloat-abi=hard\n")
    env.Exit(1)
folder = join(pio_lib_builder.path, "lib", "@CHIP@")
env.Append(LIBPATH=[folder], LIBS=["bearing_watch_c", "m"], LINKFLAGS=unit)
