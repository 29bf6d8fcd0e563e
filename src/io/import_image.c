#include "io/import_image.h"
#include "core/job.h"
#include "core/memory.h"
#include "io/import_listen.h"
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

enum { TEXTS_MOST = 65536 };

static vv_status ask(vvi_import_process *p, const char *path, vv_job *job)
{
    int fd;
    vvi_text body = {0};
    vv_status st = vvi_import_open_place(&fd, path, job);
    if (st != VV_OK)
        return st;
    vvi_import_put_file(&body, path, job);
    vvi_import_put_terms(&body, job);
    st = vvi_import_ask(p, VVI_WIRE_READ_TEXTS, &body, fd);
    vvi_text_free(&body);
    if (fd >= 0)
        close(fd);
    return st;
}

/* NULL: no memory. */
static vv_text *take_texts(vvi_wire_in *in, size_t n)
{
    vv_text *all = vvi_calloc(n + 1, sizeof *all);
    bool fine = all != NULL;
    for (size_t i = 0; i < n && fine; i++) {
        all[i].key = vvi_strdup(vvi_wire_take_text(in));
        all[i].value = vvi_strdup(vvi_wire_take_text(in));
        fine = all[i].key && all[i].value;
    }
    if (fine)
        return all;
    vv_text_free(all, all ? n : 0);
    return NULL;
}

static vv_status read_texts(vv_text **out, size_t *n_out, vvi_import_process *p, const char *path, vv_job *job)
{
    vvi_wire_in in;
    vv_status st = vvi_import_start(p, job);
    if (st != VV_OK || (st = ask(p, path, job)) != VV_OK ||
        (st = vvi_import_listen(p, VVI_WIRE_TEXTS, &in, NULL, job)) != VV_OK)
        return st;
    const size_t n = (size_t)vvi_wire_take_between(&in, 0, TEXTS_MOST);
    vv_text *all = take_texts(&in, n);
    if (!all)
        return vv_fail_memory(n * sizeof *all);
    if (!vvi_wire_taken(&in)) {
        vv_text_free(all, n);
        return vvi_import_nonsense(p, "texts that do not hold what they should");
    }
    *out = all;
    *n_out = n;
    return VV_OK;
}

vv_status vvi_import_image_text(vv_text **out, size_t *n_out, const char *path, vv_job *job)
{
    vvi_import_process p = {.socket = -1, .input = -1, .name = path};
    *out = NULL;
    *n_out = 0;
    if (vvi_job_registry(job) != vv_registry_builtin() && !vvi_job_import_program(job))
        return vv_fail_at(VV_E_UNSUPPORTED, path, NULL,
                          "the import program knows the formats that are built in and no others");
    const vv_status st = read_texts(out, n_out, &p, path, job);
    vvi_import_stop(&p);
    return st;
}
