#include "server/painter_shelf.h"
#include "image/image_layer.h"

typedef struct vvi_shelf_place place;

static uint64_t image_bytes(const vv_image *image)
{
    return image ? (uint64_t)image->width * (uint64_t)image->height * vvi_image_pixel_bytes(vv_image_layers(image)) : 0;
}

static uint64_t bytes_of(const vvi_gathered *got)
{
    const uint64_t pixels = (uint64_t)got->image->width * (uint64_t)got->image->height;
    return image_bytes(got->image) + image_bytes(got->canvas) + image_bytes(got->shifted) +
           (got->half ? 4 * pixels * sizeof *got->half : 0);
}

static void drop(place *p)
{
    if (p->bytes)
        vvi_gathered_finish(&p->got);
    p->bytes = 0;
}

static place *oldest(vvi_shelf *shelf)
{
    place *found = NULL;
    for (place *p = shelf->place; p < shelf->place + VVI_SHELF_MOST; p++)
        if (p->bytes && (!found || p->number < found->number))
            found = p;
    return found;
}

static place *free_place(vvi_shelf *shelf, uint64_t bytes, uint64_t most)
{
    uint64_t all = bytes;
    place *free = NULL;
    for (place *p = shelf->place; p < shelf->place + VVI_SHELF_MOST; p++)
        all += p->bytes;
    for (place *p; all > most && (p = oldest(shelf)) != NULL;) {
        all -= p->bytes;
        drop(p);
    }
    for (place *p = shelf->place; p < shelf->place + VVI_SHELF_MOST && !free; p++)
        free = p->bytes ? NULL : p;
    if (!free && (free = oldest(shelf)) != NULL)
        drop(free);
    return free;
}

void vvi_shelf_put(vvi_shelf *shelf, uint64_t depends, vv_picture *picture, uint64_t most)
{
    const uint64_t bytes = picture->got.image ? bytes_of(&picture->got) : 0;
    if (!bytes || bytes > most || !picture->got.counts.rays)
        return;
    place *p = free_place(shelf, bytes, most);
    *p = (place){.depends = depends, .bytes = bytes, .number = ++shelf->number, .got = picture->got};
    picture->got = (vvi_gathered){.image = NULL};
}

bool vvi_shelf_take(vvi_shelf *shelf, uint64_t depends, vv_picture *picture)
{
    for (place *p = shelf->place; p < shelf->place + VVI_SHELF_MOST; p++) {
        if (!p->bytes || p->depends != depends)
            continue;
        vvi_picture_adopt(picture, &p->got);
        p->bytes = 0;
        return true;
    }
    return false;
}

void vvi_shelf_clear(vvi_shelf *shelf)
{
    for (place *p = shelf->place; p < shelf->place + VVI_SHELF_MOST; p++)
        drop(p);
}
