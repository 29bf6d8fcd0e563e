/** @file
 * Bounded input. Readers see a file only through this: no pointer arithmetic, no read past the end, no allocation
 * larger than the bytes that can still arrive.
 */
#ifndef VVI_IO_SOURCE_H
#define VVI_IO_SOURCE_H
#include "core/status.h"
#include <volvis/sys/registry.h>

typedef enum vvi_coding { VVI_CODING_NONE, VVI_CODING_GZIP, VVI_CODING_BZIP2, VVI_CODING_ZSTD } vvi_coding;

/** A path, "-" for standard input, read through .gz, .bz2, .zst by content. FIFOs are read once, files can seek. */
vv_status vvi_source_open(vv_source **out, const char *path, vv_job *job);
/** Memory; `name` stands in errors. The memory outlives the source. */
vv_status vvi_source_memory(vv_source **out, const void *data, size_t n, const char *name, vv_job *job);
/** A data file named inside a header: relative, below the header's folder, a regular file; else VV_E_READ with what to
 * do (--allow-outside). Its bytes come as they lie: the header says how they are coded (vvi_source_section). */
vv_status vvi_source_open_beside(vv_source **out, const vv_source *header, const char *name, vv_job *job);
/** Bytes of a source from an offset on (counted as the source reads them), decoded as `coding` says: for detached or
 * appended data of known coding. n: how many bytes belong to it, UINT64_MAX for all. Close it before `source`. */
vv_status vvi_source_section(vv_source **out, vv_source *source, uint64_t offset, uint64_t n, vvi_coding coding,
                             vv_job *job);
void vvi_source_close(vv_source *source); /* NULL is fine */
/** The job whose cancel stops reading from now on; the one given at opening until then. It outlives its reads. */
void vvi_source_use_job(vv_source *source, vv_job *job);

const char *vvi_source_name(const vv_source *source);
/** Bytes from here to the end: exact when *exact, else an upper bound from the coding's largest expansion. */
uint64_t vvi_source_left(vv_source *source, bool *exact);
uint64_t vvi_source_tell(const vv_source *source);

/** Up to n bytes; *n_read less than n only at the end. */
vv_status vvi_source_read_some(vv_source *source, void *out, size_t n, size_t *n_read);
/** Exactly n bytes, or VV_E_FORMAT "<name>: ends after N bytes; M were expected ..." */
vv_status vvi_source_read(vv_source *source, void *out, size_t n, const char *what);
vv_status vvi_source_skip(vv_source *source, uint64_t n);
/** Absolute position; VV_E_UNSUPPORTED backwards in a stream. */
vv_status vvi_source_seek(vv_source *source, uint64_t offset);
/** The first n bytes without moving (n at most 4096). */
const uint8_t *vvi_source_peek(vv_source *source, size_t n, size_t *n_there);
/** One line without its end, at most `most` bytes, valid until the next call; *end at the end of the file. */
vv_status vvi_source_line(vv_source *source, const char **line_out, size_t most, bool *end);

/** The coding that the next bytes look like, by content. */
vvi_coding vvi_source_sniff(vv_source *source);
/** After the last byte that matters: a checksum behind it that is wrong, or a coded stream that is cut, is an error. */
vv_status vvi_source_check_end(vv_source *source);

/** True when bytes [offset, offset + n) can be mapped: a plain regular file that is that long. */
bool vvi_source_mappable(const vv_source *source, uint64_t offset, uint64_t n);
/** Map them for reading, with guard bytes after (vv_field_new's guard_bytes). A file that shrinks later gives zeros
 * and vvi_mapping_damaged(), never a crash. release with vvi_mapping_free. */
typedef struct vvi_mapping vvi_mapping;
vv_status vvi_source_map(vvi_mapping **out, const void **data_out, size_t *guard_out, vv_source *source,
                         uint64_t offset, uint64_t n);
bool vvi_mapping_damaged(const vvi_mapping *mapping);
void vvi_mapping_free(void *mapping);

/** Limits on outside input, all listed by `volvis doctor --limits`. */
typedef struct vvi_limits {
    uint64_t dim, voxels, header_bytes, metadata_keys, string_bytes, files, expansion_gzip, expansion_zstd;
} vvi_limits;
extern const vvi_limits vvi_limits_default;
#endif
