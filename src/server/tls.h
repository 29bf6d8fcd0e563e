/** The certificate of a server, and its key. */
#ifndef VV_SERVER_TLS_H
#define VV_SERVER_TLS_H

#include "core/status.h"

/** Whether TLS can be spoken with these PEM files, which is found out before a port is opened: then it could be told
 * from no other reason. key: NULL where it is in the certificate's file. VV_E_READ, VV_E_ARGUMENT, VV_E_MEMORY. */
vv_status vvi_tls_check(const char *certificate, const char *key);

#endif
