/* One mesh of the World as renderers see it. */
#include "core/cache.h"
#include "core/job.h"
#include "core/memory.h"
#include "core/vec.h"
#include "gfx/texture.h"
#include "grid/mesh.h"
#include "scene/resolve.h"
#include "scene/smooth_mesh.h"
#include "scene/transfer.h"
#include <math.h>
#include <stdio.h>
#include <string.h>
#include <volvis/image.h>

/* Normals --------------------------------------------------------------------------------------------------------- */

static vv_status make_normals(void **value_out, uint64_t *bytes_out, void *user, vv_job *job)
{
    vv_mesh *shaded;
    const vv_status st = vvi_mesh_smooth_shaded(&shaded, user, job);
    if (st != VV_OK)
        return st;
    *value_out = shaded;
    *bytes_out = vvi_mesh_bytes(shaded);
    return VV_OK;
}

static void drop_mesh(void *mesh)
{
    vv_mesh_release(mesh);
}

/* A mesh without normals gets some, which are kept; its vertices may be more then, its triangles are the same. */
static vv_status add_normals(vv_mesh **mesh, vv_job *job)
{
    vvi_cached *cached;
    if (vv_mesh_get_info(*mesh)->normals)
        return VV_OK;
    const vvi_cache_key key = {"mesh normals", 0, vv_mesh_checksum(*mesh)};
    const vv_status st = vvi_cache_get(&cached, &key, make_normals, drop_mesh, *mesh, job);
    if (st != VV_OK)
        return st;
    vv_mesh_release(*mesh);
    *mesh = vv_mesh_retain(vvi_cached_value(cached));
    vvi_cache_release(cached);
    return VV_OK;
}

/* Colours --------------------------------------------------------------------------------------------------------- */

static bool has_colors(const vv_mesh_info *m)
{
    for (size_t i = 0; i < m->n_parts; i++)
        if (m->parts[i].color.a >= 0 || m->parts[i].texture)
            return true;
    return m->colors;
}

static void range_of(double *lo, double *hi, const vv_mesh_info *m)
{
    *lo = INFINITY;
    *hi = -INFINITY;
    for (size_t i = 0; i < m->n_vertices; i++) {
        const double v = (double)m->values[i];
        if (!isfinite(v))
            continue;
        *lo = fmin(*lo, v);
        *hi = fmax(*hi, v);
    }
    if (!(*lo <= *hi))
        *lo = *hi = 0;
}

/* Whether three in four vertices have one value, such as the intensity of a range scanner that did not measure it: a
 * colour that says nothing. Not where it is 0, around places that stand out in a map of activation. The only value that
 * can be that of so many is found by votes (Boyer and Moore 1981). */
static bool mostly_constant(const vv_mesh_info *m)
{
    float most = 0;
    size_t votes = 0, n = 0;
    for (size_t i = 0; i < m->n_vertices; i++) {
        if (votes == 0)
            most = m->values[i];
        votes += m->values[i] == most ? 1 : votes > 0 ? (size_t)-1 : 0;
    }
    for (size_t i = 0; i < m->n_vertices; i++)
        n += m->values[i] == most;
    return most != 0 && n >= m->n_vertices - m->n_vertices / 4;
}

/* Whether a label paints: 0 without a row does not. */
static bool is_painted(const vv_mesh_actor *shape, double value)
{
    const vv_classification *c = &shape->look.classes;
    bool some = value != 0 || !shape->look.paint.nearest;
    for (size_t i = 0; i < c->n_color && !some; i++)
        some = c->color[4 * i] == 0;
    return some;
}

/* Vertices without a value are of the volume's own colour. */
static vv_status color_vertices(vv_mesh_actor *shape, vv_job *job)
{
    const vv_mesh_info *m = vv_mesh_get_info(shape->mesh);
    vv_classification classes = shape->look.classes;
    uint8_t *colors = vvi_alloc(job, 4 * m->n_vertices + 4, VVI_MEM_DERIVED);
    classes.kind = VV_SEGMENT_TRANSFER;
    classes.opacity_length = 1;
    shape->colors = colors;
    if (!colors)
        return vv_fail_memory(4 * m->n_vertices);
    for (size_t i = 0; i < m->n_vertices; i++) {
        double rgbk[4];
        vvi_transfer_evaluate(rgbk, &classes, (double)m->values[i]);
        const bool painted = !isnan(m->values[i]) && is_painted(shape, (double)m->values[i]);
        for (int c = 0; c < 3; c++) {
            const double linear = painted ? rgbk[c] : (double)shape->look.color[c];
            colors[4 * i + (size_t)c] = (uint8_t)(255 * vv_srgb_encode(fmin(fmax(linear, 0), 1)) + 0.5);
        }
        colors[4 * i + 3] = 255;
    }
    return VV_OK;
}

/* A transfer function that was given, the colour that was, those of the mesh, its values by a colour map where they
 * tell vertices apart, and else the colour that all have. */
static vv_status resolve_colors(vv_mesh_actor *shape, vvi_cast *cast, vv_job *job)
{
    const vv_object *transfer = ((const vv_segmentation *)cast->volume->segmentation)->transfer;
    const vv_mesh_info *m = vv_mesh_get_info(shape->mesh);
    const bool asked = vv_object_is_set(transfer, "color") || vv_object_is_set(transfer, "colormap") ||
                       vv_object_is_set(transfer, "preset") || vv_object_is_set(transfer, "range_lo") ||
                       vv_object_is_set(transfer, "range_hi");
    const bool colored = vv_object_is_set(&cast->volume->base, "color");
    double lo, hi;
    shape->opacity = cast->volume->color.a;
    shape->one_color = colored && !(asked && m->values);
    if (asked && !m->values)
        vvi_log(job, VV_LOG_WARNING, "render",
                "%s.segmentation.transfer: the mesh has no values at its vertices, so these colours are not used",
                cast->path);
    if (!m->values || shape->one_color || (!asked && (has_colors(m) || mostly_constant(m))))
        return VV_OK;
    range_of(&lo, &hi, m);
    const vv_status st = vvi_resolve_value_colors(cast, lo, hi, m->value_unit, job);
    return st == VV_OK ? color_vertices(shape, job) : st;
}

/* Paint ----------------------------------------------------------------------------------------------------------- */

typedef struct painting {
    const vv_mesh *mesh;
    const vv_paint *paint;
    vv_affine to_index;
} painting;

static vv_status make_painted(void **value_out, uint64_t *bytes_out, void *user, vv_job *job)
{
    const painting *p = user;
    const vv_field_info *info = vv_field_get_info(p->paint->field);
    vvi_mesh_arrays a;
    vv_mesh *copy = NULL;
    float *values;
    vv_status st = vvi_mesh_copy(&copy, &a, p->mesh, vvi_mesh_with(p->mesh), job);
    if (st == VV_OK)
        st = vvi_mesh_add_values(&values, copy, info->name, info->value_unit, job);
    if (st == VV_OK)
        st = vvi_mesh_values_of(values, vv_mesh_get_info(copy), &p->to_index, p->paint->field, p->paint->component,
                                p->paint->nearest, job);
    if (st == VV_OK)
        st = vv_field_health(p->paint->field);
    if (st != VV_OK) {
        vv_mesh_release(copy);
        return st;
    }
    *value_out = copy;
    *bytes_out = vvi_mesh_bytes(copy);
    return VV_OK;
}

/* The mesh with the values of its paint at its vertices, which are kept, and their colours. */
static vv_status paint_mesh(vv_mesh_actor *shape, const vvi_cast *cast, vv_job *job)
{
    const vv_paint *paint = &shape->look.paint;
    const size_t bytes = 4 * paint->n_color * sizeof *paint->color;
    painting p = {.mesh = shape->mesh, .paint = paint};
    vvi_cached *cached;
    vv_affine inverse;
    if (!vv_affine_invert(&inverse, paint->index_to_world))
        return vv_fail(VV_E_UNSUPPORTED, "%s.paint: has no thickness", cast->path);
    p.to_index = vv_affine_compose(inverse, shape->place);
    const uint64_t hash = vvi_hash(&p.to_index, sizeof p.to_index,
                                   vvi_hash(&paint->component, sizeof paint->component, vv_mesh_checksum(p.mesh)));
    const vvi_cache_key key = {"painted mesh", vv_field_identity(paint->field), hash};
    const vv_status st = vvi_cache_get(&cached, &key, make_painted, drop_mesh, &p, job);
    if (st != VV_OK)
        return vv_fail_in(st, "%s.paint", cast->path);
    vv_mesh_release(shape->mesh);
    shape->mesh = vv_mesh_retain(vvi_cached_value(cached));
    vvi_cache_release(cached);
    double *rows = vvi_alloc(job, bytes, VVI_MEM_DERIVED);
    if (!rows)
        return vv_fail_memory(bytes);
    memcpy(rows, paint->color, bytes);
    shape->look.classes.color = rows;
    shape->look.classes.n_color = paint->n_color;
    shape->opacity = cast->volume->color.a;
    return color_vertices(shape, job);
}

static bool has_textures(const vv_mesh_info *m)
{
    bool some = false;
    for (size_t i = 0; i < m->n_parts; i++)
        some |= m->parts[i].texture && m->parts[i].texture <= m->n_textures;
    return some && m->coordinates;
}

/* The whole ------------------------------------------------------------------------------------------------------- */

static vv_status load(vv_mesh_actor *shape, double *load_s, const vv_world *world, const vv_volume *volume,
                      const char *path, vv_job *job)
{
    const double start = vvi_render_clock();
    const vv_dataset *dataset;
    vv_status st = vvi_find_dataset(&dataset, world, volume, path);
    if (st == VV_OK)
        st = vv_dataset_mesh(&shape->mesh, world, dataset, job);
    if (st != VV_OK)
        return vv_error_last()->file || vv_error_last()->where ? st : vv_fail_in(st, "%s", path);
    *load_s += vvi_render_clock() - start;
    return add_normals(&shape->mesh, job);
}

/* What is computed of triangles in single precision has the fourth power of their sides. */
static vv_status check_size(const vv_mesh_actor *shape, const char *path)
{
    enum { MOST = 1000000000 };
    vv_vec3 corner[8];
    double size = 0;
    vvi_shape_corners(corner, shape);
    for (int c = 1; c < 8; c++)
        size = fmax(size, vvi_length(vvi_sub(corner[c], corner[0])));
    if (size <= MOST)
        return VV_OK;
    return vv_fail(
        VV_E_ARGUMENT,
        "%s: the mesh is %.3g of the scene's units long, and triangles are drawn up to %.0e; make it smaller "
        "by %s.place.scale, or give it or the scene a longer unit",
        path, size, (double)MOST, path);
}

vv_status vvi_resolve_mesh_actor(vv_mesh_actor *shape, double *load_s, const vv_world *world, const char *id,
                                 const vv_volume *volume, vv_job *job)
{
    char path[256];
    vv_affine data_to_world;
    vv_actor *look = &shape->look;
    vv_status st;
    snprintf(path, sizeof path, "volumes.%s", id);
    look->id = id;
    if ((st = load(shape, load_s, world, volume, path, job)) != VV_OK ||
        (st = vvi_place_data(&shape->place, &data_to_world, vv_affine_identity(), vv_mesh_get_info(shape->mesh)->unit,
                             world, volume, path)) != VV_OK ||
        (st = check_size(shape, path)) != VV_OK ||
        (st = vvi_resolve_planes(look, world, volume, &data_to_world, path, job)) != VV_OK)
        return st;
    vvi_resolve_shading(look, world, volume);
    if (vvi_has_texture(volume))
        vvi_log(job, VV_LOG_WARNING, "render",
                "%s.texture is not drawn on meshes: it is of volumes of samples; meshes have the images of their files",
                path);
    vvi_cast cast = {.world = world, .volume = volume, .actor = look, .path = path};
    if ((st = vvi_load_paint(&cast, &data_to_world, job)) != VV_OK)
        return st;
    if (look->paint.field)
        return paint_mesh(shape, &cast, job);
    if ((st = resolve_colors(shape, &cast, job)) != VV_OK || !has_textures(vv_mesh_get_info(shape->mesh)))
        return st;
    st = vvi_gfx_textures_get(&shape->textures, shape->mesh, job);
    return st == VV_OK ? VV_OK : vv_fail_in(st, "%s", path);
}

void vvi_shape_corners(vv_vec3 out[8], const vv_mesh_actor *shape)
{
    vv_bounds box = vv_mesh_bounds(shape->mesh);
    if (!(box.lo.x <= box.hi.x)) /* no vertices */
        box = (vv_bounds){0};
    for (int c = 0; c < 8; c++)
        out[c] = vv_affine_point(shape->place, (vv_vec3){c & 1 ? box.hi.x : box.lo.x, c & 2 ? box.hi.y : box.lo.y,
                                                         c & 4 ? box.hi.z : box.lo.z});
}

void vvi_shape_finish(vv_mesh_actor *shape)
{
    vvi_actor_finish(&shape->look);
    vv_mesh_release(shape->mesh);
    vvi_free((void *)shape->colors);
    vvi_free((void *)shape->parts);
    vvi_cache_release(shape->textures);
}
