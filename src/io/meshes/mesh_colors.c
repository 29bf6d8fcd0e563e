#include "io/meshes/mesh_colors.h"
#include "core/memory.h"

#include <math.h>
#include <string.h>
#include <volvis/image.h>

enum { SLOTS = 4 * VVI_FACE_COLORS_MOST };

uint8_t vvi_mesh_byte(double v)
{
    return (uint8_t)(v >= 1 ? 255 : v > 0 ? v * 255 + 0.5 : 0);
}

void vvi_mesh_bytes_of(uint8_t out[4], const vv_color *color)
{
    for (int c = 0; c < 3; c++)
        out[c] = vvi_mesh_byte(vv_srgb_encode(fmin(fmax((&color->r)[c], 0), 1)));
    out[3] = vvi_mesh_byte(color->a);
}

vv_color vvi_mesh_color_of(const uint8_t bytes[4])
{
    return (vv_color){vv_srgb_decode(bytes[0] / 255.0), vv_srgb_decode(bytes[1] / 255.0),
                      vv_srgb_decode(bytes[2] / 255.0), bytes[3] / 255.0};
}

static vv_status begin(vvi_face_colors *colors, vv_job *job)
{
    const size_t bytes = (SLOTS + VVI_FACE_COLORS_MOST + 1) * sizeof *colors->slot;
    colors->slot = vvi_alloc_zeroed(job, bytes, VVI_MEM_SCRATCH);
    if (!colors->slot)
        return vv_fail_memory(bytes);
    colors->colors = colors->slot + SLOTS;
    return VV_OK;
}

static vv_status add(vvi_face_colors *colors, size_t slot, vvi_mesh_builder *b, const uint8_t *bytes, uint32_t key)
{
    if (colors->n == VVI_FACE_COLORS_MOST) {
        colors->full = true;
        return VV_OK;
    }
    vv_color color;
    if (bytes)
        color = vvi_mesh_color_of(bytes);
    colors->colors[colors->n++] = key;
    colors->slot[slot] = (uint32_t)colors->n;
    return vvi_mesh_builder_new_part(b, "", 0, bytes ? &color : NULL, 0);
}

vv_status vvi_face_colors_use(vvi_face_colors *colors, vvi_mesh_builder *b, const uint8_t *bytes)
{
    uint32_t key = 0; /* no colour is one that cannot be seen */
    if (bytes)
        memcpy(&key, bytes, sizeof key);
    if (colors->full || (colors->n > 0 && key == colors->last))
        return VV_OK;
    vv_status st = colors->slot ? VV_OK : begin(colors, b->job);
    if (st != VV_OK)
        return st;
    size_t slot = (key * UINT32_C(2654435761)) >> 18;
    while (colors->slot[slot] && colors->colors[colors->slot[slot] - 1] != key)
        slot = (slot + 1) % SLOTS;
    if (!colors->slot[slot])
        st = add(colors, slot, b, bytes, key);
    if (!colors->full && st == VV_OK) {
        b->part = colors->slot[slot] - 1;
        colors->last = key;
    }
    return st;
}

void vvi_face_colors_free(vvi_face_colors *colors)
{
    vvi_free(colors->slot);
    *colors = (vvi_face_colors){0};
}

vv_status vvi_face_colors_finish(vvi_face_colors *colors, vvi_mesh_builder *b, vv_notes *notes)
{
    vv_status st = VV_OK;
    if (colors->full) {
        st = vvi_notes_warn(notes, "its faces have more than %d colours, which are left out", VVI_FACE_COLORS_MOST);
        vvi_free(b->arrays.parts);
        vvi_free(b->part_of);
        b->arrays.parts = NULL;
        b->part_of = NULL;
        b->info.n_parts = b->room_parts = 0;
    }
    vvi_face_colors_free(colors);
    return st;
}

bool vvi_mesh_face_color(uint8_t out[4], const vv_mesh_info *m, size_t triangle, const vv_mesh_part *part)
{
    if (!m->colors) {
        if (part && part->color.a >= 0)
            vvi_mesh_bytes_of(out, &part->color);
        return part && part->color.a >= 0;
    }
    for (size_t c = 0; c < 4; c++) {
        unsigned sum = 1;
        for (size_t i = 0; i < 3; i++)
            sum += m->colors[4 * (size_t)m->triangles[3 * triangle + i] + c];
        out[c] = (uint8_t)(sum / 3);
    }
    return true;
}
