/* One finger turns; two move, spread and twist the picture together. */
#include "input/method.h"

extern const vvi_method vvi_method_touch;

static int fingers(const vvi_input_state *s, const double *at[2])
{
    int n = 0;
    for (int f = 0; f < VVI_INPUT_FINGERS; f++)
        if (*s->finger[f].id) {
            if (n < 2)
                at[n] = s->finger[f].at;
            n++;
        }
    return n;
}

/* So that what was under each finger stays there: nearer about the middle of both, turned, and moved. */
static vvi_pose pinch(const vvi_method_call *c, const double *a[2], const double *b[2])
{
    const double from[2] = {a[1][0] - a[0][0], a[1][1] - a[0][1]}, to[2] = {b[1][0] - b[0][0], b[1][1] - b[0][1]};
    const double before = hypot(from[0], from[1]), after = hypot(to[0], to[1]);
    const double middle[2] = {(a[0][0] + a[1][0]) / 2, (a[0][1] + a[1][1]) / 2};
    const double moved[2] = {(b[0][0] + b[1][0]) / 2 - middle[0], (b[0][1] + b[1][1]) / 2 - middle[1]};
    vvi_pose p = c->slot->pose;
    if (before > 1e-6 && after > 1e-6) {
        const double angle = atan2(from[0] * to[1] - from[1] * to[0], from[0] * to[0] + from[1] * to[1]);
        const double cosine = cos(angle), sine = sin(angle);
        p = vvi_zoom(&p, log(after / before) / 2, middle);
        p = vvi_roll(&p, angle); /* about the picture's middle; then back to where the fingers are */
        p = vvi_pan(&p, (middle[0] - cosine * middle[0] + sine * middle[1]) / 2,
                    (middle[1] - sine * middle[0] - cosine * middle[1]) / 2);
    }
    return vvi_pan(&p, moved[0] / 2, moved[1] / 2);
}

static vvi_pose touch(const vvi_method_call *c, double value)
{
    const double *was[2], *now[2];
    const int n = fingers(c->was, was);
    (void)value;
    if (fingers(c->now, now) != n || n == 0)
        return c->slot->pose;
    if (n == 1)
        return vvi_orbit(&c->slot->pose, c->gain * (now[0][0] - was[0][0]) / 2, c->gain * (now[0][1] - was[0][1]) / 2,
                         c->slot->up);
    return pinch(c, was, now);
}

const vvi_method vvi_method_touch = {"touch", "one finger rotates; two move, zoom and roll", VVI_METHOD_TOUCHES, touch};
