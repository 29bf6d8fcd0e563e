/* The HDF5 library on our bounded input, behind one lock. Files are opened for reading through a driver of our own:
 * nothing is ever written or locked, no other file is opened, and what a file that is cut short still has is read. */
#include "core/job.h"
#include "core/memory.h"
#include "io/formats/hdf5/hdf5.h"
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define HEAP_MOST 4096
#define NEEDS ((size_t)16 << 20) /* of the library, to begin with and for a file: three or four MiB, measured */

static const uint8_t magic[8] = {0x89, 'H', 'D', 'F', '\r', '\n', 0x1a, '\n'};

/* One for the process: the library has one state for all its files. */
static pthread_mutex_t lock = PTHREAD_MUTEX_INITIALIZER;
static bool prepared;

static uint64_t number_at(const uint8_t *at, int n)
{
    uint64_t v = 0;
    for (int i = n - 1; i >= 0; i--)
        v = v << 8 | at[i];
    return v;
}

/* Bytes for the library ------------------------------------------------------------------------------------------- */

/* What the file says it has: the library refuses one that is cut short, we read what is there. */
static haddr_t end(void *user)
{
    const vvi_h5 *h5 = user;
    return h5->n_expected > h5->n_bytes ? h5->n_expected : h5->n_bytes;
}

/* Texts of any length lie in a heap, with a length of their own; the library believes the one beside the attribute and
 * copies the other into room for at least HEAP_MOST bytes. No heap beyond that is read: texts of more are left out. */
static bool is_large_heap(const vvi_h5 *h5, const uint8_t *bytes, size_t n)
{
    return !h5->room && n >= 16 && memcmp(bytes, "GCOL", 4) == 0 &&
           number_at(bytes + 8, h5->long_lengths ? 8 : 4) > HEAP_MOST;
}

static bool read_bytes(void *user, haddr_t address, size_t n, void *out)
{
    vvi_h5 *h5 = user;
    if (out == h5->room && n > h5->n_room)
        return false;
    if (address > h5->n_bytes || n > h5->n_bytes - address)
        return false;
    if (h5->st == VV_OK && (h5->st = vvi_source_seek(h5->source, address)) == VV_OK)
        h5->st = vvi_source_read(h5->source, out, n, "what its header points to");
    return h5->st == VV_OK && !is_large_heap(h5, out, n);
}

/* The lock -------------------------------------------------------------------------------------------------------- */

vv_status vvi_h5_reserve(size_t more)
{
    return vvi_memory_is_there(NEEDS + more);
}

void vvi_h5_lock(void)
{
    pthread_mutex_lock(&lock);
    if (!prepared) {
        H5dont_atexit();
        H5open();
        H5PLset_loading_state(0); /* no code from folders that the environment names */
        prepared = true;
    }
    H5Eset_auto2(H5E_DEFAULT, NULL, NULL); /* each thread has its own */
    H5Eclear2(H5E_DEFAULT);
}

void vvi_h5_unlock(void)
{
    pthread_mutex_unlock(&lock);
}

/* Errors ---------------------------------------------------------------------------------------------------------- */

static herr_t take_innermost(unsigned n, const H5E_error2_t *error, void *user)
{
    if (n == 0 && error->desc)
        snprintf(user, 160, "%s", error->desc);
    return 0;
}

vv_status vvi_h5_fail(vvi_h5 *h5, const char *where, const char *what)
{
    char said[160] = "";
    if (h5->st != VV_OK)
        return h5->st;
    H5Ewalk2(H5E_DEFAULT, H5E_WALK_UPWARD, take_innermost, said);
    H5Eclear2(H5E_DEFAULT);
    for (char *c = said; *c; c++)
        if ((unsigned char)*c < ' ')
            *c = ' ';
    const bool cut = h5->n_expected > h5->n_bytes;
    if (cut)
        return vv_fail_at(VV_E_FORMAT, h5->name, where, "%s; the file is cut short: %llu of %llu bytes are there", what,
                          (unsigned long long)h5->n_bytes, (unsigned long long)h5->n_expected);
    return vv_fail_at(VV_E_FORMAT, h5->name, where, "%s; the HDF5 library says: %s", what, said[0] ? said : "nothing");
}

/* Opening --------------------------------------------------------------------------------------------------------- */

/* A block of the user's may lie before: 0, 512, 1024, 2048, ... bytes. */
static size_t find_magic(const uint8_t *head, size_t n)
{
    for (size_t at = 0; at + 64 <= n; at = at ? 2 * at : 512)
        if (memcmp(head + at, magic, sizeof magic) == 0)
            return at;
    return SIZE_MAX;
}

bool vvi_h5_magic(const uint8_t *head, size_t n)
{
    return find_magic(head, n) != SIZE_MAX;
}

/* The superblock's own end of the file, checked before the library sees it. */
static vv_status check_superblock(vvi_h5 *h5)
{
    size_t n;
    const uint8_t *head = vvi_source_peek(h5->source, 4096, &n);
    if (!head)
        return vv_error_last()->status;
    const size_t at = find_magic(head, n);
    if (at == SIZE_MAX)
        return vv_fail_at(VV_E_FORMAT, h5->name, NULL, "is not an HDF5 file: it does not begin with \\x89HDF");
    const int version = head[at + 8];
    if (version > 3)
        return vv_fail_at(VV_E_UNSUPPORTED, h5->name, NULL, "has HDF5 superblock version %d; 0 to 3 are known",
                          version);
    const int size = head[at + (version < 2 ? 13 : 9)];
    if (size != 4 && size != 8)
        return vv_fail_at(VV_E_FORMAT, h5->name, NULL, "has offsets of %d bytes; 4 or 8 were expected", size);
    const size_t base = at + (version == 0 ? 24 : version == 1 ? 28 : 12);
    h5->long_lengths = head[at + (version < 2 ? 14 : 10)] == 8;
    h5->n_expected = number_at(head + base + 2 * (size_t)size, size);
    if (h5->n_expected > h5->n_bytes && h5->n_bytes < h5->n_expected - h5->n_expected / 2)
        return vv_fail_at(VV_E_FORMAT, h5->name, NULL,
                          "ends after %llu bytes; %llu were expected; the file is cut short or its header wrong",
                          (unsigned long long)h5->n_bytes, (unsigned long long)h5->n_expected);
    return VV_OK;
}

vv_status vvi_h5_open(vvi_h5 *h5, vv_source *source, vv_job *job)
{
    bool exact;
    *h5 = (vvi_h5){.file = -1, .source = source, .job = job, .name = vvi_source_name(source)};
    vv_status st = vvi_source_seek(source, 0);
    if (st != VV_OK)
        return st;
    h5->n_bytes = vvi_source_left(source, &exact);
    if ((st = check_superblock(h5)) != VV_OK)
        return st;
    const hid_t access = vvi_h5_access(&(vvi_h5_io){.user = h5, .end = end, .read = read_bytes});
    h5->file = H5Fopen("volvis", H5F_ACC_RDONLY, access);
    H5Pclose(access);
    return h5->file >= 0 ? VV_OK : vvi_h5_fail(h5, NULL, "cannot be opened as HDF5");
}

void vvi_h5_close(vvi_h5 *h5)
{
    if (h5->source && h5->file >= 0)
        H5Fclose(h5->file);
    h5->file = -1;
}

/* Paths ----------------------------------------------------------------------------------------------------------- */

static hid_t open_step(hid_t at, const char *name)
{
    H5L_info_t link;
    if (H5Lexists(at, name, H5P_DEFAULT) <= 0 || H5Lget_info(at, name, &link, H5P_DEFAULT) < 0 ||
        link.type != H5L_TYPE_HARD)
        return -1;
    return H5Oopen(at, name, H5P_DEFAULT);
}

hid_t vvi_h5_object(const vvi_h5 *h5, const char *path)
{
    char step[VVI_H5_PATH];
    hid_t at = H5Oopen(h5->file, "/", H5P_DEFAULT);
    while (at >= 0 && path[strspn(path, "/")]) {
        path += strspn(path, "/");
        const size_t n = strcspn(path, "/");
        const hid_t above = at;
        at = -1;
        if (n < sizeof step && H5Iget_type(above) == H5I_GROUP) {
            memcpy(step, path, n);
            step[n] = 0;
            at = open_step(above, step);
        }
        H5Oclose(above);
        path += n;
    }
    return at;
}

bool vvi_h5_has(const vvi_h5 *h5, const char *path)
{
    const hid_t object = vvi_h5_object(h5, path);
    if (object >= 0)
        H5Oclose(object);
    return object >= 0;
}
