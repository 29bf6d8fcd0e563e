/** @file
 * What a source is made of: for source.c, source_check.c, source_open.c and source_line.c alone.
 */
#ifndef VVI_IO_SOURCE_IMPL_H
#define VVI_IO_SOURCE_IMPL_H
#include "io/coding.h"
#include "io/source.h"
#include "io/store.h"

#define VVI_SOURCE_WINDOW ((size_t)256 << 10)
#define VVI_SOURCE_PEEK_MOST 4096

struct vv_source {
    vvi_store *store;
    vv_source *parent; /* instead of reading the store; borrowed */
    vv_source *kept;   /* a section, for the next who needs it */
    vv_job *job;
    char *name;
    vvi_coding coding;
    vvi_decoder *decoder; /* NULL: uncoded */
    uint64_t start, n;    /* the window, in bytes of the store or of the parent; n UINT64_MAX: all */
    uint64_t fetched;     /* bytes taken from the window */
    uint64_t at;          /* the next byte handed out */
    uint64_t decoded;     /* bytes that the decoder has made */
    uint8_t *ahead;       /* decoded, not handed out: ahead[ahead_at .. ahead_end) */
    size_t ahead_at, ahead_end;
    uint8_t *coded; /* fetched, not decoded */
    size_t coded_at, coded_end;
    uint64_t again; /* bytes that were made once and were asked for again */
    int restarts;
    bool between;      /* at the start of the data or between two coded members */
    bool ended;        /* nothing more will be decoded */
    char problem[160]; /* why it ended too early; "" when it did not */
    vv_status problem_status;
    bool cut;          /* that the file is cut short is the problem, and no other */
    bool proven;       /* all of it has been seen, and its checksums were right */
    bool proven_cut;   /* all of it has been seen, and it is cut short */
    uint64_t ends_at;  /* where either is so: how many decoded bytes there are */
    uint64_t needed;   /* bytes that must come of it: vvi_source_need() */
    bool told;         /* how much memory what came from it takes is said, and not counted: vvi_source_hold() */
    uint64_t handed;   /* bytes handed out, as long as they are counted; what vvi_source_grow() was told */
    unsigned follow;   /* VVI_FOLLOW_* */
    vvi_lack *lack;    /* of the file that is opened; NULL: what is missing is an error */
    bool guarded;      /* all decoded bytes have this sum */
    uint32_t crc, sum; /* which, and that of the first `summed` bytes */
    uint64_t summed;
    const void *mapped; /* what was mapped last, and where it lies in the store */
    uint64_t mapped_at;
    char *line;
    size_t line_room;
};

/** Whether it is known where its data end, since all of them have been seen. */
static inline bool vvi_source_seen(const vv_source *s)
{
    return s->proven || s->proven_cut;
}

/** Undecoded bytes of the window, from its start; an upper bound. */
uint64_t vvi_source_window_bytes(vv_source *source, bool *exact);
vv_status vvi_source_fail(const vv_source *source); /* with its problem */
vv_status vvi_source_rewind(vv_source *source);
/** Before n bytes are handed out which may be kept: where they are counted, the same as vvi_source_hold(). */
vv_status vvi_source_hand(vv_source *source, uint64_t n);
#endif
