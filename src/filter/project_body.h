/* The loops of project_kernel.h for one type of sample. Before it: SAMPLE and NAME(x), which names a function for it.
 * WHOLE: a whole number that holds the sum of WHOLE_ROWS of them; not defined: there is none. Nothing is worked out on
 * a condition alone: vectors have no branches. */

#define LARGER(a, b) ((((b) != (b)) | ((b) <= (a))) ? (a) : (b))
#define SMALLER(a, b) ((((b) != (b)) | ((b) >= (a))) ? (a) : (b))

/* Sample by sample; along the row, the blocks together, and in the end their halves. */
#define EXTREME(name, BETTER)                                                                                          \
    static void NAME(name)(void *extreme, const char *row, int64_t n)                                                  \
    {                                                                                                                  \
        SAMPLE *out = extreme;                                                                                         \
        for (int64_t at = 0; at < n; at += STEP, row += STEP * sizeof(SAMPLE)) {                                       \
            SAMPLE v[STEP], best[STEP];                                                                                \
            take(v, row, n - at, sizeof *v);                                                                           \
            take(best, out + at, n - at, sizeof *best);                                                                \
            for (int i = 0; i < STEP; i++)                                                                             \
                best[i] = BETTER(best[i], v[i]);                                                                       \
            give(out + at, best, n - at, sizeof *best);                                                                \
        }                                                                                                              \
    }                                                                                                                  \
    static void NAME(name##_of)(void *extreme, const char *row, int64_t n)                                             \
    {                                                                                                                  \
        SAMPLE best[STEP], *out = extreme;                                                                             \
        for (int i = 0; i < STEP; i++)                                                                                 \
            best[i] = *out;                                                                                            \
        for (int64_t at = 0; at < n; at += STEP, row += STEP * sizeof(SAMPLE)) {                                       \
            SAMPLE v[STEP];                                                                                            \
            take(v, row, n - at, sizeof *v);                                                                           \
            for (int i = (int)(n - at); i < STEP; i++)                                                                 \
                v[i] = *out;                                                                                           \
            for (int i = 0; i < STEP; i++)                                                                             \
                best[i] = BETTER(best[i], v[i]);                                                                       \
        }                                                                                                              \
        VV_UNROLL                                                                                                      \
        for (int half = STEP / 2; half > 0; half /= 2)                                                                 \
            for (int i = 0; i < half; i++)                                                                             \
                best[i] = BETTER(best[i], best[half + i]);                                                             \
        *out = best[0];                                                                                                \
    }
EXTREME(largest, LARGER)
EXTREME(smallest, SMALLER)
#undef EXTREME
#undef LARGER
#undef SMALLER

/* Numbers first: with gcc 12 comparisons of what were floats are no vectors beside sums of doubles. */
static void NAME(numbers)(double out[STEP], const char *row, int64_t n)
{
    SAMPLE v[STEP];
    take(v, row, n, sizeof *v);
    for (int i = 0; i < STEP; i++)
        out[i] = (double)v[i];
}

#ifdef WHOLE
/* Whole numbers are added as such: no sum of doubles of them is rounded, either. */
static void NAME(sum)(const vvi_project_sums *sums, const char *row, int64_t rows, int64_t step, int64_t n)
{
    for (int64_t at = 0; at < n; at += STEP, row += STEP * sizeof(SAMPLE))
        for (int64_t first = 0; first < rows; first += WHOLE_ROWS) {
            const int64_t end = rows - first < WHOLE_ROWS ? rows : first + WHOLE_ROWS;
            WHOLE whole[STEP] = {0};
            double sum[STEP];
            for (int64_t r = first; r < end; r++) {
                SAMPLE v[STEP];
                take(v, row + r * step, n - at, sizeof *v);
                for (int i = 0; i < STEP; i++)
                    whole[i] += v[i];
            }
            take(sum, sums->sum + at, n - at, sizeof *sum);
            for (int i = 0; i < STEP; i++)
                sum[i] += (double)whole[i];
            give(sums->sum + at, sum, n - at, sizeof *sum);
        }
}
#else
static void NAME(sum)(const vvi_project_sums *sums, const char *row, int64_t rows, int64_t step, int64_t n)
{
    for (int64_t at = 0; at < n; at += STEP, row += STEP * sizeof(SAMPLE)) {
        double sum[STEP];
        take(sum, sums->sum + at, n - at, sizeof *sum);
        for (int64_t r = 0; r < rows; r++) {
            double v[STEP];
            NAME(numbers)(v, row + r * step, n - at);
            if (!add(sum, v))
                count_missing(sums->count + at, v, n - at);
        }
        give(sums->sum + at, sum, n - at, sizeof *sum);
    }
}
#endif

static void NAME(square)(const vvi_project_sums *sums, const char *row, int64_t n)
{
    for (int64_t at = 0; at < n; at += STEP, row += STEP * sizeof(SAMPLE)) {
        double v[STEP], mean[STEP], square[STEP], count[STEP];
        NAME(numbers)(v, row, n - at);
        take(mean, sums->sum + at, n - at, sizeof *mean);
        take(square, sums->square + at, n - at, sizeof *square);
        take(count, sums->count + at, n - at, sizeof *count);
        add_square(mean, square, count, v);
        give(sums->sum + at, mean, n - at, sizeof *mean);
        give(sums->square + at, square, n - at, sizeof *square);
        give(sums->count + at, count, n - at, sizeof *count);
    }
}

#ifdef WHOLE
static void NAME(sum_of)(const vvi_project_sums *sums, const char *row, int64_t n)
{
    double sum = 0;
    for (int64_t first = 0; first < n; first += WHOLE_ROWS) { /* samples here: as many in one number as there can be */
        const int64_t end = n - first < WHOLE_ROWS ? n : first + WHOLE_ROWS;
        WHOLE whole[STEP] = {0}, all = 0;
        for (int64_t at = first; at < end; at += STEP) {
            SAMPLE v[STEP];
            take(v, row + at * (int64_t)sizeof *v, end - at, sizeof *v);
            for (int i = 0; i < STEP; i++)
                whole[i] += v[i];
        }
        for (int i = 0; i < STEP; i++)
            all += whole[i];
        sum += (double)all;
    }
    *sums->sum = sum;
    *sums->count = 0;
}
#else
/* Behind the end of the row are zeros. */
static void NAME(sum_of)(const vvi_project_sums *sums, const char *row, int64_t n)
{
    double v[STEP], sum[STEP] = {0}, missing[STEP] = {0};
    for (int64_t at = 0; at < n; at += STEP, row += STEP * sizeof(SAMPLE)) {
        NAME(numbers)(v, row, n - at);
        if (!add(sum, v))
            count_missing(missing, v, n - at);
    }
    *sums->sum = halves_added(sum);
    *sums->count = halves_added(missing);
}
#endif

/* The row is in the cache: first the mean, then what is away from it. */
static void NAME(square_of)(const vvi_project_sums *sums, const char *row, int64_t n)
{
    double v[STEP], square[STEP] = {0};
    NAME(sum_of)(sums, row, n);
    const double count = (double)n - *sums->count, mean = *sums->sum / count;
    for (int64_t at = 0; at < n; at += STEP, row += STEP * sizeof(SAMPLE)) {
        NAME(numbers)(v, row, n - at);
        for (int i = (int)(n - at); i < STEP; i++)
            v[i] = mean;
        for (int i = 0; i < STEP; i++) {
            const double away = v[i] - mean, all = square[i] + away * away;
            square[i] = away == away ? all : square[i];
        }
    }
    *sums->sum = mean;
    *sums->count = count;
    *sums->square = halves_added(square);
}
