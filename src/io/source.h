/** @file
 * Bounded input. Readers see a file only through this: no pointer arithmetic, no read past the end, no allocation
 * larger than the bytes that can still arrive.
 */
#ifndef VVI_IO_SOURCE_H
#define VVI_IO_SOURCE_H
#include "core/limits.h"
#include "core/status.h"
#include <volvis/sys/registry.h>

typedef enum vvi_coding {
    VVI_CODING_NONE,
    VVI_CODING_GZIP,
    VVI_CODING_BZIP2,
    VVI_CODING_ZSTD,
    VVI_CODING_ZLIB,   /* only where a header says so: its first bytes tell too little; gzip is taken for it as well */
    VVI_CODING_DEFLATE /* the same without its wrapper */
} vvi_coding;

/** A path, "-" for standard input, read through .gz, .bz2, .zst by content. FIFOs are read once, files can seek. */
vv_status vvi_source_open(vv_source **out, const char *path, vv_job *job);
/** The same for what the user names: folders too. A folder has no bytes; its files open with vvi_source_open_beside. */
vv_status vvi_source_open_input(vv_source **out, const char *path, vv_job *job);
/** Memory; `name` stands in errors. The memory outlives the source. */
vv_status vvi_source_memory(vv_source **out, const void *data, size_t n, const char *name, vv_job *job);
/** A data file named inside a header, or a file of a folder: relative, below the header's folder, a regular file; else
 * VV_E_READ with what to do (--allow-outside). Its bytes come as they lie: the header says how they are coded
 * (vvi_source_section). */
vv_status vvi_source_open_beside(vv_source **out, const vv_source *header, const char *name, vv_job *job);
/** The same, read through .gz, .bz2, .zst by content: a data set of its own beside another. */
vv_status vvi_source_open_input_beside(vv_source **out, const vv_source *header, const char *name, vv_job *job);
/** The same where the file may be absent: *out is NULL then. */
vv_status vvi_source_find_beside(vv_source **out, const vv_source *header, const char *name, vv_job *job);
/** Bytes of a source from an offset on (counted as the source reads them), decoded as `coding` says: for detached or
 * appended data of known coding. n: how many bytes belong to it, UINT64_MAX for all. Close it before `source`. */
vv_status vvi_source_section(vv_source **out, vv_source *source, uint64_t offset, uint64_t n, vvi_coding coding,
                             vv_job *job);
/** All bytes of a fresh section have this CRC-32 (zlib's): whoever reads them from the first to the last is told when
 * they have not, by vvi_source_check_end() at the latest. Such a section is never mapped. */
void vvi_source_guard(vv_source *section, uint32_t crc);
/** Keeps a coded section for the next read of the same data: who goes on from where it stands unpacks nothing twice.
 * Takes the section; it is closed with `source`, or by the next one that is kept. */
void vvi_source_keep(vv_source *source, vv_source *section);
/** The section that was kept, yours again; NULL when there is none. It stands anywhere: seek before you read. */
vv_source *vvi_source_kept(vv_source *source, vv_job *job);
void vvi_source_close(vv_source *source); /* NULL is fine */
/** Makes a source that can seek from any: pipes and coded files go to a temporary file without a name first. It stands
 * at its start afterwards. */
vv_status vvi_source_spool(vv_source *source, vv_job *job);
/** For whoever will read samples more than once: what is left of a pipe goes to a temporary file, with the bytes that
 * the header took, and positions stay what they are. Right after the header was read; VV_E_UNSUPPORTED later. Nothing
 * is done where the bytes can be read again anyway. */
vv_status vvi_source_make_repeatable(vv_source *source, vv_job *job);
/** The header was read: what was kept of it for vvi_source_make_repeatable() goes. */
void vvi_source_begin_samples(vv_source *source);
/** A path under which the very bytes of the source can be opened again, for libraries that want one; NULL when it is
 * not a plain file (then vvi_source_spool() makes it one). Never show it: vvi_source_name() is for people. */
const char *vvi_source_path(const vv_source *source);
/** The job whose cancel stops reading from now on; the one given at opening until then. It outlives its reads. */
void vvi_source_use_job(vv_source *source, vv_job *job);

const char *vvi_source_name(const vv_source *source);
/** Those of the job that the source reads for. */
const vv_limits *vvi_source_limits(const vv_source *source);
/** Bytes from here to the end: exact when *exact, else an upper bound from the coding's largest expansion. */
uint64_t vvi_source_left(vv_source *source, bool *exact);
/** The limit on how many times its data may grow, "expansion_gzip"; NULL where they lie as they are. */
const char *vvi_source_expansion(const vv_source *source);
uint64_t vvi_source_tell(const vv_source *source);

/** Up to n bytes; *n_read less than n only at the end. */
vv_status vvi_source_read_some(vv_source *source, void *out, size_t n, size_t *n_read);
/** Up to n bytes, less where the source ends or its coded data is cut; what is wrong with the data is an error. */
vv_status vvi_source_read_whole(vv_source *source, void *out, size_t n, size_t *n_read);
/** Exactly n bytes, or VV_E_FORMAT "<name>: ends after N bytes; M were expected ..." */
vv_status vvi_source_read(vv_source *source, void *out, size_t n, const char *what);
vv_status vvi_source_skip(vv_source *source, uint64_t n);
/** Absolute position; VV_E_UNSUPPORTED backwards in a stream. */
vv_status vvi_source_seek(vv_source *source, uint64_t offset);
/** How many bytes there are, once a read came short. */
uint64_t vvi_source_end(const vv_source *source);
/** The first n bytes without moving (n at most 4096). */
const uint8_t *vvi_source_peek(vv_source *source, size_t n, size_t *n_there);
/** One line without its end, at most `most` bytes, valid until the next call; *end at the end of the file. */
vv_status vvi_source_line(vv_source *source, const char **line_out, size_t most, bool *end);

/** The coding that the next bytes look like, by content. */
vvi_coding vvi_source_sniff(vv_source *source);
/** Before memory holds `bytes` of what comes from coded data: where that is more than 64 MiB and twice the file, what
 * follows is unpacked to its end and thrown away, so that damaged data cost no more until they are refused. Where the
 * source stands does not change (docs/decisions/0021-proven-before-memory.md). VV_OK also where the data are cut short,
 * which readers make what they can of. *seen_out: vvi_source_end() and vvi_source_left() know where they end. Who calls
 * this tells what is held, from the first call on; for others the source does it and counts all that it hands out. */
vv_status vvi_source_hold(vv_source *source, uint64_t bytes, bool *seen_out);
/** Before `bytes` more are taken for what is made of coded data and stays, where nobody knows beforehand how much that
 * will be (meshes): as vvi_source_hold() with all that was told so. VV_E_FORMAT also where the data are cut short or
 * end before what is needed. */
vv_status vvi_source_grow(vv_source *source, uint64_t bytes);
/** From here on `bytes` more must follow, by what a header says. */
void vvi_source_need(vv_source *source, uint64_t bytes);
/** What else will be read of the same data, in order and to its end, so that the checksum there need not be looked for
 * now: the rest of a time step that is read in slabs, later time steps. */
enum { VVI_FOLLOW_SLABS = 1, VVI_FOLLOW_FRAMES = 2 };
/** For this source and all that is opened of it from now on. */
void vvi_source_follow(vv_source *source, unsigned follow);
/** After a part was read, of which a time step ends here or does not, and behind which the header knows of `rest` more
 * bytes. Where nothing follows that gets there, coded data are read to their end: what is wrong with them is an error,
 * and that they are cut short damages the job. Where that would take long, a warning says that it was not done. */
vv_status vvi_source_check_rest(vv_source *source, bool frame_ends, uint64_t rest);
/** Where what should have followed did not get there: the warning. */
void vvi_source_tell_unproven(vv_source *source, vv_job *job);
/** After the last byte that matters: a checksum behind it that is wrong, or a coded stream that is cut, is an error. */
vv_status vvi_source_check_end(vv_source *source);
/** The same where all samples have arrived: a coded stream that is cut behind them damages the job, no more. */
vv_status vvi_source_check_tail(vv_source *source);

/** True when bytes [offset, offset + n) can be mapped: a plain regular file that is that long. */
bool vvi_source_mappable(const vv_source *source, uint64_t offset, uint64_t n);
/** Map them for reading, with guard bytes after (vv_field_new's guard_bytes). A file that shrinks later gives zeros
 * and vvi_mapping_damaged(), never a crash. release with vvi_mapping_free. */
typedef struct vvi_mapping vvi_mapping;
vv_status vvi_source_map(vvi_mapping **out, const void **data_out, size_t *guard_out, vv_source *source,
                         uint64_t offset, uint64_t n);
/** Whether `data` is what was mapped last of the source, and where in its file that lies. */
bool vvi_source_mapped_at(const vv_source *source, const void *data, uint64_t *offset_out);
bool vvi_mapping_damaged(const vvi_mapping *mapping);
/** How often samples of any mapped file were found to be gone. Whoever reads samples asks vv_field_health() of its
 * fields afterwards; this is for what ends a whole piece of work, whatever it has read. */
unsigned vvi_mapping_faults(void);
/** VV_E_READ where there were more since then. */
vv_status vvi_mapping_check_since(unsigned faults);
void vvi_mapping_free(void *mapping);

/** What a file lacks that is only looked at: the sentence that reading its samples will end with; "": nothing. */
typedef struct vvi_lack {
    char sentence[512];
} vvi_lack;

/** Samples of the source, and of what is opened beside it, may be missing: *lack says what, and is the caller's for as
 * long as sources live. */
void vvi_source_bear(vv_source *source, vvi_lack *lack);
/** A check of whether samples are there: what it says (VV_E_FORMAT) is kept where that may be, and VV_OK returned. */
vv_status vvi_source_lacks(const vv_source *source, vv_status checked);

/* Folders ------------------------------------------------------------------------------------------------------- */

/** Names of regular files, numbers in them by value ("slice2" before "slice10"). */
typedef struct vvi_names {
    char **name;
    size_t n;
} vvi_names;

bool vvi_source_is_folder(const vv_source *source);
/** The folder in which a file lies; *out NULL: it lies in none (memory, a pipe), or in one that cannot be read. */
vv_status vvi_source_open_folder_of(vv_source **out, const vv_source *file, vv_job *job);
/** Files in a folder, or in `below` of it (NULL: itself), as names for vvi_source_open_beside(); deep: those in its
 * folders too ("series2/IM001"). VV_E_LIMIT when there are more than the limits allow. Free with vvi_names_free. */
vv_status vvi_source_list(vvi_names *out, const vv_source *folder, const char *below, bool deep, vv_job *job);
/** Folders in a folder, or in `below` of it; those behind links are left out. None when there is no such folder. */
vv_status vvi_source_list_folders(vvi_names *out, const vv_source *folder, const char *below, vv_job *job);
void vvi_names_free(vvi_names *names); /* a zeroed one is fine */

/** Limits on outside input: vvi_job_limits(job). */
typedef vv_limits vvi_limits;
#endif
