/* The same properties set again and again, as by a program or a key that is held: one step for undo, like a drag. Two
 * in a moment may be meant as two; from the third on they are one with the second. */
#include "core/memory.h"
#include "server/session_impl.h"

#include <stdlib.h>
#include <string.h>

#define MOMENT (INT64_C(100) * 1000000)

/* All paths, if they are set and nothing else is done; yours to free(). NULL: something else is, or no memory. */
static char *paths_of(const json_t *edits)
{
    vvi_text paths = {0};
    bool sets = json_array_size(edits) > 0;
    for (size_t i = 0; sets && i < json_array_size(edits); i++) {
        const json_t *edit = json_array_get(edits, i);
        const char *op = json_string_value(json_object_get(edit, "op")),
                   *path = json_string_value(json_object_get(edit, "path"));
        sets = op && path && strcmp(op, "set") == 0;
        vvi_text_printf(&paths, "%s\n", sets ? path : "");
    }
    char *text = vvi_text_take(&paths);
    if (sets)
        return text;
    free(text);
    return NULL;
}

bool vvi_client_sets_again(vvi_client *client, const json_t *edits, int64_t now)
{
    vvi_again *last = &client->again;
    char *paths = paths_of(edits);
    const bool same = paths && last->paths && strcmp(paths, last->paths) == 0 && now - last->at < MOMENT &&
                      last->commit == client->session->scene;
    const int times = same ? last->times + 1 : 1;
    free(last->paths);
    *last = (vvi_again){.paths = paths, .at = now, .times = times};
    return times > 2;
}
