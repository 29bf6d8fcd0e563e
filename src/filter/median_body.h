/* Medians of rows for one type of key. Before it: KEY and NAME(x), which names a function for it.
 *
 * All loops have a constant number of turns and arrays that do not overlap: they become vectors. */

typedef KEY NAME(block)[BLOCK + SLACK];

VV_INLINE void NAME(order)(KEY *restrict a, KEY *restrict b)
{
    for (int i = 0; i < BLOCK; i++) {
        const KEY x = a[i], y = b[i];
        a[i] = x < y ? x : y;
        b[i] = x < y ? y : x;
    }
}

/* Sorted from the least to the greatest: 25 comparisons of the network of depth 7 for nine, 3 for three. */
VV_INLINE void NAME(sort)(NAME(block) * s, int n)
{
    static const uint8_t nine[25][2] = {{0, 3}, {1, 7}, {2, 5}, {4, 8}, {0, 7}, {2, 4}, {3, 8}, {5, 6}, {0, 2},
                                        {1, 3}, {4, 5}, {7, 8}, {1, 4}, {3, 6}, {5, 7}, {0, 1}, {2, 4}, {3, 5},
                                        {6, 8}, {2, 3}, {4, 5}, {6, 7}, {1, 2}, {3, 4}, {5, 6}};
    static const uint8_t three[3][2] = {{0, 1}, {1, 2}, {0, 1}};
    if (n == 9)
        for (int c = 0; c < 25; c++)
            NAME(order)(s[nine[c][0]], s[nine[c][1]]);
    else if (n == 3)
        for (int c = 0; c < 3; c++)
            NAME(order)(s[three[c][0]], s[three[c][1]]);
}

/* The least, middle and greatest of neighbours i, i + 1 and i + 2. */
VV_INLINE void NAME(split)(KEY *restrict lo, KEY *restrict mid, KEY *restrict hi, const KEY *restrict s)
{
    for (int i = 0; i < BLOCK; i++) {
        const KEY a = s[i], b = s[i + 1], c = s[i + 2];
        const KEY less = a < b ? a : b, more = a < b ? b : a, inner = more < c ? more : c;
        lo[i] = less < c ? less : c;
        hi[i] = more < c ? c : more;
        mid[i] = less < inner ? inner : less;
    }
}

/* The median of n rows, n odd: the least and the greatest of more than half of them are not it. Rows are mixed. */
VV_INLINE KEY *NAME(middle)(KEY **rows, int n)
{
    KEY **v = rows;
    int next = n / 2 + 2;
    for (int count = next;; count--) {
        for (int i = 0; i < count / 2; i++)
            NAME(order)(v[i], v[count - 1 - i]);
        for (int i = 1; i < (count + 1) / 2; i++)
            NAME(order)(v[0], v[i]);
        for (int i = count / 2; i < count - 1; i++)
            NAME(order)(v[i], v[count - 1]);
        if (count == 3)
            return v[1];
        v[count - 1] = rows[next++]; /* in the place of the greatest */
        v++;                         /* without the least */
    }
}

/* Sorted columns of nine and three of them side by side: sorted across as well, all but the 13 that can be the median
 * have too many below or above them. */
VV_INLINE const KEY *NAME(across_nine)(NAME(block) * s, NAME(block) * kept)
{
    NAME(block) spare[2];
    KEY *v[13];
    int n = 0;
    for (int i = 0; i < 9; i++) {
        KEY *lo = i >= 5 ? kept[n++] : spare[0];
        KEY *mid = i >= 2 && i <= 6 ? kept[n++] : spare[1];
        NAME(split)(lo, mid, i <= 3 ? kept[n++] : kept[13], s[i]);
    }
    for (int i = 0; i < 13; i++)
        v[i] = kept[i];
    return NAME(middle)(v, 13);
}

/* The same of columns of three: the greatest least, the middle of the middle ones and the least greatest are left. */
VV_INLINE const KEY *NAME(across_three)(NAME(block) * s, NAME(block) * kept)
{
    NAME(block) lo[3], mid[3], hi[3];
    for (int i = 0; i < 3; i++)
        NAME(split)(lo[i], mid[i], hi[i], s[i]);
    NAME(sort)(mid, 3);
    for (int i = 0; i < BLOCK; i++) {
        const KEY a = lo[0][i] < lo[1][i] ? lo[1][i] : lo[0][i], b = hi[0][i] < hi[1][i] ? hi[0][i] : hi[1][i];
        kept[0][i] = a < lo[2][i] ? lo[2][i] : a;
        kept[1][i] = mid[1][i];
        kept[2][i] = b < hi[2][i] ? b : hi[2][i];
    }
    NAME(sort)(kept, 3);
    return kept[1];
}

static void NAME(row)(void *out, const void *const *rows, int n_rows, int width, int64_t n)
{
    NAME(block) s[9], kept[14];
    for (int64_t at = 0; at < n; at += STEP) {
        const int64_t now = n - at < STEP ? n - at : STEP;
        const KEY *median = s[n_rows / 2];
        for (int r = 0; r < n_rows; r++)
            memcpy(s[r], (const KEY *)rows[r] + at, sizeof s[r]);
        NAME(sort)(s, n_rows);
        if (width == 3 && n_rows == 9) {
            median = NAME(across_nine)(s, kept);
        } else if (width == 3 && n_rows == 3) {
            median = NAME(across_three)(s, kept);
        } else if (width == 3) {
            NAME(split)(kept[0], kept[1], kept[2], s[0]);
            median = kept[1];
        }
        memcpy((KEY *)out + at, median, (size_t)now * sizeof *median);
    }
}

#undef KEY
#undef NAME
