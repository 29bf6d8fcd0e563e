/* Scene files: paths of data, newer schemas, broken text, a renderer that only this test knows. */
#include "fields.h"
#include "jobs.h"
#include "model/context.h"
#include "worlds.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cmocka.h>

static vv_world *parse(const char *json, const char *folder, vv_job *job)
{
    vv_world *world = NULL;
    if (vv_scene_parse(&world, json, strlen(json), "test.vv.json", folder, job) != VV_OK)
        fail_msg("%s", vv_error_last()->message);
    return world;
}

static char *print(const vv_world *world, const char *folder)
{
    char *json = NULL;
    assert_int_equal(vv_scene_print(&json, world, folder), VV_OK);
    return json;
}

/* What is known follows in the sentence. */
static void expect_begin(const char *message)
{
    if (strncmp(vv_error_last()->message, message, strlen(message)) != 0)
        assert_string_equal(vv_error_last()->message, message);
}

static void expect_failure(const char *json, vv_status status, const char *message)
{
    vv_world *world = NULL;
    assert_int_equal(vv_scene_parse(&world, json, strlen(json), "test.vv.json", NULL, NULL), status);
    assert_null(world);
    expect_begin(message);
    assert_string_equal(vv_error_last()->file, "test.vv.json");
}

static void errors_say_file_place_and_what_was_expected(void **state)
{
    (void)state;
    expect_failure("{\"lights\": {\"key\": {\"intensty\": 2}}}", VV_E_FORMAT,
                   "test.vv.json:lights.key: unknown property 'intensty'; did you mean 'intensity'?");
    assert_string_equal(vv_error_last()->where, "lights.key");
    expect_failure("{\"views\": {\"main\": {\"width\": 0}}}", VV_E_FORMAT,
                   "test.vv.json:views.main.width: 0 is out of range: expected 1 to 32768");
    expect_failure("{\"title\": \"a\", \"title\": \"b\"}", VV_E_FORMAT,
                   "test.vv.json:1:22: duplicate object key near '\"title\"'");
    expect_failure("{\"datasets\": {\"d\": {\"kind\": \"regulr\"}}}", VV_E_FORMAT,
                   "test.vv.json:datasets.d.kind: unknown kind 'regulr'; did you mean 'regular'?");
    expect_failure("[]", VV_E_FORMAT, "test.vv.json: expected an object (world), found an array of 0");
}

static void lengths_take_the_units_of_the_scene(void **state)
{
    (void)state;
    vv_world *world = parse("{\"cut_planes\": [{\"offset\": \"2cm\"}], \"unit\": \"mm\"}", NULL, NULL);
    assert_true(((const vv_cut_plane *)vv_path_object(&world->base, "cut_planes.0"))->offset == 20);
    vv_object_release(&world->base);
}

/* `depth` brackets, one inside the other. */
static void fill_nested(char *out, size_t depth)
{
    memset(out, '[', depth);
    memset(out + depth, ']', depth);
    out[2 * depth] = 0;
}

static void limits_are_errors(void **state)
{
    (void)state;
    vv_world *world = NULL;
    char nested[2001];
    fill_nested(nested, 1000);
    expect_failure(nested, VV_E_LIMIT, "test.vv.json: nested 1000 deep: at most 32 levels are allowed");
    const size_t large = 16 * 1024 * 1024 + 1;
    char *spaces = malloc(large);
    memset(spaces, ' ', large);
    assert_int_equal(vv_scene_parse(&world, spaces, large, "test.vv.json", NULL, NULL), VV_E_LIMIT);
    free(spaces);
    assert_null(world);
}

/* `json` with "%s" for a text of n bytes. */
static char *with_text(const char *json, size_t n)
{
    char *text = malloc(n + 1), *whole = malloc(n + strlen(json));
    memset(text, 'x', n);
    text[n] = 0;
    snprintf(whole, n + strlen(json), json, text);
    free(text);
    return whole;
}

static void texts_have_as_many_bytes_as_their_rows_say(void **state)
{
    static const struct {
        const char *json, *path;
        size_t most;
    } rows[] = {
        {"{\"title\": \"%s\"}", "title", 1024},
        {"{\"unit\": \"%s\"}", "unit", 256},
        {"{\"views\": {\"a\": {\"decorations\": {\"caption\": \"%s\"}}}}", "views.a.decorations.caption", 4096},
        {"{\"datasets\": {\"a\": {\"part\": \"%s\"}}}", "datasets.a.part", 4096},
        {"{\"datasets\": {\"a\": {\"path\": \"%s\"}}}", "datasets.a.path", 4096},
    };
    char said[128];
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        vv_world *world = NULL;
        char *fits = with_text(rows[i].json, rows[i].most), *longer = with_text(rows[i].json, rows[i].most + 1);
        assert_int_equal(vv_scene_parse(&world, fits, strlen(fits), "test.vv.json", NULL, NULL), VV_OK);
        snprintf(said, sizeof said, "test.vv.json:%s: the text is %zu bytes long: at most %zu are allowed",
                 rows[i].path, rows[i].most + 1, rows[i].most);
        expect_failure(longer, VV_E_LIMIT, said);
        char *bare = with_text("%s", rows[i].most + 1);
        vv_object *root = &world->base; /* an edit, as the program and the server make it */
        assert_int_equal(vv_path_set(&root, rows[i].path, bare, NULL), VV_E_LIMIT);
        assert_non_null(strstr(vv_error_last()->message, "bytes long: at most"));
        vv_object_release(root);
        free(fits);
        free(longer);
        free(bare);
    }
}

static void too_many_entries_are_an_error(void **state)
{
    (void)state;
    const size_t n = 65537, room = 4 * n + 64;
    char *json = malloc(room);
    size_t at = (size_t)snprintf(json, room, "{\"cut_planes\": [{}");
    for (size_t i = 1; i < n; i++, at += 3)
        memcpy(json + at, ",{}", 3);
    memcpy(json + at, "]}", 3);
    vv_world *world = NULL;
    assert_int_equal(vv_scene_parse(&world, json, strlen(json), "test.vv.json", NULL, NULL), VV_E_LIMIT);
    free(json);
}

static void what_a_newer_schema_says_survives(void **state)
{
    (void)state;
    static const char text[] = "{\n"
                               "  \"$schema\": \"volvis.schema.json\",\n"
                               "  \"schema\": 2,\n"
                               "  \"title\": \"from the future\",\n"
                               "  \"lights\": {\n"
                               "    \"key\": {\n"
                               "      \"intensity\": 2,\n"
                               "      \"kind\": \"area\",\n"
                               "      \"polarised\": [\n"
                               "        1,\n"
                               "        -0.0,\n"
                               "        0.1,\n"
                               "        {\n"
                               "          \"deep\": null\n"
                               "        }\n"
                               "      ]\n"
                               "    }\n"
                               "  },\n"
                               "  \"fog\": {\n"
                               "    \"density\": 1e-300\n"
                               "  }\n"
                               "}\n";
    const vv_property_context context = vvi_registry_context(NULL);
    vv_world *world = parse(text, NULL, NULL);
    char *again = print(world, NULL);
    assert_string_equal(again, text);
    free(again);

    vv_object *edited = &world->base;
    assert_int_equal(vv_path_set(&edited, "lights.key.kind", "spot", &context), VV_OK);
    again = print((const vv_world *)edited, NULL);
    assert_non_null(strstr(again, "\"kind\": \"spot\""));
    assert_null(strstr(again, "area"));
    assert_non_null(strstr(again, "polarised"));
    free(again);
    vv_object_release(edited);
    expect_failure("{\"schema\": 1, \"fog\": {}}", VV_E_FORMAT,
                   "test.vv.json: unknown property 'fog'; there are schema, title, unit, background, ambient, seed, "
                   "shading, cut_planes, datasets, volumes, lights, views, measurements, cross_hair and up");
}

static void count_warnings(void *user, vv_log_level level, const char *component, const char *text)
{
    (void)component;
    *(int *)user += level == VV_LOG_WARNING && strstr(text, "newer") != NULL;
}

static void a_newer_schema_is_warned_of(void **state)
{
    (void)state;
    int n = 0;
    vv_runtime *runtime = NULL;
    vv_job *job = NULL;
    vv_runtime_options options;
    vv_runtime_options_init(&options, sizeof options);
    options.threads = 1;
    options.log = count_warnings;
    options.log_user = &n;
    assert_int_equal(vv_runtime_new(&runtime, &options), VV_OK);
    assert_int_equal(vv_job_new(&job, runtime, NULL, NULL), VV_OK);
    vv_object_release(&parse("{\"schema\": 1}", NULL, job)->base);
    assert_int_equal(n, 0);
    vv_object_release(&parse("{\"schema\": 7}", NULL, job)->base);
    assert_int_equal(n, 1);
    vv_job_release(job);
    vv_runtime_release(runtime);
}

/* A renderer that is nowhere else ------------------------------------------------------------------------------ */

typedef struct film_params {
    vv_object base;
    double grain;
    char *stock;
} film_params;

static const vv_property film_rows[] = {
    {VV_PROP(film_params, grain), .kind = VV_KIND_F64, .limited = true, .min = 0, .max = 1, .def = 0.25,
     .doc = "size of the grain"},
    {VV_PROP(film_params, stock), .kind = VV_KIND_STRING, .doc = "name of the film"},
    {0},
};
static const vv_class film_class = {
    .name = "film", .doc = "a test's own renderer", .size = sizeof(film_params), .properties = film_rows};
static const vv_renderer film = {.api = VV_RENDERER_API, .name = "film", .doc = "grain", .params = &film_class};
static const vv_renderer *const film_renderers[] = {&film, NULL};

static vv_job *film_job(vv_registry *registry)
{
    vv_runtime *runtime = NULL;
    vv_job *job = NULL;
    vv_runtime_options options;
    *registry = *vv_registry_builtin();
    registry->renderers = film_renderers;
    vv_runtime_options_init(&options, sizeof options);
    options.threads = 1;
    options.registry = registry;
    assert_int_equal(vv_runtime_new(&runtime, &options), VV_OK);
    assert_int_equal(vv_job_new(&job, runtime, NULL, NULL), VV_OK);
    vv_runtime_release(runtime);
    return job;
}

static void a_new_renderer_needs_no_edit_elsewhere(void **state)
{
    (void)state;
    static const char text[] = "{\"views\": {\"main\": {\"render\": {\"method\": \"film\", \"film\": {\"grain\": "
                               "0.5}}}}}";
    vv_registry registry;
    vv_job *job = film_job(&registry);
    const vv_property_context context = vvi_registry_context(&registry);
    vv_world *world = parse(text, NULL, job);
    vv_object *root = &world->base;
    char *json = NULL, *schema = NULL;
    assert_int_equal(vv_path_set(&root, "views.main.render.film.stock", "Tri-X", &context), VV_OK);
    assert_int_equal(vv_path_set(&root, "views.main.render.film.grian", "1", &context), VV_E_ARGUMENT);
    assert_string_equal(
        vv_error_last()->message,
        "views.main.render.film.grian: unknown property 'grian'; did you mean 'grain'? There are grain and stock");
    assert_int_equal(vv_path_get(&json, root, "views.main.render"), VV_OK);
    assert_string_equal(json, "{\"method\": \"film\", \"film\": {\"grain\": 0.5, \"stock\": \"Tri-X\"}}");
    free(json);
    assert_int_equal(vv_scene_schema(&schema, &registry), VV_OK);
    assert_non_null(strstr(schema, "size of the grain"));
    free(schema);
    json = print((const vv_world *)root, NULL);
    vv_world *again = parse(json, NULL, job);
    assert_true(vv_object_equal(root, &again->base));
    free(json);
    vv_object_release(&again->base);
    vv_object_release(root);

    vv_world *unknown = NULL;
    assert_int_equal(vv_scene_parse(&unknown, text, strlen(text), "test.vv.json", NULL, NULL), VV_E_FORMAT);
    vv_job_release(job);
}

/* Broken text --------------------------------------------------------------------------------------------------- */

static char *sample_scene(size_t *n_out)
{
    const vv_property_context context = vvi_registry_context(NULL);
    test_dice dice = {77, 0};
    vv_object *world = test_roll_world(&dice, 24, &context);
    char *json = print((const vv_world *)world, NULL);
    vv_object_release(world);
    *n_out = strlen(json);
    return json;
}

static void try_broken(const char *json, size_t n)
{
    vv_world *world = NULL;
    const vv_status st = vv_scene_parse(&world, json, n, "broken", NULL, NULL);
    if (st == VV_OK) {
        vv_object_release(&world->base);
        return;
    }
    assert_null(world);
    assert_true(st == VV_E_FORMAT || st == VV_E_LIMIT);
    assert_true(strlen(vv_error_last()->message) > 10);
}

static void truncation_at_every_byte_is_one_error(void **state)
{
    (void)state;
    size_t n = 0;
    char *json = sample_scene(&n);
    assert_true(n > 500);
    for (size_t i = 0; i + 2 < n; i++) {
        char *cut = malloc(i ? i : 1); /* its own block: reading past its end is seen */
        vv_world *world = NULL;
        memcpy(cut, json, i);
        assert_int_equal(vv_scene_parse(&world, cut, i, "cut", NULL, NULL), VV_E_FORMAT);
        assert_null(world);
        free(cut);
    }
    free(json);
}

static void flipped_bits_never_crash(void **state)
{
    (void)state;
    size_t n = 0;
    char *json = sample_scene(&n);
    for (size_t i = 0; i < n; i++) {
        for (int bit = 0; bit < 8; bit++) {
            json[i] = (char)(json[i] ^ 1 << bit);
            try_broken(json, n);
            json[i] = (char)(json[i] ^ 1 << bit);
        }
    }
    free(json);
}

/* Files --------------------------------------------------------------------------------------------------------- */

static void scenes_on_disk_name_data_relative_to_themselves(void **state)
{
    (void)state;
    char folder[] = "/tmp/volvis-scene-XXXXXX", here[4096];
    vv_world *world = NULL;
    char *json = NULL;
    const vv_property_context context = vvi_registry_context(NULL);
    assert_non_null(mkdtemp(folder));
    assert_non_null(getcwd(here, sizeof here));
    assert_int_equal(chdir(folder), 0);
    assert_int_equal(mkdir("scenes", 0777) | mkdir("data", 0777), 0);
    vv_object *root = &parse("{\"datasets\": {\"d\": {\"path\": \"data/a.nrrd\"}, \"e\": {\"path\": "
                             "\"/absolute/b.nrrd\"}, \"f\": {\"path\": \"scenes/c.nrrd\"}}}",
                             NULL, NULL)
                           ->base;
    if (vv_scene_write("scenes/s.vv.json", (const vv_world *)root, NULL) != VV_OK)
        fail_msg("%s", vv_error_last()->message);
    if (vv_scene_read(&world, "scenes/s.vv.json", NULL) != VV_OK)
        fail_msg("%s", vv_error_last()->message);
    assert_true(vv_object_equal(root, &world->base));
    vv_object_release(&world->base);

    json = print((const vv_world *)root, "scenes");
    assert_non_null(strstr(json, "\"../data/a.nrrd\""));
    assert_non_null(strstr(json, "\"/absolute/b.nrrd\""));
    assert_non_null(strstr(json, "\"c.nrrd\""));
    free(json);
    assert_int_equal(chdir("data"), 0); /* the scene finds its data from elsewhere too */
    assert_int_equal(vv_scene_read(&world, "../scenes/s.vv.json", NULL), VV_OK);
    assert_int_equal(vv_path_get(&json, &world->base, "datasets.f.path"), VV_OK);
    assert_string_equal(json, "\"../scenes/c.nrrd\"");
    free(json);
    vv_object_release(&world->base);
    assert_int_equal(vv_scene_read(&world, "nowhere.vv.json", NULL), VV_E_READ);
    vv_object_release(root);
    assert_int_equal(chdir(folder), 0);
    assert_int_equal(remove("scenes/s.vv.json") | rmdir("scenes") | rmdir("data"), 0);
    assert_int_equal(chdir(here), 0);
    assert_int_equal(rmdir(folder), 0);
    (void)context;
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(errors_say_file_place_and_what_was_expected),
        cmocka_unit_test(lengths_take_the_units_of_the_scene),
        cmocka_unit_test(limits_are_errors),
        cmocka_unit_test(texts_have_as_many_bytes_as_their_rows_say),
        cmocka_unit_test(too_many_entries_are_an_error),
        cmocka_unit_test(what_a_newer_schema_says_survives),
        cmocka_unit_test(a_newer_schema_is_warned_of),
        cmocka_unit_test(a_new_renderer_needs_no_edit_elsewhere),
        cmocka_unit_test(truncation_at_every_byte_is_one_error),
        cmocka_unit_test(flipped_bits_never_crash),
        cmocka_unit_test(scenes_on_disk_name_data_relative_to_themselves),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
