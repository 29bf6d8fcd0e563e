/* Structure sets: files that are made here, element by element, and the geometry of their contours. Truth is the area
 * of what they enclose. */
#include "core/job.h"
#include "fields.h"
#include "io/formats/dicom/dicom_contours.h"
#include "io_test.h"

/* Files -------------------------------------------------------------------------------------------------------------
 */

/* Implicit VR, little endian. */
typedef struct bytes {
    uint8_t *data;
    size_t n;
} bytes;

static void add(bytes *b, const void *data, size_t n)
{
    b->data = realloc(b->data, b->n + n + 1);
    assert_non_null(b->data);
    if (n)
        memcpy(b->data + b->n, data, n);
    b->n += n;
}

static void add_head(bytes *b, uint32_t tag, size_t length)
{
    const uint8_t head[8] = {(uint8_t)(tag >> 16),    (uint8_t)(tag >> 24),   (uint8_t)tag,
                             (uint8_t)(tag >> 8),     (uint8_t)length,        (uint8_t)(length >> 8),
                             (uint8_t)(length >> 16), (uint8_t)(length >> 24)};
    add(b, head, sizeof head);
}

static void add_text(bytes *b, uint32_t tag, const char *text)
{
    const size_t n = strlen(text);
    add_head(b, tag, n + n % 2);
    add(b, text, n);
    add(b, tag >> 16 == 0x3006 ? " " : "", n % 2);
}

/* A sequence, or an item of one (0xfffee000), of what is inside, which is used up. */
static void add_group(bytes *b, uint32_t tag, bytes *inside)
{
    add_head(b, tag, inside->n);
    add(b, inside->data, inside->n);
    free(inside->data);
    *inside = (bytes){0};
}

#define ITEM 0xfffee000

typedef struct contour {
    const char *roi, *kind, *count, *data; /* count NULL: it is not said */
} contour;

/* Two regions, 5 (Liver, red) and 9 (Ring, green), with these contours. */
static bytes make_set(const contour *contours, size_t n)
{
    static const char *const numbers[] = {"5", "9"}, *const names[] = {"Liver", "Ring"},
                             *const colours[] = {"255\\0\\0", "0\\255\\0"};
    bytes file = {0}, regions = {0}, drawn = {0}, inside = {0};
    const uint8_t zeros[128] = {0};
    add(&file, zeros, sizeof zeros);
    add(&file,
        "DICM\2\0\x10\0UI\x12\0"
        "1.2.840.10008.1.2\0",
        12 + 18);
    add_text(&file, 0x00080016, "1.2.840.10008.5.1.4.1.1.481.3");
    add_text(&file, 0x00080018, "1.2.3.4");
    add_text(&file, 0x00080060, "RTSTRUCT");
    add_text(&file, 0x0020000e, "1.2.77");
    for (int r = 0; r < 2; r++) {
        add_text(&inside, 0x30060022, numbers[r]);
        add_text(&inside, 0x30060026, names[r]);
        add_group(&regions, ITEM, &inside);
    }
    add_group(&file, 0x30060020, &regions);
    for (int r = 0; r < 3; r++) { /* the third is of a region that there is not */
        const char *number = r < 2 ? numbers[r] : "77";
        bytes list = {0}, one = {0};
        for (size_t i = 0; i < n; i++) {
            if (strcmp(contours[i].roi, number) != 0)
                continue;
            add_text(&one, 0x30060042, contours[i].kind ? contours[i].kind : "CLOSED_PLANAR");
            if (contours[i].count)
                add_text(&one, 0x30060046, contours[i].count);
            add_text(&one, 0x30060050, contours[i].data);
            add_group(&list, ITEM, &one);
        }
        if (r < 2)
            add_text(&inside, 0x3006002a, colours[r]);
        add_group(&inside, 0x30060040, &list);
        add_text(&inside, 0x30060084, number);
        add_group(&drawn, ITEM, &inside);
    }
    add_group(&file, 0x30060039, &drawn);
    return file;
}

static vv_file *open_set(void **state, const contour *contours, size_t n)
{
    bytes set = make_set(contours, n);
    const char *path = io_path(state, "s.dcm");
    io_put(path, set.data, set.n);
    free(set.data);
    return io_open(path);
}

/* Rectangles in planes 3 mm apart, and one with a hole, once as two contours and once by a bridge; x and y to the left
 * and to the back. */
#define OUTER(z) "0\\0\\" z "\\20\\0\\" z "\\20\\10\\" z "\\0\\10\\" z
#define INNER(z) "5\\2\\" z "\\15\\2\\" z "\\15\\6\\" z "\\5\\6\\" z
#define BRIDGED(z) OUTER(z) "\\0\\0\\" z "\\" INNER(z) "\\5\\2\\" z
static const contour sound[] = {
    {"5", NULL, "4", OUTER("0")}, {"5", NULL, "4", OUTER("3")}, {"5", NULL, NULL, OUTER("6")},
    {"9", NULL, "4", OUTER("9")}, {"9", NULL, "4", INNER("9")}, {"9", NULL, "10", BRIDGED("12")},
};
enum { N_SOUND = sizeof sound / sizeof *sound };

static uint64_t count(const vv_field *field, int64_t k, double value)
{
    const int64_t *n = vv_field_get_info(field)->grid.dims;
    uint64_t found = 0;
    for (int64_t j = 0; j < n[1]; j++)
        for (int64_t i = 0; i < n[0]; i++)
            found += vv_field_value(field, i, j, k, 0) == value;
    return found;
}

static void regions_are_as_large_as_their_contours(void **state)
{
    vv_file *file = open_set(state, sound, N_SOUND);
    const vv_field_info *info = vv_file_info(file);
    assert_int_equal(info->meaning, VV_MEANING_LABEL);
    assert_int_equal(info->grid.space, VV_SPACE_RAS);
    assert_int_equal(info->grid.dims[2], 5);
    assert_float_equal(vv_grid_spacing(&info->grid, 2), 3, 1e-9);
    assert_null(vv_file_warning(file, 0));
    size_t n;
    const vv_label *labels = vv_file_labels(file, &n);
    assert_int_equal(n, 2);
    for (size_t i = 0; i < n; i++) {
        const bool liver = labels[i].value == 5;
        assert_string_equal(labels[i].name, liver ? "Liver" : "Ring");
        assert_true(labels[i].has_color && labels[i].color.r == liver && labels[i].color.g == !liver);
    }
    vv_field *field = io_frame(file, 0);
    const double each = vv_grid_spacing(&info->grid, 0) * vv_grid_spacing(&info->grid, 1);
    for (int64_t k = 0; k < 5; k++) { /* edges lie between the centres of samples: areas are exact */
        const double z = vv_affine_point(info->grid.index_to_world, (vv_vec3){0, 0, (double)k}).z;
        const bool liver = z < 7;
        assert_float_equal((double)count(field, k, liver ? 5 : 9) * each, liver ? 200 : 200 - 40, 1e-6);
        assert_int_equal(count(field, k, liver ? 9 : 5), 0);
    }
    /* 10 mm to the left and 1 mm to the back is inside; in RAS both are negative */
    vv_affine back;
    assert_true(vv_affine_invert(&back, info->grid.index_to_world));
    const vv_vec3 in = vv_affine_point(back, (vv_vec3){-10.01, -1.01, 3}),
                  out = vv_affine_point(back, (vv_vec3){0.5, -1, 3});
    assert_float_equal(vv_field_value(field, (int64_t)(in.x + 0.5), (int64_t)(in.y + 0.5), (int64_t)(in.z + 0.5), 0), 5,
                       0);
    assert_float_equal(vv_field_value(field, (int64_t)(out.x + 0.5), (int64_t)(out.y + 0.5), (int64_t)(out.z + 0.5), 0),
                       0, 0);
    vv_field_release(field);
    vv_file_close(file);
}

static void what_cannot_be_drawn_is_left_out_and_told(void **state)
{
    static const struct {
        contour bad;
        const char *words;
    } faults[] = {
        {{"5", "OPEN_PLANAR", "4", OUTER("0")}, "1 contour, first of ROI 5 (Liver), is not closed"},
        {{"9", "POINT", "1", "1\\2\\3"}, "first of ROI 9 (Ring), is not closed"},
        {{"5", "SOMETHING", "4", OUTER("0")}, "is not closed"},
        {{"5", NULL, "4", OUTER("0") "\\7"}, "not a multiple of 3"},
        {{"5", NULL, "2", "1\\2\\3\\4\\5\\6"}, "fewer than 3 points"},
        {{"5", NULL, "4", "x\\0\\0\\9\\0\\0\\9\\9\\0"}, "not numbers"},
        {{"5", NULL, "3", "0\\0\\0\\1e9\\0\\0\\9\\9\\0"}, "a kilometre or more away"},
        {{"77", NULL, "4", OUTER("0")}, "1 contours belong to ROIs that the file does not describe"},
        {{"5", NULL, "400", OUTER("0")}, "a number of points other than they state"},
    };
    for (size_t i = 0; i < sizeof faults / sizeof *faults; i++) {
        contour all[N_SOUND + 1];
        memcpy(all, sound, sizeof sound);
        all[N_SOUND] = faults[i].bad;
        vv_file *file = open_set(state, all, N_SOUND + 1);
        const char *warning = vv_file_warning(file, 0);
        if (!warning || !strstr(warning, faults[i].words))
            fail_msg("'%s'; expected '%s'", warning ? warning : "no warning", faults[i].words);
        assert_int_equal(vv_file_info(file)->grid.dims[2], 5);
        vv_file_close(file);
    }
}

static void a_set_without_an_area_is_refused(void **state)
{
    static const contour none[] = {{"5", "POINT", "1", "1\\2\\3"}},
                         line[] = {{"5", NULL, "3", "0\\0\\0\\5\\0\\0\\9\\0\\0"}};
    for (int i = 0; i < 3; i++) {
        bytes set = make_set(i == 1 ? none : line, i > 0);
        io_put(io_path(state, "s.dcm"), set.data, set.n);
        free(set.data);
        io_refused(io_path(state, "s.dcm"), VV_E_FORMAT, "without closed contours");
    }
}

/* Of a file that is cut or changed something is read, or one sentence says why not. */
static void damage_is_read_or_refused(void **state)
{
    bytes set = make_set(sound, N_SOUND);
    uint8_t *changed = malloc(set.n);
    const uint64_t seed = test_seed();
    uint64_t next = 0;
    assert_non_null(changed);
    for (size_t round = 0; round < 900; round++) {
        const char *path = io_path(state, "s.dcm");
        const size_t keep = round < 300 ? set.n * round / 300 : set.n;
        vv_file *file;
        memcpy(changed, set.data, set.n);
        for (int i = 0; round >= 300 && i < 3; i++) {
            const size_t at = 128 + test_random(seed, next++) % (set.n - 128);
            changed[at] = (uint8_t)test_random(seed, next++);
        }
        io_put(path, changed, keep);
        const vv_status st = vv_file_open(&file, path, NULL, NULL);
        assert_int_not_equal(st, VV_E_INTERNAL);
        if (st != VV_OK)
            assert_true(vv_error_last()->message[0] && !strchr(vv_error_last()->message, '\n'));
        vv_file_close(file);
    }
    free(changed);
    free(set.data);
}

/* Geometry ----------------------------------------------------------------------------------------------------------
 */

static void a_normal_is_twice_the_area_wherever_the_contour_lies(void **state)
{
    (void)state;
    for (int far = 0; far < 2; far++) {
        const double o = far * 524288.0;
        double at[12] = {o, o, o, o + 4, o, o, o + 4, o + 3, o, o, o + 3, o};
        const vvi_dicom_contour c = {.at = at, .n_points = 4};
        const vv_vec3 n = vvi_dicom_contour_normal(&c);
        assert_true(n.x == 0 && n.y == 0 && n.z == 24);
    }
    /* a triangle of sides a and b at right angles, in a plane that leans */
    double leaning[9] = {0, 0, 0, 3, 0, 4, 0, 2, 0};
    const vvi_dicom_contour c = {.at = leaning, .n_points = 3};
    const vv_vec3 n = vvi_dicom_contour_normal(&c);
    assert_true(n.x == -8 && n.y == 0 && n.z == 6);
    vvi_dicom_structures s = {.contour = (vvi_dicom_contour *)&c, .n_contours = 1};
    vv_vec3 unit;
    assert_true(vvi_dicom_contours_normal(&unit, &s));
    assert_float_equal(unit.x, -0.8, 1e-15);
    assert_float_equal(unit.z, 0.6, 1e-15);
    vvi_dicom_find_depths(&s, unit);
    assert_float_equal(c.depth, 0, 1e-15);
    assert_float_equal(c.off, 0, 1e-15);
    vvi_dicom_find_depths(&s, (vv_vec3){0, 0, 1}); /* of heights 0, 4 and 0 */
    assert_float_equal(c.depth, 4 / 3.0, 1e-15);
    assert_float_equal(c.off, 8 / 3.0, 1e-15);
}

static void the_usual_distance_is_that_of_most_planes(void **state)
{
    static const struct {
        double depth[8];
        size_t n, n_distances;
        double usual;
    } cases[] = {
        {{0}, 1, 0, 0},
        {{1, 1.01, 1.015}, 3, 0, 0},             /* one plane, by the decimals that files keep */
        {{0, 3, 6, 9}, 4, 3, 3},                 /* even */
        {{0, 3, 6, 12, 15}, 5, 4, 3},            /* a gap */
        {{0, 2, 4, 9, 14}, 5, 4, 2},             /* equally frequent: the least */
        {{0, 2.5, 5.01, 7.5, 7.505}, 5, 3, 2.5}, /* rounded */
    };
    (void)state;
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        double distances[8];
        size_t n = 99;
        const double usual = vvi_dicom_usual_distance(cases[i].depth, cases[i].n, distances, &n);
        assert_int_equal(n, cases[i].n_distances);
        assert_float_equal(usual, cases[i].usual, 1e-9);
    }
}

/* Samples of 1 mm whose centres are at whole numbers; the contours lie in the plane of the slice. */
static uint64_t draw(uint8_t *out, int64_t columns, int64_t rows, vvi_dicom_contour *contours, size_t n)
{
    vvi_dicom_drawing drawing = {.n = n};
    vvi_dicom_structures s = {.contour = contours,
                              .n_contours = n,
                              .normal = {0, 0, 1},
                              .frame = &drawing,
                              .n_frames = 1,
                              .to_index = vv_affine_identity(),
                              .grid = {.dims = {columns, rows, 1}, .index_to_world = vv_affine_identity()}};
    const vvi_dicom_image image = {.structures = &s};
    uint64_t found = 0;
    io_ok(vvi_dicom_draw_frame(out, &image, 0, NULL));
    for (int64_t i = 0; i < columns * rows; i++)
        found += out[i];
    return found;
}

static void samples_are_inside_by_the_even_odd_rule(void **state)
{
    double outer[] = {-0.5, -0.5, 0, 9.5, -0.5, 0, 9.5, 5.5, 0, -0.5, 5.5, 0};
    double inner[] = {2.5, 1.5, 0, 5.5, 1.5, 0, 5.5, 3.5, 0, 2.5, 3.5, 0};
    double bridged[] = {-0.5, -0.5, 0, 9.5, -0.5, 0, 9.5, 5.5, 0, -0.5, 5.5, 0, -0.5, -0.5, 0,
                        2.5,  1.5,  0, 5.5, 1.5,  0, 5.5, 3.5, 0, 2.5,  3.5, 0, 2.5,  1.5,  0};
    double wide[] = {-1e5, 1.5, 0, 1e5, 1.5, 0, 1e5, 3.5, 0, -1e5, 3.5, 0}, away[] = {50, 0, 0, 60, 0, 0, 60, 5, 0};
    vvi_dicom_contour ring[] = {{.at = outer, .n_points = 4}, {.at = inner, .n_points = 4}};
    vvi_dicom_contour one = {.at = bridged, .n_points = 10}, band = {.at = wide, .n_points = 4},
                      none = {.at = away, .n_points = 3};
    uint8_t out[60], again[60];
    (void)state;
    assert_int_equal(draw(out, 10, 6, ring, 1), 60);
    assert_int_equal(draw(out, 10, 6, ring, 2), 60 - 6);
    assert_int_equal(out[2 * 10 + 2], 1);
    assert_int_equal(out[2 * 10 + 3], 0);
    assert_int_equal(draw(again, 10, 6, &one, 1), 54); /* the bridge leaves no line */
    assert_memory_equal(out, again, sizeof out);
    assert_int_equal(draw(out, 10, 6, &band, 1), 20); /* beyond the slice on both sides */
    assert_int_equal(draw(out, 10, 6, &none, 1), 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(regions_are_as_large_as_their_contours, io_setup, io_teardown),
        cmocka_unit_test_setup_teardown(what_cannot_be_drawn_is_left_out_and_told, io_setup, io_teardown),
        cmocka_unit_test_setup_teardown(a_set_without_an_area_is_refused, io_setup, io_teardown),
        cmocka_unit_test_setup_teardown(damage_is_read_or_refused, io_setup, io_teardown),
        cmocka_unit_test(a_normal_is_twice_the_area_wherever_the_contour_lies),
        cmocka_unit_test(the_usual_distance_is_that_of_most_planes),
        cmocka_unit_test(samples_are_inside_by_the_even_odd_rule),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
