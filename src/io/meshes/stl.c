/* The row of STL, and reading it. */
#include "io/meshes/stl.h"
#include "core/job.h"
#include "core/memory.h"
#include "grid/field.h"
#include "io/meshes/mesh_colors.h"
#include "io/meshes/mesh_column.h"
#include "io/meshes/mesh_join.h"
#include "io/meshes/mesh_words.h"
#include "io/scan.h"
#include "registry.h"

#include <math.h>
#include <string.h>

enum { BLOCK = 1 << 13, BLOCK_BYTES = BLOCK * VVI_STL_FACET, TEXT_BLOCK = 256 };

static uint32_t u32(const uint8_t *b)
{
    return (uint32_t)b[0] | (uint32_t)b[1] << 8 | (uint32_t)b[2] << 16 | (uint32_t)b[3] << 24;
}

static bool has_word(const uint8_t *head, size_t n, const char *word)
{
    const size_t m = strlen(word);
    for (size_t i = 0; i + m <= n; i++)
        if (memcmp(head + i, word, m) == 0)
            return true;
    return false;
}

static bool begins_solid(const uint8_t *head, size_t n)
{
    size_t at = 0;
    while (at < n && strchr(" \t\r\n", head[at]) && head[at])
        at++;
    return n >= at + 5 && memcmp(head + at, "solid", 5) == 0;
}

/* Text has no zeros; the headers of binary files that begin with "solid" have some, or their numbers do. */
static bool is_text(const uint8_t *head, size_t n)
{
    return begins_solid(head, n) && !memchr(head, 0, n);
}

static void load_floats(float *out, const uint8_t *bytes, size_t n)
{
    memcpy(out, bytes, n * sizeof *out);
    if (vvi_machine_is_big())
        vvi_swap_bytes(out, sizeof *out, n);
}

/* A normal of length 1 or none, and corners that are numbers and not all 0. */
static bool is_facet(const uint8_t *bytes)
{
    float f[12];
    bool any = false;
    load_floats(f, bytes, 12);
    const double square = (double)f[0] * f[0] + (double)f[1] * f[1] + (double)f[2] * f[2];
    if (!(square == 0 || fabs(square - 1) < .01))
        return false;
    for (int i = 3; i < 12; i++) {
        if (!(fabsf(f[i]) < 1e30f))
            return false;
        any |= f[i] != 0;
    }
    return any;
}

/* Whether the file is at least as long as it says, by what is there of it, and all of that looks like triangles: no
 * other bytes do. */
static bool are_facets(const uint8_t *head, size_t n, uint64_t bytes)
{
    size_t at = VVI_STL_HEADER + 4;
    if (bytes < n || n < at + VVI_STL_FACET)
        return false;
    for (; at + VVI_STL_FACET <= n; at += VVI_STL_FACET)
        if (!is_facet(head + at))
            return false;
    return true;
}

/* Binary files have no mark: their triangles are looked at. Odd ones must have the suffix, or a small one its size. */
static int probe(const uint8_t *head, size_t n, const char *path)
{
    const size_t n_path = strlen(path);
    if (is_text(head, n))
        return has_word(head, n, "facet") || has_word(head, n, "endsolid") ? 2 : 1;
    if (n < VVI_STL_HEADER + 4)
        return begins_solid(head, n) ? 1 : 0;
    const uint64_t bytes = VVI_STL_HEADER + 4 + (uint64_t)VVI_STL_FACET * u32(head + VVI_STL_HEADER);
    if (are_facets(head, n, bytes))
        return 2;
    if (begins_solid(head, n))
        return 1;
    if (n < 4096)
        return bytes == n ? 1 : 0;
    return n_path > 4 && strstr(path, ".stl") && bytes > n ? 1 : 0;
}

/* Binary ---------------------------------------------------------------------------------------------------------- */

typedef struct binary {
    vv_source *source;
    vvi_mesh_builder b;
    vvi_mesh_join join;
    vvi_face_colors colors;
    uint8_t *bytes;
    float *corners;
    bool colored;           /* some bits say a colour */
    bool materialise;       /* and this is how */
    uint8_t whole_color[4]; /* of facets without one */
} binary;

/* 5 bits each. VisCAM: blue lowest, bit 15 set where there is a colour; Materialise: red lowest, bit 15 clear. */
static void color_of_bits(uint8_t out[4], const binary *r, unsigned bits)
{
    const bool own = (bits >> 15 != 0) != r->materialise;
    for (unsigned c = 0; c < 3; c++) {
        const unsigned five = bits >> (5 * (r->materialise ? c : 2 - c)) & 31;
        out[c] = own ? (uint8_t)((five * 255 + 15) / 31) : r->whole_color[c];
    }
    out[3] = own ? 255 : r->whole_color[3];
}

static void load_corners(float *out, const uint8_t *facet, size_t n)
{
    for (size_t i = 0; i < n; i++)
        load_floats(out + 9 * i, facet + i * VVI_STL_FACET + 12, 9);
}

static bool has_bits(const uint8_t *facet, size_t n)
{
    unsigned any = 0;
    for (size_t i = 0; i < n; i++)
        any |= facet[i * VVI_STL_FACET + 48] | facet[i * VVI_STL_FACET + 49];
    return any != 0;
}

/* Triangles one by one, each with its colour. */
static vv_status add_colored(binary *r, size_t n)
{
    vv_status st = VV_OK;
    for (size_t i = 0; i < n && st == VV_OK; i++) {
        const uint8_t *end = r->bytes + i * VVI_STL_FACET + 48;
        const unsigned bits = end[0] | (unsigned)end[1] << 8;
        const bool none = !r->materialise && bits >> 15 == 0;
        uint8_t color[4];
        color_of_bits(color, r, bits);
        if ((st = vvi_face_colors_use(&r->colors, &r->b, none ? NULL : color)) == VV_OK)
            st = vvi_mesh_join_add(&r->join, r->corners + 9 * i, 1);
    }
    return st;
}

static vv_status add_block(binary *r, size_t n)
{
    vv_status st = vvi_source_read(r->source, r->bytes, n * VVI_STL_FACET, "triangles");
    if (st != VV_OK)
        return st;
    load_corners(r->corners, r->bytes, n);
    if (!r->colored && has_bits(r->bytes, n)) {
        r->colored = true; /* the first of all may have none */
        if (r->b.info.n_triangles > 0)
            st = vvi_face_colors_use(&r->colors, &r->b, r->materialise ? r->whole_color : NULL);
    }
    if (st != VV_OK)
        return st;
    return r->colored ? add_colored(r, n) : vvi_mesh_join_add(&r->join, r->corners, n);
}

/* "COLOR=" and four bytes: Materialise. "unit=mm up=y": VolVis. */
static void look_at_header(binary *r, const uint8_t *header)
{
    char text[VVI_STL_HEADER + 1] = {0};
    const char *color, *unit;
    memcpy(text, header, VVI_STL_HEADER);
    memcpy(r->whole_color, (const uint8_t[]){255, 255, 255, 255}, 4);
    for (size_t i = 0; i < VVI_STL_HEADER; i++)
        text[i] = (char)(text[i] ? text[i] : ' ');
    if ((color = strstr(text, "COLOR=")) && color + 10 <= text + VVI_STL_HEADER) {
        r->materialise = true;
        memcpy(r->whole_color, header + (color + 6 - text), 4);
    }
    if ((unit = strstr(text, "VolVis unit="))) {
        vvi_unit_name(r->b.info.unit, unit + 12, strcspn(unit + 12, " "));
        r->b.unit_given = true;
        r->b.info.up = strstr(unit, " up=y") ? VV_UP_Y : VV_UP_Z;
    }
}

static vv_status check_count(const binary *r, uint32_t n)
{
    bool exact;
    const uint64_t left = vvi_source_left(r->source, &exact);
    vvi_source_need(r->source, (uint64_t)n * VVI_STL_FACET);
    if (n <= left / VVI_STL_FACET)
        return VV_OK;
    return vv_fail_at(VV_E_FORMAT, r->b.file, "byte 80",
                      "%u triangles take %llu bytes, but at most %llu follow; the file is cut short or not STL", n,
                      (unsigned long long)n * VVI_STL_FACET, (unsigned long long)left);
}

static vv_status read_facets(binary *r, uint32_t n_all, vv_job *job)
{
    vv_status st = vvi_mesh_builder_reserve(&r->b, n_all / 2, n_all);
    if (st == VV_OK)
        st = vvi_mesh_join_begin(&r->join, &r->b, n_all);
    for (uint32_t done = 0; done < n_all && st == VV_OK;) {
        const uint32_t n = n_all - done < BLOCK ? n_all - done : BLOCK;
        if ((st = add_block(r, n)) == VV_OK)
            st = vvi_job_progress(job, "read", done + n, n_all);
        done += n;
    }
    return st;
}

static vv_status warn_of_rest(const binary *r, vv_notes *notes)
{
    uint8_t more;
    size_t n = 0;
    const vv_status st = vvi_source_read_some(r->source, &more, 1, &n);
    return st == VV_OK && n > 0 ? vvi_notes_warn(notes, "has more bytes after its last triangle; they are ignored")
                                : st;
}

static vv_status read_binary(vv_mesh **out, vv_source *source, const vv_mesh_read_options *options, vv_notes *notes,
                             vv_job *job)
{
    uint8_t header[VVI_STL_HEADER + 4];
    binary r = {.source = source};
    vvi_mesh_builder_begin(&r.b, source, options, false, job);
    vv_status st = vvi_source_read(source, header, sizeof header, "the header");
    if (st != VV_OK || (st = check_count(&r, u32(header + VVI_STL_HEADER))) != VV_OK)
        return st;
    look_at_header(&r, header);
    r.bytes = vvi_alloc(job, BLOCK_BYTES, VVI_MEM_SCRATCH);
    r.corners = vvi_alloc(job, (size_t)BLOCK * 9 * sizeof *r.corners, VVI_MEM_SCRATCH);
    st = r.bytes && r.corners ? read_facets(&r, u32(header + VVI_STL_HEADER), job) : vv_fail_memory(BLOCK_BYTES);
    if (st == VV_OK && (st = warn_of_rest(&r, notes)) == VV_OK &&
        (st = vvi_face_colors_finish(&r.colors, &r.b, notes)) == VV_OK)
        st = vvi_mesh_builder_finish(out, &r.b, notes);
    vvi_mesh_builder_free(&r.b);
    vvi_mesh_join_end(&r.join);
    vvi_face_colors_free(&r.colors);
    vvi_free(r.bytes);
    vvi_free(r.corners);
    return st;
}

/* Text ------------------------------------------------------------------------------------------------------------ */

typedef struct text {
    vvi_words words;
    vvi_mesh_builder b;
    vvi_mesh_join join;
    float corners[TEXT_BLOCK * 9];
    size_t n;         /* whole facets in there */
    size_t n_corners; /* of the facet that is open */
} text;

static vv_status flush(text *r)
{
    const size_t n = r->n;
    r->n = 0;
    return n ? vvi_mesh_join_add(&r->join, r->corners, n) : VV_OK;
}

static vv_status begin_solid(text *r)
{
    const char *name = r->words.at + strspn(r->words.at, " \t");
    size_t n = strlen(name);
    while (n > 0 && (name[n - 1] == ' ' || name[n - 1] == '\t' || name[n - 1] == '\r'))
        n--;
    vv_status st = flush(r);
    if (st != VV_OK || (st = vvi_mesh_builder_new_part(&r->b, name, n, NULL, 0)) != VV_OK)
        return st;
    r->b.part = (uint32_t)r->b.info.n_parts - 1;
    r->words.at += strlen(r->words.at);
    return VV_OK;
}

static vv_status read_vertex(text *r)
{
    double v;
    vv_status st = VV_OK;
    if (r->n_corners == 3)
        return vvi_words_fail(&r->words, "a facet has more than 3 vertices");
    for (size_t a = 0; a < 3 && st == VV_OK; a++)
        if ((st = vvi_words_real(&r->words, &v, "a coordinate")) == VV_OK)
            r->corners[9 * r->n + 3 * r->n_corners + a] = (float)v;
    r->n_corners++;
    return st;
}

static vv_status end_facet(text *r)
{
    if (r->n_corners != 3)
        return vvi_words_fail(&r->words, "a facet ends with %zu vertices; 3 were expected", r->n_corners);
    r->n_corners = 0;
    return ++r->n == TEXT_BLOCK ? flush(r) : VV_OK;
}

/* Facets' normals are left out: those of the triangles are the same or better. */
static vv_status read_word(text *r, const char *word, size_t n)
{
    char key[16] = {0};
    for (size_t i = 0; i < n && i < sizeof key - 1; i++)
        key[i] = (char)(word[i] >= 'A' && word[i] <= 'Z' ? word[i] + 32 : word[i]);
    if (strcmp(key, "vertex") == 0)
        return read_vertex(r);
    if (strcmp(key, "endfacet") == 0)
        return end_facet(r);
    if (strcmp(key, "solid") == 0)
        return begin_solid(r);
    if (strcmp(key, "facet") == 0 || strcmp(key, "endsolid") == 0) {
        r->words.at += strlen(r->words.at);
        return VV_OK;
    }
    if (strcmp(key, "outer") == 0 || strcmp(key, "loop") == 0 || strcmp(key, "endloop") == 0)
        return VV_OK;
    return vvi_words_fail(&r->words, "'%.*s' is not a word of STL; expected facet, vertex or endsolid",
                          (int)(n < 40 ? n : 40), word);
}

static vv_status read_words(text *r)
{
    const char *word;
    size_t n;
    for (;;) {
        vv_status st = vvi_words_next(&r->words, &word, &n);
        if (st != VV_OK)
            return st;
        if (n == 0)
            break;
        if ((st = read_word(r, word, n)) != VV_OK)
            return st;
    }
    if (r->n_corners > 0)
        return vvi_words_fail(&r->words, "ends inside a facet; the file is cut short");
    return flush(r);
}

static vv_status read_text(vv_mesh **out, vv_source *source, const vv_mesh_read_options *options, vv_notes *notes,
                           vv_job *job)
{
    text *r = vvi_alloc_zeroed(job, sizeof *r, VVI_MEM_SCRATCH);
    if (!r)
        return vv_fail_memory(sizeof *r);
    vvi_words_begin(&r->words, source, 0, job);
    vvi_mesh_builder_begin(&r->b, source, options, false, job);
    vv_status st = vvi_mesh_join_begin(&r->join, &r->b, 0);
    if (st == VV_OK && (st = read_words(r)) == VV_OK)
        st = vvi_mesh_builder_finish(out, &r->b, notes);
    vvi_mesh_builder_free(&r->b);
    vvi_mesh_join_end(&r->join);
    vvi_free(r);
    return st;
}

/* ----------------------------------------------------------------------------------------------------------------- */

/* The size decides where it is known: binary files may begin with "solid". */
static bool is_binary(vv_source *source)
{
    size_t n;
    bool exact;
    const uint8_t *head = vvi_source_peek(source, 4096, &n);
    const uint64_t left = vvi_source_left(source, &exact);
    if (!head || !begins_solid(head, n))
        return true;
    if (exact && n >= VVI_STL_HEADER + 4 &&
        left == VVI_STL_HEADER + 4 + (uint64_t)VVI_STL_FACET * u32(head + VVI_STL_HEADER))
        return true;
    return !is_text(head, n);
}

vv_status vvi_stl_read(vv_mesh **out, vv_source *source, const vv_mesh_read_options *options, vv_notes *notes,
                       vv_job *job)
{
    return is_binary(source) ? read_binary(out, source, options, notes, job)
                             : read_text(out, source, options, notes, job);
}

static const char *const suffixes[] = {".stl", NULL};
static const char *const encodings[] = {"binary", "ascii", NULL};

const vv_mesh_format vvi_mesh_format_stl = {
    .api = VV_MESH_FORMAT_API,
    .name = "stl",
    .doc = "STL for 3D printing: triangles only; triangle colours in 15 bits, part names in text files",
    .suffixes = suffixes,
    .encodings = encodings,
    .holds = VV_MESH_HOLDS_PARTS | VV_MESH_HOLDS_COLORS | VV_MESH_HOLDS_PART_COLORS | VV_MESH_HOLDS_UNIT,
    .probe = probe,
    .read = vvi_stl_read,
    .write = vvi_stl_write,
};
