#include "server/tls.h"
#include "server/secret_file.h"

#include <errno.h>
#include <openssl/err.h>
#include <openssl/pem.h>
#include <openssl/ssl.h>
#include <openssl/x509.h>
#include <string.h>
#include <unistd.h>

static vv_status check_readable(const char *path, const char *what)
{
    return access(path, R_OK) == 0
               ? VV_OK
               : vv_fail_at(VV_E_READ, path, NULL, "the %s cannot be read: %s", what, strerror(errno));
}

/* A key with a password: nobody is asked for it. */
/* NOLINTNEXTLINE(readability-non-const-parameter): OpenSSL has one type for those that are asked */
static int has_no_password(char *out, int room, int writes, void *user)
{
    (void)out;
    (void)room;
    (void)writes;
    *(bool *)user = true;
    return -1;
}

static const char *reason_of(unsigned long error)
{
    const char *reason = ERR_reason_error_string(error);
    return reason ? reason : "OpenSSL does not say why";
}

static vv_status fail_certificate(const char *path)
{
    const unsigned long error = ERR_peek_error();
    const int reason = ERR_GET_REASON(error);
    if (ERR_GET_LIB(error) == ERR_LIB_PEM && reason == PEM_R_NO_START_LINE)
        return vv_fail_at(VV_E_ARGUMENT, path, NULL, "holds no certificate in PEM form (-----BEGIN CERTIFICATE-----)");
    if (ERR_GET_LIB(error) == ERR_LIB_SSL && (reason == SSL_R_EE_KEY_TOO_SMALL || reason == SSL_R_CA_KEY_TOO_SMALL))
        return vv_fail_at(
            VV_E_ARGUMENT, path, NULL,
            "the certificate has a key that is too short to be safe; make one of 2048 bits of RSA or more, "
            "or of 256 bits of an elliptic curve");
    if (ERR_GET_LIB(error) == ERR_LIB_SSL && reason == SSL_R_CA_MD_TOO_WEAK)
        return vv_fail_at(
            VV_E_ARGUMENT, path, NULL,
            "the certificate is signed with a digest that is no longer safe; have it signed with SHA-256");
    return vv_fail_at(VV_E_ARGUMENT, path, NULL, "the certificate cannot be used: %s", reason_of(error));
}

static vv_status fail_key(const char *path, const char *certificate, bool is_locked)
{
    const unsigned long error = ERR_peek_error();
    if (is_locked)
        return vv_fail_at(VV_E_ARGUMENT, path, NULL,
                          "the key has a password; write it without one to a file that only you can read: openssl pkey "
                          "-in %s -out FILE",
                          path);
    if (ERR_GET_LIB(error) == ERR_LIB_X509 || ERR_GET_LIB(error) == ERR_LIB_SSL)
        return vv_fail_at(VV_E_ARGUMENT, path, NULL, "is not the key of the certificate %s", certificate);
    return vv_fail_at(VV_E_ARGUMENT, path, NULL, "holds no key in PEM form (-----BEGIN PRIVATE KEY-----)%s",
                      path == certificate ? "; give it with --tls-key if it is in another file" : "");
}

static vv_status load(SSL_CTX *context, const char *certificate, const char *key)
{
    bool is_locked = false;
    SSL_CTX_set_default_passwd_cb(context, has_no_password);
    SSL_CTX_set_default_passwd_cb_userdata(context, &is_locked);
    ERR_clear_error();
    if (SSL_CTX_use_certificate_chain_file(context, certificate) != 1)
        return fail_certificate(certificate);
    if (SSL_CTX_use_PrivateKey_file(context, key, SSL_FILETYPE_PEM) != 1 || SSL_CTX_check_private_key(context) != 1)
        return fail_key(key, certificate, is_locked);
    return VV_OK;
}

vv_status vvi_tls_check(const char *certificate, const char *key)
{
    struct stat info;
    vv_status st = check_readable(certificate, "certificate");
    if (st == VV_OK && key)
        st = check_readable(key, "certificate's key");
    if (st != VV_OK)
        return st;
    SSL_CTX *context = SSL_CTX_new(TLS_server_method());
    if (!context)
        return vv_fail_memory(1024);
    st = load(context, certificate, key ? key : certificate);
    SSL_CTX_free(context);
    ERR_clear_error();
    if (st == VV_OK && stat(key ? key : certificate, &info) == 0)
        st = vvi_key_file_check(&info, key ? key : certificate, "certificate's key");
    return st;
}
