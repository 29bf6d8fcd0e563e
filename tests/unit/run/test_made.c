/* Datasets that are made of others: the truth is the operation run by hand, and what a scene may not ask for. */
#include "../io/io_test.h"
#include "core/cache.h"
#include "core/memory.h"
#include "core/text.h"
#include "fields.h"
#include "grid/mesh.h"
#include "jobs.h"
#include "model/merge.h"
#include "operations.h"
#include "registry.h"

enum { N = 9 };

static void ok(vv_status st)
{
    if (st != VV_OK)
        fail_msg("%s: %s", vv_error_last()->where ? vv_error_last()->where : "", vv_error_last()->message);
}

/* Values that no filter leaves as they are; time step t has t hundred more. */
static vv_field *make_frame(int t, vv_meaning meaning)
{
    vv_field_info info = vv_field_info_default();
    vv_field *field;
    void *data;
    info.type = VV_TYPE_U16;
    info.meaning = meaning;
    snprintf(info.grid.unit, sizeof info.grid.unit, "mm");
    for (int a = 0; a < 3; a++)
        info.grid.dims[a] = N + a;
    ok(vv_field_new_empty(&field, &data, &info, NULL));
    for (int i = 0; i < N * (N + 1) * (N + 2); i++)
        ((uint16_t *)data)[i] =
            (uint16_t)(meaning == VV_MEANING_LABEL ? (i / 300) % 3 : (i * i) % 97 + 100 * t * (1 + i % 2));
    return field;
}

static const char *write_frames(void **state, const char *name, int n_frames, vv_meaning meaning)
{
    static const vv_label labels[2] = {{.value = 1, .name = "liver"}, {.value = 2, .name = "spleen"}};
    vv_field *frames[4];
    vv_write_options options;
    const char *path = io_path(state, name);
    vv_write_options_init(&options, sizeof options);
    options.labels = meaning == VV_MEANING_LABEL ? labels : NULL;
    options.n_labels = meaning == VV_MEANING_LABEL ? 2 : 0;
    for (int t = 0; t < n_frames; t++)
        frames[t] = make_frame(t, meaning);
    ok(vv_field_write(path, (const vv_field *const *)frames, (size_t)n_frames, &options, NULL));
    for (int t = 0; t < n_frames; t++)
        vv_field_release(frames[t]);
    return path;
}

/* A World of one file, "file", and what else `datasets` says. */
static vv_world *world_of(void **state, const char *file, const char *datasets)
{
    vv_world *world = NULL;
    char *json = vvi_asprintf("{\"datasets\": {\"file\": {\"path\": \"%s\"}, %s}}", file, datasets);
    ok(vv_scene_parse(&world, json, strlen(json), "test", (const char *)*state, NULL));
    free(json);
    return world;
}

static const vv_dataset *dataset_of(const vv_world *world, const char *id)
{
    return (const vv_dataset *)(const void *)vv_collection_find(world->datasets, id);
}

static vv_field *field_of(const vv_world *world, const char *id, int64_t frame, vv_job *job)
{
    vv_field *field = NULL;
    ok(vv_dataset_field(&field, world, dataset_of(world, id), NULL, frame, job));
    return field;
}

static const char *const SMOOTH = "\"smooth\": {\"operation\": \"gaussian\", \"inputs\": {\"volume\": \"file\"}, "
                                  "\"parameters\": {\"sigma\": \"1.5mm\"}}";

static void what_is_made_is_what_its_operation_makes(void **state)
{
    vv_job *job = test_job(2, 0);
    vv_field *in = make_frame(0, VV_MEANING_SCALAR), *truth = NULL;
    vv_world *world = world_of(state, write_frames(state, "in.nrrd", 1, VV_MEANING_SCALAR), SMOOTH);
    vv_field *made = field_of(world, "smooth", 0, job);
    vv_field_info planned;
    ok(test_apply(&truth, &vvi_operation_gaussian, in, "sigma=1.5", NULL));
    assert_true(test_same_samples(made, truth));
    assert_false(test_same_samples(made, in));
    ok(vv_dataset_info(&planned, world, dataset_of(world, "smooth"), job));
    assert_memory_equal(planned.grid.dims, vv_field_get_info(made)->grid.dims, sizeof planned.grid.dims);
    assert_int_equal(planned.type, vv_field_get_info(made)->type);
    assert_true(vv_dataset_is_made(dataset_of(world, "smooth")) && !vv_dataset_is_made(dataset_of(world, "file")));
    assert_false(vv_dataset_is_mesh(dataset_of(world, "smooth"), job));
    vv_field_release(in);
    vv_field_release(truth);
    vv_field_release(made);
    vv_object_release(&world->base);
    vv_job_release(job);
}

static void what_is_made_may_stand_on_what_is_made(void **state)
{
    char datasets[1024];
    snprintf(datasets, sizeof datasets,
             "%s, \"much\": {\"operation\": \"threshold\", \"inputs\": {\"volume\": \"smooth\"}, "
             "\"parameters\": {\"range\": \"50..\"}}, "
             "\"both\": {\"operation\": \"calc\", \"inputs\": {\"p\": \"file\", \"q\": \"much\"}, "
             "\"parameters\": {\"formula\": \"p*q\"}}",
             SMOOTH);
    vv_world *world = world_of(state, write_frames(state, "in.nrrd", 1, VV_MEANING_SCALAR), datasets);
    vv_field *file = field_of(world, "file", 0, NULL), *much = field_of(world, "much", 0, NULL);
    vv_field *both = field_of(world, "both", 0, NULL); /* without a job nothing is kept, and all is made again */
    uint64_t n = 0;
    for (int64_t k = 0; k < N + 2; k++)
        for (int64_t i = 0; i < N; i++) {
            const double a = vv_field_value(file, i, k % N, k, 0), b = vv_field_value(much, i, k % N, k, 0);
            assert_true(b == 0 || b == 1);
            assert_true(vv_field_value(both, i, k % N, k, 0) == a * b);
            n += b == 1;
        }
    assert_true(n > 0 && n < N * (N + 2));
    vv_field_release(file);
    vv_field_release(much);
    vv_field_release(both);
    vv_object_release(&world->base);
}

static void it_is_made_once_dropped_and_made_again(void **state)
{
    vv_job *job = test_job(1, 0);
    vv_world *world = world_of(state, write_frames(state, "in.nrrd", 1, VV_MEANING_SCALAR), SMOOTH);
    vv_field *one = field_of(world, "smooth", 0, job), *two = field_of(world, "smooth", 0, job);
    assert_ptr_equal(one, two);
    const uint64_t identity = vv_field_identity(one);
    vv_field_release(one);
    vvi_cache_shed(vv_job_runtime(job), UINT64_MAX);
    vv_field *again = field_of(world, "smooth", 0, job);
    assert_true(vv_field_identity(again) != identity);
    assert_true(test_same_samples(again, two));
    vv_field_release(two);
    vv_field_release(again);
    vv_object_release(&world->base);
    vv_job_release(job);
}

static void a_parameter_changes_it_and_what_stands_on_it(void **state)
{
    char datasets[512];
    vv_job *job = test_job(1, 0);
    vv_object *root;
    char *json = NULL;
    snprintf(
        datasets, sizeof datasets,
        "%s, \"top\": {\"operation\": \"crop\", \"inputs\": {\"volume\": \"smooth\"}, \"parameters\": {\"z\": \"3:\"}}",
        SMOOTH);
    vv_world *world = world_of(state, write_frames(state, "in.nrrd", 1, VV_MEANING_SCALAR), datasets);
    vv_field *before = field_of(world, "top", 0, job);
    root = vv_object_retain(&world->base);
    ok(vv_path_set(&root, "datasets.smooth.parameters.sigma", "3vox", NULL));
    ok(vv_path_get(&json, root, "datasets.smooth.parameters.sigma"));
    assert_string_equal(json, "\"3vox\"");
    vv_field *after = field_of((const vv_world *)(const void *)root, "top", 0, job);
    assert_false(test_same_samples(before, after));
    ok(vv_path_copy(&root, &world->base, "datasets.smooth.parameters.sigma", NULL)); /* as undo does it */
    assert_true(vv_object_equal(root, &world->base));
    vv_field *back = field_of((const vv_world *)(const void *)root, "top", 0, job);
    assert_ptr_equal(before, back);
    free(json);
    vv_field_release(before);
    vv_field_release(after);
    vv_field_release(back);
    vv_object_release(root);
    vv_object_release(&world->base);
    vv_job_release(job);
}

static void a_file_that_changes_is_worked_on_again(void **state)
{
    vv_job *job = test_job(1, 0);
    vv_world *world = world_of(state, write_frames(state, "in.nrrd", 1, VV_MEANING_SCALAR), SMOOTH);
    vv_field *before = field_of(world, "smooth", 0, job);
    vv_field *other = make_frame(3, VV_MEANING_SCALAR);
    const vv_field *fields[] = {other};
    ok(vv_field_write(io_path(state, "in.nrrd"), fields, 1, NULL, NULL));
    vv_field *after = field_of(world, "smooth", 0, job);
    assert_false(test_same_samples(before, after));
    vv_field_release(before);
    vv_field_release(after);
    vv_field_release(other);
    vv_object_release(&world->base);
    vv_job_release(job);
}

/* A window that samples decide is one for all time steps, and only the step that is asked for is made. */
static void a_time_step_is_made_alone_and_settled_with_the_others(void **state)
{
    vv_job *job = test_job(2, 0);
    vv_field_info info;
    const char *path = write_frames(state, "in.nrrd", 3, VV_MEANING_SCALAR);
    vv_world *world = world_of(state, path,
                               "\"bytes\": {\"operation\": \"rescale\", \"inputs\": {\"volume\": \"file\"}, "
                               "\"parameters\": {\"type\": \"u8\", \"percentile\": [0, 100]}}");
    vv_property_context none = {0};
    vv_object *params = NULL;
    vv_run *run = NULL;
    vv_file *file = io_open(path);
    static const char text[] = "{\"type\": \"u8\", \"percentile\": [0, 100]}";
    ok(vv_object_from_json(&params, vvi_operation_rescale.params, text, strlen(text), &none));
    const vv_run_input input = {.file = file, .frame = -1, .name = "in"};
    const vv_step step = {&vvi_operation_rescale, params};
    ok(vv_run_new(&run, &input, 1, &step, 1, &(vv_run_output){.path = NULL}, "test", job));
    ok(vv_run_make(run));
    vv_field *made = field_of(world, "bytes", 1, job);
    assert_true(test_same_samples(made, vv_run_field(run, 1)));
    assert_false(test_same_samples(made, vv_run_field(run, 2)));
    assert_null(vv_run_field(run, 3));
    assert_int_equal(vv_run_write(run), VV_E_ARGUMENT); /* it has no file to be written to */
    ok(vv_dataset_info(&info, world, dataset_of(world, "bytes"), job));
    assert_int_equal(info.n_frames, 3);
    vv_field *none_such = NULL;
    assert_int_equal(vv_dataset_field(&none_such, world, dataset_of(world, "bytes"), NULL, 3, job), VV_E_ARGUMENT);
    assert_non_null(strstr(vv_error_last()->message, "datasets.bytes: there is no time step 3"));
    vv_field_release(made);
    vv_run_release(run);
    vv_object_release(params);
    vv_file_close(file);
    vv_object_release(&world->base);
    vv_job_release(job);
}

static void names_of_labels_go_along_into_meshes(void **state)
{
    vv_job *job = test_job(2, 0);
    vv_mesh *mesh = NULL;
    vv_world *world = world_of(state, write_frames(state, "in.nrrd", 1, VV_MEANING_LABEL),
                               "\"part\": {\"operation\": \"crop\", \"inputs\": {\"volume\": \"file\"}, "
                               "\"parameters\": {\"x\": \"1:8\"}}, "
                               "\"skin\": {\"operation\": \"isosurface\", \"inputs\": {\"volume\": \"part\"}}, "
                               "\"less\": {\"operation\": \"simplify\", \"inputs\": {\"mesh\": \"skin\"}, "
                               "\"parameters\": {\"share\": 0.5}}");
    assert_true(vv_dataset_is_mesh(dataset_of(world, "less"), job));
    ok(vv_dataset_mesh(&mesh, world, dataset_of(world, "less"), job));
    const vv_mesh_info *info = vv_mesh_get_info(mesh);
    assert_int_equal(info->n_parts, 2);
    assert_string_equal(info->parts[0].name, "liver");
    assert_string_equal(info->parts[1].name, "spleen");
    assert_string_equal(info->unit, "mm");
    vv_mesh_release(mesh);
    vv_field *field = NULL;
    assert_int_equal(vv_dataset_field(&field, world, dataset_of(world, "skin"), NULL, 0, job), VV_E_UNSUPPORTED);
    vv_object_release(&world->base);
    vv_job_release(job);
}

/* Samples that memory does not hold beside their file are made from parts of it; the bytes are the same. */
static void what_memory_does_not_hold_is_read_in_parts(void **state)
{
    enum { SIDE = 160 };
    vv_field_info info = vv_field_info_default();
    vv_field *big, *truth = NULL;
    void *data;
    vv_write_options options;
    info.type = VV_TYPE_U16;
    info.grid.dims[0] = info.grid.dims[1] = info.grid.dims[2] = SIDE;
    ok(vv_field_new_empty(&big, &data, &info, NULL));
    for (uint32_t i = 0; i < SIDE * SIDE * SIDE; i++)
        ((uint16_t *)data)[i] = (uint16_t)(i / 64 * 2654435761U >> 20);
    vv_write_options_init(&options, sizeof options);
    options.encoding = "gzip";
    options.level = 1;
    const char *path = io_path(state, "big.nrrd");
    ok(vv_field_write(path, (const vv_field *const *)&big, 1, &options, NULL));
    ok(test_apply(&truth, &vvi_operation_crop, big, "x=\"10:30\";z=\"40:120\"", NULL));
    vv_world *world = world_of(state, path,
                               "\"part\": {\"operation\": \"crop\", \"inputs\": {\"volume\": \"file\"}, "
                               "\"parameters\": {\"x\": \"10:30\", \"z\": \"40:120\"}}");
    vv_job *job = test_job(2, 7 << 20); /* less than the 8 MB of the file */
    vv_field *made = field_of(world, "part", 0, job);
    assert_true(test_same_samples(made, truth));
    vv_field_release(made);
    vv_field_release(truth);
    vv_field_release(big);
    vv_object_release(&world->base);
    vv_job_release(job);
}

static void cancelled_work_leaves_nothing_and_others_go_on(void **state)
{
    vv_job *job = test_job(1, 0), *other = NULL;
    vv_field *field = NULL;
    vv_world *world = world_of(state, write_frames(state, "in.nrrd", 1, VV_MEANING_SCALAR), SMOOTH);
    ok(vv_job_new(&other, vv_job_runtime(job), NULL, NULL));
    vv_job_cancel(job);
    assert_int_equal(vv_dataset_field(&field, world, dataset_of(world, "smooth"), NULL, 0, job), VV_E_CANCELLED);
    assert_null(field);
    field = field_of(world, "smooth", 0, other);
    vv_field_release(field);
    vv_object_release(&world->base);
    vv_job_release(other);
    vv_job_release(job);
}

static void what_is_added_to_a_world_stays_made_of_its_own(void **state)
{
    vv_field *two = make_frame(2, VV_MEANING_SCALAR);
    const vv_field *fields[] = {two};
    ok(vv_field_write(io_path(state, "two.nrrd"), fields, 1, NULL, NULL));
    vv_field_release(two);
    vv_world *world = world_of(state, write_frames(state, "in.nrrd", 1, VV_MEANING_SCALAR), SMOOTH);
    vv_world *other = world_of(state, io_path(state, "two.nrrd"), SMOOTH);
    vv_field *truth = field_of(other, "smooth", 0, NULL), *first = field_of(world, "smooth", 0, NULL);
    ok(vvi_world_merge(&world, other, NULL));
    assert_string_equal(dataset_of(world, "smooth_2")->inputs, "{\"volume\": \"file_2\"}");
    vv_field *added = field_of(world, "smooth_2", 0, NULL), *before = field_of(world, "smooth", 0, NULL);
    assert_true(test_same_samples(added, truth));
    assert_true(test_same_samples(before, first));
    assert_false(test_same_samples(added, before));
    vv_field_release(truth);
    vv_field_release(first);
    vv_field_release(added);
    vv_field_release(before);
    vv_object_release(&world->base);
    vv_object_release(&other->base);
}

/* What a scene may not ask for --------------------------------------------------------------------------------------
 */

static const struct {
    const char *datasets; /* "x" is asked for */
    vv_status status;
    const char *where, *text;
} refused[] = {
    {"\"x\": {\"operation\": \"gausian\"}", VV_E_NOT_FOUND, "datasets.x.operation", "did you mean 'gaussian'?"},
    {"\"x\": {\"operation\": \"gaussian\"}", VV_E_ARGUMENT, "datasets.x.inputs.volume", "name a dataset"},
    {"\"x\": {\"operation\": \"gaussian\", \"inputs\": {\"volume\": \"fiel\"}}", VV_E_NOT_FOUND,
     "datasets.x.inputs.volume", "did you mean 'file'?"},
    {"\"x\": {\"operation\": \"gaussian\", \"inputs\": {\"volum\": \"file\"}}", VV_E_NOT_FOUND,
     "datasets.x.inputs.volum", "did you mean 'volume'?"},
    {"\"x\": {\"operation\": \"gaussian\", \"inputs\": {\"volume\": 7}}", VV_E_ARGUMENT, "datasets.x.inputs.volume",
     "expected the name of a dataset, found 7"},
    {"\"x\": {\"operation\": \"gaussian\", \"inputs\": {\"volume\": \"file\"}, \"parameters\": {\"sgma\": 1}}",
     VV_E_NOT_FOUND, "datasets.x.parameters.sgma", "did you mean 'sigma'?"},
    {"\"x\": {\"operation\": \"gaussian\", \"inputs\": {\"volume\": \"file\"}, \"parameters\": {\"sigma\": \"2s\"}}",
     VV_E_ARGUMENT, "datasets.x.parameters.sigma", "'2s'"},
    {"\"x\": {\"operation\": \"gaussian\", \"inputs\": {\"volume\": \"x\"}}", VV_E_ARGUMENT, "datasets.x.inputs",
     "made of itself (x -> x)"},
    {"\"x\": {\"operation\": \"gaussian\", \"inputs\": {\"volume\": \"y\"}}, "
     "\"y\": {\"operation\": \"median\", \"inputs\": {\"volume\": \"x\"}}",
     VV_E_ARGUMENT, "datasets.x.inputs", "made of itself (x -> y -> x)"},
    {"\"x\": {\"operation\": \"gaussian\", \"inputs\": {\"volume\": \"y\"}}, "
     "\"y\": {\"operation\": \"median\", \"inputs\": {\"volume\": \"z\"}}, "
     "\"z\": {\"operation\": \"median\", \"inputs\": {\"volume\": \"y\"}}",
     VV_E_ARGUMENT, "datasets.y.inputs", "made of itself (y -> z -> y)"},
    {"\"x\": {\"operation\": \"gaussian\", \"on\": false, \"inputs\": {\"volume\": \"y\"}}, "
     "\"y\": {\"operation\": \"median\", \"on\": false, \"inputs\": {\"volume\": \"x\"}}",
     VV_E_ARGUMENT, "datasets.x.inputs", "made of itself (x -> y -> x)"},
    {"\"x\": {\"operation\": \"simplify\", \"inputs\": {\"mesh\": \"file\"}}", VV_E_ARGUMENT, "datasets.x.inputs.mesh",
     "simplify takes a mesh, and 'file' is a volume"},
    {"\"x\": {\"operation\": \"gaussian\", \"inputs\": {\"volume\": \"m\"}}, "
     "\"m\": {\"operation\": \"isosurface\", \"inputs\": {\"volume\": \"file\"}}",
     VV_E_ARGUMENT, "datasets.x.inputs.volume", "gaussian takes a volume, and 'm' is a mesh"},
    {"\"x\": {\"operation\": \"calc\", \"parameters\": {\"formula\": \"a\"}}", VV_E_ARGUMENT, "datasets.x.inputs",
     "calc needs inputs"},
    {"\"x\": {\"operation\": \"calc\", \"inputs\": {\"a\": \"file\"}, \"parameters\": {\"formula\": \"a+\"}}",
     VV_E_ARGUMENT, "datasets.x.parameters", ""},
    {"\"x\": {\"operation\": \"resample\", \"inputs\": {\"volume\": \"file\"}, \"parameters\": {\"spacing\": 1e-5}}",
     VV_E_LIMIT, "datasets.x.parameters", "samples"},
};

static void what_a_scene_may_not_ask_for_is_said_with_its_path(void **state)
{
    const char *path = write_frames(state, "in.nrrd", 1, VV_MEANING_SCALAR);
    vv_job *job = test_job(1, 0);
    for (size_t i = 0; i < sizeof refused / sizeof *refused; i++) {
        vv_world *world = world_of(state, path, refused[i].datasets);
        vv_field *field = NULL;
        vv_mesh *mesh = NULL;
        const vv_dataset *x = dataset_of(world, "x");
        const vv_status st = vv_dataset_is_mesh(x, job) ? vv_dataset_mesh(&mesh, world, x, job)
                                                        : vv_dataset_field(&field, world, x, NULL, 0, job);
        const vv_error *error = vv_error_last();
        if (st != refused[i].status || !error->where || strcmp(error->where, refused[i].where) != 0 ||
            !strstr(error->message, refused[i].text))
            fail_msg("%s: %d %s: %s", refused[i].datasets, st, error->where ? error->where : "", error->message);
        vv_object_release(&world->base);
    }
    vv_job_release(job);
}

/* n datasets, d0 of the file, each with two inputs that are the one before: 2^n ways to go. */
static char *doubling(int n)
{
    vvi_text text = {0};
    for (int i = 0; i < n; i++) {
        char before[16];
        snprintf(before, sizeof before, i ? "d%d" : "file", i - 1);
        vvi_text_printf(&text,
                        "%s\"d%d\": {\"operation\": \"calc\", \"inputs\": {\"a\": \"%s\", \"b\": \"%s\"}, "
                        "\"parameters\": {\"formula\": \"(a+b)/2\"}}",
                        i ? ", " : "", i, before, before);
    }
    return vvi_text_take(&text);
}

/* n datasets, one after the other. */
static char *chain(int n)
{
    vvi_text text = {0};
    for (int i = 0; i < n; i++) {
        char before[16];
        snprintf(before, sizeof before, i ? "d%d" : "file", i - 1);
        vvi_text_printf(&text,
                        "%s\"d%d\": {\"operation\": \"flip\", \"source\": \"%s\", \"parameters\": {\"axes\": \"x\"}}",
                        i ? ", " : "", i, before);
    }
    return vvi_text_take(&text);
}

static vv_status ask_last(void **state, char *datasets, int n, vv_field **out, vv_job *job)
{
    char id[16];
    vv_world *world = world_of(state, write_frames(state, "in.nrrd", 1, VV_MEANING_SCALAR), datasets);
    snprintf(id, sizeof id, "d%d", n - 1);
    const vv_status st = vv_dataset_field(out, world, dataset_of(world, id), NULL, 0, job);
    vv_object_release(&world->base);
    free(datasets);
    return st;
}

static void chains_have_an_end(void **state)
{
    vv_job *job = test_job(1, 0);
    vv_field *in = make_frame(0, VV_MEANING_SCALAR), *made = NULL;
    ok(ask_last(state, chain(64), 64, &made, job)); /* an even number of times turned */
    assert_true(test_same_samples(made, in));
    vv_field_release(made);
    assert_int_equal(ask_last(state, chain(65), 65, &made, job), VV_E_LIMIT);
    assert_non_null(strstr(vv_error_last()->message, "more than 64 operations one after the other"));
    assert_int_equal(ask_last(state, chain(2000), 2000, &made, job), VV_E_LIMIT);
    ok(ask_last(state, doubling(8), 8, &made, job));
    assert_true(vv_field_value(made, 3, 4, 5, 0) == vv_field_value(in, 3, 4, 5, 0));
    vv_field_release(made);
    assert_int_equal(ask_last(state, doubling(60), 60, &made, job), VV_E_LIMIT);
    assert_non_null(strstr(vv_error_last()->message, "more than 4096 operations in all"));
    vv_field_release(in);
    vv_job_release(job);
}

static void scenes_keep_the_recipe_as_it_was_written(void **state)
{
    static const char scene[] = "{\n"
                                "  \"schema\": 1,\n"
                                "  \"datasets\": {\n"
                                "    \"a\": {\n"
                                "      \"operation\": \"gaussian\",\n"
                                "      \"inputs\": {\n"
                                "        \"volume\": \"b\"\n"
                                "      },\n"
                                "      \"parameters\": {\n"
                                "        \"sigma\": [\n"
                                "          \"1.5vox\",\n"
                                "          0.1,\n"
                                "          2\n"
                                "        ]\n"
                                "      }\n"
                                "    },\n"
                                "    \"b\": {\n"
                                "      \"path\": \"in.nrrd\"\n"
                                "    }\n"
                                "  }\n"
                                "}\n";
    static const char old[] =
        "{\"datasets\": {\"r\": {\"path\": \"r.nrrd\", \"source\": \"b\", \"operation\": \"crop\", "
        "\"parameters\": \"{\\\"x\\\": \\\"1:\\\"}\"}}}";
    vv_world *world = NULL;
    char *json = NULL;
    (void)state;
    ok(vv_scene_parse(&world, scene, strlen(scene), "test", NULL, NULL));
    ok(vv_scene_print(&json, world, NULL));
    assert_string_equal(json, scene);
    free(json);
    vv_object_release(&world->base);
    ok(vv_scene_parse(&world, old, strlen(old), "test", NULL, NULL)); /* once a text; and a file stays a file */
    assert_string_equal(dataset_of(world, "r")->parameters, "{\"x\": \"1:\"}");
    assert_false(vv_dataset_is_made(dataset_of(world, "r")));
    vv_object_release(&world->base);
    static const char bad[] = "{\"datasets\": {\"r\": {\"parameters\": 3}}}";
    assert_int_equal(vv_scene_parse(&world, bad, strlen(bad), "test", NULL, NULL), VV_E_FORMAT);
    char *long_one = vvi_asprintf("{\"datasets\": {\"r\": {\"parameters\": {\"x\": \"%065536d\"}}}}", 1);
    assert_int_equal(vv_scene_parse(&world, long_one, strlen(long_one), "test", NULL, NULL), VV_E_LIMIT);
    assert_string_equal(vv_error_last()->where, "datasets.r.parameters");
    free(long_one);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(what_is_made_is_what_its_operation_makes, io_setup, io_teardown),
        cmocka_unit_test_setup_teardown(what_is_made_may_stand_on_what_is_made, io_setup, io_teardown),
        cmocka_unit_test_setup_teardown(it_is_made_once_dropped_and_made_again, io_setup, io_teardown),
        cmocka_unit_test_setup_teardown(a_parameter_changes_it_and_what_stands_on_it, io_setup, io_teardown),
        cmocka_unit_test_setup_teardown(a_file_that_changes_is_worked_on_again, io_setup, io_teardown),
        cmocka_unit_test_setup_teardown(a_time_step_is_made_alone_and_settled_with_the_others, io_setup, io_teardown),
        cmocka_unit_test_setup_teardown(names_of_labels_go_along_into_meshes, io_setup, io_teardown),
        cmocka_unit_test_setup_teardown(what_memory_does_not_hold_is_read_in_parts, io_setup, io_teardown),
        cmocka_unit_test_setup_teardown(cancelled_work_leaves_nothing_and_others_go_on, io_setup, io_teardown),
        cmocka_unit_test_setup_teardown(what_is_added_to_a_world_stays_made_of_its_own, io_setup, io_teardown),
        cmocka_unit_test_setup_teardown(what_a_scene_may_not_ask_for_is_said_with_its_path, io_setup, io_teardown),
        cmocka_unit_test_setup_teardown(chains_have_an_end, io_setup, io_teardown),
        cmocka_unit_test(scenes_keep_the_recipe_as_it_was_written),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
