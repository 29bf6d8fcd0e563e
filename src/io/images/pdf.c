/* PDF 1.5 (ISO 32000-1): one page, on it one picture without loss, transparency as its soft mask, texts as XMP. */
#include "io/images/pdf.h"

#include "core/job.h"
#include "core/memory.h"
#include "core/units.h"
#include "image/image_layer.h"
#include "io/images/png_rows.h"
#include "io/images/xmp.h"
#include "io/sink.h"
#include "registry.h"

#include <stdlib.h>
#include <string.h>

#define DPI 300 /* where nobody says: 1024 pixels are a column of a journal */
#define START "%PDF-1.5\n%\xe2\xe3\xcf\xd3\n1 0 obj\n<< /Type /Metadata /Subtype /XML /Length "

enum { METADATA = 1, CATALOG, PAGES, PAGE, CONTENTS, IMAGE, MASK, OBJECTS };

typedef struct writer {
    vv_sink *sink;
    const vv_image *image;
    const vv_image_options *options;
    vv_job *job;
    uint64_t at;             /* bytes written */
    uint64_t where[OBJECTS]; /* 0: there is none */
    bool transparent;
} writer;

static vv_status put(writer *w, const void *data, size_t n)
{
    w->at += n;
    return vvi_sink_write(w->sink, data, n);
}

/* Frees the text. */
static vv_status put_text(writer *w, vvi_text *t)
{
    const vv_status st = t->bad ? vv_fail_memory(t->n) : put(w, t->s ? t->s : "", t->n);
    vvi_text_free(t);
    return st;
}

static void open_object(writer *w, vvi_text *t, int number)
{
    w->where[number] = w->at + t->n;
    vvi_text_printf(t, "%d 0 obj\n", number);
}

/* First in the file, so that it is found again without reading the rest. */
static vv_status put_metadata(writer *w)
{
    vvi_text xmp = {0}, t = {0};
    vvi_xmp_write(&xmp, w->options->text, w->options->n_text);
    vvi_text_add(&t, START);
    w->where[METADATA] = strcspn(START, "\n") + 1 + 6;
    vvi_text_printf(&t, "%zu >>\nstream\n", xmp.n);
    vvi_text_add_n(&t, xmp.s ? xmp.s : "", xmp.n);
    vvi_text_add(&t, "\nendstream\nendobj\n");
    t.bad = t.bad || xmp.bad;
    vvi_text_free(&xmp);
    return put_text(w, &t);
}

static vv_status put_page(writer *w)
{
    const double points = 72 / (w->options->dpi > 0 ? w->options->dpi : DPI);
    char width[32], height[32];
    vvi_text t = {0}, drawing = {0};
    vvi_print_unsigned_zero(width, points * w->image->width);
    vvi_print_unsigned_zero(height, points * w->image->height);
    open_object(w, &t, CATALOG);
    vvi_text_printf(&t, "<< /Type /Catalog /Pages %d 0 R", PAGES);
    if (w->options->n_text > 0)
        vvi_text_printf(&t, " /Metadata %d 0 R", METADATA);
    vvi_text_add(&t, " >>\nendobj\n");
    open_object(w, &t, PAGES);
    vvi_text_printf(&t, "<< /Type /Pages /Kids [%d 0 R] /Count 1 >>\nendobj\n", PAGE);
    open_object(w, &t, PAGE);
    vvi_text_printf(&t,
                    "<< /Type /Page /Parent %d 0 R /MediaBox [0 0 %s %s] /Contents %d 0 R /Resources << /XObject << "
                    "/Im %d 0 R >> >>%s >>\nendobj\n",
                    PAGES, width, height, CONTENTS, IMAGE,
                    w->transparent ? " /Group << /S /Transparency /CS /DeviceRGB >>" : "");
    vvi_text_printf(&drawing, "q %s 0 0 %s 0 0 cm /Im Do Q", width, height);
    open_object(w, &t, CONTENTS);
    vvi_text_printf(&t, "<< /Length %zu >>\nstream\n%s\nendstream\nendobj\n", drawing.n, drawing.s ? drawing.s : "");
    t.bad = t.bad || drawing.bad;
    vvi_text_free(&drawing);
    return put_text(w, &t);
}

static vv_status put_stream(writer *w, const vvi_png_strips *s)
{
    static const char end[] = "\nendstream\nendobj\n";
    vv_status st = put(w, s->head, sizeof s->head);
    for (size_t i = 0; i < s->n && st == VV_OK; i++)
        st = put(w, s->strip[i].data, s->strip[i].n_bytes);
    if (st == VV_OK && (st = put(w, s->tail, sizeof s->tail)) == VV_OK)
        st = put(w, end, sizeof end - 1);
    return st;
}

/* Rows are filtered and deflated as those of PNG, which PDF knows by predictor 15. */
static vv_status put_picture(writer *w, int number)
{
    vvi_srgb_table table;
    vvi_png_strips strips;
    const vvi_codes codes = {
        .image = w->image,
        .channels = number == MASK ? 1 : 3,
        .straight = w->transparent,
        .bits = w->options->bits,
        .table = &table,
    };
    vvi_text t = {0};
    vvi_srgb_table_init(&table);
    vv_status st = vvi_png_strips_make(&strips, &codes, NULL, w->job);
    if (st == VV_OK) {
        open_object(w, &t, number);
        vvi_text_printf(&t,
                        "<< /Type /XObject /Subtype /Image /Width %d /Height %d /ColorSpace %s /BitsPerComponent %d "
                        "/Filter /FlateDecode /DecodeParms << /Predictor 15 /Colors %d /BitsPerComponent %d /Columns "
                        "%d >>",
                        w->image->width, w->image->height, number == MASK ? "/DeviceGray" : "/DeviceRGB", codes.bits,
                        codes.channels, codes.bits, w->image->width);
        if (number == IMAGE && w->transparent)
            vvi_text_printf(&t, " /SMask %d 0 R", MASK);
        vvi_text_printf(&t, " /Length %zu >>\nstream\n", strips.n_bytes);
        if ((st = put_text(w, &t)) == VV_OK)
            st = put_stream(w, &strips);
    }
    vvi_png_strips_free(&strips);
    return st;
}

static vv_status put_end(writer *w)
{
    const uint64_t table = w->at;
    const int n = w->transparent ? OBJECTS : MASK;
    vvi_text t = {0};
    vvi_text_printf(&t, "xref\n0 %d\n0000000000 65535 f \n", n);
    for (int i = 1; i < n; i++)
        vvi_text_printf(&t, "%010llu 00000 n \n", (unsigned long long)w->where[i]);
    vvi_text_printf(&t, "trailer\n<< /Size %d /Root %d 0 R >>\nstartxref\n%llu\n%%%%EOF\n", n, CATALOG,
                    (unsigned long long)table);
    return put_text(w, &t);
}

vv_status vvi_pdf_write(vv_sink *sink, const vv_image *image, const vv_image_options *options, vv_job *job)
{
    writer w = {.sink = sink, .image = image, .options = options, .job = job};
    w.transparent = options->alpha && vvi_image_transparent(image);
    vv_status st;
    if ((st = put_metadata(&w)) == VV_OK && (st = put_page(&w)) == VV_OK && (st = put_picture(&w, IMAGE)) == VV_OK &&
        w.transparent)
        st = put_picture(&w, MASK);
    return st == VV_OK ? put_end(&w) : st;
}

/* PDFs of other programs have none. */
vv_status vvi_pdf_read_text(vv_text **text_out, size_t *n_text_out, vv_source *source, vv_job *job)
{
    char start[sizeof START - 1];
    const char *line = "";
    bool end = false, exact;
    size_t n = 0;
    *text_out = NULL;
    *n_text_out = 0;
    vv_status st = vvi_source_read_whole(source, start, sizeof start, &n);
    if (st != VV_OK || n < sizeof start || memcmp(start, START, n) != 0 ||
        (st = vvi_source_line(source, &line, 64, &end)) != VV_OK)
        return st;
    const unsigned long long length = strtoull(line, NULL, 10);
    if (length == 0 || length > VVI_XMP_MOST || (st = vvi_source_line(source, &line, 64, &end)) != VV_OK)
        return st;
    if (length > vvi_source_left(source, &exact))
        return vv_fail_at(VV_E_FORMAT, vvi_source_name(source), NULL, "the PDF ends within its metadata");
    char *packet = vvi_alloc(job, (size_t)length, VVI_MEM_SCRATCH);
    if (!packet)
        return vv_fail_memory((size_t)length);
    if ((st = vvi_source_read(source, packet, (size_t)length, "the PDF's metadata")) == VV_OK)
        st = vvi_xmp_read_memory(text_out, n_text_out, packet, (size_t)length, vvi_source_name(source), job);
    vvi_free(packet);
    return st;
}

/* Ours alone: a PDF of somebody else is neither a picture nor data. */
static int probe(const uint8_t *head, size_t n, const char *path)
{
    (void)path;
    return n >= sizeof START - 1 && memcmp(head, START, sizeof START - 1) == 0 ? 2 : 0;
}

static const char *const suffixes[] = {".pdf", NULL};
static const int bits[] = {8, 16, 0};

const vv_image_format vvi_image_format_pdf = {
    .api = VV_IMAGE_FORMAT_API,
    .name = "pdf",
    .doc = "PDF of one page with the picture, lossless, transparency and text; sRGB, 300 pixels per inch unless --dpi "
           "is given",
    .suffixes = suffixes,
    .probe = probe,
    .write = vvi_pdf_write,
    .read_text = vvi_pdf_read_text,
    .bits = bits,
    .paper = true,
};
