/* Imaris .ims: HDF5 with a pyramid of levels, times and channels that are data sets of their own, padded to whole
 * chunks; what is known of them is text, a letter at a time. The format's page: imaris.oxinst.com, "Imaris 5.5 file
 * format". */
#include "core/memory.h"
#include "core/text.h"
#include "io/formats/hdf5/hdf5.h"
#include "io/scan.h"
#include <math.h>
#include <stdio.h>
#include <string.h>
#include <time.h>
#include <volvis/image.h>

#define LEVELS_MOST 32
#define CHANNELS_MOST 256

bool vvi_imaris_is(const vvi_h5 *h5)
{
    return vvi_h5_has(h5, "/DataSetInfo/Image") && vvi_h5_has(h5, "/DataSet/ResolutionLevel 0/TimePoint 0");
}

void vvi_imaris_path(char out[VVI_H5_PATH], int level, int64_t frame, int channel)
{
    snprintf(out, VVI_H5_PATH, "/DataSet/ResolutionLevel %d/TimePoint %lld/Channel %d/Data", level, (long long)frame,
             channel);
}

/* How many groups of a name with numbers from 0 on there are. */
static int64_t count_groups(const vvi_h5 *h5, const char *format, int64_t most)
{
    char path[VVI_H5_PATH];
    int64_t n = 0;
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wformat-nonliteral"
    for (; n < most; n++) {
        snprintf(path, sizeof path, format, (long long)n);
        if (!vvi_h5_has(h5, path))
            break;
    }
#pragma GCC diagnostic pop
    return n;
}

/* Sizes without the padding: on the group of a channel, or for all on the image. */
static vv_status take_sizes(vvi_h5_plan *plan, const vvi_h5 *h5)
{
    static const char *const names[3] = {"ImageSizeZ", "ImageSizeY", "ImageSizeX"};
    char path[VVI_H5_PATH];
    vvi_imaris_path(path, plan->level, 0, 0);
    path[strlen(path) - strlen("/Data")] = 0;
    const hid_t group = vvi_h5_object(h5, path);
    for (int a = 0; a < 3; a++) {
        double n = (double)plan->set.dims[a];
        vvi_h5_numbers(&n, 1, group, names[a]);
        if (!(n >= 1 && n <= (double)plan->set.dims[a])) {
            H5Oclose(group);
            return vv_fail_at(VV_E_FORMAT, h5->name, path, "%s is %g; 1 to %llu were expected", names[a], n,
                              (unsigned long long)plan->set.dims[a]);
        }
        plan->dims[a] = (int64_t)n;
    }
    H5Oclose(group);
    return VV_OK;
}

/* The data set of one level and what it holds. */
static vv_status take_level(vv_field_info *info, vvi_h5_plan *plan, vvi_h5 *h5, int level)
{
    plan->level = level;
    plan->set = (vvi_h5_set){0};
    vvi_imaris_path(plan->set.path, level, 0, 0);
    const hid_t data = vvi_h5_object(h5, plan->set.path);
    if (data < 0)
        return vv_fail_at(VV_E_FORMAT, h5->name, plan->set.path, "is not there");
    vv_status st = vvi_h5_describe(&plan->set, h5, data);
    if (st == VV_OK)
        st = vvi_h5_check(&plan->set, h5, data);
    H5Oclose(data);
    if (st == VV_OK && plan->set.rank != 3)
        st = vv_fail_at(VV_E_FORMAT, h5->name, plan->set.path, "has %d axes; 3 were expected", plan->set.rank);
    if (st == VV_OK)
        st = take_sizes(plan, h5);
    snprintf(plan->roles, sizeof plan->roles, "zyx");
    return st == VV_OK ? vvi_h5_lay_out(info, plan, h5->name) : st;
}

static vv_status note_levels(vv_field_info info, vvi_h5_plan plan, vvi_h5 *h5, int n_levels, vv_notes *notes)
{
    const int chosen = plan.level;
    vv_status st = VV_OK;
    for (int level = 0; level < n_levels && st == VV_OK && n_levels > 1; level++) {
        char name[32], about[96];
        if ((st = take_level(&info, &plan, h5, level)) != VV_OK)
            break;
        snprintf(name, sizeof name, "level%d", level);
        snprintf(about, sizeof about, "%lld x %lld x %lld %s", (long long)plan.dims[2], (long long)plan.dims[1],
                 (long long)plan.dims[0], vv_type_name(plan.set.type));
        st = vvi_notes_part(notes, name, about, level == chosen);
    }
    return st;
}

/* What is known of it ---------------------------------------------------------------------------------------------- */

static void place(vv_field_info *info, hid_t image)
{
    char text[64];
    double step[3], origin[3];
    for (int a = 0; a < 3; a++) {
        const char lo_name[] = {'E', 'x', 't', 'M', 'i', 'n', (char)('0' + a), 0};
        const char hi_name[] = {'E', 'x', 't', 'M', 'a', 'x', (char)('0' + a), 0};
        double lo, hi;
        if (vvi_h5_numbers(&lo, 1, image, lo_name) != 1 || vvi_h5_numbers(&hi, 1, image, hi_name) != 1 ||
            !isfinite(lo) || !isfinite(hi) || !(hi > lo))
            return;
        step[a] = (hi - lo) / (double)info->grid.dims[a]; /* the ends are those of the outermost samples' cells */
        origin[a] = lo + step[a] / 2;
    }
    info->grid.index_to_world =
        (vv_affine){{{step[0], 0, 0}, {0, step[1], 0}, {0, 0, step[2]}}, {origin[0], origin[1], origin[2]}};
    snprintf(info->grid.unit, sizeof info->grid.unit, "um");
    if (vvi_h5_text(text, sizeof text, image, "Unit"))
        vvi_unit_name(info->grid.unit, text, strlen(text));
}

static vv_status note_channels(vv_notes *notes, const vvi_h5 *h5, int n)
{
    vv_status st = VV_OK;
    for (int c = 0; c < n && st == VV_OK; c++) {
        char path[64];
        double value[3];
        vv_channel channel = {.name = ""};
        snprintf(path, sizeof path, "/DataSetInfo/Channel %d", c);
        const hid_t group = vvi_h5_object(h5, path);
        if (group >= 0) {
            vvi_h5_text(channel.name, sizeof channel.name, group, "Name");
            if (vvi_h5_numbers(value, 3, group, "Color") == 3) {
                channel.has_color = true;
                channel.color = (vv_color){(float)vv_srgb_decode(fmin(fmax(value[0], 0), 1)),
                                           (float)vv_srgb_decode(fmin(fmax(value[1], 0), 1)),
                                           (float)vv_srgb_decode(fmin(fmax(value[2], 0), 1)), 1};
            }
            if (vvi_h5_numbers(value, 2, group, "ColorRange") == 2 && isfinite(value[0]) && value[1] > value[0] &&
                isfinite(value[1])) {
                channel.lo = value[0];
                channel.hi = value[1];
            }
            H5Oclose(group);
        }
        st = vvi_notes_channel(notes, &channel);
    }
    return st;
}

/* "2010-01-31 13:45:10.250" in seconds. */
static bool read_time(double *out, hid_t group, const char *name)
{
    char text[64];
    struct tm t = {0};
    double seconds;
    if (!vvi_h5_text(text, sizeof text, group, name) ||
        sscanf(text, "%d-%d-%d %d:%d:%lf", &t.tm_year, &t.tm_mon, &t.tm_mday, &t.tm_hour, &t.tm_min, &seconds) != 6 ||
        t.tm_year < 1900 || t.tm_year > 9999)
        return false;
    t.tm_year -= 1900;
    t.tm_mon -= 1;
    *out = (double)timegm(&t) + seconds;
    return isfinite(*out);
}

static void take_time(vv_field_info *info, const vvi_h5 *h5)
{
    const hid_t group = vvi_h5_object(h5, "/DataSetInfo/TimeInfo");
    double first, second;
    if (group < 0)
        return;
    if (read_time(&first, group, "TimePoint1") && read_time(&second, group, "TimePoint2") && second > first) {
        info->frame_step = second - first;
        snprintf(info->frame_unit, sizeof info->frame_unit, "s");
    }
    H5Oclose(group);
}

/* "level2", or the number alone. */
static bool parse_level(int *out, const char *part, int n_levels)
{
    int64_t level;
    const char *end;
    if (strncmp(part, "level", 5) == 0)
        part += 5;
    if (!vvi_scan_int(&level, part, &end) || *end || level < 0 || level >= n_levels)
        return false;
    *out = (int)level;
    return true;
}

vv_status vvi_imaris_header(vv_field_info *info, vvi_h5_plan *plan, vvi_h5 *h5, const char *part, vv_notes *notes)
{
    const int n_levels = (int)count_groups(h5, "/DataSet/ResolutionLevel %lld", LEVELS_MOST);
    int level;
    vv_status st;
    plan->kind = VVI_H5_IMARIS;
    plan->n_sets = (int)count_groups(h5, "/DataSet/ResolutionLevel 0/TimePoint 0/Channel %lld", CHANNELS_MOST);
    info->components = plan->n_sets > 0 ? plan->n_sets : 1;
    info->n_frames = count_groups(h5, "/DataSet/ResolutionLevel 0/TimePoint %lld", 1 << 20);
    if (!part)
        st = vvi_h5_choose_level(info, plan, h5, n_levels, take_level, notes);
    else if (parse_level(&level, part, n_levels))
        st = take_level(info, plan, h5, level);
    else
        return vv_fail_at(VV_E_ARGUMENT, h5->name, NULL, "has no part '%.40s'; there are level0 to level%d", part,
                          n_levels - 1);
    if (st != VV_OK || (st = note_levels(*info, *plan, h5, n_levels, notes)) != VV_OK)
        return st;
    const hid_t image = vvi_h5_object(h5, "/DataSetInfo/Image");
    place(info, image);
    vvi_h5_text(info->name, sizeof info->name, image, "Name");
    take_time(info, h5);
    st = vvi_h5_note_attributes(notes, image);
    H5Oclose(image);
    return st == VV_OK ? note_channels(notes, h5, plan->n_sets) : st;
}
