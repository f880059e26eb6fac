"""Compiler, start-up options and linker script of the emulated chip, as the platform of a chip sets them."""

from SCons.Script import Default, DefaultEnvironment

env = DefaultEnvironment()
for name, tool in {"AR": "gcc-ar", "AS": "as", "CC": "gcc", "CXX": "g++", "LINK": "gcc", "RANLIB": "gcc-ranlib"}.items():
    env[name] = f"arm-none-eabi-{tool}"
machine = ["-mcpu=cortex-m4", "-mthumb"]
env.Append(
    ASFLAGS=machine,
    CCFLAGS=[*machine, "-O2", "-Wall", "-ffunction-sections"],
    LINKFLAGS=[*machine, "--specs=nano.specs", "--specs=rdimon.specs", "-nostartfiles", "-Wl,--gc-sections,-z,noexecstack"],
)
env.Replace(ARFLAGS=["rc"], LDSCRIPT_PATH="stm32f405.ld")
Default(env.BuildProgram())
