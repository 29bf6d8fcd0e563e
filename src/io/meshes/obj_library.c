/* Material libraries of OBJ: of a material, its diffuse colour (Kd, taken for sRGB as other programs do), its opacity
 * (d, or 1 - Tr), and the image of its colours (map_Kd), by which Kd is multiplied. */
#include "core/memory.h"
#include "core/text.h"
#include "io/meshes/mesh_colors.h"
#include "io/meshes/mesh_texture.h"
#include "io/meshes/obj.h"
#include "io/scan.h"

#include <stdlib.h>
#include <string.h>

enum { MATERIALS_MOST = 65536 };

static vv_status add_material(vvi_obj_library *l, const char *name, vv_job *job)
{
    if (l->n == MATERIALS_MOST)
        return VV_OK;
    if (l->n == l->room) {
        const size_t room = 2 * l->room + 16;
        vvi_obj_material *grown = vvi_realloc(job, l->material, room * sizeof *grown, VVI_MEM_SCRATCH);
        if (!grown)
            return vv_fail_memory(room * sizeof *grown);
        l->material = grown;
        l->room = room;
    }
    vvi_obj_material *m = &l->material[l->n++];
    *m = (vvi_obj_material){.color = {0, 0, 0, -1}};
    memcpy(m->name, name, vvi_utf8_cut(name, strlen(name), sizeof m->name - 1));
    return VV_OK;
}

static bool key_is(const char *word, size_t n, const char *key)
{
    return word && n == strlen(key) && memcmp(word, key, n) == 0;
}

static bool numbers(double *out, int n, vvi_words *w)
{
    size_t length;
    for (int i = 0; i < n; i++) {
        const char *end, *word = vvi_words_here(w, &length);
        if (!word || !vvi_words_number(&out[i], word, &end) || end != word + length || !(out[i] >= 0 && out[i] <= 1))
            return false;
    }
    return true;
}

/* How many words follow an option of an image; of some fewer may, those that are numbers. -1: it is none. */
static int words_after(const char *word, size_t n, bool *fewer)
{
    static const struct {
        const char *key;
        int words;
    } options[] = {{"-blendu", 1},  {"-blendv", 1}, {"-bm", 1}, {"-boost", 1}, {"-cc", 1}, {"-clamp", 1},
                   {"-imfchan", 1}, {"-mm", 2},     {"-o", 3},  {"-s", 3},     {"-t", 3},  {"-texres", 1}};
    for (size_t i = 0; i < sizeof options / sizeof *options; i++)
        if (key_is(word, n, options[i].key)) {
            *fewer = options[i].words == 3;
            return options[i].words;
        }
    return -1;
}

/* What follows the options, blanks in it and all: yours to free(). */
static vv_status read_map(char **out, vvi_obj_material *m, const vvi_obj_library *l, vvi_words *w)
{
    const char *name = w->at + strspn(w->at, " \t");
    size_t n;
    for (const char *word = vvi_words_here(w, &n); word && *word == '-'; word = vvi_words_here(w, &n)) {
        bool fewer = false;
        const int words = words_after(word, n, &fewer);
        const bool clamp = key_is(word, n, "-clamp");
        m->moved |= key_is(word, n, "-o") || key_is(word, n, "-s");
        if (words < 0)
            break;
        for (int i = 0; i < words; i++) {
            const char *before = w->at, *end;
            double number;
            word = vvi_words_here(w, &n);
            if (fewer && word && !(vvi_words_number(&number, word, &end) && end == word + n)) {
                w->at = before;
                break;
            }
            m->clamp |= clamp && key_is(word, n, "on");
        }
        name = w->at + strspn(w->at, " \t");
    }
    n = strlen(name);
    while (n > 0 && (name[n - 1] == ' ' || name[n - 1] == '\t'))
        n--;
    free(*out);
    *out = vvi_asprintf("%.*s%.*s", (int)l->n_folder, l->folder ? l->folder : "", (int)(n < 512 ? n : 512), name);
    return *out ? VV_OK : vv_fail_memory(n + 1);
}

/* What is not understood is passed over: it says how things shine. */
static vv_status read_line(vvi_obj_library *l, vvi_words *w, vv_job *job)
{
    double v[3];
    size_t n;
    const char *word = vvi_words_here(w, &n);
    vvi_obj_material *m = l->n ? &l->material[l->n - 1] : NULL;
    if (key_is(word, n, "newmtl"))
        return add_material(l, w->at + strspn(w->at, " \t"), job);
    if (m && key_is(word, n, "Kd") && numbers(v, 3, w)) {
        const uint8_t bytes[4] = {vvi_mesh_byte(v[0]), vvi_mesh_byte(v[1]), vvi_mesh_byte(v[2]), 255};
        const double alpha = m->color.a;
        m->color = vvi_mesh_color_of(bytes);
        m->color.a = alpha >= 0 ? alpha : 1;
    } else if (m && key_is(word, n, "d") && numbers(v, 1, w)) {
        m->color.a = v[0];
    } else if (m && key_is(word, n, "Tr") && numbers(v, 1, w)) {
        m->color.a = 1 - v[0];
    } else if (m && key_is(word, n, "map_Kd")) {
        return read_map(&m->map, m, l, w);
    } else if (m && key_is(word, n, "map_d")) {
        vvi_obj_material unused = {0};
        return read_map(&m->opacity, &unused, l, w);
    }
    return VV_OK;
}

static vv_status read_lines(vvi_obj_library *l, vv_source *source, vv_job *job)
{
    vvi_words words;
    const char *line;
    vvi_words_begin(&words, source, '#', job);
    for (;;) {
        vv_status st = vvi_words_line(&words, &line);
        if (st != VV_OK || !line)
            return st;
        if ((st = read_line(l, &words, job)) != VV_OK)
            return st;
    }
}

vv_status vvi_obj_read_library(vvi_obj_library *l, vv_source *source, const char *name, vv_notes *notes, vv_job *job)
{
    vv_source *library = NULL;
    vv_status st = vvi_source_find_beside(&library, source, name, job);
    if (st == VV_E_READ || st == VV_E_UNSUPPORTED)
        return vvi_notes_warn(notes, "colours of its parts are left out: %.300s", vv_error_last()->message);
    if (st == VV_OK && !library)
        return vvi_notes_warn(notes, "its material library '%.200s' does not exist; part colours are left out", name);
    const char *slash = strrchr(name, '/');
    l->folder = name;
    l->n_folder = slash ? (size_t)(slash + 1 - name) : 0;
    if (st == VV_OK)
        st = read_lines(l, library, job);
    l->folder = NULL;
    l->n_folder = 0;
    vvi_source_close(library);
    return st;
}

vv_status vvi_obj_material_texture(size_t *out, vvi_obj_library *l, vvi_obj_material *m, vvi_mesh_builder *b,
                                   vv_notes *notes)
{
    const bool blend = m->map && m->opacity && strcmp(m->map, m->opacity) == 0;
    const vv_texture_wrap wrap = m->clamp ? VV_WRAP_CLAMP : VV_WRAP_REPEAT;
    const vvi_texture_use use = {{wrap, wrap}, blend ? VVI_TEXTURE_BLEND : VVI_TEXTURE_OPAQUE, 0};
    vv_status st = VV_OK;
    for (size_t i = 0; i < l->n && m->map && !m->looked_for; i++) {
        const vvi_obj_material *o = &l->material[i];
        const bool other_blend = o->map && o->opacity && strcmp(o->map, o->opacity) == 0;
        if (!o->looked_for || !o->map || strcmp(o->map, m->map) != 0 || o->clamp != m->clamp || other_blend != blend)
            continue;
        m->looked_for = true;
        m->texture = o->texture;
    }
    if (m->map && !m->looked_for) {
        m->looked_for = true;
        st = vvi_mesh_texture_find(&m->texture, b, m->map, &use, notes);
        if (st == VV_OK && m->moved)
            st = vvi_notes_warn(notes, "the image '%.100s' is scaled or shifted (-s, -o), which is left out", m->map);
    }
    *out = m->texture;
    return st;
}

vvi_obj_material *vvi_obj_material_find(const vvi_obj_library *l, const char *name)
{
    for (size_t i = l->n; i > 0; i--)
        if (strncmp(l->material[i - 1].name, name, sizeof l->material->name - 1) == 0)
            return &l->material[i - 1];
    return NULL;
}

void vvi_obj_library_free(vvi_obj_library *l)
{
    for (size_t i = 0; i < l->n; i++) {
        free(l->material[i].map);
        free(l->material[i].opacity);
    }
    vvi_free(l->material);
    *l = (vvi_obj_library){0};
}
