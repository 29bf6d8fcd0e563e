/* Zarr folders that lie, are cut short or mutated: one sentence, at once, in little memory; never a crash. */
#include "core/memory.h"
#include "fail_alloc.h"
#include "fields.h"
#include "io_test.h"
#include "jobs.h"
#include <time.h>
#include <zlib.h>

/* A folder of the test's, with its parents. */
static void make_folder(void **state, const char *name)
{
    char path[4096];
    snprintf(path, sizeof path, "%s", io_path(state, name));
    for (char *at = path + strlen(*state) + 1; (at = strchr(at, '/')) != NULL; *at++ = '/') {
        *at = 0;
        mkdir(path, 0755);
    }
    mkdir(path, 0755);
}

static void put_text(void **state, const char *name, const char *text)
{
    io_put_text(io_path(state, name), text);
}

/* Seeds ----------------------------------------------------------------------------------------------------------- */

#define V2(more)                                                                                                       \
    "{\"zarr_format\":2,\"shape\":[4,3,5],\"chunks\":[4,3,5],\"dtype\":\"<u2\",\"order\":\"C\",\"fill_value\":0," more \
    "}"
#define V3_HEAD "{\"zarr_format\":3,\"node_type\":\"array\",\"shape\":[4,3,5],\"data_type\":\"uint16\","
#define V3_TAIL                                                                                                        \
    "\"chunk_key_encoding\":{\"name\":\"default\",\"configuration\":{\"separator\":\"/\"}},\"fill_value\":0,"          \
    "\"chunk_grid\":{\"name\":\"regular\",\"configuration\":{\"chunk_shape\":[4,3,5]}}}"
#define BYTES "{\"name\":\"bytes\",\"configuration\":{\"endian\":\"little\"}}"
#define GOOD_V3 V3_HEAD "\"codecs\":[" BYTES "]," V3_TAIL

static const char raw_v2[] = V2("\"filters\":null,\"compressor\":null");
static const char zlib_v2[] = V2("\"filters\":[{\"id\":\"delta\",\"dtype\":\"<u2\"}],\"compressor\":{\"id\":\"zlib\"}");
static const char gzip_v3[] =
    V3_HEAD "\"codecs\":[{\"name\":\"transpose\",\"configuration\":{\"order\":[2,0,1]}}," BYTES
            ",{\"name\":\"gzip\",\"configuration\":{\"level\":1}}]," V3_TAIL;
static const char shard_v3[] =
    V3_HEAD "\"codecs\":[{\"name\":\"sharding_indexed\",\"configuration\":{\"chunk_shape\":[2,3,5],\"codecs\":[" BYTES
            "],\"index_codecs\":[" BYTES "],\"index_location\":\"end\"}}]," V3_TAIL;
static const char ome_v3[] =
    "{\"zarr_format\":3,\"node_type\":\"group\",\"attributes\":{\"ome\":{\"version\":\"0.5\",\"multiscales\":[{"
    "\"axes\":"
    "[{\"name\":\"z\",\"type\":\"space\",\"unit\":\"micrometer\"},{\"name\":\"y\",\"type\":\"space\"},{\"name\":\"x\","
    "\"type\":\"space\"}],\"datasets\":[{\"path\":\"0\",\"coordinateTransformations\":[{\"type\":\"scale\",\"scale\":"
    "[1,2,3]}]}]}],\"omero\":{\"channels\":[{\"label\":\"a\",\"color\":\"FF0000\",\"window\":{\"start\":0,\"end\":9}}]}"
    ","
    "\"image-label\":{\"colors\":[{\"label-value\":1,\"rgba\":[1,2,3,4]}],\"properties\":[{\"label-value\":1,\"name\":"
    "\"b\"}]}}}}";

typedef struct seed {
    const char *folder; /* of the array, in the test's folder */
    const char *meta;   /* name of its metadata */
    const char *text;
    const char *chunk; /* name of its only chunk */
    int coding;        /* of the chunk: 0 raw, 1 zlib, 2 gzip, 3 a shard */
} seed;

static const seed seeds[] = {
    {"raw.zarr", ".zarray", raw_v2, "0.0.0", 0},
    {"zlib.zarr", ".zarray", zlib_v2, "0.0.0", 1},
    {"gzip.zarr", "zarr.json", gzip_v3, "c/0/0/0", 2},
    {"shard.zarr", "zarr.json", shard_v3, "c/0/0/0", 3},
};
#define N_SEEDS (sizeof seeds / sizeof *seeds)

static size_t make_chunk(uint8_t out[512], int coding)
{
    uint8_t plain[120];
    for (size_t i = 0; i < sizeof plain; i++)
        plain[i] = (uint8_t)(i * 7 % 31);
    memcpy(out, plain, sizeof plain);
    if (coding == 0)
        return sizeof plain;
    if (coding == 3) {
        const uint64_t index[4] = {0, 60, 60, 60}; /* little-endian machines */
        memcpy(out + sizeof plain, index, sizeof index);
        return sizeof plain + sizeof index;
    }
    z_stream z = {.next_in = plain, .avail_in = sizeof plain, .next_out = out, .avail_out = 512};
    assert_int_equal(deflateInit2(&z, 6, Z_DEFLATED, coding == 1 ? 15 : 31, 8, Z_DEFAULT_STRATEGY), Z_OK);
    assert_int_equal(deflate(&z, Z_FINISH), Z_STREAM_END);
    const size_t n = z.total_out;
    deflateEnd(&z);
    return n;
}

static void in_folder(char out[4096], void **state, const seed *s, const char *name)
{
    char whole[256];
    snprintf(whole, sizeof whole, "%s/%s", s->folder, name);
    snprintf(out, 4096, "%s", io_path(state, whole));
}

/* The folder with its metadata and chunk; *n_out bytes of chunk. */
static void make_seed(void **state, const seed *s, uint8_t chunk[512], size_t *n_out)
{
    char path[4096], folder[300];
    snprintf(folder, sizeof folder, "%s/c/0/0", s->folder);
    make_folder(state, s->chunk[0] == 'c' ? folder : s->folder);
    in_folder(path, state, s, s->meta);
    io_put_text(path, s->text);
    in_folder(path, state, s, s->chunk);
    *n_out = make_chunk(chunk, s->coding);
    io_put(path, chunk, *n_out);
}

static vv_status read_in(const char *path, vv_field_info *info, vv_job *job)
{
    vv_file *file;
    vv_status st = vv_file_open(&file, path, NULL, job);
    if (st != VV_OK)
        return st;
    *info = *vv_file_info(file);
    for (int64_t f = 0; f < info->n_frames && f < 3 && st == VV_OK; f++) {
        vv_field *field = NULL;
        st = vv_file_read(&field, file, f, NULL, job);
        assert_true((st == VV_OK) == (field != NULL));
        vv_field_release(field);
    }
    vv_file_close(file);
    return st;
}

static void expect_sentence(vv_status st)
{
    if (st == VV_OK)
        return;
    assert_int_equal(vv_error_last()->status, st);
    assert_true(vv_error_last()->message[0]);
    assert_null(strchr(vv_error_last()->message, '\n'));
    assert_int_not_equal(st, VV_E_INTERNAL);
}

static void seeds_are_read(void **state)
{
    uint8_t chunk[512];
    size_t n;
    for (size_t s = 0; s < N_SEEDS; s++) {
        vv_field_info info;
        make_seed(state, &seeds[s], chunk, &n);
        io_ok(read_in(io_path(state, seeds[s].folder), &info, NULL));
        assert_int_equal(info.grid.dims[0] * 100 + info.grid.dims[1] * 10 + info.grid.dims[2], 534);
    }
}

/* Metadata that lies ---------------------------------------------------------------------------------------------- */

typedef struct lie {
    const char *from, *to; /* in the seed's text */
    vv_status status;
    const char *words;
} lie;

static const lie lies_v2[] = {
    {"\"zarr_format\":2", "\"zarr_format\":4", VV_E_FORMAT, "'zarr_format' is not 2"},
    {"\"shape\":[4,3,5]", "\"shape\":[]", VV_E_UNSUPPORTED, "no axes"},
    {"\"shape\":[4,3,5]", "\"shape\":[4,-3,5]", VV_E_FORMAT, "entry 2 of 'shape'"},
    {"\"shape\":[4,3,5]", "\"shape\":[4,0,5]", VV_E_FORMAT, "entry 2 of 'shape'"},
    {"\"shape\":[4,3,5]", "\"shape\":[4,3.5,5]", VV_E_FORMAT, "entry 2 of 'shape'"},
    {"\"shape\":[4,3,5]", "\"shape\":[4,1e300,5]", VV_E_FORMAT, "entry 2 of 'shape'"},
    {"\"shape\":[4,3,5]", "\"shape\":[4,999999999999999999999,5]", VV_E_FORMAT, "entry 2 of 'shape'"},
    {"\"shape\":[4,3,5]", "\"shape\":[1,2,3,4,5,6,7,8,9]", VV_E_UNSUPPORTED, "9 axes"},
    {"\"shape\":[4,3,5]", "\"shape\":[4,3]", VV_E_FORMAT, "2 axes but its 'chunks' 3"},
    {"\"shape\":[4,3,5]", "\"shape\":[2000000000,2000000000,2000000000]", VV_E_FORMAT, "samples"},
    {"\"shape\":[4,3,5]", "\"shape\":[1000000,1000000,1000]", VV_E_FORMAT, "voxels"},
    {"\"shape\":[4,3,5]", "\"shape\":[10000,1000,1000]", VV_E_LIMIT, "volume"},
    {"\"shape\":[4,3,5]", "\"shop\":[4,3,5]", VV_E_FORMAT, "'shape'"},
    {"\"chunks\":[4,3,5]", "\"chunks\":[2000000000,2000000000,2000000000]", VV_E_FORMAT, "chunks of more than"},
    {"\"chunks\":[4,3,5]", "\"chunks\":[1000000,1000000,1000]", VV_E_LIMIT, "chunk"},
    {"\"chunks\":[4,3,5]", "\"chunks\":[0,3,5]", VV_E_FORMAT, "entry 1 of 'chunks'"},
    {"\"chunks\":[4,3,5]", "\"chunks\":[4,3,4]", VV_E_FORMAT, "expected"},
    {"<u2", "<c8", VV_E_UNSUPPORTED, "'<c8'"},
    {"<u2", "|V2", VV_E_UNSUPPORTED, "'|V2'"},
    {"\"<u2\"", "[[\"a\",\"<u2\"]]", VV_E_UNSUPPORTED, "structures"},
    {"\"<u2\"", "7", VV_E_FORMAT, "'dtype'"},
    {"<u2", "<u4", VV_E_FORMAT, "holds 120 bytes; 240 were expected"},
    {"\"order\":\"C\"", "\"order\":\"D\"", VV_E_FORMAT, "'order'"},
    {"\"fill_value\":0", "\"fill_value\":70000", VV_E_FORMAT, "'fill_value'"},
    {"\"fill_value\":0", "\"fill_value\":\"NaN\"", VV_E_FORMAT, "'fill_value'"},
    {"\"fill_value\":0", "\"fill_value\":{}", VV_E_FORMAT, "'fill_value'"},
    {"\"compressor\":null", "\"compressor\":{\"id\":\"zfpy\"}", VV_E_UNSUPPORTED, "'zfpy'"},
    {"\"compressor\":null", "\"compressor\":{}", VV_E_FORMAT, "'compressor' has no 'id'"},
    {"\"compressor\":null", "\"compressor\":{\"id\":\"gzip\"}", VV_E_FORMAT, "damaged"},
    {"\"filters\":null", "\"filters\":[{\"id\":\"categorize\"}]", VV_E_UNSUPPORTED, "'categorize'"},
    {"\"filters\":null", "\"filters\":[{}]", VV_E_FORMAT, "filter 1"},
    {"\"filters\":null", "\"filters\":[{\"id\":\"delta\",\"dtype\":\"M8\"}]", VV_E_UNSUPPORTED, "delta"},
    {"\"filters\":null", "\"filters\":[{\"id\":\"shuffle\",\"elementsize\":0}]", VV_E_FORMAT, "elementsize"},
    {"\"filters\":null", "\"dimension_separator\":\"-\"", VV_E_FORMAT, "'dimension_separator'"},
};

static const lie lies_v3[] = {
    {"\"node_type\":\"array\"", "\"node_type\":\"tree\"", VV_E_FORMAT, "'node_type'"},
    {"uint16", "complex64", VV_E_UNSUPPORTED, "'complex64'"},
    {"\"regular\"", "\"rectangular\"", VV_E_UNSUPPORTED, "'rectangular'"},
    {"\"default\"", "\"hash\"", VV_E_UNSUPPORTED, "'hash'"},
    {"\"separator\":\"/\"", "\"separator\":\"\"", VV_E_FORMAT, "separator"},
    {BYTES, "", VV_E_FORMAT, "none of its codecs makes bytes"},
    {"\"little\"", "\"middle\"", VV_E_FORMAT, "'endian'"},
    {"\"configuration\":{\"endian\":\"little\"}", "\"a\":1", VV_E_FORMAT, "'endian'"},
    {BYTES, BYTES "," BYTES, VV_E_UNSUPPORTED, "'bytes'"},
    {BYTES, "{\"name\":\"transpose\",\"configuration\":{\"order\":[0,0,1]}}," BYTES, VV_E_FORMAT, "transpose"},
    {BYTES, "{\"name\":\"transpose\",\"configuration\":{\"order\":[0,1,3]}}," BYTES, VV_E_FORMAT, "transpose"},
    {BYTES, "{}", VV_E_FORMAT, "codec 1 has no name"},
    {"\"fill_value\":0,", "\"storage_transformers\":[{\"name\":\"a\"}],", VV_E_UNSUPPORTED, "storage transformers"},
    {"\"fill_value\":0,", "\"cloud\":{\"must_understand\":true},", VV_E_UNSUPPORTED, "'cloud'"},
    {"{\"zarr_format\"",
     "{\"a\":[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[1]]]]]]]]]]]]]]]]]]]]]]]]]]]]"
     "]]]]]]]]]]]]]]]]]]]]]]]]]]]]]]]]]]]]],\"zarr_format\"",
     VV_E_LIMIT, "nested"},
    {"{\"zarr_format\"", "[{\"zarr_format\"", VV_E_FORMAT, "JSON"},
};

static const lie lies_shard[] = {
    {"[2,3,5]", "[3,3,5]", VV_E_FORMAT, "evenly"},
    {"[2,3,5]", "[2,3]", VV_E_FORMAT, "2 axes"},
    {"[2,3,5]", "[1,1,1]", VV_E_FORMAT, "index"},
    {"\"end\"", "\"middle\"", VV_E_FORMAT, "index_location"},
    {"\"end\"", "\"start\"", VV_E_FORMAT, "index"},
    {"\"index_codecs\":[" BYTES "]", "\"index_codecs\":[]", VV_E_FORMAT, "index_codecs"},
    {"\"index_codecs\":[" BYTES "]", "\"index_codecs\":[{\"name\":\"gzip\"}]", VV_E_UNSUPPORTED, "'gzip'"},
    {"\"index_codecs\":[" BYTES "]", "\"index_codecs\":[" BYTES ",{\"name\":\"crc32c\"}]", VV_E_FORMAT, "crc32c"},
};

static void check_lies(void **state, const seed *s, const char *text, const lie *lies, size_t n_lies)
{
    uint8_t chunk[512];
    size_t n;
    char path[4096], told[4096];
    vv_job *job = test_job(2, 64 << 20);
    make_seed(state, s, chunk, &n);
    in_folder(path, state, s, s->meta);
    for (size_t i = 0; i < n_lies; i++) {
        vv_field_info info;
        const char *at = strstr(text, lies[i].from);
        assert_non_null(at);
        snprintf(told, sizeof told, "%.*s%s%s", (int)(at - text), text, lies[i].to, at + strlen(lies[i].from));
        io_put_text(path, told);
        const vv_status st = read_in(io_path(state, s->folder), &info, job);
        if (st != lies[i].status || !strstr(vv_error_last()->message, lies[i].words))
            fail_msg("%s: status %s, '%s'; expected '%s'", lies[i].to, vv_status_name(st),
                     st == VV_OK ? "" : vv_error_last()->message, lies[i].words);
        expect_sentence(st);
    }
    vv_job_release(job);
}

static void each_lie_of_metadata_has_its_sentence(void **state)
{
    static const seed good_v3 = {"good.zarr", "zarr.json", GOOD_V3, "c/0/0/0", 0};
    check_lies(state, &seeds[0], raw_v2, lies_v2, sizeof lies_v2 / sizeof *lies_v2);
    check_lies(state, &good_v3, GOOD_V3, lies_v3, sizeof lies_v3 / sizeof *lies_v3);
    check_lies(state, &seeds[3], shard_v3, lies_shard, sizeof lies_shard / sizeof *lies_shard);
}

static void a_volume_of_too_many_chunks_is_refused_at_once(void **state)
{
    vv_job *job = test_job(2, UINT64_C(8) << 30);
    vv_field_info info;
    make_folder(state, "many.zarr");
    put_text(state, "many.zarr/.zarray",
             "{\"zarr_format\":2,\"shape\":[1000,1000,1000],\"chunks\":[1,1,1],\"dtype\":\"|u1\",\"order\":\"C\","
             "\"fill_value\":0,\"filters\":null,\"compressor\":null}");
    assert_int_equal(read_in(io_path(state, "many.zarr"), &info, job), VV_E_LIMIT);
    assert_non_null(strstr(vv_error_last()->message, "chunks"));
    vv_job_release(job);
}

/* Cut short and mutated ------------------------------------------------------------------------------------------- */

static void every_truncation_is_refused_or_told(void **state)
{
    uint8_t chunk[512];
    size_t n;
    char path[4096];
    for (size_t s = 0; s < N_SEEDS; s++) {
        vv_field_info info;
        make_seed(state, &seeds[s], chunk, &n);
        in_folder(path, state, &seeds[s], seeds[s].meta);
        for (size_t keep = 0; keep < strlen(seeds[s].text); keep++) {
            io_put(path, seeds[s].text, keep);
            const vv_status st = read_in(io_path(state, seeds[s].folder), &info, NULL);
            expect_sentence(st);
            assert_int_not_equal(st, VV_OK);
        }
        io_put_text(path, seeds[s].text);
        in_folder(path, state, &seeds[s], seeds[s].chunk);
        for (size_t keep = 0; keep < n; keep++) {
            io_put(path, chunk, keep);
            const vv_status st = read_in(io_path(state, seeds[s].folder), &info, NULL);
            expect_sentence(st);
            assert_int_not_equal(st, VV_OK);
        }
    }
}

/* A copy of bytes with a few of them changed. */
static void mutate(uint8_t *out, const void *bytes, size_t n, uint64_t random, uint64_t *next)
{
    memcpy(out, bytes, n);
    for (int changes = 1 + (int)(test_random(random, (*next)++) % 4); changes > 0; changes--) {
        const size_t at = test_random(random, (*next)++) % n;
        const uint64_t how = test_random(random, (*next)++);
        out[at] = (uint8_t)(how & 1 ? out[at] ^ UINT64_C(1) << (how >> 8) % 8 : how >> 8);
    }
}

static void read_mutant(const char *path, vv_job *job)
{
    struct timespec begin, end;
    vv_field_info info;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &begin);
    const vv_status st = read_in(path, &info, job);
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &end);
    assert_true(end.tv_sec - begin.tv_sec <= 10);
    expect_sentence(st);
    if (st == VV_OK)
        assert_true(info.grid.dims[0] >= 1 && info.grid.dims[1] >= 1 && info.grid.dims[2] >= 1);
}

static void mutations_are_read_or_refused(void **state)
{
    const uint64_t random = test_seed();
    uint64_t next = 0;
    uint8_t chunk[512], mutant[2048];
    size_t n;
    char path[4096];
    vv_job *job = test_job(1, 64 << 20);
    for (size_t s = 0; s < N_SEEDS; s++)
        for (int m = 0; m < 1500; m++) {
            make_seed(state, &seeds[s], chunk, &n);
            in_folder(path, state, &seeds[s], m % 2 ? seeds[s].meta : seeds[s].chunk);
            const size_t bytes = m % 2 ? strlen(seeds[s].text) : n;
            mutate(mutant, m % 2 ? (const void *)seeds[s].text : chunk, bytes, random, &next);
            io_put(path, mutant, bytes);
            read_mutant(io_path(state, seeds[s].folder), job);
        }
    make_folder(state, "ome.zarr/0/c/0/0");
    put_text(state, "ome.zarr/0/zarr.json", GOOD_V3);
    for (int m = 0; m < 2000; m++) {
        mutate(mutant, ome_v3, sizeof ome_v3 - 1, random, &next);
        io_put(io_path(state, "ome.zarr/zarr.json"), mutant, sizeof ome_v3 - 1);
        read_mutant(io_path(state, "ome.zarr"), job);
    }
    vv_job_release(job);
}

/* Memory ---------------------------------------------------------------------------------------------------------- */

typedef struct reading {
    const char *path;
    vv_job *job;
} reading;

static vv_status act(void *user)
{
    vv_field_info info;
    const reading *r = user;
    return read_in(r->path, &info, r->job);
}

static void every_allocation_may_fail(void **state)
{
    uint8_t chunk[512];
    size_t n;
    vv_job *job = test_job(1, 0);
    for (size_t s = 0; s < N_SEEDS; s++) {
        make_seed(state, &seeds[s], chunk, &n);
        reading r = {io_path(state, seeds[s].folder), job};
        test_fail_each_alloc(act, &r);
    }
    make_folder(state, "ome.zarr/0");
    put_text(state, "ome.zarr/zarr.json", ome_v3);
    put_text(state, "ome.zarr/0/zarr.json", GOOD_V3);
    reading r = {io_path(state, "ome.zarr"), job};
    test_fail_each_alloc(act, &r);
    vv_job_release(job);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(seeds_are_read, io_setup, io_teardown),
        cmocka_unit_test_setup_teardown(each_lie_of_metadata_has_its_sentence, io_setup, io_teardown),
        cmocka_unit_test_setup_teardown(a_volume_of_too_many_chunks_is_refused_at_once, io_setup, io_teardown),
        cmocka_unit_test_setup_teardown(every_truncation_is_refused_or_told, io_setup, io_teardown),
        cmocka_unit_test_setup_teardown(mutations_are_read_or_refused, io_setup, io_teardown),
        cmocka_unit_test_setup_teardown(every_allocation_may_fail, io_setup, io_teardown),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
