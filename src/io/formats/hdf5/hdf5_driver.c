/* The file driver through which the HDF5 library reads and writes: bytes come and go by functions of ours. */
#include "io/formats/hdf5/hdf5.h"

typedef struct opened_file {
    H5FD_t base; /* first, as the library wants it */
    vvi_h5_io io;
    haddr_t end_of_space;
} opened_file;

static const vvi_h5_io *io_of(const H5FD_t *file)
{
    return &((const opened_file *)file)->io;
}

/* The library hands settings over by copying them. */
static H5FD_t *driver_open(const char *name, unsigned flags, hid_t fapl, haddr_t most)
{
    const vvi_h5_io *io = H5Pget_driver_info(fapl);
    (void)name;
    (void)most;
    if (!io || ((flags & H5F_ACC_RDWR) && !io->write))
        return NULL;
    opened_file *file = H5allocate_memory(sizeof *file, true);
    if (file)
        file->io = *io;
    return (H5FD_t *)file;
}

static herr_t driver_close(H5FD_t *file)
{
    return H5free_memory(file);
}

static herr_t driver_query(const H5FD_t *file, unsigned long *flags)
{
    *flags = H5FD_FEAT_AGGREGATE_METADATA | H5FD_FEAT_DATA_SIEVE;
    if (file) /* NULL: what every file can */
        *flags |= io_of(file)->write ? H5FD_FEAT_ACCUMULATE_METADATA | H5FD_FEAT_AGGREGATE_SMALLDATA
                                     : H5FD_FEAT_ACCUMULATE_METADATA_READ;
    return 0;
}

static haddr_t driver_get_eoa(const H5FD_t *file, H5FD_mem_t type)
{
    (void)type;
    return ((const opened_file *)file)->end_of_space;
}

static herr_t driver_set_eoa(H5FD_t *file, H5FD_mem_t type, haddr_t address)
{
    (void)type;
    ((opened_file *)file)->end_of_space = address;
    return 0;
}

static haddr_t driver_get_eof(const H5FD_t *file, H5FD_mem_t type)
{
    (void)type;
    return io_of(file)->end(io_of(file)->user);
}

static herr_t driver_read(H5FD_t *file, H5FD_mem_t type, hid_t dxpl, haddr_t address, size_t n, void *out)
{
    (void)type;
    (void)dxpl;
    return io_of(file)->read(io_of(file)->user, address, n, out) ? 0 : -1;
}

static herr_t driver_write(H5FD_t *file, H5FD_mem_t type, hid_t dxpl, haddr_t address, size_t n, const void *data)
{
    const vvi_h5_io *io = io_of(file);
    (void)type;
    (void)dxpl;
    return io->write && io->write(io->user, address, n, data) ? 0 : -1;
}

static herr_t driver_truncate(H5FD_t *file, hid_t dxpl, hbool_t closing)
{
    const vvi_h5_io *io = io_of(file);
    (void)dxpl;
    (void)closing;
    return !io->truncate || io->truncate(io->user, ((const opened_file *)file)->end_of_space) ? 0 : -1;
}

static const H5FD_class_t driver_class = {
    .name = "volvis",
    .maxaddr = INT64_MAX,
    .fc_degree = H5F_CLOSE_STRONG,
    .fapl_size = sizeof(vvi_h5_io),
    .open = driver_open,
    .close = driver_close,
    .query = driver_query,
    .get_eoa = driver_get_eoa,
    .set_eoa = driver_set_eoa,
    .get_eof = driver_get_eof,
    .read = driver_read,
    .write = driver_write,
    .truncate = driver_truncate,
    .fl_map = H5FD_FLMAP_DICHOTOMY,
};

hid_t vvi_h5_access(const vvi_h5_io *io)
{
    static hid_t driver = -1;
    if (driver < 0)
        driver = H5FDregister(&driver_class);
    const hid_t access = H5Pcreate(H5P_FILE_ACCESS);
    H5Pset_fclose_degree(access, H5F_CLOSE_STRONG); /* whatever is still open in a file goes with it */
    H5Pset_driver(access, driver, io);
    return access;
}
