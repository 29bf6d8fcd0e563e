/* Output appears whole or not at all. */
#include "core/allowed_places.h"
#include "core/job.h"
#include "core/memory.h"
#include "fields.h"
#include "io/sink.h"
#include "io/sink_folder.h"
#include "io/source.h"
#include "io_test.h"
#include "jobs.h"
#include <dirent.h>
#include <fcntl.h>
#include <signal.h>
#include <sys/file.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <time.h>

static size_t files_in(void **state)
{
    size_t n = 0;
    DIR *dir = opendir(*state);
    assert_non_null(dir);
    for (struct dirent *e; (e = readdir(dir)) != NULL;)
        n += e->d_name[0] != '.' || (strcmp(e->d_name, ".") != 0 && strcmp(e->d_name, "..") != 0);
    closedir(dir);
    return n;
}

static void nothing_is_seen_before_the_commit_and_all_of_it_after(void **state)
{
    vv_sink *sink;
    const char *path = io_path(state, "whole");
    io_put_text(path, "old");
    io_ok(vvi_sink_open(&sink, path, NULL));
    io_ok(vvi_sink_write(sink, "new and longer", 14));
    size_t n;
    uint8_t *before = io_get(path, &n);
    assert_string_equal((char *)before, "old");
    io_ok(vvi_sink_commit(sink));
    uint8_t *after = io_get(path, &n);
    assert_string_equal((char *)after, "new and longer");
    free(before);
    free(after);
    assert_int_equal(remove(path), 0);
}

static void what_stays_in_memory_is_all_that_was_written(void **state)
{
    (void)state;
    static const size_t sizes[] = {0, 1, 1000, 262143, 262144, 262145, 1000003};
    uint8_t *data = test_malloc(1000003);
    for (size_t i = 0; i < 1000003; i++)
        data[i] = (uint8_t)(i * 2654435761u >> 13);
    for (size_t i = 0; i < sizeof sizes / sizeof *sizes; i++) {
        vv_sink *sink;
        uint8_t *taken;
        size_t n;
        io_ok(vvi_sink_open_memory(&sink, "a picture", NULL));
        for (size_t at = 0; at < sizes[i];) {
            const size_t part = sizes[i] - at < 70001 ? sizes[i] - at : 70001;
            io_ok(vvi_sink_write(sink, data + at, part));
            at += part;
        }
        io_ok(vvi_sink_take(&taken, &n, sink));
        assert_int_equal(n, sizes[i]);
        if (n)
            assert_memory_equal(taken, data, n);
        vvi_free(taken);
    }
    test_free(data);
}

static void an_abandoned_file_leaves_the_old_one_and_no_litter(void **state)
{
    vv_sink *sink, *beside;
    const char *path = io_path(state, "kept");
    io_put_text(path, "old");
    const size_t before = files_in(state);
    io_ok(vvi_sink_open(&sink, path, NULL));
    io_ok(vvi_sink_beside(&beside, sink, "kept.data"));
    io_ok(vvi_sink_write(beside, "x", 1));
    assert_int_equal(files_in(state), before);
    vvi_sink_abandon(sink);
    assert_int_equal(files_in(state), before);
    size_t n;
    uint8_t *bytes = io_get(path, &n);
    assert_string_equal((char *)bytes, "old");
    free(bytes);
}

static void a_full_disk_is_one_sentence_with_path_and_bytes_and_the_old_file_stays(void **state)
{
    char path[4096];
    snprintf(path, sizeof path, "%s", io_path(state, "full"));
    io_put_text(path, "old");
    const size_t before = files_in(state);
    fflush(stdout);
    const pid_t child = fork(); /* the limit on file sizes cannot be lifted again */
    if (child == 0) {
        const struct rlimit limit = {100000, 100000};
        signal(SIGXFSZ, SIG_IGN);
        setrlimit(RLIMIT_FSIZE, &limit);
        vv_sink *sink;
        static uint8_t data[300000];
        if (vvi_sink_open(&sink, path, NULL) != VV_OK)
            _exit(2);
        vv_status st = vvi_sink_write(sink, data, sizeof data);
        if (st == VV_OK)
            st = vvi_sink_commit(sink);
        else
            vvi_sink_abandon(sink);
        const char *text = vv_error_last()->message;
        _exit(st == VV_E_WRITE && strstr(text, "full") && strstr(text, "100000 bytes") ? 0 : 1);
    }
    int status;
    assert_int_equal(waitpid(child, &status, 0), child);
    assert_int_equal(status, 0);
    assert_int_equal(files_in(state), before);
    size_t n;
    uint8_t *bytes = io_get(path, &n);
    assert_string_equal((char *)bytes, "old");
    free(bytes);
}

static void a_device_that_takes_nothing_is_an_error(void **state)
{
    vv_sink *sink;
    if (access("/dev/full", W_OK) != 0)
        skip();
    io_ok(vvi_sink_open(&sink, "/dev/full", NULL));
    io_ok(vvi_sink_write(sink, "x", 1));
    assert_int_equal(vvi_sink_commit(sink), VV_E_WRITE);
    assert_non_null(strstr(vv_error_last()->message, "/dev/full"));
}

static int owns_numbers(const char *name)
{
    const char *slash = strrchr(name, '/');
    const char *last = slash ? slash + 1 : name;
    return strcmp(last, "mark") == 0 ? 2 : strspn(last, "0123456789") == strlen(last);
}

static void a_name_that_may_not_be_taken_from_others_is_that_of_who_comes_first(void **state)
{
    vv_sink *one, *two, *beside;
    vv_job *job = test_job(1, 0);
    size_t n;
    const size_t before = files_in(state);
    char path[4096], folder[4096];
    snprintf(path, sizeof path, "%s", io_path(state, "first"));
    snprintf(folder, sizeof folder, "%s", io_path(state, "numbers"));
    vvi_job_keep_existing(job);
    io_ok(vvi_sink_open(&one, path, job));
    io_ok(vvi_sink_open(&two, path, job));
    io_ok(vvi_sink_beside(&beside, two, "first.data"));
    io_ok(vvi_sink_write(one, "one", 4));
    io_ok(vvi_sink_write(two, "two", 4));
    io_ok(vvi_sink_commit(one));
    assert_int_equal(vvi_sink_commit(two), VV_E_WRITE);
    assert_non_null(strstr(vv_error_last()->message, "first: already exists"));
    uint8_t *data = io_get(path, &n);
    assert_string_equal((char *)data, "one");
    free(data);
    assert_int_equal(files_in(state), before + 1); /* nor is what belonged to the second left */
    assert_int_equal(vvi_sink_open(&two, path, job), VV_E_WRITE);
    io_ok(vvi_sink_open_folder(&one, folder, owns_numbers, job));
    io_ok(vvi_sink_open_folder(&two, folder, owns_numbers, job));
    io_ok(vvi_sink_put(one, "mark", "one", 3));
    io_ok(vvi_sink_put(two, "mark", "two", 3));
    io_ok(vvi_sink_commit(one));
    assert_int_equal(vvi_sink_commit(two), VV_E_WRITE);
    assert_non_null(strstr(vv_error_last()->message, "numbers: already exists"));
    assert_int_equal(files_in(state), before + 2);
    assert_int_equal(unlink(path), 0);
    vvi_sink_remove_folder(folder);
    vv_job_release(job);
}

static void a_folder_that_is_not_there_and_a_folder_as_target_are_errors(void **state)
{
    vv_sink *sink = NULL;
    assert_int_equal(vvi_sink_open(&sink, io_path(state, "no/such/folder"), NULL), VV_E_WRITE);
    assert_null(sink);
    assert_int_equal(vvi_sink_open(&sink, *state, NULL), VV_E_WRITE);
    assert_non_null(strstr(vv_error_last()->message, "folder"));
}

static void permissions_and_links_stay(void **state)
{
    vv_sink *sink;
    struct stat info;
    const char *path = io_path(state, "mode"), *link = io_path(state, "link");
    io_put_text(path, "old");
    assert_int_equal(chmod(path, 0640), 0);
    assert_int_equal(symlink("mode", link), 0);
    io_ok(vvi_sink_open(&sink, link, NULL));
    io_ok(vvi_sink_write(sink, "new", 3));
    io_ok(vvi_sink_commit(sink));
    assert_int_equal(lstat(link, &info), 0);
    assert_true(S_ISLNK(info.st_mode));
    assert_int_equal(stat(path, &info), 0);
    assert_int_equal(info.st_mode & 07777, 0640);
    assert_int_equal(info.st_size, 3);
}

static void coded_parts_between_plain_ones_are_read_back(void **state)
{
    enum { N = 700000 };
    uint8_t *data = malloc(N), *back = malloc(N);
    for (size_t i = 0; i < N; i++)
        data[i] = (uint8_t)(test_random(1, i / 3) & 15);
    static const vvi_coding codings[] = {VVI_CODING_GZIP, VVI_CODING_BZIP2, VVI_CODING_ZSTD};
    for (size_t c = 0; c < 3; c++)
        for (int level = 0; level <= 9; level += 3) {
            vv_sink *sink;
            vv_source *source, *section;
            const char *path = io_path(state, "coded");
            io_ok(vvi_sink_open(&sink, path, NULL));
            io_ok(vvi_sink_printf(sink, "header %d\n", 7));
            io_ok(vvi_sink_coding(sink, (int)codings[c], level));
            for (size_t at = 0; at < N; at += 33333)
                io_ok(vvi_sink_write(sink, data + at, N - at < 33333 ? N - at : 33333));
            io_ok(vvi_sink_coding(sink, VVI_CODING_NONE, 0));
            io_ok(vvi_sink_commit(sink));
            io_ok(vvi_source_open(&source, path, NULL));
            io_ok(vvi_source_section(&section, source, 9, UINT64_MAX, codings[c], NULL));
            io_ok(vvi_source_read(section, back, N, "data"));
            io_ok(vvi_source_check_end(section));
            assert_memory_equal(data, back, N);
            vvi_source_close(section);
            vvi_source_close(source);
        }
    free(data);
    free(back);
}

static void writing_a_field_asks_for_a_known_suffix_format_and_encoding(void **state)
{
    vv_field_info info = vv_field_info_default();
    const uint8_t one = 1;
    vv_field *field;
    io_ok(vv_field_new(&field, &info, &one, 0, NULL, NULL, NULL));
    const vv_field *frames[] = {field};
    vv_write_options options;
    vv_write_options_init(&options, sizeof options);
    assert_int_equal(vv_field_write(io_path(state, "a.nrd"), frames, 1, NULL, NULL), VV_E_ARGUMENT);
    assert_non_null(strstr(vv_error_last()->message, ".nrrd"));
    assert_int_equal(vv_field_write(io_path(state, "a"), frames, 1, NULL, NULL), VV_E_ARGUMENT);
    options.format = "nrdd";
    assert_int_equal(vv_field_write(io_path(state, "a"), frames, 1, &options, NULL), VV_E_ARGUMENT);
    assert_non_null(strstr(vv_error_last()->message, "'nrrd'"));
    options.format = "nrrd";
    options.encoding = "gzp";
    assert_int_equal(vv_field_write(io_path(state, "a"), frames, 1, &options, NULL), VV_E_ARGUMENT);
    assert_non_null(strstr(vv_error_last()->message, "'gzip'"));
    options.encoding = NULL;
    options.level = 10;
    assert_int_equal(vv_field_write(io_path(state, "a"), frames, 1, &options, NULL), VV_E_ARGUMENT);
    assert_int_equal(vv_field_write(io_path(state, "a.img"), frames, 1, NULL, NULL), VV_E_ARGUMENT);
    assert_int_equal(access(io_path(state, "a"), F_OK), -1);
    assert_int_equal(access(io_path(state, "a.img"), F_OK), -1);
    vv_field_release(field);
}

static void a_folder_appears_whole_and_replaces_only_its_like(void **state)
{
    vv_sink *sink;
    size_t n;
    char path[4096], inside[4200];
    snprintf(path, sizeof path, "%s", io_path(state, "folder"));
    for (int turn = 0; turn < 2; turn++) { /* new, and over the old one */
        io_ok(vvi_sink_open_folder(&sink, path, owns_numbers, NULL));
        io_ok(vvi_sink_put(sink, "mark", "m", 1));
        io_ok(vvi_sink_put(sink, turn ? "1/2/4" : "1/2/3", "data", 4));
        assert_int_equal(access(path, F_OK), turn ? 0 : -1);
        io_ok(vvi_sink_commit(sink));
        assert_int_equal(files_in(state), 1);
    }
    snprintf(inside, sizeof inside, "%s/1/2/4", path);
    uint8_t *data = io_get(inside, &n);
    assert_string_equal((char *)data, "data");
    free(data);
    snprintf(inside, sizeof inside, "%s/1/2/3", path);
    assert_int_equal(access(inside, F_OK), -1);
    snprintf(inside, sizeof inside, "%s/1/letter", path);
    io_put_text(inside, "dear");
    assert_int_equal(vvi_sink_open_folder(&sink, path, owns_numbers, NULL), VV_E_WRITE);
    assert_non_null(strstr(vv_error_last()->message, "1/letter"));
    assert_int_equal(files_in(state), 1);
}

static void an_abandoned_folder_leaves_nothing_and_what_comes_meanwhile_stays(void **state)
{
    vv_sink *sink;
    char path[4096], inside[4200];
    const size_t before = files_in(state);
    snprintf(path, sizeof path, "%s", io_path(state, "abandoned"));
    io_ok(vvi_sink_open_folder(&sink, path, owns_numbers, NULL));
    io_ok(vvi_sink_put(sink, "mark", "m", 1));
    io_ok(vvi_sink_put(sink, "5/6", "data", 4));
    vvi_sink_abandon(sink);
    assert_int_equal(files_in(state), before);
    io_ok(vvi_sink_open_folder(&sink, path, owns_numbers, NULL));
    io_ok(vvi_sink_put(sink, "mark", "m", 1));
    assert_int_equal(mkdir(path, 0755), 0);
    snprintf(inside, sizeof inside, "%s/letter", path);
    io_put_text(inside, "dear");
    assert_int_equal(vvi_sink_commit(sink), VV_E_WRITE);
    assert_int_equal(access(inside, F_OK), 0);
    assert_int_equal(files_in(state), before + 1);
    io_ok(vvi_sink_open_folder(&sink, io_path(state, "third"), owns_numbers, NULL));
    io_ok(vvi_sink_put(sink, "7", "x", 1));
    assert_int_equal(vvi_sink_put(sink, "7/8", "x", 1), VV_E_WRITE);
    assert_int_equal(vvi_sink_commit(sink), VV_E_WRITE);
    assert_int_equal(files_in(state), before + 1);
    assert_int_equal(vvi_sink_open_folder(&sink, "-", owns_numbers, NULL), VV_E_ARGUMENT);
}

static void a_program_that_is_killed_leaves_nothing(void **state)
{
    const char *path = io_path(state, "whole");
    io_put_text(path, "old");
    const size_t before = files_in(state);
    for (int beside = 0; beside < 2; beside++) {
        fflush(stdout);
        const pid_t child = fork();
        if (child == 0) {
            vv_sink *sink, *more;
            if (vvi_sink_open(&sink, path, NULL) != VV_OK || vvi_sink_write(sink, path, 3) != VV_OK ||
                (beside && vvi_sink_beside(&more, sink, "data") != VV_OK))
                _exit(1);
            raise(SIGKILL);
        }
        int status;
        waitpid(child, &status, 0);
        assert_true(WIFSIGNALED(status));
        assert_int_equal(files_in(state), before);
    }
}

static const char *leftover(void **state, const char *before, long process, const char *behind, int hours)
{
    char name[128];
    snprintf(name, sizeof name, "%s.%ld%s", before, process, behind);
    const char *path = io_path(state, name);
    io_put_text(path, "x");
    const struct timespec then = {.tv_sec = time(NULL) - 3600 * hours};
    assert_int_equal(utimensat(AT_FDCWD, path, (struct timespec[]){then, then}, 0), 0);
    return path;
}

/* With a file in it. Yours to free(). */
static char *leftover_folder(void **state, const char *before, long process, int hours)
{
    char name[160];
    snprintf(name, sizeof name, "%s.%ld-0.part", before, process);
    char *path = vvi_strdup(io_path(state, name));
    assert_int_equal(mkdir(path, 0700), 0);
    snprintf(name, sizeof name, "%s.%ld-0.part/zarr.json", before, process);
    io_put_text(io_path(state, name), "{}");
    const struct timespec then = {.tv_sec = time(NULL) - 3600 * hours};
    assert_int_equal(utimensat(AT_FDCWD, path, (struct timespec[]){then, then}, 0), 0);
    return path;
}

static void folders_that_killed_programs_left_are_cleared_by_who_writes_beside_them(void **state)
{
    const pid_t dead = fork();
    if (dead == 0)
        _exit(0);
    waitpid(dead, NULL, 0);
    char *gone[] = {leftover_folder(state, ".a.zarr.volvis", dead, 2), leftover_folder(state, ".young.volvis", dead, 0),
                    leftover_folder(state, "out.zarr", dead, 2)}; /* of this target, as they were named once */
    char *kept[] = {leftover_folder(state, ".lives.volvis", getpid(), 2),
                    leftover_folder(state, ".locked.volvis", dead, 2),
                    leftover_folder(state, ".a.zarr", dead, 2), /* somebody's own, as the next two */
                    leftover_folder(state, "a.zarr", dead, 2), leftover_folder(state, "a.zarr.volvis", dead, 2)};
    const int locked = open(kept[1], O_RDONLY | O_DIRECTORY);
    assert_int_equal(flock(locked, LOCK_EX | LOCK_NB), 0);
    vvi_sink_clear_leftovers(io_path(state, "out.zarr"), NULL);
    for (size_t i = 0; i < sizeof gone / sizeof *gone; i++) {
        assert_int_equal(access(gone[i], F_OK), -1);
        free(gone[i]);
    }
    for (size_t i = 0; i < sizeof kept / sizeof *kept; i++) {
        char file[4200];
        snprintf(file, sizeof file, "%s/zarr.json", kept[i]);
        assert_int_equal(unlink(file), 0);
        assert_int_equal(rmdir(kept[i]), 0);
        free(kept[i]);
    }
    close(locked);
}

static void what_killed_programs_left_is_cleared_by_the_next(void **state)
{
    vv_sink *sink;
    const pid_t dead = fork();
    if (dead == 0)
        _exit(0);
    waitpid(dead, NULL, 0);
    const char *gone[] = {leftover(state, ".a.nrrd", dead, "-0.part", 0), leftover(state, ".b", dead, "-12.part", 30)};
    const char *kept[] = {leftover(state, ".a.nrrd", dead, "-1.part", 2), /* locked: of one on another machine */
                          leftover(state, ".c", getpid(), "-0.part", 2),  /* of one that lives */
                          leftover(state, "d", dead, "-0.part", 2),       /* somebody's own */
                          leftover(state, ".e", dead, "-0.party", 2), leftover(state, ".f", dead, "-.part", 2)};
    const char *path = io_path(state, "out");
    const int locked = open(kept[0], O_RDWR);
    assert_int_equal(flock(locked, LOCK_EX | LOCK_NB), 0);
    io_ok(vvi_sink_open(&sink, path, NULL));
    io_ok(vvi_sink_commit(sink));
    close(locked);
    for (size_t i = 0; i < 2; i++)
        assert_int_equal(access(gone[i], F_OK), -1);
    for (size_t i = 0; i < 5; i++)
        assert_int_equal(unlink(kept[i]), 0);
}

static void where_files_are_written_in_one_place_alone_nothing_leads_out(void **state)
{
    vv_sink *sink;
    vv_job *job = test_job(1, 0);
    char root[4096], moved[4096], link[4096], outside[4096];
    snprintf(outside, sizeof outside, "%s", io_path(state, "outside"));
    snprintf(root, sizeof root, "%s", io_path(state, "root"));
    snprintf(link, sizeof link, "%s", io_path(state, "root/sub"));
    snprintf(moved, sizeof moved, "%s", io_path(state, "root/moved"));
    assert_true(mkdir(outside, 0700) == 0 && mkdir(root, 0700) == 0 && mkdir(link, 0700) == 0);
    char *real = realpath(root, NULL);
    io_ok(vvi_runtime_confine(vv_job_runtime(job), real));
    free(real);
    assert_int_equal(vvi_sink_open(&sink, io_path(state, "outside/x"), job), VV_E_WRITE);
    assert_non_null(strstr(vv_error_last()->message, "outside the folder"));
    io_ok(vvi_sink_open(&sink, io_path(state, "root/sub/x"), job));
    io_ok(vvi_sink_write(sink, "x", 1));
    assert_true(rename(link, moved) == 0 && symlink(outside, link) == 0); /* what took the folder's place leads out */
    io_ok(vvi_sink_commit(sink));
    assert_int_equal(access(io_path(state, "outside/x"), F_OK), -1);
    assert_int_equal(access(io_path(state, "root/moved/x"), F_OK), 0);
    assert_int_equal(vvi_sink_open(&sink, io_path(state, "root/sub/x"), job), VV_E_WRITE);
    assert_int_equal(vvi_sink_open_folder(&sink, io_path(state, "root/sub/y"), owns_numbers, job), VV_E_WRITE);
    /* a folder neither */
    assert_int_equal(unlink(link), 0);
    assert_int_equal(rename(moved, link), 0);
    io_ok(vvi_sink_open_folder(&sink, io_path(state, "root/sub/y"), owns_numbers, job));
    io_ok(vvi_sink_put(sink, "1", "x", 1));
    assert_true(rename(link, moved) == 0 && symlink(outside, link) == 0);
    io_ok(vvi_sink_commit(sink));
    assert_int_equal(access(io_path(state, "outside/y"), F_OK), -1);
    assert_int_equal(access(io_path(state, "root/moved/y/1"), F_OK), 0);
    /* how it is held is nobody's concern */
    vv_sink *beside;
    io_ok(vvi_sink_open(&sink, io_path(state, "root/a"), job));
    assert_int_equal(vvi_sink_beside(&beside, sink, "moved"), VV_E_WRITE);
    assert_non_null(strstr(vv_error_last()->message, "root/moved: is a folder"));
    vvi_sink_abandon(sink);
    vv_job_release(job);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(nothing_is_seen_before_the_commit_and_all_of_it_after),
        cmocka_unit_test(what_stays_in_memory_is_all_that_was_written),
        cmocka_unit_test(an_abandoned_file_leaves_the_old_one_and_no_litter),
        cmocka_unit_test(a_full_disk_is_one_sentence_with_path_and_bytes_and_the_old_file_stays),
        cmocka_unit_test(a_device_that_takes_nothing_is_an_error),
        cmocka_unit_test(a_name_that_may_not_be_taken_from_others_is_that_of_who_comes_first),
        cmocka_unit_test(a_folder_that_is_not_there_and_a_folder_as_target_are_errors),
        cmocka_unit_test(permissions_and_links_stay),
        cmocka_unit_test(coded_parts_between_plain_ones_are_read_back),
        cmocka_unit_test_setup_teardown(a_folder_appears_whole_and_replaces_only_its_like, io_setup, io_teardown),
        cmocka_unit_test_setup_teardown(an_abandoned_folder_leaves_nothing_and_what_comes_meanwhile_stays, io_setup,
                                        io_teardown),
        cmocka_unit_test(writing_a_field_asks_for_a_known_suffix_format_and_encoding),
        cmocka_unit_test(a_program_that_is_killed_leaves_nothing),
        cmocka_unit_test(folders_that_killed_programs_left_are_cleared_by_who_writes_beside_them),
        cmocka_unit_test(what_killed_programs_left_is_cleared_by_the_next),
        cmocka_unit_test(where_files_are_written_in_one_place_alone_nothing_leads_out),
    };
    return cmocka_run_group_tests(tests, io_setup, io_teardown);
}
