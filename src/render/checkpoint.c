/* Checkpoints of pictures. */
#include "render/checkpoint.h"
#include "core/job.h"
#include "grid/crc.h"
#include "image/image_layer.h"
#include "io/sink.h"
#include "render/picture_depends.h"
#include <errno.h>
#include <math.h>
#include <string.h>
#include <unistd.h>

enum { VERSION = 1, MARK = 0x01020304 };
static const char magic[8] = "VVPICT\r\n"; /* a copy as text breaks it, and is seen */

/* The first bytes of the file, in the machine's order: `mark` says which. */
typedef struct header {
    char magic[8];
    uint32_t mark, version;
    uint64_t depends;
    uint64_t n_bytes; /* of the arrays */
    int32_t stage, grid, ended_by, none;
    int64_t passes;
    uint64_t rays, samples;
    double spent_s, pass_began_s;
    uint64_t zeros[4];
    uint32_t zero;
    uint32_t crc; /* of all before it */
} header;
_Static_assert(sizeof(header) == VVI_CHECKPOINT_HEADER, "the format says so");

/* Arrays ---------------------------------------------------------------------------------------------------------- */

typedef struct part {
    void *data;
    size_t bytes;
} part;
enum { PARTS_MOST = 2 * (1 + VV_LAYER_COUNT) + 4 };

static size_t list_image(part *out, const vv_image *image)
{
    const size_t pixels = (size_t)image->width * (size_t)image->height;
    size_t n = 0;
    out[n++] = (part){image->rgba, 4 * pixels * sizeof *image->rgba};
    for (size_t i = 0; i < VV_LAYER_COUNT; i++)
        if (vvi_image_layer(image, i))
            out[n++] = (part){vvi_image_layer(image, i), pixels * vvi_layer_nth(i)->channels * sizeof(float)};
    return n;
}

/* Whether it needs the rays of a pass: of that on its way, or of the second one, which may yet weigh more. */
static bool has_rays(vvi_stage stage, int64_t passes)
{
    return stage == VVI_STAGE_RAYS || stage == VVI_STAGE_ADD || stage == VVI_STAGE_WEIGH ||
           (stage == VVI_STAGE_JUDGE && passes == 2);
}

/* Whether it is between two passes, or in one that is not the first. */
static bool has_passes(vvi_stage stage, int64_t passes)
{
    return has_rays(stage, passes) || (stage == VVI_STAGE_JUDGE && passes > 1);
}

static size_t list_parts(part *out, const vvi_gathered *got)
{
    const size_t n_blocks = (size_t)got->n_across * (size_t)got->n_down;
    size_t n = 0;
    if (got->stage <= VVI_STAGE_SQUARES)
        n += list_image(out + n, got->canvas);
    else if (got->stage != VVI_STAGE_DRAW)
        n += list_image(out + n, got->image);
    if (has_rays(got->stage, got->passes))
        n += list_image(out + n, got->shifted);
    if (has_passes(got->stage, got->passes)) {
        out[n++] = (part){got->active, n_blocks};
        if (got->half)
            out[n++] =
                (part){got->half, 4 * (size_t)got->image->width * (size_t)got->image->height * sizeof *got->half};
    }
    out[n++] = (part){got->done, got->n_tiles};
    return n;
}

static uint64_t bytes_of(const part *parts, size_t n)
{
    uint64_t bytes = 0;
    for (size_t i = 0; i < n; i++)
        bytes += parts[i].bytes;
    return bytes;
}

/* Saving ---------------------------------------------------------------------------------------------------------- */

static uint32_t crc_of(uint32_t crc, const void *data, size_t n)
{
    return vvi_crc32(crc, data, n, vvi_crc_has_fold());
}

static header header_of(const vvi_gathered *got, uint64_t depends, uint64_t n_bytes)
{
    header h = {.mark = MARK,
                .version = VERSION,
                .depends = depends,
                .n_bytes = n_bytes,
                .stage = (int32_t)got->stage,
                .grid = got->grid,
                .ended_by = (int32_t)got->ended_by,
                .passes = got->passes,
                .rays = got->counts.rays,
                .samples = got->counts.samples,
                .spent_s = got->spent_s,
                .pass_began_s = got->pass_began_s};
    memcpy(h.magic, magic, sizeof h.magic);
    h.crc = crc_of(0, &h, offsetof(header, crc));
    return h;
}

static vv_status write_parts(vv_sink *sink, const part *parts, size_t n)
{
    uint32_t crc = 0;
    vv_status st = VV_OK;
    for (size_t i = 0; i < n && st == VV_OK; i++) {
        crc = crc_of(crc, parts[i].data, parts[i].bytes);
        st = vvi_sink_write(sink, parts[i].data, parts[i].bytes);
    }
    return st == VV_OK ? vvi_sink_write(sink, &crc, sizeof crc) : st;
}

vv_status vv_picture_save(const vv_picture *picture, const char *path, vv_job *job)
{
    part parts[PARTS_MOST];
    const size_t n = list_parts(parts, &picture->got);
    uint64_t depends;
    vv_sink *sink;
    vv_status st = vvi_scene_health(picture->scene);
    if (st == VV_OK)
        st = vvi_picture_depends(&depends, picture, true, job);
    if (st != VV_OK || (st = vvi_sink_open(&sink, path, job)) != VV_OK)
        return st;
    const header h = header_of(&picture->got, depends, bytes_of(parts, n));
    if ((st = vvi_sink_write(sink, &h, sizeof h)) == VV_OK && (st = write_parts(sink, parts, n)) == VV_OK)
        return vvi_sink_commit(sink);
    vvi_sink_abandon(sink);
    return st;
}

/* Reading --------------------------------------------------------------------------------------------------------- */

#define BEGIN_ANEW "; remove it to begin anew"

static vv_status fail_damaged(const vv_source *source, const char *what)
{
    return vv_fail_at(VV_E_FORMAT, vvi_source_name(source), NULL,
                      "is a checkpoint that is damaged: %s is not what was written" BEGIN_ANEW, what);
}

static vv_status read_header(header *out, vv_source *source, uint64_t depends)
{
    size_t n;
    const char *name = vvi_source_name(source);
    const vv_status st = vvi_source_read_whole(source, out, sizeof *out, &n);
    if (st != VV_OK)
        return st;
    if (n < sizeof magic || memcmp(out->magic, magic, sizeof magic) != 0)
        return vv_fail_at(VV_E_FORMAT, name, NULL, "is no checkpoint of a picture; give the name of one, or of none");
    if (n < sizeof *out)
        return vv_fail_at(VV_E_FORMAT, name, NULL, "is a checkpoint that is cut after %zu bytes" BEGIN_ANEW, n);
    if (out->mark != MARK || out->version != VERSION)
        return vv_fail_at(VV_E_UNSUPPORTED, name, NULL,
                          "is a checkpoint of another version of VolVis, or of another kind of machine" BEGIN_ANEW);
    if (crc_of(0, out, offsetof(header, crc)) != out->crc)
        return fail_damaged(source, "its header");
    if (out->depends != depends)
        return vv_fail_at(
            VV_E_ARGUMENT, name, NULL,
            "is the checkpoint of another picture: its scene, view, data, instruction set (VOLVIS_CPU) or "
            "version of VolVis differs; render what it was saved of, or remove it to begin anew");
    return VV_OK;
}

/* Whether a picture of that scene can be there. */
static bool is_possible(const header *h, const vv_scene *scene)
{
    const bool draws = scene->renderer->draw, ended = h->stage == VVI_STAGE_END;
    const int64_t most = h->stage == VVI_STAGE_RAYS || h->stage == VVI_STAGE_ADD ? scene->samples - 1
                         : draws && ended                                        ? INT32_MAX
                                                                                 : scene->samples;
    if (h->stage < 0 || h->stage > VVI_STAGE_END || (draws != (h->stage == VVI_STAGE_DRAW) && !ended))
        return false;
    if (!(h->spent_s >= 0) || !isfinite(h->spent_s) || !(h->pass_began_s >= 0) || !(h->pass_began_s <= h->spent_s))
        return false;
    const bool enough = ended || h->stage == VVI_STAGE_WEIGH;
    if (enough ? h->ended_by < VV_END_SAMPLES || h->ended_by > VV_END_BUDGET : h->ended_by != VV_END_NONE)
        return false;
    if (h->stage >= VVI_STAGE_RAYS ? h->passes < 1 || h->passes > most : h->passes != 0)
        return false;
    if (h->grid < 0 || h->grid > VVI_GRIDS || (h->stage == VVI_STAGE_WEIGH && h->passes != 2))
        return false;
    return h->stage != VVI_STAGE_SQUARES || (scene->adaptive && h->grid == 1);
}

static vv_status check_size(const header *h, vv_source *source, uint64_t n_bytes)
{
    bool exact;
    const uint64_t there = vvi_source_left(source, &exact), wanted = n_bytes + sizeof h->crc;
    if (h->n_bytes != n_bytes)
        return fail_damaged(source, "its size");
    if (exact ? there != wanted : there < wanted)
        return vv_fail_at(VV_E_FORMAT, vvi_source_name(source), NULL,
                          "is a checkpoint of %llu bytes that should have %llu: it is cut or was added to" BEGIN_ANEW,
                          (unsigned long long)(there + sizeof *h), (unsigned long long)(wanted + sizeof *h));
    return VV_OK;
}

static bool are_bits(const uint8_t *v, size_t n)
{
    for (size_t i = 0; i < n; i++)
        if (v[i] > 1)
            return false;
    return true;
}

static vv_status read_parts(vvi_gathered *got, vv_source *source, const part *parts, size_t n, vv_job *job)
{
    uint32_t crc = 0, expected;
    vv_status st = VV_OK;
    for (size_t i = 0; i < n && st == VV_OK; i++) {
        if ((st = vvi_source_read(source, parts[i].data, parts[i].bytes, "what a picture has gathered")) == VV_OK)
            st = vvi_job_poll(job);
        if (st == VV_OK)
            crc = crc_of(crc, parts[i].data, parts[i].bytes);
    }
    if (st == VV_OK)
        st = vvi_source_read(source, &expected, sizeof expected, "the checksum");
    if (st != VV_OK)
        return st;
    if (crc != expected || !are_bits(got->done, got->n_tiles) ||
        (got->active && !are_bits(got->active, (size_t)got->n_across * (size_t)got->n_down)))
        return fail_damaged(source, "what was gathered");
    return VV_OK;
}

/* Bytes of the arrays of a stage, from the scene alone. */
static uint64_t bytes_expected(const header *h, const vv_scene *scene)
{
    const uint64_t w = (uint64_t)scene->width, ht = (uint64_t)scene->height,
                   pixel = vvi_image_pixel_bytes(scene->layers);
    const uint64_t canvas = (uint64_t)vvi_preview_size(scene->width) * (uint64_t)vvi_preview_size(scene->height);
    const uint64_t blocks = (w + VVI_BLOCK - 1) / VVI_BLOCK * ((ht + VVI_BLOCK - 1) / VVI_BLOCK);
    uint64_t bytes = vvi_picture_tiles_most(scene->width, scene->height);
    if (h->stage <= VVI_STAGE_SQUARES)
        bytes += canvas * pixel;
    else if (h->stage != VVI_STAGE_DRAW)
        bytes += w * ht * pixel;
    if (has_rays((vvi_stage)h->stage, h->passes))
        bytes += (w + 1) * (ht + 1) * 4 * sizeof(float);
    if (has_passes((vvi_stage)h->stage, h->passes))
        bytes += blocks + (scene->noise > 0 ? w * ht * 4 * sizeof(float) : 0);
    return bytes;
}

static vv_status read_gathered(vvi_gathered *out, vv_source *source, const header *h, const vv_scene *scene,
                               vv_job *job)
{
    part parts[PARTS_MOST];
    vv_status st = vvi_gathered_begin(out, scene, (vvi_stage)h->stage, job);
    if (st == VV_OK && has_passes(out->stage, h->passes))
        st = vvi_gathered_begin_passes(out, scene, job);
    if (st != VV_OK)
        return st;
    out->grid = h->grid;
    out->passes = h->passes;
    out->ended_by = (vv_render_end)h->ended_by;
    out->counts = (vv_render_counts){.rays = h->rays, .samples = h->samples};
    out->spent_s = h->spent_s;
    out->pass_began_s = h->pass_began_s;
    return read_parts(out, source, parts, list_parts(parts, out), job);
}

vv_status vvi_checkpoint_read(vvi_gathered *out, vv_source *source, const vv_scene *scene, uint64_t depends,
                              vv_job *job)
{
    header h;
    *out = (vvi_gathered){.image = NULL};
    vv_status st = read_header(&h, source, depends);
    if (st == VV_OK && !is_possible(&h, scene))
        st = fail_damaged(source, "its header");
    if (st == VV_OK)
        st = check_size(&h, source, bytes_expected(&h, scene));
    if (st == VV_OK && (st = read_gathered(out, source, &h, scene, job)) != VV_OK)
        vvi_gathered_finish(out);
    return st;
}

vv_status vv_picture_resume(vv_picture *picture, const char *path, vv_job *job)
{
    vvi_gathered got;
    uint64_t depends;
    vv_source *source;
    if (access(path, F_OK) != 0 && errno == ENOENT)
        return vv_fail_at(VV_E_NOT_FOUND, path, NULL, "there is no checkpoint");
    vv_status st = vvi_picture_depends(&depends, picture, true, job);
    if (st != VV_OK || (st = vvi_source_open(&source, path, job)) != VV_OK)
        return st;
    st = vvi_checkpoint_read(&got, source, picture->scene, depends, job);
    vvi_source_close(source);
    if (st != VV_OK)
        return st;
    vvi_picture_adopt(picture, &got);
    return VV_OK;
}

void vvi_checkpoint_sign(uint8_t *file, size_t n)
{
    const size_t at = offsetof(header, crc), begin = sizeof(header);
    uint32_t crc;
    if (n < begin + sizeof crc)
        return;
    crc = crc_of(0, file, at);
    memcpy(file + at, &crc, sizeof crc);
    crc = crc_of(0, file + begin, n - begin - sizeof crc);
    memcpy(file + n - sizeof crc, &crc, sizeof crc);
}
