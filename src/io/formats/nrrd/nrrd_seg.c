/* Segmentations of 3D Slicer, .seg.nrrd: a NRRD of labels with keys that tell its segments. Those that overlap lie in
 * layers, which are the components of its samples:
 * https://slicer.readthedocs.io/en/latest/developer_guide/modules/segmentations.html */
#include "core/job.h"
#include "core/memory.h"
#include "grid/lazy.h"
#include "grid/true_values.h"
#include "io/format.h"
#include "io/formats/nrrd/nrrd_scan.h"
#include "io/sink.h"
#include "registry.h"
#include <stdlib.h>
#include <string.h>

/* What looks like no label: of numbers that nobody has called labels so many may differ from both neighbours. In scans
 * they are a third and more, in segmentations one in hundreds. */
#define ALONE_MOST (1.0 / 20)
/* Of so few values they may lie as they like. */
#define FEW_VALUES 16

static int probe(const uint8_t *head, size_t n, const char *path)
{
    size_t n_path;
    vvi_path_coding(path, &n_path);
    return vvi_format_nrrd.probe(head, n, path) == 2 && vvi_format_has_suffix(&vvi_format_seg_nrrd, path, n_path) ? 2
                                                                                                                  : 0;
}

/* Writing --------------------------------------------------------------------------------------------------------- */

typedef struct making {
    const char *name; /* of the output */
    const vv_field *const *frames;
    size_t n_frames;
    vv_write_options options;
    vvi_nrrd_scan *scan; /* of each layer */
    int64_t (*box)[6];
    vv_label *labels;
} making;

static vv_status check_kind(const making *m)
{
    const vv_field_info *info = vv_field_get_info(m->frames[0]);
    const bool colours = info->meaning == VV_MEANING_RGB || info->meaning == VV_MEANING_RGBA;
    if (colours || info->meaning == VV_MEANING_VECTOR || info->components > 1)
        return vv_fail_at(
            VV_E_ARGUMENT, m->name, NULL,
            "a .seg.nrrd holds labels, and the samples are %s; write .nrrd, or take one channel (--channel)",
            colours                              ? "colours"
            : info->meaning == VV_MEANING_VECTOR ? "vectors"
                                                 : "of several channels");
    if (vv_type_is_float(info->type))
        return vv_fail_at(VV_E_ARGUMENT, m->name, NULL,
                          "a .seg.nrrd holds labels, and the samples are %s; write .nrrd, or, if they are labels, say "
                          "--type u16, or what holds them",
                          vv_type_name(info->type));
    if (m->options.origin && !m->options.new_values && info->meaning != VV_MEANING_LABEL &&
        vvi_has_scale(vv_file_info(m->options.origin)))
        return vv_fail_at(VV_E_ARGUMENT, m->name, NULL,
                          "a .seg.nrrd holds labels, and the samples have a scale (times %g, plus %g), so that their "
                          "values are amounts; write .nrrd, or take the scale out of the file's header",
                          vv_file_info(m->options.origin)->value_scale, vv_file_info(m->options.origin)->value_offset);
    if (m->n_frames > 1 && !m->options.layers)
        return vv_fail_at(VV_E_ARGUMENT, m->name, NULL,
                          "a .seg.nrrd holds one time step, and there are %zu; choose one with --frame N", m->n_frames);
    return VV_OK;
}

/* Whole numbers that nobody has called labels become labels by being written here, if they can be any. */
static vv_status check_labels(const making *m, const vvi_nrrd_scan *s)
{
    const vv_file *origin = m->options.origin;
    const bool said = vv_field_get_info(m->frames[0])->meaning == VV_MEANING_LABEL &&
                      (!origin || vv_file_info(origin)->meaning == VV_MEANING_LABEL);
    const double alone = s->n_labelled ? (double)s->n_alone / (double)s->n_labelled : 0;
    if (s->many)
        return vv_fail_at(VV_E_ARGUMENT, m->name, NULL,
                          "a .seg.nrrd names its labels, %d at most, and there are more different values; write .nrrd",
                          VVI_NRRD_NAMES_MOST);
    if (said || s->n_values <= FEW_VALUES || alone <= ALONE_MOST)
        return VV_OK;
    return vv_fail_at(VV_E_ARGUMENT, m->name, NULL,
                      "a .seg.nrrd holds labels, and the samples do not look like any: they have %zu different values, "
                      "and %.0f%% differ from both neighbours; write .nrrd",
                      s->n_values, 100 * alone);
}

static vv_status look(making *m, vv_job *job)
{
    m->scan = vvi_alloc_zeroed(job, m->n_frames * sizeof *m->scan, VVI_MEM_SCRATCH);
    m->box = vvi_alloc_zeroed(job, m->n_frames * sizeof *m->box, VVI_MEM_SCRATCH);
    if (!m->scan || !m->box)
        return vv_fail_memory(m->n_frames * sizeof *m->box);
    vv_status st = VV_OK;
    for (size_t f = 0; f < m->n_frames && st == VV_OK; f++) {
        if ((st = vvi_nrrd_scan_labels(&m->scan[f], m->frames[f], job)) == VV_OK)
            st = check_labels(m, &m->scan[f]);
        memcpy(m->box[f], m->scan[f].box, sizeof m->box[f]);
    }
    return st;
}

static bool is_named(const vv_label *labels, size_t n, vv_label_id value, int layer)
{
    for (size_t i = 0; i < n; i++)
        if (labels[i].value == value && labels[i].layer == layer)
            return true;
    return false;
}

static bool occurs(const making *m, const vv_label *label)
{
    for (size_t f = 0; f < m->n_frames; f++) {
        const vvi_nrrd_scan *s = &m->scan[f];
        for (size_t i = 0; i < s->n_values && (!m->options.layers || label->layer == (int)f); i++)
            if (s->value[i] == label->value)
                return true;
    }
    return false;
}

/* Labels that are named, and those that occur without a name; where the names are too many, only what occurs. 0 is what
 * no segment is. */
static vv_status gather(making *m, vv_job *job)
{
    size_t n = 0, room = m->options.n_labels;
    for (size_t f = 0; f < m->n_frames; f++)
        room += m->scan[f].n_values;
    m->labels = vvi_alloc(job, (room + 1) * sizeof *m->labels, VVI_MEM_SCRATCH);
    if (!m->labels)
        return vv_fail_memory(room * sizeof *m->labels);
    for (size_t i = 0; i < m->options.n_labels; i++)
        if (m->options.labels[i].value != 0 && (room <= VVI_NRRD_NAMES_MOST || occurs(m, &m->options.labels[i])))
            m->labels[n++] = m->options.labels[i];
    const size_t n_named = n;
    for (size_t f = 0; f < m->n_frames; f++) {
        const int layer = m->options.layers ? (int)f : n_named > 0 ? m->labels[0].layer : 0;
        for (size_t i = 0; i < m->scan[f].n_values; i++)
            if (!is_named(m->labels, n_named, m->scan[f].value[i], layer))
                m->labels[n++] = (vv_label){.value = m->scan[f].value[i], .layer = layer};
    }
    m->options.labels = m->labels;
    m->options.n_labels = n;
    if (n > VVI_NRRD_NAMES_MOST)
        return vv_fail_at(VV_E_ARGUMENT, m->name, NULL, "a .seg.nrrd has %d segments at most, and there are %zu",
                          VVI_NRRD_NAMES_MOST, n);
    return VV_OK;
}

/* Layers as components of one field ------------------------------------------------------------------------------- */

static vv_status interleave(vv_field **out, void *user, const vv_box *box, vv_job *job)
{
    const making *m = user;
    vv_field_info info = *vv_field_get_info(m->frames[0]);
    const size_t bytes = vv_type_bytes(info.type), step = bytes * m->n_frames;
    void *data;
    info.components = (int)m->n_frames;
    info.grid = vv_grid_crop(&info.grid, box);
    vv_status st = vv_field_new_empty(out, &data, &info, job);
    for (size_t f = 0; f < m->n_frames && st == VV_OK; f++) {
        vv_brick b;
        uint8_t *to = (uint8_t *)data + f * bytes;
        if ((st = vv_field_brick(&b, m->frames[f], box, job)) != VV_OK)
            break;
        for (int64_t k = 0; k < box->n[2]; k++)
            for (int64_t j = 0; j < box->n[1]; j++)
                for (int64_t i = 0; i < box->n[0]; i++, to += step)
                    memcpy(to, (const uint8_t *)b.data + i * b.stride[0] + j * b.stride[1] + k * b.stride[2], bytes);
        vv_brick_release(&b);
    }
    if (st != VV_OK) {
        vv_field_release(*out);
        *out = NULL;
    }
    return st;
}

static vv_status join(vv_field **out, making *m, vv_job *job)
{
    const uint64_t most = (uint64_t)32 << 20;
    const vv_runtime *runtime = job ? vv_job_runtime(job) : NULL;
    const uint64_t share = runtime ? vv_runtime_memory_limit(runtime) / 64 : most;
    vvi_lazy_pool *pool;
    vv_field_info info = *vv_field_get_info(m->frames[0]);
    info.components = (int)m->n_frames;
    vv_status st = vvi_lazy_pool_new(&pool, share < most ? share : most, 0, job);
    if (st != VV_OK)
        return st;
    st = vvi_field_lazy(out, &info, &(vvi_lazy_source){.make = interleave, .user = m}, pool, job);
    vvi_lazy_pool_release(pool);
    return st;
}

static vv_status write_segments(vv_sink *sink, making *m, vv_job *job)
{
    vv_field *all = NULL;
    vv_status st = look(m, job);
    if (st == VV_OK)
        st = gather(m, job);
    if (st == VV_OK && m->n_frames > 1)
        st = join(&all, m, job);
    else if (st == VV_OK)
        all = vv_field_retain(m->frames[0]);
    const vvi_nrrd_segmentation seg = {.box = (const int64_t(*)[6])m->box};
    if (st == VV_OK)
        st = vvi_nrrd_write_all(sink, (const vv_field *const *)&all, 1, &m->options, &seg, job);
    vv_field_release(all);
    return st;
}

static vv_status write_field(vv_sink *sink, const vv_field *const *frames, size_t n_frames,
                             const vv_write_options *options, vv_job *job)
{
    making m = {.name = vvi_sink_name(sink), .frames = frames, .n_frames = n_frames, .options = *options};
    size_t n_name;
    if (!m.options.encoding) /* gzip, as Slicer has it, unless the whole file is packed */
        m.options.encoding = vvi_path_coding(m.name, &n_name) == VVI_CODING_NONE ? "gzip" : "raw";
    vv_status st = check_kind(&m);
    if (st == VV_OK)
        st = write_segments(sink, &m, job);
    for (size_t f = 0; m.scan && f < n_frames; f++)
        vvi_nrrd_scan_finish(&m.scan[f]);
    vvi_free(m.scan);
    vvi_free(m.box);
    vvi_free(m.labels);
    return st;
}

static const char *const suffixes[] = {".seg.nrrd", NULL};
static const char *const encodings[] = {"gzip", "raw", "ascii", "hex", "bzip2", "zstd", NULL};

const vv_format vvi_format_seg_nrrd = {
    .api = VV_FORMAT_API,
    .name = "seg.nrrd",
    .doc =
        "segmentations of 3D Slicer: a NRRD whose labels are segments with names, colours and codes, in layers where "
        "they overlap; whole numbers written to it become labels",
    .suffixes = suffixes,
    .encodings = encodings,
    .probe = probe,
    .read_header = vvi_nrrd_read_segmentation,
    .free_plan = vvi_nrrd_free_plan,
    .read = vvi_nrrd_read,
    .mappable = vvi_nrrd_mappable,
    .write = write_field,
    .labels_only = true,
    .beside = true,
};
