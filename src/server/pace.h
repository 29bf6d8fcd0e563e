/** @file
 * How large the frames of one view are while it moves, and which of them is sent: from what frames took, apart from any
 * clock and socket.
 */
#ifndef VVI_SERVER_PACE_H
#define VVI_SERVER_PACE_H
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/** Sizes of frames are full size times 2^(-step / 4); step 0 is full size, step 12 an eighth, and the last but of views
 * larger than 2048 x 2048. */
enum { VVI_PACE_STEPS = 12 };

typedef struct vvi_pace {
    double target; /**< seconds that a frame may take */
    double pixel;  /**< seconds a pixel, of late; 0: not known yet */
    double fixed;  /**< seconds that a frame takes whatever its size: travel */
    int step;
    double small;   /**< seconds that a frame takes which is next to no bytes, of late; 0: not known yet */
    double rate[2]; /**< bytes a second of the last frames that were large enough to tell; 0: not known yet */
    double run_bytes, run_seconds; /**< of small frames one behind the other */
} vvi_pace;

void vvi_pace_init(vvi_pace *pace, double target);
/** A frame of so many pixels took `work` seconds to be made and `travel` seconds until the page had it. */
void vvi_pace_took(vvi_pace *pace, int64_t pixels, double work, double travel);
/** A frame of so many bytes took `travel` seconds until the page had it, `since` seconds after the one before it.
 * Whether it was a small one that showed the line to be faster than was known: what was made for that is worth making
 * again. */
bool vvi_pace_carried(vvi_pace *pace, size_t bytes, double travel, double since);
/** Bytes that a picture at rest may have: what the line carries in five seconds. SIZE_MAX: it is not known. One hiccup
 * of the page is no thin line: the better of two frames counts. */
size_t vvi_pace_room(const vvi_pace *pace);
/** Whether some frame told how fast the line is. */
bool vvi_pace_is_known(const vvi_pace *pace);
/** Whether the line carries so many bytes in ten seconds: a picture at rest that had less is followed by the whole. */
bool vvi_pace_carries(const vvi_pace *pace, size_t bytes);
/** The size of the next frame while the view moves. A step smaller as soon as a frame takes too long; larger only where
 * a fifth would be left. At least 1 x 1. */
void vvi_pace_size(int32_t size_out[2], vvi_pace *pace, int32_t width, int32_t height);

/** One frame under way and one that waits: a newer one takes its place. Numbers of frames grow. */
typedef struct vvi_outbox {
    uint64_t under_way, waiting; /**< numbers of frames; 0: none */
    int64_t sent_at;             /**< nanoseconds, of the one under way */
    size_t bytes;                /**< of all that was sent since the page had a frame */
} vvi_outbox;

/** A frame is ready. Returns the number of the frame that it pushes out, which nobody will see; 0: none. */
uint64_t vvi_outbox_put(vvi_outbox *box, uint64_t frame);
/** The frame to send now, which is under way then; 0: none is waiting, or one is under way. */
uint64_t vvi_outbox_send(vvi_outbox *box, int64_t now);
/** So many bytes were sent, of a frame or of a text. */
void vvi_outbox_wrote(vvi_outbox *box, size_t bytes);
/** So many of them were not, after all. */
void vvi_outbox_broke(vvi_outbox *box, size_t bytes);
/** The page has a frame. Seconds that it took; below 0: it was not under way. */
double vvi_outbox_acknowledge(vvi_outbox *box, uint64_t frame, int64_t now);
/** Whether the page has been silent about a frame for so many seconds, and one more for every 10 kB that were sent: who
 * reads 10 kB a second is slow, but there. */
bool vvi_outbox_is_stuck(const vvi_outbox *box, double seconds, int64_t now);
#endif
