/* A folder of slices, some of them at a time: their samples are fetched together, then packed, encoded and put side by
 * side. Each TIFF is a volume of one slice, by the writer of volumes. */
#include "io/formats/slices/slices_write.h"
#include "core/job.h"
#include "core/memory.h"
#include "core/text.h"
#include "core/units.h"
#include "grid/true_values.h"
#include "io/formats/tiff/tiff_write.h"
#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

#define MARK ".volvis-slices"
#define STRAIGHT 1e-6
#define SLAB_BYTES ((size_t)32 << 20) /* of the field, fetched at once */
#define PNG_SIDE_MOST 1000000         /* libpng reads no more */

typedef struct writer {
    vv_sink *sink;
    vv_job *job;
    vv_write_options options; /* of one slice */
    vvi_turn turn;
    vv_field_info slice; /* of one file */
    int channels;        /* files of one slice */
    bool png;
    size_t n_frames, page_bytes;
    int digits[3];     /* of channels, slices and frames in names */
    const char *names; /* a pattern of them; NULL: words and numbers */
    /* what is written now */
    vv_brick brick;
    int64_t first; /* slice of the brick */
    size_t frame;
} writer;

static int digits_of(uint64_t n)
{
    char text[32];
    return snprintf(text, sizeof text, "%" PRIu64, n > 0 ? n - 1 : 0);
}

static void fill_pattern(char out[VVI_SLICES_NAME_MOST], const writer *w, size_t frame, int channel, int64_t slice)
{
    uint64_t numbers[3];
    size_t n = 0;
    if (w->n_frames > 1)
        numbers[n++] = frame;
    if (w->channels > 1)
        numbers[n++] = (uint64_t)channel;
    numbers[n] = (uint64_t)slice;
    vvi_slices_fill(out, w->names, numbers);
}

/* "t01_ch0_z0012.tif": words that reading takes for what they are. */
static void name_of(char out[VVI_SLICES_NAME_MOST], const writer *w, int channel, int64_t slice)
{
    const size_t most = VVI_SLICES_NAME_MOST;
    size_t n = 0;
    if (w->names) {
        fill_pattern(out, w, w->frame, channel, slice);
        return;
    }
    if (w->n_frames > 1)
        n += (size_t)snprintf(out, most, "t%0*zu_", w->digits[2], w->frame);
    if (w->channels > 1)
        n += (size_t)snprintf(out + n, most - n, "ch%0*d_", w->digits[0], channel);
    snprintf(out + n, most - n, "z%0*" PRId64 "%s", w->digits[1], slice, w->png ? ".png" : ".tif");
}

int vvi_slices_folder_file(const char *name)
{
    static const char *const words[] = {"t", "ch"};
    static const char digits[] = "0123456789";
    if (strcmp(name, MARK) == 0)
        return 2;
    for (size_t i = 0; i < 2; i++) {
        const size_t n_word = strlen(words[i]), n = strncmp(name, words[i], n_word) ? 0 : strspn(name + n_word, digits);
        if (n > 0 && name[n_word + n] == '_')
            name += n_word + n + 1;
    }
    const size_t n = *name == 'z' ? strspn(name + 1, digits) : 0;
    return n > 0 && (strcmp(name + 1 + n, ".png") == 0 || strcmp(name + 1 + n, ".tif") == 0);
}

/* Planning -------------------------------------------------------------------------------------------------------- */

static vv_status choose_encoding(writer *w, const vv_field_info *info, const char *encoding,
                                 const vv_write_options *options)
{
    const bool fits = (info->type == VV_TYPE_U8 || info->type == VV_TYPE_U16) &&
                      w->turn.grid.dims[0] <= PNG_SIDE_MOST && w->turn.grid.dims[1] <= PNG_SIDE_MOST;
    w->png = encoding ? strcmp(encoding, "png") == 0 : fits;
    if (w->png && !options->keep_order)
        w->turn = vvi_turn_upright(&info->grid, STRAIGHT);
    if (w->png && !fits)
        return vv_fail_at(VV_E_ARGUMENT, vvi_sink_name(w->sink), NULL,
                          "PNG holds u8 and u16 of up to %d samples a side, and these are %s of %" PRId64 " x %" PRId64
                          ": omit --encoding png, or name the files .tif, to get TIFF, or give --type u16 with --range",
                          PNG_SIDE_MOST, vv_type_name(info->type), w->turn.grid.dims[0], w->turn.grid.dims[1]);
    return VV_OK;
}

/* Packed samples take less, of scans a half; only what cannot be enough is refused before the work. */
static vv_status check_room(const writer *w)
{
    char needs[32], has[32];
    uint64_t there;
    const uint64_t all = (uint64_t)w->page_bytes * (uint64_t)w->channels * (uint64_t)w->turn.grid.dims[2] * w->n_frames;
    if (!vvi_sink_room(w->sink, &there) || there >= all)
        return VV_OK;
    vvi_print_bytes(needs, all);
    vvi_print_bytes(has, there);
    if (there < all / 4)
        return vv_fail_at(
            VV_E_WRITE, vvi_sink_name(w->sink), NULL,
            "its disk has %s free, and the slices have %s of samples; make room, or write fewer (--z, --type u8)", has,
            needs);
    vvi_log(w->job, VV_LOG_WARNING, "io",
            "%s: its disk has %s free, and the slices have %s of samples before they are packed",
            vvi_sink_name(w->sink), has, needs);
    return VV_OK;
}

/* *encoding_out: what the names say, or what was asked for. */
static vv_status check_names(const char **encoding_out, writer *w, const vv_write_options *options)
{
    *encoding_out = options->encoding;
    if (!(w->names = options->names))
        return VV_OK;
    const vv_status st = vvi_slices_check_pattern(encoding_out, w->names, options->encoding);
    return st == VV_OK
               ? vvi_slices_check_places(w->names, w->n_frames, (uint64_t)w->channels, (uint64_t)w->turn.grid.dims[2])
               : st;
}

/* Whether rows run from the back to the front of a patient, which is upside down for radiologists. */
static bool is_front_down(const writer *w)
{
    const vv_vec3 down = w->turn.grid.index_to_world.axis[1];
    return w->turn.grid.space == VV_SPACE_RAS && down.y > fabs(down.x) && down.y > fabs(down.z);
}

static void warn_of_loss(const writer *w, const vv_field_info *info)
{
    char scale[96] = "";
    const vvi_turn by_axes = vvi_turn_pages(&info->grid, STRAIGHT);
    const bool turned = w->turn.back[0] != by_axes.back[0] || w->turn.back[1] != by_axes.back[1];
    if (w->png && vvi_has_scale(info))
        snprintf(scale, sizeof scale, ", scale of values (stored * %g %c %g)", info->value_scale,
                 info->value_offset < 0 ? '-' : '+', fabs(info->value_offset));
    vvi_log(w->job, VV_LOG_WARNING, "io", "%s: slices of %s%s%s; write .nrrd to keep all%s", vvi_sink_name(w->sink),
            w->png ? "PNG do not keep spacing, orientation, origin" : "TIFF say where they lie to VolVis alone", scale,
            w->png ? " and names" : ", and no names",
            turned ? "; they are upright, the patient's front at the top and right on the left: --order RAS keeps them "
                     "along the axes"
            : is_front_down(w)
                ? "; the patient's front is at the bottom of each: --order LPS, or volvis reorient, puts it "
                  "at the top"
                : "");
}

/* One file: its samples lie as the file has them. */
static vv_status plan(writer *w, const vv_field_info *info, const vv_write_options *options)
{
    const bool colors = (info->meaning == VV_MEANING_RGB && info->components == 3) ||
                        (info->meaning == VV_MEANING_RGBA && info->components == 4);
    w->turn = vvi_turn_pages(&info->grid, STRAIGHT);
    w->channels = colors ? 1 : info->components;
    const char *encoding;
    vv_status st = check_names(&encoding, w, options);
    if (st != VV_OK || (st = choose_encoding(w, info, encoding, options)) != VV_OK)
        return st;
    w->slice = vv_field_info_default();
    w->slice.type = info->type;
    w->slice.components = colors ? info->components : 1;
    w->slice.meaning = colors || info->meaning == VV_MEANING_LABEL ? info->meaning : w->slice.meaning;
    w->slice.value_scale = info->value_scale;
    w->slice.value_offset = info->value_offset;
    w->slice.grid = w->turn.grid;
    w->slice.grid.dims[2] = 1;
    vv_write_options_init(&w->options, sizeof w->options);
    w->options.encoding = "deflate";
    w->options.level = options->level;
    w->digits[0] = digits_of((uint64_t)w->channels);
    w->digits[1] = digits_of((uint64_t)w->turn.grid.dims[2]);
    w->digits[2] = digits_of(w->n_frames);
    if ((st = vvi_mul3_size(&w->page_bytes, (size_t)w->slice.grid.dims[0], (size_t)w->slice.grid.dims[1],
                            (size_t)w->slice.components * vv_type_bytes(info->type))) != VV_OK ||
        (st = check_room(w)) != VV_OK)
        return st;
    warn_of_loss(w, info);
    return VV_OK;
}

/* Slices ---------------------------------------------------------------------------------------------------------- */

static void pack(uint8_t *out, const writer *w, int channel, int64_t slice)
{
    const size_t bytes = vv_type_bytes(w->slice.type), pixel = bytes * (size_t)w->slice.components;
    int64_t step[3];
    const uint8_t *from = vvi_turn_brick(step, &w->turn, &w->brick) + (slice - w->first) * step[2];
    from += (size_t)channel * bytes;
    for (int64_t j = 0; j < w->slice.grid.dims[1]; j++)
        for (int64_t i = 0; i < w->slice.grid.dims[0]; i++, out += pixel)
            memcpy(out, from + j * step[1] + i * step[0], pixel);
}

/* It says where it lies, which VolVis reads, of the folder as of the file alone. */
static vv_status encode_tiff(uint8_t **out, size_t *n_out, const writer *w, const uint8_t *samples, int64_t slice,
                             const char *name)
{
    vv_field *field = NULL;
    vv_sink *sink = NULL;
    vv_field_info info = w->slice;
    vv_affine *a = &info.grid.index_to_world;
    a->origin = vv_affine_point(*a, (vv_vec3){0, 0, (double)slice});
    vv_status st = vv_field_new(&field, &info, samples, 0, NULL, NULL, w->job);
    if (st == VV_OK && (st = vvi_sink_open_memory(&sink, name, w->job)) == VV_OK)
        st = vvi_tiff_write(sink, (const vv_field *const[]){field}, 1, &w->options, w->job);
    vv_field_release(field);
    if (st == VV_OK)
        return vvi_sink_take(out, n_out, sink);
    vvi_sink_abandon(sink);
    return st;
}

static vv_status write_item(void *scratch, void *user, size_t index)
{
    (void)scratch;
    const writer *w = user;
    const int channel = (int)(index % (size_t)w->channels);
    const int64_t slice = w->first + (int64_t)(index / (size_t)w->channels);
    uint8_t *samples = vvi_alloc(w->job, w->page_bytes, VVI_MEM_SCRATCH), *file = NULL;
    size_t n = 0;
    char name[VVI_SLICES_NAME_MOST];
    if (!samples)
        return vv_fail_memory(w->page_bytes);
    name_of(name, w, channel, slice);
    pack(samples, w, channel, slice);
    vv_status st = w->png ? vvi_slices_encode_png(&file, &n, samples, &w->slice, name, w->job)
                          : encode_tiff(&file, &n, w, samples, slice, name);
    if (st == VV_OK)
        st = vvi_sink_put(w->sink, name, file, n);
    vvi_free(file);
    vvi_free(samples);
    return st;
}

static vv_status write_frame(writer *w, const vv_field *field)
{
    static const vvi_work work = {.item = write_item};
    const int64_t slices = w->turn.grid.dims[2];
    const size_t most = SLAB_BYTES / (w->page_bytes * (size_t)w->channels) + 1;
    vv_status st = VV_OK;
    for (int64_t n; w->first < slices && st == VV_OK; w->first += n) {
        n = slices - w->first < (int64_t)most ? slices - w->first : (int64_t)most;
        const vv_box box = vvi_turn_slices(&w->turn, w->first, n);
        if ((st = vv_field_brick(&w->brick, field, &box, w->job)) != VV_OK)
            return st;
        vvi_job_hush(w->job, 1); /* a file's own pages are no progress */
        st = vvi_parallel_for(w->job, &work, w, (size_t)n * (size_t)w->channels);
        vvi_job_hush(w->job, -1);
        vv_brick_release(&w->brick);
        if (st == VV_OK)
            st = vvi_job_progress(w->job, "write", w->frame * (uint64_t)slices + (uint64_t)(w->first + n),
                                  w->n_frames * (uint64_t)slices);
    }
    return st == VV_OK ? vv_field_health(field) : st;
}

/* Names by a pattern are listed in it: only by that can anybody know later whose they are. */
static vv_status put_mark(const writer *w)
{
    vvi_text text = {0};
    char name[VVI_SLICES_NAME_MOST];
    vvi_text_add(&text, VVI_FOLDER_LIST " the slices of this folder, and may replace all of them.\n");
    for (size_t f = 0; w->names && f < w->n_frames; f++)
        for (int64_t z = 0; z < w->turn.grid.dims[2]; z++)
            for (int c = 0; c < w->channels; c++) {
                fill_pattern(name, w, f, c, z);
                vvi_text_printf(&text, "%s\n", name);
            }
    const vv_status st = text.bad ? vv_fail_memory(text.n) : vvi_sink_put(w->sink, MARK, text.s, text.n);
    vvi_text_free(&text);
    return st;
}

vv_status vvi_slices_write(vv_sink *sink, const vv_field *const *frames, size_t n_frames,
                           const vv_write_options *options, vv_job *job)
{
    writer w = {.sink = sink, .job = job, .n_frames = n_frames};
    vv_status st = plan(&w, vv_field_get_info(frames[0]), options);
    for (w.frame = 0; w.frame < n_frames && st == VV_OK; w.frame++) {
        w.first = 0;
        st = write_frame(&w, frames[w.frame]);
    }
    return st == VV_OK ? put_mark(&w) : st;
}
