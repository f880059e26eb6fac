//! Compiles the C rivals: the hand-written one, and CMSIS-DSP from the folder that `CMSIS_DSP` names.

use std::env;
use std::path::PathBuf;

/// What the C rivals call, below `Source`.
const KERNELS: [&str; 9] = [
    "BasicMathFunctions/arm_add_f32.c",
    "BasicMathFunctions/arm_dot_prod_f32.c",
    "BasicMathFunctions/arm_scale_f32.c",
    "FilteringFunctions/arm_fir_decimate_f32.c",
    "MatrixFunctions/arm_mat_init_f32.c",
    "MatrixFunctions/arm_mat_mult_f32.c",
    "MatrixFunctions/arm_mat_scale_f32.c",
    "MatrixFunctions/arm_mat_sub_f32.c",
    "MatrixFunctions/arm_mat_vec_mult_f32.c",
];

fn main() {
    println!("cargo::rerun-if-changed=c");
    println!("cargo::rerun-if-env-changed=CMSIS_DSP");
    let cmsis = PathBuf::from(env::var_os("CMSIS_DSP").expect("CMSIS_DSP: run by `cargo xtask measure --peers`"));
    let sources = KERNELS.map(|kernel| cmsis.join("Source").join(kernel));
    cc::Build::new()
        .compiler("arm-none-eabi-gcc")
        .archiver("arm-none-eabi-ar")
        .no_default_flags(true)
        .warnings(false)
        .flags(["-O3", "-mcpu=cortex-m4", "-mthumb", "-mfpu=fpv4-sp-d16", "-mfloat-abi=hard", "-ffunction-sections"])
        // CMSIS-DSP's own advice for speed, and its own switch for compilers without CMSIS-Core's header.
        .define("ARM_MATH_LOOPUNROLL", None)
        .define("__GNUC_PYTHON__", None)
        .include(cmsis.join("Include"))
        .include(cmsis.join("PrivateInclude"))
        .files(["c/rls.c", "c/cmsis.c"])
        .files(sources)
        .compile("rivals");
}
