/* Recursive least squares in covariance form by hand: the upper triangle of the symmetric P alone is kept up. */

#define RLS(N)                                                                                                         \
    void rls_##N(float p[N][N], float theta[N], const float x[N], float y, float lambda)                               \
    {                                                                                                                  \
        float px[N];                                                                                                   \
        for (int i = 0; i < N; i++)                                                                                    \
            px[i] = p[i][i] * x[i];                                                                                    \
        _Pragma("GCC unroll 16") for (int i = 0; i < N; i++)                                                           \
        {                                                                                                              \
            float sum = px[i];                                                                                         \
            _Pragma("GCC unroll 16") for (int j = i + 1; j < N; j++)                                                   \
            {                                                                                                          \
                sum += p[i][j] * x[j];                                                                                 \
                px[j] += p[i][j] * x[i];                                                                               \
            }                                                                                                          \
            px[i] = sum;                                                                                               \
        }                                                                                                              \
        float denominator = lambda, error = y;                                                                         \
        _Pragma("GCC unroll 16") for (int i = 0; i < N; i++)                                                           \
        {                                                                                                              \
            denominator += x[i] * px[i];                                                                               \
            error -= x[i] * theta[i];                                                                                  \
        }                                                                                                              \
        float one_over = 1.0f / denominator, growth = 1.0f / lambda;                                                   \
        _Pragma("GCC unroll 16") for (int i = 0; i < N; i++)                                                           \
        {                                                                                                              \
            float gain = px[i] * one_over;                                                                             \
            theta[i] += gain * error;                                                                                  \
            _Pragma("GCC unroll 16") for (int j = i; j < N; j++)                                                       \
                p[i][j] = (p[i][j] - gain * px[j]) * growth;                                                           \
        }                                                                                                              \
    }

RLS(8)
RLS(15)
