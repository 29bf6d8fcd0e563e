#include "server/recording.h"
#include "core/json_text.h"
#include "core/memory.h"
#include "server/line_file.h"
#include "server/recording_impl.h"
#include "server/session_impl.h"

#include <errno.h>
#include <fcntl.h>
#include <inttypes.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

struct vvi_recording {
    vvi_line_file file;
    char *path;
    uint64_t lost, all_lost; /* lines, since one was written; and of all */
};

vv_status vvi_recording_open(vvi_recording **out, const char *path)
{
    vvi_recording *r = vvi_calloc(1, sizeof *r);
    *out = NULL;
    if (!r || !(r->path = vvi_strdup(path))) {
        free(r);
        return vv_fail_memory(strlen(path));
    }
    r->file.fd = open(path, O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0600); /* all that is said is in it */
    if (r->file.fd >= 0) {
        *out = r;
        return VV_OK;
    }
    const vv_status st =
        vv_fail_at(VV_E_WRITE, path, NULL, "a recording cannot be made: %s",
                   errno == EEXIST ? "there is such a file; remove it or give another name" : strerror(errno));
    free(r->path);
    free(r);
    return st;
}

vv_status vvi_recording_close(vvi_recording *r)
{
    vv_status st = VV_OK;
    if (!r)
        return VV_OK;
    if (close(r->file.fd) != 0 && !r->all_lost++)
        r->file.error = errno;
    if (r->all_lost)
        st = vv_fail_at(VV_E_WRITE, r->path, NULL,
                        "the recording is incomplete: %" PRIu64 " lines could not be written: %s", r->all_lost,
                        strerror(r->file.error));
    free(r->path);
    free(r);
    return st;
}

char *vvi_recording_problem(const vvi_recording *r)
{
    return r && r->lost ? vvi_asprintf("the recording %s lacks what is done now: %s", r->path, strerror(r->file.error))
                        : NULL;
}

static bool put_now(vvi_recording *r, json_t *line)
{
    char *text = line ? vvi_json_encode(line, JSON_COMPACT | JSON_REAL_PRECISION(17)) : NULL;
    json_decref(line);
    return vvi_line_file_put(&r->file, text);
}

/* Lines that are missing are told by the first that can be written again. */
static void put(vvi_recording *r, json_t *line)
{
    const bool fine = (!r->lost || put_now(r, json_pack("{s:I, s:i, s:I}", "t", (json_int_t)vvi_now(), "page", 0,
                                                        "lost", (json_int_t)r->lost))) &&
                      put_now(r, json_incref(line));
    json_decref(line);
    r->lost = fine ? 0 : r->lost + 1;
    r->all_lost += !fine;
}

void vvi_recording_begin(vvi_recording *r, const vv_world *world, const char *bindings, const char *files)
{
    char *scene = NULL;
    if (!r)
        return;
    json_t *rows = vvi_json_of_own(bindings);
    json_t *line = NULL;
    if (vv_scene_print(&scene, world, NULL) == VV_OK)
        line = json_pack("{s:i, s:o, s:O, s:s?}", VVI_RECORDING_HEAD, 1, "world", vvi_json_of_own(scene), "bindings",
                         json_object_get(rows, "bindings"), "files", files);
    put(r, line);
    json_decref(rows);
    free(scene);
}

void vvi_recording_note(vvi_recording *r, int64_t t, uint64_t page, const char *what)
{
    if (r)
        put(r, json_pack("{s:I, s:I, s:b}", "t", (json_int_t)t, "page", (json_int_t)page, what, true));
}

void vvi_recording_ends(vvi_recording *r, int64_t t, uint64_t job, bool done)
{
    if (r)
        put(r, json_pack("{s:I, s:i, s:b, s:I}", "t", (json_int_t)t, "page", 0, "ends", done, "job", (json_int_t)job));
}

void vvi_recording_says(vvi_recording *r, int64_t t, uint64_t page, json_t *message)
{
    if (r)
        put(r, json_pack("{s:I, s:I, s:O}", "t", (json_int_t)t, "page", (json_int_t)page, "says", message));
}

/* Where somebody stands ------------------------------------------------------------------------------------------- */

static json_t *json_of(vv_vec3 v)
{
    return json_pack("[f, f, f]", v.x, v.y, v.z);
}

void vvi_recording_stands(vvi_recording *r, int64_t t, uint64_t page, const vvi_stand *stand)
{
    const vvi_pose *p = &stand->pose;
    if (r)
        put(r, json_pack("{s:I, s:I, s:{s:o, s:[f, f, f, f], s:o, s:b, s:f, s:f, s:o, s:b, s:b}}", "t", (json_int_t)t,
                         "page", (json_int_t)page, "stands", "eye", json_of(p->eye), "turn", p->turn.w, p->turn.x,
                         p->turn.y, p->turn.z, "pivot", json_of(p->pivot), "parallel", p->parallel, "fov", p->fov,
                         "height", p->height, "up", json_of(stand->up), "anatomical", stand->anatomical, "y_up",
                         stand->y_up));
}
