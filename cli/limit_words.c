#include "limit_words.h"
#include "core/status.h"
#include <stdlib.h>
#include <string.h>

/* NAME=VALUE of n bytes. */
static vv_status set_one(vv_limits *limits, const char *text, size_t n)
{
    char word[128];
    if (n >= sizeof word || !memchr(text, '=', n))
        return vv_fail(VV_E_ARGUMENT, "'%.*s' is not NAME=VALUE, as in voxels=1000000", n < 64 ? (int)n : 64, text);
    memcpy(word, text, n);
    word[n] = 0;
    char *equals = strchr(word, '=');
    *equals = 0;
    return vv_limits_set(limits, word, equals + 1);
}

static vv_status set_many(vv_limits *limits, const char *text)
{
    vv_status st = VV_OK;
    while (*text && st == VV_OK) {
        const size_t n = strcspn(text, ",");
        if (n > 0)
            st = set_one(limits, text, n);
        text += n + (text[n] == ',');
    }
    return st;
}

vv_status cli_limits_read(vv_limits *out, const cli_common *common)
{
    const char *environment = getenv("VOLVIS_LIMITS"), *word;
    vv_limits_init(out, sizeof *out);
    vv_status st = environment ? set_many(out, environment) : VV_OK;
    if (st != VV_OK)
        return vv_fail_in(st, "the environment's VOLVIS_LIMITS");
    for (size_t i = 0; st == VV_OK && (word = cli_word_nth(common->limit, i)); i++)
        st = set_one(out, word, strlen(word));
    return st == VV_OK ? VV_OK : vv_fail_in(st, "--limit");
}
