/* Non-local means of a tile for one type of number. Before it: REAL and NAME(x). Sums are made in an order that does
 * not depend on the tile: a part of a volume gives the same as the whole. */

/* Squares of differences; of what is not finite that of noise. */
VV_INLINE void NAME(squares)(float *out, const REAL *a, const REAL *b, REAL scale, float expected, int64_t n)
{
    for (int64_t at = 0; at < n; at += STEP) {
        float u[STEP];
        for (int i = 0; i < STEP; i++)
            u[i] = (float)((b[at + i] - a[at + i]) * scale);
        VV_UNROLL
        for (int v = 0; v < STEP; v += VV_WIDTH) {
            const vf d = vf_load(u + v);
            vf_store(out + at + v, vf_select(vf_eq(d - d, vf_set1(0)), d * d, vf_set1(expected)));
        }
    }
}

/* One more offset for the sums of a row: weights by the sum of `n_parts` rows of squares. */
VV_INLINE void NAME(weigh)(float *sum, float *weights, const REAL *a, const REAL *b, const float *const *parts,
                           int64_t n_parts, const vvi_nonlocal_tile *t)
{
    const REAL scale = (REAL)t->inverse;
    for (int64_t at = 0; at < t->row_n; at += STEP) {
        float u[STEP];
        for (int i = 0; i < STEP; i++)
            u[i] = (float)((b[at + i] - a[at + i]) * scale);
        VV_UNROLL
        for (int v = 0; v < STEP; v += VV_WIDTH) {
            const vf d = vf_load(u + v);
            vf far = vf_load(parts[0] + at + v);
            for (int64_t p = 1; p < n_parts; p++)
                far = far + vf_load(parts[p] + at + v);
            far = vf_max(far - vf_set1(t->less), vf_set1(0));
            const vm counts = vm_and(vf_lt(far, vf_set1(VVI_SMOOTHING_LEAST)), vf_eq(d - d, vf_set1(0)));
            const vf w = vf_select(counts, vf_exp2(vf_set1(0) - far), vf_set1(0));
            const vf less = vf_select(counts, d, vf_set1(0));
            vf_store(sum + at + v, vf_fma(w, less, vf_load(sum + at + v)));
            vf_store(weights + at + v, vf_load(weights + at + v) + w);
        }
    }
}

static void NAME(nonlocal)(const vvi_nonlocal_tile *t, int64_t offset)
{
    const int64_t px = t->patch[0], py = t->patch[1], pz = t->patch[2], depth = 2 * pz + 1;
    const int64_t row_n = t->row_n, rows = t->n[1] + 2 * py;
    float *raw = t->room, *along_x = raw + row_n + 2 * px + STEP, *along_y = along_x + rows * row_n;
    for (int64_t k = -pz; k < t->n[2] + pz; k++) {
        float *slice = along_y + (k + pz) % depth * t->n[1] * row_n;
        for (int64_t j = 0; j < rows; j++) {
            const REAL *a = (const REAL *)t->numbers + t->first + k * t->stride[1] + (j - py) * t->stride[0] - px;
            NAME(squares)(raw, a, a + offset, (REAL)t->inverse, t->expected, row_n + 2 * px);
            sum_shifted(along_x + j * row_n, raw, 1, 2 * px + 1, row_n);
        }
        for (int64_t j = 0; j < t->n[1]; j++)
            sum_shifted(slice + j * row_n, along_x + j * row_n, row_n, 2 * py + 1, row_n);
        if (k < pz)
            continue;
        for (int64_t j = 0; j < t->n[1]; j++) {
            const float *parts[2 * VVI_NONLOCAL_PATCH_MOST + 1];
            const int64_t at = ((k - pz) * t->n[1] + j) * row_n;
            const REAL *a = (const REAL *)t->numbers + t->first + (k - pz) * t->stride[1] + j * t->stride[0];
            for (int64_t p = 0; p < depth; p++)
                parts[p] = along_y + ((k - pz + p) % depth * t->n[1] + j) * row_n;
            NAME(weigh)(t->sums + at, t->weights + at, a, a + offset, parts, depth, t);
        }
    }
}
