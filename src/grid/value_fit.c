#include "grid/value_fit.h"
#include <math.h>

#define COARSE 64        /* bins in which peaks are looked for: fine ones are noise */
#define SUNK 0.02        /* of the peak, where the background ends */
#define NO_VALLEY 0.8    /* of the bins: a peak that sinks no sooner is no background */
#define OBJECT_TOP 0.995 /* share of the object's samples below hi */
#define NEAR_ZERO 0.05   /* of the longer tail: there is the peak of two-sided values */
#define WIDE_PEAK 0.5    /* of the way out: a peak that reaches so far is noise about zero, and its ends no tails */
#define SHORT_TAIL 0.1   /* of the longer one: no shorter is a tail of its own */
#define TAIL_SHARE 0.005 /* of the samples, at either end: what lies further out is no end of a tail */
#define MUCH_LONGER 4    /* than the other tail: zero is not in the middle */
#define LIKE_TAILS 1.6   /* and no longer: they are alike. That of density over noise is longer */
#define OFF_ZERO 0.1     /* of the shorter tail: the middle value of values about zero lies no further off */
#define OFF_QUARTERS 0.2 /* of what lies between the quartiles: how far their middle may lie off zero */

typedef struct coarse {
    double count[COARSE];
    int n;
    double lo, width;
} coarse;

static double bin_width(const vv_statistics *s)
{
    return (s->histogram_hi - s->histogram_lo) / s->n_bins;
}

double vvi_fit_top(const vv_statistics *s)
{
    const double width = bin_width(s), median = s->percentile[2], top = s->percentile[4];
    if (floor((median - s->histogram_lo) / width) == floor((top - s->histogram_lo) / width))
        return s->histogram_hi;
    return fmin(top + width, s->histogram_hi);
}

static void make_coarse(coarse *out, const vv_statistics *s)
{
    const double fine = bin_width(s), range = vvi_fit_top(s) - s->histogram_lo;
    const double bins = fmax(floor(range / fine + 0.5), 1);
    const double each = ceil(bins / COARSE); /* whole fine bins: no beat between the two */
    *out = (coarse){.n = (int)ceil(bins / each), .lo = s->histogram_lo, .width = each * fine};
    for (int b = 0; b < s->n_bins; b++) {
        const double at = b / each;
        out->count[at < out->n ? (int)at : out->n - 1] += (double)s->histogram[b];
    }
}

/* First bin that is no background; 0 where there is none. */
static int end_of_background(const coarse *c)
{
    int peak = 0;
    for (int b = 1; b < c->n; b++)
        if (c->count[b] > c->count[peak])
            peak = b;
    if (c->n < 2 || peak >= (c->n + 1) / 2)
        return 0;
    int end = peak + 1;
    while (end < c->n && c->count[end] >= SUNK * c->count[peak])
        end++;
    return end < NO_VALLEY * c->n || c->n < 4 ? end : 0;
}

/* Otsu: the split whose classes have the largest variance between them. */
static double best_split(const coarse *c)
{
    double total = 0, sum = 0, below = 0, sum_below = 0, best = -1;
    int first = 0, last = 0;
    for (int b = 0; b < c->n; b++) {
        total += c->count[b];
        sum += b * c->count[b];
    }
    for (int b = 0; b + 1 < c->n; b++) {
        below += c->count[b];
        sum_below += b * c->count[b];
        const double above = total - below;
        if (below == 0 || above == 0)
            continue;
        const double difference = sum_below / below - (sum - sum_below) / above;
        const double between = below * above * difference * difference;
        if (between > best * (1 + 1e-12)) {
            best = between;
            first = b;
        }
        if (between >= best * (1 - 1e-12)) /* across empty bins it stays the same: take their middle */
            last = b;
    }
    return c->lo + ((first + last) / 2.0 + 1) * c->width;
}

/* Value below which `share` of the samples from fine bin `from` on lie. */
static double quantile_from(const vv_statistics *s, int from, double share, double total)
{
    double below = 0;
    for (int b = from; b < s->n_bins; b++) {
        const double here = (double)s->histogram[b];
        if (here > 0 && below + here >= share * total)
            return s->histogram_lo + (b + (share * total - below) / here) * bin_width(s);
        below += here;
    }
    return s->histogram_hi;
}

void vvi_fit_values(vvi_value_fit *out, const vv_statistics *s)
{
    coarse c;
    *out = (vvi_value_fit){.empty = s->count == 0, .constant = s->max <= s->min, .share = 1};
    out->lo = out->hi = out->split = out->median = s->min;
    if (out->empty || out->constant)
        return;
    make_coarse(&c, s);
    out->split = fmin(best_split(&c), s->max);
    const int end = end_of_background(&c);
    const int fine_end = (int)llround(end * c.width / bin_width(s));
    double above = 0;
    for (int b = fine_end; b < s->n_bins; b++)
        above += (double)s->histogram[b];
    out->lo = fmax(s->histogram_lo + fine_end * bin_width(s), s->min);
    if (above == 0) { /* all in the last bin */
        out->lo = s->min;
        above = (double)s->count;
    }
    out->share = above / (double)s->count;
    out->median = quantile_from(s, fine_end, 0.5, above);
    out->hi = fmin(quantile_from(s, above == (double)s->count ? 0 : fine_end, OBJECT_TOP, above), s->max);
    if (!(out->hi > out->lo))
        out->hi = s->max;
    if (!(out->hi > out->lo)) /* the object is the largest value alone */
        out->lo = out->split < s->max ? out->split : s->min;
}

static double middle_of(const vv_statistics *s, int bin)
{
    return s->histogram_lo + (bin + 0.5) * bin_width(s);
}

/* The counts of the values by their magnitude; ends are what lies at most that far from zero. */
static void fold(vv_statistics *out, const vv_statistics *s)
{
    const double top = fmax(-s->histogram_lo, s->histogram_hi);
    double below = 0;
    *out = (vv_statistics){.count = s->count, .max = fmax(-s->min, s->max), .histogram_hi = top};
    const size_t most_bins = sizeof out->histogram / sizeof *out->histogram;
    out->n_bins = (int)fmin(ceil(top / bin_width(s)), (double)most_bins);
    for (int b = 0; b < s->n_bins; b++) {
        const int at = (int)(fabs(middle_of(s, b)) / bin_width(out));
        out->histogram[at < out->n_bins ? at : out->n_bins - 1] += s->histogram[b];
    }
    for (int b = 0; b < out->n_bins; b++) {
        const double median = 0.5 * (double)s->count, most = 0.999 * (double)s->count;
        const double to = below + (double)out->histogram[b];
        if (below < median && to >= median)
            out->percentile[2] = middle_of(out, b);
        if (below < most && to >= most)
            out->percentile[4] = middle_of(out, b);
        below = to;
    }
}

/* Whether there are no more values in the outer half of a tail than in the inner one, the peak left out. */
static bool thins_out(const vv_statistics *s, double tail, double sign)
{
    double inner = 0, outer = 0;
    for (int b = 0; b < s->n_bins; b++) {
        const double v = sign * middle_of(s, b) / tail;
        if (v > 2 * NEAR_ZERO && v <= 1)
            *(v > 0.5 ? &outer : &inner) += (double)s->histogram[b];
    }
    return outer <= inner;
}

/* A field that fills its box: seen from zero on, faint values as well. */
static void fit_from_zero(vvi_value_fit *out, const vv_statistics *folded)
{
    const double all = (double)folded->count;
    out->lo = 0;
    out->share = 1;
    out->median = quantile_from(folded, 0, 0.5, all);
    out->hi = fmin(quantile_from(folded, 0, OBJECT_TOP, all), folded->max);
}

/* Zero is the background: the fullest bin lies at it. */
static bool peaks_at_zero(const vv_statistics *s, double longer)
{
    int peak = 0;
    for (int b = 1; b < s->n_bins; b++)
        if (s->histogram[b] > s->histogram[peak])
            peak = b;
    return fabs(middle_of(s, peak)) <= NEAR_ZERO * longer + bin_width(s);
}

typedef enum balance { BALANCE_NONE, BALANCE_MIDDLE, BALANCE_ALIKE } balance;

/* Whether zero is the middle of the values, wherever their fullest bin lies; and whether both sides are alike. */
static balance balance_of(const vv_statistics *s)
{
    const double n = (double)s->count;
    const double below = -quantile_from(s, 0, TAIL_SHARE, n), above = quantile_from(s, 0, 1 - TAIL_SHARE, n);
    const double shorter = fmin(below, above), longer = fmax(below, above);
    if (!(shorter > 0) || longer > MUCH_LONGER * shorter ||
        fabs(quantile_from(s, 0, 0.5, n)) > OFF_ZERO * shorter + bin_width(s))
        return BALANCE_NONE;
    const double quarter = quantile_from(s, 0, 0.25, n), three = quantile_from(s, 0, 0.75, n);
    return longer <= LIKE_TAILS * shorter &&
                   fabs(quarter + three) / 2 <= OFF_QUARTERS * (three - quarter) + bin_width(s)
               ? BALANCE_ALIKE
               : BALANCE_MIDDLE;
}

bool vvi_fit_two_sided(vvi_value_fit *out, const vv_statistics *s)
{
    const double below = -s->percentile[0], above = s->percentile[4], longer = fmax(below, above);
    vv_statistics folded;
    if (!s->count || !(s->max > s->min) || !(below > SHORT_TAIL * longer && above > SHORT_TAIL * longer))
        return false;
    const balance about = balance_of(s);
    const bool thin = thins_out(s, below, -1) && thins_out(s, above, 1);
    if (about != BALANCE_ALIKE && !(thin && (about == BALANCE_MIDDLE || peaks_at_zero(s, longer))))
        return false;
    fold(&folded, s);
    vvi_fit_values(out, &folded);
    if (out->empty || out->constant)
        return false;
    const bool wide = !(out->lo > 0 && out->lo < WIDE_PEAK * out->hi);
    if (wide && about == BALANCE_ALIKE)
        fit_from_zero(out, &folded);
    return !wide || about == BALANCE_ALIKE;
}
