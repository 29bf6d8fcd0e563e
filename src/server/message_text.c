/* The JSON of a page's messages, with numbers as pages write them. It is looked over first, so that it is read once,
 * whatever it has in it. */
#include "core/json_text.h"
#include "core/memory.h"
#include "server/session_impl.h"

#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#define WHOLE 9007199254740992.0 /* 2^53 */

/* SURE_DIGITS: a whole number of fewer fits 64 bits. SURE_PLACES: a number of fewer characters is finite, if its
 * exponent has fewer than three digits. */
enum { SURE_DIGITS = 19, SURE_PLACES = 200, SURE_EXPONENT = 3 };

/* What a text has in it that must be known before it is read. */
typedef struct look {
    bool beyond;   /* whole numbers beyond 2^63 */
    bool infinite; /* numbers that are none of a computer's */
    bool nul;      /* U+0000 */
} look;

static bool is_of_number(char c)
{
    return (c >= '0' && c <= '9') || c == '.' || c == 'e' || c == 'E' || c == '+' || c == '-';
}

/* Behind the number at c, a digit, behind a minus; out: what it is, if it may be any of these. */
static const char *look_at_number(look *out, bool *infinite_out, const char *c, bool minus, const char *end)
{
    const char *at = c, *exponent = NULL;
    bool real = false;
    for (; at < end && is_of_number(*at); at++) {
        real |= *at == '.' || *at == 'e' || *at == 'E';
        exponent = *at == 'e' || *at == 'E' ? at + 1 : exponent;
    }
    *infinite_out = false;
    const bool sure =
        real ? at - c < SURE_PLACES && (!exponent || at - exponent < SURE_EXPONENT) : at - c < SURE_DIGITS;
    if (sure)
        return at;
    errno = 0;
    if (!real && (strtoll(c - minus, NULL, 10), errno == ERANGE))
        out->beyond = true;
    *infinite_out = !isfinite(strtod(c, NULL));
    out->infinite |= *infinite_out;
    return at;
}

/* Behind the text that begins at c. */
static const char *look_at_text(look *out, const char *c, const char *end)
{
    for (c++; c < end && *c != '"'; c++) {
        if (*c != '\\')
            continue;
        out->nul |= end - c > 5 && memcmp(c + 1, "u0000", 5) == 0;
        c++;
    }
    return c < end ? c + 1 : end;
}

/* Ends with a 0. What is infinite becomes 0 where the text may be changed, so that the rest can be read: who asked, and
 * for what. */
static look look_over(const char *text, size_t n, char *changed)
{
    look found = {.beyond = false};
    const char *c = text, *end = text + n;
    while (c < end) {
        bool infinite = false;
        const char *begin = c;
        if (*c == '"')
            c = look_at_text(&found, c, end);
        else if (*c >= '0' && *c <= '9')
            c = look_at_number(&found, &infinite, c, c > text && c[-1] == '-', end);
        else
            c++;
        if (infinite && changed) {
            memset(changed + (begin - text), ' ', (size_t)(c - begin));
            changed[begin - text] = '0';
        }
    }
    return found;
}

/* Ids, sizes and numbers of frames are integers again. NULL: there is no memory. */
static json_t *make_whole(json_t *message)
{
    const char *key;
    json_t *value;
    bool fine = true;
    json_object_foreach(message, key, value)
    {
        const double number = json_real_value(value);
        if (json_is_real(value) && fabs(number) < WHOLE && number == floor(number))
            fine &= json_object_set_new(message, key, json_integer((json_int_t)number)) == 0;
    }
    if (fine)
        return message;
    json_decref(message);
    return NULL;
}

static json_t *read_without_infinite(const char *text, size_t n, vvi_json_flaw *flaw)
{
    char *copy = vvi_calloc(n + 1, 1);
    flaw->fault = VVI_JSON_MEMORY;
    if (!copy)
        return NULL;
    memcpy(copy, text, n);
    look_over(text, n, copy);
    json_t *message = vvi_json_decode(copy, n, JSON_REJECT_DUPLICATES | JSON_DECODE_INT_AS_REAL | JSON_ALLOW_NUL, flaw);
    free(copy);
    return message;
}

json_t *vvi_message_read(const char **flaw, bool *no_memory, const char *text, size_t n)
{
    vvi_json_flaw why;
    const look found = look_over(text, n, NULL);
    const size_t flags = JSON_REJECT_DUPLICATES | (found.nul ? JSON_ALLOW_NUL : 0) |
                         (found.beyond || found.infinite || found.nul ? JSON_DECODE_INT_AS_REAL : 0);
    *flaw = found.infinite ? "a number is too large to compute with"
            : found.nul    ? "a text contains the character U+0000, which ends texts: leave it out"
                           : NULL;
    json_t *message = found.infinite ? read_without_infinite(text, n, &why) : vvi_json_decode(text, n, flags, &why);
    *no_memory = !message && why.fault == VVI_JSON_MEMORY;
    if (!message || !(flags & JSON_DECODE_INT_AS_REAL))
        return message;
    message = make_whole(message);
    *no_memory = !message;
    return message;
}
