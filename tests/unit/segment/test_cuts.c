/* What divides a histogram, against trying every way to divide it. */
#include "fields.h"
#include "segment/cuts.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>

enum { MOST = 14 };

static double spread(const vvi_histogram *h, size_t first, size_t end)
{
    double n = 0, sum = 0, squares = 0;
    for (size_t i = first; i < end; i++) {
        n += h->count[i];
        sum += h->count[i] * h->value[i];
    }
    for (size_t i = first; i < end; i++)
        squares += h->count[i] * (h->value[i] - sum / n) * (h->value[i] - sum / n);
    return squares;
}

/* The least sum of squares within classes, of all ways to divide bins from `first` on. */
static double least(const vvi_histogram *h, size_t first, int n_classes)
{
    double best = INFINITY;
    if (n_classes == 1)
        return spread(h, first, h->n);
    for (size_t end = first + 1; end + (size_t)n_classes - 1 <= h->n; end++)
        best = fmin(best, spread(h, first, end) + least(h, end, n_classes - 1));
    return best;
}

static void classes_vary_least_within_themselves(void **state)
{
    (void)state;
    const uint64_t seed = test_seed();
    for (uint64_t t = 0; t < 300; t++) {
        double value[MOST], count[MOST];
        const int n_classes = 2 + (int)(t % 4);
        vvi_histogram h = {.n = (size_t)n_classes + (size_t)(test_random(seed, t) % (uint64_t)(MOST - n_classes)),
                           .value = value,
                           .count = count};
        size_t last[VVI_CUTS_MOST];
        for (size_t i = 0; i < h.n; i++) {
            value[i] = 1e6 + (double)(3 * i) + (double)(test_random(seed + t, i) % 3);
            count[i] = 1 + (double)(test_random(seed + t, 100 + i) % 50);
        }
        assert_int_equal(vvi_otsu(last, &h, n_classes, NULL), VV_OK);
        double got = 0;
        for (int c = 0; c < n_classes; c++)
            got += spread(&h, c ? last[c - 1] + 1 : 0, c + 1 < n_classes ? last[c] + 1 : h.n);
        const double want = least(&h, 0, n_classes);
        if (fabs(got - want) > 1e-7 * (1 + want))
            fail_msg("%d classes of %zu bins: %g within them, %g is possible", n_classes, h.n, got, want);
    }
}

/* At Li's value t the means below and above satisfy t = (back - fore) / (log back - log fore). */
static void li_is_where_its_equation_holds(void **state)
{
    (void)state;
    double value[1000], count[1000];
    const vvi_histogram h = {.n = 1000, .value = value, .count = count, .width = 1e-9};
    for (int i = 0; i < 1000; i++) {
        value[i] = 0.25 * i - 3;
        count[i] = exp(-(i - 200) * (i - 200) / 5000.0) * 1000 + exp(-(i - 700) * (i - 700) / 20000.0) * 300;
    }
    const double t = vvi_li(&h);
    double n[2] = {0}, sum[2] = {0};
    for (int i = 0; i < 1000; i++) {
        n[value[i] > t] += count[i];
        sum[value[i] > t] += count[i] * (value[i] + 3);
    }
    const double back = sum[0] / n[0], fore = sum[1] / n[1];
    assert_true(fabs(t + 3 - (back - fore) / (log(back) - log(fore))) < 1e-9);
    assert_true(t > 50 && t < 172);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(classes_vary_least_within_themselves),
        cmocka_unit_test(li_is_where_its_equation_holds),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
