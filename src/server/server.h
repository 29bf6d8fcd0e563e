/** @file
 * One session behind a port: HTTP and WebSocket by libwebsockets.
 */
#ifndef VVI_SERVER_SERVER_H
#define VVI_SERVER_SERVER_H
#include "server/session.h"

typedef struct vvi_server vvi_server;

typedef struct vvi_server_options {
    vvi_session_options session;   /**< `wake` and `user` are the server's */
    const char *listen;            /**< address; NULL: loopback alone */
    int port;                      /**< 0: one that is free */
    const char *socket;            /**< Unix socket in the place of address and port, which is then the one at the
                                        near end of a tunnel (0: 8080); NULL: none. There as long as the server is */
    const char *token;             /**< NULL: one is made */
    const char *host;              /**< a further name of the server; NULL: none */
    const char *certificate, *key; /**< PEM files; NULL: without TLS */
    uint64_t upload_most;          /**< bytes of a file that comes from a page; 0: none may */
    /** All sessions were ended from a page, and this is the link from now on; NULL: nobody is told. */
    void (*renewed)(void *user, const char *link);
    void *user;
} vvi_server_options;

/** A part of the page, built into the program. */
typedef struct vvi_asset {
    const char *path; /**< "/app.js" */
    const char *type; /**< "text/javascript" */
    const uint8_t *bytes;
    size_t n;
} vvi_asset;
/** Ends with a path NULL; empty where the page was not built. */
extern const vvi_asset vvi_assets[];

/** What can be said of options before listening: token, certificate, the socket's folder. VV_E_ARGUMENT, VV_E_READ,
 * VV_E_WRITE. */
vv_status vvi_server_options_check(const vvi_server_options *options);
/** Listens; VV_E_UNSUPPORTED where VolVis was built without libwebsockets. */
vv_status vvi_server_new(vvi_server **out, const vvi_server_options *options);
/** keep, and what fails: of vvi_session_free(). NULL is fine. */
vv_status vvi_server_free(vvi_server *server, bool keep);
/** "http://localhost:PORT/#TOKEN"; the server's. */
const char *vvi_server_link(const vvi_server *server);
vvi_session *vvi_server_session(vvi_server *server);
/** Another link, which lets in once, for a file that a browser is started with. The server takes the file away as soon
 * as somebody was let in by it, and at its end. */
vv_status vvi_server_launch(char out[512], vvi_server *server, const char *file);
/** Serves until vvi_server_stop(), or until the job is cancelled: within a second, at once where a signal did it. */
vv_status vvi_server_run(vvi_server *server, const vv_job *job);
/** From any thread. */
void vvi_server_stop(vvi_server *server);
#endif
