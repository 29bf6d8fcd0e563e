#include "fuzz.h"
#include "io/notes.h"
#include "io/source.h"
#include <stdlib.h>

void fuzz_expect(bool condition)
{
    if (!condition)
        abort();
}

vv_job *fuzz_job(void)
{
    static vv_job *job;
    if (!job) {
        vv_runtime *runtime;
        vv_runtime_options options;
        vv_runtime_options_init(&options, sizeof options);
        options.threads = 1;
        options.memory_bytes = 64 << 20;
        fuzz_expect(vv_runtime_new(&runtime, &options) == VV_OK && vv_job_new(&job, runtime, NULL, NULL) == VV_OK);
        vv_runtime_release(runtime);
    }
    return job;
}

static void expect_sentence(vv_status st)
{
    fuzz_expect(st == VV_OK || (vv_error_last()->status == st && vv_error_last()->message[0]));
    fuzz_expect(st != VV_E_INTERNAL);
}

static void read_frames(const vv_format *format, const vv_field_info *info, const void *plan, vv_source *source)
{
    for (int64_t f = 0; f < info->n_frames && f < 3; f++) {
        vv_field *field = NULL;
        const vv_status st = format->read(&field, info, plan, source, f, NULL, fuzz_job());
        expect_sentence(st);
        fuzz_expect((st == VV_OK) == (field != NULL));
        if (field)
            fuzz_expect(vv_field_get_info(field)->grid.dims[0] == info->grid.dims[0]);
        vv_field_release(field);
    }
}

void fuzz_format(const vv_format *format, const uint8_t *data, size_t n, const vv_read_options *options)
{
    vv_read_options none;
    vv_source *source;
    vv_notes *notes;
    void *plan = NULL;
    vv_field_info info = vv_field_info_default();
    vv_read_options_init(&none, sizeof none);
    fuzz_expect(vvi_source_memory(&source, data, n, "input", fuzz_job()) == VV_OK);
    fuzz_expect(vvi_notes_new(&notes, fuzz_job()) == VV_OK);
    const vv_status st = format->read_header(&info, &plan, source, options ? options : &none, notes, fuzz_job());
    expect_sentence(st);
    if (st == VV_OK) {
        fuzz_expect(info.grid.dims[0] >= 1 && info.grid.dims[1] >= 1 && info.grid.dims[2] >= 1 && info.n_frames >= 1);
        if (vv_field_info_check(&info) == VV_OK)
            read_frames(format, &info, plan, source);
        format->free_plan(plan);
    }
    vvi_notes_free(notes);
    vvi_source_close(source);
}

static void read_text(const vv_image_format *format, vv_source *source)
{
    vv_text *text = NULL;
    size_t n_text = 0;
    const vv_status st = format->read_text(&text, &n_text, source, fuzz_job());
    expect_sentence(st);
    fuzz_expect(st == VV_OK || !text);
    vv_text_free(text, n_text);
}

static void read_picture(const vv_image_format *format, vv_source *source)
{
    vv_image *image = NULL;
    vv_text *text = NULL;
    size_t n_text = 0;
    const vv_status st = format->read(&image, &text, &n_text, source, fuzz_job());
    expect_sentence(st);
    fuzz_expect((st == VV_OK) == (image != NULL) && (st == VV_OK || !text));
    fuzz_expect(!image || (image->width >= 1 && image->height >= 1));
    vv_image_release(image);
    vv_text_free(text, n_text);
}

void fuzz_image(const vv_image_format *format, const uint8_t *data, size_t n)
{
    void (*const reads[])(const vv_image_format *, vv_source *) = {read_picture, read_text};
    for (size_t i = 0; i < 2; i++) {
        vv_source *source;
        fuzz_expect(vvi_source_memory(&source, data, n, "input", fuzz_job()) == VV_OK);
        if (i == 0 ? format->read != NULL : format->read_text != NULL)
            reads[i](format, source);
        vvi_source_close(source);
    }
}
