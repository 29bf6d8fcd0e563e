/* Where VolVis is built without libwebsockets. */
#include "server/server.h"

vv_status vvi_server_options_check(const vvi_server_options *options)
{
    (void)options;
    return VV_OK;
}

vv_status vvi_server_new(vvi_server **out, const vvi_server_options *options)
{
    (void)options;
    *out = NULL;
    return vv_fail(VV_E_UNSUPPORTED, "this VolVis was built without libwebsockets, and so without a server; install "
                                     "libwebsockets-dev and build it again");
}

vv_status vvi_server_free(vvi_server *server, bool keep)
{
    (void)server;
    (void)keep;
    return VV_OK;
}

const char *vvi_server_link(const vvi_server *server)
{
    (void)server;
    return "";
}

vvi_session *vvi_server_session(vvi_server *server)
{
    (void)server;
    return NULL;
}

vv_status vvi_server_launch(char out[512], vvi_server *server, const char *file)
{
    (void)server;
    (void)file;
    *out = 0;
    return VV_OK;
}

vv_status vvi_server_run(vvi_server *server, const vv_job *job)
{
    (void)server;
    (void)job;
    return VV_OK;
}

void vvi_server_stop(vvi_server *server)
{
    (void)server;
}
