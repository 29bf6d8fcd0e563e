/* What a picture says of how it was made: all of it, or there is no memory. */
#include "core/memory.h"
#include "render/recipe.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <string.h>
#include <volvis/sys/scene.h>

#include <cmocka.h>

static vv_world *world_with_checksums(void)
{
    static const char scene[] =
        "{\"title\": \"a\", \"datasets\": {\"head\": {\"path\": \"/tmp/head.nrrd\", \"checksum\": "
        "\"crc32:01234567\"}, \"mask\": {\"path\": \"/tmp/mask.nrrd\", \"checksum\": "
        "\"crc32:89abcdef\"}}}";
    vv_world *world = NULL;
    assert_int_equal(vv_scene_parse(&world, scene, strlen(scene), "test", NULL, NULL), VV_OK);
    return world;
}

static const char *value_of(const vv_text *text, size_t n, const char *key)
{
    for (size_t i = 0; i < n; i++)
        if (strcmp(text[i].key, key) == 0)
            return text[i].value;
    return "";
}

static void a_recipe_is_whole_or_not_written(void **state)
{
    (void)state;
    static const char *const paths[] = {"-", "/tmp/picture.png"};
    static const vvi_recipe recipe = {.view = "main", .bits = 8, .rays = "2 rays per pixel"};
    vv_world *world = world_with_checksums();
    for (size_t p = 0; p < 2; p++) {
        bool failed = true;
        for (int64_t k = 1; failed; k++) {
            vv_text *text = NULL;
            size_t n = 0;
            vvi_alloc_fail_once(k);
            const vv_status st = vvi_recipe_text(&text, &n, world, &recipe, paths[p]);
            failed = vvi_alloc_has_failed();
            vvi_alloc_fail_after(0);
            assert_true(st == VV_OK || (failed && st == VV_E_MEMORY));
            if (st == VV_OK) {
                const char *scene = value_of(text, n, VVI_KEY_SCENE);
                assert_string_equal(value_of(text, n, VVI_KEY_DATA), "head crc32:01234567, mask crc32:89abcdef");
                assert_non_null(strstr(scene, p == 0 ? "\"/tmp/head.nrrd\"" : "\"head.nrrd\""));
                assert_string_equal(value_of(text, n, VVI_KEY_VIEW), "main");
                vv_text_free(text, n);
            }
            assert_true(k < 10000);
        }
    }
    vv_object_release(&world->base);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_recipe_is_whole_or_not_written),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
