/* Files that come: PUT /files/NAME. Nothing is kept for what is announced: a file holds what has come of it. */
#include "core/json_text.h"
#include "core/memory.h"
#include "server/server_impl.h"

#include <errno.h>
#include <fcntl.h>
#include <jansson.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

/* UPLOADS: how many of the largest files that are taken, all those of a session together may weigh. FILES: how many
 * there may be; each takes a block of the disk and a folder, whatever is in it. */
enum { UPLOADS = 4, FILES = 32768, BLOCK = 4096, BATCH_LEAST = 16, BATCH_MOST = 64 };
/* Seconds in which a quarter of a MiB must come: who trickles is ended. */
enum { UPLOAD_SECONDS = 20, UPLOAD_WINDOW = 256 << 10 };
/* After so many bytes it is looked again whether the rest has room: others bring files, too. */
enum { LOOK = 16 << 20 };

static int refuse_too_much(vvi_peer *peer)
{
    return vvi_answer_refusal(
        peer, HTTP_STATUS_REQ_ENTITY_TOO_LARGE,
        "This server has accepted as many files as it may; open the file from a folder of the server.\n");
}

static int refuse_storing(vvi_peer *peer, int error)
{
    if (error == ENOSPC || error == EDQUOT || error == EFBIG)
        return vvi_answer_refusal(
            peer, 507, "The server's disk is full, and the file was not stored; try again when there is room on it.\n");
    return vvi_answer_refusal(peer, HTTP_STATUS_INTERNAL_SERVER_ERROR, "The file cannot be stored on the server.\n");
}

/* Of so many bytes that are still to come. */
static int refuse_no_room(vvi_peer *peer, uint64_t bytes)
{
    if (!vvi_session_disk_holds(peer->server->session, bytes))
        return refuse_storing(peer, ENOSPC);
    return vvi_answer_refusal(
        peer, HTTP_STATUS_REQ_ENTITY_TOO_LARGE,
        "There is no room for the file beside the results and files that are there; open it from a folder of the "
        "server.\n");
}

/* Counting -------------------------------------------------------------------------------------------------------- */

/* What a file takes on a disk: one without bytes a block, too. */
static uint64_t cost_of(uint64_t bytes)
{
    return bytes > BLOCK ? (bytes + BLOCK - 1) / BLOCK * BLOCK : BLOCK;
}

static bool is_too_much(const vvi_server *server, uint64_t more)
{
    const uint64_t most = UPLOADS * cost_of(server->options.upload_most);
    return server->uploaded > most || more > most - server->uploaded;
}

/* In files without a name, which nobody finds who weighs those that are there. */
static void count_came(vvi_peer *peer, uint64_t n)
{
    vvi_http *http = peer->http;
    peer->server->uploaded += cost_of(http->n_upload + n) - cost_of(http->n_upload);
    http->n_upload += n;
    http->window += n;
    http->unchecked += n;
    if (http->nameless)
        vvi_session_upload_came(peer->server->session, (int64_t)n, false);
}

/* Files ----------------------------------------------------------------------------------------------------------- */

/* What files that come together have before their name: a word of 16 letters and digits or more, which the page made
 * up. The name behind it. */
static const char *take_batch(char out[BATCH_MOST + 1], const char *name)
{
    static const char letters[] = "0123456789abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ";
    const size_t n = strspn(name, letters);
    if (n < BATCH_LEAST || n > BATCH_MOST || name[n] != '/')
        return name;
    memcpy(out, name, n);
    out[n] = 0;
    return name + n + 1;
}

/* A name that no other file has, for a new file or for one that has none; false: errno says why not. */
static bool name_upload(vvi_http *http)
{
    char own[32];
    snprintf(own, sizeof own, "/proc/self/fd/%d", http->upload);
    for (int i = 0; i < 1000; i++) {
        snprintf(http->upload_path, sizeof http->upload_path, i ? "%.3900s/%d-%s" : "%.3900s/%.0d%s",
                 http->upload_folder, i, http->upload_name);
        if (http->nameless && linkat(AT_FDCWD, own, AT_FDCWD, http->upload_path, AT_SYMLINK_FOLLOW) == 0)
            return true;
        if (!http->nameless)
            http->upload = open(http->upload_path, O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC | O_NOFOLLOW, 0600);
        if (!http->nameless && http->upload > 0)
            return true;
        if (errno != EEXIST)
            return false;
    }
    return false;
}

/* The folder goes where nothing is in it. */
static void leave_folder(vvi_http *http)
{
    if (http->upload_folder)
        rmdir(http->upload_folder);
    free(http->upload_folder);
    http->upload_folder = NULL;
}

/* Without a name until all of it is there, so that nothing is left of it when the program is killed; where the file
 * system has no such files, with one. False: errno says why. */
static bool open_upload(vvi_http *http, vvi_session *session, const char *batch)
{
    if (vvi_session_upload_folder(&http->upload_folder, session, batch) != VV_OK)
        return false;
    http->upload = open(http->upload_folder, O_TMPFILE | O_WRONLY | O_CLOEXEC, 0600);
    http->nameless = http->upload > 0;
    if (http->nameless || name_upload(http))
        return true;
    const int error = errno;
    http->upload = 0;
    leave_folder(http);
    errno = error;
    return false;
}

void vvi_upload_drop(vvi_peer *peer)
{
    vvi_http *http = peer->http;
    if (http->upload) {
        close(http->upload);
        if (!http->nameless)
            unlink(http->upload_path);
        else
            vvi_session_upload_came(peer->server->session, -(int64_t)http->n_upload, false);
        peer->server->uploaded -= cost_of(http->n_upload);
        peer->server->uploads--;
    }
    http->upload = 0;
    leave_folder(http);
}

/* Coming ---------------------------------------------------------------------------------------------------------- */

static int begin(vvi_peer *peer, const char *name)
{
    vvi_server *server = peer->server;
    vvi_http *http = peer->http;
    char batch[BATCH_MOST + 1] = "";
    if (!vvi_session_uploads(server->session) || server->options.session.read_only)
        return vvi_answer_refusal(peer, HTTP_STATUS_FORBIDDEN, "This server accepts no files.\n");
    peer->uploads = true;
    name = take_batch(batch, name);
    if (!*name || strchr(name, '/') || *name == '.' || strlen(name) >= sizeof http->upload_name)
        return vvi_answer_refusal(peer, HTTP_STATUS_BAD_REQUEST, "A file needs a plain name of at most 127 letters.\n");
    if (http->length > server->options.upload_most)
        return vvi_answer_refusal(
            peer, HTTP_STATUS_REQ_ENTITY_TOO_LARGE,
            "The file is larger than this server accepts; open it from a folder of the server.\n");
    if (server->uploads >= FILES || is_too_much(server, cost_of(http->length)))
        return refuse_too_much(peer);
    if (vvi_session_upload_room(server->session, http->length) != VV_OK)
        return refuse_no_room(peer, http->length);
    vvi_http_note(peer, "upload", name, false);
    snprintf(http->upload_name, sizeof http->upload_name, "%s", name);
    if (!open_upload(http, server->session, batch))
        return refuse_storing(peer, errno);
    server->uploaded += cost_of(0);
    server->uploads++;
    vvi_peer_expects(peer, UPLOAD_SECONDS);
    return 0;
}

static int end(vvi_peer *peer)
{
    vvi_http *http = peer->http;
    if (vvi_session_upload_room(peer->server->session, 0) != VV_OK) {
        vvi_upload_drop(peer);
        return refuse_no_room(peer, 0);
    }
    if (http->nameless && !name_upload(http)) {
        const int error = errno;
        vvi_upload_drop(peer);
        return refuse_storing(peer, error);
    }
    const int error = close(http->upload) == 0 ? 0 : errno;
    http->upload = 0;
    if (http->nameless)
        vvi_session_upload_came(peer->server->session, -(int64_t)http->n_upload, true);
    if (error) {
        vvi_files_remove(http->upload_path);
        return refuse_storing(peer, error);
    }
    json_t *value = json_pack("{s:s}", "path", http->upload_path);
    char *text = value ? vvi_json_encode(value, 0) : NULL;
    json_decref(value);
    peer->uploads = false; /* nothing more is on its way */
    return vvi_answer_text(peer, 201, "application/json", text);
}

/* Many small files, and a file in many small pieces, cost more than their bytes: whose address owes for them is
 * answered when it does not any more. */
static int end_in_turn(vvi_peer *peer)
{
    if (vvi_peer_may_send(peer, vvi_now()))
        return end(peer);
    lws_rx_flow_control(peer->wsi, 0);
    return 0;
}

int vvi_upload_begin(vvi_peer *peer, const char *name)
{
    double since = vvi_ration_clock();
    if (!vvi_peer_ration(peer, vvi_now()))
        return -1;
    if (begin(peer, name) != 0)
        return -1;
    vvi_peer_pay(peer, &since, 0);
    if (!peer->http->upload || peer->http->length > 0)
        return 0;
    const int result = end_in_turn(peer);
    vvi_peer_pay(peer, &since, 0);
    return result;
}

/* 0, or an error's number. */
static int write_all(int fd, const uint8_t *in, size_t n)
{
    while (n > 0) {
        const ssize_t done = write(fd, in, n);
        if (done < 0 && errno != EINTR)
            return errno;
        in += done > 0 ? done : 0;
        n -= done > 0 ? (size_t)done : 0;
    }
    return 0;
}

/* Whether the rest of it has room still: others bring files, too. */
static bool has_room_still(vvi_peer *peer)
{
    vvi_http *http = peer->http;
    if (http->unchecked < LOOK)
        return true;
    http->unchecked = 0;
    return vvi_session_upload_room(peer->server->session, http->length - http->n_upload) == VV_OK;
}

int vvi_upload_take(vvi_peer *peer, const uint8_t *in, size_t n)
{
    vvi_http *http = peer->http;
    const uint64_t left = http->length - http->n_upload;
    n = n < left ? n : (size_t)left;
    const int error = write_all(http->upload, in, n);
    if (error) {
        vvi_upload_drop(peer);
        return refuse_storing(peer, error);
    }
    count_came(peer, n);
    const bool too_much = is_too_much(peer->server, 0);
    if (too_much || !has_room_still(peer)) {
        vvi_upload_drop(peer);
        return too_much ? refuse_too_much(peer) : refuse_no_room(peer, http->length);
    }
    if (http->window >= UPLOAD_WINDOW) {
        http->window = 0;
        vvi_peer_expects(peer, UPLOAD_SECONDS);
    }
    return n == left ? end_in_turn(peer) : 0;
}
