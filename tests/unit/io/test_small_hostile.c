/* Truncated and changed files of the formats that are read only, or whose samples lie beside their header: refused in
 * one sentence, or read with the right dims; every failing allocation too. */
#include "fail_alloc.h"
#include "fields.h"
#include "io_test.h"

static const uint8_t dds[] = {
    68,  68, 83,  32,  118, 51,  100, 10,  0,   1,   5,   125, 8,   103, 118, 85, 138, 182, 89, 200, 139,
    161, 92, 182, 241, 114, 145, 118, 232, 198, 225, 34,  28,  86,  107, 189, 6,  234, 48,  32, 14,  129,
    0,   86, 129, 3,   148, 1,   208, 32,  64,  129, 200, 78,  128, 58,  4,   8,  16,  57,  64, 28,  0,
};
static const char slc[] = "11111\n5 3 2 8\n1 1 1\n1 6 0 1\n1 1 Xabc17 X\x8f"
                          "123456789abcdef\0"
                          "5 X\x0a\1\5\2\0";
static const char inr[] = "#INRIMAGE-4#{\nXDIM=5\nYDIM=3\nZDIM=2\nTYPE=unsigned fixed\nPIXSIZE=8 bits\nCPU=pc\n";

typedef struct seed {
    const char *name, *text;
    const void *bytes; /* instead of text */
    size_t n;
    const char *beside;
    size_t slack; /* what may be cut without a word: the header's last letters */
} seed;

static const seed seeds[] = {
    {"s.mhd",
     "ObjectType = Image\nNDims = 3\nDimSize = 5 3 2\nOffset = 1 2 3\nElementSpacing = 1 2 3\nTransformMatrix = "
     "1 0 0 0 1 0 0 0 1\nCompressedData = False\nElementType = MET_UCHAR\nElementDataFile = data.raw\n",
     NULL, 0, "data.raw", 1},
    {"s.mhd", "NDims = 3\nDimSize = 5 3 2\nElementType = MET_UCHAR\nElementDataFile = LIST\np1\np2\n", NULL, 0, "p1",
     8},
    {"s.vvh", "dims: 5 3 2\ntype: u8\nspacing: 1 2 3\nunit: mm\ndirections: 1 0 0 0 1 0 0 0 1\ndata: data.raw\n", NULL,
     0, "data.raw", 1},
    {"s.dat", "Resolution: 5 3 2\nSliceThickness: 1 2 3\nFormat: UCHAR\nObjectFileName: data.raw\n", NULL, 0,
     "data.raw", 1},
    {"s.pvm", NULL, dds, sizeof dds, NULL, 1},
    {"s.pvm", NULL, "PVM2\n5 3 2\n1 1 2\n1\n123456789012345678901234567890", 49, NULL, 0},
    {"s.slc", NULL, slc, sizeof slc - 1, NULL, 1},
    {"s.inr", NULL, NULL, 286, NULL, 0},
    {"s.hdr", NULL, NULL, 348, "s.img", 0},
};
#define N_SEEDS (sizeof seeds / sizeof *seeds)

static void fill_analyze(uint8_t *out)
{
    static const int16_t dim[8] = {4, 5, 3, 2, 1, 0, 0, 0};
    const int32_t size = 348;
    const float step[4] = {0, 1, 2, 3};
    memset(out, 0, 348);
    memcpy(out, &size, 4);
    memcpy(out + 40, dim, 16);
    out[70] = 2;
    out[72] = 8;
    memcpy(out + 76, step, 16);
}

/* The seed's bytes, yours to free(), and what lies beside it. */
static uint8_t *make_seed(void **state, const seed *s, size_t *n)
{
    *n = s->text ? strlen(s->text) : s->n;
    uint8_t *bytes = calloc(*n + 1, 1);
    assert_non_null(bytes);
    if (s->text || s->bytes) {
        memcpy(bytes, s->text ? (const void *)s->text : s->bytes, *n);
    } else if (strcmp(s->name, "s.hdr") == 0) {
        fill_analyze(bytes);
    } else {
        memset(bytes, '\n', 256);
        memcpy(bytes, inr, strlen(inr));
        memcpy(bytes + 252, "##}\n", 4);
    }
    if (s->beside) {
        static const char samples[30] = "abcdefghijklmnopqrstuvwxyz0123";
        io_put(io_path(state, s->beside), samples, strcmp(s->beside, "p1") == 0 ? 15 : 30);
        io_put(io_path(state, "p2"), samples + 15, 15);
    }
    return bytes;
}

static vv_status read_all(const char *path, vv_field_info *info_out, vv_job *job)
{
    vv_file *file;
    vv_field *field;
    vv_status st = vv_file_open(&file, path, NULL, job);
    if (st != VV_OK)
        return st;
    *info_out = *vv_file_info(file);
    if ((st = vv_file_read(&field, file, 0, NULL, job)) == VV_OK)
        vv_field_release(field);
    vv_file_close(file);
    return st;
}

static void every_truncation_is_refused_or_known_to_be_damaged(void **state)
{
    for (size_t s = 0; s < N_SEEDS; s++) {
        size_t n;
        uint8_t *bytes = make_seed(state, &seeds[s], &n);
        const char *path = io_path(state, seeds[s].name);
        char kept_path[4096];
        snprintf(kept_path, sizeof kept_path, "%s", path);
        for (size_t keep = 0; keep <= n; keep++) {
            vv_field_info info = {0};
            vv_job *job;
            io_put(kept_path, bytes, keep);
            io_ok(vv_job_new(&job, NULL, NULL, NULL));
            const vv_status st = read_all(kept_path, &info, job);
            const bool damaged = vv_job_damaged(job);
            vv_job_release(job);
            if (st == VV_OK && (info.grid.dims[0] != 5 || info.grid.dims[1] != 3 || info.grid.dims[2] != 2))
                fail_msg("%s: %zu of %zu bytes are read as another size", kept_path, keep, n);
            if (st == VV_OK && !damaged && keep + seeds[s].slack < n)
                fail_msg("%s (%zu): %zu of %zu bytes are read as a whole file", kept_path, s, keep, n);
            if (st == VV_OK && damaged && keep == n)
                fail_msg("%s (%zu): a whole file is called damaged", kept_path, s);
            if (st != VV_OK && (strchr(vv_error_last()->message, '\n') || keep == n))
                fail_msg("%s: %s", kept_path, vv_error_last()->message);
        }
        free(bytes);
    }
}

static void changed_files_are_read_or_refused(void **state)
{
    const uint64_t random = test_seed();
    uint64_t next = 0;
    for (size_t s = 0; s < N_SEEDS; s++) {
        size_t n;
        uint8_t *bytes = make_seed(state, &seeds[s], &n), *mutant = malloc(n);
        char path[4096];
        snprintf(path, sizeof path, "%s", io_path(state, seeds[s].name));
        for (int m = 0; m < 2000; m++) {
            vv_field_info info = {0};
            memcpy(mutant, bytes, n);
            for (int changes = 1 + (int)(test_random(random, next++) % 4); changes > 0; changes--) {
                const size_t at = test_random(random, next++) % n;
                const uint64_t how = test_random(random, next++);
                mutant[at] = (uint8_t)(how & 1 ? mutant[at] ^ UINT64_C(1) << (how >> 8) % 8 : how >> 8);
            }
            io_put(path, mutant, n);
            const vv_status st = read_all(path, &info, NULL);
            if (st == VV_OK)
                assert_true(info.grid.dims[0] >= 1 && info.grid.dims[1] >= 1 && info.grid.dims[2] >= 1);
            else
                assert_true(vv_error_last()->message[0] && st != VV_E_INTERNAL);
        }
        free(mutant);
        free(bytes);
    }
}

static vv_status act_read(void *user)
{
    vv_field_info info;
    return read_all(user, &info, NULL);
}

static void every_failing_allocation_is_an_error_without_a_leak(void **state)
{
    for (size_t s = 0; s < N_SEEDS; s++) {
        size_t n;
        char path[4096];
        uint8_t *bytes = make_seed(state, &seeds[s], &n);
        snprintf(path, sizeof path, "%s", io_path(state, seeds[s].name));
        io_put(path, bytes, n);
        free(bytes);
        assert_true(test_fail_each_alloc(act_read, path) > 3);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_truncation_is_refused_or_known_to_be_damaged),
        cmocka_unit_test(changed_files_are_read_or_refused),
        cmocka_unit_test(every_failing_allocation_is_an_error_without_a_leak),
    };
    return cmocka_run_group_tests(tests, io_setup, io_teardown);
}
