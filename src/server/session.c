#include "core/allowed_places.h"
#include "core/memory.h"
#include "input/bindings.h"
#include "io/sink_folder.h"
#include "server/request.h"

#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#define FOREVER (INT64_C(3600) * 1000000000)
/* Of different people; the pool's threads are shared by all of them. After a second nobody waits for a job's end, and
 * that of a page which left goes on for a minute though others wait for its place: its owner may be back for it. */
enum { JOBS_AT_ONCE = 3, QUESTIONS_AT_ONCE = 2 };
#define FRESH (INT64_C(1000) * 1000000)
#define KEPT (INT64_C(60) * 1000000000)
#define JOB_NOTICE (INT64_C(100) * 1000000)

int64_t vvi_now(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (int64_t)t.tv_sec * 1000000000 + t.tv_nsec;
}

/* Life ------------------------------------------------------------------------------------------------------------ */

static vv_status open_folders(vvi_session *s)
{
    const vvi_session_options *o = &s->options;
    vv_status st = VV_OK;
    s->root = realpath(o->root ? o->root : "/", NULL);
    if (!s->root)
        return vv_fail_at(VV_E_READ, o->root, NULL, "there is no such folder: %s", strerror(errno));
    if (!o->state)
        return VV_OK;
    if ((st = vvi_files_make_path(o->state)) != VV_OK)
        return st;
    s->state = realpath(o->state, NULL);
    s->uploads = s->state ? vvi_asprintf("%s/files", s->state) : NULL;
    if (!s->uploads)
        return vv_fail_memory(256);
    if ((st = vvi_files_make_path(s->uploads)) == VV_OK)
        st = vvi_journal_open(&s->journal, s->state);
    return st;
}

vv_status vvi_session_write_below(vvi_session *s, const char *folder)
{
    const vv_status st = vvi_files_make_path(folder);
    if (st != VV_OK)
        return st;
    s->uploads = vvi_strdup(folder);
    return s->uploads ? VV_OK : vv_fail_memory(strlen(folder));
}

vv_status vvi_session_fix_views(vvi_session *s)
{
    vv_status st = VV_OK;
    for (vvi_client *c = s->clients; c && st == VV_OK; c = c->next)
        st = vvi_client_fix_view(c);
    return st;
}

/* Whatever is read from here on, whenever it is opened: below the root, or what was given. */
static vv_status confine(const vvi_session *s)
{
    vv_runtime *runtime = s->options.runtime;
    vv_status st = VV_OK;
    if (strcmp(s->root, "/") != 0)
        st = vvi_runtime_confine(runtime, s->root);
    if (st == VV_OK && s->state && strcmp(s->root, "/") != 0)
        st = vvi_runtime_confine(runtime, s->state);
    if (st == VV_OK && s->uploads)
        st = vvi_runtime_distrust(runtime, s->uploads);
    return st;
}

/* What a server that was killed was writing there. */
static void clear_leftovers(const vvi_session *s)
{
    char *path = strcmp(s->root, "/") != 0 ? vvi_asprintf("%s/", s->root) : NULL;
    if (path)
        vvi_sink_clear_leftovers(path, NULL);
    free(path);
}

static vv_status play(void *user, const json_t *line)
{
    return vvi_session_replay(user, line);
}

static vv_status restore(vvi_session *s)
{
    vvi_journal *journal = s->journal;
    if (s->options.fresh && journal) {
        vvi_journal_clear(journal);
        vvi_files_clear(s);
    }
    s->journal = NULL; /* what is played is there already */
    vv_status st = journal ? vvi_journal_replay(&s->restored, journal, play, s) : VV_OK;
    s->journal = journal;
    s->lost = journal ? vvi_journal_lost(journal) : 0;
    vvi_session_begin_room(s);
    if (!s->options.read_only)
        clear_leftovers(s);
    return st == VV_OK && s->restored ? confine(s) : st;
}

/* Of a session that goes on after a crash; others begin with what vvi_session_begin() is given. */
static void note_world(vvi_session *s)
{
    if (!s->restored)
        return;
    vv_world *world = vv_model_snapshot(s->model);
    vvi_recording_begin(s->recording, world, s->bindings, s->uploads);
    vv_object_release(&world->base);
}

void vvi_session_note_end(vvi_session *s, uint64_t asked, vv_status st)
{
    s->n_ended++;
    s->last_ended = st;
    vvi_recording_ends(s->recording, vvi_now(), asked, st == VV_OK);
}

vv_status vvi_session_bind(vvi_session *s, const char *bindings)
{
    vvi_input *input = vvi_input_new();
    char *text = bindings ? vvi_strdup(bindings) : vvi_bindings_default();
    vv_status st = input && text ? vvi_input_bind(input, text, strlen(text)) : vv_fail_memory(256);
    vvi_input_free(input);
    if (st == VV_OK) {
        free(s->bindings);
        s->bindings = text;
    } else {
        free(text);
    }
    return st;
}

static vv_status new_tasks(vvi_tasks **out, const vvi_session *s, const char *name, size_t at_once)
{
    const vvi_tasks_options options = {.name = name,
                                       .at_once = at_once,
                                       .most = VVI_TASKS_MOST,
                                       .fresh = FRESH,
                                       .kept = KEPT,
                                       .wake = s->options.wake,
                                       .user = s->options.user};
    return vvi_tasks_new(out, s->options.runtime, &options);
}

vv_status vvi_session_new(vvi_session **out, const vvi_session_options *options)
{
    vvi_session *s = vvi_calloc(1, sizeof *s);
    *out = NULL;
    if (!s)
        return vv_fail_memory(sizeof *s);
    s->options = *options;
    vv_runtime_retain(options->runtime);
    vv_status st = open_folders(s);
    if (st == VV_OK)
        st = vvi_session_bind(s, options->bindings);
    if (st == VV_OK)
        st = vv_model_new(&s->model, options->runtime);
    if (st == VV_OK)
        st = restore(s);
    if (st == VV_OK && options->record)
        st = vvi_recording_open(&s->recording, options->record);
    if (st == VV_OK && s->recording)
        note_world(s);
    if (st == VV_OK && options->audit)
        st = vvi_audit_open(&s->audit, options->audit);
    if (st == VV_OK)
        st = vv_model_watch(s->model, vvi_session_note_commit, s);
    if (st == VV_OK)
        st = vvi_painter_new(&s->painter, options->runtime, options->wake, options->user);
    if (st == VV_OK)
        st = new_tasks(&s->slow, s, "vv-jobs", JOBS_AT_ONCE);
    if (st == VV_OK)
        st = new_tasks(&s->quick, s, "vv-questions", QUESTIONS_AT_ONCE);
    if (st == VV_OK)
        *out = s;
    else
        vvi_session_free(s, true);
    return st;
}

static void free_files(vvi_made_file *file)
{
    while (file) {
        vvi_made_file *next = file->next;
        vvi_made_file_free(file);
        file = next;
    }
}

vv_status vvi_session_free(vvi_session *s, bool keep)
{
    if (!s)
        return VV_OK;
    while (s->clients)
        vvi_client_leave(s->clients);
    vvi_tasks_free(s->slow);
    vvi_tasks_free(s->quick);
    vvi_painter_free(s->painter);
    vv_model_release(s->model);
    if (!keep && s->journal)
        vvi_files_clear(s);
    vvi_journal_close(s->journal, keep);
    const vv_status st = vvi_recording_close(s->recording);
    vvi_audit_close(s->audit);
    free_files(s->files);
    free(s->who);
    free(s->warnings);
    free(s->unkept);
    free(s->unaudited);
    free(s->unrecorded);
    for (size_t i = 0; i < VVI_CHANGES_KEPT; i++)
        free(s->paths[i]);
    free(s->told);
    vvi_told_changes_free(&s->changes);
    for (size_t i = 0; i < s->n_given; i++)
        free(s->given[i]);
    free(s->given);
    free(s->root);
    free(s->state);
    free(s->uploads);
    free(s->saved);
    free(s->bindings);
    vv_runtime_release(s->options.runtime);
    free(s);
    return st;
}

vv_status vvi_session_begin(vvi_session *s, vv_world *world)
{
    vvi_journal_clear(s->journal);
    vvi_recording_begin(s->recording, world, s->bindings, s->uploads);
    vv_status st = vvi_session_give_files(s, world);
    if (st == VV_OK)
        st = confine(s);
    return st == VV_OK ? vvi_session_replace(s, "", world) : st;
}

uint64_t vvi_session_lost(const vvi_session *s)
{
    return s->lost;
}

const char *vvi_session_kept(const vvi_session *s)
{
    return s->journal ? vvi_journal_kept(s->journal) : NULL;
}

uint64_t vvi_session_restored(const vvi_session *s)
{
    return s->restored;
}

vv_world *vvi_session_world(vvi_session *s)
{
    for (vvi_client *c = s->clients; c; c = c->next)
        vvi_client_save_camera(c);
    return vv_model_snapshot(s->model);
}

vvi_audit *vvi_session_audit(vvi_session *s)
{
    return s->audit;
}

const char *vvi_session_uploads(const vvi_session *s)
{
    return s->uploads;
}

vvi_client *vvi_session_client(vvi_session *s, const vvi_client *after)
{
    return after ? after->next : s->clients;
}

vvi_client *vvi_session_find(const vvi_session *s, uint64_t serial)
{
    for (vvi_client *c = s->clients; c; c = c->next)
        if (c->serial == serial)
            return c;
    return NULL;
}

/* Rounds ---------------------------------------------------------------------------------------------------------- */

static void tell_job(vvi_session *s, const vvi_task_state *state)
{
    vvi_result r = {.compact = true};
    vvi_result_open(&r, NULL, '{');
    vvi_result_string(&r, "type", "job");
    vvi_result_integer(&r, "job", state->number);
    vvi_result_string(&r, "name", state->name);
    vvi_result_string(&r, "stage", state->stage);
    vvi_result_unsigned(&r, "done", state->done);
    vvi_result_unsigned(&r, "total", state->total);
    vvi_result_number(&r, "eta", state->eta_s >= 0 ? state->eta_s : (double)NAN);
    vvi_result_string(&r, "state", "running");
    vvi_result_close(&r, '}');
    vvi_session_tell(s, VVI_LINE_JOB, vvi_text_take(&r.text));
}

/* One after the other: of progress a page that reads slowly keeps the newest line alone. */
static void tell_jobs(vvi_session *s, int64_t now)
{
    vvi_task_state state;
    if (now < s->next_job_notice)
        return;
    vvi_tasks_state(&state, s->slow, s->told_job);
    if (state.number)
        tell_job(s, &state);
    s->told_job = state.number;
    s->next_job_notice = now + JOB_NOTICE;
}

/* A recording has them end in the order in which they did. */
static bool ends_now(const void *user, const vvi_task *task)
{
    const vvi_session *s = user;
    return ((const vvi_request *)(const void *)task)->asked == s->awaited;
}

void vvi_session_serve(vvi_session *s)
{
    const int64_t now = vvi_now();
    vvi_tasks_serve(s->quick, NULL, NULL);
    vvi_tasks_serve(s->slow, s->awaited ? ends_now : NULL, s);
    tell_jobs(s, now);
    for (vvi_client *c = s->clients; c; c = c->next)
        vvi_client_serve(c, now);
}

int64_t vvi_session_tick(vvi_session *s, int64_t now)
{
    int64_t wait = FOREVER;
    bool moving = false;
    for (vvi_client *c = s->clients; c; c = c->next) {
        const int64_t due = vvi_client_tick(c, now);
        wait = due < wait ? due : wait;
        moving |= c->moving;
    }
    if (!moving)
        vvi_session_keep_sync(s);
    return wait;
}
