#include "io/meshes/mesh_builder.h"
#include "core/job.h"
#include "core/memory.h"
#include "core/text.h"
#include "io/scan.h"

#include <math.h>
#include <string.h>

void vvi_mesh_builder_begin(vvi_mesh_builder *out, vv_source *source, const vv_mesh_read_options *options, bool precise,
                            vv_job *job)
{
    *out = (vvi_mesh_builder){.job = job, .source = source, .file = vvi_source_name(source), .precise = precise};
    vvi_unit_name(out->info.unit, options->unit, strlen(options->unit));
}

void vvi_mesh_builder_free(vvi_mesh_builder *b)
{
    vvi_free(b->arrays.positions);
    vvi_free(b->arrays.normals);
    vvi_free(b->arrays.values);
    vvi_free(b->arrays.colors);
    vvi_free(b->arrays.triangles);
    vvi_free(b->arrays.parts);
    vvi_free(b->arrays.coordinates);
    vvi_free(b->arrays.coordinate_of);
    vvi_mesh_textures_release(b->arrays.textures);
    vvi_free(b->places);
    vvi_free(b->part_of);
    vvi_free(b->fans);
    *b = (vvi_mesh_builder){0};
}

/* Room ------------------------------------------------------------------------------------------------------------ */

/* An array of n_had, if it is there, becomes one of n. */
static vv_status resize(vvi_mesh_builder *b, void *array, size_t n_had, size_t n, size_t each)
{
    size_t bytes;
    const size_t had = *(void **)array ? n_had : 0;
    vv_status st = vvi_mul_size(&bytes, n, each);
    if (st == VV_OK && n > had)
        st = vvi_source_grow(b->source, (uint64_t)(n - had) * each);
    if (st != VV_OK)
        return st;
    void *grown = vvi_realloc(b->job, *(void **)array, bytes ? bytes : 1, VVI_MEM_DERIVED);
    if (!grown)
        return vv_fail_memory(bytes);
    *(void **)array = grown;
    return VV_OK;
}

static vv_status room_for_vertices(vvi_mesh_builder *b, size_t n)
{
    const size_t had = b->room_vertices;
    vv_status st = b->precise ? resize(b, &b->places, had, n, 3 * sizeof(double))
                              : resize(b, &b->arrays.positions, had, n, 3 * sizeof(float));
    if (st == VV_OK && b->with & VVI_MESH_NORMALS)
        st = resize(b, &b->arrays.normals, had, n, 3 * sizeof(float));
    if (st == VV_OK && b->with & VVI_MESH_VALUES)
        st = resize(b, &b->arrays.values, had, n, sizeof(float));
    if (st == VV_OK && b->with & VVI_MESH_COLORS)
        st = resize(b, &b->arrays.colors, had, n, 4);
    if (st == VV_OK && b->with & VVI_MESH_COORDINATES && !(b->with & VVI_MESH_CORNERS))
        st = resize(b, &b->arrays.coordinates, had, n, 2 * sizeof(float));
    if (st == VV_OK)
        b->room_vertices = n;
    return st;
}

static vv_status room_for_triangles(vvi_mesh_builder *b, size_t n)
{
    vv_status st = resize(b, &b->arrays.triangles, b->room_triangles, n, 3 * sizeof(uint32_t));
    if (st == VV_OK && b->part_of)
        st = resize(b, &b->part_of, b->room_triangles, n, sizeof(uint32_t));
    if (st == VV_OK && b->with & VVI_MESH_CORNERS)
        st = resize(b, &b->arrays.coordinate_of, b->room_triangles, n, 3 * sizeof(uint32_t));
    if (st == VV_OK)
        b->room_triangles = n;
    return st;
}

static vv_status check_count(const vvi_mesh_builder *b, uint64_t n, const char *what)
{
    if (n < UINT32_MAX)
        return VV_OK;
    return vv_fail_at(VV_E_LIMIT, b->file, NULL, "has %llu %s; a mesh has fewer than 2^32", (unsigned long long)n,
                      what);
}

vv_status vvi_mesh_builder_reserve(vvi_mesh_builder *b, uint64_t n_vertices, uint64_t n_triangles)
{
    const uint64_t v = b->info.n_vertices + n_vertices, t = b->info.n_triangles + n_triangles;
    vv_status st = check_count(b, v, "vertices");
    if (st == VV_OK && (st = check_count(b, t, "triangles")) == VV_OK && v > b->room_vertices)
        st = room_for_vertices(b, (size_t)v);
    return st == VV_OK && t > b->room_triangles ? room_for_triangles(b, (size_t)t) : st;
}

static void clear_vertices(vvi_mesh_builder *b, unsigned with, size_t first, size_t end)
{
    if (end <= first)
        return;
    if (with & VVI_MESH_NORMALS)
        memset(b->arrays.normals + 3 * first, 0, 3 * (end - first) * sizeof(float));
    if (with & VVI_MESH_COLORS)
        memset(b->arrays.colors + 4 * first, 255, 4 * (end - first));
    if (with & VVI_MESH_COORDINATES && !(b->with & VVI_MESH_CORNERS))
        memset(b->arrays.coordinates + 2 * first, 0, 2 * (end - first) * sizeof(float));
    for (size_t i = first; i < end && with & VVI_MESH_VALUES; i++)
        b->arrays.values[i] = NAN;
}

vv_status vvi_mesh_builder_with(vvi_mesh_builder *b, unsigned with)
{
    const unsigned added = with & ~b->with;
    if (!added)
        return VV_OK;
    b->with |= added;
    vv_status st = room_for_vertices(b, b->room_vertices);
    if (st == VV_OK)
        clear_vertices(b, added, 0, b->info.n_vertices);
    if (st != VV_OK || !(added & VVI_MESH_CORNERS) || (st = room_for_triangles(b, b->room_triangles)) != VV_OK)
        return st;
    memset(b->arrays.coordinate_of, 0, 3 * b->info.n_triangles * sizeof *b->arrays.coordinate_of);
    return vvi_mesh_builder_coordinate(b, 0, 0);
}

vv_status vvi_mesh_builder_coordinate(vvi_mesh_builder *b, float u, float v)
{
    const size_t n = b->info.n_coordinates;
    vv_status st = check_count(b, n + 1, "texture coordinates");
    if (st == VV_OK && n == b->room_coordinates) {
        const size_t room = n * 3 / 2 + 1024;
        if ((st = resize(b, &b->arrays.coordinates, n, room, 2 * sizeof(float))) == VV_OK)
            b->room_coordinates = room;
    }
    if (st != VV_OK)
        return st;
    b->arrays.coordinates[2 * n] = u;
    b->arrays.coordinates[2 * n + 1] = v;
    b->info.n_coordinates++;
    return VV_OK;
}

vv_status vvi_mesh_builder_vertices(vvi_mesh_builder *b, size_t n)
{
    const size_t first = b->info.n_vertices, need = first + n;
    vv_status st = check_count(b, (uint64_t)first + n, "vertices");
    if (st == VV_OK && need > b->room_vertices)
        st = room_for_vertices(b, need > first * 3 / 2 + 1024 ? need : first * 3 / 2 + 1024);
    if (st != VV_OK)
        return st;
    b->info.n_vertices = need;
    clear_vertices(b, b->with, first, need);
    return VV_OK;
}

vv_status vvi_mesh_builder_triangles(vvi_mesh_builder *b, size_t n)
{
    const size_t first = b->info.n_triangles, need = first + n;
    vv_status st = check_count(b, (uint64_t)first + n, "triangles");
    if (st == VV_OK && need > b->room_triangles)
        st = room_for_triangles(b, need > first * 3 / 2 + 1024 ? need : first * 3 / 2 + 1024);
    if (st != VV_OK)
        return st;
    b->info.n_triangles = need;
    for (size_t i = first; b->part_of && i < need; i++)
        b->part_of[i] = b->part;
    if (b->with & VVI_MESH_CORNERS)
        memset(b->arrays.coordinate_of + 3 * first, 0, 3 * n * sizeof *b->arrays.coordinate_of);
    return VV_OK;
}

/* Triangles ------------------------------------------------------------------------------------------------------- */

vv_status vvi_mesh_builder_triangle(vvi_mesh_builder *b, const uint32_t corner[3])
{
    const vv_status st = vvi_mesh_builder_triangles(b, 1);
    if (st == VV_OK)
        memcpy(b->arrays.triangles + 3 * (b->info.n_triangles - 1), corner, 3 * sizeof *corner);
    return st;
}

static vv_status note_fan(vvi_mesh_builder *b, size_t n)
{
    if (b->n_fans == b->room_fans) {
        const size_t room = b->room_fans * 3 / 2 + 256;
        const vv_status st = resize(b, &b->fans, b->room_fans, room, sizeof *b->fans);
        if (st != VV_OK)
            return st;
        b->room_fans = room;
    }
    b->fans[b->n_fans++] = (vvi_mesh_fan){(uint32_t)(b->info.n_triangles - (n - 2)), (uint32_t)n};
    return VV_OK;
}

static void put_fan(uint32_t *t, const uint32_t *corner, size_t n)
{
    for (size_t i = 0; i < n - 2; i++, t += 3) {
        t[0] = corner[0];
        t[1] = corner[i + 1];
        t[2] = corner[i + 2];
    }
}

vv_status vvi_mesh_builder_polygon(vvi_mesh_builder *b, const uint32_t *corner, size_t n)
{
    const vv_status st = vvi_mesh_builder_triangles(b, n - 2);
    if (st != VV_OK)
        return st;
    put_fan(b->arrays.triangles + 3 * (b->info.n_triangles - (n - 2)), corner, n);
    return n > 3 ? note_fan(b, n) : VV_OK;
}

void vvi_mesh_builder_corners(vvi_mesh_builder *b, const uint32_t *coordinate, size_t n)
{
    put_fan(b->arrays.coordinate_of + 3 * (b->info.n_triangles - (n - 2)), coordinate, n);
}

vv_status vvi_mesh_builder_strip(vvi_mesh_builder *b, const uint32_t *corner, size_t n)
{
    vv_status st = VV_OK;
    for (size_t i = 0; i + 2 < n && st == VV_OK; i++) {
        const uint32_t t[3] = {corner[i + i % 2], corner[i + 1 - i % 2], corner[i + 2]};
        if (t[0] != t[1] && t[1] != t[2] && t[2] != t[0])
            st = vvi_mesh_builder_triangle(b, t);
    }
    return st;
}

/* Parts ----------------------------------------------------------------------------------------------------------- */

static bool is_part(const vv_mesh_part *part, const vv_mesh_part *other)
{
    const vv_color *a = &part->color, *b = &other->color;
    return strcmp(part->name, other->name) == 0 && part->texture == other->texture &&
           ((a->a < 0 && b->a < 0) || (a->r == b->r && a->g == b->g && a->b == b->b && a->a == b->a));
}

static vv_mesh_part make_part(const char *name, size_t n_name, const vv_color *color, size_t texture)
{
    vv_mesh_part part = {.color.a = -1, .texture = texture};
    memcpy(part.name, name, vvi_utf8_cut(name, n_name, sizeof part.name - 1));
    vvi_text_clean(part.name);
    if (color)
        part.color = *color;
    return part;
}

/* Triangles that came before the second part belong to the first. */
static vv_status begin_part_of(vvi_mesh_builder *b)
{
    const vv_status st = resize(b, &b->part_of, 0, b->room_triangles, sizeof(uint32_t));
    if (st == VV_OK && b->info.n_triangles)
        memset(b->part_of, 0, b->info.n_triangles * sizeof *b->part_of);
    return st;
}

static vv_status add_part(vvi_mesh_builder *b, const vv_mesh_part *part)
{
    vv_status st = VV_OK;
    const size_t n = b->info.n_parts;
    if (n == VVI_MESH_PARTS_MOST)
        return VV_OK;
    if (n == b->room_parts) {
        const size_t room = 2 * n + 8;
        if ((st = resize(b, &b->arrays.parts, n, room, sizeof *part)) != VV_OK)
            return st;
        b->room_parts = room;
    }
    if (n == 1 && !b->part_of && (st = begin_part_of(b)) != VV_OK)
        return st;
    b->arrays.parts[n] = *part;
    b->info.n_parts++;
    return VV_OK;
}

vv_status vvi_mesh_builder_new_part(vvi_mesh_builder *b, const char *name, size_t n_name, const vv_color *color,
                                    size_t texture)
{
    const vv_mesh_part part = make_part(name, n_name, color, texture);
    b->n_cut += n_name >= sizeof part.name;
    return add_part(b, &part);
}

vv_status vvi_mesh_builder_part(vvi_mesh_builder *b, const char *name, size_t n_name, const vv_color *color,
                                size_t texture)
{
    enum { LOOKED_AT = 1024 };
    const vv_mesh_part part = make_part(name, n_name, color, texture), nameless = {.color.a = -1};
    const size_t n = b->info.n_parts, first = n > LOOKED_AT ? n - LOOKED_AT : 0;
    for (size_t i = n; i > first; i--)
        if (is_part(&b->arrays.parts[i - 1], &part)) {
            b->part = (uint32_t)(i - 1);
            return VV_OK;
        }
    vv_status st = VV_OK;
    if (n == 0 && b->info.n_triangles > 0)
        st = add_part(b, &nameless);
    if (st == VV_OK)
        st = add_part(b, &part);
    b->n_cut += n_name >= sizeof part.name;
    b->part = (uint32_t)(b->info.n_parts ? b->info.n_parts - 1 : 0);
    return st;
}

/* Finishing ------------------------------------------------------------------------------------------------------- */

bool vvi_mesh_is_far(const vv_bounds *box)
{
    const double *lo = &box->lo.x, *hi = &box->hi.x;
    double far = 0, side = 0;
    for (int a = 0; a < 3; a++) {
        far = fmax(far, fmax(fabs(lo[a]), fabs(hi[a])));
        side = fmax(side, hi[a] - lo[a]);
    }
    return far > 16 * side && side > 0;
}

static vv_status check_indices(const vvi_mesh_builder *b)
{
    const uint32_t n = (uint32_t)b->info.n_vertices, *v = b->arrays.triangles;
    const size_t n_corners = 3 * b->info.n_triangles;
    for (size_t i = 0; i < n_corners; i++)
        if (v[i] >= n)
            return vv_fail_at(VV_E_FORMAT, b->file, NULL,
                              "triangle %zu names vertex %u, but the file has only %u of them (counted from 0)", i / 3,
                              v[i], n);
    return VV_OK;
}

static vv_status fail_place(const vvi_mesh_builder *b, size_t i)
{
    return vv_fail_at(VV_E_FORMAT, b->file, NULL,
                      "vertex %zu has a position that is not a number or is too large (counted from 0)", i / 3);
}

/* The box of places that are all numbers. */
static vv_status measure_places(vv_bounds *out, const vvi_mesh_builder *b)
{
    *out = (vv_bounds){{INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY}};
    double *lo = &out->lo.x, *hi = &out->hi.x;
    for (size_t i = 0; i < 3 * b->info.n_vertices; i++) {
        const double v = b->places[i];
        if (!isfinite((float)v))
            return fail_place(b, i);
        lo[i % 3] = v < lo[i % 3] ? v : lo[i % 3];
        hi[i % 3] = v > hi[i % 3] ? v : hi[i % 3];
    }
    return VV_OK;
}

/* Single precision about an origin where it would lose too much about zero. */
static vv_status settle_places(vvi_mesh_builder *b)
{
    vv_bounds box;
    if (!b->precise) {
        for (size_t i = 0; i < 3 * b->info.n_vertices; i++)
            if (!isfinite(b->arrays.positions[i]))
                return fail_place(b, i);
        return VV_OK;
    }
    vv_status st = measure_places(&box, b);
    if (st != VV_OK || (st = resize(b, &b->arrays.positions, 0, b->info.n_vertices, 3 * sizeof(float))) != VV_OK)
        return st;
    vv_vec3 o = {0, 0, 0};
    if (vvi_mesh_is_far(&box))
        o = (vv_vec3){round((box.lo.x + box.hi.x) / 2), round((box.lo.y + box.hi.y) / 2),
                      round((box.lo.z + box.hi.z) / 2)};
    b->info.origin = (vv_vec3){b->info.origin.x + o.x, b->info.origin.y + o.y, b->info.origin.z + o.z};
    for (size_t i = 0; i < 3 * b->info.n_vertices; i++)
        b->arrays.positions[i] = (float)(b->places[i] - (&o.x)[i % 3]);
    vvi_free(b->places);
    b->places = NULL;
    b->precise = false;
    return VV_OK;
}

/* Of length 1, or 0 where there is none. */
static size_t settle_normals(vvi_mesh_builder *b)
{
    size_t n_bad = 0;
    for (size_t i = 0; i < b->info.n_vertices && b->arrays.normals; i++) {
        float *n = b->arrays.normals + 3 * i;
        const double square = (double)n[0] * n[0] + (double)n[1] * n[1] + (double)n[2] * n[2];
        if (fabs(square - 1) < 1e-6 || square == 0)
            continue;
        const bool good = isfinite(square);
        n_bad += !good;
        for (int a = 0; a < 3; a++)
            n[a] = good ? (float)(n[a] / sqrt(square)) : 0;
    }
    return n_bad;
}

/* What belongs to the corners of triangles; at: room for where the next of each part goes. */
static vv_status sort_corners(vvi_mesh_builder *b, uint32_t **corners, uint64_t *at, const uint64_t *end)
{
    uint32_t *sorted = NULL;
    const vv_status st = *corners ? resize(b, &sorted, 0, b->info.n_triangles, 3 * sizeof *sorted) : VV_OK;
    if (st != VV_OK || !*corners)
        return st;
    for (size_t p = 0; p < b->info.n_parts; p++)
        at[p] = p ? end[p - 1] : 0;
    for (size_t t = 0; t < b->info.n_triangles; t++)
        memcpy(sorted + 3 * at[b->part_of[t]]++, *corners + 3 * t, 3 * sizeof *sorted);
    vvi_free(*corners);
    *corners = sorted;
    return VV_OK;
}

/* Triangles by part, in the order in which they came. */
static vv_status sort_by_part(vvi_mesh_builder *b, const uint64_t *end)
{
    uint64_t *at = NULL;
    vv_status st = resize(b, &at, 0, b->info.n_parts, sizeof *at);
    if (st == VV_OK && (st = sort_corners(b, &b->arrays.triangles, at, end)) == VV_OK)
        st = sort_corners(b, &b->arrays.coordinate_of, at, end);
    vvi_free(at);
    return st;
}

/* Counts, drops parts that have no triangles, and sorts where the file has them mixed. */
static vv_status settle_parts(vvi_mesh_builder *b)
{
    if (b->info.n_parts == 0)
        return VV_OK;
    uint64_t *end = vvi_alloc_zeroed(b->job, b->info.n_parts * sizeof *end, VVI_MEM_SCRATCH);
    if (!end)
        return vv_fail_memory(b->info.n_parts * sizeof *end);
    bool mixed = false;
    for (size_t t = 0; t < b->info.n_triangles; t++) {
        end[b->part_of ? b->part_of[t] : 0]++;
        mixed = mixed || (b->part_of && t > 0 && b->part_of[t] < b->part_of[t - 1]);
    }
    for (size_t p = 1; p < b->info.n_parts; p++)
        end[p] += end[p - 1];
    const vv_status st = mixed ? sort_by_part(b, end) : VV_OK;
    size_t kept = 0;
    for (size_t p = 0; p < b->info.n_parts; p++) {
        const uint64_t first = p ? end[p - 1] : 0;
        if (end[p] == first && b->info.n_triangles > 0)
            continue;
        b->arrays.parts[kept] = b->arrays.parts[p];
        b->arrays.parts[kept].first_triangle = (size_t)first;
        b->arrays.parts[kept++].n_triangles = (size_t)(end[p] - first);
    }
    b->info.n_parts = kept;
    vvi_free(end);
    return st;
}

/* One part that says nothing is none. */
static void drop_idle_part(vvi_mesh_builder *b)
{
    const vv_mesh_part *part = b->arrays.parts;
    if (b->info.n_parts != 1 || part->name[0] || part->color.a >= 0 || part->texture)
        return;
    vvi_free(b->arrays.parts);
    b->arrays.parts = NULL;
    b->info.n_parts = 0;
}

static size_t settle_coordinates(vvi_mesh_builder *b)
{
    size_t n_bad = 0;
    if (!b->arrays.coordinates)
        return 0;
    if (!(b->with & VVI_MESH_CORNERS))
        b->info.n_coordinates = b->info.n_vertices;
    for (size_t i = 0; i < b->info.n_coordinates; i++) {
        float *at = b->arrays.coordinates + 2 * i;
        if (isfinite(at[0]) && isfinite(at[1]))
            continue;
        at[0] = at[1] = 0;
        n_bad++;
    }
    return n_bad;
}

static vv_status check_all(vvi_mesh_builder *b, vv_notes *notes)
{
    size_t n_bad = 0;
    vv_status st;
    if (b->info.n_triangles == 0 && b->info.n_vertices > 0)
        return vv_fail_at(VV_E_FORMAT, b->file, NULL,
                          "has %zu vertices but no triangles; point clouds and lines are not read", b->info.n_vertices);
    if ((st = check_indices(b)) != VV_OK || (st = settle_places(b)) != VV_OK)
        return st;
    if (b->info.n_triangles == 0)
        st = vvi_notes_warn(notes, "has no triangles");
    if (st == VV_OK && (st = vvi_mesh_cut_fans(&n_bad, b)) == VV_OK && n_bad > 0)
        st = vvi_notes_warn(notes, "has %zu self-intersecting polygons; their triangles overlap", n_bad);
    if (st == VV_OK && (n_bad = settle_normals(b)) > 0)
        st = vvi_notes_warn(notes, "has %zu normals that are not numbers; they are left out", n_bad);
    if (st == VV_OK && (n_bad = settle_coordinates(b)) > 0)
        st = vvi_notes_warn(notes, "has %zu texture coordinates that are not numbers; they become 0, 0", n_bad);
    if (st == VV_OK && (st = settle_parts(b)) == VV_OK)
        drop_idle_part(b);
    return st;
}

/* What was doubled ahead of need goes back. */
static vv_status give_back_room(vvi_mesh_builder *b)
{
    vv_status st = VV_OK;
    if (b->room_vertices > b->info.n_vertices + b->info.n_vertices / 8)
        st = room_for_vertices(b, b->info.n_vertices);
    vvi_free(b->part_of);
    b->part_of = NULL;
    if (st == VV_OK && b->room_triangles > b->info.n_triangles + b->info.n_triangles / 8)
        st = room_for_triangles(b, b->info.n_triangles);
    return st;
}

/* A mesh without vertices has its arrays all the same. */
static vv_status need_arrays(vvi_mesh_builder *b)
{
    vv_status st = VV_OK;
    if (!b->arrays.positions)
        st = room_for_vertices(b, b->info.n_vertices);
    if (st == VV_OK && !b->arrays.triangles)
        st = room_for_triangles(b, b->info.n_triangles);
    return st;
}

static vv_status warn_of_names(const vvi_mesh_builder *b, vv_notes *notes)
{
    const size_t most = sizeof b->arrays.parts->name - 1;
    if (b->n_cut == 0)
        return VV_OK;
    return vvi_notes_warn(notes,
                          "has %zu part names of more than %zu bytes: only the first bytes are kept, and parts that "
                          "differ only after them become one",
                          b->n_cut, most);
}

vv_status vvi_mesh_builder_finish(vv_mesh **out, vvi_mesh_builder *b, vv_notes *notes)
{
    *out = NULL;
    vv_status st = vvi_job_poll(b->job);
    if (st == VV_OK && (st = warn_of_names(b, notes)) == VV_OK && (st = check_all(b, notes)) == VV_OK &&
        (st = give_back_room(b)) == VV_OK && (st = need_arrays(b)) == VV_OK &&
        (st = vvi_mesh_adopt(out, &b->arrays, &b->info, b->job)) == VV_OK)
        b->arrays = (vvi_mesh_arrays){0};
    vvi_mesh_builder_free(b);
    return st;
}
