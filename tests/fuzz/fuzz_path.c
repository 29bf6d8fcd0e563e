/* Property paths: "path=value" a line, set one after another on one World, as --set does. */
#include "fuzz.h"
#include <stdlib.h>
#include <string.h>
#include <volvis/model.h>

static void set_line(vv_object **root, char *line, const vv_property_context *context)
{
    char *json = NULL, *equals = strchr(line, '=');
    if (!equals)
        return;
    *equals = 0;
    const vv_status st = vv_path_set(root, line, equals + 1, context);
    fuzz_expect(st == VV_OK || vv_error_last()->message[0]);
    fuzz_expect(*root != NULL);
    if (vv_path_get(&json, *root, line) == VV_OK)
        free(json);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t n)
{
    static const vv_property_context context = {.length_unit = "mm", .voxel = 0.5};
    vv_object *root = NULL;
    char *text = malloc(n + 1);
    fuzz_expect(text && vv_object_new(&root, &vv_world_class, &context) == VV_OK);
    memcpy(text, data, n);
    text[n] = 0;
    char *rest = text, *line;
    for (int i = 0; i < 64 && (line = strsep(&rest, "\n")) != NULL; i++)
        set_line(&root, line, &context);
    free(text);
    vv_object_release(root);
    return 0;
}
