/* Bilateral means of rows for one type of number. Before it: REAL and NAME(x), which names a function for it. */

static void NAME(bilateral)(void *out_in, const void *row_in, const vvi_bilateral_taps *taps, double width, int64_t n)
{
    const REAL *row = row_in, inverse = (REAL)(1 / width);
    REAL *out = out_in;
    for (int64_t at = 0; at < n; at += BLOCK) {
        const REAL *c = row + at;
        vf sum[VECTORS], weights[VECTORS];
        VV_UNROLL
        for (int v = 0; v < VECTORS; v++)
            sum[v] = weights[v] = vf_set1(0);
        for (int64_t t = 0; t < taps->n; t++) {
            const REAL *a = c + taps->offset[t];
            const vf place = vf_set1(taps->weight[t]);
            float u[BLOCK];
            for (int i = 0; i < BLOCK; i++)
                u[i] = (float)((a[i] - c[i]) * inverse);
            VV_UNROLL
            for (int v = 0; v < VECTORS; v++) {
                const vf d = vf_load(u + v * VV_WIDTH), less = d * d;
                const vm counts = vf_lt(less, vf_set1(VVI_SMOOTHING_LEAST));
                const vf w = vf_select(counts, vf_exp2(place - less), vf_set1(0));
                sum[v] = vf_fma(w, vf_select(counts, d, vf_set1(0)), sum[v]);
                weights[v] = weights[v] + w;
            }
        }
        float mean[BLOCK];
        VV_UNROLL
        for (int v = 0; v < VECTORS; v++)
            vf_store(mean + v * VV_WIDTH, sum[v] / vf_max(weights[v], vf_set1(1e-30f)));
        for (int i = 0; i < BLOCK; i++)
            out[at + i] = c[i] + (REAL)(mean[i] * width);
    }
}
