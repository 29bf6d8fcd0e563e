/* Load a file, turn it, render it:  render FILE PICTURE.png [DEGREES] */
#include <stdio.h>
#include <stdlib.h>
#include <volvis/volvis.h>

/* A World is shared and never written to: an edit makes another one of it. */
static vv_status turn(vv_world **world, double degrees)
{
    vv_object *root = &(*world)->base;
    vv_status st = vv_path_set_number(&root, "views.main.camera.azimuth", degrees, NULL);
    if (st == VV_OK)
        st = vv_path_set_integer(&root, "views.main.width", 320, NULL);
    if (st == VV_OK)
        st = vv_path_set_integer(&root, "views.main.height", 240, NULL);
    *world = (vv_world *)root;
    return st;
}

static vv_status render(const char *file, const char *picture, double degrees, vv_job *job)
{
    vv_world *world = NULL;
    vv_image *image = NULL;
    vv_render_report report;
    vv_status st = vv_world_for_file(&world, file, NULL, job);
    if (st == VV_OK)
        st = turn(&world, degrees);
    if (st == VV_OK)
        st = vv_render(&image, &report, world, NULL, NULL, job);
    if (st == VV_OK)
        st = vv_image_write(picture, image, NULL, job);
    if (st == VV_OK)
        printf("%s: %d x %d by %s\n", picture, image->width, image->height, report.method);
    vv_image_release(image);
    if (world)
        vv_object_release(&world->base);
    return st;
}

int main(int argc, char **argv)
{
    vv_runtime *runtime = NULL; /* threads, memory limit, cache */
    vv_job *job = NULL;
    if (argc < 3) {
        fprintf(stderr, "usage: render FILE PICTURE.png [DEGREES]\n");
        return 2;
    }
    vv_status st = vv_runtime_new(&runtime, NULL);
    if (st == VV_OK)
        st = vv_job_new(&job, runtime, NULL, NULL);
    if (st == VV_OK)
        st = render(argv[1], argv[2], argc > 3 ? atof(argv[3]) : 30, job);
    if (st != VV_OK)
        fprintf(stderr, "render: %s\n", vv_error_last()->message);
    vv_job_release(job);
    vv_runtime_release(runtime);
    return st != VV_OK;
}
