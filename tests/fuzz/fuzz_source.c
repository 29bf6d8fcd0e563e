/* Stream codings: the first byte chooses one (and whether it lies in another), the second how it is read; the rest is
 * the stream. What is read in pieces, with steps back, is what is read at once; of a damaged stream, or it is an
 * error. */
#include "fuzz.h"
#include "io/source.h"
#include <stdlib.h>
#include <string.h>

enum { ROOM = 1 << 20 };

static vv_status read_at_once(size_t *n_out, vv_source *source, uint8_t *out)
{
    size_t n = 0;
    const vv_status st = vvi_source_read_some(source, out, ROOM, &n);
    fuzz_expect(st == VV_OK || vv_error_last()->message[0]);
    *n_out = n;
    return st == VV_OK && n < ROOM ? vvi_source_check_end(source) : st; /* it may be cut short */
}

static vv_status read_piece(uint8_t *out, vv_source *source, size_t at, size_t n)
{
    const vv_status st = vvi_source_seek(source, at);
    return st == VV_OK ? vvi_source_read(source, out, n, "piece") : st;
}

static void read_in_pieces(vv_source *source, const uint8_t *want, size_t n, unsigned step, bool damaged)
{
    uint8_t piece[4096];
    vv_status st = VV_OK;
    for (size_t at = 0; at < n && st == VV_OK; at += step) {
        const size_t m = n - at < step ? n - at : step;
        st = read_piece(piece, source, at, m);
        fuzz_expect(st == VV_OK ? memcmp(piece, want + at, m) == 0 : damaged);
        if (at > 100 * (size_t)step)
            at += 37 * (size_t)step;
    }
    if (n > 0 && st == VV_OK) {
        st = read_piece(piece, source, n / 2, 1);
        fuzz_expect(st == VV_OK ? piece[0] == want[n / 2] : damaged);
    }
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t n)
{
    vv_source *source, *outer = NULL, *stream;
    if (n < 2)
        return 0;
    fuzz_expect(vvi_source_memory(&source, data + 2, n - 2, "input", fuzz_job()) == VV_OK);
    if (data[0] & 4)
        fuzz_expect(vvi_source_section(&outer, source, 0, UINT64_MAX, VVI_CODING_GZIP, fuzz_job()) == VV_OK);
    const vvi_coding coding = (vvi_coding)(data[0] & 3);
    fuzz_expect(vvi_source_section(&stream, outer ? outer : source, 0, UINT64_MAX, coding, fuzz_job()) == VV_OK);
    uint8_t *all = malloc(ROOM);
    fuzz_expect(all != NULL);
    size_t got;
    const vv_status st = read_at_once(&got, stream, all);
    read_in_pieces(stream, all, got, 1 + data[1] * 7u, st != VV_OK);
    free(all);
    vvi_source_close(stream);
    vvi_source_close(outer);
    vvi_source_close(source);
    return 0;
}
