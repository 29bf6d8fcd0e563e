/* "Dots": the smallest useful volume format. One line of text, "DOTS nx ny nz", then one byte a sample, x fastest. */
#include "format_dots.h"
#include <inttypes.h>
#include <stdlib.h>
#include <string.h>
#include <volvis/sys/io.h>

static int probe(const uint8_t *head, size_t n, const char *path)
{
    return n >= 5 && memcmp(head, "DOTS ", 5) == 0 ? 2 : 0;
}

/* Three whole numbers after the magic word, and nothing behind them. */
static bool parse_sizes(int64_t dims[3], const char *line)
{
    const char *at = line;
    double size;
    for (int axis = 0; axis < 3; axis++) {
        while (*at == ' ')
            at++;
        if (!vv_number_scan(&size, at, &at) || !(size >= 1 && size <= 1e6) || size != (double)(int64_t)size)
            return false;
        dims[axis] = (int64_t)size;
    }
    return *at == '\0';
}

/* The plan: where the samples begin. Nothing is allocated before the file is known to hold what it promises. */
static vv_status read_header(vv_field_info *info_out, void **plan_out, vv_source *source,
                             const vv_read_options *options, vv_notes *notes, vv_job *job)
{
    const char *line;
    bool end, exact;
    uint64_t need;
    vv_status st = vv_source_line(source, &line, 256, &end);
    if (st != VV_OK)
        return st;
    *info_out = vv_field_info_default();
    if (strncmp(line, "DOTS ", 5) != 0 || !parse_sizes(info_out->grid.dims, line + 5))
        return vv_fail_at(VV_E_FORMAT, vv_source_name(source), "1", "expected 'DOTS' and three sizes of at least 1");
    if ((st = vv_field_info_bytes(&need, info_out)) != VV_OK)
        return st;
    const uint64_t left = vv_source_left(source, &exact);
    if (need > left)
        return vv_fail_at(VV_E_FORMAT, vv_source_name(source), "1",
                          "the sizes need %" PRIu64 " bytes of samples but at most %" PRIu64 " follow", need, left);
    uint64_t *start = malloc(sizeof *start);
    if (!start)
        return vv_fail_memory(sizeof *start);
    *start = vv_source_tell(source);
    *plan_out = start;
    return VV_OK;
}

/* Any box, row by row: a crop of a large file reads only what it needs. Without a region: all. */
static vv_status read_box(vv_field **out, const vv_field_info *info, const void *plan, vv_source *source, int64_t frame,
                          const vv_box *region, vv_job *job)
{
    const int64_t *dims = info->grid.dims;
    const vv_box box = region ? *region : (vv_box){.n = {dims[0], dims[1], dims[2]}};
    const int64_t *lo = box.lo, *n = box.n;
    vv_field_info part = *info;
    part.grid = vv_grid_crop(&info->grid, &box);
    void *data;
    vv_status st = vv_field_new_empty(out, &data, &part, job);
    uint8_t *row = data;
    for (int64_t k = lo[2]; st == VV_OK && k < lo[2] + n[2]; k++) {
        for (int64_t j = lo[1]; st == VV_OK && j < lo[1] + n[1]; j++, row += n[0]) {
            const uint64_t at = *(const uint64_t *)plan + (uint64_t)((k * dims[1] + j) * dims[0] + lo[0]);
            if ((st = vv_source_seek(source, at)) == VV_OK)
                st = vv_source_read(source, row, (size_t)n[0], "samples");
        }
    }
    if (st != VV_OK) {
        vv_field_release(*out);
        *out = NULL;
    }
    return st;
}

static vv_status write_dots(vv_sink *sink, const vv_field *const *frames, size_t n_frames,
                            const vv_write_options *options, vv_job *job)
{
    const vv_field_info *info = vv_field_get_info(frames[0]);
    const int64_t *dims = info->grid.dims;
    if (info->type != VV_TYPE_U8 || info->components != 1 || n_frames != 1)
        return vv_fail_at(VV_E_UNSUPPORTED, vv_sink_name(sink), NULL,
                          "dots holds one frame of one u8 a sample; convert with --type u8 first");
    const vv_box box = vv_field_box(frames[0]);
    vv_brick brick;
    vv_status st = vv_field_brick(&brick, frames[0], &box, job);
    if (st != VV_OK)
        return st;
    st = vv_sink_printf(sink, "DOTS %" PRId64 " %" PRId64 " %" PRId64 "\n", dims[0], dims[1], dims[2]);
    for (int64_t k = 0; st == VV_OK && k < dims[2]; k++)
        for (int64_t j = 0; st == VV_OK && j < dims[1]; j++)
            st = vv_sink_write(sink, (const uint8_t *)brick.data + j * brick.stride[1] + k * brick.stride[2],
                               (size_t)dims[0]);
    vv_brick_release(&brick);
    return st;
}

static const char *const suffixes[] = {".dots", NULL};

const vv_format format_dots = {
    .api = VV_FORMAT_API,
    .name = "dots",
    .doc = "bytes after one line of text, an example",
    .suffixes = suffixes,
    .probe = probe,
    .read_header = read_header,
    .free_plan = free,
    .read = read_box,
    .write = write_dots,
};
