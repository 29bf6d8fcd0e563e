#include "core/memory.h"
#include "io/formats/vvh/vvh.h"
#include "io/placement.h"
#include "io/sample_writer.h"
#include "io/source.h"
#include <inttypes.h>
#include <stdlib.h>
#include <string.h>

const char *const vvi_vvh_encodings[] = {"raw", "gzip", NULL};

/* Writing ------------------------------------------------------------------------------------------------------------
 */

static void add_place(vvi_text *t, const vv_grid *grid)
{
    double spacing[3], d[9];
    const vv_vec3 o = grid->index_to_world.origin;
    const double origin[3] = {o.x, o.y, o.z};
    for (int a = 0; a < 3; a++) {
        const vv_vec3 v = grid->index_to_world.axis[a];
        spacing[a] = vvi_length(v);
        d[3 * a] = v.x / spacing[a];
        d[3 * a + 1] = v.y / spacing[a];
        d[3 * a + 2] = v.z / spacing[a];
    }
    if (!vvi_is_identity(&grid->index_to_world)) {
        vvi_keys_print_numbers(t, "spacing", ":", spacing, 3);
        vvi_keys_print_numbers(t, "origin", ":", origin, 3);
        vvi_keys_print_numbers(t, "directions", ":", d, 9);
    }
    vvi_text_add(t, grid->space == VV_SPACE_RAS ? "space: RAS\n" : "");
    vvi_keys_print(t, "unit", ": ", grid->unit);
}

static void build_header(vvi_text *t, const vv_field_info *info, size_t n_frames, bool big, const char *data)
{
    const int64_t *n = info->grid.dims;
    vvi_text_printf(t, "# written by VolVis\ndims: %" PRId64 " %" PRId64 " %" PRId64 "\ntype: %s\n", n[0], n[1], n[2],
                    vv_type_name(info->type));
    if (vv_type_bytes(info->type) > 1)
        vvi_text_printf(t, "byte order: %s\n", big ? "big" : "little");
    if (info->components > 1)
        vvi_text_printf(t, "components: %d\n", info->components);
    if (info->components > 1 || info->meaning != VV_MEANING_SCALAR)
        vvi_keys_print(t, "meaning", ": ", vvi_meaning_name(info->meaning));
    add_place(t, &info->grid);
    if (info->value_scale != 1)
        vvi_keys_print_numbers(t, "scale", ":", &info->value_scale, 1);
    if (info->value_offset != 0)
        vvi_keys_print_numbers(t, "offset", ":", &info->value_offset, 1);
    vvi_keys_print(t, "value unit", ": ", info->value_unit);
    vvi_keys_print(t, "name", ": ", info->name);
    if (n_frames > 1)
        vvi_text_printf(t, "frames: %zu\n", n_frames);
    if (n_frames > 1 && info->frame_step != 0)
        vvi_keys_print_numbers(t, "frame step", ":", &info->frame_step, 1);
    vvi_keys_print(t, "frame unit", ": ", info->frame_unit);
    vvi_keys_print(t, "data", ": ", data);
}

/* "head.vvh" has its samples in "head.raw", or "head.raw.gz", which its name alone says is coded. */
static char *data_name(const char *path, bool gzip)
{
    const char *slash = strrchr(path, '/'), *base = slash ? slash + 1 : path, *dot = strrchr(base, '.');
    return vvi_asprintf("%.*s%s", dot ? (int)(dot - base) : (int)strlen(base), base, gzip ? ".raw.gz" : ".raw");
}

vv_status vvi_vvh_write(vv_sink *sink, const vv_field *const *frames, size_t n_frames, const vv_write_options *options,
                        vv_job *job)
{
    const bool gzip = options->encoding && strcmp(options->encoding, "gzip") == 0;
    vvi_text header = {0};
    vv_sink *data;
    char *name = data_name(vvi_sink_name(sink), gzip);
    if (!name)
        return vv_fail_memory(strlen(vvi_sink_name(sink)));
    vvi_log_lost_names(sink, options, 0, "vvh", job);
    build_header(&header, vv_field_get_info(frames[0]), n_frames, options->big_endian, name);
    vv_status st = header.bad ? vv_fail_memory(header.n) : vvi_sink_write(sink, header.s, header.n);
    if (st == VV_OK)
        st = vvi_sink_beside_on_line(&data, sink, name);
    if (st == VV_OK && gzip)
        st = vvi_sink_coding(data, VVI_CODING_GZIP, options->level);
    for (size_t f = 0; f < n_frames && st == VV_OK; f++)
        st = vvi_samples_write(data, frames[f], -1, options->big_endian, job);
    vvi_text_free(&header);
    free(name);
    return st;
}
