/* The loops of gaussian_kernel.h for one type of number. Before it: REAL, WHOLE, an integer as wide, and
 * NAME(x), which names a function for it. */

typedef REAL NAME(vector) __attribute__((vector_size(VECTOR_BYTES)));

static void NAME(sum)(void *out, const void *const *rows, const vvi_gaussian_weights *weights, int64_t n)
{
    enum { LANES = VECTOR_BYTES / sizeof(REAL) };
    const int64_t radius = weights->radius;
    for (int64_t at = 0; at < n; at += VECTORS * LANES) {
        NAME(vector) c[VECTORS], sum[VECTORS];
        memcpy(c, (const REAL *)rows[radius] + at, sizeof c);
        VV_UNROLL
        for (int v = 0; v < VECTORS; v++)
            sum[v] = (NAME(vector)){0};
        for (int64_t r = 1; r <= radius; r++) {
            const REAL *below = (const REAL *)rows[radius - r] + at, *above = (const REAL *)rows[radius + r] + at;
            const REAL w = (REAL)weights->w[r];
            VV_UNROLL
            for (int v = 0; v < VECTORS; v++) {
                NAME(vector) a, b;
                memcpy(&a, below + v * LANES, sizeof a);
                memcpy(&b, above + v * LANES, sizeof b);
                sum[v] += w * ((a - c[v]) + (b - c[v]));
            }
        }
        VV_UNROLL
        for (int v = 0; v < VECTORS; v++)
            sum[v] = c[v] + sum[v];
        memcpy((REAL *)out + at, sum, sizeof sum);
    }
}

#define CONVERT(ctype)                                                                                                 \
    for (int64_t at = 0; at < n; at += STEP) {                                                                         \
        ctype v[STEP];                                                                                                 \
        take(v, in + at * (int64_t)sizeof *v, n - at, sizeof *v);                                                      \
        for (int i = 0; i < STEP; i++)                                                                                 \
            out[at + i] = (REAL)v[i];                                                                                  \
    }                                                                                                                  \
    break

static void NAME(load)(void *out_in, const char *in, vv_type type, int64_t n)
{
    REAL *out = out_in;
    switch (type) {
    case VV_TYPE_U8:
        CONVERT(uint8_t);
    case VV_TYPE_I8:
        CONVERT(int8_t);
    case VV_TYPE_U16:
        CONVERT(uint16_t);
    case VV_TYPE_I16:
        CONVERT(int16_t);
    case VV_TYPE_U32:
        CONVERT(uint32_t);
    case VV_TYPE_I32:
        CONVERT(int32_t);
    case VV_TYPE_U64:
        CONVERT(uint64_t);
    case VV_TYPE_I64:
        CONVERT(int64_t);
    case VV_TYPE_F32:
        CONVERT(float);
    case VV_TYPE_F64:
        CONVERT(double);
    }
}
#undef CONVERT

static bool NAME(finite)(void *row_in, void *mask_in, int64_t n)
{
    typedef WHOLE lanes __attribute__((vector_size(VECTOR_BYTES)));
    const NAME(vector) zero = {0}, one = zero + 1;
    REAL *row = row_in, *mask = mask_in;
    lanes missing = {0};
    for (int64_t at = 0; at < n; at += VECTOR_BYTES / (int64_t)sizeof(REAL)) {
        NAME(vector) v;
        memcpy(&v, row + at, sizeof v);
        const lanes there = v - v == zero; /* not of NaN, nor of infinities */
        const NAME(vector) here = (NAME(vector))((lanes)one & there);
        v = (NAME(vector))((lanes)v & there);
        missing |= ~there;
        memcpy(mask + at, &here, sizeof here);
        memcpy(row + at, &v, sizeof v);
    }
    for (size_t i = 0; i < VECTOR_BYTES / sizeof(REAL); i++)
        if (missing[i])
            return false;
    return true;
}

static void NAME(divide)(void *row_in, const void *mask_in, int64_t n)
{
    REAL *row = row_in;
    const REAL *mask = mask_in;
    for (int64_t at = 0; at < n; at += STEP)
        for (int i = 0; i < STEP; i++)
            row[at + i] /= mask[at + i];
}
