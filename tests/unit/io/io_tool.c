/* What the oracle script (oracle.py) drives: writes files whose samples are a formula, and says what it reads.
 *   io_tool write FOLDER     one file a line on standard output: path, then the info as dump prints it
 *   io_tool dump FILE OUT    the info as one JSON line; all frames' samples as float64, x fastest, to OUT */
#include "fields.h"
#include <inttypes.h>
#include <stdio.h>
#include <string.h>
#include <volvis/volvis.h>

static int complain(const char *what)
{
    fprintf(stderr, "%s: %s\n", what, vv_error_last()->message);
    return 1;
}

static void print_info(const vv_field_info *info)
{
    const vv_affine *a = &info->grid.index_to_world;
    printf("{\"dims\": [%" PRId64 ", %" PRId64 ", %" PRId64
           "], \"type\": \"%s\", \"components\": %d, \"frames\": %" PRId64
           ", \"scale\": %.17g, \"offset\": %.17g, \"unit\": \"%s\", \"space\": %d, \"meaning\": %d, ",
           info->grid.dims[0], info->grid.dims[1], info->grid.dims[2], vv_type_name(info->type), info->components,
           info->n_frames, info->value_scale, info->value_offset, info->grid.unit, info->grid.space, info->meaning);
    const vv_vec3 column[4] = {a->axis[0], a->axis[1], a->axis[2], a->origin};
    printf("\"columns\": [");
    for (int c = 0; c < 4; c++)
        printf("%s[%.17g, %.17g, %.17g]", c ? ", " : "", column[c].x, column[c].y, column[c].z);
    printf("]}");
}

static bool dump_frame(FILE *out, const vv_field *field)
{
    const vv_field_info *info = vv_field_get_info(field);
    for (int64_t k = 0; k < info->grid.dims[2]; k++)
        for (int64_t j = 0; j < info->grid.dims[1]; j++)
            for (int64_t i = 0; i < info->grid.dims[0]; i++)
                for (int c = 0; c < info->components; c++) {
                    const double v = vv_field_value(field, i, j, k, c);
                    if (fwrite(&v, sizeof v, 1, out) != 1)
                        return false;
                }
    return true;
}

static int dump(const char *path, const char *out_path)
{
    vv_file *file;
    if (vv_file_open(&file, path, NULL, NULL) != VV_OK)
        return complain(path);
    FILE *out = fopen(out_path, "wb");
    const vv_field_info *info = vv_file_info(file);
    bool good = out != NULL;
    for (int64_t f = 0; f < info->n_frames && good; f++) {
        vv_field *field;
        if (vv_file_read(&field, file, f, NULL, NULL) != VV_OK)
            return complain(path);
        good = dump_frame(out, field);
        vv_field_release(field);
    }
    if (good)
        print_info(info);
    printf("\n");
    if (out && fclose(out) != 0)
        good = false;
    vv_file_close(file);
    return good ? 0 : 1;
}

/* A grid of odd sizes in one of the 48 axis orientations. */
static vv_field_info some_info(int orientation, vv_type type)
{
    static const int orders[6][3] = {{0, 1, 2}, {0, 2, 1}, {1, 0, 2}, {1, 2, 0}, {2, 0, 1}, {2, 1, 0}};
    static const double spacing[3] = {0.7, 1.1, 2.3};
    vv_field_info info = vv_field_info_default();
    double m[3][3] = {{0}};
    for (int a = 0; a < 3; a++) {
        m[a][orders[orientation / 8][a]] = (orientation >> a & 1 ? -1 : 1) * spacing[a];
        info.grid.dims[a] = 7 - 2 * a;
    }
    for (int a = 0; a < 3; a++)
        info.grid.index_to_world.axis[a] = (vv_vec3){m[a][0], m[a][1], m[a][2]};
    info.grid.index_to_world.origin = (vv_vec3){10, -20, 30.5};
    info.grid.space = VV_SPACE_RAS;
    strcpy(info.grid.unit, "mm");
    info.type = type;
    return info;
}

static int write_one(const char *folder, int number, const char *suffix, const vv_field_info *info, bool big_endian,
                     int n_frames)
{
    char path[4096];
    vv_field *frame[3] = {NULL};
    vv_write_options options;
    vv_write_options_init(&options, sizeof options);
    options.big_endian = big_endian;
    snprintf(path, sizeof path, "%s/v%04d%s", folder, number, suffix);
    for (int f = 0; f < n_frames; f++)
        frame[f] = test_field_random(info, (uint64_t)(number * 10 + f), NULL);
    const vv_status st = vv_field_write(path, (const vv_field *const *)frame, (size_t)n_frames, &options, NULL);
    vv_field_info said = *info;
    said.n_frames = n_frames;
    char samples[4200];
    snprintf(samples, sizeof samples, "%s.f64", path);
    FILE *out = fopen(samples, "wb");
    for (int f = 0; f < n_frames; f++) {
        if (out && frame[f])
            dump_frame(out, frame[f]);
        vv_field_release(frame[f]);
    }
    if (st != VV_OK || !out || fclose(out) != 0)
        return complain(path);
    printf("%s\t", path);
    print_info(&said);
    printf("\n");
    return 0;
}

static int write_all(const char *folder)
{
    static const char *const suffixes[] = {".nii", ".nii.gz", ".hdr", ".npy"};
    int number = 0, bad = 0;
    for (int o = 0; o < 48; o++)
        for (size_t s = 0; s < 4; s++) {
            vv_field_info info = some_info(o, (vv_type)((o + (int)s) % VV_TYPE_COUNT));
            if (s < 3) {
                info.value_scale = o % 3 ? 1 : 0.5;
                info.value_offset = o % 3 ? 0 : -1024;
            }
            bad |= write_one(folder, number++, suffixes[s], &info, o % 2, o % 5 == 4 ? 3 : 1);
        }
    for (int c = 3; c <= 4; c++)
        for (size_t s = 0; s < 4; s++) {
            vv_field_info info = some_info(0, VV_TYPE_U8);
            info.components = c;
            info.meaning = c == 3 ? VV_MEANING_RGB : VV_MEANING_RGBA;
            bad |= write_one(folder, number++, suffixes[s], &info, false, 1);
            info.type = VV_TYPE_F32;
            info.meaning = VV_MEANING_SCALAR;
            bad |= write_one(folder, number++, suffixes[s], &info, true, 2);
        }
    return bad;
}

int main(int argc, char **argv)
{
    if (argc == 3 && strcmp(argv[1], "write") == 0)
        return write_all(argv[2]);
    if (argc == 4 && strcmp(argv[1], "dump") == 0)
        return dump(argv[2], argv[3]);
    fprintf(stderr, "io_tool write FOLDER | io_tool dump FILE OUT\n");
    return 2;
}
