/* Fluxes of diffusion between neighbours, of rows of one type of number. Before it: REAL and NAME(x). */

static void NAME(flux)(void *out_in, const void *a_in, const void *b_in, double inverse, bool rational, int64_t n)
{
    const REAL *a = a_in, *b = b_in, scale = (REAL)inverse;
    REAL *out = out_in;
    for (int64_t at = 0; at < n; at += STEP) {
        float g[STEP];
        for (int i = 0; i < STEP; i++)
            g[i] = (float)((b[at + i] - a[at + i]) * scale);
        VV_UNROLL
        for (int v = 0; v < STEP; v += VV_WIDTH) {
            const vf u = vf_load(g + v), square = u * u, none = vf_set1(0);
            vf passes = vf_exp2(none - square);
            if (rational)
                passes = vf_set1(1) / (vf_set1(1) + square);
            const vm counts = vf_lt(square, vf_set1(rational ? 1e36f : VVI_SMOOTHING_LEAST));
            vf_store(g + v, vf_select(counts, passes, none));
        }
        for (int i = 0; i < STEP; i++) {
            const REAL f = (REAL)g[i] * (b[at + i] - a[at + i]);
            out[at + i] = g[i] > 0 ? f : 0;
        }
    }
}

static void NAME(spread)(void *out_in, const void *row_in, const void *const flux_in[6], const double rate[3],
                         int64_t n)
{
    const REAL *row = row_in, *const *flux = (const REAL *const *)flux_in;
    const REAL x = (REAL)rate[0], y = (REAL)rate[1], z = (REAL)rate[2];
    REAL *out = out_in;
    for (int64_t at = 0; at < n; at += STEP) {
        REAL sum[STEP];
        for (int i = 0; i < STEP; i++)
            sum[i] = x * (flux[1][at + i] - flux[0][at + i]);
        for (int i = 0; i < STEP; i++)
            sum[i] += y * (flux[3][at + i] - flux[2][at + i]);
        for (int i = 0; i < STEP; i++)
            sum[i] += z * (flux[5][at + i] - flux[4][at + i]);
        for (int i = 0; i < STEP; i++)
            sum[i] += row[at + i];
        memcpy(out + at, sum, sizeof sum);
    }
}
