#include "io/cf_axes.h"
#include "core/units.h"
#include "io/placement.h"
#include "io/scan.h"
#include <math.h>
#include <stdio.h>
#include <string.h>

#define EVEN 1e-3 /* of a step */

char vvi_cf_role_named(const char *name)
{
    static const struct {
        const char *name;
        char role;
    } names[] = {{"x", 'x'},
                 {"y", 'y'},
                 {"z", 'z'},
                 {"t", 't'},
                 {"c", 'c'},
                 {"time", 't'},
                 {"frame", 't'},
                 {"frames", 't'},
                 {"channel", 'c'},
                 {"channels", 'c'},
                 {"component", 'c'},
                 {"components", 'c'},
                 {"lon", 'x'},
                 {"longitude", 'x'},
                 {"grid_longitude", 'x'},
                 {"lat", 'y'},
                 {"latitude", 'y'},
                 {"grid_latitude", 'y'},
                 {"lev", 'z'},
                 {"level", 'z'},
                 {"height", 'z'},
                 {"depth", 'z'},
                 {"altitude", 'z'},
                 {"plev", 'z'},
                 {"pressure", 'z'},
                 {"row", 'y'},
                 {"column", 'x'},
                 {"slice", 'z'},
                 {"xspace", 'x'},
                 {"yspace", 'y'},
                 {"zspace", 'z'},
                 {"nx", 'x'},
                 {"ny", 'y'},
                 {"nz", 'z'},
                 {"projection_x_coordinate", 'x'},
                 {"projection_y_coordinate", 'y'}};
    for (size_t i = 0; i < sizeof names / sizeof *names; i++)
        if (strcasecmp(name, names[i].name) == 0)
            return names[i].role;
    return 0;
}

void vvi_cf_axis_unit(char out[16], const char *units)
{
    out[0] = 0;
    if (!units || strcmp(units, "1") == 0)
        return;
    if (strncmp(units, "degree", 6) == 0)
        snprintf(out, 16, "deg");
    else
        vvi_unit_name(out, units, strcspn(units, " "));
}

/* Numbers of one axis --------------------------------------------------------------------------------------------- */

static bool check(vvi_cf_line *c, const double *at, size_t n, double precision)
{
    const double step = n > 1 ? (at[n - 1] - at[0]) / (double)(n - 1) : 1;
    const double near = EVEN * fabs(step) + 2 * precision * fmax(fabs(at[0]), fabs(at[n - 1]));
    c->first = at[0];
    c->last = at[n - 1];
    c->even = true;
    for (size_t i = 0; i < n; i++) {
        if (!isfinite(at[i]) || (i > 0 && !((at[i] - at[i - 1]) * step > 0)))
            return false;
        c->even = c->even && fabs(at[i] - (at[0] + step * (double)i)) <= near;
    }
    return isfinite(step);
}

static vv_status note_range(vv_notes *notes, const vvi_cf_line *c, char role)
{
    char key[32], value[96];
    snprintf(key, sizeof key, "coordinates of %c", role);
    snprintf(value, sizeof value, "%.7g .. %.7g%s%s", c->first, c->last, c->unit[0] ? " " : "", c->unit);
    const vv_status st = vvi_notes_add(notes, key, value);
    if (st != VV_OK || c->even)
        return st;
    return vvi_notes_warn(notes, "its coordinates along %c are uneven (%s); shown as if they were even", role, value);
}

vv_status vvi_cf_take_line(vvi_cf_line *line, const double *at, size_t n, double precision, char role, vv_notes *notes)
{
    line->known = check(line, at, n, precision);
    return line->known ? note_range(notes, line, role)
                       : vvi_notes_warn(notes,
                                        "its coordinates along %c are neither ascending nor descending throughout; "
                                        "they are left out",
                                        role);
}

/* The grid -------------------------------------------------------------------------------------------------------- */

static double step_of(const vvi_cf_line *c, int64_t n)
{
    return n > 1 ? (c->last - c->first) / (double)(n - 1) : 1;
}

void vvi_cf_place_frames(vv_field_info *info, const vvi_cf_line *c)
{
    if (!c->known || info->n_frames < 2)
        return;
    info->frame_step = step_of(c, info->n_frames);
    snprintf(info->frame_unit, sizeof info->frame_unit, "%.15s", c->unit);
}

/* Degrees along one axis and metres along another have no proportion. */
static bool units_differ(const vvi_cf_line c[3], const int64_t dims[3])
{
    const vvi_cf_line *first = NULL;
    for (int a = 0; a < 3; a++) {
        if (dims[a] < 2)
            continue;
        if (first && (strcmp(first->unit, c[a].unit) != 0 || first->known != c[a].known))
            return true;
        first = &c[a];
    }
    return false;
}

vv_status vvi_cf_place(vv_field_info *info, const vvi_cf_line c[3], vv_notes *notes)
{
    vv_affine *a = &info->grid.index_to_world;
    const char *unit = "";
    bool known = false;
    for (int i = 0; i < 3; i++)
        known = known || (c[i].known && info->grid.dims[i] > 1);
    if (!known)
        return VV_OK;
    if (units_differ(c, info->grid.dims))
        return vvi_notes_warn(notes, "its axes have different units (x: %s, y: %s, z: %s); shown in equal steps",
                              c[0].unit[0] ? c[0].unit : "none", c[1].unit[0] ? c[1].unit : "none",
                              c[2].unit[0] ? c[2].unit : "none");
    double shortest = INFINITY;
    for (int i = 0; i < 3; i++)
        if (info->grid.dims[i] > 1) {
            shortest = fmin(shortest, fabs(step_of(&c[i], info->grid.dims[i])));
            unit = c[i].unit;
        }
    double step[3], origin[3];
    for (int i = 0; i < 3; i++) { /* an axis of one sample is as thick as the thinnest */
        step[i] = info->grid.dims[i] > 1 ? step_of(&c[i], info->grid.dims[i]) : shortest;
        origin[i] = c[i].known && strcmp(c[i].unit, unit) == 0 ? c[i].first : 0;
    }
    *a = (vv_affine){{{step[0], 0, 0}, {0, step[1], 0}, {0, 0, step[2]}}, {origin[0], origin[1], origin[2]}};
    snprintf(info->grid.unit, sizeof info->grid.unit, "%.15s", unit[0] ? unit : "units");
    return VV_OK;
}
