/** @file
 * Inside the painter, between its files.
 */
#ifndef VVI_SERVER_PAINTER_IMPL_H
#define VVI_SERVER_PAINTER_IMPL_H
#include "server/painter.h"
#include "server/painter_shelf.h"
#include <pthread.h>

typedef struct slot {
    bool wanted, fresh;
    vvi_wish wish;
    vvi_painted painted; /* the newest that nobody has taken */
    uint64_t resolved;   /* scene that was told worked out */
    double used;         /* seconds of the quick thread, from where those stood who waited when it came to them */
} slot;

/* Two threads render, each the wishes that are its own: quick frames, of views that move or show nothing yet, and
 * pictures at rest. */
typedef enum brush_kind { QUICK, FINE, BRUSHES } brush_kind;

typedef struct brush {
    struct vvi_painter *painter;
    pthread_t thread;
    int last;     /* view that was rendered last */
    int now;      /* view that is rendered; -1: none */
    bool moving;  /* what is rendered moves, and is worth its end */
    bool stale;   /* what is rendered is for nobody any more */
    bool drafted; /* the last one was a draft: those that move come next */
    double began; /* with what it renders, seconds */
    vv_job *job;
} brush;

struct vvi_painter {
    vv_runtime *runtime;
    void (*wake)(void *user);
    void *user;
    pthread_mutex_t lock; /* of all that follows */
    pthread_cond_t changed;
    bool ends;
    slot slots[VVI_PAINTER_VIEWS];
    int n_slots;    /* that were ever used */
    bool hurries;   /* quick frames are wished, or made */
    double reached; /* seconds that who had its turn last had used */
    brush brushes[BRUSHES];
    uint64_t n_cast, n_kept; /* rays of pictures at rest that were cast; that were there already */
    vvi_shelf shelf;         /* of the fine brush alone, as what follows */
    uint64_t ready;          /* scene that quick frames need nothing more for; */
};

/* One wish being rendered; its brush's thread alone. */
typedef struct painting {
    vvi_painter *painter;
    brush *brush;
    int at;
    bool draft;            /* a quick frame of a view at rest that shows nothing yet */
    int32_t draft_size[2]; /* of it */
    int n_looking;         /* views, this one included */
    vvi_wish wish;
    vv_world *world; /* with the camera */
    vv_job *job;
    double begin, last;
    bool has_stand;
    vvi_stand stand;
    const char *method;
    vvi_warnings warnings; /* of files that were read */
} painting;

/** Renders it, and leaves what comes of it in its slot. */
void vvi_painting_paint(painting *p);
/** Whether nobody wishes anything. */
bool vvi_painter_is_idle(vvi_painter *painter);
#endif
