#include "core/kept_maps.h"
#include "core/os.h"

static void *remove_nth(vvi_kept_maps *kept, int i)
{
    void *memory = kept->map[i].memory;
    kept->bytes -= kept->map[i].bytes;
    kept->map[i] = kept->map[--kept->n];
    return memory;
}

static void drop(vvi_kept_maps *kept)
{
    while (kept->n > 0) {
        const size_t bytes = kept->map[kept->n - 1].bytes;
        vvi_os_unmap(remove_nth(kept, kept->n - 1), bytes);
    }
}

static uint64_t difference(size_t a, size_t b)
{
    return a > b ? a - b : b - a;
}

/* The one of the nearest size within a factor of 2. -1: none. */
static int nearest(const vvi_kept_maps *kept, size_t bytes)
{
    int best = -1;
    for (int i = 0; i < kept->n; i++) {
        const size_t has = kept->map[i].bytes;
        if (has / 2 <= bytes && bytes / 2 <= has &&
            (best < 0 || difference(has, bytes) < difference(kept->map[best].bytes, bytes)))
            best = i;
    }
    return best;
}

void *vvi_kept_take(vvi_kept_maps *kept, size_t bytes, uint64_t room)
{
    void *memory = NULL;
    pthread_mutex_lock(&kept->lock);
    const int i = nearest(kept, bytes);
    if (i >= 0) {
        const size_t has = kept->map[i].bytes;
        void *old = remove_nth(kept, i);
        memory = has == bytes ? old : vvi_os_remap(old, has, bytes);
        if (!memory)
            vvi_os_unmap(old, has);
    }
    if (!memory || kept->bytes > room)
        drop(kept);
    pthread_mutex_unlock(&kept->lock);
    return memory;
}

void vvi_kept_give(vvi_kept_maps *kept, void *memory, size_t bytes, uint64_t room)
{
    pthread_mutex_lock(&kept->lock);
    const bool keep = kept->n < VVI_KEPT_MAPS && bytes <= room && kept->bytes <= room - bytes;
    if (keep) {
        kept->map[kept->n++] = (struct vvi_kept_map){memory, bytes};
        kept->bytes += bytes;
    }
    pthread_mutex_unlock(&kept->lock);
    if (!keep)
        vvi_os_unmap(memory, bytes);
}

void vvi_kept_drop(vvi_kept_maps *kept)
{
    pthread_mutex_lock(&kept->lock);
    drop(kept);
    pthread_mutex_unlock(&kept->lock);
}
