/* BigDataViewer's HDF5: setups (channels, angles) by levels by times, each a data set of 16 bits without a sign that
 * says it has one. Where they are is in the .xml beside. https://imagej.net/plugins/bdv (the format's page). */
#include "io/formats/bdv/bdv.h"
#include "core/limits.h"
#include "core/memory.h"
#include "io/formats/hdf5/hdf5.h"
#include "io/placement.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define LEVELS_MOST 32
#define PARTS_MOST 512

/* What the names at the top of the file tell. */
typedef struct contents {
    int n_setups;
    int setup[VVI_BDV_SETUPS];
    int64_t first_frame, last_frame; /* -1: none */
} contents;

/* A letter and at least two digits, nothing else. */
static int64_t number_of(const char *name, char letter)
{
    const size_t n = strspn(name + 1, "0123456789");
    return name[0] == letter && n >= 2 && n <= 9 && !name[1 + n] ? strtol(name + 1, NULL, 10) : -1;
}

static void look(contents *out, const vvi_h5 *h5)
{
    H5G_info_t info;
    *out = (contents){.first_frame = -1, .last_frame = -1};
    if (H5Gget_info(h5->file, &info) < 0 || info.nlinks > vvi_job_limits(h5->job)->files)
        return;
    for (hsize_t i = 0; i < info.nlinks; i++) {
        char name[32];
        const ssize_t n =
            H5Lget_name_by_idx(h5->file, ".", H5_INDEX_NAME, H5_ITER_INC, i, name, sizeof name, H5P_DEFAULT);
        if (n < 1 || n >= (ssize_t)sizeof name)
            continue;
        const int64_t setup = number_of(name, 's'), frame = number_of(name, 't');
        if (setup >= 0 && out->n_setups < VVI_BDV_SETUPS)
            out->setup[out->n_setups++] = (int)setup;
        if (frame >= 0 && (out->first_frame < 0 || frame < out->first_frame))
            out->first_frame = frame;
        if (frame > out->last_frame)
            out->last_frame = frame;
    }
}

bool vvi_bdv_is(const vvi_h5 *h5)
{
    contents c;
    char path[VVI_H5_PATH];
    look(&c, h5);
    if (c.n_setups == 0 || c.first_frame < 0)
        return false;
    vvi_bdv_path(path, c.first_frame, c.setup[0], 0);
    return vvi_h5_has(h5, path);
}

void vvi_bdv_path(char out[VVI_H5_PATH], int64_t frame, int setup, int level)
{
    snprintf(out, VVI_H5_PATH, "/t%05lld/s%02d/%d/cells", (long long)frame, setup, level);
}

/* The views ------------------------------------------------------------------------------------------------------- */

/* "run.h5" has "run.xml" beside it; that it is not there is no failure. */
static bool find_views(vvi_bdv_views *views, const vvi_h5 *h5)
{
    char name[256];
    vv_source *xml;
    const char *slash = strrchr(h5->name, '/'), *base = slash ? slash + 1 : h5->name, *dot = strrchr(base, '.');
    const int n = dot ? (int)(dot - base) : (int)strlen(base);
    if (n < 1 || n > 240)
        return false;
    snprintf(name, sizeof name, "%.*s.xml", n, base);
    if (vvi_source_open_beside(&xml, h5->source, name, h5->job) != VV_OK)
        return false;
    const bool read = vvi_bdv_read_views(views, xml, h5->job) == VV_OK && views->n > 0;
    vvi_source_close(xml);
    return read;
}

static const vvi_bdv_setup *find_setup(const vvi_bdv_views *views, int setup)
{
    for (int i = 0; i < views->n; i++)
        if (views->setup[i].id == setup)
            return &views->setup[i];
    return NULL;
}

/* Levels ---------------------------------------------------------------------------------------------------------- */

static int count_levels(const vvi_h5 *h5, const contents *c, int setup)
{
    char path[VVI_H5_PATH];
    int n = 0;
    for (; n < LEVELS_MOST; n++) {
        vvi_bdv_path(path, c->first_frame, setup, n);
        if (!vvi_h5_has(h5, path))
            break;
    }
    return n;
}

/* How many samples of the finest level one of this level stands for: rows of x, y, z. */
static void find_factors(double out[3], const vvi_h5 *h5, int setup, int level)
{
    char path[64];
    hsize_t dims[2];
    double row[LEVELS_MOST * 3];
    out[0] = out[1] = out[2] = 1;
    snprintf(path, sizeof path, "/s%02d/resolutions", setup);
    const hid_t data = vvi_h5_object(h5, path);
    const hid_t space = data >= 0 && H5Iget_type(data) == H5I_DATASET ? H5Dget_space(data) : -1;
    if (space >= 0 && H5Sget_simple_extent_ndims(space) == 2 && H5Sget_simple_extent_dims(space, dims, NULL) == 2 &&
        dims[1] == 3 && dims[0] <= LEVELS_MOST && (hsize_t)level < dims[0] &&
        vvi_h5_table(row, 3 * (size_t)dims[0], data))
        for (int a = 0; a < 3; a++)
            if (isfinite(row[3 * level + a]) && row[3 * level + a] > 0)
                out[a] = row[3 * level + a];
    if (space >= 0)
        H5Sclose(space);
    if (data >= 0)
        H5Oclose(data);
}

static vv_status take_level(vv_field_info *info, vvi_h5_plan *plan, vvi_h5 *h5, int setup, int level)
{
    plan->level = level;
    plan->set = (vvi_h5_set){0};
    vvi_bdv_path(plan->set.path, plan->first_frame, setup, level);
    const hid_t data = vvi_h5_object(h5, plan->set.path);
    if (data < 0)
        return vv_fail_at(VV_E_FORMAT, h5->name, plan->set.path, "is not there");
    vv_status st = H5Iget_type(data) == H5I_DATASET ? vvi_h5_describe(&plan->set, h5, data)
                                                    : vv_fail_at(VV_E_FORMAT, h5->name, plan->set.path, "is a group");
    if (st == VV_OK)
        st = vvi_h5_check(&plan->set, h5, data);
    H5Oclose(data);
    if (st == VV_OK && plan->set.rank != 3)
        st = vv_fail_at(VV_E_FORMAT, h5->name, plan->set.path, "has %d axes; 3 were expected", plan->set.rank);
    if (st != VV_OK)
        return st;
    vvi_h5_adapt(plan, &plan->set);
    for (int a = 0; a < 3; a++)
        plan->dims[a] = (int64_t)plan->set.dims[a];
    snprintf(plan->roles, sizeof plan->roles, "zyx");
    return vvi_h5_lay_out(info, plan, h5->name);
}

static vv_status take_level_of_first(vv_field_info *info, vvi_h5_plan *plan, vvi_h5 *h5, int level)
{
    return take_level(info, plan, h5, plan->setups[0], level);
}

/* Setups ---------------------------------------------------------------------------------------------------------- */

static bool same_dims(const vvi_h5_plan *plan, vvi_h5 *h5, int a, int b)
{
    vv_field_info info = vv_field_info_default();
    vvi_h5_plan p = *plan, q = *plan;
    return take_level(&info, &p, h5, a, 0) == VV_OK && take_level(&info, &q, h5, b, 0) == VV_OK &&
           p.set.type == q.set.type && memcmp(p.set.dims, q.set.dims, sizeof p.set.dims) == 0;
}

/* The first setup, and those that differ from it by their channel alone. */
static void gather_channels(vvi_h5_plan *plan, vvi_h5 *h5, const contents *c, const vvi_bdv_views *views)
{
    const vvi_bdv_setup *first = find_setup(views, c->setup[0]);
    plan->setups[0] = c->setup[0];
    plan->n_sets = 1;
    for (int i = 1; i < c->n_setups && first && plan->n_sets < VVI_H5_CHANNELS; i++) {
        const vvi_bdv_setup *other = find_setup(views, c->setup[i]);
        if (other && other->others == first->others && other->channel != first->channel && other->channel >= 0 &&
            same_dims(plan, h5, c->setup[0], c->setup[i]))
            plan->setups[plan->n_sets++] = c->setup[i];
    }
}

static vv_status note_parts(const vvi_h5_plan *plan, vvi_h5 *h5, const contents *c, vv_notes *notes)
{
    int n = 0;
    vv_status st = VV_OK;
    for (int i = 0; i < c->n_setups && st == VV_OK; i++)
        for (int level = count_levels(h5, c, c->setup[i]) - 1, l = 0; l <= level && st == VV_OK; l++) {
            vv_field_info info = vv_field_info_default();
            vvi_h5_plan p = *plan;
            char name[32], about[96];
            if (n++ >= PARTS_MOST)
                return vvi_notes_warn(notes, "holds more setups and levels than are listed");
            if ((st = take_level(&info, &p, h5, c->setup[i], l)) != VV_OK)
                break;
            snprintf(name, sizeof name, "s%02d/%d", c->setup[i], l);
            snprintf(about, sizeof about, "%lld x %lld x %lld %s", (long long)p.dims[2], (long long)p.dims[1],
                     (long long)p.dims[0], vv_type_name(p.set.type));
            st = vvi_notes_part(notes, name, about, c->setup[i] == plan->setups[0] && l == plan->level);
        }
    return st;
}

/* "s01/2", or "s01" at the finest level that fits: level is -1 then. */
static bool parse_part(int *setup, int *level, const char *part, const contents *c)
{
    char *end;
    *level = -1;
    if (part[0] != 's')
        return false;
    *setup = (int)strtol(part + 1, &end, 10);
    if (end == part + 1)
        return false;
    if (*end == '/')
        *level = (int)strtol(end + 1, &end, 10);
    for (int i = 0; i < c->n_setups && !*end; i++)
        if (c->setup[i] == *setup)
            return true;
    return false;
}

/* Placement, names ------------------------------------------------------------------------------------------------- */

static vv_status place(vv_field_info *info, const vvi_h5_plan *plan, const vvi_h5 *h5, const vvi_bdv_views *views,
                       vv_notes *notes)
{
    const vvi_bdv_setup *setup = find_setup(views, plan->setups[0]);
    const bool known = setup && setup->voxel[0] > 0 && setup->voxel[1] > 0 && setup->voxel[2] > 0;
    double factor[3], step[3], origin[3];
    find_factors(factor, h5, plan->setups[0], plan->level);
    for (int a = 0; a < 3; a++) {
        const double voxel = known && isfinite(setup->voxel[a]) ? setup->voxel[a] : 1;
        step[a] = voxel * factor[a];
        origin[a] = voxel * (factor[a] - 1) / 2; /* a coarse sample lies in the middle of those it stands for */
    }
    info->grid.index_to_world =
        (vv_affine){{{step[0], 0, 0}, {0, step[1], 0}, {0, 0, step[2]}}, {origin[0], origin[1], origin[2]}};
    if (!known)
        return vvi_notes_warn(notes, "has no .xml beside it that tells the spacing of its samples");
    snprintf(info->grid.unit, sizeof info->grid.unit, "%s", setup->unit[0] ? setup->unit : "units");
    if (strcmp(info->grid.unit, "pixel") == 0 || strcmp(info->grid.unit, "px") == 0)
        snprintf(info->grid.unit, sizeof info->grid.unit, "voxels");
    return VV_OK;
}

static vv_status note_channels(const vvi_h5_plan *plan, const vvi_bdv_views *views, vv_notes *notes)
{
    vv_status st = VV_OK;
    for (int c = 0; c < plan->n_sets && views->n > 0 && st == VV_OK; c++) {
        vv_channel channel = {.name = ""};
        const vvi_bdv_setup *setup = find_setup(views, plan->setups[c]);
        if (setup)
            snprintf(channel.name, sizeof channel.name, "%s", setup->name);
        st = vvi_notes_channel(notes, &channel);
    }
    return st;
}

static vv_status read_with_views(vv_field_info *info, vvi_h5_plan *plan, vvi_h5 *h5, const vvi_bdv_views *views,
                                 const char *part, vv_notes *notes)
{
    contents c;
    int setup = -1, level = -1;
    vv_status st = VV_OK;
    look(&c, h5);
    if (c.n_setups == 0 || c.first_frame < 0)
        return vv_fail_at(VV_E_FORMAT, h5->name, NULL, "holds no setups and times of BigDataViewer");
    plan->kind = VVI_H5_BDV;
    plan->first_frame = c.first_frame;
    if (part && !parse_part(&setup, &level, part, &c))
        return vv_fail_at(VV_E_ARGUMENT, h5->name, NULL, "has no part '%.40s'; s%02d/0 is one: a setup and a level",
                          part, c.setup[0]);
    if (part) {
        plan->n_sets = 1;
        plan->setups[0] = setup;
    } else {
        gather_channels(plan, h5, &c, views);
        if (plan->n_sets < c.n_setups)
            st = vvi_notes_warn(notes, "%d of its %d setups shown; FILE:s%02d is another", plan->n_sets, c.n_setups,
                                c.setup[c.n_setups - 1]);
    }
    info->components = plan->n_sets;
    info->n_frames = c.last_frame - c.first_frame + 1;
    if (st == VV_OK)
        st = level >= 0 ? take_level(info, plan, h5, plan->setups[0], level)
                        : vvi_h5_choose_level(info, plan, h5, count_levels(h5, &c, plan->setups[0]),
                                              take_level_of_first, notes);
    if (st == VV_OK)
        st = place(info, plan, h5, views, notes);
    if (st == VV_OK)
        st = note_channels(plan, views, notes);
    return st == VV_OK ? note_parts(plan, h5, &c, notes) : st;
}

vv_status vvi_bdv_header(vv_field_info *info, vvi_h5_plan *plan, vvi_h5 *h5, const vvi_bdv_views *given,
                         const char *part, vv_notes *notes)
{
    vvi_bdv_views *views = vvi_alloc_zeroed(h5->job, sizeof *views, VVI_MEM_SCRATCH);
    if (!views)
        return vv_fail_memory(sizeof *views);
    if (given)
        *views = *given;
    else if (!find_views(views, h5))
        *views = (vvi_bdv_views){0};
    const vv_status st = read_with_views(info, plan, h5, views, part, notes);
    vvi_free(views);
    return st;
}
