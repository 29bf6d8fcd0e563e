#include "run/measured.h"
#include "core/job.h"
#include "core/status.h"
#include "io/file_stream.h"
#include "scene/load.h"

/* Of a file, as it is. */
static vv_status take_bare(vvi_measured *out, vv_field *field, const char *name, vv_status st)
{
    out->volume.field = field;
    out->volume.data = (vv_measured_data){.name = name, .field = field};
    return st;
}

vv_status vvi_measured_file(vvi_measured *out, vv_file *file, int64_t frame, const char *name, const vv_world *world,
                            const vv_volume *volume, const char *view, vv_job *job)
{
    vv_field *field = NULL;
    vv_status st = vvi_stream_samples(&field, &out->stream, file, frame, job);
    if (!world)
        return take_bare(out, field, name, st);
    if (st == VV_OK)
        st = vvi_measured_volume_take(&out->volume, field, file, frame, name, world, volume, view, job);
    vv_field_release(field);
    return st;
}

void vvi_measured_mesh(vvi_measured *out, vv_mesh *mesh, const char *name)
{
    out->mesh = mesh;
    out->volume.data = (vv_measured_data){.name = name, .mesh = mesh, .place = vv_affine_identity()};
}

/* Samples where a scene says which are missing are read anew. */
static vv_status read_samples(vv_field **out, const vvi_measured *m, const vv_world *world, const vv_dataset *dataset,
                              const vv_volume *volume, vv_job *job)
{
    const vv_numbers *missing = volume ? volume->missing : NULL;
    const char *attribute = volume ? volume->attribute : NULL;
    const int64_t frame = volume ? volume->frame : 0;
    if (!m->file || !missing || attribute)
        return vv_dataset_field(out, world, dataset, attribute, frame, job);
    vvi_job_keep_fills(job);
    const vv_status st = vvi_file_leave_out(m->file, missing->v, missing->n);
    return st == VV_OK || st == VV_E_ARGUMENT ? vv_file_read(out, m->file, frame, NULL, job) : st;
}

vv_status vvi_measured_shown(vvi_measured *out, const vv_world *world, const char *id, const char *view, vv_job *job)
{
    const vv_volume *volume = vvi_volume_named(world, id);
    const vv_dataset *dataset = volume ? vvi_volume_dataset(world, volume) : NULL;
    const bool has_file = dataset && ((dataset->path && !dataset->fields) || vv_dataset_is_made(dataset));
    vv_field *field = NULL;
    vv_mesh *mesh = NULL;
    vv_status st = VV_OK;
    if (!dataset)
        return vv_fail(VV_E_NOT_FOUND, "there is no volume '%.64s' with data", id);
    if (vv_dataset_is_mesh(dataset, job)) {
        st = vv_dataset_mesh(&mesh, world, dataset, job);
        vvi_measured_mesh(out, mesh, id);
        return st;
    }
    if (has_file && (st = vvi_dataset_open(&out->file, world, dataset, job)) != VV_OK)
        return st;
    if ((st = read_samples(&field, out, world, dataset, volume, job)) == VV_OK)
        st = vvi_measured_volume_take(&out->volume, field, out->file, volume->frame, id, world, volume, view, job);
    vv_field_release(field);
    return st;
}

vv_status vvi_measured_dataset(vvi_measured *out, const vv_world *world, const char *id, const char *what, vv_job *job)
{
    const vv_dataset *dataset = vvi_dataset_named(world, id);
    vv_field *field = NULL;
    if (!dataset)
        return vv_fail(VV_E_NOT_FOUND, "%s: the dataset '%.64s' no longer exists", what, id);
    if (vv_dataset_is_mesh(dataset, job))
        return vv_fail(VV_E_ARGUMENT, "%s: '%.64s' is a mesh; samples are needed", what, id);
    const vv_status st = vv_dataset_field(&field, world, dataset, NULL, 0, job);
    return take_bare(out, field, id, st);
}

static void close_one(vvi_measured *m)
{
    vvi_measured_volume_finish(&m->volume);
    vv_mesh_release(m->mesh);
    vvi_stream_free(&m->stream);
    vv_file_close(m->file);
}

void vvi_measured_close(vvi_measured_all *all)
{
    close_one(&all->input);
    close_one(&all->other);
    close_one(&all->mask);
    close_one(&all->values);
    vvi_measured_meshes_finish(&all->shown);
}
