/* Area, volume and place of an object in a volume, with their errors. */
#include "measure/sums.h"

#include "core/vec.h"

#include <math.h>
#include <string.h>

#define SHARP_AREA 0.6    /* Marching Cubes, of the area in cells with edges: how much of it their bevels take away */
#define SHARP_VOLUME 0.35 /* the same of the volume, times the side of a mean voxel */
#define EDGES_MOST 12     /* length of edges in voxels, per root of the area: a single body has no more */
#define BAND_CHANCE 0.1   /* of what changes in both surfaces of a band, times their distance in voxels, at most 1 */
#define CENTROID 0.8      /* of half the size, times the share of the volume that its error is */
#define BOX_COUNTED 0.65  /* mean voxels that points and edges stick out between samples */
#define BOX_SHARP 1.2     /* Marching Cubes: the same where a twentieth of the area or more has edges */
#define STEPS 0.75        /* share of crossed edges without a ramp from which on the data are steps */

/*
 * How far counted areas are from the truth, as shares of the true area whose squares add up, from balls, tori,
 * ellipsoids, capsules, cylinders, cones, pyramids and boxes of 2 to 30 voxels, upright and turned
 * (docs/measurement.md). "Small" is 1 / the square root of the area in faces: what lies along edges falls off like it.
 */
typedef struct area_spread {
    double planes; /* of planes of any direction */
    double small;  /* times small */
    double faces;  /* per deviation of outer faces : area from 3 : 2 */
    double uneven; /* per unevenness of the directions: surfaces that do not turn every way */
    double edges;  /* per unevenness times small: these have edges */
    double flat;   /* per share of flat patches along the axes, beyond flat_least of each, which all surfaces have */
    double flat_least;
    double rim; /* per root of the share of flat patches that have none opposite, times small: the rest leans, so that
                   their rims are sharp, as of upright cones */
} area_spread;

static const area_spread lindblad_spread = {0.014, 0.16, 0.22, 0.19, 9.3, 0.32, 0.13, 8.2};
static const area_spread crofton_spread = {0.026, 0.16, 0.35, 0.35, 18.0, 0.46, 0.14, 6.8};

#define ONE_SIDED_LEAST 0.04 /* share of one-sided patches that is chance */
#define RIM_MOST 0.5
#define SHARE_MOST 0.6

void vv_measure_options_init(vv_measure_options *options, size_t size)
{
    const vv_measure_options all = {.size = size, .lo = -INFINITY, .hi = INFINITY, .method = VV_MEASURE_CUBES};
    memcpy(options, &all, size < sizeof all ? size : sizeof all);
}

static bool is_cubic(const vv_affine *m)
{
    const double s = vvi_length(m->axis[0]);
    for (int a = 0; a < 3; a++)
        if (fabs(vvi_length(m->axis[a]) - s) > 1e-5 * s ||
            fabs(vvi_dot(m->axis[a], m->axis[(a + 1) % 3])) > 1e-5 * s * s)
            return false;
    return true;
}

static void widen(vv_bounds *b, const vv_affine *m)
{
    for (int a = 0; a < 3; a++) {
        const vv_vec3 half = vvi_vec(fabs(m->axis[a].x) / 2, fabs(m->axis[a].y) / 2, fabs(m->axis[a].z) / 2);
        b->lo = vvi_sub(b->lo, half);
        b->hi = vvi_add(b->hi, half);
    }
}

/* Face of a mean voxel, to count areas in. */
static double face_of(double voxel)
{
    return cbrt(voxel) * cbrt(voxel);
}

/* Of a voxel across an index axis. */
static double face_across(const vv_affine *m, int axis)
{
    return vvi_length(vvi_cross(m->axis[(axis + 1) % 3], m->axis[(axis + 2) % 3]));
}

static double area_error(const area_spread *s, const uint64_t pattern[VVI_CONFIGURATIONS], const vv_affine *m,
                         double face, const vv_measured *found)
{
    const double small = sqrt(face / found->area), uneven = vvi_area_unevenness(pattern, m);
    double all[3], one_sided[3], flat = 0, leaning = 0;
    vvi_flat_patterns(all, one_sided, pattern);
    for (int a = 0; a < 3; a++) {
        const double share = face_across(m, a) / found->area;
        flat += fmax(all[a] * share - s->flat_least, 0);
        leaning = fmax(leaning, one_sided[a] * share - ONE_SIDED_LEAST);
    }
    const double terms[] = {s->planes,
                            s->small * small,
                            s->faces * (found->raw_faces / found->area - 1.5),
                            s->uneven * uneven,
                            s->edges * uneven * small,
                            s->flat * flat,
                            fmin(s->rim * sqrt(leaning) * small, RIM_MOST)};
    double squares = 0;
    for (size_t i = 0; i < sizeof terms / sizeof *terms; i++)
        squares += terms[i] * terms[i];
    const double share = fmin(sqrt(squares), SHARE_MOST);
    return found->area * share / (1 - share); /* what is counted lacks the share */
}

void vvi_count_areas(vv_measured *out, const uint64_t pattern[VVI_CONFIGURATIONS], const vv_affine *m, double voxel)
{
    double faces[3];
    vvi_raw_faces(faces, pattern);
    out->crofton = vvi_area_crofton(pattern, m);
    out->lindblad = is_cubic(m) ? vvi_area_lindblad(pattern) * face_of(voxel) : NAN;
    for (int a = 0; a < 3; a++)
        out->raw_faces += faces[a] * face_across(m, a);
    out->area = isnan(out->lindblad) ? out->crofton : out->lindblad;
    if (out->area > 0)
        out->area_error =
            area_error(isnan(out->lindblad) ? &crofton_spread : &lindblad_spread, pattern, m, face_of(voxel), out);
}

/* What the region or the border cuts off is what closing adds. The Euler number is that of the closed object: outside
 * begins where it is cut off. */
static vv_status count_other_side(vv_measured *out, const vvi_count_sums *t, const vvi_object *object,
                                  const vvi_region *region, bool closed, const vv_affine *m)
{
    vvi_count_sums other = *t;
    vv_status st = VV_OK;
    if (t->cut && (st = vvi_count_object(&other, object, region, !closed)) != VV_OK)
        return st;
    const uint64_t *cut = closed ? other.cut_faces : t->cut_faces;
    for (int a = 0; a < 3 && t->cut; a++)
        out->cut_area += (double)cut[a] * face_across(m, a);
    out->euler = vvi_euler_number(closed ? t->pattern : other.pattern);
    return VV_OK;
}

/* How far the centroid and the sides of the box may be off: vv_measured says why. off: how far a surface may be; NaN
 * where voxels are counted. sharp: a length. */
static void place_errors(vv_measured *out, const vv_affine *m, double off, double sharp)
{
    const double half[3] = {(out->bounds.hi.x - out->bounds.lo.x) / 2, (out->bounds.hi.y - out->bounds.lo.y) / 2,
                            (out->bounds.hi.z - out->bounds.lo.z) / 2};
    const double step[3] = {fabs(m->axis[0].x) + fabs(m->axis[1].x) + fabs(m->axis[2].x),
                            fabs(m->axis[0].y) + fabs(m->axis[1].y) + fabs(m->axis[2].y),
                            fabs(m->axis[0].z) + fabs(m->axis[1].z) + fabs(m->axis[2].z)};
    double *const centroid[3] = {&out->centroid_error.x, &out->centroid_error.y, &out->centroid_error.z};
    double *const bounds[3] = {&out->bounds_error.x, &out->bounds_error.y, &out->bounds_error.z};
    for (int a = 0; a < 3 && out->volume > 0; a++) {
        *centroid[a] = CENTROID * out->volume_error / out->volume * half[a];
        *bounds[a] = (isnan(off) ? step[a] / 2 : off) + sharp;
    }
}

static vv_status count(vv_measured *out, const vvi_object *object, const vv_measure_options *o)
{
    const vv_grid *grid = &vv_field_get_info(object->field)->grid;
    const vv_affine *m = &grid->index_to_world;
    const double voxel = fabs(vv_affine_determinant(*m));
    vvi_region region;
    vvi_count_sums t;
    vv_status st = vvi_region_init(&region, grid, &o->box, 0.5, o->planes, o->n_planes);
    if (st != VV_OK || (st = vvi_count_object(&t, object, &region, o->closed)) != VV_OK)
        return st;
    out->voxels = t.voxels;
    out->volume = (double)t.voxels * voxel;
    vvi_count_areas(out, t.pattern, m, voxel);
    out->volume_error = vvi_count_spread(t.pattern) * voxel;
    if ((st = count_other_side(out, &t, object, &region, o->closed, m)) != VV_OK || t.voxels == 0)
        return st;
    const double n = (double)t.voxels;
    out->centroid =
        vv_affine_point(*m, vvi_vec((double)t.index[0] / n, (double)t.index[1] / n, (double)t.index[2] / n));
    out->bounds = t.bounds;
    widen(&out->bounds, m);
    place_errors(out, m, NAN, BOX_COUNTED * cbrt(voxel));
    return VV_OK;
}

/* Of one surface; of a band of values, what its lower surface bounds and what its upper one does: what is too thin for
 * any sample lies between them. */
static vv_status look(vvi_cubes_sums t[2], const vvi_object *object, const vvi_region *region, const int64_t inner[3])
{
    const bool band = vvi_object_is_band(object);
    vv_status st = VV_OK;
    t[1] = (vvi_cubes_sums){.bounds = vvi_bounds_none(), .surface = vvi_bounds_none(), .least = NAN, .most = NAN};
    for (int i = 0; i < (band ? 2 : 1) && st == VV_OK; i++) {
        const vvi_object one = band ? vvi_object_upper(object, i == 1) : *object;
        st = vvi_cubes_object(&t[i], &one, region, inner);
    }
    return st;
}

/* Of the edges that a single body has. */
static double sharp_area(const vvi_cubes_sums *t, double voxel)
{
    return fmin(t->sharp_area, EDGES_MOST * sqrt(t->area * face_of(voxel)));
}

/* How far apart the two surfaces of a band are on average, in mean voxels; 1: farther, or there is one surface. */
static double thickness(const vvi_cubes_sums t[2], double voxel)
{
    const double apart = 2 * (t[0].volume - t[1].volume) * cbrt(voxel) * cbrt(voxel) / (t[0].area + t[1].area);
    return t[1].area > 0 ? fmin(fmax(apart, 0), 1) : 1;
}

/* What halving the resolution changes is three times the error of a method of second order, which Marching Cubes is
 * where the surface is smooth, and as much as that of one of first order. Edges are bevelled, by now more, now less,
 * wherever they lie; where there are more of them than one body has, those lie every way, and what is left of chance
 * beside that change is that of one. The two surfaces of a band are off alike as far as they are one beside the other:
 * what is left of a volume's error is what changes between them, and of chance the more the farther they are apart. */
static vv_status cubes_error(vv_measured *out, double *off_out, const vvi_object *object, const vvi_region *region,
                             const vvi_cubes_sums fine[2], const vv_measure_options *o, double voxel)
{
    const double sharp[2] = {sharp_area(&fine[0], voxel), sharp_area(&fine[1], voxel)};
    const double apart = thickness(fine, voxel);
    vvi_object coarse;
    vvi_cubes_sums t[2];
    vv_status st = vvi_object_coarse(&coarse, object, o);
    if (st == VV_OK)
        st = look(t, &coarse, region, coarse.n);
    if (st == VV_OK && coarse.n[0] > 1 && coarse.n[1] > 1 && coarse.n[2] > 1) {
        const double change[2] = {t[0].volume - fine[0].inner_volume, t[1].volume - fine[1].inner_volume};
        const double chance = BAND_CHANCE * hypot(change[0], change[1]) * (fine[1].area > 0 ? apart : 0);
        out->area_error = hypot(fabs(t[0].area - fine[0].inner_area) + fabs(t[1].area - fine[1].inner_area),
                                SHARP_AREA * (sharp[0] + sharp[1]));
        out->volume_error = hypot(hypot(change[0] - change[1], chance) * voxel,
                                  SHARP_VOLUME * hypot(sharp[0], sharp[1]) * apart * cbrt(voxel));
        *off_out = hypot(change[0] * voxel, SHARP_VOLUME * sharp[0] * cbrt(voxel)) / fine[0].area;
    }
    vvi_object_close(&coarse);
    return st;
}

/* Marching Cubes of steps does not converge, so that no other resolution tells its error; counts do. */
static vv_status steps_error(vv_measured *out, const vvi_object *object, const vv_measure_options *o)
{
    vv_measured counted = {.size = sizeof counted};
    vv_measure_options open = *o;
    open.closed = false;
    const vv_status st = count(&counted, object, &open);
    if (st == VV_OK) {
        out->area_error = fabs(out->area - counted.area) + counted.area_error;
        out->volume_error = fabs(out->volume - counted.volume) + counted.volume_error;
    }
    return st;
}

/* The piece of a band around a seed is what samples say: where it is thin, counts tell how little of it they see. */
static vv_status piece_error(vv_measured *out, const vvi_object *object, const vv_measure_options *o)
{
    const double area = out->area_error, volume = out->volume_error;
    const vv_status st = steps_error(out, object, o);
    out->area_error = fmax(out->area_error, area);
    out->volume_error = fmax(out->volume_error, volume);
    return st;
}

/* The band's box is that of what its lower surface bounds, unless what is above it reaches as far: where border or
 * region cut that off. */
static vv_status find_bounds(vv_measured *out, const vvi_cubes_sums t[2], const vvi_object *object,
                             const vvi_region *region, const int64_t inner[3])
{
    out->bounds = t[0].bounds;
    if (!(t[1].cut_area > 0))
        return VV_OK;
    vvi_cubes_sums samples;
    const vv_status st = vvi_cubes_object(&samples, object, region, inner);
    out->bounds = samples.bounds;
    vvi_bounds_join(&out->bounds, &t[0].surface);
    vvi_bounds_join(&out->bounds, &t[1].surface);
    return st;
}

static vv_status join_surfaces(vv_measured *out, const vvi_cubes_sums t[2], const vvi_object *object,
                               const vvi_region *region, const int64_t inner[3])
{
    const vv_affine *m = &vv_field_get_info(object->field)->grid.index_to_world;
    const double volume = fmax(t[0].volume - t[1].volume, 0);
    const double crossed = (double)(t[0].crossed + t[1].crossed), stepped = (double)(t[0].stepped + t[1].stepped);
    out->area = t[0].area + t[1].area;
    out->cut_area = fmax(t[0].cut_area - t[1].cut_area, 0);
    out->volume = volume * fabs(vv_affine_determinant(*m));
    out->unknown = t[0].unknown;
    out->steps = out->area > 0 && ((!t[0].between && !t[1].between) || (crossed > 0 && stepped >= STEPS * crossed));
    if (!(volume > 0))
        return VV_OK;
    out->centroid = vv_affine_point(*m, vvi_vec((t[0].moment[0] - t[1].moment[0]) / volume,
                                                (t[0].moment[1] - t[1].moment[1]) / volume,
                                                (t[0].moment[2] - t[1].moment[2]) / volume));
    return find_bounds(out, t, object, region, inner);
}

static vv_status cubes(vv_measured *out, const vvi_object *object, const vv_measure_options *o)
{
    const vv_grid *grid = &vv_field_get_info(object->field)->grid;
    const vv_affine *m = &grid->index_to_world;
    const double voxel = fabs(vv_affine_determinant(*m));
    double off = NAN;
    int64_t inner[3];
    vvi_region region;
    vvi_cubes_sums t[2];
    vv_status st = vvi_region_init(&region, grid, &o->box, 0, o->planes, o->n_planes);
    for (int a = 0; a < 3; a++) {
        inner[a] = (grid->dims[a] - 1) / 2 * 2;
        if (st == VV_OK && grid->dims[a] < 2)
            st = vv_fail(
                VV_E_ARGUMENT,
                "Marching Cubes needs at least 2 samples along each axis; there is one along %c: count voxels instead",
                "xyz"[a]);
    }
    if (st != VV_OK || (st = look(t, object, &region, inner)) != VV_OK ||
        (st = join_surfaces(out, t, object, &region, inner)) != VV_OK)
        return st;
    out->raw_faces = out->crofton = out->lindblad = NAN;
    out->area_error = out->volume_error = NAN;
    if (o->no_error)
        return VV_OK;
    st = out->steps ? steps_error(out, object, o) : cubes_error(out, &off, object, &region, t, o, voxel);
    if (st == VV_OK && object->section && object->value_lo > -INFINITY && object->value_hi < INFINITY)
        st = piece_error(out, object, o);
    const double sharp = (t[0].sharp_area + t[1].sharp_area) / out->area;
    if (st == VV_OK && out->area > 0)
        place_errors(out, m, off, BOX_SHARP * cbrt(voxel) * (out->steps ? 1 : fmin(20 * sharp, 1)));
    return st;
}

vv_status vv_measure(vv_measured *out, const vv_field *field, const vv_measure_options *options, vv_job *job)
{
    vv_measure_options o;
    vv_measured found = {.size = sizeof found,
                         .centroid = {NAN, NAN, NAN},
                         .bounds = vvi_bounds_none(),
                         .centroid_error = {NAN, NAN, NAN},
                         .bounds_error = {NAN, NAN, NAN}};
    vvi_object object;
    vv_measure_options_init(&o, sizeof o);
    if (options)
        memcpy(&o, options, options->size < sizeof o ? options->size : sizeof o);
    o.method = o.region && o.method == VV_MEASURE_AUTO ? VV_MEASURE_COUNT : vvi_object_method(o.object, o.method);
    if (o.region && o.method == VV_MEASURE_CUBES)
        return vv_fail(VV_E_ARGUMENT,
                       "voxels are counted in a region; Marching Cubes measures in boxes of samples and on "
                       "sides of planes: omit the method, or give --box or --clip");
    vv_status st = vvi_object_open(&object, field, &o, 1, job);
    if (st == VV_OK && o.seeded)
        st = vvi_object_track(&object, o.seed);
    if (st == VV_OK)
        st = o.method == VV_MEASURE_COUNT ? count(&found, &object, &o) : cubes(&found, &object, &o);
    vvi_object_close(&object);
    if (st == VV_OK && (st = vv_field_health(field)) == VV_OK)
        memcpy((char *)out + sizeof out->size, (char *)&found + sizeof out->size,
               (out->size < sizeof found ? out->size : sizeof found) - sizeof out->size);
    return st;
}
