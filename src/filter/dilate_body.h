/* The greatest of rows for one type of key. Before it: KEY, LEAST, and NAME(x), which names a function for it.
 *
 * Inner loops have a constant number of turns: they become vectors. */

enum { NAME(BLOCK) = VVI_DILATE_GUARD / sizeof(KEY) };

VV_INLINE KEY NAME(larger)(KEY a, KEY b)
{
    return a < b ? b : a;
}

static void NAME(most)(void *out, const void *const *rows, int n_rows, int64_t n)
{
    for (int64_t at = 0; at < n; at += NAME(BLOCK)) {
        KEY most[NAME(BLOCK)];
        int r = 1;
        memcpy(most, (const KEY *)rows[0] + at, sizeof most);
        for (; r + 3 < n_rows; r += 4) {
            const KEY *a = (const KEY *)rows[r] + at, *b = (const KEY *)rows[r + 1] + at;
            const KEY *c = (const KEY *)rows[r + 2] + at, *d = (const KEY *)rows[r + 3] + at;
            for (int i = 0; i < NAME(BLOCK); i++) {
                const KEY ab = NAME(larger)(a[i], b[i]), cd = NAME(larger)(c[i], d[i]);
                most[i] = NAME(larger)(most[i], NAME(larger)(ab, cd));
            }
        }
        for (; r < n_rows; r++) {
            const KEY *a = (const KEY *)rows[r] + at;
            for (int i = 0; i < NAME(BLOCK); i++)
                most[i] = NAME(larger)(most[i], a[i]);
        }
        if (n - at < NAME(BLOCK))
            memcpy((KEY *)out + at, most, (size_t)(n - at) * sizeof(KEY));
        else
            memcpy((KEY *)out + at, most, sizeof most);
    }
}

static bool NAME(prepare)(void *keys, int64_t n, int turn, int64_t lo, int64_t hi)
{
    const KEY greatest = (KEY)~LEAST, mask = (KEY)turn;
    const KEY low = lo < LEAST ? LEAST : (KEY)lo, high = hi > greatest ? greatest : (KEY)hi;
    KEY odd[NAME(BLOCK)] = {0}, any = 0;
    for (int64_t at = 0; at < n; at += NAME(BLOCK)) {
        KEY k[NAME(BLOCK)];
        const bool last = n - at < NAME(BLOCK);
        memcpy(k, (const KEY *)keys + at, sizeof k);
        for (int64_t i = n - at; i < NAME(BLOCK); i++)
            k[i] = low;
        for (int i = 0; i < NAME(BLOCK); i++) {
            const KEY out = (KEY)((k[i] < low) | (k[i] > high));
            odd[i] |= out;
            k[i] = out ? LEAST : (KEY)(k[i] ^ mask);
        }
        memcpy((KEY *)keys + at, k, last ? (size_t)(n - at) * sizeof(KEY) : sizeof k);
    }
    for (int i = 0; i < NAME(BLOCK); i++)
        any |= odd[i];
    return any != 0;
}

#undef KEY
#undef LEAST
#undef NAME
