/* Files of grids (VTK, OpenDX, Gaussian cube) that are cut short, changed or lie: read, partly read and said, or
 * refused with one sentence; never wrong dims, never a crash. */
#include "core/memory.h"
#include "fail_alloc.h"
#include "fields.h"
#include "io_test.h"
#include "jobs.h"
#include <time.h>

static vv_status read_all(const char *path, vv_field_info *info_out, vv_job *job)
{
    vv_file *file;
    vv_field *field;
    vv_status st = vv_file_open(&file, path, NULL, job);
    if (st != VV_OK)
        return st;
    *info_out = *vv_file_info(file);
    st = vv_file_read(&field, file, 0, NULL, job);
    if (st == VV_OK)
        vv_field_release(field);
    vv_file_close(file);
    return st;
}

typedef struct seed {
    const char *name, *encoding, *text; /* without text: written by us */
} seed;

#define VTR                                                                                                            \
    "<VTKFile type=\"RectilinearGrid\" byte_order=\"LittleEndian\"><RectilinearGrid WholeExtent=\"0 2 0 1 0 0\">"      \
    "<FieldData><DataArray type=\"Float64\" Name=\"TimeValue\" NumberOfTuples=\"1\" format=\"ascii\">2.5</DataArray>"  \
    "</FieldData><Piece Extent=\"0 2 0 1 0 0\"><Coordinates><DataArray type=\"Float32\" format=\"ascii\">0 1 3"        \
    "</DataArray><DataArray type=\"Float32\" format=\"ascii\">5 4</DataArray><DataArray type=\"Float32\" "             \
    "format=\"ascii\">7</DataArray></Coordinates><PointData Scalars=\"a\"><DataArray type=\"UInt8\" Name=\"a\" "       \
    "format=\"ascii\">1 2 3 4 5 6</DataArray></PointData></Piece></RectilinearGrid></VTKFile>"
#define VTK                                                                                                            \
    "# vtk DataFile Version 3.0\ntitle\nASCII\nDATASET RECTILINEAR_GRID\nDIMENSIONS 3 2 1\nX_COORDINATES 3 float\n"    \
    "0 1 3\nY_COORDINATES 2 float\n5 4\nZ_COORDINATES 1 float\n7\nPOINT_DATA 6\nSCALARS a%20b short 1\nLOOKUP_TABLE "  \
    "default\n1 2 3 4 5 6\nMETADATA\nINFORMATION 0\n\nFIELD f 1\nx 1 6 float\n1 2 3 4 5 6\nCELL_DATA 2\nSCALARS c "    \
    "unsigned_char\nLOOKUP_TABLE default\n1 2\n"
#define VTKB                                                                                                           \
    "# vtk DataFile Version 2.0\nbytes\nBINARY\nDATASET STRUCTURED_POINTS\nDIMENSIONS 3 2 1\nORIGIN 0 0 0\nSPACING 1 " \
    "1 1\nPOINT_DATA 6\nSCALARS a short\nLOOKUP_TABLE default\nabcdefghijkl\nVECTORS v unsigned_char\n"                \
    "abcdefghijklmnopqr\nCOLOR_SCALARS c 2\nabcdefghijkl\nLOOKUP_TABLE l 1\nabcd\n"

#define DX                                                                                                             \
    "# c\nobject 1 class array type float rank 1 shape 2 items 6 text data follows\n1 2 3 4 5 6 7 8 9 10 11 12\n"      \
    "attribute \"dep\" string \"positions\"\nobject 2 class gridpositions counts 3 2 1\norigin 0 0 0\ndelta 1 0 0\n"   \
    "delta 0 1 0\ndelta 0 0 1\nobject \"f\" class field\ncomponent \"data\" value 1\ncomponent \"positions\" value "   \
    "2\n"                                                                                                              \
    "end\n"
#define DXB                                                                                                            \
    "object 1 class array type short rank 0 items 6 lsb ieee data 0\nobject 2 class gridpositions counts 3 2\n"        \
    "object 3 class field\ncomponent \"data\" value 1\ncomponent \"positions\" value 2\nend\nabcdefghijkl"
#define GENERAL                                                                                                        \
    "file = g.bin\ngrid = 3 x 2 x 1\nformat = lsb binary\nfield = a, b\ntype = byte, byte\nstructure = "               \
    "scalar, scalar\nheader = bytes 2\npositions = 0, 1, 0, 1, 0, 1\nend\n"
#define CUBE                                                                                                           \
    "t\nu\n -1 0.0 0.0 0.0\n 3 1.0 0.0 0.0\n 2 0.0 1.0 0.0\n 1 0.0 0.0 1.0\n 6 6.0 1.0 2.0 3.0\n 2 4 5\n1 2 3 4 5 6 "  \
    "7 8 9 "                                                                                                           \
    "10 11 12\n"

static const seed seeds[] = {{"s.vti", "raw", NULL},   {"s.vti", "zlib", NULL},      {"s.vti", "base64", NULL},
                             {"s.vti", "ascii", NULL}, {"s.vtr", NULL, VTR},         {"t.vtk", NULL, VTK},
                             {"b.vtk", NULL, VTKB},    {"s.vti.gz", "zlib", NULL},   {"s.dx", NULL, DX},
                             {"b.dx", NULL, DXB},      {"s.general", NULL, GENERAL}, {"s.cube", NULL, CUBE}};
#define N_SEEDS (sizeof seeds / sizeof *seeds)

static uint8_t *make_seed(void **state, const seed *s, size_t *n)
{
    vv_field_info info = vv_field_info_default();
    const int64_t dims[3] = {5, 3, 2};
    io_put(io_path(state, "g.bin"), "..abcdefghijkl", 14);
    if (s->text) {
        io_put_text(io_path(state, s->name), s->text);
        return io_get(io_path(state, s->name), n);
    }
    memcpy(info.grid.dims, dims, sizeof dims);
    info.grid.index_to_world.origin.x = 2.5;
    strcpy(info.grid.unit, "mm");
    info.type = VV_TYPE_F32;
    vv_field *field = test_field_random(&info, 11, NULL);
    io_write(io_path(state, s->name), field, s->encoding, false);
    vv_field_release(field);
    return io_get(io_path(state, s->name), n);
}

static void every_truncation_is_read_in_part_or_refused(void **state)
{
    for (size_t s = 0; s < N_SEEDS; s++) {
        size_t n;
        uint8_t *bytes = make_seed(state, &seeds[s], &n);
        char path[4096];
        vv_field_info whole, info;
        snprintf(path, sizeof path, "%s", io_path(state, seeds[s].name));
        io_ok(read_all(path, &whole, NULL));
        for (size_t keep = 0; keep < n; keep++) {
            vv_job *job = test_job(1, 0);
            io_put(path, bytes, keep);
            const vv_status st = read_all(path, &info, job);
            if (st == VV_OK) {
                assert_memory_equal(info.grid.dims, whole.grid.dims, sizeof info.grid.dims);
            } else {
                assert_true(st == VV_E_FORMAT || st == VV_E_ARGUMENT || st == VV_E_UNSUPPORTED);
                assert_null(strchr(vv_error_last()->message, '\n'));
            }
            vv_job_release(job);
        }
        free(bytes);
    }
}

static void mutations_are_read_or_refused(void **state)
{
    const uint64_t random = test_seed();
    uint64_t next = 0;
    struct timespec begin, end;
    for (size_t s = 0; s < N_SEEDS; s++) {
        size_t n;
        uint8_t *bytes = make_seed(state, &seeds[s], &n), *mutant = malloc(n);
        char path[4096];
        snprintf(path, sizeof path, "%s", io_path(state, seeds[s].name));
        vv_job *job = test_job(1, UINT64_C(64) << 20);
        for (int m = 0; m < 1000; m++) {
            vv_field_info info = {0};
            memcpy(mutant, bytes, n);
            for (int changes = 1 + (int)(test_random(random, next++) % 4); changes > 0; changes--) {
                const size_t at = test_random(random, next++) % n;
                const uint64_t how = test_random(random, next++);
                mutant[at] = (uint8_t)(how % 3 == 0   ? mutant[at] ^ UINT64_C(1) << (how >> 8) % 8
                                       : how % 3 == 1 ? '0' + (how >> 8) % 10
                                                      : how >> 8);
            }
            io_put(path, mutant, n);
            clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &begin);
            const vv_status st = read_all(path, &info, job);
            clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &end);
            assert_true(end.tv_sec - begin.tv_sec <= 10);
            if (st == VV_OK)
                assert_true(info.grid.dims[0] >= 1 && info.grid.dims[1] >= 1 && info.grid.dims[2] >= 1);
            else
                assert_true(vv_error_last()->message[0]);
        }
        vv_job_release(job);
        free(mutant);
        free(bytes);
    }
}

/* One place of a text seed changed: what must be said. */
static const struct {
    const char *text, *was, *is, *words;
    vv_status status;
} lies[] = {
    {VTR, "RectilinearGrid\"", "PRectilinearGrid\"", "other files", VV_E_UNSUPPORTED},
    {VTR, "RectilinearGrid\"", "PolyData\"", "not a regular grid", VV_E_UNSUPPORTED},
    {VTR, "LittleEndian", "MiddleEndian", "byte_order", VV_E_FORMAT},
    {VTR, "byte_order", "compressor=\"x\" byte_order", "zlib, LZ4 and LZMA", VV_E_UNSUPPORTED},
    {VTR, "byte_order", "header_type=\"UInt8\" byte_order", "header_type", VV_E_FORMAT},
    {VTR, "WholeExtent=\"0 2", "WholeExtent=\"2 0", "WholeExtent", VV_E_FORMAT},
    {VTR, "WholeExtent=\"0 2", "WholeExtent=\"0 9999999999", "WholeExtent", VV_E_FORMAT},
    {VTR, "WholeExtent=\"0 2", "WholeExtent=\"0 1", "outside", VV_E_FORMAT},
    {VTR, "WholeExtent=\"0 2", "WholeExtent=\"0 9", "less than half", VV_E_FORMAT},
    {VTR, ">0 1 3<", ">0 1 1<", "must be ascending", VV_E_FORMAT},
    {VTR, ">0 1 3<", ">0 nan 3<", "must be ascending", VV_E_FORMAT},
    {VTR, ">0 1 3<", ">0 1<", "cut short", VV_E_FORMAT},
    {VTR, "\"UInt8\"", "\"String\"", "no array of numbers", VV_E_FORMAT},
    {VTR, "1 2 3 4 5 6", "1 2 3 4 5 256", "not u8", VV_E_FORMAT},
    {VTR, "1 2 3 4 5 6", "1", "needs more bytes", VV_E_FORMAT},
    {VTR, "format=\"ascii\">1", "format=\"appended\">1", "offset", VV_E_FORMAT},
    {VTR, "format=\"ascii\">1", "format=\"appended\" offset=\"7\">1", "nothing is appended", VV_E_FORMAT},
    {VTR, "format=\"ascii\">1", "format=\"hex\">1", "format", VV_E_FORMAT},
    {VTR, "<FieldData>", "<FieldData x=\"&e;\">", "undefined entity", VV_E_FORMAT},
    {VTR, "<FieldData>", "<FieldData><!-- -- -->", "well-formed", VV_E_FORMAT},
    {VTR, "<VTKFile", "<!DOCTYPE VTKFile [<!ENTITY e 'x'>]><VTKFile", "document type", VV_E_UNSUPPORTED},
    {VTK, "ASCII", "OCTAL", "ASCII or BINARY", VV_E_FORMAT},
    {VTK, "RECTILINEAR_GRID", "POLYDATA", "save it as .vtp or .ply", VV_E_UNSUPPORTED},
    {VTK, "RECTILINEAR_GRID", "STRUCTURED_GRID", "not a regular grid", VV_E_UNSUPPORTED},
    {VTK, "DIMENSIONS 3", "DIMENSIONS 0", "whole numbers", VV_E_FORMAT},
    {VTK, "DIMENSIONS 3", "DIMENSIONS 4", "as many coordinates", VV_E_FORMAT},
    {VTK, "DIMENSIONS 3", "DIMENSION 3", "not a known statement", VV_E_FORMAT},
    {VTK, "X_COORDINATES 3 float", "X_COORDINATES 3 quad", "not a known type of numbers", VV_E_UNSUPPORTED},
    {VTK, "Y_COORDINATES", "Z_COORDINATES", "out of order", VV_E_FORMAT},
    {VTK, "POINT_DATA 6", "POINT_DATA 7", "the grid has 6", VV_E_FORMAT},
    {VTKB, "SPACING 1", "SPACING 0", "spacing along x is 0", VV_E_FORMAT},
    {VTKB, "SPACING 1", "SPACING x", "three finite numbers", VV_E_FORMAT},
    {VTKB, "DIMENSIONS 3 2 1", "DIMENSIONS 999 999 999", "the grid has", VV_E_FORMAT},
    {DX, "counts 3", "counts 4", "6 items but its grid needs 8", VV_E_FORMAT},
    {DX, "counts 3", "counts 0", "count of at least 1", VV_E_FORMAT},
    {DX, "gridpositions", "array", "irregular", VV_E_UNSUPPORTED},
    {DX, "type float", "type string", "type that is not supported", VV_E_UNSUPPORTED},
    {DX, "rank 1", "rank 2", "expected", VV_E_FORMAT},
    {DX, "origin 0", "origin x", "finite number", VV_E_FORMAT},
    {DX, "delta 1", "delta 0", "do not span space", VV_E_FORMAT},
    {DX, "1 2 3", "1 2 x", "which is not f64", VV_E_FORMAT},
    {DX, "items 6", "items 9999999999", "which is not f64", VV_E_FORMAT},
    {DX, "value 1", "value 7", "no array of data", VV_E_FORMAT},
    {DXB, "data 0", "data 100", "ends after", VV_E_FORMAT},
    {DXB, "data 0", "data file ../../x 0", "--allow-outside", VV_E_READ},
    {GENERAL, "3 x 2", "3 by 2", "whole numbers with x", VV_E_FORMAT},
    {GENERAL, "3 x 2", "300 x 200", "ends after", VV_E_FORMAT},
    {GENERAL, "grid = 3 x 2 x 1", "gird = 3 x 2 x 1", "grid", VV_E_FORMAT},
    {GENERAL, "g.bin", "/etc/passwd", "--allow-outside", VV_E_READ},
    {GENERAL, "byte, byte", "word, byte", "not a type of numbers", VV_E_FORMAT},
    {GENERAL, "header = bytes 2", "header = lines 2", "only 'bytes N'", VV_E_FORMAT},
    {GENERAL, "field", "interleaving = field\nfield", "interleaved", VV_E_UNSUPPORTED},
    {GENERAL, "0, 1, 0", "irregular, 1, 0", "irregular", VV_E_UNSUPPORTED},
    {GENERAL, "0, 1, 0", "0, 0, 0", "step of 0", VV_E_FORMAT},
    {CUBE, " 3 1.0", " 0 1.0", "number of steps", VV_E_FORMAT},
    {CUBE, " 3 1.0", " 3 inf", "number of steps", VV_E_FORMAT},
    {CUBE, "6 6.0", "C 6.0", "an atom", VV_E_FORMAT},
    {CUBE, " 2 4 5", " 0 4 5", "orbitals", VV_E_FORMAT},
    {CUBE, " 3 1.0", " 300000 1.0", "expected", VV_E_FORMAT},
};

static void each_lie_is_one_clear_sentence(void **state)
{
    for (size_t c = 0; c < sizeof lies / sizeof *lies; c++) {
        const char *at = strstr(lies[c].text, lies[c].was);
        char text[4096];
        assert_non_null(at);
        snprintf(text, sizeof text, "%.*s%s%s", (int)(at - lies[c].text), lies[c].text, lies[c].is,
                 at + strlen(lies[c].was));
        const char *name = lies[c].text[0] == 't' ? "lie.cube" : lies[c].text[0] == 'f' ? "lie.general" : "lie.vtr";
        io_put(io_path(state, "g.bin"), "..abcdefghijkl", 14);
        io_put_text(io_path(state, name), text);
        io_refused(io_path(state, name), lies[c].status, lies[c].words);
    }
}

/* A few bytes that promise a terabyte, in each way that data can lie. */
static void promises_are_refused_before_memory_is_taken(void **state)
{
    static const char *const arrays[] = {
        "format=\"appended\" offset=\"0\"/></PointData></Piece></ImageData><AppendedData encoding='raw'>_abcdefgh",
        "format=\"appended\" offset=\"0\"/></PointData></Piece></ImageData><AppendedData encoding=\"base64\">_AAAAAAAA",
        "format=\"binary\">AAAAAAAAAAAAAAAAAAAAAAAAAAAA</DataArray></PointData></Piece></ImageData></VTKFile>",
        "format=\"ascii\">1 2 3</DataArray></PointData></Piece></ImageData></VTKFile>"};
    for (int compressed = 0; compressed < 2; compressed++)
        for (size_t a = 0; a < sizeof arrays / sizeof *arrays; a++) {
            char text[2048];
            vv_field_info info;
            vv_job *job = test_job(1, UINT64_C(16) << 20);
            snprintf(text, sizeof text,
                     "<VTKFile type=\"ImageData\" %s><ImageData WholeExtent=\"0 9999 0 9999 0 9999\" Spacing=\"1 1 1\">"
                     "<Piece><PointData><DataArray type=\"UInt8\" Name=\"a\" %s",
                     compressed ? "compressor=\"vtkZLibDataCompressor\"" : "", arrays[a]);
            io_put_text(io_path(state, "much.vti"), text);
            assert_int_equal(read_all(io_path(state, "much.vti"), &info, job), VV_E_FORMAT);
            vv_job_release(job);
        }
}

/* A flipped bit in one packed block of four leaves the others. */
static void a_damaged_block_is_nan_and_said(void **state)
{
    vv_field_info info = vv_field_info_default();
    info.grid.dims[0] = info.grid.dims[1] = 64;
    info.grid.dims[2] = 64;
    info.type = VV_TYPE_F32;
    vv_field *field = test_field_random(&info, 3, NULL);
    size_t n;
    io_write(io_path(state, "damaged.vti"), field, "zlib", false);
    uint8_t *bytes = io_get(io_path(state, "damaged.vti"), &n);
    memset(bytes + n - 2000, 0x55, 64);
    io_put(io_path(state, "damaged.vti"), bytes, n);
    free(bytes);
    vv_job *job = test_job(2, 0);
    vv_file *file;
    vv_field *back;
    io_ok(vv_file_open(&file, io_path(state, "damaged.vti"), NULL, job));
    io_ok(vv_file_read(&back, file, 0, NULL, job));
    assert_true(vv_job_damaged(job));
    assert_true(isnan(vv_field_value(back, 63, 63, 63, 0)));
    assert_true(vv_field_value(back, 0, 0, 0, 0) == vv_field_value(field, 0, 0, 0, 0));
    vv_field_release(back);
    vv_field_release(field);
    vv_file_close(file);
    vv_job_release(job);
}

typedef struct action {
    void **state;
    const char *name;
} action;

static vv_status act_read(void *user)
{
    const action *a = user;
    vv_field_info info;
    return read_all(io_path(a->state, a->name), &info, NULL);
}

static void every_failing_allocation_is_an_error_without_a_leak(void **state)
{
    for (size_t s = 0; s < N_SEEDS; s++) {
        size_t n;
        action a = {state, seeds[s].name};
        free(make_seed(state, &seeds[s], &n));
        assert_true(test_fail_each_alloc(act_read, &a) > 3);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_truncation_is_read_in_part_or_refused),
        cmocka_unit_test(mutations_are_read_or_refused),
        cmocka_unit_test(each_lie_is_one_clear_sentence),
        cmocka_unit_test(promises_are_refused_before_memory_is_taken),
        cmocka_unit_test(a_damaged_block_is_nan_and_said),
        cmocka_unit_test(every_failing_allocation_is_an_error_without_a_leak),
    };
    return cmocka_run_group_tests(tests, io_setup, io_teardown);
}
