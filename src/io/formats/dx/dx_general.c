/* .general files: lines of "keyword = values" that say how samples lie in another file. */
#include "core/memory.h"
#include "io/formats/dx/dx.h"
#include "io/header_keys.h"
#include "io/sample_writer.h"
#include "io/scan.h"
#include <ctype.h>
#include <math.h>
#include <stdio.h>
#include <string.h>
#include <strings.h>

/* All lines up to "end"; a line without "=" is none of ours. */
static vv_status read_keys(vvi_keys *keys, vv_source *source)
{
    vv_status st = VV_OK;
    bool end = false;
    for (int number = 1; st == VV_OK; number++) {
        const char *line, *value;
        size_t n;
        if ((st = vvi_source_line(source, &line, 64 << 10, &end)) != VV_OK || end)
            return st;
        line += strspn(line, " \t");
        if (strncasecmp(line, "end", 3) == 0 && !line[3 + strspn(line + 3, " \t")])
            return VV_OK;
        if (*line == '#' || !*line)
            continue;
        if (!vvi_keys_split(line, "=", &n, &value))
            return vv_fail_at(VV_E_FORMAT, vvi_source_name(source), NULL, "expected 'keyword = value' in line %d",
                              number);
        st = vvi_keys_add(keys, line, n, value, strlen(value), number);
    }
    return st;
}

/* "128 x 128 x 16" */
static vv_status read_dims(vvi_dx_grid *grid, vvi_keys *keys)
{
    const char *at = vvi_keys_get(keys, "grid");
    if (!at)
        return vvi_keys_get(keys, "points") ? vv_fail_at(VV_E_UNSUPPORTED, keys->file, NULL,
                                                         "holds scattered 'points', which are not a regular grid")
                                            : vvi_keys_need(keys, "grid");
    for (;;) {
        int64_t n;
        if (grid->n_axes == 3 || !vvi_scan_int(&n, at, &at) || n < 1 || n > INT32_MAX)
            return vvi_keys_fail(keys, "grid", "needs 1 to 3 whole numbers with x between them");
        grid->n[grid->n_axes++] = n;
        at += strspn(at, " \t");
        if (!*at)
            return VV_OK;
        if (*at != 'x' && *at != 'X' && *at != ',')
            return vvi_keys_fail(keys, "grid", "needs 1 to 3 whole numbers with x between them");
        at++;
    }
}

/* "0, 1.77, 0, 1.77, 0, 2.07", perhaps with "regular" before; origin and step of each axis. */
static vv_status read_positions(vvi_dx_grid *grid, vvi_keys *keys)
{
    const char *at = vvi_keys_get(keys, "positions");
    double v[6] = {0, 1, 0, 1, 0, 1};
    for (int i = 0; at && i < 2 * grid->n_axes;) {
        at += strspn(at, " \t,");
        if (strncasecmp(at, "irregular", 9) == 0)
            return vv_fail_at(VV_E_UNSUPPORTED, keys->file, NULL,
                              "its 'positions' are irregular, which is not a regular grid; resample it first");
        if (strncasecmp(at, "regular", 7) == 0)
            at += 7;
        else if (!vvi_scan_real(&v[i++], at, &at) || !isfinite(v[i - 1]))
            return vvi_keys_fail(keys, "positions", "needs origin and step of each axis, finite numbers");
    }
    for (int a = 0; a < grid->n_axes; a++) {
        grid->origin[a] = v[2 * a];
        grid->delta[a][a] = v[2 * a + 1];
        if (v[2 * a + 1] == 0)
            return vvi_keys_fail(keys, "positions", "has a step of 0");
    }
    return VV_OK;
}

/* The n-th of a list with commas, without blanks around; false when there are not so many. */
static bool list_item(char *out, size_t room, const char *list, int index)
{
    for (; list && index > 0; index--)
        list = (list = strchr(list, ',')) ? list + 1 : NULL;
    if (!list)
        return false;
    list += strspn(list, " \t");
    size_t n = strcspn(list, ",");
    while (n > 0 && isspace((unsigned char)list[n - 1]))
        n--;
    n = n < room - 1 ? n : room - 1;
    memcpy(out, list, n);
    out[n] = 0;
    return true;
}

typedef struct layout_of_field {
    char name[64];
    vv_type type;
    int components;
} layout_of_field;

static vv_status read_field(layout_of_field *out, vvi_keys *keys, int index)
{
    char text[64];
    int64_t n;
    const char *end;
    *out = (layout_of_field){.type = VV_TYPE_F32, .components = 1};
    if (!list_item(out->name, sizeof out->name, vvi_keys_get(keys, "field"), index))
        snprintf(out->name, sizeof out->name, "field%d", index);
    if (list_item(text, sizeof text, vvi_keys_get(keys, "type"), index) && !vvi_dx_type(&out->type, text))
        return vvi_keys_fail(keys, "type", "is '%.40s', which is not a type of numbers", text);
    if (list_item(text, sizeof text, vvi_keys_get(keys, "structure"), index) && strcasecmp(text, "scalar") != 0) {
        if (!vvi_scan_int(&n, text, &end) || strcasecmp(end, "-vector") != 0 || n < 2 || n > 4096)
            return vvi_keys_fail(keys, "structure", "is '%.40s'; scalar and N-vector are read", text);
        out->components = (int)n;
    }
    return VV_OK;
}

static int count_fields(vvi_keys *keys)
{
    char text[64];
    int n = 0;
    const char *fields = vvi_keys_get(keys, "field");
    while (fields && n < 4096 && list_item(text, sizeof text, fields, n))
        n++;
    return n ? n : 1;
}

/* "msb ieee", "lsb binary", "text" */
static void read_format(bool *text, bool *big_endian, vvi_keys *keys)
{
    const char *format = vvi_keys_get(keys, "format");
    *text = !format || strcasestr(format, "ascii") || strcasestr(format, "text");
    *big_endian = !format || !strcasestr(format, "lsb");
}

/* "bytes 100": what stands before the samples. */
static vv_status read_skip(int64_t *skip, vvi_keys *keys)
{
    const char *header = vvi_keys_get(keys, "header"), *end;
    *skip = 0;
    if (!header)
        return VV_OK;
    if (strncasecmp(header, "bytes", 5) == 0 && vvi_scan_int(skip, header + 5, &end) && *skip >= 0 &&
        *skip <= INT64_C(1) << 50)
        return VV_OK;
    return vvi_keys_fail(keys, "header", "is '%.40s'; only 'bytes N' is read: count the bytes before the data", header);
}

static vv_status choose_field(layout_of_field *chosen, vvi_data_files *files, uint64_t places, vvi_keys *keys,
                              const char *part, vv_notes *notes)
{
    const int n = count_fields(keys);
    uint64_t before = 0;
    bool found = false;
    vv_status st = VV_OK;
    for (int i = 0; i < n && st == VV_OK; i++) {
        layout_of_field f;
        if ((st = read_field(&f, keys, i)) != VV_OK)
            return st;
        const bool this = !found && (!part || strcmp(part, f.name) == 0);
        if (this) {
            *chosen = f;
            found = true;
            files->skip += (int64_t)before;
        }
        before += places * (uint64_t)f.components * vv_type_bytes(f.type);
        if (n > 1 || part)
            st = vvi_notes_part(notes, f.name, vv_type_name(f.type), this);
        if (before > (uint64_t)1 << 60)
            return vvi_keys_fail(keys, "field", "needs more bytes than any file has");
    }
    if (st == VV_OK && !found)
        return vvi_notes_fail_part(notes, VV_E_ARGUMENT, keys->file, "field", part);
    if (st == VV_OK && !part)
        st = vvi_notes_warn_unnamed(notes, keys->file, "fields");
    const char *between = vvi_keys_get(keys, "interleaving");
    if (st == VV_OK && n > 1 && (files->numbers || (between && strncasecmp(between, "record", 6) != 0)))
        return vv_fail_at(VV_E_UNSUPPORTED, keys->file, NULL,
                          "has several fields whose numbers are interleaved; write each field separately");
    return st;
}

static vv_status understand(vv_field_info *info, vvi_data_files *files, vvi_keys *keys, const char *part,
                            vv_notes *notes)
{
    vvi_dx_grid grid = {0};
    layout_of_field field = {0};
    bool big_endian;
    uint64_t places = 1;
    const char *series = vvi_keys_get(keys, "series"), *file = vvi_keys_get(keys, "file");
    vv_status st = read_dims(&grid, keys);
    if (st == VV_OK && !file)
        st = vvi_keys_need(keys, "file");
    if (st == VV_OK && series && strspn(series, " \t1") == 0)
        st = vv_fail_at(VV_E_UNSUPPORTED, keys->file, NULL, "is a 'series'; write each step separately");
    if (st != VV_OK || (st = read_positions(&grid, keys)) != VV_OK || (st = read_skip(&files->skip, keys)) != VV_OK)
        return st;
    const char *dependency = vvi_keys_get(keys, "dependency"), *majority = vvi_keys_get(keys, "majority");
    grid.cells = dependency && strncasecmp(dependency, "connections", 11) == 0;
    for (int a = 0; a < grid.n_axes; a++) {
        const uint64_t n = (uint64_t)(grid.cells ? grid.n[a] - 1 : grid.n[a]);
        if (n == 0 || places > (UINT64_C(1) << 44) / n)
            return vvi_keys_fail(keys, "grid", "has no cells, or more points than any file has");
        places *= n;
    }
    read_format(&files->numbers, &big_endian, keys);
    if ((st = choose_field(&field, files, places, keys, part, notes)) != VV_OK)
        return st;
    info->type = field.type;
    info->components = field.components;
    if (field.components > 1)
        info->meaning = VV_MEANING_VECTOR;
    if (vvi_keys_get(keys, "field"))
        snprintf(info->name, sizeof info->name, "%.63s", field.name);
    vvi_dx_place(info, &files->layout, &grid, majority && strncasecmp(majority, "column", 6) == 0);
    files->layout.swap = !files->numbers && vv_type_bytes(field.type) > 1 && vvi_order_swapped(big_endian);
    return vvi_data_files_add(files, file);
}

vv_status vvi_dx_read_general(vv_field_info *info, vvi_data_files *files, vv_source *source,
                              const vv_read_options *options, vv_notes *notes, vv_job *job)
{
    vvi_keys keys = {.file = vvi_source_name(source)};
    vv_status st = read_keys(&keys, source);
    if (st == VV_OK)
        st = understand(info, files, &keys, options->part, notes);
    vvi_keys_finish(&keys);
    return st;
}
