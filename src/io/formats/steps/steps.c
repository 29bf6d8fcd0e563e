/* Volumes in a folder that are time steps of one data set: the row of the table, and how a step is read. */
#include "io/formats/steps/steps.h"
#include "core/job.h"
#include "core/memory.h"
#include "grid/field.h"
#include "io/format.h"
#include "io/formats/slices/slices.h"
#include "io/sample_writer.h"
#include "registry.h"
#include <stdlib.h>
#include <string.h>

/* The plan -------------------------------------------------------------------------------------------------------- */

void vvi_steps_free(void *plan)
{
    vvi_steps *steps = plan;
    if (!steps)
        return;
    vv_file_close(steps->open);
    for (size_t i = 0; i < steps->n; i++)
        vvi_free(steps->file[i].name);
    vvi_free(steps->file);
    free(steps->key);
    free(steps->format);
    free(steps->raw);
    free(steps->part);
    vvi_free(steps);
}

static bool copy(char **out, const char *text)
{
    *out = text ? vvi_strdup(text) : NULL;
    return !text || *out;
}

vv_status vvi_steps_new(vvi_steps **out, const vv_read_options *options, const char *part, vv_job *job)
{
    vvi_steps *steps = *out = vvi_alloc_zeroed(job, sizeof *steps, VVI_MEM_MODEL);
    if (!steps)
        return vv_fail_memory(sizeof *steps);
    steps->finest = options->finest;
    return copy(&steps->raw, options->raw) && copy(&steps->part, part) ? VV_OK : vv_fail_memory(sizeof *steps);
}

vv_status vvi_steps_add(vvi_steps *steps, const char *name, const vvi_steps_file *file, vv_job *job)
{
    if ((steps->n & (steps->n - 1)) == 0) { /* room doubles at powers of two */
        const size_t bytes = (steps->n ? steps->n * 2 : 1) * sizeof *steps->file;
        vvi_steps_file *grown = vvi_realloc(job, steps->file, bytes, VVI_MEM_MODEL);
        if (!grown)
            return vv_fail_memory(bytes);
        steps->file = grown;
    }
    const size_t n = strlen(name) + 1;
    vvi_steps_file *to = &steps->file[steps->n];
    *to = *file;
    if (!(to->name = vvi_alloc(job, n, VVI_MEM_MODEL)))
        return vv_fail_memory(n);
    memcpy(to->name, name, n);
    steps->n++;
    return VV_OK;
}

/* Folders --------------------------------------------------------------------------------------------------------- */

static int probe_folder(vv_source *folder, vv_job *job)
{
    vvi_steps_groups groups;
    const bool sure = vvi_steps_find(&groups, folder, NULL, job) == VV_OK && groups.n_groups == 1 &&
                      groups.group[0].sure == VVI_STEPS_SURE;
    vvi_steps_groups_free(&groups);
    return sure ? 2 : 0;
}

/* The one group of files that are steps, or the only one at all. */
static vv_status choose_group(const vvi_steps_group **out, const vvi_steps_groups *groups, const vv_source *folder)
{
    size_t sure = 0;
    *out = NULL;
    for (size_t i = 0; i < groups->n_groups; i++) {
        const vvi_steps_group *one = &groups->group[i];
        sure += one->sure == VVI_STEPS_SURE;
        if (!*out || one->sure > (*out)->sure)
            *out = one;
    }
    const char *name = vvi_source_name(folder);
    if (!*out)
        return vv_fail_at(VV_E_FORMAT, name, NULL, "holds no volumes whose names fit");
    if (sure > 1)
        return vv_fail_at(VV_E_ARGUMENT, name, NULL, "holds several series of time steps; name one, as %s:%.80s", name,
                          (*out)->key);
    if ((*out)->sure == VVI_STEPS_SURE)
        return VV_OK;
    if ((*out)->n == 1)
        return vv_fail_at(VV_E_FORMAT, name, NULL,
                          "holds no files whose names differ in one number; name a file in it");
    return vv_fail_at(VV_E_ARGUMENT, name, NULL,
                      "nothing says that the numbers in the names of its files count time steps; where one does, say "
                      "it by a pattern, as %s:%.80s",
                      name, (*out)->key);
}

static vv_status take_files(vvi_steps *steps, const vvi_steps_groups *groups, const vv_source *folder, vv_job *job)
{
    const vvi_steps_group *group;
    vv_status st = choose_group(&group, groups, folder);
    if (st == VV_OK && !copy(&steps->key, group->key))
        st = vv_fail_memory(strlen(group->key));
    for (size_t i = 0; st == VV_OK && i < group->n; i++) {
        const vvi_steps_entry *entry = &groups->entry[group->first + i];
        const vvi_steps_file file = {.number = entry->number};
        st = vvi_steps_add(steps, groups->names.name[entry->name], &file, job);
    }
    return st;
}

/* A part is a pattern of names, a part of each file, or both: "a_{t}.vti:pressure". */
static vv_status plan_folder(vvi_steps **out, const vv_source *folder, const vv_read_options *options, vv_job *job)
{
    const char *inner = options->part;
    char pattern[512];
    size_t n = 0;
    const bool chosen = options->part && vvi_steps_split(&n, &inner, folder, options->part, job);
    vvi_steps_groups groups = {0};
    vv_status st = vvi_steps_new(out, options, inner, job);
    if (chosen) {
        memcpy(pattern, options->part, n);
        pattern[n] = 0;
    }
    if (st == VV_OK)
        st = vvi_steps_find(&groups, folder, chosen ? pattern : NULL, job);
    if (st == VV_OK)
        st = take_files(*out, &groups, folder, job);
    vvi_steps_groups_free(&groups);
    return st;
}

bool vvi_steps_are_contained(const vv_source *folder, const vv_read_options *options, vv_job *job)
{
    vvi_steps *steps = NULL;
    bool contained = false;
    size_t n;
    if (vvi_source_is_folder(folder) && plan_folder(&steps, folder, options, job) == VV_OK) {
        vvi_path_coding(steps->file[0].name, &n);
        for (const vv_format *const *f = vvi_job_registry(job)->formats; *f; f++)
            contained = contained || ((*f)->contained && vvi_format_has_suffix(*f, steps->file[0].name, n));
    }
    vvi_steps_free(steps);
    return contained;
}

static vv_status read_header(vv_field_info *info, void **plan_out, vv_source *source, const vv_read_options *options,
                             vv_notes *notes, vv_job *job)
{
    vvi_steps *steps = NULL;
    *plan_out = NULL;
    if (!vvi_source_is_folder(source))
        return vv_fail_at(VV_E_FORMAT, vvi_source_name(source), NULL,
                          "is a file; time steps in files of their own are read by the name of their folder");
    vv_status st = plan_folder(&steps, source, options, job);
    if (st == VV_OK)
        st = vvi_steps_open(info, steps, source, notes, job);
    if (st != VV_OK) {
        vvi_steps_free(steps);
        return st;
    }
    *plan_out = steps;
    return VV_OK;
}

/* Samples --------------------------------------------------------------------------------------------------------- */

static vv_status fail_replaced(const vvi_steps *steps, size_t at, const vv_source *source)
{
    return vv_fail_at(VV_E_READ, vvi_source_name(source), NULL,
                      "its file '%.80s' has been replaced by one of another kind since it was opened; open it again",
                      steps->file[at].name);
}

static vv_status open_step(vvi_steps *steps, size_t at, const vv_source *source, vv_job *job)
{
    if (steps->open && steps->open_at == at)
        return VV_OK;
    vv_file_close(steps->open);
    steps->open = NULL;
    vv_status st = vvi_steps_open_file(&steps->open, steps, at, source, job);
    steps->open_at = at;
    if (st != VV_OK)
        return st;
    st = vvi_steps_check(vv_file_info(steps->open), steps->file[at].name, &steps->info, steps->file[0].name, source);
    if (st == VV_OK)
        return VV_OK;
    vv_file_close(steps->open);
    steps->open = NULL;
    return fail_replaced(steps, at, source);
}

typedef struct valuing {
    vv_type from, to;
    double scale, offset;
    uint8_t *out;
} valuing;

static vv_status add_values(void *user, void *data, size_t n_bytes)
{
    enum { PIECE = 512 };
    double values[PIECE];
    valuing *v = user;
    const size_t bytes = vv_type_bytes(v->from);
    const uint8_t *from = data;
    for (size_t left = n_bytes / bytes, n; left > 0; left -= n, from += n * bytes) {
        n = left < PIECE ? left : PIECE;
        vvi_samples_to_f64(values, from, v->from, n);
        for (size_t i = 0; i < n; i++)
            values[i] = values[i] * v->scale + v->offset;
        vvi_samples_from_f64(v->out, values, v->to, n);
        v->out += n * vv_type_bytes(v->to);
    }
    return VV_OK;
}

/* Of stored numbers what they mean; takes the field's place. */
static vv_status make_values(vv_field **field, vv_type type, vv_job *job)
{
    vv_field *made = NULL;
    void *data = NULL;
    vv_field_info info = *vv_field_get_info(*field);
    valuing v = {.from = info.type, .to = type, .scale = info.value_scale, .offset = info.value_offset};
    info.type = type;
    info.value_scale = 1;
    info.value_offset = 0;
    vv_status st = vv_field_new_empty(&made, &data, &info, job);
    v.out = data;
    if (st == VV_OK)
        st = vvi_samples_each(*field, -1, add_values, &v, job);
    vv_field_release(*field);
    *field = st == VV_OK ? made : NULL;
    if (st != VV_OK)
        vv_field_release(made);
    return st;
}

vv_status vvi_steps_read(vv_field **out, const vv_field_info *info, const void *plan, vv_source *source, int64_t frame,
                         const vv_box *region, vv_job *job)
{
    /* which file is open is no part of what the plan says: files are read by one thread at a time */
    vvi_steps *steps = (vvi_steps *)plan;
    vv_field *one = NULL;
    vv_status st = open_step(steps, (size_t)frame, source, job);
    if (st != VV_OK || (st = vv_file_read(&one, steps->open, 0, region, job)) != VV_OK ||
        (steps->values && (st = make_values(&one, info->type, job)) != VV_OK))
        return st;
    if (!steps->values && (vv_field_get_info(one)->value_scale != info->value_scale ||
                           vv_field_get_info(one)->value_offset != info->value_offset)) {
        vv_field_release(one);
        return fail_replaced(steps, (size_t)frame, source);
    }
    vv_field_info now = *vv_field_get_info(one);
    now.frame = frame;
    now.n_frames = info->n_frames;
    now.frame_step = info->frame_step;
    memcpy(now.frame_unit, info->frame_unit, sizeof now.frame_unit);
    st = vvi_field_relabel(out, one, &now);
    vv_field_release(one);
    return st;
}

bool vvi_steps_mappable(const vv_field_info *info, const void *plan)
{
    (void)info;
    return ((const vvi_steps *)plan)->mappable;
}

const vv_format vvi_format_steps = {
    .api = VV_FORMAT_API,
    .name = "steps",
    .doc = "folders of volumes of one size and type, of any format, whose names differ in one number: time steps",
    .probe_folder = probe_folder,
    .read_header = read_header,
    .free_plan = vvi_steps_free,
    .read = vvi_steps_read,
    .mappable = vvi_steps_mappable,
};
