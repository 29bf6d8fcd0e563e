/* Files read by the import program (--safe): the same as without, and whatever it does stays in it. */
#include "config.h"
#include "core/limits.h"
#include "fields.h"
#include "io_test.h"
#include "jobs.h"
#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <time.h>
#include <volvis/sys/registry.h>

static double now_s(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

/* A job that reads safely. program NULL: the real one. */
static vv_job *safe_job(const char *program, uint64_t import_seconds, vv_progress_fn *progress)
{
    vv_runtime_options options;
    vv_limits limits;
    vv_runtime *runtime;
    vv_job *job;
    vv_limits_init(&limits, sizeof limits);
    limits.import_bytes = (uint64_t)640 << 20;
    limits.metadata_keys = 1000;
    limits.import_spool = (uint64_t)8 << 20;
    if (import_seconds)
        limits.import_seconds = import_seconds;
    vv_runtime_options_init(&options, sizeof options);
    options.threads = 2;
    options.memory_bytes = (uint64_t)256 << 20;
    options.safe = true;
    options.limits = &limits;
    options.import_program = program ? program : VOLVIS_IMPORT;
    io_ok(vv_runtime_new(&runtime, &options));
    io_ok(vv_job_new(&job, runtime, progress, NULL));
    vv_runtime_release(runtime);
    return job;
}

static size_t count_descriptors(void)
{
    size_t n = 0;
    DIR *folder = opendir("/proc/self/fd");
    assert_non_null(folder);
    while (readdir(folder))
        n++;
    closedir(folder);
    return n;
}

/* Whatever happened: no process and no descriptor is left. */
static void nothing_is_left(size_t descriptors)
{
    int how;
    assert_int_equal(waitpid(-1, &how, WNOHANG), -1);
    assert_int_equal(errno, ECHILD);
    assert_int_equal(count_descriptors(), descriptors);
}

/* The same file both ways --------------------------------------------------------------------------------------------
 */

static void same_notes(const vv_file *a, const vv_file *b)
{
    const char *key[2], *value[2];
    vv_part part[2];
    size_t n[2], i = 0;
    assert_string_equal(vv_file_format(a), vv_file_format(b));
    for (; vv_file_metadata(a, i, &key[0], &value[0]); i++) {
        assert_true(vv_file_metadata(b, i, &key[1], &value[1]));
        assert_string_equal(key[0], key[1]);
        assert_string_equal(value[0], value[1]);
    }
    assert_false(vv_file_metadata(b, i, &key[1], &value[1]));
    for (i = 0; vv_file_warning(a, i); i++)
        assert_string_equal(vv_file_warning(a, i), vv_file_warning(b, i));
    assert_null(vv_file_warning(b, i));
    for (i = 0; vv_file_part(a, i, &part[0]); i++) {
        assert_true(vv_file_part(b, i, &part[1]));
        assert_string_equal(part[0].name, part[1].name);
        assert_string_equal(part[0].about, part[1].about);
        assert_int_equal(part[0].chosen, part[1].chosen);
    }
    const vv_channel *c = vv_file_channels(a, &n[0]), *d = vv_file_channels(b, &n[1]);
    assert_int_equal(n[0], n[1]);
    for (i = 0; i < n[0]; i++) {
        assert_string_equal(c[i].name, d[i].name);
        assert_int_equal(c[i].has_color, d[i].has_color);
        assert_true(c[i].color.r == d[i].color.r && c[i].color.b == d[i].color.b && c[i].lo == d[i].lo);
    }
    const vv_label *l = vv_file_labels(a, &n[0]), *m = vv_file_labels(b, &n[1]);
    assert_int_equal(n[0], n[1]);
    for (i = 0; i < n[0]; i++) {
        assert_int_equal(l[i].value, m[i].value);
        assert_string_equal(l[i].name, m[i].name);
        assert_int_equal(l[i].layer, m[i].layer);
        assert_int_equal(l[i].codes != NULL, m[i].codes != NULL);
        if (l[i].codes)
            assert_memory_equal(l[i].codes, m[i].codes, VV_LABEL_CODES * sizeof *l[i].codes);
    }
}

static void same_frame(vv_file *a, vv_file *b, int64_t frame, const vv_box *box, vv_job *plain, vv_job *safe,
                       const char *path)
{
    vv_field *x = NULL, *y = NULL;
    char said[4096] = "";
    const vv_status first = vv_file_read(&x, a, frame, box, plain);
    if (first != VV_OK)
        snprintf(said, sizeof said, "%s", vv_error_last()->message);
    const vv_status second = vv_file_read(&y, b, frame, box, safe);
    if (first != second || (second != VV_OK && strcmp(said, vv_error_last()->message) != 0))
        fail_msg("%s: %s '%s', but safely %s '%s'", path, vv_status_name(first), said, vv_status_name(second),
                 second == VV_OK ? "" : vv_error_last()->message);
    if (first == VV_OK) {
        uint32_t p, q;
        io_same_info(vv_field_get_info(x), vv_field_get_info(y));
        assert_memory_equal(&vv_field_get_info(x)->grid.index_to_world, &vv_field_get_info(y)->grid.index_to_world,
                            sizeof(vv_affine));
        io_ok(vv_field_checksum(&p, x, NULL));
        io_ok(vv_field_checksum(&q, y, NULL));
        assert_int_equal(p, q);
    }
    vv_field_release(x);
    vv_field_release(y);
}

/* Whether it could be read at all. */
static bool same_both_ways(const char *path, vv_job *safe, uint64_t memory)
{
    vv_job *plain = test_job(2, memory);
    vv_file *a = NULL, *b = NULL;
    char said[4096] = "";
    const vv_status first = vv_file_open(&a, path, NULL, plain);
    if (first != VV_OK)
        snprintf(said, sizeof said, "%s", vv_error_last()->message);
    const vv_status second = vv_file_open(&b, path, NULL, safe);
    if (first != second || (second != VV_OK && strcmp(said, vv_error_last()->message) != 0))
        fail_msg("%s: %s '%s', but safely %s '%s'", path, vv_status_name(first), said, vv_status_name(second),
                 second == VV_OK ? "" : vv_error_last()->message);
    if (first == VV_OK) {
        const vv_field_info *info = vv_file_info(a);
        same_notes(a, b);
        io_same_info(info, vv_file_info(b));
        same_frame(a, b, info->n_frames - 1, NULL, plain, safe, path);
        const vv_box corner = {{info->grid.dims[0] / 2, 0, info->grid.dims[2] / 2},
                               {(info->grid.dims[0] + 1) / 2, 1, (info->grid.dims[2] + 1) / 2}};
        same_frame(a, b, 0, &corner, plain, safe, path);
        assert_false(vv_file_mappable(b));
    }
    assert_int_equal(vv_job_damaged(plain), vv_job_damaged(safe));
    vv_file_close(a);
    vv_file_close(b);
    vv_job_release(plain);
    return first == VV_OK;
}

static void every_format_that_is_written_reads_the_same(void **state)
{
    static const vv_type types[] = {VV_TYPE_U8, VV_TYPE_I16, VV_TYPE_F32};
    const vv_registry *registry = vv_registry_builtin();
    const size_t descriptors = count_descriptors();
    size_t n = 0;
    for (size_t f = 0; registry->formats[f]; f++) {
        const vv_format *format = registry->formats[f];
        for (size_t t = 0; format->write && format->suffixes && t < 3; t++) {
            vv_field_info info = vv_field_info_default();
            info.type = types[t];
            info.grid.dims[0] = 7;
            info.grid.dims[1] = 5;
            info.grid.dims[2] = 3;
            char name[64];
            vv_write_options options;
            vv_write_options_init(&options, sizeof options);
            options.format = format->name;
            for (size_t e = 0; format->encodings && format->encodings[e] && e <= t; e++)
                options.encoding = format->encodings[e];
            snprintf(name, sizeof name, "a_7x5x3_%s%s", vv_type_name(info.type), format->suffixes[0]);
            vv_field *field = test_field_random(&info, 3 + t, NULL);
            const char *path = io_path(state, name);
            if (vv_field_write(path, (const vv_field *const *)&field, 1, &options, NULL) == VV_OK) {
                vv_job *safe = safe_job(NULL, 0, NULL);
                n += same_both_ways(path, safe, 0);
                vv_job_release(safe);
            }
            vv_field_release(field);
        }
    }
    print_message("%zu files\n", n);
    assert_true(n >= 9);
    nothing_is_left(descriptors);
}

static void time_steps_coded_files_and_what_is_damaged(void **state)
{
    const size_t descriptors = count_descriptors();
    vv_field_info info = vv_field_info_default();
    info.grid.dims[0] = info.grid.dims[1] = info.grid.dims[2] = 9;
    vv_field *field[3];
    for (int i = 0; i < 3; i++)
        field[i] = test_field_random(&info, (uint64_t)i, NULL);
    static const char *const names[] = {"t.nii", "t.nii.gz", "t.nrrd", "t.npy.zst", "t.nrrd.bz2"};
    for (size_t i = 0; i < sizeof names / sizeof names[0]; i++) {
        const char *path = io_path(state, names[i]);
        if (vv_field_write(path, (const vv_field *const *)field, 3, NULL, NULL) != VV_OK)
            continue;
        vv_job *safe = safe_job(NULL, 0, NULL);
        assert_true(same_both_ways(path, safe, 0));
        vv_job_release(safe);
    }
    size_t n;
    uint8_t *bytes = io_get(io_path(state, "t.nii"), &n);
    io_put(io_path(state, "cut.nii"), bytes, n - 300); /* the last of three frames lacks some of its samples */
    io_put(io_path(state, "stump.nii"), bytes, 300);
    io_put_text(io_path(state, "none.nrrd"), "NRRD0004\n");
    free(bytes);
    static const char *const broken[] = {"cut.nii", "stump.nii", "none.nrrd", "absent.nii", "."};
    for (size_t i = 0; i < sizeof broken / sizeof broken[0]; i++) {
        vv_job *safe = safe_job(NULL, 0, NULL);
        same_both_ways(io_path(state, broken[i]), safe, 0);
        assert_true(i > 0 || vv_job_damaged(safe));
        vv_job_release(safe);
    }
    for (int i = 0; i < 3; i++)
        vv_field_release(field[i]);
    nothing_is_left(descriptors);
}

/* What it does ---------------------------------------------------------------------------------------------------- */

typedef struct deed {
    const char *what, *words;
    vv_status status;
    uint64_t seconds;
} deed;

static void tried(void **state, const char *program, const char *name, const char *text, const deed *d, vv_job *job)
{
    vv_file *file = NULL;
    vv_field *field = NULL;
    const double begin = now_s();
    const char *path = io_path(state, name);
    io_put_text(path, text);
    vv_status st = vv_file_open(&file, path, NULL, job);
    if (st == VV_OK)
        st = vv_file_read(&field, file, 0, NULL, job);
    if (st != d->status || (st != VV_OK && !strstr(vv_error_last()->message, d->words)))
        fail_msg("%s %s: %s, '%s'; expected %s, '%s'", program, d->what, vv_status_name(st),
                 st == VV_OK ? "" : vv_error_last()->message, vv_status_name(d->status), d->words);
    if (st != VV_OK) {
        assert_null(field);
        assert_null(strpbrk(vv_error_last()->message, "\n\033"));
    }
    if (now_s() - begin > (double)d->seconds + 60) /* the machine may be busy */
        fail_msg("%s %s took %.1f s", program, d->what, now_s() - begin);
    vv_field_release(field);
    vv_file_close(file);
}

#ifndef __has_feature
#define __has_feature(x) 0
#endif
#if VV_HAVE_SECCOMP && !defined(__SANITIZE_ADDRESS__) && !__has_feature(address_sanitizer) &&                          \
    !__has_feature(thread_sanitizer)
#define HOSTILE(what)                                                                                                  \
    {                                                                                                                  \
        what, "tried what no reader does", VV_E_READ, 0                                                                \
    }
#endif

static bool has_landlock(void)
{
    return syscall(444 /* landlock_create_ruleset: its version */, NULL, 0, 1) > 0;
}

static void what_a_hostile_file_does_stays_in_its_process(void **state)
{
    static const deed deeds[] = {
        {"crash", "crashed (signal 11", VV_E_READ, 0},
        {"abort", "crashed (signal 6", VV_E_READ, 0},
        {"recurse", "crashed (signal 11", VV_E_READ, 0},
        {"exit", "ended too early (exit 3)", VV_E_READ, 0},
        {"loop", "1 seconds and was stopped", VV_E_READ, 1},
        {"sleep", "for 1 seconds", VV_E_READ, 1},
        {"nothing", "", VV_OK, 0},
        {"thread", "", VV_OK, 0},
        {"progress", "", VV_OK, 1},
#ifdef HOSTILE
        {"allocate", "times 16 MiB", VV_E_MEMORY, 2},
        {"fill", "full after 8 MiB", VV_E_FORMAT, 0},
        {"code", "no code", VV_E_FORMAT, 0},
        {"look", "", VV_OK, 0},
        HOSTILE("exec"),
        HOSTILE("fork"),
        HOSTILE("socket"),
        HOSTILE("kill"),
        HOSTILE("create"),
        HOSTILE("write"),
        HOSTILE("truncate"),
        HOSTILE("unlink"),
        HOSTILE("link"),
#endif
    };
    static const char *const when[] = {"open", "read"};
    const size_t descriptors = count_descriptors();
    for (size_t i = 0; i < sizeof deeds / sizeof deeds[0]; i++) {
        for (int w = 0; w < 2; w++) {
            char text[64];
            const bool allocates = strcmp(deeds[i].what, "allocate") == 0;
            if (strcmp(deeds[i].what, "look") == 0 && !has_landlock())
                continue;
            vv_job *job = safe_job(IMPORT_HOSTILE, allocates ? 20 : 1, NULL);
            snprintf(text, sizeof text, "HOSTILE %s %s", when[w], deeds[i].what);
            tried(state, "hostile", "h.bin", text, &deeds[i], job);
            vv_job_release(job);
        }
    }
    nothing_is_left(descriptors);
}

/* With the header of a format that may name files beside its own. */
static void a_header_that_names_no_file_gets_none(void **state)
{
    static const struct {
        const char *head, *what;
    } cases[] = {
        {"encoding: raw\n# HOSTILE open alone\n\n", "alone"},
        {"encoding: raw\n# HOSTILE open alone\n\ndata file: plain.txt\n", "alone"}, /* of the samples */
        {"data file: plain.txt\n# HOSTILE open beside\n\n", "beside"},
        {"DataFile: plain.txt\n# HOSTILE open beside\n\n", "beside"},
        {"# HOSTILE open beside\n", "beside"}, /* it goes on */
    };
#ifndef HOSTILE
    skip(); /* sanitizers lock nothing */
#endif
    if (!has_landlock())
        skip();
    io_put_text(io_path(state, "plain.txt"), "x");
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        char text[128];
        const deed fine = {cases[i].what, "", VV_OK, 0};
        vv_job *job = safe_job(IMPORT_HOSTILE, 1, NULL);
        snprintf(text, sizeof text, "NRRD0004\n%s", cases[i].head);
        tried(state, "hostile", "h.nrrd", text, &fine, job);
        vv_job_release(job);
    }
}

static void what_an_import_program_says_is_checked(void **state)
{
    static const char *const lies[] = {
        "magic",      "kind",      "length",    "empty",  "format", "done",     "dims",    "huge",   "type",  "nan",
        "components", "unit",      "name",      "status", "text",   "longtext", "rest",    "bool",   "label", "endless",
        "held",       "otherdims", "othertype", "scale",  "notes",  "again",    "damaged", "beyond", "before"};
    static const deed others[] = {
        {"cut", "ended too early (exit 0)", VV_E_READ, 0},
        {"half", "for 1 seconds", VV_E_READ, 1},
        {"silent", "for 1 seconds", VV_E_READ, 1},
        {"many", "samples along x", VV_E_FORMAT, 0},
        {"control", "a?[2Jb?c", VV_E_FORMAT, 0},
        {"shrink", "", VV_OK, 0},
        {"grow", "", VV_OK, 0},
        {"after", "", VV_OK, 0},
        {"truth", "", VV_OK, 0},
    };
    const size_t descriptors = count_descriptors();
    vv_job *job = safe_job(IMPORT_LIAR, 1, NULL);
    for (size_t i = 0; i < sizeof lies / sizeof lies[0]; i++) {
        const deed d = {lies[i], "an invalid answer", VV_E_READ, 0};
        tried(state, "liar", lies[i], "", &d, job);
    }
    for (size_t i = 0; i < sizeof others / sizeof others[0]; i++)
        tried(state, "liar", others[i].what, "", &others[i], job);
    vv_job_release(job);
    nothing_is_left(descriptors);
}

static void samples_do_not_change_after_they_were_handed_over(void **state)
{
    vv_job *job = safe_job(IMPORT_LIAR, 5, NULL);
    vv_file *file;
    vv_field *field;
    io_put_text(io_path(state, "after"), "");
    io_ok(vv_file_open(&file, io_path(state, "after"), NULL, job));
    io_ok(vv_file_read(&field, file, 0, NULL, job));
    double first[24]; /* it writes all the time: up to now, but not from now on */
    for (int i = 0; i < 24; i++)
        first[i] = vv_field_value(field, i % 4, i / 4 % 3, i / 12, 0);
    for (int t = 0; t < 20; t++) {
        for (int i = 0; i < 24; i++)
            assert_true(vv_field_value(field, i % 4, i / 4 % 3, i / 12, 0) == first[i]);
        usleep(2000);
    }
    assert_true(vv_runtime_memory_used(vv_job_runtime(job)) >= 24);
    vv_file_close(file);
    vv_field_release(field);
    vv_job_release(job);
}

/* Cancel, progress, the end of who asked -----------------------------------------------------------------------------
 */

static int reports;
static int reports_most;

static bool count_reports(void *user, const vv_progress *progress)
{
    (void)user;
    assert_true(progress->done <= progress->total);
    return ++reports <= reports_most;
}

static void progress_comes_through_and_cancel_goes_through(void **state)
{
    const size_t descriptors = count_descriptors();
    vv_file *file;
    vv_field *field;
    io_put_text(io_path(state, "p"), "HOSTILE read progress");
    reports = 0;
    reports_most = 1000;
    vv_job *job = safe_job(IMPORT_HOSTILE, 0, count_reports);
    io_ok(vv_file_open(&file, io_path(state, "p"), NULL, job));
    io_ok(vv_file_read(&field, file, 0, NULL, job));
    assert_true(reports >= 3);
    vv_field_release(field);
    /* refused at the second report; the next read of the same file begins again */
    vv_runtime *runtime = vv_runtime_retain(vv_job_runtime(job));
    vv_job_release(job);
    reports = 0;
    reports_most = 1;
    io_ok(vv_job_new(&job, runtime, count_reports, NULL));
    assert_int_equal(vv_file_read(&field, file, 0, NULL, job), VV_E_CANCELLED);
    assert_int_equal(reports, 2); /* and no more of those that would come */
    assert_null(field);
    vv_job_release(job);
    io_ok(vv_job_new(&job, runtime, NULL, NULL));
    io_ok(vv_file_read(&field, file, 0, NULL, job));
    assert_true(vv_field_value(field, 1, 1, 1, 0) == 8);
    vv_field_release(field);
    vv_file_close(file);
    vv_job_release(job);
    vv_runtime_release(runtime);
    nothing_is_left(descriptors);
}

static bool is_alive(pid_t pid)
{
    char path[64], state = 0;
    snprintf(path, sizeof path, "/proc/%d/stat", (int)pid);
    FILE *f = fopen(path, "r");
    if (!f)
        return false;
    const int n = fscanf(f, "%*d %*s %c", &state);
    fclose(f);
    return n == 1 && state != 'Z' && state != 'X';
}

enum { PATIENCE_S = 60 }; /* the machine may be busy */

/* Reading has begun: since the header it has taken 0.05 s more of a processor. */
static void wait_until_it_works(pid_t pid)
{
    clockid_t clock;
    struct timespec first, now;
    const double begin = now_s();
    assert_int_equal(clock_getcpuclockid(pid, &clock), 0);
    assert_int_equal(clock_gettime(clock, &first), 0);
    do {
        usleep(1000);
        assert_true(is_alive(pid));
        assert_int_equal(clock_gettime(clock, &now), 0);
        if (now_s() - begin > PATIENCE_S)
            fail_msg("waited %d s for the import program to read", PATIENCE_S);
    } while ((double)(now.tv_sec - first.tv_sec) + 1e-9 * (double)(now.tv_nsec - first.tv_nsec) < 0.05);
}

static void wait_until_it_is_gone(pid_t pid)
{
    for (const double begin = now_s(); is_alive(pid); usleep(1000))
        if (now_s() - begin > PATIENCE_S)
            fail_msg("waited %d s for the import program to end", PATIENCE_S);
}

static void it_ends_with_who_asked(void **state)
{
    int ends[2];
    pid_t import = 0;
    io_put_text(io_path(state, "s"), "HOSTILE read loop");
    assert_int_equal(pipe(ends), 0);
    const pid_t child = fork();
    if (child == 0) {
        vv_file *file;
        vv_field *field;
        const char *key, *value;
        vv_job *job = safe_job(IMPORT_HOSTILE, 60, NULL);
        if (vv_file_open(&file, io_path(state, "s"), NULL, job) == VV_OK && vv_file_metadata(file, 0, &key, &value)) {
            const pid_t pid = (pid_t)atoi(value);
            if (write(ends[1], &pid, sizeof pid) == sizeof pid)
                vv_file_read(&field, file, 0, NULL, job);
        }
        _exit(0);
    }
    assert_int_equal(read(ends[0], &import, sizeof import), sizeof import);
    wait_until_it_works(import);
    kill(child, SIGKILL);
    waitpid(child, NULL, 0);
    wait_until_it_is_gone(import);
    close(ends[0]);
    close(ends[1]);
}

static void without_the_program_it_says_so(void **state)
{
    static const vv_registry mine = {0};
    vv_job *job = safe_job("/nonexistent/volvis-import", 0, NULL);
    vv_file *file;
    io_put_text(io_path(state, "x.nrrd"), "NRRD0004\n");
    assert_int_equal(vv_file_open(&file, io_path(state, "x.nrrd"), NULL, job), VV_E_READ);
    assert_non_null(strstr(vv_error_last()->message, "cannot be started"));
    vv_job_release(job);
    job = safe_job("/bin/true", 0, NULL);
    assert_int_equal(vv_file_open(&file, io_path(state, "x.nrrd"), NULL, job), VV_E_READ);
    assert_non_null(strstr(vv_error_last()->message, "ended too early"));
    vv_job_release(job);
    vv_runtime_options options;
    vv_runtime *runtime;
    vv_runtime_options_init(&options, sizeof options);
    options.safe = true;
    options.registry = &mine;
    io_ok(vv_runtime_new(&runtime, &options));
    io_ok(vv_job_new(&job, runtime, NULL, NULL));
    assert_int_equal(vv_file_open(&file, io_path(state, "x.nrrd"), NULL, job), VV_E_UNSUPPORTED);
    vv_job_release(job);
    vv_runtime_release(runtime);
}

/* Real files, where there are some beside the checkout. */
static size_t n_real;
static size_t n_read;

static int read_real(const char *path, const struct stat *info, int type, struct FTW *where)
{
    (void)where;
    if (type != FTW_F || info->st_size > 8 << 20)
        return 0;
    vv_job *safe = safe_job(NULL, 0, NULL);
    n_real++;
    n_read += same_both_ways(path, safe, (uint64_t)256 << 20);
    vv_job_release(safe);
    return 0;
}

static void real_files_read_the_same(void **state)
{
    (void)state;
    const size_t descriptors = count_descriptors();
    const char *shared = getenv("VOLVIS_SHARED");
    if (nftw(shared ? shared : VOLVIS_SHARED_DIR "/data", read_real, 16, FTW_PHYS) != 0 || n_real == 0) {
        print_message("no real data beside the checkout\n");
        skip();
    }
    print_message("%zu files, %zu of them are read\n", n_real, n_read);
    nothing_is_left(descriptors);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(every_format_that_is_written_reads_the_same, io_setup, io_teardown),
        cmocka_unit_test_setup_teardown(time_steps_coded_files_and_what_is_damaged, io_setup, io_teardown),
        cmocka_unit_test_setup_teardown(what_a_hostile_file_does_stays_in_its_process, io_setup, io_teardown),
        cmocka_unit_test_setup_teardown(a_header_that_names_no_file_gets_none, io_setup, io_teardown),
        cmocka_unit_test_setup_teardown(what_an_import_program_says_is_checked, io_setup, io_teardown),
        cmocka_unit_test_setup_teardown(samples_do_not_change_after_they_were_handed_over, io_setup, io_teardown),
        cmocka_unit_test_setup_teardown(progress_comes_through_and_cancel_goes_through, io_setup, io_teardown),
        cmocka_unit_test_setup_teardown(it_ends_with_who_asked, io_setup, io_teardown),
        cmocka_unit_test_setup_teardown(without_the_program_it_says_so, io_setup, io_teardown),
        cmocka_unit_test(real_files_read_the_same),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
