/* A picture in steps: looked at on the way, broken off, and gone on with from a file. */
#include <stdio.h>
#include <string.h>
#include <volvis/volvis.h>

enum { N = 32 };

/* A ball whose values fall from 255 in the middle to 0. */
static vv_status make_world(vv_world **out, vv_job *job)
{
    vv_field *field = NULL;
    uint8_t *samples;
    vv_field_info info = vv_field_info_default();
    for (int axis = 0; axis < 3; axis++)
        info.grid.dims[axis] = N;
    *out = NULL;
    vv_status st = vv_field_new_empty(&field, (void **)&samples, &info, job);
    for (int i = 0; st == VV_OK && i < N * N * N; i++) {
        const int x = i % N - N / 2, y = i / N % N - N / 2, z = i / N / N - N / 2, r2 = x * x + y * y + z * z;
        samples[i] = (uint8_t)(r2 < 255 ? 255 - r2 : 0);
    }
    if (st == VV_OK)
        st = vv_world_for_field(out, "ball", field, job);
    vv_field_release(field);
    return st;
}

/* The first process: 20 ms of work, a look, a file. */
static vv_status begin(vv_world *world, const char *file, vv_job *job)
{
    vv_picture *picture;
    vv_picture_until until;
    vv_image *image = NULL;
    vv_picture_until_init(&until, sizeof until);
    until.seconds = 0.02;
    vv_status st = vv_picture_new(&picture, world, NULL, false, job);
    if (st != VV_OK)
        return st;
    if ((st = vv_picture_step(picture, &until, job)) == VV_OK && (st = vv_picture_look(&image, picture, job)) == VV_OK)
        st = vv_picture_save(picture, file, job);
    printf("%.0f %% of %d x %d pixels\n", 100 * vv_picture_done(picture), image ? image->width : 0,
           image ? image->height : 0);
    vv_image_release(image);
    vv_picture_free(picture);
    return st;
}

/* The second one: whatever was done is not done again. */
static vv_status go_on(vv_image **out, vv_world *world, const char *file, vv_job *job)
{
    vv_picture *picture;
    *out = NULL;
    vv_status st = vv_picture_new(&picture, world, NULL, false, job);
    if (st != VV_OK)
        return st;
    if ((st = vv_picture_resume(picture, file, job)) == VV_OK && (st = vv_picture_step(picture, NULL, job)) == VV_OK)
        st = vv_picture_look(out, picture, job);
    vv_picture_free(picture);
    return st;
}

int main(void)
{
    static const char file[] = "ball.part";
    vv_runtime *runtime;
    vv_job *job = NULL;
    vv_world *world = NULL;
    vv_image *whole = NULL, *resumed = NULL;
    bool same = false;
    if (vv_runtime_new(&runtime, NULL) != VV_OK)
        return 1;
    vv_status st = vv_job_new(&job, runtime, NULL, NULL);
    if (st == VV_OK && (st = make_world(&world, job)) == VV_OK && (st = begin(world, file, job)) == VV_OK &&
        (st = go_on(&resumed, world, file, job)) == VV_OK &&
        (st = vv_render(&whole, NULL, world, NULL, NULL, job)) == VV_OK)
        same = !memcmp(whole->rgba, resumed->rgba, 4 * sizeof(float) * (size_t)whole->width * (size_t)whole->height);
    printf("%s\n", st != VV_OK ? vv_error_last()->message : same ? "the same bytes" : "other bytes");
    remove(file);
    vv_image_release(whole);
    vv_image_release(resumed);
    if (world)
        vv_object_release(&world->base);
    vv_job_release(job);
    vv_runtime_release(runtime);
    return !same;
}
