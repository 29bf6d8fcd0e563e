/* The two files of a pair: .hdr and .img, each with .gz or without. */
#include "core/memory.h"
#include "core/text.h"
#include "io/formats/nifti/nifti.h"
#include <stdlib.h>
#include <string.h>
#include <strings.h>

static bool ends_in(const char *path, size_t n, const char *suffix)
{
    const size_t m = strlen(suffix);
    return n > m && strncasecmp(path + n - m, suffix, m) == 0;
}

/* The other file of a pair: the same name with .img for .hdr or the reverse, in the same letter case, with .gz or not.
 */
static vv_status open_other(vv_source **out, vv_source *source, const char *from, const char *to, vv_job *job)
{
    const char *path = vvi_source_name(source), *slash = strrchr(path, '/');
    const char *base = slash ? slash + 1 : path;
    size_t n = strlen(base);
    *out = NULL;
    const bool coded = ends_in(base, n, ".gz");
    n -= coded ? 3 : 0;
    if (!ends_in(base, n, from))
        return vv_fail_at(VV_E_READ, path, NULL,
                          "its samples lie in a second file, whose name is known only when this one ends in %s", from);
    const bool upper = base[n - 1] >= 'A' && base[n - 1] <= 'Z';
    vv_status st = VV_OK;
    for (int attempt = 0; attempt < 2 && !*out && st == VV_OK; attempt++) {
        const bool gz = coded != (attempt == 1);
        char *name = vvi_asprintf("%.*s%s%s", (int)(n - 4), base, to, gz ? ".gz" : "");
        if (!name)
            return vv_fail_memory(n);
        for (size_t i = n - 4; upper && i < n; i++)
            name[i] = (char)(name[i] >= 'a' && name[i] <= 'z' ? name[i] - 32 : name[i]);
        st = vvi_source_find_beside(out, source, name, job);
        if (st == VV_OK && !*out && attempt == 1) /* told by the name that this one asks for */
            st = vv_fail_at(VV_E_READ, path, NULL,
                            "is one of a pair, and '%.*s%.4s', with or without .gz, is not beside it; copy it there",
                            (int)(n - 4), base, name + n - 4);
        free(name);
    }
    return st;
}

/* Bytes of a source, decoded if they are coded. `inner` is what to read; NULL means `source` itself. */
static vv_status open_inside(vv_source **inner, vv_source *source, vv_job *job)
{
    *inner = NULL;
    const vvi_coding coding = vvi_source_sniff(source);
    return coding == VVI_CODING_NONE ? VV_OK : vvi_source_section(inner, source, 0, UINT64_MAX, coding, job);
}

void vvi_nifti_close(vvi_nifti_opened *o)
{
    vvi_source_close(o->inner);
    vvi_source_close(o->outer);
}

vv_status vvi_nifti_open_other(vvi_nifti_opened *o, vv_source *source, const char *from, const char *to, vv_job *job)
{
    *o = (vvi_nifti_opened){0};
    vv_status st = open_other(&o->outer, source, from, to, job);
    if (st == VV_OK)
        st = open_inside(&o->inner, o->outer, job);
    o->source = o->inner ? o->inner : o->outer;
    return st;
}

bool vvi_nifti_is_image(const vv_source *source)
{
    const char *name = vvi_source_name(source);
    const size_t n = strlen(name);
    return ends_in(name, n, ".img") || ends_in(name, n, ".img.gz");
}

vv_status vvi_nifti_open_samples(vvi_nifti_opened *o, const vvi_nifti *h, vv_source *source, vv_job *job)
{
    *o = (vvi_nifti_opened){.source = source};
    if (!h->pair || vvi_nifti_is_image(source))
        return VV_OK;
    return vvi_nifti_open_other(o, source, ".hdr", ".img", job);
}
