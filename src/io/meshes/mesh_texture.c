#include "io/meshes/mesh_texture.h"
#include "core/job.h"
#include "core/memory.h"
#include "core/text.h"
#include "io/image_source.h"
#include "io/images/image_codes.h"
#include "io/images/png.h"
#include "io/scan.h"
#include "io/sink.h"

#include <stdlib.h>
#include <string.h>

enum { TEXTURES_MOST = 4096 };

/* Reading --------------------------------------------------------------------------------------------------------- */

/* Bytes as meshes have them, of one alpha or of its own. */
static void put_pixels(uint8_t *out, const vv_image *image, const vvi_texture_use *use)
{
    vvi_srgb_table table;
    vvi_srgb_table_init(&table);
    const vvi_codes codes = {.image = image, .channels = 4, .apart = true, .bits = 8, .table = &table};
    for (int32_t y = 0; y < image->height; y++, out += vvi_codes_row_bytes(&codes)) {
        vvi_codes_row(out, &codes, y);
        for (size_t x = 0; x < (size_t)image->width && use->alpha != VVI_TEXTURE_BLEND; x++) {
            uint8_t *a = &out[4 * x + 3];
            *a = use->alpha == VVI_TEXTURE_OPAQUE || *a >= 255 * use->cutoff ? 255 : 0;
        }
    }
}

static vv_status add(size_t *out, vvi_mesh_builder *b, const vv_image *image, const char *name,
                     const vvi_texture_use *use)
{
    vv_mesh_texture t = {.width = image->width, .height = image->height, .wrap = {use->wrap[0], use->wrap[1]}};
    const char *slash = strrchr(name, '/');
    size_t bytes, n;
    vv_status st = vvi_mul3_size(&bytes, (size_t)image->width, (size_t)image->height, 4);
    if (st != VV_OK)
        return st;
    name = slash ? slash + 1 : name;
    memcpy(t.name, name, vvi_utf8_cut(name, strlen(name), sizeof t.name - 1));
    vvi_text_clean(t.name);
    uint8_t *pixels = vvi_alloc(b->job, bytes, VVI_MEM_DERIVED);
    if (!pixels)
        return vv_fail_memory(bytes);
    put_pixels(pixels, image, use);
    t.pixels = pixels;
    if ((st = vvi_mesh_textures_add(&b->arrays.textures, &t, b->job)) != VV_OK) {
        vvi_free(pixels);
        return st;
    }
    vvi_mesh_textures_get(&n, b->arrays.textures);
    *out = n;
    return VV_OK;
}

static vv_status leave_out(const char *name, vv_notes *notes)
{
    return vvi_notes_warn(notes, "the image '%.100s' on its triangles is left out: %.300s", *name ? name : "(no name)",
                          vv_error_last()->message);
}

vv_status vvi_mesh_texture_read(size_t *out, vvi_mesh_builder *b, vv_source *source, const char *name,
                                const vvi_texture_use *use, vv_notes *notes)
{
    vv_image *image = NULL;
    size_t n;
    *out = 0;
    vvi_mesh_textures_get(&n, b->arrays.textures);
    if (n == TEXTURES_MOST)
        return vvi_notes_warn(notes, "has more than %d images on its triangles; '%.100s' is left out", TEXTURES_MOST,
                              name);
    vv_status st = vvi_image_read_straight(&image, source, b->job);
    if (st == VV_E_FORMAT || st == VV_E_UNSUPPORTED)
        return leave_out(name, notes);
    if (st == VV_OK)
        st = add(out, b, image, name, use);
    vv_image_release(image);
    return st;
}

vv_status vvi_mesh_texture_find(size_t *out, vvi_mesh_builder *b, const char *name, const vvi_texture_use *use,
                                vv_notes *notes)
{
    char local[1024];
    vv_source *source = NULL;
    size_t n = strlen(name);
    *out = 0;
    if (n == 0 || n >= sizeof local)
        return vvi_notes_warn(notes, "names an image on its triangles in a way that is not understood");
    for (size_t i = 0; i <= n; i++)
        local[i] = (char)(name[i] == '\\' ? '/' : name[i]);
    const char *slash = strrchr(local, '/');
    vv_status st = vvi_source_find_beside(&source, b->source, local, b->job);
    const bool refused = st == VV_E_READ;
    if (slash && ((st == VV_OK && !source) || refused))
        st = vvi_source_find_beside(&source, b->source, slash + 1, b->job);
    if (st == VV_OK && !source && refused) /* it may well be there: say why it was not taken */
        st = vvi_source_find_beside(&source, b->source, local, b->job);
    if (st == VV_E_READ || st == VV_E_UNSUPPORTED)
        return leave_out(name, notes);
    if (st != VV_OK)
        return st;
    if (!source)
        return vvi_notes_warn(notes, "the image '%.100s' on its triangles does not exist; it is left out", name);
    st = vvi_mesh_texture_read(out, b, source, local, use, notes);
    vvi_source_close(source);
    return st;
}

/* Writing --------------------------------------------------------------------------------------------------------- */

vv_status vvi_mesh_texture_encode(uint8_t **out, size_t *n_out, const vv_mesh_texture *t, vv_job *job)
{
    vv_image *image;
    vv_sink *sink = NULL;
    *out = NULL;
    vv_status st = vv_image_new(&image, t->width, t->height, 0, job);
    const size_t n = (size_t)t->width * (size_t)t->height;
    float light[256];
    if (st != VV_OK)
        return st;
    for (int i = 0; i < 256; i++)
        light[i] = (float)vv_srgb_decode(i / 255.0);
    for (size_t i = 0; i < n; i++) {
        const uint8_t *p = t->pixels + 4 * i;
        for (size_t c = 0; c < 3; c++)
            image->rgba[4 * i + c] = light[p[c]];
        image->rgba[4 * i + 3] = (float)p[3] / 255;
    }
    st = vvi_sink_open_memory(&sink, "image.png", job);
    if (st == VV_OK && (st = vvi_png_write_straight(sink, image, job)) == VV_OK)
        st = vvi_sink_take(out, n_out, sink);
    else if (sink)
        vvi_sink_abandon(sink);
    vv_image_release(image);
    return st;
}

/* "folder/a.obj" -> "a_obj_0.png", of letters that no format would have to escape; another one than that of a.ply. */
char *vvi_mesh_texture_name(const vv_sink *sink, size_t index)
{
    const char *path = vvi_sink_name(sink), *slash = strrchr(path, '/'), *name = slash ? slash + 1 : path;
    char *out = vvi_asprintf("%s_%zu.png", name, index);
    const size_t n = strlen(name);
    for (size_t i = 0; out && out[i]; i++)
        if ((i < n && out[i] == '.') || strchr(" %#?\"\\", out[i]) || (unsigned char)out[i] < ' ')
            out[i] = '_';
    return out;
}

void vvi_mesh_texture_warn(const vv_sink *sink, const vv_mesh_info *m, bool clamp, const char *format,
                           const vv_job *job)
{
    for (size_t i = 0; i < m->n_textures; i++) {
        const int *wrap = m->textures[i].wrap;
        const bool held = (wrap[0] == VV_WRAP_REPEAT && wrap[1] == VV_WRAP_REPEAT) ||
                          (clamp && wrap[0] == VV_WRAP_CLAMP && wrap[1] == VV_WRAP_CLAMP);
        if (!held)
            vvi_log(job, VV_LOG_WARNING, "io",
                    "%s: image %zu is %s beyond its borders, which %s cannot say: it repeats", vvi_sink_name(sink), i,
                    wrap[0] == VV_WRAP_MIRROR ? "mirrored" : "continued", format);
    }
}

vv_status vvi_mesh_texture_write(vv_sink *sink, const vv_mesh_info *m, size_t index, vv_job *job)
{
    vv_sink *beside = NULL; /* belongs to `sink` */
    uint8_t *bytes = NULL;
    size_t n = 0;
    char *name = vvi_mesh_texture_name(sink, index);
    vv_status st = name ? vvi_sink_beside(&beside, sink, name) : vv_fail_memory(64);
    free(name);
    if (st == VV_OK && (st = vvi_mesh_texture_encode(&bytes, &n, &m->textures[index], job)) == VV_OK)
        st = vvi_sink_write(beside, bytes, n);
    vv_image_bytes_free(bytes);
    return st;
}
