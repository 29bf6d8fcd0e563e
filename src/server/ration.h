/** @file
 * What those who send may cost the server's one loop: processor time of its thread, of which bytes and messages are
 * worth a little each. Apart from any clock and socket.
 *
 * Each client has an account, and each address one for all that are there. What a message took is paid after it was
 * done; who cannot pay is not read from for a while. Who has hardly spent anything of late is read from though others
 * of his address have spent all that it has. Newcomers have little: to come again is no way to more.
 *
 * Connections have an account too, one for all of them, until somebody is let in by one: where it is empty, those that
 * come wait in the system's queue.
 */
#ifndef VVI_SERVER_RATION_H
#define VVI_SERVER_RATION_H
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/** All of a server; zeros: nobody is there. */
typedef struct vvi_rations {
    struct vvi_ration_place *first; /* addresses */
    int n;                          /* clients */
    int n_greeted;                  /* those of them that look */
    double owed;                    /* seconds that went for connections of late */
    int64_t at;                     /* when that was so, nanoseconds */
} vvi_rations;

typedef struct vvi_ration {
    vvi_rations *all;
    struct vvi_ration_place *place;
    double left;         /* seconds */
    int64_t at;          /* when that was so, nanoseconds */
    bool greeted;        /* it looks: what its address gets is for such ones */
    bool draws;          /* it is not full */
    int64_t short_since; /* 0: it has enough */
} vvi_ration;

/** Nobody is there any more. */
void vvi_rations_clear(vvi_rations *all);
/** So many seconds of the thread's time went for connections; `n` of them are new. */
void vvi_rations_pay_coming(vvi_rations *all, double seconds, int n, int64_t now);
/** Nanoseconds until the next one may come; 0: it may. Where nobody looks, any may. */
int64_t vvi_rations_wait_coming(vvi_rations *all, int64_t now);
/** False: no memory. */
bool vvi_ration_begin(vvi_ration *ration, vvi_rations *all, const char *address, int64_t now);
/** What it has spent stays spent for its address. */
void vvi_ration_end(vvi_ration *ration, int64_t now);
/** So many seconds of the thread's time went, for so many bytes. */
void vvi_ration_pay(vvi_ration *ration, double seconds, size_t bytes, int64_t now);
/** Nanoseconds until it may be read from again; 0: it may. Who is alone always may. */
int64_t vvi_ration_wait(vvi_ration *ration, int64_t now);
/** The same for one that has not said hello: an address may not bring any number of newcomers. */
int64_t vvi_ration_wait_hello(vvi_ration *ration, int64_t now);
/** It has said hello. */
void vvi_ration_greeted(vvi_ration *ration, int64_t now);
/** Whether it has sent more than it may for half a minute, without a rest. */
bool vvi_ration_persists(const vvi_ration *ration, int64_t now);
/** Seconds of processor time that this thread has used. */
double vvi_ration_clock(void);
#endif
