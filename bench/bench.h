/** @file
 * What programs that time the library share.
 */
#ifndef VVI_BENCH_H
#define VVI_BENCH_H
#include <volvis/volvis.h>

enum { BENCH_RUNS_MOST = 200 };

/** Seconds of runs: by the clock, and of all processors together. */
typedef struct bench_times {
    double seconds[BENCH_RUNS_MOST], processor[BENCH_RUNS_MOST];
    double before, used; /* of the run that goes on */
    double first;        /* seconds of the first run, which is not counted: it warms up */
    int n;
} bench_times;

double bench_now(void);
/** Around each run: the first warms up, and is not counted. */
void bench_begin(bench_times *times);
void bench_end(bench_times *times);
/** From the shortest to the longest; the median is at n / 2. */
void bench_sort(bench_times *times);
/** Runs within what a bench_times holds. */
int bench_runs(int asked);
/** The samples of a file; the caller releases them. */
vv_status bench_read(vv_field **out, const char *path, vv_job *job);
/** main(): at least `least` words after the name, a runtime with VOLVIS_THREADS threads, errors told. */
int bench_main(int argc, char **argv, int least, const char *usage, vv_status (*run)(int, char **, vv_job *));
#endif
