#include "scene/proposals.h"
#include <math.h>
#include <string.h>
#include <volvis/render.h>

#define SURFACE_DEPTH 3.0  /* optical depth that closes a surface */
#define SURFACE_SHARE 0.02 /* of the extent, in which it is reached */
#define FOG_DEPTH 0.5      /* through all that stands around */
#define SOFT 0.15          /* of the way to the mean of a class: edges are no steps, which would show every voxel */

static void add_opacity(vvi_proposal *out, double value, double opacity)
{
    const size_t n = out->n_opacity;
    if (n == VVI_PROPOSAL_NODES)
        return;
    out->opacity[n][0] = n ? fmax(value, out->opacity[n - 1][0]) : value;
    out->opacity[n][1] = opacity;
    out->n_opacity++;
}

/* Of a depth that is reached over a distance. */
static double opacity_of(double depth, double distance, double length)
{
    return -expm1(-depth * length / distance);
}

static double value_at(const vvi_value_profile *p, double place)
{
    return p->lo + place * p->width;
}

/* The bins that are looked at, as a profile of their own; false: none. */
static bool window(vvi_value_profile *out, const vvi_proposal_data *d)
{
    const vvi_value_profile *p = d->profile;
    int first = 0, n = 0;
    *out = (vvi_value_profile){.width = p->width};
    for (int b = 0; b < p->n; b++) {
        const double middle = value_at(p, b + 0.5);
        if (middle < d->from || middle > d->to)
            continue;
        first = n ? first : b;
        out->count[n] = p->count[b];
        out->seen[n] = p->seen[b];
        out->slope[n] = p->slope[b];
        n++;
    }
    out->lo = value_at(p, first);
    out->n = n;
    return n > 1 && !d->fit->empty && !d->fit->constant && d->extent > 0;
}

/* Curves over values ---------------------------------------------------------------------------------------------- */

/* Weights of a Gaussian over bins; a value at b is the sum over bins k of w(k - b) y[k]. */
static double smoothed(const double *y, int n, int b, double sigma)
{
    const int radius = (int)ceil(3 * sigma);
    double sum = 0, all = 0;
    for (int k = b - radius; k <= b + radius; k++) {
        const double w = exp(-0.5 * (k - b) * (k - b) / (sigma * sigma));
        if (k < 0 || k >= n)
            continue;
        sum += w * y[k];
        all += w;
    }
    return sum / all;
}

/* Hills and the valleys between them, by rising place: hill i stands between valleys i and i + 1. */
typedef struct ranges {
    int hill[VVI_PROFILE_BINS], valley[VVI_PROFILE_BINS + 1];
    int n;
} ranges;

static void find_hills(ranges *out, const double *y, int n)
{
    int low = 0; /* the lowest since the last hill */
    *out = (ranges){.n = 0};
    for (int b = 0; b < n; b++) {
        low = y[b] < y[low] ? b : low;
        if ((b > 0 && y[b] <= y[b - 1]) || (b + 1 < n && y[b] < y[b + 1]))
            continue;
        out->valley[out->n] = out->n ? low : 0;
        out->hill[out->n++] = b;
        low = b;
    }
    out->valley[out->n] = n;
}

static double prominence(const ranges *r, const double *y, int i)
{
    const double left = i > 0 ? y[r->valley[i]] : -INFINITY;
    const double right = i + 1 < r->n ? y[r->valley[i + 1]] : -INFINITY;
    return y[r->hill[i]] - fmax(left, right);
}

static void join_hill(ranges *r, const double *y, int i)
{
    const bool leftwards = i > 0 && (i + 1 == r->n || y[r->valley[i]] >= y[r->valley[i + 1]]);
    const int valley = leftwards ? i : i + 1;
    memmove(r->hill + i, r->hill + i + 1, (size_t)(r->n - i - 1) * sizeof *r->hill);
    memmove(r->valley + valley, r->valley + valley + 1, (size_t)(r->n - valley) * sizeof *r->valley);
    r->n--;
}

/* What stands out least is joined to its neighbour beyond the higher valley, until there are few and all stand out: by
 * need[] at their places. */
static void join_hills(ranges *r, const double *y, const double *need, int most)
{
    while (r->n > 1) {
        int least = 0;
        double excess = INFINITY;
        for (int i = 0; i < r->n; i++) {
            const double over = prominence(r, y, i) - need[r->hill[i]];
            least = over < excess ? i : least;
            excess = fmin(over, excess);
        }
        if (r->n <= most && excess >= 0)
            return;
        join_hill(r, y, least);
    }
}

/* Boundaries ------------------------------------------------------------------------------------------------------ */

enum { BOUNDARIES_MOST = 4 };
#define STANDS_OUT 0.15   /* of the slope at a boundary, that it is above the valleys beside */
#define FAINT 0.1         /* of the largest slope: no boundary is flatter */
#define SHOULDER 0.606531 /* exp(-1/2): slope at one width from the middle */

typedef struct boundary {
    double lo, middle, hi; /* values */
    double width;          /* world length from the middle to lo or hi */
    bool open;             /* it has no upper side */
} boundary;

/* Mean slope by value; where nothing was seen, linear between what was. */
static void mean_slope(double out[VVI_PROFILE_BINS], const vvi_value_profile *p)
{
    const double sigma = fmax(p->n / 96.0, 0.5);
    int last = -1;
    for (int b = 0; b < p->n; b++) {
        const double seen = smoothed(p->seen, p->n, b, sigma);
        if (!(seen > 1e-3))
            continue;
        out[b] = smoothed(p->slope, p->n, b, sigma) / seen;
        for (int k = last + 1; k < b; k++)
            out[k] = last < 0 ? out[b] : out[last] + (out[b] - out[last]) * (k - last) / (b - last);
        last = b;
    }
    for (int k = last + 1; k < p->n; k++)
        out[k] = last < 0 ? 0 : out[last];
}

/* Where the curve has sunk to a level, from a hill towards its valley; false: it does not. */
static bool sink(double *place_out, const double *y, int hill, int valley, double level)
{
    const int step = valley < hill ? -1 : 1;
    for (int b = hill; b != valley; b += step)
        if (y[b] > level && y[b + step] <= level) {
            *place_out = b + 0.5 + step * (y[b] - level) / (y[b] - y[b + step]);
            return true;
        }
    *place_out = valley + 0.5;
    return false;
}

static bool boundary_at(boundary *out, const vvi_value_profile *p, const double *y, const ranges *r, int i)
{
    const int hill = r->hill[i], end = r->valley[i + 1] < p->n ? r->valley[i + 1] : p->n - 1;
    const double top = y[hill];
    double lo, hi;
    const bool falls_lo = sink(&lo, y, hill, r->valley[i], SHOULDER * top);
    const bool falls_hi = sink(&hi, y, hill, end, SHOULDER * top);
    if (hill == 0)
        return false;
    out->lo = value_at(p, lo);
    out->hi = value_at(p, hi);
    out->middle = value_at(p, falls_lo && falls_hi ? 0.5 * (lo + hi) : hill + 0.5);
    out->open = end == p->n - 1 && !falls_hi;
    /* a boundary of contrast c is c (Phi(x / s) - 1 / 2), of slope c / (s sqrt(2 pi)) in the middle */
    const double contrast = (out->hi - out->lo) / erf(M_SQRT1_2);
    out->width = contrast / (top * sqrt(2 * M_PI));
    return out->width > 0 && isfinite(out->width);
}

static int find_boundaries(boundary out[BOUNDARIES_MOST], const vvi_value_profile *p)
{
    double y[VVI_PROFILE_BINS] = {0}, need[VVI_PROFILE_BINS] = {0}, steepest = 0;
    ranges r;
    int n = 0;
    mean_slope(y, p);
    for (int b = 0; b < p->n; b++) {
        need[b] = STANDS_OUT * y[b];
        steepest = fmax(steepest, y[b]);
    }
    find_hills(&r, y, p->n);
    join_hills(&r, y, need, BOUNDARIES_MOST);
    for (int i = 0; i < r.n && steepest > 0; i++)
        if (y[r.hill[i]] > FAINT * steepest && boundary_at(&out[n], p, y, &r, i))
            n++;
    return n;
}

bool vvi_propose_boundaries(vvi_proposal *out, const vvi_proposal_data *d)
{
    static const double outermost = 0.35, innermost = 2.5; /* optical depths: what is inside is to be seen */
    vvi_value_profile p;
    boundary found[BOUNDARIES_MOST];
    *out = (vvi_proposal){.n_opacity = 0};
    if (!window(&p, d))
        return false;
    const int n = find_boundaries(found, &p);
    for (int i = 0; i < n; i++) {
        const double depth = n > 1 ? outermost * pow(innermost / outermost, (double)i / (n - 1)) : innermost;
        add_opacity(out, found[i].lo, 0);
        add_opacity(out, found[i].middle, opacity_of(depth, found[i].width, d->length));
        if (!found[i].open)
            add_opacity(out, found[i].hi, 0);
    }
    return n > 0;
}

/* Classes --------------------------------------------------------------------------------------------------------- */

typedef struct sums {
    double n[VVI_PROFILE_BINS + 1], v[VVI_PROFILE_BINS + 1]; /* of the bins before each place */
} sums;

static double between(const sums *s, int from, int to)
{
    const double n = s->n[to] - s->n[from], v = s->v[to] - s->v[from];
    return n > 0 ? v * v / n : 0;
}

/* Across empty bins nothing changes: their middle. */
static double middle_of_gap(const double *count, int n, int place)
{
    int end = place;
    while (end < n && count[end] == 0)
        end++;
    return 0.5 * (place + end);
}

bool vvi_otsu_three(double place_out[2], const double *count, int n)
{
    sums s = {.n = {0}};
    double best = -1;
    int at[2] = {0, 0}, filled = 0;
    for (int b = 0; b < n; b++) {
        s.n[b + 1] = s.n[b] + count[b];
        s.v[b + 1] = s.v[b] + count[b] * (b + 0.5);
        filled += count[b] > 0;
    }
    for (int i = 1; i < n; i++)
        for (int k = filled > 2 ? i + 1 : i; k < (filled > 2 ? n : i + 1); k++) {
            const double sum = between(&s, 0, i) + between(&s, i, k) + between(&s, k, n);
            if (sum > best * (1 + 1e-12)) {
                best = sum;
                at[0] = i;
                at[1] = k;
            }
        }
    for (int i = 0; i < 2; i++)
        place_out[i] = middle_of_gap(count, n, at[i]);
    return filled > 1;
}

typedef struct classes {
    double threshold[2], mean[3]; /* values */
    double share[3];              /* of the samples */
} classes;

static bool find_classes(classes *out, const vvi_value_profile *p)
{
    double place[2], n[3] = {0}, sum[3] = {0}, all = 0;
    if (!vvi_otsu_three(place, p->count, p->n))
        return false;
    for (int b = 0; b < p->n; b++) {
        const int i = b + 0.5 < place[0] ? 0 : b + 0.5 < place[1] ? 1 : 2;
        n[i] += p->count[b];
        sum[i] += p->count[b] * (b + 0.5);
        all += p->count[b];
    }
    out->threshold[0] = value_at(p, place[0]);
    out->threshold[1] = value_at(p, place[1]);
    for (int i = 0; i < 3; i++) {
        out->mean[i] = n[i] > 0 ? value_at(p, sum[i] / n[i]) : out->threshold[0];
        out->share[i] = n[i] / all;
    }
    return true;
}

/* From one opacity to another about a threshold. */
static void add_edge(vvi_proposal *out, double threshold, double below, double above, double from, double to)
{
    add_opacity(out, threshold - SOFT * (threshold - below), from);
    add_opacity(out, threshold + SOFT * (above - threshold), to);
}

bool vvi_propose_outside(vvi_proposal *out, const vvi_proposal_data *d)
{
    vvi_value_profile p;
    classes c;
    *out = (vvi_proposal){.n_opacity = 0};
    if (!window(&p, d) || !find_classes(&c, &p))
        return false;
    const double solid = opacity_of(SURFACE_DEPTH, SURFACE_SHARE * d->extent, d->length);
    add_edge(out, c.threshold[0], c.mean[0], c.share[1] > 0 ? c.mean[1] : c.mean[2], 0, solid);
    return true;
}

bool vvi_propose_dense(vvi_proposal *out, const vvi_proposal_data *d)
{
    vvi_value_profile p;
    classes c;
    *out = (vvi_proposal){.n_opacity = 0};
    if (!window(&p, d) || !find_classes(&c, &p))
        return false;
    const double solid = opacity_of(SURFACE_DEPTH, SURFACE_SHARE * d->extent, d->length);
    const double fog = c.share[1] > 0 ? opacity_of(FOG_DEPTH, d->extent * cbrt(c.share[1]), d->length) : 0;
    if (fog > 0)
        add_edge(out, c.threshold[0], c.mean[0], c.mean[1], 0, fog);
    add_edge(out, c.threshold[1], fog > 0 ? c.mean[1] : c.mean[0], c.mean[2], fog, solid);
    return true;
}

/* Hills of the histogram ------------------------------------------------------------------------------------------ */

enum { HILLS_MOST = 6 };

/* Logarithms of smoothed counts: a hill of few samples is one too. A hill stands out by a tenth, and by more than
 * counts differ by chance. */
static void log_counts(double out[VVI_PROFILE_BINS], double need[VVI_PROFILE_BINS], const vvi_value_profile *p)
{
    const double sigma = fmax(p->n / 96.0, 0.5);
    for (int b = 0; b < p->n; b++) {
        const double count = smoothed(p->count, p->n, b, sigma);
        out[b] = log1p(count);
        need[b] = 0.1 + 3 / sqrt(1 + count);
    }
}

/* The last range, where it is the only one that is a band, is parted into three classes. */
static void part_hill(ranges *r, const double *count, int n)
{
    double place[2];
    const int from = r->valley[r->n - 1];
    if (!vvi_otsu_three(place, count + from, n - from))
        return;
    const int first = r->n - 1;
    r->valley[first + 1] = from + (int)place[0];
    r->valley[first + 2] = from + (int)place[1];
    r->valley[first + 3] = n;
    r->n += 2;
}

/* sRGB of Okabe & Ito without black: what is thin and black is not seen. */
static const uint8_t colors[][3] = {{86, 180, 233}, {230, 159, 0}, {0, 158, 115},
                                    {240, 228, 66}, {213, 94, 0},  {204, 121, 167}};

static void add_band(vvi_proposal *out, double lo, double hi, double opacity, size_t color)
{
    double row[4] = {lo + 0.1 * (hi - lo)};
    for (int c = 0; c < 3; c++)
        row[1 + c] = vv_srgb_decode(colors[color % (sizeof colors / sizeof *colors)][c] / 255.0);
    add_opacity(out, lo, 0);
    add_opacity(out, lo + 0.15 * (hi - lo), opacity);
    add_opacity(out, hi - 0.15 * (hi - lo), opacity);
    add_opacity(out, hi, 0);
    memcpy(out->color[out->n_color++], row, sizeof row);
    row[0] = hi - 0.1 * (hi - lo);
    memcpy(out->color[out->n_color++], row, sizeof row);
}

static double samples(const double *count, int from, int to)
{
    double sum = 0;
    for (int b = from; b < to; b++)
        sum += count[b];
    return sum;
}

/* The first hill that is a band. The background is none; of its slope what lies beyond the background's end is, where
 * that is most of what there is. */
static int first_band(ranges *r, const double *count, int end_of_background)
{
    int first = 0;
    while (first + 1 < r->n && r->hill[first] < end_of_background)
        first++;
    const int from = r->valley[first], end = r->valley[r->n];
    if (first > 0 && from > end_of_background && samples(count, end_of_background, from) > samples(count, from, end))
        first--;
    r->valley[first] = end_of_background > r->valley[first] ? end_of_background : r->valley[first];
    return first;
}

bool vvi_propose_bands(vvi_proposal *out, const vvi_proposal_data *d)
{
    static const double thinnest = 1.5, thickest = 25; /* optical depths through a block of what is in a band */
    double y[VVI_PROFILE_BINS] = {0}, need[VVI_PROFILE_BINS] = {0};
    vvi_value_profile p;
    ranges r;
    *out = (vvi_proposal){.n_opacity = 0};
    if (!window(&p, d))
        return false;
    log_counts(y, need, &p);
    find_hills(&r, y, p.n);
    join_hills(&r, y, need, HILLS_MOST);
    const double end = fmin(fmax(ceil((d->fit->lo - p.lo) / p.width), 0), p.n - 1);
    const int first = first_band(&r, p.count, (int)end);
    if (r.n - first == 1)
        part_hill(&r, p.count, p.n);
    const double all = samples(p.count, 0, p.n);
    for (int i = first; i < r.n; i++) {
        const double share = samples(p.count, r.valley[i], r.valley[i + 1]) / all;
        const double rank = r.n - first > 1 ? (double)(i - first) / (r.n - first - 1) : 0.5;
        const double depth = thinnest * pow(thickest / thinnest, rank);
        if (share > 0)
            add_band(out, value_at(&p, r.valley[i]), value_at(&p, r.valley[i + 1]),
                     opacity_of(depth, d->extent * cbrt(share), d->length), (size_t)(i - first));
    }
    return out->n_opacity > 0;
}
