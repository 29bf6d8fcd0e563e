/* Material libraries of OBJ: of a material, its diffuse colour (Kd, taken for sRGB as other programs do) and its
 * opacity (d, or 1 - Tr). */
#include "core/memory.h"
#include "core/text.h"
#include "io/meshes/mesh_colors.h"
#include "io/meshes/obj.h"
#include "io/scan.h"

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
    if (st == VV_OK)
        st = read_lines(l, library, job);
    vvi_source_close(library);
    return st;
}

const vvi_obj_material *vvi_obj_material_find(const vvi_obj_library *l, const char *name)
{
    for (size_t i = l->n; i > 0; i--)
        if (strncmp(l->material[i - 1].name, name, sizeof l->material->name - 1) == 0)
            return &l->material[i - 1];
    return NULL;
}

void vvi_obj_library_free(vvi_obj_library *l)
{
    vvi_free(l->material);
    *l = (vvi_obj_library){0};
}
