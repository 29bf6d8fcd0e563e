/* The JSON of a page's messages, with numbers as pages write them. */
#include "core/memory.h"
#include "server/session_impl.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define WHOLE 9007199254740992.0 /* 2^53 */

/* Numbers that are none of a computer's become 0, so that the rest can be read: who asked, and for what. */
static void take_out_infinite(char *text)
{
    bool quoted = false;
    for (char *c = text; *c; c++) {
        if (quoted && *c == '\\' && c[1])
            c++;
        else if (*c == '"')
            quoted = !quoted;
        else if (!quoted && *c >= '0' && *c <= '9') {
            char *end;
            const double value = strtod(c, &end);
            if (!isfinite(value)) {
                memset(c, ' ', (size_t)(end - c));
                *c = '0';
            }
            c = end - 1;
        }
    }
}

/* Ids, sizes and numbers of frames are integers again. */
static void make_whole(json_t *message)
{
    const char *key;
    json_t *value;
    json_object_foreach(message, key, value)
    {
        const double number = json_real_value(value);
        if (json_is_real(value) && fabs(number) < WHOLE && number == floor(number))
            json_object_set_new(message, key, json_integer((json_int_t)number));
    }
}

static json_t *read_flawed(const char *text, size_t n)
{
    char *copy = vvi_calloc(n + 1, 1);
    if (!copy)
        return NULL;
    memcpy(copy, text, n);
    take_out_infinite(copy);
    json_t *message = json_loads(copy, JSON_REJECT_DUPLICATES | JSON_DECODE_INT_AS_REAL | JSON_ALLOW_NUL, NULL);
    free(copy);
    return message;
}

json_t *vvi_message_read(const char **flaw, const char *text, size_t n)
{
    json_error_t error = {0};
    *flaw = NULL;
    json_t *message = json_loadb(text, n, JSON_REJECT_DUPLICATES, &error);
    if (message)
        return message;
    if (json_error_code(&error) == json_error_numeric_overflow)
        message = json_loadb(text, n, JSON_REJECT_DUPLICATES | JSON_DECODE_INT_AS_REAL, &error);
    if (!message && (json_error_code(&error) == json_error_numeric_overflow ||
                     json_error_code(&error) == json_error_null_character)) {
        *flaw = json_error_code(&error) == json_error_numeric_overflow
                    ? "a number is too large to compute with"
                    : "a text contains the character U+0000, which ends texts: leave it out";
        message = read_flawed(text, n);
    }
    make_whole(message);
    return message;
}
