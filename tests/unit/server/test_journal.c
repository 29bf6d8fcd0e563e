/* What a session leaves for the next one. */
#include "server/journal.h"

#include <fcntl.h>
#include <setjmp.h>
#include <signal.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <unistd.h>

#include <cmocka.h>

static char folder[64], path[96];

static int set_up(void **state)
{
    (void)state;
    snprintf(folder, sizeof folder, "/tmp/volvis-journal-XXXXXX");
    if (!mkdtemp(folder))
        return -1;
    snprintf(path, sizeof path, "%s/journal.jsonl", folder);
    return 0;
}

static int tear_down(void **state)
{
    (void)state;
    unlink(path);
    return rmdir(folder);
}

static vvi_journal *open_journal(void)
{
    vvi_journal *journal = NULL;
    assert_int_equal(vvi_journal_open(&journal, folder), VV_OK);
    return journal;
}

static void add(vvi_journal *journal, int number)
{
    assert_int_equal(vvi_journal_add(journal, json_pack("{s:i}", "n", number)), VV_OK);
}

static void write_text(const char *text)
{
    FILE *file = fopen(path, "wb");
    assert_non_null(file);
    assert_int_equal(fwrite(text, 1, strlen(text), file), strlen(text));
    assert_int_equal(fclose(file), 0);
}

typedef struct played {
    int n, sum, fails_at;
} played;

static vv_status play(void *user, const json_t *line)
{
    played *p = user;
    if (p->fails_at && p->n + 1 == p->fails_at)
        return vv_fail(VV_E_FORMAT, "not this one");
    p->n++;
    p->sum += (int)json_integer_value(json_object_get(line, "n"));
    return VV_OK;
}

static void expect(vvi_journal *journal, int n, int sum)
{
    played p = {.n = 0};
    uint64_t told = 99;
    assert_int_equal(vvi_journal_replay(&told, journal, play, &p), VV_OK);
    assert_int_equal(told, n);
    assert_int_equal(p.n, n);
    assert_int_equal(p.sum, sum);
}

static void what_was_added_is_played_in_order(void **state)
{
    (void)state;
    vvi_journal *journal = open_journal();
    expect(journal, 0, 0);
    for (int i = 1; i <= 10; i++)
        add(journal, i);
    vvi_journal_sync(journal);
    vvi_journal_close(journal, true);
    journal = open_journal();
    expect(journal, 10, 55);
    add(journal, 5); /* after those that were played */
    expect(journal, 11, 60);
    vvi_journal_clear(journal);
    expect(journal, 0, 0);
    add(journal, 3);
    expect(journal, 1, 3);
    vvi_journal_close(journal, false);
    assert_int_equal(access(path, F_OK), -1);
    vvi_journal_close(NULL, true);
}

static void a_line_that_was_cut_off_is_forgotten(void **state)
{
    static const char *const texts[] = {"{\"n\":1}\n{\"n\":2}\n{\"n", "{\"n\":1}\n{\"n\":2}\n{\"n\":4}"};
    (void)state;
    for (size_t i = 0; i < sizeof texts / sizeof *texts; i++) {
        write_text(texts[i]);
        vvi_journal *journal = open_journal();
        expect(journal, 2, 3);
        assert_non_null(strstr(vvi_journal_kept(journal), "line 3 was cut off"));
        assert_int_equal(vvi_journal_lost(journal), 0);
        add(journal, 7);
        vvi_journal_close(journal, true);
        journal = open_journal();
        expect(journal, 3, 10);
        assert_null(vvi_journal_kept(journal));
        vvi_journal_close(journal, false);
    }
}

static char *text_of(const char *name)
{
    char whole[160], *text = calloc(1, 1 << 16);
    snprintf(whole, sizeof whole, "%s/%s", folder, name);
    FILE *file = fopen(whole, "rb");
    assert_non_null(file);
    assert_true(fread(text, 1, (1 << 16) - 1, file) > 0);
    fclose(file);
    unlink(whole);
    return text;
}

static void what_cannot_be_played_is_kept_and_told(void **state)
{
    static const struct {
        const char *text;
        int fails_at, n, lost;
        const char *why;
    } rows[] = {
        {"{\"n\":1}\n{\"n\":2}\n{\"n\":4}\n", 2, 1, 2, "line 2 cannot be played: not this one"},
        {"{\"n\":1}\n{\"n\":2}\n", 1, 0, 2, "line 1 cannot be played: not this one"},
        {"{\"n\":1}\nx\n{\"n\":9}\n", 0, 1, 2, "line 2 cannot be played: is damaged"},
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        played p = {.fails_at = rows[i].fails_at};
        uint64_t n;
        write_text(rows[i].text);
        vvi_journal *journal = open_journal();
        assert_int_equal(vvi_journal_replay(&n, journal, play, &p), VV_OK);
        assert_int_equal(n, rows[i].n);
        assert_int_equal(vvi_journal_lost(journal), rows[i].lost);
        assert_non_null(strstr(vvi_journal_kept(journal), rows[i].why));
        assert_non_null(strstr(vvi_journal_kept(journal), "/journal-1.jsonl"));
        char *old = text_of("journal-1.jsonl");
        assert_string_equal(old, rows[i].text);
        free(old);
        add(journal, 8); /* after what was played */
        vvi_journal_close(journal, true);
        journal = open_journal();
        expect(journal, rows[i].n + 1, (rows[i].n ? 1 : 0) + 8);
        assert_null(vvi_journal_kept(journal));
        vvi_journal_close(journal, false);
    }
}

static void one_that_is_too_large_is_kept_and_told(void **state)
{
    char kept[160];
    (void)state;
    write_text("{\"n\":1}\n");
    assert_int_equal(truncate(path, ((off_t)1 << 30) + 1), 0); /* a hole */
    vvi_journal *journal = open_journal();
    expect(journal, 0, 0);
    assert_non_null(strstr(vvi_journal_kept(journal), "too large for a journal (1024 MiB); it is kept as"));
    snprintf(kept, sizeof kept, "%s/journal-1.jsonl", folder);
    assert_int_equal(unlink(kept), 0);
    add(journal, 2);
    expect(journal, 1, 2);
    vvi_journal_close(journal, false);
}

static void a_journal_does_not_grow_beyond_its_limit(void **state)
{
    enum { LINE = 1 << 20 };
    bool must;
    (void)state;
    vvi_journal *journal = open_journal();
    char *text = calloc(1, LINE + 1);
    memset(text, 'x', LINE);
    vv_status st = VV_OK;
    int n = 0;
    while (n < 200 && (st = vvi_journal_add(journal, json_pack("{s:s}", "text", text))) == VV_OK)
        n++;
    free(text);
    assert_int_equal(st, VV_E_LIMIT);
    assert_int_equal(n, 63);
    assert_true(vvi_journal_wants_world(journal, &must));
    assert_false(must);
    assert_false(vvi_journal_is_cut(journal));
    assert_int_equal(vvi_journal_begin(journal, json_pack("{s:i}", "n", 5)), VV_OK);
    assert_true(vvi_journal_is_cut(journal));
    assert_false(vvi_journal_wants_world(journal, &must));
    add(journal, 4);
    vvi_journal_close(journal, true);
    journal = open_journal();
    expect(journal, 2, 9);
    vvi_journal_close(journal, false);
}

static void what_was_not_done_is_taken_back(void **state)
{
    bool must;
    (void)state;
    vvi_journal *journal = open_journal();
    add(journal, 1);
    add(journal, 2);
    vvi_journal_take_back(journal);
    add(journal, 4);
    expect(journal, 2, 5);
    vvi_journal_miss(journal);
    assert_true(vvi_journal_wants_world(journal, &must) && must);
    assert_int_equal(vvi_journal_add(journal, json_pack("{s:i}", "n", 8)), VV_E_WRITE);
    expect(journal, 2, 5);
    assert_int_equal(vvi_journal_begin(journal, json_pack("{s:i}", "n", 16)), VV_OK);
    add(journal, 32);
    expect(journal, 2, 48);
    vvi_journal_close(journal, false);
}

static void a_folder_has_one_session(void **state)
{
    vvi_journal *second = NULL;
    (void)state;
    vvi_journal *journal = open_journal();
    assert_int_equal(vvi_journal_open(&second, folder), VV_E_ARGUMENT);
    assert_null(second);
    assert_non_null(strstr(vv_error_last()->message, "another server"));
    vvi_journal_close(journal, false);
    journal = open_journal();
    vvi_journal_close(journal, false);
    assert_int_equal(vvi_journal_open(&second, "/nowhere/at/all"), VV_E_WRITE);
}

static void a_link_is_no_journal(void **state)
{
    vvi_journal *journal = NULL;
    char elsewhere[96];
    (void)state;
    snprintf(elsewhere, sizeof elsewhere, "%s/elsewhere", folder);
    assert_int_equal(symlink(elsewhere, path), 0);
    assert_int_equal(vvi_journal_open(&journal, folder), VV_E_WRITE);
    assert_int_equal(access(elsewhere, F_OK), -1);
}

/* A limit of the size of files is as good as a full disk. */
static void a_full_disk_takes_no_line_until_there_is_room(void **state)
{
    struct rlimit before, small = {.rlim_cur = 20};
    (void)state;
    vvi_journal *journal = open_journal();
    add(journal, 1);
    signal(SIGXFSZ, SIG_IGN);
    assert_int_equal(getrlimit(RLIMIT_FSIZE, &before), 0);
    small.rlim_max = before.rlim_max;
    assert_int_equal(setrlimit(RLIMIT_FSIZE, &small), 0);
    const vv_status first = vvi_journal_add(journal, json_pack("{s:s}", "text", "longer than what is left"));
    const vv_status second = vvi_journal_add(journal, json_pack("{s:i}", "n", 2)); /* that fits */
    const vv_status third = vvi_journal_begin(journal, json_pack("{s:s}", "text", "longer than what there is"));
    assert_int_equal(setrlimit(RLIMIT_FSIZE, &before), 0);
    assert_int_equal(first, VV_E_WRITE);
    assert_int_equal(second, VV_OK);
    assert_int_equal(third, VV_E_WRITE);
    add(journal, 4);
    vvi_journal_close(journal, true);
    journal = open_journal();
    expect(journal, 3, 7);
    assert_int_equal(vvi_journal_lost(journal), 0);
    vvi_journal_close(journal, false);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(what_was_added_is_played_in_order, set_up, tear_down),
        cmocka_unit_test_setup_teardown(a_line_that_was_cut_off_is_forgotten, set_up, tear_down),
        cmocka_unit_test_setup_teardown(what_cannot_be_played_is_kept_and_told, set_up, tear_down),
        cmocka_unit_test_setup_teardown(a_folder_has_one_session, set_up, tear_down),
        cmocka_unit_test_setup_teardown(a_link_is_no_journal, set_up, tear_down),
        cmocka_unit_test_setup_teardown(one_that_is_too_large_is_kept_and_told, set_up, tear_down),
        cmocka_unit_test_setup_teardown(a_journal_does_not_grow_beyond_its_limit, set_up, tear_down),
        cmocka_unit_test_setup_teardown(what_was_not_done_is_taken_back, set_up, tear_down),
        cmocka_unit_test_setup_teardown(a_full_disk_takes_no_line_until_there_is_room, set_up, tear_down),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
