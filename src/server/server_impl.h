/** @file
 * Inside the server, between its files.
 */
#ifndef VVI_SERVER_SERVER_IMPL_H
#define VVI_SERVER_SERVER_IMPL_H
#include "server/gate.h"
#include "server/server.h"
#include <libwebsockets.h>
#include <pthread.h>
#include <stdatomic.h>

enum { VVI_MESSAGE_MOST = 1 << 20, VVI_BODY_MOST = 4096 };

struct vvi_server {
    vvi_server_options options;
    struct lws_context *context;
    pthread_mutex_t waking; /* threads of the session wake the loop, until it is gone: */
    bool gone;
    lws_sorted_usec_list_t due;
    bool has_socket; /* a file, to be taken away */
    vvi_gate gate;
    vvi_session *session;
    char link[512];
    int sockets, sockets_most;
    uint64_t uploaded; /* bytes of all files that came or come */
    atomic_bool stops;
};

/** Of one HTTP request. */
typedef struct vvi_http {
    const uint8_t *bytes; /* of the answer */
    size_t n, at;
    uint8_t *owned; /* free() it */
    int file;       /* that is sent in the place of bytes; 0: none */
    char body[VVI_BODY_MOST + 1];
    size_t n_body;
    bool takes_session, too_large;
    int upload;                  /* a file that is being written; 0: none */
    uint64_t n_upload, reserved; /* bytes: what came; what was promised */
    char upload_name[128], upload_path[4096];
} vvi_http;

/** Of one WebSocket. */
typedef struct vvi_socket {
    vvi_client *client;
    char *message; /* that is coming in pieces */
    size_t n_message;
    double budget; /* messages that may come now */
    int64_t budget_at;
    bool paused;      /* nothing is taken from it for now */
    const char *ends; /* why, static; NULL: it goes on */
} vvi_socket;

int vvi_http_callback(struct lws *wsi, enum lws_callback_reasons reason, void *user, void *in, size_t n);
int vvi_socket_callback(struct lws *wsi, enum lws_callback_reasons reason, void *user, void *in, size_t n);
/** The connection ends as soon as this sentence (static) has left, or soon. */
void vvi_socket_end(struct lws *wsi, const char *why);
/** What a request says of itself, and whether it may pass. */
vvi_pass vvi_server_check(vvi_server *server, struct lws *wsi, bool upgrades);
vvi_server *vvi_server_of(struct lws *wsi);
#endif
