/* The texture of a volume: its image, its colours, and where it stands. */
#include "core/job.h"
#include "model/placement.h"
#include "scene/resolve.h"
#include <math.h>
#include <stdio.h>
#include <string.h>

/* What a pattern has where nobody says: sRGB colours, and how often it comes along the longest side. */
typedef struct pattern_row {
    double color[2][3];
    double along;
} pattern_row;
static const pattern_row by_kind[] = {
    [VV_TEXTURE_IMAGE] = {.along = 1},
    [VV_TEXTURE_CHECKER] = {{{0.95, 0.95, 0.95}, {0.25, 0.25, 0.25}}, 8},
    [VV_TEXTURE_WOOD] = {{{0.87, 0.66, 0.42}, {0.48, 0.27, 0.13}}, 10},
    [VV_TEXTURE_MARBLE] = {{{0.96, 0.95, 0.92}, {0.30, 0.34, 0.40}}, 4},
    [VV_TEXTURE_NOISE] = {{{1, 1, 1}, {0.1, 0.1, 0.1}}, 8},
};

static vv_status fail_texture(const vvi_cast *cast, const char *property, vv_status status, const char *text)
{
    char where[512];
    snprintf(where, sizeof where, "%s.texture.%s", cast->path, property);
    return vv_fail_at(status, NULL, where, "%s", text);
}

static int kind_of(const vv_volume_texture *t)
{
    const bool has_image = t->image && *t->image;
    return vv_object_is_set(&t->base, "kind") ? t->kind : has_image ? VV_TEXTURE_IMAGE : VV_TEXTURE_NONE;
}

bool vvi_has_texture(const vv_volume *volume)
{
    return kind_of((const vv_volume_texture *)volume->texture) != VV_TEXTURE_NONE;
}

static vv_status load_image(vvi_cast *cast, const vv_volume_texture *t, vv_job *job)
{
    if (!t->image || !*t->image)
        return fail_texture(cast, "image", VV_E_ARGUMENT,
                            "an image texture needs a file: name one, or choose another kind");
    const vv_status st = vv_image_read(&cast->actor->texture.image, NULL, NULL, t->image, job);
    return st == VV_OK ? VV_OK : vv_fail_in(st, "%s.texture.image", cast->path);
}

/* Middle and longest side of the volume, half a voxel around its samples included, before it is placed. */
static double find_middle(vv_vec3 *middle, const vv_actor *actor, const vv_affine *world_to_data)
{
    const int64_t *n = vv_field_get_info(actor->field)->grid.dims;
    const vv_affine own = vv_affine_compose(*world_to_data, actor->index_to_world);
    vv_vec3 lo = {INFINITY, INFINITY, INFINITY}, hi = {-INFINITY, -INFINITY, -INFINITY};
    for (int c = 0; c < 8; c++) {
        const vv_vec3 index = {c & 1 ? (double)n[0] - 0.5 : -0.5, c & 2 ? (double)n[1] - 0.5 : -0.5,
                               c & 4 ? (double)n[2] - 0.5 : -0.5};
        const vv_vec3 p = vv_affine_point(own, index);
        lo = vvi_vec(fmin(lo.x, p.x), fmin(lo.y, p.y), fmin(lo.z, p.z));
        hi = vvi_vec(fmax(hi.x, p.x), fmax(hi.y, p.y), fmax(hi.z, p.z));
    }
    *middle = vvi_scaled(vvi_add(lo, hi), 0.5);
    return fmax(hi.x - lo.x, fmax(hi.y - lo.y, hi.z - lo.z));
}

/* q = frequency * place^-1 (data - middle), where data = data_to_world^-1 world. */
static vv_status place_texture(vvi_cast *cast, const vv_volume_texture *t, const vv_affine *data_to_world)
{
    vv_texture *out = &cast->actor->texture;
    vv_affine world_to_data, to_texture, m = vv_affine_identity();
    vv_vec3 middle;
    vv_affine_invert(&world_to_data, *data_to_world); /* the volume's own place has been looked at */
    const double side = find_middle(&middle, cast->actor, &world_to_data);
    out->frequency = vv_object_is_set(&t->base, "frequency") ? t->frequency : by_kind[out->kind].along / side;
    m.origin = vvi_scaled(middle, -1);
    m = vv_affine_compose(m, world_to_data);
    if (!vv_affine_invert(&to_texture, vvi_placement_matrix((const vv_placement *)t->place)))
        return fail_texture(cast, "place", VV_E_ARGUMENT, "flattens the texture: its matrix has no inverse");
    m = vv_affine_compose(to_texture, m);
    for (int i = 0; i < 3; i++)
        m.axis[i] = vvi_scaled(m.axis[i], out->frequency);
    m.origin = vvi_scaled(m.origin, out->frequency);
    if (!vvi_finite(m.axis[0]) || !vvi_finite(m.axis[1]) || !vvi_finite(m.axis[2]) || !vvi_finite(m.origin))
        return fail_texture(cast, "place", VV_E_ARGUMENT, "moves the texture too far away to compute with");
    out->from_world = m;
    return VV_OK;
}

static void find_colors(vv_texture *out, const vv_volume_texture *t)
{
    const vv_color *set[2] = {vv_object_is_set(&t->base, "color") ? &t->color : NULL,
                              vv_object_is_set(&t->base, "second_color") ? &t->second_color : NULL};
    for (int i = 0; i < 2; i++) {
        const double given[3] = {set[i] ? set[i]->r : 0, set[i] ? set[i]->g : 0, set[i] ? set[i]->b : 0};
        for (int c = 0; c < 3; c++)
            out->color[i][c] = set[i] ? given[c] : vv_srgb_decode(by_kind[out->kind].color[i][c]);
    }
}

/* Where a pattern is chosen it is shown, whatever image is named. */
static void tell_unused_image(const vvi_cast *cast, const vv_volume_texture *t, vv_job *job)
{
    if (t->kind != VV_TEXTURE_NONE && t->kind != VV_TEXTURE_IMAGE && t->image && *t->image)
        vvi_log(job, VV_LOG_WARNING, "render",
                "%s.texture.image is not used: texture.kind chooses a pattern; leave it out, or image shows it",
                cast->path);
}

vv_status vvi_resolve_texture(vvi_cast *cast, const vv_affine *data_to_world, vv_job *job)
{
    const vv_volume_texture *t = (const vv_volume_texture *)cast->volume->texture;
    vv_texture *out = &cast->actor->texture;
    out->kind = kind_of(t);
    if (out->kind == VV_TEXTURE_NONE)
        return VV_OK;
    tell_unused_image(cast, t, job);
    out->mapping = t->mapping;
    out->wrap = t->wrap;
    out->apply = t->apply;
    out->strength = t->strength;
    out->seed = (uint32_t)t->seed;
    find_colors(out, t);
    const vv_status st = out->kind == VV_TEXTURE_IMAGE ? load_image(cast, t, job) : VV_OK;
    return st == VV_OK ? place_texture(cast, t, data_to_world) : st;
}
