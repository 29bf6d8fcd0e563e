/* A format, an operation and a renderer of one's own, beside those that are built in:  own_rows FOLDER */
#include "format_dots.h"
#include "operation_negative.h"
#include "renderer_film.h"
#include <stdio.h>
#include <volvis/volvis.h>

static const vv_format *const formats[] = {&format_dots, NULL};
static const vv_operation *const operations[] = {&operation_negative, NULL};
static const vv_renderer *const renderers[] = {&renderer_film, NULL};
static const vv_registry rows = {.formats = formats, .operations = operations, .renderers = renderers};

/* Writes a ramp as dots: its suffix says which format it is. */
static vv_status write_ramp(const char *path, vv_job *job)
{
    vv_field *ramp;
    uint8_t *samples;
    vv_field_info info = vv_field_info_default();
    for (int axis = 0; axis < 3; axis++)
        info.grid.dims[axis] = 16;
    vv_status st = vv_field_new_empty(&ramp, (void **)&samples, &info, job);
    if (st != VV_OK)
        return st;
    for (int i = 0; i < 16 * 16 * 16; i++)
        samples[i] = (uint8_t)(16 * (i % 16));
    st = vv_field_write(path, (const vv_field *const[]){ramp}, 1, NULL, job);
    vv_field_release(ramp);
    return st;
}

/* The negative of a file, as `volvis negative` makes it: read, run and written by the library. */
static vv_status write_negative(const char *path, const char *out, vv_job *job)
{
    vv_run *run = NULL;
    vv_step step = {.operation = vv_operation_find("negative", job)};
    vv_run_input input = {.frame = -1, .name = path, .path = path};
    const vv_run_output output = {.path = out};
    vv_status st = step.operation ? vv_operation_new_params(&step.params, step.operation) : vv_error_last()->status;
    if (st == VV_OK)
        st = vv_file_open(&input.file, path, NULL, job);
    if (st == VV_OK)
        st = vv_run_new(&run, &input, 1, &step, 1, &output, path, job);
    if (st == VV_OK)
        st = vv_run_write(run);
    vv_run_release(run);
    vv_file_close(input.file);
    vv_object_release(step.params);
    return st;
}

static vv_status draw(const char *path, const char *picture, vv_job *job)
{
    vv_world *world;
    vv_image *image = NULL;
    vv_status st = vv_world_for_file(&world, path, NULL, job);
    if (st != VV_OK)
        return st;
    vv_object *root = &world->base;
    st = vv_path_set_text(&root, "views.main.render.method", "film", NULL);
    if (st == VV_OK)
        st = vv_path_set_number(&root, "views.main.render.film.strength", 2, NULL);
    if (st == VV_OK)
        st = vv_path_set_integer(&root, "views.main.width", 96, NULL);
    if (st == VV_OK)
        st = vv_path_set_integer(&root, "views.main.height", 72, NULL);
    if (st == VV_OK)
        st = vv_render(&image, NULL, (vv_world *)root, NULL, NULL, job);
    if (st == VV_OK)
        st = vv_image_write(picture, image, NULL, job);
    vv_image_release(image);
    vv_object_release(root);
    return st;
}

int main(int argc, char **argv)
{
    char ramp[512], negative[512], picture[512];
    const char *folder = argc > 1 ? argv[1] : ".";
    vv_runtime *runtime = NULL;
    vv_job *job = NULL;
    vv_runtime_options options;
    snprintf(ramp, sizeof ramp, "%s/ramp.dots", folder);
    snprintf(negative, sizeof negative, "%s/negative.dots", folder);
    snprintf(picture, sizeof picture, "%s/film.png", folder);
    vv_runtime_options_init(&options, sizeof options);
    options.more = &rows;
    vv_status st = vv_runtime_new(&runtime, &options);
    if (st == VV_OK)
        st = vv_job_new(&job, runtime, NULL, NULL);
    if (st == VV_OK)
        st = write_ramp(ramp, job);
    if (st == VV_OK)
        st = write_negative(ramp, negative, job);
    if (st == VV_OK)
        st = draw(negative, picture, job);
    if (st != VV_OK)
        fprintf(stderr, "own_rows: %s\n", vv_error_last()->message);
    else
        printf("%s, %s and %s are written\n", ramp, negative, picture);
    vv_job_release(job);
    vv_runtime_release(runtime);
    return st != VV_OK;
}
