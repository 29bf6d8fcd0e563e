/** @file
 * Files for the tests of readers and writers: a folder of their own, bytes in and out, fields compared.
 */
#ifndef IO_TEST_H
#define IO_TEST_H
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <ftw.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>
#include <volvis/volvis.h>

/* A new folder, in memory where the machine has such: syncing thousands of little files is not what is tested. */
static inline int io_setup(void **state)
{
    char name[] = "/dev/shm/volvis-io-XXXXXX", other[] = "/tmp/volvis-io-XXXXXX";
    char *made = mkdtemp(name);
    if (!made)
        made = mkdtemp(other);
    *state = made ? strdup(made) : NULL;
    return *state ? 0 : -1;
}

static inline int io_remove_one(const char *path, const struct stat *info, int type, struct FTW *where)
{
    (void)info;
    (void)type;
    (void)where;
    return remove(path);
}

static inline int io_teardown(void **state)
{
    nftw(*state, io_remove_one, 16, FTW_DEPTH | FTW_PHYS);
    free(*state);
    return 0;
}

/* A path in the test's folder; good until the eighth next call. */
static inline const char *io_path(void **state, const char *name)
{
    static char paths[8][4096];
    static unsigned turn;
    char *path = paths[turn++ % 8];
    snprintf(path, sizeof paths[0], "%s/%s", (const char *)*state, name);
    return path;
}

static inline void io_put(const char *path, const void *data, size_t n)
{
    FILE *f = fopen(path, "wb");
    assert_non_null(f);
    assert_int_equal(fwrite(data, 1, n, f), n);
    assert_int_equal(fclose(f), 0);
}

static inline void io_put_text(const char *path, const char *text)
{
    io_put(path, text, strlen(text));
}

/* All bytes of a file, yours to free(). */
static inline uint8_t *io_get(const char *path, size_t *n)
{
    FILE *f = fopen(path, "rb");
    struct stat info;
    assert_non_null(f);
    assert_int_equal(fstat(fileno(f), &info), 0);
    *n = (size_t)info.st_size;
    uint8_t *data = malloc(*n + 1);
    assert_non_null(data);
    assert_int_equal(fread(data, 1, *n, f), *n);
    data[*n] = 0;
    fclose(f);
    return data;
}

static inline void io_ok(vv_status st)
{
    if (st != VV_OK)
        fail_msg("%s", vv_error_last()->message);
}

static inline vv_file *io_open(const char *path)
{
    vv_file *file = NULL;
    io_ok(vv_file_open(&file, path, NULL, NULL));
    return file;
}

static inline vv_field *io_frame(vv_file *file, int64_t frame)
{
    vv_field *field = NULL;
    io_ok(vv_file_read(&field, file, frame, NULL, NULL));
    return field;
}

static inline void io_write(const char *path, const vv_field *field, const char *encoding, bool big_endian)
{
    vv_write_options options;
    vv_write_options_init(&options, sizeof options);
    options.encoding = encoding;
    options.big_endian = big_endian;
    options.stored = true;
    io_ok(vv_field_write(path, &field, 1, &options, NULL));
}

/* Expects opening (or, when it opens, reading the first frame) to fail with this status and these words. */
static inline void io_refused(const char *path, vv_status status, const char *words)
{
    vv_file *file = NULL;
    vv_field *field = NULL;
    vv_status st = vv_file_open(&file, path, NULL, NULL);
    if (st == VV_OK)
        st = vv_file_read(&field, file, 0, NULL, NULL);
    if (st != status || !strstr(vv_error_last()->message, words))
        fail_msg("%s: status %s, '%s'; expected '%s'", path, vv_status_name(st),
                 st == VV_OK ? "" : vv_error_last()->message, words);
    assert_null(field);
    vv_file_close(file);
}

/* Whether all samples of two fields are the same bits. */
static inline void io_same_samples(const vv_field *a, const vv_field *b)
{
    const vv_field_info *p = vv_field_get_info(a), *q = vv_field_get_info(b);
    assert_memory_equal(p->grid.dims, q->grid.dims, sizeof p->grid.dims);
    assert_int_equal(p->type, q->type);
    assert_int_equal(p->components, q->components);
    vv_brick x, y;
    const vv_box box = vv_field_box(a);
    io_ok(vv_field_brick(&x, a, &box, NULL));
    io_ok(vv_field_brick(&y, b, &box, NULL));
    const size_t sample = vv_type_bytes(p->type) * (size_t)p->components;
    for (int64_t k = 0; k < box.n[2]; k++)
        for (int64_t j = 0; j < box.n[1]; j++)
            for (int64_t i = 0; i < box.n[0]; i++)
                assert_memory_equal((const char *)x.data + i * x.stride[0] + j * x.stride[1] + k * x.stride[2],
                                    (const char *)y.data + i * y.stride[0] + j * y.stride[1] + k * y.stride[2], sample);
    vv_brick_release(&x);
    vv_brick_release(&y);
}

/* Whether every sample lies at the same world position, to a share of the volume's size. */
static inline void io_same_positions(const vv_grid *a, const vv_grid *b, double tolerance)
{
    for (int corner = 0; corner < 8; corner++) { /* the map is affine: corners tell all */
        const vv_vec3 index = {corner & 1 ? (double)(a->dims[0] - 1) : 0, corner & 2 ? (double)(a->dims[1] - 1) : 0,
                               corner & 4 ? (double)(a->dims[2] - 1) : 0};
        const vv_vec3 p = vv_affine_point(a->index_to_world, index), q = vv_affine_point(b->index_to_world, index);
        const double apart = fmax(fabs(p.x - q.x), fmax(fabs(p.y - q.y), fabs(p.z - q.z)));
        const double size = fmax(1, fmax(fabs(p.x), fmax(fabs(p.y), fabs(p.z))));
        if (!(apart <= tolerance * size))
            fail_msg("corner %d: (%.17g %.17g %.17g) is now (%.17g %.17g %.17g)", corner, p.x, p.y, p.z, q.x, q.y, q.z);
    }
}

/* Everything but the placement's numbers. */
static inline void io_same_info(const vv_field_info *a, const vv_field_info *b)
{
    assert_string_equal(a->grid.unit, b->grid.unit);
    assert_int_equal(a->grid.space, b->grid.space);
    assert_int_equal(a->meaning, b->meaning);
    assert_float_equal(a->value_scale, b->value_scale, 1e-7 * fabs(a->value_scale));
    assert_float_equal(a->value_offset, b->value_offset, 1e-7 * (fabs(a->value_offset) + 1e-30));
    assert_string_equal(a->value_unit, b->value_unit);
    assert_string_equal(a->name, b->name);
}

/** The o-th of the 48 ways to put the index axes along the world axes, with these spacings; o in [0, 48). */
static inline vv_affine io_orientation(int o, const double spacing[3])
{
    static const int orders[6][3] = {{0, 1, 2}, {0, 2, 1}, {1, 0, 2}, {1, 2, 0}, {2, 0, 1}, {2, 1, 0}};
    double m[3][3] = {{0}};
    for (int a = 0; a < 3; a++)
        m[a][orders[o / 8][a]] = (o >> a & 1 ? -1 : 1) * spacing[a];
    return (vv_affine){{{m[0][0], m[0][1], m[0][2]}, {m[1][0], m[1][1], m[1][2]}, {m[2][0], m[2][1], m[2][2]}},
                       {10, -20, 30.5}};
}
#endif
