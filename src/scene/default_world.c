/* The World that a data file or a field alone becomes: something is always to be seen. */
#include "core/job.h"
#include "core/property_impl.h"
#include "core/text.h"
#include "core/units.h"
#include "grid/label_id.h"
#include "io/channel_colors.h"
#include "io/mesh_file.h"
#include "model/contents.h"
#include "model/context.h"
#include "model/dataset.h"
#include "model/merge.h"
#include "scene/load.h"
#include <ctype.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <sys/stat.h>
#include <volvis/image.h>
#include <volvis/mesh_file.h>

/* Both lights hang on the camera, so that every view is lit: the key from the upper left, a weaker fill from the right.
 */
#define KEY_LIGHT                                                                                                      \
    "{\"frame\": \"camera\", \"kind\": \"directional\", \"direction\": [0.5, -0.6, -0.8], \"intensity\": 0.9}"
#define FILL_LIGHT                                                                                                     \
    "{\"frame\": \"camera\", \"kind\": \"directional\", \"direction\": [-0.8, 0.1, -0.6], \"intensity\": 0.3}"

/* Three sides of the data at once: what a person turns to first. */
#define MAIN_VIEW "{\"camera\": {\"azimuth\": 30, \"elevation\": 15}}"

/* Positron emission: spots that are hot in a body that is faint and nothing by itself are looked for as the largest
 * value on each ray. */
#define ACTIVITY_VIEW                                                                                                  \
    "{\"camera\": {\"azimuth\": 30, \"elevation\": 15}, \"render\": {\"raycast\": {\"mode\": \"maximum\"}}}"

/* Few slices, which from there would be an edge, are seen face on: across x, y or z as slices are shown, the first row
 * on top, and of anatomical data as radiologists look at them. */
static const char *const flat_views[3] = {"{\"camera\": {\"azimuth\": 90}}", "{\"camera\": {\"azimuth\": 0}}",
                                          "{\"camera\": {\"elevation\": -90}}"};
#define FLAT (1.0 / 8)

/* One slice is an image: as it is, without light, over the window that its file says. */
static const char *const image_views[3] = {
    "{\"render\": {\"method\": \"slice\", \"slice\": {\"orientation\": \"sagittal\", \"axes\": \"samples\"}}}",
    "{\"render\": {\"method\": \"slice\", \"slice\": {\"orientation\": \"coronal\", \"axes\": \"samples\"}}}",
    "{\"render\": {\"method\": \"slice\", \"slice\": {\"orientation\": \"axial\", \"axes\": \"samples\"}}}"};

/* Of a label whose file says that it is opaque, over a voxel: its border is a surface, and what lies behind it dim. */
#define LABEL_OPACITY 0.5

/* A world in the making; after a failure the further steps do nothing. */
typedef struct making {
    bool known_methods; /* the registry has the methods that views name */
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
    if (strcmp(name, "path") == 0)
        vvi_text_json_path(&json, value);
    else
        vvi_text_json(&json, value);
    char *quoted = vvi_text_take(&json);
    m->st = path && quoted ? vv_path_set(&m->world, path, quoted, &m->context) : vv_fail_memory(strlen(value));
    free(path);
    free(quoted);
}

/* What a file says beside the info. */
typedef struct file_names {
    const vv_channel *channels;
    size_t n_channels;
    const vv_label *labels;
    size_t n_labels;
    bool emission; /* of a positron emission tomograph */
} file_names;

/* A volume from its JSON text, which is freed. */
static void add_volume(making *m, const char *id, vvi_text *json)
{
    if (m->st == VV_OK && (json->bad || !json->s))
        m->st = vv_fail_memory(json->n);
    add(m, "volumes", id, json->s);
    vvi_text_free(json);
}

static void add_number(vvi_text *json, const char *before, double value)
{
    char number[32];
    vvi_print_number(number, value);
    vvi_text_printf(json, "%s%s", before, number);
}

/* Channels: a volume for each, from the dark to its colour over its window, or over what the histogram says. */
static void add_channel(making *m, const char *id, const file_names *names, int component)
{
    char volume[VVI_ID_MOST + 16];
    vvi_text json = {0};
    const vv_channel *channel = (size_t)component < names->n_channels ? &names->channels[component] : NULL;
    const vv_color c = vvi_channel_color(names->channels, names->n_channels, (size_t)component);
    vvi_text_printf(&json,
                    "{\"data\": \"%s\", \"component\": %d, \"segmentation\": {\"transfer\": {\"colormap\": "
                    "\"#%02lx%02lx%02lx\"",
                    id, component, lrint(255 * vv_srgb_encode(c.r)), lrint(255 * vv_srgb_encode(c.g)),
                    lrint(255 * vv_srgb_encode(c.b)));
    if (channel && channel->lo < channel->hi) {
        add_number(&json, ", \"range_lo\": ", channel->lo);
        add_number(&json, ", \"range_hi\": ", channel->hi);
    }
    vvi_text_add(&json, "}}");
    if (channel && channel->name[0]) {
        vvi_text_add(&json, ", \"title\": ");
        vvi_text_json(&json, channel->name);
    }
    vvi_text_add(&json, "}");
    snprintf(volume, sizeof volume, "%.*s_%d", VVI_ID_MOST - 8, id, component);
    add_volume(m, volume, &json);
}

static int by_value(const void *a, const void *b)
{
    return vvi_label_compare((*(const vv_label *const *)a)->value, (*(const vv_label *const *)b)->value, false);
}

static int by_unsigned_value(const void *a, const void *b)
{
    return vvi_label_compare((*(const vv_label *const *)a)->value, (*(const vv_label *const *)b)->value, true);
}

/* A row for each colour; what is all round, label 0, stays clear. Opacities are for a voxel, whatever its size. */
static void add_label_rows(vvi_text *json, const vv_label *const *labels, size_t n, bool is_unsigned)
{
    char digits[VVI_LABEL_DIGITS];
    const char *before = "\"table\": [[";
    bool any = false;
    for (size_t i = 0; i < n; i++) {
        const vv_label *l = labels[i];
        if (!l->has_color)
            continue;
        const double row[] = {l->color.r, l->color.g, l->color.b, l->value == 0 ? 0 : LABEL_OPACITY * l->color.a};
        vvi_text_printf(json, "%s\"%s\"", before, vvi_label_print(digits, l->value, is_unsigned));
        for (int k = 0; k < 4; k++)
            add_number(json, ", ", row[k]);
        vvi_text_add(json, "]");
        before = ", [";
        any = true;
    }
    vvi_text_add(json, any ? "], " : "");
}

static void add_label_names(vvi_text *json, const vv_label *const *labels, size_t n, bool is_unsigned)
{
    char digits[VVI_LABEL_DIGITS];
    const char *before = "";
    vvi_text_add(json, "\"names\": [");
    for (size_t i = 0; i < n; i++) {
        if (!labels[i]->name[0])
            continue;
        vvi_text_printf(json, "%s{\"label\": \"%s\", \"name\": ", before,
                        vvi_label_print(digits, labels[i]->value, is_unsigned));
        vvi_text_json(json, labels[i]->name);
        vvi_text_add(json, "}");
        before = ", ";
    }
    vvi_text_add(json, "]");
}

/* That they are labels is not said: what is made of them, and shown here instead, may be none. */
static void add_labels(making *m, const char *id, const vv_field_info *info, const file_names *names)
{
    vvi_text json = {0};
    const bool is_unsigned = vvi_label_is_unsigned(info->type);
    const vv_label **sorted = malloc((names->n_labels + 1) * sizeof(void *));
    if (!sorted) {
        m->st = m->st == VV_OK ? vv_fail_memory((names->n_labels + 1) * sizeof(void *)) : m->st;
        return;
    }
    for (size_t i = 0; i < names->n_labels; i++)
        sorted[i] = &names->labels[i];
    qsort(sorted, names->n_labels, sizeof(void *), is_unsigned ? by_unsigned_value : by_value);
    vvi_text_printf(&json, "{\"data\": \"%s\"", id);
    if (names->n_labels > 0) {
        add_number(&json, ", \"segmentation\": {\"transfer\": {\"opacity_length\": ", vv_grid_voxel(&info->grid));
        vvi_text_add(&json, "}, \"labels\": {");
        add_label_rows(&json, sorted, names->n_labels, is_unsigned);
        add_label_names(&json, sorted, names->n_labels, is_unsigned);
        vvi_text_add(&json, "}}");
    }
    vvi_text_add(&json, "}");
    free(sorted);
    add_volume(m, id, &json);
}

static void add_volumes(making *m, const char *id, const vv_field_info *info, const file_names *names)
{
    vvi_text json = {0};
    if (info->meaning == VV_MEANING_LABEL) {
        add_labels(m, id, info, names);
        return;
    }
    if (vvi_has_channels(info)) {
        for (int c = 0; c < info->components; c++)
            add_channel(m, id, names, c);
        return;
    }
    vvi_text_printf(&json, "{\"data\": \"%s\"", id);
    if (names->n_channels > 0 && names->channels[0].lo < names->channels[0].hi) { /* as a DICOM file has it */
        add_number(&json, ", \"slices\": {\"window_lo\": ", names->channels[0].lo);
        add_number(&json, ", \"window_hi\": ", names->channels[0].hi);
        vvi_text_add(&json, "}");
    }
    vvi_text_add(&json, "}");
    add_volume(m, id, &json);
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
    const vv_registry *registry = vvi_job_registry(job);
    making m = {.context = vvi_registry_context(registry),
                .known_methods =
                    vv_registry_renderer(registry, "slice") == vv_registry_renderer(vv_registry_builtin(), "slice")};
    m.st = vv_object_new(&m.world, &vv_world_class, &m.context);
    return m;
}

static double length_of(vv_vec3 v)
{
    return sqrt(v.x * v.x + v.y * v.y + v.z * v.z);
}

/* The axis across an image, which is the only one with a single sample; -1: there is none. */
static int axis_across(const vv_grid *grid)
{
    int across = -1;
    for (int a = 0; a < 3; a++) {
        if (grid->dims[a] == 1 && across >= 0)
            return -1;
        across = grid->dims[a] == 1 ? a : across;
    }
    return across;
}

static bool is_activity(const vv_field_info *info)
{
    static const char *const units[] = {"Bq/ml", "kBq/ml", "Bq/cc", "SUV", "g/ml"};
    for (size_t i = 0; i < sizeof units / sizeof *units; i++)
        if (strcasecmp(info->value_unit, units[i]) == 0)
            return true;
    return false;
}

/* The axis along which a grid has much less extent than along both others; -1: there is none. */
static int thin_axis(const vv_grid *grid)
{
    double extent[3];
    int thin = 0;
    for (int a = 0; a < 3; a++) {
        extent[a] = (double)grid->dims[a] * length_of(grid->index_to_world.axis[a]);
        thin = extent[a] < extent[thin] ? a : thin;
    }
    for (int a = 0; a < 3; a++)
        if (a != thin && !(extent[thin] < FLAT * extent[a]))
            return -1;
    return thin;
}

/* The axis of the world that one of the grid is nearest to. */
static int world_axis(const vv_grid *grid, int a)
{
    const vv_vec3 *v = &grid->index_to_world.axis[a];
    const double along[3] = {fabs(v->x), fabs(v->y), fabs(v->z)};
    const int nearest = along[1] > along[0] ? 1 : 0;
    return along[2] > along[nearest] ? 2 : nearest;
}

/* An image however few its samples or thick its slice; others by their extent. */
static const char *view_of(const vv_field_info *info, bool emission, bool known_methods)
{
    const int across = axis_across(&info->grid), thin = thin_axis(&info->grid);
    if (known_methods && across >= 0)
        return image_views[world_axis(&info->grid, across)];
    if (thin >= 0)
        return flat_views[world_axis(&info->grid, thin)];
    return known_methods && (emission || is_activity(info)) ? ACTIVITY_VIEW : MAIN_VIEW;
}

/* Lights and a view. */
static void light_up(making *m, const char *view)
{
    add(m, "lights", "key", KEY_LIGHT);
    add(m, "lights", "fill", FILL_LIGHT);
    add(m, "views", "main", view);
}

/* Everything but the dataset itself. */
static void furnish(making *m, const char *id, const vv_field_info *info, const file_names *names)
{
    set_text(m, "", "unit", info->grid.unit);
    add_volumes(m, id, info, names);
    light_up(m, view_of(info, names->emission, m->known_methods));
}

static vv_status check_id(const char *id)
{
    if (vvi_id_valid(id))
        return VV_OK;
    return vv_fail(
        VV_E_ARGUMENT,
        "'%.80s' is not a valid name: expected 1 to %d letters, digits, _ and -, not starting with a digit or -", id,
        VVI_ID_MOST);
}

static vv_status world_for_field(vv_world **out, const char *id, const vv_field *field, const file_names *names,
                                 vv_job *job)
{
    vv_object *dataset = NULL;
    char path[VVI_ID_MOST + 16];
    *out = NULL;
    const vv_status st = check_id(id);
    if (st != VV_OK)
        return st;
    making m = begin(job);
    if (m.st == VV_OK)
        m.st = vv_object_new(&dataset, &vv_dataset_class, &m.context);
    if (m.st == VV_OK)
        m.st = vvi_dataset_attach((vv_dataset *)dataset, field);
    snprintf(path, sizeof path, "datasets.%s", id);
    if (m.st == VV_OK)
        m.st = vv_path_put(&m.world, path, dataset, &m.context);
    vv_object_release(dataset);
    furnish(&m, id, vv_field_get_info(field), names);
    return finish(out, &m);
}

vv_status vv_world_for_field(vv_world **out, const char *id, const vv_field *field, vv_job *job)
{
    static const file_names none;
    return world_for_field(out, id, field, &none, job);
}

static bool is_emission(const vv_file *file)
{
    const char *key, *value;
    for (size_t i = 0; vv_file_metadata(file, i, &key, &value); i++)
        if (strcmp(key, "Modality") == 0)
            return strcmp(value, "PT") == 0;
    return false;
}

static file_names names_of(const vv_file *file)
{
    file_names n = {.emission = is_emission(file)};
    n.channels = vv_file_channels(file, &n.n_channels);
    n.labels = vv_file_labels(file, &n.n_labels);
    return n;
}

_Static_assert(VVI_ID_MOST == 63, "vvi_world_id() needs room for 64 bytes");

/* "/data/MRI head.nii.gz" gives "MRI_head"; what would start with a digit gets a letter in front. */
void vvi_world_id(char out[64], const char *path)
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
    const file_names names = names_of(file);
    if (st == VV_OK)
        st = world_for_field(out, id, field, &names, job);
    vv_field_release(field);
    return st;
}

static vv_status world_for_open_file(vv_world **out, const char *id, const char *path, const vv_read_options *options,
                                     const vv_file *file, vv_job *job)
{
    const file_names names = names_of(file);
    char dataset[VVI_ID_MOST + 16];
    making m = begin(job);
    add(&m, "datasets", id, NULL);
    snprintf(dataset, sizeof dataset, "datasets.%s", id);
    set_text(&m, dataset, "path", path);
    set_text(&m, dataset, "format", options ? options->format : NULL);
    set_text(&m, dataset, "part", options ? options->part : NULL);
    set_text(&m, dataset, "raw", options ? options->raw : NULL);
    furnish(&m, id, vv_file_info(file), &names);
    return finish(out, &m);
}

/* Meshes ---------------------------------------------------------------------------------------------------------- */

static void furnish_mesh(making *m, const char *id, const vv_mesh *mesh)
{
    vvi_text json = {0};
    set_text(m, "", "unit", vv_mesh_get_info(mesh)->unit);
    vvi_text_printf(&json, "{\"data\": \"%s\"}", id);
    add_volume(m, id, &json);
    light_up(m, MAIN_VIEW);
}

/* A stream's mesh is kept with the World. */
static void keep_mesh(making *m, const char *dataset, const vv_mesh *mesh)
{
    vv_object *object = NULL;
    if (m->st == VV_OK)
        m->st = vv_object_new(&object, &vv_dataset_class, &m->context);
    if (m->st == VV_OK && (m->st = vvi_dataset_attach_mesh((vv_dataset *)object, mesh)) == VV_OK)
        m->st = vv_path_put(&m->world, dataset, object, &m->context);
    vv_object_release(object);
}

vv_status vv_world_for_mesh(vv_world **out, const char *id, const vv_mesh *mesh, vv_job *job)
{
    char dataset[VVI_ID_MOST + 16];
    const vv_status st = check_id(id);
    *out = NULL;
    if (st != VV_OK)
        return st;
    snprintf(dataset, sizeof dataset, "datasets.%s", id);
    making m = begin(job);
    keep_mesh(&m, dataset, mesh);
    furnish_mesh(&m, id, mesh);
    return finish(out, &m);
}

vv_status vvi_world_for_mesh(vv_world **out, const char *path, const char *format, const char *part, vv_job *job)
{
    char id[VVI_ID_MOST + 1], dataset[VVI_ID_MOST + 16];
    vv_mesh_read_options options;
    vv_mesh *mesh = NULL;
    *out = NULL;
    vvi_world_id(id, strcmp(path, "-") ? path : "mesh");
    snprintf(dataset, sizeof dataset, "datasets.%s", id);
    making m = begin(job);
    add(&m, "datasets", id, NULL);
    if (is_stream(path)) {
        vv_mesh_read_options_init(&options, sizeof options);
        options.format = format;
        options.part = part;
        m.st = m.st == VV_OK ? vv_mesh_read(&mesh, path, &options, job) : m.st;
        keep_mesh(&m, dataset, mesh);
    } else {
        set_text(&m, dataset, "path", path);
        set_text(&m, dataset, "format", format);
        set_text(&m, dataset, "part", part);
        set_text(&m, dataset, "kind", "mesh");
        if (m.st == VV_OK)
            m.st = vv_dataset_mesh(
                &mesh, NULL, (const vv_dataset *)vv_collection_find(((const vv_world *)m.world)->datasets, id), job);
    }
    if (m.st == VV_OK)
        furnish_mesh(&m, id, mesh);
    vv_mesh_release(mesh);
    return finish(out, &m);
}

vv_status vv_world_for_file(vv_world **out, const char *path, const vv_read_options *options, vv_job *job)
{
    char id[VVI_ID_MOST + 1];
    vv_file *file = NULL;
    *out = NULL;
    const bool plain = !options || (!options->format && !options->raw);
    if (plain && vvi_mesh_is_file(path, job))
        return vvi_world_for_mesh(out, path, NULL, options ? options->part : NULL, job);
    vvi_world_id(id, strcmp(path, "-") ? path : "data");
    vv_status st = vv_file_open(&file, path, options, job);
    if (st != VV_OK)
        return st;
    st =
        is_stream(path) ? world_for_stream(out, id, file, job) : world_for_open_file(out, id, path, options, file, job);
    vv_file_close(file);
    return st;
}

/* Data that are made of others ------------------------------------------------------------------------------------- */

static void show_samples(making *m, const vv_world *from, const vv_dataset *dataset, const char *id, vv_job *job)
{
    vv_field *field = NULL;
    vv_file *file = NULL;
    if (dataset->fields) {
        static const file_names none;
        m->st = vv_dataset_field(&field, from, dataset, NULL, 0, job);
        if (m->st == VV_OK)
            furnish(m, id, vv_field_get_info(field), &none);
    } else if ((m->st = vvi_dataset_open(&file, from, dataset, job)) == VV_OK) {
        const file_names names = names_of(file);
        furnish(m, id, vv_file_info(file), &names);
    }
    vv_field_release(field);
    vv_file_close(file);
}

static void show_mesh(making *m, const vv_world *from, const vv_dataset *dataset, const char *id, vv_job *job)
{
    vv_mesh *mesh = NULL;
    m->st = vv_dataset_mesh(&mesh, from, dataset, job);
    if (m->st == VV_OK)
        furnish_mesh(m, id, mesh);
    vv_mesh_release(mesh);
}

vv_status vvi_world_for_dataset(vv_world **out, const vv_world *from, const char *id, vv_job *job)
{
    const vv_dataset *dataset = vvi_dataset_named(from, id);
    *out = NULL;
    if (!dataset)
        return vv_fail(VV_E_NOT_FOUND, "there is no dataset '%.64s'", id);
    making m = begin(job);
    for (size_t i = 0; i < from->datasets->n && m.st == VV_OK; i++) {
        char path[VVI_ID_MOST + 16];
        snprintf(path, sizeof path, "datasets.%s", from->datasets->entry[i].id);
        m.st = vv_path_put(&m.world, path, from->datasets->entry[i].object, &m.context);
    }
    if (m.st == VV_OK && vv_dataset_is_mesh(dataset, job))
        show_mesh(&m, from, dataset, id, job);
    else if (m.st == VV_OK)
        show_samples(&m, from, dataset, id, job);
    return finish(out, &m);
}
