/* Writes the seeds of all fuzz targets: the smallest file of each dialect, made by our own writers, and texts.
 *   make_corpus FOLDER */
#include "fields.h"
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <volvis/volvis.h>

static const char *root;

static void stop(const char *what)
{
    fprintf(stderr, "make_corpus: %s: %s\n", what, vv_error_last()->message);
    exit(1);
}

static const char *path_of(const char *target, const char *name)
{
    static char path[4096];
    snprintf(path, sizeof path, "%s/%s", root, target);
    if (mkdir(path, 0755) != 0 && errno != EEXIST)
        stop(path);
    snprintf(path, sizeof path, "%s/%s/%s", root, target, name);
    return path;
}

static void put(const char *target, const char *name, const void *data, size_t n)
{
    FILE *file = fopen(path_of(target, name), "wb");
    if (!file || fwrite(data, 1, n, file) != n || fclose(file) != 0)
        stop(name);
}

static void put_text(const char *target, const char *name, const char *text)
{
    put(target, name, text, strlen(text));
}

static vv_field_info seed_info(vv_type type, int components, vv_meaning meaning)
{
    vv_field_info info = vv_field_info_default();
    info.grid.dims[0] = 3;
    info.grid.dims[1] = 2;
    info.grid.dims[2] = 2;
    info.grid.index_to_world.axis[1].y = -1.5;
    info.grid.space = VV_SPACE_RAS;
    strcpy(info.grid.unit, "mm");
    info.type = type;
    info.components = components;
    info.meaning = meaning;
    info.frame_step = 2;
    strcpy(info.frame_unit, "s");
    strcpy(info.name, "seed");
    return info;
}

static void write_volume(const char *target, const char *name, const char *encoding, const vv_field_info *info,
                         int n_frames, bool big_endian)
{
    vv_field *frame[2] = {test_field_random(info, 1, NULL), test_field_random(info, 2, NULL)};
    vv_write_options options;
    vv_write_options_init(&options, sizeof options);
    options.encoding = encoding;
    options.big_endian = big_endian;
    if (vv_field_write(path_of(target, name), (const vv_field *const *)frame, (size_t)n_frames, &options, NULL) !=
        VV_OK)
        stop(name);
    vv_field_release(frame[0]);
    vv_field_release(frame[1]);
}

static void write_volumes(void)
{
    static const char *const encodings[] = {"raw", "ascii", "hex", "gzip", "bzip2"};
    char name[64];
    for (int type = 0; type < VV_TYPE_COUNT; type++) {
        const vv_field_info info = seed_info((vv_type)type, 1, VV_MEANING_SCALAR);
        snprintf(name, sizeof name, "%s-%s.nrrd", encodings[type % 5], vv_type_name((vv_type)type));
        write_volume("nrrd", name, encodings[type % 5], &info, 1 + type % 2, type % 3 == 0);
        snprintf(name, sizeof name, "%s.nii", vv_type_name((vv_type)type));
        write_volume("nifti", name, NULL, &info, 1 + type % 2, type % 3 == 0);
        snprintf(name, sizeof name, "%s.npy", vv_type_name((vv_type)type));
        write_volume("npy", name, NULL, &info, 1 + type % 2, type % 3 == 0);
    }
    const vv_field_info rgb = seed_info(VV_TYPE_U8, 3, VV_MEANING_RGB);
    const vv_field_info vector = seed_info(VV_TYPE_F32, 3, VV_MEANING_VECTOR);
    const vv_field_info label = seed_info(VV_TYPE_U16, 1, VV_MEANING_LABEL);
    write_volume("nrrd", "rgb.nrrd", "raw", &rgb, 1, false);
    write_volume("nrrd", "vector.nrrd", "gzip", &vector, 2, true);
    write_volume("nrrd", "label.nrrd", "bzip2", &label, 1, false);
    write_volume("nifti", "rgb.nii", NULL, &rgb, 1, false);
    write_volume("nifti", "vector.nii", NULL, &vector, 2, true);
    write_volume("nifti", "label.nii", NULL, &label, 1, false);
    write_volume("npy", "rgb.npy", NULL, &rgb, 1, false);
    write_volume("npy", "vector.npy", NULL, &vector, 2, true);
    vv_field_info wide = seed_info(VV_TYPE_U8, 1, VV_MEANING_SCALAR);
    wide.grid.dims[0] = 40000; /* the second version of NIfTI */
    wide.grid.dims[1] = wide.grid.dims[2] = 1;
    write_volume("nifti", "wide.nii", NULL, &wide, 1, false);
}

/* Two bytes that say how, then a coded stream: the volume files serve as such. */
static void write_sources(void)
{
    static const struct {
        const char *suffix;
        uint8_t coding;
    } codings[] = {{".raw", 0}, {".raw.gz", 1}, {".raw.bz2", 2}, {".raw.zst", 3}};
    const vv_field_info info = seed_info(VV_TYPE_U16, 1, VV_MEANING_SCALAR);
    for (size_t i = 0; i < 4; i++) {
        char name[64];
        uint8_t bytes[4096] = {codings[i].coding, 3};
        snprintf(name, sizeof name, "stream%s", codings[i].suffix);
        write_volume("source", name, NULL, &info, 2, false);
        FILE *file = fopen(path_of("source", name), "rb");
        const size_t n = file ? fread(bytes + 2, 1, sizeof bytes - 2, file) : 0;
        if (!file || fclose(file) != 0)
            stop(name);
        put("source", name, bytes, n + 2);
    }
}

static void write_texts(void)
{
    put_text(
        "nrrd", "dialects.nrrd",
        "NRRD0005\n# comment\ncontent: \"a\"\ntype: unsigned short int\ndimension: 4\nsizes: 2 2 2 2\nspace: LPS\n"
        "space directions: none (1,0,0) (0,0,-2) (0,1.5,0)\nspace origin: (1,2,3)\nspace units: \"mm\" \"mm\" \"mm\"\n"
        "kinds: list domain domain domain\ncenterings: ??? cell node cell\nlabels: \"c\" \"x\" \"y\" \"z\"\n"
        "measurement frame: (1,0,0) (0,1,0) (0,0,1)\nsample units: \"HU\"\nkey:=va\\nlue\nendian: big\nline skip: 1\n"
        "byte skip: 2\nencoding: raw\n\nskipped\nab0123456789abcdef0123456789abcdef");
    put_text("nrrd", "mins.nrrd",
             "NRRD0001\ntype: float\ndimension: 2\nsizes: 2 2\naxis mins: 0 1\naxis maxs: 3 nan\ncenters: node cell\n"
             "units: \"um\" \"um\"\nencoding: txt\n\n1 2.5, nan -inf");
    put_text("nrrd", "detached.nrrd",
             "NRRD0004\ntype: uchar\ndimension: 3\nsizes: 1 1 2\nencoding: raw\ndata file: slice%03d.raw 1 2 1 2\n");
    put_text("nrrd", "list.nrrd",
             "NRRD0004\ntype: uchar\ndimension: 3\nsizes: 1 1 2\nencoding: gz\ndata file: LIST 2\na.gz\nb.gz\n");
    put_text("raw", "u8", "2x2x2,u8\n01234567");
    put_text("raw", "all", "1x2x1x2,u16x2,spacing=1x1.5x2,big,skip=3\n...0123456789abcdef");
    put_text("scene", "empty", "{}");
    put_text("scene", "world",
             "{\"unit\": \"mm\", \"lights\": {\"key\": {\"kind\": \"point\", \"intensity\": 2}}, \"cut_planes\": "
             "[{\"offset\": \"2cm\"}], \"views\": {\"main\": {\"width\": 64}}}");
    put_text("path", "sets",
             "lights.key.intensity=2\nviews.main.width=64\ncut_planes.0.offset=1.5mm\nunit=mm\nlights.key=null\n"
             "views.main.camera.fov=30deg\nbackground=1,0,0");
    static const char *const quantities[] = {"1.5mm", "30deg",   "2s",     "8G",  "50%",
                                             "3vox",  "-1e-300", "0.1rad", "inf", "1e400"};
    for (size_t i = 0; i < sizeof quantities / sizeof *quantities; i++) {
        char name[32], text[32];
        snprintf(name, sizeof name, "quantity%zu", i);
        snprintf(text, sizeof text, "%c%s", (int)('0' + i % 6), quantities[i]);
        put_text("unit", name, text);
        put_text("unit", quantities[i], quantities[i]);
    }
}

static void write_image(const char *target, const char *name, const vv_image *image, int bits, unsigned layers)
{
    vv_text text = {(char[]){"VolVis:Scene"}, (char[]){"{}"}};
    vv_image_options options;
    vv_image_options_init(&options, sizeof options);
    options.bits = bits;
    options.layers = layers;
    options.text = &text;
    options.n_text = 1;
    const vv_status st = vv_image_write(path_of(target, name), image, &options, NULL);
    if (st != VV_OK && st != VV_E_UNSUPPORTED) /* built without its library */
        stop(name);
}

static void write_images(void)
{
    const unsigned layers = (1u << VV_LAYER_COUNT) - 1;
    vv_image *image;
    if (vv_image_new(&image, 19, 18, layers, NULL) != VV_OK)
        stop("image");
    for (size_t i = 0; i < 19 * 18 * 4; i++)
        image->rgba[i] = i % 4 == 3 ? 1 : (float)test_random_unit(1, i);
    write_image("jpeg", "colour.jpg", image, 0, 0);
    write_image("exr", "half.exr", image, 16, 0);
    write_image("exr", "layers.exr", image, 32, layers);
    write_image("pfm", "colour.pfm", image, 0, 0);
    write_image("pfm", "beside.pfm", image, 0, VV_LAYER_DEPTH);
    vv_image_release(image);
    put_text("pfm", "text", "Pf\n1 2\n1.0\n01234567");
    put_text("jpeg", "text", "\xff\xd8\xff\xfe");
    put_text("exr", "text", "v/1\001");
}

int main(int argc, char **argv)
{
    if (argc != 2) {
        fprintf(stderr, "make_corpus FOLDER\n");
        return 2;
    }
    root = argv[1];
    if (mkdir(root, 0755) != 0 && errno != EEXIST)
        stop(root);
    write_volumes();
    write_sources();
    write_images();
    write_texts();
    return 0;
}
