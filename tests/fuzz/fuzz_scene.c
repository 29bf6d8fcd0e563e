/* Scene files: parsed or refused; what is parsed prints, and the print parses to the same print; what is to be made of
 * nothing is refused. */
#include "fuzz.h"
#include <stdlib.h>
#include <string.h>
#include <volvis/model.h>

/* Of a World without files: whatever is made of whatever ends in a sentence. */
static void ask_for_made(const vv_world *world)
{
    for (size_t i = 0; i < world->datasets->n; i++)
        if (((const vv_dataset *)(const void *)world->datasets->entry[i].object)->path)
            return;
    for (size_t i = 0; i < world->datasets->n && i < 64; i++) {
        const vv_dataset *dataset = (const vv_dataset *)(const void *)world->datasets->entry[i].object;
        vv_field_info info;
        if (vv_dataset_is_made(dataset))
            fuzz_expect(vv_dataset_info(&info, world, dataset, fuzz_job()) != VV_OK && vv_error_last()->message[0]);
    }
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t n)
{
    vv_world *world = NULL, *again = NULL;
    const vv_status st = vv_scene_parse(&world, (const char *)data, n, "input", NULL, fuzz_job());
    fuzz_expect((st == VV_OK) == (world != NULL));
    fuzz_expect(st == VV_OK || vv_error_last()->message[0]);
    if (!world)
        return 0;
    char *first = NULL, *second = NULL;
    if (vv_scene_print(&first, world, NULL) == VV_OK) {
        fuzz_expect(vv_scene_parse(&again, first, strlen(first), "print", NULL, fuzz_job()) == VV_OK);
        fuzz_expect(vv_scene_print(&second, again, NULL) == VV_OK);
        fuzz_expect(strcmp(first, second) == 0);
    }
    ask_for_made(world);
    free(first);
    free(second);
    vv_object_release((vv_object *)world);
    vv_object_release((vv_object *)again);
    return 0;
}
