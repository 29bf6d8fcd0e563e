/* Seconds that reading a volume takes: reading FILE THREADS ROUNDS [IMPORT-PROGRAM]. Every sample is added up, so that
 * what is mapped is read too. With an import program, formats that are contained are read by it, without one here.
 * Prints one line for each round, the seconds that passed and those of all processors together, then the sum.
 */
#include "grid/field.h"
#include <stdio.h>
#include <stdlib.h>
#include <sys/resource.h>
#include <time.h>
#include <volvis/file.h>

static double now_s(clockid_t clock)
{
    struct timespec t;
    clock_gettime(clock, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

/* Of all processors: of this process, and of those that it has waited for. */
static double processors_s(void)
{
    struct rusage children;
    getrusage(RUSAGE_CHILDREN, &children);
    return now_s(CLOCK_PROCESS_CPUTIME_ID) + (double)(children.ru_utime.tv_sec + children.ru_stime.tv_sec) +
           1e-6 * (double)(children.ru_utime.tv_usec + children.ru_stime.tv_usec);
}

/* Of the bytes, 8 at a time: what it costs is reading memory once. */
static uint64_t add_up(const vv_field *field)
{
    const vv_box all = vv_field_box(field);
    uint64_t bytes = 0, sum = 0;
    vv_brick brick;
    if (vv_field_info_bytes(&bytes, vv_field_get_info(field)) != VV_OK ||
        vv_field_brick(&brick, field, &all, NULL) != VV_OK)
        exit(1);
    const uint64_t *words = brick.data;
    for (uint64_t i = 0; i < bytes / 8; i++)
        sum += words[i];
    vv_brick_release(&brick);
    return sum;
}

static vv_status read_once(const char *path, vv_job *job, uint64_t *sum)
{
    vv_file *file;
    vv_field *field = NULL;
    vv_status st = vv_file_open(&file, path, NULL, job);
    if (st != VV_OK)
        return st;
    if ((st = vv_file_read(&field, file, 0, NULL, job)) == VV_OK)
        *sum = add_up(field);
    vv_field_release(field);
    vv_file_close(file);
    return st;
}

int main(int argc, char **argv)
{
    vv_runtime_options options;
    vv_runtime *runtime;
    vv_job *job;
    uint64_t sum = 0;
    if (argc != 4 && argc != 5)
        return 2;
    vv_runtime_options_init(&options, sizeof options);
    options.threads = atoi(argv[2]);
    options.contain = argc == 5;
    options.import_program = argc == 5 ? argv[4] : NULL;
    if (vv_runtime_new(&runtime, &options) != VV_OK || vv_job_new(&job, runtime, NULL, NULL) != VV_OK)
        return 1;
    for (int i = 0; i < atoi(argv[3]); i++) {
        const double start = now_s(CLOCK_MONOTONIC), start_cpu = processors_s();
        if (read_once(argv[1], job, &sum) != VV_OK) {
            fprintf(stderr, "%s\n", vv_error_last()->message);
            return 1;
        }
        printf("%.6f %.6f\n", now_s(CLOCK_MONOTONIC) - start, processors_s() - start_cpu);
    }
    printf("sum %llu\n", (unsigned long long)sum);
    vv_job_release(job);
    vv_runtime_release(runtime);
    return 0;
}
