/* The HDF5 library writes to the file of a sink. */
#include "io/formats/hdf5/hdf5.h"
#include <errno.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

static int descriptor(void *user)
{
    return (int)(intptr_t)user;
}

static haddr_t end(void *user)
{
    struct stat info;
    return fstat(descriptor(user), &info) == 0 ? (haddr_t)info.st_size : HADDR_UNDEF;
}

static bool read_back(void *user, haddr_t address, size_t n, void *out)
{
    for (size_t done = 0; done < n;) {
        const ssize_t got = pread(descriptor(user), (char *)out + done, n - done, (off_t)(address + done));
        if (got < 0 && errno == EINTR)
            continue;
        if (got < 0)
            return false;
        if (got == 0) { /* not written yet */
            memset((char *)out + done, 0, n - done);
            return true;
        }
        done += (size_t)got;
    }
    return true;
}

static bool write_all(void *user, haddr_t address, size_t n, const void *data)
{
    for (size_t done = 0; done < n;) {
        const ssize_t put = pwrite(descriptor(user), (const char *)data + done, n - done, (off_t)(address + done));
        if (put < 0 && errno != EINTR)
            return false;
        done += put > 0 ? (size_t)put : 0;
    }
    return true;
}

static bool truncate_at(void *user, haddr_t n)
{
    return ftruncate(descriptor(user), (off_t)n) == 0;
}

hid_t vvi_h5_create_file(int fd)
{
    const vvi_h5_io io = {
        .user = (void *)(intptr_t)fd, .end = end, .read = read_back, .write = write_all, .truncate = truncate_at};
    const hid_t access = vvi_h5_access(&io);
    const hid_t file = H5Fcreate("volvis", H5F_ACC_TRUNC, H5P_DEFAULT, access);
    H5Pclose(access);
    return file;
}
