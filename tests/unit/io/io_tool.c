/* What the oracle scripts drive (served.py): writes files whose samples are a formula, and says what it reads.
 *   io_tool write FOLDER     one file a line on standard output: path, then the info as dump prints it
 *   io_tool write-vti FOLDER     the same as VTK image data
 *   io_tool dump FILE OUT [PART]   the info as one JSON line; all frames' samples as float64, x fastest, to OUT
 *   io_tool stored FILE OUT [PART]   the same, the samples in their own type, without scale
 *   io_tool notes FILE [PART]      metadata and warnings, one a line
 *   io_tool copy FILE OUT [ENCODING [big]]   reads all frames and writes them
 *   io_tool serve [IMPORT_PROGRAM]   obeys the lines of its input, each such words with tabs between them; "done" and
 *                                    an exit code end each answer; with a program, that reads what should be contained
 * An empty word is as good as none. */
#include "fields.h"
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
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
    printf("], \"step\": %.17g, \"step_unit\": \"%s\", \"name\": \"", info->frame_step, info->frame_unit);
    for (const char *c = info->name; *c; c++)
        putchar(*c == '"' || *c == '\\' || (unsigned char)*c < ' ' ? '?' : *c);
    printf("\"");
}

static bool dump_row(FILE *out, double *row, const vv_field *field, int64_t j, int64_t k)
{
    const vv_field_info *info = vv_field_get_info(field);
    size_t n = 0;
    for (int64_t i = 0; i < info->grid.dims[0]; i++)
        for (int c = 0; c < info->components; c++)
            row[n++] = vv_field_value(field, i, j, k, c);
    return fwrite(row, sizeof *row, n, out) == n;
}

static bool dump_frame(FILE *out, const vv_field *field)
{
    const vv_field_info *info = vv_field_get_info(field);
    double *row = malloc((size_t)info->grid.dims[0] * (size_t)info->components * sizeof *row);
    bool good = row != NULL;
    for (int64_t k = 0; k < info->grid.dims[2]; k++)
        for (int64_t j = 0; j < info->grid.dims[1] && good; j++)
            good = dump_row(out, row, field, j, k);
    free(row);
    return good;
}

static bool write_row(FILE *out, const char *first, int64_t n, int64_t stride, size_t bytes)
{
    if (stride == (int64_t)bytes)
        return fwrite(first, bytes, (size_t)n, out) == (size_t)n;
    for (int64_t i = 0; i < n; i++)
        if (fwrite(first + i * stride, bytes, 1, out) != 1)
            return false;
    return true;
}

/* Without scale, in their own type: 64-bit integers are more than a double holds. */
static bool dump_stored(FILE *out, const vv_field *field)
{
    const vv_field_info *info = vv_field_get_info(field);
    const size_t bytes = vv_type_bytes(info->type) * (size_t)info->components;
    const vv_box box = vv_field_box(field);
    vv_brick brick;
    if (vv_field_brick(&brick, field, &box, NULL) != VV_OK) {
        complain("samples");
        return false;
    }
    bool good = true;
    for (int64_t k = 0; k < box.n[2]; k++)
        for (int64_t j = 0; j < box.n[1] && good; j++)
            good = write_row(out, (const char *)brick.data + j * brick.stride[1] + k * brick.stride[2], box.n[0],
                             brick.stride[0], bytes);
    vv_brick_release(&brick);
    return good;
}

static void print_channels(const vv_file *file)
{
    size_t n;
    const vv_channel *channels = vv_file_channels(file, &n);
    printf(", \"channels\": [");
    for (size_t i = 0; i < n; i++)
        printf("%s[\"%s\", %.6g, %.6g, %.6g, %.17g, %.17g]", i ? ", " : "", channels[i].name,
               channels[i].has_color ? channels[i].color.r : -1, channels[i].has_color ? channels[i].color.g : -1,
               channels[i].has_color ? channels[i].color.b : -1, channels[i].lo, channels[i].hi);
    printf("]}");
}

static vv_status open_part(vv_file **file, const char *path, const char *part, vv_job *job)
{
    vv_read_options options;
    vv_read_options_init(&options, sizeof options);
    options.part = part;
    return vv_file_open(file, path, &options, job);
}

static int dump(const char *path, const char *out_path, const char *part, bool stored, vv_job *job)
{
    vv_file *file;
    if (open_part(&file, path, part, job) != VV_OK)
        return complain(path);
    FILE *out = fopen(out_path, "wb");
    const vv_field_info *info = vv_file_info(file);
    bool good = out != NULL;
    for (int64_t f = 0; f < info->n_frames && good; f++) {
        vv_field *field = NULL;
        good = vv_file_read(&field, file, f, NULL, job) == VV_OK;
        if (!good)
            complain(path);
        else
            good = stored ? dump_stored(out, field) : dump_frame(out, field);
        vv_field_release(field);
    }
    if (good) {
        print_info(info);
        printf(", \"format\": \"%s\"", vv_file_format(file));
        print_channels(file);
        printf("\n");
    }
    if (out && fclose(out) != 0)
        good = false;
    vv_file_close(file);
    return good ? 0 : 1;
}

static int notes(const char *path, const char *part, vv_job *job)
{
    vv_file *file;
    const char *key, *value;
    if (open_part(&file, path, part, job) != VV_OK)
        return complain(path);
    for (size_t i = 0; vv_file_metadata(file, i, &key, &value); i++)
        printf("%s: %s\n", key, value);
    for (size_t i = 0; vv_file_warning(file, i); i++)
        printf("warning: %s\n", vv_file_warning(file, i));
    vv_file_close(file);
    return 0;
}

static int copy_frames(const char *out, vv_file *file, const vv_write_options *options, vv_job *job)
{
    enum { MOST = 16 };
    const vv_field *frames[MOST];
    size_t n = 0;
    vv_status st = VV_OK;
    for (; n < MOST && (int64_t)n < vv_file_info(file)->n_frames && st == VV_OK; n++) {
        vv_field *field = NULL;
        st = vv_file_read(&field, file, (int64_t)n, NULL, job);
        frames[n] = field;
    }
    if (st == VV_OK)
        st = vv_field_write(out, frames, n, options, job);
    for (size_t f = 0; f < n; f++)
        vv_field_release((vv_field *)frames[f]);
    return st == VV_OK ? 0 : complain(out);
}

static int copy(const char *path, const char *out, const char *encoding, bool big_endian, vv_job *job)
{
    vv_file *file;
    vv_write_options options;
    vv_write_options_init(&options, sizeof options);
    if (vv_file_open(&file, path, NULL, job) != VV_OK)
        return complain(path);
    options.stored = true;
    options.encoding = encoding;
    options.big_endian = big_endian;
    options.channels = vv_file_channels(file, &options.n_channels);
    options.labels = vv_file_labels(file, &options.n_labels);
    const int bad = copy_frames(out, file, &options, job);
    vv_file_close(file);
    return bad;
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

static int write_as(const char *folder, int number, const char *suffix, const vv_field_info *info, bool big_endian,
                    int n_frames, const char *encoding)
{
    char path[4096];
    vv_field *frame[3] = {NULL};
    vv_write_options options;
    vv_write_options_init(&options, sizeof options);
    options.big_endian = big_endian;
    options.encoding = encoding;
    options.stored = true;
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
    printf("}\n");
    return 0;
}

static int write_one(const char *folder, int number, const char *suffix, const vv_field_info *info, bool big_endian,
                     int n_frames)
{
    return write_as(folder, number, suffix, info, big_endian, n_frames, NULL);
}

/* Every orientation, type, encoding and odd size. */
static int write_vti(const char *folder)
{
    static const char *const encodings[] = {"raw", "zlib", "base64", "ascii"};
    static const int64_t sizes[][3] = {{7, 5, 3}, {1, 1, 1}, {13, 2, 1}, {1, 3, 17}, {127, 131, 11}};
    int number = 0, bad = 0;
    for (int o = 0; o < 48; o++)
        for (int e = 0; e < 4; e++) {
            vv_field_info info = some_info(o, (vv_type)((o + 3 * e) % VV_TYPE_COUNT));
            memcpy(info.grid.dims, sizes[e == 3 ? o % 4 : o % 5], sizeof sizes[0]);
            info.components = 1 + (o + e) % 4;
            if (info.type == VV_TYPE_U8 && info.components == 3)
                info.meaning = VV_MEANING_RGB;
            strcpy(info.name, o % 2 ? "a < b & \"c\"" : "values");
            bad |= write_as(folder, number++, ".vti", &info, o % 3 == 0, 1, encodings[e]);
        }
    return bad;
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

static const char *word_or_null(char **words, int n, int at)
{
    return at < n && words[at][0] ? words[at] : NULL;
}

/* One command; 2: it is none. */
static int obey(char **words, int n, vv_job *job)
{
    const char *verb = n > 0 ? words[0] : "";
    const bool stored = strcmp(verb, "stored") == 0;
    if (n == 2 && strcmp(verb, "write") == 0)
        return write_all(words[1]);
    if (n == 2 && strcmp(verb, "write-vti") == 0)
        return write_vti(words[1]);
    if ((n == 2 || n == 3) && strcmp(verb, "notes") == 0)
        return notes(words[1], word_or_null(words, n, 2), job);
    if ((n == 3 || n == 4) && (stored || strcmp(verb, "dump") == 0))
        return dump(words[1], words[2], word_or_null(words, n, 3), stored, job);
    if (n >= 3 && n <= 5 && strcmp(verb, "copy") == 0)
        return copy(words[1], words[2], word_or_null(words, n, 3), word_or_null(words, n, 4) != NULL, job);
    return 2;
}

static void obey_lines(vv_job *job)
{
    enum { MOST = 6 };
    static char line[MOST * 4096];
    while (fgets(line, sizeof line, stdin)) {
        char *words[MOST], *next = line;
        int n = 0;
        line[strcspn(line, "\n")] = 0;
        while (n < MOST && (words[n] = strsep(&next, "\t")) != NULL)
            n++;
        const int code = obey(words, n, job);
        printf("done %d\n", code);
        fflush(stdout);
    }
}

/* Many commands without a program started for each. */
static int serve(const char *import_program)
{
    vv_runtime_options options;
    vv_runtime *runtime = NULL;
    vv_job *job = NULL;
    vv_runtime_options_init(&options, sizeof options);
    options.import_program = import_program;
    if (import_program &&
        (vv_runtime_new(&runtime, &options) != VV_OK || vv_job_new(&job, runtime, NULL, NULL) != VV_OK))
        return complain("serve");
    obey_lines(job);
    vv_job_release(job);
    vv_runtime_release(runtime);
    return 0;
}

int main(int argc, char **argv)
{
    if ((argc == 2 || argc == 3) && strcmp(argv[1], "serve") == 0)
        return serve(argv[2]);
    const int code = obey(argv + 1, argc - 1, NULL);
    if (code == 2)
        fprintf(stderr, "io_tool serve [IMPORT_PROGRAM] | write FOLDER | write-vti FOLDER | dump FILE OUT [PART] | "
                        "stored FILE OUT [PART] | notes FILE [PART] | copy FILE OUT [ENCODING [big]]\n");
    return code;
}
