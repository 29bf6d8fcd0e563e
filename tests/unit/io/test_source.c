/* Bounded input: codings, positions, sections, limits, names inside files, and mapped files that shrink. */
#include "core/job.h"
#include "fields.h"
#include "io/sink.h"
#include "io/source.h"
#include "io_test.h"
#include "jobs.h"
#include <fcntl.h>
#include <pthread.h>
#include <signal.h>
#include <stdatomic.h>
#include <sys/wait.h>

enum { N = 300000 };

static uint8_t pattern(uint64_t i)
{
    return (uint8_t)(test_random(7, i / 5) + i);
}

static void write_coded_at(const char *path, vvi_coding coding, size_t n, int level)
{
    vv_sink *sink;
    uint8_t *data = malloc(n);
    for (size_t i = 0; i < n; i++)
        data[i] = pattern(i);
    io_ok(vvi_sink_open(&sink, path, NULL));
    io_ok(vvi_sink_coding(sink, (int)coding, level));
    io_ok(vvi_sink_write(sink, data, n));
    io_ok(vvi_sink_commit(sink));
    free(data);
}

static void write_coded(const char *path, vvi_coding coding, size_t n)
{
    write_coded_at(path, coding, n, 0);
}

static void check_at(vv_source *source, uint64_t at, size_t n)
{
    uint8_t *got = malloc(n);
    io_ok(vvi_source_seek(source, at));
    io_ok(vvi_source_read(source, got, n, "pattern"));
    for (size_t i = 0; i < n; i++)
        assert_int_equal(got[i], pattern(at + i));
    assert_true(vvi_source_tell(source) == at + n);
    free(got);
}

static void every_coding_reads_at_any_place_forwards_and_backwards(void **state)
{
    for (int c = VVI_CODING_NONE; c <= VVI_CODING_ZSTD; c++) {
        vv_source *source;
        const char *path = io_path(state, "coded");
        write_coded(path, (vvi_coding)c, N);
        io_ok(vvi_source_open(&source, path, NULL));
        check_at(source, 0, N);
        check_at(source, 10, 3);
        check_at(source, 12, 200000);
        check_at(source, 290000, 10000);
        check_at(source, 5000, 1);
        check_at(source, 0, 150000); /* a large read leaves nothing behind to go back to */
        check_at(source, 149990, 10);
        check_at(source, 10, 10);
        io_ok(vvi_source_seek(source, 200000));
        check_at(source, 199995, 10);
        size_t there;
        io_ok(vvi_source_seek(source, 77));
        const uint8_t *peek = vvi_source_peek(source, 4096, &there);
        assert_int_equal(there, 4096);
        for (size_t i = 0; i < 4096; i++)
            assert_int_equal(peek[i], pattern(77 + i));
        assert_true(vvi_source_tell(source) == 77);
        uint8_t byte;
        io_ok(vvi_source_seek(source, N));
        assert_int_equal(vvi_source_read(source, &byte, 1, "more"), VV_E_FORMAT);
        assert_non_null(strstr(vv_error_last()->message, "300000"));
        vvi_source_close(source);
    }
}

/* From the third time on they come from a temporary file: the same bytes, the source then has a path. */
static void coded_data_that_are_asked_for_again_and_again_are_kept(void **state)
{
    enum { MANY = 40 << 20 };
    static const vvi_coding codings[] = {VVI_CODING_GZIP, VVI_CODING_ZSTD};
    for (size_t c = 0; c < 2; c++) {
        vv_source *source;
        const char *path = io_path(state, "coded");
        write_coded_at(path, codings[c], MANY, 1); /* quick: how well they are packed is nothing here */
        io_ok(vvi_source_open(&source, path, NULL));
        for (int times = 0; times < 5; times++) {
            check_at(source, MANY - 5, 5);
            check_at(source, (uint64_t)times * 1000, 100);
            assert_int_equal(vvi_source_path(source) != NULL, times >= 2);
        }
        vvi_source_close(source);
    }
}

static void members_one_after_another_are_one_stream(void **state)
{
    for (int c = VVI_CODING_GZIP; c <= VVI_CODING_ZSTD; c++) {
        size_t n;
        vv_source *source;
        const char *path = io_path(state, "members");
        write_coded(path, (vvi_coding)c, 1000);
        uint8_t *one = io_get(path, &n), *both = malloc(2 * n + 5);
        memcpy(both, one, n);
        memcpy(both + n, one, n);
        memset(both + 2 * n, 0, 5); /* padding, as tapes had it */
        io_put(path, both, 2 * n + 5);
        io_ok(vvi_source_open(&source, path, NULL));
        uint8_t got[2001];
        size_t n_got;
        io_ok(vvi_source_read_some(source, got, sizeof got, &n_got));
        assert_int_equal(n_got, 2000);
        assert_memory_equal(got, got + 1000, 1000);
        io_ok(vvi_source_check_end(source));
        vvi_source_close(source);
        free(one);
        free(both);
    }
}

static void cut_coded_files_say_that_they_are_cut(void **state)
{
    for (int c = VVI_CODING_GZIP; c <= VVI_CODING_ZSTD; c++) {
        size_t n;
        const char *path = io_path(state, "cut");
        write_coded(path, (vvi_coding)c, 20000);
        uint8_t *bytes = io_get(path, &n);
        for (size_t keep = 12; keep < n; keep += n / 13) {
            vv_source *source;
            uint8_t got[20000];
            io_put(path, bytes, keep);
            io_ok(vvi_source_open(&source, path, NULL));
            vv_status st = vvi_source_read(source, got, sizeof got, "pattern");
            if (st == VV_OK)
                st = vvi_source_check_end(source);
            assert_int_equal(st, VV_E_FORMAT);
            assert_non_null(strstr(vv_error_last()->message, "cut short"));
            vvi_source_close(source);
        }
        free(bytes);
    }
}

/* The first byte of the last `back` is another. */
static void damage(const char *path, size_t back)
{
    size_t n;
    uint8_t *bytes = io_get(path, &n);
    bytes[n - back] ^= 0xff;
    io_put(path, bytes, n);
    free(bytes);
}

static void coded_data_are_proven_from_where_they_are_read_and_read_on_there(void **state)
{
    enum { MANY = 5 * N, AT = 2 * N + 77 };
    const uint64_t much = (uint64_t)1 << 30; /* more than may be held unproven of so small a file */
    for (int c = VVI_CODING_GZIP; c <= VVI_CODING_ZSTD; c++)
        for (int spoilt = 0; spoilt <= (c != VVI_CODING_ZSTD); spoilt++) { /* which is written without a sum */
            bool seen;
            vv_source *source, *twice;
            const char *path = io_path(state, "proven");
            write_coded_at(path, (vvi_coding)c, MANY, 1);
            if (spoilt)
                damage(path, c == VVI_CODING_GZIP ? 8 : 4);
            io_ok(vvi_source_open(&source, path, NULL));
            check_at(source, 0, AT);
            io_ok(vvi_source_hold(source, MANY, &seen));
            assert_int_equal(vvi_source_hold(source, much, &seen), spoilt ? VV_E_FORMAT : VV_OK);
            assert_true(seen == !spoilt && (spoilt || vvi_source_end(source) == MANY));
            assert_true(spoilt || (vvi_source_left(source, &seen) == MANY - AT && seen));
            assert_true(vvi_source_tell(source) == AT);
            check_at(source, AT, MANY - AT - 9);
            vvi_source_close(source);
            /* a stream in a stream: what both have taken is left where it was */
            vv_sink *sink;
            size_t n;
            uint8_t *bytes = io_get(path, &n);
            io_ok(vvi_sink_open(&sink, path, NULL));
            io_ok(vvi_sink_coding(sink, VVI_CODING_GZIP, 1));
            io_ok(vvi_sink_write(sink, bytes, n));
            io_ok(vvi_sink_commit(sink));
            free(bytes);
            io_ok(vvi_source_open(&source, path, NULL));
            io_ok(vvi_source_section(&twice, source, 0, UINT64_MAX, (vvi_coding)c, NULL));
            check_at(twice, 0, AT);
            assert_int_equal(vvi_source_hold(twice, much, &seen), spoilt ? VV_E_FORMAT : VV_OK);
            check_at(twice, AT, MANY - AT - 9);
            vvi_source_close(twice);
            vvi_source_close(source);
        }
}

static void coded_data_that_are_cut_are_known_to_be_before_they_are_read_to_there(void **state)
{
    bool seen;
    size_t n;
    uint8_t *some = malloc(N);
    vv_source *source;
    const char *path = io_path(state, "proven");
    write_coded_at(path, VVI_CODING_GZIP, 3 * N, 1);
    uint8_t *bytes = io_get(path, &n);
    io_put(path, bytes, n / 2);
    free(bytes);
    io_ok(vvi_source_open(&source, path, NULL));
    check_at(source, 0, N);
    io_ok(vvi_source_hold(source, (uint64_t)1 << 30, &seen));
    assert_true(seen);
    const uint64_t end = vvi_source_end(source);
    assert_true(end > N && end < 2 * N);
    io_ok(vvi_source_read_whole(source, some, N, &n));
    assert_true(N + n == end);
    free(some);
    vvi_source_close(source);
}

/* Who reads and says nothing of what he holds. */
static void what_is_handed_out_of_coded_data_is_counted_until_they_must_be_proven(void **state)
{
    enum { MANY = 80 << 20 };
    vv_source *source;
    const char *path = io_path(state, "zeros.gz");
    uint8_t *zeros = calloc(1, MANY);
    vv_sink *sink;
    io_ok(vvi_sink_open(&sink, path, NULL));
    io_ok(vvi_sink_coding(sink, VVI_CODING_GZIP, 1));
    io_ok(vvi_sink_write(sink, zeros, MANY));
    io_ok(vvi_sink_commit(sink));
    damage(path, 8);
    io_ok(vvi_source_open(&source, path, NULL));
    size_t n, all = 0;
    vv_status st = VV_OK;
    while (st == VV_OK && all < MANY) {
        st = vvi_source_read_some(source, zeros, 1 << 20, &n);
        all += n;
    }
    assert_int_equal(st, VV_E_FORMAT);
    assert_true(all > (size_t)50 << 20 && all < (size_t)64 << 20);
    vvi_source_close(source);
    free(zeros);
}

static void a_flipped_bit_in_a_gzip_file_is_found_by_its_checksum(void **state)
{
    size_t n;
    const char *path = io_path(state, "flip");
    write_coded(path, VVI_CODING_GZIP, 5000);
    uint8_t *bytes = io_get(path, &n);
    for (size_t bit = 10 * 8; bit < n * 8; bit += 37) {
        vv_source *source;
        uint8_t got[5000];
        bytes[bit / 8] ^= (uint8_t)(1 << bit % 8);
        io_put(path, bytes, n);
        bytes[bit / 8] ^= (uint8_t)(1 << bit % 8);
        io_ok(vvi_source_open(&source, path, NULL));
        vv_status st = vvi_source_read(source, got, sizeof got, "pattern");
        if (st == VV_OK)
            st = vvi_source_check_end(source);
        assert_int_equal(st, VV_E_FORMAT);
        vvi_source_close(source);
    }
    free(bytes);
}

/* A pipe with these bytes, in path; the process that writes them. */
static pid_t begin_pipe(char path[4096], void **state, const uint8_t *bytes, size_t n)
{
    snprintf(path, 4096, "%s", io_path(state, "pipe"));
    unlink(path);
    assert_int_equal(mkfifo(path, 0600), 0);
    fflush(stdout);
    const pid_t child = fork();
    if (child == 0) {
        const int fd = open(path, O_WRONLY);
        for (size_t at = 0, most = 1000; at < n;) {
            const ssize_t put = write(fd, bytes + at, n - at < most ? n - at : most);
            if (put < 1)
                _exit(1);
            at += (size_t)put;
        }
        _exit(0);
    }
    return child;
}

/* Positions stay what they are. A coded pipe is kept coded. */
static void a_pipe_that_is_made_repeatable_in_time_can_be_read_again(void **state)
{
    for (int c = VVI_CODING_NONE; c <= VVI_CODING_ZSTD; c++) {
        char path[4096];
        size_t n;
        int status;
        vv_source *source, *section;
        const char *file = io_path(state, "coded");
        write_coded(file, (vvi_coding)c, N);
        uint8_t *bytes = io_get(file, &n);
        const pid_t child = begin_pipe(path, state, bytes, n);
        io_ok(vvi_source_open(&source, path, NULL));
        check_at(source, 0, 5000); /* a header */
        io_ok(vvi_source_make_repeatable(source, NULL));
        vvi_source_begin_samples(source);
        waitpid(child, &status, 0);
        assert_int_equal(status, 0); /* all has arrived */
        assert_true(vvi_source_tell(source) == 5000);
        check_at(source, 5000, N - 5000);
        check_at(source, 10, N - 10);
        check_at(source, N - 7, 7);
        check_at(source, 0, 1);
        assert_int_equal(vvi_source_mappable(source, 0, N), c == VVI_CODING_NONE);
        assert_true(vvi_source_end(source) == N || c != VVI_CODING_NONE);
        io_ok(vvi_source_section(&section, source, 100, N - 100, VVI_CODING_NONE, NULL));
        for (int times = 0; times < 2; times++) {
            uint8_t got[300];
            io_ok(vvi_source_seek(section, 0));
            io_ok(vvi_source_read(section, got, sizeof got, "pattern"));
            for (size_t i = 0; i < sizeof got; i++)
                assert_int_equal(got[i], pattern(100 + i));
        }
        io_ok(vvi_source_make_repeatable(source, NULL)); /* it is */
        vvi_source_close(section);
        vvi_source_close(source);
        free(bytes);
    }
}

static void a_pipe_is_not_made_repeatable_once_samples_are_read(void **state)
{
    char path[4096];
    int status;
    vv_source *source;
    static uint8_t bytes[N];
    for (size_t i = 0; i < N; i++)
        bytes[i] = pattern(i);
    const pid_t child = begin_pipe(path, state, bytes, N);
    io_ok(vvi_source_open(&source, path, NULL));
    vvi_source_begin_samples(source);
    check_at(source, 0, N);
    assert_int_equal(vvi_source_make_repeatable(source, NULL), VV_E_UNSUPPORTED);
    assert_non_null(strstr(vv_error_last()->message, "stream"));
    vvi_source_close(source);
    waitpid(child, &status, 0);
    assert_int_equal(status, 0);
}

static void a_pipe_larger_than_a_temporary_file_may_be_is_refused(void **state)
{
    char path[4096];
    int status;
    vv_source *source;
    vv_runtime *runtime;
    vv_job *job;
    vv_limits limits = vvi_limits_default;
    limits.import_spool = 1000;
    vv_runtime_options options;
    vv_runtime_options_init(&options, sizeof options);
    options.limits = &limits;
    io_ok(vv_runtime_new(&runtime, &options));
    io_ok(vv_job_new(&job, runtime, NULL, NULL));
    static uint8_t bytes[2000];
    const pid_t child = begin_pipe(path, state, bytes, sizeof bytes);
    io_ok(vvi_source_open(&source, path, job));
    assert_int_equal(vvi_source_make_repeatable(source, job), VV_E_LIMIT);
    assert_non_null(strstr(vv_error_last()->message, "import_spool"));
    vvi_source_close(source);
    vv_job_release(job);
    vv_runtime_release(runtime);
    waitpid(child, &status, 0);
}

static void a_pipe_is_read_once_and_forwards(void **state)
{
    char path[4096];
    static uint8_t bytes[N];
    for (size_t i = 0; i < N; i++)
        bytes[i] = pattern(i);
    const pid_t child = begin_pipe(path, state, bytes, N);
    vv_source *source;
    bool exact;
    io_ok(vvi_source_open(&source, path, NULL));
    assert_true(vvi_source_left(source, &exact) > N && !exact);
    assert_false(vvi_source_mappable(source, 0, 1));
    check_at(source, 100, 50);
    check_at(source, 1000, N - 1000);
    assert_int_equal(vvi_source_seek(source, 0), VV_E_UNSUPPORTED);
    assert_non_null(strstr(vv_error_last()->message, "stream"));
    vvi_source_close(source);
    int status;
    waitpid(child, &status, 0);
    assert_int_equal(status, 0);
}

static void lines_end_at_line_ends_and_the_file_and_have_a_limit(void **state)
{
    static const char text[] = "one\r\ntwo\n\nlast";
    vv_source *source;
    const char *line;
    bool end;
    io_ok(vvi_source_memory(&source, text, sizeof text - 1, "text", NULL));
    static const char *const want[] = {"one", "two", "", "last"};
    for (int i = 0; i < 4; i++) {
        io_ok(vvi_source_line(source, &line, 100, &end));
        assert_string_equal(line, want[i]);
        assert_false(end);
    }
    io_ok(vvi_source_line(source, &line, 100, &end));
    assert_true(end);
    vvi_source_close(source);
    char *long_line = malloc(100000);
    memset(long_line, 'x', 100000);
    io_ok(vvi_source_memory(&source, long_line, 100000, "text", NULL));
    assert_int_equal(vvi_source_line(source, &line, 50000, &end), VV_E_FORMAT);
    vvi_source_close(source);
    free(long_line);
}

static void sections_know_their_bounds(void **state)
{
    vv_source *source, *section, *inner;
    bool exact;
    const char *path = io_path(state, "sections");
    write_coded(path, VVI_CODING_NONE, N);
    io_ok(vvi_source_open(&source, path, NULL));
    io_ok(vvi_source_section(&section, source, 1000, 500, VVI_CODING_NONE, NULL));
    assert_true(vvi_source_left(section, &exact) == 500 && exact);
    assert_true(vvi_source_mappable(section, 0, 500));
    assert_false(vvi_source_mappable(section, 0, 501));
    assert_false(vvi_source_mappable(section, UINT64_MAX, 2));
    io_ok(vvi_source_section(&inner, section, 100, UINT64_MAX, VVI_CODING_NONE, NULL));
    assert_true(vvi_source_left(inner, &exact) == 400 && exact);
    uint8_t byte;
    io_ok(vvi_source_read(inner, &byte, 1, "byte"));
    assert_int_equal(byte, pattern(1100));
    vvi_source_close(inner);
    vvi_source_close(section);
    assert_int_equal(vvi_source_section(&section, source, UINT64_MAX, 10, VVI_CODING_NONE, NULL), VV_OK);
    assert_true(vvi_source_left(section, &exact) == 0);
    vvi_source_close(section);
    vvi_source_close(source);
}

/* Names inside files --------------------------------------------------------------------------------------------- */

static void names_that_lead_out_are_refused(void **state)
{
    char outside[4096];
    snprintf(outside, sizeof outside, "%s", io_path(state, "secret"));
    io_put_text(outside, "secret");
    assert_int_equal(mkdir(io_path(state, "in"), 0700), 0);
    assert_int_equal(mkdir(io_path(state, "in/sub"), 0700), 0);
    io_put_text(io_path(state, "in/h"), "header");
    io_put_text(io_path(state, "in/data"), "data");
    io_put_text(io_path(state, "in/sub/data"), "data");
    io_put_text(io_path(state, "in/..data"), "data");
    io_put_text(io_path(state, "in/~"), "data");
    assert_int_equal(symlink("../secret", io_path(state, "in/link")), 0);
    assert_int_equal(symlink(outside, io_path(state, "in/absolute-link")), 0);
    assert_int_equal(symlink("..", io_path(state, "in/up")), 0);
    assert_int_equal(symlink("sub/data", io_path(state, "in/good-link")), 0);
    assert_int_equal(symlink("loop", io_path(state, "in/loop")), 0);
    assert_int_equal(symlink("/proc/self/root", io_path(state, "in/root")), 0);
    assert_int_equal(mkfifo(io_path(state, "in/fifo"), 0600), 0);
    char longest[5000], absolute[4200];
    memset(longest, 'a', sizeof longest - 1);
    longest[sizeof longest - 1] = 0;
    snprintf(absolute, sizeof absolute, "%s", outside);
    const char *const bad[] = {
        "../secret",
        "sub/../../secret",
        "..",
        ".",
        "",
        "sub",
        "/etc/passwd",
        absolute,
        "link",
        "absolute-link",
        "up/secret",
        "up/in/data",
        "loop",
        "root/etc/passwd",
        "fifo",
        "/dev/null",
        "/dev/zero",
        "/proc/self/mem",
        "/proc/self/environ",
        "http://example.org/data",
        "file:///etc/passwd",
        "\\\\server\\share\\data",
        "C:\\data",
        "data/",
        "data/x",
        "no-such-file",
        longest,
        "./../secret",
        "sub//..//../secret",
        "~/secret",
        "~root/secret",
    };
    vv_source *header, *data = NULL;
    io_ok(vvi_source_open(&header, io_path(state, "in/h"), NULL));
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        const vv_status st = vvi_source_open_beside(&data, header, bad[i], NULL);
        if (st != VV_E_READ)
            fail_msg("'%.60s' gives %s", bad[i], vv_status_name(st));
        assert_null(data);
        assert_non_null(strstr(vv_error_last()->message, "/in/"));
    }
    static const char *const good[] = {"data", "./data", "sub/data", "..data", "~", "good-link", "sub//data"};
    for (size_t i = 0; i < sizeof good / sizeof *good; i++) {
        io_ok(vvi_source_open_beside(&data, header, good[i], NULL));
        vvi_source_close(data);
    }
    vvi_source_close(header);
}

static void outside_files_open_when_the_runtime_allows_them(void **state)
{
    vv_runtime_options options;
    vv_runtime *runtime;
    vv_job *job;
    vv_source *header, *data;
    vv_runtime_options_init(&options, sizeof options);
    options.allow_outside = true;
    io_ok(vv_runtime_new(&runtime, &options));
    io_ok(vv_job_new(&job, runtime, NULL, NULL));
    io_put_text(io_path(state, "outside"), "data");
    mkdir(io_path(state, "inner"), 0700);
    io_put_text(io_path(state, "inner/h"), "header");
    io_ok(vvi_source_open(&header, io_path(state, "inner/h"), job));
    io_ok(vvi_source_open_beside(&data, header, "../outside", job));
    vvi_source_close(data);
    io_ok(vvi_source_open_beside(&data, header, io_path(state, "outside"), job));
    vvi_source_close(data);
    assert_int_equal(vvi_source_open_beside(&data, header, "/dev/zero", job), VV_E_READ);
    vvi_source_close(header);
    vv_job_release(job);
    vv_runtime_release(runtime);
}

static void memory_and_pipes_have_no_folder_to_look_in(void **state)
{
    vv_source *header, *data = NULL;
    io_ok(vvi_source_memory(&header, "x", 1, "memory", NULL));
    assert_int_equal(vvi_source_open_beside(&data, header, "data", NULL), VV_E_READ);
    vvi_source_close(header);
}

/* Mapping -------------------------------------------------------------------------------------------------------- */

static void mapped_files_have_guard_bytes_even_at_a_page_boundary(void **state)
{
    const size_t page = (size_t)sysconf(_SC_PAGESIZE);
    for (size_t n = page - 1; n <= page + 1; n++) {
        vv_source *source;
        vvi_mapping *mapping;
        const void *data;
        size_t guard;
        const char *path = io_path(state, "page");
        write_coded(path, VVI_CODING_NONE, n);
        io_ok(vvi_source_open(&source, path, NULL));
        io_ok(vvi_source_map(&mapping, &data, &guard, source, 3, n - 3));
        vvi_source_close(source); /* the map lives on */
        assert_true(guard >= 64);
        const volatile uint8_t *bytes = data;
        for (size_t i = 0; i < n - 3; i++)
            assert_int_equal(bytes[i], pattern(i + 3));
        for (size_t i = 0; i < guard; i++)
            assert_int_equal(bytes[n - 3 + i], 0);
        assert_false(vvi_mapping_damaged(mapping));
        vvi_mapping_free(mapping);
    }
}

static void a_file_that_shrinks_while_mapped_reads_zeros_and_says_so(void **state)
{
    enum { SIDE = 64 };
    char path[4096];
    snprintf(path, sizeof path, "%s", io_path(state, "shrinks_64x64x64_u8.raw"));
    vv_field_info info = vv_field_info_default();
    info.grid.dims[0] = info.grid.dims[1] = info.grid.dims[2] = SIDE;
    vv_field *field = test_field_random(&info, 3, NULL);
    io_write(path, field, NULL, false);
    vv_file *file = io_open(path);
    assert_true(vv_file_mappable(file));
    vv_field *mapped = io_frame(file, 0);
    vv_file_close(file);
    io_ok(vv_field_health(mapped));
    assert_int_equal(truncate(path, 5000), 0);
    assert_true(vv_field_value(mapped, 0, 0, 1, 0) == vv_field_value(field, 0, 0, 1, 0));
    assert_true(vv_field_value(mapped, 0, 0, 2, 0) == 0);
    assert_true(vv_field_value(mapped, SIDE - 1, SIDE - 1, SIDE - 1, 0) == 0);
    assert_int_equal(vv_field_health(mapped), VV_E_READ);
    vv_field_release(mapped);
    vv_field_release(field);
}

static void *read_all(void *user)
{
    const volatile uint8_t *bytes = user;
    unsigned sum = 0;
    for (size_t i = 0; i < N; i++)
        sum += bytes[i];
    return (void *)(uintptr_t)sum;
}

static void several_threads_survive_the_same_shrinking(void **state)
{
    vv_source *source;
    vvi_mapping *mapping;
    const void *data;
    size_t guard;
    char path[4096];
    snprintf(path, sizeof path, "%s", io_path(state, "threads"));
    write_coded(path, VVI_CODING_NONE, N);
    io_ok(vvi_source_open(&source, path, NULL));
    io_ok(vvi_source_map(&mapping, &data, &guard, source, 0, N));
    assert_int_equal(truncate(path, 0), 0);
    pthread_t thread[3];
    for (int t = 0; t < 3; t++)
        assert_int_equal(pthread_create(&thread[t], NULL, read_all, (void *)(uintptr_t)data), 0);
    for (int t = 0; t < 3; t++) {
        void *sum;
        pthread_join(thread[t], &sum);
        assert_null(sum);
    }
    assert_true(vvi_mapping_damaged(mapping));
    vvi_mapping_free(mapping);
    vvi_source_close(source);
}

typedef struct shrunk {
    const uint8_t *bytes;
    pthread_t owner;
    atomic_bool helped;
    atomic_uint sum;
} shrunk;

/* The bytes are read by a thread of the pool alone: the loop's own waits for one, not for ever. */
static vv_status read_as_helper(void *scratch, void *shared, size_t index)
{
    shrunk *s = shared;
    (void)scratch;
    (void)index;
    if (!pthread_equal(pthread_self(), s->owner)) {
        for (size_t i = 0; i < N; i++)
            atomic_fetch_add(&s->sum, ((const volatile uint8_t *)s->bytes)[i]);
        atomic_store(&s->helped, true);
    }
    for (int ms = 0; ms < 10000 && !atomic_load(&s->helped); ms++)
        usleep(1000);
    return VV_OK;
}

static void threads_of_the_pool_survive_the_same_shrinking(void **state)
{
    static const vvi_work work = {.item = read_as_helper};
    vv_source *source;
    vvi_mapping *mapping;
    const void *data;
    size_t guard;
    const char *path = io_path(state, "pool");
    vv_job *job = test_job(2, 0);
    write_coded(path, VVI_CODING_NONE, N);
    io_ok(vvi_source_open(&source, path, job));
    io_ok(vvi_source_map(&mapping, &data, &guard, source, 0, N));
    assert_int_equal(truncate(path, 0), 0);
    shrunk shared = {.bytes = data, .owner = pthread_self()};
    io_ok(vvi_parallel_for(job, &work, &shared, 2));
    assert_true(atomic_load(&shared.helped));
    assert_int_equal(atomic_load(&shared.sum), 0);
    assert_true(vvi_mapping_damaged(mapping));
    vvi_mapping_free(mapping);
    vvi_source_close(source);
    vv_job_release(job);
}

static void another_bus_error_still_ends_the_process(void **state)
{
    vv_source *source;
    const char *path = io_path(state, "other");
    write_coded(path, VVI_CODING_NONE, N);
    io_ok(vvi_source_open(&source, path, NULL));
    fflush(stdout);
    const pid_t child = fork();
    if (child == 0) {
        vvi_mapping *mapping;
        const void *data;
        size_t guard;
        signal(SIGBUS, SIG_DFL);
        if (vvi_source_map(&mapping, &data, &guard, source, 0, N) != VV_OK)
            _exit(2);
        raise(SIGBUS); /* takes our handler away; a fault would now repeat itself, a raised signal has to be raised
                          again */
        raise(SIGBUS);
        _exit(0);
    }
    int status;
    waitpid(child, &status, 0);
    assert_true(WIFSIGNALED(status));
    assert_int_equal(WTERMSIG(status), SIGBUS);
    vvi_source_close(source);
}

static volatile sig_atomic_t seen;

static void note_bus_error(int number)
{
    seen = number;
}

static void a_handler_that_was_there_before_is_called_for_its_own_faults(void **state)
{
    vv_source *source;
    vvi_mapping *mapping;
    const void *data;
    size_t guard;
    const char *path = io_path(state, "before");
    write_coded(path, VVI_CODING_NONE, N);
    void (*old)(int) = signal(SIGBUS, note_bus_error);
    io_ok(vvi_source_open(&source, path, NULL));
    io_ok(vvi_source_map(&mapping, &data, &guard, source, 0, N));
    raise(SIGBUS);
    assert_int_equal(seen, SIGBUS);
    vvi_mapping_free(mapping);
    vvi_source_close(source);
    signal(SIGBUS, old);
}

/* Bombs ---------------------------------------------------------------------------------------------------------- */

static void an_expansion_past_all_honesty_is_stopped(void **state)
{
    /* zstd of zeros reaches about 30000:1; gzip cannot pass 1032:1 */
    vv_sink *sink;
    vv_source *source;
    uint8_t *zeros = calloc(1, 1 << 20);
    const char *path = io_path(state, "bomb.zst");
    io_ok(vvi_sink_open(&sink, path, NULL));
    io_ok(vvi_sink_coding(sink, VVI_CODING_ZSTD, 9));
    for (int i = 0; i < 256; i++)
        io_ok(vvi_sink_write(sink, zeros, 1 << 20));
    io_ok(vvi_sink_commit(sink));
    io_ok(vvi_source_open(&source, path, NULL));
    assert_int_equal(vvi_source_seek(source, (uint64_t)256 << 20), VV_OK);
    uint8_t byte;
    const uint64_t reached = vvi_source_tell(source);
    if (reached < (uint64_t)256 << 20) {
        assert_int_equal(vvi_source_read(source, &byte, 1, "byte"), VV_E_FORMAT);
        assert_true(reached <= (uint64_t)80 << 20);
    }
    vvi_source_close(source);
    free(zeros);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_coding_reads_at_any_place_forwards_and_backwards),
        cmocka_unit_test(coded_data_that_are_asked_for_again_and_again_are_kept),
        cmocka_unit_test(members_one_after_another_are_one_stream),
        cmocka_unit_test(cut_coded_files_say_that_they_are_cut),
        cmocka_unit_test(coded_data_are_proven_from_where_they_are_read_and_read_on_there),
        cmocka_unit_test(coded_data_that_are_cut_are_known_to_be_before_they_are_read_to_there),
        cmocka_unit_test(what_is_handed_out_of_coded_data_is_counted_until_they_must_be_proven),
        cmocka_unit_test(a_flipped_bit_in_a_gzip_file_is_found_by_its_checksum),
        cmocka_unit_test(a_pipe_is_read_once_and_forwards),
        cmocka_unit_test(a_pipe_that_is_made_repeatable_in_time_can_be_read_again),
        cmocka_unit_test(a_pipe_is_not_made_repeatable_once_samples_are_read),
        cmocka_unit_test(a_pipe_larger_than_a_temporary_file_may_be_is_refused),
        cmocka_unit_test(lines_end_at_line_ends_and_the_file_and_have_a_limit),
        cmocka_unit_test(sections_know_their_bounds),
        cmocka_unit_test(names_that_lead_out_are_refused),
        cmocka_unit_test(outside_files_open_when_the_runtime_allows_them),
        cmocka_unit_test(memory_and_pipes_have_no_folder_to_look_in),
        cmocka_unit_test(mapped_files_have_guard_bytes_even_at_a_page_boundary),
        cmocka_unit_test(a_file_that_shrinks_while_mapped_reads_zeros_and_says_so),
        cmocka_unit_test(several_threads_survive_the_same_shrinking),
        cmocka_unit_test(threads_of_the_pool_survive_the_same_shrinking),
        cmocka_unit_test(another_bus_error_still_ends_the_process),
        cmocka_unit_test(a_handler_that_was_there_before_is_called_for_its_own_faults),
        cmocka_unit_test(an_expansion_past_all_honesty_is_stopped),
    };
    return cmocka_run_group_tests(tests, io_setup, io_teardown);
}
