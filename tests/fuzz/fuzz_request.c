/* What strangers send: the head of a request; and behind its end, frames of a WebSocket. */
#include "fuzz.h"
#include "server/framing.h"
#include "server/head.h"

#include <stdlib.h>
#include <string.h>

static void check_text(const char *text, const char *bytes, size_t n)
{
    fuzz_expect(!text || (text >= bytes && text < bytes + n && memchr(text, 0, (size_t)(bytes + n - text))));
}

/* Its bytes are not 0-terminated. */
static size_t read_head(const uint8_t *data, size_t n)
{
    vvi_head h;
    const char *why;
    size_t used;
    char *bytes = malloc(n ? n : 1);
    fuzz_expect(bytes != NULL);
    memcpy(bytes, data, n);
    const int status = vvi_head_read(&h, &why, &used, bytes, n);
    fuzz_expect(used <= n && (status == 0 || status == 200 || (status >= 400 && why)));
    if (status == 0)
        fuzz_expect(memcmp(bytes, data, n) == 0);
    if (status == 200) {
        const char *const texts[] = {h.host, h.origin, h.cookie, h.authorization, h.upgrade, h.socket_key, h.path};
        for (size_t i = 0; i < sizeof texts / sizeof *texts; i++)
            check_text(texts[i], bytes, n);
        fuzz_expect(h.path && *h.path == '/' && !h.coding);
        vvi_head_lists(h.connection, "upgrade");
    }
    free(bytes);
    return used;
}

static void read_frames(const uint8_t *data, size_t n)
{
    vvi_framing f = {.n_head = 0};
    const uint8_t *at = data, *end = data + n;
    vvi_framed what = VVI_FRAMED_MORE;
    while (at < end && what != VVI_FRAMED_BAD && what != VVI_FRAMED_CLOSE) {
        what = vvi_framing_take(&f, &at, end);
        fuzz_expect(at <= end && f.n_message <= VVI_MESSAGE_MOST && f.n_control <= VVI_CONTROL_MOST);
        fuzz_expect(what != VVI_FRAMED_MESSAGE || f.message[f.n_message] == 0);
        fuzz_expect(what != VVI_FRAMED_BAD || (f.code >= 1000 && f.why));
    }
    vvi_framing_clear(&f);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t n)
{
    const size_t used = read_head(data, n);
    read_frames(data + used, n - used);
    return 0;
}
