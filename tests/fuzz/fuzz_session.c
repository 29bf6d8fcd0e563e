/* A session without sockets: lines are messages of a page, those after '@' of another. What comes before a byte 0 is
 * the journal that it finds. Nothing outside its root and its state may be touched. */
#include "core/memory.h"
#include "fields.h"
#include "fuzz.h"
#include "server/session_impl.h"

#include <ftw.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>
#include <volvis/file.h>
#include <volvis/image.h>

enum { CLIENTS = 2, MESSAGES_MOST = 200 };
static char folder[64], root[80], state[80], outside[80], ball[96];
static const char secret[] = "not to be read, not to be written\n";

static void ignore(void *user)
{
    (void)user;
}

static int take_away(const char *path, const struct stat *info, int type, struct FTW *where)
{
    (void)info;
    (void)type;
    (void)where;
    return remove(path);
}

static void remove_folder(void)
{
    nftw(folder, take_away, 16, FTW_DEPTH | FTW_PHYS);
}

static void write_bytes(const char *path, const void *bytes, size_t n)
{
    FILE *file = fopen(path, "wb");
    fuzz_expect(file && fwrite(bytes, 1, n, file) == n);
    fclose(file);
}

static void make_folder(void)
{
    if (*folder)
        return;
    snprintf(folder, sizeof folder, "%s/volvis-fuzz-XXXXXX", access("/dev/shm", W_OK) == 0 ? "/dev/shm" : "/tmp");
    fuzz_expect(mkdtemp(folder) != NULL);
    atexit(remove_folder);
    snprintf(root, sizeof root, "%s/root", folder);
    snprintf(state, sizeof state, "%s/state", folder);
    snprintf(outside, sizeof outside, "%s/outside.vv.json", folder);
    snprintf(ball, sizeof ball, "%s/ball.nrrd", root);
    fuzz_expect(mkdir(root, 0700) == 0 && mkdir(state, 0700) == 0);
    write_bytes(outside, secret, strlen(secret));
    vv_field *field = test_field_cube(&test_form_ramp, 6, 0, 8, fuzz_job());
    fuzz_expect(field && vv_field_write(ball, (const vv_field *const *)&field, 1, NULL, fuzz_job()) == VV_OK);
    vv_field_release(field);
}

/* The folder holds what it held, and the file in it what it said. */
static void check_outside(void)
{
    char bytes[sizeof secret + 1];
    struct stat info;
    FILE *file = fopen(outside, "rb");
    fuzz_expect(file != NULL);
    const size_t n = fread(bytes, 1, sizeof bytes, file);
    fclose(file);
    fuzz_expect(n == strlen(secret) && memcmp(bytes, secret, n) == 0);
    fuzz_expect(stat(folder, &info) == 0 && info.st_nlink == 4); /* root, state, . and .. of its own */
}

static vvi_session *open_session(void)
{
    const vvi_session_options options = {
        .runtime = vv_job_runtime(fuzz_job()), .root = root, .state = state, .clients_most = CLIENTS, .wake = ignore};
    vvi_session *session = NULL;
    vv_world *world = NULL;
    if (vvi_session_new(&session, &options) != VV_OK) {
        fuzz_expect(vv_error_last()->message[0] != 0);
        fuzz_expect(vvi_session_new(&session, &options) == VV_OK); /* the journal was thrown away */
    }
    if (vvi_session_restored(session) > 0)
        return session;
    fuzz_expect(vv_world_for_file(&world, ball, NULL, fuzz_job()) == VV_OK);
    fuzz_expect(vvi_session_begin(session, world) == VV_OK);
    vv_object_release(&world->base);
    return session;
}

/* What a socket would do after a message. */
static void serve(vvi_session *session, int64_t now)
{
    vvi_session_serve(session);
    vvi_session_tick(session, now);
    for (vvi_client *c = vvi_session_client(session, NULL); c; c = vvi_session_client(session, c)) {
        vvi_outgoing out;
        while (vvi_client_next(&out, c, now)) {
            json_t *text = out.text ? json_loadb(out.text, out.n, 0, NULL) : json_null();
            fuzz_expect(text != NULL);
            json_decref(text);
            free(out.text);
            vv_image_bytes_free(out.bytes);
        }
    }
}

static void let_end(vvi_session *session, int64_t now)
{
    vvi_task_state slow, quick;
    for (int i = 0; i < 50; i++) {
        serve(session, now);
        vvi_tasks_state(&slow, session->slow, 0);
        vvi_tasks_state(&quick, session->quick, 0);
        if (!slow.number && !slow.n_waiting && !quick.number && !quick.n_waiting)
            return;
        usleep(200);
    }
}

static void talk(vvi_session *session, const char *text, size_t n)
{
    vvi_client *client[CLIENTS] = {NULL, NULL};
    int64_t now = vvi_now();
    for (int i = 0; i < MESSAGES_MOST && n > 0; i++) {
        const char *end = memchr(text, '\n', n);
        const size_t length = end ? (size_t)(end - text) : n;
        const size_t skip = length > 0 && *text == '@';
        vvi_client **c = &client[skip];
        if (!*c)
            fuzz_expect(vvi_client_join(c, session, NULL) == VV_OK);
        if (vvi_client_message(*c, text + skip, length - skip, now) != VV_OK) {
            fuzz_expect(vv_error_last()->message[0] != 0);
            vvi_client_leave(*c);
            *c = NULL;
        }
        serve(session, now);
        now += 40000000;
        text += end ? length + 1 : length;
        n -= end ? length + 1 : length;
    }
    let_end(session, now);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t n)
{
    const uint8_t *zero = n ? memchr(data, 0, n) : NULL;
    const size_t n_journal = zero ? (size_t)(zero - data) : 0, skip = zero ? n_journal + 1 : 0;
    char journal[120];
    make_folder();
    snprintf(journal, sizeof journal, "%s/journal.jsonl", state);
    if (zero)
        write_bytes(journal, data, n_journal);
    vvi_session *session = open_session();
    talk(session, (const char *)data + skip, n - skip);
    vvi_session_free(session, false);
    check_outside();
    return 0;
}
