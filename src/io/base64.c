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
