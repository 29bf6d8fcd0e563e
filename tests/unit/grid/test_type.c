/* Sample types, conversions, and the check of infos. */
#include "fields.h"
#include "grid/field.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

static void types_are_known_by_the_names_that_files_use(void **state)
{
    (void)state;
    static const struct {
        const char *text;
        vv_type type;
    } names[] = {
        {"u8", VV_TYPE_U8},
        {"uint8", VV_TYPE_U8},
        {"uchar", VV_TYPE_U8},
        {"unsigned char", VV_TYPE_U8},
        {"  Unsigned   CHAR ", VV_TYPE_U8},
        {"signed char", VV_TYPE_I8},
        {"int16", VV_TYPE_I16},
        {"short", VV_TYPE_I16},
        {"ushort", VV_TYPE_U16},
        {"uint16_t", VV_TYPE_U16},
        {"int", VV_TYPE_I32},
        {"unsigned int", VV_TYPE_U32},
        {"longlong", VV_TYPE_I64},
        {"unsigned long long int", VV_TYPE_U64},
        {"float", VV_TYPE_F32},
        {"double", VV_TYPE_F64},
        {"float64", VV_TYPE_F64},
    };
    for (size_t i = 0; i < sizeof names / sizeof *names; i++) {
        vv_type type = VV_TYPE_COUNT;
        if (!vv_type_parse(&type, names[i].text) || type != names[i].type)
            fail_msg("'%s' is not understood", names[i].text);
    }
    for (int t = 0; t < VV_TYPE_COUNT; t++) {
        vv_type type;
        assert_true(vv_type_parse(&type, vv_type_name((vv_type)t)) && type == (vv_type)t);
    }
}

static void other_words_are_no_types(void **state)
{
    (void)state;
    static const char *const wrong[] = {
        "",         " ",          "u", "8",   "u88",
        "unsigned", "char|short", "|", "u8|", "a word that is very much longer than any name of a type could be"};
    vv_type type = VV_TYPE_F64;
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++)
        if (vv_type_parse(&type, wrong[i]))
            fail_msg("'%s' is taken for a type", wrong[i]);
    assert_false(vv_type_parse(&type, NULL));
    assert_int_equal(type, VV_TYPE_F64);
    assert_int_equal(vv_type_bytes((vv_type)99), 0);
}

static void conversion_rounds_clamps_and_makes_nan_zero(void **state)
{
    (void)state;
    static const double in[] = {-1e300, -200.5, -0.5, 0.49, 0.5, 1.5, 2.5, 254.7, 1e300, NAN, INFINITY, -INFINITY};
    uint8_t u8[12];
    int8_t i8[12];
    vvi_samples_from_f64(u8, in, VV_TYPE_U8, 12);
    vvi_samples_from_f64(i8, in, VV_TYPE_I8, 12);
    static const uint8_t want_u8[12] = {0, 0, 0, 0, 0, 2, 2, 255, 255, 0, 255, 0};
    static const int8_t want_i8[12] = {-128, -128, 0, 0, 0, 2, 2, 127, 127, 0, 127, -128};
    assert_memory_equal(u8, want_u8, 12);
    assert_memory_equal(i8, want_i8, 12);
    uint64_t u64[12];
    int64_t i64[12];
    vvi_samples_from_f64(u64, in, VV_TYPE_U64, 12);
    vvi_samples_from_f64(i64, in, VV_TYPE_I64, 12);
    assert_true(u64[8] == UINT64_MAX && u64[0] == 0 && u64[9] == 0 && u64[10] == UINT64_MAX);
    assert_true(i64[8] == INT64_MAX && i64[0] == INT64_MIN && i64[9] == 0 && i64[11] == INT64_MIN);
    float f32[12];
    vvi_samples_from_f64(f32, in, VV_TYPE_F32, 12);
    assert_true(f32[8] == (float)vvi_type_max(VV_TYPE_F32) && isnan(f32[9]) && isinf(f32[10]));
}

static void every_number_of_a_type_survives_a_round_trip_at_any_alignment(void **state)
{
    (void)state;
    const uint64_t seed = test_seed();
    for (int t = 0; t < VV_TYPE_COUNT; t++) {
        char raw[1 + 64 * 8], back[1 + 64 * 8];
        double v[64], numbers[64];
        for (size_t i = 0; i < 64; i++)
            numbers[i] = floor((test_random_unit(seed, i) - 0.5) * 0x1p53);
        vvi_samples_from_f64(raw + 1, numbers, (vv_type)t, 64);
        vvi_samples_to_f64(v, raw + 1, (vv_type)t, 64);
        vvi_samples_from_f64(back + 1, v, (vv_type)t, 64);
        assert_memory_equal(raw + 1, back + 1, 64 * vv_type_bytes((vv_type)t));
    }
}

static void swapping_bytes_reverses_each_element(void **state)
{
    (void)state;
    for (size_t each = 1; each <= 8; each *= 2) {
        uint8_t data[1 + 24], want[24];
        for (size_t i = 0; i < 24; i++) {
            data[1 + i] = (uint8_t)i;
            want[i] = (uint8_t)(i / each * each + each - 1 - i % each);
        }
        vvi_swap_bytes(data + 1, each, 24 / each);
        assert_memory_equal(data + 1, want, 24);
    }
}

static void sizes_that_overflow_are_refused(void **state)
{
    (void)state;
    vv_field_info info = vv_field_info_default();
    uint64_t bytes = 0;
    info.grid.dims[0] = 3, info.grid.dims[1] = 5, info.grid.dims[2] = 7;
    info.type = VV_TYPE_F64;
    info.components = 2;
    assert_int_equal(vv_field_info_bytes(&bytes, &info), VV_OK);
    assert_int_equal(bytes, 3 * 5 * 7 * 2 * 8);
    info.grid.dims[0] = info.grid.dims[1] = info.grid.dims[2] = INT64_C(1) << 21;
    assert_int_equal(vv_field_info_bytes(&bytes, &info), VV_E_LIMIT);
    info.grid.dims[0] = INT64_MAX;
    assert_int_equal(vv_field_info_bytes(&bytes, &info), VV_E_LIMIT);
    info.grid.dims[0] = 0;
    assert_int_equal(vv_field_info_bytes(&bytes, &info), VV_E_LIMIT);
    info.grid.dims[0] = -4;
    assert_int_equal(vv_field_info_bytes(&bytes, &info), VV_E_LIMIT);
}

static void the_default_info_is_good_and_each_wrong_one_is_told(void **state)
{
    (void)state;
    const vv_field_info good = vv_field_info_default();
    assert_int_equal(vv_field_info_check(&good), VV_OK);
    vv_field_info wrong[20];
    size_t n = 0;
#define WRONG(change)                                                                                                  \
    do {                                                                                                               \
        vv_field_info *w = &wrong[n++];                                                                                \
        *w = good;                                                                                                     \
        change;                                                                                                        \
    } while (0)
    WRONG(w->grid.dims[1] = 0);
    WRONG(w->grid.index_to_world.axis[1].x = NAN);
    WRONG(w->grid.index_to_world.origin.z = INFINITY);
    WRONG(w->grid.index_to_world.axis[2] = w->grid.index_to_world.axis[0]);
    WRONG(w->grid.index_to_world.axis[0] = (vv_vec3){0});
    WRONG(w->grid.space = (vv_space)7);
    WRONG(memset(w->grid.unit, 'm', sizeof w->grid.unit));
    WRONG(w->type = (vv_type)10);
    WRONG(w->components = 0);
    WRONG(w->meaning = VV_MEANING_RGB);
    WRONG(w->meaning = VV_MEANING_RGBA);
    WRONG(w->meaning = (vv_meaning)9);
    WRONG(w->meaning = VV_MEANING_LABEL; w->type = VV_TYPE_F32);
    WRONG(w->value_scale = 0);
    WRONG(w->value_scale = NAN);
    WRONG(w->value_offset = INFINITY);
    WRONG(w->frame = 1);
    WRONG(w->n_frames = 0);
    WRONG(w->frame_step = NAN);
    WRONG(memset(w->name, 'x', sizeof w->name));
#undef WRONG
    for (size_t i = 0; i < n; i++)
        if (vv_field_info_check(&wrong[i]) != VV_E_FORMAT)
            fail_msg("wrong info %zu is taken", i);
}

static void components_have_the_names_of_their_meaning(void **state)
{
    vv_field_info info = vv_field_info_default();
    (void)state;
    assert_null(vv_component_name(&info, 0));
    info.components = 3;
    info.meaning = VV_MEANING_VECTOR;
    assert_string_equal(vv_component_name(&info, 2), "z");
    assert_null(vv_component_name(&info, 3));
    assert_null(vv_component_name(&info, -1));
    info.meaning = VV_MEANING_RGB;
    assert_string_equal(vv_component_name(&info, 1), "green");
    assert_null(vv_component_name(&info, 3));
    info.components = 4;
    info.meaning = VV_MEANING_RGBA;
    assert_string_equal(vv_component_name(&info, 3), "alpha");
    info.meaning = VV_MEANING_LABEL;
    assert_null(vv_component_name(&info, 0));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(types_are_known_by_the_names_that_files_use),
        cmocka_unit_test(other_words_are_no_types),
        cmocka_unit_test(conversion_rounds_clamps_and_makes_nan_zero),
        cmocka_unit_test(every_number_of_a_type_survives_a_round_trip_at_any_alignment),
        cmocka_unit_test(swapping_bytes_reverses_each_element),
        cmocka_unit_test(sizes_that_overflow_are_refused),
        cmocka_unit_test(the_default_info_is_good_and_each_wrong_one_is_told),
        cmocka_unit_test(components_have_the_names_of_their_meaning),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
