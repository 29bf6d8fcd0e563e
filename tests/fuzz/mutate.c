/* Files with a few bytes changed and files that are cut short, through vv_file_open() and vv_file_read().
 *
 *   mutate [-n COUNT] [-k FOLDER] FILE|FOLDER...
 *
 * Each file (of a folder: each file in it, deep) is a seed. Of each, COUNT mutants and all truncations up to 4 KiB
 * (more than that: 4096 of them) are read in a child process of little memory. What must not happen: the child dies, a
 * file takes more than two seconds of processor time, memory or a descriptor is not given back, a failure without a
 * sentence, a success whose samples are not what its info says, or a whole success of a file that is cut short with
 * samples other than the seed's. What happened is kept in FOLDER. A folder of seeds that is itself a volume
 * (Zarr, a DICOM series) is named with a slash at its end: its files are changed one at a time, and then the folder:
 * files are gone, copied over each other, renamed, cut, or more than there were. Of a folder with a file "head.*", a
 * header whose samples lie beside it, that file is opened. */
#include "core/limits.h"
#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <ftw.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/time.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>
#include <volvis/volvis.h>

enum { BATCH = 200, SEED_MOST = 4 << 20, TRUNCATIONS = 4096 };

typedef struct seed {
    char name[256];
    char path[4200];   /* where a mutant is put, with the name that its format needs */
    char opened[4200]; /* what is opened: the same, or the folder */
    uint8_t *bytes;
    size_t n;
    bool set;   /* of a folder: its files come and go */
    bool whole; /* it can be read as it is */
    uint32_t checksum;
    int64_t dims[3];
} seed;

static char folder[64] = "/dev/shm/volvis-mutate-XXXXXX";
static const char *kept = "out/mutate";
static uint64_t random_state = 1;
static int mutants = 1000;
static size_t n_read, n_refused, n_found;

static uint64_t next_random(void)
{
    uint64_t z = (random_state += UINT64_C(0x9e3779b97f4a7c15));
    z = (z ^ z >> 30) * UINT64_C(0xbf58476d1ce4e5b9);
    z = (z ^ z >> 27) * UINT64_C(0x94d049bb133111eb);
    return z ^ z >> 31;
}

static vv_job *new_job(void)
{
    vv_runtime_options options;
    vv_runtime *runtime;
    vv_job *job;
    vv_runtime_options_init(&options, sizeof options);
    options.threads = 1;
    options.memory_bytes = (uint64_t)48 << 20;
    if (vv_runtime_new(&runtime, &options) != VV_OK || vv_job_new(&job, runtime, NULL, NULL) != VV_OK)
        exit(2);
    vv_runtime_release(runtime);
    return job;
}

static void put_bytes(const char *path, const uint8_t *bytes, size_t n)
{
    FILE *f = fopen(path, "wb");
    if (!f || fwrite(bytes, 1, n, f) != n || fclose(f) != 0) {
        fprintf(stderr, "mutate: %s: %s\n", path, strerror(errno));
        exit(2);
    }
}

/* A broken promise ends the child with this code; the parent says which. */
enum { NO_SENTENCE = 40, WRONG_SAMPLES, NOT_GIVEN_BACK, WRONG_CUT, DESCRIPTOR_LEFT };

static const char *problem_name(int how)
{
    static const char *const names[] = {
        "a failure without a sentence", "samples that are not what the info says", "memory that is not given back",
        "a file cut short that is read as whole, with other samples", "a descriptor that is left open"};
    static char text[64];
    if (WIFSIGNALED(how)) {
        snprintf(text, sizeof text, "%s",
                 WTERMSIG(how) == SIGPROF   ? "more than two seconds"
                 : WTERMSIG(how) == SIGALRM ? "more than twenty seconds of waiting"
                                            : strsignal(WTERMSIG(how)));
        return text;
    }
    const int code = WEXITSTATUS(how);
    if (code >= NO_SENTENCE && code <= DESCRIPTOR_LEFT)
        return names[code - NO_SENTENCE];
    snprintf(text, sizeof text, "exit %d (a sanitizer?)", code);
    return text;
}

static void expect(bool condition, int problem)
{
    if (!condition)
        _exit(problem);
}

static void check_failure(vv_status st)
{
    const vv_error *e = vv_error_last();
    expect(e->status == st && e->message[0] && !strchr(e->message, '\n') && st != VV_E_INTERNAL, NO_SENTENCE);
}

/* Up to three frames; the checksum of the first. True when all could be read. */
static bool read_file(uint32_t *checksum_out, int64_t dims_out[3], const char *path, vv_job *job)
{
    vv_file *file;
    vv_status st = vv_file_open(&file, path, NULL, job);
    *checksum_out = 0;
    if (st != VV_OK) {
        check_failure(st);
        return false;
    }
    const vv_field_info *info = vv_file_info(file);
    expect(vv_field_info_check(info) == VV_OK, WRONG_SAMPLES);
    memcpy(dims_out, info->grid.dims, sizeof info->grid.dims);
    for (int64_t f = 0; f < info->n_frames && f < 3 && st == VV_OK; f++) {
        vv_field *field = NULL;
        st = vv_file_read(&field, file, f, NULL, job);
        if (st != VV_OK) {
            check_failure(st);
            break;
        }
        const vv_field_info *got = vv_field_get_info(field);
        expect(memcmp(got->grid.dims, info->grid.dims, sizeof got->grid.dims) == 0 && got->type == info->type &&
                   got->components == info->components,
               WRONG_SAMPLES);
        uint32_t checksum;
        if (vv_field_checksum(&checksum, field, job) == VV_OK && f == 0)
            *checksum_out = checksum;
        vv_field_release(field);
    }
    vv_file_close(file);
    return st == VV_OK;
}

static size_t count_descriptors(void)
{
    size_t n = 0;
    DIR *d = opendir("/proc/self/fd");
    while (d && readdir(d))
        n++;
    if (d)
        closedir(d);
    return n;
}

static void start_clock(void)
{
    const struct itimerval two = {.it_value = {.tv_sec = 2}};
    setitimer(ITIMER_PROF, &two, NULL);
    alarm(20);
}

/* The m-th mutant: a few bits, bytes, numbers or pieces changed. */
static size_t mutate(uint8_t *out, const seed *s, uint64_t number, int m)
{
    static const uint8_t ends[] = {0x00, 0xff, 0x7f, 0x80, 0x01, '0', '9', '-', ' ', '\n', '"', '/', '.'};
    size_t n = s->n;
    random_state = number * 1000003 + (uint64_t)m * 7919 + 1;
    memcpy(out, s->bytes, n);
    for (int changes = 1 + (int)(next_random() % 4); changes > 0 && n > 0; changes--) {
        /* half of them in the first 512 bytes, where headers are */
        const size_t at = next_random() % (next_random() & 1 && n > 512 ? 512 : n);
        const uint64_t how = next_random();
        switch (how % 6) {
        case 0:
            out[at] ^= (uint8_t)(1u << (how >> 8) % 8);
            break;
        case 1:
            out[at] = (uint8_t)(how >> 8);
            break;
        case 2:
            for (size_t i = 0; i < 1u << (how >> 8) % 4 && at + i < n; i++)
                out[at + i] = ends[(how >> 16) % sizeof ends];
            break;
        case 3: /* a piece again, elsewhere */
            for (size_t i = 0, from = (how >> 8) % n; i < (how >> 40) % 32 && at + i < n && from + i < n; i++)
                out[at + i] = s->bytes[from + i];
            break;
        case 4: /* a piece is gone */
            if (n > 8) {
                const size_t gone = 1 + (how >> 8) % 8;
                memmove(out + at, out + at + (at + gone < n ? gone : 0), n - at - (at + gone < n ? gone : 0));
                n -= at + gone < n ? gone : 0;
            }
            break;
        default:
            out[at] = (uint8_t)(out[at] + (how & 64 ? 1 : -1));
        }
    }
    return n;
}

/* Files of a volume that is a folder ------------------------------------------------------------------------------ */

typedef struct member {
    char path[512];
    uint8_t *bytes;
    size_t n;
} member;

static const char *volume; /* a folder that is one volume, in our copy of it */
static member members[64];
static size_t n_members;
static char more_path[2][600]; /* files that a mutant has and the volume has not */
static size_t n_more;

static int remove_foreign(const char *path, const struct stat *info, int type, struct FTW *where)
{
    (void)info;
    (void)where;
    for (size_t i = 0; i < n_members; i++)
        if (strcmp(members[i].path, path) == 0)
            return 0;
    return type == FTW_F ? unlink(path) : 0;
}

/* All is as it was, whatever a child left. */
static void restore_all(void)
{
    nftw(volume, remove_foreign, 16, FTW_PHYS);
    for (size_t i = 0; i < n_members; i++)
        put_bytes(members[i].path, members[i].bytes, members[i].n);
    n_more = 0;
}

/* What the last mutant changed is undone, and the m-th made. */
static void change_set(uint64_t number, int m)
{
    static size_t touched[8];
    static int n_touched;
    for (size_t i = 0; i < n_more; i++)
        unlink(more_path[i]);
    for (int i = 0; i < n_touched; i++)
        put_bytes(members[touched[i]].path, members[touched[i]].bytes, members[touched[i]].n);
    n_more = 0;
    n_touched = 0;
    random_state = number * 1000003 + (uint64_t)m * 7919 + 1;
    for (int changes = 1 + (int)(next_random() % 3); changes > 0; changes--) {
        const size_t i = next_random() % n_members;
        const member *a = &members[i], *b = &members[next_random() % n_members];
        const uint64_t how = next_random();
        touched[n_touched++] = i;
        if (how % 4 == 0)
            unlink(a->path);
        else if (how % 4 == 1) /* another instead of it */
            put_bytes(a->path, b->bytes, b->n);
        else if (how % 4 == 2)
            put_bytes(a->path, a->bytes, (how >> 8) % (a->n + 1));
        if (how % 4 != 3 || n_more == 2)
            continue;
        /* under another name, perhaps as a copy */
        char *to = more_path[n_more++];
        snprintf(to, sizeof more_path[0], "%s%s", a->path, how & 64 ? "" : "x");
        char *last = strrchr(to, '/') + 1;
        last[(how >> 16) % strlen(last)] = "0123456789.abz#%"[(how >> 8) % 16];
        FILE *f = fopen(to, "wb"); /* the name may be that of a folder */
        if (!f || fwrite(b->bytes, 1, b->n, f) != b->n || fclose(f) != 0)
            continue;
        if (how & 128 && strcmp(to, a->path) != 0)
            unlink(a->path);
    }
}

/* The last number of a text may lose digits, a header that needs no end its last lines, and data at the end of a file
 * may begin elsewhere: nobody can see that. */
static bool hides_cuts(const char *name)
{
    const char *end = strrchr(name, '.');
    return (end && (strcmp(end, ".cube") == 0 || strcmp(end, ".general") == 0)) || strncmp(name, "ascii", 5) == 0 ||
           strncmp(name, "text", 4) == 0 || strncmp(name, "end", 3) == 0;
}

/* Mutants [first, first + BATCH), or truncations. */
static void run_batch(const seed *s, uint64_t number, int first, int last, bool cut, int progress)
{
    vv_job *job = new_job();
    uint8_t *bytes = malloc(s->n + 1);
    const size_t descriptors = count_descriptors();
    uint32_t counts[2] = {0, 0};
    if (s->set)
        restore_all();
    for (int m = first; m < last; m++) {
        size_t n = s->n <= TRUNCATIONS ? (size_t)m : (size_t)((double)s->n * m / TRUNCATIONS);
        uint32_t checksum;
        int64_t dims[3];
        vv_job *one = NULL;
        if (s->set) {
            change_set(number, m);
        } else {
            if (cut)
                memcpy(bytes, s->bytes, n);
            else
                n = mutate(bytes, s, number, m);
            put_bytes(s->path, bytes, n);
        }
        if (pwrite(progress, &m, sizeof m, 0) != sizeof m || vv_job_new(&one, vv_job_runtime(job), NULL, NULL) != VV_OK)
            _exit(2);
        const uint64_t used = vv_runtime_memory_used(vv_job_runtime(job));
        start_clock();
        const bool ok = read_file(&checksum, dims, s->opened, one);
        const bool damaged = vv_job_damaged(one);
        vv_job_release(one);
        expect(vv_runtime_memory_used(vv_job_runtime(job)) == used, NOT_GIVEN_BACK);
        expect(count_descriptors() == descriptors, DESCRIPTOR_LEFT);
        if (cut && ok && s->whole && !hides_cuts(s->name) && memcmp(dims, s->dims, sizeof dims) == 0 && !damaged)
            expect(checksum == s->checksum, WRONG_CUT);
        counts[ok]++;
    }
    if (pwrite(progress, counts, sizeof counts, 8) != sizeof counts)
        _exit(2);
    free(bytes);
    vv_job_release(job);
    exit(0);
}

static void keep(const seed *s, int m, bool cut, const char *what)
{
    char path[8192], command[16384];
    snprintf(path, sizeof path, "%s/%s-%s-%d", kept, s->name, cut ? "cut" : "mutant", m);
    printf("FOUND %s: %s %d: %s (kept as %s)\n", s->name, cut ? "cut" : "mutant", m, what, path);
    snprintf(command, sizeof command, "mkdir -p '%s' && cp -r '%s' '%s'", kept, s->path, path);
    if (system(command) != 0)
        fprintf(stderr, "mutate: %s cannot be kept\n", path);
    n_found++;
}

/* Goes on after what a child died of, until a seed has been found faulty a few times. */
static void run_all(const seed *s, uint64_t number, int count, bool cut)
{
    FILE *shared = tmpfile();
    int faults = 0;
    for (int first = 0; first < count && faults < 5;) {
        const int last = first + BATCH < count ? first + BATCH : count;
        int how, at = first;
        uint32_t counts[2] = {0, 0};
        fflush(stdout);
        const pid_t child = fork();
        if (child == 0)
            run_batch(s, number, first, last, cut, fileno(shared));
        waitpid(child, &how, 0);
        if (how == 0 && pread(fileno(shared), counts, sizeof counts, 8) == sizeof counts) {
            n_refused += counts[0];
            n_read += counts[1];
            first = last;
        } else {
            if (pread(fileno(shared), &at, sizeof at, 0) != sizeof at)
                at = first;
            keep(s, at, cut, problem_name(how));
            first = at + 1;
            faults++;
        }
    }
    fclose(shared);
}

static bool load(seed *s, const char *path)
{
    FILE *f = fopen(path, "rb");
    struct stat about;
    if (!f || fstat(fileno(f), &about) != 0 || about.st_size > SEED_MOST) {
        if (f)
            fclose(f);
        return false;
    }
    s->n = (size_t)about.st_size;
    s->bytes = malloc(s->n + 1);
    const bool ok = s->bytes && fread(s->bytes, 1, s->n, f) == s->n;
    fclose(f);
    return ok;
}

static void run_seed(seed *s)
{
    static uint64_t number;
    const size_t found = n_found, read = n_read, refused = n_refused;
    vv_job *job = new_job();
    const pid_t child = fork(); /* the seed itself may be what makes a reader die */
    if (child == 0) {
        uint32_t checksum;
        int64_t dims[3];
        start_clock();
        read_file(&checksum, dims, s->opened, job);
        _exit(0);
    }
    int how;
    waitpid(child, &how, 0);
    if (how != 0)
        keep(s, -1, false, problem_name(how));
    s->whole = how == 0 && read_file(&s->checksum, s->dims, s->opened, job) && !vv_job_damaged(job);
    vv_job_release(job);
    number++;
    run_all(s, number, (int)(s->n <= TRUNCATIONS ? s->n : TRUNCATIONS) * (mutants > 0), true);
    run_all(s, number, mutants, false);
    printf("%-40s %8zu bytes%s: %zu read, %zu refused, %zu found\n", s->name, s->n, s->whole ? "" : " (not readable)",
           n_read - read, n_refused - refused, n_found - found);
}

/* One file by itself: its name stays, since formats look at suffixes. */
static void run_file(const char *path)
{
    seed s = {0};
    const char *slash = strrchr(path, '/');
    snprintf(s.name, sizeof s.name, "%s", slash ? slash + 1 : path);
    snprintf(s.path, sizeof s.path, "%s/%s", folder, s.name);
    snprintf(s.opened, sizeof s.opened, "%s", s.path);
    if (load(&s, path)) {
        put_bytes(s.path, s.bytes, s.n);
        run_seed(&s);
        unlink(s.path);
    }
    free(s.bytes);
}

static int visit_file(const char *path, const struct stat *info, int type, struct FTW *where)
{
    (void)info;
    (void)where;
    if (type == FTW_F)
        run_file(path);
    return 0;
}

static char opened[4200]; /* what is opened of a volume: the folder, or the header in it */

static int take_member(const char *path, const struct stat *info, int type, struct FTW *where)
{
    seed s = {0};
    (void)info;
    if (type != FTW_F || n_members == sizeof members / sizeof *members || strlen(path) >= sizeof members[0].path ||
        !load(&s, path))
        return 0;
    member *m = &members[n_members++];
    *m = (member){.bytes = s.bytes, .n = s.n};
    snprintf(m->path, sizeof m->path, "%s", path);
    if (strncmp(path + where->base, "head.", 5) == 0)
        snprintf(opened, sizeof opened, "%s", path);
    return 0;
}

static int visit_member(const char *path, const struct stat *info, int type, struct FTW *where)
{
    seed s = {0};
    (void)info;
    if (type != FTW_F)
        return 0;
    snprintf(s.name, sizeof s.name, "%.200s", path + where->base);
    snprintf(s.path, sizeof s.path, "%s", path);
    snprintf(s.opened, sizeof s.opened, "%s", opened);
    if (load(&s, path)) {
        run_seed(&s);
        put_bytes(s.path, s.bytes, s.n);
    }
    free(s.bytes);
    return 0;
}

static int remove_one(const char *path, const struct stat *info, int type, struct FTW *where)
{
    (void)info;
    (void)type;
    (void)where;
    return remove(path);
}

static void run_volume(const char *path)
{
    char command[8192], name[4096], copy[4200];
    snprintf(name, sizeof name, "%s", path);
    name[strlen(name) - 1] = 0;
    const char *slash = strrchr(name, '/');
    snprintf(copy, sizeof copy, "%s/%s", folder, slash ? slash + 1 : name);
    snprintf(command, sizeof command, "cp -r '%s' '%s'", name, copy);
    if (system(command) != 0)
        return;
    volume = copy;
    n_members = 0;
    snprintf(opened, sizeof opened, "%s", copy);
    nftw(copy, take_member, 16, FTW_PHYS);
    nftw(copy, visit_member, 16, FTW_PHYS);
    seed whole = {.set = true};
    snprintf(whole.name, sizeof whole.name, "%.200s", slash ? slash + 1 : name);
    snprintf(whole.path, sizeof whole.path, "%s", copy);
    snprintf(whole.opened, sizeof whole.opened, "%s", opened);
    run_seed(&whole);
    for (size_t i = 0; i < n_members; i++)
        free(members[i].bytes);
    nftw(copy, remove_one, 16, FTW_DEPTH | FTW_PHYS);
}

int main(int argc, char **argv)
{
    int option;
    while ((option = getopt(argc, argv, "n:k:")) != -1) {
        if (option == 'n')
            mutants = atoi(optarg);
        else if (option == 'k')
            kept = optarg;
        else
            return 2;
    }
    if (optind == argc || !mkdtemp(folder)) {
        fprintf(stderr, "mutate [-n COUNT] [-k FOLDER] FILE|FOLDER...\n");
        return 2;
    }
    for (int i = optind; i < argc; i++) {
        const size_t n = strlen(argv[i]);
        if (n > 1 && argv[i][n - 1] == '/')
            run_volume(argv[i]);
        else
            nftw(argv[i], visit_file, 16, FTW_PHYS);
    }
    nftw(folder, remove_one, 16, FTW_DEPTH | FTW_PHYS);
    printf("%zu read, %zu refused, %zu found\n", n_read, n_refused, n_found);
    return n_found ? 1 : 0;
}
