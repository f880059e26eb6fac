/* What a user of CMSIS-DSP writes: recursive least squares from its matrix kernels, its transforms, its decimator. */

#include "dsp/basic_math_functions.h"
#include "dsp/controller_functions.h"
#include "dsp/filtering_functions.h"
#include "dsp/matrix_functions.h"

#define MOST 15

/* k = P x / (lambda + x' P x);  theta += k (y - x' theta);  P = (P - k x' P) / lambda, with x' P = (P x)'. */
void cmsis_rls(uint32_t n, float *p_cells, float *theta, const float *x, float y, float lambda)
{
    float px_cells[MOST], gain_cells[MOST], step[MOST], outer_cells[MOST * MOST], predicted, quadratic;
    arm_matrix_instance_f32 p, px_row, gain, outer;
    arm_mat_init_f32(&p, n, n, p_cells);
    arm_mat_init_f32(&px_row, 1, n, px_cells);
    arm_mat_init_f32(&gain, n, 1, gain_cells);
    arm_mat_init_f32(&outer, n, n, outer_cells);

    arm_mat_vec_mult_f32(&p, x, px_cells);
    arm_dot_prod_f32(x, px_cells, n, &quadratic);
    arm_scale_f32(px_cells, 1.0f / (lambda + quadratic), gain_cells, n);
    arm_dot_prod_f32(x, theta, n, &predicted);
    arm_scale_f32(gain_cells, y - predicted, step, n);
    arm_add_f32(theta, step, theta, n);
    arm_mat_mult_f32(&gain, &px_row, &outer);
    arm_mat_sub_f32(&p, &outer, &p);
    arm_mat_scale_f32(&p, 1.0f / lambda, &p);
}

void cmsis_clarke_park(float ia, float ib, float sine, float cosine, float *d, float *q)
{
    float alpha, beta;
    arm_clarke_f32(ia, ib, &alpha, &beta);
    arm_park_f32(alpha, beta, d, q, sine, cosine);
}

/* One block of `factor` samples gives one output. The instance is not set up anew, which would clear the history. */
float cmsis_decimate(const float *taps, uint16_t count, float *history, uint8_t factor, const float *block)
{
    arm_fir_decimate_instance_f32 filter = {.M = factor, .numTaps = count, .pCoeffs = taps, .pState = history};
    float output;
    arm_fir_decimate_f32(&filter, block, &output, factor);
    return output;
}
