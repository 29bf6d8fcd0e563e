/** @file
 * What a page sends through a WebSocket (RFC 6455), taken apart into messages; apart from any socket.
 */
#ifndef VVI_SERVER_FRAMING_H
#define VVI_SERVER_FRAMING_H
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/** Bytes of a message, and pieces of one, at most. VVI_MESSAGE_OWN: bytes that everybody has for a message that comes;
 * those beyond are all clients' together, VVI_MESSAGES_SHARED of them. */
enum {
    VVI_MESSAGE_MOST = 1 << 20,
    VVI_MESSAGE_OWN = 256 << 10,
    VVI_MESSAGES_SHARED = 16 << 20,
    VVI_MESSAGE_PIECES = 1024,
    VVI_CONTROL_MOST = 125
};

typedef enum vvi_framed {
    VVI_FRAMED_MORE,    /**< nothing is whole yet */
    VVI_FRAMED_MESSAGE, /**< a text, UTF-8 */
    VVI_FRAMED_PING,    /**< control bytes are to be sent back */
    VVI_FRAMED_PONG,
    VVI_FRAMED_CLOSE, /**< the farewell, with `code` or 0 */
    VVI_FRAMED_BAD    /**< the connection ends by `code` and `why` */
} vvi_framed;

/** Zeros: nothing came. */
typedef struct vvi_framing {
    uint8_t head[14];
    size_t n_head;
    uint8_t kind; /* of the frame */
    bool final, in_message;
    uint8_t mask[4];
    uint64_t length, at; /* of the frame's bytes; those that came */
    int pieces;
    char *message; /**< with a 0 behind it; until the next call */
    size_t n_message, room;
    size_t most;    /**< bytes of a message, yours to set; 0: VVI_MESSAGE_MOST */
    size_t *shared; /**< bytes that all take beyond their own, yours to set; NULL: as many as it likes */
    uint8_t control[VVI_CONTROL_MOST];
    size_t n_control;
    int code;
    const char *why;
} vvi_framing;

/** Takes bytes from *at, up to the end of what it tells of. */
vvi_framed vvi_framing_take(vvi_framing *framing, const uint8_t **at, const uint8_t *end);
void vvi_framing_clear(vvi_framing *framing);
/** The message is read: the room of a long one is given back. */
void vvi_framing_forget(vvi_framing *framing);
/** The head of a frame of ours, of n bytes; returns its length. */
size_t vvi_framing_head(uint8_t out[10], int kind, size_t n);
/** The same of a message in parts: the first has its kind, the others VVI_FRAME_MORE. */
size_t vvi_framing_part(uint8_t out[10], int kind, size_t n, bool last);
/** Kinds of frames. */
enum {
    VVI_FRAME_MORE = 0,
    VVI_FRAME_TEXT = 1,
    VVI_FRAME_BINARY = 2,
    VVI_FRAME_CLOSE = 8,
    VVI_FRAME_PING = 9,
    VVI_FRAME_PONG = 10
};
/** Why a connection is closed, of the registry of WebSocket. */
enum {
    VVI_CLOSE_GOES = 1000,
    VVI_CLOSE_PROTOCOL = 1002,
    VVI_CLOSE_KIND = 1003,
    VVI_CLOSE_NO_TEXT = 1007,
    VVI_CLOSE_POLICY = 1008,
    VVI_CLOSE_TOO_LARGE = 1009,
    VVI_CLOSE_TRY_LATER = 1013
};
#endif
