/** @file
 * Inside the painter, between its files.
 */
#ifndef VVI_SERVER_PAINTER_IMPL_H
#define VVI_SERVER_PAINTER_IMPL_H
#include "server/painter.h"
#include <pthread.h>

typedef struct slot {
    bool wanted, fresh;
    vvi_wish wish;
    vvi_painted painted; /* the newest that nobody has taken */
    uint64_t resolved;   /* scene that was told worked out */
    double slice;        /* seconds before the next picture at rest steps aside */
} slot;

struct vvi_painter {
    vv_runtime *runtime;
    void (*wake)(void *user);
    void *user;
    pthread_t thread;
    pthread_mutex_t lock; /* of all that follows */
    pthread_cond_t changed;
    bool ends;
    slot slots[VVI_PAINTER_VIEWS];
    int n_slots;  /* that were ever used */
    int last;     /* view that was rendered last */
    int now;      /* view that is rendered; -1: none */
    bool resting; /* it is at rest */
    bool stale;   /* what is rendered is for nobody any more */
    vv_job *job;
    uint64_t ready; /* scene that quick frames need nothing more for */
    double moved;   /* seconds of moving frames since the last picture at rest */
};

/* One wish being rendered; the painter's thread alone. */
typedef struct painting {
    vvi_painter *painter;
    int at;
    vvi_wish wish;
    vv_world *world; /* with the camera */
    vv_job *job;
    double begin, last;
    bool aside; /* it made room for those that move */
    bool done;  /* nothing better will come */
    bool has_stand;
    vvi_stand stand;
    const char *method;
} painting;

/** Renders it, and leaves what comes of it in its slot. */
void vvi_painting_paint(painting *p);
/** Whether nobody wishes anything. */
bool vvi_painter_is_idle(vvi_painter *painter);
#endif
