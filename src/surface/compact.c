#include "surface/compact.h"
#include "core/job.h"
#include "core/memory.h"
#include "core/vec.h"
#include "surface/reduced_records.h"

#include <math.h>
#include <string.h>

enum { HEAD = 104, PATTERNS = 256, SIDE_MOST = 65535 };

/* Bytes ----------------------------------------------------------------------------------------------------------- */

static uint8_t *put(uint8_t *at, uint64_t value, int bytes)
{
    for (int i = 0; i < bytes; i++)
        *at++ = (uint8_t)(value >> 8 * i);
    return at;
}

static uint8_t *put_double(uint8_t *at, double value)
{
    uint64_t bits;
    memcpy(&bits, &value, sizeof bits);
    return put(at, bits, 8);
}

static uint8_t *put_head(uint8_t *at, unsigned kind, unsigned flags, const vv_affine *place)
{
    const vv_vec3 columns[4] = {place->axis[0], place->axis[1], place->axis[2], place->origin};
    memcpy(at, (const uint8_t[4]){'V', 'V', 'S', '1'}, 4);
    at = put(put(at + 4, kind, 2), flags, 2);
    for (int i = 0; i < 4; i++)
        at = put_double(put_double(put_double(at, columns[i].x), columns[i].y), columns[i].z);
    return at;
}

static vv_status allocate(vvi_compact *out, size_t n, vv_job *job)
{
    *out = (vvi_compact){.bytes = vvi_alloc_zeroed(job, n, VVI_MEM_DERIVED), .n = n};
    return out->bytes ? VV_OK : vv_fail_memory(n);
}

/* Records --------------------------------------------------------------------------------------------------------- */

static size_t case_bytes(void)
{
    size_t n = 0;
    for (unsigned pattern = 0; pattern < PATTERNS; pattern++)
        n += 3 * (size_t)vvi_reduced_case(pattern)->n_triangles;
    return n;
}

static uint8_t *put_cases(uint8_t *at)
{
    for (unsigned pattern = 0; pattern < PATTERNS; pattern++)
        at = put(at, vvi_reduced_case(pattern)->n_triangles, 1);
    at = put(at, case_bytes(), 4);
    for (unsigned pattern = 0; pattern < PATTERNS; pattern++) {
        const vvi_case *k = vvi_reduced_case(pattern);
        memcpy(at, k->triangle, 3 * (size_t)k->n_triangles);
        at += 3 * (size_t)k->n_triangles;
    }
    return at + (4 - case_bytes() % 4) % 4;
}

vv_status vvi_compact_reduced(vvi_compact *out, const vvi_reduced *r, unsigned corners, bool ends, vv_job *job)
{
    const size_t table = HEAD + 7 * 4 + PATTERNS + 4 + (case_bytes() + 3) / 4 * 4;
    *out = (vvi_compact){.n = 0};
    for (int a = 0; a < 3; a++)
        if (r->n[a] > SIDE_MOST || r->grid.dims[a] > INT32_MAX)
            return vv_fail(VV_E_LIMIT, "%d bricks along an axis are more than a page can draw", r->n[a]);
    if (r->n_bytes > UINT32_MAX || r->n_triangles > UINT32_MAX)
        return vv_fail(VV_E_LIMIT, "%zu triangles are more than a page can draw", r->n_triangles);
    const vv_status st = allocate(out, table + 12 * r->n_bricks + r->n_bytes, job);
    if (st != VV_OK)
        return st;
    uint8_t *at = put_head(out->bytes, VVI_COMPACT_RECORDS, (corners & 255) | (ends ? VVI_COMPACT_ENDS : 0),
                           &r->grid.index_to_world);
    for (int a = 0; a < 3; a++)
        at = put(at, (uint64_t)r->grid.dims[a], 4);
    at = put(put(put(put(at, r->n_bricks, 4), r->n_cells, 4), r->n_triangles, 4), r->n_bytes, 4);
    at = put_cases(at);
    for (size_t i = 0; i < r->n_bricks; i++) {
        const vvi_reduced_brick *b = &r->bricks[i];
        for (int a = 0; a < 3; a++)
            at = put(at, (uint64_t)b->at[a], 2);
        at = put(put(at, b->n_cells, 2), b->first_byte, 4);
    }
    if (r->n_bytes)
        memcpy(at, r->records, r->n_bytes);
    return VV_OK;
}

/* Triangles ------------------------------------------------------------------------------------------------------- */

/* Meyer, Suessmuth, Sussner, Stamminger & Greiner 2010: On floating-point normal vectors. */
static void octahedral(int16_t out[2], const float n[3])
{
    const float sum = fabsf(n[0]) + fabsf(n[1]) + fabsf(n[2]);
    float x = n[0] / sum, y = n[1] / sum;
    if (!(sum > 0)) {
        out[0] = out[1] = INT16_MIN;
        return;
    }
    if (n[2] < 0) {
        const float u = x;
        x = copysignf(1 - fabsf(y), u);
        y = copysignf(1 - fabsf(u), y);
    }
    out[0] = (int16_t)lroundf(32767 * x);
    out[1] = (int16_t)lroundf(32767 * y);
}

size_t vvi_compact_mesh_bytes(size_t n_vertices, size_t n_triangles, bool colors)
{
    return HEAD + 8 + 12 * n_triangles + (colors ? 14 : 10) * n_vertices;
}

/* The smallest cube that holds all vertices becomes 0 .. 65535 along each axis. */
static void fit(vv_affine *out, double *scale, float lo[3], const vv_mesh_info *mesh)
{
    float hi[3] = {-INFINITY, -INFINITY, -INFINITY}, side = 0;
    for (int a = 0; a < 3; a++)
        lo[a] = INFINITY;
    for (size_t i = 0; i < 3 * mesh->n_vertices; i++) {
        lo[i % 3] = fminf(lo[i % 3], mesh->positions[i]);
        hi[i % 3] = fmaxf(hi[i % 3], mesh->positions[i]);
    }
    for (int a = 0; a < 3; a++) {
        lo[a] = isfinite(lo[a]) ? lo[a] : 0;
        side = fmaxf(side, isfinite(hi[a]) ? hi[a] - lo[a] : 0);
    }
    *scale = side > 0 ? (double)side / SIDE_MOST : 1;
    *out = (vv_affine){
        .axis = {{.x = *scale}, {.y = *scale}, {.z = *scale}},
        .origin = {mesh->origin.x + (double)lo[0], mesh->origin.y + (double)lo[1], mesh->origin.z + (double)lo[2]}};
}

static uint8_t *put_vertex(uint8_t *at, const vv_mesh_info *mesh, size_t vertex, const float lo[3], double scale)
{
    static const float none[3];
    int16_t normal[2];
    for (size_t a = 0; a < 3; a++) {
        const double v = ((double)mesh->positions[3 * vertex + a] - (double)lo[a]) / scale;
        at = put(at, (uint64_t)lround(v >= 0 && v <= SIDE_MOST ? v : v > 0 ? SIDE_MOST : 0), 2);
    }
    octahedral(normal, mesh->normals ? mesh->normals + 3 * vertex : none);
    return put(put(at, (uint16_t)normal[0], 2), (uint16_t)normal[1], 2);
}

vv_status vvi_compact_mesh(vvi_compact *out, const vv_mesh_info *mesh, const uint8_t *colors, vv_job *job)
{
    vv_affine place;
    float lo[3];
    double scale;
    *out = (vvi_compact){.n = 0};
    const vv_status st =
        allocate(out, vvi_compact_mesh_bytes(mesh->n_vertices, mesh->n_triangles, colors != NULL), job);
    if (st != VV_OK)
        return st;
    fit(&place, &scale, lo, mesh);
    uint8_t *at = put_head(out->bytes, VVI_COMPACT_TRIANGLES, colors ? VVI_COMPACT_COLORS : 0, &place);
    at = put(put(at, mesh->n_vertices, 4), mesh->n_triangles, 4);
    for (size_t i = 0; i < 3 * mesh->n_triangles; i++)
        at = put(at, mesh->triangles[i], 4);
    if (colors)
        memcpy(at, colors, 4 * mesh->n_vertices);
    at += colors ? 4 * mesh->n_vertices : 0;
    for (size_t i = 0; i < mesh->n_vertices; i++)
        at = put_vertex(at, mesh, i, lo, scale);
    return VV_OK;
}

/* Boxes ----------------------------------------------------------------------------------------------------------- */

enum { BOXES_HEAD = HEAD + 8 * 4 };

static size_t n_boxes(const vv_field *solid)
{
    const int64_t *n = vv_field_get_info(solid)->grid.dims;
    return (size_t)n[0] * (size_t)n[1] * (size_t)n[2];
}

size_t vvi_compact_boxes_bytes(const vv_field *solid)
{
    return BOXES_HEAD + (n_boxes(solid) + 7) / 8;
}

static bool is_solid(const uint8_t *bits, size_t i)
{
    return bits[i / 8] >> i % 8 & 1;
}

/* Faces with nothing beyond them. */
static size_t count_faces(const uint8_t *bits, const int64_t n[3])
{
    const size_t step[3] = {1, (size_t)n[0], (size_t)n[0] * (size_t)n[1]};
    size_t faces = 0, i = 0;
    int64_t p[3];
    for (p[2] = 0; p[2] < n[2]; p[2]++)
        for (p[1] = 0; p[1] < n[1]; p[1]++)
            for (p[0] = 0; p[0] < n[0]; p[0]++, i++)
                for (int a = 0; a < 3 && is_solid(bits, i); a++)
                    faces += (size_t)(p[a] == 0 || !is_solid(bits, i - step[a])) +
                             (size_t)(p[a] == n[a] - 1 || !is_solid(bits, i + step[a]));
    return faces;
}

static vv_status put_boxes(uint8_t *bits, const vv_field *solid, int least, vv_job *job)
{
    const vv_box all = vv_field_box(solid);
    const int64_t *n = vv_field_get_info(solid)->grid.dims;
    vv_brick brick;
    const vv_status st = vv_field_brick(&brick, solid, &all, job);
    if (st != VV_OK)
        return st;
    size_t at = 0;
    for (int64_t k = 0; k < n[2]; k++)
        for (int64_t j = 0; j < n[1]; j++)
            for (int64_t i = 0; i < n[0]; i++, at++) {
                const uint8_t *sample =
                    (const uint8_t *)brick.data + i * brick.stride[0] + j * brick.stride[1] + k * brick.stride[2];
                bits[at / 8] |= (uint8_t)((*sample >= least) << at % 8);
            }
    vv_brick_release(&brick);
    return VV_OK;
}

vv_status vvi_compact_boxes(vvi_compact *out, size_t *triangles_out, const vv_field *solid, const vv_grid *grid,
                            int least, vv_job *job)
{
    const vv_grid *boxes = &vv_field_get_info(solid)->grid;
    const double side = vvi_length(boxes->index_to_world.axis[0]) / vvi_length(grid->index_to_world.axis[0]);
    *out = (vvi_compact){.n = 0};
    for (int a = 0; a < 3; a++)
        if (grid->dims[a] > INT32_MAX)
            return vv_fail(VV_E_LIMIT, "%lld samples along an axis are more than a page can draw",
                           (long long)grid->dims[a]);
    vv_status st = allocate(out, vvi_compact_boxes_bytes(solid), job);
    if (st == VV_OK)
        st = put_boxes(out->bytes + BOXES_HEAD, solid, least, job);
    if (st != VV_OK) {
        vvi_free(out->bytes);
        *out = (vvi_compact){.n = 0};
        return st;
    }
    *triangles_out = 2 * count_faces(out->bytes + BOXES_HEAD, boxes->dims);
    uint8_t *at = put_head(out->bytes, VVI_COMPACT_BOXES, 0, &grid->index_to_world);
    for (int a = 0; a < 3; a++)
        at = put(at, (uint64_t)grid->dims[a], 4);
    at = put(at, (uint64_t)lround(side), 4);
    for (int a = 0; a < 3; a++)
        at = put(at, (uint64_t)boxes->dims[a], 4);
    put(at, *triangles_out, 4);
    return VV_OK;
}
