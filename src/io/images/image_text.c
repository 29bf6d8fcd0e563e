/* Text of image files as UTF-8. */
#include "io/images/image_text.h"

#include <stdbool.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

static int sequence_length(uint8_t lead)
{
    return lead < 0x80                   ? 1
           : lead >= 0xc2 && lead < 0xe0 ? 2
           : (lead & 0xf0) == 0xe0       ? 3
           : lead >= 0xf0 && lead < 0xf5 ? 4
                                         : 0;
}

static bool is_utf8(const uint8_t *s, size_t n)
{
    for (size_t i = 0; i < n;) {
        const int length = sequence_length(s[i]);
        if (length == 0 || (size_t)length > n - i)
            return false;
        for (int k = 1; k < length; k++)
            if ((s[i + (size_t)k] & 0xc0) != 0x80)
                return false;
        i += (size_t)length;
    }
    return true;
}

/* Texts that should be Latin-1 by their standard are often UTF-8, so only what is not UTF-8 is converted. */
char *vvi_text_utf8(const char *s, size_t n)
{
    const uint8_t *p = (const uint8_t *)s;
    n = strnlen(s, n);
    const bool fine = is_utf8(p, n);
    char *out = malloc(2 * n + 1), *q = out;
    for (size_t i = 0; out && i < n; i++) {
        if (!fine && p[i] >= 0x80)
            *q++ = (char)(0xc0 | p[i] >> 6);
        *q++ = (char)(fine || p[i] < 0x80 ? p[i] : 0x80 | (p[i] & 0x3f));
    }
    if (out)
        *q = 0;
    return out;
}
