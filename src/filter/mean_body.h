/* Sums of boxes for one kind of number. Before it: NUMBER, and NAME(x), which names something for it. */

#define LOAD(ctype)                                                                                                    \
    for (int64_t i = 0; i < n; i++) {                                                                                  \
        ctype v;                                                                                                       \
        memcpy(&v, in + i * step, sizeof v);                                                                           \
        to[i] = (NUMBER)v;                                                                                             \
    }                                                                                                                  \
    break

static void NAME(load)(void *out, const char *in, int64_t step, vv_type type, int64_t n)
{
    NUMBER *to = out;
    switch (type) {
    case VV_TYPE_U8:
        LOAD(uint8_t);
    case VV_TYPE_I8:
        LOAD(int8_t);
    case VV_TYPE_U16:
        LOAD(uint16_t);
    case VV_TYPE_I16:
        LOAD(int16_t);
    case VV_TYPE_U32:
        LOAD(uint32_t);
    case VV_TYPE_I32:
        LOAD(int32_t);
    case VV_TYPE_U64:
        LOAD(uint64_t);
    case VV_TYPE_I64:
        LOAD(int64_t);
    case VV_TYPE_F32:
        LOAD(float);
    case VV_TYPE_F64:
        LOAD(double);
    }
}

/* out[i] = a[i] + a[i + first], and + b[i + second] if there is b. `out` may be a: what lies ahead is read before. */
static void NAME(join)(NUMBER *out, const NUMBER *a, int64_t first, const NUMBER *b, int64_t second, int64_t n)
{
    for (int64_t at = 0; at < n; at += AT_ONCE) {
        NUMBER sum[AT_ONCE];
        const int64_t now = n - at < AT_ONCE ? n - at : AT_ONCE;
        for (int64_t i = 0; i < now; i++)
            sum[i] = a[at + i] + a[at + i + first];
        for (int64_t i = 0; i < now && b; i++)
            sum[i] += b[at + i + second];
        memcpy(out + at, sum, (size_t)now * sizeof *sum);
    }
}

/* Runs of `width` numbers, `step` from one to the next, from the highest binary digit of width to the lowest. */
static bool NAME(run)(NUMBER *out, const NUMBER *in, int64_t n, int64_t step, int64_t width)
{
    int digit = 0;
    const NUMBER *from = in;
    int64_t done = 1;
    while (width >> (digit + 1))
        digit++;
    for (digit--; digit >= 0; digit--) {
        const int64_t odd = width >> digit & 1, next = 2 * done + odd;
        NAME(join)(out, from, done * step, odd ? in : NULL, 2 * done * step, n - (next - 1) * step);
        from = out;
        done = next;
    }
    return from == out;
}

static void *NAME(sum)(void *block, void *room, const int64_t dims[3], const int64_t radius[3])
{
    const int64_t step[3] = {1, dims[0], dims[0] * dims[1]}, all = step[2] * dims[2];
    NUMBER *in = block, *out = room;
    for (int a = 0; a < 3; a++)
        if (NAME(run)(out, in, all, step[a], 2 * radius[a] + 1)) {
            NUMBER *const other = in;
            in = out;
            out = other;
        }
    return in;
}

static void NAME(give)(double *out, const void *in, int64_t n)
{
    for (int64_t i = 0; i < n; i++)
        out[i] = (double)((const NUMBER *)in)[i];
}

const vvi_mean_lines NAME(vvi_mean_lines) = {
    .bytes = sizeof(NUMBER),
    .load = NAME(load),
    .sum = NAME(sum),
    .give = NAME(give),
};

#undef LOAD
#undef NUMBER
#undef NAME
