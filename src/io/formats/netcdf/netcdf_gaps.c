/* The attributes of a data set by which CF tells what its numbers mean, and what that makes of its plan. */
#include "io/formats/hdf5/hdf5.h"
#include <string.h>

static int numbers_of(double *out, int most, const void *user, const char *name)
{
    return vvi_h5_numbers(out, most, *(const hid_t *)user, name);
}

static bool text_of(char *out, size_t room, const void *user, const char *name)
{
    return vvi_h5_text(out, room, *(const hid_t *)user, name);
}

static bool is_float(const void *user, const char *name)
{
    const hid_t id = H5Aopen(*(const hid_t *)user, name, H5P_DEFAULT), type = id >= 0 ? H5Aget_type(id) : -1;
    const bool found = type >= 0 && H5Tget_class(type) == H5T_FLOAT;
    if (type >= 0)
        H5Tclose(type);
    if (id >= 0)
        H5Aclose(id);
    return found;
}

static vvi_cf_attributes attributes_of(const hid_t *data)
{
    return (vvi_cf_attributes){.user = data, .numbers = numbers_of, .is_float = is_float, .text = text_of};
}

void vvi_netcdf_packing(double *scale, double *offset, hid_t data)
{
    const vvi_cf_attributes of = attributes_of(&data);
    vvi_cf_packing(scale, offset, &of);
}

/* Numbers that are names, or colours. */
static bool are_labels(const vvi_h5_plan *plan, hid_t data)
{
    const vvi_h5_set *set = &plan->set;
    char meaning[16];
    const char *c = strchr(plan->roles, 'c');
    const int64_t n = c ? plan->dims[c - plan->roles] : 1;
    return set->names || set->truth || (set->type == VV_TYPE_U8 && (n == 3 || n == 4)) ||
           (vvi_h5_text(meaning, sizeof meaning, data, "meaning") && strcmp(meaning, "scalar") != 0);
}

/* Bytes of the data set that become NaN. */
static void take_lost(vvi_h5_plan *plan, hid_t data)
{
    static const char *const names[] = {"_FillValue", "missing_value"};
    double value;
    memcpy(plan->gap, plan->set.lost, sizeof plan->gap);
    for (int i = 1; i >= 0 && !vv_type_is_float(plan->set.type); i--) {
        uint8_t bytes[16] = {0};
        if (vvi_h5_numbers(&value, 1, data, names[i]) != 1)
            continue;
        const hid_t id = H5Aopen(data, names[i], H5P_DEFAULT), type = H5Dget_type(data);
        const hid_t space = id >= 0 ? H5Aget_space(id) : -1;
        if (space >= 0 && H5Sget_simple_extent_npoints(space) == 1 && H5Tget_size(type) <= sizeof bytes &&
            H5Aread(id, type, bytes) >= 0)
            memcpy(plan->gap, bytes, sizeof bytes);
        if (space >= 0)
            H5Sclose(space);
        if (type >= 0)
            H5Tclose(type);
        if (id >= 0)
            H5Aclose(id);
    }
}

vv_status vvi_netcdf_take_gaps(vvi_h5_plan *plan, hid_t data, vv_notes *notes)
{
    const vvi_cf_attributes of = attributes_of(&data);
    vvi_cf_take_gaps(&plan->gaps, plan->set.type, are_labels(plan, data), &of);
    if (plan->gaps.turned && (plan->set.convert || plan->set.names || plan->set.truth))
        plan->gaps.turned = false; /* numbers that the library makes: their bits are not those of the file */
    if (plan->gaps.any)
        take_lost(plan, data);
    vvi_h5_adapt(plan, &plan->set);
    return vvi_cf_note_gaps(&plan->gaps, notes);
}
