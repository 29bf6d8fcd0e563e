/* Samples of datasets: attached ones first, else from the file or made of others, kept in the runtime's cache. */
#include "scene/load.h"
#include "core/cache.h"
#include "core/job.h"
#include "core/memory.h"
#include "core/names.h"
#include "grid/mesh.h"
#include "io/file_stream.h"
#include "io/mesh_file.h"
#include "model/dataset.h"
#include "model/made_data.h"
#include "model/object_hash.h"
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <volvis/sys/registry.h>

/* One thing to load: the user of the cache's makers. */
typedef struct request {
    const vv_dataset *dataset;
    int64_t frame;
} request;

static uint64_t hash_attached(const struct vv_dataset_fields *fields)
{
    const uint64_t identity = fields->n ? vv_field_identity(fields->field[0]) : 0;
    const uint32_t mesh = fields->mesh ? vv_mesh_checksum(fields->mesh) : 0;
    return vvi_hash(&mesh, sizeof mesh, vvi_hash(&identity, sizeof identity, 1));
}

static bool is_title(const void *user, const vv_object *owner, const vv_property *row)
{
    return strcmp(row->name, "title") == 0;
}

uint64_t vvi_dataset_content(const vv_dataset *d)
{
    struct stat s;
    if (d->fields)
        return hash_attached(d->fields);
    uint64_t hash = vvi_object_hash(&d->base, &(vvi_hash_rules){.leaves_out = is_title}, 0);
    if (d->path && !stat(d->path, &s)) {
        const int64_t parts[] = {(int64_t)s.st_dev, (int64_t)s.st_ino, s.st_size, s.st_mtim.tv_sec, s.st_mtim.tv_nsec};
        hash = vvi_hash(parts, sizeof parts, hash);
    }
    return hash;
}

/* All that decides what is loaded. A file that changes gets another key; what was loaded before it goes in time. */
static vvi_cache_key key_of(const char *what, const request *r)
{
    const uint64_t hash = vvi_hash(&r->frame, sizeof r->frame, vvi_dataset_content(r->dataset));
    return (vvi_cache_key){.what = what, .parameters = hash};
}

/* What is made ------------------------------------------------------------------------------------------------- */

bool vv_dataset_is_made(const vv_dataset *dataset)
{
    return dataset->operation && !dataset->path && !dataset->fields;
}

/* NULL, and the thread's error: nothing can be made. */
static const vvi_made_data *made_data_of(const vv_world *world, const vv_dataset *dataset, vv_job *job)
{
    const vvi_made_data *data = vvi_job_registry(job)->made_data;
    if (!data || !world)
        vv_fail(VV_E_UNSUPPORTED, "the dataset is made by %s, of others that are not at hand here", dataset->operation);
    return world ? data : NULL;
}

static vv_status check_kind(const vv_dataset *dataset, const vv_field_info *info, vv_job *job)
{
    enum { MOST = 64 };
    const char *names[MOST];
    const vv_data_kind *const *rows = vvi_job_registry(job)->data_kinds;
    size_t n = 0;
    if (!dataset->kind)
        return VV_OK;
    for (; n < MOST && rows[n]; n++) {
        names[n] = rows[n]->name;
        if (strcmp(rows[n]->name, dataset->kind) != 0)
            continue;
        if (!info || !rows[n]->accepts || rows[n]->accepts(info))
            return VV_OK;
        return vv_fail(VV_E_UNSUPPORTED, "%s: the samples are not of kind '%s'", dataset->path, dataset->kind);
    }
    return vvi_fail_name(VV_E_UNSUPPORTED, NULL, "kind", dataset->kind, &(vvi_known){names, n, NULL, NULL},
                         "'%.64s' is not a known kind of data", dataset->kind);
}

static vv_status open_file(vv_file **out, const vv_dataset *dataset, vv_job *job)
{
    vv_read_options options;
    vv_status st = check_kind(dataset, NULL, job);
    if (st != VV_OK)
        return st;
    vv_read_options_init(&options, sizeof options);
    options.format = dataset->format;
    options.part = dataset->part;
    options.raw = dataset->raw;
    st = vv_file_open(out, dataset->path, &options, job);
    if (st == VV_OK && (st = check_kind(dataset, vv_file_info(*out), job)) != VV_OK) {
        vv_file_close(*out);
        *out = NULL;
    }
    return st;
}

vv_status vvi_dataset_open(vv_file **out, const vv_world *world, const vv_dataset *dataset, vv_job *job)
{
    *out = NULL;
    if (!vv_dataset_is_made(dataset))
        return open_file(out, dataset, job);
    const vvi_made_data *data = made_data_of(world, dataset, job);
    return data ? data->open(out, world, dataset, job) : VV_E_UNSUPPORTED;
}

static vv_status fail_sum(const vv_dataset *dataset, const char *what, uint32_t found)
{
    return vv_fail_at(VV_E_FORMAT, dataset->path, NULL,
                      "%s checksum crc32:%08x, expected %s: the file is not the one that the scene was made with; "
                      "unset checksum to use it anyway",
                      what, found, dataset->checksum);
}

static vv_status check_sum(const vv_dataset *dataset, const vv_field *field, vv_job *job)
{
    uint32_t expected = 0, found = 0;
    if (!dataset->checksum || !vvi_checksum_parse(&expected, dataset->checksum))
        return VV_OK;
    const vv_status st = vv_field_checksum(&found, field, job);
    if (st != VV_OK || found == expected)
        return st;
    return fail_sum(dataset, "the samples have", found);
}

static void drop_field(void *value)
{
    vv_field_release(value);
}

/* For memory, and of a format whose parts can be read as they are asked for. */
static bool is_too_large(const vv_file *file, vv_job *job)
{
    const vv_runtime *runtime = vv_job_runtime(job);
    uint64_t bytes;
    return runtime && vvi_file_has_boxes(file) && vv_field_info_bytes(&bytes, vv_file_info(file)) == VV_OK &&
           bytes > vv_runtime_memory_limit(runtime) / 8 * 7; /* what fits is quicker whole */
}

static vv_status make_field(void **value_out, uint64_t *bytes_out, void *user, vv_job *job)
{
    const request *r = user;
    vv_file *file = NULL;
    vv_field *field = NULL;
    vv_status st = open_file(&file, r->dataset, job);
    if (st != VV_OK)
        return st;
    const int64_t n_frames = vv_file_info(file)->n_frames;
    if (r->frame < 0 || r->frame >= n_frames)
        st = vv_fail_at(VV_E_ARGUMENT, r->dataset->path, NULL, "there is no time step %lld: expected 0 to %lld",
                        (long long)r->frame, (long long)n_frames - 1);
    const bool mapped = vv_file_mappable(file), pieces = st == VV_OK && !mapped && is_too_large(file, job);
    if (pieces)
        st = vvi_file_stream_boxes(&field, file, r->frame, job); /* which has the file */
    else if (st == VV_OK)
        st = vv_file_read(&field, file, r->frame, NULL, job);
    if (!pieces)
        vv_file_close(file);
    if (st == VV_OK && r->frame == 0)
        st = check_sum(r->dataset, field, job);
    if (st == VV_OK && (st = vv_field_info_bytes(bytes_out, vv_field_get_info(field))) == VV_OK) {
        *bytes_out = mapped || pieces ? 0 : *bytes_out;
        *value_out = field;
        return VV_OK;
    }
    vv_field_release(field);
    return st;
}

static vv_status make_info(void **value_out, uint64_t *bytes_out, void *user, vv_job *job)
{
    const request *r = user;
    vv_file *file = NULL;
    vv_status st = open_file(&file, r->dataset, job);
    if (st != VV_OK)
        return st;
    vv_field_info *info = vvi_alloc(NULL, sizeof *info, VVI_MEM_MODEL);
    if (info) {
        *info = *vv_file_info(file);
        *value_out = info;
        *bytes_out = sizeof *info;
    } else {
        st = vv_fail_memory(sizeof *info);
    }
    vv_file_close(file);
    return st;
}

static vv_status fail_no_samples(const vv_dataset *dataset, const char *name, int64_t frame)
{
    const vv_field *first = vvi_dataset_attached(dataset, NULL);
    if (first && frame != 0)
        return vv_fail(VV_E_NOT_FOUND, "there is no time step %lld: only time step 0 is in memory", (long long)frame);
    if (first)
        return vv_fail(VV_E_NOT_FOUND, "there is no attribute '%.63s'; there is '%s'", name ? name : "",
                       vv_field_get_info(first)->name);
    return vv_fail(VV_E_NOT_FOUND, "the dataset has no samples: neither a path nor a field in memory");
}

/* Meshes --------------------------------------------------------------------------------------------------------- */

bool vv_dataset_is_mesh(const vv_dataset *dataset, vv_job *job)
{
    const vv_registry *registry = vvi_job_registry(job);
    if (dataset->fields)
        return dataset->fields->mesh;
    if (vv_dataset_is_made(dataset))
        return registry->made_data && registry->made_data->is_mesh(dataset, job);
    if (dataset->kind)
        return !strcmp(dataset->kind, "mesh");
    if (!dataset->path || dataset->raw)
        return false;
    return dataset->format ? vvi_mesh_format_find(dataset->format, registry) != NULL
                           : vvi_mesh_is_file(dataset->path, job);
}

static void drop_mesh(void *value)
{
    vv_mesh_release(value);
}

static vv_status check_mesh_sum(const vv_dataset *dataset, const vv_mesh *mesh)
{
    uint32_t expected = 0;
    if (!dataset->checksum || !vvi_checksum_parse(&expected, dataset->checksum))
        return VV_OK;
    const uint32_t found = vv_mesh_checksum(mesh);
    return found == expected ? VV_OK : fail_sum(dataset, "the mesh has", found);
}

static vv_status make_mesh(void **value_out, uint64_t *bytes_out, void *user, vv_job *job)
{
    const vv_dataset *dataset = ((const request *)user)->dataset;
    vv_mesh_read_options options;
    vv_mesh *mesh;
    vv_mesh_read_options_init(&options, sizeof options);
    options.format = dataset->format;
    options.part = dataset->part;
    vv_status st = vv_mesh_read(&mesh, dataset->path, &options, job);
    if (st != VV_OK)
        return st;
    if ((st = check_mesh_sum(dataset, mesh)) != VV_OK) {
        vv_mesh_release(mesh);
        return st;
    }
    *value_out = mesh;
    *bytes_out = vvi_mesh_bytes(mesh);
    return VV_OK;
}

/* What cannot be read has neither. */
static vv_status fail_no_triangles(const vv_world *world, const vv_dataset *dataset, vv_job *job)
{
    vv_field_info info;
    const vv_status st =
        dataset->path || vv_dataset_is_made(dataset) ? vv_dataset_info(&info, world, dataset, job) : VV_OK;
    return st != VV_OK ? st : vv_fail_at(VV_E_ARGUMENT, dataset->path, NULL, "the dataset has samples, not triangles");
}

static vv_status make_mesh_of_others(vv_mesh **out, const vv_world *world, const vv_dataset *dataset, vv_job *job)
{
    const vvi_made_data *data = made_data_of(world, dataset, job);
    return data ? data->mesh(out, world, dataset, job) : VV_E_UNSUPPORTED;
}

vv_status vv_dataset_mesh(vv_mesh **out, const vv_world *world, const vv_dataset *dataset, vv_job *job)
{
    request r = {dataset, 0};
    vvi_cached *cached = NULL;
    *out = NULL;
    if (dataset->fields && dataset->fields->mesh) {
        *out = vv_mesh_retain(dataset->fields->mesh);
        return VV_OK;
    }
    const bool made = vv_dataset_is_made(dataset);
    if ((!dataset->path && !made) || !vv_dataset_is_mesh(dataset, job))
        return fail_no_triangles(world, dataset, job);
    if (made)
        return make_mesh_of_others(out, world, dataset, job);
    const vvi_cache_key key = key_of("mesh", &r);
    const vv_status st = vvi_cache_get(&cached, &key, make_mesh, drop_mesh, &r, job);
    if (st != VV_OK)
        return st;
    *out = vv_mesh_retain(vvi_cached_value(cached));
    vvi_cache_release(cached);
    return VV_OK;
}

static vv_status refuse_mesh(const vv_dataset *dataset, vv_job *job)
{
    if (!vv_dataset_is_mesh(dataset, job))
        return VV_OK;
    if (!dataset->path)
        return vv_fail(VV_E_UNSUPPORTED, "%s makes a mesh, but samples are needed here", dataset->operation);
    return vv_fail_at(VV_E_UNSUPPORTED, dataset->path, NULL,
                      "is a mesh, but samples are needed here; 'volvis render' shows meshes");
}

/* Fields ---------------------------------------------------------------------------------------------------------- */

/* Files have one attribute. */
static vv_status check_name(const vv_field *field, const vv_dataset *dataset, const char *name)
{
    const char *found = vv_field_get_info(field)->name;
    if (!name || !strcmp(found, name))
        return VV_OK;
    return vv_fail_at(VV_E_NOT_FOUND, dataset->path, NULL,
                      *found ? "there is no attribute '%.63s'; there is '%s'" : "there is no attribute '%.63s'%s", name,
                      found);
}

static vv_status make_field_of_others(vv_field **out, const vv_world *world, const request *r, const char *name,
                                      vv_job *job)
{
    vv_field *field = NULL;
    const vvi_made_data *data = made_data_of(world, r->dataset, job);
    vv_status st = data ? refuse_mesh(r->dataset, job) : VV_E_UNSUPPORTED;
    if (st == VV_OK && (st = data->field(&field, world, r->dataset, r->frame, job)) == VV_OK)
        st = check_name(field, r->dataset, name);
    if (st == VV_OK)
        *out = field;
    else
        vv_field_release(field);
    return st;
}

vv_status vv_dataset_field(vv_field **out, const vv_world *world, const vv_dataset *dataset, const char *name,
                           int64_t frame, vv_job *job)
{
    request r = {dataset, frame};
    vvi_cached *cached = NULL;
    *out = NULL;
    const vv_field *attached = frame == 0 ? vvi_dataset_attached(dataset, name) : NULL;
    if (attached) {
        *out = vv_field_retain(attached);
        return VV_OK;
    }
    if (vv_dataset_is_made(dataset))
        return make_field_of_others(out, world, &r, name, job);
    if (!dataset->path)
        return fail_no_samples(dataset, name, frame);
    vv_status st = refuse_mesh(dataset, job);
    if (st != VV_OK)
        return st;
    const vvi_cache_key key = key_of("samples", &r);
    st = vvi_cache_get(&cached, &key, make_field, drop_field, &r, job);
    if (st != VV_OK)
        return st;
    vv_field *field = vvi_cached_value(cached);
    st = check_name(field, dataset, name);
    if (st == VV_OK)
        *out = vv_field_retain(field);
    vvi_cache_release(cached);
    return st;
}

static vv_status plan_of_others(vv_field_info *out, const vv_world *world, const vv_dataset *dataset, vv_job *job)
{
    const vvi_made_data *data = made_data_of(world, dataset, job);
    const vv_status st = data ? refuse_mesh(dataset, job) : VV_E_UNSUPPORTED;
    return st == VV_OK ? data->info(out, world, dataset, job) : st;
}

vv_status vv_dataset_info(vv_field_info *out, const vv_world *world, const vv_dataset *dataset, vv_job *job)
{
    request r = {dataset, 0};
    vvi_cached *cached = NULL;
    const vv_field *attached = vvi_dataset_attached(dataset, NULL);
    if (attached) {
        *out = *vv_field_get_info(attached);
        return VV_OK;
    }
    if (vv_dataset_is_made(dataset))
        return plan_of_others(out, world, dataset, job);
    if (!dataset->path)
        return fail_no_samples(dataset, NULL, 0);
    vv_status st = refuse_mesh(dataset, job);
    if (st != VV_OK)
        return st;
    const vvi_cache_key key = key_of("header", &r);
    st = vvi_cache_get(&cached, &key, make_info, vvi_free, &r, job);
    if (st != VV_OK)
        return st;
    *out = *(const vv_field_info *)vvi_cached_value(cached);
    vvi_cache_release(cached);
    return VV_OK;
}
