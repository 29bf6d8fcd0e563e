#include "server/pace.h"

#include <math.h>

#define RECENT 0.3        /* weight of the newest frame */
#define TELLING 16384     /* bytes of a frame, at least, that tell how fast the line is */
#define RUN 32768         /* bytes of small frames one behind the other, at least, that tell it too */
#define PAUSE 1           /* seconds between two of them, at most */
#define AT_REST 5         /* seconds that a picture at rest may be under way */
#define WHOLE 10          /* seconds that the whole may be, which follows one that had less */
#define SLOWEST 1e4       /* bytes a second of a page that is there */
#define AHEAD (256 << 10) /* bytes of texts before a frame that count as sent with it */
#define ROOM 0.8          /* of the target, which a larger frame must stay below */
#define UNKNOWN 262144    /* pixels of a frame, at most, while it is not known what they take */
#define LEAST 65536       /* of one that is an eighth of a view's width and height, and may be less still */

void vvi_pace_init(vvi_pace *pace, double target)
{
    *pace = (vvi_pace){.target = target, .step = 4};
}

static double blend(double old, double now)
{
    return old > 0 ? old + RECENT * (now - old) : now;
}

void vvi_pace_took(vvi_pace *pace, int64_t pixels, double work, double travel)
{
    if (pixels <= 0 || !(work >= 0) || !(travel >= 0) || !isfinite(work + travel))
        return;
    pace->pixel = blend(pace->pixel, work / (double)pixels);
    pace->fixed = blend(pace->fixed, travel);
}

static double rate_of(const vvi_pace *pace)
{
    return fmax(pace->rate[0], pace->rate[1]);
}

static void note_rate(vvi_pace *pace, double rate)
{
    pace->rate[1] = pace->rate[0];
    pace->rate[0] = rate;
}

/* Small frames tell that the line is faster than was known, which is how a line that was slow, and so gets none but
 * small ones, is found to be mended: many one behind the other how fast it is, and one that half a second of it would
 * have carried that it may be twice as fast. Less tells nothing: a thin line too carries the first bytes at once. */
static bool note_small(vvi_pace *pace, size_t bytes, double travel, double since)
{
    const double known = rate_of(pace), alone = (double)bytes / travel;
    const bool is_run = since > 0 && since < PAUSE;
    double least = 0;
    pace->run_bytes = is_run ? pace->run_bytes + (double)bytes : 0;
    pace->run_seconds = is_run ? pace->run_seconds + since : 0;
    if (pace->run_bytes >= RUN) {
        least = pace->run_bytes / pace->run_seconds;
        pace->run_bytes = pace->run_seconds = 0;
    }
    if ((double)bytes >= 0.5 * known && alone > known)
        least = fmax(least, fmin(alone, 2 * known));
    if (!(known > 0 && least > known))
        return false;
    note_rate(pace, least);
    return true;
}

/* What a small frame takes too is the page's time and the way, whatever the bytes: at most half of it, since a small
 * one may have waited behind texts. */
bool vvi_pace_carried(vvi_pace *pace, size_t bytes, double travel, double since)
{
    if (!(travel > 0))
        return false;
    if (bytes < TELLING) {
        pace->small = pace->small > 0 && travel > pace->small ? blend(pace->small, travel) : travel;
        return note_small(pace, bytes, travel, since);
    }
    pace->run_bytes = pace->run_seconds = 0;
    note_rate(pace, (double)bytes / fmax(travel - pace->small, 0.5 * travel));
    return false;
}

size_t vvi_pace_room(const vvi_pace *pace)
{
    const double room = AT_REST * rate_of(pace);
    return room > 0 && room < 1e9 ? (size_t)room : SIZE_MAX;
}

bool vvi_pace_is_known(const vvi_pace *pace)
{
    return rate_of(pace) > 0;
}

bool vvi_pace_carries(const vvi_pace *pace, size_t bytes)
{
    return WHOLE * rate_of(pace) >= (double)bytes;
}

static double scale(int step)
{
    return exp2(-step / 4.0);
}

static int32_t scaled(int32_t length, int step)
{
    const double n = round(length * scale(step));
    return n < 1 ? 1 : (int32_t)n;
}

static double pixels(int step, int32_t width, int32_t height)
{
    return (double)scaled(width, step) * (double)scaled(height, step);
}

static double seconds(const vvi_pace *pace, int step, int32_t width, int32_t height)
{
    return pace->fixed + pace->pixel * pixels(step, width, height);
}

static bool is_slow(const vvi_pace *pace, int32_t width, int32_t height)
{
    return pace->pixel > 0 ? seconds(pace, pace->step, width, height) > pace->target
                           : pixels(pace->step, width, height) > UNKNOWN;
}

/* The smallest; of a view larger than screens are it may be less than an eighth. */
static bool is_last(const vvi_pace *pace, int32_t width, int32_t height)
{
    return pace->step >= VVI_PACE_STEPS && pixels(pace->step, width, height) <= LEAST;
}

void vvi_pace_size(int32_t size_out[2], vvi_pace *pace, int32_t width, int32_t height)
{
    while (!is_last(pace, width, height) && is_slow(pace, width, height))
        pace->step++;
    while (pace->pixel > 0 && pace->step > 0 && seconds(pace, pace->step - 1, width, height) < ROOM * pace->target)
        pace->step--;
    size_out[0] = scaled(width, pace->step);
    size_out[1] = scaled(height, pace->step);
}

uint64_t vvi_outbox_put(vvi_outbox *box, uint64_t frame)
{
    const uint64_t pushed = box->waiting;
    box->waiting = frame;
    return pushed;
}

uint64_t vvi_outbox_send(vvi_outbox *box, int64_t now)
{
    if (box->under_way || !box->waiting)
        return 0;
    box->under_way = box->waiting;
    box->waiting = 0;
    box->sent_at = now;
    return box->under_way;
}

void vvi_outbox_wrote(vvi_outbox *box, size_t bytes)
{
    box->bytes += bytes;
    if (!box->under_way && box->bytes > AHEAD)
        box->bytes = AHEAD;
}

void vvi_outbox_broke(vvi_outbox *box, size_t bytes)
{
    box->bytes -= bytes < box->bytes ? bytes : box->bytes;
}

double vvi_outbox_acknowledge(vvi_outbox *box, uint64_t frame, int64_t now)
{
    if (!frame || frame != box->under_way)
        return -1;
    box->under_way = 0;
    box->bytes = 0;
    return 1e-9 * (double)(now - box->sent_at);
}

bool vvi_outbox_is_stuck(const vvi_outbox *box, double limit, int64_t now)
{
    return box->under_way && 1e-9 * (double)(now - box->sent_at) > limit + (double)box->bytes / SLOWEST;
}
