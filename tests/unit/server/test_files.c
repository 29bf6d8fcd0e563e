/* Files as a page names them: none outside the root. */
#include "core/memory.h"
#include "server/session_impl.h"

#include <fcntl.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cmocka.h>

static char folder[64], root[80], state_folder[80];
static vvi_session session;

static char *below(const char *path)
{
    static char out[4][160];
    static int next;
    char *at = out[next = (next + 1) % 4];
    snprintf(at, sizeof *out, "%s/%s", folder, path);
    return at;
}

static void touch(const char *path)
{
    const int fd = open(below(path), O_WRONLY | O_CREAT, 0600);
    assert_true(fd >= 0);
    close(fd);
}

/* outside.txt, root/a.txt, root/deep/b.txt, links out of the root and within it, rootless/ beside it. */
static int set_up(void **state)
{
    (void)state;
    snprintf(folder, sizeof folder, "/tmp/volvis-files-XXXXXX");
    assert_non_null(mkdtemp(folder));
    snprintf(root, sizeof root, "%s/root", folder);
    snprintf(state_folder, sizeof state_folder, "%s/state", folder);
    static const char *const folders[] = {"root", "root/deep", "rootless", "state"};
    for (size_t i = 0; i < 4; i++)
        assert_int_equal(mkdir(below(folders[i]), 0700), 0);
    touch("outside.txt");
    touch("root/a.txt");
    touch("root/deep/b.txt");
    touch("rootless/c.txt");
    touch("state/d.txt");
    assert_int_equal(symlink(below("outside.txt"), below("root/out")), 0);
    assert_int_equal(symlink(folder, below("root/up")), 0);
    assert_int_equal(symlink("a.txt", below("root/in")), 0);
    assert_int_equal(symlink(below("not-there"), below("root/dangling")), 0);
    session = (vvi_session){.root = root, .state = state_folder};
    return 0;
}

static int tear_down(void **state)
{
    static const char *const all[] = {"root/dangling",  "root/in",         "root/up",    "root/out",    "state/d.txt",
                                      "rootless/c.txt", "root/deep/b.txt", "root/a.txt", "outside.txt", "state",
                                      "rootless",       "root/deep",       "root"};
    (void)state;
    for (size_t i = 0; i < sizeof all / sizeof *all; i++)
        remove(below(all[i]));
    return rmdir(folder);
}

static void expect(const char *path, bool fresh, const char *resolved)
{
    char *out = NULL;
    const vv_status st = vvi_files_resolve(&out, &session, path, fresh);
    if (resolved ? st != VV_OK || strcmp(out, resolved) != 0 : st == VV_OK || out != NULL)
        fail_msg("'%s' is '%s', not '%s'", path, out ? out : "refused", resolved ? resolved : "refused");
    free(out);
}

static void what_is_inside_is_found_by_any_name(void **state)
{
    static const char *const names[] = {"a.txt",         "/a.txt", "//a.txt",         "./a.txt",
                                        "deep/../a.txt", "in",     "/deep/.././a.txt"};
    (void)state;
    for (size_t i = 0; i < sizeof names / sizeof *names; i++)
        expect(names[i], false, below("root/a.txt"));
    expect(below("root/a.txt"), false, below("root/a.txt"));
    expect(below("state/d.txt"), false, below("state/d.txt"));
    expect("", false, root);
    expect("/", false, root);
}

static void nothing_leads_out(void **state)
{
    static const char *const names[] = {"..",
                                        "../outside.txt",
                                        "/../outside.txt",
                                        "deep/../../outside.txt",
                                        "out",
                                        "up",
                                        "up/outside.txt",
                                        "up/root/../outside.txt",
                                        "dangling",
                                        "/etc/passwd",
                                        "nothing",
                                        "a.txt/..",
                                        "../rootless/c.txt",
                                        "deep/b.txt/../../../outside.txt"};
    (void)state;
    for (size_t i = 0; i < sizeof names / sizeof *names; i++)
        expect(names[i], false, NULL);
    expect(below("outside.txt"), false, NULL);
    expect(below("rootless/c.txt"), false, NULL); /* begins like the root */
    expect(below("root/../outside.txt"), false, NULL);
}

static void new_files_are_made_in_folders_that_are_there(void **state)
{
    static const char *const bad[] = {"",
                                      "/",
                                      "deep/",
                                      ".",
                                      "..",
                                      "deep/..",
                                      "../new.txt",
                                      "up/new.txt",
                                      "nowhere/new.txt",
                                      "out",
                                      "dangling",
                                      "/tmp/volvis-new",
                                      "up/root/../new.txt"};
    (void)state;
    expect("new.txt", true, below("root/new.txt"));
    expect("/deep/new.txt", true, below("root/deep/new.txt"));
    expect("deep/../new.txt", true, below("root/new.txt"));
    expect("up/root/new.txt", true, below("root/new.txt")); /* out and in again */
    expect("a.txt", true, below("root/a.txt"));
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++)
        expect(bad[i], true, NULL);
}

static void the_root_of_all_holds_all(void **state)
{
    char everything[] = "/";
    (void)state;
    session.root = everything;
    expect(below("outside.txt"), false, below("outside.txt"));
    expect(below("root/out"), false, below("outside.txt"));
    expect("/", false, "/");
    expect("/..", false, "/");
    expect(below("new.txt"), true, below("new.txt"));
    expect(&folder[1], false, folder);
    session.root = root;
}

/* A file that a saved scene names is read-only, and is not taken away. */
static void results_go_unless_they_are_kept(void **state)
{
    (void)state;
    session.uploads = state_folder;
    touch("state/kept");
    assert_int_equal(chmod(below("state/kept"), 0400), 0);
    assert_int_equal(symlink(below("outside.txt"), below("state/link")), 0);
    vvi_files_clear(&session);
    assert_int_equal(access(below("state/d.txt"), F_OK), -1);
    assert_int_equal(access(below("state/kept"), F_OK), 0);
    assert_int_equal(access(below("outside.txt"), F_OK), 0);
    session.uploads = NULL;
    remove(below("state/kept"));
    remove(below("state/link"));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(what_is_inside_is_found_by_any_name),
        cmocka_unit_test(nothing_leads_out),
        cmocka_unit_test(new_files_are_made_in_folders_that_are_there),
        cmocka_unit_test(the_root_of_all_holds_all),
        cmocka_unit_test(results_go_unless_they_are_kept),
    };
    return cmocka_run_group_tests(tests, set_up, tear_down);
}
