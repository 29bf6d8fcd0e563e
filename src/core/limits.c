#include "core/limits.h"
#include "core/names.h"
#include "core/runtime.h"
#include "core/status.h"
#include "core/units.h"
#include <math.h>
#include <string.h>

const vv_limits vvi_limits_default = {
    .size = sizeof vvi_limits_default,
    .dim = 1u << 20,
    .voxels = (uint64_t)1 << 40,
    .header_bytes = 16u << 20,
    .metadata_keys = 65536,
    .string_bytes = 1u << 20,
    .files = 65536,
    .nesting = 32,
    .expansion_gzip = 1100,
    .expansion_zstd = 20000,
    .expansion_after = (uint64_t)64 << 20,
    .import_seconds = 600,
    .import_bytes = (uint64_t)64 << 30,
    .import_spool = (uint64_t)16 << 30,
    .undo_bytes = (uint64_t)64 << 20,
    .session_bytes = (uint64_t)64 << 30,
    .expansion_mesh = 100,
};

/* One limit: where it is kept, and the least and most that it may be. The most is what the code can count without
 * overflow, not what is wise. */
typedef struct limit_row {
    const char *name, *doc;
    size_t offset;
    uint64_t least, most;
    bool bytes; /**< may be written as 64M */
} limit_row;

static const limit_row rows[] = {
    {"dim", "samples along one axis", offsetof(vv_limits, dim), 1, (uint64_t)1 << 31, false},
    {"voxels", "samples of one volume", offsetof(vv_limits, voxels), 1, (uint64_t)1 << 60, false},
    {"header_bytes", "bytes of a header, and of the metadata that is kept", offsetof(vv_limits, header_bytes), 4096,
     (uint64_t)1 << 40, true},
    {"metadata_keys", "entries of metadata", offsetof(vv_limits, metadata_keys), 1, (uint64_t)1 << 32, false},
    {"string_bytes", "bytes of one text", offsetof(vv_limits, string_bytes), 256, (uint64_t)1 << 30, true},
    {"files", "data files of one header, files of a folder", offsetof(vv_limits, files), 1, (uint64_t)1 << 32, false},
    {"nesting", "depth of nested elements, groups and sequences", offsetof(vv_limits, nesting), 4, 256, false},
    {"expansion_gzip", "factor by which gzip data may grow", offsetof(vv_limits, expansion_gzip), 1, (uint64_t)1 << 32,
     false},
    {"expansion_zstd", "factor by which zstd, bzip2 and other data may grow", offsetof(vv_limits, expansion_zstd), 1,
     (uint64_t)1 << 32, false},
    {"expansion_after", "bytes that data may grow to before the factor is checked",
     offsetof(vv_limits, expansion_after), 1u << 20, (uint64_t)1 << 60, true},
    {"import_seconds", "processor time for one file under --safe", offsetof(vv_limits, import_seconds), 1, 1u << 30,
     false},
    {"import_bytes", "address space of the import program of --safe", offsetof(vv_limits, import_bytes), 64u << 20,
     (uint64_t)1 << 60, true},
    {"import_spool", "bytes of a temporary file, of unpacked data or of data from a pipe",
     offsetof(vv_limits, import_spool), 0, (uint64_t)1 << 60, true},
    {"undo_bytes", "bytes that are kept to undo with, in view and serve", offsetof(vv_limits, undo_bytes), 65536,
     (uint64_t)1 << 60, true},
    {"session_bytes", "bytes of uploads, samples, pictures and files that pages write, in view and serve",
     offsetof(vv_limits, session_bytes), 0, (uint64_t)1 << 60, true},
    {"expansion_mesh", "factor by which objects in many places may make a mesh larger than its file",
     offsetof(vv_limits, expansion_mesh), 1, (uint64_t)1 << 32, false},
};
enum { N_ROWS = sizeof rows / sizeof rows[0] };

static uint64_t *value_of(vv_limits *limits, const limit_row *row)
{
    return (uint64_t *)(void *)((char *)limits + row->offset);
}

/* An older caller's struct may end before a limit. */
static bool is_there(const vv_limits *limits, const limit_row *row)
{
    return limits->size >= row->offset + sizeof(uint64_t);
}

void vv_limits_init(vv_limits *limits, size_t size)
{
    memset(limits, 0, size);
    memcpy(limits, &vvi_limits_default, size < sizeof *limits ? size : sizeof *limits);
    limits->size = size;
}

static const limit_row *find_row(const vv_limits *limits, const char *name)
{
    for (size_t i = 0; i < N_ROWS; i++) {
        if (strcmp(rows[i].name, name) == 0 && is_there(limits, &rows[i]))
            return &rows[i];
    }
    return NULL;
}

static vv_status fail_unknown(const char *name)
{
    const char *names[N_ROWS];
    for (size_t i = 0; i < N_ROWS; i++)
        names[i] = rows[i].name;
    return vvi_fail_name(VV_E_ARGUMENT, NULL, NULL, name, &(vvi_known){names, N_ROWS, "volvis doctor --limits", NULL},
                         "there is no limit '%.64s'", name);
}

static vv_status check_value(const limit_row *row, double value, const char *text)
{
    /* NaN fails every comparison */
    if (!(value >= (double)row->least && value <= (double)row->most) || floor(value) < value)
        return vv_fail(VV_E_ARGUMENT, "the limit %s is '%.64s'; expected a whole number from %llu to %llu%s", row->name,
                       text, (unsigned long long)row->least, (unsigned long long)row->most,
                       row->bytes ? ", of bytes, or as in 64M" : ", or as in 2K");
    return VV_OK;
}

/* 2, 64K, 1M: of what is counted K is a thousand. */
static double parse_count(const char *text)
{
    static const char suffixes[] = "KMGT";
    double value, factor = 1;
    const char *end;
    if (!vvi_scan_number(&value, text, &end) || end == text)
        return NAN;
    const char *at = *end ? strchr(suffixes, *end) : NULL;
    for (const char *s = suffixes; at && s <= at; s++)
        factor *= 1000;
    return end[at ? 1 : 0] ? NAN : value * factor;
}

vv_status vv_limits_set(vv_limits *limits, const char *name, const char *text)
{
    double value;
    const limit_row *row = find_row(limits, name);
    if (!row)
        return fail_unknown(name);
    vv_status st = row->bytes ? vvi_parse_quantity(&value, text, VV_Q_BYTES, NULL, row->name) : VV_OK;
    if (!row->bytes)
        value = parse_count(text);
    if (st == VV_OK)
        st = check_value(row, value, text);
    if (st == VV_OK)
        *value_of(limits, row) = (uint64_t)value;
    return st;
}

bool vv_limits_get(const vv_limits *limits, size_t index, const char **name_out, const char **doc_out,
                   uint64_t *value_out)
{
    if (index >= N_ROWS || !is_there(limits, &rows[index]))
        return false;
    *name_out = rows[index].name;
    *doc_out = rows[index].doc;
    memcpy(value_out, (const char *)limits + rows[index].offset, sizeof *value_out);
    return true;
}

bool vvi_limits_of_bytes(size_t index)
{
    return index < N_ROWS && rows[index].bytes;
}

vv_status vvi_limits_read(vv_limits *out, const vv_limits *limits)
{
    vv_limits_init(out, sizeof *out);
    if (!limits)
        return VV_OK;
    if (limits->size < offsetof(vv_limits, voxels))
        return vv_fail(VV_E_ARGUMENT, "limits: call vv_limits_init() first");
    memcpy(out, limits, limits->size < sizeof *out ? limits->size : sizeof *out);
    out->size = sizeof *out;
    for (size_t i = 0; i < N_ROWS; i++) {
        const uint64_t value = *value_of(out, &rows[i]);
        if (value < rows[i].least || value > rows[i].most)
            return vv_fail(VV_E_ARGUMENT, "the limit %s is %llu; expected %llu to %llu", rows[i].name,
                           (unsigned long long)value, (unsigned long long)rows[i].least,
                           (unsigned long long)rows[i].most);
    }
    return VV_OK;
}

const vv_limits *vvi_job_limits(const vv_job *job)
{
    return job && job->runtime ? &job->runtime->limits : &vvi_limits_default;
}
