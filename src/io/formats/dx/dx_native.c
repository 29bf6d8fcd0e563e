/* .dx files: which array on which grid, and where its data lie. */
#include "core/memory.h"
#include "io/formats/dx/dx_objects.h"
#include "io/sample_writer.h"
#include <inttypes.h>
#include <stdio.h>
#include <string.h>

static const vvi_dx_object *find(const vvi_dx_objects *p, const char *name, vvi_dx_kind wanted)
{
    for (size_t i = 0; i < p->n_objects; i++)
        if ((name && *name ? strcmp(p->object[i].name, name) == 0 : true) &&
            (wanted == VVI_DX_OTHER || p->object[i].kind == wanted))
            return &p->object[i];
    return NULL;
}

/* The field that was asked for, else the first on a regular grid, else the first; all of them are parts. */
static vv_status choose(const vvi_dx_object **out, const vvi_dx_objects *p, const char *part, vv_notes *notes)
{
    const vvi_dx_object *first = NULL, *regular = NULL, *asked = NULL;
    for (size_t i = 0; i < p->n_objects; i++) {
        const vvi_dx_object *o = &p->object[i];
        if (o->kind != VVI_DX_FIELD)
            continue;
        first = first ? first : o;
        const vvi_dx_object *positions = find(p, o->positions, VVI_DX_OTHER);
        regular = regular ? regular : positions && positions->kind == VVI_DX_GRID && o->positions[0] ? o : NULL;
        asked = part && strcmp(o->name, part) == 0 ? o : asked;
    }
    *out = part ? asked : regular ? regular : first;
    vv_status st = VV_OK;
    for (size_t i = 0; i < p->n_objects && st == VV_OK && first; i++)
        if (p->object[i].kind == VVI_DX_FIELD)
            st = vvi_notes_part(notes, p->object[i].name, "", &p->object[i] == *out);
    if (st == VV_OK && part && !asked)
        st = vvi_notes_fail_part(notes, VV_E_ARGUMENT, vvi_source_name(p->source), "field", part);
    if (st == VV_OK && !part)
        st = vvi_notes_warn_unnamed(notes, vvi_source_name(p->source), "fields");
    return st;
}

static vv_status fail_irregular(const vvi_dx_objects *p, const vvi_dx_object *positions)
{
    return vv_fail_at(
        VV_E_UNSUPPORTED, vvi_source_name(p->source), NULL,
        "its positions are irregular (class %.30s), which is not a regular grid; resample it first (OpenDX: Regrid)",
        positions ? positions->class_name : "of another file");
}

static vv_status check_array(const vvi_dx_objects *p, const vvi_dx_object *array, const vvi_dx_grid *grid)
{
    const char *name = vvi_source_name(p->source);
    double n = 1;
    if (!array->has_type || array->not_real || array->rank > 1)
        return vv_fail_at(
            VV_E_UNSUPPORTED, name, NULL,
            "its array '%.60s' has a type that is not supported; only real numbers and vectors of them are read",
            array->name);
    for (int a = 0; a < grid->n_axes; a++) {
        if (grid->cells && grid->n[a] < 2)
            return vv_fail_at(VV_E_FORMAT, name, NULL, "its grid has no cells along %c", 'x' + a);
        n *= (double)(grid->cells ? grid->n[a] - 1 : grid->n[a]);
    }
    if (n != (double)array->items)
        return vv_fail_at(VV_E_FORMAT, name, NULL, "its array '%.60s' has %" PRId64 " items but its grid needs %.0f",
                          array->name, array->items, n);
    return VV_OK;
}

/* Where the samples lie: behind the header, after its "end", or in a file beside. */
static vv_status find_data(vvi_data_files *files, const vvi_dx_objects *p, const vvi_dx_object *array)
{
    files->numbers = array->text;
    files->layout.swap = !array->text && vv_type_bytes(array->type) > 1 && vvi_order_swapped(array->big_endian);
    const uint64_t base = array->follows || array->file[0] ? 0 : vvi_source_tell(p->source);
    if (array->offset > INT64_MAX - base)
        return vv_fail_at(VV_E_FORMAT, vvi_source_name(p->source), NULL,
                          "its array '%.60s' lies at an impossible offset", array->name);
    files->skip = (int64_t)(base + array->offset);
    return array->file[0] ? vvi_data_files_add(files, array->file) : VV_OK;
}

static vv_status understand(vv_field_info *info, vvi_data_files *files, const vvi_dx_objects *p, const char *part,
                            vv_notes *notes)
{
    const vvi_dx_object *field = NULL;
    vv_status st = choose(&field, p, part, notes);
    if (st != VV_OK)
        return st;
    const vvi_dx_object *positions = find(p, field ? field->positions : NULL, field ? VVI_DX_OTHER : VVI_DX_GRID);
    const vvi_dx_object *array = find(p, field ? field->data : NULL, VVI_DX_ARRAY);
    if (!array || (!field && !positions))
        return vv_fail_at(VV_E_FORMAT, vvi_source_name(p->source), NULL,
                          "has no array of data on a grid of positions in this file");
    if (!positions || positions->kind != VVI_DX_GRID)
        return fail_irregular(p, positions);
    vvi_dx_grid grid = positions->grid;
    grid.cells = array->cells;
    if ((st = check_array(p, array, &grid)) != VV_OK)
        return st;
    info->type = array->type;
    info->components = array->components;
    if (array->rank == 1 && array->components > 1)
        info->meaning = VV_MEANING_VECTOR;
    snprintf(info->name, sizeof info->name, "%.63s", field ? field->name : array->name);
    vvi_dx_place(info, &files->layout, &grid, false);
    return find_data(files, p, array);
}

vv_status vvi_dx_read_native(vv_field_info *info, vvi_data_files *files, vv_source *source,
                             const vv_read_options *options, vv_notes *notes, vv_job *job)
{
    vvi_dx_objects p;
    vv_status st = vvi_dx_read_objects(&p, source, job);
    if (st == VV_OK)
        st = understand(info, files, &p, options->part, notes);
    vvi_free(p.object);
    return st;
}
