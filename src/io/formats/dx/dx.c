/* OpenDX: which of the two kinds of headers a file is, and what both have in common. */
#include "io/formats/dx/dx.h"
#include "core/memory.h"
#include "io/placement.h"
#include "registry.h"
#include <ctype.h>
#include <string.h>
#include <strings.h>

/* The first line that is neither blank nor a comment. */
static const char *first_words(const char *text)
{
    for (;;) {
        text += strspn(text, " \t\r\n");
        if (*text != '#')
            return text;
        text += strcspn(text, "\n");
    }
}

static bool is_native(const char *text)
{
    const char *at = first_words(text);
    const bool data_mode = strncasecmp(at, "data", 4) == 0 && isspace((unsigned char)at[4]);
    return (strncasecmp(at, "object", 6) == 0 && isspace((unsigned char)at[6]) && strcasestr(at, "class")) || data_mode;
}

static bool is_general(const char *text)
{
    const char *at = first_words(text);
    const size_t word = strcspn(at, " \t=\r\n");
    const char *equals = at + word + strspn(at + word, " \t");
    static const char *const keys[] = {"file",     "grid",   "format", "interleaving",
                                       "majority", "header", "series", "field"};
    for (size_t i = 0; i < sizeof keys / sizeof *keys; i++)
        if (strlen(keys[i]) == word && strncasecmp(at, keys[i], word) == 0)
            return *equals == '=';
    return false;
}

static int probe(const uint8_t *head, size_t n, const char *path)
{
    char text[4097];
    n = n < 4096 ? n : 4096;
    memcpy(text, head, n);
    text[n] = 0;
    return is_native(text) || (is_general(text) && strcasestr(text, "grid")) ? 1 : 0;
}

bool vvi_dx_type(vv_type *out, const char *text)
{
    static const struct {
        const char *name;
        vv_type type;
    } types[] = {
        {"byte", VV_TYPE_U8},          {"unsigned byte", VV_TYPE_U8}, {"ubyte", VV_TYPE_U8},
        {"char", VV_TYPE_U8},          {"unsigned char", VV_TYPE_U8}, {"signed byte", VV_TYPE_I8},
        {"short", VV_TYPE_I16},        {"signed short", VV_TYPE_I16}, {"unsigned short", VV_TYPE_U16},
        {"ushort", VV_TYPE_U16},       {"int", VV_TYPE_I32},          {"signed int", VV_TYPE_I32},
        {"unsigned int", VV_TYPE_U32}, {"uint", VV_TYPE_U32},         {"float", VV_TYPE_F32},
        {"double", VV_TYPE_F64},
    };
    for (size_t i = 0; i < sizeof types / sizeof *types; i++)
        if (strcasecmp(types[i].name, text) == 0) {
            *out = types[i].type;
            return true;
        }
    return false;
}

void vvi_dx_place(vv_field_info *info, vvi_layout *layout, const vvi_dx_grid *grid, bool first_fastest)
{
    vv_affine *map = &info->grid.index_to_world;
    double origin[3];
    memcpy(origin, grid->origin, sizeof origin);
    for (int a = 0; a < grid->n_axes; a++) {
        const double *d = grid->delta[a];
        info->grid.dims[a] = grid->cells ? grid->n[a] - 1 : grid->n[a];
        map->axis[a] = (vv_vec3){d[0], d[1], d[2]};
        for (int k = 0; k < 3 && grid->cells; k++)
            origin[k] += d[k] / 2;
    }
    map->origin = (vv_vec3){origin[0], origin[1], origin[2]};
    vvi_complete_axes(map, grid->n_axes);
    strcpy(info->grid.unit, "units");
    layout->n_axes = 0;
    if (info->components > 1)
        layout->axis[layout->n_axes++] = (vvi_layout_axis){info->components, VVI_ROLE_COMPONENT};
    for (int i = 0; i < grid->n_axes; i++) {
        const int a = first_fastest ? i : grid->n_axes - 1 - i;
        layout->axis[layout->n_axes++] = (vvi_layout_axis){info->grid.dims[a], (vvi_role)(VVI_ROLE_X + a)};
    }
    layout->type = info->type;
}

static void free_plan(void *plan)
{
    vvi_data_files_finish(plan);
    vvi_free(plan);
}

static vv_status read_header(vv_field_info *info, void **plan_out, vv_source *source, const vv_read_options *options,
                             vv_notes *notes, vv_job *job)
{
    *plan_out = NULL;
    char text[4097];
    size_t n;
    vv_status st = vvi_source_spool(source, job);
    if (st != VV_OK)
        return st;
    const uint8_t *head = vvi_source_peek(source, 4096, &n);
    if (!head)
        return vv_error_last()->status;
    memcpy(text, head, n);
    text[n] = 0;
    vvi_data_files *d = vvi_alloc_zeroed(job, sizeof *d, VVI_MEM_MODEL);
    if (!d)
        return vv_fail_memory(sizeof *d);
    *d = (vvi_data_files){.header = vvi_source_name(source), .limits = vvi_job_limits(job), .coded_bytes = UINT64_MAX};
    st = is_general(text) ? vvi_dx_read_general(info, d, source, options, notes, job)
                          : vvi_dx_read_native(info, d, source, options, notes, job);
    if (st == VV_OK)
        st = vvi_data_files_check(d, source, job);
    if (st != VV_OK)
        free_plan(d);
    else
        *plan_out = d;
    return st;
}

static vv_status read_samples(vv_field **out, const vv_field_info *info, const void *plan, vv_source *source,
                              int64_t frame, const vv_box *region, vv_job *job)
{
    return vvi_data_files_read(out, info, plan, source, frame, region, job);
}

static bool mappable(const vv_field_info *info, const void *plan)
{
    return ((const vvi_data_files *)plan)->mappable;
}

static const char *const suffixes[] = {".dx", ".general", NULL};

const vv_format vvi_format_dx = {
    .beside = true,
    .api = VV_FORMAT_API,
    .name = "dx",
    .doc = "OpenDX regular grids, .dx and .general import headers; text or binary, fields are parts",
    .suffixes = suffixes,
    .probe = probe,
    .read_header = read_header,
    .free_plan = free_plan,
    .read = read_samples,
    .mappable = mappable,
};
