#include "io/base64.h"

void vvi_base64_group(char out[4], const uint8_t *in, size_t n)
{
    static const char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    const unsigned a = in[0], b = n > 1 ? in[1] : 0, c = n > 2 ? in[2] : 0;
    out[0] = digits[a >> 2];
    out[1] = digits[(a & 3) << 4 | b >> 4];
    out[2] = n > 1 ? digits[(b & 15) << 2 | c >> 6] : '=';
    out[3] = n > 2 ? digits[c & 63] : '=';
}

vv_status vvi_base64_write(vvi_base64 *coder, vv_sink *sink, const void *data, size_t n)
{
    const uint8_t *in = data;
    char text[4096];
    size_t used = 0;
    vv_status st = VV_OK;
    for (size_t i = 0; i < n && st == VV_OK; i++) {
        coder->rest[coder->n_rest++] = in[i];
        if (coder->n_rest < 3)
            continue;
        vvi_base64_group(text + used, coder->rest, 3);
        used += 4;
        coder->n_rest = 0;
        if (used == sizeof text) {
            st = vvi_sink_write(sink, text, used);
            used = 0;
        }
    }
    return st == VV_OK ? vvi_sink_write(sink, text, used) : st;
}

vv_status vvi_base64_end(vvi_base64 *coder, vv_sink *sink)
{
    char text[4];
    if (coder->n_rest == 0)
        return VV_OK;
    vvi_base64_group(text, coder->rest, coder->n_rest);
    coder->n_rest = 0;
    return vvi_sink_write(sink, text, sizeof text);
}
