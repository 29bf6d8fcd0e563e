/* Real files in the dialects of other programs: dims, types, spacings as their index says, and the same voxels where
 * two files hold the same. The files are not part of this repository: where they are absent, nothing is tested, and
 * said. */
#include "io_test.h"

static const char *shared(void **state, const char *name)
{
    static char path[4][4096];
    static unsigned turn;
    const char *root = getenv("VOLVIS_SHARED");
    char *out = path[turn++ % 4];
    (void)state;
    snprintf(out, sizeof path[0], "%s/data/%s", root ? root : VOLVIS_SHARED_DIR, name);
    return out;
}

static bool there(void **state)
{
    if (access(shared(state, "formats/nrrd"), R_OK) == 0)
        return true;
    print_message("%s is not there: skipped\n", shared(state, "formats"));
    skip();
    return false;
}

typedef struct expected {
    const char *path;
    int64_t dims[3];
    vv_type type;
    int components;
    int64_t frames;
    double spacing[3];

} expected;

static const expected files[] = {
    {"formats/nrrd/HeadMRVolumeWithDirection.nhdr", {48, 62, 42}, VV_TYPE_U8, 1, 1, {4, 4, 4}},
    {"formats/nrrd/Input-RA-Short.nrrd", {64, 64, 64}, VV_TYPE_I16, 1, 1, {0.755874, 0.755874, 0.755874}},
    {"formats/nrrd/Skull.nrrd", {160, 232, 160}, VV_TYPE_U8, 1, 1, {1, 0.898437, 0.898437}},
    {"formats/nrrd/box.nhdr", {20, 20, 20}, VV_TYPE_F32, 1, 1, {1, 2, 3}},
    {"formats/nrrd/mini-vector-fast.nrrd", {5, 5, 5}, VV_TYPE_F32, 4, 1, {1, 1, 1}},
    {"formats/nrrd/testrgb-0.nhdr", {120, 95, 1}, VV_TYPE_U8, 3, 1, {1, 1, 1}},
    {"formats/nrrd/testrgb-1.nhdr", {120, 95, 1}, VV_TYPE_U8, 3, 1, {1, 1, 1}},
    {"formats/nrrd/testrgba.nrrd", {120, 95, 1}, VV_TYPE_U8, 4, 1, {1, 1, 1}},
    {"formats/nrrd/ball/test1d_ascii.nrrd", {27, 1, 1}, VV_TYPE_U8, 1, 1, {1.0458, 1.0458, 1.0458}},
    {"formats/nrrd/ball/test_simple4d_raw.nrrd", {1, 1, 1}, VV_TYPE_F64, 1, 1, {1.5, 1.5, 1}},
    {"formats/nifti/ASR.nii.gz", {79, 67, 64}, VV_TYPE_U8, 1, 1, {2.38975, 2.36649, 2.38523}},
    {"formats/nifti/LPS.nii.gz", {64, 79, 67}, VV_TYPE_U8, 1, 1, {2.38523, 2.38975, 2.36649}},
    {"formats/nifti/RAS.nii.gz", {64, 79, 67}, VV_TYPE_U8, 1, 1, {2.38523, 2.38975, 2.36649}},
    {"formats/nifti/SLA.nii.gz", {67, 64, 79}, VV_TYPE_U8, 1, 1, {2.36649, 2.38523, 2.38975}},
    {"formats/nifti/LPSLabels.nii.gz", {256, 256, 124}, VV_TYPE_I16, 1, 1, {0.9375, 0.9375, 1.5}},
    {"formats/nifti/anatomical.nii", {33, 41, 25}, VV_TYPE_I16, 1, 1, {2, 2, 2}},
    {"formats/nifti/example4d.nii.gz", {128, 96, 24}, VV_TYPE_I16, 1, 2, {2, 2, 2.2}},
    {"formats/nifti/example_nifti2.nii.gz", {32, 20, 12}, VV_TYPE_I16, 1, 2, {2, 2, 2.2}},
    {"formats/nifti/functional.nii", {17, 21, 3}, VV_TYPE_I16, 1, 20, {4, 4, 8}},
    {"formats/nifti/ras.hdr", {62, 41, 34}, VV_TYPE_U8, 1, 1, {2.38523, 2.38975, 2.36649}},
    {"formats/nifti/ras.img", {62, 41, 34}, VV_TYPE_U8, 1, 1, {2.38523, 2.38975, 2.36649}},
    {"volumes/lobster_301x324x56_u8.nhdr", {301, 324, 56}, VV_TYPE_U8, 1, 1, {1, 1, 1.4}},
    {"volumes/engine_256x256x256_u8.nhdr", {256, 256, 256}, VV_TYPE_U8, 1, 1, {1, 1, 1}},
    {"volumes/tooth.nhdr", {103, 94, 161}, VV_TYPE_U16, 1, 1, {1, 1, 1}},
    {"volumes/mra_head_256x256x256_u8.nhdr", {256, 256, 256}, VV_TYPE_U8, 1, 1, {1, 1, 1}},
    {"volumes/neuron_409x415x119_u8.nhdr", {409, 415, 119}, VV_TYPE_U8, 1, 1, {1, 1, 1}},
    {"volumes/chestct_256x256x133_u8.nhdr", {256, 256, 133}, VV_TYPE_U8, 1, 1, {1.40625, 1.40625, 2.5}},
    {"volumes/neghip_64x64x64_u8.raw", {64, 64, 64}, VV_TYPE_U8, 1, 1, {1, 1, 1}},
    {"volumes/fuel_64x64x64_u8.raw", {64, 64, 64}, VV_TYPE_U8, 1, 1, {1, 1, 1}},
    {"volumes/nucleon_41x41x41_u8.raw", {41, 41, 41}, VV_TYPE_U8, 1, 1, {1, 1, 1}},
    {"volumes/manix128_128x128x115_u8.raw", {128, 128, 115}, VV_TYPE_U8, 1, 1, {1, 1, 1}},
    {"volumes/lobster_301x324x56_u8.raw.gz", {301, 324, 56}, VV_TYPE_U8, 1, 1, {1, 1, 1}},
    {"formats/metaimage/BigEndian.mhd", {24, 24, 1}, VV_TYPE_U16, 1, 1, {1, 1, 1}},
    {"formats/metaimage/BinarySquare3D.mhd", {21, 21, 21}, VV_TYPE_U8, 1, 1, {1, 1, 1}},
    {"formats/metaimage/HeadMRVolume.mha", {48, 62, 42}, VV_TYPE_U8, 1, 1, {4, 4, 4}},
    {"formats/metaimage/HeadMRVolume.mhd", {48, 62, 42}, VV_TYPE_U8, 1, 1, {4, 4, 4}},
    {"formats/metaimage/HeadMRVolumeCompressed.mha", {48, 62, 42}, VV_TYPE_U8, 1, 1, {4, 4, 4}},
    {"formats/metaimage/HeadMRVolumeWithDirection.mhd", {48, 62, 42}, VV_TYPE_U8, 1, 1, {4, 4, 4}},
    {"formats/metaimage/SmallRampVolumeList.mhd", {6, 6, 6}, VV_TYPE_U8, 1, 1, {1, 1, 1}},
    {"formats/metaimage/VHFColor.mhd", {50, 50, 10}, VV_TYPE_U8, 3, 1, {1, 1, 1}},
    {"formats/slc/bolt.slc", {70, 123, 66}, VV_TYPE_U8, 1, 1, {1, 1, 1}},
    {"formats/slc/neghip.slc", {66, 66, 66}, VV_TYPE_U8, 1, 1, {1, 1, 1}},
    {"volumes/embryo.slc", {256, 256, 256}, VV_TYPE_U8, 1, 1, {1, 1, 1}},
    {"volumes/frogtissue.mhd", {500, 470, 136}, VV_TYPE_U8, 1, 1, {1, 1, 1.5}},
    {"volumes/CT_AVM.nii.gz", {256, 242, 154}, VV_TYPE_U8, 1, 1, {0.719943, 0.720914, 1}},
    {"volumes/MR_Gd.nii.gz", {176, 188, 144}, VV_TYPE_U8, 1, 1, {0.976562, 0.976562, 1.0026}},
    {"volumes/pcasl_4d.nii.gz", {52, 68, 20}, VV_TYPE_F32, 1, 10, {3, 3, 6}},
};

static void every_file_opens_with_what_its_index_says(void **state)
{
    if (!there(state))
        return;
    for (size_t i = 0; i < sizeof files / sizeof *files; i++) {
        vv_file *file = io_open(shared(state, files[i].path));
        const vv_field_info *info = vv_file_info(file);
        assert_memory_equal(info->grid.dims, files[i].dims, sizeof files[i].dims);
        assert_int_equal(info->type, files[i].type);
        assert_int_equal(info->components, files[i].components);
        assert_int_equal(info->n_frames, files[i].frames);
        for (int a = 0; a < 3; a++)
            assert_float_equal(vv_grid_spacing(&info->grid, a), files[i].spacing[a], 1e-5);
        vv_field *field = io_frame(file, info->n_frames - 1);
        io_ok(vv_field_health(field));
        vv_field_release(field);
        vv_file_close(file);
    }
}

static void same_voxels(void **state, const char *const *names)
{
    vv_file *first = io_open(shared(state, names[0]));
    vv_field *a = io_frame(first, 0);
    for (int i = 1; names[i]; i++) {
        vv_file *other = io_open(shared(state, names[i]));
        vv_field *b = io_frame(other, 0);
        io_same_samples(a, b);
        io_same_positions(&vv_field_get_info(a)->grid, &vv_field_get_info(b)->grid, 0);
        vv_field_release(b);
        vv_file_close(other);
    }
    vv_field_release(a);
    vv_file_close(first);
}

static void all_dialects_of_one_volume_have_the_same_voxels(void **state)
{
    static const char *const vol[] = {"formats/nrrd/vol-ascii.nrrd",
                                      "formats/nrrd/vol-ascii.nhdr",
                                      "formats/nrrd/vol-gzip-big.nrrd",
                                      "formats/nrrd/vol-gzip-big.nhdr",
                                      "formats/nrrd/vol-gzip-little.nrrd",
                                      "formats/nrrd/vol-gzip-little.nhdr",
                                      "formats/nrrd/vol-raw-big.nrrd",
                                      "formats/nrrd/vol-raw-big.nhdr",
                                      "formats/nrrd/vol-raw-little.nrrd",
                                      "formats/nrrd/vol-raw-little.nhdr",
                                      NULL};
    static const char *const ball[] = {
        "formats/nrrd/ball/BallBinary30x30x30.nrrd", "formats/nrrd/ball/BallBinary30x30x30.nhdr",
        "formats/nrrd/ball/BallBinary30x30x30_gz.nrrd", "formats/nrrd/ball/BallBinary30x30x30_bz2.nrrd", NULL};
    static const char *const rgb[] = {"formats/nrrd/testrgb-0.nhdr", "formats/nrrd/testrgb-1.nhdr", NULL};
    static const char *const pair[] = {"formats/nifti/ras.hdr", "formats/nifti/ras.img", NULL};
    if (!there(state))
        return;
    same_voxels(state, vol);
    same_voxels(state, ball);
    same_voxels(state, rgb);
    same_voxels(state, pair);
}

/* For each sample of one volume the sample of the other at the same world position. */
static void a_brain_in_four_axis_orders_is_one_brain_in_the_world(void **state)
{
    static const char *const orders[] = {"ASR", "LPS", "SLA"};
    char name[64];
    if (!there(state))
        return;
    vv_file *ras_file = io_open(shared(state, "formats/nifti/RAS.nii.gz"));
    vv_field *ras = io_frame(ras_file, 0);
    for (size_t o = 0; o < 3; o++) {
        snprintf(name, sizeof name, "formats/nifti/%s.nii.gz", orders[o]);
        vv_file *file = io_open(shared(state, name));
        vv_field *field = io_frame(file, 0);
        char letters[16];
        vv_grid_orientation(letters, &vv_file_info(file)->grid);
        assert_string_equal(letters, orders[o]);
        vv_affine to_index;
        assert_true(vv_affine_invert(&to_index, vv_file_info(file)->grid.index_to_world));
        const vv_affine map = vv_affine_compose(to_index, vv_file_info(ras_file)->grid.index_to_world);
        const int64_t *n = vv_file_info(ras_file)->grid.dims;
        for (int64_t k = 0; k < n[2]; k++)
            for (int64_t j = 0; j < n[1]; j++)
                for (int64_t i = 0; i < n[0]; i++) {
                    const vv_vec3 p = vv_affine_point(map, (vv_vec3){(double)i, (double)j, (double)k});
                    const int64_t q[3] = {llround(p.x), llround(p.y), llround(p.z)};
                    assert_true(fabs(p.x - (double)q[0]) < 0.01 && fabs(p.y - (double)q[1]) < 0.01 &&
                                fabs(p.z - (double)q[2]) < 0.01);
                    assert_true(vv_field_value(ras, i, j, k, 0) == vv_field_value(field, q[0], q[1], q[2], 0));
                }
        vv_field_release(field);
        vv_file_close(file);
    }
    vv_field_release(ras);
    vv_file_close(ras_file);
}

static void what_cannot_be_shown_is_refused_with_a_reason(void **state)
{
    if (!there(state))
        return;
    io_refused(shared(state, "formats/nrrd/mini-ten-mask.nrrd"), VV_E_UNSUPPORTED, "matrices");
    io_refused(shared(state, "formats/metaimage/MetaImageError.mhd"), VV_E_READ, "Error.raw");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_file_opens_with_what_its_index_says),
        cmocka_unit_test(all_dialects_of_one_volume_have_the_same_voxels),
        cmocka_unit_test(a_brain_in_four_axis_orders_is_one_brain_in_the_world),
        cmocka_unit_test(what_cannot_be_shown_is_refused_with_a_reason),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
