/* Scene files on disk. */
#include "core/memory.h"
#include "core/property_impl.h"
#include "io/sink.h"
#include "io/source.h"
#include "model/file_path.h"
#include <string.h>
#include <volvis/model.h>

/* All of a source, up to the limit of documents. */
static vv_status read_all(vvi_text *text, vv_source *source)
{
    enum { PIECE = 65536 };
    char *piece = vvi_alloc(NULL, PIECE, VVI_MEM_SCRATCH);
    vv_status st = piece ? VV_OK : vv_fail_memory(PIECE);
    size_t n = PIECE;
    while (st == VV_OK && n == PIECE && text->n <= VVI_JSON_BYTES) {
        st = vvi_source_read_some(source, piece, PIECE, &n);
        if (st == VV_OK)
            vvi_text_add_n(text, piece, n);
    }
    vvi_free(piece);
    return st == VV_OK && text->bad ? vv_fail_memory(text->n + PIECE) : st;
}

vv_status vv_scene_read(vv_world **out, const char *path, vv_job *job)
{
    vv_source *source = NULL;
    vvi_text text = {0};
    *out = NULL;
    char *folder = vvi_folder_of(path);
    if (!folder)
        return vv_fail_memory(strlen(path) + 1);
    vv_status st = vvi_source_open(&source, path, job);
    if (st == VV_OK)
        st = read_all(&text, source);
    if (st == VV_OK)
        st = vv_scene_parse(out, text.s ? text.s : "", text.n, path, folder, job);
    vvi_source_close(source);
    vvi_text_free(&text);
    free(folder);
    return st;
}

vv_status vv_scene_write(const char *path, const vv_world *world, vv_job *job)
{
    char *json = NULL;
    vv_sink *sink = NULL;
    char *folder = vvi_folder_of(path);
    if (!folder)
        return vv_fail_memory(strlen(path) + 1);
    vv_status st = vv_scene_print(&json, world, folder);
    free(folder);
    if (st == VV_OK)
        st = vvi_sink_open(&sink, path, job);
    if (st == VV_OK) {
        st = vvi_sink_write(sink, json, strlen(json));
        if (st == VV_OK)
            st = vvi_sink_commit(sink);
        else
            vvi_sink_abandon(sink);
    }
    free(json);
    return st;
}
