#include "import/import_image.h"
#include "core/job.h"
#include "core/memory.h"
#include "image/image_layer.h"
#include "import/import_listen.h"
#include "import/import_room.h"
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

enum { TEXTS_MOST = 65536 };

/* What each question about an image says. */
static vv_status ask(vvi_import_process *p, vvi_wire_kind kind, const char *path, vv_job *job)
{
    int fd;
    vvi_text body = {0};
    vv_status st = vvi_import_open_place(&fd, path, job);
    if (st != VV_OK)
        return st;
    vvi_import_put_file(&body, path, job);
    vvi_import_put_terms(&body, job);
    st = vvi_import_ask(p, kind, &body, fd);
    vvi_text_free(&body);
    if (fd >= 0)
        close(fd);
    return st;
}

/* Texts ----------------------------------------------------------------------------------------------------------- */

/* NULL: no memory. */
static vv_text *take_texts(vvi_wire_in *in, size_t n)
{
    vv_text *all = vvi_calloc(n + 1, sizeof *all);
    bool fine = all != NULL;
    for (size_t i = 0; i < n && fine; i++) {
        all[i].key = vvi_strdup(vvi_wire_take_text(in));
        all[i].value = vvi_strdup(vvi_wire_take_text(in));
        fine = all[i].key && all[i].value;
    }
    if (fine)
        return all;
    vv_text_free(all, all ? n : 0);
    return NULL;
}

static vv_status read_texts(vv_text **out, size_t *n_out, vvi_import_process *p, const char *path, vv_job *job)
{
    vvi_wire_in in;
    vv_status st = vvi_import_start(p, job);
    if (st != VV_OK || (st = ask(p, VVI_WIRE_READ_TEXTS, path, job)) != VV_OK ||
        (st = vvi_import_listen(p, VVI_WIRE_TEXTS, &in, NULL, job)) != VV_OK)
        return st;
    const size_t n = (size_t)vvi_wire_take_between(&in, 0, TEXTS_MOST);
    vv_text *all = take_texts(&in, n);
    if (!all)
        return vv_fail_memory(n * sizeof *all);
    if (!vvi_wire_taken(&in)) {
        vv_text_free(all, n);
        return vvi_import_nonsense(p, "texts that do not hold what they should");
    }
    *out = all;
    *n_out = n;
    return VV_OK;
}

/* Pixels ---------------------------------------------------------------------------------------------------------- */

static uint64_t take(uint64_t *end, uint64_t bytes)
{
    const uint64_t at = *end;
    *end += bytes;
    return at;
}

static uint64_t layer_bytes(uint64_t n_pixels, size_t index)
{
    return n_pixels * vvi_layer_nth(index)->channels * sizeof(float);
}

vvi_image_room vvi_image_room_of(int64_t width, int64_t height, unsigned layers)
{
    const uint64_t n = (uint64_t)width * (uint64_t)height;
    vvi_image_room r = {0};
    r.rgba = take(&r.end, n * 4 * sizeof(float));
    for (size_t i = 0; i < VV_LAYER_COUNT; i++)
        r.layer[i] = take(&r.end, layers >> i & 1 ? layer_bytes(n, i) : 0);
    return r;
}

/* Whatever numbers they are: images have no others that would be wrong. */
static void copy_pixels(vv_image *out, const char *from)
{
    const uint64_t n = (uint64_t)out->width * (uint64_t)out->height;
    const vvi_image_room r = vvi_image_room_of(out->width, out->height, vv_image_layers(out));
    memcpy(out->rgba, from + r.rgba, (size_t)(n * 4 * sizeof(float)));
    for (size_t i = 0; i < VV_LAYER_COUNT; i++)
        if (vvi_image_layer(out, i))
            memcpy(vvi_image_layer(out, i), from + r.layer[i], (size_t)layer_bytes(n, i));
}

static vv_status fill_room(vvi_import_process *p, vvi_import_room *room, int fd, vv_job *job)
{
    const vvi_text nothing = {0};
    vvi_wire_in in;
    vv_status st = vvi_import_room_count(room, job);
    if (st != VV_OK || (st = vvi_import_ask(p, VVI_WIRE_READ_IMAGE, &nothing, fd)) != VV_OK ||
        (st = vvi_import_listen(p, VVI_WIRE_DONE, &in, NULL, job)) != VV_OK)
        return st;
    if (!vvi_wire_taken(&in))
        return vvi_import_nonsense(p, "a message that does not hold what it should");
    return vvi_import_room_seal(room, fd) ? VV_OK : vvi_import_nonsense(p, "pixels that it still holds");
}

static vv_status take_pixels(vv_image *out, vvi_import_process *p, vv_job *job)
{
    vvi_import_room *room;
    int fd;
    vv_status st =
        vvi_import_room_new(&room, &fd, vvi_image_room_of(out->width, out->height, vv_image_layers(out)).end);
    if (st != VV_OK)
        return st;
    st = fill_room(p, room, fd, job);
    close(fd);
    if (st == VV_OK)
        copy_pixels(out, room->data);
    vvi_import_room_free(room);
    return st;
}

static vv_status read_image(vv_image **out, vvi_import_process *p, const char *path, vv_job *job)
{
    vvi_wire_in in;
    vv_status st = vvi_import_start(p, job);
    if (st != VV_OK || (st = ask(p, VVI_WIRE_OPEN_IMAGE, path, job)) != VV_OK ||
        (st = vvi_import_listen(p, VVI_WIRE_OPENED_IMAGE, &in, NULL, job)) != VV_OK)
        return st;
    const int32_t width = (int32_t)vvi_wire_take_between(&in, 1, VVI_IMAGE_SIDE_MOST),
                  height = (int32_t)vvi_wire_take_between(&in, 1, VVI_IMAGE_SIDE_MOST);
    const unsigned layers = (unsigned)vvi_wire_take_between(&in, 0, (1 << VV_LAYER_COUNT) - 1);
    if (!vvi_wire_taken(&in))
        return vvi_import_nonsense(p, "an image of no size");
    st = vv_image_new(out, width, height, layers, job);
    return st == VV_OK ? take_pixels(*out, p, job) : st;
}

/* Ready to be started; VV_E_UNSUPPORTED where the program would know other formats. */
static vv_status prepare(vvi_import_process *out, const char *path, const vv_job *job)
{
    *out = (vvi_import_process){.socket = -1, .input = -1, .name = path};
    if (vvi_job_registry(job) != vv_registry_builtin() && !vvi_job_import_program(job))
        return vv_fail_at(VV_E_UNSUPPORTED, path, NULL,
                          "the import program knows the formats that are built in and no others");
    return VV_OK;
}

vv_status vvi_import_image(vv_image **out, const char *path, vv_job *job)
{
    vvi_import_process p;
    *out = NULL;
    vv_status st = prepare(&p, path, job);
    if (st != VV_OK)
        return st;
    st = read_image(out, &p, path, job);
    vvi_import_stop(&p);
    if (st != VV_OK) {
        vv_image_release(*out);
        *out = NULL;
    }
    return st;
}

vv_status vvi_import_image_text(vv_text **out, size_t *n_out, const char *path, vv_job *job)
{
    vvi_import_process p;
    *out = NULL;
    *n_out = 0;
    vv_status st = prepare(&p, path, job);
    if (st != VV_OK)
        return st;
    st = read_texts(out, n_out, &p, path, job);
    vvi_import_stop(&p);
    return st;
}
