#include "render/decorate/layout.h"
#include <math.h>

/* What it costs to change the side, to stand halfway up, and to go all the way. */
#define OTHER_SIDE 0.15
#define HALFWAY 0.4
#define ALL_THE_WAY 0.1
enum { STEPS = 48 };

bool vvi_layout_is_free(const vvi_layout *l, vvi_box b)
{
    if (!(b.x0 >= 0 && b.y0 >= 0 && b.x1 <= l->width && b.y1 <= l->height && b.x1 >= b.x0 && b.y1 >= b.y0))
        return false;
    for (size_t i = 0; i < l->n; i++) {
        const vvi_box *o = &l->box[i];
        if (b.x0 < o->x1 + l->gap && o->x0 < b.x1 + l->gap && b.y0 < o->y1 + l->gap && o->y0 < b.y1 + l->gap)
            return false;
    }
    return true;
}

bool vvi_layout_take(vvi_layout *l, vvi_box b)
{
    if (l->n == VVI_LAYOUT_MOST || !vvi_layout_is_free(l, b))
        return false;
    l->box[l->n++] = b;
    return true;
}

bool vvi_layout_place(vvi_box *out, vvi_layout *l, const vvi_wish *w)
{
    const double down = l->height - 2 * l->margin - w->height, left = l->margin,
                 right = l->width - l->margin - w->width;
    double best = INFINITY;
    if (!(down >= 0 && right >= left))
        return false;
    for (int other = 0; other < 2; other++)
        for (int i = 0; i <= STEPS; i++) {
            const double x = (other != 0) == w->right ? left : right, part = (double)i / STEPS;
            const double y = l->margin + down * (w->bottom ? 1 - part : part);
            const vvi_box b = {x, y, x + w->width, y + w->height};
            double cost = OTHER_SIDE * other + ALL_THE_WAY * part + HALFWAY * fmin(part, 1 - part) * 2;
            if (cost >= best || !vvi_layout_is_free(l, b))
                continue;
            cost += w->cost ? w->cost(w->user, b) : 0;
            if (cost < best) {
                best = cost;
                *out = b;
            }
        }
    return best < INFINITY && vvi_layout_take(l, *out);
}
