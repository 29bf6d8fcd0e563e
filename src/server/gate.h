/** @file
 * Who is let in: the checks of every request and upgrade, apart from any socket.
 *
 * A page of somebody else's can make a browser talk to this machine, under any name that it has given it (DNS
 * rebinding), and a WebSocket asks nobody first. So a request is answered only when it names this server as its host,
 * comes from this server's own page, and shows the token, or the cookie that was given for it.
 */
#ifndef VVI_SERVER_GATE_H
#define VVI_SERVER_GATE_H
#include "core/status.h"

enum { VVI_TOKEN_BYTES = 32, VVI_TOKEN_TEXT = 2 * VVI_TOKEN_BYTES + 1, VVI_GATE_HOSTS = 16, VVI_GATE_ADDRESSES = 64 };

/** What a request says of itself; NULL: it does not say. */
typedef struct vvi_request {
    const char *host;       /**< "localhost:8080" */
    const char *origin;     /**< "http://localhost:8080" */
    const char *fetch_site; /**< Sec-Fetch-Site */
    const char *bearer;     /**< what follows "Bearer " in Authorization */
    const char *cookie;     /**< the whole header */
    const char *address;    /**< of the peer, as text */
    const char *here;       /**< number and port by which it has come: no page can give them to another machine */
} vvi_request;

/** Failures of one address within a second. */
typedef struct vvi_failures {
    char address[48];
    int64_t since; /**< nanoseconds */
    int n;
} vvi_failures;

typedef struct vvi_gate {
    char token[VVI_TOKEN_TEXT], cookie[VVI_TOKEN_TEXT];
    char launch[VVI_TOKEN_TEXT];    /**< lets in once; empty: there is none */
    char cookie_name[40];           /**< with the port: browsers give the cookies of a host to all its ports */
    char host[VVI_GATE_HOSTS][256]; /**< names with ports that are this server's */
    int n_hosts;
    bool tls;
    vvi_failures failures[VVI_GATE_ADDRESSES];
} vvi_gate;

/** What a request may do. */
typedef enum vvi_pass {
    VVI_PASS_NONE,   /**< 403, and nothing is said of why */
    VVI_PASS_SLOWER, /**< 429: not the token, and five failures in this second */
    VVI_PASS_PAGE,   /**< the page itself and what it is made of, which hold nothing of anybody */
    VVI_PASS_ALL     /**< it has shown the token or the cookie */
} vvi_pass;

/** Hexadecimal digits of 256 random bits. VV_E_READ when the system gives none. */
vv_status vvi_token_make(char out[VVI_TOKEN_TEXT]);
/** Whether a text will do as a token: VV_E_ARGUMENT. It is 16 characters or more, none of them blank, of at least 8
 * kinds and no short piece again and again. */
vv_status vvi_token_check(const char *token);
/** A gate for a server on `port` whose names are the loopback ones, with a fresh cookie. token NULL: one is made. */
vv_status vvi_gate_open(vvi_gate *out, int port, const char *token, bool tls);
/** Another name of this server, with or without a port: "viewer.example.org". VV_E_LIMIT, VV_E_ARGUMENT. */
vv_status vvi_gate_add_host(vvi_gate *gate, const char *host, int port);
/** now: nanoseconds of a clock that does not run back. */
vvi_pass vvi_gate_check(vvi_gate *gate, const vvi_request *request, int64_t now);
/** Another token and another cookie: whoever was let in is so no more. VV_E_READ. */
vv_status vvi_gate_renew(vvi_gate *gate);
/** Makes the token that lets in once (`launch`), in the place of one that was there. VV_E_READ. */
vv_status vvi_gate_launch(vvi_gate *gate);
/** Whether a name of a host, with or without a port, is a loopback one. */
bool vvi_gate_is_loopback(const char *host);
/** Whether a text is the token; takes as long for every wrong one of its length. A wrong one counts as a failure; the
 * right one lets in however many were wrong before. */
vvi_pass vvi_gate_exchange(vvi_gate *gate, const vvi_request *request, const char *token, int64_t now);
/** The value of the header Set-Cookie. */
void vvi_gate_cookie(char out[256], const vvi_gate *gate);
#endif
