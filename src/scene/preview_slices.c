#include "scene/preview_slices.h"
#include "core/status.h"
#include "grid/slice_axes.h"
#include "scene/preview_colors.h"
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <unistd.h>

#define READ_WHOLE ((uint64_t)64 << 20) /* bytes: decoding three times costs more */
#define PAGE 4096                       /* bytes: samples that are further apart cost a read of the disk each */
#define AHEAD (128 << 10) /* bytes that a system reads around a page of a mapped file: thrown away past this */
#define CLOSE 4           /* samples a pixel along an axis whose samples share pages */

/* Samples of a slice where they lie: column and row in steps of bytes from the top left one. */
typedef struct plane {
    vv_field *slab; /* NULL: part of a whole field */
    vv_brick brick;
    const char *first;
    int64_t across, down; /* from a sample that is shown to the next */
    bool apart;           /* so far that what lies between is not worth reading */
} plane;

static vv_status open_plane(plane *p, const vv_field *whole, vv_file *file, int64_t frame, const vv_box *box,
                            vv_job *job)
{
    if (whole)
        return vv_field_brick(&p->brick, whole, box, job);
    const vv_status st = vv_file_read(&p->slab, file, frame, box, job);
    const vv_box all = st == VV_OK ? vv_field_box(p->slab) : *box;
    return st == VV_OK ? vv_field_brick(&p->brick, p->slab, &all, job) : st;
}

static void close_planes(plane planes[VVI_SLICE_WAYS])
{
    for (int i = 0; i < VVI_SLICE_WAYS; i++) {
        vv_brick_release(&planes[i].brick);
        vv_field_release(planes[i].slab);
    }
}

/* Of an axis with far more samples than its slice has pixels every k-th is enough: of a mapped file only what lies
 * there is read, and not a page for each sample of a slice that crosses all pages. */
static void thin(plane *p, int64_t *stride, vvi_preview_slice *slice, int axis, int pixels)
{
    const int64_t n = slice->n[axis], every = n / (*stride < PAGE ? CLOSE * pixels : pixels);
    if (every < 2)
        return;
    p->first += every / 2 * *stride;
    *stride *= every;
    p->apart = p->apart || *stride > AHEAD;
    slice->n[axis] = n / every;
    slice->step[axis] *= (double)n / (double)slice->n[axis];
}

/* One slice: the box, its samples, and which way they run on the screen. */
static vv_status take_plane(plane *p, vvi_preview_slice *slice, const vvi_slice_axes *v, const vv_field *whole,
                            vv_file *file, int64_t frame, int pixels, vv_job *job)
{
    const vv_grid *grid = &vv_file_info(file)->grid;
    int axis[3], sign[3];
    vvi_grid_index_axes(axis, sign, grid);
    const int a = axis[v->right], b = axis[v->up], c = axis[v->normal];
    vv_box box = {{0, 0, 0}, {grid->dims[0], grid->dims[1], grid->dims[2]}};
    box.lo[c] = grid->dims[c] / 2;
    box.n[c] = 1;
    *slice = (vvi_preview_slice){.n = {grid->dims[a], grid->dims[b]},
                                 .step = {vv_grid_spacing(grid, a), vv_grid_spacing(grid, b)}};
    const vv_status st = open_plane(p, whole, file, frame, &box, job);
    if (st != VV_OK)
        return st;
    p->across = p->brick.stride[a];
    p->down = p->brick.stride[b];
    p->first = p->brick.data;
    thin(p, &p->across, slice, 0, pixels);
    thin(p, &p->down, slice, 1, pixels);
    if (sign[v->right] * v->right_sign < 0) {
        p->first += (slice->n[0] - 1) * p->across;
        p->across = -p->across;
    }
    if (sign[v->up] * v->up_sign > 0) { /* row 0 is the top */
        p->first += (slice->n[1] - 1) * p->down;
        p->down = -p->down;
    }
    return VV_OK;
}

static vv_status paint(vvi_preview_slice *slice, const plane *p, const vvi_preview_colors *colors)
{
    const size_t n = (size_t)(slice->n[0] * slice->n[1]);
    slice->rgb = malloc(n * 3 * sizeof *slice->rgb);
    if (!slice->rgb)
        return vv_fail_memory(n * 3 * sizeof *slice->rgb);
    slice->nearest = vvi_preview_colors_nearest(colors);
    for (int64_t j = 0; j < slice->n[1]; j++)
        for (int64_t i = 0; i < slice->n[0]; i++)
            vvi_preview_color(slice->rgb + 3 * (j * slice->n[0] + i), colors, p->first + i * p->across + j * p->down);
    return VV_OK;
}

/* A regular part of the samples of all slices is enough for percentiles. */
static void look(vvi_preview_colors *colors, const vvi_preview_slice *slices, const plane *planes, int n)
{
    for (int s = 0; s < n; s++) {
        const int64_t all = slices[s].n[0] * slices[s].n[1], every = all / 200000 + 1;
        for (int64_t at = 0; at < all; at += every)
            vvi_preview_colors_look(colors, planes[s].first + at % slices[s].n[0] * planes[s].across +
                                                at / slices[s].n[0] * planes[s].down);
    }
}

/* The system reads around each page that is touched, which costs more than the page where the next one is far away. */
static void read_no_more(const plane *planes, int n)
{
    const uintptr_t page = (uintptr_t)sysconf(_SC_PAGESIZE);
    for (int i = 0; i < n; i++) {
        const vv_brick *b = &planes[i].brick;
        uintptr_t begin = (uintptr_t)b->data;
        uintptr_t end = begin;
        for (int a = 0; a < 3; a++)
            end += (uintptr_t)((b->box.n[a] - 1) * b->stride[a]);
        begin -= begin % page;
        if (planes[i].apart)
            madvise((void *)begin, end - begin, MADV_RANDOM); /* a hint: that it fails changes no picture */
    }
}

/* How many of its two axes have more than one sample. */
static int extent(const vvi_slice_axes *v, const vv_grid *grid, const int axis[3])
{
    return (grid->dims[axis[v->right]] > 1) + (grid->dims[axis[v->up]] > 1);
}

/* All three of a volume; of an image or a line the first that shows all of it. */
static vv_status take_all(vvi_preview_slice out[VVI_SLICE_WAYS], plane planes[VVI_SLICE_WAYS], int *n_out,
                          const vv_field *whole, vv_file *file, int64_t frame, int pixels, vv_job *job)
{
    const vv_grid *grid = &vv_file_info(file)->grid;
    const vvi_slice_axes *views = vvi_slice_axes_of(grid->space);
    vv_status st = VV_OK;
    int axis[3], sign[3], most = 0, least = 2;
    vvi_grid_index_axes(axis, sign, grid);
    for (int i = 0; i < VVI_SLICE_WAYS; i++) {
        const int n = extent(&views[i], grid, axis);
        most = n > most ? n : most;
        least = n < least ? n : least;
    }
    for (int i = 0; i < VVI_SLICE_WAYS && st == VV_OK; i++) {
        if (least < 2 && (*n_out > 0 || extent(&views[i], grid, axis) < most))
            continue;
        st = take_plane(&planes[*n_out], &out[*n_out], &views[i], whole, file, frame,
                        least < 2 ? pixels : pixels / VVI_SLICE_WAYS + 1, job);
        ++*n_out;
    }
    return st;
}

vv_status vvi_preview_slices_read(vvi_preview_slice out[VVI_SLICE_WAYS], int *n_out, vv_file *file,
                                  const vv_field *field, int64_t frame, int pixels, vv_job *job)
{
    plane planes[VVI_SLICE_WAYS] = {0};
    vv_field *whole = NULL;
    vvi_preview_colors *colors = NULL;
    uint64_t bytes = 0;
    *n_out = 0;
    memset(out, 0, VVI_SLICE_WAYS * sizeof *out);
    vv_status st = vv_field_info_bytes(&bytes, vv_file_info(file));
    const bool cheap = bytes <= READ_WHOLE || vv_file_mappable(file); /* mapped: nothing is read yet */
    if (st == VV_OK && !field && cheap)
        st = vv_file_read(&whole, file, frame, NULL, job);
    if (st == VV_OK)
        st = take_all(out, planes, n_out, field ? field : whole, file, frame, pixels, job);
    if (st == VV_OK && whole && vv_file_mappable(file))
        read_no_more(planes, *n_out);
    if (st == VV_OK)
        st = vvi_preview_colors_new(&colors, file);
    if (st == VV_OK) {
        look(colors, out, planes, *n_out);
        st = vvi_preview_colors_settle(colors, job);
    }
    for (int i = 0; i < *n_out && st == VV_OK; i++)
        st = paint(&out[i], &planes[i], colors);
    vvi_preview_colors_free(colors);
    close_planes(planes);
    vv_field_release(whole);
    return st;
}

void vvi_preview_slices_finish(vvi_preview_slice slices[VVI_SLICE_WAYS])
{
    for (int i = 0; i < VVI_SLICE_WAYS; i++) {
        free(slices[i].rgb);
        slices[i].rgb = NULL;
    }
}
