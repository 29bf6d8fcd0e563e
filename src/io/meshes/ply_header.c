#include "core/memory.h"
#include "core/text.h"
#include "io/meshes/mesh_column.h"
#include "io/meshes/ply.h"
#include "io/scan.h"

#include <string.h>

static const struct {
    const char *name;
    vvi_ply_role role;
} vertex_roles[] = {
    {"x", VVI_PLY_X},
    {"y", VVI_PLY_Y},
    {"z", VVI_PLY_Z},
    {"nx", VVI_PLY_NX},
    {"ny", VVI_PLY_NY},
    {"nz", VVI_PLY_NZ},
    {"red", VVI_PLY_RED},
    {"green", VVI_PLY_GREEN},
    {"blue", VVI_PLY_BLUE},
    {"alpha", VVI_PLY_ALPHA},
    {"diffuse_red", VVI_PLY_RED},
    {"diffuse_green", VVI_PLY_GREEN},
    {"diffuse_blue", VVI_PLY_BLUE},
    {"r", VVI_PLY_RED},
    {"g", VVI_PLY_GREEN},
    {"b", VVI_PLY_BLUE},
    {"quality", VVI_PLY_VALUE},
    {"value", VVI_PLY_VALUE},
    {"scalar", VVI_PLY_VALUE},
    {"intensity", VVI_PLY_VALUE},
    {"s", VVI_PLY_U},
    {"t", VVI_PLY_V},
    {"u", VVI_PLY_U},
    {"v", VVI_PLY_V},
    {"texture_u", VVI_PLY_U},
    {"texture_v", VVI_PLY_V},
    {"texture_s", VVI_PLY_U},
    {"texture_t", VVI_PLY_V},
};

static const struct {
    const char *name;
    vvi_ply_role role;
} face_roles[] = {
    {"vertex_indices", VVI_PLY_CORNERS},
    {"vertex_index", VVI_PLY_CORNERS},
    {"red", VVI_PLY_RED},
    {"green", VVI_PLY_GREEN},
    {"blue", VVI_PLY_BLUE},
    {"alpha", VVI_PLY_ALPHA},
    {"part", VVI_PLY_PART},
    {"texcoord", VVI_PLY_COORDINATES},
    {"texnumber", VVI_PLY_TEXTURE},
};

static bool is_list(vvi_ply_role role)
{
    return role == VVI_PLY_CORNERS || role == VVI_PLY_COORDINATES;
}

static vvi_ply_role role_of(vvi_ply_kind kind, const char *name, bool list)
{
    for (size_t i = 0; kind == VVI_PLY_VERTEX && !list && i < sizeof vertex_roles / sizeof *vertex_roles; i++)
        if (strcmp(vertex_roles[i].name, name) == 0)
            return vertex_roles[i].role;
    for (size_t i = 0; kind == VVI_PLY_FACE || kind == VVI_PLY_STRIPS; i++) {
        if (i == sizeof face_roles / sizeof *face_roles)
            break;
        if (strcmp(face_roles[i].name, name) == 0 && list == is_list(face_roles[i].role))
            return face_roles[i].role;
    }
    return kind == VVI_PLY_VERTEX && !list && strncmp(name, "scalar_", 7) == 0 ? VVI_PLY_VALUE : VVI_PLY_NOTHING;
}

static vvi_ply_kind kind_of(const char *name)
{
    return strcmp(name, "vertex") == 0      ? VVI_PLY_VERTEX
           : strcmp(name, "face") == 0      ? VVI_PLY_FACE
           : strcmp(name, "tristrips") == 0 ? VVI_PLY_STRIPS
                                            : VVI_PLY_OTHER;
}

const vvi_ply_property *vvi_ply_find(const vvi_ply_element *e, vvi_ply_role role)
{
    for (size_t i = 0; i < e->n_properties; i++)
        if (e->property[i].role == role)
            return &e->property[i];
    return NULL;
}

/* The next word of the line, cut to what there is room for; "" at its end. */
static void word_here(char out[64], vvi_words *w)
{
    size_t n;
    const char *word = vvi_words_here(w, &n);
    n = n < 63 ? n : 63;
    if (n > 0)
        memcpy(out, word, n);
    out[n] = 0;
}

static vv_status read_format(vvi_ply *ply, vvi_words *w)
{
    char name[64];
    word_here(name, w);
    const bool big = strcmp(name, "binary_big_endian") == 0;
    ply->ascii = strcmp(name, "ascii") == 0;
    ply->swapped = big != vvi_machine_is_big();
    if (!ply->ascii && !big && strcmp(name, "binary_little_endian") != 0)
        return vvi_words_fail(w, "the format is '%s'; expected ascii, binary_little_endian or binary_big_endian", name);
    return VV_OK;
}

static vv_status read_element(vvi_ply *ply, vvi_words *w)
{
    char count[64];
    const char *end;
    if (ply->n_elements == VVI_PLY_ELEMENTS_MOST)
        return vvi_words_fail(w, "has more than %d kinds of elements", VVI_PLY_ELEMENTS_MOST);
    vvi_ply_element *e = &ply->element[ply->n_elements++];
    *e = (vvi_ply_element){.fixed = true};
    word_here(e->name, w);
    word_here(count, w);
    if (!vvi_scan_uint(&e->n, count, &end) || *end)
        return vvi_words_fail(w, "found '%.40s' where the number of elements '%.40s' was expected", count, e->name);
    e->kind = kind_of(e->name);
    for (size_t i = 0; i + 1 < ply->n_elements; i++)
        if (e->kind != VVI_PLY_OTHER && ply->element[i].kind == e->kind)
            return vvi_words_fail(w, "has a second element '%.40s'", e->name);
    return VV_OK;
}

static vv_status read_type(vv_type *out, vvi_words *w)
{
    char name[64];
    word_here(name, w);
    if (!vv_type_parse(out, name))
        return vvi_words_fail(
            w, "there is no type '%.40s'; expected char, uchar, short, ushort, int, uint, float or double", name);
    return VV_OK;
}

static void copy_text(char *out, size_t room, const char *text)
{
    const size_t n = vvi_utf8_cut(text, strlen(text), room - 1);
    memcpy(out, text, n);
    out[n] = 0;
    vvi_text_clean(out);
}

/* After their property, where that says more than that they are values and no comment did. */
static void name_values(vvi_mesh_builder *b, const char *property)
{
    const char *name = strncmp(property, "scalar_", 7) == 0 ? property + 7 : property;
    const bool says = strcmp(name, "value") != 0 && strcmp(name, "scalar") != 0 && strcmp(name, "quality") != 0;
    if (says && !b->info.value_name[0])
        copy_text(b->info.value_name, sizeof b->info.value_name, name);
}

static vv_status read_property(vvi_ply *ply, vvi_words *w, vvi_mesh_builder *b)
{
    char name[64];
    if (ply->n_elements == 0)
        return vvi_words_fail(w, "has a property before the first element");
    vvi_ply_element *e = &ply->element[ply->n_elements - 1];
    if (e->n_properties == VVI_PLY_PROPERTIES_MOST)
        return vvi_words_fail(w, "has more than %d properties of '%.40s'", VVI_PLY_PROPERTIES_MOST, e->name);
    vvi_ply_property p = {.offset = e->bytes};
    const char *before = w->at;
    word_here(name, w);
    p.list = strcmp(name, "list") == 0;
    if (!p.list)
        w->at = before;
    vv_status st = p.list ? read_type(&p.count_type, w) : VV_OK;
    if (st != VV_OK || (st = read_type(&p.type, w)) != VV_OK)
        return st;
    if (p.list && vv_type_is_float(p.count_type))
        return vvi_words_fail(w, "the number of items of a list is not a whole number");
    word_here(name, w);
    p.role = role_of(e->kind, name, p.list);
    if (vvi_ply_find(e, p.role))
        p.role = VVI_PLY_NOTHING; /* the first of its meaning counts */
    if (p.role == VVI_PLY_VALUE)
        name_values(b, name);
    e->bytes += vv_type_bytes(p.list ? p.count_type : p.type);
    e->fixed = e->fixed && !p.list;
    e->property[e->n_properties++] = p;
    return VV_OK;
}

/* "part: skin", with or without the colon; what follows, else NULL. */
static const char *after_key(const char *text, const char *key)
{
    const size_t n = strlen(key);
    if (strncmp(text, key, n) != 0 || (text[n] != ':' && text[n] != ' '))
        return NULL;
    text += n + 1;
    return text + strspn(text, " \t");
}

/* What VolVis says of a mesh stands in comments; others are kept as metadata. */
static vv_status read_comment(vvi_ply *ply, const char *text, vvi_mesh_builder *b, vv_notes *notes)
{
    const char *value;
    text += strspn(text, " \t");
    if (vvi_mesh_builder_comment(b, text))
        return VV_OK;
    if ((value = after_key(text, "value_name"))) {
        copy_text(b->info.value_name, sizeof b->info.value_name, value);
    } else if ((value = after_key(text, "value_unit"))) {
        copy_text(b->info.value_unit, sizeof b->info.value_unit, value);
    } else if ((value = after_key(text, "part")) || strcmp(text, "part:") == 0) {
        ply->n_part_names++;
        return vvi_mesh_builder_new_part(b, value ? value : "", value ? strlen(value) : 0, NULL, 0);
    } else if ((value = after_key(text, "TextureFile")) && ply->n_textures < VVI_PLY_TEXTURES_MOST) {
        char *name = ply->texture[ply->n_textures++] = vvi_strdup(value);
        if (!name)
            return vv_fail_memory(strlen(value));
        for (size_t n = strlen(name); n > 0 && (name[n - 1] == ' ' || name[n - 1] == '\t'); n--)
            name[n - 1] = 0;
    } else {
        return vvi_notes_add(notes, "comment", text);
    }
    return VV_OK;
}

static vv_status read_line(vvi_ply *ply, vvi_words *w, vvi_mesh_builder *b, vv_notes *notes, bool *done)
{
    char key[64];
    word_here(key, w);
    *done = strcmp(key, "end_header") == 0;
    if (*done || key[0] == 0)
        return VV_OK;
    if (strcmp(key, "format") == 0)
        return read_format(ply, w);
    if (strcmp(key, "element") == 0)
        return read_element(ply, w);
    if (strcmp(key, "property") == 0)
        return read_property(ply, w, b);
    if (strcmp(key, "comment") == 0 || strcmp(key, "obj_info") == 0)
        return read_comment(ply, w->at, b, notes);
    return vvi_words_fail(w, "'%.40s' is not a line of a PLY header; expected element, property, comment or end_header",
                          key);
}

static vv_status check_elements(const vvi_ply *ply, vvi_words *w)
{
    const vvi_ply_element *vertex = NULL, *face = NULL;
    for (size_t i = 0; i < ply->n_elements; i++) {
        vertex = ply->element[i].kind == VVI_PLY_VERTEX ? &ply->element[i] : vertex;
        face = ply->element[i].kind == VVI_PLY_FACE || ply->element[i].kind == VVI_PLY_STRIPS ? &ply->element[i] : face;
    }
    if (!vertex || !vvi_ply_find(vertex, VVI_PLY_X) || !vvi_ply_find(vertex, VVI_PLY_Y) ||
        !vvi_ply_find(vertex, VVI_PLY_Z))
        return vvi_words_fail(w, "the header ends without an element 'vertex' that has x, y and z");
    if (face && !vvi_ply_find(face, VVI_PLY_CORNERS))
        return vvi_words_fail(w, "the element '%.40s' has no list 'vertex_indices'", face->name);
    return VV_OK;
}

vv_status vvi_ply_read_header(vvi_ply *out, vvi_words *w, vvi_mesh_builder *b, vv_notes *notes)
{
    const char *line;
    bool done = false;
    vv_status st = vvi_words_line(w, &line);
    *out = (vvi_ply){.ascii = true};
    if (st == VV_OK && (!line || strcmp(line, "ply") != 0))
        return vvi_words_fail(w, "the first line is not 'ply'");
    while (st == VV_OK && !done) {
        if ((st = vvi_words_line(w, &line)) != VV_OK)
            return st;
        if (!line)
            return vvi_words_fail(w, "ends inside the header; the file is cut short");
        if (vvi_source_tell(w->source) > vvi_source_limits(w->source)->header_bytes)
            return vvi_words_fail(
                w, "the header has no end; this is not a PLY file, or --limit header_bytes=N allows more");
        st = read_line(out, w, b, notes, &done);
    }
    return st == VV_OK ? check_elements(out, w) : st;
}
