#include "grid/value_fit.h"
#include <math.h>

#define COARSE 64      /* bins in which peaks are looked for: fine ones are noise */
#define SUNK 0.02      /* of the peak, where the background ends */
#define WIDE_HILL 0.15 /* of the bins, at half its height: what surrounds the object varies itself */
#define WIDE_SUNK 0.1  /* of such a hill: what stands out of it begins on its slope */
#define LATE 0.25      /* of the bins: where a peak has not sunk by then, the object's values lie on its slope */
#define VALLEY 0.25    /* of the peak: what lies deeper, and before a hill, ends the background then */
#define HILL 1.5       /* times its valley */
#define CHANCE 4       /* deviations of a count: less is no hill */
#define NO_VALLEY 0.8  /* of the bins: a peak that sinks no sooner is no background */
#define SURROUNDS 0.75 /* of the border: what the object stands in has so much of it */
#define INSIDE 0.7     /* of the share that other values have of all samples: no more of the border is the object's */
#define PADDING 0.001  /* of the samples */
#define WIDE 16        /* bins: what is narrower may be a mask, and padding beside it the object */

typedef struct coarse {
    double count[COARSE], border[COARSE]; /* of samples: all; those at the border */
    double on_border;                     /* samples, NaN too */
    int n;
    int first, each; /* fine bins: the first one, and how many a bin has */
    double lo, width;
} coarse;

/* Bins from `from` to before `to`. */
typedef struct span {
    int from, to;
} span;

double vvi_bin_width(const vv_statistics *s)
{
    return (s->histogram_hi - s->histogram_lo) / s->n_bins;
}

double vvi_fit_top(const vv_statistics *s)
{
    const double width = vvi_bin_width(s), median = s->percentile[2], top = s->percentile[4];
    if (floor((median - s->histogram_lo) / width) == floor((top - s->histogram_lo) / width))
        return s->histogram_hi;
    return fmin(top + width, s->histogram_hi);
}

/* The bin above the padding: what few samples lie below has a gap above it that is wider than all the rest. */
static int first_bin(const vv_statistics *s)
{
    const int end = (int)fmin(ceil((vvi_fit_top(s) - s->histogram_lo) / vvi_bin_width(s)), s->n_bins);
    int first = 0, last_seen = 0;
    double below = 0;
    for (int b = 0; b < end && below <= PADDING * (double)s->count; b++) {
        if (!s->histogram[b])
            continue;
        if (below > 0 && b - last_seen > end - b && end - b >= WIDE)
            first = b;
        last_seen = b;
        below += (double)s->histogram[b];
    }
    return first;
}

double vvi_fit_bottom(const vv_statistics *s)
{
    return s->histogram_lo + first_bin(s) * vvi_bin_width(s);
}

static void make_coarse(coarse *out, const vv_statistics *s, const vvi_border *border)
{
    const double fine = vvi_bin_width(s);
    const int first = first_bin(s);
    const double lo = s->histogram_lo + first * fine, range = vvi_fit_top(s) - lo;
    const double bins = fmax(floor(range / fine + 0.5), 1);
    const double each = ceil(bins / COARSE); /* whole fine bins: no beat between the two */
    *out = (coarse){.on_border = border ? (double)border->n : 0,
                    .n = (int)ceil(bins / each),
                    .first = first,
                    .each = (int)each,
                    .lo = lo,
                    .width = each * fine};
    for (int b = first; b < s->n_bins; b++) {
        const double at = (b - first) / each;
        const int bin = at < out->n ? (int)at : out->n - 1;
        out->count[bin] += (double)s->histogram[b];
        out->border[bin] += border ? (double)border->count[b] : 0;
    }
}

static int fullest(const double count[COARSE], int n)
{
    int peak = 0;
    for (int b = 1; b < n; b++)
        if (count[b] > count[peak])
            peak = b;
    return peak;
}

/* To where a peak sinks to a share of it, on both sides. */
static span peak_at(const coarse *c, int peak, double sunk)
{
    span at = {peak, peak + 1};
    while (at.from > 0 && c->count[at.from - 1] >= sunk * c->count[peak])
        at.from--;
    while (at.to < c->n && c->count[at.to] >= sunk * c->count[peak])
        at.to++;
    return at;
}

/* Whether the highest peak lies low enough to be taken for the background without a look at the border. */
static bool peaks_low(const coarse *c)
{
    return c->n >= 2 && fullest(c->count, c->n) < (c->n + 1) / 2;
}

static double width_at_half(const coarse *c, int peak)
{
    const span at = peak_at(c, peak, 0.5);
    return (double)(at.to - at.from) / c->n;
}

/* The lowest bin before `end` that has a hill behind it: the object's values begin before the background's have sunk.
 */
static int valley_before(const coarse *c, int peak, int end)
{
    int lowest = peak;
    for (int b = peak + 1; b < end && end > LATE * c->n; b++) {
        if (c->count[b] < c->count[lowest])
            lowest = b;
        else if (c->count[lowest] <= VALLEY * c->count[peak] && c->count[b] >= HILL * c->count[lowest] &&
                 c->count[b] >= c->count[lowest] + CHANCE * sqrt(fmax(c->count[lowest], 1)))
            return lowest;
    }
    return end;
}

/* First bin that is no background; 0 where there is none. */
static int end_of_background(const coarse *c, bool *wide_out)
{
    if (!peaks_low(c))
        return 0;
    const int peak = fullest(c->count, c->n);
    if (c->n < 4) /* a mask: every value is a hill of its own */
        return peak + 1;
    const int sunk = peak_at(c, peak, SUNK).to;
    *wide_out = width_at_half(c, peak) >= WIDE_HILL;
    if (sunk >= NO_VALLEY * c->n)
        return 0;
    return valley_before(c, peak, *wide_out ? peak_at(c, peak, WIDE_SUNK).to : sunk);
}

static double sum(const double count[COARSE], int from, int to)
{
    double all = 0;
    for (int b = from; b < to; b++)
        all += count[b];
    return all;
}

/* Whether an object stands in the values of a peak: then they fill the border, and less of the inside. */
static bool surrounds(const coarse *c, span peak)
{
    const double of_border = sum(c->border, peak.from, peak.to) / fmax(c->on_border, 1);
    const double of_all = sum(c->count, peak.from, peak.to) / sum(c->count, 0, c->n);
    return of_border >= SURROUNDS && 1 - of_border <= INSIDE * (1 - of_all) && of_all < 1;
}

/* The background that the border tells: the highest peak, else the border's own. False where there is none. */
static bool background_at_border(span *out, const coarse *c)
{
    const int candidates[] = {fullest(c->count, c->n), fullest(c->border, c->n)};
    for (int i = 0; i < 2; i++) {
        *out = peak_at(c, candidates[i], SUNK);
        if (width_at_half(c, candidates[i]) < WIDE_HILL && surrounds(c, *out))
            return true;
    }
    return false;
}

/* Otsu: the split whose classes have the largest variance between them. */
static double best_split(const coarse *c)
{
    double total = 0, sum_all = 0, below = 0, sum_below = 0, best = -1;
    int first = 0, last = 0;
    for (int b = 0; b < c->n; b++) {
        total += c->count[b];
        sum_all += b * c->count[b];
    }
    for (int b = 0; b + 1 < c->n; b++) {
        below += c->count[b];
        sum_below += b * c->count[b];
        const double above = total - below;
        if (below == 0 || above == 0)
            continue;
        const double difference = sum_below / below - (sum_all - sum_below) / above;
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

double vvi_quantile_from(const vv_statistics *s, int from, double share, double total)
{
    double below = 0;
    for (int b = from; b < s->n_bins; b++) {
        const double here = (double)s->histogram[b];
        if (here > 0 && below + here >= share * total)
            return s->histogram_lo + (b + (share * total - below) / here) * vvi_bin_width(s);
        below += here;
    }
    return s->histogram_hi;
}

static double edge_of(const vv_statistics *s, int bin)
{
    return fmin(fmax(s->histogram_lo + bin * vvi_bin_width(s), s->min), s->max);
}

static double counted(const vv_statistics *s, span bins)
{
    double all = 0;
    for (int b = bins.from; b < bins.to; b++)
        all += (double)s->histogram[b];
    return all;
}

static void fit_rising(vvi_value_fit *out, const vv_statistics *s, int from)
{
    double above = counted(s, (span){from, s->n_bins});
    out->lo = edge_of(s, from);
    if (above == 0) { /* all in the last bin */
        out->lo = s->min;
        above = (double)s->count;
    }
    out->share = above / (double)s->count;
    out->median = vvi_quantile_from(s, from, 0.5, above);
    out->hi = fmin(vvi_quantile_from(s, above == (double)s->count ? 0 : from, VVI_OBJECT_TOP, above), s->max);
    if (!(out->hi > out->lo))
        out->hi = s->max;
    if (!(out->hi > out->lo)) /* the object is the largest value alone */
        out->lo = out->split < s->max ? out->split : s->min;
}

/* The background lies above. */
static void fit_falling(vvi_value_fit *out, const vv_statistics *s, span object)
{
    const double below = counted(s, object);
    out->falls = true;
    out->share = below / (double)s->count;
    out->hi = edge_of(s, object.to);
    out->median = vvi_quantile_from(s, object.from, 0.5, below);
    out->lo = fmax(vvi_quantile_from(s, object.from, 1 - VVI_OBJECT_TOP, below), s->min);
    if (!(out->hi > out->lo))
        out->lo = s->min;
    if (!(out->hi > out->lo)) /* the object is the smallest value alone */
        out->hi = out->split;
}

void vvi_fit_values(vvi_value_fit *out, const vv_statistics *s, const vvi_border *border)
{
    coarse c;
    span background;
    *out = (vvi_value_fit){.empty = s->count == 0, .constant = s->max <= s->min, .share = 1};
    out->lo = out->hi = out->split = out->median = s->min;
    if (out->empty || out->constant)
        return;
    make_coarse(&c, s, border);
    out->split = fmin(best_split(&c), s->max);
    out->high_peak = c.n >= 2 && !peaks_low(&c);
    int end = end_of_background(&c, &out->wide);
    if (out->high_peak && border && background_at_border(&background, &c)) {
        end = background.to;
        if (sum(c.count, 0, background.from) > sum(c.count, background.to, c.n)) {
            fit_falling(out, s, (span){c.first, c.first + background.from * c.each});
            return;
        }
    }
    fit_rising(out, s, c.first + end * c.each);
}
