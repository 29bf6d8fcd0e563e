/* The World that a data file or a field alone becomes: something is always to be seen. */
#include "core/job.h"
#include "core/property_impl.h"
#include "model/context.h"
#include "model/dataset.h"
#include <ctype.h>
#include <string.h>
#include <sys/stat.h>

/* Both lights hang on the camera, so that every view is lit: the key from the upper left, a weaker fill from the right.
 */
#define KEY_LIGHT                                                                                                      \
    "{\"frame\": \"camera\", \"kind\": \"directional\", \"direction\": [0.5, -0.6, -0.8], \"intensity\": 0.9}"
#define FILL_LIGHT                                                                                                     \
    "{\"frame\": \"camera\", \"kind\": \"directional\", \"direction\": [-0.8, 0.1, -0.6], \"intensity\": 0.3}"

/* Three sides of the data at once: what a person turns to first. */
#define MAIN_VIEW "{\"camera\": {\"azimuth\": 30, \"elevation\": 15}}"

/* A world in the making; after a failure the further steps do nothing. */
typedef struct making {
    vv_object *world;
    vv_property_context context;
    vv_status st;
} making;

static void add(making *m, const char *map, const char *id, const char *json)
{
    if (m->st == VV_OK)
        m->st = vv_path_add(&m->world, map, id, json, &m->context);
}

/* Text as it is, whatever it looks like. */
static void set_text(making *m, const char *object, const char *name, const char *value)
{
    vvi_text json = {0};
    if (m->st != VV_OK || !value)
        return;
    char *path = vvi_asprintf("%s%s%s", object, *object ? "." : "", name);
    vvi_text_json(&json, value);
    char *quoted = vvi_text_take(&json);
    m->st = path && quoted ? vv_path_set(&m->world, path, quoted, &m->context) : vv_fail_memory(strlen(value));
    free(path);
    free(quoted);
}

static void add_volume(making *m, const char *id, const vv_field_info *info)
{
    char json[256];
    const bool labels = info->meaning == VV_MEANING_LABEL;
    snprintf(json, sizeof json, "{\"data\": \"%s\"%s}", id,
             labels ? ", \"interpolation\": \"nearest\", \"segmentation\": {\"kind\": \"labels\"}" : "");
    add(m, "volumes", id, json);
}

static vv_status finish(vv_world **out, making *m)
{
    if (m->st != VV_OK) {
        vv_object_release(m->world);
        return m->st;
    }
    *out = (vv_world *)m->world;
    return VV_OK;
}

static making begin(vv_job *job)
{
    making m = {.context = vvi_registry_context(vvi_job_registry(job))};
    m.st = vv_object_new(&m.world, &vv_world_class, &m.context);
    return m;
}

/* Everything but the dataset itself. */
static void furnish(making *m, const char *id, const vv_field_info *info)
{
    set_text(m, "", "unit", info->grid.unit);
    add_volume(m, id, info);
    add(m, "lights", "key", KEY_LIGHT);
    add(m, "lights", "fill", FILL_LIGHT);
    add(m, "views", "main", MAIN_VIEW);
}

vv_status vv_world_for_field(vv_world **out, const char *id, const vv_field *field, vv_job *job)
{
    vv_object *dataset = NULL;
    char path[VVI_ID_MOST + 16];
    *out = NULL;
    if (!vvi_id_valid(id))
        return vv_fail(VV_E_ARGUMENT,
                       "'%.80s' is no name: expected 1 to %d letters, digits, _ and -, not starting "
                       "with a digit or -",
                       id, VVI_ID_MOST);
    making m = begin(job);
    if (m.st == VV_OK)
        m.st = vv_object_new(&dataset, &vv_dataset_class, &m.context);
    if (m.st == VV_OK)
        m.st = vvi_dataset_attach((vv_dataset *)dataset, field);
    snprintf(path, sizeof path, "datasets.%s", id);
    if (m.st == VV_OK)
        m.st = vv_path_put(&m.world, path, dataset, &m.context);
    vv_object_release(dataset);
    furnish(&m, id, vv_field_get_info(field));
    return finish(out, &m);
}

/* "/data/MRI head.nii.gz" gives "MRI_head"; what would start with a digit gets a letter in front. */
static void id_from_path(char out[VVI_ID_MOST + 1], const char *path)
{
    const char *slash = strrchr(path, '/'), *name = slash ? slash + 1 : path;
    size_t n = 0;
    if (!isalpha((unsigned char)*name) && *name != '_')
        out[n++] = 'v';
    for (; *name && *name != '.' && n < VVI_ID_MOST; name++) {
        const bool plain = (*name & 0x80) == 0 && (isalnum((unsigned char)*name) || *name == '-' || *name == '_');
        out[n++] = plain ? *name : '_';
    }
    out[n] = 0;
}

/* Streams can be read only once: what they hold is read at once and kept with the World. */
static bool is_stream(const char *path)
{
    struct stat s;
    return !strcmp(path, "-") || (!stat(path, &s) && !S_ISREG(s.st_mode) && !S_ISDIR(s.st_mode));
}

static vv_status world_for_stream(vv_world **out, const char *id, vv_file *file, vv_job *job)
{
    vv_field *field = NULL;
    vv_status st = vv_file_read(&field, file, 0, NULL, job);
    if (st == VV_OK)
        st = vv_world_for_field(out, id, field, job);
    vv_field_release(field);
    return st;
}

static vv_status world_for_open_file(vv_world **out, const char *id, const char *path, const vv_read_options *options,
                                     const vv_field_info *info, vv_job *job)
{
    char dataset[VVI_ID_MOST + 16];
    making m = begin(job);
    add(&m, "datasets", id, NULL);
    snprintf(dataset, sizeof dataset, "datasets.%s", id);
    set_text(&m, dataset, "path", path);
    set_text(&m, dataset, "format", options ? options->format : NULL);
    set_text(&m, dataset, "raw", options ? options->raw : NULL);
    furnish(&m, id, info);
    return finish(out, &m);
}

vv_status vv_world_for_file(vv_world **out, const char *path, const vv_read_options *options, vv_job *job)
{
    char id[VVI_ID_MOST + 1];
    vv_file *file = NULL;
    *out = NULL;
    id_from_path(id, strcmp(path, "-") ? path : "data");
    vv_status st = vv_file_open(&file, path, options, job);
    if (st != VV_OK)
        return st;
    st = is_stream(path) ? world_for_stream(out, id, file, job)
                         : world_for_open_file(out, id, path, options, vv_file_info(file), job);
    vv_file_close(file);
    return st;
}
