/* What an edit makes be made again: derived data is kept for all that it does not touch, and a picture after an edit is
 * the picture of a fresh start. */
#include "core/cache.h"
#include "fields.h"
#include "jobs.h"
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <volvis/volvis.h>

#include <cmocka.h>

typedef struct edit {
    const char *path, *json;
    unsigned made; /* pieces of derived data that it makes anew */
} edit;

/* A frame of a fresh runtime makes four: statistics, min-max cells, skipping distances, the list of visible boxes. */
static const edit edits[] = {
    {"views.main.camera.azimuth", "77", 0},
    {"views.main.width", "40", 0},
    {"lights.key.intensity", "0.3", 0},
    {"background", "\"#203040\"", 0},
    {"volumes.ball.shading.diffuse", "0.2", 0},
    {"volumes.ball.cut_planes", "[{\"normal\": [1, 0, 0], \"offset\": 0}]", 0},
    {"volumes.ball.place.position", "[1, 2, 3]", 0},
    {"views.main.render.raycast.step", "0.31", 0},
    /* nodes further out move the rows of the table, and skipping must ask the rows that rays look up */
    {"volumes.ball.segmentation.transfer.color", "[[-4.5, 1, 0, 0], [4.5, 0, 0, 1]]", 2},
    {"volumes.ball.segmentation.transfer.color", "[[-4.5, 0, 1, 0], [4.5, 1, 1, 0]]", 0},
    /* what can be seen changes: distances and boxes, and nothing else */
    {"volumes.ball.segmentation.transfer.opacity", "[[-3, 0], [0, 0.5]]", 2},
    {"views.main.render.raycast.mode", "\"isosurface\"", 2},
    {"views.main.render.raycast.iso", "-1.5", 2},
    {"views.main.render.raycast.iso", "-2.5", 2},
    {"views.main.render.raycast.iso", "-1.5", 0},         /* still there */
    {"views.main.render.raycast.mode", "\"maximum\"", 0}, /* needs the min-max cells alone */
};

static vv_image *picture(vv_world *world, vv_job *job)
{
    vv_image *image = NULL;
    if (vv_render(&image, NULL, world, NULL, NULL, job) != VV_OK)
        fail_msg("%s", vv_error_last()->message);
    return image;
}

static void assert_same_picture_from_a_fresh_start(vv_world *world, const vv_image *image, const char *path)
{
    vv_job *fresh = test_job(2, 0);
    vv_image *again = picture(world, fresh);
    assert_int_equal(again->width, image->width);
    if (memcmp(again->rgba, image->rgba, (size_t)image->width * (size_t)image->height * 4 * sizeof(float)) != 0)
        fail_msg("after an edit of %s the picture is not that of a fresh start", path);
    vv_image_release(again);
    vv_job_release(fresh);
}

static void an_edit_makes_only_what_depends_on_it(void **state)
{
    (void)state;
    vv_job *job = test_job(2, 0);
    vv_runtime *runtime = vv_job_runtime(job);
    vv_field_info info = vv_field_info_default();
    info.type = VV_TYPE_F32;
    info.grid = test_cube(19, -1, 19);
    vv_field *field = test_field(&test_form_sphere, &info, job);
    vv_world *world = NULL;
    vv_model *model = NULL;
    vvi_cache_counts before, after;
    assert_int_equal(vv_world_for_field(&world, "ball", field, job), VV_OK);
    assert_int_equal(vv_model_new(&model, runtime), VV_OK);
    assert_int_equal(vv_model_replace(model, NULL, world), VV_OK);
    assert_int_equal(vv_model_set(model, NULL, "views.main.width", "48"), VV_OK);
    assert_int_equal(vv_model_set(model, NULL, "views.main.height", "32"), VV_OK);
    assert_int_equal(vv_model_set(model, NULL, "views.main.camera.fit", "data"), VV_OK);
    assert_int_equal(
        vv_model_set(model, NULL, "volumes.ball.segmentation.transfer.opacity", "[[-4, 0.9], [-3, 0.1], [0, 0]]"),
        VV_OK);
    vv_object_release(&world->base);
    world = vv_model_snapshot(model);
    vvi_cache_get_counts(&before, runtime);
    vv_image_release(picture(world, job));
    vv_object_release(&world->base);
    vvi_cache_get_counts(&after, runtime);
    assert_int_equal(after.misses - before.misses, 5); /* one of them the border: the values peak high */
    for (size_t i = 0; i < sizeof edits / sizeof *edits; i++) {
        if (vv_model_set(model, NULL, edits[i].path, edits[i].json) != VV_OK)
            fail_msg("%s", vv_error_last()->message);
        world = vv_model_snapshot(model);
        vvi_cache_get_counts(&before, runtime);
        vv_image *image = picture(world, job);
        vvi_cache_get_counts(&after, runtime);
        if (after.misses - before.misses != edits[i].made)
            fail_msg("%s made %u pieces of derived data, not %u", edits[i].path,
                     (unsigned)(after.misses - before.misses), edits[i].made);
        assert_same_picture_from_a_fresh_start(world, image, edits[i].path);
        vv_image_release(image);
        vv_object_release(&world->base);
    }
    vv_model_release(model);
    vv_field_release(field);
    vv_job_release(job);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(an_edit_makes_only_what_depends_on_it)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
