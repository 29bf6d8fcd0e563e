/* Recordings of sessions that are played again, line by line. */
#include "core/job.h"
#include "core/json_text.h"
#include "core/memory.h"
#include "server/recording.h"
#include "server/recording_impl.h"
#include "server/session_impl.h"

#include <errno.h>
#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>
#include <volvis/image.h>

#define AFTER (INT64_C(1000) * 1000000)        /* what comes to rest does so within this */
#define TIME_MOST INT64_C(1000000000000000000) /* 31 years since the machine was started */
enum { LINE_MOST = 2 << 20, PAGES_MOST = 1000 };

static bool is_vector(vv_vec3 *out, const json_t *v)
{
    return json_unpack((json_t *)v, "[F, F, F!]", &out->x, &out->y, &out->z) == 0 && vvi_finite(*out);
}

static bool is_stand(vvi_stand *out, const json_t *v)
{
    vvi_pose *p = &out->pose;
    int parallel = 0, anatomical = 0, y_up = 0;
    const bool fine = is_vector(&p->eye, json_object_get(v, "eye")) &&
                      is_vector(&p->pivot, json_object_get(v, "pivot")) &&
                      is_vector(&out->up, json_object_get(v, "up")) &&
                      json_unpack((json_t *)v, "{s:[F, F, F, F!], s:b, s:F, s:F, s:b, s?b}", "turn", &p->turn.w,
                                  &p->turn.x, &p->turn.y, &p->turn.z, "parallel", &parallel, "fov", &p->fov, "height",
                                  &p->height, "anatomical", &anatomical, "y_up", &y_up) == 0;
    const double length =
        fine ? p->turn.w * p->turn.w + p->turn.x * p->turn.x + p->turn.y * p->turn.y + p->turn.z * p->turn.z : 0;
    p->parallel = parallel != 0;
    out->anatomical = anatomical != 0;
    out->y_up = y_up != 0;
    return fine && fabs(length - 1) < 1e-6 && isfinite(p->fov) && isfinite(p->height);
}

typedef struct player {
    vvi_session *session;
    vvi_client *pages[PAGES_MOST];
    int64_t t;
    vv_job *job;
    const char *path, *files_root;
    char *files; /* the folder that the recording names; NULL: none */
    size_t line;
    uint64_t ends; /* jobs that have ended in the recording */
} player;

static vv_status fail_line(const player *p, const char *what)
{
    char where[32];
    snprintf(where, sizeof where, "line %zu", p->line);
    return vv_fail_at(VV_E_FORMAT, p->path, where, "%s", what);
}

/* Takes what is to be sent, as if it were read and acknowledged at once. */
static void drain(player *p)
{
    for (vvi_client *c = vvi_session_client(p->session, NULL); c; c = vvi_session_client(p->session, c)) {
        vvi_outgoing out;
        while (vvi_client_next(&out, c, p->t)) {
            if (!out.text)
                vvi_outbox_acknowledge(&c->box, c->box.under_way, p->t);
            free(out.text);
            vv_image_bytes_free(out.bytes);
        }
    }
}

static vv_status fail_job(const player *p)
{
    return fail_line(p,
                     "a job that was done in the recording is not done now; are the files that it needs still there?");
}

/* Goes on until as many jobs have ended as had then, and sees that this one did what it did. job 0: recordings of
 * before do not say which. */
static vv_status wait_for_job(player *p, json_int_t job, bool was_done)
{
    vv_status st = VV_OK;
    p->session->awaited = job > 0 ? (uint64_t)job : 0;
    while (p->session->n_ended < p->ends && st == VV_OK) {
        const bool idle = vvi_tasks_are_idle(p->session->slow);
        vvi_session_serve(p->session);
        if (idle && p->session->n_ended < p->ends)
            return fail_job(p);
        drain(p);
        vvi_client *c = vvi_session_client(p->session, NULL);
        for (; c; c = vvi_session_client(p->session, c))
            vvi_client_tick(c, p->t);
        nanosleep(&(struct timespec){.tv_nsec = 1000000}, NULL);
        st = vvi_job_poll(p->job);
    }
    return st == VV_OK && was_done && p->session->last_ended != VV_OK ? fail_job(p) : st;
}

static bool is_one_of(const json_t *message, const char *const *types)
{
    const char *type = json_string_value(json_object_get(message, "type"));
    for (int i = 0; type && types[i]; i++)
        if (strcmp(types[i], type) == 0)
            return true;
    return false;
}

/* Samples of this player, which pages spoke of by where they were when it was recorded. What was there before it began
 * is where it was. */
static void name_samples(const player *p, json_t *value)
{
    const size_t n = p->files ? strlen(p->files) : 0;
    const char *text = json_string_value(value), *key;
    json_t *part;
    size_t i;
    if (text && n && strncmp(text, p->files, n) == 0 && text[n] == '/') {
        char *here = vvi_asprintf("%s%s", vvi_session_uploads(p->session), text + n);
        if (here && access(here, F_OK) == 0)
            json_string_set(value, here);
        free(here);
    }
    json_object_foreach(value, key, part) name_samples(p, part);
    json_array_foreach(value, i, part) name_samples(p, part);
}

/* What asks changes no World; what makes pictures and files of it has only seen to it that views stay as they are. */
static vv_status say(player *p, vvi_client *client, json_t *message)
{
    static const char *const changes[] = {"hello",  "size", "events", "edit", "undo",   "redo",   "action",
                                          "camera", "open", "new",    "run",  "cancel", "sample", NULL};
    static const char *const fixes[] = {"picture", "command", NULL}, *const fixes_all[] = {"save", NULL};
    if (is_one_of(message, fixes))
        return vvi_client_fix_view(client);
    if (is_one_of(message, fixes_all))
        return vvi_session_fix_views(p->session);
    if (!is_one_of(message, changes))
        return VV_OK;
    name_samples(p, message);
    char *text = vvi_json_encode(message, JSON_COMPACT | JSON_REAL_PRECISION(17));
    if (!text)
        return vv_fail_memory(1024);
    const vv_status st = vvi_client_message(client, text, strlen(text), p->t);
    free(text);
    drain(p);
    return st;
}

static vv_status stand(const player *p, vvi_client *client, const json_t *where)
{
    vvi_stand there;
    if (!is_stand(&there, where))
        return fail_line(p, "'stands' is not the place of a page");
    vvi_client_stand(client, &there);
    return VV_OK;
}

/* What follows may stand on them: it would be another World. */
static vv_status fail_lost(const player *p, json_int_t n)
{
    char where[32], to_line[64];
    snprintf(where, sizeof where, "line %zu", p->line);
    snprintf(to_line, sizeof to_line, "head -n %zu", p->line - 1);
    return vv_fail_at(VV_E_FORMAT, p->path, where,
                      "%" JSON_INTEGER_FORMAT " line%s missing here, which could not be written when the session was "
                      "recorded; the lines before it (%s) can be played",
                      n, n == 1 ? " is" : "s are", to_line);
}

static vv_status play_line(player *p, json_t *line)
{
    const json_int_t page = json_integer_value(json_object_get(line, "page"));
    json_t *message = json_object_get(line, "says");
    const json_t *t = json_object_get(line, "t");
    if (page < 0 || page >= PAGES_MOST)
        return fail_line(p, "there are at most 999 pages");
    vvi_client **client = &p->pages[page];
    if (!json_is_integer(t) || json_integer_value(t) < 0 || json_integer_value(t) > TIME_MOST)
        return fail_line(p, "'t' is a whole number of nanoseconds from 0 to 10^18");
    if (json_is_integer(json_object_get(line, "lost")))
        return fail_lost(p, json_integer_value(json_object_get(line, "lost")));
    p->t = json_integer_value(t);
    vvi_session_tick(p->session, p->t);
    if (json_object_get(line, "joins"))
        return *client ? fail_line(p, "a page joins twice") : vvi_client_join(client, p->session, NULL);
    if (json_object_get(line, "ends")) {
        p->ends++;
        return wait_for_job(p, json_integer_value(json_object_get(line, "job")),
                            json_is_true(json_object_get(line, "ends")));
    }
    if (!*client)
        return fail_line(p, "is from a page that has not joined");
    if (json_object_get(line, "stands"))
        return stand(p, *client, json_object_get(line, "stands"));
    if (json_object_get(line, "leaves")) {
        vvi_client_leave(*client);
        *client = NULL;
        return VV_OK;
    }
    return message ? say(p, *client, message) : fail_line(p, "is not a known entry");
}

/* What was bound then; recordings of before have the default. */
static vv_status bind(const player *p, json_t *rows)
{
    json_t *all = rows ? json_pack("{s:O}", "bindings", rows) : NULL;
    char *text = all ? vvi_json_encode(all, JSON_REAL_PRECISION(17)) : NULL;
    json_decref(all);
    if (rows && !text)
        return vv_fail_memory(1024);
    const vv_status st = vvi_session_bind(p->session, text);
    free(text);
    return st == VV_OK ? st : vv_fail_in(st, "%s:line 1", p->path);
}

/* A recording may come from anybody: what is written goes into a new folder, whatever folder it names. */
static vv_status make_folder(player *p, const json_t *line)
{
    const char *files = json_string_value(json_object_get(line, "files"));
    if (!files || !p->files_root)
        return VV_OK;
    char *folder = vvi_asprintf("%s/replay-XXXXXX", p->files_root);
    vv_status st = folder ? vvi_files_make_path(p->files_root) : vv_fail_memory(strlen(files));
    if (st == VV_OK && !mkdtemp(folder))
        st = vv_fail_at(VV_E_WRITE, p->files_root, NULL, "cannot make a folder for samples: %s", strerror(errno));
    if (st == VV_OK)
        st = vvi_session_write_below(p->session, folder);
    if (st == VV_OK && !(p->files = vvi_strdup(files)))
        st = vv_fail_memory(strlen(files));
    free(folder);
    return st;
}

static vv_status begin(player *p, const json_t *line)
{
    vv_world *world = NULL;
    const json_t *scene = json_object_get(line, "world");
    if (json_integer_value(json_object_get(line, VVI_RECORDING_HEAD)) != 1 || !scene)
        return fail_line(p, "a recording of a session begins with its World");
    if (!json_is_object(scene))
        return fail_line(p, "'world' is not a World; expected an object, {\"...\": ...}, as a scene file has it");
    char *text = vvi_json_encode(scene, JSON_REAL_PRECISION(17));
    vv_status st = text ? vv_scene_parse(&world, text, strlen(text), p->path, NULL, p->job) : vv_fail_memory(1024);
    free(text);
    if (st == VV_OK &&
        ((st = bind(p, json_object_get(line, "bindings"))) != VV_OK || (st = make_folder(p, line)) != VV_OK))
        vv_object_release(&world->base);
    if (st == VV_OK) {
        st = vvi_session_begin(p->session, world);
        vv_object_release(&world->base);
    }
    return st;
}

/* How long the next line is, LINE_MOST of one that is longer; 0: there is none. */
static size_t read_line(char *text, FILE *file)
{
    size_t n = 0;
    for (int c; n < LINE_MOST && (c = getc_unlocked(file)) != EOF;) {
        text[n++] = (char)c;
        if (c == '\n')
            break;
    }
    return n;
}

static vv_status play_all(player *p, FILE *file)
{
    char *text = vvi_alloc(p->job, LINE_MOST, VVI_MEM_SCRATCH);
    vv_status st = text ? VV_OK : vv_fail_memory(LINE_MOST);
    for (size_t n; st == VV_OK && (n = read_line(text, file)) > 0;) {
        vvi_json_flaw flaw = {.fault = VVI_JSON_SYNTAX};
        json_t *line = n < LINE_MOST ? vvi_json_decode(text, n, 0, &flaw) : NULL;
        p->line++;
        if (!line && flaw.fault == VVI_JSON_MEMORY)
            st = vv_fail_memory(n);
        else if (!line)
            st = fail_line(p, n < LINE_MOST ? "is not JSON" : "is longer than 2 MiB");
        else
            st = p->line == 1 ? begin(p, line) : play_line(p, line);
        json_decref(line);
    }
    vvi_free(text);
    return st == VV_OK && p->line == 0 ? fail_line(p, "is empty") : st;
}

static void wake_nobody(void *user)
{
    (void)user;
}

/* Ends the session. Of what it made, that stays which the World (NULL: nobody wants any) shows. */
static void end(player *p, const vv_world *world)
{
    char *folder = p->files ? vvi_strdup(vvi_session_uploads(p->session)) : NULL;
    if (world && folder)
        vvi_files_keep(p->session, world);
    vvi_session_free(p->session, true);
    if (folder) {
        vvi_files_clear(&(vvi_session){.uploads = folder});
        rmdir(folder); /* unless something is left */
    }
    free(folder);
    free(p->files);
}

vv_status vvi_recording_play(vv_world **out, const char *path, const vvi_session_options *options,
                             const char *files_root, bool keeps, vv_job *job)
{
    vvi_session_options o = *options;
    player p = {.job = job, .path = path, .files_root = files_root};
    *out = NULL;
    o.wake = wake_nobody;
    FILE *file = fopen(path, "re");
    if (!file)
        return vv_fail_at(VV_E_READ, path, NULL, "cannot be opened: %s", strerror(errno));
    vv_status st = vvi_session_new(&p.session, &o);
    if (st == VV_OK) {
        p.session->is_played = true;
        st = play_all(&p, file);
    }
    fclose(file);
    if (st == VV_OK) {
        vvi_session_tick(p.session, p.t + AFTER);
        *out = vvi_session_world(p.session);
    }
    end(&p, keeps ? *out : NULL);
    return st;
}
