/* Images that meshes and their copies share. */
#include "core/memory.h"
#include "grid/mesh.h"

#include <stdatomic.h>
#include <string.h>

struct vvi_mesh_textures {
    atomic_int references;
    vv_mesh_texture *texture;
    size_t n;
};

vv_status vvi_mesh_textures_add(vvi_mesh_textures **inout, const vv_mesh_texture *texture, vv_job *job)
{
    vvi_mesh_textures *all = *inout;
    if (!all) {
        if (!(all = vvi_alloc_zeroed(job, sizeof *all, VVI_MEM_DERIVED)))
            return vv_fail_memory(sizeof *all);
        atomic_init(&all->references, 1);
        *inout = all;
    }
    const size_t bytes = (all->n + 1) * sizeof *all->texture;
    vv_mesh_texture *more = vvi_realloc(job, all->texture, bytes, VVI_MEM_DERIVED);
    if (!more)
        return vv_fail_memory(bytes);
    all->texture = more;
    more[all->n++] = *texture;
    return VV_OK;
}

const vv_mesh_texture *vvi_mesh_textures_get(size_t *n_out, const vvi_mesh_textures *textures)
{
    *n_out = textures ? textures->n : 0;
    return *n_out ? textures->texture : NULL;
}

vvi_mesh_textures *vvi_mesh_textures_retain(vvi_mesh_textures *textures)
{
    if (textures)
        atomic_fetch_add_explicit(&textures->references, 1, memory_order_relaxed);
    return textures;
}

void vvi_mesh_textures_release(vvi_mesh_textures *textures)
{
    if (!textures || atomic_fetch_sub_explicit(&textures->references, 1, memory_order_acq_rel) != 1)
        return;
    for (size_t i = 0; i < textures->n; i++)
        vvi_free((void *)(uintptr_t)textures->texture[i].pixels);
    vvi_free(textures->texture);
    vvi_free(textures);
}

vv_status vvi_mesh_textures_copy(vvi_mesh_textures **out, const vv_mesh_info *m, vv_job *job)
{
    *out = NULL;
    vv_status st = VV_OK;
    for (size_t i = 0; i < m->n_textures && st == VV_OK; i++) {
        vv_mesh_texture t = m->textures[i];
        size_t bytes;
        if ((st = vvi_mul3_size(&bytes, (size_t)t.width, (size_t)t.height, 4)) != VV_OK)
            return st;
        uint8_t *pixels = vvi_alloc(job, bytes, VVI_MEM_DERIVED);
        if (!pixels)
            return vv_fail_memory(bytes);
        memcpy(pixels, t.pixels, bytes);
        t.pixels = pixels;
        if ((st = vvi_mesh_textures_add(out, &t, job)) != VV_OK)
            vvi_free(pixels);
    }
    return st;
}
