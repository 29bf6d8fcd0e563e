/** @file
 * Inside the server, between its files.
 */
#ifndef VVI_SERVER_SERVER_IMPL_H
#define VVI_SERVER_SERVER_IMPL_H
#include "server/framing.h"
#include "server/gate.h"
#include "server/head.h"
#include "server/ration.h"
#include "server/server.h"
#include <libwebsockets.h>
#include <pthread.h>
#include <stdatomic.h>

enum { VVI_BODY_MOST = 4096, VVI_DOORS = 2 };

struct vvi_server {
    vvi_server_options options;
    struct lws_context *context;
    pthread_mutex_t waking; /* threads of the session wake the loop, until it is gone: */
    bool gone;
    atomic_bool woken; /* the session has something to say */
    lws_sorted_usec_list_t due;
    bool has_socket; /* a file, to be taken away */
    vvi_gate gate;
    vvi_session *session;
    struct vvi_peer *peers;
    char link[512], origin[440]; /* origin: the link without its token */
    char *launch_file;           /* that holds the link which lets in once; NULL: none */
    int port, sockets, sockets_most;
    bool soon;         /* what is due for all is done soon */
    int64_t swept;     /* when it was looked who takes too long */
    uint64_t uploaded; /* what all files that came or come take on a disk, bytes */
    int uploads;       /* files that came or come */
    int at_once;       /* connections that came since the doors were looked at */
    int waiting;       /* of those who waited, that are taken whatever they cost, so many have not come yet */
    int64_t emptied;   /* when it was looked how many those are */
    int strangers;     /* connections that were not let in */
    vvi_rations rations;
    struct lws *doors[VVI_DOORS]; /* where connections come, as far as any has; two loopback addresses at most */
    int calls;                    /* of connections, since the clock of this thread showed: */
    double clock, paid;           /* paid: seconds since then that somebody has paid */
    double of_call;               /* seconds that the loop itself takes for a call, about */
    bool is_shut;                 /* those that come wait in the system's queue */
    size_t shared;                /* bytes of long messages that come, of all clients */
    atomic_bool stops;
};

/* server_doors.c -------------------------------------------------------------------------------------------------- */

/** A connection comes at a door: it is let in, and others when it is their turn or they have waited. False: there are
 * too many. */
bool vvi_doors_admit(vvi_server *server, struct lws *door, int64_t now);
/** Whenever a connection has closed: doors that are shut stay so. */
void vvi_doors_stay(vvi_server *server);
/** Connections that have brought nobody yet took the time since the clock showed `since`, and a call of the loop. */
void vvi_doors_pay(vvi_server *server, double since, int64_t now);
/** One who has come and gone took `seconds`, and so many calls. */
void vvi_doors_pay_visit(vvi_server *server, double seconds, int calls, int64_t now);
/** Opens them again when it is time. Nanoseconds until then; INT64_MAX: they are open. */
int64_t vvi_doors_tick(vvi_server *server, int64_t now);

/* server_peer.c --------------------------------------------------------------------------------------------------- */

typedef enum vvi_peer_state {
    VVI_PEER_HEAD,   /* its request comes */
    VVI_PEER_BODY,   /* what the request brings comes */
    VVI_PEER_ANSWER, /* the answer leaves */
    VVI_PEER_SOCKET, /* it is a WebSocket */
    VVI_PEER_ENDS    /* all is said; what it still sends is passed over until it closes, or soon */
} vvi_peer_state;

/** One connection. libwebsockets gives bytes, encrypted or not, and its loop; HTTP and WebSocket are read here
 * (decision 20). */
typedef struct vvi_peer {
    vvi_server *server;
    struct lws *wsi;
    struct vvi_peer *next, **link; /* of the server's */
    vvi_peer_state state;
    char address[48];
    int64_t deadline; /* when it ends unless something happens, nanoseconds; 0: never */
    char *in;         /* the head as it comes */
    size_t n_in, room_in;
    struct vvi_http *http;     /* its request; NULL: none yet, or no more */
    struct vvi_socket *socket; /* NULL: none */
    uint8_t *out;              /* what leaves, LWS_PRE bytes before it; NULL: nothing */
    size_t n_out, at_out;
    int64_t moved;     /* when some of it left */
    int calls;         /* of the loop, since it is a WebSocket or brings a file */
    size_t passed;     /* bytes that nobody wanted */
    bool let_in;       /* it has shown a token or a cookie that is right */
    bool ends;         /* it is being ended */
    bool uploads;      /* it was let in to bring a file */
    vvi_ration ration; /* of a WebSocket, and of a file that comes; zeros: it has none */
    int64_t resumes;   /* when more is taken from it, where it has cost too much; 0: at once */
} vvi_peer;

int vvi_peer_callback(struct lws *wsi, enum lws_callback_reasons reason, void *user, void *in, size_t n);
/** n bytes to be sent when nothing else is leaving; copies them behind each other. False: no memory. */
bool vvi_peer_put(vvi_peer *peer, const void *head, size_t n_head, const void *bytes, size_t n);
/** The same for n bytes that are yet to be written there. NULL: no memory. */
uint8_t *vvi_peer_room(vvi_peer *peer, size_t n);
/** What has not left yet of `out`, from `at` on, becomes these n bytes, of which it has at least as many there. */
void vvi_peer_cut(vvi_peer *peer, size_t at, const void *end, size_t n);
/** It ends in so many seconds unless this is called again. */
void vvi_peer_expects(vvi_peer *peer, int seconds);
/** It has shown a token or a cookie that is right. */
void vvi_peer_let_in(vvi_peer *peer);
/** At once, from a timer. */
void vvi_peer_kill(vvi_peer *peer);
/** What it costs is counted from now on. False: no memory. */
bool vvi_peer_ration(vvi_peer *peer, int64_t now);
/** It pays for the time since the clock (vvi_ration_clock()) showed *since, which is set anew, and for n bytes. */
void vvi_peer_pay(vvi_peer *peer, double *since, size_t n);
/** Whether something may be taken from it now; else `resumes` says when. */
bool vvi_peer_may_send(vvi_peer *peer, int64_t now);
/** Whether the other side of one that has to wait has gone. */
bool vvi_peer_has_gone(const vvi_peer *peer);
/** Goes on with one that might not: bytes that wait in the system come again. */
void vvi_peer_resume(vvi_peer *peer, int64_t now);

/* server_http.c --------------------------------------------------------------------------------------------------- */

/** Of the one request of a connection. */
typedef struct vvi_http {
    const uint8_t *bytes; /* of the answer */
    size_t n, at;
    uint8_t *owned; /* free() it */
    int file;       /* that is sent in the place of bytes; 0: none */
    bool without_body, secure_name;
    char body[VVI_BODY_MOST + 1];
    size_t n_body;
    uint64_t length; /* of the body, as it was promised */
    bool takes_session;
    int upload;          /* a file that is being written; 0: none */
    bool nameless;       /* it has no name yet */
    uint64_t n_upload;   /* bytes of it that came */
    uint64_t window;     /* of those, since the deadline was set */
    uint64_t unchecked;  /* and since it was looked whether there is room for the rest */
    char *upload_folder; /* of it, and of what comes with it */
    char upload_name[128], upload_path[4096];
} vvi_http;

/* server_answer.c: all of these but the last return -1 where the connection ends at once. */
/** n bytes, which stay where they are. */
int vvi_answer_bytes(vvi_peer *peer, int status, const char *type, const void *bytes, size_t n);
/** Takes the text; NULL: there was no memory. */
int vvi_answer_text(vvi_peer *peer, int status, const char *type, char *text);
/** A sentence, static. */
int vvi_answer_refusal(vvi_peer *peer, int status, const char *sentence);
/** Another time: the server has as many connections as it can have. */
int vvi_answer_later(vvi_peer *peer);
/** The body of a request that waits for it may come; false: no memory. */
bool vvi_answer_go_on(vvi_peer *peer);
/** Nothing, with another header. */
int vvi_answer_empty(vvi_peer *peer, int status, const char *name, const char *value);
/** The next piece of the answer into peer->out; *done: there is none. */
int vvi_answer_next(vvi_peer *peer, bool *done);
/** Whether all of it has left. */
bool vvi_answer_has_left(const vvi_peer *peer);
void vvi_answer_clear(vvi_http *http);

/* These return -1 where the connection ends at once. */
/** The head is read, or could not be (status, why). */
int vvi_http_begin(vvi_peer *peer, const vvi_head *head, int status, const char *why);
int vvi_http_take(vvi_peer *peer, const uint8_t *in, size_t n);
void vvi_http_free(vvi_peer *peer);
/** A line of the audit log. */
void vvi_http_note(const vvi_peer *peer, const char *what, const char *object, bool refused);

/* server_upload.c ------------------------------------------------------------------------------------------------- */

/** PUT of this name. Returns -1 where the connection ends at once, as do the others. */
int vvi_upload_begin(vvi_peer *peer, const char *name);
/** More of the file; it ends with its last byte, or when it is its turn. */
int vvi_upload_take(vvi_peer *peer, const uint8_t *in, size_t n);
/** What came of a file that is not whole goes, and counts no more. */
void vvi_upload_drop(vvi_peer *peer);

/* server_socket.c ------------------------------------------------------------------------------------------------- */

typedef struct vvi_socket {
    vvi_client *client;
    vvi_framing framing;
    int64_t came;        /* when */
    bool spoke;          /* something of what it said was taken */
    int pieces;          /* in so many, before it said hello */
    double cost;         /* seconds of the loop, so far */
    int64_t begun;       /* when the message that is not whole yet began; 0: there is none */
    int64_t heard;       /* when something came last */
    int64_t drained;     /* when nothing of it waited to be taken, last */
    bool pings, ponders; /* pings: one is to be sent; ponders: one was, and nothing came since */
    bool paused;         /* nothing is taken from it for now */
    uint8_t *rest;       /* what came and is not taken yet */
    size_t n_rest;
    uint8_t pong[VVI_CONTROL_MOST];
    size_t n_pong;
    bool pongs;
    bool breaks;     /* what leaves is a picture in parts, which may be broken off */
    int64_t seen_at; /* when it was looked at last how far that is; 0: never */
    size_t seen;     /* how far it was */
    int code;        /* it ends by this farewell; 0: it goes on */
    bool parted;     /* that is on its way */
    char why[VVI_CONTROL_MOST - 1];
} vvi_socket;

/** Answers the upgrade and joins the session. */
int vvi_socket_begin(vvi_peer *peer, const vvi_head *head);
/** The status of a refusal with its sentence; 200: it is an upgrade to our WebSocket. */
int vvi_socket_check(const char **why, const vvi_head *head);
int vvi_socket_take(vvi_peer *peer, const uint8_t *in, size_t n);
int vvi_socket_next(vvi_peer *peer, bool *done);
/** What is due by now, once a second or more often; how long until it should be called again, nanoseconds. */
int64_t vvi_socket_tick(vvi_peer *peer, int64_t now);
/** It ends as soon as this sentence has left, or soon. */
void vvi_socket_end(vvi_peer *peer, int code, const char *why);
void vvi_socket_free(vvi_peer *peer);

/* server.c -------------------------------------------------------------------------------------------------------- */

/** After a message: what is due for all of them is done soon. */
void vvi_server_go_soon(vvi_server *server);
/** Everybody who was let in is sent away, and there is another token, in another link. */
vv_status vvi_server_renew(vvi_server *server);
/** The file that a browser was started with is not there any more. */
void vvi_server_forget_launch(vvi_server *server);
vvi_server *vvi_server_of(struct lws *wsi);
#endif
