/* Data sets of HDF5 files: what they are, whether they can be read, and the list of those that hold numbers. */
#include "core/job.h"
#include "core/limits.h"
#include "core/memory.h"
#include "core/text.h"
#include "io/formats/hdf5/hdf5.h"
#include "io/sample_writer.h"
#include <inttypes.h>
#include <stdio.h>
#include <string.h>

#define SETS_MOST 4096
#define CHUNK_MOST ((uint64_t)1 << 30)
#define CHUNKS_ALWAYS ((uint64_t)1 << 20) /* so many may be looked for in any file */

/* Types ----------------------------------------------------------------------------------------------------------- */

static bool choose_integer(vvi_h5_set *set, hid_t type)
{
    const size_t bytes = H5Tget_size(type);
    const bool is_signed = H5Tget_class(type) == H5T_INTEGER && H5Tget_sign(type) == H5T_SGN_2;
    if (bytes == 0 || bytes > 8 || !vvi_h5_number_is_whole(type))
        return false;
    const int size = bytes == 1 ? 0 : bytes == 2 ? 1 : bytes <= 4 ? 2 : 3;
    set->type = (vv_type)(VV_TYPE_U8 + 2 * size + (is_signed ? 1 : 0));
    /* fewer bits than bytes: the library knows how */
    set->convert = bytes != vv_type_bytes(set->type) || H5Tget_precision(type) != 8 * bytes || H5Tget_offset(type) != 0;
    return true;
}

static bool is_half(hid_t type)
{
    size_t sign, exponent, exponent_bits, mantissa, mantissa_bits;
    return H5Tget_size(type) == 2 &&
           H5Tget_fields(type, &sign, &exponent, &exponent_bits, &mantissa, &mantissa_bits) >= 0 && sign == 15 &&
           exponent == 10 && exponent_bits == 5 && mantissa == 0 && mantissa_bits == 10 && H5Tget_ebias(type) == 15 &&
           H5Tget_norm(type) == H5T_NORM_IMPLIED;
}

static bool choose_float(vvi_h5_set *set, hid_t type)
{
    const size_t bytes = H5Tget_size(type);
    if (!vvi_h5_number_is_whole(type))
        return false;
    set->half = is_half(type);
    set->type = set->half || bytes <= 4 ? VV_TYPE_F32 : VV_TYPE_F64;
    set->convert = !set->half && H5Tequal(type, H5T_IEEE_F32LE) <= 0 && H5Tequal(type, H5T_IEEE_F32BE) <= 0 &&
                   H5Tequal(type, H5T_IEEE_F64LE) <= 0 && H5Tequal(type, H5T_IEEE_F64BE) <= 0;
    return bytes <= 16;
}

/* Two values named FALSE and TRUE: how h5py keeps booleans. */
static bool is_truth(hid_t type)
{
    bool truth = H5Tget_nmembers(type) == 2;
    for (unsigned i = 0; i < 2 && truth; i++) {
        char *name = H5Tget_member_name(type, i);
        truth = name && strcmp(name, i ? "TRUE" : "FALSE") == 0;
        H5free_memory(name);
    }
    return truth;
}

static bool choose_type(vvi_h5_set *set, hid_t type)
{
    const H5T_class_t class = H5Tget_class(type);
    bool known = false;
    if (class == H5T_INTEGER || class == H5T_BITFIELD) {
        known = choose_integer(set, type);
    } else if (class == H5T_FLOAT) {
        known = choose_float(set, type);
    } else if (class == H5T_ENUM) {
        const hid_t base = H5Tget_super(type);
        known = base >= 0 && choose_integer(set, base) && !set->convert;
        set->truth = is_truth(type);
        set->names = !set->truth;
        if (set->truth && set->type == VV_TYPE_I8)
            set->type = VV_TYPE_U8;
        H5Tclose(base);
    }
    const H5T_order_t order = known ? H5Tget_order(type) : H5T_ORDER_NONE;
    set->swap = !set->convert && H5Tget_size(type) > 1 && vvi_order_swapped(order == H5T_ORDER_BE);
    return known && (order == H5T_ORDER_LE || order == H5T_ORDER_BE || set->convert);
}

hid_t vvi_h5_memory_type(const vvi_h5_set *set, hid_t data)
{
    const hid_t native[VV_TYPE_COUNT] = {H5T_NATIVE_UINT8,  H5T_NATIVE_INT8,  H5T_NATIVE_UINT16, H5T_NATIVE_INT16,
                                         H5T_NATIVE_UINT32, H5T_NATIVE_INT32, H5T_NATIVE_UINT64, H5T_NATIVE_INT64,
                                         H5T_NATIVE_FLOAT,  H5T_NATIVE_DOUBLE};
    return set->convert ? H5Tcopy(native[set->type]) : H5Dget_type(data);
}

uint64_t vvi_h5_count(const vvi_h5_set *set)
{
    uint64_t n = 1;
    for (int a = 0; a < set->rank; a++)
        n *= set->dims[a]; /* no overflow: see check_dims */
    return n;
}

/* Storage --------------------------------------------------------------------------------------------------------- */

static void describe_filters(vvi_h5_set *set, hid_t creation)
{
    const int n = H5Pget_nfilters(creation);
    for (int i = 0; i < n && i < 8; i++) {
        unsigned flags, values[8];
        size_t n_values = 8;
        char name[64] = "";
        const H5Z_filter_t id =
            H5Pget_filter2(creation, (unsigned)i, &flags, &n_values, values, sizeof name, name, NULL);
        const char *known = id == H5Z_FILTER_DEFLATE      ? "gzip"
                            : id == H5Z_FILTER_SHUFFLE    ? "shuffle"
                            : id == H5Z_FILTER_FLETCHER32 ? "fletcher32"
                            : id == H5Z_FILTER_SZIP       ? "szip"
                            : id == 32000                 ? "lzf"
                            : id == 32001                 ? "blosc"
                            : id == 32004                 ? "lz4"
                            : id == 32008                 ? "bitshuffle"
                            : id == 32013                 ? "zfp"
                            : id == 32015                 ? "zstd"
                                                          : name;
        name[sizeof name - 1] = 0;
        set->filter[i].id = id;
        set->filter[i].parameter = n_values > 0 ? values[0] : 0;
        set->filter[i].known = (vvi_h5_filter_is_ours(id) || (id < 256 && H5Zfilter_avail(id) > 0)) && n <= 8;
        set->by_chunks = set->by_chunks && vvi_h5_filter_is_ours(id);
        snprintf(set->filter[i].name, sizeof set->filter[i].name, "%.23s", known);
        vvi_text_clean(set->filter[i].name);
        set->n_filters = i + 1;
    }
}

/* What samples are that are not there, as bytes of the file; zeros when nobody says. */
static void describe_fill(vvi_h5_set *set, hid_t creation, hid_t type)
{
    H5D_fill_value_t defined;
    uint8_t value[16] = {0};
    memset(set->fill, 0, sizeof set->fill);
    if (set->bytes <= sizeof value && H5Pfill_value_defined(creation, &defined) >= 0 &&
        defined == H5D_FILL_VALUE_USER_DEFINED && H5Pget_fill_value(creation, type, value) >= 0)
        memcpy(set->fill, value, sizeof set->fill);
}

static void describe_storage(vvi_h5_set *set, hid_t data, hid_t type)
{
    const hid_t creation = H5Dget_create_plist(data);
    const H5D_layout_t layout = H5Pget_layout(creation);
    set->offset = UINT64_MAX;
    set->stored = H5Dget_storage_size(data);
    if (set->stored == 0 && H5Eget_num(H5E_DEFAULT) > 0) /* it cannot be known: then not as if nothing were there */
        set->stored = 1;
    set->bytes = H5Tget_size(type);
    describe_fill(set, creation, type);
    memset(set->lost, vv_type_is_float(set->type) && !set->convert ? 0xff : 0, sizeof set->lost); /* NaN: all bits */
    if (layout == H5D_CHUNKED) {
        set->chunked = H5Pget_chunk(creation, set->rank, set->chunk) == set->rank;
        set->by_chunks = set->chunked;
        describe_filters(set, creation);
    } else if (layout == H5D_CONTIGUOUS && vvi_h5_is_inside(creation)) {
        const haddr_t at = H5Dget_offset(data);
        set->offset = at == HADDR_UNDEF ? UINT64_MAX : at;
    }
    H5Pclose(creation);
}

static vv_status fail_type(const vvi_h5 *h5, const char *path)
{
    return vv_fail_at(VV_E_UNSUPPORTED, h5->name, path,
                      "holds no numbers that are supported; only integers and floats are read");
}

static vv_status check_dims(const vvi_h5_set *set, const vvi_h5 *h5)
{
    const vv_limits *limits = vvi_job_limits(h5->job);
    uint64_t left = limits->voxels;
    for (int a = 0; a < set->rank; a++) {
        if (set->dims[a] < 1 || set->dims[a] > limits->dim)
            return vv_fail_at(VV_E_FORMAT, h5->name, set->path,
                              "axis %d has %llu samples; 1 to %llu are allowed (--limit dim=N allows more)", a + 1,
                              (unsigned long long)set->dims[a], (unsigned long long)limits->dim);
        if (set->dims[a] > left)
            return vv_fail_at(VV_E_FORMAT, h5->name, set->path,
                              "asks for more than %llu samples; its header is wrong, or --limit voxels=N allows more",
                              (unsigned long long)limits->voxels);
        left /= set->dims[a];
    }
    return VV_OK;
}

static vv_status describe(vvi_h5_set *set, vvi_h5 *h5, hid_t data, int least, int most)
{
    const hid_t space = H5Dget_space(data), type = H5Dget_type(data);
    vv_status st = VV_OK;
    set->rank = space >= 0 ? H5Sget_simple_extent_ndims(space) : -1;
    if (space < 0 || type < 0)
        st = vvi_h5_fail(h5, set->path, "has a shape or a type that cannot be read");
    else if (set->rank < least || set->rank > most)
        st =
            vv_fail_at(VV_E_UNSUPPORTED, h5->name, set->path, "has %d axes; %d to %d are read", set->rank, least, most);
    else if (H5Sget_simple_extent_dims(space, set->dims, NULL) != set->rank)
        st = vvi_h5_fail(h5, set->path, "has a shape that cannot be read");
    else if (!choose_type(set, type))
        st = fail_type(h5, set->path);
    if (st == VV_OK)
        st = check_dims(set, h5);
    if (st == VV_OK)
        describe_storage(set, data, type);
    if (space >= 0)
        H5Sclose(space);
    if (type >= 0)
        H5Tclose(type);
    return st;
}

vv_status vvi_h5_describe(vvi_h5_set *set, vvi_h5 *h5, hid_t data)
{
    return describe(set, h5, data, 2, VVI_H5_RANK);
}

vv_status vvi_h5_describe_line(vvi_h5_set *set, vvi_h5 *h5, hid_t data)
{
    return describe(set, h5, data, 1, 1);
}

/* Can it be read? ------------------------------------------------------------------------------------------------- */

static vv_status check_filters(const vvi_h5_set *set, const vvi_h5 *h5)
{
    for (int i = 0; i < set->n_filters; i++)
        if (!set->filter[i].known)
            return vv_fail_at(
                VV_E_UNSUPPORTED, h5->name, set->path,
                "is compressed by filter %d (%s), which is not built in; 'h5repack -f GZIP=4 IN OUT' on a "
                "machine that has it makes a file that can be read",
                (int)set->filter[i].id, set->filter[i].name[0] ? set->filter[i].name : "no name");
    return VV_OK;
}

static vv_status check_chunks(const vvi_h5_set *set, const vvi_h5 *h5, size_t bytes)
{
    uint64_t chunk = bytes, n = 1;
    const uint64_t most = h5->n_bytes < CHUNKS_ALWAYS / 16 ? CHUNKS_ALWAYS : 16 * h5->n_bytes;
    for (int a = 0; a < set->rank; a++) {
        if (set->chunk[a] < 1 || chunk > CHUNK_MOST / set->chunk[a])
            return vv_fail_at(VV_E_FORMAT, h5->name, set->path, "has chunks of more than %llu bytes",
                              (unsigned long long)CHUNK_MOST);
        chunk *= set->chunk[a];
        n *= (set->dims[a] + set->chunk[a] - 1) / set->chunk[a]; /* no overflow: at most as many as samples */
    }
    if (set->stored > 0 && n > most)
        return vv_fail_at(VV_E_FORMAT, h5->name, set->path, "has %llu chunks, more than a file of %llu bytes can hold",
                          (unsigned long long)n, (unsigned long long)h5->n_bytes);
    return VV_OK;
}

static vv_status check_contiguous(const vvi_h5_set *set, vvi_h5 *h5, uint64_t bytes)
{
    if (set->offset == UINT64_MAX)
        return VV_OK;
    if (set->stored < bytes)
        return vv_fail_at(VV_E_FORMAT, h5->name, set->path, "has room for %llu bytes; %llu were expected",
                          (unsigned long long)set->stored, (unsigned long long)bytes);
    return vvi_source_expect_half(h5->source, set->offset, bytes, "samples");
}

/* Without stored samples it is one fill value, however large: no more of that than packed data may grow to. */
static vv_status check_fill(const vvi_h5_set *set, const vvi_h5 *h5, uint64_t bytes)
{
    const vv_limits *limits = vvi_job_limits(h5->job);
    if (set->stored > 0 || bytes <= limits->expansion_after || bytes / limits->expansion_zstd <= h5->n_bytes)
        return VV_OK;
    return vv_fail_at(VV_E_LIMIT, h5->name, set->path,
                      "asks for %llu bytes, none of which are stored; --limit expansion_after=%lluG allows reading its "
                      "fill value throughout",
                      (unsigned long long)bytes, (unsigned long long)(bytes >> 30) + 1);
}

/* A list of external files counts beside any layout: the library goes by the list. */
bool vvi_h5_is_inside(hid_t creation)
{
    return H5Pget_layout(creation) != H5D_VIRTUAL && H5Pget_external_count(creation) == 0;
}

vv_status vvi_h5_check(const vvi_h5_set *set, vvi_h5 *h5, hid_t data)
{
    const hid_t creation = H5Dget_create_plist(data), type = H5Dget_type(data);
    const H5D_layout_t layout = H5Pget_layout(creation);
    const bool inside = vvi_h5_is_inside(creation);
    const size_t bytes = H5Tget_size(type);
    H5Pclose(creation);
    H5Tclose(type);
    if (!inside)
        return vv_fail_at(VV_E_UNSUPPORTED, h5->name, set->path,
                          "keeps its samples in other files; 'h5repack' makes a complete file of it");
    vv_status st = check_filters(set, h5);
    if (st == VV_OK && layout == H5D_CHUNKED)
        st = check_chunks(set, h5, bytes);
    if (st == VV_OK && layout == H5D_COMPACT && set->stored < vvi_h5_count(set) * bytes)
        st = vv_fail_at(VV_E_FORMAT, h5->name, set->path, "has room for %llu bytes; %llu were expected",
                        (unsigned long long)set->stored, (unsigned long long)(vvi_h5_count(set) * bytes));
    if (st == VV_OK && layout == H5D_CONTIGUOUS)
        st = check_contiguous(set, h5, vvi_h5_count(set) * bytes);
    return st == VV_OK ? check_fill(set, h5, vvi_h5_count(set) * bytes) : st;
}

/* The list -------------------------------------------------------------------------------------------------------- */

typedef struct listing {
    vvi_h5_list *list;
    vvi_h5 *h5;
    vv_status st;
} listing;

static vv_status add_set(vvi_h5_list *list, const char *path, vv_job *job)
{
    if (list->n == list->room) {
        const size_t room = list->room ? 2 * list->room : 8;
        vvi_h5_set *grown = vvi_realloc(job, list->set, room * sizeof *grown, VVI_MEM_SCRATCH);
        if (!grown)
            return vv_fail_memory(room * sizeof *grown);
        list->set = grown;
        list->room = room;
    }
    vvi_h5_set *set = &list->set[list->n++];
    *set = (vvi_h5_set){0};
    snprintf(set->path, sizeof set->path, "/%s", path);
    return VV_OK;
}

static uint64_t depth_of(const char *path)
{
    uint64_t depth = 0;
    for (; *path; path++)
        depth += *path == '/';
    return depth;
}

static herr_t list_object(hid_t root, const char *path, const H5O_info_t *info, void *user)
{
    listing *l = user;
    (void)root;
    if ((l->st = vvi_job_poll(l->h5->job)) != VV_OK)
        return 1;
    if (depth_of(path) > vvi_job_limits(l->h5->job)->nesting) {
        l->st = vv_fail_at(VV_E_FORMAT, vvi_source_name(l->h5->source), NULL,
                           "has groups nested more than %llu deep; --limit nesting=N allows more",
                           (unsigned long long)vvi_job_limits(l->h5->job)->nesting);
        return 1;
    }
    if (info->type != H5O_TYPE_DATASET || strlen(path) + 2 > VVI_H5_PATH)
        return 0;
    l->list->full = l->list->n >= SETS_MOST;
    if (l->list->full)
        return 1;
    l->st = add_set(l->list, path, l->h5->job);
    return l->st == VV_OK ? 0 : 1;
}

static bool describe_listed(vvi_h5_set *set, vvi_h5 *h5)
{
    const hid_t data = vvi_h5_object(h5, set->path);
    char class[32];
    if (data < 0)
        return false;
    const bool is_set = H5Iget_type(data) == H5I_DATASET && vvi_h5_describe(set, h5, data) == VV_OK;
    set->dimension_scale =
        is_set && vvi_h5_text(class, sizeof class, data, "CLASS") && strcmp(class, "DIMENSION_SCALE") == 0;
    H5Oclose(data);
    return is_set && !set->dimension_scale;
}

vv_status vvi_h5_list_sets(vvi_h5_list *out, vvi_h5 *h5)
{
    listing l = {out, h5, VV_OK};
    *out = (vvi_h5_list){0};
    if (H5Ovisit2(h5->file, H5_INDEX_NAME, H5_ITER_INC, list_object, &l, H5O_INFO_BASIC) < 0 && l.st == VV_OK)
        l.st = vvi_h5_fail(h5, NULL, "has a directory that cannot be read");
    size_t kept = 0;
    for (size_t i = 0; i < out->n && l.st == VV_OK; i++) {
        if ((l.st = vvi_job_poll(h5->job)) == VV_OK && describe_listed(&out->set[i], h5))
            out->set[kept++] = out->set[i];
        if (l.st == VV_OK)
            l.st = h5->st;
    }
    out->n = kept;
    if (l.st != VV_OK)
        vvi_h5_list_free(out);
    return l.st;
}

void vvi_h5_list_free(vvi_h5_list *list)
{
    vvi_free(list->set);
    *list = (vvi_h5_list){0};
}
