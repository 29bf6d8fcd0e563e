/* From the arrays and pieces of VTK's XML files to a field. */
#include "core/job.h"
#include "core/limits.h"
#include "core/memory.h"
#include "io/formats/vtk/vtk_xml.h"
#include "io/scan.h"
#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

/* Which array --------------------------------------------------------------------------------------------------------
 */

static bool is_part(const vvi_vtk_array *a)
{
    return a->piece == 0 && (a->section == VVI_VTK_POINTS || a->section == VVI_VTK_CELLS) &&
           strcmp(a->name, "vtkGhostType") != 0 && strcmp(a->name, "vtkGhostLevels") != 0;
}

/* What a user calls an array: its name, "cells/NAME" where points have one of that name, "array N" without one. */
static void part_name(char *out, size_t room, const vvi_vtk_file *file, size_t index)
{
    const vvi_vtk_array *a = &file->array[index];
    bool taken = false;
    for (size_t i = 0; i < index; i++)
        taken = taken || (is_part(&file->array[i]) && file->array[i].section != a->section &&
                          strcmp(file->array[i].name, a->name) == 0);
    if (!a->name[0])
        snprintf(out, room, "array %zu", index);
    else
        snprintf(out, room, "%s%s", taken ? a->section == VVI_VTK_CELLS ? "cells/" : "points/" : "", a->name);
}

static bool is_wanted(const vvi_vtk_array *a, vvi_vtk_section section, bool active)
{
    return is_part(a) && a->section == section && a->has_type && (a->scalars || !active);
}

/* The active scalars of points, then of cells; else the first of points, then of cells. */
static bool choose_default(size_t *out, const vvi_vtk_file *file)
{
    for (int pass = 0; pass < 4; pass++)
        for (size_t i = 0; i < file->n_arrays; i++)
            if (is_wanted(&file->array[i], pass % 2 ? VVI_VTK_CELLS : VVI_VTK_POINTS, pass < 2)) {
                *out = i;
                return true;
            }
    return false;
}

/* SIZE_MAX: there is none of that name. */
static vv_status choose(size_t *out, const vvi_vtk_file *file, const char *part)
{
    char name[256];
    *out = SIZE_MAX;
    if (!part)
        return choose_default(out, file)
                   ? VV_OK
                   : vv_fail_at(VV_E_FORMAT, file->name, NULL, "has no array of numbers on its points or cells");
    for (size_t i = 0; i < file->n_arrays; i++) {
        part_name(name, sizeof name, file, i);
        if (is_part(&file->array[i]) && strcmp(name, part) == 0) {
            *out = i;
            return VV_OK;
        }
    }
    return VV_OK;
}

void vvi_vtk_samples_of(int64_t out[3], const int64_t extent[6], bool cells)
{
    for (int a = 0; a < 3; a++) {
        const int64_t n = extent[2 * a + 1] - extent[2 * a] + 1;
        out[a] = cells && n > 1 ? n - 1 : n;
    }
}

static vv_status list_parts(const vvi_vtk_plan *plan, vv_notes *notes)
{
    vv_status st = VV_OK;
    for (size_t i = 0; i < plan->file.n_arrays && st == VV_OK; i++) {
        const vvi_vtk_array *a = &plan->file.array[i];
        char name[256], about[128], components[32] = "";
        int64_t n[3];
        if (!is_part(a))
            continue;
        vvi_vtk_samples_of(n, plan->file.whole, a->section == VVI_VTK_CELLS);
        if (a->components > 1)
            snprintf(components, sizeof components, " x %d", a->components);
        snprintf(about, sizeof about, "%" PRId64 " x %" PRId64 " x %" PRId64 ", %.20s%s, %s", n[0], n[1], n[2],
                 a->has_type ? vv_type_name(a->type) : a->type_name, components,
                 a->section == VVI_VTK_CELLS ? "cells" : "points");
        part_name(name, sizeof name, &plan->file, i);
        st = vvi_notes_part(notes, name, about, i == plan->chosen);
    }
    return st;
}

vv_status vvi_vtk_find_in_piece(const vvi_vtk_array **out, const vvi_vtk_plan *plan, size_t piece)
{
    const vvi_vtk_file *file = &plan->file;
    const vvi_vtk_array *chosen = &file->array[plan->chosen];
    for (size_t i = 0; i < file->n_arrays; i++) {
        const vvi_vtk_array *a = &file->array[i];
        if (a->piece == piece && a->section == chosen->section && strcmp(a->name, chosen->name) == 0 && a->has_type &&
            a->type == chosen->type && a->components == chosen->components) {
            *out = a;
            return VV_OK;
        }
    }
    return vv_fail_at(VV_E_FORMAT, file->name, NULL, "its piece %zu has no array '%.60s' like that of its first piece",
                      piece + 1, chosen->name);
}

/* Where samples are -------------------------------------------------------------------------------------------------
 */

static vv_status place_image(vv_field_info *info, const vvi_vtk_file *file, bool cells)
{
    vv_affine *map = &info->grid.index_to_world;
    const double *d = file->direction;
    double step[3], index[3];
    for (int a = 0; a < 3; a++) {
        const bool flat = file->whole[2 * a] == file->whole[2 * a + 1];
        step[a] = file->spacing[a];
        if (step[a] == 0 && !flat)
            return vv_fail_at(VV_E_FORMAT, file->name, NULL, "its spacing along %c is 0", 'x' + a);
        if (step[a] == 0) /* the thickness of a plane is of no meaning */
            step[a] = 1;
        index[a] = step[a] * ((double)file->whole[2 * a] + (cells && !flat ? 0.5 : 0));
    }
    for (int a = 0; a < 3; a++)
        map->axis[a] = (vv_vec3){d[a] * step[a], d[3 + a] * step[a], d[6 + a] * step[a]};
    map->origin = (vv_vec3){file->origin[0] + d[0] * index[0] + d[1] * index[1] + d[2] * index[2],
                            file->origin[1] + d[3] * index[0] + d[4] * index[1] + d[5] * index[2],
                            file->origin[2] + d[6] * index[0] + d[7] * index[1] + d[8] * index[2]};
    strcpy(info->grid.unit, file->has_spacing ? "units" : "voxels");
    return VV_OK;
}

/* Coordinates along an axis, put together from those of all pieces. */
static vv_status read_axis(double *at, const vvi_vtk_file *file, int axis, vv_source *source, vv_job *job)
{
    const int64_t first = file->whole[2 * axis], n = file->whole[2 * axis + 1] - first + 1;
    for (int64_t i = 0; i < n; i++)
        at[i] = (double)NAN;
    for (size_t p = 0; p < file->n_pieces; p++) {
        const int64_t *extent = file->piece[p].extent;
        const uint64_t m = (uint64_t)(extent[2 * axis + 1] - extent[2 * axis] + 1);
        int found = 0;
        double *v = NULL;
        for (size_t i = 0; i < file->n_arrays; i++) {
            if (file->array[i].piece != p || file->array[i].section != VVI_VTK_COORDINATES || found++ != axis)
                continue;
            vv_status st = vvi_vtk_numbers(&v, file, &file->array[i], m, source, job);
            if (st != VV_OK)
                return st;
            break;
        }
        if (!v)
            return vv_fail_at(VV_E_FORMAT, file->name, NULL, "has no coordinates along %c", 'x' + axis);
        memcpy(at + (extent[2 * axis] - first), v, (size_t)m * sizeof *v);
        vvi_free(v);
    }
    return VV_OK;
}

static vv_status place_rectilinear(vv_field_info *info, vvi_vtk_plan *plan, bool cells, vv_source *source,
                                   vv_notes *notes, vv_job *job)
{
    const vvi_vtk_file *file = &plan->file;
    double *at[3] = {NULL};
    int64_t n[3];
    vvi_axes *axes = NULL;
    vv_status st = VV_OK;
    for (int a = 0; a < 3 && st == VV_OK; a++) {
        n[a] = file->whole[2 * a + 1] - file->whole[2 * a] + 1;
        if ((uint64_t)n[a] > vvi_job_limits(job)->dim) {
            st = vv_fail_at(VV_E_LIMIT, file->name, NULL,
                            "has %" PRId64 " samples along %c; the limit is %" PRIu64 " (--limit dim=N allows more)",
                            n[a], 'x' + a, vvi_job_limits(job)->dim);
            break;
        }
        at[a] = vvi_alloc(job, (size_t)n[a] * sizeof *at[a], VVI_MEM_SCRATCH);
        st = at[a] ? read_axis(at[a], file, a, source, job) : vv_fail_memory((size_t)n[a] * sizeof *at[a]);
        if (st == VV_OK && cells)
            n[a] = vvi_axes_centres(at[a], n[a]);
    }
    if (st == VV_OK)
        st = vvi_axes_new(&axes, (const double *const *)at, n, file->name, job);
    for (int a = 0; a < 3; a++)
        vvi_free(at[a]);
    if (st != VV_OK)
        return st;
    plan->stored.meaning = info->meaning;
    vvi_axes_place(info, axes);
    strcpy(info->grid.unit, "units");
    st = vvi_axes_warn(notes, axes);
    if (!vvi_axes_even(axes))
        plan->uneven = axes;
    else
        vvi_axes_free(axes);
    return st;
}

/* What samples are --------------------------------------------------------------------------------------------------
 */

static void describe(vv_field_info *info, const vvi_vtk_array *a)
{
    info->type = a->type;
    info->components = a->components;
    if (a->type == VV_TYPE_U8 && !a->bits && a->components == 3)
        info->meaning = VV_MEANING_RGB;
    else if (a->type == VV_TYPE_U8 && !a->bits && a->components == 4)
        info->meaning = VV_MEANING_RGBA;
    else if (a->vectors && a->components > 1)
        info->meaning = VV_MEANING_VECTOR;
    const size_t n = vvi_utf8_cut(a->name, strlen(a->name), sizeof info->name - 1);
    memcpy(info->name, a->name, n);
    info->name[n] = 0;
}

void vvi_vtk_lay_out(vvi_layout *out, const vvi_vtk_file *file, const vvi_vtk_array *a, const int64_t extent[6])
{
    int64_t n[3];
    vvi_vtk_samples_of(n, extent, a->section == VVI_VTK_CELLS);
    *out = (vvi_layout){.type = a->type, .swap = vvi_vtk_swapped(file, a)};
    if (a->components > 1)
        out->axis[out->n_axes++] = (vvi_layout_axis){a->components, VVI_ROLE_COMPONENT};
    for (int axis = 0; axis < 3; axis++)
        out->axis[out->n_axes++] = (vvi_layout_axis){n[axis], (vvi_role)(VVI_ROLE_X + axis)};
}

/* Each piece has the array, and the bytes of it can arrive. */
static vv_status check_pieces(vvi_vtk_plan *plan, vv_source *source, vv_job *job)
{
    vv_status st = VV_OK;
    for (size_t p = 0; p < plan->file.n_pieces && st == VV_OK; p++) {
        const vvi_vtk_array *a;
        vvi_vtk_reader *reader;
        uint64_t n, offset;
        if ((st = vvi_vtk_find_in_piece(&a, plan, p)) != VV_OK)
            return st;
        vvi_vtk_lay_out(&plan->layout, &plan->file, a, plan->file.piece[p].extent);
        if ((st = vvi_layout_count(&n, &plan->layout, plan->file.name)) != VV_OK ||
            (st = vvi_vtk_open(&reader, &plan->file, a, n, source, job)) != VV_OK)
            return st;
        plan->mappable = vvi_vtk_plain(&offset, reader) && vvi_layout_mappable(&plan->layout, offset) &&
                         vvi_source_mappable(source, offset, n * vv_type_bytes(a->type)) && !plan->uneven;
        vvi_vtk_close(reader);
    }
    plan->mappable = plan->mappable && plan->file.n_pieces == 1;
    return st;
}

/* How many cells the pieces have together, of those of the whole: they do not overlap but in points. */
static vv_status check_cover(vvi_vtk_plan *plan, vv_notes *notes)
{
    int64_t n[3];
    double there = 0;
    for (size_t p = 0; p < plan->file.n_pieces; p++) {
        vvi_vtk_samples_of(n, plan->file.piece[p].extent, true);
        there += (double)n[0] * (double)n[1] * (double)n[2];
    }
    vvi_vtk_samples_of(n, plan->file.whole, true);
    plan->missing = 1 - there / ((double)n[0] * (double)n[1] * (double)n[2]);
    if (plan->missing > 0.5)
        return vv_fail_at(VV_E_FORMAT, plan->file.name, NULL,
                          "its pieces cover %.3g %% of its WholeExtent, less than half", 100 * (1 - plan->missing));
    return plan->missing > 1e-12
               ? vvi_notes_warn(notes, "its pieces leave %.3g %% of its WholeExtent empty", 100 * plan->missing)
               : VV_OK;
}

static vv_status place(vv_field_info *info, vvi_vtk_plan *plan, vv_source *source, const vv_read_options *options,
                       vv_notes *notes, vv_job *job)
{
    vvi_vtk_file *file = &plan->file;
    vv_status st = choose(&plan->chosen, file, options->part);
    if (st == VV_OK && plan->chosen == SIZE_MAX && (st = list_parts(plan, notes)) == VV_OK)
        st = vvi_notes_fail_part(notes, VV_E_ARGUMENT, file->name, "array", options->part);
    if (st != VV_OK)
        return st;
    const vvi_vtk_array *a = &file->array[plan->chosen];
    const bool cells = a->section == VVI_VTK_CELLS;
    if (!a->has_type)
        return vv_fail_at(VV_E_UNSUPPORTED, file->name, NULL, "its array '%.60s' is of type %.40s; numbers are needed",
                          a->name, a->type_name);
    describe(info, a);
    vvi_vtk_samples_of(info->grid.dims, file->whole, cells);
    plan->stored = *info;
    if ((st = check_cover(plan, notes)) != VV_OK)
        return st;
    if ((st = file->rectilinear ? place_rectilinear(info, plan, cells, source, notes, job)
                                : place_image(info, file, cells)) != VV_OK ||
        (st = vvi_vtk_read_notes(info, file, source, notes, job)) != VV_OK || (st = list_parts(plan, notes)) != VV_OK)
        return st;
    if (!options->part && (st = vvi_notes_warn_unnamed(notes, file->name, "arrays")) != VV_OK)
        return st;
    if (!plan->uneven)
        plan->stored = *info;
    return vvi_source_lacks(source, check_pieces(plan, source, job));
}

void vvi_vtk_free_plan(void *memory)
{
    vvi_vtk_plan *plan = memory;
    vvi_axes_free(plan->uneven);
    vvi_vtk_finish(&plan->file);
    vvi_free(plan);
}

bool vvi_vtk_mappable(const vv_field_info *info, const void *plan)
{
    return ((const vvi_vtk_plan *)plan)->mappable;
}

vv_status vvi_vtk_read_header(vv_field_info *info, void **plan_out, vvi_vtk_parse_fn *parse, vv_source *source,
                              const vv_read_options *options, vv_notes *notes, vv_job *job)
{
    *plan_out = NULL;
    vv_status st = vvi_source_spool(source, job);
    if (st != VV_OK)
        return st;
    vvi_vtk_plan *plan = vvi_alloc_zeroed(job, sizeof *plan, VVI_MEM_MODEL);
    if (!plan)
        return vv_fail_memory(sizeof *plan);
    st = parse(&plan->file, source, notes, job);
    if (st == VV_OK)
        st = place(info, plan, source, options, notes, job);
    if (st != VV_OK)
        vvi_vtk_free_plan(plan);
    else
        *plan_out = plan;
    return st;
}
