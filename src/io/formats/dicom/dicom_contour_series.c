/* The images on which a structure set was drawn, and the grid that they have. */
#include "core/memory.h"
#include "io/formats/dicom/dicom_contours.h"
#include "io/notes.h"
#include <math.h>
#include <stdio.h>
#include <string.h>

#define PARALLEL 0.9998 /* the cosine of a degree */

/* The stack of images with the most samples whose text is this one; -1: none. */
static ptrdiff_t stack_of(const vvi_dicom_plan *plan, vvi_dicom_text which, const char *text)
{
    ptrdiff_t found = -1;
    double most = 0;
    for (size_t i = 0; i < plan->n_stacks && text[0]; i++) {
        const vvi_dicom_stack *stack = &plan->stack[i];
        const vvi_dicom_image *image = &plan->image[stack->slice[0].image];
        const double n = image->number[VVI_DICOM_ROWS] * image->number[VVI_DICOM_COLUMNS] * (double)stack->n;
        if (vvi_dicom_segmentation_of(image) || strcmp(image->text[which], text) != 0 || n <= most)
            continue;
        most = n;
        found = (ptrdiff_t)i;
    }
    return found;
}

/* What is to be told of the images is told of them, not of what was drawn on them. */
static vv_status grid_of(vv_grid *out, const vvi_dicom_plan *plan, vvi_dicom_stack *stack, const char *name,
                         vv_job *job)
{
    vv_notes *notes;
    vv_field_info info = vv_field_info_default();
    vvi_dicom_plan arranged = *plan;
    const vvi_dicom_image *image = &plan->image[stack->slice[0].image];
    info.grid.dims[0] = (int64_t)image->number[VVI_DICOM_COLUMNS];
    info.grid.dims[1] = (int64_t)image->number[VVI_DICOM_ROWS];
    arranged.slice = NULL;
    vv_status st = vvi_notes_new(&notes, job);
    if (st == VV_OK)
        st = vvi_dicom_arrange(&info, &arranged, stack, name, notes, job);
    if (st == VV_OK)
        st = vvi_dicom_place(&info, &arranged, name, notes);
    vvi_free(arranged.slice);
    vvi_notes_free(notes);
    *out = info.grid;
    return st;
}

static bool is_parallel(const vv_grid *grid, const vvi_dicom_structures *s)
{
    const vv_vec3 a = grid->index_to_world.axis[0], b = grid->index_to_world.axis[1];
    const vv_vec3 n = {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
    vv_vec3 normal;
    if (!vvi_dicom_contours_normal(&normal, s))
        return true;
    return fabs(n.x * normal.x + n.y * normal.y + n.z * normal.z) >= PARALLEL * sqrt(n.x * n.x + n.y * n.y + n.z * n.z);
}

static vv_status find_in(vv_grid *out, bool *found, const vvi_dicom_plan *plan, const vvi_dicom_image *image,
                         const char *name, vv_notes *notes, vv_job *job)
{
    char about[256], text[400];
    ptrdiff_t which = stack_of(plan, VVI_DICOM_SERIES_UID, image->text[VVI_DICOM_DRAWN_SERIES_UID]);
    const bool drawn = which >= 0;
    *found = false;
    if (!drawn)
        which = stack_of(plan, VVI_DICOM_PLACE_UID, image->text[VVI_DICOM_DRAWN_PLACE_UID]);
    if (which < 0)
        return VV_OK;
    vvi_dicom_stack *stack = &plan->stack[which];
    vv_status st = grid_of(out, plan, stack, name, job);
    if (st != VV_OK)
        return st;
    vvi_dicom_describe(about, sizeof about, plan, stack);
    if (out->space != VV_SPACE_RAS || !is_parallel(out, image->structures))
        return vvi_notes_warn(notes,
                              "its contours do not lie in the slices of series %s (%.200s): they get a grid of "
                              "their own",
                              stack->name, about);
    *found = true;
    snprintf(text, sizeof text, "of series %s (%s), %s", stack->name, about,
             drawn ? "on which the contours were drawn" : "which has the contours' frame of reference");
    return vvi_notes_add(notes, "grid", text);
}

/* Nothing that is wrong with other files keeps this one from being read. */
static vv_status find_beside(vv_grid *out, bool *found, const vvi_dicom_image *image, vv_source *folder,
                             vv_notes *notes, vv_job *job)
{
    vv_notes *others;
    vvi_dicom_plan plan = {0};
    const char *name = vvi_source_name(folder);
    vv_status st = vvi_notes_new(&others, job);
    if (st == VV_OK)
        st = vvi_dicom_gather(&plan, folder, false, others, job);
    if (st == VV_OK)
        st = vvi_dicom_sort_images(&plan, name, job);
    if (st == VV_OK)
        st = find_in(out, found, &plan, image, name, notes, job);
    vvi_dicom_plan_finish(&plan);
    vvi_notes_free(others);
    if (st == VV_OK || st == VV_E_MEMORY || st == VV_E_CANCELLED)
        return st;
    *found = false;
    return VV_OK;
}

vv_status vvi_dicom_series_grid(vv_grid *out, bool *found, const vvi_dicom_plan *plan, const vvi_dicom_image *image,
                                vv_source *source, vv_notes *notes, vv_job *job)
{
    vv_source *folder;
    *found = false;
    if (vvi_source_is_folder(source))
        return find_in(out, found, plan, image, vvi_source_name(source), notes, job);
    if (!image->text[VVI_DICOM_DRAWN_SERIES_UID][0] && !image->text[VVI_DICOM_DRAWN_PLACE_UID][0])
        return VV_OK;
    vv_status st = vvi_source_open_folder_of(&folder, source, job);
    if (st != VV_OK || !folder)
        return st;
    st = find_beside(out, found, image, folder, notes, job);
    vvi_source_close(folder);
    return st;
}
