/* The table of simulation methods. */
#include "input/method.h"

#include <string.h>

static vvi_pose turntable(const vvi_method_call *c, double value)
{
    (void)value;
    return vvi_orbit(&c->slot->pose, c->gain * (c->now->pointer[0] - c->was->pointer[0]) / 2,
                     c->gain * (c->now->pointer[1] - c->was->pointer[1]) / 2, c->slot->up);
}

static vvi_pose arcball(const vvi_method_call *c, double value)
{
    (void)value;
    return vvi_arcball(&c->slot->pose, c->was->pointer, c->now->pointer);
}

static vvi_pose trackball(const vvi_method_call *c, double value)
{
    (void)value;
    return vvi_trackball(&c->slot->pose, c->was->pointer, c->now->pointer);
}

static vvi_pose pan(const vvi_method_call *c, double value)
{
    (void)value;
    return vvi_pan(&c->slot->pose, c->gain * (c->now->pointer[0] - c->was->pointer[0]) / 2,
                   c->gain * (c->now->pointer[1] - c->was->pointer[1]) / 2);
}

static vvi_pose zoom(const vvi_method_call *c, double value)
{
    (void)value;
    return vvi_zoom(&c->slot->pose, c->gain * (c->now->pointer[1] - c->was->pointer[1]) / 2, NULL);
}

/* By the angle that the pointer turns about the middle. */
static vvi_pose roll(const vvi_method_call *c, double value)
{
    const double *a = c->was->pointer, *b = c->now->pointer;
    (void)value;
    return vvi_roll(&c->slot->pose, c->gain * atan2(a[0] * b[1] - a[1] * b[0], a[0] * b[0] + a[1] * b[1]));
}

/* A notch of a wheel, towards the pointer: an eighth of the way. */
static vvi_pose wheel_zoom(const vvi_method_call *c, double value)
{
    return vvi_zoom(&c->slot->pose, c->gain * value * 0.0625, c->now->pointer);
}

/* One press: 5 degrees, a twentieth of the picture, or a tenth nearer. */
enum { STEPS_OF_A_CIRCLE = 72, STEPS_OF_A_PICTURE = 20 };

static vvi_pose step_azimuth(const vvi_method_call *c, double value)
{
    return vvi_orbit(&c->slot->pose, c->gain * value / STEPS_OF_A_CIRCLE, 0, c->slot->up);
}

static vvi_pose step_elevation(const vvi_method_call *c, double value)
{
    return vvi_orbit(&c->slot->pose, 0, c->gain * value * 2 / STEPS_OF_A_CIRCLE, c->slot->up);
}

static vvi_pose step_right(const vvi_method_call *c, double value)
{
    return vvi_pan(&c->slot->pose, c->gain * value / STEPS_OF_A_PICTURE, 0);
}

static vvi_pose step_up(const vvi_method_call *c, double value)
{
    return vvi_pan(&c->slot->pose, 0, c->gain * value / STEPS_OF_A_PICTURE);
}

static vvi_pose step_nearer(const vvi_method_call *c, double value)
{
    return vvi_zoom(&c->slot->pose, c->gain * value * 0.05, NULL);
}

static vvi_pose step_roll(const vvi_method_call *c, double value)
{
    return vvi_roll(&c->slot->pose, c->gain * value * 2 * M_PI / STEPS_OF_A_CIRCLE);
}

static vvi_pose nothing(const vvi_method_call *c, double value)
{
    (void)value;
    return c->slot->pose;
}

extern const vvi_method vvi_method_touch;
static const vvi_method rows[] = {
    {"turntable", "rotate about the World's up axis and the horizon; up stays up", VVI_METHOD_DRAG, turntable},
    {"arcball", "rotate with a trackball that fills the picture (Shoemake 1992)", VVI_METHOD_DRAG, arcball},
    {"trackball", "rotate with a trackball that continues outside the picture (Bell)", VVI_METHOD_DRAG, trackball},
    {"pan", "move parallel to the picture", VVI_METHOD_DRAG, pan},
    {"zoom", "come nearer (up) or go back (down)", VVI_METHOD_DRAG, zoom},
    {"roll", "roll the picture about its middle", VVI_METHOD_DRAG, roll},
    {"wheel-zoom", "zoom to what the pointer is on", VVI_METHOD_AXIS, wheel_zoom},
    {"step-azimuth", "rotate by 5 degrees about the World's up axis", VVI_METHOD_PRESS, step_azimuth},
    {"step-elevation", "rotate by 5 degrees about the horizon", VVI_METHOD_PRESS, step_elevation},
    {"step-right", "move by a twentieth of the picture, across", VVI_METHOD_PRESS, step_right},
    {"step-up", "move by a twentieth of the picture, up", VVI_METHOD_PRESS, step_up},
    {"step-nearer", "a tenth nearer", VVI_METHOD_PRESS, step_nearer},
    {"step-roll", "roll the picture by 5 degrees", VVI_METHOD_PRESS, step_roll},
    {"action", "request an action by its name: fit, undo", VVI_METHOD_PRESS, nothing, true},
    {"click", "the same, with a button that does not move", VVI_METHOD_CLICK, nothing, true},
    {"drag", "the same, for as long as it is held: window", VVI_METHOD_DRAG, nothing, true},
};

const vvi_method *const vvi_methods[] = {&rows[0],  &rows[1],  &rows[2],  &rows[3],  &rows[4],          &rows[5],
                                         &rows[6],  &rows[7],  &rows[8],  &rows[9],  &rows[10],         &rows[11],
                                         &rows[12], &rows[13], &rows[14], &rows[15], &vvi_method_touch, NULL};

const vvi_method *vvi_method_find(const char *name)
{
    for (int i = 0; vvi_methods[i]; i++)
        if (strcmp(vvi_methods[i]->name, name) == 0)
            return vvi_methods[i];
    return NULL;
}
