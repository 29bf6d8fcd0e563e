/** @file
 * What comparisons of all kinds share.
 */
#ifndef VVI_MEASURING_COMPARING_H
#define VVI_MEASURING_COMPARING_H
#include "measuring/answer.h"
#include <volvis/compare.h>

/** One comparison on its way. */
typedef struct vvi_comparing {
    vv_answer *answer;
    vv_compare_limits limits;
    bool exceeded;
    vv_job *job;
} vvi_comparing;

/** A new answer: *out. */
vv_status vvi_comparing_begin(vvi_comparing *c, vv_answer **out, const vv_compare_limits *limits, vv_job *job);
/** After the last: what is to be returned. */
vv_status vvi_comparing_end(const vvi_comparing *c, bool *exceeded_out, vv_status st);
/** What is not within its limit is said. least: the limit is the least that will do, else the most. */
void vvi_comparing_judge(vvi_comparing *c, const char *what, double found, double limit, bool least);
/** By the limits, where there are some; else whatever differs. */
void vvi_comparing_verdict(const vvi_comparing *c, bool identical);
#endif
