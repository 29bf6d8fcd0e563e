/* Samples of your own, smoothed, and the surface where they have one value:  surface OUT.ply */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <volvis/volvis.h>

enum { N = 48 };

/* How deep a place lies in a ball of radius 8 mm; samples are 0.5 mm apart. The field frees them with its end. */
static vv_status make_ball(vv_field **out, vv_job *job)
{
    float *samples = malloc(sizeof(float) * N * N * N), *at = samples;
    vv_field_info info = vv_field_info_default();
    if (!samples)
        return VV_E_MEMORY;
    for (int k = 0; k < N; k++)
        for (int j = 0; j < N; j++)
            for (int i = 0; i < N; i++)
                *at++ = (float)(8 - 0.5 * hypot(hypot(i - 23.5, j - 23.5), k - 23.5));
    info.type = VV_TYPE_F32;
    for (int axis = 0; axis < 3; axis++)
        info.grid.dims[axis] = N;
    info.grid.index_to_world = (vv_affine){.axis = {{0.5, 0, 0}, {0, 0.5, 0}, {0, 0, 0.5}}};
    strcpy(info.grid.unit, "mm");
    return vv_field_new(out, &info, samples, 0, free, samples, job);
}

/* *data becomes what an operation makes of it, with one of its parameters set. */
static vv_status run(vv_data *data, const char *name, const char *parameter, double value, vv_job *job)
{
    vv_data made = {0};
    vv_object *params = NULL;
    const vv_property_context context = vv_data_context(data); /* lengths are in its unit */
    const vv_operation *operation = vv_operation_find(name, job);
    if (!operation)
        return vv_error_last()->status;
    vv_status st = vv_operation_new_params(&params, operation);
    if (st == VV_OK)
        st = vv_path_set_number(&params, parameter, value, &context);
    if (st == VV_OK)
        st = vv_operation_make(&made, operation, data, 1, params, job);
    if (st == VV_OK) {
        vv_data_release(data);
        *data = made;
    }
    vv_object_release(params);
    return st;
}

int main(int argc, char **argv)
{
    vv_data data = {0};
    vv_job *job = NULL; /* this thread alone */
    const char *path = argc > 1 ? argv[1] : "ball.ply";
    vv_status st = make_ball(&data.field, job);
    if (st == VV_OK)
        st = run(&data, "gaussian", "sigma", 0.75, job);
    if (st == VV_OK)
        st = run(&data, "isosurface", "iso", 0, job);
    if (st == VV_OK)
        st = vv_mesh_write(path, data.mesh, NULL, job);
    if (st == VV_OK)
        printf("%s: %zu triangles\n", path, vv_mesh_get_info(data.mesh)->n_triangles);
    else
        fprintf(stderr, "surface: %s\n", vv_error_last()->message);
    vv_data_release(&data);
    return st != VV_OK;
}
