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
    int64_t number = 0;
    char *one = NULL, *two = NULL;
    assert_int_equal(vvi_files_make_folder(&one, &session, "result", &number), VV_OK);
    number = 0; /* as if nobody knew of the first */
    assert_int_equal(vvi_files_make_folder(&two, &session, "result", &number), VV_OK);
    assert_string_equal(one, below("state/result-1"));
    assert_string_equal(two, below("state/result-2"));
    touch("state/result-1/gone.nrrd");
    touch("state/result-2/kept.nrrd");
    touch("state/result-2/gone.raw");
    assert_int_equal(chmod(below("state/result-2/kept.nrrd"), 0400), 0);
    vvi_files_clear(&session);
    assert_int_equal(access(one, F_OK), -1);
    assert_int_equal(access(below("state/result-2/kept.nrrd"), F_OK), 0);
    assert_int_equal(access(below("state/result-2/gone.raw"), F_OK), -1);
    vvi_files_remove(below("state/result-2/kept.nrrd")); /* a scene names it */
    assert_int_equal(access(below("state/result-2/kept.nrrd"), F_OK), 0);
    remove(below("state/result-2/kept.nrrd"));
    vvi_files_remove_empty(below("state/result-2/kept.nrrd"));
    assert_int_equal(access(two, F_OK), -1);
    free(one);
    free(two);
    assert_int_equal(access(below("state/d.txt"), F_OK), -1);
    assert_int_equal(access(below("state/kept"), F_OK), 0);
    assert_int_equal(access(below("outside.txt"), F_OK), 0);
    session.uploads = NULL;
    remove(below("state/kept"));
    remove(below("state/link"));
}

/* What is sent with the same word lies in one folder, and nothing else does. */
static void uploads_that_come_together_lie_together(void **state)
{
    char *path[6] = {0}, word[40];
    (void)state;
    session.uploads = state_folder;
    static const char *const batches[] = {
        "", "", "one word that is the page's", "another", "one word that is the page's", ""};
    for (int i = 0; i < 6; i++)
        assert_int_equal(vvi_session_upload_folder(&path[i], &session, batches[i]), VV_OK);
    assert_string_equal(path[2], path[4]);
    for (int i = 0; i < 6; i++)
        for (int k = 0; k < i; k++)
            assert_true((strcmp(path[i], path[k]) == 0) == (i == 4 && k == 2));
    for (int i = 0; i < 200; i++) { /* of many pages at once */
        char *folder_of = NULL, *again = NULL;
        snprintf(word, sizeof word, "page %d", i);
        assert_int_equal(vvi_session_upload_folder(&folder_of, &session, word), VV_OK);
        assert_int_equal(vvi_session_upload_folder(&again, &session, word), VV_OK);
        assert_string_equal(folder_of, again);
        free(folder_of);
        free(again);
    }
    for (int i = 0; i < 6; i++)
        free(path[i]);
    vvi_files_clear(&session);
    session.uploads = NULL;
}

static void sentences_do_not_tell_where_the_server_keeps_files(void **state)
{
    char said[400];
    (void)state;
    session.uploads = state_folder;
    snprintf(said, sizeof said, "%s/upload-3/a.nrrd:2: no, as '%s/b.nrrd' and %s-2/c", state_folder, state_folder,
             state_folder);
    char *told = vvi_files_sentence(&session, said);
    snprintf(said, sizeof said, "a.nrrd:2: no, as 'b.nrrd' and %s-2/c", state_folder);
    assert_string_equal(told, said);
    free(told);
    session.uploads = NULL;
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(what_is_inside_is_found_by_any_name),
        cmocka_unit_test(nothing_leads_out),
        cmocka_unit_test(new_files_are_made_in_folders_that_are_there),
        cmocka_unit_test(the_root_of_all_holds_all),
        cmocka_unit_test(results_go_unless_they_are_kept),
        cmocka_unit_test(uploads_that_come_together_lie_together),
        cmocka_unit_test(sentences_do_not_tell_where_the_server_keeps_files),
    };
    return cmocka_run_group_tests(tests, set_up, tear_down);
}
