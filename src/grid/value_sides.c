#include "grid/value_sides.h"
#include <math.h>

#define NEAR_ZERO 0.05     /* of the longer tail: there is the peak of two-sided values */
#define WIDE_PEAK 0.5      /* of the way out: a peak that reaches so far is noise about zero, and its ends no tails */
#define SHORT_TAIL 0.1     /* of the longer one: no shorter is a tail of its own */
#define TAIL_SHARE 0.005   /* of the samples, at either end: what lies further out is no end of a tail */
#define MUCH_LONGER 4      /* than the other tail: zero is not in the middle */
#define LIKE_TAILS 1.6     /* and no longer: they are alike. That of density over noise is longer */
#define OFF_ZERO 0.1       /* of the shorter tail: the middle value of values about zero lies no further off */
#define OFF_QUARTERS 0.2   /* of what lies between the quartiles: how far their middle may lie off zero */
#define MOSTLY_ZERO 0.5    /* of the samples: what is left are the tails */
#define CUT_SEEN 0.5       /* of the way from a cut to the end: what just passed is seen as well */
#define CUT_AT 0.2         /* of the way out: a tail that begins no sooner was cut off, whatever its shape */
#define FEW_ON_A_SIDE 0.01 /* of what is left: chance */

static double middle_of(const vv_statistics *s, int bin)
{
    return s->histogram_lo + (bin + 0.5) * vvi_bin_width(s);
}

/* The counts of the values by their magnitude; ends are what lies at most that far from zero. */
static void fold(vv_statistics *out, const vv_statistics *s)
{
    const double top = fmax(-s->histogram_lo, s->histogram_hi);
    double below = 0;
    *out = (vv_statistics){.count = s->count, .max = fmax(-s->min, s->max), .histogram_hi = top};
    const size_t most_bins = sizeof out->histogram / sizeof *out->histogram;
    out->n_bins = (int)fmin(ceil(top / vvi_bin_width(s)), (double)most_bins);
    for (int b = 0; b < s->n_bins; b++) {
        const int at = (int)(fabs(middle_of(s, b)) / vvi_bin_width(out));
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

/* Whether there are no more values in the outer half of a tail, from `middle` on, than in the inner one. */
static bool thins_out(const vv_statistics *s, double from, double middle, double to, double sign)
{
    double inner = 0, outer = 0;
    for (int b = 0; b < s->n_bins; b++) {
        const double v = sign * middle_of(s, b);
        if (v > from && v <= to)
            *(v > middle ? &outer : &inner) += (double)s->histogram[b];
    }
    return outer <= inner;
}

/* A field that fills its box: seen from zero on, faint values as well. */
static void fit_from_zero(vvi_value_fit *out, const vv_statistics *folded)
{
    const double all = (double)folded->count;
    out->lo = 0;
    out->share = 1;
    out->median = vvi_quantile_from(folded, 0, 0.5, all);
    out->hi = fmin(vvi_quantile_from(folded, 0, VVI_OBJECT_TOP, all), folded->max);
}

/* Zero is the background: the fullest bin lies at it. */
static bool peaks_at_zero(const vv_statistics *s, double longer)
{
    int peak = 0;
    for (int b = 1; b < s->n_bins; b++)
        if (s->histogram[b] > s->histogram[peak])
            peak = b;
    return fabs(middle_of(s, peak)) <= NEAR_ZERO * longer + vvi_bin_width(s);
}

typedef enum balance { BALANCE_NONE, BALANCE_MIDDLE, BALANCE_ALIKE } balance;

/* Whether zero is the middle of the values, wherever their fullest bin lies; and whether both sides are alike. */
static balance balance_of(const vv_statistics *s)
{
    const double n = (double)s->count;
    const double below = -vvi_quantile_from(s, 0, TAIL_SHARE, n), above = vvi_quantile_from(s, 0, 1 - TAIL_SHARE, n);
    const double shorter = fmin(below, above), longer = fmax(below, above);
    if (!(shorter > 0) || longer > MUCH_LONGER * shorter ||
        fabs(vvi_quantile_from(s, 0, 0.5, n)) > OFF_ZERO * shorter + vvi_bin_width(s))
        return BALANCE_NONE;
    const double quarter = vvi_quantile_from(s, 0, 0.25, n), three = vvi_quantile_from(s, 0, 0.75, n);
    return longer <= LIKE_TAILS * shorter &&
                   fabs(quarter + three) / 2 <= OFF_QUARTERS * (three - quarter) + vvi_bin_width(s)
               ? BALANCE_ALIKE
               : BALANCE_MIDDLE;
}

/* Bins beyond zero's own, to one side of it: where their values begin and end, and how many there are. */
typedef struct tail {
    double from, to, n;
} tail;

static tail tail_of(const vv_statistics *s, double sign)
{
    const double width = vvi_bin_width(s);
    const int zero = (int)floor(-s->histogram_lo / width), step = sign > 0 ? 1 : -1;
    tail out = {0};
    double so_far = 0;
    for (int b = zero + step; b >= 0 && b < s->n_bins; b += step)
        out.n += (double)s->histogram[b];
    for (int b = zero + step; b >= 0 && b < s->n_bins && so_far < (1 - TAIL_SHARE) * out.n; b += step) {
        if (so_far == 0 && s->histogram[b])
            out.from = fabs(middle_of(s, b)) - width / 2;
        so_far += (double)s->histogram[b];
        out.to = fabs(middle_of(s, b)) + width / 2;
    }
    return out;
}

/* What begins far from zero was cut there, else few lie far out. */
static bool is_tail(const vv_statistics *s, const tail *t, double sign)
{
    return t->from > CUT_AT * t->to || thins_out(s, t->from, (t->from + t->to) / 2, t->to, sign);
}

/* All but zero are the tails, wherever they begin. */
static bool stands_out_of_zero(const vv_statistics *s)
{
    const double zero = floor(-s->histogram_lo / vvi_bin_width(s));
    if (!(zero >= 0 && zero < s->n_bins) || (double)s->histogram[(int)zero] < MOSTLY_ZERO * (double)s->count)
        return false;
    const tail below = tail_of(s, -1), above = tail_of(s, 1);
    const double few = FEW_ON_A_SIDE * (below.n + above.n);
    return below.n > few && above.n > few && fmin(below.to, above.to) > SHORT_TAIL * fmax(below.to, above.to) &&
           is_tail(s, &below, -1) && is_tail(s, &above, 1);
}

/* Nothing above zero, which is where most of it is. */
static bool lower_half(const vv_statistics *s)
{
    return s->max <= 0 && peaks_at_zero(s, -s->percentile[0]);
}

bool vvi_fit_magnitudes(vvi_value_fit *out, const vv_statistics *s, double most)
{
    vv_statistics folded;
    if (!s->count || !(s->max > s->min))
        return false;
    fold(&folded, s);
    vvi_fit_values(out, &folded, NULL);
    if (out->empty || out->constant)
        return false;
    if (!(out->lo > 0 && out->lo < WIDE_PEAK * (most > 0 ? most : out->hi)))
        fit_from_zero(out, &folded);
    out->hi = most > 0 ? most : out->hi;
    return true;
}

/* Tails that were cut far from zero begin a little before: opacity that rose from zero on would be whole at the cut,
 * and hide with its pale colours what the map was cut for. */
static void fit_from_cut(vvi_value_fit *out, const vv_statistics *s)
{
    const tail below = tail_of(s, -1), above = tail_of(s, 1);
    const double cut = fmin(below.from, above.from), from = cut - CUT_SEEN * (out->hi - cut);
    if (below.from > CUT_AT * below.to && above.from > CUT_AT * above.to && from > out->lo && from < out->median)
        out->lo = from;
}

/* Tails on both sides, and zero in their middle or their background. */
static bool has_two_tails(const vv_statistics *s, balance about)
{
    const double below = -s->percentile[0], above = s->percentile[4], longer = fmax(below, above);
    const double near = 2 * NEAR_ZERO;
    if (!(below > SHORT_TAIL * longer && above > SHORT_TAIL * longer))
        return false;
    const bool thin =
        thins_out(s, near * below, below / 2, below, -1) && thins_out(s, near * above, above / 2, above, 1);
    return about == BALANCE_ALIKE || (thin && (about == BALANCE_MIDDLE || peaks_at_zero(s, longer)));
}

bool vvi_fit_two_sided(vvi_value_fit *out, const vv_statistics *s)
{
    if (!s->count || !(s->max > s->min) || !(s->min < 0))
        return false;
    const balance about = balance_of(s);
    if (stands_out_of_zero(s)) {
        const bool fitted = vvi_fit_magnitudes(out, s, 0);
        if (fitted)
            fit_from_cut(out, s);
        return fitted;
    }
    if (lower_half(s) || (about == BALANCE_ALIKE && has_two_tails(s, about)))
        return vvi_fit_magnitudes(out, s, 0);
    vv_statistics folded;
    if (!has_two_tails(s, about))
        return false;
    fold(&folded, s);
    vvi_fit_values(out, &folded, NULL);
    return !out->empty && !out->constant && !out->wide && out->lo > 0 && out->lo < WIDE_PEAK * out->hi;
}
