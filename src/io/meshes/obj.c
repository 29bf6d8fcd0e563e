/* The row of OBJ, and reading it. */
#include "io/meshes/obj.h"
#include "core/job.h"
#include "core/memory.h"
#include "core/text.h"
#include "io/meshes/mesh_colors.h"
#include "io/scan.h"
#include "registry.h"

#include <inttypes.h>
#include <stdio.h>
#include <string.h>

typedef struct reader {
    vv_source *source;
    vvi_words words;
    vvi_mesh_builder b;
    vvi_obj_library library;
    float *normal;                 /* of vn, three each */
    uint32_t *normal_of;           /* of each vertex: vn + 1 that it had last, 0: none */
    uint32_t *corner, *coordinate; /* of a face, and their coordinates on textures */
    size_t n_normals, room_normals, room_normal_of, room_corner, room_coordinate;
    uint64_t n_lost; /* corners that name coordinates that there are not */
    struct {
        unsigned long long line;
        char corner[41];
        size_t n;     /* that came before it */
    } lost;           /* the first of them */
    size_t n_mixed;   /* corners whose vertex had another normal before */
    uint64_t n_other; /* lines of points, curves and other things */
    char group[64], material[64];
    bool stale; /* group or material have changed since the last face */
    vv_notes *notes;
    vv_job *job;
} reader;

/* Rooms that double. */
static vv_status grow(void *array, size_t *room, size_t need, size_t each, const reader *r)
{
    if (need <= *room)
        return VV_OK;
    const size_t more = need + need / 2 + 256;
    const vv_status st = vvi_source_grow(r->b.source, (uint64_t)(more - *room) * each);
    if (st != VV_OK)
        return st;
    void *grown = vvi_realloc(r->job, *(void **)array, more * each, VVI_MEM_SCRATCH);
    if (!grown)
        return vv_fail_memory(more * each);
    *(void **)array = grown;
    *room = more;
    return VV_OK;
}

/* Vertices -------------------------------------------------------------------------------------------------------- */

/* Numbers of the rest of the line, at most n; how many. */
static int numbers_here(double *out, int n, vvi_words *w)
{
    size_t length;
    for (int i = 0; i < n; i++) {
        const char *end, *word = vvi_words_here(w, &length);
        if (!word || !vvi_words_number(&out[i], word, &end) || end != word + length)
            return i;
    }
    return n;
}

/* x y z, x y z w, or x y z and a colour. */
static vv_status read_vertex(reader *r)
{
    double v[7];
    const int n = numbers_here(v, 7, &r->words);
    if (n < 3)
        return vvi_words_fail(&r->words, "a vertex has %d numbers; at least 3 were expected", n);
    vv_status st = n >= 6 ? vvi_mesh_builder_with(&r->b, VVI_MESH_COLORS) : VV_OK;
    if (st != VV_OK || (st = vvi_mesh_builder_vertices(&r->b, 1)) != VV_OK)
        return st;
    const size_t i = r->b.info.n_vertices - 1;
    memcpy(r->b.places + 3 * i, v, 3 * sizeof *v);
    for (size_t c = 0; c < 3 && n >= 6; c++)
        r->b.arrays.colors[4 * i + c] = vvi_mesh_byte(v[3 + c]);
    if ((st = grow(&r->normal_of, &r->room_normal_of, i + 1, sizeof *r->normal_of, r)) == VV_OK)
        r->normal_of[i] = 0;
    return st;
}

static vv_status read_normal(reader *r)
{
    double v[3];
    if (numbers_here(v, 3, &r->words) != 3)
        return vvi_words_fail(&r->words, "a normal has fewer than 3 numbers");
    const vv_status st = grow(&r->normal, &r->room_normals, 3 * (r->n_normals + 1), sizeof *r->normal, r);
    if (st != VV_OK)
        return st;
    for (size_t a = 0; a < 3; a++)
        r->normal[3 * r->n_normals + a] = (float)v[a];
    r->n_normals++;
    return VV_OK;
}

/* u, u v or u v w. */
static vv_status read_coordinate(reader *r)
{
    double v[3] = {0, 0, 0};
    if (numbers_here(v, 3, &r->words) < 1)
        return vvi_words_fail(&r->words, "a texture coordinate has no number");
    const vv_status st = vvi_mesh_builder_with(&r->b, VVI_MESH_COORDINATES | VVI_MESH_CORNERS);
    return st == VV_OK ? vvi_mesh_builder_coordinate(&r->b, (float)v[0], (float)v[1]) : st;
}

/* Faces ----------------------------------------------------------------------------------------------------------- */

/* From 1, or backwards from the last with a sign; to from 0. */
static bool scan_index(size_t *out, const char **at, size_t n)
{
    int64_t v;
    const char *end;
    if (**at < '-' || **at > '9' || !vvi_scan_int(&v, *at, &end))
        return false;
    *at = end;
    if (v == 0 || v > (int64_t)n || v < -(int64_t)n)
        return false;
    *out = (size_t)(v > 0 ? v - 1 : (int64_t)n + v);
    return true;
}

/* Vertices with one normal keep it; others have the sum of theirs, of length 1 in the end. */
static vv_status use_normal(reader *r, size_t vertex, size_t normal)
{
    const vv_status st = vvi_mesh_builder_with(&r->b, VVI_MESH_NORMALS);
    if (st != VV_OK || r->normal_of[vertex] == normal + 1)
        return st;
    r->n_mixed += r->normal_of[vertex] != 0;
    r->normal_of[vertex] = (uint32_t)normal + 1;
    for (size_t a = 0; a < 3; a++)
        r->b.arrays.normals[3 * vertex + a] += r->normal[3 * normal + a];
    return VV_OK;
}

/* text: what stands in the place of a number of one of `there`, and what follows it. */
static vv_status fail_index(const reader *r, const char *what, const char *text, size_t n, size_t there)
{
    const char *slash = memchr(text, '/', n);
    const size_t own = slash ? (size_t)(slash - text) : n;
    return vvi_words_fail(&r->words, "a face names %s '%.*s', but %zu came before it, counted from 1", what,
                          (int)(own < 40 ? own : 40), text, there);
}

static void note_lost(reader *r, const char *word, size_t n, size_t there)
{
    if (r->n_lost++)
        return;
    r->lost.line = (unsigned long long)r->words.line;
    snprintf(r->lost.corner, sizeof r->lost.corner, "%.*s", (int)(n < 40 ? n : 40), word);
    r->lost.n = there;
}

static vv_status warn_of_lost(const reader *r)
{
    char others[64] = "";
    if (r->n_lost > 1)
        snprintf(others, sizeof others, ", as do %" PRIu64 " others", r->n_lost - 1);
    return vvi_notes_warn(r->notes,
                          "line %llu: the corner '%s' of a face names a texture coordinate (its second number) that "
                          "does not exist: %zu came before it, counted from 1; it gets the place 0 0%s",
                          r->lost.line, r->lost.corner, r->lost.n, others);
}

/* v, v/vt, v//vn or v/vt/vn. */
static vv_status read_corner(reader *r, uint32_t *out, uint32_t *coordinate, const char *word, size_t n)
{
    const char *at = word;
    const size_t n_coordinates = r->b.info.n_coordinates ? r->b.info.n_coordinates - 1 : 0; /* the first is nobody's */
    size_t vertex, normal, of;
    *coordinate = 0;
    if (!scan_index(&vertex, &at, r->b.info.n_vertices))
        return fail_index(r, "vertex", word, n, r->b.info.n_vertices);
    *out = (uint32_t)vertex;
    if (at[0] != '/')
        return at == word + n ? VV_OK : vvi_words_fail(&r->words, "'%.40s' is not a corner of a face", word);
    at++;
    if (at < word + n && *at != '/') {
        if (scan_index(&of, &at, n_coordinates))
            *coordinate = (uint32_t)of + 1;
        else
            note_lost(r, word, n, n_coordinates);
    }
    while (at < word + n && *at != '/')
        at++;
    if (at == word + n)
        return VV_OK;
    const char *third = ++at;
    if (!scan_index(&normal, &at, r->n_normals) || at != word + n)
        return fail_index(r, "normal", third, (size_t)(word + n - third), r->n_normals);
    return use_normal(r, vertex, normal);
}

/* A backslash at the end of a line goes on with the next. */
static vv_status next_corner(reader *r, const char **word, size_t *n)
{
    vv_status st = VV_OK;
    *word = vvi_words_here(&r->words, n);
    while (st == VV_OK && *n == 1 && **word == '\\') {
        const char *line;
        if ((st = vvi_words_line(&r->words, &line)) == VV_OK)
            *word = vvi_words_here(&r->words, n);
    }
    return st;
}

static vv_status use_part(reader *r)
{
    vvi_obj_material *m = vvi_obj_material_find(&r->library, r->material);
    const char *name = r->group[0] ? r->group : r->material;
    vv_color color = m ? m->color : (vv_color){.a = -1};
    size_t texture = 0;
    r->stale = false;
    if (m && m->map) {
        const vv_status st = vvi_obj_material_texture(&texture, &r->library, m, &r->b, r->notes);
        if (st != VV_OK)
            return st;
        if (texture && color.r + color.g + color.b == 0) /* some programs write that beside an image */
            color = (vv_color){1, 1, 1, color.a};
    }
    return vvi_mesh_builder_part(&r->b, name, strlen(name), color.a >= 0 ? &color : NULL, texture);
}

static vv_status read_face(reader *r)
{
    const char *word;
    size_t n, n_corners = 0;
    vv_status st = r->stale ? use_part(r) : VV_OK;
    while (st == VV_OK && (st = next_corner(r, &word, &n)) == VV_OK && n > 0) {
        if ((st = grow(&r->corner, &r->room_corner, n_corners + 1, sizeof *r->corner, r)) == VV_OK &&
            (st = grow(&r->coordinate, &r->room_coordinate, n_corners + 1, sizeof *r->coordinate, r)) == VV_OK)
            st = read_corner(r, &r->corner[n_corners], &r->coordinate[n_corners], word, n);
        n_corners++;
    }
    if (st == VV_OK && n_corners < 3)
        return vvi_words_fail(&r->words, "a face has %zu corners; at least 3 were expected", n_corners);
    if (st == VV_OK && (st = vvi_mesh_builder_polygon(&r->b, r->corner, n_corners)) == VV_OK &&
        r->b.with & VVI_MESH_CORNERS)
        vvi_mesh_builder_corners(&r->b, r->coordinate, n_corners);
    return st;
}

/* Lines ----------------------------------------------------------------------------------------------------------- */

/* The rest of the line without the blanks at its ends. False: it is longer than what is kept. */
static bool rest_of_line(char out[64], vvi_words *w)
{
    const char *text = w->at + strspn(w->at, " \t");
    size_t n = strlen(text);
    while (n > 0 && (text[n - 1] == ' ' || text[n - 1] == '\t'))
        n--;
    const size_t kept = vvi_utf8_cut(text, n, 63);
    memcpy(out, text, kept);
    out[kept] = 0;
    vvi_text_clean(out);
    return kept == n;
}

static vv_status read_library(reader *r)
{
    char name[256];
    const char *text = r->words.at + strspn(r->words.at, " \t");
    size_t n = strlen(text);
    while (n > 0 && (text[n - 1] == ' ' || text[n - 1] == '\t'))
        n--;
    if (n == 0 || n >= sizeof name)
        return vvi_notes_warn(r->notes, "names a material library in a way that is not understood");
    memcpy(name, text, n);
    name[n] = 0;
    return vvi_obj_read_library(&r->library, r->source, name, r->notes, r->job);
}

static vv_status read_line(reader *r, const char *line)
{
    char key[16] = {0};
    size_t n;
    if (*line == '#') {
        vvi_mesh_builder_comment(&r->b, line + 1);
        return VV_OK;
    }
    const char *word = vvi_words_here(&r->words, &n);
    if (!word)
        return VV_OK;
    memcpy(key, word, n < sizeof key - 1 ? n : sizeof key - 1);
    if (strcmp(key, "v") == 0)
        return read_vertex(r);
    if (strcmp(key, "vn") == 0)
        return read_normal(r);
    if (strcmp(key, "vt") == 0)
        return read_coordinate(r);
    if (strcmp(key, "f") == 0 || strcmp(key, "fo") == 0)
        return read_face(r);
    if (strcmp(key, "mtllib") == 0)
        return read_library(r);
    if (strcmp(key, "o") == 0 || strcmp(key, "g") == 0 || strcmp(key, "usemtl") == 0) {
        r->b.n_cut += !rest_of_line(key[0] == 'u' ? r->material : r->group, &r->words);
        r->stale = true;
        return VV_OK;
    }
    if (strcmp(key, "s") != 0)
        r->n_other++;
    for (size_t i = 0; i < n; i++)
        if ((unsigned char)word[i] < ' ' || (unsigned char)word[i] > 126)
            return vvi_words_fail(&r->words, "is not a line of OBJ: it has bytes that are not text");
    return VV_OK;
}

static vv_status read_lines(reader *r)
{
    const char *line;
    for (;;) {
        vv_status st = vvi_words_line(&r->words, &line);
        if (st != VV_OK)
            return st;
        if (!line)
            break;
        if ((st = read_line(r, line)) != VV_OK)
            return st;
    }
    vv_status st = VV_OK;
    if (r->n_mixed > 0)
        st = vvi_notes_warn(r->notes, "has vertices with more than one normal; the mean is used");
    if (st == VV_OK && r->n_lost > 0)
        st = warn_of_lost(r);
    if (st == VV_OK && r->n_other > 0)
        st = vvi_notes_warn(r->notes, "has %" PRIu64 " lines of points, curves and other things, which are left out",
                            r->n_other);
    return st;
}

static vv_status read_obj(vv_mesh **out, vv_source *source, const vv_mesh_read_options *options, vv_notes *notes,
                          vv_job *job)
{
    reader r = {.source = source, .notes = notes, .job = job};
    vvi_words_begin(&r.words, source, 0, job);
    vvi_mesh_builder_begin(&r.b, source, options, true, job);
    r.b.info.up = vvi_mesh_format_obj.up;
    vv_status st = read_lines(&r);
    if (st == VV_OK)
        st = vvi_mesh_builder_finish(out, &r.b, notes);
    vvi_mesh_builder_free(&r.b);
    vvi_obj_library_free(&r.library);
    vvi_free(r.normal);
    vvi_free(r.normal_of);
    vvi_free(r.corner);
    vvi_free(r.coordinate);
    return st;
}

/* No mark: the first word of the first line that is no comment. */
static int probe(const uint8_t *head, size_t n, const char *path)
{
    static const char *const words[] = {"v", "vn", "vt", "f", "o", "g", "s", "mtllib", "usemtl"};
    size_t at = 0;
    (void)path;
    while (at < n && (head[at] == '#' || strchr(" \t\r\n", head[at])) && head[at]) {
        if (head[at] == '#')
            while (at < n && head[at] != '\n')
                at++;
        else
            at++;
    }
    for (size_t i = 0; i < sizeof words / sizeof *words; i++) {
        const size_t m = strlen(words[i]);
        if (n - at > m && memcmp(head + at, words[i], m) == 0 && (head[at + m] == ' ' || head[at + m] == '\t'))
            return 1;
    }
    return 0;
}

static const char *const suffixes[] = {".obj", NULL};

const vv_mesh_format vvi_mesh_format_obj = {
    .beside = true,
    .up = VV_UP_Y,
    .api = VV_MESH_FORMAT_API,
    .name = "obj",
    .doc = "Wavefront OBJ: normals, colours, parts; part colours in a .mtl file next to it, images on triangles in "
           "others",
    .suffixes = suffixes,
    .holds = VV_MESH_HOLDS_NORMALS | VV_MESH_HOLDS_COLORS | VV_MESH_HOLDS_PARTS | VV_MESH_HOLDS_PART_COLORS |
             VV_MESH_HOLDS_UNIT | VV_MESH_HOLDS_DOUBLES | VV_MESH_HOLDS_TEXTURES,
    .probe = probe,
    .read = read_obj,
    .write = vvi_obj_write,
};
