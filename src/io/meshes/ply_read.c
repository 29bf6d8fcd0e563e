/* Reading PLY. Records of one size are read in blocks and taken column by column; those with lists one by one. */
#include "core/job.h"
#include "core/memory.h"
#include "io/meshes/mesh_colors.h"
#include "io/meshes/mesh_column.h"
#include "io/meshes/mesh_texture.h"
#include "io/meshes/ply.h"
#include "registry.h"

#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#define ROOM ((size_t)1 << 20)

typedef struct reader {
    vvi_ply *ply;
    const vvi_ply_element *element;
    vvi_words words;
    vvi_mesh_builder b;
    vvi_face_colors colors;
    uint8_t *bytes; /* read ahead, at .. end not taken yet */
    size_t at, end, room;
    uint32_t *corner; /* of one polygon */
    size_t room_corner, n_corner;
    double *place; /* u v of its corners on a texture */
    size_t room_place, n_place;
    size_t texture[VVI_PLY_TEXTURES_MOST]; /* of each that the header names: as in vv_mesh_part */
    bool numbered;                         /* faces say which one they have */
    double value[VVI_PLY_ROLES];           /* of one record */
    double *column;                        /* of VVI_COLUMN_MOST records */
    double odd;                            /* of a face: what is named and can be no vertex; 0: nothing */
    bool parted, colored;                  /* faces say which part they belong to, or which colour they have */
    vv_source *source;
    vv_job *job;
} reader;

/* Sizes ----------------------------------------------------------------------------------------------------------- */

/* The least that a record takes: in text each number is a digit and a blank. */
static uint64_t least_bytes(const reader *r, const vvi_ply_element *e)
{
    return r->ply->ascii ? 2 * (uint64_t)e->n_properties : e->bytes;
}

/* Before memory is taken: whether the file can hold what its header says. */
static vv_status check_sizes(const reader *r)
{
    bool exact;
    const uint64_t left = vvi_source_left(r->source, &exact) + 2; /* the last line end may be missing */
    uint64_t need = 0;
    for (size_t i = 0; i < r->ply->n_elements; i++) {
        const vvi_ply_element *e = &r->ply->element[i];
        const uint64_t each = least_bytes(r, e);
        if (each > 0 && e->n > (left - need) / each)
            return vv_fail_at(VV_E_FORMAT, r->b.file, "header",
                              "%" PRIu64 " of '%.40s' take at least %" PRIu64 " bytes each, but at most %" PRIu64
                              " bytes follow; the file is cut short or its header wrong",
                              e->n, e->name, each, left);
        need += each * e->n;
    }
    vvi_source_need(r->source, need > 2 ? need - 2 : 0);
    return VV_OK;
}

static vv_status reserve(reader *r)
{
    uint64_t n_vertices = 0, n_faces = 0;
    for (size_t i = 0; i < r->ply->n_elements; i++) {
        const vvi_ply_element *e = &r->ply->element[i];
        if (e->kind == VVI_PLY_VERTEX)
            n_vertices = e->n;
        else if (e->kind == VVI_PLY_FACE)
            n_faces = e->n;
    }
    return vvi_mesh_builder_reserve(&r->b, n_vertices, n_faces);
}

/* Vertices -------------------------------------------------------------------------------------------------------- */

static unsigned vertex_has(const vvi_ply_element *e)
{
    unsigned with = 0;
    if (vvi_ply_find(e, VVI_PLY_NX) && vvi_ply_find(e, VVI_PLY_NY) && vvi_ply_find(e, VVI_PLY_NZ))
        with |= VVI_MESH_NORMALS;
    if (vvi_ply_find(e, VVI_PLY_RED) && vvi_ply_find(e, VVI_PLY_GREEN) && vvi_ply_find(e, VVI_PLY_BLUE))
        with |= VVI_MESH_COLORS;
    if (vvi_ply_find(e, VVI_PLY_U) && vvi_ply_find(e, VVI_PLY_V))
        with |= VVI_MESH_COORDINATES;
    return with | (vvi_ply_find(e, VVI_PLY_VALUE) ? VVI_MESH_VALUES : 0);
}

/* Bytes as they are, larger integers by their highest bits, 0 .. 1 as floats. */
static uint8_t color_byte(double v, vv_type type)
{
    if (vv_type_is_float(type))
        return vvi_mesh_byte(v);
    const double scaled = type == VV_TYPE_U16 ? v / 257 : v;
    return (uint8_t)(scaled >= 255 ? 255 : scaled > 0 ? scaled + 0.5 : 0);
}

/* One property of vertices first .. first + n. */
static void put_column(reader *r, const vvi_ply_property *p, const double *v, size_t first, size_t n)
{
    const vvi_mesh_arrays *a = &r->b.arrays;
    const size_t axis = p->role <= VVI_PLY_Z ? p->role - VVI_PLY_X : (size_t)p->role - VVI_PLY_NX;
    if (p->role <= VVI_PLY_Z && r->b.precise)
        for (size_t i = 0; i < n; i++)
            r->b.places[3 * (first + i) + axis] = v[i];
    else if (p->role <= VVI_PLY_Z)
        for (size_t i = 0; i < n; i++)
            a->positions[3 * (first + i) + axis] = (float)v[i];
    else if (p->role <= VVI_PLY_NZ && a->normals)
        for (size_t i = 0; i < n; i++)
            a->normals[3 * (first + i) + axis] = (float)v[i];
    else if (p->role >= VVI_PLY_RED && p->role <= VVI_PLY_ALPHA && a->colors)
        for (size_t i = 0; i < n; i++)
            a->colors[4 * (first + i) + (size_t)(p->role - VVI_PLY_RED)] = color_byte(v[i], p->type);
    else if ((p->role == VVI_PLY_U || p->role == VVI_PLY_V) && a->coordinates)
        for (size_t i = 0; i < n; i++)
            a->coordinates[2 * (first + i) + (p->role == VVI_PLY_V)] = (float)v[i];
    else if (p->role == VVI_PLY_VALUE && a->values)
        for (size_t i = 0; i < n; i++)
            a->values[first + i] = (float)v[i];
}

static vv_status read_vertex_block(reader *r, size_t n)
{
    const vvi_ply_element *e = r->element;
    const size_t first = r->b.info.n_vertices;
    vv_status st = vvi_source_read(r->source, r->bytes, n * e->bytes, "vertices");
    if (st != VV_OK || (st = vvi_mesh_builder_vertices(&r->b, n)) != VV_OK)
        return st;
    for (size_t i = 0; i < e->n_properties; i++) {
        const vvi_ply_property *p = &e->property[i];
        if (p->role == VVI_PLY_NOTHING)
            continue;
        const vvi_column column = {p->type, r->ply->swapped, p->offset, e->bytes};
        vvi_column_load(r->column, &column, r->bytes, n);
        put_column(r, p, r->column, first, n);
    }
    return vvi_job_poll(r->job);
}

static vv_status read_vertex_blocks(reader *r)
{
    vv_status st = VV_OK;
    size_t most = r->room / (r->element->bytes ? r->element->bytes : 1);
    most = most < VVI_COLUMN_MOST ? most : VVI_COLUMN_MOST;
    for (uint64_t left = r->element->n; left > 0 && st == VV_OK;) {
        const size_t n = left < most ? (size_t)left : most;
        st = read_vertex_block(r, n);
        left -= n;
    }
    return st;
}

static vv_status take_vertex(reader *r)
{
    const vv_status st = vvi_mesh_builder_vertices(&r->b, 1);
    for (size_t i = 0; st == VV_OK && i < r->element->n_properties; i++) {
        const vvi_ply_property *p = &r->element->property[i];
        if (p->role != VVI_PLY_NOTHING)
            put_column(r, p, &r->value[p->role], r->b.info.n_vertices - 1, 1);
    }
    return st;
}

/* Faces ----------------------------------------------------------------------------------------------------------- */

static vv_status use_part(reader *r)
{
    uint8_t bytes[4] = {0, 0, 0, 255};
    if (r->parted) {
        const double part = r->value[VVI_PLY_PART];
        r->b.part = part >= 0 && part < (double)r->b.info.n_parts ? (uint32_t)part : 0;
        return VV_OK;
    }
    for (size_t i = 0; i < r->element->n_properties; i++) {
        const vvi_ply_property *p = &r->element->property[i];
        if (p->role >= VVI_PLY_RED && p->role <= VVI_PLY_ALPHA)
            bytes[p->role - VVI_PLY_RED] = color_byte(r->value[p->role], p->type);
    }
    return vvi_face_colors_use(&r->colors, &r->b, bytes);
}

/* With parts that are listed, the colour of a face is its part's. */
static void color_part(reader *r)
{
    vv_mesh_part *part = &r->b.arrays.parts[r->b.part];
    uint8_t bytes[4] = {0, 0, 0, 255};
    if (part->color.a >= 0)
        return;
    for (size_t i = 0; i < r->element->n_properties; i++) {
        const vvi_ply_property *p = &r->element->property[i];
        if (p->role >= VVI_PLY_RED && p->role <= VVI_PLY_ALPHA)
            bytes[p->role - VVI_PLY_RED] = color_byte(r->value[p->role], p->type);
    }
    part->color = vvi_mesh_color_of(bytes);
}

/* The image of a face is its part's. */
static vv_status use_texture(reader *r)
{
    const double number = r->numbered ? r->value[VVI_PLY_TEXTURE] : 0;
    const bool known = number >= 0 && number < (double)r->ply->n_textures;
    const size_t texture = known ? r->texture[(size_t)number] : 0;
    if (!r->parted && !r->colored)
        return vvi_mesh_builder_part(&r->b, "", 0, NULL, texture);
    if (r->b.part < r->b.info.n_parts)
        r->b.arrays.parts[r->b.part].texture = texture;
    return VV_OK;
}

/* The list may be empty, of a face without an image. */
static vv_status take_places(reader *r)
{
    vv_status st = VV_OK;
    if (!(r->b.with & VVI_MESH_CORNERS) || r->n_place != 2 * r->n_corner)
        return VV_OK;
    for (size_t i = 0; i < r->n_corner && st == VV_OK; i++) { /* whose vertices are taken */
        st = vvi_mesh_builder_coordinate(&r->b, (float)r->place[2 * i], (float)r->place[2 * i + 1]);
        r->corner[i] = (uint32_t)(r->b.info.n_coordinates - 1);
    }
    if (st == VV_OK)
        vvi_mesh_builder_corners(&r->b, r->corner, r->n_corner);
    return st;
}

static vv_status take_face(reader *r)
{
    vv_status st = r->parted || r->colored ? use_part(r) : VV_OK;
    if (st == VV_OK && r->ply->n_textures)
        st = use_texture(r);
    if (st != VV_OK)
        return st;
    if (r->parted && r->colored)
        color_part(r);
    if (r->n_corner < 3)
        return vv_fail_at(VV_E_FORMAT, r->b.file, NULL,
                          "a face before triangle %zu has %zu corners; at least 3 were expected (counted from 0)",
                          r->b.info.n_triangles, r->n_corner);
    st = r->n_corner == 3 ? vvi_mesh_builder_triangle(&r->b, r->corner)
                          : vvi_mesh_builder_polygon(&r->b, r->corner, r->n_corner);
    return st == VV_OK ? take_places(r) : st;
}

/* Strips stand in one list, each ended by -1. */
static vv_status take_strips(reader *r)
{
    vv_status st = VV_OK;
    for (size_t first = 0; first < r->n_corner && st == VV_OK;) {
        size_t end = first;
        while (end < r->n_corner && r->corner[end] != UINT32_MAX)
            end++;
        st = vvi_mesh_builder_strip(&r->b, r->corner + first, end - first);
        first = end + 1;
    }
    return st;
}

static vv_status take_record(reader *r)
{
    switch (r->element->kind) {
    case VVI_PLY_VERTEX:
        return take_vertex(r);
    case VVI_PLY_FACE:
        return take_face(r);
    case VVI_PLY_STRIPS:
        return take_strips(r);
    case VVI_PLY_OTHER:
        break;
    }
    return VV_OK;
}

/* Records with lists ---------------------------------------------------------------------------------------------- */

/* n bytes that are read ahead; NULL and the thread's error where the file ends sooner. */
static const uint8_t *need(reader *r, size_t n)
{
    if (r->end - r->at < n) {
        size_t got = 0;
        memmove(r->bytes, r->bytes + r->at, r->end - r->at);
        r->end -= r->at;
        r->at = 0;
        vv_status st = vvi_job_poll(r->job);
        if (st == VV_OK)
            st = vvi_source_read_some(r->source, r->bytes + r->end, r->room - r->end, &got);
        r->end += got;
        if (st == VV_OK && r->end < n)
            st = vvi_source_read(r->source, r->bytes, n - r->end, r->element->name); /* says what is missing */
        if (st != VV_OK || r->end < n)
            return NULL;
    }
    const uint8_t *at = r->bytes + r->at;
    r->at += n;
    return at;
}

static bool read_number(reader *r, double *out, vv_type type)
{
    const vvi_column column = {type, r->ply->swapped, 0, 0};
    const uint8_t *at = need(r, vv_type_bytes(type));
    if (at && type == VV_TYPE_U8)
        *out = *at;
    else if (at)
        vvi_column_load(out, &column, at, 1);
    return at != NULL;
}

static uint32_t index_of(reader *r, double v)
{
    if (v >= 0 && v < UINT32_MAX)
        return (uint32_t)v;
    r->odd = v;
    return UINT32_MAX;
}

/* Strips end with -1. */
static vv_status check_face(const reader *r, uint64_t face)
{
    if (r->odd == 0 || r->element->kind != VVI_PLY_FACE)
        return VV_OK;
    uint64_t n = 0;
    for (size_t i = 0; i < r->ply->n_elements; i++)
        n += r->ply->element[i].kind == VVI_PLY_VERTEX ? r->ply->element[i].n : 0;
    return vv_fail_at(VV_E_FORMAT, r->b.file, NULL,
                      "face %" PRIu64 " names vertex %.17g; there are %" PRIu64
                      " vertices, counted from 0 (the list counts them otherwise, or is damaged)",
                      face, r->odd, n);
}

static vv_status room_for_corners(reader *r, uint64_t n)
{
    bool exact;
    if (n <= r->room_corner)
        return VV_OK;
    const uint64_t left =
        vvi_source_left(r->source, &exact) + (r->ply->ascii ? strlen(r->words.at) : (uint64_t)(r->end - r->at));
    if (n > left)
        return vv_fail_at(VV_E_FORMAT, r->b.file, NULL,
                          "a list of '%.40s' has %" PRIu64 " items, but at most %" PRIu64
                          " bytes follow; the file is cut short or damaged",
                          r->element->name, n, left);
    const vv_status st = vvi_source_grow(r->source, 2 * n * sizeof *r->corner);
    if (st != VV_OK)
        return st;
    uint32_t *grown = vvi_realloc(r->job, r->corner, (size_t)(2 * n) * sizeof *grown, VVI_MEM_SCRATCH);
    if (!grown)
        return vv_fail_memory((size_t)(2 * n) * sizeof *grown);
    r->corner = grown;
    r->room_corner = (size_t)(2 * n);
    return VV_OK;
}

static vv_status room_for_list(reader *r, const vvi_ply_property *p, uint64_t n)
{
    const vv_status st = room_for_corners(r, n);
    if (st != VV_OK || p->role != VVI_PLY_COORDINATES || n <= r->room_place)
        return st;
    double *grown = vvi_realloc(r->job, r->place, (size_t)(2 * n) * sizeof *grown, VVI_MEM_SCRATCH);
    if (!grown)
        return vv_fail_memory((size_t)(2 * n) * sizeof *grown);
    r->place = grown;
    r->room_place = (size_t)(2 * n);
    return VV_OK;
}

/* Items of a list: kept where they are corners. */
static vv_status read_items(reader *r, const vvi_ply_property *p, size_t n)
{
    const size_t bytes = vv_type_bytes(p->type);
    const bool kept = p->role == VVI_PLY_CORNERS;
    if (kept)
        r->n_corner = n;
    if (p->role == VVI_PLY_COORDINATES)
        r->n_place = n;
    for (size_t i = 0; i < n;) {
        const size_t some = n - i < VVI_COLUMN_MOST ? n - i : VVI_COLUMN_MOST;
        const uint8_t *at = need(r, some * bytes);
        if (!at)
            return vv_error_last()->status;
        if (kept && bytes == 4 && !r->ply->swapped && !vv_type_is_float(p->type)) {
            memcpy(r->corner + i, at, some * bytes);
            for (size_t k = 0; k < some && p->type == VV_TYPE_I32; k++)
                if (r->corner[i + k] > INT32_MAX)
                    r->odd = (int32_t)r->corner[i + k];
        } else if (p->role == VVI_PLY_COORDINATES) {
            const vvi_column column = {p->type, r->ply->swapped, 0, bytes};
            vvi_column_load(r->place + i, &column, at, some);
        } else if (kept) {
            const vvi_column column = {p->type, r->ply->swapped, 0, bytes};
            vvi_column_load(r->column, &column, at, some);
            for (size_t k = 0; k < some; k++)
                r->corner[i + k] = index_of(r, r->column[k]);
        }
        i += some;
    }
    return VV_OK;
}

static vv_status read_list(reader *r, const vvi_ply_property *p)
{
    double n;
    if (!read_number(r, &n, p->count_type))
        return vv_error_last()->status;
    const vv_status st = room_for_list(r, p, n >= 0 ? (uint64_t)n : UINT64_MAX);
    return st == VV_OK ? read_items(r, p, (size_t)n) : st;
}

static vv_status read_record(reader *r)
{
    vv_status st = VV_OK;
    for (size_t i = 0; i < r->element->n_properties && st == VV_OK; i++) {
        const vvi_ply_property *p = &r->element->property[i];
        double v;
        if (p->list)
            st = read_list(r, p);
        else if (!read_number(r, &v, p->type))
            st = vv_error_last()->status;
        else if (p->role != VVI_PLY_NOTHING)
            r->value[p->role] = v;
    }
    return st;
}

static vv_status read_record_of_words(reader *r)
{
    vv_status st = VV_OK;
    for (size_t i = 0; i < r->element->n_properties && st == VV_OK; i++) {
        const vvi_ply_property *p = &r->element->property[i];
        int64_t n = 1;
        double v;
        if (p->list && ((st = vvi_words_int(&r->words, &n, 0, INT64_MAX, "the length of a list")) != VV_OK ||
                        (st = room_for_list(r, p, (uint64_t)n)) != VV_OK))
            return st;
        if (p->list && p->role == VVI_PLY_CORNERS)
            r->n_corner = (size_t)n;
        if (p->list && p->role == VVI_PLY_COORDINATES)
            r->n_place = (size_t)n;
        for (int64_t k = 0; k < n && st == VV_OK; k++) {
            st = vvi_words_real(&r->words, &v, r->element->name);
            if (p->role == VVI_PLY_CORNERS && st == VV_OK)
                r->corner[k] = index_of(r, v);
            else if (p->role == VVI_PLY_COORDINATES && st == VV_OK)
                r->place[k] = v;
            else if (p->role != VVI_PLY_NOTHING && st == VV_OK)
                r->value[p->role] = v;
        }
    }
    return st;
}

static vv_status read_records(reader *r)
{
    vv_status st = VV_OK;
    if (!r->ply->ascii && r->element->fixed && r->element->kind == VVI_PLY_OTHER)
        return vvi_source_skip(r->source, r->element->n * r->element->bytes);
    for (uint64_t i = 0; i < r->element->n && st == VV_OK; i++) {
        st = r->ply->ascii ? read_record_of_words(r) : read_record(r);
        if (st == VV_OK && (st = check_face(r, i)) == VV_OK)
            st = take_record(r);
    }
    return st;
}

/* Bytes that were read ahead go back, for elements that are read in another way. */
static vv_status give_back(reader *r)
{
    const size_t ahead = r->end - r->at;
    r->at = r->end = 0;
    return ahead ? vvi_source_seek(r->source, vvi_source_tell(r->source) - ahead) : VV_OK;
}

static vv_status read_element(reader *r, const vvi_ply_element *e)
{
    r->element = e;
    memset(r->value, 0, sizeof r->value);
    if (e->kind == VVI_PLY_VERTEX) {
        const vv_status st = vvi_mesh_builder_with(&r->b, vertex_has(e));
        if (st != VV_OK)
            return st;
    }
    if (e->kind == VVI_PLY_FACE) {
        const bool placed = !(r->b.with & VVI_MESH_COORDINATES) && vvi_ply_find(e, VVI_PLY_COORDINATES);
        const vv_status st = placed ? vvi_mesh_builder_with(&r->b, VVI_MESH_COORDINATES | VVI_MESH_CORNERS) : VV_OK;
        if (st != VV_OK)
            return st;
        r->numbered = vvi_ply_find(e, VVI_PLY_TEXTURE);
        r->parted = r->ply->n_part_names > 0 && vvi_ply_find(e, VVI_PLY_PART);
        r->colored = vvi_ply_find(e, VVI_PLY_RED) && vvi_ply_find(e, VVI_PLY_GREEN) && vvi_ply_find(e, VVI_PLY_BLUE);
    }
    if (e->kind == VVI_PLY_VERTEX && !r->ply->ascii && e->fixed)
        return read_vertex_blocks(r);
    const vv_status st = read_records(r);
    return st == VV_OK ? give_back(r) : st;
}

/* The whole file -------------------------------------------------------------------------------------------------- */

static bool is_precise(const vvi_ply *ply)
{
    for (size_t i = 0; i < ply->n_elements; i++)
        for (int role = VVI_PLY_X; ply->element[i].kind == VVI_PLY_VERTEX && role <= VVI_PLY_Z; role++) {
            const vvi_ply_property *p = vvi_ply_find(&ply->element[i], (vvi_ply_role)role);
            if (p && vv_type_bytes(p->type) >= 4 && p->type != VV_TYPE_F32)
                return true;
        }
    return false;
}

static vv_status take_room(reader *r)
{
    r->room = ROOM;
    r->room_corner = 256;
    r->bytes = vvi_alloc(r->job, ROOM, VVI_MEM_SCRATCH);
    r->corner = vvi_alloc(r->job, r->room_corner * sizeof *r->corner, VVI_MEM_SCRATCH);
    r->column = vvi_alloc(r->job, VVI_COLUMN_MOST * sizeof *r->column, VVI_MEM_SCRATCH);
    r->ply = vvi_alloc_zeroed(r->job, sizeof *r->ply, VVI_MEM_SCRATCH);
    return r->bytes && r->corner && r->column && r->ply ? VV_OK : vv_fail_memory(ROOM);
}

static vv_status read_all(reader *r, vv_notes *notes)
{
    static const vvi_texture_use use = {{VV_WRAP_REPEAT, VV_WRAP_REPEAT}, VVI_TEXTURE_BLEND, 0};
    vv_status st = vvi_ply_read_header(r->ply, &r->words, &r->b, notes);
    r->b.precise = st == VV_OK && is_precise(r->ply);
    if (st != VV_OK || (st = check_sizes(r)) != VV_OK || (st = reserve(r)) != VV_OK)
        return st;
    for (size_t i = 0; i < r->ply->n_textures && st == VV_OK; i++)
        st = vvi_mesh_texture_find(&r->texture[i], &r->b, r->ply->texture[i], &use, notes);
    for (size_t i = 0; i < r->ply->n_elements && st == VV_OK; i++)
        st = read_element(r, &r->ply->element[i]);
    return st == VV_OK ? vvi_face_colors_finish(&r->colors, &r->b, notes) : st;
}

vv_status vvi_ply_read(vv_mesh **out, vv_source *source, const vv_mesh_read_options *options, vv_notes *notes,
                       vv_job *job)
{
    reader r = {.source = source, .job = job};
    vvi_words_begin(&r.words, source, 0, job);
    vvi_mesh_builder_begin(&r.b, source, options, false, job);
    r.b.info.up = vvi_mesh_format_ply.up;
    vv_status st = take_room(&r);
    if (st == VV_OK && (st = read_all(&r, notes)) == VV_OK)
        st = vvi_mesh_builder_finish(out, &r.b, notes);
    vvi_mesh_builder_free(&r.b);
    vvi_face_colors_free(&r.colors);
    vvi_free(r.bytes);
    vvi_free(r.corner);
    vvi_free(r.column);
    vvi_free(r.place);
    for (size_t i = 0; r.ply && i < r.ply->n_textures; i++)
        free(r.ply->texture[i]);
    vvi_free(r.ply);
    return st;
}
