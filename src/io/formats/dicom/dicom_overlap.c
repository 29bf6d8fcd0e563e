/* Which segments share samples, and layers in which none do. */
#include "core/job.h"
#include "core/memory.h"
#include "grid/field.h"
#include "io/formats/dicom/dicom_layers.h"
#include <string.h>

#define SEGMENTS_MOST 8192 /* in one file of frames: pairs of them are looked at */

/* Who has each sample of a place: the first segment, plus 1, in the first plane, the second in the next one. */
typedef struct owners {
    vvi_dicom_scratch scratch;
    vvi_dicom_file file;
    uint8_t *samples;
    uint16_t *plane;
    size_t n, n_planes, room;
} owners;

static void mark(vvi_dicom_layers *l, size_t a, size_t b)
{
    const size_t ab = a * l->n_segments + b, ba = b * l->n_segments + a;
    l->overlap[ab / 8] |= (uint8_t)(1u << ab % 8);
    l->overlap[ba / 8] |= (uint8_t)(1u << ba % 8);
}

static vv_status add_plane(vvi_dicom_layers *l, owners *o)
{
    const size_t bytes = o->n * sizeof *o->plane;
    if (o->n_planes == o->room) {
        void *grown = vvi_realloc(l->job, o->plane, (o->room + 1) * bytes, VVI_MEM_SCRATCH);
        if (!grown)
            return vv_fail_memory((o->room + 1) * bytes);
        o->plane = grown;
        o->room++;
    }
    memset(o->plane + o->n_planes++ * o->n, 0, bytes);
    return VV_OK;
}

static vv_status own(vvi_dicom_layers *l, owners *o, size_t segment)
{
    vv_status st = VV_OK;
    for (size_t i = 0; i < o->n && st == VV_OK; i++) {
        if (!o->samples[i])
            continue;
        size_t p = 0;
        while (p < o->n_planes && o->plane[p * o->n + i])
            mark(l, o->plane[p++ * o->n + i] - 1u, segment);
        if (p == o->n_planes)
            st = add_plane(l, o);
        if (st == VV_OK)
            o->plane[p * o->n + i] = (uint16_t)(segment + 1);
    }
    return st;
}

/* A frame that cannot be unpacked has no samples; that is told when it is read. */
static vv_status look_at_place(vvi_dicom_layers *l, owners *o, size_t p)
{
    vv_status st = vvi_job_poll(l->job);
    o->n_planes = 0;
    for (size_t i = l->place[p]; i < l->place[p + 1] && st == VV_OK; i++) {
        size_t n_missing;
        const int32_t frame = l->slice[i].frame;
        st = vvi_dicom_pixels(o->samples, l->image, frame, o->file.source, &o->scratch, &n_missing, l->job);
        if (st == VV_OK)
            st = own(l, o, vvi_dicom_segment_of(l, frame));
        else if (st == VV_E_FORMAT || st == VV_E_READ)
            st = VV_OK;
    }
    return st;
}

static vv_status find_overlaps(vvi_dicom_layers *l)
{
    owners o = {.n = (size_t)(l->image->number[VVI_DICOM_ROWS] * l->image->number[VVI_DICOM_COLUMNS])};
    if (l->n_segments > SEGMENTS_MOST)
        return vv_fail_at(VV_E_LIMIT, l->name, NULL, "has %zu %ss; up to %d are read", l->n_segments,
                          vvi_dicom_word(l->image), SEGMENTS_MOST);
    l->overlap = vvi_dicom_layers_room(l, l->n_segments * l->n_segments / 8 + 1, 1);
    o.samples = vvi_dicom_layers_room(l, o.n, vv_type_bytes(l->image->type));
    vv_status st = l->overlap && o.samples ? vvi_dicom_open(&o.file, l->image, l->source, l->job) : VV_E_MEMORY;
    for (size_t p = 0; p < l->n_places && st == VV_OK; p++)
        if (l->place[p + 1] - l->place[p] > 1)
            st = look_at_place(l, &o, p);
    vvi_dicom_close(&o.file);
    vvi_dicom_scratch_finish(&o.scratch);
    vvi_free(o.plane);
    vvi_free(o.samples);
    return st;
}

static bool fits(const vvi_dicom_layers *l, size_t segment, size_t layer)
{
    for (size_t i = 0; i < segment; i++) {
        const size_t bit = i * l->n_segments + segment;
        if (l->layer[i] == layer && l->overlap[bit / 8] >> bit % 8 & 1)
            return false;
    }
    return true;
}

vv_status vvi_dicom_find_layers(vvi_dicom_layers *l)
{
    vv_status st = VV_OK;
    l->n_layers = 1;
    if (vvi_dicom_segmentation_of(l->image) != VVI_DICOM_BINARY || l->n_segments < 2)
        return VV_OK;
    if ((st = find_overlaps(l)) != VV_OK)
        return st;
    for (size_t s = 0; s < l->n_segments; s++) {
        while (!fits(l, s, l->layer[s]))
            l->layer[s]++;
        l->n_layers = l->layer[s] >= l->n_layers ? l->layer[s] + 1 : l->n_layers;
    }
    return VV_OK;
}
