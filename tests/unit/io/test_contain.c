/* Formats that are read by the import program without being asked (vv_format.contained): HDF5 and what is made of it.
 */
#include "core/memory.h"
#include "fields.h"
#include "io_test.h"
#include "jobs.h"
#include <pthread.h>
#include <sys/wait.h>
#include <time.h>
#include <volvis/sys/registry.h>

static char said[8192];

static void take_line(void *user, vv_log_level level, const char *component, const char *text)
{
    (void)user;
    (void)level;
    (void)component;
    const size_t n = strlen(said);
    snprintf(said + n, sizeof said - n, "%s\n", text);
}

/* program NULL: none but what is beside this test or installed. */
static vv_job *job_of(const char *program, bool contain)
{
    vv_runtime_options options;
    vv_runtime *runtime;
    vv_job *job;
    vv_runtime_options_init(&options, sizeof options);
    assert_true(options.contain);
    options.threads = 2;
    options.memory_bytes = (uint64_t)256 << 20;
    options.contain = contain;
    options.import_program = program;
    options.log = take_line;
    options.log_level = VV_LOG_INFO;
    said[0] = 0;
    io_ok(vv_runtime_new(&runtime, &options));
    io_ok(vv_job_new(&job, runtime, NULL, NULL));
    vv_runtime_release(runtime);
    return job;
}

/* Children of this process that have not been waited for: the import program while a file is open. */
static bool has_child(void)
{
    siginfo_t info = {0};
    return waitid(P_ALL, 0, &info, WEXITED | WNOHANG | WNOWAIT) == 0;
}

static uint32_t checksum_of(vv_file *file, int64_t frame, const vv_box *box, vv_job *job)
{
    vv_field *field;
    uint32_t sum;
    io_ok(vv_file_read(&field, file, frame, box, job));
    io_ok(vv_field_checksum(&sum, field, NULL));
    vv_field_release(field);
    return sum;
}

static void same_both_ways(const char *path, const char *opened)
{
    static const vv_box boxes[] = {{{0, 0, 0}, {7, 5, 3}}, {{0, 0, 1}, {7, 5, 2}}, {{2, 1, 0}, {3, 4, 2}}};
    vv_job *here = job_of(NULL, false), *contained = job_of(VOLVIS_IMPORT, true);
    vv_file *a, *b;
    io_ok(vv_file_open(&a, path, NULL, here));
    assert_false(has_child());
    io_ok(vv_file_open(&b, opened, NULL, contained));
    assert_true(has_child());
    assert_string_equal(vv_file_format(a), vv_file_format(b));
    io_same_info(vv_file_info(a), vv_file_info(b));
    for (int64_t f = 0; f < vv_file_info(a)->n_frames; f++)
        for (size_t i = 0; i < sizeof boxes / sizeof *boxes; i++)
            assert_int_equal(checksum_of(a, f, &boxes[i], here), checksum_of(b, f, &boxes[i], contained));
    if (path == opened)
        assert_int_equal(vv_file_mappable(a), vv_file_mappable(b));
    vv_file_close(a);
    vv_file_close(b);
    assert_false(has_child());
    vv_job_release(here);
    vv_job_release(contained);
}

static const char *make(void **state, const char *name, vv_type type, const char *encoding, int frames)
{
    vv_field_info info = vv_field_info_default();
    vv_field *field[2];
    const int64_t dims[3] = {7, 5, 3};
    vv_write_options options;
    memcpy(info.grid.dims, dims, sizeof dims);
    info.type = type;
    vv_write_options_init(&options, sizeof options);
    options.encoding = encoding;
    for (int f = 0; f < frames; f++)
        field[f] = test_field_random(&info, (uint64_t)f, NULL);
    const char *path = io_path(state, name);
    io_ok(vv_field_write(path, (const vv_field *const *)field, (size_t)frames, &options, NULL));
    for (int f = 0; f < frames; f++)
        vv_field_release(field[f]);
    return path;
}

static void hdf5_is_contained_and_reads_the_same(void **state)
{
    static const char *const encodings[] = {"raw", "gzip"};
    static const vv_type types[] = {VV_TYPE_U8, VV_TYPE_U16, VV_TYPE_F64};
    for (int e = 0; e < 2; e++)
        for (int t = 0; t < 3; t++) {
            const char *path = make(state, "a.h5", types[t], encodings[e], 1 + t % 2);
            same_both_ways(path, path);
        }
}

static void samples_that_lie_plainly_are_mapped_by_who_asked(void **state)
{
    const char *path = make(state, "plain.h5", VV_TYPE_U16, "raw", 1);
    vv_job *job = job_of(VOLVIS_IMPORT, true);
    vv_file *file;
    vv_field *field;
    io_ok(vv_file_open(&file, path, NULL, job));
    assert_true(vv_file_mappable(file));
    const uint64_t before = vvi_memory_by_tag(vv_job_runtime(job), VVI_MEM_VOXELS);
    io_ok(vv_file_read(&field, file, 0, NULL, job));
    assert_int_equal(vvi_memory_by_tag(vv_job_runtime(job), VVI_MEM_VOXELS), before);
    vv_file_close(file); /* the field goes on */
    assert_false(has_child());
    uint32_t sum;
    io_ok(vv_field_checksum(&sum, field, NULL));
    vv_field_release(field);
    vv_job_release(job);
}

typedef struct feeding {
    const char *from, *to;
} feeding;

static void *feed(void *user)
{
    const feeding *f = user;
    size_t n;
    uint8_t *bytes = io_get(f->from, &n);
    io_put(f->to, bytes, n); /* waits until somebody reads */
    free(bytes);
    return NULL;
}

static void pipes_are_handed_over(void **state)
{
    const char *path = make(state, "p.h5", VV_TYPE_I16, "gzip", 2);
    feeding f = {path, io_path(state, "fifo")};
    pthread_t feeder;
    assert_int_equal(mkfifo(f.to, 0600), 0);
    assert_int_equal(pthread_create(&feeder, NULL, feed, &f), 0);
    same_both_ways(path, f.to);
    pthread_join(feeder, NULL);
}

static void without_the_program_it_is_read_here(void **state)
{
    const char *path = make(state, "h.h5", VV_TYPE_U8, "gzip", 1);
    vv_job *job = job_of(NULL, true);
    vv_file *file;
    io_ok(vv_file_open(&file, path, NULL, job));
    assert_true(has_child() || strstr(said, "there is no import program"));
    vv_file_close(file);
    vv_job_release(job);
    /* other formats need none */
    job = job_of("/nonexistent", true);
    io_ok(vv_file_open(&file, make(state, "h.nrrd", VV_TYPE_U8, "raw", 1), NULL, job));
    vv_file_close(file);
    vv_job_release(job);
}

/* What lies where samples would be mapped from is checked against the file; the name says which lie. */
static void where_samples_lie_is_checked(void **state)
{
    static const struct {
        const char *lie;
        vv_status status;
    } lies[] = {{"mapped", VV_OK}, {"beyond", VV_E_READ}, {"before", VV_E_READ}, {"truth", VV_OK}};
    for (size_t i = 0; i < sizeof lies / sizeof *lies; i++) {
        static const uint8_t bytes[64] = "\x89HDF\r\n\x1a\n";
        vv_job *job = job_of(IMPORT_LIAR, true);
        vv_file *file;
        vv_field *field;
        const char *path = io_path(state, lies[i].lie);
        io_put(path, bytes, sizeof bytes);
        io_ok(vv_file_open(&file, path, NULL, job));
        assert_int_equal(vv_file_read(&field, file, 0, NULL, job), lies[i].status);
        if (lies[i].status == VV_OK) {
            assert_true(vv_field_value(field, 0, 0, 0, 0) == (i == 0 ? 0x89 : 7));
            vv_field_release(field);
        } else {
            assert_non_null(strstr(vv_error_last()->message, "an invalid answer"));
        }
        vv_file_close(file);
        vv_job_release(job);
        assert_false(has_child());
    }
}

static void *cancel_soon(void *user)
{
    usleep(200000);
    vv_job_cancel(user);
    return NULL;
}

static void cancel_ends_a_reader_that_never_answers(void **state)
{
    static const uint8_t bytes[64] = "\x89HDF\r\n\x1a\n";
    vv_job *job = job_of(IMPORT_LIAR, true);
    vv_file *file;
    vv_field *field;
    pthread_t other;
    const char *path = io_path(state, "silent");
    io_put(path, bytes, sizeof bytes);
    io_ok(vv_file_open(&file, path, NULL, job));
    assert_int_equal(pthread_create(&other, NULL, cancel_soon, job), 0);
    assert_int_equal(vv_file_read(&field, file, 0, NULL, job), VV_E_CANCELLED);
    assert_false(has_child());
    pthread_join(other, NULL);
    vv_file_close(file);
    vv_job_release(job);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(hdf5_is_contained_and_reads_the_same, io_setup, io_teardown),
        cmocka_unit_test_setup_teardown(samples_that_lie_plainly_are_mapped_by_who_asked, io_setup, io_teardown),
        cmocka_unit_test_setup_teardown(pipes_are_handed_over, io_setup, io_teardown),
        cmocka_unit_test_setup_teardown(without_the_program_it_is_read_here, io_setup, io_teardown),
        cmocka_unit_test_setup_teardown(where_samples_lie_is_checked, io_setup, io_teardown),
        cmocka_unit_test_setup_teardown(cancel_ends_a_reader_that_never_answers, io_setup, io_teardown),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
