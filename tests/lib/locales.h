/** @file
 * A locale that writes 1,5.
 */
#ifndef TEST_LOCALES_H
#define TEST_LOCALES_H

/** Puts one in force and gives its name; NULL when none is installed and none can be made. setlocale(LC_ALL, "C") ends
 * it. */
const char *test_comma_locale(void);
#endif
