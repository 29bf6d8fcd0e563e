/* Area, volume, box and centroid of the object. */
#include "measuring/measuring.h"
#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

static const char *unit_of(const vvi_measuring *m)
{
    return vv_field_get_info(m->field)->grid.unit;
}

static void put(vvi_measuring *m, const char *key, const char *label, double value, double error, int power)
{
    vvi_figure f = {.key = key, .label = label, .value = value, .error = error};
    if (power)
        vvi_power_unit(f.unit, unit_of(m), power);
    vvi_tell_figure(m->answer, &f);
}

static void put_header(vvi_measuring *m)
{
    const bool cubes = m->choice.method == VV_MEASURE_CUBES;
    vvi_tell_text(m->answer, "unit", unit_of(m));
    vvi_tell_text(m->answer, "method", cubes ? "cubes" : "count");
    vvi_tell_text(m->answer, "object", m->object);
    if (m->choice.object == VV_OBJECT_RANGE) {
        vvi_tell_number(m->answer, "threshold_lo", m->choice.lo);
        vvi_tell_number(m->answer, "threshold_hi", m->choice.hi);
        vvi_tell_bool(m->answer, "automatic", m->automatic);
    }
    vvi_measuring_put_seed(m);
    vvi_tell_line(m->answer, "object", "%s%s", m->object,
                  m->choice.seeded ? "; the piece around the seed: 6-connected inside, 26-connected outside" : "");
    if (vvi_measuring_is_part(m))
        vvi_tell_line(m->answer, "region", "%s", m->region);
    vvi_tell_line(m->answer, "method", "%s",
                  cubes ? "Marching Cubes, values interpolated: n samples are n - 1 steps long"
                        : "voxels counted, without interpolation: n samples are n steps long");
}

/* Along x, y, z, of the line above. */
static void put_errors(vvi_measuring *m, const double error[3])
{
    char value[48], text[3][48];
    for (int a = 0; a < 3; a++)
        vvi_figure_digits(value, text[a], 0, error[a]);
    if (!isnan(error[0]))
        vvi_tell_line(m->answer, "", "\xc2\xb1 %s, %s, %s", text[0], text[1], text[2]);
}

static void put_box(vvi_measuring *m, const double lo[3], const double hi[3], const double error[3])
{
    char from[3][48], to[3][48], digits[48];
    for (int a = 0; a < 3; a++) {
        vvi_figure_digits(from[a], digits, lo[a], error[a]);
        vvi_figure_digits(to[a], digits, hi[a], error[a]);
    }
    vvi_tell_line(m->answer, "box", "%s .. %s, %s .. %s, %s .. %s %s", from[0], to[0], from[1], to[1], from[2], to[2],
                  unit_of(m));
    put_errors(m, error);
}

static void put_size(vvi_measuring *m, const double size[3], const double error[3])
{
    char text[3][48], digits[48];
    for (int a = 0; a < 3; a++)
        vvi_figure_digits(text[a], digits, size[a], error[a]);
    vvi_tell_line(m->answer, "", "%s x %s x %s %s", text[0], text[1], text[2], unit_of(m));
    put_errors(m, error);
}

static void put_place(vvi_measuring *m, const vv_measured *found)
{
    const double centre[3] = {found->centroid.x, found->centroid.y, found->centroid.z};
    const double lo[3] = {found->bounds.lo.x, found->bounds.lo.y, found->bounds.lo.z};
    const double hi[3] = {found->bounds.hi.x, found->bounds.hi.y, found->bounds.hi.z};
    static const char *const keys[] = {"centroid", "box_lo", "box_hi", "box_size"};
    const bool some = !isnan(found->centroid.x);
    const double size[3] = {hi[0] - lo[0], hi[1] - lo[1], hi[2] - lo[2]}, none[3] = {NAN, NAN, NAN};
    const double *const v[4] = {centre, lo, hi, size};
    const double ce[3] = {found->centroid_error.x, found->centroid_error.y, found->centroid_error.z};
    const double be[3] = {found->bounds_error.x, found->bounds_error.y, found->bounds_error.z};
    const double se[3] = {2 * be[0], 2 * be[1], 2 * be[2]}; /* both ends may be off to the same side of the object */
    const double *const error[4] = {ce, be, be, se};
    for (int i = 0; i < 4; i++)
        vvi_tell_place(m->answer, keys[i], some ? v[i] : none, some ? error[i] : none, unit_of(m));
    vvi_tell_numbers(m->answer, "centroid_error", ce, 3);
    vvi_tell_numbers(m->answer, "box_error", be, 3);
    vvi_tell_numbers(m->answer, "box_size_error", se, 3);
    if (!some)
        vvi_tell_line(m->answer, "box", "empty");
    if (!some)
        return;
    char text[VVI_FIGURE_TEXT];
    vvi_place_print(text, centre, ce);
    vvi_tell_line(m->answer, "centroid", "%s %s", text, unit_of(m));
    put_errors(m, ce);
    put_box(m, lo, hi, be);
    put_size(m, size, se);
}

static void put_details(vvi_measuring *m, const vv_measured *found)
{
    put(m, "cut_area", "cut off", found->cut_area, NAN, 2);
    if (m->choice.method == VV_MEASURE_CUBES)
        return;
    put(m, "voxels", "voxels", (double)found->voxels, NAN, 0);
    put(m, "area_lindblad", "by Lindblad", found->lindblad, NAN, 2);
    put(m, "area_crofton", "by Crofton", found->crofton, NAN, 2);
    put(m, "raw_faces", "raw faces", found->raw_faces, NAN, 2);
    put(m, "euler", "Euler number", (double)found->euler, NAN, 0);
}

/* How many voxels make a volume; scenes keep that alone. */
static void put_voxels(vvi_measuring *m, const vv_measured *found)
{
    const vvi_figure f = {.key = "voxels", .label = "voxels", .value = (double)found->voxels, .error = NAN};
    if (m->choice.method == VV_MEASURE_COUNT)
        vvi_tell_figure_for(m->answer, &f, VV_FOR_ALL & ~VV_FOR_SCENES);
}

/* Samples of the whole volume that are no number: no method knows whether they are inside. */
static vv_status count_unknown(uint64_t *out, const vvi_measuring *m)
{
    vv_values_options o;
    vv_values *v = NULL;
    *out = 0;
    if (!vv_type_is_float(vv_field_get_info(m->field)->type))
        return VV_OK;
    vv_values_options_init(&o, sizeof o);
    o.component = m->choice.component;
    o.n_bins = 2;
    const vv_status st = vv_measure_values(&v, m->field, &o, m->job);
    *out = st == VV_OK ? v->nan_count : 0;
    vv_values_free(v);
    return st;
}

static void note_unknown(vvi_measuring *m, const vv_measured *found, uint64_t n)
{
    const bool all = !vvi_measuring_is_part(m);
    char which[64];
    snprintf(which, sizeof which, "sample%s%s %s", n == 1 ? "" : "s", all ? "" : " of the whole volume",
             n == 1 ? "is" : "are");
    if (n == 0)
        return;
    vvi_tell_count(m->answer, "unknown_samples", n);
    if (m->choice.method == VV_MEASURE_COUNT) {
        vvi_tell_note(m->answer, "%" PRIu64 " %s NaN: they are taken to be outside", n, which);
        return;
    }
    vvi_tell_count(m->answer, "unknown_cells", found->unknown);
    vvi_tell_note(m->answer,
                  "%" PRIu64 " %s NaN: of the cells around them %" PRIu64
                  " have a corner inside and are left out, the others are taken to be outside",
                  n, which, found->unknown);
}

static void put_remarks(vvi_measuring *m, const vv_measured *found, bool area, uint64_t n_unknown)
{
    if (isnan(found->centroid.x))
        vvi_measuring_note_empty(m);
    if (found->steps)
        vvi_tell_note(m->answer,
                      "nothing lies between inside and outside: Marching Cubes makes such areas 8 %% too large at "
                      "any resolution, up to 25 %% where voxels are not cubes; --method count does not");
    note_unknown(m, found, n_unknown);
    if (area && found->cut_area > 0 && !m->choice.closed && !vvi_measuring_is_part(m))
        vvi_tell_note(
            m->answer,
            "the object reaches the border of the volume; the faces where it is cut off are not part of its area%s",
            m->choice.object == VV_OBJECT_RANGE ? "" : ": --closed adds them, as where a file was cut to its object");
}

vv_status vvi_measure_object(vvi_measuring *m)
{
    vv_measured found = {.size = sizeof found};
    uint64_t n_unknown = 0;
    vv_status st = vvi_measuring_choose(m);
    if (st != VV_OK || (st = vv_measure(&found, m->field, &m->choice, m->job)) != VV_OK)
        return st;
    if (found.steps && vvi_measuring_count_steps(m) && (st = vv_measure(&found, m->field, &m->choice, m->job)))
        return st;
    if ((st = count_unknown(&n_unknown, m)) != VV_OK)
        return st;
    put_header(m);
    if (m->choice.method == VV_MEASURE_CUBES && m->choice.closed)
        found.area += found.cut_area;
    if (m->what & VVI_AREA)
        put(m, "area", "area", found.area, found.area_error, 2);
    if (m->what & VVI_VOLUME)
        put(m, "volume", "volume", found.volume, found.volume_error, 3);
    if (m->what & VVI_DETAILS)
        put_details(m, &found);
    else if (m->what & VVI_VOLUME)
        put_voxels(m, &found);
    if (m->what & VVI_BOX)
        put_place(m, &found);
    put_remarks(m, &found, m->what & VVI_AREA, n_unknown);
    return VV_OK;
}

vv_status vvi_measure_summary(vvi_measuring *m)
{
    const vv_status st = vvi_measure_statistics(m);
    const int64_t *dims = vv_field_get_info(m->field)->grid.dims;
    const bool thin = dims[0] < 2 || dims[1] < 2 || dims[2] < 2;
    if (st == VV_OK && thin && m->choice.method == VV_MEASURE_CUBES) {
        vvi_tell_note(m->answer,
                      "%s is one sample thick, and Marching Cubes needs two along every axis: area and volume are "
                      "left out; --method count counts voxels",
                      m->input->name);
        return VV_OK;
    }
    return st == VV_OK ? vvi_measure_object(m) : st;
}
