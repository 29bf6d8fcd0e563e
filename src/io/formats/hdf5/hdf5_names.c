/* What components and labels are called, as we write it beside a data set; and a data set in words. */
#include "core/memory.h"
#include "core/text.h"
#include "io/formats/hdf5/hdf5.h"
#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define NUMBERS_MOST 8192
#define LABELS_MOST (NUMBERS_MOST / 6)
#define NAMES_MOST 65536

/* The next line of `rest`, cut to what a name holds. */
static void next_name(char out[64], char **rest)
{
    const char *line = *rest ? strsep(rest, "\n") : "";
    snprintf(out, 64, "%.63s", line ? line : "");
    vvi_text_clean(out);
}

static vv_color color_of(const double *v)
{
    vv_color color = {v[0], v[1], v[2], v[3]};
    double *part[4] = {&color.r, &color.g, &color.b, &color.a};
    for (int i = 0; i < 4; i++)
        *part[i] = isfinite(*part[i]) ? fmin(fmax(*part[i], 0), 1) : 1;
    return color;
}

static vv_status note_channels(vv_notes *notes, const double *row, int n, char *names, int components)
{
    vv_status st = VV_OK;
    for (int c = 0; c < n && n == components && st == VV_OK; c++, row += 7) {
        vv_channel channel = {.has_color = row[0] > 0, .color = color_of(row + 1)};
        next_name(channel.name, &names);
        if (isfinite(row[5]) && isfinite(row[6]) && row[6] > row[5]) {
            channel.lo = row[5];
            channel.hi = row[6];
        }
        st = vvi_notes_channel(notes, &channel);
    }
    return st;
}

/* ids: NULL where the rows have all digits. */
static vv_status note_labels(vv_notes *notes, const double *row, int n, const vv_label_id *ids, char *names)
{
    vv_status st = VV_OK;
    for (int i = 0; i < n && st == VV_OK; i++, row += 6) {
        vv_label label = {.has_color = row[1] > 0, .color = color_of(row + 2)};
        next_name(label.name, &names);
        if (!ids && !(fabs(row[0]) < 0x1p62))
            continue;
        label.value = ids ? ids[i] : (vv_label_id)row[0];
        st = vvi_notes_label(notes, &label);
    }
    return st;
}

vv_status vvi_h5_note_names(vv_notes *notes, hid_t data, int components)
{
    double *row = vvi_calloc(NUMBERS_MOST, sizeof *row);
    vv_label_id *ids = vvi_calloc(LABELS_MOST, sizeof *ids);
    char *names = vvi_calloc(1, NAMES_MOST);
    vv_status st = row && ids && names ? VV_OK : vv_fail_memory(NUMBERS_MOST * sizeof *row);
    if (st == VV_OK) {
        const int n = vvi_h5_numbers(row, NUMBERS_MOST, data, "channels") / 7;
        vvi_h5_text(names, NAMES_MOST, data, "channel_names");
        st = note_channels(notes, row, n, names, components);
    }
    if (st == VV_OK) {
        const int n = vvi_h5_numbers(row, NUMBERS_MOST, data, "labels") / 6;
        const bool exact = n > 0 && vvi_h5_label_ids(ids, LABELS_MOST, data, "label_ids") == n;
        vvi_h5_text(names, NAMES_MOST, data, "label_names");
        st = note_labels(notes, row, n, exact ? ids : NULL, names);
    }
    free(row);
    free(ids);
    free(names);
    return st;
}

/* Names of an enumeration's values. */
vv_status vvi_h5_note_members(vv_notes *notes, hid_t data)
{
    const hid_t type = H5Dget_type(data), base = H5Tget_super(type);
    const int n = H5Tget_nmembers(type);
    const bool is_signed = H5Tget_sign(base) == H5T_SGN_2;
    vv_status st = VV_OK;
    for (int i = 0; i < n && i < 4096 && st == VV_OK; i++) {
        vv_label label = {.name = ""};
        uint8_t value[16] = {0};
        char *name = H5Tget_member_name(type, (unsigned)i);
        const bool read =
            name && H5Tget_size(type) <= 8 && H5Tget_member_value(type, (unsigned)i, value) >= 0 &&
            H5Tconvert(base, is_signed ? H5T_NATIVE_INT64 : H5T_NATIVE_UINT64, 1, value, NULL, H5P_DEFAULT) >= 0;
        if (read) {
            snprintf(label.name, sizeof label.name, "%.63s", name);
            vvi_text_clean(label.name);
            memcpy(&label.value, value, sizeof label.value);
            st = vvi_notes_label(notes, &label);
        }
        H5free_memory(name);
    }
    H5Tclose(base);
    H5Tclose(type);
    return st;
}

/* For people ------------------------------------------------------------------------------------------------------ */

static void add_shape(vvi_text *t, const hsize_t *n, int rank)
{
    for (int a = rank - 1; a >= 0; a--)
        vvi_text_printf(t, "%s%" PRIu64, a < rank - 1 ? " x " : "", (uint64_t)n[a]);
}

void vvi_h5_about(char *out, size_t room, const vvi_h5_set *set)
{
    vvi_text t = {0};
    add_shape(&t, set->dims, set->rank);
    vvi_text_printf(&t, " %s", set->half ? "f16" : vv_type_name(set->type));
    if (set->chunked) {
        vvi_text_add(&t, ", chunks ");
        add_shape(&t, set->chunk, set->rank);
    }
    for (int i = 0; i < set->n_filters; i++)
        vvi_text_printf(&t, ", %s", set->filter[i].name);
    snprintf(out, room, "%s", t.s && !t.bad ? t.s : "");
    vvi_text_free(&t);
}
