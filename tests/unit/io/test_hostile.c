/* Truncated, lying and hostile files: one clear sentence, at once, in little memory; never wrong dims, never a crash.
 * Peak memory is checked in a child process under a limit on its address space. */
#include "core/memory.h"
#include "fail_alloc.h"
#include "fields.h"
#include "io/sink.h"
#include "io/source.h"
#include "io_test.h"
#include "jobs.h"
#include <sys/resource.h>
#include <sys/wait.h>
#include <time.h>
#include <zlib.h>

static vv_status read_all_in(const char *path, vv_field_info *info_out, vv_job *job)
{
    vv_file *file;
    vv_status st = vv_file_open(&file, path, NULL, job);
    if (st != VV_OK)
        return st;
    *info_out = *vv_file_info(file);
    for (int64_t f = 0; f < info_out->n_frames && f < 4 && st == VV_OK; f++) {
        vv_field *field;
        st = vv_file_read(&field, file, f, NULL, job);
        if (st == VV_OK)
            vv_field_release(field);
    }
    vv_file_close(file);
    return st;
}

static vv_status read_all(const char *path, vv_field_info *info_out)
{
    return read_all_in(path, info_out, NULL);
}

/* Seeds: the smallest file of each dialect that the writers know. */
typedef struct seed {
    const char *name, *encoding;
} seed;

static const seed seeds[] = {
    {"s.nrrd", "raw"},        {"s.nrrd", "gzip"}, {"s.nrrd", "bzip2"}, {"s.nrrd", "ascii"}, {"s.nrrd", "hex"},
    {"s.nii", NULL},          {"s.nii.gz", NULL}, {"s.npy", NULL},     {"s.npy.zst", NULL}, {"s_5x3x2_u16.raw", NULL},
    {"s.nrrd.gz", "raw"},     {"s.mha", "raw"},   {"s.mha", "zlib"},   {"s.tif", "raw"},    {"s.tif", "lzw"},
    {"s.ome.tif", "deflate"}, {"s.mrc", NULL}};
#define N_SEEDS (sizeof seeds / sizeof *seeds)

static uint8_t *make_seed(void **state, const seed *s, size_t *n)
{
    vv_field_info info = vv_field_info_default();
    info.grid.dims[0] = 5;
    info.grid.dims[1] = 3;
    info.grid.dims[2] = 2;
    info.grid.index_to_world.origin.x = 2.5;
    strcpy(info.grid.unit, "mm");
    info.type = VV_TYPE_U16;
    vv_field *field = test_field_random(&info, 11, NULL);
    io_write(io_path(state, s->name), field, s->encoding, false);
    vv_field_release(field);
    return io_get(io_path(state, s->name), n);
}

static void every_truncation_is_one_clear_sentence(void **state)
{
    for (size_t s = 0; s < N_SEEDS; s++) {
        size_t n;
        uint8_t *bytes = make_seed(state, &seeds[s], &n);
        char path[4096];
        snprintf(path, sizeof path, "%s", io_path(state, seeds[s].name));
        for (size_t keep = 0; keep < n; keep++) {
            vv_field_info info;
            vv_job *job;
            io_put(path, bytes, keep);
            io_ok(vv_job_new(&job, NULL, NULL, NULL));
            const vv_status st = read_all_in(path, &info, job);
            const bool damaged = vv_job_damaged(job); /* what is missing was said */
            vv_job_release(job);
            const bool text =
                seeds[s].encoding && (strcmp(seeds[s].encoding, "ascii") == 0 || strcmp(seeds[s].encoding, "hex") == 0);
            if (st == VV_OK && damaged) {
                assert_int_equal(info.grid.dims[0] * 100 + info.grid.dims[1] * 10 + info.grid.dims[2], 532);
            } else if (st == VV_OK &&
                       !(text && keep + 7 > n)) /* text may lose its last line end, or digits of the last number */
                fail_msg("%s %s: %zu of %zu bytes are read as a whole file", seeds[s].name,
                         seeds[s].encoding ? seeds[s].encoding : "", keep, n);
            if (st != VV_OK) {
                const bool names_a_file = strcmp(seeds[s].name, "s.mha") == 0; /* "LOCAL" cut short */
                assert_true(st == VV_E_FORMAT || st == VV_E_ARGUMENT || st == VV_E_UNSUPPORTED ||
                            (names_a_file && st == VV_E_READ));
                assert_non_null(strstr(vv_error_last()->message, seeds[s].name));
                assert_null(strchr(vv_error_last()->message, '\n'));
            }
        }
        free(bytes);
    }
}

/* Ten thousand files with a few bits or bytes changed: read or refused. One process: a crash, a leak or a hang shows.
 */
static void mutations_are_read_or_refused(void **state)
{
    const uint64_t random = test_seed();
    uint64_t next = 0;
    struct timespec begin, end;
    for (size_t s = 0; s < N_SEEDS; s++) {
        size_t n;
        uint8_t *bytes = make_seed(state, &seeds[s], &n);
        uint8_t *mutant = malloc(n);
        char path[4096];
        snprintf(path, sizeof path, "%s", io_path(state, seeds[s].name));
        for (int m = 0; m < 10000 / (int)N_SEEDS + 1; m++) {
            vv_field_info info = {0};
            memcpy(mutant, bytes, n);
            for (int changes = 1 + (int)(test_random(random, next++) % 4); changes > 0; changes--) {
                const size_t at = test_random(random, next++) % n;
                const uint64_t how = test_random(random, next++);
                mutant[at] = (uint8_t)(how & 1 ? mutant[at] ^ UINT64_C(1) << (how >> 8) % 8 : how >> 8);
            }
            io_put(path, mutant, n);
            clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &begin);
            const vv_status st = read_all(path, &info);
            clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &end);
            assert_true(end.tv_sec - begin.tv_sec <= 10);
            if (st == VV_OK)
                assert_true(info.grid.dims[0] >= 1 && info.grid.dims[1] >= 1 && info.grid.dims[2] >= 1);
            else
                assert_true(vv_error_last()->message[0]);
        }
        free(mutant);
        free(bytes);
    }
}

/* Hostile headers ------------------------------------------------------------------------------------------------- */

/* Reads a file in a child that may take a minute of a busy machine, and looks at how much it really held.
 * The reply is the status, or 100 and more for a broken promise. */
static void refused_in_little_memory(const char *path, vv_status status, const char *words)
{
    static const long most_kb = 64 << 10;
    struct rusage before;
    getrusage(RUSAGE_SELF, &before);
    fflush(stdout);
    const pid_t child = fork();
    if (child == 0) {
        vv_field_info info;
        alarm(60);
        const vv_status st = read_all(path, &info);
        if (st != status || !strstr(vv_error_last()->message, words)) {
            fprintf(stderr, "%s: %s: %s\n", path, vv_status_name(st), st == VV_OK ? "" : vv_error_last()->message);
            _exit(1);
        }
        struct rusage after;
        getrusage(RUSAGE_SELF, &after);
        _exit(after.ru_maxrss - before.ru_maxrss > most_kb ? 2 : 0);
    }
    int result;
    waitpid(child, &result, 0);
    if (result != 0)
        fail_msg("%s: the child ended with %d (256: other words, 512: too much memory, 14: too slow)", path, result);
}

typedef struct nifti_case {
    const char *why;
    int at, size;
    double value; /* stored little-endian as int16, or float when size is 4 */
    vv_status status;
    const char *words;
} nifti_case;

static void put_le(uint8_t *at, int size, double value)
{
    if (size == 4) {
        const float f = (float)value;
        memcpy(at, &f, 4);
    } else {
        const int16_t i = (int16_t)value;
        memcpy(at, &i, 2);
    }
}

static const nifti_case nifti_cases[] = {
    {"rank 0", 40, 2, 0, VV_E_FORMAT, "dim[0]"},
    {"rank 8", 40, 2, 8, VV_E_FORMAT, "dim[0]"},
    {"rank 200", 40, 2, 200, VV_E_FORMAT, "dim[0] is 200"},
    {"rank -1", 40, 2, -1, VV_E_FORMAT, "dim[0]"},
    {"no width", 42, 2, 0, VV_E_FORMAT, "dim[1] is 0"},
    {"negative width", 42, 2, -5, VV_E_FORMAT, "dim[1] is -5"},
    {"largest width", 42, 2, 32767, VV_E_FORMAT, "expected"},
    {"unknown type", 70, 2, 77, VV_E_FORMAT, "datatype 77"},
    {"complex", 70, 2, 32, VV_E_UNSUPPORTED, "complex"},
    {"bits", 70, 2, 1, VV_E_UNSUPPORTED, "bits"},
    {"wrong bitpix", 72, 2, 24, VV_E_FORMAT, "bitpix"},
    {"offset inside the header", 108, 4, 100, VV_E_FORMAT, "vox_offset"},
    {"offset before the file", 108, 4, -4, VV_E_FORMAT, "vox_offset"},
    {"offset not whole", 108, 4, 352.5, VV_E_FORMAT, "vox_offset"},
    {"offset past the end", 108, 4, 1e9, VV_E_FORMAT, "expected"},
    {"offset infinite", 108, 4, INFINITY, VV_E_FORMAT, "vox_offset"},
    {"offset no number", 108, 4, NAN, VV_E_FORMAT, "vox_offset"},
    {"offset larger than a file", 108, 4, 3e38, VV_E_FORMAT, "vox_offset"},
    {"intercept no number", 116, 4, NAN, VV_E_FORMAT, "intercept"},
};

static void each_lie_of_a_nifti_header_is_refused(void **state)
{
    static const seed plain = {"s.nii", NULL};
    size_t n;
    uint8_t *bytes = make_seed(state, &plain, &n);
    const char *path = io_path(state, "lie.nii");
    for (size_t c = 0; c < sizeof nifti_cases / sizeof *nifti_cases; c++) {
        uint8_t *mutant = malloc(n);
        memcpy(mutant, bytes, n);
        put_le(mutant + nifti_cases[c].at, nifti_cases[c].size, nifti_cases[c].value);
        io_put(path, mutant, n);
        io_refused(path, nifti_cases[c].status, nifti_cases[c].words);
        free(mutant);
    }
    free(bytes);
}

static void a_nifti_of_377_bytes_that_asks_for_18_gigabytes_is_refused_at_once(void **state)
{
    uint8_t header[377] = {0};
    const int32_t size = 348;
    memcpy(header, &size, 4);
    const int16_t dims[8] = {3, 2048, 2048, 2200, 1, 1, 1, 1};
    memcpy(header + 40, dims, sizeof dims);
    put_le(header + 70, 2, 16);
    put_le(header + 72, 2, 32);
    put_le(header + 108, 4, 352);
    memcpy(header + 344, "n+1", 4);
    const char *path = io_path(state, "asks.nii");
    io_put(path, header, sizeof header);
    refused_in_little_memory(path, VV_E_FORMAT, "ends after 377 bytes");
    /* the same inside gzip */
    vv_sink *sink;
    path = io_path(state, "asks.nii.gz");
    io_ok(vvi_sink_open(&sink, path, NULL));
    io_ok(vvi_sink_coding(sink, VVI_CODING_GZIP, 9));
    io_ok(vvi_sink_write(sink, header, sizeof header));
    io_ok(vvi_sink_commit(sink));
    refused_in_little_memory(path, VV_E_FORMAT, "ends after 377 bytes");
}

static void a_nifti_2_of_540_bytes_with_200_axes_is_refused(void **state)
{
    uint8_t header[544] = {0};
    const int32_t size = 540;
    memcpy(header, &size, 4);
    memcpy(header + 4, "n+2\0\r\n\x1a\n", 8);
    const int64_t dims[8] = {200, INT64_MAX, INT64_MAX, INT64_MIN, -1, 0, 1, 2};
    memcpy(header + 16, dims, sizeof dims);
    put_le(header + 12, 2, 16);
    put_le(header + 14, 2, 32);
    const char *path = io_path(state, "axes.nii");
    io_put(path, header, 540);
    refused_in_little_memory(path, VV_E_FORMAT, "dim[0] is 200");
    for (int64_t rank = 1; rank <= 7; rank++) { /* products that overflow 64 bits */
        const int64_t huge[8] = {rank, 1 << 20, 1 << 20, 1 << 20, 1 << 20, 1 << 20, 1, 1};
        memcpy(header + 16, huge, sizeof huge);
        io_put(path, header, 540);
        vv_field_info info;
        assert_true(read_all(path, &info) == VV_E_FORMAT || rank < 3);
        assert_true(read_all(path, &info) != VV_OK);
    }
}

static const struct {
    const char *why, *text, *words;
    vv_status status;
} nrrd_cases[] = {
    {"product past 64 bits",
     "NRRD0004\ntype: double\ndimension: 5\nsizes: 1048576 1048576 1048576 1048576 1048576\nkinds: "
     "list domain domain domain time\nendian: little\nencoding: raw\n\n",
     "more than", VV_E_FORMAT},
    {"size past 64 bits", "NRRD0004\ntype: uchar\ndimension: 3\nsizes: 99999999999999999999 1 1\nencoding: raw\n\n",
     "sizes", VV_E_FORMAT},
    {"size too large", "NRRD0004\ntype: uchar\ndimension: 3\nsizes: 1048577 1 1\nencoding: raw\n\n", "1048577",
     VV_E_FORMAT},
    {"negative size", "NRRD0004\ntype: uchar\ndimension: 3\nsizes: -1 1 1\nencoding: raw\n\n", "-1", VV_E_FORMAT},
    {"sizes and dimension", "NRRD0004\ntype: uchar\ndimension: 3\nsizes: 2 2\nencoding: raw\n\n",
     "'sizes' has 2 numbers but 'dimension' is 3", VV_E_FORMAT},
    {"dimension 17", "NRRD0004\ntype: uchar\ndimension: 17\nsizes: 2 2\nencoding: raw\n\n", "dimension", VV_E_FORMAT},
    {"dimension 0", "NRRD0004\ntype: uchar\ndimension: 0\nsizes: 2 2\nencoding: raw\n\n", "dimension", VV_E_FORMAT},
    {"lying gzip", "NRRD0004\ntype: uchar\ndimension: 3\nsizes: 1048576 1024 64\nencoding: gzip\n\n\x1f\x8b\x08",
     "can hold at most", VV_E_FORMAT},
    {"lying raw", "NRRD0004\ntype: uchar\ndimension: 3\nsizes: 1048576 1024 64\nencoding: raw\n\nabc", "ends after",
     VV_E_FORMAT},
    {"lying text", "NRRD0004\ntype: uchar\ndimension: 3\nsizes: 1048576 1024 64\nencoding: ascii\n\n1 2 3",
     "ends after", VV_E_FORMAT},
    {"text out of range", "NRRD0004\ntype: uchar\ndimension: 1\nsizes: 2\nencoding: ascii\n\n1 256",
     "'256', which is not u8", VV_E_FORMAT},
    {"text no number", "NRRD0004\ntype: uchar\ndimension: 1\nsizes: 2\nencoding: ascii\n\n1 x2x3", "not u8",
     VV_E_FORMAT},
    {"fraction of an integer", "NRRD0004\ntype: int\ndimension: 1\nsizes: 2\nencoding: ascii\n\n1 2.5", "not i32",
     VV_E_FORMAT},
    {"infinite integer", "NRRD0004\ntype: int\ndimension: 1\nsizes: 2\nencoding: ascii\n\n1 inf", "not i32",
     VV_E_FORMAT},
    {"nan integer", "NRRD0004\ntype: short\ndimension: 1\nsizes: 2\nencoding: ascii\n\n1 nan", "not i16", VV_E_FORMAT},
    {"hex", "NRRD0004\ntype: uchar\ndimension: 1\nsizes: 2\nencoding: hex\n\n01g2", "hexadecimal", VV_E_FORMAT},
    {"singular",
     "NRRD0004\ntype: uchar\ndimension: 2\nsizes: 1 1\nspace dimension: 2\nspace directions: (1,1) (2,2)\n"
     "encoding: raw\n\nab",
     "one plane", VV_E_FORMAT},
    {"zero spacing", "NRRD0004\ntype: uchar\ndimension: 1\nsizes: 1\nspacings: 0\nencoding: raw\n\nab", "spacings",
     VV_E_FORMAT},
    {"infinite direction",
     "NRRD0004\ntype: uchar\ndimension: 1\nsizes: 1\nspace dimension: 1\nspace directions: (inf)\n"
     "encoding: raw\n\nab",
     "finite", VV_E_FORMAT},
    {"twice", "NRRD0004\ntype: uchar\ntype: uchar\n", "twice", VV_E_FORMAT},
    {"misspelt field", "NRRD0004\ntyp: uchar\n", "did you mean 'type'", VV_E_FORMAT},
    {"no type", "NRRD0004\ndimension: 1\nsizes: 1\nencoding: raw\n\na", "'type'", VV_E_FORMAT},
    {"no endian", "NRRD0004\ntype: int\ndimension: 1\nsizes: 1\nencoding: raw\n\nabcd", "'endian'", VV_E_FORMAT},
    {"block", "NRRD0004\ntype: block\nblock size: 4\ndimension: 1\nsizes: 1\nencoding: raw\n\nabcd", "numeric type",
     VV_E_UNSUPPORTED},
    {"version 6", "NRRD0006\ntype: uchar\n", "newer", VV_E_UNSUPPORTED},
    {"version x", "NRRD000x\ntype: uchar\n", "NRRD0001", VV_E_FORMAT},
    {"pattern with %s", "NRRD0004\ntype: uchar\ndimension: 1\nsizes: 1\nencoding: raw\ndata file: a%s 1 2 1\n", "%d",
     VV_E_FORMAT},
    {"pattern with %n", "NRRD0004\ntype: uchar\ndimension: 1\nsizes: 1\nencoding: raw\ndata file: %d%n 1 2 1\n", "%d",
     VV_E_FORMAT},
    {"pattern of 2^40 files",
     "NRRD0004\ntype: uchar\ndimension: 1\nsizes: 1\nencoding: raw\ndata file: %d 1 1000000000000 "
     "1\n",
     "more names than", VV_E_FORMAT},
    {"pattern that stands still", "NRRD0004\ntype: uchar\ndimension: 1\nsizes: 1\nencoding: raw\ndata file: %d 1 2 0\n",
     "step", VV_E_FORMAT},
    {"detached absolute", "NRRD0004\ntype: uchar\ndimension: 1\nsizes: 1\nencoding: raw\ndata file: /etc/passwd\n",
     "--allow-outside", VV_E_READ},
    {"detached above", "NRRD0004\ntype: uchar\ndimension: 1\nsizes: 1\nencoding: raw\ndata file: ../../../etc/passwd\n",
     "--allow-outside", VV_E_READ},
    {"detached list above",
     "NRRD0004\ntype: uchar\ndimension: 1\nsizes: 1\nencoding: raw\ndata file: "
     "LIST\n../x\n",
     "--allow-outside", VV_E_READ},
    {"detached device", "NRRD0004\ntype: uchar\ndimension: 1\nsizes: 1\nencoding: raw\ndata file: /dev/zero\n",
     "absolute", VV_E_READ},
    {"byte skip past the end", "NRRD0004\ntype: uchar\ndimension: 1\nsizes: 1\nbyte skip: 1000\nencoding: raw\n\nabc",
     "ends after", VV_E_FORMAT},
    {"line skip past the end", "NRRD0004\ntype: uchar\ndimension: 1\nsizes: 1\nline skip: 10\nencoding: raw\n\nabc",
     "'line skip'", VV_E_FORMAT},
    {"byte skip -1 of gzip", "NRRD0004\ntype: uchar\ndimension: 1\nsizes: 1\nbyte skip: -1\nencoding: gzip\n\nabc",
     "-1", VV_E_FORMAT},
    {"five unnamed axes", "NRRD0004\ntype: uchar\ndimension: 6\nsizes: 1 1 1 1 1 1\nencoding: raw\n\nabc", "axes",
     VV_E_UNSUPPORTED},
    {"matrix",
     "NRRD0004\ntype: float\ndimension: 4\nsizes: 6 1 1 1\nkinds: 3D-symmetric-matrix domain domain domain\n"
     "endian: little\nencoding: raw\n\nabc",
     "matrices", VV_E_UNSUPPORTED},
    {"colour of two",
     "NRRD0004\ntype: uchar\ndimension: 3\nsizes: 2 1 1\nkinds: RGB-color domain domain\nencoding: raw\n\nab",
     "3 entries", VV_E_FORMAT},
};

static void each_lie_of_a_nrrd_header_is_refused(void **state)
{
    const char *path = io_path(state, "lie.nrrd");
    for (size_t c = 0; c < sizeof nrrd_cases / sizeof *nrrd_cases; c++) {
        io_put_text(path, nrrd_cases[c].text);
        io_refused(path, nrrd_cases[c].status, nrrd_cases[c].words);
    }
}

static const struct {
    const char *header, *words;
    vv_status status;
} npy_cases[] = {
    {"{'descr': '|O', 'fortran_order': False, 'shape': (1,), }", "objects", VV_E_UNSUPPORTED},
    {"{'descr': [('a', '<i4')], 'fortran_order': False, 'shape': (1,), }", "structures", VV_E_UNSUPPORTED},
    {"{'descr': '<c8', 'fortran_order': False, 'shape': (1,), }", "'c8'", VV_E_UNSUPPORTED},
    {"{'descr': '<U5', 'fortran_order': False, 'shape': (1,), }", "'U5'", VV_E_UNSUPPORTED},
    {"{'descr': '<f16', 'fortran_order': False, 'shape': (1,), }", "'f16'", VV_E_UNSUPPORTED},
    {"{'descr': '<M8[ns]', 'fortran_order': False, 'shape': (1,), }", "descr", VV_E_FORMAT},
    {"{'descr': '|u1', 'fortran_order': False, 'shape': (), }", "one number", VV_E_UNSUPPORTED},
    {"{'descr': '|u1', 'fortran_order': False, 'shape': (0, 1), }", "shape", VV_E_FORMAT},
    {"{'descr': '|u1', 'fortran_order': False, 'shape': (-1, 1), }", "shape", VV_E_FORMAT},
    {"{'descr': '|u1', 'fortran_order': False, 'shape': (99999999999999999999, 1), }", "shape", VV_E_FORMAT},
    {"{'descr': '<f8', 'fortran_order': False, 'shape': (1048576, 1048576, 1048576, 1048576, 1048576), }", "more than",
     VV_E_FORMAT},
    {"{'descr': '<f8', 'fortran_order': False, 'shape': (1000, 1000, 1000), }", "ends after", VV_E_FORMAT},
    {"{'descr': '|u1', 'fortran_order': False, 'shape': (1, 1, 1, 1, 1, 1), }", "5 axes", VV_E_UNSUPPORTED},
    {"{'descr': '|u1', 'fortran_order': 1, 'shape': (1,), }", "fortran_order", VV_E_FORMAT},
    {"{'descr': '|u1', 'fortran_order': False, 'shape': (1", "shape", VV_E_FORMAT},
    {"{'fortran_order': False, 'shape': (1,), }", "descr", VV_E_FORMAT},
    {"", "descr", VV_E_FORMAT},
};

static void each_lie_of_an_npy_header_is_refused(void **state)
{
    const char *path = io_path(state, "lie.npy");
    for (size_t c = 0; c < sizeof npy_cases / sizeof *npy_cases; c++) {
        uint8_t file[512] = {0x93, 'N', 'U', 'M', 'P', 'Y', 1, 0};
        const size_t n = strlen(npy_cases[c].header);
        file[8] = (uint8_t)n;
        memcpy(file + 10, npy_cases[c].header, n);
        io_put(path, file, n + 10);
        io_refused(path, npy_cases[c].status, npy_cases[c].words);
    }
    const uint8_t lying[] = {0x93, 'N', 'U', 'M', 'P', 'Y', 2, 0, 0xff, 0xff, 0xff, 0xff};
    io_put(path, lying, sizeof lying);
    refused_in_little_memory(path, VV_E_FORMAT, "header has 4294967295 bytes");
    const uint8_t newer[] = {0x93, 'N', 'U', 'M', 'P', 'Y', 9, 0, 0, 0, 0, 0};
    io_put(path, newer, sizeof newer);
    io_refused(path, VV_E_UNSUPPORTED, "version 9");
}

static void raw_layouts_that_lie_or_are_not_understood_are_refused(void **state)
{
    static const struct {
        const char *layout, *words;
        vv_status status;
    } cases[] = {
        {"", "dims", VV_E_ARGUMENT},
        {"4x4", "dims", VV_E_ARGUMENT},
        {"4x4x4", "dims", VV_E_ARGUMENT},
        {"4x4x4,u9", "type", VV_E_ARGUMENT},
        {"4x4x4,u8,sapcing=1x1x1", "sapcing", VV_E_ARGUMENT},
        {"4x4x4,u8,spacing=1x1", "spacing", VV_E_ARGUMENT},
        {"4x4x4,u8,spacing=1x1x0", "spacing", VV_E_ARGUMENT},
        {"4x4x4,u8,spacing=1x1xnan", "spacing", VV_E_ARGUMENT},
        {"4x4x4,u8,skip=-1", "skip", VV_E_ARGUMENT},
        {"4x4x4,u8,skip=99999999999999999999", "skip", VV_E_ARGUMENT},
        {"4x4x4,u8,skip=9223372036854775807", "ends after", VV_E_FORMAT},
        {"4x4x5,u8", "ends after 64 bytes; 80", VV_E_FORMAT},
        {"0x4x4,u8", "0 samples along x", VV_E_ARGUMENT},
        {"1048576x1048576x1048576x1048576,f64", "more than", VV_E_FORMAT},
        {"99999999999999999999x1x1,u8", "dims", VV_E_ARGUMENT},
    };
    const char *path = io_path(state, "lie.raw");
    uint8_t bytes[64] = {0};
    io_put(path, bytes, sizeof bytes);
    for (size_t c = 0; c < sizeof cases / sizeof *cases; c++) {
        vv_read_options options;
        vv_file *file;
        vv_read_options_init(&options, sizeof options);
        options.raw = cases[c].layout;
        const vv_status st = vv_file_open(&file, path, &options, NULL);
        if (st != cases[c].status || !strstr(vv_error_last()->message, cases[c].words))
            fail_msg("'%s': %s, %s", cases[c].layout, vv_status_name(st), vv_error_last()->message);
    }
}

/* Bombs -------------------------------------------------------------------------------------------------------------
 */

enum { MEBIBYTE = 1 << 20, PACKED_ROOM = 1 << 12 };

/* A mebibyte of zeros, packed so that it can stand in a stream any number of times: how many bytes that are, and the
 * checksum of the zeros. */
static size_t pack_zeros(uint8_t packed[PACKED_ROOM], uLong *crc)
{
    z_stream z = {0};
    uint8_t *zeros = calloc(1, MEBIBYTE);
    assert_non_null(zeros);
    assert_int_equal(deflateInit2(&z, 9, Z_DEFLATED, -MAX_WBITS, 9, Z_DEFAULT_STRATEGY), Z_OK);
    z.next_in = zeros;
    z.avail_in = MEBIBYTE;
    z.next_out = packed;
    z.avail_out = PACKED_ROOM;
    assert_int_equal(deflate(&z, Z_FULL_FLUSH), Z_OK);
    assert_true(z.avail_in == 0 && z.avail_out > 0);
    deflateEnd(&z);
    *crc = crc32(0, zeros, MEBIBYTE);
    free(zeros);
    return PACKED_ROOM - z.avail_out;
}

/* One gzip stream of so many zeros; packing them all takes longer than all that is tested. */
static void write_gzip_of_zeros(vv_sink *sink, int mebibytes)
{
    static const uint8_t head[] = {0x1f, 0x8b, 8, 0, 0, 0, 0, 0, 2, 255}, last[] = {3, 0};
    uint8_t packed[PACKED_ROOM];
    uLong one, all = 0;
    const size_t n = pack_zeros(packed, &one);
    io_ok(vvi_sink_write(sink, head, sizeof head));
    for (int i = 0; i < mebibytes; i++) {
        io_ok(vvi_sink_write(sink, packed, n));
        all = crc32_combine(all, one, MEBIBYTE);
    }
    const uint32_t tail[] = {(uint32_t)all, (uint32_t)mebibytes << 20}; /* of a little-endian machine */
    io_ok(vvi_sink_write(sink, last, sizeof last));
    io_ok(vvi_sink_write(sink, tail, sizeof tail));
}

/* The header and a gzip stream of zeros, in another one. */
static void write_nested_bomb(const char *path, const char *header, int mebibytes)
{
    vv_sink *sink;
    io_ok(vvi_sink_open(&sink, path, NULL));
    io_ok(vvi_sink_coding(sink, VVI_CODING_GZIP, 9));
    io_ok(vvi_sink_write(sink, header, strlen(header)));
    write_gzip_of_zeros(sink, mebibytes);
    io_ok(vvi_sink_commit(sink));
}

static void write_bomb(const char *path, const char *header, int mebibytes)
{
    vv_sink *sink;
    uint8_t *zeros = calloc(1, MEBIBYTE);
    io_ok(vvi_sink_open(&sink, path, NULL));
    io_ok(vvi_sink_coding(sink, VVI_CODING_GZIP, 9));
    io_ok(vvi_sink_write(sink, header, strlen(header)));
    for (int i = 0; i < mebibytes; i++)
        io_ok(vvi_sink_write(sink, zeros, MEBIBYTE));
    io_ok(vvi_sink_commit(sink));
    free(zeros);
}

static void bombs_stop_at_the_cap_in_little_memory(void **state)
{
    /* a header that wants a little, and a gzip stream in a gzip stream that would give hundreds of megabytes */
    static const char lines[] = "NRRD0004\ntype: uchar\ndimension: 1\nsizes: 1\nline skip: 3\nencoding: raw\n\n";
    static const char wants[] = "NRRD0004\ntype: uchar\ndimension: 3\nsizes: 1024 1024 600\nencoding: gzip\n\n";
    const char *path = io_path(state, "lines.nrrd.gz");
    write_bomb(path, lines, 64);
    refused_in_little_memory(path, VV_E_FORMAT, "line");
    path = io_path(state, "nested.nrrd.gz");
    write_nested_bomb(path, wants, 600);
    refused_in_little_memory(path, VV_E_FORMAT, "can hold at most");
}

static void a_long_header_and_too_many_keys_do_not_grow_without_end(void **state)
{
    enum { KEYS = 200000 };
    char *text = malloc(KEYS * 16 + 200), *at = text;
    at += sprintf(at, "NRRD0004\ntype: uchar\ndimension: 1\nsizes: 1\nencoding: raw\n");
    for (int i = 0; i < KEYS; i++)
        at += sprintf(at, "k%d:=v\n", i);
    at += sprintf(at, "\nx");
    const char *path = io_path(state, "keys.nrrd");
    io_put(path, text, (size_t)(at - text));
    vv_file *file = io_open(path);
    const char *key, *value;
    assert_true(vv_file_metadata(file, 65535, &key, &value));
    assert_false(vv_file_metadata(file, 65536, &key, &value));
    assert_non_null(strstr(vv_file_warning(file, 0), "more metadata"));
    vv_file_close(file);
    free(text);
    char *comment = malloc((17 << 20) + 100);
    at = comment + sprintf(comment, "NRRD0004\n");
    for (int i = 0; i < 17 * 1024; i++) {
        memset(at, '#', 1023);
        at[1023] = '\n';
        at += 1024;
    }
    io_put(path, comment, (size_t)(at - comment));
    refused_in_little_memory(path, VV_E_FORMAT, "header has more than");
    free(comment);
}

/* Memory ------------------------------------------------------------------------------------------------------------
 */

static void a_volume_past_the_memory_limit_is_refused_before_it_is_read(void **state)
{
    vv_job *job = test_job(1, 8 << 20);
    vv_field_info info = vv_field_info_default();
    info.grid.dims[0] = info.grid.dims[1] = info.grid.dims[2] = 256;
    vv_field *field = test_field(&test_form_constant, &info, NULL), *read = NULL;
    const char *path = io_path(state, "large.nrrd");
    io_write(path, field, "gzip", false);
    vv_field_release(field);
    vv_file *file;
    io_ok(vv_file_open(&file, path, NULL, job));
    assert_int_equal(vv_file_read(&read, file, 0, NULL, job), VV_E_LIMIT);
    assert_null(read);
    const vv_box part = {{0, 0, 3}, {256, 256, 1}};
    io_ok(vv_file_read(&read, file, 0, &part, job));
    vv_field_release(read);
    vv_file_close(file);
    assert_true(vv_runtime_memory_used(vv_job_runtime(job)) == 0);
    vv_job_release(job);
}

typedef struct acting {
    char path[4096], out[4096];
    vv_field *field;
} acting;

static vv_status act_read(void *user)
{
    vv_field_info info;
    return read_all(((acting *)user)->path, &info);
}

static vv_status act_write(void *user)
{
    acting *a = user;
    const vv_field *frames[] = {a->field};
    return vv_field_write(a->out, frames, 1, NULL, NULL);
}

static void every_failing_allocation_of_reading_and_writing_is_an_error_without_a_leak(void **state)
{
    vv_field_info info = vv_field_info_default();
    info.grid.dims[0] = 4;
    info.value_scale = 2;
    strcpy(info.value_unit, "HU");
    acting a = {.field = test_field_random(&info, 1, NULL)};
    for (size_t s = 0; s < N_SEEDS; s++) {
        size_t n;
        free(make_seed(state, &seeds[s], &n));
        snprintf(a.path, sizeof a.path, "%s", io_path(state, seeds[s].name));
        snprintf(a.out, sizeof a.out, "%s", io_path(state, seeds[s].name));
        assert_true(test_fail_each_alloc(act_read, &a) > 3);
        assert_true(test_fail_each_alloc(act_write, &a) > 3);
    }
    snprintf(a.out, sizeof a.out, "%s", io_path(state, "detached.nhdr"));
    assert_true(test_fail_each_alloc(act_write, &a) > 3);
    snprintf(a.out, sizeof a.out, "%s", io_path(state, "pair.hdr"));
    assert_true(test_fail_each_alloc(act_write, &a) > 3);
    snprintf(a.path, sizeof a.path, "%s", io_path(state, "detached.nhdr"));
    assert_true(test_fail_each_alloc(act_read, &a) > 3);
    snprintf(a.path, sizeof a.path, "%s", io_path(state, "pair.hdr"));
    assert_true(test_fail_each_alloc(act_read, &a) > 3);
    vv_field_release(a.field);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_truncation_is_one_clear_sentence),
        cmocka_unit_test(mutations_are_read_or_refused),
        cmocka_unit_test(each_lie_of_a_nifti_header_is_refused),
        cmocka_unit_test(a_nifti_of_377_bytes_that_asks_for_18_gigabytes_is_refused_at_once),
        cmocka_unit_test(a_nifti_2_of_540_bytes_with_200_axes_is_refused),
        cmocka_unit_test(each_lie_of_a_nrrd_header_is_refused),
        cmocka_unit_test(each_lie_of_an_npy_header_is_refused),
        cmocka_unit_test(raw_layouts_that_lie_or_are_not_understood_are_refused),
        cmocka_unit_test(bombs_stop_at_the_cap_in_little_memory),
        cmocka_unit_test(a_long_header_and_too_many_keys_do_not_grow_without_end),
        cmocka_unit_test(a_volume_past_the_memory_limit_is_refused_before_it_is_read),
        cmocka_unit_test(every_failing_allocation_of_reading_and_writing_is_an_error_without_a_leak),
    };
    return cmocka_run_group_tests(tests, io_setup, io_teardown);
}
