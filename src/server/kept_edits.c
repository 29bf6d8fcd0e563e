/* What is done to the World is written down before it is done, so that nothing that was answered is lost by a crash,
 * and what cannot be written down is not done. Cameras are the exception: who looks is not kept from it by a full disk,
 * and writes nothing where pages can change nothing.
 */
#include "core/json_text.h"
#include "core/memory.h"
#include "server/session_impl.h"

#include <stdlib.h>
#include <string.h>

/* A World and the files that it may name wherever they are. */
static json_t *line_of(const vvi_session *session, const vv_world *world)
{
    char *scene = NULL;
    json_t *given = json_array();
    for (size_t i = 0; i < session->n_given; i++)
        vvi_json_append(&given, json_string(session->given[i]));
    if (vv_scene_print(&scene, world, NULL) != VV_OK)
        scene = NULL;
    json_t *value = scene ? vvi_json_of_own(scene) : NULL;
    free(scene);
    return json_pack("{s:s, s:o, s:o}", "who", "", "given", given, "scene", value);
}

/* To all, when it begins (problem: why) and when it has ended (NULL). */
static void tell_change(const vvi_session *session, char **told, const char *problem, const char *over)
{
    if ((*told != NULL) == (problem != NULL))
        return;
    free(*told);
    *told = problem ? vvi_strdup(problem) : NULL;
    for (vvi_client *c = session->clients; c; c = c->next)
        if (c->greeted)
            vvi_client_notice(c, problem ? "error" : "info", problem ? problem : over);
}

void vvi_session_tell_problems(vvi_client *client)
{
    const vvi_session *s = client->session;
    const char *const problems[] = {s->unkept, s->unaudited, s->unrecorded};
    for (size_t i = 0; i < sizeof problems / sizeof *problems; i++)
        if (problems[i])
            vvi_client_notice(client, "error", problems[i]);
}

static void tell(vvi_session *session, vv_status st)
{
    tell_change(session, &session->unkept, st != VV_OK ? vv_error_last()->message : NULL,
                "changes are kept again for the case of a crash");
}

/* Somebody has removed the folder of the session, or the journal: both are made anew. */
static void mend_folder(vvi_session *session)
{
    if (!vvi_journal_is_gone(session->journal))
        return;
    vvi_journal_miss(session->journal);
    vvi_files_make_path(session->uploads);
    if (!session->mended)
        for (vvi_client *c = session->clients; c; c = c->next)
            if (c->greeted)
                vvi_client_notice(c, "warning",
                                  "the journal of this session was removed while it ran, and is written anew; files "
                                  "that were put into the session may be gone with it");
    session->mended = true; /* told once, until it is there again */
}

vv_status vvi_session_keep_begin(vvi_session *session)
{
    bool must;
    mend_folder(session);
    if (!session->journal || !vvi_journal_wants_world(session->journal, &must))
        return VV_OK;
    vv_world *world = vv_model_snapshot(session->model);
    vv_status st = vvi_journal_begin(session->journal, line_of(session, world));
    vv_object_release(&world->base);
    session->mended &= st != VV_OK;
    if (must)
        tell(session, st);
    return must ? st : VV_OK;
}

vv_status vvi_session_keep(vvi_session *session, const char *who, json_t *line)
{
    const bool camera = strcmp(who, VVI_CAMERA) == 0;
    if (!session->journal || (camera && session->options.read_only)) {
        json_decref(line);
        return VV_OK;
    }
    const vv_status st = vvi_journal_add(session->journal, line);
    tell(session, st);
    if (st == VV_OK || !camera)
        return st;
    vvi_journal_miss(session->journal);
    return VV_OK;
}

vv_status vvi_session_keep_world(vvi_session *session, const char *who, const vv_world *world)
{
    char *scene = NULL;
    if (!session->journal)
        return VV_OK;
    const vv_status st = vv_scene_print(&scene, world, NULL);
    json_t *value = st == VV_OK ? vvi_json_of_own(scene) : NULL;
    free(scene);
    return st == VV_OK ? vvi_session_keep(session, who, json_pack("{s:s, s:o}", "who", who, "scene", value)) : st;
}

void vvi_session_keep_sync(vvi_session *session)
{
    const vv_status st = vvi_journal_sync(session->journal);
    if (st != VV_OK)
        tell(session, st);
    char *problem = vvi_audit_problem(session->audit);
    tell_change(session, &session->unaudited, problem, "what people do is written down again");
    free(problem);
    problem = vvi_recording_problem(session->recording);
    tell_change(session, &session->unrecorded, problem,
                "the session is recorded again, but for what was done meanwhile");
    free(problem);
}
