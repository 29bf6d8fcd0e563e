/* For the tests of the example scenes: prints the schema, or reads scenes and writes them as the library does. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <volvis/model.h>
#include <volvis/sys/registry.h>

static int fail(void)
{
    fprintf(stderr, "%s\n", vv_error_last()->message);
    return 1;
}

static int print_schema(void)
{
    char *json = NULL;
    if (vv_scene_schema(&json, NULL) != VV_OK)
        return fail();
    fputs(json, stdout);
    free(json);
    return 0;
}

/* The scene as it is written beside itself. */
static int print_scene(const char *path)
{
    char folder[4096];
    char *json = NULL;
    vv_world *world = NULL;
    const char *slash = strrchr(path, '/');
    snprintf(folder, sizeof folder, "%.*s", slash ? (int)(slash - path) : 1, slash ? path : ".");
    if (vv_scene_read(&world, path, NULL) != VV_OK)
        return fail();
    const vv_status st = vv_scene_print(&json, world, folder);
    vv_object_release(&world->base);
    if (st != VV_OK)
        return fail();
    fputs(json, stdout);
    free(json);
    return 0;
}

int main(int argc, char **argv)
{
    if (!vv_registry_renderer(vv_registry_builtin(), "raycast")) {
        fprintf(stderr, "skipped: this build has no ray caster, whose parameters some scenes set\n");
        return 77;
    }
    if (argc == 2 && !strcmp(argv[1], "--schema"))
        return print_schema();
    return argc == 2 ? print_scene(argv[1]) : 2;
}
