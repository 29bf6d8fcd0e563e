#include "gfx/facet.h"
#include <string.h>

/* Each line that cuts a convex polygon adds one corner; rounding may add more. */
enum { CORNERS_MOST = 3 * VVI_GFX_FACET_CORNERS };

static double turn(vvi_gfx_spot a, vvi_gfx_spot b, double x, double y)
{
    return (b.x - a.x) * (y - a.y) - (b.y - a.y) * (x - a.x);
}

static double signed_area(const vvi_gfx_spot *s, size_t n)
{
    double sum = 0;
    for (size_t i = 2; i < n; i++)
        sum += turn(s[0], s[i - 1], s[i].x, s[i].y);
    return sum / 2;
}

double vvi_gfx_facet_area(const vvi_gfx_spot *spot, size_t n)
{
    return fabs(signed_area(spot, n));
}

/* From the three corners that span most: corner 0 and two neighbours. */
static bool set_plane(vvi_gfx_facet *f)
{
    const vvi_gfx_spot *s = f->spot;
    double most = 0;
    for (size_t i = 2; i < f->n; i++) {
        const double area = turn(s[0], s[i - 1], s[i].x, s[i].y);
        const double n1 = s[i - 1].near - s[0].near, n2 = s[i].near - s[0].near;
        if (fabs(area) <= most)
            continue;
        most = fabs(area);
        f->plane[0] = (n1 * (s[i].y - s[0].y) - n2 * (s[i - 1].y - s[0].y)) / area;
        f->plane[1] = ((s[i - 1].x - s[0].x) * n2 - (s[i].x - s[0].x) * n1) / area;
        f->plane[2] = s[0].near - f->plane[0] * s[0].x - f->plane[1] * s[0].y;
    }
    return most > 0;
}

static bool set_box(vvi_gfx_facet *f)
{
    f->low[0] = f->low[1] = INFINITY;
    f->high[0] = f->high[1] = -INFINITY;
    for (size_t i = 0; i < f->n; i++) {
        f->low[0] = fmin(f->low[0], f->spot[i].x), f->high[0] = fmax(f->high[0], f->spot[i].x);
        f->low[1] = fmin(f->low[1], f->spot[i].y), f->high[1] = fmax(f->high[1], f->spot[i].y);
    }
    return vvi_gfx_facet_area(f->spot, f->n) > VVI_GFX_FACET_AREA;
}

bool vvi_gfx_facet_init(vvi_gfx_facet *facet)
{
    return set_box(facet) && set_plane(facet);
}

vvi_gfx_spot vvi_gfx_facet_middle(const vvi_gfx_facet *f)
{
    vvi_gfx_spot sum = {0};
    for (size_t i = 0; i < f->n; i++) {
        sum.x += f->spot[i].x / f->n;
        sum.y += f->spot[i].y / f->n;
        sum.near += f->spot[i].near / f->n;
    }
    return sum;
}

double vvi_gfx_facet_longest(size_t *side_out, const vvi_gfx_facet *f)
{
    double longest = 0;
    *side_out = 0;
    for (size_t i = 0; i < f->n; i++) {
        const vvi_gfx_spot a = f->spot[i], b = f->spot[(i + 1) % f->n];
        const double length = hypot(b.x - a.x, b.y - a.y);
        if (length > longest) {
            longest = length;
            *side_out = i;
        }
    }
    return longest;
}

/* Cutting --------------------------------------------------------------------------------------------------------- */

/* The part of a convex polygon where numbers at its corners, times sign, are not below 0 (Sutherland & Hodgman 1974):
 * CORNERS_MOST corners at most. */
static size_t part(vvi_gfx_spot *out, const vvi_gfx_spot *in, const double *at, size_t n, double sign)
{
    size_t m = 0;
    for (size_t i = 0; i < n && m + 2 <= CORNERS_MOST; i++) {
        const size_t next = i + 1 < n ? i + 1 : 0;
        const double a = sign * at[i], b = sign * at[next];
        if (a >= 0)
            out[m++] = in[i];
        if ((a < 0 && b > 0) || (a > 0 && b < 0))
            out[m++] = vvi_gfx_between(in[i], in[next], a / (a - b));
    }
    return m;
}

size_t vvi_gfx_facet_window(vvi_gfx_spot *spot, size_t n, const double window[4])
{
    vvi_gfx_spot other[CORNERS_MOST];
    double at[CORNERS_MOST];
    for (int side = 0; side < 4 && n >= 3; side++) {
        for (size_t i = 0; i < n; i++)
            at[i] = (side & 1 ? spot[i].y : spot[i].x) - window[side];
        n = part(other, spot, at, n, side < 2 ? 1 : -1);
        memcpy(spot, other, n * sizeof *spot);
    }
    return n;
}

static bool make_part(vvi_gfx_facet *out, const vvi_gfx_facet *f, const double *at, double sign)
{
    vvi_gfx_spot spot[CORNERS_MOST];
    const size_t n = part(spot, f->spot, at, f->n, sign);
    if (n < 3 || n > VVI_GFX_FACET_CORNERS)
        return false;
    *out = *f;
    out->n = (uint16_t)n;
    memcpy(out->spot, spot, n * sizeof *spot);
    return set_box(out);
}

bool vvi_gfx_facet_cut(vvi_gfx_facet *a_out, vvi_gfx_facet *b_out, const vvi_gfx_facet *facet, const double *at)
{
    vvi_gfx_facet a, b;
    if (!make_part(&a, facet, at, 1) || !make_part(&b, facet, at, -1))
        return false;
    *a_out = a;
    *b_out = b;
    return true;
}

bool vvi_gfx_facet_halve(vvi_gfx_facet *a_out, vvi_gfx_facet *b_out, const vvi_gfx_facet *f)
{
    double at[VVI_GFX_FACET_CORNERS], most = -1;
    size_t side, far = 0;
    vvi_gfx_facet_longest(&side, f);
    const vvi_gfx_spot a = f->spot[side], b = f->spot[(side + 1) % f->n], middle = vvi_gfx_between(a, b, 0.5);
    for (size_t i = 0; i < f->n; i++)
        if (fabs(turn(a, b, f->spot[i].x, f->spot[i].y)) > most) {
            most = fabs(turn(a, b, f->spot[i].x, f->spot[i].y));
            far = i;
        }
    for (size_t i = 0; i < f->n; i++)
        at[i] = i == far ? 0 : turn(middle, f->spot[far], f->spot[i].x, f->spot[i].y);
    return vvi_gfx_facet_cut(a_out, b_out, f, at);
}

/* Comparing ------------------------------------------------------------------------------------------------------- */

/* The polygon that two facets share; 0: none. */
static size_t shared(vvi_gfx_spot *out, const vvi_gfx_facet *a, const vvi_gfx_facet *b)
{
    const double sign = signed_area(b->spot, b->n) < 0 ? -1 : 1;
    vvi_gfx_spot other[CORNERS_MOST];
    double at[CORNERS_MOST];
    size_t n = a->n;
    memcpy(out, a->spot, n * sizeof *out);
    for (size_t k = 0; k < b->n && n >= 3; k++) {
        const vvi_gfx_spot from = b->spot[k], to = b->spot[k + 1 < b->n ? k + 1 : 0];
        for (size_t i = 0; i < n; i++)
            at[i] = turn(from, to, out[i].x, out[i].y);
        n = part(other, out, at, n, sign);
        memcpy(out, other, n * sizeof *out);
    }
    return n >= 3 ? n : 0;
}

static double area_where(const vvi_gfx_spot *s, const double *at, size_t n, double sign)
{
    vvi_gfx_spot cut[CORNERS_MOST];
    const size_t m = part(cut, s, at, n, sign);
    return m < 3 ? 0 : vvi_gfx_facet_area(cut, m);
}

bool vvi_gfx_facet_compare(double *before, double *behind, const vvi_gfx_facet *a, const vvi_gfx_facet *b,
                           double tolerance)
{
    vvi_gfx_spot s[CORNERS_MOST];
    double at[CORNERS_MOST];
    if (a->low[0] >= b->high[0] || b->low[0] >= a->high[0] || a->low[1] >= b->high[1] || b->low[1] >= a->high[1])
        return false;
    const size_t n = shared(s, a, b);
    if (!n || vvi_gfx_facet_area(s, n) < VVI_GFX_FACET_AREA)
        return false;
    for (size_t i = 0; i < n; i++)
        at[i] = vvi_gfx_facet_near(a, s[i].x, s[i].y) - vvi_gfx_facet_near(b, s[i].x, s[i].y) - tolerance;
    *before = area_where(s, at, n, 1);
    for (size_t i = 0; i < n; i++)
        at[i] += 2 * tolerance;
    *behind = area_where(s, at, n, -1);
    return true;
}
