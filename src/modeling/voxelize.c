/* Voxelize: a primitive becomes densities on the grid of a volume, alone or together with the densities that are there
 * (CSG): of Wang & Kaufman 1994. */
#include "core/job.h"
#include "core/vec.h"
#include "grid/making.h"
#include "model/placement.h"
#include "modeling/place.h"
#include "registry.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

enum { ITEM = 4 * VVI_PLACED_BRICK, BRICK_SAMPLES = VVI_PLACED_BRICK * VVI_PLACED_BRICK * VVI_PLACED_BRICK };

typedef struct voxelize_params {
    vv_object object;
    int shape;
    double radius, top, tube, height, rounding;
    vv_vec3 size, center, rotation;
    int with, set, profile;
    double width;
} voxelize_params;

enum {
    ROW_SHAPE,
    ROW_RADIUS,
    ROW_TOP,
    ROW_TUBE,
    ROW_HEIGHT,
    ROW_SIZE,
    ROW_ROUNDING,
    ROW_CENTER,
    ROW_ROTATION,
    ROW_WITH,
    ROW_SET,
    ROW_PROFILE,
    ROW_WIDTH
};
enum { ALONE, UNION, INTERSECTION, DIFFERENCE, XOR };
enum { EXTREMES, PRODUCTS };

static const char *const shape_names[] = {"sphere", "ellipsoid", "box", "cylinder", "cone", "capsule", "torus", NULL};
static const char *const with_names[] = {"alone", "union", "intersection", "difference", "xor", NULL};
static const char *const set_names[] = {"extremes", "products", NULL};
static const char *const profile_names[] = {"linear", "hypercone", "gaussian", "smoothstep", NULL};

#define MOST 1e12
#define LENGTH(field_name, least_length)                                                                               \
    VV_PROP(voxelize_params, field_name), .kind = VV_KIND_F64, .quantity = VV_Q_LENGTH, .limited = true,               \
                                          .min = (least_length), .max = MOST

static const vv_property properties[] = {
    [ROW_SHAPE] = {VV_PROP(voxelize_params, shape), .kind = VV_KIND_ENUM, .names = shape_names,
                   .doc = "what is drawn; its axis is z, before it is turned"},
    [ROW_RADIUS] = {LENGTH(radius, 0), .automatic = "a quarter of the volume's shortest side",
                    .when = "shape=sphere|cylinder|cone|capsule|torus",
                    .doc = "of a cone that of its lower end, of a torus that of the circle in its middle"},
    [ROW_TOP] = {LENGTH(top, 0), .def = 0, .when = "shape=cone", .doc = "radius of the upper end; 0: a point"},
    [ROW_TUBE] = {LENGTH(tube, 0), .automatic = "a third of the radius", .when = "shape=torus",
                  .doc = "radius of what the ring is bent from"},
    [ROW_HEIGHT] = {LENGTH(height, 0), .automatic = "twice the radius", .when = "shape=cylinder|cone|capsule",
                    .doc = "along its axis; of a capsule between the middles of its round ends"},
    [ROW_SIZE] = {VV_PROP(voxelize_params, size), .kind = VV_KIND_VEC3, .quantity = VV_Q_LENGTH, .limited = true,
                  .min = 0, .max = MOST, .automatic = "half of the volume's sides", .when = "shape=ellipsoid|box",
                  .doc = "from end to end along x, y and z, before it is turned"},
    [ROW_ROUNDING] = {LENGTH(rounding, 0), .def = 0, .when = "shape=box", .doc = "radius of its edges and corners"},
    [ROW_CENTER] = {VV_PROP(voxelize_params, center), .kind = VV_KIND_VEC3, .quantity = VV_Q_LENGTH,
                    .automatic = "the middle of the volume", .doc = "where its middle is in the world"},
    [ROW_ROTATION] = {VV_PROP(voxelize_params, rotation), .kind = VV_KIND_VEC3, .quantity = VV_Q_ANGLE,
                      .def_text = "[0, 0, 0]", .doc = "about x, then y, then z"},
    [ROW_WITH] = {VV_PROP(voxelize_params, with), .kind = VV_KIND_ENUM, .names = with_names,
                  .doc = "alone: of the volume only its grid is taken; the others put its values, as densities from 0 "
                         "to 1, together with the shape; difference: the shape is cut out"},
    [ROW_SET] = {VV_PROP(voxelize_params, set), .kind = VV_KIND_ENUM, .names = set_names,
                 .when = "with=union|intersection|difference|xor",
                 .doc = "extremes: the larger or smaller density; products: as chances are multiplied, which leaves no "
                        "skin where surfaces coincide"},
    [ROW_PROFILE] = {VV_PROP(voxelize_params, profile), .kind = VV_KIND_ENUM, .names = profile_names,
                     .doc = "how density falls through the surface; hypercone: as in the paper of 1994; gaussian: its "
                            "width is three standard deviations"},
    [ROW_WIDTH] = {LENGTH(width, 0), .automatic = "2.449 voxels where linear, 3 elsewhere",
                   .doc = "from the surface, where density is 0.5, to where it is 0 or 1"},
    {0},
};

static const vv_class voxelize_class = {
    .name = "voxelize",
    .doc = "parameters of voxelize",
    .size = sizeof(voxelize_params),
    .properties = properties,
};

/* What parameters mean on a grid -------------------------------------------------------------------------------- */

typedef struct solid {
    vvi_placed placed; /* its profile is that below, once it is where it stays */
    vvi_profile profile;
    double voxel; /* the longest side of one */
} solid;

static bool is_set(const voxelize_params *p, int row)
{
    return p->object.set >> row & 1;
}

static void find_lengths(vvi_lengths *out, const voxelize_params *p, const double sides[3])
{
    const double shortest = fmin(sides[0], fmin(sides[1], sides[2]));
    out->radius = is_set(p, ROW_RADIUS) ? p->radius : shortest / 4;
    out->top = p->top;
    out->tube = is_set(p, ROW_TUBE) ? p->tube : out->radius / 3;
    out->height = is_set(p, ROW_HEIGHT) ? p->height : 2 * out->radius;
    out->rounding = p->rounding;
    for (int a = 0; a < 3; a++)
        out->size[a] = sides[a] / 2;
    if (is_set(p, ROW_SIZE))
        out->size[0] = p->size.x, out->size[1] = p->size.y, out->size[2] = p->size.z;
}

static vv_vec3 middle_of(const vv_grid *grid)
{
    return vv_affine_point(
        grid->index_to_world,
        vvi_vec((double)(grid->dims[0] - 1) / 2, (double)(grid->dims[1] - 1) / 2, (double)(grid->dims[2] - 1) / 2));
}

/* From the world to where the shape is not turned and in the middle. */
static vv_affine to_own(const voxelize_params *p, const vv_grid *grid)
{
    const vv_placement frame = {
        .position = is_set(p, ROW_CENTER) ? p->center : middle_of(grid), .rotation = p->rotation, .scale = {1, 1, 1}};
    vv_affine own = vv_affine_identity();
    vv_affine_invert(&own, vvi_placement_matrix(&frame));
    return vv_affine_compose(own, grid->index_to_world);
}

static vv_status find_solid(solid *out, const vv_field_info *info, const vv_object *params)
{
    const voxelize_params *p = (const voxelize_params *)params;
    const vv_affine *map = &info->grid.index_to_world;
    double sides[3], voxel = 0;
    for (int a = 0; a < 3; a++) {
        sides[a] = vvi_length(map->axis[a]) * (double)info->grid.dims[a];
        voxel = fmax(voxel, vvi_length(map->axis[a]));
    }
    const double width = is_set(p, ROW_WIDTH) ? p->width : vvi_profile_voxels((vvi_profile_kind)p->profile) * voxel;
    out->voxel = voxel;
    out->placed = (vvi_placed){.primitive = &vvi_primitives[p->shape], .to_own = to_own(p, &info->grid)};
    find_lengths(&out->placed.lengths, p, sides);
    if (!(width > 0))
        return vv_fail(VV_E_ARGUMENT, "voxelize: width is %g, and must be above 0", width);
    vvi_profile_init(&out->profile, (vvi_profile_kind)p->profile, width);
    return vvi_primitive_check(out->placed.primitive, &out->placed.lengths, "voxelize");
}

static vv_status plan(vv_field_info *out, const vv_field_info *inputs, size_t n_inputs, const vv_object *params)
{
    const voxelize_params *p = (const voxelize_params *)params;
    solid found;
    *out = vv_field_info_default();
    out->grid = inputs[0].grid;
    out->n_frames = inputs[0].n_frames;
    out->frame = inputs[0].frame;
    out->frame_step = inputs[0].frame_step;
    memcpy(out->frame_unit, inputs[0].frame_unit, sizeof out->frame_unit);
    out->type = VV_TYPE_F32;
    snprintf(out->name, sizeof out->name, "density");
    if (p->with != ALONE && (inputs[0].components != 1 || inputs[0].meaning == VV_MEANING_LABEL))
        return vv_fail(VV_E_UNSUPPORTED,
                       "voxelize: --with %s takes densities from 0 to 1, one at each sample; these are %s",
                       with_names[p->with], inputs[0].components != 1 ? "several" : "labels");
    return find_solid(&found, &inputs[0], params);
}

/* Two densities -------------------------------------------------------------------------------------------------- */

static void clamp_densities(float *a, int64_t n)
{
    for (int64_t i = 0; i < n; i++)
        a[i] = a[i] > 0 ? a[i] < 1 ? a[i] : 1 : 0; /* NaN too is 0 */
}

static void join_extremes(float *a, const float *b, int64_t n, int with)
{
    for (int64_t i = 0; i < n; i++) {
        const float not_a = 1 - a[i], not_b = 1 - b[i];
        const float less_b = a[i] < not_b ? a[i] : not_b, less_a = not_a < b[i] ? not_a : b[i];
        if (with == UNION)
            a[i] = a[i] > b[i] ? a[i] : b[i];
        else if (with == INTERSECTION)
            a[i] = a[i] < b[i] ? a[i] : b[i];
        else
            a[i] = with == DIFFERENCE || less_b > less_a ? less_b : less_a;
    }
}

static void join_products(float *a, const float *b, int64_t n, int with)
{
    for (int64_t i = 0; i < n; i++) {
        const float both = a[i] * b[i];
        if (with == UNION)
            a[i] = a[i] + b[i] - both;
        else if (with == INTERSECTION)
            a[i] = both;
        else
            a[i] = with == DIFFERENCE ? a[i] - both : a[i] + b[i] - 2 * both;
    }
}

/* Samples -------------------------------------------------------------------------------------------------------- */

typedef struct shared {
    vvi_making making;
    solid solid;
    int with, set;
    const vv_field_info *info;
} shared;

static void read_row(float *out, const shared *s, const vv_brick *in, int64_t j, int64_t k, int64_t n)
{
    double stored[VVI_PLACED_BRICK];
    const char *row = (const char *)in->data + j * in->stride[1] + k * in->stride[2];
    vvi_samples_to_f64(stored, row, s->info->type, (size_t)n);
    for (int64_t i = 0; i < n; i++)
        out[i] = (float)(stored[i] * s->info->value_scale + s->info->value_offset);
    clamp_densities(out, n);
}

static void make_brick(const shared *s, const vv_box *box)
{
    float densities[BRICK_SAMPLES], there[VVI_PLACED_BRICK];
    const int64_t n = box->n[0];
    vv_brick in = {0};
    if (s->with != ALONE)
        in = vvi_brick_part(&s->making.brick, box);
    vvi_placed_densities(densities, &s->solid.placed, box);
    for (int64_t k = 0; k < box->n[2]; k++)
        for (int64_t j = 0; j < box->n[1]; j++) {
            float *row = densities + (k * box->n[1] + j) * n;
            if (s->with != ALONE) {
                read_row(there, s, &in, j, k, n);
                (s->set == PRODUCTS ? join_products : join_extremes)(there, row, n, s->with);
                memcpy(row, there, (size_t)n * sizeof *row);
            }
            memcpy(s->making.out + (size_t)vvi_slabs_row(&s->making.slabs, box, j, k) * sizeof *row, row,
                   (size_t)n * sizeof *row);
        }
}

static vv_status item(void *scratch, void *user, size_t index)
{
    const shared *s = user;
    const vv_box all = vvi_slabs_item(&s->making.slabs, index);
    int64_t at[3];
    for (at[2] = 0; at[2] < all.n[2]; at[2] += VVI_PLACED_BRICK)
        for (at[1] = 0; at[1] < all.n[1]; at[1] += VVI_PLACED_BRICK)
            for (at[0] = 0; at[0] < all.n[0]; at[0] += VVI_PLACED_BRICK) {
                vv_box box;
                for (int a = 0; a < 3; a++) {
                    box.lo[a] = all.lo[a] + at[a];
                    box.n[a] = all.n[a] - at[a] < VVI_PLACED_BRICK ? all.n[a] - at[a] : VVI_PLACED_BRICK;
                }
                make_brick(s, &box);
            }
    return VV_OK;
}

static vvi_slabs cubes_of(const vv_box *box)
{
    vvi_slabs slabs = {.box = *box, .n = 1};
    for (int a = 0; a < 3; a++) {
        slabs.step[a] = ITEM;
        slabs.items[a] = (box->n[a] + ITEM - 1) / ITEM;
        slabs.n *= (size_t)slabs.items[a];
    }
    return slabs;
}

static void warn(const solid *s, vv_job *job)
{
    const double thick = s->placed.primitive->thickness(&s->placed.lengths);
    if (thick < 2 * s->voxel)
        vvi_job_warn(job, "voxelize",
                     "the %s is %.3g voxels thick where it is thinnest: below 2 its surface is not met",
                     s->placed.primitive->name, thick / s->voxel);
}

static vv_status run_box(vv_field **out, const vv_field *const *inputs, size_t n_inputs, const vv_object *params,
                         const vv_box *box, vv_job *job)
{
    static const vvi_work work = {.stage = "voxelize", .item = item};
    static const vv_box little = {{0, 0, 0}, {1, 1, 1}};
    const voxelize_params *p = (const voxelize_params *)params;
    const vv_field_info *info = vv_field_get_info(inputs[0]);
    shared s = {.making = {.in = inputs[0], .slabs = cubes_of(box)}, .with = p->with, .set = p->set, .info = info};
    vv_field_info made;
    *out = NULL;
    vv_status st = plan(&made, info, n_inputs, params);
    if (st == VV_OK && (st = find_solid(&s.solid, info, params)) == VV_OK) {
        s.solid.placed.profile = &s.solid.profile;
        warn(&s.solid, job);
        st = vvi_making_run(out, &s.making, &made, box, p->with == ALONE ? &little : box, &work, &s, job);
    }
    return st;
}

const vv_operation vvi_operation_voxelize = {
    .api = VV_OPERATION_API,
    .name = "voxelize",
    .component = "modeling",
    .group = "modeling",
    .doc = "draw a solid on the grid of a volume, with smooth densities, or put it together with the solids there",
    .example = "volvis voxelize head.nrrd -o ball.nrrd --shape sphere --radius 20mm",
    .params = &voxelize_class,
    .inputs = VV_ONE_VOLUME,
    .run_box = run_box,
    .plan = plan,
};
