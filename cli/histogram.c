#include "histogram.h"
#include "grid/info_text.h"
#include "terminal.h"
#include "value.h"
#include <math.h>
#include <stdio.h>
#include <unistd.h>

enum { BARS = 16 };

/* Bins of the statistics that a bar stands for: [*first, *end). All bars are of equally many, but the last. */
static void bins_of(int bar, int n_bins, int *first, int *end)
{
    const int each = (n_bins + BARS - 1) / BARS;
    *first = bar * each;
    *end = *first + each < n_bins ? *first + each : n_bins;
}

void cli_histogram_text(vvi_text *out, const vv_statistics *s, bool logarithmic)
{
    const int each = (s->n_bins + BARS - 1) / BARS, n_bars = each ? (s->n_bins + each - 1) / each : 0;
    const int width = cli_terminal_width(STDOUT_FILENO) - 42;
    const double span = s->histogram_hi - s->histogram_lo;
    uint64_t counts[BARS] = {0}, most = 1;
    for (int b = 0; b < n_bars; b++) {
        int first, end;
        bins_of(b, s->n_bins, &first, &end);
        for (int i = first; i < end; i++)
            counts[b] += s->histogram[i];
        most = counts[b] > most ? counts[b] : most;
    }
    vvi_text_printf(out, "histogram     (bars by the %scount)\n", logarithmic ? "logarithm of the " : "");
    for (int b = 0; b < n_bars; b++) {
        int first, end;
        bins_of(b, s->n_bins, &first, &end);
        const double lo = s->histogram_lo + span * first / s->n_bins, hi = s->histogram_lo + span * end / s->n_bins;
        const double share =
            logarithmic ? log1p((double)counts[b]) / log1p((double)most) : (double)counts[b] / (double)most;
        const int length = (int)lround(width * share);
        char from[32], to[32];
        vvi_value_print(from, lo, s->min, s->max);
        vvi_value_print(to, hi, s->min, s->max);
        vvi_text_printf(out, "  %10s .. %-10s %6.2f %% ", from, to, 100.0 * (double)counts[b] / (double)s->count);
        for (int i = 0; i < length; i++)
            vvi_text_add(out, "#");
        vvi_text_add(out, "\n");
    }
}
