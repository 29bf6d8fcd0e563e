/* Formats of raw samples with a text header: .vvh, .dat, Inrimage. What their keys say, and each way to be wrong. */
#include "fields.h"
#include "io/sink.h"
#include "io/source.h"
#include "io_test.h"

typedef struct lie {
    const char *text, *words;
    vv_status status;
} lie;

static void refuse_all(void **state, const char *name, const lie *lies, size_t n)
{
    for (size_t i = 0; i < n; i++) {
        io_put_text(io_path(state, name), lies[i].text);
        io_refused(io_path(state, name), lies[i].status, lies[i].words);
        assert_null(strchr(vv_error_last()->message, '\n'));
    }
}

/* A header of these lines; `data` holds 0, 1, 2, ... */
static vv_field *read_with(void **state, const char *header, const char *text)
{
    uint8_t bytes[64];
    for (int i = 0; i < 64; i++)
        bytes[i] = (uint8_t)i;
    io_put(io_path(state, "data"), bytes, 64);
    io_put_text(io_path(state, header), text);
    vv_file *file = io_open(io_path(state, header));
    vv_field *field = io_frame(file, 0);
    vv_file_close(file);
    return field;
}

/* vvh ----------------------------------------------------------------------------------------------------------------
 */

#define HEAD "dims: 2 3 4\ntype: u8\n"

static const lie vvh_lies[] = {
    {"type: u8\ndata: data\n", "no 'dims'", VV_E_FORMAT},
    {"dims: 2 3 4\ndata: data\n", "no 'type'", VV_E_FORMAT},
    {HEAD, "no 'data'", VV_E_FORMAT},
    {"dimms: 2 3 4\n", "l.vvh:1: there is no key 'dimms'; did you mean 'dims'?", VV_E_FORMAT},
    {HEAD "spacings: 1 1 1\n", "l.vvh:3: there is no key 'spacings'; did you mean 'spacing'?", VV_E_FORMAT},
    {HEAD "dims: 2 3 4\n", "twice; it was given in line 1", VV_E_FORMAT},
    {HEAD "spacing 1 1 1\n", "l.vvh:3: 'spacing 1 1 1' is neither 'key: value' nor a # comment", VV_E_FORMAT},
    {"dims: 2 3 4 5\ntype: u8\ndata: data\n", "expected the samples along x, y and z", VV_E_FORMAT},
    {"dims: 2 0 4\ntype: u8\ndata: data\n", "'dims' has 0", VV_E_FORMAT},
    {"dims: two\ntype: u8\ndata: data\n", "'dims' is 'two'", VV_E_FORMAT},
    {"dims: 1048576 1048576 1048576\ntype: f64\ndata: data\n", "", VV_E_FORMAT},
    {"dims: 1000 1000 10\ntype: u8\ndata: data\n", "were expected", VV_E_FORMAT},
    {"dims: 2 3 4\ntype: u9\ndata: data\n", "'u9', which is not a type", VV_E_FORMAT},
    {HEAD "byte order: middle\n", "little or big", VV_E_FORMAT},
    {HEAD "components: 0\ndata: data\n", "'components' has 0", VV_E_FORMAT},
    {HEAD "meaning: colour\n", "'colour'; scalar, rgb", VV_E_FORMAT},
    {HEAD "meaning: rgb\n", "samples of 1 channels cannot be", VV_E_FORMAT},
    {"dims: 1\ntype: float\nmeaning: label\n", "labels are whole numbers", VV_E_FORMAT},
    {HEAD "order: x y y\n", "each of x, y, z, c and t once", VV_E_FORMAT},
    {HEAD "order: x y\n", "lacks z, of which there are 4", VV_E_FORMAT},
    {HEAD "spacing: 1 0 1\ndata: data\n", "spacing is 0", VV_E_FORMAT},
    {HEAD "spacing: 1 1\n", "expected 3", VV_E_FORMAT},
    {HEAD "directions: 1 0 0 1 0 0 0 0 1\n", "one plane", VV_E_FORMAT},
    {HEAD "space: there\n", "plain, RAS or LPS", VV_E_FORMAT},
    {HEAD "scale: 0\n", "'scale' is 0", VV_E_FORMAT},
    {HEAD "coding: rle\n", "raw, text, gzip", VV_E_FORMAT},
    {HEAD "coding: text\nskip: -1\n", "only raw data", VV_E_FORMAT},
    {HEAD "skip: -2\n", "'skip' has -2", VV_E_FORMAT},
    {HEAD "data: missing\n", "missing", VV_E_READ},
    {HEAD "data: ../data\n", "--allow-outside", VV_E_READ},
    {HEAD "data:\n", "names no file", VV_E_FORMAT},
    {HEAD "data: a%d\n", "FIRST LAST", VV_E_FORMAT},
    {HEAD "data: a%x 1 4\n", "needs one %d", VV_E_FORMAT},
    {HEAD "data: a%d 1 4 -1\n", "never leads", VV_E_FORMAT},
    {HEAD "data:\na\nb\nc\nd\ne\n", "names 5 data files, which cannot share 24 samples", VV_E_FORMAT},
};

static void each_lie_of_a_vvh_is_one_sentence(void **state)
{
    uint8_t zeros[24] = {0};
    io_put(io_path(state, "data"), zeros, 24);
    refuse_all(state, "l.vvh", vvh_lies, sizeof vvh_lies / sizeof *vvh_lies);
}

static void orders_of_axes_are_any(void **state)
{
    static const struct {
        const char *text;
        int step[4]; /* bytes from one to the next along x, y, z, c */
    } cases[] = {
        {"dims: 2 3 4\ntype: u8\ncomponents: 2\ndata: data\n", {2, 4, 12, 1}},
        {"dims: 2 3 4\ntype: u8\ncomponents: 2\norder: x y z c\ndata: data\n", {1, 2, 6, 24}},
        {"dims: 2x3x4\ntype: uint8\ncomponents: 2\norder: zcyx\ndata: data\n", {24, 8, 1, 4}},
        {"dims: 2 3 4\ntype: u8\nskip: -1\norder: x z y\ndata: data\n", {1, 8, 2, 0}},
    };
    for (size_t c = 0; c < sizeof cases / sizeof *cases; c++) {
        vv_field *field = read_with(state, "o.vvh", cases[c].text);
        const int *step = cases[c].step, base = c == 3 ? 40 : 0;
        for (int n = 0; n < 48; n++) {
            const int x = n % 2, y = n / 2 % 3, z = n / 6 % 4, part = n / 24;
            if (part == 0 || step[3])
                assert_float_equal(vv_field_value(field, x, y, z, part),
                                   base + x * step[0] + y * step[1] + z * step[2] + part * step[3], 0);
        }
        vv_field_release(field);
    }
}

static void many_files_codings_and_places_are_understood(void **state)
{
    static const char *const cases[] = {
        "# a comment\n\ndims: 2 2 3\ntype: i16\nbyte order: big\ndata: s%02d.raw 5 1 -2\n",
        "DIMS: 2 2 3\nType: short\nByte Order: BIG\nData:\n s05.raw\n# between\ns03.raw\n\ns01.raw\n",
        "dims: 2 2 3\ntype: i16\ncoding: text\ndata: text\n",
        "dims: 2 2 3\ntype: i16\ncoding: zlib\nskip: 3\ndata: zlib\n",
        "dims: 2 2 3\ntype: i16\nskip: 3\ndata: whole.gz\n",
    };
    int16_t values[12];
    char text[128] = "";
    for (int i = 0; i < 12; i++) {
        values[i] = (int16_t)(300 * i - 1000);
        snprintf(text + strlen(text), sizeof text - strlen(text), "%d,\n", values[i]);
    }
    for (int k = 0; k < 3; k++) {
        char name[16];
        uint8_t big[8];
        for (int i = 0; i < 4; i++) {
            big[2 * i] = (uint8_t)((uint16_t)values[4 * k + i] >> 8);
            big[2 * i + 1] = (uint8_t)values[4 * k + i];
        }
        snprintf(name, sizeof name, "s%02d.raw", 5 - 2 * k);
        io_put(io_path(state, name), big, 8);
    }
    io_put_text(io_path(state, "text"), text);
    for (int coding = 0; coding < 2; coding++) { /* before the coding three bytes, or inside */
        vv_sink *sink;
        io_ok(vvi_sink_open(&sink, io_path(state, coding ? "whole.gz" : "zlib"), NULL));
        io_ok(coding ? VV_OK : vvi_sink_write(sink, "abc", 3));
        io_ok(vvi_sink_coding(sink, coding ? VVI_CODING_GZIP : VVI_CODING_ZLIB, 0));
        io_ok(coding ? vvi_sink_write(sink, "abc", 3) : VV_OK);
        io_ok(vvi_sink_write(sink, values, sizeof values));
        io_ok(vvi_sink_commit(sink));
    }
    for (size_t c = 0; c < sizeof cases / sizeof *cases; c++) {
        vv_field *field = read_with(state, "m.vvh", cases[c]);
        for (int i = 0; i < 12; i++)
            assert_float_equal(vv_field_value(field, i % 2, i / 2 % 2, i / 4, 0), values[i], 0);
        vv_field_release(field);
    }
}

static void a_vvh_places_scales_and_names(void **state)
{
    vv_field *field = read_with(state, "p.vvh",
                                "dims: 2 2 2\ntype: u8\nspacing: 2 3 4\norigin: 5 6 7\ndirections: 0 1 0 1 0 0 0 0 -1\n"
                                "space: LPS\nscale: 0.5\noffset: -3\nvalue unit: HU\nname: a name: with colon\n"
                                "frames: 4\nframe step: 2\nframe unit: s\ncomment: said\ndata: data\n");
    const vv_field_info *info = vv_field_get_info(field);
    const vv_affine *a = &info->grid.index_to_world;
    assert_true(a->axis[0].y == -2 && a->axis[1].x == -3 && a->axis[2].z == -4);
    assert_true(a->origin.x == -5 && a->origin.y == -6 && a->origin.z == 7);
    assert_int_equal(info->grid.space, VV_SPACE_RAS);
    assert_string_equal(info->grid.unit, "mm");
    assert_string_equal(info->value_unit, "HU");
    assert_string_equal(info->name, "a name: with colon");
    assert_string_equal(info->frame_unit, "s");
    assert_true(info->n_frames == 4 && info->frame_step == 2);
    assert_float_equal(vv_field_value(field, 1, 1, 1, 0), 7 * 0.5 - 3, 0);
    vv_field_release(field);
}

/* dat ----------------------------------------------------------------------------------------------------------------
 */

#define DAT "ObjectFileName: data\nResolution: 2 2 2\n"

static void a_dat_says_what_its_data_file_holds(void **state)
{
    vv_field *field = read_with(state, "a.dat",
                                "ObjectFileName:\tdata\nTaggedFileName:\t---\nResolution:\t2 2 3\n"
                                "SliceThickness:\t0.5 1 2 \nFormat:\tUSHORT\nNbrTags:\t0\nObjectModel:\tRGBA\n");
    assert_int_equal(vv_field_get_info(field)->components, 1); /* the data are too short for colours */
    assert_float_equal(vv_grid_spacing(&vv_field_get_info(field)->grid, 2), 2, 0);
    assert_float_equal(vv_field_value(field, 1, 0, 0, 0), 0x0302, 0);
    vv_field_release(field);
    field = read_with(state, "b.dat", "ObjectFileName: data\nResolution: 4 2 2\nFormat: UCHAR\nObjectModel: RGBA\n");
    assert_int_equal(vv_field_get_info(field)->meaning, VV_MEANING_RGBA); /* 64 bytes: four a sample */
    assert_float_equal(vv_field_value(field, 1, 1, 1, 2), 4 * 13 + 2, 0);
    vv_field_release(field);
    field = read_with(state, "c.dat", DAT "Format: USHORT\nByteOrder: big\n");
    assert_float_equal(vv_field_value(field, 1, 0, 0, 0), 0x0203, 0);
    vv_field_release(field);
}

static void each_lie_of_a_dat_is_one_sentence(void **state)
{
    static const lie lies[] = {
        {DAT, "no 'Format'", VV_E_FORMAT},
        {DAT "Format: UCHR\n", "'UCHR'; UCHAR", VV_E_FORMAT},
        {DAT "Format: UCHAR9\n", "'UCHAR9'", VV_E_FORMAT},
        {DAT "Format: UCHAR\nno colon\n", "is not 'Key: value'", VV_E_FORMAT},
        {DAT "Format: UCHAR\nSliceThickness: 1 -1 1\n", "more than 0", VV_E_FORMAT},
        {"ObjectFileName: data\nResolution: 2 2\nFormat: UCHAR\n", "expected 3", VV_E_FORMAT},
        {"ObjectFileName: data\nResolution: 9 9 9\nFormat: UCHAR\n", "were expected", VV_E_FORMAT},
        {"ObjectFileName: ../data\nResolution: 2 2 2\nFormat: UCHAR\n", "--allow-outside", VV_E_READ},
        {"ObjectFileName: none\nResolution: 2 2 2\nFormat: UCHAR\n", "none", VV_E_READ},
        {"ObjectFileName:\nResolution: 2 2 2\nFormat: UCHAR\n", "names no file", VV_E_FORMAT},
    };
    uint8_t zeros[64] = {0};
    io_put(io_path(state, "data"), zeros, 64);
    refuse_all(state, "l.dat", lies, sizeof lies / sizeof *lies);
}

/* Inrimage -----------------------------------------------------------------------------------------------------------
 */

/* A padded header of these lines and 64 bytes 0, 1, 2, ... */
static const char *write_inr(void **state, const char *lines)
{
    char bytes[320];
    const char *path = io_path(state, "t.inr");
    memset(bytes, '\n', 256);
    memcpy(bytes, "#INRIMAGE-4#{\n", 14);
    memcpy(bytes + 14, lines, strlen(lines));
    memcpy(bytes + 252, "##}\n", 4);
    for (int i = 0; i < 64; i++)
        bytes[256 + i] = (char)i;
    io_put(path, bytes, sizeof bytes);
    return path;
}

#define INR "XDIM=2\nYDIM=2\nZDIM=2\n"

static void an_inrimage_has_types_orders_and_scales(void **state)
{
    static const struct {
        const char *lines;
        vv_type type;
        int components;
        double value; /* of sample (1, 0, 0) */
    } cases[] = {
        {INR "VDIM=1\nTYPE=unsigned fixed\nPIXSIZE=8 bits\nSCALE=2**0\nCPU=decm\nVX=0.5\nTZ=3\n", VV_TYPE_U8, 1, 1},
        {INR "TYPE=unsigned fixed\nPIXSIZE=16 bits\nCPU=decm\n", VV_TYPE_U16, 1, 0x0302},
        {INR "TYPE=signed fixed\nPIXSIZE=16 bits\nCPU=sun\nSCALE=2**-3\n", VV_TYPE_I16, 1, 0x0203 / 8.0},
        {INR "TYPE=signed fixed\nPIXSIZE=32 bits\nCPU=pc\n", VV_TYPE_I32, 1, 0x07060504},
        {INR "VDIM=3\nTYPE=unsigned fixed\nPIXSIZE=8 bits\n", VV_TYPE_U8, 3, 3},
    };
    for (size_t c = 0; c < sizeof cases / sizeof *cases; c++) {
        vv_file *file = io_open(write_inr(state, cases[c].lines));
        vv_field *field = io_frame(file, 0);
        assert_int_equal(vv_file_info(file)->type, cases[c].type);
        assert_int_equal(vv_file_info(file)->components, cases[c].components);
        assert_float_equal(vv_field_value(field, 1, 0, 0, 0), cases[c].value, 0);
        if (c == 0)
            assert_true(vv_file_info(file)->grid.index_to_world.axis[0].x == 0.5 &&
                        vv_file_info(file)->grid.index_to_world.origin.z == 3);
        vv_field_release(field);
        vv_file_close(file);
    }
}

static void each_lie_of_an_inrimage_is_one_sentence(void **state)
{
    static const lie lies[] = {
        {"XDIM=2\nYDIM=0\n", "'YDIM' has 0", VV_E_FORMAT},
        {"YDIM=2\n", "no 'XDIM'", VV_E_FORMAT},
        {INR "TYPE=packed\nPIXSIZE=8 bits\n", "'packed' of 8 bits", VV_E_FORMAT},
        {INR "TYPE=unsigned fixed\nPIXSIZE=12 bits\n", "of 12 bits", VV_E_FORMAT},
        {INR "TYPE=unsigned fixed\nPIXSIZE=8 bytes\n", "number of bits", VV_E_FORMAT},
        {INR "TYPE=unsigned fixed\nPIXSIZE=16 bits\n", "no 'CPU'", VV_E_FORMAT},
        {INR "TYPE=unsigned fixed\nPIXSIZE=16 bits\nCPU=cray\n", "'cray'", VV_E_FORMAT},
        {INR "TYPE=unsigned fixed\nPIXSIZE=8 bits\nSCALE=3**2\n", "power of two", VV_E_FORMAT},
        {INR "TYPE=unsigned fixed\nPIXSIZE=8 bits\nVY=0\n", "longer than 0", VV_E_FORMAT},
        {INR "TYPE=unsigned fixed\nPIXSIZE=8 bits\nVDIM=90\n", "were expected", VV_E_FORMAT},
        {INR INR, "twice", VV_E_FORMAT},
    };
    for (size_t i = 0; i < sizeof lies / sizeof *lies; i++)
        io_refused(write_inr(state, lies[i].text), lies[i].status, lies[i].words);
    io_put_text(io_path(state, "e.inr"), "#INRIMAGE-4#{\nXDIM=2\n");
    io_refused(io_path(state, "e.inr"), VV_E_FORMAT, "'##}' is missing");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(each_lie_of_a_vvh_is_one_sentence),
        cmocka_unit_test(orders_of_axes_are_any),
        cmocka_unit_test(many_files_codings_and_places_are_understood),
        cmocka_unit_test(a_vvh_places_scales_and_names),
        cmocka_unit_test(a_dat_says_what_its_data_file_holds),
        cmocka_unit_test(each_lie_of_a_dat_is_one_sentence),
        cmocka_unit_test(an_inrimage_has_types_orders_and_scales),
        cmocka_unit_test(each_lie_of_an_inrimage_is_one_sentence),
    };
    return cmocka_run_group_tests(tests, io_setup, io_teardown);
}
